//! Exactly one owner for maps that are computed, as for the others (`tests/owner`): at random points, vertices and edges one
//! triangle claims each covered point, never none, never two; tables and answers are the same on every device.
//!
//! What covers a point is asked without the lookup's code: by signs of exact determinants. Edges have points on the query
//! grid (six bits finer than the vertices') at their quarters.
#![cfg(feature = "gpu")]

mod devices;
mod glb;
mod maps;

use invertex::igt::{self, BuildOptions, Layout, Needs, Reference, Tables, build_cpu};
use invertex::mesh::{Mesh, shapes};
use invertex::param::grid::QUERY_SHIFT;
use invertex::param::projection::{self, Line};
use invertex::param::{Map, Primary};
use maps::{computed, dented_ball};
use std::collections::HashMap;

type Point = [i32; 3];

/// A surface with what its tables are made of.
struct Surface {
    name: String,
    primary: Primary,
    reference: Reference,
    /// Whether every point of T3 has an owner.
    closed: bool,
}

impl Surface {
    fn new(map: Map, mesh: &Mesh) -> Surface {
        let (computed, open) = computed(mesh, map);
        assert_eq!(computed.quality.turned_triangles, [0u32; 0]);
        let primary = computed.primary();
        let layer = vec![0; open.triangles.len()];
        Surface {
            name: format!("{map} of {}", mesh.name),
            primary,
            reference: Reference::new(&open, &primary, &layer, Layout::Packed).unwrap(),
            closed: map.line() == Line::Sphere,
        }
    }

    fn tables(&self, hash: u32) -> Tables {
        let options = BuildOptions {
            hash,
            layout: Layout::Packed,
        };
        build_cpu(&self.reference, &Needs::default(), options).unwrap()
    }

    fn owners(&self, q: Point) -> Vec<u32> {
        let claims = |t: &u32| {
            let corners = self.reference.corners(*t as usize);
            projection::hit(self.primary.line(), q, &corners).is_some()
        };
        (0..self.reference.triangles.len() as u32)
            .filter(claims)
            .collect()
    }

    /// Whether the line through `q` passes through the inside of some triangle.
    fn inside_of_one(&self, q: Point) -> bool {
        let count = self.reference.triangles.len();
        (0..count).any(|t| strictly_inside(self.primary.line(), q, self.reference.corners(t)))
    }

    /// Points at which exactly one owner is due: insides, edges between two triangles, vertices that such edges surround.
    fn due(&self, count: usize) -> Vec<Point> {
        let triangles = &self.reference.triangles;
        let mut sides: HashMap<(u32, u32), u32> = HashMap::new();
        let both = |t: &[u32; 3]| [0, 1, 2].map(|k| (t[k], t[(k + 1) % 3]));
        for (a, b) in triangles.iter().flat_map(both) {
            *sides.entry((a, b)).or_default() += 1;
        }
        let inner =
            |a: u32, b: u32| sides.get(&(a, b)) == Some(&1) && sides.get(&(b, a)) == Some(&1);
        let mut surrounded: HashMap<u32, bool> = HashMap::new();
        for (a, b) in triangles.iter().flat_map(both) {
            *surrounded.entry(a).or_insert(true) &= inner(a, b);
            *surrounded.entry(b).or_insert(true) &= inner(a, b);
        }
        let at = |v: u32| self.reference.t3[v as usize].map(|c| c << QUERY_SHIFT);
        let mut points: Vec<Point> = vec![];
        for t in triangles.iter().step_by(triangles.len() / count + 1) {
            for (a, b) in both(t) {
                let (p, q) = (at(a), at(b));
                let quarters = [1, 2, 3].map(|n| [0, 1, 2].map(|k| p[k] + (q[k] - p[k]) / 4 * n));
                if inner(a, b) {
                    points.extend(quarters);
                }
                // About an axis a pole is the end of the domain.
                let pole = self.primary.line() == Line::Cylinder && p[..2] == [0, 0];
                if surrounded[&a] && !pole {
                    points.push(p);
                }
            }
        }
        assert!(
            points.len() > count,
            "{}: {} points",
            self.name,
            points.len()
        );
        points
    }

    /// How many of `points` (whose owner is due where `due`) have another number of owners than they should, or another answer.
    fn wrong(&self, tables: &Tables, points: &[Point], due: bool) -> usize {
        let bad = |q: &&Point| {
            let owners = self.owners(**q);
            let found = tables.lookup(**q, None, false).map(|f| f.triangle);
            let must = due || self.closed || self.inside_of_one(**q);
            owners.len() > 1 || must && owners.is_empty() || found != owners.first().copied()
        };
        points.iter().filter(bad).count()
    }
}

/// In i128: vertices are below 2^23, queries below 2^29, so that a determinant stays below 2^84.
fn strictly_inside(line: Line, q: Point, corners: [Point; 3]) -> bool {
    let wide = |p: Point| p.map(i128::from);
    let q = wide(q);
    let v = corners.map(|p| wide(p).map(|c| c << QUERY_SHIFT));
    let det = |a: [i128; 3], b: [i128; 3], c: [i128; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    match line {
        Line::Parallel => {
            let area = |a: [i128; 3], b: [i128; 3], c: [i128; 3]| {
                (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            };
            let sides = [0, 1, 2].map(|i| area(v[i], v[(i + 1) % 3], q).signum());
            sides[0] != 0 && sides.iter().all(|s| *s == sides[0])
        }
        Line::Sphere => {
            let sense = det(v[0], v[1], v[2]).signum();
            let sides = [0, 1, 2].map(|i| det(q, v[i], v[(i + 1) % 3]).signum());
            sense != 0 && sides.iter().all(|s| *s == sense)
        }
        Line::Cylinder => {
            // The half-line at the query's height: from the axis outwards along (x, y).
            let start = [0, 0, q[2]];
            let from = v.map(|p| [0, 1, 2].map(|k| p[k] - start[k]));
            let d = [q[0], q[1], 0];
            let sense = det(from[0], from[1], from[2]).signum();
            let sides = [0, 1, 2].map(|i| det(d, from[i], from[(i + 1) % 3]).signum());
            sense != 0 && sides.iter().all(|s| *s == sense)
        }
    }
}

/// Points all over T3.
fn anywhere(count: usize) -> Vec<Point> {
    let mut state = 31u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 34) as i32 - (1 << 29)
    };
    (0..count).map(|_| [next(), next(), next()]).collect()
}

fn surfaces() -> Vec<Surface> {
    let ball = dented_ball(2);
    let mut all: Vec<Surface> = Map::ALL
        .iter()
        .map(|map| Surface::new(*map, &ball))
        .collect();
    // With a border, where nothing more is owed.
    all.extend([Map::Lscm, Map::GeometryImage].map(|map| Surface::new(map, &shapes::tube(12, 4))));
    all
}

#[test]
fn every_computed_map_gives_each_point_one_owner() {
    for surface in surfaces() {
        for hash in [4, 64] {
            let tables = surface.tables(hash);
            tables.validate(surface.reference.triangles.len()).unwrap();
            let due = surface.due(150);
            assert_eq!(surface.wrong(&tables, &due, true), 0, "{}", surface.name);
            let anywhere = anywhere(700);
            let covered = anywhere
                .iter()
                .filter(|q| surface.inside_of_one(**q))
                .count();
            assert!(covered > 60, "{}: {covered} are covered", surface.name);
            assert_eq!(
                surface.wrong(&tables, &anywhere, false),
                0,
                "{}",
                surface.name
            );
        }
    }
}

/// Negative controls: a triangle that is gone leaves a hole, one that is there twice has two owners.
#[test]
fn a_hole_and_a_double_are_seen() {
    for map in [Map::Lscm, Map::Sphere] {
        let mut surface = Surface::new(map, &dented_ball(2));
        let due = surface.due(150);
        let gone = surface.reference.triangles.pop().unwrap();
        surface.reference.layer.pop();
        let tables = surface.tables(64);
        let corners = gone.map(|v| surface.reference.t3[v as usize]);
        let middle = [0, 1, 2].map(|k| {
            let sum: i64 = corners.iter().map(|c| i64::from(c[k]) << QUERY_SHIFT).sum();
            (sum / 3) as i32
        });
        assert_eq!(
            surface.wrong(&tables, &[middle], true),
            1,
            "{}: a hole",
            surface.name
        );
        surface.reference.triangles.extend([gone, gone]);
        surface.reference.layer.extend([0, 0]);
        let tables = surface.tables(64);
        assert_eq!(
            surface.wrong(&tables, &[middle], true),
            1,
            "{}: a double",
            surface.name
        );
        assert!(surface.wrong(&tables, &due, true) > 0, "{}", surface.name);
    }
}

#[test]
fn every_device_makes_the_same_tables_and_answers() {
    let surfaces = surfaces();
    devices::on_every_device(|context| {
        for surface in &surfaces {
            let options = BuildOptions {
                hash: 64,
                layout: Layout::Packed,
            };
            let needs = Needs::default();
            let cpu = surface.tables(64);
            let built = igt::gpu::build(context, &surface.reference, &needs, options);
            let device = built.unwrap().tables;
            let what = format!("{} on {}", surface.name, context.info().name);
            assert_eq!(cpu.sha256(), device.sha256(), "{what}");
            let mut points = surface.due(60);
            points.extend(anywhere(400));
            let answers = igt::gpu::query(context, &device, &points, None, false).unwrap();
            for (q, answer) in points.iter().zip(&answers) {
                assert_eq!(
                    cpu.lookup_with_cost(*q, None, false),
                    *answer,
                    "{what}: {q:?}"
                );
            }
            // Negative control: a changed word is another sum.
            let mut other = device.clone();
            other.triangle[0] ^= 1;
            assert_ne!(cpu.sha256(), other.sha256(), "{what}");
        }
    });
}
