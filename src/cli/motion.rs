//! What moves from picture to picture: `--animation`, `--time`, `--frames`, `--fps`, `--turntable`, `--distance`.
//!
//! In: the options. Out: one [`Frame`] for each picture: a moment of the animation, a turn of the camera, how far away it is.

use std::str::FromStr;

use invertex::Result;
use invertex::scene::{Pose, Scene};

use super::bad_option;

/// Most pictures of a sequence.
const MOST: u32 = 100_000;
/// Pictures of a range of distances where nothing says how many.
const FRAMES: u32 = 60;
/// Pictures a second where nothing says how many.
const FPS: f64 = 30.0;

/// Options of moving pictures.
#[derive(clap::Args)]
pub(super) struct Motion {
    /// Pose the model by this animation: its name, or its index.
    #[arg(long, value_name = "NAME", help_heading = "Motion")]
    animation: Option<String>,
    /// Seconds into the animation (default 0), or A..B for a sequence from A to B. After its last keyframe an animation
    /// begins again. Without one: seconds of an attribute that varies with time.
    #[arg(
        long,
        value_name = "T|A..B",
        help_heading = "Motion",
        allow_hyphen_values = true
    )]
    time: Option<Time>,
    /// A sequence of N pictures, frame_0000.png and so on in the folder OUT: 1/F of a second apart from T on, or evenly
    /// from A to B.
    #[arg(long, value_name = "N", conflicts_with = "camera", help_heading = "Motion",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST)))]
    frames: Option<u32>,
    /// Pictures a second of a sequence. Default: 30.
    #[arg(
        long,
        value_name = "F",
        help_heading = "Motion",
        allow_hyphen_values = true
    )]
    fps: Option<Rate>,
    /// N pictures once round the model, from --view on, in the folder OUT; with --animation and --fps or A..B it moves
    /// while it turns.
    #[arg(long, value_name = "N", conflicts_with_all = ["camera", "frames"], help_heading = "Motion",
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST)))]
    turntable: Option<u32>,
    /// How far away the camera is, 1 (default) where it sees the model whole; or A..B for a sequence from A to B, each
    /// picture by the same factor farther than the one before it.
    #[arg(
        long,
        value_name = "D|A..B",
        conflicts_with = "camera",
        help_heading = "Motion",
        allow_hyphen_values = true
    )]
    distance: Option<Distance>,
    /// Where --lod pixels:X switches levels from picture to picture, blend the two over N pictures.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        hide_default_value = true,
        help_heading = "Motion"
    )]
    pub(super) blend: u32,
}

/// What `--distance` says: the first picture's and the last one's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Distance(pub(super) f64, pub(super) f64);

impl FromStr for Distance {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let number = |text: &str| {
            let number = text.trim().parse::<f64>().ok();
            number.filter(|d| d.is_finite() && *d > 0.0)
        };
        let (from, to) = text.split_once("..").unwrap_or((text, text));
        match (number(from), number(to)) {
            (Some(from), Some(to)) => Ok(Distance(from, to)),
            _ => Err(format!(
                "\"{text}\" is not a distance above 0 nor a range such as 1..20"
            )),
        }
    }
}

/// What `--time` says.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Time {
    /// One moment, or the first of a sequence.
    From(f64),
    /// A sequence.
    Range(f64, f64),
}

impl FromStr for Time {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let seconds = |text: &str| {
            let seconds = text.trim().parse::<f64>().ok();
            seconds.filter(|t| t.is_finite() && *t >= 0.0)
        };
        let time = match text.split_once("..") {
            None => seconds(text).map(Time::From),
            Some((from, to)) => match (seconds(from), seconds(to)) {
                (Some(from), Some(to)) if from <= to => Some(Time::Range(from, to)),
                _ => None,
            },
        };
        time.ok_or_else(|| {
            format!("\"{text}\" is not a time in seconds (0 or later) nor a range such as 0.5..2")
        })
    }
}

/// Pictures a second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rate(f64);

impl FromStr for Rate {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let rate = text.parse::<f64>().ok();
        rate.filter(|f| f.is_finite() && *f > 0.0)
            .map(Rate)
            .ok_or_else(|| format!("\"{text}\" is not a number of pictures a second"))
    }
}

/// One picture of a sequence, or the only one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    /// Degrees that the camera has gone round.
    pub(super) turn: f64,
    /// Seconds as they were asked for; none where nothing varies with time.
    pub(super) time: Option<f64>,
    /// How far away the camera is; 1 sees the model whole.
    pub(super) distance: f64,
}

impl Motion {
    /// Whether pictures are numbered, in a folder.
    pub(super) fn is_sequence(&self) -> bool {
        let range = matches!(self.time, Some(Time::Range(..)));
        self.turntable.is_some() || self.frames.is_some() || range || self.moves_away()
    }

    fn moves_away(&self) -> bool {
        self.distance.is_some_and(|Distance(from, to)| from != to)
    }

    /// Whether `--blend` means something: where levels switch and pictures are `coloured`.
    ///
    /// # Errors
    /// [`invertex::Error::Option`] where it does not.
    pub(super) fn check_blend(&self, switches: bool, coloured: bool) -> Result<()> {
        let reason = match self.blend {
            0 => return Ok(()),
            _ if !switches || !self.is_sequence() => {
                "blends levels in a sequence that switches them; give --lod pixels:0.5 and --distance 1..20"
            }
            _ if !coloured => "blends colours, not numbers",
            _ => return Ok(()),
        };
        Err(bad_option("--blend", reason))
    }

    /// The frames, in order. `varies`: whether pictures vary with time though nothing be animated.
    ///
    /// # Errors
    /// [`invertex::Error::Option`] where the options contradict each other or mean nothing.
    pub(super) fn frames(&self, varies: bool) -> Result<Vec<Frame>> {
        let timed = varies || self.animation.is_some();
        let given = [
            (self.time.is_some(), "--time"),
            (self.frames.is_some() && !self.moves_away(), "--frames"),
            (self.fps.is_some(), "--fps"),
        ];
        if let Some((_, option)) = given.iter().find(|(given, _)| *given && !timed) {
            let reason = "needs something that varies with time: --animation, or --attribute wood, procedural and others";
            return Err(bad_option(option, reason));
        }
        if self.fps.is_some() && !self.is_sequence() {
            let reason =
                "means something for a sequence only: give --frames, --turntable or --time A..B";
            return Err(bad_option("--fps", reason));
        }
        let count = self.turntable.or(self.frames);
        let (from, step, count) = match (self.time.unwrap_or(Time::From(0.0)), self.fps) {
            (Time::From(from), None) if self.turntable.is_some() => (from, 0.0, count),
            (Time::From(from), fps) => (from, 1.0 / fps.map_or(FPS, |f| f.0), count),
            (Time::Range(..), Some(_)) if count.is_some() => {
                let reason = "the range and the number of pictures say it already";
                return Err(bad_option("--fps", reason));
            }
            (Time::Range(from, to), fps) => match count {
                Some(n) => (from, (to - from) / f64::from(n.max(2) - 1), count),
                None => {
                    let fps = fps.map_or(FPS, |f| f.0);
                    (from, 1.0 / fps, Some(pictures((to - from) * fps)?))
                }
            },
        };
        let count = count.unwrap_or(if self.moves_away() { FRAMES } else { 1 });
        let Distance(near, far) = self.distance.unwrap_or(Distance(1.0, 1.0));
        let apart = (far / near).ln() / f64::from(count.max(2) - 1);
        let turn = match self.turntable {
            Some(n) => 360.0 / f64::from(n),
            None => 0.0,
        };
        let frame = |k: f64| Frame {
            turn: k * turn,
            time: timed.then_some(from + k * step),
            distance: near * (k * apart).exp(),
        };
        Ok((0..count).map(|k| frame(f64::from(k))).collect())
    }

    /// The animation that is asked for, as an index.
    ///
    /// # Errors
    /// [`invertex::Error::Input`] listing the animations there are.
    pub(super) fn animation(&self, scene: &Scene) -> Result<Option<usize>> {
        let wanted = self.animation.as_deref();
        wanted.map(|name| scene.animation_named(name)).transpose()
    }
}

/// Pictures of a range that is `steps` pictures long, both ends included where they fall on one.
fn pictures(steps: f64) -> Result<u32> {
    // Three tenths of a second at ten a second are 2.9999999999999996 steps.
    let count = (steps + 1e-9).floor() + 1.0;
    if count > f64::from(MOST) {
        let reason = format!("{count} pictures; up to {MOST} are drawn");
        return Err(bad_option("--time", reason));
    }
    Ok(count as u32)
}

/// The moment that is shown at `time` of animation `animation`: the same time, or what is left of it after whole rounds.
pub(super) fn shown(scene: &Scene, animation: Option<usize>, time: Option<f64>) -> Option<f64> {
    Some(scene.animations[animation?].looped(time?))
}

/// The scene at a moment that [`shown`] gave.
pub(super) fn pose(scene: &Scene, animation: Option<usize>, time: Option<f64>) -> Result<Pose> {
    match (animation, time) {
        (Some(animation), Some(time)) => scene.pose(animation, time),
        _ => Ok(scene.rest()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(time: Option<&str>, frames: Option<u32>, fps: Option<f64>) -> Motion {
        Motion {
            animation: Some("walk".into()),
            time: time.map(|t| t.parse().unwrap()),
            frames,
            fps: fps.map(Rate),
            turntable: None,
            distance: None,
            blend: 0,
        }
    }

    fn times(motion: &Motion) -> Vec<f64> {
        let frames = motion.frames(false).unwrap();
        frames.iter().filter_map(|f| f.time).collect()
    }

    #[test]
    fn times_are_read() {
        assert_eq!("0.5".parse(), Ok(Time::From(0.5)));
        assert_eq!("0..1.5".parse(), Ok(Time::Range(0.0, 1.5)));
        for bad in [
            "", "nan", "-1", "inf", "x", "1..", "..1", "2..1", "0..nan", "0...1.5x",
        ] {
            assert!(bad.parse::<Time>().is_err(), "{bad}");
        }
        for bad in ["", "0", "-2", "nan", "inf"] {
            assert!(bad.parse::<Rate>().is_err(), "{bad}");
        }
    }

    #[test]
    fn sequences_have_the_moments_they_say() {
        assert_eq!(times(&motion(None, None, None)), [0.0]);
        assert_eq!(times(&motion(Some("2.5"), None, None)), [2.5]);
        assert_eq!(
            times(&motion(Some("1"), Some(3), Some(4.0))),
            [1.0, 1.25, 1.5]
        );
        assert_eq!(times(&motion(Some("1..2"), Some(3), None)), [1.0, 1.5, 2.0]);
        assert_eq!(times(&motion(Some("1..2"), Some(1), None)), [1.0]);
        assert_eq!(times(&motion(Some("0..0.3"), None, Some(10.0))).len(), 4);
        assert_eq!(times(&motion(Some("0..1"), None, None)).len(), 31);
        let contradicting = motion(Some("0..1"), Some(3), Some(5.0));
        assert_eq!(contradicting.frames(false).unwrap_err().exit_code(), 2);
        assert!(motion(None, None, Some(5.0)).frames(false).is_err());
        assert!(motion(Some("0..1e9"), None, None).frames(false).is_err());
    }

    #[test]
    fn distances_are_read_and_grow_by_one_factor() {
        assert_eq!("2".parse(), Ok(Distance(2.0, 2.0)));
        for bad in ["", "0", "-1", "nan", "1..", "..2", "1..inf", "x"] {
            assert!(bad.parse::<Distance>().is_err(), "{bad}");
        }
        let mut away = motion(None, Some(5), None);
        away.animation = None;
        away.distance = Some(Distance(1.0, 16.0));
        let frames = away.frames(false).unwrap();
        for (frame, wanted) in frames.iter().zip([1.0, 2.0, 4.0, 8.0, 16.0]) {
            assert!((frame.distance - wanted).abs() < 1e-9 && frame.time.is_none());
        }
        away.frames = None;
        assert_eq!(away.frames(false).unwrap().len(), FRAMES as usize);
    }

    #[test]
    fn a_turntable_goes_once_round_and_moves_if_told() {
        let still = Motion {
            turntable: Some(4),
            ..motion(Some("0.5"), None, None)
        };
        let frames = still.frames(false).unwrap();
        let turns: Vec<f64> = frames.iter().map(|f| f.turn).collect();
        assert_eq!(turns, [0.0, 90.0, 180.0, 270.0]);
        assert_eq!(times(&still), [0.5; 4]);
        let moving = Motion {
            turntable: Some(2),
            ..motion(None, None, Some(2.0))
        };
        assert_eq!(times(&moving), [0.0, 0.5]);
        let lifeless = Motion {
            animation: None,
            ..still
        };
        assert!(
            lifeless.frames(false).is_err(),
            "no time without anything that varies"
        );
        let frames = lifeless.frames(true).unwrap();
        assert!(frames.iter().all(|f| f.time == Some(0.5)));
    }
}
