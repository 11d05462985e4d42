//! Convex polygons whose corners carry a few numbers that vary linearly over them.

/// Most corners.
const MOST: usize = 12;
/// From so many corners on a polygon is taken apart along a diagonal, so that a cut always has room.
const MANY: usize = 10;

/// A convex polygon: its corners in order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon<const N: usize> {
    corners: [[f64; N]; MOST],
    count: usize,
}

impl<const N: usize> Polygon<N> {
    pub(super) fn new(corners: impl IntoIterator<Item = [f64; N]>) -> Self {
        let mut polygon = Polygon {
            corners: [[0.0; N]; MOST],
            count: 0,
        };
        corners.into_iter().for_each(|c| polygon.push(c));
        polygon
    }

    fn push(&mut self, corner: [f64; N]) {
        // A convex polygon never comes here with all places taken: rounding could make one less than convex, by a hair.
        if self.count < MOST {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    pub(super) fn corners(&self) -> &[[f64; N]] {
        &self.corners[..self.count]
    }

    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The same polygon with other numbers.
    pub(super) fn map<const M: usize>(&self, f: impl FnMut(&[f64; N]) -> [f64; M]) -> Polygon<M> {
        Polygon::new(self.corners().iter().map(f))
    }

    /// The mean of the corners.
    pub(super) fn middle(&self) -> [f64; N] {
        let share = 1.0 / self.count.max(1) as f64;
        std::array::from_fn(|k| self.corners().iter().map(|c| c[k]).sum::<f64>() * share)
    }

    /// What lies where `side`, a linear function, is not negative. Source: Sutherland and Hodgman 1974, Reentrant polygon
    /// clipping.
    pub(super) fn cut(&self, side: impl Fn(&[f64; N]) -> f64) -> Self {
        let mut kept = Polygon::new([]);
        let corners = self.corners();
        let Some(mut before) = corners.last() else {
            return kept;
        };
        let mut from = side(before);
        for corner in corners {
            let here = side(corner);
            if (here < 0.0) != (from < 0.0) {
                let s = from / (from - here);
                kept.push(std::array::from_fn(|k| {
                    before[k] + (corner[k] - before[k]) * s
                }));
            }
            if here >= 0.0 {
                kept.push(*corner);
            }
            (before, from) = (corner, here);
        }
        kept
    }

    /// The parts on both sides of a line; of one with many corners, of a diagonal.
    pub(super) fn halves(&self, side: impl Fn(&[f64; N]) -> f64) -> [Self; 2] {
        if self.count >= MANY {
            let corners = self.corners();
            let middle = self.count / 2;
            let rest = corners[middle..].iter().chain([&corners[0]]);
            return [
                Polygon::new(corners[..=middle].iter().copied()),
                Polygon::new(rest.copied()),
            ];
        }
        [self.cut(|c| -side(c)), self.cut(side)]
    }
}

impl Polygon<2> {
    /// Its area.
    pub(super) fn area(&self) -> f64 {
        let corners = self.corners();
        let Some(first) = corners.first() else {
            return 0.0;
        };
        let cross = |a: &[f64; 2], b: &[f64; 2]| {
            (a[0] - first[0]) * (b[1] - first[1]) - (a[1] - first[1]) * (b[0] - first[0])
        };
        corners
            .windows(2)
            .map(|pair| cross(&pair[0], &pair[1]))
            .sum::<f64>()
            .abs()
            / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_up_the_whole() {
        let mut parts = vec![Polygon::new([
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 3.0],
            [0.0, 3.0],
        ])];
        for k in 0..40 {
            let angle = f64::from(k) * 2.4;
            let side = |c: &[f64; 2]| (c[0] - 2.0) * angle.cos() + (c[1] - 1.5) * angle.sin() - 0.1;
            parts = parts
                .iter()
                .flat_map(|p| p.halves(side))
                .filter(|p| !p.is_empty())
                .collect();
            let area: f64 = parts.iter().map(Polygon::area).sum();
            assert!((area - 12.0).abs() < 1e-9, "{k}: {area}");
        }
        assert!(parts.len() > 100);
    }
}
