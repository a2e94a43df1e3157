//! Images in KTX2 containers, compressed by Basis Universal (`KHR_texture_basisu`).
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use image::RgbaImage;

/// First bytes of a container.
const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Offsets of a header's words [bytes] (KTX 2.0, section 3).
const SIZE: usize = 20;
const KEYS: usize = 56;
const LEVELS: usize = 80;
/// Levels of the largest side that an image may have.
const MAX_LEVELS: u32 = 16;
/// Largest block of 4 x 4 texels [bytes].
const BLOCK: u64 = 16;

pub(super) fn is_container(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Width and height [texels]; `None` unless it is one flat image.
pub(super) fn size(bytes: &[u8]) -> Option<[u32; 2]> {
    let word =
        |index: usize| Some(u32::from_le_bytes(*bytes.get(SIZE + 4 * index..)?.first_chunk()?));
    let [width, height, depth, layers, faces] = [word(0)?, word(1)?, word(2)?, word(3)?, word(4)?];
    (depth == 0 && layers <= 1 && faces == 1).then_some([width, height])
}

/// Decodes the largest level, whose size has been checked.
pub(super) fn decode(bytes: &[u8]) -> Result<RgbaImage, String> {
    let damaged = || "the KTX2 container is damaged or not one flat image".to_owned();
    let [width, height] = size(bytes).ok_or_else(damaged)?;
    let levels = bytes.get(SIZE + 20..).and_then(<[u8]>::first_chunk).ok_or_else(damaged)?;
    let levels = u32::from_le_bytes(*levels).max(1);
    // The decoder allocates whatever size a level announces.
    let most = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4)) * BLOCK;
    let is_sound = |level: u32| {
        let announced = bytes.get(LEVELS + 24 * level as usize + 16..)?.first_chunk()?;
        (u64::from_le_bytes(*announced) <= most).then_some(())
    };
    if levels > MAX_LEVELS || (0..levels).any(|level| is_sound(level).is_none()) {
        return Err(damaged());
    }
    // Keys are not needed, and damaged ones are a panic there.
    let mut bytes = bytes.to_vec();
    bytes[KEYS..KEYS + 8].fill(0);
    let problem = |error: basisu::Error| format!("its KTX2 container is damaged: {error:?}");
    let texture = Transcoder::new(&bytes).map_err(problem)?;
    let texels = texture.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(problem)?;
    RgbaImage::from_raw(width, height, texels).ok_or_else(damaged)
}
