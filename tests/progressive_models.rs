//! The bounds of progressive meshes on real models: points all over several cuts, answered by the tables as a renderer asks them.
//! No point may lie beyond its bound where the primary is one-to-one. Where the surface folds back under its projection lines, a
//! level's folds lie a little beside the reference's, and between the two another sheet answers, for which nothing is said.
//! Spot and the apple in the suite; every shared model, ten million points, with `INVERTEX_LONG=1`.

mod exact;
#[path = "long/mod.rs"]
mod long;
mod parted;

use exact::Exact;
use invertex::igt::{Ambiguous, Asker, BuildOptions, Layout, Needs, Reference, Tables, build_cpu};
use invertex::lod::progressive::{Cost, Made, Progressive};
use invertex::mesh::Mesh;
use invertex::param::PrimaryRequest;
use invertex::scene::Scene;
use parted::{Model, spread};
use rayon::prelude::*;
use std::collections::HashSet;

/// Points of the long form, over all models.
const POINTS: u64 = 10_000_000;
const MODELS: u64 = 13;

/// A mesh and everything that answers for it.
struct Subject {
    model: Model,
    tables: Tables,
    ambiguous: HashSet<u32>,
    exact: Exact,
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
    fn new(mesh: &Mesh, primary: &PrimaryRequest) -> Self {
        let model = Model::with(mesh, primary);
        let (mesh, layer) = (&model.mesh, &model.parts.triangle_layer);
        let reference = Reference::new(mesh, &model.primary, layer, Layout::Packed).unwrap();
        let options = BuildOptions {
            hash: invertex::asset::hash_for(mesh.triangles.len()),
            layout: Layout::Packed,
        };
        let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
        let ambiguous = Ambiguous::of(mesh, &model.primary, layer).unwrap();
        Subject {
            exact: Exact::new(&model.mesh),
            tables,
            ambiguous: ambiguous.triangles.into_iter().collect(),
            model,
        }
    }

    /// How far point `i` of a triangle lies from the reference's, and its bound; none where nothing answers, or the answer is
    /// one of several.
    fn at(&self, t: &Made, i: u64) -> Option<(f64, f64)> {
        let model = &self.model;
        let corners = t.corners.map(|v| model.grid(v));
        let b = spread(i);
        let query = model.query(t.corners, b);
        let asker = Asker {
            grazed: false,
            ..Asker::of(model.primary.line(), &corners, Some(t.layer))
        };
        let found = self.tables.lookup(query, asker, false)?;
        if !found.hit || self.ambiguous.contains(&found.triangle) {
            return None;
        }
        let of = (&model.mesh, &model.primary);
        let (met, shares) = self.exact.at(of, (query, asker.side), found.triangle)?;
        let there = model.point(model.mesh.triangles[met as usize], shares);
        let far = there.distance(model.point(t.corners, b));
        Some((far, f64::from(t.deviation.total)))
    }

    fn check(&self, points: u64) -> Found {
        let mesh = &self.model.mesh;
        let progressive = Progressive::new(
            &self.model.input(),
            Cost::Displacement,
            mesh.triangles.len() / 100,
        );
        let (low, high) = mesh.positions.iter().fold(
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

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Found {
            points,
            above: [above, folds],
            worst,
        } = self;
        write!(
            f,
            "{points} points, {above} above and {folds} at folds, the farthest at {worst:.4} of its bound"
        )
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

fn check((name, primary): (&str, PrimaryRequest), points: u64, path: &std::path::Path) {
    let meshes = Scene::load(path).unwrap().meshes;
    let whole: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let share = |mesh: &Mesh| points * mesh.triangles.len() as u64 / whole.max(1) as u64;
    let each = meshes.iter().map(|mesh| {
        let subject = Subject::new(mesh, &primary);
        let found = subject.check(share(mesh));
        println!("{} over {}: {found}", mesh.name, subject.model.primary.kind);
        found
    });
    let found = each.fold(Found::default(), Found::and);
    let numbers = found.to_string();
    long::proved(name, "deviation bound", &numbers);
    let Found {
        points,
        above,
        worst,
    } = found;
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
            check((name, long::primary(name)), 30_000, &path);
        }
    }
}

fn at_length(name: &str) {
    if let Some(path) = long::model(name) {
        check((name, long::primary(name)), POINTS / MODELS, &path);
    }
}

long::on_every_model!(at_length);

/// `auto` takes the apple as it lies round its centre, folds at the stalk and all; charts have none.
#[test]
fn food_apple_without_folds() {
    if let Some(path) = long::model("food_apple") {
        let primary = "lscm".parse().unwrap();
        check(("food_apple, lscm", primary), POINTS / MODELS, &path);
    }
}
