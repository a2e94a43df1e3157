//! Light that reaches splats, looked up at points where each splat leaves itself out.
use crate::shadows::Prepared;
use crate::{
    error::{Error, Input},
    model::{Light, LightKind},
};
use bytemuck::{Pod, Zeroable};

/// WGSL for a kernel of the host, to place the points at which [`Prepared::light_points`] evaluates a light
/// for its splats. It declares a struct with the layout of [`SplatLight`], and
///
/// ```wgsl
/// fn splat_point(
///     light: SplatLight,
///     center: vec3<f32>,
///     rotation: vec4<f32>,
///     sigma: vec3<f32>,
///     opacity: f32,
/// ) -> vec3<f32>
/// ```
///
/// The arguments are those of a [`Gaussian`](crate::Gaussian) whose opacity is a splat's. The point is so far
/// in front of the centre, towards the light, that no texel around it finds the splat itself in front: a lone
/// splat gets all light. This holds for curves ([`Receiver::Curve`](crate::Receiver)) with the spline filter
/// and without blur.
pub const SPLAT_POINT_WGSL: &str = "
struct SplatLight {
    position: vec3<f32>,    // of the light [m]; of a directional one its direction
    is_directional: u32,
    texel: f32,          // edge of a map's texel [m], or a metre away from the light
    step: f32,           // of depths in curves [m]
    pad_0: u32,
    pad_1: u32,
}

const SPLAT_TAPS: f32 = 2.2; // reach of the filter [texels]

// `direction` in the space of a splat whose deviations are 1, less its centre.
fn splat_space(direction: vec3<f32>, rotation: vec4<f32>, sigma: vec3<f32>) -> vec3<f32> {
    // By the inverse of the rotation.
    let turned = 2.0 * cross(-rotation.xyz, direction);
    return sigma * (direction + rotation.w * turned + cross(-rotation.xyz, turned));
}

// How far hits of the splat within the filter's texels are in front of its centre: the depth of a hit is its
// mean over the splat at the hit's place across the ray.
fn splat_reach(ray: vec3<f32>, texel: f32, rotation: vec4<f32>, sigma: vec3<f32>, opacity: f32) -> f32 {
    let aside = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(ray.x) > 0.5);
    let right = normalize(cross(ray, aside));
    let along = splat_space(ray, rotation, sigma);
    let x = splat_space(right, rotation, sigma);
    let y = splat_space(cross(right, ray), rotation, sigma);
    let normal = cross(x, y);
    let area = dot(normal, normal);
    let slope = vec2(dot(cross(along, y), normal), dot(cross(x, along), normal)) / area;
    let thickness = dot(along, normal);
    let tilt = sqrt(max(dot(along, along) - thickness * thickness / area, 0.0));
    let reach = sqrt(min(2.0 * log(max(opacity * 8192.0, 256.0)), 64.0)); // [standard deviations]
    // A needle along the ray has no area.
    return select(reach * length(along), min(reach * tilt, length(slope) * SPLAT_TAPS * texel), area > 0.0);
}

fn splat_point(
    light: SplatLight,
    center: vec3<f32>,
    rotation: vec4<f32>,
    sigma: vec3<f32>,
    opacity: f32,
) -> vec3<f32> {
    var ray = light.position;
    var texel = light.texel;
    var slack = 2.0 * light.step;
    if light.is_directional == 0u {
        let away = center - light.position;
        ray = normalize(away);
        texel *= length(away);
        slack += SPLAT_TAPS * texel; // depths are along the axis, planes of hits across the ray
    }
    return center - ray * (splat_reach(ray, texel, rotation, sigma, opacity) + slack);
}
";

/// A light as [`SPLAT_POINT_WGSL`] reads it, from a uniform buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SplatLight {
    /// Position of the light, world space \[m\]; for a directional light its direction, unit.
    pub position: [f32; 3],
    /// 1 for a directional light.
    pub is_directional: u32,
    /// Edge of the largest texel of its maps \[m\], or at 1 m from the light.
    pub texel: f32,
    /// Largest step of depths in its curves \[m\].
    pub step: f32,
    pad: [u32; 2],
}

impl Prepared {
    /// Light `index` of `lights`, which the views were made of, for [`SPLAT_POINT_WGSL`].
    ///
    /// # Errors
    /// If the light is invalid or does not exist.
    pub fn splat_light(&self, lights: &[Light], index: usize) -> Result<SplatLight, Error> {
        let unknown = Input::Light.invalid(index, "it is not among the lights");
        let light = lights.get(index).ok_or(unknown)?;
        light.check(index)?;
        let (mut texel, mut step) = (0.0_f32, 0.0_f32);
        for view in self.views().iter().filter(|view| view.light == Some(index)) {
            // In perspective views, the distance from the light is at least the distance along the axis.
            texel = texel.max(1.0 / view.scale);
            step = step.max((view.far - view.near) / 65535.0);
        }
        let (position, is_directional) = match light.kind.with_unit_direction() {
            LightKind::Directional { direction } => (direction, 1),
            LightKind::Spot { position, .. } | LightKind::Point { position } => (position, 0),
        };
        Ok(SplatLight { position: position.to_array(), is_directional, texel, step, pad: [0; 2] })
    }
}
