//! Accessors: typed numbers in buffers (glTF 2.0, sec. 3.6.2). Ranges are checked before anything is allocated.

use super::file::{AGAIN, File};
use crate::error::{Error, Result};
use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;

/// Greatest count of an accessor without a buffer view: it takes no bytes in the file.
const MOST_ZEROS: usize = 1 << 22;

impl File<'_> {
    /// The vectors of an accessor, normalised where it says so.
    pub(super) fn vectors<const N: usize>(
        &self,
        accessor: &Accessor,
        place: &str,
    ) -> Result<Vec<[f32; N]>> {
        let dimensions = [
            Dimensions::Scalar,
            Dimensions::Vec2,
            Dimensions::Vec3,
            Dimensions::Vec4,
        ];
        if dimensions.get(N - 1) != Some(&accessor.dimensions()) {
            return Err(self.misfit(accessor, place, &format!("vectors of {N}")));
        }
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        let size = kind.size();
        self.elements(accessor, |bytes| {
            std::array::from_fn(|i| number(&bytes[i * size..], kind, normalized))
        })
    }

    /// The indices of an accessor.
    pub(super) fn indices(&self, accessor: &Accessor, place: &str) -> Result<Vec<u32>> {
        let whole = matches!(
            accessor.data_type(),
            DataType::U8 | DataType::U16 | DataType::U32
        );
        if !whole || accessor.dimensions() != Dimensions::Scalar {
            return Err(self.misfit(accessor, place, "unsigned numbers"));
        }
        self.elements(accessor, whole_number)
    }

    fn misfit(&self, accessor: &Accessor, place: &str, needed: &str) -> Error {
        let (index, dimensions, kind) = (
            accessor.index(),
            accessor.dimensions(),
            accessor.data_type(),
        );
        let message = format!(
            "accessors[{index}] holds {dimensions:?} of {kind:?}, and {needed} are needed; {AGAIN}"
        );
        self.error(place, message)
    }

    fn elements<T: Copy>(
        &self,
        accessor: &Accessor,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let place = format!("accessors[{}]", accessor.index());
        let (count, size) = (accessor.count(), accessor.size());
        let mut values: Vec<T> = match accessor.view() {
            Some(view) => self
                .slices(&view, accessor.offset(), count, size, &place)?
                .map(&decode)
                .collect(),
            None if count <= MOST_ZEROS => vec![decode(&[0; 64]); count],
            None => {
                let message = format!(
                    "it has {count} elements and no bufferView; at most {MOST_ZEROS} are read"
                );
                return Err(self.error(place, message));
            }
        };
        if let Some(sparse) = accessor.sparse() {
            let place = format!("{place}.sparse");
            let (at, new) = (sparse.indices(), sparse.values());
            let index_size = at.index_type().size();
            let at = self.slices(&at.view(), at.offset(), sparse.count(), index_size, &place)?;
            let new = self.slices(&new.view(), new.offset(), sparse.count(), size, &place)?;
            for (index, value) in at.map(whole_number).zip(new.map(decode)) {
                let slot = values.get_mut(index as usize);
                *slot.ok_or_else(|| {
                    self.error(
                        &place,
                        format!("it replaces element {index} of {count} (counted from 0); {AGAIN}"),
                    )
                })? = value;
            }
        }
        Ok(values)
    }

    /// Slices of `size` bytes, as far apart as the view says.
    fn slices<'s>(
        &'s self,
        view: &View,
        offset: usize,
        count: usize,
        size: usize,
        place: &str,
    ) -> Result<impl Iterator<Item = &'s [u8]> + use<'s>> {
        let bytes = self.view(view)?;
        let stride = view.stride().unwrap_or(size);
        let length = count.checked_sub(1).map_or(Some(0), |steps| {
            steps.checked_mul(stride)?.checked_add(size)
        });
        let end = length.and_then(|length| length.checked_add(offset));
        let Some(bytes) = end.and_then(|end| bytes.get(offset..end)) else {
            return Err(self.error(
                place,
                format!(
                    "{count} elements of {size} bytes, {stride} apart, from byte {offset} do not fit in the {} bytes of bufferViews[{}]; {AGAIN}",
                    bytes.len(),
                    view.index()
                ),
            ));
        };
        Ok((0..count).map(move |i| &bytes[i * stride..][..size]))
    }
}

/// A number at the start of the bytes; normalised as in glTF 2.0, sec. 3.6.2.2.
fn number(bytes: &[u8], kind: DataType, normalized: bool) -> f32 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, most) = match kind {
        DataType::I8 => (f32::from(bytes[0].cast_signed()), f32::from(i8::MAX)),
        DataType::U8 => (f32::from(bytes[0]), f32::from(u8::MAX)),
        DataType::I16 => (f32::from(i16::from_le_bytes(two())), f32::from(i16::MAX)),
        DataType::U16 => (f32::from(u16::from_le_bytes(two())), f32::from(u16::MAX)),
        DataType::U32 => (u32::from_le_bytes(four()) as f32, u32::MAX as f32),
        DataType::F32 => return f32::from_le_bytes(four()),
    };
    if normalized {
        (value / most).max(-1.0)
    } else {
        value
    }
}

/// An unsigned number of one, two or four bytes.
fn whole_number(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, &byte| value << 8 | u32::from(byte))
}
