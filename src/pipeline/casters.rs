//! A scene's casters on the GPU: uploaded once, read by every view.
use super::small::TriangleExtent;
use crate::{
    caster::{Material, Particle, Profile, Receives, Shape, Texture, Transfer, Triangle},
    dither::{Pattern, blue_ranks, window},
    error::Error,
    footprint::{
        CASTER_TEXELS, Caster, GpuMaterial, MAX_MATERIALS, ROW, TRIANGLE_TEXELS, TriangleRecord,
    },
    gpu::{Allocator, Memory},
    scene::Bounds,
    stage::{hits::Features, project::CHUNK_SIZE},
    view::GpuView,
    volume::absorptions,
};
use bytemuck::Zeroable as _;
use glam::Vec3;
use std::ops::{Range, RangeInclusive};
use wgpu::{
    TextureFormat::{Rgba8UnormSrgb, Rgba32Uint},
    TextureUsages,
};

/// Which depth or filter a caster goes to, and whether the picture shows it. In an order that makes
/// neighbours of what each list holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Seen and solid, casts nothing.
    ShownOpaque,
    /// To the opaque depth.
    Opaque,
    /// To the opaque depth, not seen.
    HiddenOpaque,
    /// To the opaque depth, but the picture blends it.
    Dithered,
    /// Seen and blended, casts nothing.
    Shown,
    /// To the filter.
    Translucent,
    /// To the filter, not seen.
    HiddenTranslucent,
    /// Neither casts nor is seen.
    Nothing,
}

impl Class {
    const ALL: [Self; CLASSES] = [
        Self::ShownOpaque,
        Self::Opaque,
        Self::HiddenOpaque,
        Self::Dithered,
        Self::Shown,
        Self::Translucent,
        Self::HiddenTranslucent,
        Self::Nothing,
    ];
    /// What blocks light.
    pub const BLOCKING: RangeInclusive<Self> = Self::Opaque..=Self::Dithered;
    /// What filters light.
    pub const FILTERING: RangeInclusive<Self> = Self::Translucent..=Self::HiddenTranslucent;
    /// What the camera sees as solid.
    pub const SOLID: RangeInclusive<Self> = Self::ShownOpaque..=Self::Opaque;
    /// What the camera sees and blends.
    pub const BLENDED: RangeInclusive<Self> = Self::Dithered..=Self::Translucent;

    pub fn of(material: &Material) -> Self {
        let casts = material.casts && material.transfer != Transfer::None;
        let blended = material.transfer == Transfer::Dither || !material.transfer.is_opaque();
        match (material.visible, casts, material.transfer.is_opaque(), blended) {
            (false, false, ..) => Self::Nothing,
            (false, true, true, _) => Self::HiddenOpaque,
            (false, true, false, _) => Self::HiddenTranslucent,
            (true, false, _, false) => Self::ShownOpaque,
            (true, false, _, true) => Self::Shown,
            (true, true, true, false) => Self::Opaque,
            (true, true, true, true) => Self::Dithered,
            (true, true, false, _) => Self::Translucent,
        }
    }

    /// Whether it blocks or filters light.
    pub fn casts(self) -> bool {
        Self::BLOCKING.contains(&self) || Self::FILTERING.contains(&self)
    }
}

const CLASSES: usize = 8;

/// The casters of neighbouring classes.
#[derive(Clone, Debug)]
pub struct Span {
    /// In the order of the upload.
    pub particles: Range<u32>,
    pub triangles: Range<u32>,
    pub features: Features,
}

impl Span {
    pub fn count(&self) -> usize {
        self.particles.len() + self.triangles.len()
    }
}

/// What a chunk's particles are within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// World space [m].
    pub bounds: Bounds,
    /// [m]
    pub min_radius: f32,
}

impl Extent {
    fn of(casters: &[Caster]) -> Self {
        let none = Self { bounds: Bounds::EMPTY, min_radius: f32::INFINITY };
        casters.iter().fold(none, |extent, caster| Self {
            bounds: extent.bounds.with_sphere(caster.center, caster.radius),
            min_radius: extent.min_radius.min(caster.radius),
        })
    }

    /// Whether some particle may be at most 2x2 texels in the view: then its radius is below 1.5.
    pub(super) fn may_be_tiny(&self, view: &GpuView) -> bool {
        let texels_per_metre = if view.perspective > 0.0 {
            let center = -view.view_from_world.transform_point3(self.bounds.center()).z;
            let farthest = (center + self.bounds.radius()).min(view.far);
            view.scale / farthest.max(view.near)
        } else {
            view.scale
        };
        self.min_radius * texels_per_metre < 1.5
    }
}

/// Particles, triangles, materials and images in kernel form. Within each kind the casters are
/// ordered by class, and stay in the scene's order within a class.
#[derive(Debug)]
pub struct CasterSet {
    pub casters: wgpu::Texture,
    pub triangles: wgpu::Texture,
    pub images: wgpu::Texture,
    pub materials: wgpu::Buffer,
    particle_ranges: [Range<u32>; CLASSES],
    /// Of particles that filter: what each [`CHUNK_SIZE`] of them are within.
    extents: Vec<Extent>,
    triangle_ranges: [Range<u32>; CLASSES],
    /// Of opaque and dithered triangles: what each [`CHUNK_SIZE`] of them are within.
    triangle_extents: Vec<TriangleExtent>,
    features: [Features; CLASSES],
    /// Whether some receiver is tinted by all casters but its own.
    pub owners: bool,
    /// Edge of the window that shows every dithered material's opacity, 0 for none [texels].
    pub dither_window: u32,
    /// Bytes by texture and buffer.
    pub memory: Memory,
}

impl CasterSet {
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        particles: &[Particle],
        triangles: &[Triangle],
        materials: &[Material],
        textures: &[Texture],
    ) -> Result<Self, Error> {
        if materials.len() > MAX_MATERIALS {
            return Err(Error::Limit {
                limit: "materials of a scene",
                have: MAX_MATERIALS as u64,
                need: materials.len() as u64,
                remedy: "merge materials that are alike",
            });
        }
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let classes: Vec<_> = materials.iter().map(Class::of).collect();
        let (particle_order, particle_ranges) =
            by_class(&particles.iter().map(|p| classes[p.material as usize]));
        let (triangle_order, triangle_ranges) =
            by_class(&triangles.iter().map(|t| classes[t.material as usize]));
        let mut casters: Vec<_> = particle_order
            .iter()
            .map(|&i| &particles[i as usize])
            .map(|p| Caster::new(p, &materials[p.material as usize]))
            .collect();
        let records: Vec<_> =
            triangle_order.iter().map(|&i| TriangleRecord::new(&triangles[i as usize])).collect();
        let mut features = [Features::NONE; CLASSES];
        for particle in particles {
            add_features(&mut features, &materials[particle.material as usize], true);
        }
        for triangle in triangles {
            add_features(&mut features, &materials[triangle.material as usize], false);
        }
        let owners = materials.iter().any(|m| m.visible && m.receives == Receives::Others);
        for features in features.iter_mut().filter(|_| owners) {
            features.owners = true;
            features.plain = false;
        }
        let [first, last] = [Class::FILTERING.start(), Class::FILTERING.end()]
            .map(|&class| &particle_ranges[class as usize]);
        let translucent = &casters[first.start as usize..last.end as usize];
        let extents = translucent.chunks(CHUNK_SIZE as usize).map(Extent::of).collect();
        let [start, end] = [
            triangle_ranges[*Class::BLOCKING.start() as usize].start,
            triangle_ranges[*Class::BLOCKING.end() as usize].end,
        ];
        let triangle_extents = triangle_order[start as usize..end as usize]
            .chunks(CHUNK_SIZE as usize)
            .map(|chunk| chunk.iter().map(|&i| &triangles[i as usize]))
            .map(|chunk| TriangleExtent::of(chunk, materials))
            .collect();
        let blue_first = casters.len() as u32 * CASTER_TEXELS;
        if materials.iter().any(|m| m.transfer == Transfer::Dither && m.pattern == Pattern::Blue) {
            // Behind the particles, because every kernel that dithers reads these already.
            casters.extend_from_slice(bytemuck::cast_slice::<u16, Caster>(blue_ranks()));
        }
        Ok(Self {
            casters: upload(&mut allocator, queue, "casters", &casters, CASTER_TEXELS)?,
            triangles: upload(&mut allocator, queue, "triangles", &records, TRIANGLE_TEXELS)?,
            images: upload_images(&mut allocator, queue, textures)?,
            materials: upload_materials(
                &mut allocator,
                queue,
                materials,
                textures,
                blue_first,
                &absorptions(materials, triangles),
            ),
            extents,
            particle_ranges,
            triangle_ranges,
            triangle_extents,
            features,
            owners,
            dither_window: window(materials),
            memory,
        })
    }

    /// The casters of `classes`.
    pub fn span(&self, classes: RangeInclusive<Class>) -> Span {
        let (first, last) = (*classes.start() as usize, *classes.end() as usize);
        let of = |ranges: &[Range<u32>; CLASSES]| ranges[first].start..ranges[last].end;
        Span {
            particles: of(&self.particle_ranges),
            triangles: of(&self.triangle_ranges),
            features: self.features[first..=last].iter().fold(Features::NONE, |a, &b| a.or(b)),
        }
    }

    /// Of the chunks of the particles that filter.
    pub fn extents(&self) -> &[Extent] {
        &self.extents
    }

    /// Of the chunks of the opaque and dithered triangles.
    pub fn triangle_extents(&self) -> &[TriangleExtent] {
        &self.triangle_extents
    }
}

/// Stable order by class, and each class's range in it.
fn by_class(classes: &(impl Iterator<Item = Class> + Clone)) -> (Vec<u32>, [Range<u32>; CLASSES]) {
    let mut order = Vec::new();
    let mut ranges = [const { 0..0 }; CLASSES];
    for (class, range) in Class::ALL.into_iter().zip(&mut ranges) {
        let first = order.len() as u32;
        order.extend((0..).zip(classes.clone()).filter(|&(_, c)| c == class).map(|(i, _)| i));
        *range = first..order.len() as u32;
    }
    (order, ranges)
}

fn add_features(features: &mut [Features; CLASSES], material: &Material, is_particle: bool) {
    let features = &mut features[Class::of(material) as usize];
    features.particles |= is_particle;
    features.triangles |= !is_particle;
    features.textures |= material.texture.is_some();
    features.puffs |= is_particle && material.shape == Shape::Puff;
    features.quads |= is_particle && material.shape == Shape::Quad;
    features.dither |= material.transfer == Transfer::Dither;
    features.gain |= material.transfer == Transfer::Gain;
    features.over |= material.transfer == Transfer::Over;
    features.volumes |= !is_particle && material.is_volume();
    features.solid &= !is_particle && material.transfer == Transfer::Opaque;
    features.plain &= is_particle
        && material.shape == Shape::Disc
        && material.profile == Profile::Soft
        && material.transfer == Transfer::Filter
        && material.reflectivity == 0.0
        && material.texture.is_none();
}

fn upload<T: bytemuck::Pod>(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    name: &'static str,
    records: &[T],
    texels: u32,
) -> Result<wgpu::Texture, Error> {
    let count = records.len() as u64 * u64::from(texels);
    let texture = allocator.records(
        name,
        Rgba32Uint,
        count,
        TextureUsages::COPY_DST | TextureUsages::STORAGE_BINDING,
    )?;
    let row = ROW as usize * 16;
    let bytes: &[u8] = bytemuck::cast_slice(records);
    let whole = bytes.len() / row * row;
    let write = |first_row: u32, bytes: &[u8]| {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: first_row, z: 0 },
                ..texture.as_image_copy()
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d {
                width: (bytes.len().min(row) / 16) as u32,
                height: bytes.len().div_ceil(row) as u32,
                depth_or_array_layers: 1,
            },
        );
    };
    // A write is staged in one buffer, whose size is limited: 32 MiB at a time.
    let stretch = 512 * row;
    for (i, part) in bytes[..whole].chunks(stretch).enumerate() {
        write((i * 512) as u32, part);
    }
    if whole < bytes.len() {
        write((whole / row) as u32, &bytes[whole..]);
    }
    Ok(texture)
}

fn upload_images(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    textures: &[Texture],
) -> Result<wgpu::Texture, Error> {
    let width = textures.iter().map(|t| t.width).max().unwrap_or(1);
    let height = textures.iter().map(|t| t.height).max().unwrap_or(1);
    let size = [width, height, textures.len().max(1) as u32].map(u64::from);
    let images = allocator.texture("images", Rgba8UnormSrgb, size, TextureUsages::COPY_DST)?;
    for (layer, texture) in textures.iter().enumerate() {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: 0, z: layer as u32 },
                ..images.as_image_copy()
            },
            &texture.rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(texture.width * 4),
                rows_per_image: None,
            },
            wgpu::Extent3d {
                width: texture.width,
                height: texture.height,
                depth_or_array_layers: 1,
            },
        );
    }
    Ok(images)
}

fn upload_materials(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    materials: &[Material],
    textures: &[Texture],
    blue_first: u32,
    absorptions: &[Vec3],
) -> wgpu::Buffer {
    let buffer = allocator.uniform::<[GpuMaterial; MAX_MATERIALS]>("materials");
    let record =
        |(m, &absorption)| GpuMaterial { blue_first, absorption, ..GpuMaterial::new(m, textures) };
    let mut records: Vec<_> = materials.iter().zip(absorptions).map(record).collect();
    records.resize(MAX_MATERIALS, GpuMaterial::zeroed());
    queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&records));
    buffer
}
