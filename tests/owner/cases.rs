//! Small surfaces with every awkward feature, and the points that are asked about them.

use invertex::igt::Reference;
use invertex::mesh::{Mesh, shapes};
use invertex::param::grid::{QUERY_MAX, QUERY_SHIFT};
use invertex::param::{Axis, Primary, PrimaryKind};

/// A small deterministic generator (SplitMix64, Steele et al. 2014).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) mesh: Mesh,
    pub(crate) primary: Primary,
}

/// A case whose vertices lie on multiples of 2^11 vertex-grid steps: edges then have many grid points on them.
fn coarse(name: &'static str, mut mesh: Mesh, kind: PrimaryKind, origin: [f64; 3]) -> Case {
    let mut primary = Primary::new(kind, &mesh, origin).unwrap();
    primary.frame.scale = (1u64 << 22) as f64;
    let steps = 2048.0;
    let round = |x: f32, o: f64| ((((x as f64 - o) * steps).round()) / steps + o) as f32;
    if let PrimaryKind::UvSet(set) = kind {
        for uv in &mut mesh.uv_sets[set as usize] {
            *uv = [round(uv[0], origin[0]), round(uv[1], origin[1])];
        }
    } else {
        for p in &mut mesh.positions {
            *p = [0, 1, 2].map(|k| round(p[k], origin[k]));
        }
    }
    Case {
        name,
        mesh,
        primary,
    }
}

pub(crate) fn cases() -> Vec<Case> {
    vec![
        coarse(
            "uv",
            shapes::grid(9),
            PrimaryKind::UvSet(0),
            [0.5, 0.5, 0.0],
        ),
        coarse("charts", charts(), PrimaryKind::UvSet(0), [0.5, 0.5, 0.0]),
        coarse(
            "relief",
            relief(),
            PrimaryKind::Plane(Axis::Z),
            [0.5, 0.5, 0.0],
        ),
        coarse(
            "plane",
            shapes::grid(7),
            PrimaryKind::Plane(Axis::Z),
            [0.5, 0.5, 0.0],
        ),
        coarse(
            "cylinder",
            shapes::tube(13, 5),
            PrimaryKind::Cylinder(Axis::Z),
            [0.0; 3],
        ),
        coarse(
            "closed about the axis",
            shapes::uv_sphere(9, 6),
            PrimaryKind::Cylinder(Axis::Z),
            [0.0; 3],
        ),
        coarse(
            "sphere of octants",
            shapes::octahedron(),
            PrimaryKind::Sphere,
            [0.0; 3],
        ),
        coarse(
            "icosphere",
            shapes::icosphere(2),
            PrimaryKind::Sphere,
            [0.0; 3],
        ),
        coarse(
            "globe with poles",
            shapes::uv_sphere(12, 7),
            PrimaryKind::Sphere,
            [0.0; 3],
        ),
    ]
}

/// A grid whose inner vertices are moved about: slivers, and no two edges in line.
fn uneven(n: u32) -> Mesh {
    let mut mesh = shapes::grid(n);
    let mut random = Random(77);
    let mut away = || (random.below(1000) as f32 / 1000.0 - 0.5) * 0.6 / n as f32;
    for (p, uv) in mesh.positions.iter_mut().zip(&mut mesh.uv_sets[0]) {
        let (x, y) = (p[0] + away(), p[1] + away());
        if p[..2].iter().all(|c| *c > 0.0 && *c < 1.0) {
            *p = [x, y, 0.0];
            *uv = [x, y];
        }
    }
    mesh
}

/// Heights over an uneven grid, seen along z.
fn relief() -> Mesh {
    let mut mesh = uneven(11);
    let mut random = Random(5);
    for p in &mut mesh.positions {
        p[2] = random.below(1000) as f32 / 1500.0 - 0.3;
    }
    mesh
}

/// Four charts with a seam between each two: one as it was, one mirrored, one turned by a quarter, one half as large.
fn charts() -> Mesh {
    let whole = uneven(10);
    let mut mesh = shapes::grid(1);
    (mesh.positions, mesh.normals, mesh.triangles) = (vec![], vec![], vec![]);
    mesh.uv_sets[0].clear();
    let place = |chart: usize, [u, v]: [f32; 2]| match chart {
        0 => [0.02 + 0.46 * u, 0.02 + 0.46 * v],
        1 => [0.98 - 0.46 * u, 0.02 + 0.46 * v],
        2 => [0.02 + 0.46 * v, 0.98 - 0.46 * u],
        _ => [0.6 + 0.23 * u, 0.6 + 0.23 * v],
    };
    for chart in 0..4 {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&whole.positions);
        mesh.normals.extend(&whole.normals);
        mesh.uv_sets[0].extend(whole.uv_sets[0].iter().map(|uv| place(chart, *uv)));
        mesh.triangles
            .extend(whole.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh
}

/// Random points, and adversarial ones: vertices, edge points, texel borders, seams, poles, the centre and the axis.
pub(crate) fn points(
    case: &Case,
    reference: &Reference,
    bits: u32,
    count: usize,
    seed: u64,
) -> Vec<[i32; 3]> {
    let mut random = Random(0x1234_5678 + case.name.len() as u64 + (seed << 32));
    let mut out = Vec::with_capacity(count * 4);
    for i in 0..count {
        let free = [0, 1, 2].map(|_| (random.next() as i32 >> 2).clamp(-QUERY_MAX, QUERY_MAX));
        out.push(free);
        let t = reference.corners(random.below(reference.triangles.len()));
        let v = t.map(|p| p.map(|x| x << QUERY_SHIFT));
        out.push(v[i % 3]);
        // Quarter points of edges lie on the grid because vertices are multiples of 2^17 query steps.
        let k = random.below(5) as i32;
        out.push([0, 1, 2].map(|c| v[0][c] + ((v[1][c] - v[0][c]) >> 2) * k));
        let border = [0, 1, 2].map(|c| {
            let step = 1i32 << (30 - bits);
            if random.below(2) == 0 {
                free[c] / step * step
            } else {
                0
            }
        });
        out.push(border);
    }
    out
}
