//! Lights as a scene describes them.
use super::{LookUp, MAX_VIEWPOINTS, Source};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// Kind of a light, with its position and direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel rays.
    Directional {
        /// Direction in which light travels: world space, any length.
        direction: Vec3,
    },
    /// A cone of rays from a point.
    Spot {
        /// Apex of the cone, world space \[m\].
        position: Vec3,
        /// Direction of the cone's axis, away from the light: world space, any length.
        direction: Vec3,
        /// Opening angle of the whole cone, above 0 and below pi \[radians\]. It has a soft edge:
        /// [`Light::inner_angle`].
        angle: f32,
    },
    /// Rays from a point in all directions.
    Point {
        /// Position, world space \[m\].
        position: Vec3,
    },
}

impl LightKind {
    /// The kind with a unit direction. A direction of unit length up to rounding keeps its bits; an invalid
    /// one ([`Light::check`]) points down.
    #[must_use]
    pub fn with_unit_direction(self) -> Self {
        let unit = |direction| unit(direction).unwrap_or(Vec3::NEG_Y);
        match self {
            Self::Directional { direction } => Self::Directional { direction: unit(direction) },
            Self::Spot { position, direction, angle } => {
                Self::Spot { position, direction: unit(direction), angle }
            }
            Self::Point { .. } => self,
        }
    }

    fn problem(&self) -> Option<&'static str> {
        let (position, direction, angle) = match *self {
            Self::Directional { direction } => (Vec3::ZERO, direction, 1.0),
            Self::Spot { position, direction, angle } => (position, direction, angle),
            Self::Point { position } => (position, Vec3::NEG_Y, 1.0),
        };
        if !position.is_finite() {
            return Some("its position must be finite");
        }
        if unit(direction).is_none() {
            return Some("its direction must be finite and not zero");
        }
        let is_cone = angle > 0.0 && angle < std::f32::consts::PI;
        (!is_cone).then_some("its angle must be above 0 and below pi radians")
    }
}

fn unit(direction: Vec3) -> Option<Vec3> {
    /// Rounding error of a unit vector's squared length.
    const ROUNDING: f64 = 1e-6;
    // Squares of any 32-bit float fit 64 bits.
    let long = direction.as_dvec3();
    if (long.length_squared() - 1.0).abs() <= ROUNDING {
        return Some(direction);
    }
    long.try_normalize().map(DVec3::as_vec3)
}

/// Error of a light that no shadow view fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("light {index} cannot be used: {problem}")]
#[non_exhaustive]
pub struct InvalidLight {
    /// Index of the light.
    pub index: usize,
    /// The problem.
    pub problem: &'static str,
}

/// Shadow maps of a directional light that follow the camera: fine near it, coarse far from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cascades {
    /// Number of cascades, clamped to 1..=6. Default 4.
    pub count: u32,
    /// Practical split (Zhang et al. 2006), 0..=1: 0 for equal ranges, 1 for equal ratios. Default 0.8.
    pub lambda: f32,
    /// Share of a map's half edge over which it fades into the next, 0..=0.5. Default 0.1.
    pub fade: f32,
    /// Distance from the camera up to which there are shadows, above 0 \[m\]; when `None`, all of the scene.
    pub range: Option<f32>,
}

impl Default for Cascades {
    fn default() -> Self {
        Self { count: 4, lambda: 0.8, fade: 0.1, range: None }
    }
}

impl Cascades {
    fn problem(&self) -> Option<&'static str> {
        let &Self { lambda, fade, range, .. } = self;
        let is_range = |range: f32| range > 0.0 && range.is_finite();
        let is_valid = (0.0..=1.0).contains(&lambda)
            && (0.0..=0.5).contains(&fade)
            && range.is_none_or(is_range);
        (!is_valid).then_some(
            "of its cascades lambda must be 0 to 1, fade 0 to 0.5 and range above 0 and finite",
        )
    }

    /// Number of cascades, clamped to its range.
    pub fn count(&self) -> u32 {
        self.count.clamp(1, MAX_CASCADES)
    }
}

/// Most cascades of a shadow.
pub const MAX_CASCADES: u32 = 6;
/// Most shadows of a light, including its own.
pub const MAX_SHADOWS: usize = 4;

/// Largest number of rays along the edge of a texel that glass refracts.
pub const MAX_CAUSTIC_RAYS: u32 = 8;
/// Largest map on which refracted light lands, if it is its light's only one; half as large if not
/// \[texels\].
pub const MAX_CAUSTIC_SIZE: u32 = 2048;
/// Largest number of points along the edge of a light's map that send its light on.
pub const MAX_BOUNCE: u32 = 32;
/// Most points of all lights that send light on.
pub const MAX_BOUNCES: u32 = 1024;

/// One shadow of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// Light that the shadow is rendered from: a map for a direction or a cone, a cube map for a point.
    pub kind: LightKind,
    /// First depth of its views \[m\]; chosen from the bounds when `None`.
    pub near: Option<f32>,
    /// Last depth of its views \[m\]; chosen from the bounds when `None`.
    pub far: Option<f32>,
    /// Edge of each view's map \[texels\]; chosen when `None`.
    pub size: Option<u32>,
    /// Cascades of a directional light; one view that fits the whole scene when `None`.
    pub cascades: Option<Cascades>,
}

/// A light and its shadows.
///
/// From frame to frame, [`Self::color`], [`Self::intensity`], [`Self::look_up`] and [`Self::shafts`] cost
/// only the bytes written. [`Self::kind`], [`Self::near`], [`Self::far`] and the extent of [`Self::cascades`]
/// change views, whose maps are rendered anew. [`Self::size`], [`Self::casts`] and the numbers of
/// [`Self::cascades`] and [`Self::shadows`] also change the atlas: maps that stay are copied. The size of a
/// [`Self::source`] costs its levels, which are made in every frame; its kind costs nothing more.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name for people and file names; masks keep the slots of lights by it. Default `light`.
    pub name: String,
    /// Kind, position and direction. Default: directional, straight down.
    pub kind: LightKind,
    /// Linear rgb, 0 or more. Default white.
    pub color: Vec3,
    /// Irradiance at normal incidence: of a directional light, or at 1 m from others. 0 or more; default 1.
    pub intensity: f32,
    /// First depth of the shadow views, above 0 for spots and points \[m\]. Default `None`: from the bounds.
    pub near: Option<f32>,
    /// Last depth of the shadow views, beyond the first \[m\]. The light of a spot or point fades out towards
    /// it. Default `None`: chosen from the bounds, and the light has no end.
    pub far: Option<f32>,
    /// Edge of each view's map, 16..=4096 \[texels\]. Default `None`: by importance, up to the scene's.
    pub size: Option<u32>,
    /// Opening angle of a spot's inner cone, 0 up to the whole \[radians\], with full light. Towards the
    /// whole cone, light falls by the square of the cosine's share (glTF `KHR_lights_punctual`). Default
    /// `None`: 0.85 of the whole, from which it falls by a cubic: to half at 0.93 of the angle, about 0.9 of
    /// its tangent.
    pub inner_angle: Option<f32>,
    /// Distance at which the light of a spot or point ends, above 0 \[m\]: it also falls by
    /// `1 - (distance / end)^4` (glTF's `range`). Default `None`: as for [`Self::far`].
    pub end: Option<f32>,
    /// Whether the light has shadow views at all. Default true.
    pub casts: bool,
    /// Cascades of a directional light. Default `None`: one view that fits the whole scene.
    pub cascades: Option<Cascades>,
    /// Further shadows, at most three; more are ignored. Per channel, the shadow with the least light counts;
    /// outside its maps, a further shadow transmits everything. Default none.
    pub shadows: Vec<Shadow>,
    /// Whether the air scatters its light, if the scene has air. Default true.
    pub shafts: bool,
    /// Emitting surface of an area light, which gives penumbrae. Default `None`: a point.
    pub source: Option<Source>,
    /// Parts of the source (Heckbert and Herf 1997), each with maps from its middle and penumbrae of its own
    /// size: 1..=[`MAX_VIEWPOINTS`]; for round sources 1 or at least 3, for a point light's sphere 1, 4 or 8.
    /// Their light is averaged. Maps and look-ups cost that many times as much. Default 1.
    pub viewpoints: u32,
    /// Rays along each edge of a texel, up to [`MAX_CAUSTIC_RAYS`], that faces with
    /// [`Fresnel::Face`](super::Fresnel::Face) refract onto opaque surfaces. For lights without a source and
    /// without further shadows, with one map of at most [`MAX_CAUSTIC_SIZE`] texels a side or several of at
    /// most half that. Default 0: straight shadows.
    pub caustics: u32,
    /// Points along each edge of a map, up to [`MAX_BOUNCE`], that send the light that arrives there once
    /// more: a diffuse bounce off opaque triangles, in the picture only. A point light has six maps; of
    /// cascades the last counts. All lights together have at most [`MAX_BOUNCES`] points. Default 0: none.
    pub bounce: u32,
    /// How receivers read its maps. Default: as [`ShadowSettings`](super::ShadowSettings) says.
    pub look_up: LookUp,
}

impl Default for Light {
    /// A white directional light, straight down.
    fn default() -> Self {
        Self {
            name: "light".to_owned(),
            kind: LightKind::Directional { direction: Vec3::NEG_Y },
            color: Vec3::ONE,
            intensity: 1.0,
            near: None,
            far: None,
            size: None,
            inner_angle: None,
            end: None,
            casts: true,
            cascades: None,
            shadows: Vec::new(),
            shafts: true,
            source: None,
            viewpoints: 1,
            caustics: 0,
            bounce: 0,
            look_up: LookUp::default(),
        }
    }
}

/// Choices for a light with a size when its scene was loaded.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SoftLight {
    /// Name of the light.
    pub light: String,
    /// Edge of its maps at which nearly all its penumbrae span three texels; 0 if it has none \[texels\].
    pub asked: u32,
    /// Edge of its maps \[texels\].
    pub size: u32,
    /// Its viewpoints.
    pub viewpoints: u32,
}

impl Shadow {
    /// Fault of its depths or cascades.
    fn problem(&self) -> Option<&'static str> {
        // The planes of a sun may be behind the middle of the scene.
        let first = match self.kind {
            LightKind::Directional { .. } => f32::MIN,
            _ => f32::MIN_POSITIVE,
        };
        let is_within = |depth: f32| (first..=f32::MAX).contains(&depth);
        let is_behind = self.far.is_none_or(|far| far > self.near.unwrap_or(0.0));
        if !([self.near, self.far].into_iter().flatten().all(is_within) && is_behind) {
            return Some(
                "its near and far must be finite, a spot's or point's above 0, far behind near",
            );
        }
        self.cascades.as_ref().and_then(Cascades::problem)
    }

    /// Views that the shadow needs.
    pub fn view_count(&self) -> usize {
        match self.kind {
            LightKind::Directional { .. } => self.cascades.map_or(1, |c| c.count() as usize),
            LightKind::Spot { .. } => 1,
            LightKind::Point { .. } => 6,
        }
    }
}

impl Light {
    /// A directional light that travels along `direction` (world space, any length).
    pub fn directional(direction: impl Into<[f32; 3]>) -> Self {
        let direction = Vec3::from(direction.into());
        Self { kind: LightKind::Directional { direction }, ..Self::default() }
    }

    /// A spot light around `direction` (world space, any length); `angle` is the whole cone \[radians\].
    pub fn spot(position: impl Into<[f32; 3]>, direction: impl Into<[f32; 3]>, angle: f32) -> Self {
        let (position, direction) = (position.into().into(), direction.into().into());
        Self { kind: LightKind::Spot { position, direction, angle }, ..Self::default() }
    }

    /// A point light.
    pub fn point(position: impl Into<[f32; 3]>) -> Self {
        let position = Vec3::from(position.into());
        Self { kind: LightKind::Point { position }, ..Self::default() }
    }

    /// Checks all numbers of the light and its further shadows. `index`: the light's.
    ///
    /// If a number contradicts its field's documentation: not finite, a direction of zero, a cone without an
    /// angle, a negative size.
    pub fn check(&self, index: usize) -> Result<(), InvalidLight> {
        let kinds =
            std::iter::once(&self.kind).chain(self.shadows.iter().map(|shadow| &shadow.kind));
        let of_source = self.source.iter().filter_map(|source| source.problem(&self.kind));
        let of_viewpoints =
            self.source.iter().filter_map(|it| it.parts_problem(&self.kind, self.viewpoints));
        let of_fall = [(self.inner_angle, 0.0), (self.end, f32::MIN_POSITIVE)]
            .into_iter()
            .filter(|&(number, least)| number.is_some_and(|number| !(least..).contains(&number)))
            .map(|_| "its inner angle must be 0 or more, and its end above 0");
        let problems = kinds.filter_map(LightKind::problem).chain(of_source).chain(of_viewpoints);
        let sent = self.color.extend(self.intensity);
        let is_sent = sent.is_finite() && sent.cmpge(Vec4::ZERO).all();
        let of_sent =
            (!is_sent).then_some("its color and intensity must be finite and not negative");
        let own = Shadow {
            kind: self.kind,
            near: self.near,
            far: self.far,
            size: self.size,
            cascades: self.cascades,
        };
        let of_shadows = std::iter::once(&own).chain(&self.shadows).filter_map(Shadow::problem);
        let problems = problems.chain(of_fall).chain(of_sent).chain(of_shadows);
        let problems = problems.chain(self.caustics_problem()).chain(self.bounce_problem());
        let problem = problems.chain(self.look_up.problem()).next();
        problem.map_or(Ok(()), |problem| Err(InvalidLight { index, problem }))
    }

    /// Reason why its caustics cannot be made.
    pub fn caustics_problem(&self) -> Option<&'static str> {
        if self.caustics == 0 {
            None
        } else if self.caustics > MAX_CAUSTIC_RAYS {
            Some("its caustics have at most 8 rays along the edge of a texel")
        } else if !self.casts {
            Some("caustics are made from the light's maps, and it casts no shadow")
        } else if self.area().is_some() {
            Some("glass would throw the light of each point of its source elsewhere")
        } else if !self.shadows.is_empty() {
            Some("a further shadow would also shade light that glass throws past it")
        } else {
            let is_large = self.size.is_some_and(|size| size > self.largest_caustic_map());
            is_large.then_some(if self.view_count() == 1 {
                "with caustics its map has at most 2048 texels a side"
            } else {
                "with caustics each of its maps has at most 1024 texels a side"
            })
        }
    }

    /// Largest edge of its maps with caustics \[texels\].
    pub(crate) fn largest_caustic_map(&self) -> u32 {
        if self.view_count() == 1 { MAX_CAUSTIC_SIZE } else { MAX_CAUSTIC_SIZE / 2 }
    }

    /// Reason why no light can be sent on from its maps.
    pub fn bounce_problem(&self) -> Option<&'static str> {
        if self.bounce == 0 {
            None
        } else if !self.casts {
            Some("a bounce is made from the light's maps, and it casts no shadow")
        } else if self.bounce > MAX_BOUNCE || self.bounce_count() > MAX_BOUNCES {
            Some("its bounce has at most 32 points along an edge, of a point light 13")
        } else {
            None
        }
    }

    /// Points that send its light on.
    pub fn bounce_count(&self) -> u32 {
        let maps = if matches!(self.kind, LightKind::Point { .. }) { 6 } else { 1 };
        if self.casts { maps * self.bounce.pow(2) } else { 0 }
    }

    /// The source that softens its shadows; `None` without shadows or without a size.
    pub fn area(&self) -> Option<Source> {
        self.source.filter(|source| self.casts && !source.is_point())
    }

    /// Distance at which the light ends \[m\]; `None` for no end.
    pub fn range(&self) -> Option<f32> {
        match self.kind {
            LightKind::Directional { .. } => None,
            LightKind::Spot { .. } | LightKind::Point { .. } => {
                let ends = [self.far, self.end].into_iter().flatten().filter(|&end| end > 0.0);
                ends.reduce(f32::min)
            }
        }
    }

    /// Its own shadow, one per part of its source, then the further ones; none if the light casts none.
    pub fn all_shadows(&self) -> impl Iterator<Item = Shadow> + '_ {
        let Self { near, far, size, cascades, .. } = *self;
        let count = self.viewpoint_count();
        let shadow = move |index| Shadow { kind: self.viewpoint(index), near, far, size, cascades };
        let all = (0..count).map(shadow).chain(self.shadows.iter().copied());
        all.take(if self.casts { count as usize + MAX_SHADOWS - 1 } else { 0 })
    }

    /// Parts of its source that have shadows of their own; 1 without a source.
    pub fn viewpoint_count(&self) -> u32 {
        self.area().map_or(1, |_| self.viewpoints.clamp(1, MAX_VIEWPOINTS))
    }

    /// The light from the middle of a part of its source; for a sun, its direction.
    fn viewpoint(&self, index: u32) -> LightKind {
        let Some(source) = self.area().filter(|_| self.viewpoint_count() > 1) else {
            return self.kind;
        };
        let count = self.viewpoint_count();
        let Vec2 { x, y } = source.part_middle(count, index);
        match self.kind.with_unit_direction() {
            LightKind::Directional { direction } => {
                let (right, up) = direction.any_orthonormal_pair();
                let slope = source.half_axes()[0].x;
                LightKind::Directional { direction: direction + (right * x + up * y) * slope }
            }
            LightKind::Spot { position, direction, angle } => {
                let [right, up] = source.facing(direction).half_axes();
                LightKind::Spot { position: position + right * x + up * y, direction, angle }
            }
            LightKind::Point { position } => {
                LightKind::Point { position: position + source.part_place(count, index) }
            }
        }
    }

    /// Shadow views that the light needs.
    pub fn view_count(&self) -> usize {
        self.all_shadows().map(|shadow| shadow.view_count()).sum()
    }

    /// Distance beyond which its irradiance is below 0.01 \[m\]; infinite for a directional light.
    pub fn reach(&self) -> f32 {
        match self.kind {
            LightKind::Directional { .. } => f32::INFINITY,
            _ => (self.color.max_element() * self.intensity / 0.01).max(0.0).sqrt(),
        }
    }
}
