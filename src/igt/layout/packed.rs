//! The packed layout's hash and lists.
//!
//! Entries take as many bits as the mesh needs: b ([`Format::id_bits`](super::Format)) for a triangle's number, and its layer
//! below that only in lists where triangles of several layers meet (*mixed*; elsewhere the layer of the asker changes no
//! answer). A hash texel is a 64-bit *head* that holds whole lists where they are short. Other lists begin with the triangle
//! that covers most of the texel, and the rest of their entries are *masked*: above them stand six bits that say where they
//! are to be read. In a *sorted* list, one for each region around the first triangle: the signs of its test, if it fails,
//! say where to look next. In others one for each quadrant of the texel.
//!
//! ```text
//! head    bits 0..4 a tag, 60 bits of payload
//!   0            no list
//!   1..=5        that many entries, b bits each; single, not mixed
//!   6..=13       28 bits the address of a block, 31 the first entry, 1: sorted. 6 and the sum of
//!                1: full blocks follow, else a half one;  2: not single;  4: mixed
//!   14           divided: 28 bits the first of 4^k heads, 3 bits k; the texel's 2^k x 2^k children, row by row
//! block   half: 64 bits of masked entries; full: 127 bits of them, bit 127 on the last one.
//!         Room that is left begins with an entry of all ones. Addresses count 64-bit units.
//! ```
//!
//! A list is *single* where no two of its triangles of one layer cover a common point of the texel: the first hit of the
//! asker's layer is then the only one. Entries stand in the order in which they are likely to be hit.

/// Words of a head.
pub const HEAD_WORDS: usize = 2;
/// Bits of a mask: one a region, or one a quadrant (bit 0 the first, bit 1 right of it, bits 2 and 3 above).
pub const MASK_BITS: u32 = 6;
/// The most bits of an entry, layer included.
pub const MAX_ENTRY_BITS: u32 = 31;
/// The most entries a head holds.
pub const MOST_INLINE: u32 = 5;
/// Tag of a texel without a list.
pub const EMPTY: u64 = 0;
/// Tag of a list in blocks, and what is added to it.
const BLOCKS: u64 = 6;
const FULL: u64 = 1;
const NOT_SINGLE: u64 = 2;
const MIXED: u64 = 4;
const DIVIDED: u64 = 14;
const ADDRESS_BITS: u32 = 28;
/// The largest address plus one.
pub const ADDRESSES: u64 = 1 << ADDRESS_BITS;
const PAYLOAD_AT: u32 = 4;
const PAYLOAD_BITS: u32 = 60;
/// Bit 127: no block follows.
pub(in crate::igt) const LAST: u32 = 1 << 31;

/// A hash texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Head {
    /// No list.
    Empty,
    /// A list of [`Run::count`] entries or, where `rest` says so, one that goes on in blocks.
    List {
        /// The entries in the head.
        run: Run,
        /// Where the others are.
        rest: Rest,
        /// What kind of list.
        kind: Kind,
    },
    /// The texel is cut into `2^by` x `2^by`.
    Divided {
        /// Index of the first child's head.
        first: usize,
        /// log2 of the children along a side.
        by: u32,
    },
}

/// What is known of a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// No two triangles of a layer overlap.
    pub single: bool,
    /// Entries have layers.
    pub mixed: bool,
    /// Masks name regions around the first triangle, not quadrants.
    pub sorted: bool,
}

/// Where a list goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Nowhere.
    None,
    /// At a 64-bit unit.
    Half(usize),
    /// At a 128-bit unit, in 64-bit units (even).
    Full(usize),
}

/// An entry and where it is to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Masked {
    /// As [`Format::entry`](super::Format::entry) has it.
    pub entry: u32,
    /// One bit a region or quadrant; 0 without masks.
    pub mask: u32,
}

/// A run of entries in the low bits of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The entries, the first in the lowest bits.
    pub window: u128,
    /// How many there are at most.
    pub count: u32,
}

impl Run {
    /// Takes the next entry of `bits` bits and the mask, if there are any, above it; none at the end.
    pub fn next(&mut self, bits: u32, masked: bool) -> Option<Masked> {
        let entry = self.window as u32 & end(bits);
        if self.count == 0 || entry == end(bits) {
            return None;
        }
        self.count -= 1;
        self.window >>= bits;
        let mask_bits = if masked { MASK_BITS } else { 0 };
        let mask = self.window as u32 & ((1 << mask_bits) - 1);
        self.window >>= mask_bits;
        Some(Masked { entry, mask })
    }
}

/// The entry that ends a run early: all ones.
pub fn end(bits: u32) -> u32 {
    u32::MAX >> (32 - bits)
}

/// How many entries of `bits` bits a head without blocks holds.
pub fn inline(bits: u32) -> u32 {
    (PAYLOAD_BITS / bits).min(MOST_INLINE)
}

/// How many masked entries a half block holds.
pub fn in_half(bits: u32) -> u32 {
    64 / (bits + MASK_BITS)
}

/// How many masked entries a full block holds.
pub fn in_full(bits: u32) -> u32 {
    127 / (bits + MASK_BITS)
}

/// Masked entries one after the other from bit 0 on; room for `count` of them, an end mark where they are fewer.
fn window(entries: &[Masked], bits: u32, count: u32) -> u128 {
    let marked = (entries.len() < count as usize).then_some(u128::from(end(bits)));
    let one = |m: &Masked| u128::from(m.entry) | u128::from(m.mask) << bits;
    let all = entries.iter().map(one).chain(marked);
    all.enumerate()
        .fold(0, |w, (i, e)| w | e << (i as u32 * (bits + MASK_BITS)))
}

/// The head of a list that fits one: single, not mixed.
pub fn inline_head(entries: &[u32], bits: u32) -> u64 {
    let at = |i: usize| PAYLOAD_AT + i as u32 * bits;
    let count = entries.len() as u64;
    let entries = entries.iter().enumerate();
    entries.fold(count, |head, (i, entry)| head | u64::from(*entry) << at(i))
}

/// The head of a list whose other entries are in blocks; its address is added to by [`moved`].
pub fn list_head(first: u32, kind: Kind, full: bool, address: u64) -> u64 {
    let flag = |is: bool, flag: u64| if is { flag } else { 0 };
    let tag = BLOCKS + flag(full, FULL) + flag(!kind.single, NOT_SINGLE) + flag(kind.mixed, MIXED);
    let behind = u64::from(first) | flag(kind.sorted, 1 << MAX_ENTRY_BITS);
    tag | address << PAYLOAD_AT | behind << (PAYLOAD_AT + ADDRESS_BITS)
}

/// The head of a divided texel.
pub fn divided_head(first: u64, by: u32) -> u64 {
    DIVIDED | first << PAYLOAD_AT | u64::from(by) << (PAYLOAD_AT + ADDRESS_BITS)
}

/// A head whose addresses count from elsewhere: what is added for half blocks, full blocks and children.
pub fn moved(head: u64, half: u64, full: u64, children: u64) -> u64 {
    let by = match head & 15 {
        DIVIDED => children,
        tag if tag < BLOCKS => 0,
        tag if (tag - BLOCKS) & FULL != 0 => full,
        _ => half,
    };
    head + (by << PAYLOAD_AT)
}

/// A half block.
pub fn half_block(entries: &[Masked], bits: u32) -> u64 {
    window(entries, bits, in_half(bits)) as u64
}

/// A full block.
pub fn full_block(entries: &[Masked], bits: u32, last: bool) -> [u32; 4] {
    let w = window(entries, bits, in_full(bits));
    let mut words = [0, 1, 2, 3].map(|i| (w >> (32 * i)) as u32);
    // An end mark may reach into bit 127 only where the block is full, and then there is none.
    words[3] = words[3] & !LAST | if last { LAST } else { 0 };
    words
}

/// Reads a head.
pub fn head(words: [u32; 2]) -> Head {
    let word = u64::from(words[0]) | u64::from(words[1]) << 32;
    let (tag, payload) = (word & 15, word >> PAYLOAD_AT);
    let address = (payload & (ADDRESSES - 1)) as usize;
    let behind = payload >> ADDRESS_BITS;
    let list = |window: u64, count: u64, rest: Rest, kind: Kind| Head::List {
        run: Run {
            window: u128::from(window),
            count: count as u32,
        },
        rest,
        kind,
    };
    match tag {
        EMPTY => Head::Empty,
        DIVIDED => Head::Divided {
            first: address,
            by: (behind & 7) as u32,
        },
        1..BLOCKS => {
            let kind = Kind {
                single: true,
                mixed: false,
                sorted: false,
            };
            list(payload, tag, Rest::None, kind)
        }
        _ => {
            let flags = tag - BLOCKS;
            let kind = Kind {
                single: flags & NOT_SINGLE == 0,
                mixed: flags & MIXED != 0,
                sorted: behind >> MAX_ENTRY_BITS != 0,
            };
            let rest = if flags & FULL != 0 {
                Rest::Full(address)
            } else {
                Rest::Half(address)
            };
            list(behind & ((1 << MAX_ENTRY_BITS) - 1), 1, rest, kind)
        }
    }
}

/// The run of a half block at a 64-bit unit.
pub fn half_run(list: &[u32], unit: usize, bits: u32) -> Run {
    let word = |i: usize| u128::from(list[2 * unit + i]);
    Run {
        window: word(0) | word(1) << 32,
        count: in_half(bits),
    }
}

/// The run of a full block at a 64-bit unit, and whether it is the list's last.
pub fn full_run(list: &[u32], unit: usize, bits: u32) -> (Run, bool) {
    let word = |i: usize| u128::from(list[2 * unit + i]);
    let run = Run {
        window: word(0) | word(1) << 32 | word(2) << 64 | (word(3) & !u128::from(LAST)) << 96,
        count: in_full(bits),
    };
    (run, list[2 * unit + 3] & LAST != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(mut run: Run, bits: u32, masked: bool) -> Vec<Masked> {
        std::iter::from_fn(|| run.next(bits, masked)).collect()
    }

    fn words(head: u64) -> [u32; 2] {
        [head as u32, (head >> 32) as u32]
    }

    /// Entries of `bits` bits, none of them an end mark.
    fn entries(bits: u32, count: u32) -> Vec<Masked> {
        let one = |i: u32| Masked {
            entry: (i * 7919 + 5) & (end(bits) >> 1),
            mask: (i * 31 + 3) & 63,
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn heads_keep_what_they_are_given() {
        for bits in 1..=MAX_ENTRY_BITS {
            for count in 1..=inline(bits) {
                let given: Vec<u32> = entries(bits, count).iter().map(|m| m.entry).collect();
                let Head::List { run, rest, kind } = head(words(inline_head(&given, bits))) else {
                    panic!("a list");
                };
                let kept: Vec<u32> = read(run, bits, false).iter().map(|m| m.entry).collect();
                assert_eq!((kept, rest), (given, Rest::None));
                assert!(kind.single && !kind.mixed);
            }
            for flags in 0..16 {
                let first = end(bits) >> 1;
                let given = Kind {
                    single: flags & 1 != 0,
                    mixed: flags & 2 != 0,
                    sorted: flags & 8 != 0,
                };
                let full = flags & 4 != 0;
                let (address, there) = if full {
                    (ADDRESSES - 2, Rest::Full(ADDRESSES as usize - 2))
                } else {
                    (12_345, Rest::Half(12_345))
                };
                let word = list_head(first, given, full, 1);
                let word = moved(word, address - 1, address - 1, 5);
                let Head::List { run, rest, kind } = head(words(word)) else {
                    panic!("a list");
                };
                let kept = read(run, bits, false)[0].entry;
                assert_eq!((kept, rest, kind), (first, there, given));
            }
        }
        assert_eq!(head([0, 0]), Head::Empty);
        let divided = Head::Divided { first: 107, by: 3 };
        assert_eq!(head(words(moved(divided_head(7, 3), 1, 2, 100))), divided);
    }

    #[test]
    fn blocks_keep_what_they_are_given() {
        for bits in 1..=MAX_ENTRY_BITS {
            for count in 1..=in_full(bits) {
                let given = entries(bits, count);
                for last in [true, false] {
                    let (run, ends) = full_run(&full_block(&given, bits, last), 0, bits);
                    assert_eq!((read(run, bits, true), ends), (given.clone(), last));
                }
                if count <= in_half(bits) {
                    let [low, high] = words(half_block(&given, bits));
                    assert_eq!(
                        read(half_run(&[0, 0, low, high], 1, bits), bits, true),
                        given
                    );
                }
            }
        }
    }
}
