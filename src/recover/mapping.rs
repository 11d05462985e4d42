//! Correspondences by name, and what they leave to choose.
//!
//! The names are those of Tarini, Cignoni and Scopigno, *Visibility Based Methods and Assessment for Detail-Recovery*
//! (IEEE Visualization 2003), section 3.

use crate::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// Which point of the reference a point of the simple surface stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mapping {
    /// The one with the same primary parameterization: the inverse geometric texture.
    #[default]
    UvMatch,
    /// The closest one (section 3.1).
    Proximity,
    /// The first along the normal, outwards before inwards (3.2).
    Normal,
    /// The first along the mean direction that the faces round it are seen from (3.3).
    VisibilityFace,
    /// The same, directions gathered at vertices.
    VisibilityVertex,
    /// The same, directions gathered at texels.
    VisibilityTexel,
    /// Between normal and mean direction, gathered at vertices, by how much directions vary (3.4).
    HybridVertex,
    /// The same, gathered at texels.
    HybridTexel,
    /// The first along the normal from a surface that lies further out, inwards: what bakers call a cage.
    Cage,
    /// Of each texel the one whose point is predicted to lie nearest to what is seen of the reference there.
    Auto,
}

/// Names, as `--map` takes them.
const NAMES: [(Mapping, &str); 10] = [
    (Mapping::UvMatch, "uv-match"),
    (Mapping::Proximity, "proximity"),
    (Mapping::Normal, "normal"),
    (Mapping::VisibilityFace, "visibility-face"),
    (Mapping::VisibilityVertex, "visibility-vertex"),
    (Mapping::VisibilityTexel, "visibility-texel"),
    (Mapping::HybridVertex, "hybrid-vertex"),
    (Mapping::HybridTexel, "hybrid-texel"),
    (Mapping::Cage, "cage"),
    (Mapping::Auto, "auto"),
];

impl Mapping {
    /// All that need nothing but two surfaces in one space.
    pub const OF_TWO_SURFACES: [Mapping; 9] = [
        Mapping::Proximity,
        Mapping::Normal,
        Mapping::VisibilityFace,
        Mapping::VisibilityVertex,
        Mapping::VisibilityTexel,
        Mapping::HybridVertex,
        Mapping::HybridTexel,
        Mapping::Cage,
        Mapping::Auto,
    ];

    /// Whether a cage says where some of its rays begin.
    pub fn looks_from_cage(self) -> bool {
        matches!(self, Mapping::Cage | Mapping::Auto)
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        NAMES
            .iter()
            .find(|(mapping, _)| *mapping == self)
            .map_or("", |(_, name)| name)
    }
}

impl fmt::Display for Mapping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Mapping {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let known = NAMES.iter().find(|(_, name)| *name == text.trim());
        known.map(|(mapping, _)| *mapping).ok_or_else(|| {
            let names = NAMES.map(|(_, name)| name).join(", ");
            Error::Option {
                option: "--map",
                reason: format!("\"{text}\" is no mapping; there are: {names}"),
            }
        })
    }
}

/// What a texel gets whose ray met nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Misses {
    /// Nothing: it is transparent.
    Blank,
    /// The closest point (Sander et al. 2000).
    #[default]
    Proximity,
    /// What its neighbours have.
    Fill,
}

/// How points are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovery {
    /// How far a ray goes either way, in diagonals of the reference's box. None: twice as far as the simple surface lies
    /// from the reference anywhere ([`Pair::reach`](super::Pair::reach)).
    pub reach: Option<f32>,
    /// Whether only triangles count that do not look away from the simple surface.
    pub facing: bool,
    /// What stands in for a point that was not found.
    pub misses: Misses,
    /// How visibility is found.
    pub probes: Probes,
}

impl Default for Recovery {
    fn default() -> Self {
        Recovery {
            reach: None,
            facing: true,
            misses: Misses::default(),
            probes: Probes::default(),
        }
    }
}

/// Pictures of the simple surface that say from where it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probes {
    /// How many directions, 1 to 1024 (the paper's 29, after Zhang and Turk 2002).
    pub directions: u32,
    /// Pixels along each side of a picture, 16 to 4096.
    pub size: u32,
    /// Up, where the model is mostly looked at from the side: a direction counts by the squared cosine of its elevation,
    /// as people walk round what stands on the ground (the paper's section 6). None: all directions count alike.
    pub upright: Option<[f32; 3]>,
}

impl Default for Probes {
    fn default() -> Self {
        Probes {
            directions: 29,
            size: 1024,
            upright: None,
        }
    }
}

impl Recovery {
    /// Refuses what is out of range.
    pub(crate) fn check(&self) -> Result<()> {
        let wrong = |option, reason: String| Err(Error::Option { option, reason });
        if let Some(reach) = self.reach
            && !(reach > 0.0 && reach.is_finite())
        {
            return wrong(
                "--reach",
                format!("{reach} is not a positive number of diagonals"),
            );
        }
        if !(1..=1024).contains(&self.probes.directions) {
            let reason = format!("{} is outside 1 to 1024", self.probes.directions);
            return wrong("--probes", reason);
        }
        if !(16..=4096).contains(&self.probes.size) {
            let reason = format!("{} is outside 16 to 4096", self.probes.size);
            return wrong("--probe-size", reason);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back_and_others_are_refused() {
        for (mapping, name) in NAMES {
            assert_eq!(mapping.to_string(), name);
            assert_eq!(name.parse::<Mapping>().unwrap(), mapping);
        }
        let refused = "visibility".parse::<Mapping>().unwrap_err().to_string();
        assert!(refused.contains("visibility-texel"), "{refused}");
    }
}
