//! Twin of `wgsl/driver/` with the states `wgsl/state/filter.wgsl`, `discs.wgsl` and `ordered.wgsl`:
//! transmittance, and depth of the nearest translucent hit.
//!
//! The transmittances of a tile's pairs are multiplied front to back, a segment at a time; a tile with one
//! segment is then done. Several segments, or scattered casters, add optical depths in fixed point: integer
//! sums do not depend on the order. With order-dependent blending, hits wait for late ones, across the ends
//! of segments too, and segments are composed.
use super::{
    caster_hit::{Hit, Records, Target},
    order::HitOrder,
    scatter::ScatterSums,
    tile::{TEXELS, Tile, TileTexels},
};
use crate::records::{Footprint, GpuView, INVISIBLE, NO_OWNER, owner_tag};
use glam::{DVec3, IVec3, Vec2, Vec3};

/// Pairs of a segment.
pub const SEGMENT: usize = 2048;
/// Pairs at the end of a segment whose hits go to the next one if they are behind its front.
pub const OVERLAP: usize = 256;
/// Optical depth 1 in fixed point.
pub const FIXED_ONE: f32 = 65536.0;
/// Largest addend of optical depth: past ln 1024 a texel is black.
pub const MAX_TAU: f32 = 7.0;
/// [`MAX_TAU`] in fixed point.
pub const SATURATED: i32 = 7 << 16;
/// Largest transmittance of one addend: two `gain` casters at their brightest.
pub const MAX_LIGHT: f32 = 256.0;
/// Least opacity of a hit that sets the nearest depth.
pub const VISIBLE_OPACITY: f32 = 1.0 / 255.0;

fn to_tau(light: Vec3) -> Vec3 {
    let least = (-MAX_TAU).exp();
    -light.clamp(Vec3::splat(least), Vec3::splat(MAX_LIGHT)).map(f32::ln)
}

/// Properties of a view's casters that select how they are composed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modes {
    /// A `gain` caster may amplify light: no early termination at saturation.
    pub gain: bool,
    /// An `over` caster makes blending order-dependent: segments are composed, not added.
    pub ordered: bool,
    /// Closed meshes absorb along the ray: their sums are signed.
    pub volumes: bool,
    /// Some receiver is tinted by all casters except its own object's.
    pub owners: bool,
}

impl Modes {
    /// Whether segments are composed one by one, and tiny particles are not scattered.
    pub fn direct(self) -> bool {
        self.ordered || self.volumes || self.owners
    }
}

pub(super) fn merge(sum: &mut IVec3, tau: IVec3, modes: Modes) {
    if modes.volumes {
        *sum = sum.wrapping_add(tau);
        return;
    }
    let gain = modes.gain;
    let open = |sum: i32| gain || sum < SATURATED;
    let added = sum.saturating_add(tau);
    *sum = IVec3::new(
        if open(sum.x) { added.x } else { sum.x },
        if open(sum.y) { added.y } else { sum.y },
        if open(sum.z) { added.z } else { sum.z },
    );
}

/// Transfer of one segment's casters at a texel: `L` becomes `L * scale + added`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Passed {
    scale: DVec3,
    added: DVec3,
    nearest: f32,
    /// Optical depth of volumes, modulo 2^32.
    tau: IVec3,
    /// Volumes that the ray leaves, minus those that it enters.
    leaves: i32,
    /// Owner tag of the caster that set `nearest`.
    owner: u16,
    /// Hits out of order.
    late: u32,
}

impl Passed {
    const ALL: Self = Self {
        scale: DVec3::ONE,
        added: DVec3::ZERO,
        nearest: 1.0,
        tau: IVec3::ZERO,
        leaves: 0,
        owner: NO_OWNER,
        late: 0,
    };

    fn pass(&mut self, hit: &Hit) {
        // 64 bits keep the absorption of each of a million faint casters.
        let light = DVec3::ONE - hit.absorbed.as_dvec3();
        self.scale *= light;
        self.added = self.added * light + hit.added.as_dvec3();
    }

    fn cross(&mut self, target: &Target<'_>, texel: Vec2, opaque_depth: f32) {
        if let Some(crossing) = target.crossing(texel, opaque_depth) {
            self.tau = self.tau.wrapping_add(crossing.tau);
            self.leaves += crossing.leaves;
        }
    }

    fn see(&mut self, hit: &Hit, id: u32) {
        if hit.opacity >= VISIBLE_OPACITY && hit.depth < self.nearest {
            (self.nearest, self.owner) = (hit.depth, owner_tag(id));
        }
    }
}

/// A texel before `resolve`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accumulated {
    pub light: Light,
    /// `D`
    pub nearest: f32,
    /// Owner tag of `nearest`.
    pub owner: u16,
    /// Hits out of order.
    pub late: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Product of transmittances.
    Passed(Vec3),
    /// Optical depth in fixed point.
    Sums(IVec3),
}

/// Accumulates a tile: `pairs` are its footprints with their depth keys, front to back; `index` counts from
/// the view's first tile.
pub fn accumulate(
    records: Records<'_>,
    index: u32,
    pairs: &[(&Footprint, u32)],
    opaque: &TileTexels<f32>,
    scattered: Option<&ScatterSums>,
    modes: Modes,
) -> TileTexels<Accumulated> {
    let tile = Tile::new(records.view, index);
    let scattered = scattered.filter(|sums| sums.has(index));
    let direct = modes.direct() || (pairs.len() <= SEGMENT && scattered.is_none());
    let light = if direct { Light::Passed(Vec3::ONE) } else { Light::Sums(IVec3::ZERO) };
    let mut texels =
        TileTexels::filled(Accumulated { light, nearest: 1.0, owner: NO_OWNER, late: 0 });
    let mut volumes = TileTexels::filled((IVec3::ZERO, 0));
    for first in (0..pairs.len()).step_by(SEGMENT) {
        let passed = if modes.ordered {
            ordered_segment(records, &tile, pairs, first, opaque)
        } else {
            segment_of(records, &tile, &pairs[first..pairs.len().min(first + SEGMENT)], opaque)
        };
        for place in 0..TEXELS {
            let (texel, passed) = (&mut texels[place], passed[place]);
            if passed.nearest < texel.nearest {
                (texel.nearest, texel.owner) = (passed.nearest, passed.owner);
            }
            texel.late += passed.late;
            let (tau, leaves) = &mut volumes[place];
            (*tau, *leaves) = (tau.wrapping_add(passed.tau), *leaves + passed.leaves);
            match &mut texel.light {
                Light::Passed(light) => {
                    *light = *light * passed.scale.as_vec3() + passed.added.as_vec3();
                }
                Light::Sums(sums) => {
                    let tau = (to_tau(passed.scale.as_vec3()) * FIXED_ONE).round().as_ivec3();
                    merge(sums, tau, modes);
                }
            }
        }
    }
    if let Some(scattered) = scattered {
        for place in 0..TEXELS {
            let (texel, (tau, nearest)) = (&mut texels[place], scattered.texel(index, place));
            if nearest < texel.nearest {
                (texel.nearest, texel.owner) = (nearest, NO_OWNER);
            }
            match &mut texel.light {
                Light::Passed(light) if !modes.volumes => {
                    *light *= super::resolve::passed(tau);
                }
                Light::Passed(_) => {
                    volumes[place].0 = volumes[place].0.wrapping_add(tau);
                }
                Light::Sums(sums) => merge(sums, tau, modes),
            }
        }
    }
    for place in (0..TEXELS).filter(|_| modes.volumes) {
        let (texel, (tau, leaves)) = (&mut texels[place], volumes[place]);
        // The light is inside a volume.
        if leaves > 0 {
            texel.nearest = 0.0;
        }
        if let Light::Passed(light) = &mut texel.light {
            // A mesh that is not closed would brighten.
            let tau = if modes.gain { tau } else { tau.max(IVec3::ZERO) };
            *light *= super::resolve::passed(tau);
        }
    }
    texels
}

fn segment_of(
    records: Records<'_>,
    tile: &Tile,
    pairs: &[(&Footprint, u32)],
    opaque: &TileTexels<f32>,
) -> TileTexels<Passed> {
    let mut passed = TileTexels::filled(Passed::ALL);
    for (footprint, _) in pairs {
        let target = Target::new(records, footprint);
        if !target.filters() {
            continue;
        }
        for (place, texel) in target.texels(tile) {
            passed[place].cross(&target, texel, opaque[place]);
            if let Some(hit) = hit_before(&target, texel, opaque[place]) {
                passed[place].pass(&hit);
                passed[place].see(&hit, target.id);
            }
        }
    }
    passed
}

/// Hit in front of the opaque surface.
fn hit_before(target: &Target<'_>, texel: Vec2, opaque_depth: f32) -> Option<Hit> {
    target.hit(texel, opaque_depth).filter(|hit| hit.depth < opaque_depth)
}

/// Like [`segment_of`], for the segment that starts at pair `first`, with sorted hits. It includes those
/// hits of the previous segment's last [`OVERLAP`] pairs that are behind its own front.
fn ordered_segment(
    records: Records<'_>,
    tile: &Tile,
    pairs: &[(&Footprint, u32)],
    first: usize,
    opaque: &TileTexels<f32>,
) -> TileTexels<Passed> {
    let end = pairs.len().min(first + SEGMENT);
    let mut passed = TileTexels::filled((Passed::ALL, HitOrder::new(Hit::NONE)));
    for i in first.saturating_sub(OVERLAP)..end {
        let target = Target::new(records, pairs[i].0);
        if !target.filters() {
            continue;
        }
        for (place, texel) in target.texels(tile) {
            let (passed, order) = &mut passed[place];
            if i >= first {
                passed.cross(&target, texel, opaque[place]);
            }
            let front = |pair: usize| front_depth(records.view, pairs[pair].1, texel);
            let Some(hit) = hit_before(&target, texel, opaque[place]) else { continue };
            let is_own = if i < first {
                hit.depth >= front(first)
            } else {
                end == pairs.len() || i + OVERLAP < end || hit.depth < front(end)
            };
            if is_own {
                passed.see(&hit, target.id);
                if let Some((_, hit)) = order.push(hit.depth, hit) {
                    passed.pass(&hit);
                }
            }
        }
    }
    let mut composed = TileTexels::filled(Passed::ALL);
    for place in 0..TEXELS {
        let (passed, order) = &mut passed[place];
        order.drain().for_each(|(_, hit)| passed.pass(&hit));
        passed.late = order.late;
        composed[place] = *passed;
    }
    composed
}

/// Least light depth at `texel` of the hits of a caster with depth key `key`, for keys by distance.
fn front_depth(view: &GpuView, key: u32, texel: Vec2) -> f32 {
    let front = key as f32 / (INVISIBLE - 1) as f32;
    if view.perspective > 0.0 { view.depth_of_key(texel, front) } else { front }
}
