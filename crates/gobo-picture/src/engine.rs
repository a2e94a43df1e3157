//! Rendering of scenes on a device.
use super::{
    Frame, RenderOptions,
    emitters::DeviceEmitters,
    read_maps::{DeviceCurves, read_maps},
    watch::tell,
    work::{Stages, Work},
};
use crate::picture::{
    Kept, PictureCapacity, PictureRequest, PreparedPicture,
    debug::{self, DebugMode},
};
use glam::Vec3;
use gobo::{
    Error,
    gpu::{Gpu, KernelJob, Memory, Timeline},
    model::{Class, Counters, CurveMemory, Receiver, Scene, ShadowSettings, View, moved},
    records::Picture,
    shadows::{Config, HostInputs, Prepared, Shadows},
    stage::sort::pair_limit,
    view::{atlas::AtlasLimits, picture_views},
};
use gobo_reference as reference;

#[derive(Debug)]
pub(super) struct GpuEngine {
    pub(super) gpu: Gpu,
    pub(super) shadows: Shadows,
    pub(super) work: Work,
    pub(super) emitters: DeviceEmitters,
    /// Buffer sizes of the last picture, if all its pairs fitted.
    capacity: Option<PictureCapacity>,
    /// Drawings of pictures, and capacities that were too small, in all frames.
    drawn: u64,
    grown: u64,
    /// Whether a frame with the same casters has counted its pairs.
    has_counted: bool,
    /// State of the previous picture.
    kept: Kept,
    /// Curves that stayed on the device.
    pub(super) curves: Option<DeviceCurves>,
}

type Record = fn(&PreparedPicture, &mut wgpu::CommandEncoder, &mut Timeline);

/// Inputs of a frame's picture and of its heat maps.
#[derive(Clone)]
struct Lit<'a> {
    scene: &'a Scene,
    camera: View,
    prepared: &'a Prepared,
}

impl Lit<'_> {
    fn request(&self, capacity: PictureCapacity) -> PictureRequest<'_> {
        let Self { scene, camera, prepared } = self;
        PictureRequest { scene, camera, prepared, capacity }
    }
}

/// The settings of a frame's maps. Where nothing filters light, curves would be 1 at every depth, as nearest
/// depths say with a fifth of the memory; maps that are read back have what the scene asks for.
pub(super) fn settings(scene: &Scene, reads_maps: bool) -> ShadowSettings {
    let filters = |material| Class::FILTERING.contains(&Class::of(material));
    let has_curves = reads_maps || scene.shadow.soften || scene.materials.iter().any(filters);
    let receiver = if has_curves { scene.shadow.receiver } else { Receiver::Nearest };
    let curve_memory = CurveMemory::Counted;
    ShadowSettings { receiver, curve_memory, ..scene.shadow }
}

/// Whether the samples of a pixel share light; through a lens they have other eyes.
fn shares_light(scene: &Scene) -> bool {
    scene.samples > 1 && scene.lens.radius == 0.0
}

/// Whether samples share the light of surfaces, too; masks are smoothed by each sample's own surfaces.
fn shares_surfaces(scene: &Scene) -> bool {
    shares_light(scene) && scene.mask.is_none()
}

impl GpuEngine {
    /// An engine on an open device.
    pub(super) fn new(gpu: Gpu) -> Result<Self, Error> {
        let config = Config::new(gpu.tier, &gpu.adapter);
        let shadows = Shadows::sharing(&gpu.device, &gpu.queue, config, gpu.kernels.clone())?;
        let work = Work::new(&gpu);
        let (emitters, kept) = (DeviceEmitters::default(), Kept::default());
        let (capacity, has_counted) = (None, false);
        let (drawn, grown, curves) = (0, 0, None);
        Ok(Self { gpu, shadows, work, emitters, capacity, drawn, grown, has_counted, kept, curves })
    }

    /// First error that the device reported: without memory for a texture, a later error only says that it
    /// cannot be bound.
    pub(super) fn cause_of(&self, error: Error) -> Error {
        self.gpu.check().err().unwrap_or(error)
    }

    pub(super) fn render(
        &mut self,
        scene: &Scene,
        options: &RenderOptions<'_>,
    ) -> Result<Frame, Error> {
        let cache = self.shadows.kernels().cache().clone();
        cache.made_meanwhile(|| self.frame(scene, options))
    }

    fn frame(&mut self, scene: &Scene, options: &RenderOptions<'_>) -> Result<Frame, Error> {
        self.shadows.configure(|config| config.toggles.sums = options.sums);
        // Times of a frame that failed.
        self.work.take();
        self.curves = None;
        let before = self.repeats();
        self.emit(scene)?;
        let limits = AtlasLimits::of(&self.gpu.device.limits());
        let (views, shrunk) = picture_views(scene, &limits);
        let whole = View::from_camera(&scene.camera, &scene.held_bounds());
        self.kept.is_first = options.sample.is_none() && shares_surfaces(scene);
        let first = options.sample.unwrap_or(0) as usize;
        let camera = View::of_samples(scene, &whole).nth(first).unwrap_or_else(|| whole.clone());
        // Compiles the picture's kernels while the device renders the maps of a first frame.
        let ahead = |engine: &mut Self, prepared: &Prepared| {
            if options.maps_only || engine.capacity.is_some() {
                return Ok(());
            }
            let lit = Lit { scene, camera: camera.clone(), prepared };
            let request = lit.request(PictureCapacity::default());
            PreparedPicture::uncompiled(&engine.shadows, &request, &mut engine.kept).map(drop)
        };
        let (prepared, counted) =
            self.shade_maps(scene, &views, &settings(scene, options.maps), ahead)?;
        let maps = if options.maps {
            let owners = self.shadows.casters()?.owners;
            let caustics = prepared.caustics.as_ref();
            let curves = DeviceCurves::of(prepared.maps(), &views, options);
            let (maps, of_device) = (prepared.maps(), curves.as_ref());
            let maps = read_maps(&self.gpu, maps, &views, owners, caustics, options, of_device)?;
            self.curves = curves.filter(|_| options.curves_stay);
            maps
        } else {
            Vec::new()
        };
        tell(options.watch, 1, options.samples(scene) + 1)?;
        let mut skipped = scene.skipped.clone();
        if self.emitters.left_out > 0 {
            *skipped.entry(moved::PARTICLE).or_default() += self.emitters.left_out;
        }
        let mut frame = Frame {
            picture: Picture::default(),
            debug: Vec::new(),
            maps,
            counters: Counters { shrunk: shrunk as u64, skipped, ..counted },
            stages: self.work.take(),
            picture_stages: Stages::new(),
            memory: Vec::new(),
        };
        let mut memory = prepared.memory().clone();
        memory.add_all(&self.emitters.memory);
        prepared.caustics.iter().for_each(|caustics| memory.add_all(&caustics.memory));
        if !options.maps_only {
            let lit = Lit { scene, camera, prepared: &prepared };
            self.add_picture(&mut frame, &mut memory, &lit, &whole, options)?;
        }
        frame.memory = memory.0;
        let counters = &mut frame.counters;
        let counts = [
            &mut counters.levels_made,
            &mut counters.pictures_drawn,
            &mut counters.capacities_grown,
        ];
        for (count, (now, before)) in counts.into_iter().zip(self.repeats().into_iter().zip(before))
        {
            *count = now - before;
        }
        self.gpu.check()?;
        if !options.keep {
            self.forget();
        }
        Ok(frame)
    }

    /// Renders the pictures, and adds their costs to those of the maps.
    fn add_picture(
        &mut self,
        frame: &mut Frame,
        memory: &mut Memory,
        lit: &Lit<'_>,
        whole: &View,
        options: &RenderOptions<'_>,
    ) -> Result<(), Error> {
        let scene = lit.scene;
        let budget = scene.shadow.pair_budget.min(pair_limit(&self.gpu.device));
        self.kept.first_light = None;
        let (shown, capacity, overflowed) = self.shade_whole_picture(lit, budget)?;
        memory.add_all(&shown.memory);
        let mut picture = shown.read(&self.gpu)?;
        let has_more = scene.samples > 1 && options.sample.is_none();
        if options.light || has_more {
            picture.light = self.read_light(&shown)?;
        }
        if has_more {
            self.kept.first_light = shares_light(scene).then(|| shown.first_light());
            picture = self.shade_samples(lit, whole, budget, picture.light, options)?;
            self.kept.first_light = None;
        } else {
            tell(options.watch, 1, 1)?;
        }
        self.kept.slots = shown.slots().former(scene.lights.iter());
        let clusters = shown.read_cluster_counters(&self.gpu)?;
        for &mode in options.debug {
            frame.debug.push((mode, self.shade_debug(mode, lit, &shown, &picture, capacity)?));
        }
        frame.picture = picture;
        frame.picture_stages = self.work.take();
        let of_picture = frame.picture_stages.iter().map(|(_, ms)| ms).sum();
        frame.stages.push(("picture", of_picture));
        let counters = &mut frame.counters;
        counters.cluster_lights = clusters.needed.into();
        counters.clusters_overflowed = clusters.overflowed.into();
        counters.masks = shown.slots().count.into();
        counters.unmasked_lights = shown.slots().unmasked.into();
        counters.overflowed += overflowed;
        Ok(())
    }

    /// Counts over all frames: maps whose levels were made, drawings of pictures, and capacities that were
    /// too small.
    fn repeats(&self) -> [u64; 3] {
        [self.shadows.levels_made(), self.drawn, self.grown]
    }

    /// The kernels of a frame that are not made yet.
    pub(super) fn pending(&mut self, scene: &Scene) -> Result<Vec<KernelJob>, Error> {
        self.emit(scene)?;
        let (views, _) = picture_views(scene, &AtlasLimits::of(&self.gpu.device.limits()));
        let camera = View::from_camera(&scene.camera, &scene.held_bounds());
        let (casters, slots) = (scene.casters(), self.emitters.slots.clone());
        let inputs = HostInputs::new().emitted(&slots).image_levels();
        let count_first = !self.has_counted;
        self.shadows.configure(|config| config.toggles.count_first = count_first);
        // Prepared twice, as in `Shadows::pending`: maps of an earlier frame are cleared by a kernel.
        self.kept.is_first = shares_surfaces(scene);
        let settings = &settings(scene, false);
        self.shadows.prepare_uncompiled(&casters, &views, settings, &inputs)?;
        let prepared = self.shadows.prepare_uncompiled(&casters, &views, settings, &inputs)?;
        let lit = Lit { scene, camera, prepared: &prepared };
        let request = lit.request(self.capacity.unwrap_or_default());
        PreparedPicture::uncompiled(&self.shadows, &request, &mut self.kept)?;
        Ok(self.shadows.kernels().cache().pending())
    }

    pub(super) fn forget(&mut self) {
        self.shadows.forget();
        self.emitters = DeviceEmitters::default();
        self.has_counted = false;
    }

    /// Renders the maps until their pairs fit. `ahead` requests kernels that compile meanwhile.
    pub(super) fn shade_maps(
        &mut self,
        scene: &Scene,
        views: &[View],
        settings: &ShadowSettings,
        ahead: impl FnOnce(&mut Self, &Prepared) -> Result<(), Error>,
    ) -> Result<(Prepared, Counters), Error> {
        let mut ahead = Some(ahead);
        let (casters, slots) = (scene.casters(), self.emitters.slots.clone());
        let inputs = HostInputs::new().emitted(&slots).image_levels();
        let count_first = !self.has_counted;
        self.shadows.configure(|config| config.toggles.count_first = count_first);
        loop {
            let mut prepared = self.shadows.prepare_with(&casters, views, settings, &inputs)?;
            self.shadows.configure(|config| config.toggles.count_first = false);
            self.has_counted = true;
            ahead.take().map_or(Ok(()), |ahead| ahead(self, &prepared))?;
            self.work
                .submit(&self.gpu, |encoder, timeline| prepared.record_timed(encoder, timeline))?;
            let counters = prepared.counters()?;
            self.gpu.check()?;
            if !self.shadows.grow_from(&counters) {
                let has_filters = !self.shadows.config().toggles.sums;
                let throws = || prepared.throw_light(&scene.lights, &casters);
                let caustics = if has_filters { throws()? } else { None };
                if let Some(caustics) = &caustics {
                    self.work
                        .submit(&self.gpu, |encoder, timeline| caustics.record(encoder, timeline));
                }
                prepared.caustics = caustics;
                return Ok((prepared, counters));
            }
            self.grown += 1;
        }
    }

    fn read_light(&self, shown: &PreparedPicture) -> Result<Vec<[f32; 3]>, Error> {
        let _phase = tracing::debug_span!("read_back").entered();
        let radiance = shown.read_radiance(&self.gpu)?;
        Ok(radiance.iter().map(|&[r, g, b, _]| [r, g, b]).collect())
    }

    /// Mean over all samples per pixel of `camera`; `first`: light of the first sample.
    fn shade_samples(
        &mut self,
        lit: &Lit<'_>,
        camera: &View,
        budget: u32,
        first: Vec<[f32; 3]>,
        options: &RenderOptions<'_>,
    ) -> Result<Picture, Error> {
        // The maps are the first part.
        let parts = options.samples(lit.scene) + 1;
        let mut done = 2;
        tell(options.watch, done, parts)?;
        let mut mean = reference::MeanPicture::new(lit.scene);
        let add = |mean: &mut reference::MeanPicture, light: Vec<[f32; 3]>| {
            let _phase = tracing::debug_span!("read_back").entered();
            mean.add(light.into_iter().map(Vec3::from_array));
        };
        add(&mut mean, first);
        for camera in View::of_samples(lit.scene, camera).skip(1) {
            let lit = Lit { camera, ..lit.clone() };
            let (shown, ..) = self.shade_whole_picture(&lit, budget)?;
            self.kept.first_light = shares_light(lit.scene).then(|| shown.first_light());
            add(&mut mean, self.read_light(&shown)?);
            done += 1;
            tell(options.watch, done, parts)?;
        }
        let _phase = tracing::debug_span!("read_back").entered();
        Ok(mean.picture())
    }

    /// The complete picture, the capacities that it was prepared with, and the number of casters that did not
    /// fit at once.
    fn shade_whole_picture(
        &mut self,
        lit: &Lit<'_>,
        budget: u32,
    ) -> Result<(PreparedPicture, PictureCapacity, u64), Error> {
        let known = self.capacity.take();
        let (mut capacity, mut only_counts) = (known.unwrap_or_default(), known.is_none());
        let mut overflowed = 0;
        loop {
            let picture = self.prepare_picture(lit, capacity)?;
            if only_counts {
                self.submit_picture(&picture, PreparedPicture::record_counts);
            } else {
                self.draw_picture(&picture, PreparedPicture::record);
            }
            let needs = picture.needs(&self.gpu, budget)?;
            self.grown += u64::from(needs.is_some());
            match needs {
                None => {
                    if only_counts {
                        self.draw_picture(&picture, PreparedPicture::record_counted);
                    }
                    self.capacity = Some(capacity).filter(|capacity| !capacity.is_in_parts());
                    return Ok((picture, capacity, overflowed));
                }
                // The picture is drawn in parts of the largest size that the budget allows.
                Some(needs) if overflowed == 0 && needs.is_in_parts() => {
                    let [solid, blended] = picture.read_counters(&self.gpu)?;
                    overflowed = u64::from(solid.overflowed + blended.overflowed);
                    (capacity, only_counts) = (needs, true);
                }
                Some(needs) => (capacity, only_counts) = (needs, true),
            }
        }
    }

    fn prepare_picture(
        &mut self,
        lit: &Lit<'_>,
        capacity: PictureCapacity,
    ) -> Result<PreparedPicture, Error> {
        PreparedPicture::new(&self.shadows, &lit.request(capacity), &mut self.kept)
    }

    fn draw_picture(&mut self, picture: &PreparedPicture, record: Record) {
        self.drawn += 1;
        self.submit_picture(picture, record);
    }

    fn submit_picture(&mut self, picture: &PreparedPicture, record: Record) {
        let Self { gpu, work, .. } = self;
        work.submit(gpu, |encoder, timeline| record(picture, encoder, timeline));
    }

    /// Debug picture of `mode`.
    fn shade_debug(
        &mut self,
        mode: DebugMode,
        lit: &Lit<'_>,
        shown: &PreparedPicture,
        picture: &Picture,
        capacity: PictureCapacity,
    ) -> Result<Picture, Error> {
        let &Lit { scene, prepared, .. } = lit;
        let (views, maps) = (prepared.views(), prepared.maps());
        match mode {
            DebugMode::Clusters => debug::clusters(&self.gpu, shown, scene, picture),
            DebugMode::Cascades => debug::cascades(&self.gpu, shown, scene, views, picture),
            DebugMode::Atlas => debug::atlas(&self.gpu, maps, views),
            DebugMode::Masks => debug::masks(&self.gpu, shown, picture),
            DebugMode::Cost => {
                self.shadows.configure(|config| config.toggles.count_cost = true);
                let counting = self.prepare_picture(lit, capacity);
                self.shadows.configure(|config| config.toggles.count_cost = false);
                let counting = counting?;
                self.submit_picture(&counting, PreparedPicture::record);
                Ok(debug::cost(picture, &counting.read_costs(&self.gpu)?))
            }
        }
    }
}
