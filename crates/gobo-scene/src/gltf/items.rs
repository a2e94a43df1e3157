//! Items of an accessor, read in place: unused items cost nothing, however often a file names them.
use super::file::GltfFile;
use crate::SceneError;
use ::gltf::accessor::DataType;

/// An accessor whose items are all within its buffers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Items<'a> {
    /// Base items; zeros if there are none.
    base: Option<Strided<'a>>,
    /// Sorted indices, and the items that replace the base's.
    sparse: Option<(Strided<'a>, Strided<'a>)>,
    pub(crate) count: usize,
    data_type: DataType,
    is_normalized: bool,
}

/// Byte strings at a constant stride.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Strided<'a> {
    fn get(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..][..self.size]
    }

    /// Little-endian number `i`.
    fn index(&self, i: usize) -> usize {
        self.get(i).iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte))
    }
}

impl GltfFile {
    /// Items of `accessor`, which must have been checked.
    pub(crate) fn items(&self, accessor: &gltf::Accessor<'_>) -> Result<Items<'_>, SceneError> {
        let (size, count) = (accessor.size(), accessor.count());
        let rows = |view: &gltf::buffer::View<'_>, offset: usize, size: usize, count: usize| {
            let bytes = &self.view(view)?[offset..];
            Ok(Strided { bytes, stride: view.stride().unwrap_or(size), size, count })
        };
        let base = match accessor.view() {
            None => None,
            Some(view) => Some(rows(&view, accessor.offset(), size, count)?),
        };
        let sparse = match accessor.sparse() {
            None => None,
            Some(sparse) => {
                let (indices, values) = (sparse.indices(), sparse.values());
                let index_size = indices.index_type().size();
                let indices = rows(&indices.view(), indices.offset(), index_size, sparse.count())?;
                Some((indices, rows(&values.view(), values.offset(), size, sparse.count())?))
            }
        };
        let (data_type, is_normalized) = (accessor.data_type(), accessor.normalized());
        Ok(Items { base, sparse, count, data_type, is_normalized })
    }
}

impl<'a> Items<'a> {
    /// Bytes of item `i`; `None` for an item of zeros.
    fn bytes(&self, i: usize) -> Option<&'a [u8]> {
        if let Some((indices, values)) = &self.sparse {
            let index = first_from(indices.count, |at| indices.index(at) >= i);
            if index < indices.count && indices.index(index) == i {
                return Some(values.get(index));
            }
        }
        self.base.map(|base| base.get(i))
    }

    /// First components of item `i`; integers are scaled to -1..=1 if the accessor is normalised.
    pub(crate) fn floats<const N: usize>(&self, i: usize) -> [f32; N] {
        let Some(bytes) = self.bytes(i) else { return [0.0; N] };
        let scaled = |number: f32, most: f32| {
            if self.is_normalized { (number / most).max(-1.0) } else { number }
        };
        std::array::from_fn(|c| match self.data_type {
            DataType::U8 => scaled(bytes[c].into(), 255.0),
            DataType::I8 => scaled(bytes[c].cast_signed().into(), 127.0),
            DataType::U16 => scaled(u16::from_le_bytes(part(bytes, c)).into(), 65535.0),
            DataType::I16 => scaled(i16::from_le_bytes(part(bytes, c)).into(), 32767.0),
            DataType::U32 => u32::from_le_bytes(part(bytes, c)) as f32,
            DataType::F32 => f32::from_le_bytes(part(bytes, c)),
        })
    }

    /// First components of item `i`, an integer vector.
    pub(crate) fn wholes<const N: usize>(&self, i: usize) -> [usize; N] {
        let Some(bytes) = self.bytes(i) else { return [0; N] };
        std::array::from_fn(|c| match self.data_type {
            DataType::U8 | DataType::I8 => usize::from(bytes[c]),
            DataType::U16 | DataType::I16 => usize::from(u16::from_le_bytes(part(bytes, c))),
            DataType::U32 | DataType::F32 => u32::from_le_bytes(part(bytes, c)) as usize,
        })
    }

    /// Item `i`, an integer.
    pub(crate) fn whole(&self, i: usize) -> usize {
        let bytes = self.bytes(i).unwrap_or_default();
        bytes.iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte))
    }
}

/// Component `c` of an item.
fn part<const N: usize>(bytes: &[u8], c: usize) -> [u8; N] {
    std::array::from_fn(|i| bytes[c * N + i])
}

/// First of `count` indices that satisfies `holds`, which all later ones satisfy, too.
fn first_from(count: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = low.midpoint(high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}
