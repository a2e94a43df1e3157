//! A scene's casters on the GPU: uploaded once, read by every view.
use super::groups::{Group, Groups, Members, now, sort_by_place};
use crate::{
    caster::{Material, Particle, Profile, Receives, Shape, Texture, Transfer, Triangle},
    cull::Occluders,
    dither::{Pattern, blue_ranks, window},
    error::Error,
    footprint::{
        CASTER_TEXELS, Caster, GpuMaterial, MAX_MATERIALS, ROW, TRIANGLE_TEXELS, TriangleRecord,
    },
    gpu::{Allocator, Memory},
    stage::hits::Features,
    view::GpuView,
    volume::absorptions,
};
use bytemuck::Zeroable as _;
use glam::Vec3;
use std::{
    hash::{DefaultHasher, Hash as _, Hasher as _},
    ops::{Range, RangeInclusive},
};
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

/// Particles, triangles, materials and images in kernel form. Within each kind the casters are
/// ordered by class. Within a class triangles stay in the scene's order, and particles do where
/// some filter depends on the order; otherwise neighbours are put together.
#[derive(Debug)]
pub struct CasterSet {
    pub casters: wgpu::Texture,
    pub triangles: wgpu::Texture,
    pub images: wgpu::Texture,
    pub materials: wgpu::Buffer,
    particle_ranges: [Range<u32>; CLASSES],
    triangle_ranges: [Range<u32>; CLASSES],
    features: [Features; CLASSES],
    /// Whether some receiver is tinted by all casters but its own.
    pub owners: bool,
    /// Edge of the window that shows every dithered material's opacity, 0 for none [texels].
    pub dither_window: u32,
    /// Bytes by texture and buffer.
    pub memory: Memory,
    groups: Groups,
    source: Source,
    /// When it was made: no other set has the same.
    id: u64,
}

/// What was uploaded, to tell what changes.
#[derive(Debug)]
struct Source {
    /// Indices into the scene's particles and triangles, in the order of the upload.
    particle_order: Vec<u32>,
    triangle_order: Vec<u32>,
    /// Particles, then the ranks of the blue noise.
    casters: Vec<Caster>,
    triangles: Vec<TriangleRecord>,
    materials: Vec<Material>,
    /// Hashes.
    textures: Vec<u64>,
    /// [texels]
    texture_sizes: Vec<(u32, u32)>,
    blue_first: u32,
}

/// What decides where a material's casters are in the upload.
fn layout(material: &Material) -> (Class, bool, bool) {
    let blue = material.transfer == Transfer::Dither && material.pattern == Pattern::Blue;
    (Class::of(material), material.transfer == Transfer::Over, blue)
}

fn hash(texture: &Texture) -> u64 {
    let mut hasher = DefaultHasher::new();
    (texture.width, texture.height, &texture.rgba).hash(&mut hasher);
    hasher.finish()
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
        let layouts: Vec<_> = materials.iter().map(layout).collect();
        let (mut particle_order, particle_ranges) =
            by_class(&particles.iter().map(|p| classes[p.material as usize]));
        let is_ordered = |class| layouts.iter().any(|&(of, over, _)| of == class && over);
        for (class, range) in Class::ALL.into_iter().zip(&particle_ranges) {
            if !is_ordered(class) {
                let particles_of = &mut particle_order[range.start as usize..range.end as usize];
                sort_by_place(particles_of, |i| particles[i as usize].center);
            }
        }
        let (triangle_order, triangle_ranges) =
            by_class(&triangles.iter().map(|t| classes[t.material as usize]));
        let mut casters: Vec<_> = particle_order
            .iter()
            .map(|&i| &particles[i as usize])
            .map(|p| Caster::new(p, &materials[p.material as usize]))
            .collect();
        let records: Vec<_> =
            triangle_order.iter().map(|&i| TriangleRecord::new(&triangles[i as usize])).collect();
        let owners = asks_for_owners(materials);
        let features = features_of(particles, triangles, materials);
        let by = |ranges: &[Range<u32>; CLASSES]| {
            Class::ALL.into_iter().zip(ranges.iter().cloned()).collect::<Vec<_>>()
        };
        let members = Members { casters: &casters, triangles, order: &triangle_order, materials };
        let groups = Groups::new(members, &by(&particle_ranges), &by(&triangle_ranges));
        let blue_first = casters.len() as u32 * CASTER_TEXELS;
        if layouts.iter().any(|&(_, _, blue)| blue) {
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
            particle_ranges,
            triangle_ranges,
            features,
            owners,
            dither_window: window(materials),
            memory,
            groups,
            source: Source {
                particle_order,
                triangle_order,
                casters,
                triangles: records,
                materials: materials.to_vec(),
                textures: textures.iter().map(hash).collect(),
                texture_sizes: textures.iter().map(|t| (t.width, t.height)).collect(),
                blue_first,
            },
            id: now(),
        })
    }

    /// Takes over what has changed in the scene and uploads that alone. False where it could not,
    /// and a new set must be made: with another number of casters, materials or textures, other
    /// sizes of textures, casters of another class, or particles that have drifted so far apart
    /// that other neighbours should be together.
    pub fn update(
        &mut self,
        queue: &wgpu::Queue,
        particles: &[Particle],
        triangles: &[Triangle],
        materials: &[Material],
        textures: &[Texture],
    ) -> bool {
        let Self { source, groups, .. } = self;
        let same_layouts = materials.len() == source.materials.len()
            && materials.iter().map(layout).eq(source.materials.iter().map(layout));
        let sizes = textures.iter().map(|t| (t.width, t.height));
        if !same_layouts
            || particles.len() != source.particle_order.len()
            || triangles.len() != source.triangle_order.len()
            || !sizes.eq(source.texture_sizes.iter().copied())
        {
            return false;
        }
        let classes: Vec<_> = materials.iter().map(Class::of).collect();
        let in_place = |order: &[u32], ranges: &[Range<u32>; CLASSES], of: &dyn Fn(u32) -> u32| {
            Class::ALL.into_iter().zip(ranges).all(|(class, range)| {
                let members = &order[range.start as usize..range.end as usize];
                members.iter().all(|&i| classes[of(i) as usize] == class)
            })
        };
        if !in_place(&source.particle_order, &self.particle_ranges, &|i| {
            particles[i as usize].material
        }) || !in_place(&source.triangle_order, &self.triangle_ranges, &|i| {
            triangles[i as usize].material
        }) {
            return false;
        }

        let hashes: Vec<u64> = textures.iter().map(hash).collect();
        let new_texture: Vec<bool> =
            hashes.iter().zip(&source.textures).map(|(new, old)| new != old).collect();
        for (layer, _) in new_texture.iter().enumerate().filter(|&(_, &new)| new) {
            upload_image(queue, &self.images, layer, &textures[layer]);
        }
        let new_material: Vec<bool> = materials
            .iter()
            .zip(&source.materials)
            .map(|(new, old)| new != old || new.texture.is_some_and(|t| new_texture[t as usize]))
            .collect();
        if new_material.contains(&true) {
            let absorptions = absorptions(materials, triangles);
            let records = material_records(materials, textures, source.blue_first, &absorptions);
            queue.write_buffer(&self.materials, 0, bytemuck::cast_slice(&records));
        }
        (source.materials, source.textures) = (materials.to_vec(), hashes);
        self.features = features_of(particles, triangles, materials);
        self.dither_window = window(materials);
        self.owners = asks_for_owners(materials);

        let changed_at = now();
        let (mut new_particles, mut new_triangles) = (Vec::new(), Vec::new());
        let mut new_sheets = false;
        for group in &mut groups.groups {
            let range = group.casters.start as usize..group.casters.end as usize;
            let is_new = if group.is_triangles() {
                let records = &mut source.triangles[range.clone()];
                replace(records, &source.triangle_order[range], |i| {
                    let triangle = &triangles[i as usize];
                    (TriangleRecord::new(triangle), new_material[triangle.material as usize])
                })
            } else {
                let records = &mut source.casters[range.clone()];
                replace(records, &source.particle_order[range], |i| {
                    let particle = &particles[i as usize];
                    let material = particle.material as usize;
                    (Caster::new(particle, &materials[material]), new_material[material])
                })
            };
            if is_new {
                let order = &source.triangle_order;
                let members = Members { casters: &source.casters, triangles, order, materials };
                group.refit(members, changed_at);
                new_sheets |= group.may_hide();
                let parts =
                    if group.is_triangles() { &mut new_triangles } else { &mut new_particles };
                parts.push(group.casters.clone());
            }
        }
        if new_sheets {
            let order = &source.triangle_order;
            let members = Members { casters: &source.casters, triangles, order, materials };
            groups.find_sheets(members, changed_at);
        }
        upload_parts(queue, &self.casters, &source.casters, CASTER_TEXELS, &new_particles);
        upload_parts(queue, &self.triangles, &source.triangles, TRIANGLE_TEXELS, &new_triangles);
        (new_particles.is_empty() && new_triangles.is_empty()) || groups.refit()
    }

    /// Casters that lie together, in the order of the upload: particles first.
    pub fn groups(&self) -> &[Group] {
        &self.groups.groups
    }

    /// The group that a triangle of the upload is in.
    pub(super) fn triangle_group(&self, triangle: u32) -> &Group {
        self.groups.of_triangle(triangle)
    }

    /// Indices of the groups that a view may see, in order: all that touch one of its texels, and
    /// few others.
    pub fn visible(&self, view: &GpuView) -> Vec<u32> {
        self.groups.visible(view)
    }

    /// What hides others in a shadow view.
    pub fn occluders(&self, view: &GpuView) -> Occluders {
        self.groups.occluders(view)
    }

    /// Takes the groups out of `visible` that occluders of the same shadow view hide: its maps of
    /// `nodes` a curve, 0 for none, are the same to the last bit without them. Returns how many
    /// casters these groups have.
    pub fn hide(
        &self,
        visible: &mut Vec<u32>,
        view: &GpuView,
        occluders: &Occluders,
        nodes: u32,
    ) -> u64 {
        // What a curve merges hangs on how many pairs lie between; and a map of owners that is
        // cleared has other bits, which nobody reads, than one that nothing filters.
        let filters = nodes == 0 && !self.owners;
        self.groups.hide(visible, view, occluders, filters)
    }

    /// When occluders last changed.
    pub(super) fn sheets_at(&self) -> u64 {
        self.groups.sheets_at
    }

    /// When something in it last changed.
    pub(super) fn changed_at(&self) -> u64 {
        self.groups.groups.iter().map(|group| group.changed_at).max().unwrap_or(0)
    }

    /// No other set has the same.
    pub(super) fn id(&self) -> u64 {
        self.id
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

fn features_of(
    particles: &[Particle],
    triangles: &[Triangle],
    materials: &[Material],
) -> [Features; CLASSES] {
    let mut features = [Features::NONE; CLASSES];
    for particle in particles {
        add_features(&mut features, &materials[particle.material as usize], true);
    }
    for triangle in triangles {
        add_features(&mut features, &materials[triangle.material as usize], false);
    }
    let owners = asks_for_owners(materials);
    for features in features.iter_mut().filter(|_| owners) {
        features.owners = true;
        features.plain = false;
    }
    features
}

/// Whether some receiver is tinted by all casters but its own.
fn asks_for_owners(materials: &[Material]) -> bool {
    materials.iter().any(|m| m.visible && m.receives == Receives::Others)
}

/// Puts what is made of each index into the records. Whether one differs, or must be new.
fn replace<T: PartialEq>(
    records: &mut [T],
    order: &[u32],
    make: impl Fn(u32) -> (T, bool),
) -> bool {
    let mut is_new = false;
    for (record, &index) in records.iter_mut().zip(order) {
        let (made, must) = make(index);
        is_new |= must || *record != made;
        *record = made;
    }
    is_new
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
    features.plain &= is_particle && is_plain(material);
}

/// Whether a particle is a soft disc of the `filter` transfer and nothing else.
pub(crate) fn is_plain(material: &Material) -> bool {
    material.shape == Shape::Disc
        && material.profile == Profile::Soft
        && material.transfer == Transfer::Filter
        && material.reflectivity == 0.0
        && material.texture.is_none()
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
    write_rows(queue, &texture, 0, bytemuck::cast_slice(records));
    Ok(texture)
}

/// Bytes of a row of a record texture.
const ROW_BYTES: usize = ROW as usize * 16;

/// The rows that hold the records of `parts`, which are in order.
fn upload_parts<T: bytemuck::Pod>(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    records: &[T],
    texels: u32,
    parts: &[Range<u32>],
) {
    let bytes: &[u8] = bytemuck::cast_slice(records);
    let write = |rows: Range<u32>| {
        let end = (rows.end as usize * ROW_BYTES).min(bytes.len());
        write_rows(queue, texture, rows.start, &bytes[rows.start as usize * ROW_BYTES..end]);
    };
    let mut pending = 0..0;
    for part in parts {
        let rows = part.start * texels / ROW..(part.end * texels).div_ceil(ROW);
        if rows.start <= pending.end && !pending.is_empty() {
            pending.end = pending.end.max(rows.end);
        } else {
            if !pending.is_empty() {
                write(pending);
            }
            pending = rows;
        }
    }
    if !pending.is_empty() {
        write(pending);
    }
}

/// Whole rows, and what is left in the last one.
fn write_rows(queue: &wgpu::Queue, texture: &wgpu::Texture, first_row: u32, bytes: &[u8]) {
    let row = ROW_BYTES;
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
        write(first_row + (i * 512) as u32, part);
    }
    if whole < bytes.len() {
        write(first_row + (whole / row) as u32, &bytes[whole..]);
    }
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
        upload_image(queue, &images, layer, texture);
    }
    Ok(images)
}

fn upload_image(queue: &wgpu::Queue, images: &wgpu::Texture, layer: usize, texture: &Texture) {
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
        wgpu::Extent3d { width: texture.width, height: texture.height, depth_or_array_layers: 1 },
    );
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
    let records = material_records(materials, textures, blue_first, absorptions);
    queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&records));
    buffer
}

fn material_records(
    materials: &[Material],
    textures: &[Texture],
    blue_first: u32,
    absorptions: &[Vec3],
) -> Vec<GpuMaterial> {
    let record =
        |(m, &absorption)| GpuMaterial { blue_first, absorption, ..GpuMaterial::new(m, textures) };
    let mut records: Vec<_> = materials.iter().zip(absorptions).map(record).collect();
    records.resize(MAX_MATERIALS, GpuMaterial::zeroed());
    records
}
