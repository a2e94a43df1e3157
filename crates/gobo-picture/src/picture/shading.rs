//! Shade kernels of a picture, for each band of tiles and for the particles.

use super::{
    air::Air,
    band_memory::BandMemory,
    bands::{TileRect, pixels_of},
    finish::Finish,
    lighting::Lighting,
    lists::CameraList,
    prepared::Targets,
};
use crate::stage::{
    light_points::{PANE_LIST, SURFACE_LIST, light_points, list_offset, listed},
    mask, shade,
};
use gobo::{
    Error,
    frame::{Commands, Dispatch, Work},
    gpu::{Allocator, KernelDesc, Resources},
    model::{Material, Scene},
    shadows::Shadows,
    stage::{
        features::{Features, Flags},
        light_points::{PointBatch, point_grid},
    },
};
use wgpu::Buffer;

/// Features of triangles' looks.
const LOOKS: Flags = Flags::HAS_TEXTURES.union(Flags::HAS_VERTEX_COLORS).union(Flags::HAS_FRESNEL);

const LABEL: &str = "gobo shade";

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
    of_composite: &'static KernelDesc,
    /// Kernel that makes points of visible opaque surfaces.
    of_surfaces: &'static KernelDesc,
    has_layers: bool,
    /// Whether pictures through further samples take over the light of surfaces.
    keeps_light: bool,
    /// Whether some translucent casters are triangles.
    has_panes: bool,
    /// Kernel that stores the surfaces for masks, if lights have masks.
    masks: Option<&'static KernelDesc>,
}

impl ShadeFeatures {
    /// `lists`: opaque and blended; `cost`: whether the cost of each pixel is counted.
    pub(super) fn new(
        [solid, blended]: &[CameraList; 2],
        lighting: &Lighting,
        finish: &Finish,
        cost: bool,
        scene: &Scene,
    ) -> Self {
        let light = lighting
            .features
            .with(Flags::HAS_BRICKS, !scene.grids.is_empty())
            .with(Flags::HAS_CAPSULES, !scene.strands.is_empty());
        let masks = lighting.masks.as_ref();
        // Some light without a mask casts shadows.
        let unmasked = masks.is_none_or(|masks| masks.slots.unmasked > 0);
        let far_sides = || scene.materials.iter().filter_map(|material| material.far_side);
        let far_texture = far_sides().any(|far| scene.materials[far as usize].texture.is_some());
        let has_far_sides = far_sides().next().is_some();
        let light = light.with(Flags::HAS_FAR_SIDES, has_far_sides);
        let has_details = scene.materials.iter().any(|material| material.details.is_some());
        let mut details = scene.materials.iter().filter_map(|material| material.details);
        let has_coats = details.any(|it| scene.materials[it as usize].details.is_some());
        let light = light.with(Flags::HAS_COATS, has_coats);
        let shown = |features: Features| {
            let environment = scene.environment.is_some();
            features
                .with(Flags::HAS_ENVIRONMENT, environment)
                .with(Flags::HAS_FAR_SIDES, has_far_sides)
                .with(Flags::HAS_DETAILS, has_details)
                .with(Flags::HAS_COATS, has_coats)
                .with(
                    Flags::HAS_TEXTURES,
                    far_texture || has_details || features.has(Flags::HAS_TEXTURES),
                )
        };
        let counted = |features: Features| features.with(Flags::COUNT_COST, cost);
        let aired =
            |features: Features| counted(features).with(Flags::HAS_AIR, scene.air.is_some());
        let kinds = Flags::HAS_PARTICLES | Flags::HAS_TRIANGLES | Flags::HAS_CAPSULES | LOOKS;
        let of_kinds = |flags| Features::NONE.with(flags, true);
        let has_layers = blended.list.footprint_count > 0;
        let panes = has_layers && blended.features.has(Flags::HAS_TRIANGLES);
        let pane_kinds = blended.features.flags & LOOKS | Flags::HAS_TRIANGLES;
        let shadows = light.has(Flags::HAS_SHADOWS) && (unmasked || panes);
        Self {
            solid: counted(Features { nodes: 0, ..solid.features }),
            layers: aired(Features { nodes: 0, ..blended.features })
                .with(Flags::HAS_REFRACTION, scene.materials.iter().any(Material::refracts)),
            surfaces: shown(of_kinds(solid.features.flags & kinds)),
            of_surfaces: shade::surfaces(scene.materials.iter().any(|material| material.catcher)),
            panes: shown(of_kinds(pane_kinds)),
            // Panes read the maps, with or without masks.
            light: light.with(Flags::HAS_SHADOWS, shadows),
            casters: light,
            masks: masks.map(|memory| mask::surfaces(memory.is_half())),
            has_layers,
            keeps_light: false,
            has_panes: panes,
            of_composite: finish.composite(),
            composite: aired(Features::NONE)
                .with(Flags::HAS_COATS, has_coats)
                .with(Flags::HAS_LAYERS, has_layers)
                .with(Flags::HAS_PANES, panes),
        }
    }

    /// Features for a picture that keeps the light of its surfaces, or takes it over.
    pub(super) fn sharing(self, targets: &Targets) -> Self {
        let keeps_light = targets.kept_layer.is_some();
        let takes_light = targets.first_surfaces.is_some() && !keeps_light;
        Self { surfaces: self.surfaces.with(Flags::TAKES_LIGHT, takes_light), keeps_light, ..self }
    }
}

/// Dispatches of a band.
#[derive(Debug)]
struct BandDispatches {
    /// Visible opaque surfaces: the rounds of their walk, and their points.
    surfaces: Vec<Dispatch>,
    /// Stores the surfaces for masks, if lights have masks.
    masks: Option<Dispatch>,
    /// Lights the air up to the surfaces; empty without air.
    air: Vec<Dispatch>,
    /// Layers, panes, light and the blended pixels.
    pixels: Vec<Dispatch>,
}

/// Dispatches of all shade kernels.
#[derive(Debug)]
pub(super) struct Shading {
    casters: Vec<Dispatch>,
    /// Bands of each part.
    bands: Vec<Vec<BandDispatches>>,
    /// Whether surfaces stored for the masks are still there for the shading.
    keeps_surfaces: bool,
}

/// Inputs of [`Shading::new`].
pub(super) struct ToShade<'a, 'b> {
    pub allocator: &'a mut Allocator<'b>,
    pub shadows: &'a Shadows,
    pub materials: &'a [Material],
    pub features: ShadeFeatures,
    /// Opaque and blended casters.
    pub lists: &'a [CameraList; 2],
    pub rounds: u32,
    pub memory: &'a BandMemory,
    pub targets: &'a Targets,
    pub air: Option<&'a Air>,
}

impl ToShade<'_, '_> {
    fn run(
        &self,
        desc: &KernelDesc,
        features: Features,
        resources: &Resources,
        work: impl Into<Work>,
    ) -> Result<Dispatch, Error> {
        Ok(self.shadows.kernels().dispatch(desc, features, resources, work)?)
    }

    /// `panes`: the batch of the panes; `light`: the light of the band's points.
    fn band(
        &mut self,
        rect: &TileRect,
        resources: &Resources,
        panes: &Buffer,
        light: &[Dispatch],
    ) -> Result<BandDispatches, Error> {
        let (features, groups) = (self.features, rect.groups());
        let [solid, blended] = self.lists;
        let of_solid = resources
            .clone()
            .and(&solid.scratch.resources)
            .with("pairs", &solid.scratch.pairs[solid.list.sorted_pairs]);
        let of_blended = resources
            .clone()
            .and(&blended.scratch.resources)
            .with("pairs", &blended.scratch.pairs[blended.list.sorted_pairs])
            .with("lit", &self.targets.lit)
            .with("brick_lights", &self.targets.brick_lights);
        let (mut surfaces, mut layers) = (Vec::new(), Vec::new());
        for round in 0..self.rounds {
            let band = self.allocator.uniform("band", &rect.band(round, self.memory.tiles));
            let of_solid = of_solid.clone().with("band", &band);
            surfaces.push(self.run(&shade::SEEN, features.solid, &of_solid, groups)?);
            if features.has_layers {
                let of_blended = of_blended.clone().with("band", &band);
                let tiles = Work::indirect(&self.memory.layered_tiles, 0);
                layers.push(self.run(&shade::LAYERS, features.layers, &of_blended, tiles)?);
            }
        }
        let band = self.allocator.uniform("band", &rect.band(0, self.memory.tiles));
        let of_solid = of_solid.with("band", &band);
        let of_composite = of_solid.clone().with("tiles", &blended.scratch.tiles);
        let of_blended = of_blended.with("band", &band);
        surfaces.push(self.run(features.of_surfaces, features.surfaces, &of_solid, groups)?);
        let of_masks = |desc| self.run(desc, Features::NONE, &of_solid, groups);
        let masks = features.masks.map(of_masks).transpose()?;
        let kernels = self.shadows.kernels();
        let air = self.air.map_or(Ok(Vec::new()), |air| air.of_band(kernels, rect, &band))?;
        let mut pixels = Vec::new();
        if features.has_layers {
            let groups = point_grid(rect.size.element_product());
            pixels.push(self.run(&shade::LAYERED, Features::NONE, &of_blended, groups)?);
            pixels.extend(layers);
        }
        if features.has_panes {
            let of_panes = of_blended.with("point_batch", panes);
            let points = Work::indirect(&self.memory.point_lists, list_offset(PANE_LIST));
            pixels.push(self.run(&shade::PANES, features.panes, &of_panes, points)?);
        }
        pixels.extend_from_slice(light);
        if features.keeps_light {
            pixels.push(self.run(&shade::KEEP, Features::NONE, &of_solid, groups)?);
        }
        pixels.push(self.run(features.of_composite, features.composite, &of_composite, groups)?);
        Ok(BandDispatches { surfaces, masks, air, pixels })
    }

    /// Runs of particles, as many at once as the band's memory holds points.
    fn casters(&mut self, resources: &Resources) -> Result<Vec<Dispatch>, Error> {
        let at_a_time = pixels_of(self.memory.tiles) * self.memory.points_of_pixel;
        let ([_, blended], features) = (self.lists, self.features.casters);
        // Triangles follow the particles.
        let count = blended.first_setup;
        let mut runs = Vec::new();
        for first in (0..count).step_by(at_a_time as usize) {
            let count = at_a_time.min(count - first);
            let batch = PointBatch::of(first, count);
            let buffer = self.allocator.uniform("point_batch", &batch);
            let resources = resources
                .clone()
                .and(&blended.scratch.resources)
                .with("lit", &self.targets.lit)
                .with("point_batch", &buffer);
            let groups = point_grid(count);
            runs.push(self.run(&shade::CASTERS, Features::NONE, &resources, groups)?);
            runs.push(self.run(light_points(features), features, &resources, groups)?);
        }
        Ok(runs)
    }

    /// Runs of the lattices of bricks, as many points at once as the band's memory holds.
    fn bricks(&mut self, resources: &Resources) -> Result<Vec<Dispatch>, Error> {
        let at_a_time = pixels_of(self.memory.tiles) * self.memory.points_of_pixel;
        let features = self.features.casters;
        let bricks = self.shadows.casters()?.bricks();
        let grids: Vec<_> = bricks.grids().collect();
        let firsts = grids.iter().map(|(_, record)| record.first_point);
        let ends = firsts.skip(1).chain([bricks.lattice_points]);
        let mut runs = Vec::new();
        for (&(grid, record), end) in grids.iter().zip(ends) {
            let material = &self.materials[record.material as usize];
            let own_shadow = features.nodes > 0 && record.is_own_shadow(material);
            for first in (record.first_point..end).step_by(at_a_time as usize) {
                let count = at_a_time.min(end - first);
                let own_shadow = u32::from(own_shadow);
                let batch = PointBatch { grid, own_shadow, ..PointBatch::of(first, count) };
                let buffer = self.allocator.uniform("point_batch", &batch);
                let resources = resources
                    .clone()
                    .with("lit", &self.targets.brick_lights)
                    .with("point_batch", &buffer);
                let groups = point_grid(count);
                runs.push(self.run(&shade::BRICKS, features, &resources, groups)?);
                runs.push(self.run(light_points(features), features, &resources, groups)?);
            }
        }
        Ok(runs)
    }
}

impl Shading {
    /// `resources`: those that all shade kernels share, including a band's memory.
    pub(super) fn new(
        mut to: ToShade<'_, '_>,
        parts: &[TileRect],
        resources: &Resources,
    ) -> Result<Self, Error> {
        let (features, tiles) = (to.features, to.memory.tiles);
        let [surfaces, panes] = [SURFACE_LIST, PANE_LIST]
            .map(|list| to.allocator.uniform("point_batch", &listed(list, pixels_of(tiles))));
        let mut light = Vec::new();
        for (list, batch) in [(SURFACE_LIST, &surfaces), (PANE_LIST, &panes)] {
            if list == SURFACE_LIST || features.has_panes {
                let listed = resources.clone().with("point_batch", batch);
                let points = Work::indirect(&to.memory.point_lists, list_offset(list));
                let kernel = light_points(features.light);
                light.push(to.run(kernel, features.light, &listed, points)?);
            }
        }
        let mut bands = Vec::new();
        for part in parts {
            let rects = part.bands(tiles);
            let of_part = rects.iter().map(|rect| to.band(rect, resources, &panes, &light));
            bands.push(of_part.collect::<Result<Vec<_>, _>>()?);
        }
        let mut casters = Vec::new();
        if !to.targets.is_lit {
            casters.append(&mut to.casters(resources)?);
            casters.append(&mut to.bricks(resources)?);
        }
        let keeps_surfaces =
            features.masks.is_some() && matches!(&bands[..], [part] if part.len() == 1);
        Ok(Self { casters, bands, keeps_surfaces })
    }

    /// The light of the visible translucent particles.
    pub(super) fn casters(&self) -> Commands {
        let mut commands = Commands::new();
        commands.pass(LABEL, self.casters.iter().cloned());
        commands
    }

    /// The opaque surfaces in the bands of a part, for masks, after its pairs.
    pub(super) fn surfaces(&self, part: usize) -> Commands {
        let bands = self.bands[part].iter();
        let mut commands = Commands::new();
        commands
            .pass(LABEL, bands.flat_map(|band| band.surfaces.iter().chain(&band.masks).cloned()));
        commands
    }

    /// The bands of a part, after its pairs.
    pub(super) fn part(&self, part: usize) -> Commands {
        let mut commands = Commands::new();
        let mut dispatches = Vec::new();
        for band in &self.bands[part] {
            if !self.keeps_surfaces {
                dispatches.extend_from_slice(&band.surfaces);
            }
            if !band.air.is_empty() {
                commands.pass(LABEL, std::mem::take(&mut dispatches));
                commands.pass("gobo air", band.air.iter().cloned());
            }
            dispatches.extend_from_slice(&band.pixels);
        }
        commands.pass(LABEL, dispatches);
        commands
    }
}
