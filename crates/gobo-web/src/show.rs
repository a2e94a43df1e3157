//! A scene on a device: its shadow maps, and the picture around them.
use crate::{
    bricks::Bricks,
    device::{Buffers, TooLarge},
    frame::Frame,
    knobs::Knobs,
    looks::{Class, Look},
    passes::{DEPTH, LIGHT, Layouts, Pass, Passes, SAMPLES, tone_pipeline},
    sprites::Sprites,
    triangles::{Triangles, image},
};
use gobo::{
    Bounds, Error, KernelError, KernelJob, Light, Prepared, Scene, ShadowSettings, Shadows,
    glam::Vec3,
    host::LightBindings,
    internals::view::{atlas::AtlasLimits, fitted_views},
    wgpu::{self, TextureUsages, util::DeviceExt as _},
};
use half::f16;
use std::collections::HashMap;

/// Error of a scene that cannot be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShowError {
    /// Of the shadow maps.
    #[error(transparent)]
    Shadows(#[from] Error),
    /// Of a kernel.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// Of what the device holds.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// What was made last, and what is left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Name of the kernel or pass.
    pub name: &'static str,
    /// Number of those that are made.
    pub made: usize,
    /// Number of all.
    pub all: usize,
}

/// Maps of the scene as they are read.
#[derive(Debug)]
struct Lit {
    prepared: Prepared,
    views: Vec<gobo::View>,
    bindings: LightBindings,
    /// What it was made for.
    wish: Wish,
    /// Whether the maps have been recorded.
    is_drawn: bool,
}

/// What maps depend on.
#[derive(Clone, Debug, PartialEq)]
struct Wish {
    lights: Vec<Light>,
    settings: ShadowSettings,
    /// Of the camera that cascades follow.
    camera: Option<gobo::Camera>,
}

/// Textures that a picture of a size is drawn into.
#[derive(Debug)]
struct Targets {
    size: [u32; 2],
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    light: wgpu::TextureView,
    tone: wgpu::BindGroup,
    bricks: Option<wgpu::BindGroup>,
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
    /// By nodes of the curves, and whether light may increase along them.
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
    /// Kernels that are not made, and the number of those that were, of a wish.
    jobs: Option<(Wish, Vec<KernelJob>, usize)>,
    lit: Option<Lit>,
    targets: Option<Targets>,
}

fn group<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

impl Show {
    /// Uploads a scene. `shadows`: of the same device.
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

    /// Renders the maps alone, all kernels of which are made first.
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

    /// Makes the next kernel or pass that a picture needs; `None` once all are made. The device compiles it before what is
    /// submitted later.
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

    /// Turns the scene's lights, and returns their views.
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

    /// Prepares maps, unless those that are there are the same.
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

    /// Draws the scene, and before it the maps that have changed. Everything must be made ([`Self::step`]). Whether maps were
    /// drawn.
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
            // There is room now for what was scattered.
            self.lit = None;
        }
        self.light(self.wish(knobs, size))?;
        self.make_targets(size);
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

    fn make_targets(&mut self, size: [u32; 2]) {
        if self.targets.as_ref().is_some_and(|targets| targets.size == size) {
            return;
        }
        let texture = |label, format, sample_count, usage| {
            let texture = self.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let read = TextureUsages::TEXTURE_BINDING;
        let color = texture("color", LIGHT, SAMPLES, TextureUsages::empty());
        let depth = texture("depth", DEPTH, SAMPLES, read);
        let light = texture("light", LIGHT, 1, read);
        let tone = [self.tone.as_entire_binding(), wgpu::BindingResource::TextureView(&light)];
        let tone = group(&self.device, &self.layouts.tone, tone);
        let bricks = (self.bricks.order.count() > 0).then(|| {
            let buffers = self.bricks.buffers.iter().map(wgpu::Buffer::as_entire_binding);
            let depth = wgpu::BindingResource::TextureView(&depth);
            group(&self.device, &self.layouts.bricks, buffers.chain([depth]))
        });
        self.targets = Some(Targets { size, color, depth, light, tone, bricks });
    }
}

impl Targets {
    /// The pass that draws what is solid first, or the one after it.
    fn begin<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        is_first: bool,
    ) -> wgpu::RenderPass<'e> {
        let load =
            if is_first { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
        let depth_ops = is_first.then_some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(0.0),
            store: wgpu::StoreOp::Store,
        });
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(if is_first { "solid" } else { "translucent" }),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: (!is_first).then_some(&self.light),
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops,
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}

/// What all passes bind.
struct Drawing<'a> {
    own: &'a wgpu::BindGroup,
    light: &'a wgpu::BindGroup,
    passes: &'a Passes,
    triangles: &'a Triangles,
    images: &'a [wgpu::BindGroup],
}

impl Drawing<'_> {
    /// Sets the pipeline of a pass; whether there is one.
    fn begin(&self, to: &mut wgpu::RenderPass<'_>, pass: Pass) -> bool {
        let Some(pipeline) = self.passes.get(pass) else { return false };
        to.set_pipeline(pipeline);
        to.set_bind_group(0, self.own, &[]);
        to.set_bind_group(1, self.light, &[]);
        true
    }

    fn plain(
        &self,
        to: &mut wgpu::RenderPass<'_>,
        pass: Pass,
        group: &wgpu::BindGroup,
        corners: std::ops::Range<u32>,
        count: u32,
    ) {
        if count > 0 && self.begin(to, pass) {
            to.set_bind_group(2, group, &[]);
            to.draw(corners, 0..count);
        }
    }

    fn triangles(&self, to: &mut wgpu::RenderPass<'_>, class: Class) {
        for &pass in Pass::of(class) {
            if !self.triangles.has(class) || !self.begin(to, pass) {
                continue;
            }
            to.set_vertex_buffer(0, self.triangles.corners.slice(..));
            for batch in self.triangles.batches.iter().filter(|batch| batch.class == class) {
                let index = batch.texture.map_or(0, |texture| texture as usize + 1);
                to.set_bind_group(2, &self.images[index], &[]);
                to.draw(batch.corners.clone(), 0..1);
            }
        }
    }
}

/// Bind groups of the scene's images, behind a white one.
fn images_of(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    layouts: &Layouts,
    scene: &Scene,
) -> Vec<wgpu::BindGroup> {
    let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("image"),
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let white = gobo::Texture { name: String::new(), width: 1, height: 1, rgba: vec![255; 4] };
    let bound = |texture: &gobo::Texture| {
        let view = image(device, queue, texture);
        let resources =
            [wgpu::BindingResource::TextureView(&view), wgpu::BindingResource::Sampler(&sampler)];
        group(device, &layouts.image, resources)
    };
    std::iter::once(&white).chain(&scene.textures).map(bound).collect()
}

/// The sharp level of the surroundings, or a black texel.
fn sky_of(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> wgpu::TextureView {
    let edge = scene.environment.as_ref().map_or(1, |environment| environment.size() + 2);
    let count = (edge * edge) as usize;
    let rgba =
        |texel: &Vec3| texel.extend(1.0).to_array().map(|value| f16::from_f32(value).to_bits());
    let texels: Vec<[u16; 4]> = scene
        .environment
        .as_ref()
        .map_or_else(|| vec![[0; 4]], |of| of.texels().iter().take(count).map(rgba).collect());
    let descriptor = wgpu::TextureDescriptor {
        label: Some("sky"),
        size: wgpu::Extent3d { width: edge, height: edge, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: LIGHT,
        usage: TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let bytes = bytemuck::cast_slice(&texels);
    let texture = device.create_texture_with_data(queue, &descriptor, order, bytes);
    texture.create_view(&Default::default())
}
