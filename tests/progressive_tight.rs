//! Bounds of progressive meshes are attained: what is stored for a triangle is found in one of its points.
//!
//! Where a triangle of the reference and one of a level share a piece of T3 their distance is largest at a corner of that piece, or
//! close to one: vertices of the reference inside the triangle, and edges that cross. Here they are found by asking every
//! vertex and every edge of the reference, with side products of lines (`param::projection`) and a search for their
//! zeros, none of which the simplifier uses.

mod hills;
#[path = "long/mod.rs"]
mod long;
mod parted;

use glam::DVec3;
use invertex::lod::progressive::{Cost, Made, Progressive};
use invertex::param::projection::{Line, orientation};
use invertex::scene::Scene;
use parted::Model;
use rayon::prelude::*;
use std::collections::HashSet;

/// Triangles of each cut that are looked at.
const TRIANGLES: usize = 300;

/// The share of its bound that a triangle has to attain, and the share of triangles that have to.
const ATTAINED: f64 = 0.95;

/// The reference: vertices in T3 and in space, and edges, those of one layer after the other.
struct Reference {
    line: Line,
    t3: Vec<DVec3>,
    at: Vec<DVec3>,
    layers: Vec<Layer>,
    extent: f64,
}

#[derive(Default)]
struct Layer {
    vertices: Vec<u32>,
    edges: Vec<[u32; 2]>,
}

impl Reference {
    fn new(model: &Model) -> Self {
        let mesh = &model.mesh;
        let vertices = 0..mesh.positions.len() as u32;
        let grid = |v: u32| DVec3::from(model.grid(v).map(f64::from));
        let at: Vec<DVec3> = mesh
            .positions
            .iter()
            .map(|p| DVec3::from(p.map(f64::from)))
            .collect();
        let mut layers: Vec<Layer> = Vec::new();
        for (t, &layer) in mesh.triangles.iter().zip(&model.parts.triangle_layer) {
            let layer = sheet(model, *t, layer);
            layers.resize_with(layers.len().max(layer + 1), Layer::default);
            let layer = &mut layers[layer];
            layer.vertices.extend(t);
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                layer.edges.push([a.min(b), a.max(b)]);
            }
        }
        for layer in &mut layers {
            layer.vertices.sort_unstable();
            layer.vertices.dedup();
            layer.edges.sort_unstable();
            layer.edges.dedup();
        }
        let (low, high) = at
            .iter()
            .fold((DVec3::MAX, DVec3::MIN), |(l, h), p| (l.min(*p), h.max(*p)));
        Reference {
            line: model.primary.line(),
            t3: vertices.map(grid).collect(),
            at,
            layers,
            extent: (high - low).length(),
        }
    }

    /// How far a triangle lies from the reference at the corners of their overlay.
    fn attained(&self, model: &Model, t: &Made, place: &[u32]) -> f64 {
        let t3 = t.corners.map(|v| self.t3[v as usize]);
        let corners = t.corners.map(|v| self.at[place[v as usize] as usize]);
        let layer = &self.layers[sheet(model, t.corners, t.layer)];
        let distance = |p: DVec3, reference: DVec3| {
            let b = shares(self.line, p, &t3)?;
            Some(blend(&corners, b).distance(reference))
        };
        let sides: Vec<[f64; 3]> = self.t3.iter().map(|&p| sides(self.line, p, &t3)).collect();
        let mut largest = 0.0f64;
        for &v in &layer.vertices {
            let (p, at) = (self.t3[v as usize], self.at[v as usize]);
            largest = largest.max(distance(p, at).unwrap_or(0.0));
        }
        for &[a, b] in &layer.edges {
            let (a, b) = (a as usize, b as usize);
            for i in (0..3).filter(|&i| (sides[a][i] < 0.0) != (sides[b][i] < 0.0)) {
                let s = self.zero(i, [self.t3[a], self.t3[b]], &t3);
                let (p, at) = (
                    self.t3[a].lerp(self.t3[b], s),
                    self.at[a].lerp(self.at[b], s),
                );
                largest = largest.max(distance(p, at).unwrap_or(0.0));
            }
        }
        largest
    }

    /// Where between two points side `i` of a triangle changes its sign.
    fn zero(&self, i: usize, [a, b]: [DVec3; 2], t3: &[DVec3; 3]) -> f64 {
        let side = |s: f64| sides(self.line, a.lerp(b, s), t3)[i];
        let (mut low, mut high) = (0.0, 1.0);
        let start = side(0.0) < 0.0;
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            match (side(middle) < 0.0) == start {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }
}

/// The number of the sheet of T3 that a triangle lies on: its layer, and the side that lines meet.
fn sheet(model: &Model, corners: [u32; 3], layer: u8) -> usize {
    let sense = orientation(model.primary.line(), &corners.map(|v| model.grid(v)));
    usize::from(layer) * 3 + (sense + 1) as usize
}

/// `det(d, corner_j - p, corner_k - p)` for the three edges, with d the direction of the line through p.
fn sides(line: Line, p: DVec3, t3: &[DVec3; 3]) -> [f64; 3] {
    let d = direction(line, p);
    let w = t3.map(|c| c - p);
    [(1, 2), (2, 0), (0, 1)].map(|(j, k)| d.dot(w[j].cross(w[k])))
}

fn direction(line: Line, p: DVec3) -> DVec3 {
    match line {
        Line::Parallel => DVec3::Z,
        Line::Cylinder => p.with_z(0.0),
        Line::Sphere => p,
    }
}

/// Barycentric coordinates of the point where the line through `p` meets a triangle, if it does.
fn shares(line: Line, p: DVec3, t3: &[DVec3; 3]) -> Option<[f64; 3]> {
    let sides = sides(line, p, t3);
    let sum: f64 = sides.iter().sum();
    let normal = (t3[1] - t3[0]).cross(t3[2] - t3[0]);
    // The line runs along the triangle: what is left is rounding.
    if sum.abs() < 1e-6 * normal.length() * direction(line, p).length() {
        return None;
    }
    let b = sides.map(|side| side / sum);
    let inside = b.iter().all(|&b| b >= -1e-9);
    let ahead = line == Line::Parallel || blend(t3, b).dot(direction(line, p)) > 0.0;
    (inside && ahead).then_some(b)
}

fn blend(corners: &[DVec3; 3], b: [f64; 3]) -> DVec3 {
    corners[0] * b[0] + corners[1] * b[1] + corners[2] * b[2]
}

fn edges_of(t: &Made) -> [[u32; 2]; 3] {
    let [a, b, c] = t.corners;
    [[a, b], [b, c], [c, a]]
}

/// Of the triangles that several cuts have from collapses, but for those on rims and seams: how many there are, how many attain their bounds, the largest that
/// was found as a share of its bound.
fn tight(model: &Model, least: usize) -> (usize, usize, f64) {
    let history = Progressive::new(&model.input(), Cost::Displacement, least);
    let reference = Reference::new(model);
    let steps = history.collapses.len();
    let (mut all, mut attained, mut farthest) = (0, 0, 0.0f64);
    for collapses in [steps / 2, steps * 9 / 10, steps] {
        let cut: Vec<&Made> = history.after(collapses).collect();
        let edges: HashSet<[u32; 2]> = cut.iter().flat_map(|t| edges_of(t)).collect();
        // What the chords of a rim leave out is no part of the overlay.
        let inner = |t: &Made| edges_of(t).iter().all(|&[a, b]| edges.contains(&[b, a]));
        let made = cut.into_iter().filter(|t| t.made.is_some() && inner(t));
        let made: Vec<&Made> = made.collect();
        let some = made.par_iter().step_by(made.len() / TRIANGLES + 1);
        let shares: Vec<f64> = some
            .map(|t| {
                let found = reference.attained(model, t, &history.place);
                // What is far below the grid's step is rounding.
                let rounding = reference.extent * 1e-7;
                (found + rounding) / (f64::from(t.deviation.total) + rounding)
            })
            .collect();
        all += shares.len();
        attained += shares.iter().filter(|&&share| share >= ATTAINED).count();
        farthest = shares.into_iter().fold(farthest, f64::max);
    }
    (all, attained, farthest)
}

#[test]
fn bounds_are_attained() {
    for (name, model) in hills::models() {
        let (all, attained, farthest) = tight(&model, 0);
        println!("{name}: {attained} of {all}, at most {farthest}");
        assert!(farthest <= 1.001, "{name}: {farthest} of a bound");
        assert!(attained * 20 >= all * 19, "{name}: {attained} of {all}");
    }
}

fn at_length(name: &str) {
    if let Some(path) = long::model(name) {
        check(name, &path);
    }
}

fn check(name: &str, path: &std::path::Path) {
    let (mut all, mut attained, mut farthest) = (0, 0, 0.0f64);
    for mesh in &Scene::load(path).unwrap().meshes {
        let model = Model::with(mesh, &long::primary(name));
        let found = tight(&model, mesh.triangles.len() / 100);
        (all, attained) = (all + found.0, attained + found.1);
        farthest = farthest.max(found.2);
    }
    let numbers = format!("{attained} of {all} triangles, the farthest at {farthest:.4}");
    long::proved(name, "bound attained", &numbers);
    assert!(attained * 20 >= all * 19, "{name}: {numbers}");
}

#[test]
fn spot_attains_its_bounds() {
    if let Some(path) = long::found("spot") {
        check("spot", &path);
    }
}

long::on_every_model!(at_length);
