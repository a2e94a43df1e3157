//! A splat in a directional view's map, in 64 bits from its definition.
use gobo::{
    glam::{DMat3, DVec2, DVec3},
    model::{Gaussian, View, reach_squared},
};
use std::f64::consts::FRAC_1_SQRT_2;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Ellipse {
    /// Centre [texels].
    pub(crate) center: DVec2,
    /// Light depth at its centre.
    pub(crate) depth: f64,
    /// Principal axes of one deviation [texels].
    pub(crate) axes: [DVec2; 2],
    /// Change of the light depth along each axis.
    pub(crate) tilt: DVec2,
    /// Distance at which it ends [deviations].
    pub(crate) reach: f64,
    /// Opacity at its centre.
    pub(crate) opacity: f64,
}

impl Ellipse {
    pub(crate) fn new(gaussian: &Gaussian, view: &View) -> Self {
        let range = f64::from(view.far - view.near);
        let scale = f64::from(view.scale);
        let in_view = view.view_from_world.as_dmat4();
        let to_map = DMat3::from_diagonal(DVec3::new(scale, -scale, -1.0 / range));
        let at = to_map * in_view.transform_point3(gaussian.center.as_dvec3());
        let own = DMat3::from_quat(gaussian.rotation.as_dquat().normalize())
            * DMat3::from_diagonal(gaussian.sigma.as_dvec3());
        let axes = to_map * DMat3::from_mat4(in_view) * own;
        let [x, y, along] = [0, 1, 2].map(|i| axes.row(i));
        let angle = 0.5 * (2.0 * x.dot(y)).atan2(x.dot(x) - y.dot(y));
        let ways = [DVec2::from_angle(angle), DVec2::from_angle(angle).perp()];
        let deviations = ways.map(|way| x * way.x + y * way.y);
        // No deviation is below half the diagonal of a texel.
        let grown = deviations.map(|v| v.length().max(FRAC_1_SQRT_2));
        let thin = deviations[0].length() * deviations[1].length() / (grown[0] * grown[1]);
        let tilt = deviations.map(|v| along.dot(v.normalize_or_zero()));
        Self {
            center: at.truncate() + view.size.as_dvec2() * 0.5,
            depth: at.z - f64::from(view.near) / range,
            axes: [ways[0] * grown[0], ways[1] * grown[1]],
            tilt: DVec2::from_array(tilt),
            reach: f64::from(reach_squared(gaussian.opacity)).sqrt(),
            opacity: f64::from(gaussian.opacity) * thin,
        }
    }

    /// Position in its axes [deviations].
    pub(crate) fn place(&self, texel: DVec2) -> DVec2 {
        let away = texel - self.center;
        DVec2::from_array(self.axes.map(|axis| away.dot(axis) / axis.length_squared()))
    }

    /// Half the box around everything within `reach` deviations [texels].
    pub(crate) fn half_box(&self, reach: f64) -> DVec2 {
        (self.axes[0].abs() + self.axes[1].abs()) * reach
    }
}

/// Number of quads over each texel of a view's map: the number of its blends.
pub(crate) fn layers(gaussians: &[Gaussian], view: &View) -> Vec<u32> {
    let mut layers = vec![0; (view.size.x * view.size.y) as usize];
    let last = view.size.as_dvec2();
    for gaussian in gaussians {
        let ellipse = Ellipse::new(gaussian, view);
        let half = ellipse.half_box(ellipse.reach);
        let [low, high] = [ellipse.center - half, ellipse.center + half + 1.0]
            .map(|corner| corner.floor().clamp(DVec2::ZERO, last).as_uvec2());
        for y in low.y..high.y {
            for x in low.x..high.x {
                let texel = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                let inside = ellipse.place(texel).abs().max_element() <= ellipse.reach;
                layers[(y * view.size.x + x) as usize] += u32::from(inside);
            }
        }
    }
    layers
}
