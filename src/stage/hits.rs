//! What the kernels that evaluate hits share: sources, bindings and specialisation.
use crate::{
    gpu::{Binding, Constant, FLOAT, Source, join},
    records::{GpuMaterial, GpuView, MAX_MATERIALS, MAX_VIEWS},
};
use wgpu::TextureSampleType::Uint;

/// What a batch holds; kernels leave out the rest. Hash key of the pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Features {
    pub particles: bool,
    pub triangles: bool,
    pub textures: bool,
    pub puffs: bool,
    pub quads: bool,
    pub gain: bool,
    /// The order counts.
    pub over: bool,
    /// Closed meshes absorb along the way through them.
    pub volumes: bool,
    /// Maps say whose the nearest depth is.
    pub owners: bool,
    pub dither: bool,
    /// Opaque triangles of a few texels took a path of their own.
    pub small: bool,
    /// Soft discs of the `filter` transfer and nothing else.
    pub plain: bool,
    /// Opaque triangles without texture or pattern and nothing else.
    pub solid: bool,
    /// The views are perspective ones; of plain casters only.
    pub perspective: bool,
    /// There are opaque casters as well; of plain casters only.
    pub opaque: bool,
    /// Tiles have many casters; of plain casters only.
    pub dense: bool,
    /// Discs wait in a queue; of plain casters only, and no property of them.
    pub queued: bool,
    /// Of a curve (K); 0 where there are none.
    pub nodes: u32,
    /// Kernels of the picture count what each pixel costs; no property of casters.
    pub cost: bool,
}

impl Features {
    /// Of no caster.
    pub const NONE: Self = Self {
        particles: false,
        triangles: false,
        textures: false,
        puffs: false,
        quads: false,
        gain: false,
        over: false,
        volumes: false,
        owners: false,
        dither: false,
        small: false,
        plain: true,
        solid: true,
        perspective: false,
        opaque: false,
        dense: false,
        queued: false,
        nodes: 0,
        cost: false,
    };

    pub const ALL: Self = Self {
        particles: true,
        triangles: true,
        textures: true,
        puffs: true,
        quads: true,
        gain: true,
        over: true,
        volumes: true,
        owners: true,
        dither: true,
        small: false,
        plain: false,
        solid: false,
        perspective: false,
        opaque: false,
        dense: false,
        queued: false,
        nodes: 0,
        cost: false,
    };

    /// Whether segments are composed one by one, and nothing is scattered by choice.
    pub fn is_composed(self) -> bool {
        self.nodes == 0 && (self.over || self.volumes || self.owners)
    }

    /// Of two sets of casters together.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            particles: self.particles || other.particles,
            triangles: self.triangles || other.triangles,
            textures: self.textures || other.textures,
            puffs: self.puffs || other.puffs,
            quads: self.quads || other.quads,
            gain: self.gain || other.gain,
            over: self.over || other.over,
            volumes: self.volumes || other.volumes,
            owners: self.owners || other.owners,
            dither: self.dither || other.dither,
            small: self.small || other.small,
            plain: self.plain && other.plain,
            solid: self.solid && other.solid,
            perspective: false,
            opaque: false,
            dense: false,
            queued: false,
            nodes: 0,
            cost: false,
        }
    }

    /// Of a batch whose views are all perspective ones, or none is, with opaque casters or without.
    #[must_use]
    pub fn of_views(self, perspective: bool, opaque: bool) -> Self {
        Self { perspective: self.plain && perspective, opaque: self.plain && opaque, ..self }
    }

    /// How tiles are walked.
    #[must_use]
    pub fn of_walk(self, dense: bool, queued: bool) -> Self {
        Self { dense: self.plain && dense, queued: self.plain && queued, ..self }
    }

    /// Values of the overrides of `constants`.
    pub fn constants(self, constants: &[Constant]) -> Vec<Constant> {
        let flag = |name: &str| match name {
            "HAS_PARTICLES" => Some(self.particles),
            "HAS_TRIANGLES" => Some(self.triangles),
            "HAS_TEXTURES" => Some(self.textures),
            "HAS_PUFFS" => Some(self.puffs),
            "HAS_QUADS" => Some(self.quads),
            "HAS_GAIN" => Some(self.gain),
            "HAS_OVER" => Some(self.over),
            "HAS_VOLUMES" => Some(self.volumes),
            "HAS_OWNERS" => Some(self.owners),
            "HAS_DITHER" => Some(self.dither),
            "HAS_SMALL" => Some(self.small),
            "PERSPECTIVE" => Some(self.perspective),
            "HAS_OPAQUE" => Some(self.opaque),
            "DENSE" => Some(self.dense),
            "COUNT_COST" => Some(self.cost),
            _ => None,
        };
        let value = |name: &str, usual: f64| match name {
            "NODES" => f64::from(self.nodes),
            _ => flag(name).map_or(usual, |v| f64::from(u8::from(v))),
        };
        constants.iter().map(|&(name, usual)| (name, value(name, usual))).collect()
    }
}

pub(super) const VIEWS: Binding = Binding::uniform::<[GpuView; MAX_VIEWS]>("views");
pub(super) const MATERIALS: Binding = Binding::uniform::<[GpuMaterial; MAX_MATERIALS]>("materials");
pub(super) const CASTERS: Binding = Binding::texture("casters", Uint);
pub(super) const SETUPS: Binding = Binding::texture("setups", Uint);
pub(super) const IMAGES: Binding = Binding::texture("images", FLOAT).array();
/// Opaque depths of triangles of a few texels.
pub(super) const SMALL_DEPTHS: Binding = Binding::read::<u32>("small_depths");
pub(super) const OPAQUES: Binding = Binding::texture("opaques", FLOAT).array();

/// What all of these kernels need.
pub(super) const CASTER_SOURCES: &[Source] = crate::sources![
    "common/record.wgsl",
    "common/view.wgsl",
    "common/material.wgsl",
    "common/tile_rect.wgsl"
];
/// A hit of any caster: the functions, what they read, and what they can leave out.
pub(super) const HIT_SOURCES: &[Source] = join![
    Source: CASTER_SOURCES,
    crate::sources![
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/rolled.wgsl"
    ],
];
pub(super) const HIT_CONSTANTS: &[Constant] = &[
    ("HAS_PARTICLES", 1.0),
    ("HAS_TRIANGLES", 1.0),
    ("HAS_TEXTURES", 1.0),
    ("HAS_PUFFS", 1.0),
    ROLLED,
];
/// Of `wgsl/common/rolled.wgsl`; the pipeline's configuration says whether.
pub(crate) const ROLLED: Constant = ("ROLLED", 0.0);
/// Of `wgsl/common/wide.wgsl`; the pipeline's configuration says whether.
pub(crate) const WIDE: Constant = ("WIDE", 1.0);
