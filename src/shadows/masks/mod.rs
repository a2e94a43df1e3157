//! Shadow masks, made after the visible surfaces.
mod camera;
mod host;

pub use host::{LightMasks, MaskSlot, MaskView, ShadowFunction};

use crate::{
    error::Error,
    frame::{Dispatch, HostBindings, Kernels},
    gpu::{Allocator, Memory, Resources, reused, write_records},
    model::MaskSettings,
    records::{MaskParams, MaskSlots, mask_size},
    stage::{
        features::Features,
        mask::{self, GROUP_SIZE, masks_at_once},
    },
};
use camera::Joined;
use glam::UVec2;
use std::sync::Arc;
use wgpu::{
    Buffer, Texture,
    TextureFormat::{R32Uint, Rgba8Unorm, Rgba32Uint},
    TextureUsages,
};

/// Textures of masks, kept from frame to frame while their capacity suffices.
#[derive(Debug)]
pub struct MaskTextures {
    /// Size of the picture \[pixels\].
    size: UVec2,
    half: bool,
    masks: u32,
    lights: u32,
    /// Visible surfaces, at the picture's size.
    surfaces: Texture,
    /// Surfaces of masks of half the size.
    half_surfaces: Option<Texture>,
    /// Receiver points, at the masks' size.
    points: Texture,
    slot_table: Texture,
    /// Targets of look-up and blur, alternating.
    made: [Texture; 2],
    /// Masks at the picture's size, if they are computed at half the size.
    enlarged: Option<Texture>,
    /// Parameters of look-up, rows, columns and enlarging.
    params: [Buffer; 4],
    /// Bytes by texture.
    pub memory: Memory,
}

impl MaskTextures {
    fn new(
        device: &wgpu::Device,
        size: UVec2,
        half: bool,
        masks: u32,
        lights: u32,
    ) -> Result<Self, Error> {
        let mut memory = Memory::default();
        let allocator = &mut Allocator::new(device, &mut memory);
        let storage = TextureUsages::STORAGE_BINDING;
        let mask_size = mask_size(size, half);
        let extent = |size: UVec2, layers| [u64::from(size.x), u64::from(size.y), layers];
        let mut surfaces =
            |name, size| allocator.texture(name, Rgba32Uint, extent(size, 1), storage);
        let whole = surfaces("mask_surfaces", size)?;
        let half_surfaces = half.then(|| surfaces("half_surfaces", mask_size)).transpose()?;
        let points = surfaces("mask_points", mask_size)?;
        let usage = storage | TextureUsages::COPY_SRC;
        let mut of_size =
            |size| allocator.texture("masks", Rgba8Unorm, extent(size, masks.into()), usage);
        let made = [of_size(mask_size)?, of_size(mask_size)?];
        let enlarged = half.then(|| of_size(size)).transpose()?;
        let read = storage | TextureUsages::COPY_DST;
        let slot_table = allocator.records("mask_slots", R32Uint, lights.into(), read)?;
        let params =
            std::array::from_fn(|_| allocator.rewritten_uniform::<MaskParams>("mask_params"));
        Ok(Self {
            size,
            half,
            masks,
            lights,
            surfaces: whole,
            half_surfaces,
            points,
            slot_table,
            made,
            enlarged,
            params,
            memory,
        })
    }

    /// `former`, or new textures if it is shared or too small.
    pub fn take(
        former: &mut Option<Arc<Self>>,
        device: &wgpu::Device,
        size: UVec2,
        half: bool,
        slots: &MaskSlots,
    ) -> Result<Arc<Self>, Error> {
        let (masks, lights) = (slots.count.max(1), slots.of_lights.len() as u32);
        let suffices = |former: &Self| {
            (former.size, former.half) == (size, half)
                && former.masks >= masks
                && former.lights >= lights
        };
        reused(former, suffices, || Self::new(device, size, half, masks, lights))
    }
}

/// Resources of a frame's masks.
#[derive(Debug)]
pub struct MaskMemory {
    /// Masks of each light.
    pub slots: MaskSlots,
    settings: MaskSettings,
    textures: Arc<MaskTextures>,
}

impl MaskMemory {
    /// Memory of the masks of a picture.
    pub fn new(
        queue: &wgpu::Queue,
        settings: &MaskSettings,
        slots: MaskSlots,
        textures: Arc<MaskTextures>,
    ) -> Self {
        let none = std::iter::repeat_n(0, slots.of_lights.len());
        Self::joined(queue, settings, slots, textures, none)
    }

    /// `joined`: flags of each light's slot on the device.
    fn joined(
        queue: &wgpu::Queue,
        settings: &MaskSettings,
        slots: MaskSlots,
        textures: Arc<MaskTextures>,
        joined: impl Iterator<Item = u32>,
    ) -> Self {
        let bits = slots.of_lights.iter().zip(joined);
        let table: Vec<u32> =
            bits.map(|(&slot, bits)| if slot == 0 { 0 } else { slot | bits }).collect();
        write_records(queue, &textures.slot_table, bytemuck::cast_slice(&table).to_vec());
        Self { slots, settings: *settings, textures }
    }

    /// The masks at the picture's size, four channels per layer; there may be more layers than masks.
    pub fn masks(&self) -> &Texture {
        // The result of a look-up, a row and a column.
        self.textures.enlarged.as_ref().unwrap_or(&self.textures.made[0])
    }

    /// Resources for readers of the masks, and for the kernel that fills `mask_surfaces`.
    pub fn resources(&self) -> Resources {
        let MaskTextures { surfaces, half_surfaces, points, slot_table, .. } = &*self.textures;
        Resources::new()
            .with("mask_surfaces", surfaces)
            .with("mask_points", points)
            .with("mask_slots", slot_table)
            .with("light_masks", self.masks())
            .with_any("half_surfaces", half_surfaces.as_ref())
    }

    /// Textures by name.
    pub fn memory(&self) -> &Memory {
        &self.textures.memory
    }

    /// Whether masks have half the picture's size.
    pub fn is_half(&self) -> bool {
        self.settings.half
    }

    /// Makes the masks from `mask_surfaces`. `resources`: views, lights, clusters and maps; `features`: of
    /// the maps; `joined`: a shadow function of the host.
    pub fn dispatches(
        &self,
        kernels: &Kernels,
        queue: &wgpu::Queue,
        features: Features,
        resources: &Resources,
        joined: Option<&Joined<'_>>,
    ) -> Result<Vec<Dispatch>, Error> {
        let Self { slots, settings, textures } = self;
        let size = mask_size(textures.size, settings.half);
        let masks_at_once = masks_at_once(slots.count);
        let layers = slots.count.div_ceil(masks_at_once);
        let [of_look_up, of_rows, of_columns, of_enlarging] = &textures.params;
        let fill = |params: &Buffer, size: UVec2, step, column| {
            let values = MaskParams {
                size,
                step,
                taps: settings.taps / 2,
                sensitivity: settings.sensitivity,
                depth_scale: settings.depth_scale,
                column,
                mask_count: slots.count,
                anisotropic: u32::from(settings.anisotropic),
                pad_0: 0,
                pad_1: 0,
                pad_2: 0,
            };
            queue.write_buffer(params, 0, bytemuck::bytes_of(&values));
            [size.x.div_ceil(GROUP_SIZE), size.y.div_ceil(GROUP_SIZE), layers]
        };
        let step = 1 + u32::from(settings.half);
        let [first, second] = &textures.made;
        let seen = textures.half_surfaces.as_ref().unwrap_or(&textures.surfaces);
        let resources = resources.clone().and(&self.resources());
        let on = |to, params| {
            let resources = resources.clone().with("mask_surfaces", seen).with("new_masks", to);
            resources.with("mask_params", params)
        };
        let plain = Features { masks_at_once, ..Features::NONE };
        let features = Features { masks_at_once, ..features };

        let groups = fill(of_look_up, size, step, 0);
        let look_up = match joined {
            Some(joined) => joined.function.kernel(kernels.device(), features)?,
            None => kernels.get(mask::look_up(features), features)?,
        };
        let look_up = kernels.dispatch_of(look_up, &on(first, of_look_up), groups)?;
        let mut dispatches = vec![match joined {
            Some(joined) => look_up.with_host(HostBindings::new(joined.bindings)),
            None => look_up,
        }];
        if settings.taps > 1 {
            let blurs = [(of_rows, first, second), (of_columns, second, first)];
            for (column, (params, from, to)) in (0..).zip(blurs) {
                let groups = fill(params, size, step, column);
                let resources = on(to, params).with("light_masks", from);
                dispatches.push(kernels.dispatch(&mask::BLUR, plain, &resources, groups)?);
            }
        }
        if let Some(enlarged) = &textures.enlarged {
            let groups = fill(of_enlarging, textures.size, 1, 0);
            let resources = resources
                .with("light_masks", first)
                .with("new_masks", enlarged)
                .with("mask_params", of_enlarging);
            dispatches.push(kernels.dispatch(&mask::ENLARGE, plain, &resources, groups)?);
        }
        Ok(dispatches)
    }
}
