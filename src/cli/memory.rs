//! Memory of the host, asked for before it is used: an allocation that fails later aborts the program
//! without a remedy.
use super::failure::Failure;
use gobo::{
    gpu::Backend,
    scene::Scene,
    view::{atlas::AtlasLimits, fitted_views},
};

/// What a command needs of a scene besides its casters.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Needs {
    pub(super) backend_is_cpu: bool,
    /// Whether maps are read back from a device.
    pub(super) maps: bool,
    pub(super) picture: bool,
    /// Points whose light is looked up.
    pub(super) points: u64,
}

impl Needs {
    pub(super) fn of(backend: Backend) -> Self {
        Self { backend_is_cpu: backend == Backend::Cpu, ..Self::default() }
    }

    pub(super) fn check(&self, scene: &Scene) -> Result<(), Failure> {
        let bytes = self.bytes(scene);
        let mut probe = Vec::<u8>::new();
        let is_there = usize::try_from(bytes).is_ok_and(|n| probe.try_reserve_exact(n).is_ok());
        // Otherwise the compiler may leave the allocation out.
        std::hint::black_box(&mut probe);
        if !is_there {
            return Err(if self.points > 0 && self.of_points(scene) > bytes / 2 {
                Failure::Points { points: self.points, lights: scene.lights.len(), bytes }
            } else {
                Failure::Memory(bytes)
            });
        }
        Ok(())
    }

    /// Points as read and as records, twice, and their answers, as returned and as a file.
    fn of_points(&self, scene: &Scene) -> u64 {
        self.points.saturating_mul(72 + 24 * scene.lights.len() as u64)
    }

    /// Estimate [bytes].
    fn bytes(&self, scene: &Scene) -> u64 {
        let nodes = u64::from(scene.shadow.curve_nodes());
        let mut bytes = self.of_points(scene);
        if self.maps || self.backend_is_cpu {
            // F, D and Z of a texel, its channels and nodes.
            let texel = 20 + 12 * u64::from(scene.shadow.colored) + 8 * nodes;
            let (views, _) = fitted_views(scene, &AtlasLimits::CORE);
            let texels = views.iter().map(|view| u64::from(view.size.x) * u64::from(view.size.y));
            let (all, most) =
                texels.fold((0, 0), |(sum, most), texels| (sum + texels, texels.max(most)));
            bytes = bytes.saturating_add(all * texel);
            if self.backend_is_cpu {
                // What the twin keeps of a texel of the view that it renders.
                bytes = bytes.saturating_add(most * (64 + 24 * nodes));
            }
        }
        // Records of casters as they are uploaded, or, of the twin, with footprints, keys, rectangles and
        // setups as well.
        let [particle, triangle] = if self.backend_is_cpu { [128, 384] } else { [32, 128] };
        let casters =
            particle * scene.particles.len() as u64 + triangle * scene.triangles.len() as u64;
        bytes = bytes.saturating_add(casters);
        let texels = |t: &gobo::model::Texture| u64::from(t.width) * u64::from(t.height);
        if self.backend_is_cpu {
            // The twin's picture keeps the images of solid and of blended casters, each with a copy of the scene.
            let texel = if self.picture { 2 * (16 + 4) } else { 16 };
            bytes = bytes.saturating_add(texel * scene.textures.iter().map(texels).sum::<u64>());
        }
        if self.picture {
            // Light and shown light of the mean, one sample, and the twin's layers.
            let pixel = if self.backend_is_cpu { 192 } else { 80 };
            let pixels = u64::from(scene.camera.size.x) * u64::from(scene.camera.size.y);
            bytes = bytes.saturating_add(pixel * pixels);
        }
        bytes
    }
}
