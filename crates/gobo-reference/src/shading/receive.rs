//! CPU reference of `wgsl/shade/receive.wgsl`: share of a light that the shadow maps let through to a point.
use super::{
    Lighting, Receiver, incoming,
    seen_plane::seen_normal,
    taps::{beyond_spline, wide_lift},
    thrown::landed_light,
};
use crate::{
    light_views::cube_face,
    receive::{MapTexel, light_by_channel, receive, receive_curve},
};
use glam::{Vec2, Vec3, Vec4};
use gobo::{
    model::Receives,
    records::{CASTER_BIAS, GpuLight, GpuView, ROLE_FACE, ROLE_WINDOW, SPLINE_REACH},
};
use std::ops::Range;

/// A receiving surface, world space; `normal` is on the light's side, zero without one.
#[derive(Clone, Copy, Debug)]
struct ReceivingSurface {
    pub point: Vec3,
    pub normal: Vec3,
}

/// Light and receiver of a look-up.
#[derive(Clone, Copy, Debug)]
struct LookUp<'a> {
    light: &'a GpuLight,
    surface: ReceivingSurface,
    slant: Slant,
    receiver: Receiver,
}

/// Slant of a surface towards the light.
#[derive(Clone, Copy, Debug)]
struct Slant {
    /// Sine of the angle between its normal and the direction to the light.
    sine: f32,
    tangent: f32,
    /// Largest distance of the surface's own caster in the maps \[m\].
    reach: f32,
}

/// Least cosine of a slope: 86 degrees.
pub const MIN_INCIDENCE: f32 = 0.0625;

/// Tangent plane of a receiver, view space.
#[derive(Clone, Copy, Debug)]
struct ReceiverPlane {
    point: Vec3,
    normal: Vec3,
    /// Whether shadows end at the receiver: those of a light with a size.
    is_end: bool,
}

/// Distance behind a stored depth from which a receiver is shadowed, for opaque surfaces and for translucent
/// casters; \[m\], or as light depth.
#[derive(Clone, Copy, Debug)]
struct Bias {
    solid: f32,
    tint: f32,
}

/// Share of the bias by which an opaque receiver extends, so that casters that touch it tint it.
pub const TOUCH: f32 = 1.0 / 16.0;
/// Cosine between a plane's normal and a ray below which the plane has no depth along it.
pub const EDGE_ON: f32 = 0.02;

impl ReceiverPlane {
    fn new(view: &GpuView, surface: ReceivingSurface) -> Self {
        Self {
            point: view.view_from_world.transform_point3(surface.point),
            normal: view.view_from_world.transform_vector3(surface.normal),
            is_end: false,
        }
    }

    /// Light depth of the receiver at depth `z` along the ray through `texel`.
    fn depth_along(&self, view: &GpuView, texel: Vec2, z: f32) -> f32 {
        if self.is_end { self.meets(view, texel).min(z) } else { z }
    }

    /// Light depth along the ray through `texel` (view's map) up to which translucent casters tint the
    /// receiver at `z`. An opaque receiver cannot tint itself: its tint depth is slightly beyond its plane,
    /// so that a caster that touches it counts. For a leaf it is in front of the plane by the bias.
    fn tint_depth(
        &self,
        view: &GpuView,
        texel: Vec2,
        z: f32,
        bias: f32,
        receiver: Receiver,
    ) -> f32 {
        match (receiver.solid, receiver.leaf) {
            (true, _) => self.meets(view, texel) + TOUCH * bias,
            (false, true) => self.meets(view, texel) - bias,
            (false, false) => z - bias,
        }
    }

    /// Light depth at which the ray through `texel` meets the plane; the point's own if the plane is edge-on.
    fn meets(&self, view: &GpuView, texel: Vec2) -> f32 {
        let Self { point, normal, .. } = *self;
        let slope = (texel - view.size * 0.5) / view.scale;
        let perspective = view.perspective > 0.0;
        // Rays start at the eye, or in the eye's plane.
        let ray = if perspective { Vec3::new(slope.x, -slope.y, -1.0) } else { Vec3::NEG_Z };
        let start = if perspective { Vec3::ZERO } else { Vec3::new(slope.x, -slope.y, 0.0) };
        let meets = normal.dot(ray);
        let is_edge_on = meets.abs() < EDGE_ON * ray.length();
        let along = if is_edge_on { -point.z } else { normal.dot(point - start) / meets };
        (along - view.near) / (view.far - view.near)
    }
}

impl Lighting<'_> {
    fn receive_texel(
        &self,
        view: usize,
        texel: Vec2,
        z: f32,
        plane: ReceiverPlane,
        bias: Bias,
        receiver: Receiver,
    ) -> Vec3 {
        let size = self.views[view].size;
        let at = texel.clamp(Vec2::ZERO, size - 1.0);
        let z = plane.depth_along(&self.views[view], at + 0.5, z);
        let tint_z = plane.tint_depth(&self.views[view], at + 0.5, z, bias.tint, receiver);
        let at = at.as_uvec2();
        let (map, i) = (&self.maps[view], (at.y * size.x as u32 + at.x) as usize);
        let tinted = match receiver.receives {
            Receives::Curve | Receives::Nearest => true,
            Receives::Opaque => false,
            Receives::Others => map.owner.get(i) != Some(&receiver.tag),
        };
        let by_channel = |light: Vec3| {
            map.colored
                .get(i)
                .map_or(light, |depths| light_by_channel(light, *depths, z, bias.solid))
        };
        // Curves have no owner tags.
        let by_curve = matches!(receiver.receives, Receives::Curve | Receives::Others);
        if let Some(curve) = map.curve.as_ref().filter(|_| by_curve) {
            let light = receive_curve(z, map.opaque[i], bias.solid, |_| curve.light_at(i, tint_z));
            return by_channel(light);
        }
        let filter = if tinted { Vec3::from_array(map.filter[i]) } else { Vec3::ONE };
        // A texel without translucent casters has depth 1.
        let is_behind = tint_z > map.nearest[i] && map.nearest[i] < 1.0;
        let nearest = if is_behind { f32::NEG_INFINITY } else { f32::INFINITY };
        let texel = MapTexel { filter, nearest, opaque: map.opaque[i] };
        by_channel(receive(z, &texel, bias.solid))
    }

    /// Compares each texel separately, and weights the results by the light's filter.
    fn receive(&self, index: usize, of: LookUp<'_>, point: Vec3, bias: Bias) -> Vec3 {
        let LookUp { light, surface, receiver, .. } = of;
        let Some(taps) = self.taps(index, point) else { return Vec3::ONE };
        let view = &self.views[index];
        let mut plane = ReceiverPlane::new(view, surface);
        if is_soft(light, receiver) {
            if surface.normal == Vec3::ZERO {
                plane.normal = seen_normal(view, self.maps[index], plane.point, bias.solid);
            }
            plane.is_end = plane.normal != Vec3::ZERO;
        }
        let range = view.far - view.near;
        let bias = Bias { solid: bias.solid / range, tint: bias.tint / range };
        let mut sum = Vec3::ZERO;
        for (texel, weight) in taps.of(light, receiver.turn) {
            sum += weight * self.receive_texel(index, texel, taps.z, plane, bias, receiver);
        }
        sum
    }

    /// The point, offset along its normal by the depth that the slope spans within the filter; and the bias
    /// \[m\].
    fn lifted(&self, index: usize, of: LookUp<'_>) -> (Vec3, Bias) {
        let LookUp { light, surface, slant, receiver } = of;
        let view = &self.views[index];
        let along = -view.view_from_world.transform_point3(surface.point).z;
        let texel = if view.perspective > 0.0 { along.max(0.0) } else { 1.0 } / view.scale;
        let (mut sine, mut reach) =
            (slant.sine, slant.sine * (light.normal_bias + 0.5 + beyond_spline(light)));
        // Where the filter is wide, the slope that depths in the view have, along its axes, may be more.
        if beyond_spline(light) > 0.0 {
            let slope = view.view_from_world.transform_vector3(surface.normal).truncate();
            (sine, reach) = (sine.max(slope.length()), reach.max(wide_lift(light, slope)));
        }
        // The bias is a part of the normal bias: edges of shadows move with the point.
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let has_normal = surface.normal != Vec3::ZERO;
        let own_sine = if has_normal { sine } else { 0.0 };
        let least = if slant.reach > 0.0 { CASTER_BIAS } else { 0.0 };
        let bias = light.depth_bias(view, texel, own_sine, least);
        let part = (bias * cosine).min(light.normal_bias * sine * texel);
        let is_soft = is_soft(light, receiver);
        let lift = if is_soft { 0.0 } else { reach * texel - part };
        let point = surface.point + surface.normal * lift;
        let added = slant.reach.max(0.0) + light.slope_bias * slant.tangent * texel;
        if slant.reach < 0.0 {
            return (point, Bias { solid: added, tint: added });
        }
        // A point without a normal is on no caster, so none of its own can tint it.
        let is_on_caster = has_normal || slant.reach > 0.0;
        let tint = if is_on_caster { bias } else { light.depth_bias(view, 0.0, 0.0, 0.0) };
        (point, Bias { solid: bias + added, tint: tint + added })
    }

    /// Light through the first window that contains the point, blended into the next near its border; and its
    /// weight.
    fn through_windows(&self, windows: Range<usize>, of: LookUp<'_>) -> (Vec3, f32) {
        let (mut sum, mut rest) = (Vec3::ZERO, 1.0);
        for index in windows {
            let (at, bias) = self.lifted(index, of);
            let view = &self.views[index];
            let is_window = view.role == ROLE_WINDOW;
            let share = if is_window { window_share(of.light, view, at) } else { 1.0 };
            if share > 0.0 {
                let passed = self.receive(index, of, at, bias);
                sum += passed * (rest * share);
                rest *= 1.0 - share;
            }
        }
        (sum / (1.0 - rest).max(1e-6), 1.0 - rest)
    }

    /// Light through the shadow of `views`: their first, the face of a cube, or windows.
    fn through_shadow(&self, views: Range<usize>, of: LookUp<'_>) -> (Vec3, f32) {
        if self.views[views.start].role == ROLE_WINDOW {
            return self.through_windows(views, of);
        }
        let (at, bias) = self.lifted(views.start, of);
        (self.receive(views.start, of, at, bias), 1.0)
    }

    /// The share `straight` of a light, with light that glass throws. By windows, from the first on, as
    /// shadows are.
    fn with_thrown(&self, light: &GpuLight, point: Vec3, straight: Vec3) -> Vec3 {
        let views = self.views_of(light.first_view as usize, point);
        if self.maps[views.start].caustics.is_empty() {
            return straight;
        }
        let is_face = self.views[views.start].role == ROLE_FACE;
        let views = if is_face { views.start..views.start + 1 } else { views };
        let (mut sum, mut rest) = (Vec4::ZERO, 1.0);
        for index in views {
            let view = &self.views[index];
            let is_window = view.role == ROLE_WINDOW;
            let share = if is_window { window_share(light, view, point) } else { 1.0 };
            if share > 0.0 {
                sum += landed_light(view, self.maps[index], point) * (rest * share);
                rest *= 1.0 - share;
            }
        }
        straight * (1.0 - sum.w) + sum.truncate()
    }

    /// Views of the shadow that starts at `first`; for a cube, the face that sees the point.
    fn views_of(&self, first: usize, point: Vec3) -> Range<usize> {
        let view = &self.views[first];
        let away = || {
            let in_view = view.view_from_world.transform_point3(point);
            glam::Mat3::from_mat4(view.view_from_world).transpose() * in_view
        };
        let face = if view.role == ROLE_FACE { cube_face(away()) } else { 0 };
        first + face..first + view.role_count as usize
    }

    /// Least transmittance, per channel, among the mean of a light's viewpoints and its further shadows.
    /// `normal` is on the light's side; `reach`: largest distance of the point's own caster in the maps
    /// \[m\].
    pub fn shadow(
        &self,
        index: usize,
        point: Vec3,
        normal: Vec3,
        reach: f32,
        receiver: Receiver,
    ) -> Vec3 {
        let light = &self.points[index];
        if light.view_count == 0 {
            return Vec3::ONE;
        }
        let (toward, _) = incoming(light, point);
        let surface = ReceivingSurface { point, normal };
        let cosine = normal.dot(toward);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        // Without a normal there is no slope.
        let tangent = normal.length_squared() * sine / cosine.max(MIN_INCIDENCE);
        let slant = Slant { sine, tangent, reach };
        let of = LookUp { light, surface, slant, receiver };
        let first = light.first_view as usize;
        let mut passed = Vec3::ONE;
        let mut next = first;
        for viewpoint in 1..=light.viewpoints() {
            let views = self.views_of(next, point);
            next = views.end;
            let (through, share) = self.through_shadow(views, of);
            passed = passed.lerp(Vec3::ONE.lerp(through, share), 1.0 / viewpoint as f32);
        }
        while next < first + light.view_count as usize {
            let views = self.views_of(next, point);
            next = views.end;
            let (further, share) = self.through_shadow(views, of);
            passed = passed.lerp(passed.min(further), share);
        }
        self.with_thrown(light, point, passed)
    }
}

/// Whether a light has penumbrae on a receiver.
fn is_soft(light: &GpuLight, receiver: Receiver) -> bool {
    light.area().is_some() && matches!(receiver.receives, Receives::Curve | Receives::Nearest)
}

/// Weight of a window at a point: it falls towards the border, and is 0 outside.
fn window_share(light: &GpuLight, view: &GpuView, point: Vec3) -> f32 {
    let p = view.view_from_world.transform_point3(point);
    let spread = view.scale / if view.perspective > 0.0 { (-p.z).max(1e-6) } else { 1.0 };
    let position = Vec2::new(p.x, -p.y) * spread + view.size * 0.5;
    // All texels of the filter must be in the window.
    let border =
        position.min(view.size - position).min_element() - SPLINE_REACH - beyond_spline(light);
    if !(border > 0.0 && (view.near..=view.far).contains(&-p.z)) {
        return 0.0;
    }
    (border / view.fade.max(1e-3)).min(1.0)
}
