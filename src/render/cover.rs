//! Which pixels a triangle covers, at what depth, and where inside it a pixel lies. Twin of `glsl/render/cover.glsl`.
//!
//! In: three [`Projected`] corners and a pixel. Out: the sign of the triangle as seen, the depth, barycentrics.
//!
//! Edge k runs from corner k + 1 to corner k + 2; its value at a pixel is the cross product of the two corners taken
//! relative to the pixel. Between ordinary corners near the pixel that is an exact integer; otherwise a float whose
//! sign two triangles that share the edge still see as exact opposites. A pixel exactly on an edge belongs to the
//! triangle for which the edge is a left or a top one. So every pixel inside a fan of triangles has exactly one owner,
//! and nothing is left to a rasteriser's own rules. Corners behind the eye need no clipping: the homogeneous cross
//! products (Olano and Greer, *Triangle scan conversion using 2D homogeneous coordinates*, 1997) hold for them too.

use super::draw::Projected;

/// What the three edges say at one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges {
    /// The sign counts: the same as of `weight`, but exact between ordinary corners.
    pub value: [f32; 3],
    /// Barycentrics in the triangle's plane, up to a common factor.
    pub weight: [f32; 3],
    /// Direction of each edge, for pixels exactly on it.
    pub step: [[f32; 2]; 3],
}

/// A corner relative to a pixel, in sixteenths (times w for a corner that is not ordinary).
struct Relative {
    ix: i32,
    iy: i32,
    x: f32,
    y: f32,
    near: bool,
}

fn relative(v: &Projected, px: i32, py: i32) -> Relative {
    if v.ordinary != 0 {
        let (ix, iy) = (v.x - (px * 16 + 8), v.y - (py * 16 + 8));
        let near = ix.abs() < 32768 && iy.abs() < 32768;
        Relative {
            ix,
            iy,
            x: ix as f32,
            y: iy as f32,
            near,
        }
    } else {
        let x = (v.hx - (px as f32 + 0.5) * v.w) * 16.0;
        let y = (v.hy - (py as f32 + 0.5) * v.w) * 16.0;
        Relative {
            ix: 0,
            iy: 0,
            x,
            y,
            near: false,
        }
    }
}

/// The edges of `corner` at the centre of pixel (`px`, `py`).
pub(crate) fn edges(corner: &[Projected; 3], px: i32, py: i32) -> Edges {
    let at = [
        relative(&corner[0], px, py),
        relative(&corner[1], px, py),
        relative(&corner[2], px, py),
    ];
    let all_ordinary = corner.iter().all(|c| c.ordinary != 0);
    let mut out = Edges {
        value: [0.0; 3],
        weight: [0.0; 3],
        step: [[0.0; 2]; 3],
    };
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (a, b) = (&at[i], &at[j]);
        let (va, vb) = (&corner[i], &corner[j]);
        if va.ordinary != 0 && vb.ordinary != 0 {
            out.value[k] = if a.near && b.near {
                (a.ix * b.iy - b.ix * a.iy) as f32
            } else {
                a.x * b.y - b.x * a.y
            };
            out.step[k] = [b.x - a.x, b.y - a.y];
            out.weight[k] = if all_ordinary {
                out.value[k] * corner[k].inverse_w
            } else {
                out.value[k] * va.w * vb.w
            };
        } else {
            let (ax, ay) = homogeneous(a, va);
            let (bx, by) = homogeneous(b, vb);
            out.value[k] = ax * by - bx * ay;
            out.step[k] = [bx - ax, by - ay];
            out.weight[k] = out.value[k];
        }
    }
    out
}

fn homogeneous(at: &Relative, v: &Projected) -> (f32, f32) {
    if v.ordinary != 0 {
        (at.x * v.w, at.y * v.w)
    } else {
        (at.x, at.y)
    }
}

impl Edges {
    /// +1 or -1, the sense in which the triangle is seen (y down), where it covers the pixel; 0 where it does not.
    pub(crate) fn covers(&self) -> i32 {
        let [a, b, c] = self.value;
        if a >= 0.0 && b >= 0.0 && c >= 0.0 && (a > 0.0 || b > 0.0 || c > 0.0) {
            i32::from((0..3).all(|k| self.value[k] > 0.0 || owned(self.step[k], 1.0)))
        } else if a <= 0.0 && b <= 0.0 && c <= 0.0 && (a < 0.0 || b < 0.0 || c < 0.0) {
            -i32::from((0..3).all(|k| self.value[k] < 0.0 || owned(self.step[k], -1.0)))
        } else {
            0
        }
    }

    /// Barycentrics in the plane of the triangle, seen with `sense`; none where the plane is behind the eye.
    pub(crate) fn barycentric(&self, sense: i32) -> Option<[f32; 3]> {
        let [a, b, c] = self.weight;
        let sum = a + b + c;
        let seen = sum * sense as f32;
        // Where the plane is seen edge on, barycentrics grow without bound.
        let bounded = a.abs() + b.abs() + c.abs() < seen * 1e6;
        (seen > 1e-30 && bounded).then(|| [a / sum, b / sum, c / sum])
    }
}

/// Whether a pixel on an edge is the triangle's: left and top edges.
fn owned(step: [f32; 2], sense: f32) -> bool {
    let (x, y) = (step[0] * sense, step[1] * sense);
    y < 0.0 || (y == 0.0 && x > 0.0)
}

/// Depth in 0..1 at barycentrics `b` after a `step` in clip-space depth and w; none outside, and none behind the eye.
pub(crate) fn depth(corner: &[Projected; 3], b: [f32; 3], step: [f32; 2]) -> Option<f32> {
    let z = b[0] * corner[0].z + b[1] * corner[1].z + b[2] * corner[2].z + step[0];
    let w = b[0] * corner[0].w + b[1] * corner[1].w + b[2] * corner[2].w + step[1];
    if w > 1e-20 {
        let depth = z / w;
        (0.0..1.0).contains(&depth).then_some(depth)
    } else {
        None
    }
}

/// The pixels a triangle may cover: first and last column and row, inside the image; none if it cannot be seen.
pub(crate) fn bounds(corner: &[Projected; 3], width: u32, height: u32) -> Option<[i32; 4]> {
    let (right, bottom) = (width as i32 - 1, height as i32 - 1);
    let (w, h) = (width as i32 as f32, height as i32 as f32);
    let outside = |test: &dyn Fn(&Projected) -> bool| corner.iter().all(test);
    if outside(&|v| v.z < 0.0) || outside(&|v| v.z > v.w) {
        return None;
    }
    if corner.iter().all(|v| v.ordinary != 0) {
        let x = corner.map(|v| v.x);
        let y = corner.map(|v| v.y);
        let least = |c: [i32; 3]| (c[0].min(c[1]).min(c[2]) + 7) >> 4;
        let most = |c: [i32; 3]| (c[0].max(c[1]).max(c[2]) - 8) >> 4;
        let b = [
            least(x).max(0),
            most(x).min(right),
            least(y).max(0),
            most(y).min(bottom),
        ];
        return (b[0] <= b[1] && b[2] <= b[3]).then_some(b);
    }
    if outside(&|v| v.hx < 0.0)
        || outside(&|v| v.hx > w * v.w)
        || outside(&|v| v.hy < 0.0)
        || outside(&|v| v.hy > h * v.w)
    {
        return None;
    }
    Some([0, right, 0, bottom])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repeatable sequence of numbers in 0..bound.
    struct Sequence(u64);

    impl Sequence {
        fn below(&mut self, bound: u64) -> i32 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((self.0 >> 33) % bound) as i32
        }
    }

    fn at(x: i32, y: i32, w: f32) -> Projected {
        let (hx, hy) = (x as f32 / 16.0 * w, y as f32 / 16.0 * w);
        Projected {
            x,
            y,
            z: 0.5 * w,
            w,
            hx,
            hy,
            inverse_w: 1.0 / w,
            ordinary: 1,
        }
    }

    fn owners(triangles: &[[Projected; 3]], x: i32, y: i32) -> usize {
        triangles
            .iter()
            .filter(|t| edges(t, x, y).covers() != 0)
            .count()
    }

    /// A square cut into fans about inner points that lie on pixel centres as often as not.
    fn fans(sequence: &mut Sequence, side: i32) -> Vec<[Projected; 3]> {
        let mut out = Vec::new();
        for cell_y in 0..4 {
            for cell_x in 0..4 {
                let (x0, y0, s) = (cell_x * side, cell_y * side, side);
                let snap = sequence.below(2) * 15 + 1;
                let inner = |v: i32| v / snap * snap + if snap == 16 { 8 } else { 0 };
                let middle = [
                    x0 + inner(sequence.below(s as u64 - 17)).max(1),
                    y0 + inner(sequence.below(s as u64 - 17)).max(1),
                ];
                let c = [[x0, y0], [x0 + s, y0], [x0 + s, y0 + s], [x0, y0 + s]];
                for k in 0..4 {
                    let (a, b) = (c[k], c[(k + 1) % 4]);
                    let w = |p: [i32; 2]| 1.0 + (p[0] * 7 + p[1] * 3) as f32 * 1e-3;
                    let corner = [a, b, middle].map(|p| at(p[0] - 40, p[1] - 24, w(p)));
                    // Every other triangle turned round: the rule must not depend on winding.
                    out.push(if k % 2 == 0 {
                        corner
                    } else {
                        [corner[1], corner[0], corner[2]]
                    });
                }
            }
        }
        out
    }

    #[test]
    fn every_pixel_of_a_cut_square_has_exactly_one_owner() {
        let mut sequence = Sequence(1);
        for round in 0..40 {
            let side = 8 + round * 8;
            let triangles = fans(&mut sequence, side.max(40));
            let size = 4 * side.max(40);
            for y in -3..size / 16 {
                for x in -3..size / 16 {
                    let (cx, cy) = (x * 16 + 8 + 40, y * 16 + 8 + 24);
                    // The square is half open: its left and top sides are its own.
                    let inside = (0..size).contains(&cx) && (0..size).contains(&cy);
                    assert_eq!(
                        owners(&triangles, x, y),
                        usize::from(inside),
                        "{round} {x} {y}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_plane_through_the_eye_covers_half_the_image_without_holes() {
        // Homogeneous pixels of the floor y = -1 seen from the origin: a grid of squares, some behind the eye.
        let point = |x: f32, z: f32| {
            let (w, size) = (-z, 64.0);
            let (hx, hy) = (x * size / 2.0 + size / 2.0 * w, size / 2.0 + size / 2.0 * w);
            let mut v = Projected {
                z: 0.5 * w,
                w,
                hx,
                hy,
                ..Projected::default()
            };
            if w > 1e-20 {
                (v.x, v.y) = (
                    (hx / w * 16.0 + 0.5).floor() as i32,
                    (hy / w * 16.0 + 0.5).floor() as i32,
                );
                (v.inverse_w, v.ordinary) = (1.0 / w, 1);
            }
            v
        };
        let mut triangles = Vec::new();
        for i in -40..40 {
            for j in -100..20 {
                let (x, z) = (i as f32 * 2.5, j as f32 * 2.5 + 0.7);
                let c = [
                    point(x, z),
                    point(x + 2.5, z),
                    point(x + 2.5, z + 2.5),
                    point(x, z + 2.5),
                ];
                triangles.push([c[0], c[1], c[2]]);
                triangles.push([c[0], c[2], c[3]]);
            }
        }
        for y in 0..64 {
            for x in 0..64 {
                let seen: Vec<_> = triangles
                    .iter()
                    .filter(|t| {
                        let e = edges(t, x, y);
                        let sense = e.covers();
                        sense != 0
                            && e.barycentric(sense)
                                .and_then(|b| depth(t, b, [0.0; 2]))
                                .is_some()
                    })
                    .collect();
                // Below the horizon the floor, once; above it nothing, though its mirror image would project there.
                assert_eq!(seen.len(), usize::from(y >= 32), "{x} {y}");
                for t in seen {
                    assert!(
                        bounds(t, 64, 64)
                            .is_some_and(|b| b[0] <= x && x <= b[1] && b[2] <= y && y <= b[3])
                    );
                }
            }
        }
    }

    #[test]
    fn barycentrics_sum_to_one_and_reproduce_the_pixel() {
        let corner = [at(3, 5, 2.0), at(900, 77, 0.5), at(210, 1333, 7.0)];
        for (x, y) in [(10, 10), (20, 30), (14, 60)] {
            let e = edges(&corner, x, y);
            let b = e.barycentric(e.covers()).unwrap();
            assert!((b.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            let sum = |f: fn(&Projected) -> f32| (0..3).map(|k| b[k] * f(&corner[k])).sum::<f32>();
            let (px, py) = (sum(|v| v.hx) / sum(|v| v.w), sum(|v| v.hy) / sum(|v| v.w));
            assert!((px - (x as f32 + 0.5)).abs() < 1e-4 && (py - (y as f32 + 0.5)).abs() < 1e-4);
        }
        let flat = [at(0, 0, 1.0), at(160, 160, 1.0), at(320, 320, 1.0)];
        assert!((0..20).all(|i| edges(&flat, i, i).covers() == 0));
    }
}
