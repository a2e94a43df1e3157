//! CPU reference of `accumulate`: transmittance of each ray's hits, and the nearest of them.
use super::{
    caster_hit::{Hit, Records, SurfaceCrossing, Target},
    tile::{TEXELS, Tile, TileTexels},
};
use glam::{DVec3, Vec3};
use gobo::records::{Footprint, NO_OWNER, owner_tag};

/// Least presence of a hit that sets the nearest depth.
pub const VISIBLE_PRESENCE: f32 = 1.0 / 255.0;

/// Properties of a view's casters that select how hits are composed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modes {
    /// A `gain` caster may amplify light.
    pub gain: bool,
    /// An `over` caster makes blending depend on the order of the hits.
    pub ordered: bool,
    /// Closed meshes absorb along the ray.
    pub volumes: bool,
    /// Some receiver is tinted by all casters except its own object's.
    pub owners: bool,
}

/// A texel before it is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accumulated {
    /// Product of the hits' transmittances, `F`.
    pub light: Vec3,
    /// `D`
    pub nearest: f32,
    /// Owner tag of `nearest`.
    pub owner: u16,
}

impl Accumulated {
    /// A texel without hits.
    pub const NONE: Self = Self { light: Vec3::ONE, nearest: 1.0, owner: NO_OWNER };
}

/// A ray in front of its opaque surface. 64 bits keep the absorption of each of a million faint casters.
#[derive(Clone, Debug)]
struct TexelRay {
    passed: DVec3,
    /// Hits in order of depth, if the order matters.
    hits: Vec<Hit>,
    /// Optical depth of volumes.
    tau: DVec3,
    /// Number of volumes that the ray leaves minus number that it enters.
    leaves: i32,
    nearest: f32,
    owner: u16,
}

impl TexelRay {
    const EMPTY: Self = Self {
        passed: DVec3::ONE,
        hits: Vec::new(),
        tau: DVec3::ZERO,
        leaves: 0,
        nearest: 1.0,
        owner: NO_OWNER,
    };

    fn meet(&mut self, hit: &Hit, id: u32, modes: Modes) {
        if hit.presence >= VISIBLE_PRESENCE && hit.depth < self.nearest {
            (self.nearest, self.owner) = (hit.depth, owner_tag(id));
        }
        if modes.ordered {
            let behind = self.hits.partition_point(|other| other.depth <= hit.depth);
            self.hits.insert(behind, *hit);
        } else {
            self.passed *= DVec3::ONE - hit.absorbed.as_dvec3();
        }
    }

    fn cross(&mut self, face: &SurfaceCrossing) {
        let depth = f64::from(face.depth) * f64::from(face.metres);
        self.tau += f64::from(face.leaves) * depth * face.absorption.as_dvec3();
        self.leaves += face.leaves;
    }

    fn accumulated(&self, modes: Modes) -> Accumulated {
        let Self { mut passed, mut tau, leaves, mut nearest, owner, .. } = *self;
        for hit in &self.hits {
            passed = passed * (DVec3::ONE - hit.absorbed.as_dvec3()) + hit.added.as_dvec3();
        }
        if !modes.gain {
            // A mesh that is not closed would amplify light.
            tau = tau.max(DVec3::ZERO);
        }
        if leaves > 0 {
            // The light is inside a volume.
            nearest = 0.0;
        }
        Accumulated { light: (passed * (-tau).map(f64::exp)).as_vec3(), nearest, owner }
    }
}

/// Accumulates a tile. `footprints`: of its pairs, front to back; `index`: counted from the view's first
/// tile.
pub fn accumulate<'a>(
    records: Records<'_>,
    index: u32,
    footprints: impl Iterator<Item = &'a Footprint>,
    opaque: &TileTexels<f32>,
    modes: Modes,
) -> TileTexels<Accumulated> {
    let tile = Tile::new(records.view, index);
    let mut rays = TileTexels::filled(TexelRay::EMPTY);
    for footprint in footprints {
        let target = Target::new(records, footprint);
        if !target.filters() {
            continue;
        }
        for (in_tile, texel) in target.texels(&tile) {
            let (ray, end) = (&mut rays[in_tile], opaque[in_tile]);
            if let Some(face) = target.face(texel, end) {
                ray.cross(&face);
            }
            if let Some(hit) = target.hit(texel, end).filter(|hit| hit.depth < end) {
                ray.meet(&hit, target.id, modes);
            }
        }
    }
    let mut texels = TileTexels::filled(Accumulated::NONE);
    (0..TEXELS).for_each(|in_tile| texels[in_tile] = rays[in_tile].accumulated(modes));
    texels
}
