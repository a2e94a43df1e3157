//! Lights as kernels read them.
use super::GpuView;
use crate::model::{Light, LightKind, LookUp, ShadowFilter, ShadowSettings};
use glam::Vec3;
use std::ops::Range;

/// Most lights of a picture. A point that evaluates all of them with nine taps each stays below the 65,535
/// iterations that llvmpipe allows an invocation.
pub const MAX_LIGHTS: usize = 4096;
/// Most shadow views of a picture: for each light, four shadows of six views.
pub const MAX_SHADOW_VIEWS: usize = 4 * 6 * MAX_LIGHTS;
/// Texels of a [`GpuLight`]. WGSL: `wgsl/records/light.wgsl`.
pub const LIGHT_TEXELS: u32 = 5;
const _: () = assert!(size_of::<GpuLight>() == LIGHT_TEXELS as usize * 16);
/// Texels of a [`GpuView`]. WGSL: `wgsl/records/light.wgsl`.
pub const VIEW_TEXELS: u32 = 8;
const _: () = assert!(size_of::<GpuView>() == VIEW_TEXELS as usize * 16);

/// Numbers of [`LightKind`] in [`GpuLight::kind`].
pub const LIGHT_DIRECTIONAL: u32 = 0;
/// Kind of a spot.
pub const LIGHT_SPOT: u32 = 1;
/// Kind of a point light.
pub const LIGHT_POINT: u32 = 2;

/// Numbers of [`ShadowFilter`] in [`GpuLight::taps`].
pub const FILTER_NONE: u32 = 0;
/// Percentage closer filtering over a square; bilinear with one tap.
pub const FILTER_BOX: u32 = 1;
/// A spline over a square.
pub const FILTER_SPLINE: u32 = 2;
/// Taps on a Vogel disc.
pub const FILTER_DISC: u32 = 3;
/// Fixed-point steps of a disc's radius per texel. WGSL: `wgsl/shade/taps.wgsl`.
pub const RADIUS_STEPS: f32 = 256.0;
/// Half the support of the spline \[texels\]. WGSL: `wgsl/shade/taps.wgsl`.
pub const SPLINE_REACH: f32 = 1.5;
/// Most taps of all lights of a picture together: a point that evaluates them stays below the 65,535
/// iterations that llvmpipe allows an invocation.
pub const MAX_TAPS: u32 = 40_960;

/// Fields of [`GpuLight::traits`].
pub const SHAFTS_BIT: u32 = 1;
/// First bit of the area's index plus 1, 0 for none.
pub const AREA_SHIFT: u32 = 1;
/// Mask of that number.
pub const AREA_MASK: u32 = 0xff;
/// First bit of the number of viewpoints, less one.
pub const VIEWPOINTS_SHIFT: u32 = 9;
/// Mask of that number.
pub const VIEWPOINTS_MASK: u32 = 0xf;
/// A spot's light falls off by the square of its share of the cosines.
pub const INNER_BIT: u32 = 1 << 13;
/// The window at the end of the light's range is not squared.
pub const END_BIT: u32 = 1 << 14;
/// The bias is in texels, not in metres.
pub const TEXELS_BIT: u32 = 1 << 15;

/// Depth bias where none is stated, for lights without and with a size \[texels\]: spots of the latter may
/// cross the planes of the surfaces they shade.
const BIAS_TEXELS: f32 = 0.25;
const SOFT_BIAS_TEXELS: f32 = 4.0;
/// Least and largest bias in texels, as shares of the view's depth range. The least is two steps of a curve's
/// depths.
pub const LEAST_BIAS: f32 = 1.0 / 32768.0;
/// See [`LEAST_BIAS`].
pub const LARGEST_BIAS: f32 = 1.0 / 512.0;
/// Least bias of a receiver that is a caster, whose neighbours overlap it \[texels\].
pub const CASTER_BIAS: f32 = 4.0;
/// Least cosine of a slope that a bias in texels covers alone: 66 degrees.
pub const LEAST_COSINE: f32 = 0.4;

/// Least difference of the cosines of a spot's cones (glTF `KHR_lights_punctual`).
const LEAST_FALL: f32 = 1e-3;

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/light.wgsl`.
    pub struct GpuLight {
        /// Position, world space \[m\].
        pub position: Vec3,
        pub kind: u32,
        /// Direction in which light travels: unit, world space.
        pub direction: Vec3,
        pub first_view: u32,
        /// Linear rgb times the intensity.
        pub color: Vec3,
        /// Number of views; 0 if the light casts no shadow.
        pub view_count: u32,
        /// Cosines of half the angle of a spot: at the end of its light, and where it begins to fade.
        pub cone_outer: f32,
        pub cone_inner: f32,
        /// Reciprocal square of the range [1/m^2]; 0 if the light has no end.
        pub per_range2: f32,
        /// [`SHAFTS_BIT`] if the air scatters its light; from [`AREA_SHIFT`] on its area's index plus 1, 0
        /// for none; from [`VIEWPOINTS_SHIFT`] on the number of its viewpoints, less one; [`INNER_BIT`] if a
        /// spot falls off by the square of its share of the cosines, [`END_BIT`] if the window at the end of
        /// its range is not squared, [`TEXELS_BIT`] if its bias is in texels.
        pub traits: u32,
        /// Filter: its kind, from bit 8 on the bilinear taps per side or the taps of a disc, from bit 16 on a
        /// disc's radius [1/256 texel].
        pub taps: u32,
        /// Depth bias \[m\]; \[texels\] with [`TEXELS_BIT`].
        pub bias: f32,
        /// Slope-scaled bias \[texels\].
        pub slope_bias: f32,
        /// Normal offset \[texels\].
        pub normal_bias: f32,
    }
}

impl GpuLight {
    /// `views`: indices of its views among the shadow views of all lights; `settings`: defaults of its
    /// look-up.
    pub fn new(light: &Light, views: Range<u32>, settings: &ShadowSettings) -> Self {
        let LookUp { filter, bias, slope_bias, normal_bias } = light.look_up;
        let (kind, position, direction, angle) = match light.kind.with_unit_direction() {
            LightKind::Directional { direction } => (LIGHT_DIRECTIONAL, Vec3::ZERO, direction, 0.0),
            LightKind::Spot { position, direction, angle } => {
                (LIGHT_SPOT, position, direction, angle)
            }
            LightKind::Point { position } => (LIGHT_POINT, position, Vec3::NEG_Y, 0.0),
        };
        let outer = (angle * 0.5).cos();
        let inner = match light.inner_angle {
            None => (angle * 0.5 * 0.85).cos(),
            Some(inner) => (inner * 0.5).cos().max(outer + LEAST_FALL),
        };
        let range = light.range();
        let bias = bias.or(settings.bias);
        let is_soft = light.area().is_some();
        let usual_bias = if is_soft { SOFT_BIAS_TEXELS } else { BIAS_TEXELS };
        let bits = [
            (light.shafts, SHAFTS_BIT),
            (light.inner_angle.is_some(), INNER_BIT),
            (range.is_some() && range == light.end, END_BIT),
            (bias.is_none(), TEXELS_BIT),
        ];
        Self {
            position,
            kind,
            direction,
            first_view: views.start,
            color: light.color * light.intensity,
            view_count: views.len() as u32,
            cone_outer: outer,
            cone_inner: inner,
            per_range2: range.map_or(0.0, |range| 1.0 / (range * range)),
            traits: bits.into_iter().filter(|(is_so, _)| *is_so).map(|(_, bit)| bit).sum(),
            taps: packed_filter(&filter.unwrap_or(settings.filter)),
            bias: bias.unwrap_or(usual_bias),
            slope_bias: slope_bias.unwrap_or(settings.slope_bias),
            normal_bias: normal_bias.unwrap_or(settings.normal_bias),
        }
    }

    /// Depth bias in a view \[m\]. A bias in texels covers as much of the slope as it can, so that the point
    /// moves less. `texel`: edge of a texel at the receiver's depth \[m\]; `sine`: of the slope; `least`:
    /// \[texels\].
    pub fn depth_bias(&self, view: &GpuView, texel: f32, sine: f32, least: f32) -> f32 {
        if self.traits & TEXELS_BIT == 0 {
            return self.bias;
        }
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let slope = self.normal_bias * sine / cosine.max(LEAST_COSINE);
        let range = view.far - view.near;
        (self.bias.max(least).max(slope) * texel).max(LEAST_BIAS * range).min(LARGEST_BIAS * range)
    }

    /// Whether its maps are read with another filter than the spline, or with a slope-scaled bias.
    pub fn is_filtered(&self) -> bool {
        self.view_count > 0 && (self.taps != FILTER_SPLINE || self.slope_bias != 0.0)
    }

    /// Texels that a point reads from one of its maps.
    pub fn tap_count(&self) -> usize {
        let count = (self.taps >> 8 & 0xff) as usize;
        if self.view_count == 0 {
            return 0;
        }
        match self.taps & 0xff {
            FILTER_SPLINE => 9,
            FILTER_BOX => (count + 1) * (count + 1),
            FILTER_DISC => count,
            _ => 1,
        }
    }

    /// Parts of its source that have views of their own.
    pub fn viewpoints(&self) -> usize {
        (self.traits >> VIEWPOINTS_SHIFT & VIEWPOINTS_MASK) as usize + 1
    }

    /// Index of its area; `None` for a point source.
    pub fn area(&self) -> Option<usize> {
        ((self.traits >> AREA_SHIFT & AREA_MASK) as usize).checked_sub(1)
    }
}

fn packed_filter(filter: &ShadowFilter) -> u32 {
    match *filter {
        ShadowFilter::None => FILTER_NONE,
        ShadowFilter::Bilinear => FILTER_BOX | (1 << 8),
        ShadowFilter::Spline => FILTER_SPLINE,
        ShadowFilter::Pcf { taps } => FILTER_BOX | (taps.min(ShadowFilter::MAX_PCF) << 8),
        ShadowFilter::Vogel { taps, radius } => {
            let steps = (radius.clamp(0.0, ShadowFilter::MAX_RADIUS) * RADIUS_STEPS).round();
            FILTER_DISC | (taps.clamp(1, ShadowFilter::MAX_VOGEL) << 8) | ((steps as u32) << 16)
        }
    }
}
