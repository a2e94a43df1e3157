//! NIfTI-1, with its data inside or in another file, compressed or not: Cox et al. 2004, `nifti1.h`.
use super::{
    array::{Axis, Layout, Number},
    file::{DenseFile, bytes_beside},
    packed::{Packing, unpacked},
    space::{BodyAxes, Place},
    voxels::Dense,
};
use crate::vdb::VolumeFault;
use flate2::read::MultiGzDecoder;
use glam::{DQuat, DVec3};
use std::{
    io::Read as _,
    path::{Path, PathBuf},
};

/// Length of the header \[bytes\].
const HEADER: usize = 348;
const MAGIC: usize = 344;
const GZIP: &[u8] = &[0x1f, 0x8b];

pub(super) fn is(head: &[u8]) -> bool {
    let mut first = Vec::new();
    if head.starts_with(GZIP) {
        // A truncated head unpacks as far as it goes.
        let _ = MultiGzDecoder::new(head).take(HEADER as u64).read_to_end(&mut first);
    }
    NiftiHeader::of(if first.is_empty() { head } else { &first }).is_some()
}

pub(super) fn named(head: &[u8], path: &Path) -> Option<PathBuf> {
    NiftiHeader::of(head)?.is_beside().then(|| path.with_extension("img"))
}

/// The header; its first number tells the byte order.
struct NiftiHeader<'a> {
    bytes: &'a [u8],
    is_big: bool,
}

impl<'a> NiftiHeader<'a> {
    fn of(bytes: &'a [u8]) -> Option<Self> {
        let bytes = bytes.get(..HEADER)?;
        let is_known = |magic: &[u8]| magic == b"n+1\0" || magic == b"ni1\0";
        let length = |is_big| Self { bytes, is_big }.i32(0);
        let is_big = [false, true].into_iter().find(|&is_big| length(is_big) == HEADER as i32)?;
        is_known(&bytes[MAGIC..]).then_some(Self { bytes, is_big })
    }

    /// Whether the data are in a file of their own.
    fn is_beside(&self) -> bool {
        self.bytes[MAGIC + 1] == b'i'
    }

    fn number<const N: usize>(&self, at: usize) -> [u8; N] {
        std::array::from_fn(|i| self.bytes[at + if self.is_big { N - 1 - i } else { i }])
    }

    fn i16(&self, at: usize) -> i16 {
        i16::from_le_bytes(self.number(at))
    }

    fn i32(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.number(at))
    }

    fn f32(&self, at: usize) -> f64 {
        f64::from(f32::from_le_bytes(self.number(at)))
    }

    fn vector(&self, at: usize) -> DVec3 {
        DVec3::new(self.f32(at), self.f32(at + 4), self.f32(at + 8))
    }

    fn layout(&self) -> Result<Layout, VolumeFault> {
        let count = self.i16(40);
        if !(1..=7).contains(&count) {
            return Err(VolumeFault::damaged(format!(
                "the header has {count} dimensions, of 1 to 7"
            )));
        }
        let (number, channels) = match self.i16(70) {
            2 => (Number::U8, 1),
            4 => (Number::I16, 1),
            8 => (Number::I32, 1),
            16 => (Number::F32, 1),
            64 => (Number::F64, 1),
            128 => (Number::U8, 3),
            256 => (Number::I8, 1),
            512 => (Number::U16, 1),
            768 => (Number::U32, 1),
            1024 => (Number::I64, 1),
            1280 => (Number::U64, 1),
            2304 => (Number::U8, 4),
            kind => {
                let message = format!("its voxels are of the data type {kind}");
                return Err(VolumeFault::new(message, "write whole numbers, floats or doubles"));
            }
        };
        let mut axes = vec![(channels, Axis::Channel)];
        let space = Axis::SPACE.into_iter().chain(std::iter::repeat(Axis::Other));
        for (i, axis) in (0..count).zip(space) {
            let length = self.i16(42 + 2 * i as usize);
            let wrong = || VolumeFault::damaged(format!("{length} voxels along an axis"));
            axes.push((u64::try_from(length).map_err(|_| wrong())?, axis));
        }
        Layout::new(number, self.is_big, &axes)
    }

    /// By method 3, 2 or 1 of the header's description.
    fn place(&self) -> Place {
        let [qform, sform] = [252, 254].map(|at| self.i16(at));
        // Some programs write lengths of 0 or less.
        let length = |i: usize| Some(self.f32(76 + 4 * i).abs()).filter(|&length| length > 0.0);
        let lengths = [1, 2, 3].map(|i| length(i).unwrap_or(1.0));
        let mut place = if sform > 0 {
            let rows = [280, 296, 312];
            let column = |i: usize| {
                let [x, y, z] = rows.map(|row| self.f32(row + 4 * i));
                DVec3::new(x, y, z)
            };
            Place::new([column(0), column(1), column(2)], column(3))
        } else if qform > 0 {
            let axis = self.vector(256);
            let real = (1.0 - axis.length_squared()).max(0.0).sqrt();
            let turn = DQuat::from_xyzw(axis.x, axis.y, axis.z, real);
            let turn = if turn.length() > 0.0 { turn.normalize() } else { turn };
            let side = if self.f32(76) < 0.0 { -1.0 } else { 1.0 };
            let [x, y, z] = lengths;
            let axes = [DVec3::X * x, DVec3::Y * y, DVec3::Z * z * side].map(|axis| turn * axis);
            Place::new(axes, self.vector(268))
        } else {
            let [x, y, z] = lengths;
            Place::new([DVec3::X * x, DVec3::Y * y, DVec3::Z * z], DVec3::ZERO)
        };
        place.body = (sform > 0 || qform > 0).then_some(BodyAxes::RightFront);
        place.unit = match self.bytes[123] & 7 {
            1 => Some(1.0),
            2 => Some(1e-3),
            3 => Some(1e-6),
            _ => None,
        };
        place
    }
}

pub(super) fn read(file: &mut DenseFile<'_>) -> Result<Dense, VolumeFault> {
    file.has_one_array()?;
    let bytes = std::mem::take(&mut file.bytes);
    let is_packed = bytes.starts_with(GZIP);
    let head = if is_packed { unpacked(Packing::Gzip, &bytes, HEADER)? } else { Vec::new() };
    let header = NiftiHeader::of(if is_packed { &head } else { &bytes });
    let header = header.ok_or_else(|| VolumeFault::damaged("the header of NIfTI-1 is cut off"))?;
    let layout = header.layout()?;
    let start = header.f32(108);
    let start = if start.is_finite() { start.clamp(0.0, 1e9) as usize } else { 0 };
    let (place, slope) = (header.place(), [header.f32(112), header.f32(116)]);
    let data = if header.is_beside() {
        let name = file.path.with_extension("img");
        let name = name.file_name().unwrap_or_default().to_string_lossy();
        let mut data = bytes_beside(file.path, &name)?;
        data.drain(..start.min(data.len()));
        data
    } else {
        let start = start.max(HEADER);
        let mut data = if is_packed {
            unpacked(Packing::Gzip, &bytes, layout.bytes().saturating_add(start))?
        } else {
            bytes
        };
        data.drain(..start.min(data.len()));
        data
    };
    let is_scaled = layout.channels == 1 && slope[0] != 0.0 && slope.iter().all(|v| v.is_finite());
    let mut dense = Dense::new(data, layout, place)?;
    if is_scaled {
        dense.scale = slope;
    }
    Ok(dense)
}
