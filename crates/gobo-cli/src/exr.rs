//! Linear light as `OpenEXR`, and layers of it.
use super::failure::Failure;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, LayerAttributes, WritableImage as _, f16,
};
use gobo::records::Picture;
use std::{io::Cursor, path::Path};

/// A channel of a file: its name, and a sample for each pixel.
pub(super) type Channel = AnyChannel<FlatSamples>;

/// A channel of light or colour, as half floats. The largest half is 65504: brighter light is white in any
/// case.
pub(super) fn half_channel(name: &str, samples: impl Iterator<Item = f32>) -> Channel {
    let half = |value: f32| f16::from_f32(value.min(65504.0));
    AnyChannel::new(name, FlatSamples::F16(samples.map(half).collect()))
}

/// A channel of data, as 32-bit floats.
pub(super) fn full_channel(name: &str, samples: impl Iterator<Item = f32>) -> Channel {
    AnyChannel::new(name, FlatSamples::F32(samples.collect()))
}

/// Channels R, G and B of linear rgb; `layer`: the layer's name and a dot, or nothing.
pub(super) fn rgb_channels(layer: &str, rgb: &[[f32; 3]]) -> [Channel; 3] {
    [(0, "R"), (1, "G"), (2, "B")].map(|(channel, name)| {
        half_channel(&format!("{layer}{name}"), rgb.iter().map(|pixel| pixel[channel]))
    })
}

/// Encodes a picture's light, and further channels, as a whole file; `path` is for errors.
pub(super) fn encode(
    path: &Path,
    picture: &Picture,
    beside: &[Channel],
) -> Result<Vec<u8>, Failure> {
    let [width, height] = picture.size.to_array().map(|side| side as usize);
    let (size, attributes) = ((width, height), LayerAttributes::named("light"));
    let light = rgb_channels("", &picture.light);
    let channels = AnyChannels::sort(light.into_iter().chain(beside.iter().cloned()).collect());
    let layer = exr::prelude::Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|error| Failure::file(path, std::io::Error::other(error.to_string())))?;
    Ok(bytes.into_inner())
}
