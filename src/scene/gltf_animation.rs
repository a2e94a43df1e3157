//! Keys of glTF nodes.
use super::{
    SceneError,
    gltf_file::File,
    track::{Mode, Track},
};
use ::gltf::{
    Accessor,
    accessor::{DataType, Dimensions},
    animation::{Interpolation, Property},
};
use glam::Vec4;
use std::collections::HashMap;

/// Translation, rotation and scale of a node.
pub(super) type NodeTracks = [Option<Track>; 3];

/// Of the file's first animation, by node.
pub(super) fn tracks(file: &mut File) -> Result<HashMap<usize, NodeTracks>, SceneError> {
    let mut tracks: HashMap<usize, NodeTracks> = HashMap::new();
    let Some(animation) = file.document.animations().next() else { return Ok(tracks) };
    let mut has_weights = false;
    for channel in animation.channels() {
        let place = match channel.target().property() {
            Property::Translation => 0,
            Property::Rotation => 1,
            Property::Scale => 2,
            Property::MorphTargetWeights => {
                has_weights = true;
                continue;
            }
        };
        let sampler = channel.sampler();
        let mode = match sampler.interpolation() {
            Interpolation::Step => Mode::Step,
            Interpolation::Linear => Mode::Linear,
            Interpolation::CubicSpline => Mode::Cubic,
        };
        let node = channel.target().node().index();
        let damaged = || {
            let message =
                format!("keys of node {node} are missing, of another type or out of order");
            file.invalid(message, "export the file again")
        };
        let times = read(file, &sampler.input(), Dimensions::Scalar)?.ok_or_else(damaged)?;
        let kind = if place == 1 { Dimensions::Vec4 } else { Dimensions::Vec3 };
        let values = read(file, &sampler.output(), kind)?.ok_or_else(damaged)?;
        let times = times.into_iter().map(|time| time.x).collect();
        let track = Track::new(times, values, mode).ok_or_else(damaged)?;
        tracks.entry(node).or_default()[place] = Some(track);
    }
    let count = file.document.animations().count();
    let path = file.path.display().to_string();
    if count > 1 {
        file.notes.push(format!("{path}: of its {count} animations the first is played"));
    }
    if has_weights {
        file.notes.push(format!("{path}: morph targets stay as they are"));
    }
    Ok(tracks)
}

/// `None` where items are of another type.
fn read(
    file: &File,
    accessor: &Accessor<'_>,
    dimensions: Dimensions,
) -> Result<Option<Vec<Vec4>>, SceneError> {
    let is_whole =
        matches!(accessor.data_type(), DataType::I8 | DataType::U8 | DataType::I16 | DataType::U16);
    let is_known =
        accessor.data_type() == DataType::F32 || is_whole && dimensions == Dimensions::Vec4;
    if accessor.dimensions() != dimensions || !is_known {
        return Ok(None);
    }
    file.check(accessor, accessor.size())?;
    let items = file.items(accessor)?;
    let item = |i: usize| match dimensions {
        Dimensions::Scalar => {
            let [x] = items.floats(i);
            Vec4::new(x, 0.0, 0.0, 0.0)
        }
        Dimensions::Vec4 => Vec4::from_array(items.floats(i)),
        _ => {
            let [x, y, z] = items.floats(i);
            Vec4::new(x, y, z, 0.0)
        }
    };
    Ok(Some((0..items.count).map(item).collect()))
}
