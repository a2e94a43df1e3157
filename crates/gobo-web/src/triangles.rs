//! Triangles on the device, in batches of one class and one image.
use crate::{
    device::{Buffers, TooLarge},
    looks::Class,
};
use bytemuck::{Pod, Zeroable};
use gobo::{Scene, Texture, wgpu};
use std::ops::Range;

/// WGSL: `Corner` of `wgsl/triangles.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    color: [u8; 4],
    look: u32,
}

/// Attributes of a [`Corner`].
pub(crate) const ATTRIBUTES: [wgpu::VertexAttribute; 5] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4, 4 => Uint32
];

/// Triangles of one class and one image.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    pub(crate) class: Class,
    /// Index into the scene's textures.
    pub(crate) texture: Option<u32>,
    pub(crate) corners: Range<u32>,
}

/// Triangles of a scene.
#[derive(Debug)]
pub(crate) struct Triangles {
    pub(crate) corners: wgpu::Buffer,
    pub(crate) batches: Vec<Batch>,
}

impl Triangles {
    pub(crate) fn of(scene: &Scene, buffers: &Buffers<'_>) -> Result<Self, TooLarge> {
        let key = |&index: &u32| {
            let material = &scene.materials[scene.triangles[index as usize].material as usize];
            (Class::of(material), material.texture)
        };
        let is_seen = |index: &u32| {
            scene.materials[scene.triangles[*index as usize].material as usize].visible
        };
        let mut order: Vec<u32> = (0..scene.triangles.len() as u32).filter(is_seen).collect();
        order.sort_by_key(key);
        buffers.check("triangles", order.len() as u64 * 3 * size_of::<Corner>() as u64)?;
        let mut corners: Vec<Corner> = Vec::with_capacity(order.len() * 3);
        let mut batches: Vec<Batch> = Vec::new();
        for index in order {
            let (class, texture) = key(&index);
            let triangle = &scene.triangles[index as usize];
            let first = corners.len() as u32;
            corners.extend((0..3).map(|i| Corner {
                position: triangle.positions[i].into(),
                normal: triangle.normals[i].into(),
                uv: triangle.uvs[i].into(),
                color: triangle.colors[i].0,
                look: triangle.material,
            }));
            match batches.last_mut() {
                Some(batch) if batch.class == class && batch.texture == texture => {
                    batch.corners.end = first + 3;
                }
                _ => batches.push(Batch { class, texture, corners: first..first + 3 }),
            }
        }
        Ok(Self { corners: buffers.vertices("triangles", &corners)?, batches })
    }

    pub(crate) fn has(&self, class: Class) -> bool {
        self.batches.iter().any(|batch| batch.class == class)
    }
}

/// An image on the device.
pub(crate) fn image(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &Texture,
) -> wgpu::TextureView {
    let size =
        wgpu::Extent3d { width: texture.width, height: texture.height, depth_or_array_layers: 1 };
    let made = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("image"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * texture.width),
        rows_per_image: None,
    };
    queue.write_texture(made.as_image_copy(), &texture.rgba, layout, size);
    made.create_view(&wgpu::TextureViewDescriptor::default())
}
