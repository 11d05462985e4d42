//! Statistics of repeated timings.
//!
//! In: nanoseconds of each repetition. Out: minimum, median, 95th and 99th percentile, mean, all in nanoseconds.

use serde::Serialize;

/// What a set of timings says. Percentiles are nearest-rank: a value that was measured, never one between two.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeStatistics {
    /// How many repetitions.
    pub runs: usize,
    /// The fastest, nanoseconds.
    pub min_ns: u64,
    /// Half of the runs took at most this, nanoseconds.
    pub median_ns: u64,
    /// 95 % of the runs took at most this, nanoseconds.
    pub p95_ns: u64,
    /// 99 % of the runs took at most this, nanoseconds.
    pub p99_ns: u64,
    /// The mean, nanoseconds.
    pub mean_ns: f64,
}

impl TimeStatistics {
    /// Statistics of `nanoseconds` in any order; `None` when there are none.
    pub fn of(nanoseconds: &[u64]) -> Option<Self> {
        let mut sorted = nanoseconds.to_vec();
        sorted.sort_unstable();
        let (&min_ns, runs) = (sorted.first()?, sorted.len());
        // Nearest rank: the smallest measured value that at least `percent` of the runs do not exceed.
        let rank = |percent: usize| sorted[(runs * percent).div_ceil(100).max(1) - 1];
        let mean_ns = sorted.iter().map(|&t| t as f64).sum::<f64>() / runs as f64;
        Some(Self {
            runs,
            min_ns,
            median_ns: rank(50),
            p95_ns: rank(95),
            p99_ns: rank(99),
            mean_ns,
        })
    }
}

/// What the timings of one pass say.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassStatistics {
    /// Its name.
    pub name: String,
    /// Half of the frames took at most this, nanoseconds.
    pub median_ns: u64,
    /// 95 % of the frames, nanoseconds.
    pub p95_ns: u64,
    /// 99 % of the frames, nanoseconds.
    pub p99_ns: u64,
}

/// Statistics of every pass, in the order in which names first come; each frame is its passes' names and nanoseconds.
pub fn pass_statistics<'a>(
    frames: impl Iterator<Item = &'a [(String, u64)]>,
) -> Vec<PassStatistics> {
    let mut of: Vec<(&str, Vec<u64>)> = Vec::new();
    for (name, nanoseconds) in frames.flatten() {
        match of.iter_mut().find(|(known, _)| known == name) {
            Some((_, times)) => times.push(*nanoseconds),
            None => of.push((name, vec![*nanoseconds])),
        }
    }
    let statistics = |(name, times): (&str, Vec<u64>)| {
        let s = TimeStatistics::of(&times)?;
        Some(PassStatistics {
            name: name.to_owned(),
            median_ns: s.median_ns,
            p95_ns: s.p95_ns,
            p99_ns: s.p99_ns,
        })
    };
    of.into_iter().filter_map(statistics).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_one_to_a_hundred_are_themselves() {
        let times: Vec<u64> = (1..=100).rev().collect();
        let s = TimeStatistics::of(&times).unwrap();
        assert_eq!(
            (s.runs, s.min_ns, s.median_ns, s.p95_ns, s.p99_ns),
            (100, 1, 50, 95, 99)
        );
        assert_eq!(s.mean_ns, 50.5);
    }

    #[test]
    fn none_one_and_an_odd_count() {
        assert_eq!(TimeStatistics::of(&[]), None);
        let one = TimeStatistics::of(&[7]).unwrap();
        assert_eq!((one.min_ns, one.median_ns, one.p99_ns), (7, 7, 7));
        assert_eq!(TimeStatistics::of(&[9, 1, 5]).unwrap().median_ns, 5);
    }

    #[test]
    fn passes_keep_their_order_and_their_own_times() {
        let frame = |a, b| vec![("first".to_owned(), a), ("second".to_owned(), b)];
        let frames = [frame(1, 10), frame(3, 30), frame(2, 20)];
        let passes = pass_statistics(frames.iter().map(Vec::as_slice));
        let medians: Vec<_> = passes.iter().map(|p| (&*p.name, p.median_ns)).collect();
        assert_eq!(medians, [("first", 2), ("second", 20)]);
        assert_eq!(pass_statistics(std::iter::empty()), []);
    }
}
