//! Reads accessors: the only place where offsets and counts of a file meet its bytes.
//!
//! In: the accessor, view and sparse tables, all unchecked but the views. Out: arrays of numbers, every byte of them inside
//! its view. All arithmetic is checked 64-bit; memory is charged to a budget before it is allocated, so that neither a count
//! nor a thousand accessors over the same bytes ask for more than the file's size justifies.

use super::component::{Component, layout};
use super::document::View;
use super::json::{Accessor, SparsePart, at};
use crate::{Error, Result};
use std::cell::Cell;

/// Numbers may take up this many bytes, and `BUDGET_FACTOR` times the file's bytes.
const BUDGET_BASE: u64 = 64 << 20;
const BUDGET_FACTOR: u64 = 64;

/// One accessor, checked: all its elements lie inside the binary.
pub(super) struct Checked<'a> {
    pub(super) count: usize,
    pub(super) component: Component,
    pub(super) components: usize,
    pub(super) normalized: bool,
    base: Option<Elements<'a>>,
    sparse: Option<(Vec<usize>, Elements<'a>)>,
}

/// Equally spaced elements.
#[derive(Clone, Copy)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Elements<'a> {
    fn get(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..]
    }
}

/// Reads the accessors of one document.
pub(crate) struct Reader<'a> {
    pub(super) file: &'a str,
    accessors: &'a [Accessor],
    views: &'a [View],
    binary: &'a [u8],
    left: Cell<u64>,
}

impl<'a> Reader<'a> {
    /// `file_bytes`: what the budget grows with.
    pub(super) fn new(
        file: &'a str,
        accessors: &'a [Accessor],
        views: &'a [View],
        binary: &'a [u8],
        file_bytes: u64,
    ) -> Self {
        let left = Cell::new(BUDGET_BASE.saturating_add(file_bytes.saturating_mul(BUDGET_FACTOR)));
        Reader {
            file,
            accessors,
            views,
            binary,
            left,
        }
    }

    /// An error about accessor `index`.
    pub(super) fn fault(&self, index: usize, reason: impl Into<String>) -> Error {
        Error::input(self.file, format!("accessors[{index}]"), reason)
    }

    /// Takes `count` elements of `size` bytes off the budget, before they are allocated.
    pub(crate) fn charge(
        &self,
        count: usize,
        size: usize,
        element: impl FnOnce() -> String,
    ) -> Result<()> {
        let need = (count as u64).checked_mul(size as u64);
        match need.and_then(|need| self.left.get().checked_sub(need)) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => Err(Error::input(
                self.file,
                element(),
                format!(
                    "{count} elements of {size} bytes are more than a file of this size can mean"
                ),
            )),
        }
    }

    /// Checks accessor `index` against its views; `user` is the place that names it.
    pub(super) fn check(&self, index: usize, user: impl FnOnce() -> String) -> Result<Checked<'a>> {
        let accessor = at(self.file, self.accessors, "accessors", index, user)?;
        let Some(component) = Component::from_number(accessor.component_type) else {
            return Err(self.fault(
                index,
                format!("componentType {} does not exist", accessor.component_type),
            ));
        };
        let Some((components, size)) = layout(&accessor.kind, component) else {
            return Err(self.fault(index, format!("type {:?} does not exist", accessor.kind)));
        };
        let count = usize::try_from(accessor.count).unwrap_or(usize::MAX);
        if count == 0 {
            return Err(self.fault(index, "has count 0"));
        }
        let base = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or(0);
                Some(self.elements(index, view, offset, count, size, true)?)
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => {
                if sparse.count == 0 || sparse.count > accessor.count {
                    return Err(
                        self.fault(index, format!("sparse.count {} of {count}", sparse.count))
                    );
                }
                let at =
                    self.sparse_indices(index, &sparse.indices, sparse.count as usize, count)?;
                let values = &sparse.values;
                Some((
                    at,
                    self.elements(
                        index,
                        values.buffer_view,
                        values.byte_offset,
                        sparse.count as usize,
                        size,
                        false,
                    )?,
                ))
            }
            None => None,
        };
        Ok(Checked {
            count,
            component,
            components,
            normalized: accessor.normalized,
            base,
            sparse,
        })
    }

    /// `count` elements of `size` bytes from `offset` of a view.
    fn elements(
        &self,
        index: usize,
        view: usize,
        offset: u64,
        count: usize,
        size: usize,
        strided: bool,
    ) -> Result<Elements<'a>> {
        let place = || format!("accessors[{index}]");
        let view_number = view;
        let view = at(self.file, self.views, "bufferViews", view, place)?;
        let stride = view.stride.filter(|_| strided).unwrap_or(size);
        if stride < size {
            return Err(self.fault(
                index,
                format!("elements of {size} bytes overlap at byteStride {stride}"),
            ));
        }
        let end = (count as u64 - 1)
            .checked_mul(stride as u64)
            .and_then(|last| last.checked_add(size as u64))
            .and_then(|bytes| bytes.checked_add(offset));
        if end.is_none_or(|end| end > view.length as u64) {
            let reason = format!(
                "{count} elements of {size} bytes from {offset} are not inside bufferViews[{view_number}] ({} bytes)",
                view.length
            );
            return Err(self.fault(index, reason));
        }
        Ok(Elements {
            bytes: &self.binary[view.start + offset as usize..view.start + view.length],
            stride,
        })
    }

    /// Indices of a sparse accessor: strictly growing, below `limit`.
    fn sparse_indices(
        &self,
        index: usize,
        part: &SparsePart,
        count: usize,
        limit: usize,
    ) -> Result<Vec<usize>> {
        let component = part.component_type.and_then(Component::from_number);
        let Some(component) = component.filter(|c| c.unsigned(&[0; 4]).is_some()) else {
            return Err(self.fault(
                index,
                "sparse.indices.componentType is not an unsigned integer type",
            ));
        };
        let elements = self.elements(
            index,
            part.buffer_view,
            part.byte_offset,
            count,
            component.size(),
            false,
        )?;
        self.charge(count, size_of::<usize>(), || {
            format!("accessors[{index}].sparse")
        })?;
        let mut out: Vec<usize> = Vec::with_capacity(count);
        for i in 0..count {
            let value = component.unsigned(elements.get(i)).unwrap_or(0) as usize;
            if value >= limit || out.last().is_some_and(|&last| last >= value) {
                let reason =
                    format!("sparse index {i} is {value}: not growing, or not below {limit}");
                return Err(self.fault(index, reason));
            }
            out.push(value);
        }
        Ok(out)
    }

    /// All elements, each made of its `N` components by `convert`; elements without bytes are `zero`.
    fn collect<const N: usize, T: Copy>(
        &self,
        index: usize,
        checked: &Checked,
        zero: T,
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<[T; N]>> {
        if checked.components != N {
            return Err(self.fault(
                index,
                format!("has {} components where {N} are needed", checked.components),
            ));
        }
        self.charge(checked.count, size_of::<[T; N]>(), || {
            format!("accessors[{index}]")
        })?;
        let size = checked.component.size();
        let element =
            |bytes: &[u8]| -> [T; N] { std::array::from_fn(|k| convert(&bytes[k * size..])) };
        let mut out = match checked.base {
            Some(base) => (0..checked.count).map(|i| element(base.get(i))).collect(),
            None => vec![[zero; N]; checked.count],
        };
        if let Some((places, values)) = &checked.sparse {
            for (i, &place) in places.iter().enumerate() {
                out[place] = element(values.get(i));
            }
        }
        Ok(out)
    }

    /// Accessor `index` as floats; integers normalized if it says so.
    ///
    /// # Errors
    /// [`Error::Input`] naming the accessor, and the element where a value is not finite.
    pub(crate) fn floats<const N: usize>(
        &self,
        index: usize,
        user: impl FnOnce() -> String,
    ) -> Result<Vec<[f32; N]>> {
        let checked = self.check(index, user)?;
        let out: Vec<[f32; N]> = self.collect(index, &checked, 0.0, |bytes| {
            checked.component.float(bytes, checked.normalized)
        })?;
        if checked.component == Component::F32
            && let Some(i) = out.iter().position(|v| v.iter().any(|c| !c.is_finite()))
        {
            return Err(self.fault(index, format!("element {i} is not finite: {:?}", out[i])));
        }
        Ok(out)
    }

    /// Accessor `index` as unsigned integers.
    pub(crate) fn unsigned<const N: usize>(
        &self,
        index: usize,
        user: impl FnOnce() -> String,
    ) -> Result<Vec<[u32; N]>> {
        let checked = self.check(index, user)?;
        if checked.component.unsigned(&[0; 4]).is_none() || checked.normalized {
            return Err(self.fault(
                index,
                "is not of an unsigned integer type (5121, 5123, 5125)",
            ));
        }
        self.collect(index, &checked, 0, |bytes| {
            checked.component.unsigned(bytes).unwrap_or(0)
        })
    }

    /// Checks every accessor, used or not: its bounds, and that its floats are finite.
    pub(super) fn check_all(&self) -> Result<()> {
        for index in 0..self.accessors.len() {
            let checked = self.check(index, String::new)?;
            if checked.component != Component::F32 {
                continue;
            }
            // Scanning costs time, not memory; it is charged all the same, or many accessors over one view would hang.
            self.charge(checked.count, checked.components * 4, || {
                format!("accessors[{index}]")
            })?;
            for part in [
                checked.base.map(|base| (base, checked.count)),
                checked.sparse.map(|(at, v)| (v, at.len())),
            ] {
                let Some((elements, count)) = part else {
                    continue;
                };
                for i in 0..count {
                    let bytes = &elements.get(i)[..checked.components * 4];
                    if bytes
                        .chunks_exact(4)
                        .any(|c| !Component::F32.float(c, false).is_finite())
                    {
                        return Err(self.fault(index, format!("element {i} is not finite")));
                    }
                }
            }
        }
        Ok(())
    }
}
