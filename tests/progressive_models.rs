//! The bounds of progressive meshes on real models: points all over several cuts, answered by the tables as a renderer asks them.
//! No point may lie beyond its bound where the primary is one-to-one. Where the surface folds back under its projection lines, a
//! level's folds lie a little beside the reference's, and between the two another sheet answers, for which nothing is said.
//! Spot and the apple in the suite; every shared model, ten million points, with `INVERTEX_LONG=1`.

#[path = "long/mod.rs"]
mod long;

use glam::DVec3;
use invertex::igt::{Ambiguous, Asker, BuildOptions, Layout, Needs, Reference, Tables, build_cpu};
use invertex::lod::LodInput;
use invertex::lod::progressive::{Made, Progressive};
use invertex::mesh::Mesh;
use invertex::param::{Parts, Primary, parameterize, parts};
use invertex::scene::Scene;
use rayon::prelude::*;
use std::collections::HashSet;

/// Points of the long form, over all models.
const POINTS: u64 = 10_000_000;
const MODELS: u64 = 13;

/// A mesh and everything that answers for it.
struct Subject {
    mesh: Mesh,
    primary: Primary,
    parts: Parts,
    tables: Tables,
    ambiguous: HashSet<u32>,
}

/// What was found: points that were answered, those above the bound, the worst of them as a share of the bound.
#[derive(Clone, Copy, Default)]
struct Found {
    points: u64,
    /// Above it on a mesh that is one-to-one, and on one that is not.
    above: [u64; 2],
    worst: f64,
}

impl Subject {
    fn new(mesh: &Mesh, name: &str) -> Self {
        let chosen = parameterize(mesh, &long::primary(name)).unwrap();
        let cut = |c: &invertex::param::Computed| c.embedding.cut_open(mesh);
        let mesh = chosen.computed.as_ref().map_or_else(|| mesh.clone(), cut);
        let primary = chosen.primary;
        let parts = parts(&mesh, &primary);
        let layer = &parts.triangle_layer;
        let reference = Reference::new(&mesh, &primary, layer, Layout::Packed).unwrap();
        let options = BuildOptions {
            hash: invertex::asset::hash_for(mesh.triangles.len()),
            layout: Layout::Packed,
        };
        let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
        let ambiguous = Ambiguous::of(&mesh, &primary, layer).unwrap();
        Subject {
            tables,
            ambiguous: ambiguous.triangles.into_iter().collect(),
            mesh,
            primary,
            parts,
        }
    }

    fn position(&self, v: u32) -> DVec3 {
        DVec3::from(self.mesh.positions[v as usize].map(f64::from))
    }

    /// How far point `i` of a triangle lies from the reference's, and its bound; none where nothing answers, or the answer is
    /// one of several.
    fn at(&self, t: &Made, i: u64) -> Option<(f64, f64)> {
        let corners = t.corners.map(|v| {
            let t3 = self.primary.t3_of(&self.mesh, v as usize);
            self.primary.to_grid(t3)
        });
        let (u, v) = (spread(i * 2 + 1), spread(i * 2 + 2).sqrt());
        let b = [1.0 - v, v * (1.0 - u), v * u];
        let t3 = [0, 1, 2].map(|k| (0..3).map(|c| f64::from(corners[c][k]) * b[c]).sum::<f64>());
        let query = t3.map(|x| (x * 64.0).round() as i32);
        let asker = Asker {
            grazed: false,
            ..Asker::of(self.primary.line(), &corners, Some(t.layer))
        };
        let found = self.tables.lookup(query, asker, false)?;
        if !found.hit || self.ambiguous.contains(&found.triangle) {
            return None;
        }
        let blend = |corners: [u32; 3], b: [f64; 3]| -> DVec3 {
            (0..3).map(|c| self.position(corners[c]) * b[c]).sum()
        };
        let there = blend(
            self.mesh.triangles[found.triangle as usize],
            found.barycentric.map(f64::from),
        );
        Some((
            there.distance(blend(t.corners, b)),
            f64::from(t.deviation.total),
        ))
    }

    fn check(&self, points: u64) -> Found {
        let input = LodInput {
            mesh: &self.mesh,
            primary: &self.primary,
            parts: &self.parts,
            world: glam::Mat4::IDENTITY.to_cols_array_2d(),
        };
        let progressive = Progressive::new(&input, self.mesh.triangles.len() / 100).unwrap();
        let (low, high) = self.mesh.positions.iter().fold(
            (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY),
            |(low, high), &p| (low.min(p.into()), high.max(p.into())),
        );
        // Queries are rounded to 2^-29 of the extent, answers to 2^-21 of a triangle.
        let rounding = f64::from((high - low).length()) * 1e-6;
        let mut all = Found::default();
        let steps = progressive.collapses.len();
        for collapses in [steps / 2, steps * 9 / 10, steps] {
            let made: Vec<&Made> = progressive
                .after(collapses)
                .filter(|t| t.made.is_some())
                .collect();
            let each = |i: u64| {
                let (far, bound) =
                    self.at(made.get((i % made.len().max(1) as u64) as usize)?, i)?;
                let (above, folds) = (far > bound + rounding, !self.ambiguous.is_empty());
                Some(Found {
                    points: 1,
                    above: [above && !folds, above && folds].map(u64::from),
                    worst: if folds { 0.0 } else { far / (bound + rounding) },
                })
            };
            all = (0..points / 3)
                .into_par_iter()
                .filter_map(each)
                .chain([all])
                .reduce(Found::default, Found::and);
        }
        all
    }
}

impl Found {
    fn and(self, other: Found) -> Found {
        Found {
            points: self.points + other.points,
            above: [0, 1].map(|k| self.above[k] + other.above[k]),
            worst: self.worst.max(other.worst),
        }
    }
}

/// A number in 0..1 for each index.
fn spread(i: u64) -> f64 {
    let mut h = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h = (h ^ (h >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (h >> 11) as f64 / (1u64 << 53) as f64
}

fn check(name: &str, points: u64, path: &std::path::Path) {
    let meshes = Scene::load(path).unwrap().meshes;
    let whole: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let share = |mesh: &Mesh| points * mesh.triangles.len() as u64 / whole.max(1) as u64;
    let found = meshes
        .iter()
        .map(|mesh| Subject::new(mesh, name).check(share(mesh)))
        .fold(Found::default(), Found::and);
    let Found {
        points,
        above,
        worst,
    } = found;
    let numbers = format!(
        "{points} points, {} above and {} at folds, the farthest at {worst:.4} of its bound",
        above[0], above[1]
    );
    long::proved(name, "deviation bound", &numbers);
    assert!(points > 1000, "{name}: {points} points were answered");
    assert_eq!(above[0], 0, "{name}: {numbers}");
    assert!(above[1] * 50 <= points, "{name}: {numbers}");
    // Somewhere a point comes near its bound, if any mesh is one-to-one.
    assert!(worst == 0.0 || worst > 0.8, "{name}: {numbers}");
}

#[test]
fn two_models_keep_their_bounds() {
    for name in ["spot", "food_apple"] {
        if let Some(path) = long::found(name) {
            check(name, 30_000, &path);
        }
    }
}

fn at_length(name: &str) {
    if let Some(path) = long::model(name) {
        check(name, POINTS / MODELS, &path);
    }
}

long::on_every_model!(at_length);
