//! Tracks at a moment: what lies between keyframes.
//!
//! In: a [`Track`] and a time in seconds. Out: its numbers there, in double precision. Before the first keyframe the first
//! one holds, after the last one the last (glTF 2.0, 3.11 and appendix C).

use super::animation::{Interpolation, Track};
use glam::DQuat;

/// Where a time lies: between keyframes `low` and `high`, `seconds` apart, after `fraction` of the way (0 up to, not
/// including, 1).
struct Between {
    low: usize,
    high: usize,
    fraction: f64,
    seconds: f64,
}

impl Track {
    /// Time of the last keyframe, in seconds; 0 without any.
    pub fn end(&self) -> f64 {
        self.times.last().map_or(0.0, |&t| f64::from(t))
    }

    /// Numbers at each keyframe: of the value alone, without its tangents.
    pub fn width(&self) -> usize {
        let groups = match self.interpolation {
            Interpolation::Cubic => 3,
            Interpolation::Linear | Interpolation::Step => 1,
        };
        self.values.len() / (groups * self.times.len()).max(1)
    }

    /// The numbers at `time`, each by itself: [`Track::width`] of them. A rotation's are a quaternion between keyframes of
    /// which no unit length is promised; [`Track::rotation`] goes along the arc.
    pub fn sample(&self, time: f64) -> Vec<f64> {
        (0..self.width()).map(|k| self.number(time, k)).collect()
    }

    /// A quaternion x, y, z, w of unit length at `time`: along the shorter arc at constant speed, or the spline's value,
    /// normalized. None where there is nothing to normalize.
    pub fn rotation(&self, time: f64) -> Option<DQuat> {
        let unit = |q: DQuat| (q.length_squared() > 1e-12).then(|| q.normalize());
        if self.interpolation == Interpolation::Linear {
            let at = self.between(time);
            let key = |i: usize| unit(DQuat::from_array([0, 1, 2, 3].map(|k| self.key(i, k))));
            return Some(slerp(key(at.low)?, key(at.high)?, at.fraction));
        }
        unit(DQuat::from_array(
            [0, 1, 2, 3].map(|k| self.number(time, k)),
        ))
    }

    fn between(&self, time: f64) -> Between {
        let after = self.times.partition_point(|&t| f64::from(t) <= time);
        if after == 0 || after == self.times.len() {
            let held = after.saturating_sub(1);
            return Between {
                low: held,
                high: held,
                fraction: 0.0,
                seconds: 0.0,
            };
        }
        // Of keyframes at one time the last one counts, so there are seconds between these two.
        let [from, to] = [after - 1, after].map(|i| f64::from(self.times[i]));
        Between {
            low: after - 1,
            high: after,
            fraction: (time - from) / (to - from),
            seconds: to - from,
        }
    }

    /// Number `k` of keyframe `i`'s value.
    fn key(&self, i: usize, k: usize) -> f64 {
        match self.interpolation {
            Interpolation::Cubic => self.group(i, 1, k),
            Interpolation::Linear | Interpolation::Step => {
                f64::from(self.values[i * self.width() + k])
            }
        }
    }

    /// Number `k` of keyframe `i`'s in-tangent (0), value (1) or out-tangent (2).
    fn group(&self, i: usize, part: usize, k: usize) -> f64 {
        f64::from(self.values[(i * 3 + part) * self.width() + k])
    }

    fn number(&self, time: f64, k: usize) -> f64 {
        let at = self.between(time);
        let (from, t) = (self.key(at.low, k), at.fraction);
        match self.interpolation {
            Interpolation::Step => from,
            Interpolation::Linear => from + (self.key(at.high, k) - from) * t,
            Interpolation::Cubic => {
                let to = self.key(at.high, k);
                let leaving = self.group(at.low, 2, k) * at.seconds;
                let arriving = self.group(at.high, 0, k) * at.seconds;
                hermite(from, leaving, to, arriving, t)
            }
        }
    }
}

/// The cubic from `from` to `to` whose derivatives by t at 0 and 1 are `leaving` and `arriving`.
fn hermite(from: f64, leaving: f64, to: f64, arriving: f64, t: f64) -> f64 {
    let (t2, t3) = (t * t, t * t * t);
    from * (2.0 * t3 - 3.0 * t2 + 1.0)
        + leaving * (t3 - 2.0 * t2 + t)
        + to * (3.0 * t2 - 2.0 * t3)
        + arriving * (t3 - t2)
}

/// From `a` to `b`, both of unit length, along the shorter arc at constant speed (Shoemake 1985). The angle comes from
/// chords, so nothing is lost where it is small, and there is no case of its own but for equal ends.
fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    let angle = 2.0 * (a - b).length().atan2((a + b).length());
    let sine = angle.sin();
    if sine <= 0.0 {
        return a;
    }
    (a * (((1.0 - t) * angle).sin() / sine) + b * ((t * angle).sin() / sine)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn track(times: &[f32], values: &[f32], interpolation: Interpolation) -> Track {
        Track {
            times: times.into(),
            values: values.into(),
            interpolation,
        }
    }

    /// About one axis, half the angle of the quaternion's cosine: slerp turns by the share of the angle.
    #[test]
    fn slerp_is_a_turn_by_a_share_of_the_angle() {
        let axis = DVec3::new(2.0, -1.0, 0.5).normalize();
        let start = DQuat::from_axis_angle(DVec3::new(0.3, 0.9, -0.2).normalize(), 0.8);
        for angle in [1e-9, 1e-3, 0.03, 1.0, 2.5, 3.1] {
            for t in [0.0, 0.1, 0.5, 0.77, 1.0] {
                let turned = |by: f64| DQuat::from_axis_angle(axis, by) * start;
                let got = slerp(turned(0.0), turned(angle), t);
                assert!((got - turned(angle * t)).length() < 1e-14, "{angle} {t}");
                // The same rotation by its other quaternion: the shorter arc all the same.
                let other = slerp(turned(0.0), -turned(angle), t);
                assert!((other - got).length() < 1e-14, "{angle} {t}");
            }
        }
        // Negative control: interpolating the numbers is another motion.
        let (a, b) = (start, DQuat::from_axis_angle(axis, 2.5) * start);
        let straight = (a * 0.77 + b * 0.23).normalize();
        assert!((straight - slerp(a, b, 0.23)).length() > 1e-3);
    }

    #[test]
    fn a_spline_meets_its_keys_with_their_tangents() {
        // Two numbers, three keyframes: in-tangent, value, out-tangent.
        let values = [
            9.0, 9.0, 1.0, -2.0, 3.0, 0.5, //
            -1.0, 2.0, 4.0, 0.0, 0.25, -6.0, //
            8.0, 1.0, -3.0, 5.0, 9.0, 9.0,
        ];
        let times = [0.5, 0.75, 2.75];
        let t = track(&times, &values, Interpolation::Cubic);
        assert_eq!(t.width(), 2);
        let value = |i: usize, part: usize, k: usize| f64::from(values[(i * 3 + part) * 2 + k]);
        for (i, &time) in times.iter().enumerate() {
            let (time, step) = (f64::from(time), 1e-6);
            let here = t.sample(time);
            for (k, &here) in here.iter().enumerate() {
                assert_eq!(here, value(i, 1, k));
                let slope =
                    |from: f64, to: f64| (t.sample(to)[k] - t.sample(from)[k]) / (to - from);
                if i > 0 {
                    assert!((slope(time - step, time) - value(i, 0, k)).abs() < 1e-3);
                }
                if i < 2 {
                    assert!((slope(time, time + step) - value(i, 2, k)).abs() < 1e-3);
                }
            }
        }
        // A cubic is known by four values: between keys it is one. Its fourth differences vanish.
        let p = |i: i32| t.sample(1.0 + 0.25 * f64::from(i))[0];
        let fourth = p(0) - 4.0 * p(1) + 6.0 * p(2) - 4.0 * p(3) + p(4);
        assert!(fourth.abs() < 1e-12, "{fourth}");
        let third = p(0) - 3.0 * p(1) + 3.0 * p(2) - p(3);
        assert!(third.abs() > 1e-3, "negative control: it is no parabola");
    }

    #[test]
    fn steps_hold_lines_are_straight_and_ends_are_held() {
        let (times, values) = ([1.0, 2.0, 2.0, 4.0], [5.0, 7.0, 11.0, 3.0]);
        let step = track(&times, &values, Interpolation::Step);
        let line = track(&times, &values, Interpolation::Linear);
        let just_before = 2.0 - 1e-9;
        for (time, stepped, straight) in [
            (0.0, 5.0, 5.0),
            (1.0, 5.0, 5.0),
            (1.5, 5.0, 6.0),
            (just_before, 5.0, 7.0),
            (2.0, 11.0, 11.0),
            (3.0, 11.0, 7.0),
            (4.0, 3.0, 3.0),
            (1e9, 3.0, 3.0),
        ] {
            assert_eq!(step.sample(time), [stepped], "{time}");
            assert!((line.sample(time)[0] - straight).abs() < 1e-8, "{time}");
        }
        assert_eq!((line.end(), line.width()), (4.0, 1));
    }

    #[test]
    fn rotations_have_unit_length_or_are_none() {
        let turn = (std::f64::consts::FRAC_1_SQRT_2 * 2.0) as f32;
        let keys = [0.0, 0.0, 0.0, 2.0, 0.0, turn, 0.0, turn];
        let line = track(&[0.0, 1.0], &keys, Interpolation::Linear);
        let half = line.rotation(0.5).unwrap();
        let wanted = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_4);
        assert!((half - wanted).length() < 1e-7, "{half}");
        let none = track(&[0.0, 1.0], &[0.0; 8], Interpolation::Linear);
        assert!(none.rotation(0.5).is_none());
        // A spline from a quaternion to its negative passes through nothing.
        let mut cubic = vec![0.0; 24];
        (cubic[7], cubic[19]) = (1.0, -1.0);
        let through = track(&[0.0, 1.0], &cubic, Interpolation::Cubic);
        assert!(through.rotation(0.5).is_none() && through.rotation(0.25).is_some());
    }
}
