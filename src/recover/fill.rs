//! What texels without a value get: that of their neighbours, so that filtering finds no border.

use rayon::prelude::*;

/// Texels with a value spread into those without, one texel a round for `rounds` rounds; the first neighbour counts, left,
/// right, above, below.
pub(super) fn spread<T: Copy + Send + Sync>(
    mut known: Vec<Option<T>>,
    size: u32,
    rounds: u32,
) -> Vec<Option<T>> {
    let size = size as usize;
    for _ in 0..rounds {
        let grown = (0..known.len()).into_par_iter().map(|at| {
            let (x, y) = (at % size, at / size);
            let near = [
                (x > 0).then(|| at - 1),
                (x + 1 < size).then_some(at + 1),
                (y > 0).then(|| at - size),
                (y + 1 < size).then_some(at + size),
            ];
            known[at].or_else(|| near.into_iter().flatten().find_map(|n| known[n]))
        });
        known = grown.collect();
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_reaches_as_many_texels_as_there_are_rounds() {
        let mut known = vec![None; 7 * 7];
        known[3 * 7 + 3] = Some(5);
        for rounds in 0..4u32 {
            let filled = spread(known.clone(), 7, rounds);
            for (at, texel) in filled.iter().enumerate() {
                let away = (at % 7).abs_diff(3) + (at / 7).abs_diff(3);
                assert_eq!(texel.is_some(), away <= rounds as usize);
            }
        }
    }
}
