//! Memory of the host, probed before it is used: an allocation that fails later aborts the program without a
//! remedy.
use super::failure::Failure;
use gobo::{
    gpu::Backend,
    model::{Strand, View},
    records::{FormerSlots, MaskSlots},
    view::{atlas::AtlasLimits, picture_views},
};
use gobo_reference::mask::SeenSurface;
use gobo_reference::records::air_columns;
use gobo_scene::Scene;

/// Memory that a command needs for a scene, besides its casters.
#[derive(Clone, Copy, Debug, Default)]
pub struct Needs {
    pub backend_is_cpu: bool,
    /// Whether maps are read back from a device.
    pub maps: bool,
    pub picture: bool,
    /// Points whose light is looked up at a time.
    pub points: u64,
}

impl Needs {
    pub(super) fn of(backend: Backend) -> Self {
        Self { backend_is_cpu: backend == Backend::Cpu, ..Self::default() }
    }

    pub(super) fn check(&self, scene: &Scene) -> Result<(), Failure> {
        self.missing(scene).map_or(Ok(()), |bytes| Err(Failure::Memory(bytes)))
    }

    /// The needed memory, if the host cannot allocate it \[bytes\].
    pub fn missing(&self, scene: &Scene) -> Option<u64> {
        let bytes = self.bytes(scene);
        let mut probe = Vec::<u8>::new();
        let is_there = usize::try_from(bytes).is_ok_and(|n| probe.try_reserve_exact(n).is_ok());
        // Otherwise the compiler may remove the allocation.
        std::hint::black_box(&mut probe);
        (!is_there).then_some(bytes)
    }

    /// Points in world space and in the scene's, their order, and their results.
    fn of_points(&self, scene: &Scene) -> u64 {
        self.points.saturating_mul(64 + 12 * scene.lights.len() as u64)
    }

    /// Estimate [bytes].
    fn bytes(&self, scene: &Scene) -> u64 {
        let mut bytes = self.of_points(scene);
        if self.maps || self.backend_is_cpu {
            bytes = bytes.saturating_add(self.of_maps(scene));
        }
        // Uploaded records of casters; or, for the CPU reference, records with copies, footprints, keys,
        // rectangles and setups, also for the picture.
        let [particle, triangle] = if self.backend_is_cpu { [256, 640] } else { [32, 128] };
        // In addition to a particle's: axes and a setup; the capsule's own record and particle.
        let [gaussian, capsule] = if self.backend_is_cpu { [80, 144] } else { [32, 128] };
        let emitted: u64 = scene.motions.iter().map(|motion| motion.most_particles()).sum();
        // Voxels of a brick on the device, or those of the scene, and its own record.
        let brick = if self.backend_is_cpu { 1536 } else { 4672 };
        let made: u64 = scene.motions.iter().map(|motion| motion.most_bricks()).sum();
        let bricks = scene.grids.iter().map(|grid| grid.bricks.len() as u64).sum::<u64>() + made;
        let gaussians = scene.gaussians.len() as u64;
        let segments = |strand: &Strand| strand.vertices.len().saturating_sub(1) as u64;
        let dragged: u64 = scene.motions.iter().map(|motion| motion.most_vertices()).sum();
        let capsules = scene.strands.iter().map(segments).sum::<u64>() + dragged;
        let particles = scene.particles.len() as u64 + emitted + bricks + gaussians + capsules;
        let casters = particle * particles
            + triangle * scene.triangles.len() as u64
            + brick * bricks
            + gaussian * gaussians
            + capsule * capsules;
        bytes = bytes.saturating_add(casters);
        if self.picture {
            bytes = bytes.saturating_add(self.of_picture(scene));
        }
        bytes
    }

    fn of_maps(&self, scene: &Scene) -> u64 {
        let (views, _) = picture_views(scene, &AtlasLimits::CORE);
        let shadow = &scene.shadow.within_curve_budget(&views);
        let nodes = u64::from(shadow.curve_nodes());
        // F, D and Z of a texel, its channels and nodes.
        let texel = 20 + 12 * u64::from(shadow.colored) + 8 * nodes;
        let texels = views.iter().map(|view| u64::from(view.size.x) * u64::from(view.size.y));
        let (all, most) =
            texels.fold((0, 0), |(sum, most), texels| (sum + texels, texels.max(most)));
        let mut bytes = all.saturating_mul(texel);
        if self.backend_is_cpu {
            // Memory of the CPU reference per texel of the view that it renders, softens or blurs.
            let filters = shadow.soften || shadow.blur > 0;
            let of_texel = 64 + 24 * nodes + u64::from(filters) * (128 + 8 * nodes);
            bytes = bytes.saturating_add(most * of_texel);
            if scene.lights.iter().any(|light| light.source.is_some()) {
                // Mip levels: four nodes for a block of four texels, of nine, and so on.
                bytes = bytes.saturating_add(all * 24);
            }
        }
        if self.maps {
            // Arrays and previews of the view that is being written.
            bytes = bytes.saturating_add(most * (24 + 20 * nodes));
        }
        bytes
    }

    /// Linear and displayed light of the mean picture, one sample, and the CPU reference's layers, masks and
    /// air.
    fn of_picture(&self, scene: &Scene) -> u64 {
        let size = scene.camera.size;
        let pixels = u64::from(size.x) * u64::from(size.y);
        if !self.backend_is_cpu {
            return 80 * pixels;
        }
        let mut bytes = 192 * pixels;
        if let Some(settings) = &scene.mask {
            let camera = View::from_camera(&scene.camera, &scene.held_bounds());
            let masks = MaskSlots::new(scene, settings, &camera, &FormerSlots::new()).count;
            // Surfaces by tile and by row, with their pixels, and values of a mask before and after a blur.
            let surface = 3 * size_of::<SeenSurface>() as u64;
            bytes = bytes.saturating_add((surface + 16 * (u64::from(masks) + 4)) * pixels);
        }
        if let Some(air) = &scene.air {
            let columns = air_columns(size);
            let slices = u64::from(columns.x) * u64::from(columns.y) * u64::from(air.steps);
            bytes = bytes.saturating_add(16 * slices);
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::{
        glam::Vec3,
        model::{Gaussian, Material, StrandVertex},
    };

    #[test]
    fn every_kind_of_caster_counts() {
        for needs in [Needs::of(Backend::Auto), Needs::of(Backend::Cpu)] {
            let empty = needs.bytes(&gobo_scene::empty_scene());
            let mut splats = gobo_scene::empty_scene();
            splats.materials = vec![Material::default()];
            splats.gaussians = vec![Gaussian::default(); 1000];
            assert!(needs.bytes(&splats) >= empty + 64 * 1000);
            let mut fur = gobo_scene::empty_scene();
            let vertices = vec![StrandVertex::new(Vec3::ZERO, 0.1); 5];
            fur.strands = vec![Strand { vertices, ..Strand::default() }; 250];
            assert!(needs.bytes(&fur) >= empty + 160 * 1000);
        }
    }
}
