//! SPZ (Niantic): versions 1 to 3 are one gzip stream, version 4 has a plain header and a zstd stream per
//! attribute. x is right, y up, z back.
use super::{
    cloud::{HARMONIC, SplatCloud, word},
    harmonics::Harmonics,
    packed::smallest_three,
};
use crate::{error::Fault, limits::Limit};
use flate2::read::MultiGzDecoder;
use glam::{Quat, Vec3};
use gobo::model::Gaussian;
use half::f16;
use ruzstd::decoding::StreamingDecoder;
use std::io::{self, Read};

const MAGIC: [u8; 4] = *b"NGSP";

/// Length of the header of versions 1 to 3, and of version 4 \[bytes\].
const HEADER: usize = 16;
const HEADER_4: usize = 32;

/// Length of an entry in the list of streams: compressed and plain length \[bytes\].
const ENTRY: usize = 16;

/// Scale of coefficients: a byte stores 0.5 + this * the coefficient.
pub(super) const COLOR_SCALE: f32 = 0.15;

/// Byte of a coefficient 0 of higher harmonics, and bytes per 1.
pub(super) const SH_ZERO: f32 = 128.0;
pub(super) const SH_STEPS: f32 = 128.0;

/// Extensions of a file are shorter than this \[bytes\].
const MOST_BEHIND: u64 = 1 << 26;

const DAMAGED: &str = "the file is cut off or damaged: write it again";

/// Names of the attributes in messages, in the order of the file.
const NAMES: [&str; 6] =
    ["positions", "alphas", "colours", "scales", "rotations", "spherical harmonics"];

/// Index of higher harmonics in [`NAMES`].
const HIGHER: usize = 5;

#[derive(Clone, Copy, Debug)]
struct SpzHeader {
    version: u32,
    count: usize,
    degree: u8,
    /// Fractional bits of a coordinate.
    fraction: u8,
}

impl SpzHeader {
    fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        if bytes.len() < HEADER || bytes[..4] != MAGIC {
            return Err(("this is no SPZ file: it does not start with NGSP".to_owned(), DAMAGED));
        }
        let [version, count] = [1, 2].map(|i| u32::from_le_bytes(word(bytes, i)));
        let [degree, fraction, ..] = word(bytes, 3);
        if !(1..=4).contains(&version) {
            return Err((format!("is SPZ version {version}"), "gobo reads versions 1 to 4"));
        }
        if degree > 4 || fraction > 24 {
            let message = format!(
                "spherical harmonics of degree {degree}, coordinates with {fraction} bits of fraction"
            );
            return Err((message, DAMAGED));
        }
        Limit::Splats.grown(0, count.into())?;
        Ok(Self { version, count: count as usize, degree, fraction })
    }

    /// Bytes per splat of an attribute, by its index in [`NAMES`].
    fn size(self, attribute: usize) -> usize {
        let position = if self.version == 1 { 6 } else { 9 };
        let rotation = if self.version < 3 { 3 } else { 4 };
        [position, 1, 3, 3, rotation, 3 * self.harmonics()][attribute]
    }

    /// Coefficients of higher harmonics per channel.
    fn harmonics(self) -> usize {
        (usize::from(self.degree) + 1).pow(2) - 1
    }
}

pub(super) fn is_spz(bytes: &[u8]) -> bool {
    let mut start = [0; 4];
    bytes.starts_with(&MAGIC)
        || bytes.starts_with(&[0x1f, 0x8b])
            && MultiGzDecoder::new(bytes).read_exact(&mut start).is_ok()
            && start == MAGIC
}

/// Number of splats that a header announces.
pub(super) fn announced(start: &[u8]) -> Option<u64> {
    let mut head = [0; HEADER];
    if start.starts_with(&MAGIC) {
        head.copy_from_slice(start.get(..HEADER)?);
    } else {
        MultiGzDecoder::new(start).read_exact(&mut head).ok()?;
    }
    Some(u32::from_le_bytes(word(&head, 2)).into())
}

/// The splats of a file, decoded on demand.
pub(crate) struct Spz {
    header: SpzHeader,
    attributes: Attributes,
}

impl Spz {
    pub(crate) fn open(bytes: &[u8]) -> Result<Self, Fault> {
        Self::open_as(bytes, false)
    }

    /// With the coefficients of higher harmonics, too.
    pub(crate) fn open_whole(bytes: &[u8]) -> Result<Self, Fault> {
        Self::open_as(bytes, true)
    }

    fn open_as(bytes: &[u8], is_whole: bool) -> Result<Self, Fault> {
        let open = if bytes.starts_with(&MAGIC) { streams } else { gzip };
        let (header, attributes) = open(bytes, is_whole)?;
        Ok(Self { header, attributes })
    }

    pub(crate) fn count(&self) -> usize {
        self.header.count
    }

    /// Coefficients of higher harmonics per channel.
    pub(crate) fn harmonics(&self) -> usize {
        self.header.harmonics()
    }

    pub(crate) fn splat(&self, i: usize) -> Gaussian {
        let [positions, alphas, colors, scales, rotations, _] = &self.attributes;
        let three = |bytes: &[u8]| Vec3::from_array([0, 1, 2].map(|k| bytes[3 * i + k].into()));
        let coefficient = (three(colors) / 255.0 - Vec3::splat(0.5)) / COLOR_SCALE;
        Gaussian {
            center: position(self.header, positions, i),
            rotation: rotation(self.header, rotations, i),
            sigma: (three(scales) / 16.0 - Vec3::splat(10.0)).exp(),
            opacity: f32::from(alphas[i]) / 255.0,
            color: Vec3::splat(0.5) + HARMONIC * coefficient,
            ..Gaussian::default()
        }
    }
}

impl Spz {
    /// Coefficients of all splats of a file that was opened whole.
    pub(crate) fn all_harmonics(&self) -> Result<Harmonics, Fault> {
        let mut all = Harmonics::with_room(self.harmonics(), self.count() as u64)?;
        let plain = |byte: u8| (f32::from(byte) - SH_ZERO) / SH_STEPS;
        let triples = self.attributes[HIGHER].as_chunks::<3>().0;
        all.coefficients.extend(triples.iter().map(|rgb| rgb.map(plain)));
        Ok(all)
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<SplatCloud, Fault> {
    let file = Spz::open(bytes)?;
    let mut cloud = SplatCloud::with_room(file.count() as u64)?;
    for i in 0..file.count() {
        cloud.push(file.splat(i));
    }
    cloud.leave_out_harmonics(file.harmonics());
    Ok(cloud.finish())
}

fn position(header: SpzHeader, bytes: &[u8], i: usize) -> Vec3 {
    let part = |k: usize| {
        if header.version == 1 {
            let start = 6 * i + 2 * k;
            return f16::from_le_bytes([bytes[start], bytes[start + 1]]).to_f32();
        }
        let start = 9 * i + 3 * k;
        let fixed = i32::from_le_bytes([0, bytes[start], bytes[start + 1], bytes[start + 2]]) >> 8;
        fixed as f32 / (1 << header.fraction) as f32
    };
    Vec3::from_array([0, 1, 2].map(part))
}

fn rotation(header: SpzHeader, bytes: &[u8], i: usize) -> Quat {
    if header.version < 3 {
        let [x, y, z] = [0, 1, 2].map(|k| f32::from(bytes[3 * i + k]) / 127.5 - 1.0);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        return Quat::from_xyzw(x, y, z, w);
    }
    // From the top: index of the largest part of x y z w, then the others, a sign and nine bits each, the
    // last one lowest.
    let packed = u32::from_le_bytes(word(bytes, i));
    let part = |shift: u32| {
        let size = (packed >> shift & 511) as f32 / 511.0 * std::f32::consts::FRAC_1_SQRT_2;
        if packed >> (shift + 9) & 1 == 1 { -size } else { size }
    };
    // `smallest_three` has the order w x y z.
    let q = smallest_three([20, 10, 0].map(part), (packed >> 30) as usize);
    Quat::from_xyzw(q.w, q.x, q.y, q.z)
}

/// Bytes of each attribute; none of harmonics unless the file is opened whole.
type Attributes = [Vec<u8>; 6];

/// Reads exactly `length` bytes.
fn exactly(from: &mut impl Read, length: usize, name: &str) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    let read = from.take(length as u64).read_to_end(&mut bytes);
    read.map_err(|error| (format!("the {name} cannot be read: {error}"), DAMAGED))?;
    if bytes.len() == length {
        return Ok(bytes);
    }
    Err((format!("the file ends in the {name}: {} of {length} bytes", bytes.len()), DAMAGED))
}

/// Skips exactly `length` bytes.
fn pass(from: &mut impl Read, length: usize, name: &str) -> Result<(), Fault> {
    let passed = io::copy(&mut from.take(length as u64), &mut io::sink())
        .map_err(|error| (format!("the {name} cannot be read: {error}"), DAMAGED))?;
    if passed == length as u64 {
        return Ok(());
    }
    Err((format!("the file ends in the {name}: {passed} of {length} bytes"), DAMAGED))
}

/// Versions 1 to 3.
fn gzip(bytes: &[u8], is_whole: bool) -> Result<(SpzHeader, Attributes), Fault> {
    let mut plain = MultiGzDecoder::new(bytes);
    let header = SpzHeader::parse(&exactly(&mut plain, HEADER, "header")?)?;
    if header.version > 3 {
        let message = "is SPZ version 4 inside gzip";
        return Err((message.to_owned(), "write version 4 without gzip around it"));
    }
    let mut attributes = Attributes::default();
    for (i, attribute) in attributes.iter_mut().enumerate() {
        let size = header.count * header.size(i);
        if i < HIGHER || is_whole {
            *attribute = exactly(&mut plain, size, NAMES[i])?;
        } else {
            pass(&mut plain, size, NAMES[i])?;
        }
    }
    // Extensions, and the checksum of the whole.
    io::copy(&mut plain.take(MOST_BEHIND), &mut io::sink())
        .map_err(|error| (format!("the end of the file cannot be read: {error}"), DAMAGED))?;
    Ok((header, attributes))
}

/// Version 4.
fn streams(bytes: &[u8], is_whole: bool) -> Result<(SpzHeader, Attributes), Fault> {
    let header = SpzHeader::parse(bytes)?;
    if header.version < 4 {
        let message = format!("is SPZ version {} without gzip", header.version);
        return Err((message, "compress it by gzip, as its version says"));
    }
    let ends = || ("the file ends in its list of streams".to_owned(), DAMAGED);
    if bytes.len() < HEADER_4 {
        return Err(ends());
    }
    let stream_count = usize::from(bytes[HEADER - 1]);
    if stream_count != 6 && !(stream_count == 5 && header.degree == 0) {
        let message = format!("{stream_count} streams, not 6");
        return Err((message, DAMAGED));
    }
    let start = u32::from_le_bytes(word(bytes, 4)) as usize;
    let list = bytes.get(start.max(HEADER_4)..).ok_or_else(ends)?;
    let (entries, mut rest) = list.split_at_checked(stream_count * ENTRY).ok_or_else(ends)?;
    let mut attributes = Attributes::default();
    for (i, name) in NAMES.into_iter().enumerate().take(stream_count) {
        let length = |at: usize| {
            let number = entries[ENTRY * i + at..].first_chunk().copied().unwrap_or_default();
            usize::try_from(u64::from_le_bytes(number)).unwrap_or(usize::MAX)
        };
        let size = header.count * header.size(i);
        if length(8) != size {
            let message = format!("the {name} have {} bytes, not {size}", length(8));
            return Err((message, DAMAGED));
        }
        let cut = || (format!("the file ends in the {name}"), DAMAGED);
        let (packed, behind) = rest.split_at_checked(length(0)).ok_or_else(cut)?;
        rest = behind;
        if size == 0 {
            continue;
        }
        let bad = |error| (format!("the {name} cannot be read: {error}"), DAMAGED);
        let mut plain = StreamingDecoder::new(packed).map_err(bad)?;
        if i < HIGHER || is_whole {
            attributes[i] = exactly(&mut plain, size, name)?;
        } else {
            pass(&mut plain, size, name)?;
        }
    }
    Ok((header, attributes))
}
