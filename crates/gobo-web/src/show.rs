//! A scene on a device: its shadow maps, and the picture around them.
use crate::{
    bricks::Bricks,
    device::{Buffers, TooLarge},
    drawing::{Drawing, Targets, group, images_of, sky_of},
    frame::Frame,
    knobs::Knobs,
    looks::{Class, Look},
    passes::{Layouts, Pass, Passes, tone_pipeline},
    sprites::Sprites,
    triangles::Triangles,
};
use gobo::{
    Bounds, Error, KernelError, KernelJob, Light, Prepared, Scene, ShadowSettings, Shadows,
    host::LightBindings,
    view::{atlas::AtlasLimits, fitted_views},
    wgpu,
};
use std::collections::HashMap;

/// Error of a scene that cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShowError {
    /// Error of the shadow maps.
    #[error(transparent)]
    Shadows(#[from] Error),
    /// Error of a kernel.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// The scene exceeds the device's limits.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// Progress of making kernels and passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Name of the last kernel or pass.
    pub name: &'static str,
    /// Number made so far.
    pub made: usize,
    /// Number of all.
    pub all: usize,
}

/// Maps of the scene, ready to be read.
#[derive(Debug)]
struct Lit {
    prepared: Prepared,
    views: Vec<gobo::View>,
    bindings: LightBindings,
    /// Parameters that they were made for.
    wish: Wish,
    /// Whether the maps have been recorded.
    is_drawn: bool,
}

/// Parameters of maps.
#[derive(Clone, Debug, PartialEq)]
struct Wish {
    lights: Vec<Light>,
    settings: ShadowSettings,
    /// Camera that cascades follow.
    camera: Option<gobo::Camera>,
}

/// A scene on a device.
#[derive(Debug)]
pub struct Show {
    device: wgpu::Device,
    queue: wgpu::Queue,
    shadows: Shadows,
    scene: Scene,
    /// Lights of the first picture.
    lights: Vec<Light>,
    bounds: Bounds,
    /// Longest edge of a map \[texels\].
    most_texels: u32,
    layouts: Layouts,
    /// Passes by nodes of the curves, and whether light may increase along them.
    passes: HashMap<(u32, bool), Passes>,
    tones: HashMap<wgpu::TextureFormat, wgpu::RenderPipeline>,
    frame: wgpu::Buffer,
    tone: wgpu::Buffer,
    own: wgpu::BindGroup,
    sky: wgpu::BindGroup,
    images: Vec<wgpu::BindGroup>,
    triangles: Triangles,
    solid: (Sprites, wgpu::BindGroup),
    blended: (Sprites, wgpu::BindGroup),
    bricks: Bricks,
    /// Kernels of a wish that are not made yet, and the number of those that were.
    jobs: Option<(Wish, Vec<KernelJob>, usize)>,
    lit: Option<Lit>,
    targets: Option<Targets>,
}

impl Show {
    /// Uploads a scene. `shadows`: on the same device.
    ///
    /// # Errors
    /// If the device cannot hold it.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        shadows: Shadows,
        mut scene: Scene,
    ) -> Result<Self, ShowError> {
        let layouts = Layouts::new(device);
        let buffers = Buffers(device);
        // Point lights need the fewest kernels.
        for light in &mut scene.lights {
            (light.source, light.viewpoints) = (None, 1);
        }
        let looks: Vec<Look> = scene.materials.iter().map(Look::new).collect();
        let looks = buffers.storage("materials", &looks)?;
        let frame = buffers.uniform("frame", size_of::<Frame>());
        let tone = buffers.uniform("tone", 16);
        let own = [frame.as_entire_binding(), looks.as_entire_binding()];
        let own = group(device, &layouts.frame, own);
        let [solid, blended] = Sprites::of(&scene, &buffers)?.map(|sprites| {
            let bound = sprites.buffers.iter().map(wgpu::Buffer::as_entire_binding);
            let bound = group(device, &layouts.sprites, bound);
            (sprites, bound)
        });
        let bricks = Bricks::of(&scene, &buffers)?;
        let triangles = Triangles::of(&scene, &buffers)?;
        let sky = sky_of(device, queue, &scene);
        let sky = [wgpu::BindingResource::TextureView(&sky)];
        let sky = group(device, &layouts.sky, sky);
        let images = images_of(device, queue, &layouts, &scene);
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            shadows,
            lights: scene.lights.clone(),
            bounds: scene.bounds(),
            scene,
            most_texels: 1024,
            layouts,
            passes: HashMap::new(),
            tones: HashMap::new(),
            frame,
            tone,
            own,
            sky,
            images,
            triangles,
            solid,
            blended,
            bricks,
            jobs: None,
            lit: None,
            targets: None,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Sets the longest edge of a map \[texels\].
    pub fn set_most_texels(&mut self, most: u32) {
        self.most_texels = most;
    }

    /// Views of the maps, in their order.
    pub fn map_views(&self) -> &[gobo::View] {
        self.lit.as_ref().map_or(&[], |lit| &lit.views)
    }

    /// Renders the maps alone, after making all their kernels.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    pub fn shade_maps(&mut self, knobs: &Knobs) -> Result<&Prepared, ShowError> {
        let camera = self.scene.camera;
        self.light(self.wish(knobs, camera.size.into()))?;
        let lit = self.lit.as_mut().ok_or(Error::Superseded)?;
        if !std::mem::replace(&mut lit.is_drawn, true) {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            lit.prepared.record(&mut encoder)?;
            self.queue.submit([encoder.finish()]);
        }
        Ok(&lit.prepared)
    }

    fn wish(&self, knobs: &Knobs, size: [u32; 2]) -> Wish {
        let middle = self.bounds.or_unit().center();
        let mut lights = self.lights.clone();
        if let Some(first) = lights.iter_mut().find(|light| light.casts) {
            *first = knobs.light(first, middle);
        }
        for light in &mut lights {
            light.size = light.size.map(|size| size.min(self.most_texels));
        }
        let shadow = &self.scene.shadow;
        let settings = ShadowSettings {
            size: shadow.size.min(self.most_texels),
            receiver: knobs.receiver,
            ..*shadow
        };
        let follows = lights.iter().any(|light| light.cascades.is_some());
        let camera = follows.then(|| knobs.camera(&self.scene.camera, size));
        Wish { lights, settings, camera }
    }

    /// Makes the next kernel or pass that a picture needs; `None` once all are made. The device compiles it
    /// before it runs commands submitted later.
    ///
    /// # Errors
    /// If the device refuses one, or is lost.
    pub fn step(&mut self, knobs: &Knobs, size: [u32; 2]) -> Result<Option<Step>, ShowError> {
        let wish = self.wish(knobs, size);
        let needs = self.needed();
        let is_new = self.jobs.as_ref().is_none_or(|(of, ..)| {
            of.settings != wish.settings || of.lights.len() != wish.lights.len()
        });
        if is_new {
            let jobs = self.pending(&wish)?;
            self.jobs = Some((wish.clone(), jobs, 0));
        }
        if let Some((_, jobs, made)) = &mut self.jobs
            && let Some(job) = jobs.pop()
        {
            *made += 1;
            job.run()?;
            let all = *made + jobs.len() + needs.len();
            return Ok(Some(Step { name: job.name(), made: *made, all }));
        }
        self.light(wish)?;
        let Some(lit) = &self.lit else { return Ok(None) };
        let maps = lit.prepared.maps();
        let passes = self.passes.entry((maps.nodes, maps.gain)).or_default();
        let missing = needs.iter().position(|&pass| passes.get(pass).is_none());
        let Some(index) = missing else { return Ok(None) };
        let text = maps.wgsl(1, "gobo_")?;
        let look_up = (&*text, &lit.bindings.layout);
        passes.make(&self.device, &self.layouts, look_up, needs[index]);
        let kernels = self.jobs.as_ref().map_or(0, |(.., made)| *made);
        let (made, all) = (kernels + index + 1, kernels + needs.len());
        Ok(Some(Step { name: needs[index].name(), made, all }))
    }

    /// Passes that the scene needs, in the order in which they are drawn.
    fn needed(&self) -> Vec<Pass> {
        let of_class = |class| self.triangles.has(class).then_some(Pass::of(class));
        let all = [Class::Solid, Class::Pane, Class::Cover].into_iter().filter_map(of_class);
        let sprites = [(&self.solid.0, Pass::SolidSprites), (&self.blended.0, Pass::Sprites)];
        let sprites = sprites.into_iter().filter(|(of, _)| of.order.count() > 0);
        let bricks = (self.bricks.order.count() > 0).then_some(Pass::Bricks);
        [Pass::Sky]
            .into_iter()
            .chain(all.flatten().copied())
            .chain(bricks)
            .chain(sprites.map(|(_, pass)| pass))
            .collect()
    }

    /// Applies the visitor's changes to the scene's lights, and returns their views.
    fn views(&mut self, wish: &Wish) -> Vec<gobo::View> {
        let limits = AtlasLimits::of(&self.device.limits());
        let scene = &mut self.scene;
        scene.lights.clone_from(&wish.lights);
        let first = (scene.camera, scene.shadow);
        (scene.camera, scene.shadow) = (wish.camera.unwrap_or(scene.camera), wish.settings);
        let (views, _) = fitted_views(scene, &limits);
        (scene.camera, scene.shadow) = first;
        views
    }

    fn pending(&mut self, wish: &Wish) -> Result<Vec<KernelJob>, ShowError> {
        let views = self.views(wish);
        let (casters, inputs) = (self.scene.casters(), gobo::HostInputs::new());
        let mut jobs = self.shadows.pending(&casters, &views, &wish.settings, &inputs)?;
        jobs.reverse();
        Ok(jobs)
    }

    /// Prepares maps, unless the present ones are the same.
    fn light(&mut self, wish: Wish) -> Result<(), ShowError> {
        if self.lit.as_ref().is_some_and(|lit| lit.wish == wish) {
            return Ok(());
        }
        let views = self.views(&wish);
        let casters = self.scene.casters();
        let prepared = self.shadows.prepare(&casters, &views, &wish.settings)?;
        let chosen: Vec<usize> = (0..wish.lights.len()).collect();
        let bindings = prepared.bind_lights(&wish.lights, &chosen)?;
        self.lit = Some(Lit { prepared, views, bindings, wish, is_drawn: false });
        Ok(())
    }

    /// Draws the scene, after those maps that have changed. Everything must be made ([`Self::step`]). Returns
    /// whether maps were drawn.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn draw(
        &mut self,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
        size: [u32; 2],
        knobs: &Knobs,
    ) -> Result<bool, ShowError> {
        if self.shadows.statistics()?.is_some_and(|counters| counters.overflowed > 0) {
            // Maps made anew have room for the pairs that did not fit.
            self.lit = None;
        }
        self.light(self.wish(knobs, size))?;
        if self.targets.as_ref().is_none_or(|targets| targets.size != size) {
            let bricks = (self.bricks.order.count() > 0).then_some(&*self.bricks.buffers);
            let targets = Targets::new(&self.device, &self.layouts, size, &self.tone, bricks);
            self.targets = Some(targets);
        }
        let camera = knobs.camera(&self.scene.camera, size);
        let frame = Frame::new(&self.scene, &camera, &self.bounds, self.lights.len() as u32);
        self.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
        self.queue.write_buffer(&self.tone, 0, bytemuck::cast_slice(&frame.tone()));
        let (eye, forward) = frame.eye();
        let sorted = [
            (&mut self.blended.0.order, &self.blended.0.buffers[1]),
            (&mut self.bricks.order, &self.bricks.buffers[1]),
        ];
        for (order, buffer) in sorted {
            if let Some(order) = order.sort(eye, forward) {
                self.queue.write_buffer(buffer, 0, bytemuck::cast_slice(order));
            }
        }
        let device = &self.device;
        let tone = self
            .tones
            .entry(format)
            .or_insert_with(|| tone_pipeline(device, &self.layouts, format));
        let (Some(lit), Some(targets)) = (&mut self.lit, &self.targets) else { return Ok(false) };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let draws_maps = !std::mem::replace(&mut lit.is_drawn, true);
        if draws_maps {
            lit.prepared.record(&mut encoder)?;
            lit.prepared.record_statistics(&mut encoder)?;
        }
        let maps = lit.prepared.maps();
        let Some(passes) = self.passes.get(&(maps.nodes, maps.gain)) else { return Ok(false) };
        let drawing = Drawing {
            own: &self.own,
            light: &lit.bindings.group,
            passes,
            triangles: &self.triangles,
            images: &self.images,
        };
        let mut pass = targets.begin(&mut encoder, true);
        drawing.plain(&mut pass, Pass::Sky, &self.sky, 0..3, 1);
        drawing.triangles(&mut pass, Class::Solid);
        let count = self.solid.0.order.count();
        drawing.plain(&mut pass, Pass::SolidSprites, &self.solid.1, 0..4, count);
        drop(pass);
        let mut pass = targets.begin(&mut encoder, false);
        drawing.triangles(&mut pass, Class::Pane);
        drawing.triangles(&mut pass, Class::Cover);
        if let Some(bricks) = &targets.bricks {
            drawing.plain(&mut pass, Pass::Bricks, bricks, 0..36, self.bricks.order.count());
        }
        let count = self.blended.0.order.count();
        drawing.plain(&mut pass, Pass::Sprites, &self.blended.1, 0..4, count);
        drop(pass);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tone"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(tone);
        pass.set_bind_group(0, &targets.tone, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        self.queue.submit([encoder.finish()]);
        Ok(draws_maps)
    }
}
