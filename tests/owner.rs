//! Exactly one owner: every query point inside the covered domain is owned by one triangle, never none, never two.
//!
//! A brute force over all triangles that shares no code with the lookup (the line meets each triangle's plane in a
//! rational point, which is tested against the edges inside the plane) says which closed triangles contain the point; the
//! lookup must name one of them, and exactly one triangle may claim it.
//! The number of points is INVERTEX_OWNER_POINTS (default 3 000 of each of four sorts per primary).

use invertex::igt::{BuildOptions, Layout, Needs, Reference, Tables, build_cpu};
use invertex::mesh::{Mesh, shapes};
use invertex::param::grid::{QUERY_MAX, QUERY_SHIFT};
use invertex::param::projection::{self, Line};
use invertex::param::{Axis, Primary, PrimaryKind};
use rayon::prelude::*;

/// A small deterministic generator (SplitMix64, Steele et al. 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

fn points_per_sort() -> usize {
    std::env::var("INVERTEX_OWNER_POINTS")
        .ok()
        .and_then(|n| n.parse().ok())
        .unwrap_or(3_000)
}

/// Closed containment by an independent route, in i128. Vertices are multiples of 2^11 vertex steps ([`coarse`]) and
/// everything is divided by what is common, so that no product overflows.
fn contains(line: Line, q: [i32; 3], t: &[[i32; 3]; 3]) -> bool {
    let wide = |p: [i32; 3]| p.map(|x| x as i128);
    let v = t.map(|p| wide(p).map(|x| x << QUERY_SHIFT));
    let q = wide(q);
    let (start, d, half) = match line {
        Line::Parallel => ([q[0], q[1], 0], [0, 0, 1], false),
        Line::Cylinder => ([0, 0, q[2]], [q[0], q[1], 0], true),
        Line::Sphere => ([0, 0, 0], q, true),
    };
    // For parallel lines the third coordinate is free.
    let v = if line == Line::Parallel {
        v.map(|p| [p[0], p[1], 0])
    } else {
        v
    };
    let n = reduced(cross(minus(v[1], v[0]), minus(v[2], v[0])));
    let along = dot(n, d);
    if along == 0 {
        return false;
    }
    let far = dot(n, minus(v[0], start));
    // A half-line that starts in the triangle's plane (on the axis) touches it in the closed sense.
    if half && (far.signum() * along.signum() < 0 || far == 0 && line == Line::Sphere) {
        return false;
    }
    // The meeting point is start + d far / along. Which side of the plane through the line's start, perpendicular within the
    // triangle's plane, each edge lies on is decided with everything scaled by `along`, reduced first.
    let g = gcd(far, along);
    let (far, along) = (far / g, along / g);
    (0..3).all(|i| {
        let (a, b) = (v[i], v[(i + 1) % 3]);
        let inward = cross(n, reduced(minus(b, a)));
        let inward = reduced(inward);
        let (from, step) = (dot(inward, minus(start, a)), dot(inward, d));
        compare_products(from, along, -step, far) * (along.signum() as i32) >= 0
    })
}

/// The sign of a b - c d without overflow (256-bit products by halves).
fn compare_products(a: i128, b: i128, c: i128, d: i128) -> i32 {
    let wide = |x: i128, y: i128| {
        let negative = (x < 0) != (y < 0);
        let (x, y) = (x.unsigned_abs(), y.unsigned_abs());
        let mask = u64::MAX as u128;
        let (xl, xh, yl, yh) = (x & mask, x >> 64, y & mask, y >> 64);
        let low = xl * yl;
        let middle = xh * yl + (low >> 64);
        let middle2 = xl * yh + (middle & mask);
        let high = xh * yh + (middle >> 64) + (middle2 >> 64);
        let low = (middle2 << 64) | (low & mask);
        (negative && (high, low) != (0, 0), high, low)
    };
    let (p, r) = (wide(a, b), wide(c, d));
    let order = match (p.0, r.0) {
        (false, true) => std::cmp::Ordering::Greater,
        (true, false) => std::cmp::Ordering::Less,
        (false, false) => (p.1, p.2).cmp(&(r.1, r.2)),
        (true, true) => (r.1, r.2).cmp(&(p.1, p.2)),
    };
    order as i32
}

fn minus(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn gcd(a: i128, b: i128) -> i128 {
    let (mut a, mut b) = (a.unsigned_abs(), b.unsigned_abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.max(1) as i128
}

fn reduced(p: [i128; 3]) -> [i128; 3] {
    let g = gcd(gcd(p[0], p[1]), p[2]);
    p.map(|x| x / g)
}

struct Case {
    name: &'static str,
    mesh: Mesh,
    primary: Primary,
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

fn cases() -> Vec<Case> {
    vec![
        coarse(
            "uv",
            shapes::grid(9),
            PrimaryKind::UvSet(0),
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

/// Random points, and adversarial ones: vertices, edge points, texel borders, seams, poles, the centre and the axis.
fn points(case: &Case, reference: &Reference, bits: u32, count: usize) -> Vec<[i32; 3]> {
    let mut random = Random(0x1234_5678 + case.name.len() as u64);
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

fn check(case: &Case, layout: Layout, hash: u32) -> (usize, usize) {
    let layer = vec![0; case.mesh.triangles.len()];
    let reference = Reference::new(&case.mesh, &case.primary, &layer, layout).unwrap();
    let tables = build_cpu(&reference, &Needs::default(), BuildOptions { hash, layout }).unwrap();
    tables.validate(reference.triangles.len()).unwrap();
    let points = points(case, &reference, tables.bits(), points_per_sort());
    let covered = points
        .par_iter()
        .filter(|q| owner_is_one(case, &reference, &tables, **q))
        .count();
    (points.len(), covered)
}

/// Asserts the promise for one point; whether it is covered.
fn owner_is_one(case: &Case, reference: &Reference, tables: &Tables, q: [i32; 3]) -> bool {
    let line = case.primary.line();
    let all = 0..reference.triangles.len();
    let inside: Vec<usize> = all
        .clone()
        .filter(|t| contains(line, q, &reference.corners(*t)))
        .collect();
    let claims: Vec<usize> = all
        .filter(|t| projection::hit(line, q, &reference.corners(*t)).is_some())
        .collect();
    let found = tables.lookup(q, None, false);
    assert!(
        claims.len() <= 1,
        "{}: {q:?} has owners {claims:?}",
        case.name
    );
    assert_eq!(
        found.map(|f| f.triangle as usize),
        claims.first().copied(),
        "{}: lookup at {q:?}",
        case.name
    );
    let on_axis =
        line != Line::Parallel && q[0] == 0 && q[1] == 0 && (line == Line::Cylinder || q[2] == 0);
    if let Some(owner) = claims.first() {
        assert!(
            on_axis || inside.contains(owner),
            "{}: {q:?} owner {owner} inside {inside:?}",
            case.name
        );
    }
    if line == Line::Sphere || interior(case, reference, q, &inside) {
        assert_eq!(
            claims.len(),
            1,
            "{}: hole at {q:?}, inside {inside:?}",
            case.name
        );
    }
    claims.len() == 1
}

/// Whether a covered point is away from the surface's border: it stays inside when moved a step in every direction.
fn interior(case: &Case, reference: &Reference, q: [i32; 3], inside: &[usize]) -> bool {
    let line = case.primary.line();
    let covered =
        |p| (0..reference.triangles.len()).any(|t| contains(line, p, &reference.corners(t)));
    let steps = [
        [1, 0, 0],
        [-1, 0, 0],
        [0, 1, 0],
        [0, -1, 0],
        [0, 0, 1],
        [0, 0, -1],
    ];
    !inside.is_empty()
        && steps
            .iter()
            .all(|s| covered([0, 1, 2].map(|k| (q[k] + 64 * s[k]).clamp(-QUERY_MAX, QUERY_MAX))))
}

#[test]
fn every_covered_point_has_exactly_one_owner() {
    for case in cases() {
        for (layout, hash) in [
            (Layout::Packed, 4),
            (Layout::Packed, 64),
            (Layout::Classic, 32),
        ] {
            // RGB9E5 moves vertices by up to 1/512: only shapes whose faces survive that are one-to-one.
            if layout == Layout::Classic && case.mesh.triangles.len() > 100 {
                continue;
            }
            let (points, covered) = check(&case, layout, hash);
            println!(
                "{}: {layout:?} {hash}: {points} points, {covered} covered, 0 holes, 0 doubles",
                case.name
            );
            assert!(
                covered * 20 > points,
                "{}: hardly any point is covered",
                case.name
            );
        }
    }
}

#[test]
fn a_missing_triangle_makes_a_hole() {
    // Negative control: the same check must fail on a sphere with one triangle left out.
    let mut case = cases().into_iter().find(|c| c.name == "icosphere").unwrap();
    case.mesh.triangles.remove(17);
    let broken = std::panic::catch_unwind(|| check(&case, Layout::Packed, 16));
    assert!(broken.is_err());
}
