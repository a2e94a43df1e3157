//! Shade kernels of a picture, bound for each band of tiles and for the particles.
use super::{
    band_memory::BandMemory,
    bands::{TileRect, pixels_of},
    lists::CameraList,
};
use crate::{
    error::Error,
    frame::Kernels,
    gpu::{Allocator, Resources, Timeline},
    model::Scene,
    shadows::kernels::Variant,
    stage::{
        features::Features,
        shade::{NO_LIST, PANE_LIST, PointBatch, SURFACE_LIST, list_offset, point_grid},
    },
};
use wgpu::{BindGroup, Buffer, Texture};

/// Features that the kernels are specialised to.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadeFeatures {
    solid: Features,
    layers: Features,
    surfaces: Features,
    panes: Features,
    /// Features of visible opaque surfaces.
    light: Features,
    /// Features of particles.
    casters: Features,
    composite: Features,
    /// Kernel that stores the surfaces for masks, if lights have masks.
    masks: Option<Variant>,
}

impl ShadeFeatures {
    /// `masks`: the kernel of [`MaskMemory::of_surfaces`](super::masks::MaskMemory::of_surfaces);
    /// `unmasked`: some light without a mask casts shadows.
    pub(super) fn new(
        solid: &CameraList,
        blended: &CameraList,
        light: Features,
        masks: Option<Variant>,
        unmasked: bool,
        cost: bool,
        scene: &Scene,
    ) -> Self {
        let (air, environment) = (scene.air.is_some(), scene.environment.is_some());
        let Features { particles, triangles, textures, .. } = solid.features;
        let has_layers = blended.list.footprint_count > 0;
        let panes = has_layers && blended.features.triangles;
        Self {
            solid: Features { cost, nodes: 0, ..solid.features },
            layers: Features { cost, air, nodes: 0, ..blended.features },
            surfaces: Features { particles, triangles, textures, environment, ..Features::NONE },
            panes: Features {
                triangles: true,
                textures: blended.features.textures,
                environment,
                ..Features::NONE
            },
            // Panes read the maps, with or without masks.
            light: Features { shadows: light.shadows && (unmasked || panes), ..light },
            casters: light,
            masks,
            composite: Features { cost, air, layers: has_layers, panes, ..Features::NONE },
        }
    }
}

/// Bindings of a band.
#[derive(Debug)]
pub(super) struct ShadedBand {
    groups: [u32; 3],
    /// Bindings of each round.
    seen: Vec<BindGroup>,
    layers: Vec<BindGroup>,
    /// Bindings that list the tiles with translucent casters, if there are any, and their number of workgroups.
    layered: Option<(BindGroup, [u32; 3])>,
    surfaces: BindGroup,
    /// Bindings with masks, if lights have masks.
    masks: Option<BindGroup>,
    panes: Option<BindGroup>,
    composite: BindGroup,
}

/// Bindings for a run of particles.
#[derive(Debug)]
struct LitCasters {
    groups: [u32; 3],
    points: BindGroup,
    light: BindGroup,
}

/// Bindings of all shade kernels.
#[derive(Debug)]
pub(super) struct Shading {
    features: ShadeFeatures,
    bands: Vec<Vec<ShadedBand>>,
    casters: Vec<LitCasters>,
    /// Bindings for the light of the surfaces and of the panes.
    light: Vec<(u32, BindGroup)>,
    point_lists: Buffer,
    layered_tiles: Buffer,
    /// Whether surfaces stored for the masks are still there for the shading.
    keeps_surfaces: bool,
}

/// Inputs of [`Shading::new`].
pub(super) struct ToShade<'a, 'b> {
    pub allocator: &'a mut Allocator<'b>,
    pub queue: &'a wgpu::Queue,
    pub kernels: &'a Kernels,
    pub features: ShadeFeatures,
    pub solid: &'a CameraList,
    pub blended: &'a CameraList,
    pub rounds: u32,
    pub memory: &'a BandMemory,
    /// Light of the particles.
    pub lit_casters: &'a Texture,
}

impl ToShade<'_, '_> {
    fn uniform<T: bytemuck::NoUninit>(&mut self, name: &'static str, value: &T) -> Buffer {
        let buffer = self.allocator.uniform::<T>(name);
        self.queue.write_buffer(&buffer, 0, bytemuck::bytes_of(value));
        buffer
    }

    fn bind(
        &mut self,
        variant: Variant,
        features: Features,
        resources: &Resources<'_>,
    ) -> Result<BindGroup, Error> {
        let device = self.allocator.device;
        Ok(self.kernels.of(variant, features)?.bind(device, resources)?)
    }

    /// `panes`: the batch of the panes.
    fn band(
        &mut self,
        rect: &TileRect,
        resources: &Resources<'_>,
        panes: &Buffer,
    ) -> Result<ShadedBand, Error> {
        let features = self.features;
        let (solid, blended) = (self.solid, self.blended);
        let of_solid = resources
            .clone()
            .and(&solid.scratch.resources())
            .with("pairs", &solid.scratch.pairs[solid.list.sorted_pairs]);
        let of_blended = resources
            .clone()
            .and(&blended.scratch.resources())
            .with("pairs", &blended.scratch.pairs[blended.list.sorted_pairs])
            .with("lit", self.lit_casters);
        let (mut seen, mut layers) = (Vec::new(), Vec::new());
        for round in 0..self.rounds {
            let band = self.uniform("band", &rect.band(round, self.memory.tiles));
            let of_solid = of_solid.clone().with("band", &band);
            seen.push(self.bind(Variant::ShadeSeen, features.solid, &of_solid)?);
            if features.composite.layers {
                let of_blended = of_blended.clone().with("band", &band);
                layers.push(self.bind(Variant::ShadeLayers, features.layers, &of_blended)?);
            }
        }
        let band = self.uniform("band", &rect.band(0, self.memory.tiles));
        let of_solid = of_solid.with("band", &band).with("blended_tiles", &blended.scratch.tiles);
        let of_blended = of_blended.with("band", &band);
        let surfaces = self.bind(Variant::ShadeSurfaces, features.surfaces, &of_solid)?;
        let bind_masks = |variant| self.bind(variant, Features::NONE, &of_solid);
        let masks = features.masks.map(bind_masks).transpose()?;
        let panes = if features.composite.panes {
            let of_panes = of_blended.clone().with("point_batch", panes);
            Some(self.bind(Variant::ShadePanes, features.panes, &of_panes)?)
        } else {
            None
        };
        let layered = if features.composite.layers {
            let bound = self.bind(Variant::ShadeLayered, Features::NONE, &of_blended)?;
            Some((bound, point_grid(rect.size.element_product())))
        } else {
            None
        };
        let composite = self.bind(Variant::ShadeComposite, features.composite, &of_solid)?;
        let groups = rect.groups();
        Ok(ShadedBand { groups, seen, layers, layered, surfaces, masks, panes, composite })
    }

    /// Runs of particles, as many at a time as the band's memory holds points.
    fn casters(&mut self, resources: &Resources<'_>) -> Result<Vec<LitCasters>, Error> {
        let at_a_time = pixels_of(self.memory.tiles) * self.memory.points_of_pixel();
        // Triangles follow the particles.
        let count = self.blended.first_setup;
        let blended = self.blended;
        let features = self.features;
        let mut runs = Vec::new();
        for first in (0..count).step_by(at_a_time as usize) {
            let batch = PointBatch {
                first,
                count: at_a_time.min(count - first),
                has_normals: 0,
                list: NO_LIST,
            };
            let buffer = self.uniform("point_batch", &batch);
            let resources = resources
                .clone()
                .and(&blended.scratch.resources())
                .with("lit", self.lit_casters)
                .with("point_batch", &buffer);
            runs.push(LitCasters {
                groups: point_grid(batch.count),
                points: self.bind(Variant::ShadeCasters, Features::NONE, &resources)?,
                light: self.bind(Variant::LightPoints, features.casters, &resources)?,
            });
        }
        Ok(runs)
    }
}

impl Shading {
    /// `resources`: those that all shade kernels share, including a band's memory.
    pub(super) fn new(
        mut to: ToShade<'_, '_>,
        parts: &[TileRect],
        resources: &Resources<'_>,
    ) -> Result<Self, Error> {
        let features = to.features;
        let tiles = to.memory.tiles;
        let [surfaces, panes] = [SURFACE_LIST, PANE_LIST]
            .map(|list| to.uniform("point_batch", &PointBatch::listed(list, pixels_of(tiles))));
        let mut light = Vec::new();
        for (list, batch) in [(SURFACE_LIST, &surfaces), (PANE_LIST, &panes)] {
            if list == SURFACE_LIST || features.composite.panes {
                let listed = resources.clone().with("point_batch", batch);
                light.push((list, to.bind(Variant::LightPoints, features.light, &listed)?));
            }
        }
        let mut bands = Vec::new();
        for part in parts {
            let of_part: Result<Vec<_>, Error> =
                part.bands(tiles).iter().map(|rect| to.band(rect, resources, &panes)).collect();
            bands.push(of_part?);
        }
        let casters = to.casters(resources)?;
        let keeps_surfaces =
            features.masks.is_some() && matches!(&bands[..], [part] if part.len() == 1);
        let point_lists = to.memory.point_lists().clone();
        let layered_tiles = to.memory.layered_tiles().clone();
        Ok(Self { features, bands, casters, light, point_lists, layered_tiles, keeps_surfaces })
    }

    /// Records the light of the visible translucent particles.
    pub(super) fn record_casters(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let mut pass = timeline.pass(encoder, "gobo shade");
        for run in &self.casters {
            let points = kernels.known(Variant::ShadeCasters, Features::NONE);
            points.record(&mut pass, &run.points, run.groups);
            let light = kernels.known(Variant::LightPoints, self.features.casters);
            light.record(&mut pass, &run.light, run.groups);
        }
    }

    /// Records the opaque surfaces in the bands of a part, for masks; its pairs have been recorded.
    pub(super) fn record_surfaces(
        &self,
        part: usize,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let features = &self.features;
        let mut pass = timeline.pass(encoder, "gobo shade");
        for band in &self.bands[part] {
            let mut record = |variant, features, bound| {
                kernels.known(variant, features).record(&mut pass, bound, band.groups);
            };
            for round in &band.seen {
                record(Variant::ShadeSeen, features.solid, round);
            }
            record(Variant::ShadeSurfaces, features.surfaces, &band.surfaces);
            if let (Some(variant), Some(masks)) = (features.masks, &band.masks) {
                record(variant, Features::NONE, masks);
            }
        }
    }

    /// Records the bands of a part, whose pairs have been recorded.
    pub(super) fn record_part(
        &self,
        part: usize,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let features = &self.features;
        let mut pass = timeline.pass(encoder, "gobo shade");
        for band in &self.bands[part] {
            let mut record = |variant, features, bound| {
                kernels.known(variant, features).record(&mut pass, bound, band.groups);
            };
            if !self.keeps_surfaces {
                for round in &band.seen {
                    record(Variant::ShadeSeen, features.solid, round);
                }
                record(Variant::ShadeSurfaces, features.surfaces, &band.surfaces);
            }
            if let Some((layered, groups)) = &band.layered {
                let kernel = kernels.known(Variant::ShadeLayered, Features::NONE);
                kernel.record(&mut pass, layered, *groups);
            }
            for round in &band.layers {
                let kernel = kernels.known(Variant::ShadeLayers, features.layers);
                kernel.record_indirect(&mut pass, round, &self.layered_tiles, 0);
            }
            if let Some(panes) = &band.panes {
                let kernel = kernels.known(Variant::ShadePanes, features.panes);
                kernel.record_indirect(&mut pass, panes, &self.point_lists, list_offset(PANE_LIST));
            }
            let light = kernels.known(Variant::LightPoints, features.light);
            for (list, points) in &self.light {
                light.record_indirect(&mut pass, points, &self.point_lists, list_offset(*list));
            }
            let composite = kernels.known(Variant::ShadeComposite, features.composite);
            composite.record(&mut pass, &band.composite, band.groups);
        }
    }
}
