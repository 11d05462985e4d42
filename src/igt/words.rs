//! The words of a table: our own, or in a file that is mapped.

use crate::scene::Mapped;
use std::fmt;
use std::ops::{Deref, DerefMut, Range};

/// Words of a table, a slice of `u32` to whoever reads them. Those of a mapped file are fetched when they are looked at;
/// to change them makes a copy.
#[derive(Clone)]
pub struct Words(Store);

#[derive(Clone)]
enum Store {
    Own(Vec<u32>),
    /// Bytes of a file: whole words, aligned, on a little-endian processor.
    Mapped(Mapped, Range<usize>),
}

impl Words {
    /// The little-endian words at some bytes of a file; none where these are not there, or not whole words. They are copied
    /// where the processor cannot read them as they lie.
    pub fn in_file(file: &Mapped, range: Range<usize>) -> Option<Words> {
        let bytes = file.bytes().get(range.clone())?;
        let (words, []) = bytes.as_chunks::<4>() else {
            return None;
        };
        let as_they_lie =
            cfg!(target_endian = "little") && bytemuck::try_cast_slice::<u8, u32>(bytes).is_ok();
        Some(Words(if as_they_lie {
            Store::Mapped(file.clone(), range)
        } else {
            Store::Own(words.iter().map(|w| u32::from_le_bytes(*w)).collect())
        }))
    }

    /// The words, to be changed: from now on our own.
    pub fn to_mut(&mut self) -> &mut Vec<u32> {
        if let Store::Mapped(..) = self.0 {
            self.0 = Store::Own(self.to_vec());
        }
        match &mut self.0 {
            Store::Own(words) => words,
            Store::Mapped(..) => unreachable!("made our own above"),
        }
    }

    /// Whether they lie in a mapped file.
    pub fn is_mapped(&self) -> bool {
        matches!(self.0, Store::Mapped(..))
    }
}

impl Deref for Words {
    type Target = [u32];

    #[inline]
    fn deref(&self) -> &[u32] {
        match &self.0 {
            Store::Own(words) => words,
            Store::Mapped(file, range) => bytemuck::cast_slice(&file.bytes()[range.clone()]),
        }
    }
}

impl DerefMut for Words {
    fn deref_mut(&mut self) -> &mut [u32] {
        self.to_mut()
    }
}

impl From<Vec<u32>> for Words {
    fn from(words: Vec<u32>) -> Self {
        Words(Store::Own(words))
    }
}

impl PartialEq for Words {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl fmt::Debug for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self[..].fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_file_are_read_as_they_lie_or_copied() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("words");
        std::fs::write(&path, (0..32).collect::<Vec<u8>>()).unwrap();
        let file = Mapped::open(&path).unwrap();
        let mut aligned = Words::in_file(&file, 4..12).unwrap();
        assert_eq!(aligned[..], [0x0706_0504, 0x0b0a_0908]);
        assert_eq!(aligned.is_mapped(), cfg!(target_endian = "little"));
        let odd = Words::in_file(&file, 1..5).unwrap();
        assert!(!odd.is_mapped());
        assert_eq!(odd[..], [0x0403_0201]);
        // Not there, not whole, not in order.
        for range in [28..36, 0..3, usize::MAX - 3..usize::MAX] {
            assert!(Words::in_file(&file, range).is_none());
        }
        let before = aligned.clone();
        aligned[0] = 1;
        assert!(!aligned.is_mapped() && aligned != before);
        assert_eq!(Words::in_file(&file, 4..12), Some(before));
    }
}
