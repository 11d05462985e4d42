//! Tessellation: rows along s (closer where the silhouette or the relief bends), 240 columns round.
//!
//! In: surface and atlas. Out: the arrays of a glTF primitive. Each chart has its own vertices; vertices of
//! neighbouring charts at the same place have the same position and normal bits.

use crate::atlas::{Atlas, COLUMNS, Chart};
use crate::surface::Surface;
use glam::{DVec2, DVec3};

#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) tangents: Vec<[f32; 4]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) indices: Vec<u32>,
}

/// Longest row, and most the silhouette turns (radians) from one row to the next.
const ROW: f64 = 0.056;
const BEND: f64 = 0.62;

/// Rows per unit of length where relief is finer than the silhouette: (from height, to height, row length).
const FINE: [(f64, f64, f64); 3] = [
    (1.29, 1.36, 0.014),
    (1.478, 1.524, 0.0075),
    (0.285, 0.36, 0.024),
];

/// Cost of the silhouette between two arc lengths, in rows.
fn cost(surface: &Surface, a: f64, b: f64) -> f64 {
    let profile = surface.profile;
    let (p, q) = (profile.at(a), profile.at(b));
    let before = profile.at(a - (b - a));
    let angle = |from: crate::profile::Point, to: crate::profile::Point| {
        libm::atan2(to.height - from.height, to.radius - from.radius)
    };
    let bend = if a > 0.0 {
        (angle(p, q) - angle(before, p)).abs()
    } else {
        0.0
    };
    let longest = FINE
        .iter()
        .filter(|f| p.height >= f.0 && p.height < f.1)
        .map(|f| f.2)
        .fold(ROW, f64::min);
    ((b - a) / longest).max(bend / BEND)
}

/// Arc lengths of the rows of one chart, both ends included.
fn rows(surface: &Surface, (from, to): (f64, f64)) -> Vec<f64> {
    const SAMPLES: usize = 2000;
    let at = |i: usize| from + (to - from) * i as f64 / SAMPLES as f64;
    let mut sum = vec![0.0];
    for i in 0..SAMPLES {
        sum.push(sum[i] + cost(surface, at(i), at(i + 1)));
    }
    let count = libm::ceil(sum[SAMPLES]).max(1.0) as usize;
    (0..=count)
        .map(|row| match row {
            0 => from,
            last if last == count => to,
            _ => at(sum.partition_point(|&c| c < sum[SAMPLES] * row as f64 / count as f64)),
        })
        .collect()
}

/// The direction in which u grows, on the surface: from the Jacobian of (s, turn) -> uv.
fn tangent(
    surface: &Surface,
    atlas: &Atlas,
    chart: &Chart,
    s: f64,
    turn: f64,
    normal: DVec3,
) -> DVec3 {
    let (ds, dt) = (2e-4, 2e-4);
    let uv = |s: f64, turn: f64| -> DVec2 { atlas.texel(surface.profile, chart, s, turn) };
    let total = surface.profile.total();
    let s = s.clamp(4e-3, total - 4e-3);
    let along = (uv(s + ds, turn) - uv(s - ds, turn)) / (2.0 * ds);
    let round = (uv(s, turn + dt) - uv(s, turn - dt)) / (2.0 * dt);
    let (p_along, p_round) = surface.derivatives(s, turn);
    // Solve J (ds, dturn) = (1, 0).
    let determinant = along.x * round.y - round.x * along.y;
    let raw = (p_along * round.y - p_round * along.y) / determinant;
    (raw - normal * raw.dot(normal)).normalize_or(DVec3::X)
}

impl Mesh {
    fn vertex(&mut self, surface: &Surface, atlas: &Atlas, chart: &Chart, s: f64, column: u32) {
        let turn = f64::from(column) / f64::from(COLUMNS);
        let wrapped = f64::from(column % COLUMNS) / f64::from(COLUMNS);
        let normal = surface.normal(s, wrapped);
        let tangent = tangent(surface, atlas, chart, s, turn, normal);
        let uv = atlas.uv(surface.profile, chart, s, turn);
        self.positions
            .push(surface.position(s, wrapped).as_vec3().to_array());
        self.normals.push(normal.as_vec3().to_array());
        self.tangents.push(tangent.as_vec3().extend(1.0).to_array());
        self.uvs.push(uv.as_vec2().to_array());
    }

    fn chart(&mut self, surface: &Surface, atlas: &Atlas, chart: &Chart) {
        let rows = rows(surface, chart.s);
        let (first, last) = chart.columns;
        let base = self.positions.len() as u32;
        let width = last - first + 1;
        for &s in &rows {
            for column in first..=last {
                self.vertex(surface, atlas, chart, s, column);
            }
        }
        let total = surface.profile.total();
        for row in 0..rows.len() as u32 - 1 {
            for column in 0..width - 1 {
                let a = base + row * width + column;
                let (b, c, d) = (a + 1, a + width, a + width + 1);
                // At the ends of the axis a row is one point: half of each quad has no area.
                if rows[row as usize] > 0.0 {
                    self.indices.extend([a, b, d]);
                }
                if rows[row as usize + 1] < total {
                    self.indices.extend([a, d, c]);
                }
            }
        }
    }
}

/// The whole vase.
pub(crate) fn tessellate(surface: &Surface, atlas: &Atlas) -> Mesh {
    let mut mesh = Mesh::default();
    for chart in &atlas.charts {
        mesh.chart(surface, atlas, chart);
    }
    mesh
}
