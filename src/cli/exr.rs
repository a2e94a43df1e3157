//! Linear light as `OpenEXR`: half floats.
use super::{failure::Failure, layers};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    SpecificChannels, WritableImage as _, f16,
};
use gobo::internals::records::Picture;
use std::{io::Cursor, path::Path};

/// The largest half is 65504: brighter light is white in any case.
fn half(value: f32) -> f16 {
    f16::from_f32(value.min(65504.0))
}

/// Encodes a picture's light, and layers of it, as a whole file; `path` is for errors.
pub(super) fn encode(
    path: &Path,
    picture: &Picture,
    layers: &[layers::Layer],
) -> Result<Vec<u8>, Failure> {
    let [width, height] = picture.size.to_array().map(|side| side as usize);
    let (size, attributes) = ((width, height), LayerAttributes::named("light"));
    let encoding = Encoding::SMALL_LOSSLESS;
    let mut bytes = Cursor::new(Vec::new());
    if layers.is_empty() {
        let pixel = |at: exr::prelude::Vec2<usize>| {
            let [r, g, b] = picture.light[at.y() * width + at.x()].map(half);
            (r, g, b)
        };
        let channels = SpecificChannels::rgb(pixel);
        let image = Image::from_layer(Layer::new(size, attributes, encoding, channels));
        let written = image.write().non_parallel().to_buffered(&mut bytes);
        written.map_err(|error| failure(path, &error))?;
        return Ok(bytes.into_inner());
    }
    let channels_of = |prefix: String, light: &[[f32; 3]]| {
        ["R", "G", "B"]
            .into_iter()
            .enumerate()
            .map(|(channel, name)| {
                let samples = light.iter().map(|pixel| half(pixel[channel])).collect();
                AnyChannel::new(format!("{prefix}{name}").as_str(), FlatSamples::F16(samples))
            })
            .collect::<Vec<_>>()
    };
    let of_layers = layers.iter().flat_map(|(name, light)| channels_of(format!("{name}."), light));
    let channels = channels_of(String::new(), &picture.light).into_iter().chain(of_layers);
    let channels = AnyChannels::sort(channels.collect());
    let image = Image::from_layer(Layer::new(size, attributes, encoding, channels));
    let written = image.write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|error| failure(path, &error))?;
    Ok(bytes.into_inner())
}

fn failure(path: &Path, error: &exr::error::Error) -> Failure {
    Failure::file(path, std::io::Error::other(error.to_string()))
}
