//! Images of untrusted files: their size is checked before they are decoded, as a few bytes may announce
//! gigabytes.
use super::{
    ktx2,
    limits::{self, Limit},
    read,
};
use image::{DynamicImage, ImageDecoder as _, ImageReader, RgbaImage};
use std::{
    io::{BufRead, Cursor, Seek},
    path::Path,
};

/// The problem and the remedy.
pub(super) type ImageFault = (String, String);

/// Width and height of an image \[texels\], from its head; `None` if it is no image, or has a side longer
/// than `most`.
pub(super) fn size(bytes: &[u8], most: u32) -> Option<[u32; 2]> {
    if ktx2::is_container(bytes) {
        return ktx2::size(bytes).filter(|size| size.iter().all(|&side| side <= most));
    }
    check_header(bytes, bytes.len() as u64).ok()?;
    size_of(Cursor::new(bytes), most)
}

/// Like [`size`], of a file.
pub(super) fn size_of_file(path: &Path, most: u32) -> Option<[u32; 2]> {
    let (head, length) = read::head(path, MAX_HEADER).ok()?;
    check_header(&head, length).ok()?;
    size_of(read::open(path).ok()?, most)
}

/// Longest header of a Radiance image, with the line of its size \[bytes\]. Programs write a few hundred
/// bytes.
const MAX_HEADER: u64 = 1 << 16;

/// Refuses a long header of a Radiance image: the decoder keeps all its lines. `start`: first bytes of a file
/// of `length` bytes, more than the longest header if the file has more.
pub(super) fn check_header(start: &[u8], length: u64) -> Result<(), String> {
    if length <= MAX_HEADER || !start.starts_with(b"#?") {
        return Ok(());
    }
    let start = &start[..start.len().min(MAX_HEADER as usize)];
    let mut lines = start.split_inclusive(|&byte| byte == b'\n');
    let ends = lines.any(|line| line == b"\n" || line == b"\r\n");
    let size = ends.then(|| lines.next()).flatten();
    match size {
        Some(line) if line.ends_with(b"\n") => Ok(()),
        _ => Err(format!("its header has more than {MAX_HEADER} bytes")),
    }
}

fn size_of(contents: impl BufRead + Seek, most: u32) -> Option<[u32; 2]> {
    let reader = ImageReader::new(contents).with_guessed_format().ok()?;
    let (width, height) = reader.into_dimensions().ok()?;
    (width <= most && height <= most).then_some([width, height])
}

/// Decodes an image. `most`: longest side \[texels\]; `texels`: sum over all textures so far, to which the
/// image's are added.
pub(super) fn decode(bytes: &[u8], most: u32, texels: &mut u64) -> Result<RgbaImage, ImageFault> {
    let help = || format!("use a PNG, JPEG, WebP or KTX2 of at most {most} texels a side");
    let bad = |error: &dyn std::fmt::Display| (error.to_string(), help());
    if ktx2::is_container(bytes) {
        let size = ktx2::size(bytes).ok_or_else(|| bad(&"it is not one flat image"))?;
        let all = admitted(size, 0, most, *texels, help)?;
        let image = ktx2::decode(bytes).map_err(|error| bad(&error))?;
        *texels = all;
        return Ok(image);
    }
    check_header(bytes, bytes.len() as u64).map_err(|message| bad(&message))?;
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let decoder =
        reader.map_err(|error| bad(&error))?.into_decoder().map_err(|error| bad(&error))?;
    let size = decoder.dimensions().into();
    let all = admitted(size, decoder.total_bytes(), most, *texels, help)?;
    let image = DynamicImage::from_decoder(decoder).map_err(|error| bad(&error))?;
    *texels = all;
    Ok(image.into_rgba8())
}

/// Sum of an image's texels and those so far, if it may be decoded. `stored`: bytes of the encoded image.
fn admitted(
    [width, height]: [u32; 2],
    stored: u64,
    most: u32,
    texels: u64,
    help: impl Fn() -> String,
) -> Result<u64, ImageFault> {
    if width > most || height > most {
        return Err((format!("the image has {width} x {height} texels"), help()));
    }
    if width == 0 || height == 0 {
        return Err(("the image has no texels".to_owned(), help()));
    }
    let all = Limit::Texels.grown(texels, u64::from(width) * u64::from(height));
    let all = all.map_err(|(message, help)| (message, help.to_owned()))?;
    // The encoded image, and its decoded bytes.
    let bytes = stored + 4 * u64::from(width) * u64::from(height);
    if !limits::has_memory(bytes) {
        let message = format!("no memory for {width} x {height} texels ({} MiB)", bytes >> 20);
        return Err((message, "use smaller images, or a machine with more memory".to_owned()));
    }
    Ok(all)
}
