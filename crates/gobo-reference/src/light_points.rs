//! CPU reference of `wgsl/shade/light_through.wgsl`: share of each light that reaches the host's points.
use super::{
    area::{Fit, mean_over_points},
    shading::Lighting,
    threads::each,
};
use glam::Vec3;
use gobo::{
    model::{ReceiverPoint, Scene, View},
    records::ViewMaps,
};

/// Points per work item of a thread.
const RUN: usize = 1024;

/// Shares in linear rgb, point by point, light by light; `maps` of `views`: the shadow views of the scene's
/// lights. `fit`: fits views to the points of area lights.
pub fn light_points(
    scene: &Scene,
    views: &[View],
    maps: &[ViewMaps],
    fit: Fit<'_>,
    points: &[ReceiverPoint],
) -> Vec<[f32; 3]> {
    let runs: Vec<_> = points.chunks(RUN).collect();
    let shares = mean_over_points(scene, views, maps, fit, |of_lights| {
        let lighting = Lighting::of_points(scene, of_lights);
        let of_point = |point| (0..scene.lights.len()).map(move |light| (light, point));
        let share = |(light, point)| lighting.share(light, point);
        each(runs.len(), |run| runs[run].iter().flat_map(of_point).map(share).collect::<Vec<_>>())
            .concat()
    });
    shares.into_iter().map(Vec3::into).collect()
}
