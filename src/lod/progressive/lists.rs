//! Many short lists in one piece of memory.
//!
//! In: lists of numbers, changed one after the other. Out: [`Lists`]. A list that has outgrown its room moves to the end; what is
//! left behind is reclaimed at once when it has become more than what is used.

/// Lists, by number.
#[derive(Debug, Default)]
pub(super) struct Lists {
    spans: Vec<Span>,
    pool: Vec<u32>,
    /// Of the pool, what belongs to lists.
    used: usize,
}

/// Where a list stands in the pool.
#[derive(Clone, Copy, Debug, Default)]
struct Span {
    start: usize,
    len: u32,
    room: u32,
}

/// Below this size nothing is reclaimed.
const SMALL: usize = 1 << 16;

impl Lists {
    /// List `i` holds what stands in `items` under it, in order: pairs of a list and an item.
    pub(super) fn of(lists: usize, items: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut spans = vec![Span::default(); lists];
        items.clone().for_each(|(i, _)| spans[i as usize].room += 1);
        let mut used = 0;
        for span in &mut spans {
            span.start = used;
            used += span.room as usize;
        }
        let mut pool = vec![0; used];
        for (i, item) in items {
            let span = &mut spans[i as usize];
            pool[span.start + span.len as usize] = item;
            span.len += 1;
        }
        Lists { spans, pool, used }
    }

    pub(super) fn count(&self) -> usize {
        self.spans.len()
    }

    pub(super) fn get(&self, i: u32) -> &[u32] {
        let span = self.spans[i as usize];
        &self.pool[span.start..][..span.len as usize]
    }

    /// Makes a list one of other items.
    pub(super) fn set(&mut self, i: u32, items: &[u32]) {
        if items.len() > self.spans[i as usize].room as usize {
            self.place(i as usize, items.len());
        }
        self.spans[i as usize].len = 0;
        self.append(i as usize, items);
        self.reclaim_much();
    }

    /// Takes an item out; the others keep their order.
    pub(super) fn remove(&mut self, i: u32, old: u32) {
        let span = &mut self.spans[i as usize];
        let list = &mut self.pool[span.start..][..span.len as usize];
        if let Some(at) = list.iter().position(|&item| item == old) {
            list.copy_within(at + 1.., at);
            span.len -= 1;
        }
    }

    /// Puts items to the end of a list.
    pub(super) fn extend(&mut self, i: u32, items: &[u32]) {
        let span = self.spans[i as usize];
        let len = span.len as usize + items.len();
        if len > span.room as usize {
            self.place(i as usize, len + len / 2);
            let from = span.start..span.start + span.len as usize;
            self.pool.copy_within(from, self.spans[i as usize].start);
            self.spans[i as usize].len = span.len;
        }
        self.append(i as usize, items);
    }

    /// Leaves a list empty, and its room to others.
    pub(super) fn clear(&mut self, i: u32) {
        self.used -= self.spans[i as usize].room as usize;
        self.spans[i as usize] = Span::default();
        self.reclaim_much();
    }

    fn reclaim_much(&mut self) {
        if self.pool.len() > SMALL.max(2 * self.used) {
            self.reclaim();
        }
    }

    /// Gives a list other room, at the end, and leaves it empty.
    fn place(&mut self, i: usize, room: usize) {
        self.used += room - self.spans[i].room as usize;
        self.spans[i] = Span {
            start: self.pool.len(),
            len: 0,
            room: room as u32,
        };
        self.pool.resize(self.pool.len() + room, 0);
    }

    fn append(&mut self, i: usize, items: &[u32]) {
        let span = &mut self.spans[i];
        self.pool[span.start + span.len as usize..][..items.len()].copy_from_slice(items);
        span.len += items.len() as u32;
    }

    /// Moves all lists together.
    fn reclaim(&mut self) {
        let mut pool = Vec::with_capacity(self.used + self.used / 2);
        for span in &mut self.spans {
            let start = pool.len();
            pool.extend_from_slice(&self.pool[span.start..][..span.room as usize]);
            span.start = start;
        }
        self.pool = pool;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a list of lists, through many changes.
    #[test]
    fn lists_are_what_was_done_to_them() {
        let items = (0..60_000u32).map(|n| (n * 7 % 1000, n));
        let mut known = vec![Vec::new(); 1000];
        items.clone().for_each(|(i, n)| known[i as usize].push(n));
        let mut lists = Lists::of(1000, items);
        let mut reclaimed = 0;
        for n in 0..30_000u32 {
            let before = lists.pool.len();
            let i = n.wrapping_mul(0x9e37_79b9) >> 22;
            let i = i.min(known.len() as u32 - 1);
            let list = &mut known[i as usize];
            match n % 5 {
                0 if n < 20_000 => {
                    lists.extend(i, &[n, n + 1, n + 2]);
                    list.extend([n, n + 1, n + 2]);
                }
                1 => {
                    let items = vec![n; (n % 37) as usize];
                    lists.set(i, &items);
                    *list = items;
                }
                2 if !list.is_empty() => {
                    let at = list.len() / 3;
                    let at = list.iter().position(|item| *item == list[at]).unwrap();
                    lists.remove(i, list[at]);
                    list.remove(at);
                }
                3 => {
                    lists.clear(i);
                    list.clear();
                }
                _ => {}
            }
            reclaimed += usize::from(lists.pool.len() < before);
        }
        assert_eq!(lists.count(), known.len());
        for (i, list) in known.iter().enumerate() {
            assert_eq!(lists.get(i as u32), list);
        }
        let used: usize = lists.spans.iter().map(|span| span.room as usize).sum();
        assert_eq!(lists.used, used);
        assert!(reclaimed > 0);
    }
}
