//! Light of a picture besides the maps: levels of area lights, air, masks and the environment.
use super::{
    air::{Air, air},
    bands::TileRect,
    environment::environment_texture,
    prepared::{Kept, PictureRequest},
};
use gobo::{
    Error,
    frame::Dispatch,
    gpu::{Allocator, Resources},
    records::{LightRecords, MaskSlots},
    shadows::{
        AreaLevels, Shadows,
        masks::{MaskMemory, MaskTextures},
    },
    stage::features::{Features, Flags},
};

#[derive(Debug)]
pub(super) struct Lighting {
    /// Levels, air, masks and the environment.
    pub resources: Resources,
    /// Masks, if lights have any.
    pub masks: Option<MaskMemory>,
    /// Mask slots; unmasked lights are counted there.
    pub slots: MaskSlots,
    /// Features of the maps and masks that light passes.
    pub features: Features,
    /// Levels of area lights, which are made first.
    pub levels: Option<AreaLevels>,
    pub air: Option<Air>,
    /// Makes the masks, after the visible surfaces; empty without masks.
    pub masking: Vec<Dispatch>,
}

impl Lighting {
    /// `resources`: views, parameters, lights, clusters and maps, and the memory of `bands`.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        shadows: &Shadows,
        request: &PictureRequest<'_>,
        kept: &mut Kept,
        records: &LightRecords,
        resources: Resources,
        bands: &[TileRect],
    ) -> Result<Self, Error> {
        let &PictureRequest { scene, camera, prepared, .. } = request;
        let (queue, kernels, maps) = (shadows.queue(), shadows.kernels(), prepared.maps());
        let features = maps.features().with(Flags::HAS_FILTERS, records.is_filtered());
        let levels =
            AreaLevels::new(allocator, kernels, maps, prepared.light_shelf(), records, &resources)?;
        let features = features.with(Flags::HAS_AREAS, levels.is_some());
        let of_levels = levels.as_ref().map(AreaLevels::texture);
        let resources = resources.with_any("levels", of_levels);
        let (volume, air) = air(allocator, features, scene, &resources, bands)?;
        let mask = scene.mask.as_ref();
        let slots = mask.map(|settings| MaskSlots::new(scene, settings, camera, &kept.slots));
        let slots = slots.unwrap_or_default();
        let (mut masks, mut masking) = (None, Vec::new());
        if let Some(settings) = mask.filter(|_| slots.count > 0) {
            let (device, former) = (allocator.device, &mut kept.masks);
            let textures = MaskTextures::take(former, device, camera.size, settings.half, &slots)?;
            let memory = MaskMemory::new(queue, settings, slots.clone(), textures);
            allocator.memory.add_all(memory.memory());
            masking = memory.dispatches(kernels, queue, features, &resources, None)?;
            masks = Some(memory);
        }
        let features = features
            .with(Flags::HAS_MASKS, masks.is_some())
            .with(Flags::HAS_CAUSTICS, prepared.caustics.is_some())
            .with(Flags::HAS_SHADOWS, !prepared.views().is_empty());
        let environment = environment_texture(allocator, queue, scene, &mut kept.environment)?;
        let resources = Resources::new()
            .with_any("levels", of_levels)
            .with_any("caustics", prepared.caustics.as_ref().map(|it| &it.texels))
            .with_any("bounces", prepared.caustics.as_ref().map(|it| &it.bounces))
            .with("air", &volume)
            .with("environment", &environment);
        let resources = masks.iter().fold(resources, |all, it| all.and(&it.resources()));
        Ok(Self { resources, levels, masks, slots, features, air, masking })
    }
}
