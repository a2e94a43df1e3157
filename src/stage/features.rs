//! Kinds of casters and views of a batch: kernels are specialised to them.
use crate::gpu::Constant;

bitflags::bitflags! {
    /// Kinds of casters, views and pictures. Most have the name of their override in `wgsl/features.wgsl`.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub struct Flags: u64 {
        /// Some casters are particles, bricks or capsules.
        const HAS_PARTICLES = 1 << 0;
        /// Some casters are triangles.
        const HAS_TRIANGLES = 1 << 1;
        /// Some material has a texture.
        const HAS_TEXTURES = 1 << 2;
        /// Some particles are puffs.
        const HAS_PUFFS = 1 << 3;
        /// Some particles are quads.
        const HAS_QUADS = 1 << 4;
        /// Some caster may amplify light.
        const HAS_GAIN = 1 << 5;
        /// Blending is order-dependent.
        const HAS_OVER = 1 << 6;
        /// Some casters are so faint that products of transmittances lose their absorption to rounding.
        const FAINT = 1 << 7;
        /// Some closed meshes absorb along the ray.
        const HAS_VOLUMES = 1 << 8;
        /// Maps hold owner tags of the nearest depth.
        const HAS_OWNERS = 1 << 9;
        /// Some material is dithered.
        const HAS_DITHER = 1 << 10;
        /// Some casters are not soft discs of the `filter` transfer.
        const NOT_PLAIN = 1 << 11;
        /// Some casters are not splats of the `filter` transfer.
        const NOT_SPLATS = 1 << 33;
        /// Some casters are not opaque triangles without texture or pattern.
        const NOT_SOLID = 1 << 12;
        /// Opaque triangles of a few texels have a kernel of their own.
        const HAS_SMALL = 1 << 13;
        /// The views are perspective ones; for casters of one simple kind only.
        const PERSPECTIVE = 1 << 14;
        /// The views are orthographic ones.
        const PARALLEL = 1 << 36;
        /// The setup of a splat has its footprint's index; for splats alone.
        const SETUPS_IN_ORDER = 1 << 37;
        /// There are opaque casters as well; for casters of one simple kind only.
        const HAS_OPAQUE = 1 << 15;
        /// Tiles have many casters; for casters of one simple kind only.
        const DENSE = 1 << 16;
        /// Casters are collected in a queue; for casters of one simple kind only.
        const QUEUED = 1 << 17;
        /// Curves are softened.
        const HAS_SOFTENING = 1 << 18;
        /// Curves are in pages.
        const HAS_PAGES = 1 << 44;
        /// Kernels of the picture count the cost of each pixel.
        const COUNT_COST = 1 << 19;
        /// The picture takes over the light of surfaces from the one through the first sample of the pixels.
        const TAKES_LIGHT = 1 << 45;
        /// The picture has air.
        const HAS_AIR = 1 << 20;
        /// The picture has an environment of its own.
        const HAS_ENVIRONMENT = 1 << 21;
        /// The picture has translucent casters.
        const HAS_LAYERS = 1 << 22;
        /// Some order-dependent casters are triangles.
        const HAS_PANES = 1 << 23;
        /// Some light is an area light.
        const HAS_AREAS = 1 << 24;
        /// Some casters are Gaussians.
        const HAS_GAUSSIANS = 1 << 28;
        /// Some casters are capsules of strands.
        const HAS_CAPSULES = 1 << 32;
        /// Some particles are discs or quads.
        const HAS_FACING = 1 << 30;
        /// Some Gaussians are media.
        const HAS_MEDIA = 1 << 29;
        /// Some map is read with another filter than the spline.
        const HAS_FILTERS = 1 << 25;
        /// Lights of the picture have masks.
        const HAS_MASKS = 1 << 26;
        /// Some light of the picture reads maps.
        const HAS_SHADOWS = 1 << 27;
        /// Some casters are bricks of voxels.
        const HAS_BRICKS = 1 << 31;
        /// Some triangles have colours at their corners.
        const HAS_VERTEX_COLORS = 1 << 34;
        /// Some pane shows the scene behind it refracted or blurred.
        const HAS_REFRACTION = 1 << 35;
        /// Some triangles reflect a share of the light that depends on its angle.
        const HAS_FRESNEL = 1 << 39;
        /// Some triangles of the picture send light on to their far side.
        const HAS_FAR_SIDES = 1 << 40;
        /// Images say of some triangles of the picture what they are like texel by texel.
        const HAS_DETAILS = 1 << 42;
        /// Some triangles of the picture have a clear coat.
        const HAS_COATS = 1 << 43;
        /// Glass or lit surfaces throw light of some light of the picture.
        const HAS_CAUSTICS = 1 << 41;
        /// Some of the views whose levels are made are faces of cubes.
        const HAS_FACES = 1 << 38;
    }
}

/// Kinds of casters and views of a batch, to which kernels are specialised. Hash key of the pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Features {
    /// Kinds of casters and views.
    pub flags: Flags,
    /// Nodes of a curve (K); 0 without curves.
    pub nodes: u32,
    /// Masks that one invocation computes: 1, 2 or 4.
    pub masks_at_once: u32,
}

/// Kinds of casters that have kernels of their own, for lists without others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simple {
    /// Soft discs.
    Discs,
    /// Gaussians.
    Splats,
}

impl Features {
    /// Features of an empty set of casters.
    pub const NONE: Self = Self { flags: Flags::HAS_SHADOWS, nodes: 0, masks_at_once: 1 };

    /// Features of maps that are read.
    pub fn of_maps(nodes: u32, has_gain: bool) -> Self {
        Self { nodes, ..Self::NONE }.with(Flags::HAS_GAIN, has_gain)
    }

    /// Whether it has all of `flags`.
    pub fn has(self, flags: Flags) -> bool {
        self.flags.contains(flags)
    }

    /// The features with `flags` on or off.
    #[must_use]
    pub fn with(mut self, flags: Flags, on: bool) -> Self {
        self.flags.set(flags, on);
        self
    }

    /// Whether all casters are soft discs of the `filter` transfer.
    pub fn is_plain(self) -> bool {
        !self.has(Flags::NOT_PLAIN)
    }

    /// The only kind of the casters, all of the `filter` transfer.
    pub fn simple(self) -> Option<Simple> {
        if self.is_plain() {
            Some(Simple::Discs)
        } else {
            (!self.has(Flags::NOT_SPLATS)).then_some(Simple::Splats)
        }
    }

    /// Whether curves are made by two walks: all casters only pass light on, and none is a volume, a brick, a
    /// strand or a Gaussian.
    pub fn only_rays(self) -> bool {
        const OTHERS: Flags =
            Flags::HAS_BRICKS.union(Flags::HAS_CAPSULES).union(Flags::HAS_GAUSSIANS);
        !self.flags.intersects(OTHERS | Flags::HAS_VOLUMES | Flags::HAS_OVER)
    }

    /// Whether segments are composed one by one, and tiny particles are not scattered.
    pub fn is_composed(self) -> bool {
        const COMPOSED: Flags = Flags::HAS_OVER.union(Flags::HAS_VOLUMES).union(Flags::HAS_OWNERS);
        self.nodes == 0 && self.flags.intersects(COMPOSED)
    }

    /// Features of the union of two sets of casters.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { flags: self.flags | other.flags, ..Self::NONE }
    }

    /// Features for a batch of views: all perspective or none, with opaque casters or without.
    #[must_use]
    pub fn of_views(self, perspective: bool, opaque: bool) -> Self {
        let is_simple = self.simple().is_some();
        self.with(Flags::PERSPECTIVE, is_simple && perspective)
            .with(Flags::PARALLEL, !perspective)
            .with(Flags::HAS_OPAQUE, is_simple && opaque)
    }

    /// Features for a way to walk tiles.
    #[must_use]
    pub fn of_walk(self, dense: bool, queued: bool) -> Self {
        let is_simple = self.simple().is_some();
        self.with(Flags::DENSE, is_simple && dense).with(Flags::QUEUED, is_simple && queued)
    }

    /// Values of the overrides of `wgsl/features.wgsl`, and of flags that no kernel reads.
    pub fn constants(self) -> Vec<Constant> {
        let flags = Flags::all().iter_names();
        let flags = flags.map(|(name, flag)| (name, f64::from(u8::from(self.has(flag)))));
        let counts = [("NODES", f64::from(self.nodes)), ("MASKS", f64::from(self.masks_at_once))];
        flags.chain(counts).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Flags;

    #[test]
    fn each_flag_has_a_bit_of_its_own() {
        let all = Flags::all().bits().count_ones() as usize;
        assert_eq!(all, <Flags as bitflags::Flags>::FLAGS.len());
    }
}
