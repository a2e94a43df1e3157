//! A scene's casters on the GPU: uploaded once, read by every view.
mod bricks;
mod caster_records;
mod check;
mod emitted;
mod extent;
mod features;
pub(super) mod group;
pub(crate) mod groups;
mod host_bricks;
pub(crate) mod host_casters;
pub(crate) mod host_kinds;
mod record_sources;
mod slots;
mod update;
mod upload;
mod uploaded;

use crate::records::image_level_count;
pub use extent::{SMALL_SIDE, TriangleExtent};
pub use slots::EmittedSlots;

use crate::shadows::cull::Occluders;
use crate::shadows::{
    casters::{
        group::{Group, Members},
        groups::{Groups, next_generation},
        host_casters::{HostSeen, HostSets},
        host_kinds::record_count,
    },
    host_inputs::HostInputs,
};
use crate::{
    error::Error,
    frame::Kernels,
    gpu::{Allocator, Memory, RecordForm, Resources},
    model::{CLASSES, Casters, Class, Grid, Material, absorptions, by_class, dither::window},
    records::{Bricks, Capsules, GpuView, TriangleRecord},
    stage::features::{Features, Flags},
};
use bricks::UploadedBricks;
use caster_records::{CasterRecords, first_written};
use emitted::Emitted;
use features::{add_host_features, asks_for_owners, features_of};
use glam::UVec2;
use rayon::prelude::*;
use record_sources::{RecordSources, by_kind, particle_order};
use std::{
    ops::{Range, RangeInclusive},
    sync::Arc,
};
use upload::{material_records, upload, upload_images};
use uploaded::{Uploaded, hash};
use wgpu::BufferUsages;

/// The casters of neighbouring classes.
#[derive(Clone, Debug)]
pub struct Span {
    /// Indices in upload order, of particles and Gaussians.
    pub particles: Range<u32>,
    /// Indices in upload order, of triangles.
    pub triangles: Range<u32>,
    /// Kinds among them.
    pub features: Features,
}

impl Span {
    /// Number of casters.
    pub fn count(&self) -> usize {
        self.particles.len() + self.triangles.len()
    }
}

/// Particles, triangles, materials and images in kernel form. The casters of each kind are sorted by class.
/// Within a class, triangles stay in the scene's order, and so do particles if blending depends on the order;
/// otherwise they are sorted in space.
#[derive(Debug)]
pub struct CasterSet {
    /// Records of particles, Gaussians, bricks and capsules.
    pub(super) casters: CasterRecords,
    /// Records of triangles.
    pub triangles: wgpu::Texture,
    /// All textures, one per layer.
    pub images: wgpu::Texture,
    /// Records of the materials.
    pub materials: wgpu::Buffer,
    bricks: UploadedBricks,
    particle_ranges: [Range<u32>; CLASSES],
    triangle_ranges: [Range<u32>; CLASSES],
    features: [Features; CLASSES],
    /// Sets in the host's buffers.
    host: Option<Arc<HostSets>>,
    /// Declared state of each of the host's sets.
    host_seen: Vec<HostSeen>,
    /// Records reserved for the host's casters, behind the uploaded ones.
    host_records: Range<u32>,
    /// Particles of emitters, behind the host's.
    emitted: Vec<Emitted>,
    /// Whether some receiver is tinted by all casters except its own object's.
    pub owners: bool,
    /// Edge of the window over which the coverage of every dithered material equals its opacity \[texels\]; 0
    /// without dithering.
    pub dither_window: u32,
    memory: Memory,
    /// Memory of the host's sets.
    host_memory: Memory,
    groups: Groups,
    uploaded: Uploaded,
    /// Identity of the set, unique.
    id: u64,
}

impl CasterSet {
    /// Resources of the set that kernels read.
    pub fn resources(&self) -> Resources {
        Resources::new()
            .with("casters", self.casters.read())
            .with("triangles", &self.triangles)
            .with("images", &self.images)
            .with("materials", &self.materials)
            .with("bricks", &self.bricks.records)
            .with("voxels", &self.bricks.voxels)
    }

    /// Uploads a scene's casters.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &Casters<'_>,
        form: RecordForm,
    ) -> Result<Self, Error> {
        Self::reserving((device, queue), casters, &HostInputs::new(), &[], form)
    }

    /// A set with records reserved for casters of the host, including bricks of its grids (`host_grids`),
    /// which [`Self::set_host_casters`] fills in, and for emitters, which [`Self::place_emitted`] fills in.
    pub(super) fn reserving(
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        casters: &Casters<'_>,
        inputs: &HostInputs<'_>,
        host_grids: &[Grid],
        form: RecordForm,
    ) -> Result<Self, Error> {
        let mut memory = Memory::default();
        let mut allocator = Allocator::new(device, &mut memory);
        let bricks = UploadedBricks::new(&mut allocator, queue, casters.grids, host_grids)?;
        let capsules = &Capsules::new(casters.strands);
        let particles = &*capsules.among(bricks.among(casters.particles));
        let casters = &Casters { particles, ..*casters };
        let &Casters { gaussians, triangles, materials, textures, in_order, .. } = casters;
        let classes: Vec<_> = materials.iter().map(Class::of).collect();
        let (particle_order, particle_ranges) = particle_order(casters, &classes);
        let (triangle_order, triangle_ranges) =
            by_class(&triangles.iter().map(|t| classes[t.material as usize]));
        let sources = RecordSources::new(casters, capsules);
        let blue_first = sources.blue_first();
        let records = sources.all(&particle_order);
        let triangle_records: Vec<_> = triangle_order
            .par_iter()
            .map(|&i| TriangleRecord::new(&triangles[i as usize]))
            .collect();
        let host_first = first_written(form, records.len() as u32);
        let host_records = host_first..host_first.saturating_add(record_count(inputs));
        let (emitted, end) = emitted::placed(inputs.emitted, host_records.end);
        let members = Members { casters: &records, triangles, order: &triangle_order, materials };
        let of_emitter = |e: &Emitted| (classes[e.slots.material as usize], e.records());
        let of_emitters: Vec<_> = emitted.iter().map(of_emitter).collect();
        let by_kind = by_kind(&particle_ranges, &particle_order, particles.len());
        let groups = Groups::new(members, &by_kind, &triangle_ranges, &of_emitters);
        let absorptions = absorptions(materials, triangles);
        Ok(Self {
            casters: CasterRecords::new(&mut allocator, queue, form, &records, &(host_first..end))?,
            triangles: upload(&mut allocator, queue, "triangles", &triangle_records, 0)?,
            images: upload_images(&mut allocator, queue, textures, inputs.image_levels)?,
            materials: allocator.filled(
                "materials",
                &material_records(materials, textures, blue_first, &absorptions),
                BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            ),
            bricks,
            particle_ranges,
            triangle_ranges,
            features: features_of(particles, gaussians, triangles, materials),
            host: None,
            host_seen: Vec::new(),
            host_records,
            emitted,
            owners: asks_for_owners(materials),
            dither_window: window(materials),
            memory,
            host_memory: Memory::default(),
            groups,
            uploaded: Uploaded {
                particle_order,
                triangle_order,
                casters: records,
                triangles: triangle_records,
                materials: materials.to_vec(),
                textures: textures.iter().map(hash).collect(),
                texture_sizes: textures.iter().map(|t| (t.width, t.height)).collect(),
                blue_first,
                particle_count: particles.len(),
                in_order,
            },
            id: next_generation(),
        })
    }

    /// Whether it has this form, and the reserved records suffice for [`Self::set_host_casters`] with these
    /// sets.
    pub(super) fn suffices(&self, inputs: &HostInputs<'_>, form: RecordForm) -> bool {
        let size = UVec2::new(self.images.width(), self.images.height());
        let levels = if inputs.image_levels { image_level_count(size) } else { 1 };
        self.casters.form() == form
            && record_count(inputs) as usize <= self.host_records.len()
            && self.images.mip_level_count() >= levels
            && self.emitted.iter().map(|emitter| &emitter.slots).eq(inputs.emitted)
    }

    /// Replaces the host's sets, except where they match the former ones. `materials`: those of the uploaded
    /// casters.
    pub(super) fn set_host_casters(
        &mut self,
        kernels: &Kernels,
        materials: &[Material],
        inputs: &HostInputs<'_>,
    ) -> Result<(), Error> {
        inputs.casters.iter().enumerate().try_for_each(|(index, set)| set.check(index))?;
        let follows = match &self.host {
            Some(sets) => sets.follow(materials, self.host_records.start, inputs)?,
            None => false,
        };
        if !follows {
            let (mut memory, shelf) = (Memory::default(), kernels.shelf());
            shelf.iter().for_each(|shelf| shelf.turn());
            let mut allocator =
                Allocator { shelf, ..Allocator::new(kernels.device(), &mut memory) };
            self.host = HostSets::new(&mut allocator, kernels, self, materials, inputs)?;
            self.host_memory = memory;
        }
        self.host_seen.clear();
        self.host_seen.extend(self.host.iter().flat_map(|sets| sets.seen(inputs)));
        add_host_features(&mut self.features, materials, inputs);
        Ok(())
    }

    /// Identity and version of each of the host's sets that a view may see.
    pub(super) fn host_versions<'a>(
        &'a self,
        view: &GpuView,
    ) -> impl Iterator<Item = (usize, Option<u64>)> + use<'a> {
        let view = *view;
        let sets = self.host_seen.iter().enumerate();
        sets.filter_map(move |(index, seen)| Some((index, seen.version(&view)?)))
    }

    pub(crate) fn host(&self) -> Option<&HostSets> {
        self.host.as_deref()
    }

    pub(super) fn shared_host(&self) -> Option<Arc<HostSets>> {
        self.host.clone()
    }

    /// Whether the list, an index of [`Class::LISTS`], has a caster.
    pub(super) fn has(&self, list: usize) -> bool {
        self.count(Class::LISTS[list].clone()) > 0
            || self.host().is_some_and(|host| !host.spans[list].groups.is_empty())
    }

    /// Bytes by texture and buffer.
    pub(crate) fn memory(&self) -> Memory {
        let mut memory = self.memory.clone();
        self.host_memory.0.iter().for_each(|&(name, bytes)| memory.add(name, bytes));
        memory
    }

    /// Spatially coherent groups of casters in upload order, particles first.
    pub fn groups(&self) -> &[Group] {
        &self.groups.groups
    }

    /// The group that contains a triangle of the upload.
    pub(super) fn triangle_group(&self, triangle: u32) -> &Group {
        self.groups.of_triangle(triangle)
    }

    /// Indices of the groups that a view may see, in order. Conservative: includes all that touch one of its
    /// texels.
    pub fn visible(&self, view: &GpuView) -> Vec<u32> {
        self.groups.visible(view)
    }

    /// Occluders of a shadow view.
    pub fn occluders(&self, view: &GpuView) -> Occluders {
        self.groups.occluders(view)
    }

    /// Removes from `visible` the groups hidden by occluders of the same shadow view: without them, its maps,
    /// with curves of `nodes` nodes (0 for none), are the same to the last bit. Returns the number of casters
    /// in these groups.
    pub fn hide(
        &self,
        visible: &mut Vec<u32>,
        view: &GpuView,
        occluders: &Occluders,
        nodes: u32,
    ) -> u64 {
        // Merges in a curve depend on the number of pairs in between, and a cleared map of owners differs in
        // unread bits from one without filtering casters. The number of host casters on a tile is unknown.
        let alone = self.host().is_none_or(|host| host.spans[1].groups.is_empty());
        let filters = nodes == 0 && !self.owners && alone;
        self.groups.hide(visible, view, occluders, filters)
    }

    /// Whether blending depends on the order of the casters.
    pub(super) fn is_ordered(&self) -> bool {
        self.span(Class::FILTERING).features.has(Flags::HAS_OVER)
    }

    /// Generation of the occluders' last change.
    pub(super) fn occluders_at(&self) -> u64 {
        self.groups.occluders_at
    }

    /// Generation of the last change.
    pub(super) fn changed_at(&self) -> u64 {
        self.groups.groups.iter().map(|group| group.changed_at).max().unwrap_or(0)
    }

    /// Identity of the set, unique.
    pub(super) fn id(&self) -> u64 {
        self.id
    }

    /// Records of the bricks.
    pub fn bricks(&self) -> &Bricks {
        self.bricks.bricks()
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
