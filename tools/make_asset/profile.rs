//! The silhouette of the vase: height and radius as functions of the length along the profile.
//!
//! In: control points (height, radius), bottom to top. Out: `at(s)`, s in object units of arc length. Height rises
//! strictly with s, which is what makes the cylinder one-to-one. Cubic Hermite with Fritsch and Carlson's monotone
//! tangents: no overshoot, so no radius below zero and no height that turns back.

const CONTROL: [(f64, f64); 50] = [
    (0.000, 0.000),
    (0.030, 0.255),
    (0.038, 0.300),
    (0.050, 0.317),
    (0.072, 0.322),
    (0.092, 0.312),
    (0.102, 0.290),
    (0.112, 0.272),
    (0.150, 0.218),
    (0.196, 0.172),
    (0.232, 0.152),
    (0.246, 0.154),
    (0.254, 0.172),
    (0.266, 0.178),
    (0.278, 0.172),
    (0.288, 0.164),
    (0.320, 0.190),
    (0.380, 0.255),
    (0.470, 0.350),
    (0.600, 0.457),
    (0.750, 0.540),
    (0.900, 0.587),
    (1.030, 0.600),
    (1.150, 0.578),
    (1.260, 0.522),
    (1.350, 0.440),
    (1.420, 0.355),
    (1.468, 0.285),
    (1.482, 0.272),
    (1.490, 0.276),
    (1.500, 0.280),
    (1.510, 0.274),
    (1.520, 0.252),
    (1.580, 0.218),
    (1.670, 0.200),
    (1.750, 0.206),
    (1.800, 0.228),
    (1.832, 0.266),
    (1.848, 0.292),
    (1.868, 0.302),
    (1.886, 0.296),
    (1.896, 0.278),
    (1.902, 0.262),
    (1.930, 0.250),
    (1.985, 0.205),
    (2.030, 0.135),
    (2.058, 0.072),
    (2.082, 0.046),
    (2.100, 0.044),
    (2.112, 0.052),
];
/// The knob: a bud above a small collar.
const KNOB: [(f64, f64); 7] = [
    (2.122, 0.050),
    (2.132, 0.048),
    (2.158, 0.066),
    (2.190, 0.074),
    (2.226, 0.058),
    (2.262, 0.026),
    (2.292, 0.000),
];
const STEPS: usize = 48;

/// A point of the silhouette.
#[derive(Clone, Copy)]
pub(crate) struct Point {
    pub(crate) height: f64,
    pub(crate) radius: f64,
}

/// The silhouette, sampled finely and looked up by arc length.
pub(crate) struct Profile {
    points: Vec<Point>,
    length: Vec<f64>,
}

/// Monotone tangents for values at the given abscissae.
fn tangents(x: &[f64], y: &[f64]) -> Vec<f64> {
    let slope: Vec<f64> = (1..x.len())
        .map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1]))
        .collect();
    let mut m = vec![slope[0]];
    for pair in slope.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        m.push(if a * b <= 0.0 {
            0.0
        } else {
            2.0 * a * b / (a + b)
        });
    }
    m.push(slope[slope.len() - 1]);
    m
}

fn hermite(y: (f64, f64), m: (f64, f64), width: f64, t: f64) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * y.0
        + (t3 - 2.0 * t2 + t) * width * m.0
        + (3.0 * t2 - 2.0 * t3) * y.1
        + (t3 - t2) * width * m.1
}

impl Profile {
    /// The one vase of this program.
    pub(crate) fn vase() -> Self {
        let control: Vec<(f64, f64)> = CONTROL.iter().chain(&KNOB).copied().collect();
        let (heights, radii): (Vec<f64>, Vec<f64>) = control.iter().copied().unzip();
        let mut chord = vec![0.0];
        for pair in control.windows(2) {
            let (dy, dr) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            chord.push(chord[chord.len() - 1] + (dy * dy + dr * dr).sqrt());
        }
        let (mh, mr) = (tangents(&chord, &heights), tangents(&chord, &radii));
        let mut points = vec![Point {
            height: heights[0],
            radius: radii[0],
        }];
        for i in 1..control.len() {
            let width = chord[i] - chord[i - 1];
            for step in 1..=STEPS {
                let t = step as f64 / STEPS as f64;
                points.push(Point {
                    height: hermite((heights[i - 1], heights[i]), (mh[i - 1], mh[i]), width, t),
                    radius: hermite((radii[i - 1], radii[i]), (mr[i - 1], mr[i]), width, t),
                });
            }
        }
        let mut length = vec![0.0];
        for pair in points.windows(2) {
            let (dy, dr) = (
                pair[1].height - pair[0].height,
                pair[1].radius - pair[0].radius,
            );
            length.push(length[length.len() - 1] + (dy * dy + dr * dr).sqrt());
        }
        Self { points, length }
    }

    /// Length of the whole silhouette.
    pub(crate) fn total(&self) -> f64 {
        self.length[self.length.len() - 1]
    }

    /// The point at arc length `s` (clamped to the ends).
    pub(crate) fn at(&self, s: f64) -> Point {
        let s = s.clamp(0.0, self.total());
        let i = self
            .length
            .partition_point(|&l| l <= s)
            .clamp(1, self.length.len() - 1);
        let (a, b) = (self.points[i - 1], self.points[i]);
        let t = (s - self.length[i - 1]) / (self.length[i] - self.length[i - 1]);
        Point {
            height: a.height + t * (b.height - a.height),
            radius: a.radius + t * (b.radius - a.radius),
        }
    }

    /// Arc length at which the silhouette reaches a height.
    pub(crate) fn s_of_height(&self, height: f64) -> f64 {
        let i = self
            .points
            .partition_point(|p| p.height <= height)
            .clamp(1, self.points.len() - 1);
        let (a, b) = (self.points[i - 1], self.points[i]);
        let t = ((height - a.height) / (b.height - a.height)).clamp(0.0, 1.0);
        self.length[i - 1] + t * (self.length[i] - self.length[i - 1])
    }
}
