//! Linear light as `OpenEXR`: half floats.
use super::failure::Failure;
use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage as _, f16,
};
use gobo::internals::records::Picture;
use std::{io::Cursor, path::Path};

/// Encodes a picture's light as a whole file; `path` is for errors.
pub(super) fn encode(path: &Path, picture: &Picture) -> Result<Vec<u8>, Failure> {
    let [width, height] = picture.size.to_array().map(|side| side as usize);
    let pixel = |at: exr::prelude::Vec2<usize>| {
        // The largest half is 65504: brighter light is white in any case.
        let [r, g, b] =
            picture.light[at.y() * width + at.x()].map(|v| f16::from_f32(v.min(65504.0)));
        (r, g, b)
    };
    let layer = Layer::new(
        (width, height),
        LayerAttributes::named("light"),
        Encoding::SMALL_LOSSLESS,
        SpecificChannels::rgb(pixel),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|error| Failure::file(path, std::io::Error::other(error.to_string())))?;
    Ok(bytes.into_inner())
}
