//! Tables from a file are untrusted: every index a lookup would follow is checked before anything reads them.

use super::layout::{self, EMPTY, LAST, LONG};
use super::{BuildOptions, Layout, Tables};
use rayon::prelude::*;

impl Tables {
    /// Checks that every lookup stays inside the tables and names triangles of a mesh with `triangles` triangles.
    /// The error is the element and the reason.
    pub fn validate(&self, triangles: usize) -> Result<(), (String, String)> {
        let refuse = |element: &str, reason: String| Err((element.to_owned(), reason));
        let [width, height] = self.hash_size;
        if width != height
            || (BuildOptions {
                hash: width,
                layout: self.layout,
            })
            .bits()
            .is_err()
        {
            return refuse(
                "hash_size",
                format!("{width} x {height} is not a square power of two from 4 to 8192"),
            );
        }
        let frame = self.primary.frame;
        if !(frame.scale > 0.0
            && frame.scale.is_finite()
            && frame.origin.iter().all(|x| x.is_finite()))
        {
            return refuse(
                "primary.frame",
                "origin or scale is not a finite number".into(),
            );
        }
        let texels = width as usize * height as usize;
        let lengths = [
            (
                "hash",
                self.hash.len(),
                texels * layout::hash_words(self.layout),
            ),
            (
                "triangle",
                self.triangle.len(),
                triangles * layout::triangle_words(self.layout, &self.primary),
            ),
        ];
        for (name, have, want) in lengths {
            if have != want {
                return refuse(name, format!("{have} words where {want} belong"));
            }
        }
        let fault = match self.layout {
            Layout::Packed => self.packed_fault(triangles),
            Layout::Classic => self.classic_fault(triangles),
        };
        fault.map_or(Ok(()), |(element, reason)| refuse(&element, reason))
    }

    fn packed_fault(&self, triangles: usize) -> Option<(String, String)> {
        let bad = |word: u32| (word & !LAST) as usize >= triangles;
        if let Some(i) = self.list.par_iter().position_first(|w| bad(*w)) {
            return Some((
                format!("list[{i}]"),
                format!("triangle {} of {triangles}", self.list[i] & !LAST),
            ));
        }
        // Every walk ends: the last word of the list carries the flag, and so does whatever lies before it or not.
        if self.list.last().is_some_and(|w| w & LAST == 0) {
            return Some((
                format!("list[{}]", self.list.len() - 1),
                "the last list has no end".into(),
            ));
        }
        let fault = self.hash.par_chunks(2).position_first(|texel| {
            texel[0] != EMPTY
                && (bad(texel[0]) || texel[0] & LAST == 0 && texel[1] as usize >= self.list.len())
        });
        fault.map(|t| {
            (
                format!("hash[{t}]"),
                "its triangle or its list does not exist".into(),
            )
        })
    }

    fn classic_fault(&self, triangles: usize) -> Option<(String, String)> {
        // How many words before each place name no triangle (lengths of long lists may): every list is then one
        // subtraction, however many texels share it.
        let mut strange = Vec::with_capacity(self.list.len() + 1);
        strange.push(0u32);
        for word in &self.list {
            let is_strange = (word & 0xff_ffff) as usize >= triangles;
            strange.push(strange[strange.len() - 1] + u32::from(is_strange));
        }
        let fault = self.hash.par_iter().position_first(|word| {
            let (mut start, mut length) = ((word & 0xff_ffff) as usize, (word >> 24) as usize);
            if length == LONG as usize {
                let Some(stored) = self.list.get(start) else {
                    return true;
                };
                (start, length) = (start + 1, *stored as usize);
            }
            // An empty list must lie inside as well: a lookup takes the slice before it looks at its length.
            match strange.get(start.saturating_add(length)) {
                Some(end) => *end != strange[start],
                None => true,
            }
        });
        fault.map(|t| {
            (
                format!("hash[{t}]"),
                "its list or a triangle in it does not exist".into(),
            )
        })
    }
}
