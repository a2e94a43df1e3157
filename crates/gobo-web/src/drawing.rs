//! Targets, pipelines and buffers of the drawn pictures.
use crate::{
    looks::Class,
    passes::{DEPTH, LIGHT, Layouts, Pass, Passes, SAMPLES},
    triangles::{Triangles, image},
};
use gobo::{
    Scene,
    glam::Vec3,
    wgpu::{self, TextureUsages, util::DeviceExt as _},
};
use half::f16;

pub(crate) fn group<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// Textures that a picture of a size is drawn into.
#[derive(Debug)]
pub(crate) struct Targets {
    pub(crate) size: [u32; 2],
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    light: wgpu::TextureView,
    pub(crate) tone: wgpu::BindGroup,
    pub(crate) bricks: Option<wgpu::BindGroup>,
}

impl Targets {
    /// Textures of a size. `tone`: exposure and tone curve; `bricks`: buffers of bricks, if there are any.
    pub(crate) fn new(
        device: &wgpu::Device,
        layouts: &Layouts,
        size: [u32; 2],
        tone: &wgpu::Buffer,
        bricks: Option<&[wgpu::Buffer]>,
    ) -> Self {
        let texture = |label, format, sample_count, usage| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
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
        let tone = [tone.as_entire_binding(), wgpu::BindingResource::TextureView(&light)];
        let tone = group(device, &layouts.tone, tone);
        let bricks = bricks.map(|bricks| {
            let buffers = bricks.iter().map(wgpu::Buffer::as_entire_binding);
            let depth = wgpu::BindingResource::TextureView(&depth);
            group(device, &layouts.bricks, buffers.chain([depth]))
        });
        Self { size, color, depth, light, tone, bricks }
    }

    /// The pass that draws solid surfaces first, or the one after it.
    pub(crate) fn begin<'e>(
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

/// Bindings of all passes.
#[derive(Debug)]
pub(crate) struct Drawing<'a> {
    pub(crate) own: &'a wgpu::BindGroup,
    pub(crate) light: &'a wgpu::BindGroup,
    pub(crate) passes: &'a Passes,
    pub(crate) triangles: &'a Triangles,
    pub(crate) images: &'a [wgpu::BindGroup],
}

impl Drawing<'_> {
    /// Sets the pipeline of a pass; returns whether there is one.
    fn begin(&self, to: &mut wgpu::RenderPass<'_>, pass: Pass) -> bool {
        let Some(pipeline) = self.passes.get(pass) else { return false };
        to.set_pipeline(pipeline);
        to.set_bind_group(0, self.own, &[]);
        to.set_bind_group(1, self.light, &[]);
        true
    }

    pub(crate) fn plain(
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

    pub(crate) fn triangles(&self, to: &mut wgpu::RenderPass<'_>, class: Class) {
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

/// Bind groups of the scene's images, after a white one.
pub(crate) fn images_of(
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
pub(crate) fn sky_of(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    scene: &Scene,
) -> wgpu::TextureView {
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
