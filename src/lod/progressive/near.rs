//! The reference round a collapse: gathered once, asked by every triangle that comes to be.
//!
//! In: the triangles of the reference that the faces round a place cover. Out: [`Near`], each of them once, over vertices of
//! its own, so that what a vertex is asked is asked once and not by each of its triangles.

/// Triangles of the reference, each once.
#[derive(Debug, Default)]
pub(super) struct Near {
    /// Their numbers in the reference.
    pub(super) triangles: Vec<u32>,
    /// Their corners among `vertices`.
    pub(super) corners: Vec<[u32; 3]>,
    /// Vertices of the reference.
    pub(super) vertices: Vec<u32>,
    numbers: Numbers,
}

impl Near {
    /// Gathers the triangles of `covers`, which may name them several times, in the order in which they are named first.
    pub(super) fn gather<'c>(
        &mut self,
        reference: &[[u32; 3]],
        covers: impl Iterator<Item = &'c [u32]> + Clone,
    ) {
        self.triangles.clear();
        self.corners.clear();
        self.vertices.clear();
        self.numbers.clear(covers.clone().map(<[u32]>::len).sum());
        for &t in covers.flatten() {
            self.numbers.of(t, &mut self.triangles);
        }
        self.numbers.clear(3 * self.triangles.len());
        for &t in &self.triangles {
            let [a, b, c] = reference[t as usize];
            let mut corner = |v| self.numbers.of(v, &mut self.vertices);
            self.corners.push([corner(a), corner(b), corner(c)]);
        }
    }
}

/// Numbers for names, in the order in which these come: a table with open addresses, which stays small enough for the cache.
#[derive(Debug, Default)]
struct Numbers {
    /// A name and its number plus one; zero where free.
    slots: Vec<(u32, u32)>,
    /// What a hash is shifted down by to be a slot.
    shift: u32,
}

impl Numbers {
    /// Forgets all; there will be no more than `most` names.
    fn clear(&mut self, most: usize) {
        let slots = (most + most / 2 + 8).next_power_of_two();
        self.shift = 32 - slots.ilog2();
        self.slots.clear();
        self.slots.resize(slots, (0, 0));
    }

    #[inline]
    /// The number of `name` in `names`, to whose end it is put where it is new.
    fn of(&mut self, name: u32, names: &mut Vec<u32>) -> u32 {
        // Knuth, The Art of Computer Programming, volume 3, section 6.4: the golden ratio spreads what is close.
        let mut slot = (name.wrapping_mul(0x9e37_79b9) >> self.shift) as usize;
        loop {
            let (known, number) = self.slots[slot];
            if number == 0 {
                names.push(name);
                self.slots[slot] = (name, names.len() as u32);
                return names.len() as u32 - 1;
            }
            if known == name {
                return number - 1;
            }
            slot = (slot + 1) & (self.slots.len() - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn everything_is_there_once_and_corners_are_what_they_were() {
        let reference: Vec<[u32; 3]> = (0..900u32)
            .map(|t| [t * 7 % 500, t * 13 % 500 + 500, t * 17 % 500 + 1000])
            .collect();
        let mut near = Near::default();
        for most in [0u32, 1, 2, 30, 900] {
            let all: Vec<u32> = (0..most).map(|i| i * 11 % 900).collect();
            let runs = [&all[..], &all[..all.len() / 2], &[], &all[all.len() / 3..]];
            near.gather(&reference, runs.into_iter());
            assert_eq!(near.triangles, all);
            let once: HashSet<u32> = near.vertices.iter().copied().collect();
            assert_eq!(once.len(), near.vertices.len());
            for (t, corners) in near.triangles.iter().zip(&near.corners) {
                let named = corners.map(|v| near.vertices[v as usize]);
                assert_eq!(named, reference[*t as usize]);
            }
        }
    }
}
