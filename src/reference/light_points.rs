//! Twin of `wgsl/shade/answer_shares.wgsl`: share of each light that reaches points of the host.
use super::{shading::Lighting, threads::each};
use crate::{
    model::{ReceiverPoint, Scene, View},
    records::ViewMaps,
};

/// Points per work item of a thread.
const RUN: usize = 1024;

/// Shares in linear rgb, point by point, light by light; `maps` of `views`: the shadow views of the scene's
/// lights.
pub fn light_points(
    scene: &Scene,
    views: &[View],
    maps: &[ViewMaps],
    points: &[ReceiverPoint],
) -> Vec<[f32; 3]> {
    let lighting = Lighting::new(scene, views, maps);
    let shares = |point| lighting.lights().iter().map(move |light| (light, point));
    let runs: Vec<_> = points.chunks(RUN).collect();
    let of_runs = each(runs.len(), |run| {
        let pairs = runs[run].iter().flat_map(shares);
        pairs.map(|(light, point)| lighting.share(light, point).to_array()).collect::<Vec<_>>()
    });
    of_runs.concat()
}
