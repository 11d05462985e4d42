//! Pictures of a primary parameterization: its layout in T3, a checkerboard on the model, a heat map of its stretch.
//!
//! In: a mesh (cut open, where the map is computed) and its primary. Out: RGBA pixels. The model is seen orthographically from
//! above and to one side. A sphere's layout is its two halves seen from above and below. Drawn on the processor: these are
//! for looking at a map, not for comparing pixels.

use crate::mesh::Mesh;
use crate::param::projection::Line;
use crate::param::{Primary, parts};
use glam::{DMat3, DVec2, DVec3};

/// Squares of the checkerboard along the unit square, and along a quarter of a great circle.
const SQUARES: f64 = 40.0;
/// Samples along a side of a pixel.
const SAMPLES: usize = 2;

/// Square pictures, 8-bit RGBA.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapPictures {
    /// Pixels along a side.
    pub side: u32,
    /// The layout, a colour for each chart (for each part, where there are no charts).
    pub layout: Vec<u8>,
    /// The model with a checkerboard.
    pub checkerboard: Vec<u8>,
    /// The model by stretch: blue is none, red is a factor of two, either way.
    pub stretch: Vec<u8>,
}

/// The pictures of `primary` over `mesh`.
pub fn map_pictures(mesh: &Mesh, primary: &Primary, side: u32) -> MapPictures {
    let t3: Vec<DVec3> = (0..mesh.positions.len())
        .map(|v| DVec3::from(primary.t3_of(mesh, v)))
        .collect();
    let chart = parts(mesh, primary).triangle_part;
    let stretch = stretch(mesh, &t3, primary);
    let line = primary.line();
    let view = View::of(mesh);
    let seen = |t: usize| mesh.triangles[t].map(|v| view.point(mesh.positions[v as usize]));
    let mut layout = Canvas::new(side);
    // Edges of triangles as small as a pixel would hide all else.
    let edges = mesh.triangles.len() < (side as usize).pow(2) / 60;
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|v| t3[v as usize] - DVec3::from(primary.frame.origin));
        layout.flat(corners, line, (colour_of(chart[t]), edges));
    }
    let mut checkerboard = Canvas::new(side);
    let mut heat = Canvas::new(side);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|v| t3[v as usize] - DVec3::from(primary.frame.origin));
        let light = view.light(mesh.corners(t));
        checkerboard.solid(seen(t), |b| {
            let at = corners[0] * b[0] + corners[1] * b[1] + corners[2] * b[2];
            let base = if dark(at, line) {
                DVec3::new(0.25, 0.3, 0.45)
            } else {
                DVec3::new(0.95, 0.93, 0.88)
            };
            base * light
        });
        heat.solid(seen(t), |_| warmth(stretch[t]) * light);
    }
    MapPictures {
        side,
        layout: layout.pixels(),
        checkerboard: checkerboard.pixels(),
        stretch: heat.pixels(),
    }
}

/// Whether a point of T3, relative to the origin, lies on a dark square.
fn dark(p: DVec3, line: Line) -> bool {
    let even = |x: f64, y: f64| ((x * SQUARES).floor() + (y * SQUARES).floor()) as i64 & 1 == 0;
    match line {
        Line::Parallel => even(p.x, p.y),
        Line::Cylinder => even(p.y.atan2(p.x) / std::f64::consts::TAU, p.z / 4.0),
        Line::Sphere => {
            // The six faces of a cube, so that squares are of nearly one size.
            let a = p.abs();
            let (major, x, y) = match () {
                () if a.x >= a.y && a.x >= a.z => (a.x, p.y, p.z),
                () if a.y >= a.z => (a.y, p.z, p.x),
                () => (a.z, p.x, p.y),
            };
            let angle = |c: f64| (c / major).atan() / std::f64::consts::FRAC_PI_2;
            even(angle(x), angle(y))
        }
    }
}

/// For each triangle the factor of lengths that is farthest from the mean, as a power of two; infinite where it has no image.
fn stretch(mesh: &Mesh, t3: &[DVec3], primary: &Primary) -> Vec<f64> {
    let origin = DVec3::from(primary.frame.origin);
    let maps: Vec<Option<[f64; 2]>> = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
            let image =
                mesh.triangles[t].map(|v| flattened(t3[v as usize] - origin, primary.line()));
            singular(a, b, c, image)
        })
        .collect();
    let mut logs: Vec<f64> = maps
        .iter()
        .flatten()
        .map(|s| 0.5 * (s[0] * s[1]).log2())
        .filter(|x| x.is_finite())
        .collect();
    logs.sort_by(f64::total_cmp);
    let middle = logs.get(logs.len() / 2).copied().unwrap_or(0.0);
    let far = |s: &Option<[f64; 2]>| match s {
        Some([large, small]) => (large.log2() - middle)
            .abs()
            .max((small.log2() - middle).abs()),
        None => f64::INFINITY,
    };
    maps.iter().map(far).collect()
}

/// Where P brings a point: into the plane of charts, onto the cylinder, onto the sphere.
fn flattened(p: DVec3, line: Line) -> DVec3 {
    match line {
        Line::Parallel => DVec3::new(p.x, p.y, 0.0),
        Line::Cylinder => {
            (p * DVec3::new(1.0, 1.0, 0.0)).normalize_or_zero() + DVec3::new(0.0, 0.0, p.z)
        }
        Line::Sphere => p.normalize_or_zero(),
    }
}

/// Singular values of the map between triangles in space.
fn singular(a: DVec3, b: DVec3, c: DVec3, [p, q, r]: [DVec3; 3]) -> Option<[f64; 2]> {
    let plane = |a: DVec3, b: DVec3, c: DVec3| {
        let x = (b - a).try_normalize()?;
        let y = ((c - a) - x * x.dot(c - a)).try_normalize()?;
        Some([
            DVec2::new(x.dot(b - a), 0.0),
            DVec2::new(x.dot(c - a), y.dot(c - a)),
        ])
    };
    let ([e, f], [g, h]) = (plane(a, b, c)?, plane(p, q, r)?);
    let determinant = e.perp_dot(f);
    let x = (g * f.y - h * e.y) / determinant;
    let y = (h * e.x - g * f.x) / determinant;
    let same = DVec2::new(x.x + y.y, x.y - y.x).length();
    let turned = DVec2::new(x.x - y.y, x.y + y.x).length();
    let small = 0.5 * (same - turned);
    (small > 0.0).then_some([0.5 * (same + turned), small])
}

/// From blue (0) over green to red (1 and more).
fn warmth(x: f64) -> DVec3 {
    let x = x.min(1.0);
    let ramp = |centre: f64| (1.5 - 4.0 * (x - centre).abs()).clamp(0.0, 1.0);
    DVec3::new(ramp(0.85), ramp(0.5), ramp(0.15)) * 0.85 + 0.1
}

/// A colour that differs from those of the numbers near it.
fn colour_of(number: u32) -> DVec3 {
    let hue = f64::from(number) * 0.618_033_988_749_895;
    let channel = |shift: f64| 0.62 + 0.3 * ((hue + shift) * std::f64::consts::TAU).cos();
    DVec3::new(channel(0.0), channel(1.0 / 3.0), channel(2.0 / 3.0))
}

/// An orthographic view of a model that fills the picture.
struct View {
    turn: DMat3,
    middle: DVec3,
    scale: f64,
}

impl View {
    fn of(mesh: &Mesh) -> View {
        let turn = DMat3::from_rotation_x(0.35) * DMat3::from_rotation_y(-0.6);
        let turned = mesh
            .positions
            .iter()
            .map(|p| turn * DVec3::from(p.map(f64::from)));
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = turned.fold(start, |(low, high), p| (low.min(p), high.max(p)));
        let extent = (high - low).truncate().max_element();
        View {
            turn,
            middle: (low + high) * 0.5,
            scale: if extent > 0.0 { 0.94 / extent } else { 1.0 },
        }
    }

    /// In the unit square, y down; z towards the eye.
    fn point(&self, p: [f32; 3]) -> DVec3 {
        let p = (self.turn * DVec3::from(p.map(f64::from)) - self.middle) * self.scale;
        DVec3::new(0.5 + p.x, 0.5 - p.y, p.z)
    }

    fn light(&self, corners: [[f32; 3]; 3]) -> f64 {
        let [a, b, c] = corners.map(|p| self.turn * DVec3::from(p.map(f64::from)));
        let normal = (b - a).cross(c - a).normalize_or_zero();
        0.45 + 0.55 * normal.dot(DVec3::new(0.3, 0.5, 0.8).normalize()).abs()
    }
}

/// Samples with depth.
struct Canvas {
    side: usize,
    colour: Vec<DVec3>,
    depth: Vec<f64>,
}

impl Canvas {
    fn new(side: u32) -> Canvas {
        let side = side as usize * SAMPLES;
        Canvas {
            side,
            colour: vec![DVec3::ONE; side * side],
            depth: vec![f64::NEG_INFINITY; side * side],
        }
    }

    /// A triangle in the unit square (z nearer is larger), coloured by its barycentric coordinates.
    fn solid(&mut self, corners: [DVec3; 3], colour: impl Fn([f64; 3]) -> DVec3) {
        let [a, b, c] = corners.map(|p| p.truncate() * self.side as f64);
        let double = (b - a).perp_dot(c - a);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f64, high: f64| {
            let last = self.side as f64 - 1.0;
            (
                low.floor().clamp(0.0, last) as usize,
                high.ceil().clamp(0.0, last) as usize,
            )
        };
        let ((left, right), (top, bottom)) = (range(low.x, high.x), range(low.y, high.y));
        if double == 0.0 || !double.is_finite() {
            return;
        }
        for y in top..=bottom {
            for x in left..=right {
                let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let weights = [
                    (b - p).perp_dot(c - p),
                    (c - p).perp_dot(a - p),
                    (a - p).perp_dot(b - p),
                ]
                .map(|w| w / double);
                let depth = weights[0] * corners[0].z
                    + weights[1] * corners[1].z
                    + weights[2] * corners[2].z;
                let at = y * self.side + x;
                if weights.iter().all(|w| *w >= 0.0) && depth > self.depth[at] {
                    self.depth[at] = depth;
                    self.colour[at] = colour(weights);
                }
            }
        }
    }

    /// A triangle of T3, relative to the origin, with its edges.
    fn flat(&mut self, corners: [DVec3; 3], line: Line, (base, edges): (DVec3, bool)) {
        let place = |p: DVec3| match line {
            Line::Parallel => DVec3::new(0.5 + p.x, 0.5 - p.y, 0.0),
            Line::Cylinder => DVec3::new(
                0.5 + p.y.atan2(p.x) / std::f64::consts::TAU,
                0.5 - 0.5 * p.z,
                0.0,
            ),
            Line::Sphere => {
                let p = p.normalize_or_zero() * 0.24;
                let up = corners.iter().map(|c| c.z).sum::<f64>() >= 0.0;
                DVec3::new(if up { 0.25 + p.x } else { 0.75 - p.x }, 0.5 - p.y, 0.0)
            }
        };
        let corners = corners.map(place);
        let line_width = 1.2 / self.side as f64;
        let [a, b, c] = corners.map(DVec3::truncate);
        let double = (b - a).perp_dot(c - a).abs();
        let heights =
            [(c - b).length(), (a - c).length(), (b - a).length()].map(|edge| double / edge);
        self.solid(corners, |w| {
            let at_edge = (0..3).any(|k| w[k] * heights[k] < line_width);
            if at_edge && edges { base * 0.45 } else { base }
        });
    }

    fn pixels(&self) -> Vec<u8> {
        let side = self.side / SAMPLES;
        let mut out = Vec::with_capacity(side * side * 4);
        for y in 0..side {
            for x in 0..side {
                let mut sum = DVec3::ZERO;
                for (i, j) in (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j))) {
                    sum += self.colour[(y * SAMPLES + i) * self.side + x * SAMPLES + j];
                }
                let byte = |c: f64| {
                    (c / (SAMPLES * SAMPLES) as f64 * 255.0)
                        .round()
                        .clamp(0.0, 255.0) as u8
                };
                out.extend([byte(sum.x), byte(sum.y), byte(sum.z), 255]);
            }
        }
        out
    }
}
