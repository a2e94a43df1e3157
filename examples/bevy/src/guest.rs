//! gobo in the render world: it borrows Bevy's device, queue and encoders, and submits nothing.
use crate::casters::{SceneCasters, Sun};
use bevy::{
    prelude::*,
    render::renderer::{RenderAdapterInfo, RenderDevice, RenderQueue},
};
use gobo::{
    Bounds, Casters, Error, HostCasters, HostInputs, Light, Prepared, ShadowSettings, Shadows,
    Support, Tier, Triangle,
    host::{LightMasks, MaskView},
    model::MaskSettings,
    wgpu,
};

/// Particles on the device, such as those of an effect that a compute shader moves.
pub trait ParticleSet: Send + Sync + 'static {
    /// Material of the particles. Its number, which the loader returns, is that of [`Guest::add`].
    fn material(&self) -> gobo::Material;

    /// The particles in gobo's form; `materials`: [`Self::material`] for [`HostCasters::new`].
    fn casters<'a>(&'a self, materials: &'a [u32]) -> HostCasters<'a>;

    /// Writes a frame's inputs, before it is recorded.
    fn prepare(&mut self, _queue: &wgpu::Queue) {}

    /// Records the particles' movement, before all cameras.
    fn record(&self, _encoder: &mut wgpu::CommandEncoder) {}
}

/// gobo's settings.
#[derive(Resource, Clone, Copy)]
pub(crate) struct Settings {
    pub shadow: ShadowSettings,
    pub mask: MaskSettings,
    pub bounds: Bounds,
}

/// gobo in the render world, from [`GoboSystems::Open`](crate::GoboSystems) on.
#[derive(Resource)]
pub struct Guest {
    shadows: Shadows,
    sets: Vec<Box<dyn ParticleSet>>,
    masks: LightMasks,
    frame: Option<Frame>,
}

struct Frame {
    prepared: Prepared,
    lights: [Light; 1],
}

impl Guest {
    pub(crate) fn open(
        device: &RenderDevice,
        queue: &RenderQueue,
        adapter: &RenderAdapterInfo,
        settings: &Settings,
    ) -> Result<Self, Error> {
        // Bevy has already opened the device, so missing features cannot be added.
        let support = Support::of(device.wgpu_device(), adapter, &settings.shadow);
        for missing in &support.missing {
            info!("gobo does without {missing}");
        }
        support.check(Tier::Core)?;
        let shadows = Shadows::new(device.wgpu_device(), queue, adapter)?;
        Ok(Self { shadows, sets: Vec::new(), masks: LightMasks::new(), frame: None })
    }

    /// Adds particles. `make` makes their loader from gobo's shadows and the number of their material.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn add<S: ParticleSet>(
        &mut self,
        make: impl FnOnce(&mut Shadows, u32) -> Result<S, Error>,
    ) -> Result<(), Error> {
        let set = make(&mut self.shadows, self.sets.len() as u32)?;
        self.sets.push(Box::new(set));
        self.frame = None;
        Ok(())
    }

    /// The maps of the frame and their lights, for shaders of the app's.
    pub fn maps(&self) -> Option<(&Prepared, &[Light])> {
        self.frame.as_ref().map(|frame| (&frame.prepared, &frame.lights[..]))
    }

    /// Uploads meshes and fits the view if something has changed. Particles are on the device already.
    pub(crate) fn prepare(
        &mut self,
        sun: Sun,
        scene: &SceneCasters,
        settings: &Settings,
        is_changed: bool,
        queue: &wgpu::Queue,
    ) -> Result<(), Error> {
        self.sets.iter_mut().for_each(|set| set.prepare(queue));
        let Some(direction) = sun.0 else {
            self.frame = None;
            return Ok(());
        };
        if self.frame.is_some() && !is_changed {
            return Ok(());
        }
        // glam's types differ between the two versions; arrays do not.
        let lights = [Light::directional(direction.to_array())];
        let views = gobo::light_views(0, &lights[0], settings.shadow.size, None, &settings.bounds)?;
        let count = self.sets.len() as u32;
        let of_sets = self.sets.iter().map(|set| set.material());
        let materials: Vec<_> = of_sets.chain(scene.materials.iter().cloned()).collect();
        let moved = |face: &Triangle| Triangle { material: face.material + count, ..*face };
        let triangles: Vec<_> = scene.triangles.iter().map(moved).collect();
        let casters =
            Casters { triangles: &triangles, materials: &materials, ..Casters::default() };
        let numbers: Vec<[u32; 1]> = (0..count).map(|number| [number]).collect();
        let sets: Vec<_> =
            self.sets.iter().zip(&numbers).map(|(set, number)| set.casters(number)).collect();
        let inputs = HostInputs::new().casters(&sets);
        let prepared = self.shadows.prepare_with(&casters, &views, &settings.shadow, &inputs)?;
        self.frame = Some(Frame { prepared, lights });
        Ok(())
    }

    pub(crate) fn forget(&mut self) {
        self.frame = None;
    }

    /// Records particles and maps, once a frame.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        self.sets.iter().for_each(|set| set.record(encoder));
        self.frame.as_ref().map_or(Ok(()), |frame| frame.prepared.record(encoder))
    }

    /// Records the mask of a camera, from its prepass to the texture that materials read.
    pub(crate) fn record_mask(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        clip_from_world: Mat4,
        [depths, normals]: [&wgpu::Texture; 2],
        mask: &wgpu::Texture,
        settings: &Settings,
    ) -> Result<(), Error> {
        let Some(Frame { prepared, lights }) = &self.frame else { return Ok(()) };
        let view = MaskView::new(clip_from_world.to_cols_array_2d(), depths).normals(normals);
        self.masks.prepare(prepared, lights, &[0], &view, &settings.mask)?;
        let slot = self.masks.slots().first().copied().flatten();
        let (Some(slot), Some(masks)) = (slot, self.masks.texture()) else { return Ok(()) };
        if masks.size().width != mask.width() || masks.size().height != mask.height() {
            return Ok(()); // the mask follows in the next frame
        }
        self.masks.record(encoder);
        let from = wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d { x: 0, y: 0, z: slot.layer },
            ..masks.as_image_copy()
        };
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..masks.size() };
        encoder.copy_texture_to_texture(from, mask.as_image_copy(), size);
        Ok(())
    }
}
