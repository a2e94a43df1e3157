//! Shadow masks: the slots of lights, and the parameters of kernels.
//!
//! A mask is a layer of four 8-bit channels. It has four *slots* for lights that are blocked equally in all
//! channels, or one slot, of three channels, for a light that some caster tints. Lights that do not overlap
//! on the screen share a slot.
use super::Reach;
use crate::model::{Bounds, Class, Light, LightKind, MaskSettings, Scene, View};
use glam::{DVec2, DVec3, Mat4, UVec2};
use std::collections::HashMap;

/// Slots of a mask. WGSL: `wgsl/records/mask.wgsl`.
pub const SLOTS: u32 = 4;
/// Flag of a slot: the light owns all channels of its mask.
pub const COLORED_BIT: u32 = 1 << 31;
/// Flag of a slot on the device: the host's shadow function applies to the light.
pub const JOINED_BIT: u32 = 1 << 30;

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/mask.wgsl`.
    pub struct MaskParams {
        /// Size of the masks that are computed \[pixels\].
        pub size: UVec2,
        /// Pixels of the picture per pixel of the masks, along an edge.
        pub step: u32,
        /// Blur taps to each side of the centre.
        pub taps: u32,
        /// Edge-stopping strength, as [`MaskSettings::sensitivity`].
        pub sensitivity: f32,
        /// Distance up to which the blur has its full width \[m\]; 0: everywhere.
        pub depth_scale: f32,
        /// 1: a column is blurred, 0: a row.
        pub column: u32,
        pub mask_count: u32,
        /// 1: the blur narrows on slanted surfaces, as [`MaskSettings::anisotropic`].
        pub anisotropic: u32,
        pub pad_0: u32,
        pub pad_1: u32,
        pub pad_2: u32,
    }
}

crate::records::gpu_struct! {
    /// Camera of a host's depths. WGSL: `wgsl/records/mask.wgsl`.
    pub struct HostView {
        /// Inverse of the matrix that the depths were rendered with.
        pub world_from_clip: Mat4,
        /// Rotation of the normals to world space.
        pub world_from_normal: Mat4,
        /// Depth of pixels without a surface.
        pub empty: f32,
        /// 1: depths are light depths of the view.
        pub is_light_depth: u32,
        /// Format of the normals: [`NORMALS_NONE`] and so on.
        pub normals: u32,
        pub pad_0: u32,
    }
}

/// No normals: they are derived from the depths.
pub const NORMALS_NONE: u32 = 0;
/// Normals in a float or snorm format.
pub const NORMALS_SIGNED: u32 = 1;
/// Normals in a unorm format: 0 is -1.
pub const NORMALS_UNORM: u32 = 2;

/// Slots of the previous frame by the lights' names; lights keep them.
pub type FormerSlots = HashMap<String, u32>;

/// Assignment of lights to slots of masks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MaskSlots {
    /// Slot of each light, packed as `mask_slot` of `wgsl/records/mask.wgsl` reads it; 0 for none.
    pub of_lights: Vec<u32>,
    /// Number of masks.
    pub count: u32,
    /// Lights that cast shadows into the picture but have no slot.
    pub unmasked: u32,
}

/// Part of the picture that a light reaches: slopes to the right and down, and depths \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenBounds {
    low: DVec3,
    high: DVec3,
}

impl ScreenBounds {
    const EVERYWHERE: Self =
        Self { low: DVec3::splat(f64::NEG_INFINITY), high: DVec3::splat(f64::INFINITY) };

    /// Conservative bounds; `None` outside the picture.
    pub fn new(light: &Light, camera: &View) -> Option<Self> {
        let reach = Reach::new(light, camera);
        if reach.per_radius == 0.0 {
            return Some(Self::EVERYWHERE);
        }
        let mut center = reach.center.as_dvec3();
        let mut radius = 1.0 / f64::from(reach.per_radius);
        if let LightKind::Spot { direction, angle, .. } = light.kind.with_unit_direction() {
            // Bounding sphere of the cone.
            let axis = camera.view_from_world.transform_vector3(direction).as_dvec3();
            let axis = axis * DVec3::new(1.0, -1.0, -1.0);
            let (sine, cosine) = (f64::from(angle) * 0.5).sin_cos();
            let (along, around) =
                if cosine > sine { (0.5 / cosine, 0.5 / cosine) } else { (cosine, sine) };
            center += axis * (along * radius);
            radius *= around * (1.0 + 1e-5);
        }
        let half = camera.size.as_dvec2() * 0.5 / f64::from(camera.scale);
        let screen = Self {
            low: (-half).extend(f64::from(camera.near)),
            high: half.extend(f64::from(camera.far)),
        };
        let x = slopes(DVec2::new(center.x, center.z), radius)?;
        let y = slopes(DVec2::new(center.y, center.z), radius)?;
        let bounds = Self {
            low: DVec3::new(x.x, y.x, center.z - radius),
            high: DVec3::new(x.y, y.y, center.z + radius),
        };
        bounds.overlaps(&screen).then_some(bounds)
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// Slopes between which a circle is seen; `None` behind the eye.
fn slopes(center: DVec2, radius: f64) -> Option<DVec2> {
    if center.y + radius <= 0.0 {
        return None;
    }
    let distance = center.length();
    if distance <= radius * 1.0001 {
        return Some(DVec2::new(f64::NEG_INFINITY, f64::INFINITY));
    }
    let (angle, half) = (center.x.atan2(center.y), (radius / distance).asin());
    let slope = |angle: f64, beyond: f64| {
        if angle.abs() >= std::f64::consts::FRAC_PI_2 { beyond } else { angle.tan() }
    };
    let pad = 1e-6;
    let low = slope(angle - half - pad, f64::NEG_INFINITY);
    let high = slope(angle + half + pad, f64::INFINITY);
    Some(DVec2::new(low, high))
}

impl MaskSlots {
    /// Greedy assignment in the order of the lights; lights keep their former slots if possible.
    pub fn new(
        scene: &Scene,
        settings: &MaskSettings,
        camera: &View,
        former: &FormerSlots,
    ) -> Self {
        let tinting = tinting_bounds(scene);
        let wants = scene.lights.iter().map(|light| {
            // Masks have eight bits and end at 1.
            let is_masked = light.view_count() > 0 && light.caustics == 0;
            let bounds = Some(light).filter(|_| is_masked);
            let bounds = bounds.and_then(|light| ScreenBounds::new(light, camera));
            bounds.map(|bounds| (bounds, scene.shadow.colored || is_tinted(light, &tinting)))
        });
        let wants: Vec<_> = wants.collect();
        let names: Vec<_> = scene.lights.iter().map(|light| light.name.as_str()).collect();
        let thrown = scene.lights.iter().filter(|light| light.caustics > 0).count() as u32;
        let slots = Self::assign(&wants, &names, settings.limit, former);
        Self { unmasked: slots.unmasked + thrown, ..slots }
    }

    /// `wants`: for each light that casts shadows into the picture, its bounds, and whether its shadows are
    /// coloured.
    pub fn assign(
        wants: &[Option<(ScreenBounds, bool)>],
        names: &[&str],
        limit: u32,
        former: &FormerSlots,
    ) -> Self {
        let mut taken: Vec<Vec<(u32, ScreenBounds)>> = Vec::new();
        let mut of_lights = vec![0; wants.len()];
        // All slots of a mask are of its first light's kind.
        let fits = |taken: &[Vec<(u32, ScreenBounds)>], slot: u32, bounds: &ScreenBounds| {
            let mask = ((slot & !COLORED_BIT) - 1) / SLOTS;
            let others = taken.get(mask as usize).map_or(&[][..], Vec::as_slice);
            mask < limit
                && others.iter().all(|(other, place)| {
                    (other & COLORED_BIT == slot & COLORED_BIT)
                        && (*other != slot || !place.overlaps(bounds))
                })
        };
        let place = |taken: &mut Vec<Vec<_>>, slot: u32, bounds: ScreenBounds| {
            let mask = (((slot & !COLORED_BIT) - 1) / SLOTS) as usize;
            if taken.len() <= mask {
                taken.resize(mask + 1, Vec::new());
            }
            taken[mask].push((slot, bounds));
            slot
        };
        for (i, want) in wants.iter().enumerate() {
            let (Some((bounds, colored)), Some(&slot)) = (want, former.get(names[i])) else {
                continue;
            };
            if slot != 0 && (slot & COLORED_BIT != 0) == *colored && fits(&taken, slot, bounds) {
                of_lights[i] = place(&mut taken, slot, *bounds);
            }
        }
        let mut unmasked = 0;
        for (i, want) in wants.iter().enumerate() {
            let Some((bounds, colored)) = want.filter(|_| of_lights[i] == 0) else { continue };
            let step = if colored { SLOTS } else { 1 };
            let kind = if colored { COLORED_BIT } else { 0 };
            let mut slots = (0..limit * SLOTS).step_by(step as usize).map(|at| (at + 1) | kind);
            match slots.find(|&slot| fits(&taken, slot, &bounds)) {
                Some(slot) => of_lights[i] = place(&mut taken, slot, bounds),
                None => unmasked += 1,
            }
        }
        Self { of_lights, count: taken.len() as u32, unmasked }
    }

    /// Slots by the lights' names, for the next frame.
    pub fn former<'a>(&self, lights: impl Iterator<Item = &'a Light>) -> FormerSlots {
        let names = lights.map(|light| light.name.clone());
        names.zip(self.of_lights.iter().copied()).filter(|&(_, slot)| slot != 0).collect()
    }
}

/// Bounds of all casters that filter light.
fn tinting_bounds(scene: &Scene) -> Bounds {
    let tints: Vec<_> = scene
        .materials
        .iter()
        .map(|material| Class::FILTERING.contains(&Class::of(material)))
        .collect();
    let is = |material: u32| tints.get(material as usize).copied().unwrap_or(false);
    let particles = scene.particles.iter().filter(|particle| is(particle.material));
    let bounds = particles.fold(Bounds::EMPTY, |b, p| b.with_sphere(p.center, p.radius));
    let gaussians = scene.gaussians.iter().filter(|gaussian| is(gaussian.material));
    let bounds = gaussians.fold(bounds, |b, gaussian| {
        b.with(&gaussian.bounds(scene.materials[gaussian.material as usize].gaussian))
    });
    let emissions = scene.emissions.iter().filter(|emission| is(emission.emitter.material));
    let bounds = emissions.fold(bounds, |b, emission| b.with(&emission.bounds()));
    let grids = scene.grids.iter().filter(|grid| is(grid.material));
    let bounds = grids.fold(bounds, |b, grid| b.with(&grid.bounds()));
    let strands = scene.strands.iter().filter(|strand| is(strand.material));
    let bounds = strands.fold(bounds, |b, strand| b.with(&strand.bounds()));
    let corners =
        scene.triangles.iter().filter(|triangle| is(triangle.material)).flat_map(|t| t.positions);
    corners.fold(bounds, |b, p| b.with_sphere(p, 0.0))
}

fn is_tinted(light: &Light, tinting: &Bounds) -> bool {
    let place = light.kind.with_unit_direction();
    let (LightKind::Spot { position, .. } | LightKind::Point { position }) = place else {
        return !tinting.is_empty();
    };
    let Some(range) = light.range() else { return !tinting.is_empty() };
    let nearest = position.clamp(tinting.min, tinting.max);
    !tinting.is_empty() && nearest.distance(position) <= range
}

/// Size of the masks of a picture \[pixels\].
pub fn mask_size(size: UVec2, half: bool) -> UVec2 {
    if half { (size + 1) / 2 } else { size }
}
