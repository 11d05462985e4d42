//! Exactly one owner: every query point inside the covered domain is owned by one triangle, never none, never two.
//!
//! A brute force that shares no code with the lookup (the line meets each triangle's plane in a rational point, which is
//! tested against the edges inside the plane) says which closed triangles contain the point; the lookup must name one of
//! them, and exactly one triangle may claim it. Every device gives the CPU's answers.
//! The number of points is INVERTEX_OWNER_POINTS (3 000 of each of four sorts per surface and table); with INVERTEX_LONG=1
//! it is ten million in all for each kind of primary.

mod cases;
mod exact;
mod index;
#[path = "../long/mod.rs"]
mod long;

use cases::{Case, cases, points};
use exact::contains;
use index::Index;
use invertex::igt::{BuildOptions, Layout, Needs, Reference, Tables, build_cpu};
use invertex::param::grid::QUERY_MAX;
use invertex::param::projection::{self, Line};
use invertex::param::{Axis, PrimaryKind};
use rayon::prelude::*;

/// Points of a kind of primary in the long form.
const AT_LENGTH: u64 = 10_000_000;
/// Points of each sort that are made, looked up and checked at a time.
const BLOCK: usize = 100_000;
/// Of the long form's points a table of four texels a side gets one where others get this many: its lists are so long
/// that a software device takes a hundred times as long over them.
const FINE_TO_COARSE: u64 = 12;
/// Every so many points the triangles that claim it are sought among all, not only among the index's.
const SAMPLE: usize = 997;

/// A surface with its tables.
struct Tried {
    case: Case,
    reference: Reference,
    tables: Tables,
    index: Index,
}

fn tried(case: Case, layout: Layout, hash: u32) -> Tried {
    let layer = vec![0; case.mesh.triangles.len()];
    let reference = Reference::new(&case.mesh, &case.primary, &layer, layout).unwrap();
    let tables = build_cpu(&reference, &Needs::default(), BuildOptions { hash, layout }).unwrap();
    tables.validate(reference.triangles.len()).unwrap();
    let index = Index::new(case.primary.line(), &reference);
    Tried {
        case,
        reference,
        tables,
        index,
    }
}

/// The surfaces of a kind, each in all its tables.
fn all_tried(of_kind: impl Fn(PrimaryKind) -> bool) -> Vec<Tried> {
    let mut out = Vec::new();
    for (layout, hash) in [
        (Layout::Packed, 4),
        (Layout::Packed, 64),
        (Layout::Classic, 32),
    ] {
        for case in cases().into_iter().filter(|c| of_kind(c.primary.kind)) {
            // RGB9E5 moves vertices by up to 1/512: only shapes whose faces survive that are one-to-one.
            if layout == Layout::Packed || case.mesh.triangles.len() <= 100 {
                out.push(tried(case, layout, hash));
            }
        }
    }
    out
}

impl Tried {
    /// Its part of the long form's points.
    fn weight(&self) -> u64 {
        let coarse = self.tables.hash_size[0] == 4;
        if coarse { 1 } else { FINE_TO_COARSE }
    }

    /// Asserts the promise for `count` points of each sort; how many points are covered.
    fn check(&self, count: usize, devices: &Devices) -> usize {
        let mut covered = 0;
        for (block, first) in (0..count).step_by(BLOCK).enumerate() {
            let count = BLOCK.min(count - first);
            let bits = self.tables.bits();
            let points = points(&self.case, &self.reference, bits, count, block as u64);
            let whole = |(i, q): (usize, &[i32; 3])| self.owner_is_one(*q, i % SAMPLE == 0);
            covered += points.par_iter().enumerate().filter(|p| whole(*p)).count();
            // The sorts take turns, so that the first points are of every sort.
            let asked = if long::long() {
                points.len()
            } else {
                points.len().min(1_200)
            };
            devices.answer_alike(&self.tables, &points[..asked], self.case.name);
        }
        covered
    }

    /// Asserts the promise for one point; whether it is covered. `thoroughly`: claims of triangles that the index rejects
    /// are sought too.
    fn owner_is_one(&self, q: [i32; 3], thoroughly: bool) -> bool {
        let (line, name) = (self.case.primary.line(), self.case.name);
        let claims =
            |t: &u32| projection::hit(line, q, &self.reference.corners(*t as usize)).is_some();
        let mut owners = self.index.near(q).iter().copied().filter(claims);
        let (owner, second) = (owners.next(), owners.next());
        assert!(
            second.is_none(),
            "{name}: {q:?} has owners {owner:?} {second:?}"
        );
        if thoroughly {
            let count = (0..self.reference.triangles.len() as u32)
                .filter(claims)
                .count();
            assert_eq!(
                count,
                usize::from(owner.is_some()),
                "{name}: owners of {q:?}"
            );
        }
        let found = self.tables.lookup(q, None, false).map(|f| f.triangle);
        assert_eq!(found, owner, "{name}: lookup at {q:?}");
        let height_free = line == Line::Cylinder || q[2] == 0;
        let on_axis = line != Line::Parallel && q[0] == 0 && q[1] == 0 && height_free;
        match owner {
            Some(owner) => assert!(
                on_axis || self.index.contains(owner, q),
                "{name}: {q:?} is not in its owner {owner}"
            ),
            None => assert!(
                line != Line::Sphere && !self.interior(q),
                "{name}: hole at {q:?}"
            ),
        }
        owner.is_some()
    }

    /// Whether a covered point is away from the surface's border: it stays inside when moved a step in every direction.
    fn interior(&self, q: [i32; 3]) -> bool {
        let moved = |axis: usize, by: i32| {
            let mut p = q;
            p[axis] = (p[axis] + by).clamp(-QUERY_MAX, QUERY_MAX);
            self.index.covered(p)
        };
        self.index.covered(q) && (0..3).all(|axis| moved(axis, 64) && moved(axis, -64))
    }
}

/// The devices that answer beside the CPU: all there are.
struct Devices {
    #[cfg(feature = "gpu")]
    contexts: Vec<invertex::gpu::Context>,
}

#[cfg(feature = "gpu")]
#[path = "../render/mod.rs"]
mod render;

impl Devices {
    fn none() -> Self {
        Devices {
            #[cfg(feature = "gpu")]
            contexts: Vec::new(),
        }
    }

    fn all() -> Self {
        Devices {
            #[cfg(feature = "gpu")]
            contexts: render::contexts(),
        }
    }

    fn names(&self) -> String {
        #[cfg(feature = "gpu")]
        let names = self
            .contexts
            .iter()
            .map(|c| format!(" = {}", c.info().name))
            .collect();
        #[cfg(not(feature = "gpu"))]
        let names = String::new();
        names
    }

    /// Asserts that every device gives the CPU's answers, bit for bit.
    fn answer_alike(&self, _tables: &Tables, _points: &[[i32; 3]], _name: &str) {
        #[cfg(feature = "gpu")]
        for context in &self.contexts {
            let got = invertex::igt::gpu::query(context, _tables, _points, None, false).unwrap();
            _points.par_iter().zip(&got).for_each(|(q, got)| {
                let device = &context.info().name;
                assert_eq!(
                    _tables.lookup_with_cost(*q, None, false),
                    *got,
                    "{_name} on {device}: {q:?}"
                );
            });
        }
    }
}

/// All surfaces of a kind of primary.
fn check_kind(kind: &str, of_kind: impl Fn(PrimaryKind) -> bool) {
    let devices = Devices::all();
    let surfaces = all_tried(of_kind);
    let parts: u64 = surfaces.iter().map(Tried::weight).sum();
    let (mut asked, mut covered) = (0, 0);
    let began = std::time::Instant::now();
    for surface in &surfaces {
        let share = (AT_LENGTH * surface.weight()).div_ceil(4 * parts);
        let count = long::count("INVERTEX_OWNER_POINTS", 3_000, share) as usize;
        let here = surface.check(count, &devices);
        let name = surface.case.name;
        let (layout, hash) = (surface.tables.layout, surface.tables.hash_size[0]);
        println!(
            "{name}: {layout:?} {hash}: {} points, {here} covered",
            4 * count
        );
        assert!(here * 20 > 4 * count, "{name}: hardly any point is covered");
        (asked, covered) = (asked + 4 * count, covered + here);
    }
    let numbers = format!(
        "{asked} points, {covered} covered: 0 holes, 0 doubles; cpu{} ({:.0} s)",
        devices.names(),
        began.elapsed().as_secs_f64()
    );
    long::proved(kind, "exactly one owner", &numbers);
}

#[test]
fn a_uv_point_has_one_owner() {
    check_kind("uv", |kind| matches!(kind, PrimaryKind::UvSet(_)));
}

#[test]
fn a_point_of_a_plane_has_one_owner() {
    check_kind("plane", |kind| matches!(kind, PrimaryKind::Plane(_)));
}

#[test]
fn a_point_about_an_axis_has_one_owner() {
    check_kind("cylinder", |kind| kind == PrimaryKind::Cylinder(Axis::Z));
}

#[test]
fn a_direction_has_one_owner() {
    check_kind("sphere", |kind| kind == PrimaryKind::Sphere);
}

/// Points whose triangles the index and the unaccelerated brute force tell differently.
fn told_differently(surface: &Tried, count: usize) -> usize {
    let bits = surface.tables.bits();
    let points = points(&surface.case, &surface.reference, bits, count, 99);
    let line = surface.case.primary.line();
    let differs = |q: &[i32; 3]| {
        let near = surface.index.near(*q);
        (0..surface.reference.triangles.len() as u32).any(|t| {
            let fast = near.contains(&t) && surface.index.contains(t, *q);
            fast != contains(line, *q, &surface.reference.corners(t as usize))
        })
    };
    points.par_iter().filter(|q| differs(q)).count()
}

#[test]
fn the_index_changes_no_answer() {
    let count = long::count("INVERTEX_OWNER_INDEX_POINTS", 100, 5_000) as usize;
    for mut surface in all_tried(|_| true) {
        assert_eq!(
            told_differently(&surface, count),
            0,
            "{}",
            surface.case.name
        );
        // Negative control: a triangle that one cell has lost is missed.
        let fullest = surface.index.cells.iter_mut().max_by_key(|cell| cell.len());
        fullest.unwrap().clear();
        surface
            .index
            .cells
            .iter_mut()
            .step_by(2)
            .for_each(Vec::clear);
        assert!(told_differently(&surface, 100) > 0, "{}", surface.case.name);
    }
}

#[test]
fn a_missing_triangle_makes_a_hole() {
    // Negative control: the same check must fail on a sphere with one triangle left out.
    let mut case = cases().into_iter().find(|c| c.name == "icosphere").unwrap();
    case.mesh.triangles.remove(17);
    let broken = tried(case, Layout::Packed, 16);
    let check = std::panic::AssertUnwindSafe(|| broken.check(3_000, &Devices::none()));
    assert!(std::panic::catch_unwind(check).is_err());
}
