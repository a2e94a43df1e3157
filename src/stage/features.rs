//! Kinds of casters and views of a batch: kernels are specialised to them.
use crate::gpu::Constant;

/// Kinds of casters and views of a batch, to which kernels are specialised. Hash key of the pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Features {
    pub particles: bool,
    pub triangles: bool,
    pub textures: bool,
    pub puffs: bool,
    pub quads: bool,
    pub gain: bool,
    /// Blending is order-dependent.
    pub over: bool,
    /// Some casters are so faint that products of transmittances lose their absorption to rounding.
    pub faint: bool,
    /// Some closed meshes absorb along the ray.
    pub volumes: bool,
    /// Maps hold owner tags of the nearest depth.
    pub owners: bool,
    pub dither: bool,
    /// Opaque triangles of a few texels have a kernel of their own.
    pub small: bool,
    /// All casters are soft discs of the `filter` transfer.
    pub plain: bool,
    /// All casters are opaque triangles without texture or pattern.
    pub solid: bool,
    /// The views are perspective ones; for plain casters only.
    pub perspective: bool,
    /// There are opaque casters as well; for plain casters only.
    pub opaque: bool,
    /// Tiles have many casters; for plain casters only.
    pub dense: bool,
    /// Discs are collected in a queue; for plain casters only, and no property of them.
    pub queued: bool,
    /// Nodes of a curve (K); 0 without curves.
    pub nodes: u32,
    /// Curves are softened; no property of casters.
    pub softening: bool,
    /// Kernels of the picture count the cost of each pixel; no property of casters.
    pub cost: bool,
    /// The picture has air; no property of casters.
    pub air: bool,
    /// The picture has an environment of its own; no property of casters.
    pub environment: bool,
    /// The picture has translucent casters.
    pub layers: bool,
    /// Some order-dependent casters are triangles.
    pub panes: bool,
    /// Some light is an area light; no property of casters.
    pub areas: bool,
    /// Some map is read with another filter than the spline; no property of casters.
    pub filters: bool,
    /// Lights of the picture have masks; no property of casters.
    pub masks: bool,
    /// Some light of the picture reads maps; no property of casters.
    pub shadows: bool,
    /// Masks that one invocation computes: 1, 2 or 4; no property of casters.
    pub masks_at_once: u32,
}

impl Features {
    /// Traits of an empty set of casters.
    pub const NONE: Self = Self {
        particles: false,
        triangles: false,
        textures: false,
        puffs: false,
        quads: false,
        gain: false,
        over: false,
        faint: false,
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
        softening: false,
        cost: false,
        air: false,
        environment: false,
        layers: false,
        panes: false,
        areas: false,
        filters: false,
        masks: false,
        shadows: true,
        masks_at_once: 1,
    };

    pub const ALL: Self = Self {
        particles: true,
        triangles: true,
        textures: true,
        puffs: true,
        quads: true,
        gain: true,
        over: true,
        faint: true,
        volumes: true,
        owners: true,
        dither: true,
        plain: false,
        solid: false,
        ..Self::NONE
    };

    /// Whether segments are composed one by one, and tiny particles are not scattered.
    pub fn is_composed(self) -> bool {
        self.nodes == 0 && (self.over || self.volumes || self.owners)
    }

    /// Traits of the union of two sets of casters.
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
            faint: self.faint || other.faint,
            volumes: self.volumes || other.volumes,
            owners: self.owners || other.owners,
            dither: self.dither || other.dither,
            small: self.small || other.small,
            plain: self.plain && other.plain,
            solid: self.solid && other.solid,
            ..Self::NONE
        }
    }

    /// Traits for a batch of views: all perspective or none, with opaque casters or without.
    #[must_use]
    pub fn of_views(self, perspective: bool, opaque: bool) -> Self {
        Self { perspective: self.plain && perspective, opaque: self.plain && opaque, ..self }
    }

    /// Traits for a way to walk tiles.
    #[must_use]
    pub fn of_walk(self, dense: bool, queued: bool) -> Self {
        Self { dense: self.plain && dense, queued: self.plain && queued, ..self }
    }

    /// Values of the overrides of `wgsl/features.wgsl`.
    pub fn constants(self) -> Vec<Constant> {
        let flags = [
            ("HAS_PARTICLES", self.particles),
            ("HAS_TRIANGLES", self.triangles),
            ("HAS_TEXTURES", self.textures),
            ("HAS_PUFFS", self.puffs),
            ("HAS_QUADS", self.quads),
            ("HAS_GAIN", self.gain),
            ("HAS_OVER", self.over),
            ("FAINT", self.faint),
            ("HAS_VOLUMES", self.volumes),
            ("HAS_OWNERS", self.owners),
            ("HAS_DITHER", self.dither),
            ("HAS_SMALL", self.small),
            ("PERSPECTIVE", self.perspective),
            ("HAS_OPAQUE", self.opaque),
            ("DENSE", self.dense),
            ("HAS_SOFTENING", self.softening),
            ("COUNT_COST", self.cost),
            ("HAS_AIR", self.air),
            ("HAS_ENVIRONMENT", self.environment),
            ("HAS_LAYERS", self.layers),
            ("HAS_PANES", self.panes),
            ("HAS_FILTERS", self.filters),
            ("HAS_SHADOWS", self.shadows),
        ];
        let flags = flags.map(|(name, is)| (name, f64::from(u8::from(is))));
        let counts = [("NODES", f64::from(self.nodes)), ("MASKS", f64::from(self.masks_at_once))];
        flags.into_iter().chain(counts).collect()
    }
}
