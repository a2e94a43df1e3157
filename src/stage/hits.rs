//! What a batch holds: kernels leave out the rest.
use crate::gpu::Constant;

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
    /// Some are so faint that products of transmittances lose what they absorb.
    pub faint: bool,
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
    /// The picture has air; no property of casters.
    pub air: bool,
    /// The picture has an environment of its own; no property of casters.
    pub environment: bool,
    /// The picture has casters that are not solid.
    pub layers: bool,
    /// Of these, some are triangles.
    pub panes: bool,
    /// Some light has a size; no property of casters.
    pub areas: bool,
    /// Some map is read otherwise than by the spline; no property of casters.
    pub filters: bool,
    /// Lights of the picture have masks; no property of casters.
    pub masks: bool,
    /// Some light of the picture asks maps; no property of casters.
    pub shadows: bool,
    /// Masks that an invocation takes at once: 1, 2 or 4; no property of casters.
    pub masks_at_once: u32,
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
        small: false,
        plain: false,
        solid: false,
        perspective: false,
        opaque: false,
        dense: false,
        queued: false,
        nodes: 0,
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
            faint: self.faint || other.faint,
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
            air: false,
            environment: false,
            layers: false,
            panes: false,
            areas: false,
            filters: false,
            masks: false,
            shadows: true,
            masks_at_once: 1,
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
