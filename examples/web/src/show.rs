//! A host with its own device, shader and pass, around gobo's maps.
use gobo::{Bounds, Casters, Error, Light, Material, Particle, Receiver, ShadowSettings, Shadows, Shape, glam::{Vec3, Vec4}, host::LightBindings, light_views, wgpu::{self, util::DeviceExt as _}};

/// Puffs of the ring.
const COUNT: usize = 9;

/// Parameters that the sliders set.
#[derive(Clone, Copy, Debug)]
pub struct Knobs {
    /// Angle of the lamp about the middle [turns].
    pub turn: f32,
    /// Opacity of the puffs, 0..=1.
    pub opacity: f32,
    /// Radius of the puffs [m].
    pub radius: f32,
}

impl Default for Knobs {
    fn default() -> Self {
        Self { turn: 0.1, opacity: 0.7, radius: 0.32 }
    }
}

/// Uniforms of `show.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Params {
    lamp: [f32; 4],
    puffs: [[f32; 4]; COUNT],
    colors: [[f32; 4]; COUNT],
}

/// The scene on one device.
#[derive(Debug)]
pub struct Show {
    device: wgpu::Device,
    queue: wgpu::Queue,
    shadows: Shadows,
    settings: ShadowSettings,
    params: wgpu::Buffer,
    own: wgpu::BindGroup,
    own_layout: wgpu::BindGroupLayout,
    format: wgpu::TextureFormat,
    pipeline: Option<wgpu::RenderPipeline>,
}

fn settings() -> ShadowSettings {
    ShadowSettings { size: 256, receiver: Receiver::Curve, nodes: 4, ..ShadowSettings::default() }
}

impl Show {
    /// `format`: of the render target.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        adapter: &wgpu::AdapterInfo,
        format: wgpu::TextureFormat,
    ) -> Result<Self, Error> {
        let own_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("show"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let params = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("show"),
            contents: &[0; size_of::<Params>()],
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        });
        let own = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("show"),
            layout: &own_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: params.as_entire_binding(),
            }],
        });
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            shadows: Shadows::new(device, queue, adapter)?,
            settings: settings(),
            params,
            own,
            own_layout,
            format,
            pipeline: None,
        })
    }

    /// The queue of its device.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Renders the maps that the knobs change, and draws the scene.
    pub fn draw(&mut self, target: &wgpu::TextureView, knobs: &Knobs) -> Result<(), Error> {
        let materials = [Material { shape: Shape::Puff, ..Material::default() }];
        let particles: Vec<Particle> = (0..COUNT as u32).map(|i| puff(i, knobs)).collect();
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        let (sine, cosine) = (knobs.turn * std::f32::consts::TAU).sin_cos();
        let lamp = Vec3::new(sine * 1.5, 3.0, cosine * 1.5);
        let lights = [Light::spot(lamp, Vec3::new(0.0, 0.5, 0.0) - lamp, 1.4)];
        let bounds = Bounds { min: Vec3::new(-4.0, 0.0, -4.0), max: Vec3::new(4.0, 2.0, 4.0) };
        let views = light_views(0, &lights[0], self.settings.size, None, &bounds)?;
        let prepared = self.shadows.prepare(&casters, &views, &self.settings)?;
        let light = prepared.bind_lights(&lights, &[0])?;
        let params = Params {
            lamp: lamp.extend(0.0).into(),
            puffs: std::array::from_fn(|i| particles[i].center.extend(particles[i].radius).into()),
            colors: std::array::from_fn(|i| particles[i].color.into()),
        };
        self.queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
        if self.pipeline.is_none() {
            let text = prepared.maps().wgsl(1, "gobo_")? + include_str!("show.wgsl");
            self.pipeline = Some(self.pipeline(text, &light));
        }
        let mut encoder = self.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        if let Some(pipeline) = &self.pipeline {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &self.own, &[]);
            pass.set_bind_group(1, &light.group, &[]);
            pass.draw(0..3, 0..1);
        }
        drop(pass);
        self.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn pipeline(&self, text: String, light: &LightBindings) -> wgpu::RenderPipeline {
        let device = &self.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("show"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("show"),
            bind_group_layouts: &[Some(&self.own_layout), Some(&light.layout)],
            immediate_size: 0,
        });
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("show"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("shade"),
                compilation_options: Default::default(),
                targets: &[Some(self.format.into())],
            }),
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Picture of the scene at rest, `size` pixels: rgba, row by row, once the device has drawn it.
    pub async fn picture(&mut self, size: [u32; 2], knobs: &Knobs) -> Result<Vec<u8>, Error> {
        let [width, height] = size;
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        self.draw(&texture.create_view(&Default::default()), knobs)?;
        let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: u64::from(row * height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let to = wgpu::TexelCopyBufferInfo { buffer: &staging, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        self.queue.submit([encoder.finish()]);
        let (done, mapped) = futures_channel::oneshot::channel();
        staging.map_async(wgpu::MapMode::Read, .., |result| {
            // A receiver that has gone away is ignored.
            let _ = done.send(result);
        });
        // A browser answers by itself.
        if cfg!(not(target_arch = "wasm32")) {
            let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
            waited.map_err(|error| Error::Lost(error.to_string()))?;
        }
        let lost = |error: &dyn std::fmt::Display| Error::Lost(error.to_string());
        mapped.await.map_err(|e| lost(&e))?.map_err(|e| lost(&e))?;
        let bytes = staging.get_mapped_range(..).map_err(|e| lost(&e))?;
        let rows = bytes.chunks_exact(row as usize);
        Ok(rows.flat_map(|row| &row[..width as usize * 4]).copied().collect())
    }
}

fn puff(i: u32, knobs: &Knobs) -> Particle {
    let share = i as f32 / COUNT as f32;
    let (sine, cosine) = (share * std::f32::consts::TAU).sin_cos();
    let hue = |shift: f32| 0.5 + 0.5 * ((share + shift) * std::f32::consts::TAU).cos();
    Particle {
        center: Vec3::new(cosine * 0.9, 0.75 + 0.35 * (3.0 * sine).sin(), sine * 0.9),
        radius: knobs.radius,
        color: Vec4::new(hue(0.0), hue(0.33), hue(0.67), knobs.opacity),
        id: i,
        ..Particle::default()
    }
}
