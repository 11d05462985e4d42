//! Which meshes of two models belong together by name.
//!
//! The convention is that of texture bakers: `wheel_low` takes its detail from `wheel_high`, `wheel_high_bolts`, `wheel_hp.001`
//! and `wheel`.

/// Endings of the simple mesh's name, and of a cage's.
const LOW: [&str; 3] = ["_low", "_lp", "_cage"];
/// What the detailed mesh's name has after what they share; more may follow.
const HIGH: [&str; 2] = ["_high", "_hp"];

/// The name of a simple mesh or of a cage without its ending, in small letters.
pub(super) fn stem(low: &str) -> String {
    let name = low.to_lowercase();
    let cut = LOW.iter().find_map(|ending| name.strip_suffix(ending));
    cut.filter(|stem| !stem.is_empty())
        .unwrap_or(&name)
        .to_owned()
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
    HIGH.iter().any(|word| rest(word).is_some_and(ends))
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
    }
}
