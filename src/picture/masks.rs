//! Shadow masks of a picture, bound and ready to be recorded after the visible opaque surfaces.
use crate::{
    error::Error,
    gpu::{Allocator, Kernel, Resources, Timeline, write_records},
    model::MaskSettings,
    records::{MaskParams, MaskSlots, mask_size},
    shadows::kernels::{Kernels, Variant},
    stage::{hits::Features, mask::GROUP_SIZE},
};
use glam::UVec2;
use wgpu::{
    BindGroup, Texture,
    TextureFormat::{R32Uint, Rgba8Unorm, Rgba32Uint},
    TextureUsages,
};

/// Textures of masks.
#[derive(Debug)]
pub(super) struct MaskMemory {
    pub slots: MaskSlots,
    settings: MaskSettings,
    /// Size of the picture [pixels].
    size: UVec2,
    /// Visible surfaces, at the picture's size.
    surfaces: Texture,
    /// Visible surfaces at half size, if masks have half size.
    half_surfaces: Option<Texture>,
    slot_table: Texture,
    /// Masks after the look-up and during the blur, in turns.
    made: [Texture; 2],
    /// Masks at the picture's size, if the others are at half of it.
    enlarged: Option<Texture>,
}

impl MaskMemory {
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        settings: &MaskSettings,
        slots: MaskSlots,
        size: UVec2,
    ) -> Result<Self, Error> {
        let storage = TextureUsages::STORAGE_BINDING;
        let own = mask_size(size, settings.half);
        let layers = u64::from(slots.count.max(1));
        let extent = |size: UVec2, layers| [u64::from(size.x), u64::from(size.y), layers];
        let mut surfaces =
            |name, size| allocator.texture(name, Rgba32Uint, extent(size, 1), storage);
        let whole = surfaces("mask_surfaces", size)?;
        let half = settings.half.then(|| surfaces("half_surfaces", own)).transpose()?;
        let usage = storage | TextureUsages::COPY_SRC;
        let mut masks = |size| allocator.texture("masks", Rgba8Unorm, extent(size, layers), usage);
        let made = [masks(own)?, masks(own)?];
        let enlarged = settings.half.then(|| masks(size)).transpose()?;
        let count = slots.of_lights.len() as u64;
        let slot_table =
            allocator.records("mask_slots", R32Uint, count, TextureUsages::COPY_DST)?;
        write_records(queue, &slot_table, bytemuck::cast_slice(&slots.of_lights).to_vec());
        Ok(Self {
            slots,
            settings: *settings,
            size,
            surfaces: whole,
            half_surfaces: half,
            slot_table,
            made,
            enlarged,
        })
    }

    /// The finished masks, four channels a layer, at the picture's size.
    pub(super) fn masks(&self) -> &Texture {
        // After the look-up, a row pass and a column pass.
        self.enlarged.as_ref().unwrap_or(&self.made[0])
    }

    /// Resources for kernels that read the masks, and for the one that fills `mask_surfaces`.
    pub(super) fn resources(&self) -> Resources<'_> {
        Resources::new()
            .with("mask_surfaces", &self.surfaces)
            .with("mask_slots", &self.slot_table)
            .with("light_masks", self.masks())
    }
}

/// A kernel, bound, with its workgroups.
#[derive(Debug)]
struct MaskPass {
    kernel: Kernel,
    bindings: BindGroup,
    groups: [u32; 3],
}

#[derive(Debug)]
pub(super) struct PreparedMasks {
    passes: Vec<MaskPass>,
}

impl PreparedMasks {
    /// `resources`: views, lights, clusters and maps; `features`: of the maps.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &mut Kernels,
        features: Features,
        memory: &MaskMemory,
        resources: &Resources<'_>,
    ) -> Result<Self, Error> {
        let settings = &memory.settings;
        let own = mask_size(memory.size, settings.half);
        let mut passes = Vec::new();
        let mut add = |variant, size: UVec2, along, layers: u32, bound: Resources<'_>| {
            let params = allocator.uniform::<MaskParams>("mask_params");
            let values = MaskParams {
                size,
                step: if settings.half && size == own { 2 } else { 1 },
                taps: settings.taps / 2,
                along,
                sensitivity: settings.sensitivity,
                depth_scale: settings.depth_scale,
            };
            queue.write_buffer(&params, 0, bytemuck::bytes_of(&values));
            let of_variant = if variant == Variant::MaskLookUp { features } else { Features::NONE };
            let kernel = kernels.plan(allocator.device, variant, of_variant)?.clone();
            let bound = resources.clone().and(&bound).with("mask_params", &params);
            let groups = [size.x.div_ceil(GROUP_SIZE), size.y.div_ceil(GROUP_SIZE), layers];
            let bindings = kernel.bind(allocator.device, &bound)?;
            passes.push(MaskPass { kernel, bindings, groups });
            Ok::<(), Error>(())
        };
        let none = UVec2::ZERO;
        let whole = || Resources::new().with("mask_surfaces", &memory.surfaces);
        let [first, second] = &memory.made;
        let layers = memory.slots.count;
        if let Some(half) = &memory.half_surfaces {
            add(Variant::MaskShrink, own, none, 1, whole().with("new_surfaces", half))?;
        }
        let seen = memory.half_surfaces.as_ref().unwrap_or(&memory.surfaces);
        let on = |to| {
            let slots = Resources::new().with("mask_slots", &memory.slot_table);
            slots.with("mask_surfaces", seen).with("new_masks", to)
        };
        add(Variant::MaskLookUp, own, none, layers, on(first))?;
        if settings.taps > 1 {
            add(Variant::MaskBlur, own, UVec2::X, layers, on(second).with("light_masks", first))?;
            add(Variant::MaskBlur, own, UVec2::Y, layers, on(first).with("light_masks", second))?;
        }
        if let (Some(half), Some(enlarged)) = (&memory.half_surfaces, &memory.enlarged) {
            let bound = whole().with("half_surfaces", half).with("light_masks", first);
            add(
                Variant::MaskEnlarge,
                memory.size,
                none,
                layers,
                bound.with("new_masks", enlarged),
            )?;
        }
        Ok(Self { passes })
    }

    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        for MaskPass { kernel, bindings, groups } in &self.passes {
            let mut pass = timeline.pass(encoder, "gobo mask");
            kernel.record(&mut pass, bindings, *groups);
        }
    }
}
