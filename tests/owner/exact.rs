//! The brute force: does a projection line meet a closed triangle? In rational numbers, triangle by triangle.

use invertex::param::grid::QUERY_SHIFT;
use invertex::param::projection::Line;

/// Closed containment by an independent route, in i128. Vertices are multiples of 2^11 vertex steps ([`super::cases`]) and
/// everything is divided by what is common, so that no product overflows.
pub(crate) fn contains(line: Line, q: [i32; 3], t: &[[i32; 3]; 3]) -> bool {
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

pub(crate) fn minus(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
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
