//! Rectangles and strips of the plane: what ways from points to their feet pass.

use glam::DVec2;

/// Shares are taken wider by this: rounding must not leave anything out.
const ROUNDING: f64 = 1e-12;

/// Least and largest coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    pub(super) low: DVec2,
    pub(super) high: DVec2,
}

/// What the ways from a part's points to their feet pass: a rectangle, and a strip along the ways.
pub(super) struct Passed {
    within: Rectangle,
    across: DVec2,
    strip: [f64; 2],
}

impl Rectangle {
    pub(super) fn around(points: impl IntoIterator<Item = DVec2>) -> Rectangle {
        let start = Rectangle {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
        };
        points.into_iter().fold(start, |all, p| Rectangle {
            low: all.low.min(p),
            high: all.high.max(p),
        })
    }

    pub(super) fn meets(&self, other: &Rectangle) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

impl Passed {
    pub(super) fn new(images: &[DVec2], feet: &[DVec2]) -> Passed {
        let way: DVec2 = feet.iter().zip(images).map(|(f, i)| f - i).sum();
        let all = || images.iter().chain(feet).copied();
        let across = way.perp().normalize_or_zero();
        let least = all().map(|p| across.dot(p)).fold(f64::INFINITY, f64::min);
        let most = all()
            .map(|p| across.dot(p))
            .fold(f64::NEG_INFINITY, f64::max);
        Passed {
            within: Rectangle::around(all()),
            across,
            strip: [least, most],
        }
    }

    pub(super) fn meets(&self, corners: [DVec2; 3]) -> bool {
        let side = corners.map(|p| self.across.dot(p));
        let beside =
            side.iter().all(|s| *s > self.strip[1]) || side.iter().all(|s| *s < self.strip[0]);
        !beside && Rectangle::around(corners).meets(&self.within)
    }

    /// The share of a segment that lies within, if any does. Source: Liang and Barsky 1984.
    pub(super) fn part_of(&self, [a, b]: [DVec2; 2]) -> Option<[f64; 2]> {
        let (low, high) = (self.within.low, self.within.high);
        let slabs = [
            (a.x, b.x, [low.x, high.x]),
            (a.y, b.y, [low.y, high.y]),
            (self.across.dot(a), self.across.dot(b), self.strip),
        ];
        let (mut from, mut to) = (0f64, 1f64);
        for (a, b, slab) in slabs {
            let (along, ends) = (b - a, slab.map(|e| e - a));
            if along == 0.0 {
                if ends[0] > 0.0 || ends[1] < 0.0 {
                    return None;
                }
                continue;
            }
            let s = ends.map(|e| e / along);
            from = from.max(s[0].min(s[1]));
            to = to.min(s[0].max(s[1]));
        }
        let (from, to) = ((from - ROUNDING).max(0.0), (to + ROUNDING).min(1.0));
        (from <= to).then_some([from, to])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ways from a small square to another one: a line across them is passed where they cross it, and no farther along.
    #[test]
    fn what_ways_pass_is_no_wider_than_they_are() {
        let square = |x: f64, y: f64| {
            [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)].map(|(u, v)| DVec2::new(x + u, y + v))
        };
        let passed = Passed::new(&square(0.0, 0.0), &square(2.0, 2.0));
        let line = [DVec2::new(-3.0, 1.0), DVec2::new(5.0, 1.0)];
        let [from, to] = passed.part_of(line).unwrap();
        let ends = [from, to].map(|s| -3.0 + 8.0 * s);
        assert!(
            ends[0] > 0.8 && ends[0] <= 0.9 && ends[1] < 1.2 && ends[1] >= 1.1,
            "{ends:?}"
        );
        assert!(
            passed
                .part_of([DVec2::new(0.0, 1.5), DVec2::new(0.5, 2.0)])
                .is_none()
        );
        assert!(passed.meets([
            DVec2::new(1.0, 1.1),
            DVec2::new(1.3, 0.9),
            DVec2::new(0.9, 0.9)
        ]));
        assert!(!passed.meets([
            DVec2::new(0.0, 1.5),
            DVec2::new(0.5, 2.0),
            DVec2::new(0.0, 2.0)
        ]));
    }
}
