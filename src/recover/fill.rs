//! What texels without a value get: that of their neighbours, so that filtering finds no border.

use rayon::prelude::*;

/// A texel without a value, and the neighbour whose value it takes; that one may have taken it before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Grown {
    pub(super) at: u32,
    pub(super) from: u32,
}

/// Texels with a value spread into those without, one texel a round for `rounds` rounds; the first neighbour counts, left,
/// right, above, below.
pub(super) fn spread<T: Copy>(mut known: Vec<Option<T>>, size: u32, rounds: u32) -> Vec<Option<T>> {
    let there = known.iter().map(Option::is_some).collect();
    for Grown { at, from } in growth(there, size, rounds, &|_| false) {
        known[at as usize] = known[from as usize];
    }
    known
}

/// Likewise, but into no texel that is `closed`: who takes whose value, in the order in which it is done.
pub(super) fn growth(
    mut known: Vec<bool>,
    size: u32,
    rounds: u32,
    closed: &(dyn Fn(usize) -> bool + Sync),
) -> Vec<Grown> {
    let size = size as usize;
    // The first round looks at all texels, later ones at the neighbours of those that the round before has filled.
    let (mut open, mut all): (Vec<usize>, Vec<Grown>) = (Vec::new(), Vec::new());
    for round in 0..rounds {
        if round == 0 {
            let rows = (0..known.len() / size).into_par_iter();
            open = rows
                .flat_map_iter(|y| rim(&known, size, y))
                .filter(|&at| !closed(at))
                .collect();
        }
        let first = all.len();
        all.extend(open.iter().filter_map(|&at| {
            let from = near(at, size, known.len()).find(|&n| known[n])?;
            let [at, from] = [at, from].map(|x| x as u32);
            Some(Grown { at, from })
        }));
        all[first..]
            .iter()
            .for_each(|g| known[g.at as usize] = true);
        let mut next: Vec<usize> = open
            .iter()
            .flat_map(|&at| near(at, size, known.len()))
            .filter(|&n| !known[n] && !closed(n))
            .collect();
        next.sort_unstable();
        next.dedup();
        open = next;
    }
    all
}

/// The texels of row `y` without a value that lie beside one with a value.
fn rim(known: &[bool], size: usize, y: usize) -> impl Iterator<Item = usize> {
    let row = |y: usize| known.get(y * size..(y + 1) * size);
    let (own, above, below) = (
        &known[y * size..(y + 1) * size],
        y.checked_sub(1).and_then(row),
        row(y + 1),
    );
    let there = move |other: Option<&[bool]>, x: usize| other.is_some_and(|row| row[x]);
    let beside = move |x: usize| {
        (x > 0 && own[x - 1]) || (x + 1 < size && own[x + 1]) || there(above, x) || there(below, x)
    };
    (0..size)
        .filter(move |&x| !own[x] && beside(x))
        .map(move |x| y * size + x)
}

/// The texels left, right, above and below, as far as there are any.
fn near(at: usize, size: usize, count: usize) -> impl Iterator<Item = usize> {
    let (x, left) = (at % size, at.wrapping_sub(1));
    [
        (x > 0).then_some(left),
        (x + 1 < size).then_some(at + 1),
        (at >= size).then(|| at - size),
        (at + size < count).then_some(at + size),
    ]
    .into_iter()
    .flatten()
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

    /// By definition: each round looks at every texel.
    #[test]
    fn rounds_by_frontier_are_rounds_over_all_texels() {
        let size = 23;
        let mut known: Vec<Option<usize>> = vec![None; size * size];
        for k in 0..30 {
            known[(k * 97 + k * k * 31) % (size * size)] = Some(k);
        }
        let closed = |at: usize| at % 7 == 3;
        let mut slow = known.clone();
        for rounds in 0..6 {
            let there = known.iter().map(Option::is_some).collect();
            let mut fast = known.clone();
            for Grown { at, from } in growth(there, size as u32, rounds, &closed) {
                fast[at as usize] = fast[from as usize];
            }
            assert_eq!(fast, slow);
            let round = |at: usize| {
                let first = || near(at, size, slow.len()).find_map(|n| slow[n]);
                slow[at].or_else(|| if closed(at) { None } else { first() })
            };
            slow = (0..slow.len()).map(round).collect();
        }
    }
}
