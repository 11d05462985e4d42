//! Which models, and which meshes of two models, belong together by name.
//!
//! The convention is that of texture bakers: `wheel_low` takes its detail from `wheel_high`, `wheel_high_bolts`, `wheel_hp.001`
//! and `wheel`.

/// What a mesh or a model is for, as its name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It is baked for.
    Low,
    /// Its detail is wanted; in the name of a mesh more may follow the ending.
    High,
    /// Rays run from it.
    Cage,
}

/// The endings of names.
const ENDINGS: [(&str, Role); 5] = [
    ("_low", Role::Low),
    ("_lp", Role::Low),
    ("_high", Role::High),
    ("_hp", Role::High),
    ("_cage", Role::Cage),
];

/// What a name without an extension says that a model is for, and the name without that ending, in small letters; none where
/// it says nothing.
pub fn role(name: &str) -> Option<(String, Role)> {
    let name = name.to_lowercase();
    let cut = |&(ending, role): &(&str, Role)| Some((name.strip_suffix(ending)?.to_owned(), role));
    let found = ENDINGS.iter().find_map(cut);
    found.filter(|(stem, _)| !stem.is_empty())
}

/// The name of a simple mesh or of a cage without its ending, in small letters.
pub(super) fn stem(low: &str) -> String {
    match role(low) {
        Some((stem, Role::Low | Role::Cage)) => stem,
        _ => low.to_lowercase(),
    }
}

/// Whether mesh `high` of the detailed model is meant for mesh `low` of the simple one.
pub(super) fn belongs(high: &str, low: &str) -> bool {
    if high == low {
        return true;
    }
    let (high, stem) = (high.to_lowercase(), stem(low));
    if high == stem {
        return true;
    }
    let rest = |word: &str| {
        high.strip_prefix(stem.as_str())
            .and_then(|rest| rest.strip_prefix(word))
    };
    let ends = |rest: &str| rest.chars().next().is_none_or(|c| !c.is_alphabetic());
    let mut endings = ENDINGS.iter().filter(|(_, role)| *role == Role::High);
    endings.any(|(word, _)| rest(word).is_some_and(ends))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_belong_together_as_bakers_have_it() {
        for (high, low) in [
            ("wheel", "wheel"),
            ("wheel", "wheel_low"),
            ("Wheel_High", "wheel_low"),
            ("wheel_hp.001", "wheel_lp"),
            ("wheel_high_bolts", "wheel_low"),
            ("wheel_high2", "Wheel_LOW"),
            ("_low", "_low"),
        ] {
            assert!(belongs(high, low), "{high} {low}");
        }
        for (high, low) in [
            ("wheels", "wheel"),
            ("wheel2_high", "wheel_low"),
            ("wheel_higher", "wheel_low"),
            ("wheel_low", "wheel"),
            ("tyre_high", "wheel_low"),
            ("", "_low"),
        ] {
            assert!(!belongs(high, low), "{high} {low}");
        }
        assert_eq!(stem("Wheel_cage"), "wheel");
        assert_eq!(stem("Wheel_high"), "wheel_high");
        assert_eq!(role("Wheel_HP"), Some(("wheel".into(), Role::High)));
        assert_eq!((role("wheel"), role("_low")), (None, None));
    }
}
