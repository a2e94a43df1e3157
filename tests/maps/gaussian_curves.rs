//! Gaussians in depth: curves against the transmittance in front of each receiver, in 64 bits.
use super::gaussians::{all_maps, kinds, lit_by, medium, splats};
use crate::common::gaussian_truth::{Seen, meet};
use gobo::{
    glam::{DVec3, Vec3},
    model::{Material, Projection, Receiver, Transfer, View},
    records::{ViewMaps, curve::light_at},
    view::shadow_views,
};
use gobo_scene::Scene;

const DEPTHS: u32 = 24;

/// Ray through a texel's centre, by the inverse of the view's matrix: its start, its step per metre along the
/// axis, and the distances along the axis of light depths 0 and 1.
pub(super) fn ray(view: &View, texel: [u32; 2]) -> (DVec3, DVec3, [f64; 2]) {
    let world = view.view_from_world.as_dmat4().inverse();
    let half = view.size.as_dvec2() * 0.5;
    let scale = f64::from(view.scale);
    let x = (f64::from(texel[0]) + 0.5 - half.x) / scale;
    let y = (half.y - f64::from(texel[1]) - 0.5) / scale;
    let (start, way) = match view.projection {
        Projection::Orthographic => (DVec3::new(x, y, 0.0), DVec3::NEG_Z),
        _ => (DVec3::ZERO, DVec3::new(x, y, -1.0)),
    };
    let ends = [view.near, view.far].map(f64::from);
    (world.transform_point3(start), world.transform_vector3(way), ends)
}

/// Light that passes all Gaussians in front of light depth `depth`.
fn passed(scene: &Scene, view: &View, texel: [u32; 2], depth: f64) -> DVec3 {
    let (start, way, [near, far]) = ray(view, texel);
    let end = near + depth * (far - near);
    scene.gaussians.iter().fold(DVec3::ONE, |light, gaussian| {
        let material = &scene.materials[gaussian.material as usize];
        let met = meet(&Seen::whole(gaussian), gaussian, material, start, way, [near, end]);
        let is_passed = met.deviation > 0.0 || (met.t >= near && met.t < end);
        let alpha = if is_passed { met.alpha } else { 0.0 };
        light * (DVec3::ONE - alpha * (DVec3::ONE - gaussian.color.as_dvec3()))
    })
}

/// Mean and largest error of a view's curves at receivers of all depths.
fn errors(scene: &Scene, maps: &ViewMaps) -> (f64, f64) {
    let curve = maps.curve.as_ref().expect("curve mode");
    let nodes = curve.nodes;
    let (mut sum, mut most, mut count) = (0.0, 0.0_f64, 0.0);
    for y in (3..maps.view.size.y).step_by(9) {
        for x in (2..maps.view.size.x).step_by(7) {
            let at = (y * maps.view.size.x + x) as usize;
            let packed = &curve.packed[at * nodes..(at + 1) * nodes];
            for i in 0..DEPTHS {
                let depth = (f64::from(i) + 0.37) / f64::from(DEPTHS);
                let found = light_at(packed, depth as f32, false).as_dvec3();
                let apart = (found - passed(scene, &maps.view, [x, y], depth)).abs().max_element();
                (sum, most, count) = (sum + apart, most.max(apart), count + 1.0);
            }
        }
    }
    (sum / count, most)
}

fn in_curve_mode(mut scene: Scene) -> Scene {
    scene.shadow.receiver = Receiver::Curve;
    scene
}

/// One medium has the fitted ramp at any optical depth.
#[test]
fn a_medium_is_its_fitted_ramp() {
    for (density, bound) in
        [(0.4, 0.035), (2.0, 0.062), (4.0, 0.062), (10.0, 0.062), (200.0, 0.075)]
    {
        for kind in kinds() {
            let mut scene = in_curve_mode(lit_by(kind, vec![medium(density)], 1));
            let gaussian = &mut scene.gaussians[0];
            gaussian.center = Vec3::new(-0.6, -0.8, -0.5);
            gaussian.sigma = Vec3::new(0.5, 0.3, 0.4);
            (gaussian.opacity, gaussian.color) = (1.0, Vec3::ZERO);
            for maps in all_maps(&scene) {
                for maps in &maps {
                    let (_, most) = errors(&scene, maps);
                    assert!(most <= bound, "{density}, {kind:?}: {most}");
                }
            }
        }
    }
}

/// Many intersecting Gaussians: merges and ramps together.
#[test]
fn curves_of_gaussians_agree_in_the_mean() {
    let looks: [fn() -> Material; 2] = [|| splats(Transfer::Filter), || medium(2.0)];
    for look in looks {
        for kind in kinds() {
            let scene = in_curve_mode(lit_by(kind, vec![look()], 60));
            let views = shadow_views(&scene);
            for maps in all_maps(&scene) {
                assert_eq!(maps.len(), views.len());
                for maps in &maps {
                    let (mean, _) = errors(&scene, maps);
                    assert!(mean <= 4e-3, "{kind:?}: {mean}");
                }
            }
        }
    }
}
