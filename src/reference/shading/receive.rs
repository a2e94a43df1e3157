//! Twin of `wgsl/shade/receive.wgsl`: what of a light the shadow maps let through to a point.
use super::{Lighting, Receiver};
use crate::{
    model::Receives,
    records::{GpuLight, GpuView, PART_FACE, PART_WINDOW},
    reference::receive::{MapTexel, light_by_channel, receive, receive_curve},
};
use glam::{Vec2, Vec3};
use std::ops::Range;

/// What receives, in world space; `normal` is on the light's side, zero where there is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub point: Vec3,
    pub normal: Vec3,
}

/// Of a surface, in view space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    point: Vec3,
    normal: Vec3,
}

/// Of the bias: how much deeper a solid receiver lies than it is, so that it is behind what lies on it.
const TOUCH: f32 = 1.0 / 16.0;
/// Cosine between a plane's normal and a ray below which the plane has no depth along it.
const EDGE_ON: f32 = 0.02;

impl Plane {
    pub(super) fn new(view: &GpuView, surface: Surface) -> Self {
        Self {
            point: view.view_from_world.transform_point3(surface.point),
            normal: view.view_from_world.transform_vector3(surface.normal),
        }
    }

    /// Light depth along the ray through `texel` (view's map) from which on what is translucent tints
    /// the receiver, which is at `z`. What is solid cannot tint itself, and counts where its plane meets
    /// the ray: up to what touches it.
    fn tint_depth(
        &self,
        view: &GpuView,
        texel: Vec2,
        z: f32,
        bias: f32,
        receiver: Receiver,
    ) -> f32 {
        if !receiver.solid {
            return z - bias;
        }
        let Self { point, normal } = *self;
        let slope = (texel - view.size * 0.5) / view.scale;
        let perspective = view.perspective > 0.0;
        // From the eye, or from the eye's plane.
        let way = if perspective { Vec3::new(slope.x, -slope.y, -1.0) } else { Vec3::NEG_Z };
        let start = if perspective { Vec3::ZERO } else { Vec3::new(slope.x, -slope.y, 0.0) };
        let meets = normal.dot(way);
        let is_edge_on = meets.abs() < EDGE_ON * way.length();
        let along = if is_edge_on { -point.z } else { normal.dot(point - start) / meets };
        (along - view.near) / (view.far - view.near) + TOUCH * bias
    }
}

/// Nine texels of a map, around a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taps {
    /// Light depth of the point.
    pub z: f32,
    middle: Vec2,
    x: [f32; 3],
    y: [f32; 3],
}

impl Taps {
    /// Texel and weight of number `i`.
    pub(super) fn tap(&self, i: usize) -> (Vec2, f32) {
        let step = Vec2::new((i % 3) as f32 - 1.0, (i / 3) as f32 - 1.0);
        (self.middle + step, self.x[i % 3] * self.y[i / 3])
    }
}

impl Lighting<'_> {
    pub(super) fn receive_texel(
        &self,
        view: usize,
        texel: Vec2,
        z: f32,
        plane: Plane,
        bias: f32,
        receiver: Receiver,
    ) -> Vec3 {
        let size = self.records.views[view].size;
        let at = texel.clamp(Vec2::ZERO, size - 1.0);
        let tint_z = plane.tint_depth(&self.records.views[view], at + 0.5, z, bias, receiver);
        let at = at.as_uvec2();
        let (map, i) = (&self.maps[view], (at.y * size.x as u32 + at.x) as usize);
        let tinted = match receiver.receives {
            Receives::Curve | Receives::Nearest => true,
            Receives::Opaque => false,
            Receives::Others => map.owner.get(i) != Some(&receiver.tag),
        };
        let by_channel = |light: Vec3| {
            map.colored.get(i).map_or(light, |depths| light_by_channel(light, *depths, z, bias))
        };
        // A curve knows no owners.
        let by_curve = matches!(receiver.receives, Receives::Curve | Receives::Others);
        if let Some(curve) = map.curve.as_ref().filter(|_| by_curve) {
            let light = receive_curve(z, map.opaque[i], bias, |_| curve.light_at(i, tint_z));
            return by_channel(light);
        }
        let filter = if tinted { Vec3::from_array(map.filter[i]) } else { Vec3::ONE };
        let nearest = if tint_z > map.nearest[i] { f32::NEG_INFINITY } else { f32::INFINITY };
        let texel = MapTexel { filter, nearest, opaque: map.opaque[i] };
        by_channel(receive(z, &texel, bias))
    }

    /// What of a texel lets light through to light depth `z` and no farther.
    pub(super) fn light_before(&self, view: usize, texel: Vec2, z: f32) -> Vec3 {
        let size = self.records.views[view].size;
        let at = texel.clamp(Vec2::ZERO, size - 1.0).as_uvec2();
        let (map, i) = (&self.maps[view], (at.y * size.x as u32 + at.x) as usize);
        let solid = map.colored.get(i).copied().unwrap_or([map.opaque[i]; 3]);
        let light = match &map.curve {
            Some(curve) => curve.light_at(i, z),
            None if z > map.nearest[i] => Vec3::from_array(map.filter[i]),
            None => Vec3::ONE,
        };
        light_by_channel(light, solid, z, 0.0)
    }

    /// Where the map of a view is asked about a point; `None` where it does not reach.
    pub(super) fn taps(&self, view: usize, point: Vec3) -> Option<Taps> {
        let view = &self.records.views[view];
        let p = view.view_from_world.transform_point3(point);
        let distance = -p.z;
        let perspective = view.perspective > 0.0;
        let spread = view.scale / if perspective { distance.max(1e-6) } else { 1.0 };
        let place = Vec2::new(p.x, -p.y) * spread + view.size * 0.5;
        let z = (distance - view.near) / (view.far - view.near);
        let inside = place.cmpge(Vec2::ZERO).all() && place.cmple(view.size).all();
        if !(z >= 0.0 && (inside || perspective)) {
            return None;
        }
        let middle = place.floor().clamp(Vec2::splat(-1e6), Vec2::splat(1e6));
        let t = (place - middle - 0.5).clamp(Vec2::splat(-0.5), Vec2::splat(0.5));
        Some(Taps { z, middle, x: spline(t.x), y: spline(t.y) })
    }

    /// Nine texels, each asked for itself, weighted by a quadratic B-spline.
    fn receive(
        &self,
        index: usize,
        point: Vec3,
        surface: Surface,
        bias: f32,
        receiver: Receiver,
    ) -> Vec3 {
        let Some(taps) = self.taps(index, point) else { return Vec3::ONE };
        let view = &self.records.views[index];
        let (plane, bias) = (Plane::new(view, surface), bias / (view.far - view.near));
        let mut light = Vec3::ZERO;
        for i in 0..9 {
            let (texel, weight) = taps.tap(i);
            light += weight * self.receive_texel(index, texel, taps.z, plane, bias, receiver);
        }
        light
    }

    /// What of a light reaches a point through one view. `point`: lifted off `surface`.
    fn receive_light(
        &self,
        index: usize,
        light: &GpuLight,
        point: Vec3,
        surface: Surface,
        bias: f32,
        receiver: Receiver,
    ) -> Vec3 {
        // Levels tell nothing of what is one caster's and not another's.
        let takes_all = matches!(receiver.receives, Receives::Curve | Receives::Nearest);
        if light.area().is_some() && takes_all {
            self.receive_area(index, light, point, surface, bias, receiver)
        } else {
            self.receive(index, point, surface, bias, receiver)
        }
    }

    /// `normal` lifts the point off its own shadow; `sine` of the angle between the normal and the
    /// way to the light.
    fn lifted(&self, view: &GpuView, point: Vec3, normal: Vec3, sine: f32) -> Vec3 {
        let along = -view.view_from_world.transform_point3(point).z;
        let texel = if view.perspective > 0.0 { along.max(0.0) } else { 1.0 } / view.scale;
        point + normal * ((self.normal_bias + 0.5) * sine * texel)
    }

    /// Light through the first window that holds the point, faded into the next; and how much it
    /// counts.
    fn through_windows(
        &self,
        windows: Range<usize>,
        light: &GpuLight,
        surface: Surface,
        sine: f32,
        bias: f32,
        receiver: Receiver,
    ) -> (Vec3, f32) {
        let (mut sum, mut rest) = (Vec3::ZERO, 1.0);
        for index in windows {
            let at = self.lifted(&self.records.views[index], surface.point, surface.normal, sine);
            let share = window_share(&self.records.views[index], at);
            if share > 0.0 {
                let passed = self.receive_light(index, light, at, surface, bias, receiver);
                sum += passed * (rest * share);
                rest *= 1.0 - share;
            }
        }
        (sum / (1.0 - rest).max(1e-6), 1.0 - rest)
    }

    /// Through the shadow of `views`: the first of them, the face of a cube, or windows.
    fn through_shadow(
        &self,
        views: Range<usize>,
        light: &GpuLight,
        surface: Surface,
        sine: f32,
        bias: f32,
        receiver: Receiver,
    ) -> (Vec3, f32) {
        if self.records.views[views.start].part == PART_WINDOW {
            return self.through_windows(views, light, surface, sine, bias, receiver);
        }
        let at = self.lifted(&self.records.views[views.start], surface.point, surface.normal, sine);
        (self.receive_light(views.start, light, at, surface, bias, receiver), 1.0)
    }

    /// The views of the shadow that starts at `first`: of a cube the face that looks at the point.
    fn views_of(&self, first: usize, light: &GpuLight, point: Vec3) -> Range<usize> {
        let view = &self.records.views[first];
        let face = if view.part == PART_FACE { cube_face(point - light.position) } else { 0 };
        first + face..first + view.part_count as usize
    }

    /// Of all shadows of a light the least light, per channel. `normal` is on the light's side.
    pub fn shadow(
        &self,
        light: &GpuLight,
        point: Vec3,
        normal: Vec3,
        toward: Vec3,
        bias: f32,
        receiver: Receiver,
    ) -> Vec3 {
        if light.view_count == 0 {
            return Vec3::ONE;
        }
        let surface = Surface { point, normal };
        let cosine = normal.dot(toward);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let first = light.first_view as usize;
        let views = self.views_of(first, light, point);
        let (own, share) = self.through_shadow(views.clone(), light, surface, sine, bias, receiver);
        let mut passed = Vec3::ONE.lerp(own, share);
        let mut next = views.end;
        while next < first + light.view_count as usize {
            let views = self.views_of(next, light, point);
            next = views.end;
            let (further, share) = self.through_shadow(views, light, surface, sine, bias, receiver);
            passed = passed.lerp(passed.min(further), share);
        }
        passed
    }
}

/// Weights of a quadratic B-spline around t in -0.5..0.5.
fn spline(t: f32) -> [f32; 3] {
    [0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)]
}

/// How much of a window's answer counts at a point: less towards its border, nothing beyond.
fn window_share(view: &GpuView, point: Vec3) -> f32 {
    let p = view.view_from_world.transform_point3(point);
    let spread = view.scale / if view.perspective > 0.0 { (-p.z).max(1e-6) } else { 1.0 };
    let place = Vec2::new(p.x, -p.y) * spread + view.size * 0.5;
    // All nine texels are the window's own.
    let border = place.min(view.size - place).min_element() - 1.5;
    if !(border > 0.0 && (view.near..=view.far).contains(&-p.z)) {
        return 0.0;
    }
    (border / view.fade.max(1e-3)).min(1.0)
}

/// The face of a cube that looks towards `away` from its middle.
pub(super) fn cube_face(away: Vec3) -> usize {
    let size = away.abs();
    if size.x >= size.y && size.x >= size.z {
        usize::from(away.x <= 0.0)
    } else if size.y >= size.z {
        2 + usize::from(away.y <= 0.0)
    } else {
        4 + usize::from(away.z <= 0.0)
    }
}
