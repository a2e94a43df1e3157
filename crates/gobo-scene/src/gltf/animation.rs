//! Keys of glTF nodes.
use super::file::GltfFile;
use crate::{
    SceneError,
    limits::Limit,
    track::{Mode, Track},
};
use ::gltf::{
    Accessor,
    accessor::{DataType, Dimensions},
    animation::{Interpolation, Property},
};
use glam::Vec4;
use std::collections::HashMap;

/// Tracks of a node.
#[derive(Debug, Default)]
pub(crate) struct NodeTracks {
    /// Tracks of translation, rotation and scale.
    pub(crate) transform: [Option<Track>; 3],
    /// Weights of the mesh's morph targets.
    pub(crate) weights: Vec<Track>,
}

/// Tracks of the file's first animation, by node.
pub(crate) fn tracks(file: &mut GltfFile) -> Result<HashMap<usize, NodeTracks>, SceneError> {
    let mut tracks: HashMap<usize, NodeTracks> = HashMap::new();
    let Some(animation) = file.document.animations().next() else { return Ok(tracks) };
    let mut keys = 0;
    for channel in animation.channels() {
        let transform = match channel.target().property() {
            Property::Translation => 0,
            Property::Rotation => 1,
            Property::Scale => 2,
            Property::MorphTargetWeights => WEIGHTS,
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
        for accessor in [sampler.input(), sampler.output()] {
            keys = Limit::Keys.grown_in(&file.path, keys, accessor.count() as u64)?;
        }
        let times = read(file, &sampler.input(), Dimensions::Scalar)?.ok_or_else(damaged)?;
        let kind = match transform {
            1 => Dimensions::Vec4,
            WEIGHTS => Dimensions::Scalar,
            _ => Dimensions::Vec3,
        };
        let values = read(file, &sampler.output(), kind)?.ok_or_else(damaged)?;
        let times: Vec<f32> = times.into_iter().map(|time| time.x).collect();
        let node_tracks = tracks.entry(node).or_default();
        if transform != WEIGHTS {
            node_tracks.transform[transform] =
                Some(Track::new(times, values, mode).ok_or_else(damaged)?);
            continue;
        }
        // All weights of a key are contiguous.
        let rows = times.len() * if mode == Mode::Cubic { 3 } else { 1 };
        if rows == 0 || values.is_empty() || values.len() % rows != 0 {
            return Err(damaged());
        }
        let count = values.len() / rows;
        for target in 0..count {
            let own_values = values.iter().skip(target).step_by(count).copied().collect();
            let track = Track::new(times.clone(), own_values, mode);
            node_tracks.weights.push(track.ok_or_else(damaged)?);
        }
    }
    let count = file.document.animations().count();
    let path = file.path.display().to_string();
    if count > 1 {
        file.notes.push(format!("{path}: of its {count} animations the first is played"));
    }
    Ok(tracks)
}

/// Index of the morph targets' weights among the properties.
const WEIGHTS: usize = 3;

/// Values of an accessor; `None` if its items have another type.
fn read(
    file: &GltfFile,
    accessor: &Accessor<'_>,
    dimensions: Dimensions,
) -> Result<Option<Vec<Vec4>>, SceneError> {
    let is_whole =
        matches!(accessor.data_type(), DataType::I8 | DataType::U8 | DataType::I16 | DataType::U16);
    let is_known =
        accessor.data_type() == DataType::F32 || is_whole && dimensions != Dimensions::Vec3;
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
