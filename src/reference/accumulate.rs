//! Twin of `wgsl/driver/accumulate_*.wgsl`: the light that passes, and the depth of the nearest
//! translucent hit.
//!
//! A tile's pairs are multiplied up front to back, a segment at a time. A tile with one segment
//! is done then. Where several segments or scattered casters meet, optical depths are added in
//! fixed point: sums of integers are the same in every order.
use super::{
    caster_hit::{Hit, Records, Target},
    tile::{TEXELS, Tile, TileTexels},
};
use crate::{
    model::TILE_SIZE,
    records::{Footprint, GpuView, NO_OWNER, TileRect, owner_tag, pcg},
};
use glam::{IVec3, UVec2, Vec2, Vec3};

/// Pairs that are multiplied up before their product goes to the sums.
pub const SEGMENT: usize = 2048;
/// Of optical depth.
pub const FIXED_ONE: f32 = 65536.0;
/// What one addend adds at most: past ln 1024 a texel is black.
pub const MAX_TAU: f32 = 7.0;
/// [`MAX_TAU`] in fixed point.
pub const SATURATED: i32 = 7 << 16;
/// The most light that one addend lets pass: two `gain` casters at their brightest.
const MAX_LIGHT: f32 = 256.0;
/// Least opacity of a hit that counts for the nearest depth.
pub const VISIBLE_OPACITY: f32 = 1.0 / 255.0;

/// In 0..1.
fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// What chance adds before rounding down. Particles with equal opacity must not all round the
/// same way: a million roundings of 1/2 unit are 8 of optical depth.
fn chance(id: u32) -> Vec3 {
    let seed = id.wrapping_mul(3);
    Vec3::from_array([0, 1, 2].map(|channel| unit_float(pcg(seed.wrapping_add(channel)))))
}

fn to_tau(light: Vec3) -> Vec3 {
    let least = (-MAX_TAU).exp();
    -light.clamp(Vec3::splat(least), Vec3::splat(MAX_LIGHT)).map(f32::ln)
}

/// What one view's casters do, apart from their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modes {
    /// A `gain` caster may brighten: saturation is no end.
    pub gain: bool,
    /// An `over` caster depends on the order: segments are composed, not added.
    pub ordered: bool,
    /// Closed meshes absorb along the way through them: their sums are signed.
    pub volumes: bool,
    /// Some receiver is tinted by all casters but its own.
    pub owners: bool,
}

impl Modes {
    /// Whether segments are composed one by one, and nothing is scattered by choice.
    pub fn direct(self) -> bool {
        self.ordered || self.volumes || self.owners
    }
}

fn merge(sum: &mut IVec3, tau: IVec3, modes: Modes) {
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

/// What the casters of one segment do to a texel: `L` becomes `L * scale + added`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Passed {
    scale: Vec3,
    added: Vec3,
    nearest: f32,
    /// Of volumes, modulo 2^32.
    tau: IVec3,
    /// How many volumes the ray leaves more than it enters.
    leaves: i32,
    /// Whose `nearest` is.
    owner: u16,
}

impl Passed {
    const ALL: Self = Self {
        scale: Vec3::ONE,
        added: Vec3::ZERO,
        nearest: 1.0,
        tau: IVec3::ZERO,
        leaves: 0,
        owner: NO_OWNER,
    };

    fn meet(&mut self, hit: &Hit, id: u32) {
        self.scale *= hit.light;
        self.added = self.added * hit.light + hit.added;
        if hit.opacity >= VISIBLE_OPACITY && hit.depth < self.nearest {
            (self.nearest, self.owner) = (hit.depth, owner_tag(id));
        }
    }
}

/// What scattered casters add to a view's texels; tile by tile.
#[derive(Clone, Debug)]
pub struct ScatterSums {
    tau: Vec<IVec3>,
    nearest: Vec<f32>,
    tiles: Vec<bool>,
}

impl ScatterSums {
    pub fn new(tile_count: usize) -> Self {
        Self {
            tau: vec![IVec3::ZERO; tile_count * TEXELS],
            nearest: vec![1.0; tile_count * TEXELS],
            tiles: vec![false; tile_count],
        }
    }

    /// One caster, straight to its texels. `opaque`: of the view's texels, tile by tile.
    pub fn scatter(
        &mut self,
        records: Records<'_>,
        footprint: &Footprint,
        rect: &TileRect,
        opaque: &[TileTexels<f32>],
        modes: Modes,
    ) {
        let target = Target::new(records, footprint);
        if !target.filters() {
            return;
        }
        if rect.is_scattered() {
            let first = super::project::scatter_texel(footprint.center);
            for offset in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
                let texel = first + offset;
                if texel.cmpge(Vec2::ZERO).all() && texel.cmplt(records.view.size).all() {
                    let (tile, place) = place_of(records.view, texel.as_uvec2());
                    self.add(&target, texel + 0.5, tile, place, &opaque[tile], modes);
                }
            }
            return;
        }
        for (x, y) in rect.tiles() {
            let index = y * records.view.tiles_x + x;
            let tile = index as usize;
            for (place, texel) in Tile::new(records.view, index).texels() {
                self.add(&target, texel, tile, place, &opaque[tile], modes);
            }
        }
    }

    fn add(
        &mut self,
        target: &Target<'_>,
        texel: Vec2,
        tile: usize,
        place: usize,
        opaque: &TileTexels<f32>,
        modes: Modes,
    ) {
        let sum = tile * TEXELS + place;
        if let Some(crossing) = target.crossing(texel, opaque[place]).filter(|_| modes.volumes) {
            self.tau[sum] = self.tau[sum].wrapping_add(crossing.tau);
            self.tiles[tile] = true;
        }
        let Some(hit) = target.hit(texel, opaque[place]).filter(|hit| hit.depth < opaque[place])
        else {
            return;
        };
        let tau = to_tau(hit.light + hit.added) * FIXED_ONE + chance(target.id);
        merge(&mut self.tau[sum], tau.floor().as_ivec3(), modes);
        if hit.opacity >= VISIBLE_OPACITY {
            self.nearest[sum] = self.nearest[sum].min(hit.depth);
        }
        self.tiles[tile] = true;
    }
}

impl ScatterSums {
    /// Optical depth and nearest depth of a tile's texel.
    pub fn texel(&self, tile: u32, place: usize) -> (IVec3, f32) {
        let at = tile as usize * TEXELS + place;
        (self.tau[at], self.nearest[at])
    }
}

/// Tile of a texel, counted from the view's first, and its place in the tile.
fn place_of(view: &GpuView, texel: UVec2) -> (usize, usize) {
    let tile = texel / TILE_SIZE;
    let rest = texel % TILE_SIZE;
    ((tile.y * view.tiles_x + tile.x) as usize, (rest.y * TILE_SIZE + rest.x) as usize)
}

/// A texel before `resolve`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accumulated {
    pub light: Light,
    /// `D`
    pub nearest: f32,
    /// Whose it is.
    pub owner: u16,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Product of transmittances.
    Passed(Vec3),
    /// Optical depth in fixed point.
    Sums(IVec3),
}

/// Everything that reaches a tile: `footprints` are its pairs, front to back; `index` counts from
/// the view's first tile.
pub fn accumulate(
    records: Records<'_>,
    index: u32,
    footprints: &[&Footprint],
    opaque: &TileTexels<f32>,
    scattered: Option<&ScatterSums>,
    modes: Modes,
) -> TileTexels<Accumulated> {
    let tile = Tile::new(records.view, index);
    let scattered = scattered.filter(|sums| sums.tiles[index as usize]);
    let direct = modes.direct() || (footprints.len() <= SEGMENT && scattered.is_none());
    let light = if direct { Light::Passed(Vec3::ONE) } else { Light::Sums(IVec3::ZERO) };
    let mut texels = TileTexels::filled(Accumulated { light, nearest: 1.0, owner: NO_OWNER });
    let mut volumes = TileTexels::filled((IVec3::ZERO, 0));
    for segment in footprints.chunks(SEGMENT) {
        let passed = segment_of(records, &tile, segment, opaque);
        for place in 0..TEXELS {
            let (texel, passed) = (&mut texels[place], passed[place]);
            if passed.nearest < texel.nearest {
                (texel.nearest, texel.owner) = (passed.nearest, passed.owner);
            }
            let (tau, leaves) = &mut volumes[place];
            (*tau, *leaves) = (tau.wrapping_add(passed.tau), *leaves + passed.leaves);
            match &mut texel.light {
                Light::Passed(light) => *light = *light * passed.scale + passed.added,
                Light::Sums(sums) => {
                    let tau = (to_tau(passed.scale) * FIXED_ONE).round().as_ivec3();
                    merge(sums, tau, modes);
                }
            }
        }
    }
    if let Some(scattered) = scattered {
        for place in 0..TEXELS {
            let (texel, from) = (&mut texels[place], index as usize * TEXELS + place);
            if scattered.nearest[from] < texel.nearest {
                (texel.nearest, texel.owner) = (scattered.nearest[from], NO_OWNER);
            }
            match &mut texel.light {
                Light::Passed(light) if !modes.volumes => {
                    *light *= super::resolve::passed(scattered.tau[from]);
                }
                Light::Passed(_) => {
                    volumes[place].0 = volumes[place].0.wrapping_add(scattered.tau[from]);
                }
                Light::Sums(sums) => merge(sums, scattered.tau[from], modes),
            }
        }
    }
    for place in (0..TEXELS).filter(|_| modes.volumes) {
        let (texel, (tau, leaves)) = (&mut texels[place], volumes[place]);
        // The light is inside.
        if leaves > 0 {
            texel.nearest = 0.0;
        }
        if let Light::Passed(light) = &mut texel.light {
            // A body that is not closed would brighten.
            let tau = if modes.gain { tau } else { tau.max(IVec3::ZERO) };
            *light *= super::resolve::passed(tau);
        }
    }
    texels
}

fn segment_of(
    records: Records<'_>,
    tile: &Tile,
    footprints: &[&Footprint],
    opaque: &TileTexels<f32>,
) -> TileTexels<Passed> {
    let mut passed = TileTexels::filled(Passed::ALL);
    for footprint in footprints {
        let target = Target::new(records, footprint);
        if !target.filters() {
            continue;
        }
        for (place, texel) in tile.texels() {
            if let Some(crossing) = target.crossing(texel, opaque[place]) {
                let passed = &mut passed[place];
                passed.tau = passed.tau.wrapping_add(crossing.tau);
                passed.leaves += crossing.leaves;
            }
            // A hit at or behind the opaque surface does nothing.
            if let Some(hit) = target.hit(texel, opaque[place])
                && hit.depth < opaque[place]
            {
                passed[place].meet(&hit, target.id);
            }
        }
    }
    passed
}
