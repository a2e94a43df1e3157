//! Twin of `wgsl/common/receive.wgsl`, `shading.wgsl`, `sheet.wgsl` and `tone.wgsl`: the light that
//! reaches a point, and what of it the camera sees.
use super::{
    air::phase,
    receive::{MapTexel, light_by_channel, receive, receive_curve},
};
use crate::{
    caster::{Material, Receives},
    frame::ViewMaps,
    owner::owner_tag,
    scene::Scene,
    stage::shade::GpuLight,
    view::{GpuView, View},
};
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4Swizzles as _};
use std::{f32::consts::FRAC_1_PI, ops::Range};

/// Numbers of [`GpuLight::kind`].
const DIRECTIONAL: u32 = 0;
const SPOT: u32 = 1;
/// Numbers of [`GpuView::part`].
const PART_FACE: u32 = 1;
const PART_WINDOW: u32 = 2;

/// What lights the picture.
#[derive(Clone, Debug)]
pub struct Lighting<'a> {
    pub lights: Vec<GpuLight>,
    views: Vec<GpuView>,
    maps: &'a [ViewMaps],
    pub ambient: Vec3,
    background: Vec3,
    /// [m]
    bias: f32,
    /// [texels]
    normal_bias: f32,
}

/// A point of what the camera sees.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub point: Vec3,
    /// Interpolated, on the eye's side.
    pub normal: Vec3,
    /// Of the plane, on the eye's side.
    pub face: Vec3,
    pub to_eye: Vec3,
    pub albedo: Vec3,
    pub roughness: f32,
    /// How far what is in the map may lie off the point [m].
    pub reach: f32,
    pub receiver: Receiver,
}

/// Who receives light.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    receives: Receives,
    /// Of its object.
    tag: u16,
}

impl Receiver {
    /// Tinted by all that is before it.
    pub const AIR: Self = Self { receives: Receives::Curve, tag: 0 };

    pub fn new(material: &Material, id: u32) -> Self {
        Self { receives: material.receives, tag: owner_tag(id) }
    }
}

/// How much is mirrored: all of what reflects by itself, of the rest what shines like glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gloss {
    pub reflectivity: f32,
    /// 1 of glass, 0 of what is not there.
    pub polish: f32,
}

impl Gloss {
    const SOLID: Self = Self { reflectivity: 0.0, polish: 1.0 };

    /// `cosine` of the angle between the eye and the normal.
    pub fn mirrored(self, cosine: f32) -> f32 {
        self.reflectivity + (1.0 - self.reflectivity) * self.polish * fresnel(cosine)
    }
}

/// What a pane scatters and what it mirrors of the lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    pub diffuse: Vec3,
    pub shine: Vec3,
}

impl<'a> Lighting<'a> {
    /// `maps` of `views`: the shadow views of the scene's lights.
    pub fn new(scene: &Scene, views: &[View], maps: &'a [ViewMaps]) -> Self {
        let lights = scene.lights.iter().enumerate();
        Self {
            lights: lights.map(|(index, light)| GpuLight::new(light, index, views)).collect(),
            views: views.iter().map(|view| view.to_gpu(0, UVec2::ZERO, 0)).collect(),
            maps,
            ambient: scene.ambient,
            background: scene.background,
            bias: scene.shadow.bias,
            normal_bias: scene.shadow.normal_bias,
        }
    }

    /// What is seen, and mirrored, where there is nothing: brighter above.
    pub fn sky(&self, direction: Vec3) -> Vec3 {
        self.background * (1.0 + 0.35 * direction.y)
    }

    fn ambient_light(&self, normal: Vec3) -> Vec3 {
        self.ambient * (0.85 + 0.15 * normal.y)
    }

    fn receive_texel(
        &self,
        view: usize,
        texel: Vec2,
        z: f32,
        bias: f32,
        receiver: Receiver,
    ) -> Vec3 {
        let size = self.views[view].size;
        let at = texel.clamp(Vec2::ZERO, size - 1.0).as_uvec2();
        let (map, i) = (&self.maps[view], (at.y * size.x as u32 + at.x) as usize);
        let tinted = match receiver.receives {
            Receives::Curve | Receives::Nearest => true,
            Receives::Opaque => false,
            Receives::Others => map.owner.get(i) != Some(&receiver.tag),
        };
        // A curve knows no owners.
        let by_curve = matches!(receiver.receives, Receives::Curve | Receives::Others);
        if let Some(curve) = map.curve.as_ref().filter(|_| by_curve) {
            return receive_curve(z, map.opaque[i], bias, |z| curve.light_at(i, z));
        }
        let filter = if tinted { Vec3::from_array(map.filter[i]) } else { Vec3::ONE };
        let texel = MapTexel { filter, nearest: map.nearest[i], opaque: map.opaque[i] };
        let light = receive(z, &texel, bias);
        map.colored.get(i).map_or(light, |depths| light_by_channel(light, *depths, z, bias))
    }

    /// Nine texels, each asked for itself, weighted by a quadratic B-spline.
    fn receive(&self, index: usize, point: Vec3, bias: f32, receiver: Receiver) -> Vec3 {
        let view = &self.views[index];
        let p = view.view_from_world.transform_point3(point);
        let distance = -p.z;
        let perspective = view.perspective > 0.0;
        let spread = view.scale / if perspective { distance.max(1e-6) } else { 1.0 };
        let place = Vec2::new(p.x, -p.y) * spread + view.size * 0.5;
        let range = view.far - view.near;
        let z = (distance - view.near) / range;
        let inside = place.cmpge(Vec2::ZERO).all() && place.cmple(view.size).all();
        if !(z >= 0.0 && (inside || perspective)) {
            return Vec3::ONE;
        }
        let middle = place.floor().clamp(Vec2::splat(-1e6), Vec2::splat(1e6));
        let t = (place - middle - 0.5).clamp(Vec2::splat(-0.5), Vec2::splat(0.5));
        let (x, y) = (spline(t.x), spline(t.y));
        let mut light = Vec3::ZERO;
        for i in 0..9 {
            let step = Vec2::new((i % 3) as f32 - 1.0, (i / 3) as f32 - 1.0);
            let weight = x[i % 3] * y[i / 3];
            light += weight * self.receive_texel(index, middle + step, z, bias / range, receiver);
        }
        light
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
        point: Vec3,
        normal: Vec3,
        sine: f32,
        bias: f32,
        receiver: Receiver,
    ) -> (Vec3, f32) {
        let (mut sum, mut rest) = (Vec3::ZERO, 1.0);
        for index in windows {
            let at = self.lifted(&self.views[index], point, normal, sine);
            let share = window_share(&self.views[index], at);
            if share > 0.0 {
                sum += self.receive(index, at, bias, receiver) * (rest * share);
                rest *= 1.0 - share;
            }
        }
        (sum / (1.0 - rest).max(1e-6), 1.0 - rest)
    }

    /// Through the shadow of `views`: the first of them, the face of a cube, or windows.
    fn through_shadow(
        &self,
        views: Range<usize>,
        point: Vec3,
        normal: Vec3,
        sine: f32,
        bias: f32,
        receiver: Receiver,
    ) -> (Vec3, f32) {
        if self.views[views.start].part == PART_WINDOW {
            return self.through_windows(views, point, normal, sine, bias, receiver);
        }
        let at = self.lifted(&self.views[views.start], point, normal, sine);
        (self.receive(views.start, at, bias, receiver), 1.0)
    }

    /// The views of the shadow that starts at `first`: of a cube the face that looks at the point.
    fn views_of(&self, first: usize, light: &GpuLight, point: Vec3) -> Range<usize> {
        let view = &self.views[first];
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
        let cosine = normal.dot(toward);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let first = light.first_view as usize;
        let views = self.views_of(first, light, point);
        let (own, share) = self.through_shadow(views.clone(), point, normal, sine, bias, receiver);
        let mut passed = Vec3::ONE.lerp(own, share);
        let mut next = views.end;
        while next < first + light.view_count as usize {
            let views = self.views_of(next, light, point);
            next = views.end;
            let (further, share) = self.through_shadow(views, point, normal, sine, bias, receiver);
            passed = passed.lerp(passed.min(further), share);
        }
        passed
    }

    pub fn shade_solid(&self, surface: &Surface) -> Vec3 {
        let mut sum = surface.albedo * self.ambient_light(surface.normal);
        for light in &self.lights {
            let (toward, color) = incoming(light, surface.point);
            let cosine = surface.normal.dot(toward);
            if cosine > 0.0 && surface.face.dot(toward) > 0.0 && color.cmpgt(Vec3::ZERO).any() {
                let bias = self.bias + surface.reach;
                let passed =
                    self.shadow(light, surface.point, surface.face, toward, bias, surface.receiver);
                let shine = highlight(surface, toward, Gloss::SOLID);
                sum += color * passed * (cosine * (surface.albedo * FRAC_1_PI + shine));
            }
        }
        sum
    }

    /// A thin sheet, lit from both sides.
    pub fn light_sheet(&self, surface: &Surface, gloss: Gloss) -> Lit {
        let mut lit = Lit { diffuse: self.ambient_light(surface.normal), shine: Vec3::ZERO };
        for light in &self.lights {
            let (toward, color) = incoming(light, surface.point);
            let cosine = surface.normal.dot(toward);
            let side = if surface.face.dot(toward) > 0.0 { surface.face } else { -surface.face };
            let passed = color
                * self.shadow(light, surface.point, side, toward, self.bias, surface.receiver);
            lit.diffuse += passed * (cosine.abs() * FRAC_1_PI);
            if cosine > 0.0 {
                let shine = highlight(surface, toward, gloss);
                lit.shine += passed * (cosine * shine);
            }
        }
        lit
    }

    /// Radiance that a point of the air sends back along `ray`, were it to scatter all it takes.
    pub fn scattered(&self, point: Vec3, ray: Vec3, anisotropy: f32) -> Vec3 {
        let mut sum = self.ambient;
        for light in self.lights.iter().filter(|light| light.shafts != 0) {
            let (toward, color) = incoming(light, point);
            if color.cmpgt(Vec3::ZERO).any() {
                let passed =
                    self.shadow(light, point, Vec3::ZERO, toward, self.bias, Receiver::AIR);
                sum += color * passed * phase(toward.dot(ray), anisotropy);
            }
        }
        sum
    }

    /// A particle of colour 1, by the light at its middle.
    pub fn light_particle(&self, point: Vec3, radius: f32, receiver: Receiver) -> Vec3 {
        let mut sum = self.ambient;
        for light in &self.lights {
            let (toward, color) = incoming(light, point);
            let passed =
                self.shadow(light, point, Vec3::ZERO, toward, self.bias + radius, receiver);
            sum += color * passed * (0.5 * FRAC_1_PI);
        }
        sum
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
fn cube_face(away: Vec3) -> usize {
    let size = away.abs();
    if size.x >= size.y && size.x >= size.z {
        usize::from(away.x <= 0.0)
    } else if size.y >= size.z {
        2 + usize::from(away.y <= 0.0)
    } else {
        4 + usize::from(away.z <= 0.0)
    }
}

/// The way to the light, and the irradiance of what faces it, before shadows.
fn incoming(light: &GpuLight, point: Vec3) -> (Vec3, Vec3) {
    if light.kind == DIRECTIONAL {
        return (-light.direction, light.color);
    }
    let away = point - light.position;
    let square = away.length_squared().max(1e-4);
    let ray = away / square.sqrt();
    let part = square * light.per_range2;
    let window = (1.0 - part * part).max(0.0);
    let mut color = light.color / square * (window * window);
    if light.kind == SPOT {
        let (outer, inner) = (light.cone_outer, light.cone_inner);
        let t = ((ray.dot(light.direction) - outer) / (inner - outer)).clamp(0.0, 1.0);
        color *= t * t * (3.0 - 2.0 * t);
    }
    (-ray, color)
}

/// Schlick 1994, of glass and most that is no metal.
fn fresnel(cosine: f32) -> f32 {
    0.04 + 0.96 * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}

/// Blinn 1977, normalised; the exponent from the roughness as Walter et al. 2007, section 6.
fn highlight(surface: &Surface, toward: Vec3, gloss: Gloss) -> f32 {
    let Surface { normal, to_eye, roughness, .. } = *surface;
    let middle = (toward + to_eye).normalize();
    let width = (roughness * roughness).max(0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = normal.dot(middle).max(1e-6).powf(exponent);
    (exponent + 8.0) * (FRAC_1_PI / 8.0) * lobe * gloss.mirrored(to_eye.dot(middle))
}

/// World space, of a point of the camera's map at light depth `depth`.
pub fn world_point(view: &GpuView, world_from_view: &Mat4, pixel: Vec2, depth: f32) -> Vec3 {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let distance = view.near + depth * (view.far - view.near);
    let point = Vec3::new(slope.x, -slope.y, -1.0) * distance;
    (*world_from_view * point.extend(1.0)).xyz()
}

/// Khronos PBR Neutral (2024): hue and saturation stay, only highlights are compressed.
fn tone_mapped(light: Vec3) -> Vec3 {
    const START: f32 = 0.76;
    /// Far less than the original: fire stays orange.
    const DESATURATION: f32 = 0.01;
    let least = light.min_element();
    let toe = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = light - toe;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let rest = 1.0 - START;
    let new_peak = 1.0 - rest * rest / (peak + rest - START);
    let share = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    (color * (new_peak / peak)).lerp(Vec3::splat(new_peak), share)
}

/// sRGB (IEC 61966-2-1) of linear light.
pub fn to_screen(light: Vec3) -> [u8; 3] {
    tone_mapped(light).to_array().map(|v| {
        let v = v.clamp(0.0, 1.0);
        let v = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (v * 255.0 + 0.5).floor() as u8
    })
}
