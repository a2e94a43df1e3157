//! Twin of `wgsl/sums/scatter.wgsl`: casters added straight to their texels, in fixed point.
use super::{
    accumulate::{FIXED_ONE, MAX_LIGHT, MAX_TAU, Modes, VISIBLE_OPACITY, merge},
    caster_hit::{Records, Target},
    tile::{TEXELS, Tile, TileTexels},
};
use crate::{
    model::TILE_SIZE,
    records::{Footprint, GpuView, TileRect},
};
use glam::{IVec3, UVec2, Vec2, Vec3};

/// Float in 0..1 of random bits.
fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// Dither added before rounding down, with channels a third apart. Particles with equal opacity must not
/// all round the same way: a million roundings of 1/2 unit are 8 of optical depth. Multiples of the golden
/// ratio: their sums over runs of casters deviate less than random ones.
fn spread(id: u32) -> Vec3 {
    let turn = id.wrapping_mul(2_654_435_769);
    let third = |i: u32| unit_float(turn.wrapping_add(i.wrapping_mul(0x5555_5555)));
    Vec3::new(third(0), third(1), third(2))
}

/// Optical depth of an absorbed share, with full precision where the share is small.
fn absorbed_tau(absorbed: Vec3) -> Vec3 {
    let least = 1.0 - MAX_LIGHT;
    absorbed.map(|x| -(-x.clamp(least, 1.0)).ln_1p()).min(Vec3::splat(MAX_TAU))
}

/// Sums of scattered casters for a view's texels, tile by tile.
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

    /// Adds one caster to its texels. `opaque`: depths of the view's texels, tile by tile.
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
            for (place, texel) in target.texels(&Tile::new(records.view, index)) {
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
        let tau = absorbed_tau(hit.absorbed - hit.added) * FIXED_ONE + spread(target.id);
        merge(&mut self.tau[sum], tau.floor().as_ivec3(), modes);
        if hit.opacity >= VISIBLE_OPACITY {
            self.nearest[sum] = self.nearest[sum].min(hit.depth);
        }
        self.tiles[tile] = true;
    }

    /// Whether anything was scattered to a tile.
    pub(super) fn has(&self, tile: u32) -> bool {
        self.tiles[tile as usize]
    }

    /// Optical depth and nearest depth of a tile's texel.
    pub fn texel(&self, tile: u32, place: usize) -> (IVec3, f32) {
        let at = tile as usize * TEXELS + place;
        (self.tau[at], self.nearest[at])
    }
}

/// Tile of a texel, counted from the view's first, and its index in the tile.
fn place_of(view: &GpuView, texel: UVec2) -> (usize, usize) {
    let tile = texel / TILE_SIZE;
    let rest = texel % TILE_SIZE;
    ((tile.y * view.tiles_x + tile.x) as usize, (rest.y * TILE_SIZE + rest.x) as usize)
}
