//! Shadow masks for a host: its depths, normals and shadow functions in, textures out.
use super::{MaskMemory, MaskTextures, camera::MaskCamera};
use crate::{
    error::{Error, Input},
    frame::Commands,
    gpu::{
        Allocator, HostText, Kernel, KernelError, Memory, Shelf, Tier, Timeline, allocated,
        check_alive,
    },
    model::{Light, MaskSettings},
    records::{ALL_LIGHTS, COLORED_BIT, FormerSlots, JOINED_BIT, MaskSlots, SLOTS, ScreenBounds},
    shadows::{
        AreaLevels, Prepared, Shadows, batch::context::view_uniform,
        look_ups::light_source::LightSource,
    },
    stage::{
        features::{Features, Flags},
        mask,
    },
};
use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};
use wgpu::{
    BindGroupLayout, Texture, TextureFormat::R32Uint, TextureFormat::Rgba32Uint, TextureUsages,
};

pub use super::camera::MaskView;

/// A shadow function of a host, such as its sky or a traced sun. Clones share its kernels.
#[derive(Clone, Debug)]
pub struct ShadowFunction(Arc<Text>);

#[derive(Debug)]
struct Text {
    label: String,
    wgsl: String,
    layout: BindGroupLayout,
    tier: Tier,
    made: Mutex<HashMap<Features, Kernel>>,
}

impl Shadows {
    /// Makes a shadow function from WGSL of the host, which declares
    ///
    /// ```wgsl
    /// fn host_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32>
    /// ```
    ///
    /// and its bindings in `@group(1)`, of `layout`. It returns the share of a light that reaches a point
    /// (world space \[m\], unit normal), which multiplies the maps' share. `light` is an index into the
    /// lights that [`LightMasks::prepare`] was given as `chosen`. All other names of the library begin with
    /// `gobo_`. `label` names the text in errors.
    ///
    /// # Errors
    /// If the text is invalid WGSL or does not fit: with its line, as `label:line`; or the device is lost.
    pub fn shadow_function(
        &self,
        label: &str,
        wgsl: &str,
        layout: &BindGroupLayout,
    ) -> Result<ShadowFunction, Error> {
        let (device, tier) = self.device();
        check_alive(device)?;
        let (label, wgsl) = (label.to_owned(), wgsl.to_owned());
        let made = Mutex::default();
        let function =
            ShadowFunction(Arc::new(Text { label, wgsl, layout: layout.clone(), tier, made }));
        function.kernel(device, Features::NONE)?;
        Ok(function)
    }
}

impl ShadowFunction {
    pub(super) fn kernel(
        &self,
        device: &wgpu::Device,
        features: Features,
    ) -> Result<Kernel, KernelError> {
        let Text { label, wgsl, layout, tier, made } = &*self.0;
        let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kernel) = made.get(&features) {
            return Ok(kernel.clone());
        }
        let constants = features.constants();
        let choice = mask::JOINED;
        let host = HostText { label, wgsl, layout, choice, constants: &constants, shared: &[] };
        let kernel = Kernel::with_host_text(device, mask::look_up(features), *tier, &host)?;
        Ok(made.entry(features).or_insert(kernel).clone())
    }
}

/// Slot of a light in [`LightMasks::texture`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MaskSlot {
    /// Layer of the array.
    pub layer: u32,
    /// Channel of the light's share, 0 to 3; `None` if red, green and blue are its shares per channel.
    pub channel: Option<u32>,
}

/// Shadow masks for a host's camera. Textures and bind groups are kept from frame to frame: submit the
/// recorded commands of a frame before you prepare the next.
#[derive(Debug, Default)]
pub struct LightMasks {
    textures: Option<Arc<MaskTextures>>,
    former: FormerSlots,
    frame: Option<MaskFrame>,
    /// Shelf for the device of the last frame.
    shelf: Option<(wgpu::Device, Shelf)>,
}

#[derive(Debug)]
struct MaskFrame {
    memory: MaskMemory,
    levels: Option<AreaLevels>,
    commands: Commands,
    bytes: Memory,
}

impl LightMasks {
    /// No masks.
    pub fn new() -> Self {
        Self::default()
    }

    /// Assigns slots to the `chosen` of `lights`, which the views were made of, where they are visible, and
    /// binds the passes that compute their masks. Lights with names keep their slots as long as possible. The
    /// textures are kept while the size stays and their capacity suffices.
    ///
    /// # Errors
    /// If a light or an input is invalid, a later [`Shadows::prepare`] has taken the maps over, or the device
    /// is lost or out of memory.
    pub fn prepare(
        &mut self,
        prepared: &Prepared,
        lights: &[Light],
        chosen: &[usize],
        view: &MaskView<'_>,
        settings: &MaskSettings,
    ) -> Result<(), Error> {
        prepared.check_usable()?;
        check(settings)?;
        let (device, queue) = prepared.device();
        allocated(device, || {
            let kept = self.shelf.take().filter(|(of, _)| of == device);
            let (_, shelf) =
                self.shelf.insert(kept.unwrap_or_else(|| (device.clone(), Shelf::new(queue))));
            shelf.turn();
            let shelf = Some(&*shelf);
            let camera = view.camera(device, shelf)?;
            let mut bytes = Memory::default();
            let mut allocator = Allocator { shelf, ..Allocator::new(device, &mut bytes) };
            let source =
                prepared.light_source(&mut allocator, lights, chosen, true, Some(&camera.view))?;
            let lights: Vec<&Light> = chosen.iter().map(|&index| &lights[index]).collect();
            let joins = |index: &usize| view.joined.is_some_and(|it| it.lights.contains(index));
            let wants: Vec<_> = lights
                .iter()
                .zip(chosen)
                .map(|(light, index)| {
                    let has_shadow = light.view_count() > 0 || joins(index);
                    let bounds = ScreenBounds::new(light, &camera.view).filter(|_| has_shadow);
                    let colored = prepared.tints || prepared.settings.colored || joins(index);
                    bounds.map(|bounds| (bounds, colored))
                })
                .collect();
            let names: Vec<_> = lights.iter().map(|light| light.name.as_str()).collect();
            let slots = MaskSlots::assign(&wants, &names, settings.limit, &self.former);
            self.former = slots.former(lights.iter().copied());
            self.former.remove("");
            let size = camera.view.size;
            // Frees the bindings of the previous frame.
            self.frame = None;
            let textures =
                MaskTextures::take(&mut self.textures, device, size, settings.half, &slots)?;
            let joined = chosen.iter().map(|index| if joins(index) { JOINED_BIT } else { 0 });
            let memory = MaskMemory::joined(queue, settings, slots, textures, joined);
            let inputs =
                Inputs { prepared, source: &source, camera: &camera, view, memory: &memory };
            let commands = inputs.commands(&mut allocator)?;
            commands.compile()?;
            let levels = source.levels;
            levels.iter().try_for_each(AreaLevels::compile)?;
            self.frame = Some(MaskFrame { memory, levels, commands, bytes });
            Ok(())
        })
    }

    /// Records the masks, after the maps and the host's depths; nothing before [`Self::prepare`].
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        self.record_timed(encoder, &mut Timeline::untimed());
    }

    /// Like [`Self::record`], with timestamps around each pass.
    pub fn record_timed(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        let Some(MaskFrame { levels, commands, .. }) = &self.frame else { return };
        levels.iter().for_each(|levels| levels.record(encoder, timeline));
        commands.record(encoder, timeline);
        timeline.end(encoder);
    }

    /// Array of `rgba8unorm` masks, of the size of the host's depths; usages `TEXTURE_BINDING`,
    /// `STORAGE_BINDING` and `COPY_SRC`. Kept from one `prepare` to the next while its capacity suffices; it
    /// may have more layers than there are masks.
    pub fn texture(&self) -> Option<&Texture> {
        self.frame.as_ref().map(|frame| frame.memory.masks())
    }

    /// Slot of each chosen light; `None` if it has no shadow, is outside the picture or has no slot.
    pub fn slots(&self) -> Vec<Option<MaskSlot>> {
        let of_lights = self.frame.iter().flat_map(|frame| &frame.memory.slots.of_lights);
        of_lights
            .map(|&slot| {
                let place = (slot & !COLORED_BIT).checked_sub(1)?;
                let channel = (slot & COLORED_BIT == 0).then_some(place % SLOTS);
                Some(MaskSlot { layer: place / SLOTS, channel })
            })
            .collect()
    }

    /// Number of masks of the frame.
    pub fn count(&self) -> u32 {
        self.frame.as_ref().map_or(0, |frame| frame.memory.slots.count)
    }

    /// Lights that cast shadows into the picture but have no slot within [`MaskSettings::limit`]: shade
    /// them without masks.
    pub fn unmasked(&self) -> u32 {
        self.frame.as_ref().map_or(0, |frame| frame.memory.slots.unmasked)
    }

    /// Bytes by buffer and texture.
    pub fn memory(&self) -> Memory {
        let mut all = Memory::default();
        if let Some(frame) = &self.frame {
            all.add_all(&frame.bytes);
            all.add_all(frame.memory.memory());
        }
        all
    }
}

/// Inputs of a frame's masks.
struct Inputs<'a> {
    prepared: &'a Prepared,
    source: &'a LightSource,
    camera: &'a MaskCamera,
    view: &'a MaskView<'a>,
    memory: &'a MaskMemory,
}

impl Inputs<'_> {
    /// Commands from the host's depths to the masks.
    fn commands(&self, allocator: &mut Allocator<'_>) -> Result<Commands, Error> {
        let &Self { prepared, source, camera, view, memory } = self;
        let kernels = &prepared.kernels_on(allocator.shelf);
        let (maps, (_, queue)) = (prepared.maps(), prepared.device());
        let gpu_view = camera.view.to_gpu(0, glam::UVec2::ZERO, 0);
        let views = view_uniform(allocator, &[gpu_view]);
        let params = allocator.uniform("host_view", &camera.params);
        let copied = TextureUsages::COPY_DST | TextureUsages::STORAGE_BINDING;
        let clusters = allocator.records("clusters", R32Uint, 2, copied)?;
        let all = bytemuck::cast_slice(&[ALL_LIGHTS, 0]).to_vec();
        crate::gpu::write_records(queue, &clusters, all);
        let none = match &source.levels {
            None => {
                Some(allocator.records("levels", Rgba32Uint, 1, TextureUsages::STORAGE_BINDING)?)
            }
            Some(_) => None,
        };
        let resources = source
            .resources
            .clone()
            .with("views", &views)
            .with("host_view", &params)
            .with("clusters", &clusters)
            .with("host_depths", &camera.depths)
            .with("host_normals", camera.normals.as_ref().unwrap_or(&camera.depths))
            .with_any("levels", none.as_ref());
        let seen = if memory.is_half() { &mask::HALF_HOST_SURFACES } else { &mask::HOST_SURFACES };
        let [x, y] = camera.view.size.to_array().map(|size| size.div_ceil(mask::GROUP_SIZE));
        let of_host = resources.clone().and(&memory.resources());
        let mut dispatches = vec![kernels.dispatch(seen, Features::NONE, &of_host, [x, y, 1])?];
        let features = maps
            .features()
            .with(Flags::HAS_AREAS, source.levels.is_some())
            .with(Flags::HAS_FILTERS, source.is_filtered);
        let joined = view.joined.as_ref();
        dispatches.extend(memory.dispatches(kernels, queue, features, &resources, joined)?);
        let mut commands = Commands::new();
        commands.pass("gobo mask", dispatches);
        Ok(commands)
    }
}

fn check(settings: &MaskSettings) -> Result<(), Error> {
    let MaskSettings { taps, depth_scale, sensitivity, limit, .. } = *settings;
    let invalid = |problem| Err(Input::MaskSetting.invalid(0, problem));
    if taps % 2 == 0 || taps > MaskSettings::MAX_TAPS {
        return invalid("taps must be odd, 1 to 15");
    }
    if !(1..=MaskSettings::MAX_LIMIT).contains(&limit) {
        return invalid("limit must be 1 to 64");
    }
    let is_usable = |v: f32| v.is_finite() && v >= 0.0;
    if !(is_usable(depth_scale) && is_usable(sensitivity) && sensitivity > 0.0) {
        return invalid(
            "depth_scale must be finite and not negative, sensitivity finite and above 0",
        );
    }
    Ok(())
}
