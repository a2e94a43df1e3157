//! Images in KTX2 containers: compressed by Basis Universal (`KHR_texture_basisu`), or bytes of rgb or rgba.
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use image::RgbaImage;
use ruzstd::decoding::StreamingDecoder;
use std::{io::Read as _, panic::catch_unwind};

/// First bytes of a container.
const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Offsets of a header's words \[bytes\] (KTX 2.0, section 3).
const FORMAT: usize = 12;
const SIZE: usize = 20;
const SUPERCOMPRESSION: usize = 44;
const KEYS: usize = 56;
const LEVELS: usize = 80;
/// Mip levels of the largest allowed side.
const MAX_LEVELS: u32 = 16;
/// Largest block of 4 x 4 texels \[bytes\].
const BLOCK: u64 = 16;

pub(super) fn is_container(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Width and height \[texels\]; `None` unless it is one two-dimensional image.
pub(super) fn size(bytes: &[u8]) -> Option<[u32; 2]> {
    let word =
        |index: usize| Some(u32::from_le_bytes(*bytes.get(SIZE + 4 * index..)?.first_chunk()?));
    let [width, height, depth, layers, faces] = [word(0)?, word(1)?, word(2)?, word(3)?, word(4)?];
    (depth == 0 && layers <= 1 && faces == 1).then_some([width, height])
}

/// Channels of a `VkFormat` of bytes; `None` for other formats.
fn channels(format: u32) -> Option<usize> {
    match format {
        // R8G8B8: UNORM, SRGB.
        23 | 29 => Some(3),
        // R8G8B8A8: UNORM, SRGB.
        37 | 43 => Some(4),
        _ => None,
    }
}

/// The largest level of an image of bytes whose size has been checked; `None` for other formats.
fn plain(bytes: &[u8], [width, height]: [u32; 2]) -> Option<Result<RgbaImage, String>> {
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let long = |at: usize| Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let channels = channels(word(FORMAT)?)?;
    let length = channels * width as usize * height as usize;
    let read = || {
        let (start, stored) = (long(LEVELS)?, long(LEVELS + 8)?);
        let start = usize::try_from(start).ok()?;
        let stored = bytes.get(start..start.checked_add(usize::try_from(stored).ok()?)?)?;
        // Grows with the data, whatever the header announces.
        let mut texels = Vec::new();
        match word(SUPERCOMPRESSION)? {
            0 => texels.extend_from_slice(stored),
            2 => {
                let decoder = StreamingDecoder::new(stored).ok()?;
                decoder.take(length as u64 + 1).read_to_end(&mut texels).ok()?;
            }
            3 => {
                let decoder = flate2::read::ZlibDecoder::new(stored);
                decoder.take(length as u64 + 1).read_to_end(&mut texels).ok()?;
            }
            _ => return None,
        }
        (texels.len() == length).then_some(())?;
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        for texel in texels.chunks_exact(channels) {
            rgba.extend([texel[0], texel[1], texel[2], texel.get(3).copied().unwrap_or(255)]);
        }
        RgbaImage::from_raw(width, height, rgba)
    };
    Some(read().ok_or_else(|| "the texels of its KTX2 container are damaged or cut off".to_owned()))
}

/// Decodes the largest level, whose size has been checked.
pub(super) fn decode(bytes: &[u8]) -> Result<RgbaImage, String> {
    let damaged = || "the KTX2 container is damaged or not one flat image".to_owned();
    let [width, height] = size(bytes).ok_or_else(damaged)?;
    if let Some(image) = plain(bytes, [width, height]) {
        return image;
    }
    let levels = bytes.get(SIZE + 20..).and_then(<[u8]>::first_chunk).ok_or_else(damaged)?;
    let levels = u32::from_le_bytes(*levels).max(1);
    // The decoder allocates any size that a level announces.
    let most = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4)) * BLOCK;
    let is_sound = |level: u32| {
        let announced = bytes.get(LEVELS + 24 * level as usize + 16..)?.first_chunk()?;
        (u64::from_le_bytes(*announced) <= most).then_some(())
    };
    if levels > MAX_LEVELS || (0..levels).any(|level| is_sound(level).is_none()) {
        return Err(damaged());
    }
    // Keys are not needed, and the decoder panics at damaged ones.
    let mut bytes = bytes.to_vec();
    bytes[KEYS..KEYS + 8].fill(0);
    // The decoder also panics at incomplete code tables; the panic is caught where panics unwind.
    let texels = catch_unwind(|| {
        Transcoder::new(&bytes)?.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
    });
    let texels = texels.map_err(|_| damaged())?;
    let texels = texels.map_err(|error| format!("its KTX2 container is damaged: {error:?}"))?;
    RgbaImage::from_raw(width, height, texels).ok_or_else(damaged)
}
