//! All stages in order, for every shadow view.
use super::{
    Pair,
    accumulate::{Accumulated, Modes, accumulate},
    bin::{Bins, bin},
    blur::blur,
    capsule::project_capsule,
    caster_hit::Records,
    caustics::throw_all,
    curve::{
        soften::soften_curves,
        tile::{CurveModes, curves},
    },
    gaussian::project_gaussian,
    kinds::{any_faint, any_puff, only_discs, only_rays},
    occlude::occlude,
    project::{ProjectParams, Projected, project_caster, project_triangle},
    resolve::resolve,
    soften::soften,
    sort,
    texture::Image,
    threads::each,
    tile::{Tile, TileTexels},
};
use glam::{UVec2, Vec3};
use gobo::{
    model::{
        Casters, Class, Counters, Gaussian, Material, Receives, Scene, ShadowSettings, Shape,
        Transfer, View, absorptions, dither::window,
    },
    records::{
        BRICK_SEGMENT, Bricks, CURVE_SEGMENT, Capsules, CasterRecord, CurveMap, DEPTH_BITS,
        Footprint, GAUSSIAN_MARK, GaussianAxes, GaussianSetup, GpuMaterial, GpuView, INVISIBLE,
        NO_OWNER, ORDERED_SEGMENT, TileRect, TriangleRecord, TriangleSetup, ViewMaps,
    },
};

mod tiles;

use tiles::{last_depths, without_curves};

/// Pairs per segment of the kernels, for the counters.
const SEGMENT: usize = 2048;
/// Casters per work item of a thread.
const CHUNK: usize = 4096;

/// Records that all views share.
pub(super) struct SceneRecords<'a> {
    pub materials: &'a [Material],
    gpu_materials: Vec<GpuMaterial>,
    /// Absorption coefficient of each material [1/m].
    pub absorptions: Vec<Vec3>,
    pub images: Vec<Image<'a>>,
    /// Particles, then Gaussians.
    pub casters: Vec<CasterRecord>,
    pub axes: Vec<GaussianAxes>,
    pub bricks: Bricks,
    pub capsules: Capsules,
    pub triangles: Vec<TriangleRecord>,
    modes: Modes,
    /// Modes of curves, in curve mode.
    curve_modes: Option<CurveModes>,
    pair_budget: u32,
    /// Window of the softening \[texels\]; 0 if dithered surfaces are not softened.
    soften_window: u32,
    colored: bool,
    /// Radius of the blur \[texels\].
    blur: u32,
}

/// Projected casters of one view.
pub(super) struct ViewCasters {
    pub footprints: Vec<Footprint>,
    pub keys: Vec<u32>,
    pub rects: Vec<TileRect>,
    pub gaussians: Vec<GaussianSetup>,
    pub setups: Vec<TriangleSetup>,
}

impl ViewCasters {
    /// Its pairs. `sorted`: the visible footprints, front to back.
    pub(super) fn bins(
        &self,
        sorted: &[u32],
        view: &GpuView,
        tile_count: u32,
        budget: u32,
    ) -> Bins {
        let outline = |i: u32| {
            let footprint = &self.footprints[i as usize];
            (footprint.thin == GAUSSIAN_MARK)
                .then(|| &self.gaussians[footprint.red_green as usize].outline)
        };
        bin(sorted, &self.rects, outline, &[*view], tile_count, budget)
    }
}

/// Maps of all views, and their counters. Each view is a batch of its own.
pub fn render_maps(scene: &Scene, views: &[View]) -> (Vec<ViewMaps>, Counters) {
    let shadow = scene.shadow.within_curve_budget(views);
    let records = SceneRecords::new(scene.casters(), &shadow);
    let mut counters = Counters {
        nodes_dropped: u64::from(scene.shadow.curve_nodes() - shadow.curve_nodes()),
        casters: scene.casters().count(),
        views_rendered: views.len() as u64,
        skipped: scene.skipped.clone(),
        ..Counters::default()
    };
    let mut maps: Vec<_> = views.iter().map(|view| records.render(view, &mut counters)).collect();
    throw_all(scene, views, &mut maps);
    (maps, counters)
}

impl<'a> SceneRecords<'a> {
    pub(super) fn new(scene: Casters<'a>, shadow: &ShadowSettings) -> Self {
        let materials = scene.materials;
        let bricks = Bricks::new(scene.grids, UVec2::new(u32::MAX, 1));
        let capsules = Capsules::new(scene.strands);
        let particles = capsules.among(bricks.among(scene.particles, ..bricks.particles.len()));
        let all = Casters { particles: &particles, ..scene };
        let uses = |transfer: Transfer| {
            let used = |material: u32| {
                let material = &materials[material as usize];
                material.transfer == transfer && Class::of(material).casts()
            };
            particles.iter().any(|particle| used(particle.material))
                || scene.gaussians.iter().any(|gaussian| used(gaussian.material))
                || scene.triangles.iter().any(|triangle| used(triangle.material))
        };
        let caster = |particle: &gobo::model::Particle| {
            CasterRecord::new(particle, &materials[particle.material as usize])
        };
        let of_gaussian = |(gaussian, axes): (&Gaussian, u32)| {
            CasterRecord::of_gaussian(gaussian, &materials[gaussian.material as usize], axes)
        };
        let has_volumes = scene.triangles.iter().any(|triangle| {
            let material = &materials[triangle.material as usize];
            material.is_volume() && Class::of(material).casts()
        });
        Self {
            materials,
            absorptions: absorptions(materials, scene.triangles),
            gpu_materials: materials.iter().map(|m| GpuMaterial::new(m, scene.textures)).collect(),
            images: scene.textures.iter().map(Image::new).collect(),
            casters: particles
                .iter()
                .map(caster)
                .chain(scene.gaussians.iter().zip(0..).map(of_gaussian))
                .collect(),
            axes: scene.gaussians.iter().map(GaussianAxes::new).collect(),
            triangles: scene.triangles.iter().map(TriangleRecord::new).collect(),
            bricks,
            capsules,
            modes: Modes {
                gain: uses(Transfer::Gain),
                ordered: uses(Transfer::Over),
                owners: materials.iter().any(|m| m.visible && m.receives == Receives::Others),
                volumes: has_volumes,
            },
            curve_modes: (shadow.curve_nodes() > 0).then(|| CurveModes {
                nodes: shadow.curve_nodes(),
                gain: uses(Transfer::Gain),
                rays: only_rays(&all),
                few: !only_discs(&all),
                over: uses(Transfer::Over),
                volumes: has_volumes,
                bodies: has_volumes || any_puff(&all),
                faint: any_faint(&all),
                softening: shadow.soften,
                segment: match (scene.grids.is_empty(), uses(Transfer::Over) || has_volumes) {
                    (false, _) => BRICK_SEGMENT,
                    (true, true) => ORDERED_SEGMENT,
                    (true, false) => CURVE_SEGMENT,
                } as usize,
            }),
            pair_budget: shadow.pair_budget,
            soften_window: if shadow.soften { window(materials) } else { 0 },
            blur: shadow.blur,
            colored: shadow.colored && uses(Transfer::Dither),
        }
    }

    pub(super) fn render(&self, view: &View, counters: &mut Counters) -> ViewMaps {
        let mut maps = self.sharp(view, counters);
        blur(&mut maps, self.blur);
        maps
    }

    fn sharp(&self, view: &View, counters: &mut Counters) -> ViewMaps {
        let gpu_view = view.to_gpu(0, UVec2::ZERO, 0);
        let tiles = view.tiles();
        let tile_count = (tiles.x * tiles.y) as usize;
        let params = ProjectParams {
            scatter: false,
            include_non_casters: false,
            by_distance: self.modes.ordered,
        };
        let casters = self.project(&gpu_view, params);
        let sorted = depth_order(&casters.keys);
        let within = |budget| casters.bins(&sorted, &gpu_view, tile_count as u32, budget);
        // Pairs beyond the budget are counted; the maps are the same.
        let (fitting, bins) = (within(self.pair_budget), within(u32::MAX));
        let ViewCasters { footprints, keys, gaussians, setups, .. } = casters;

        let records = self.hit_records(&gpu_view, &gaussians, &setups);
        let blocking =
            |index: usize| bins.tile(index).iter().map(|pair| &footprints[pair.footprint as usize]);
        let tile = |index: usize| Tile::new(&gpu_view, index as u32);
        let depths = each(tile_count, |i| occlude(records, &tile(i), blocking(i), self.colored));
        let opaque: Vec<_> = depths.iter().map(last_depths).collect();
        // Kernels have separate lists for casters that filter and for casters that block.
        let filtering = |index: usize| {
            let pairs = bins.tile(index).iter().map(|pair| pair.footprint as usize);
            let pairs = pairs.filter(|&i| self.filters(i));
            pairs.map(|i| (&footprints[i], keys[i])).collect::<Vec<_>>()
        };
        count(counters, &fitting, sorted.len());
        if let Some(modes) = self.curve_modes {
            let tiles = each(tile_count, |index| {
                let (pairs, opaque) = (filtering(index), &opaque[index]);
                curves(records, index as u32, &pairs, opaque, modes)
            });
            let accumulated: Vec<_> = tiles.iter().map(without_curves).collect();
            let mut maps = self.store(view, &gpu_view, &accumulated, &opaque);
            let nodes = modes.nodes as usize;
            let mut packed = vec![[0; 2]; maps.nearest.len() * nodes];
            for (index, tile) in tiles.iter().enumerate() {
                for (in_tile, texel) in Tile::new(&gpu_view, index as u32).texels() {
                    let at = (texel.y as u32 * view.size.x + texel.x as u32) as usize;
                    packed[at * nodes..(at + 1) * nodes].copy_from_slice(&tile[in_tile].nodes);
                    counters.disordered += u64::from(tile[in_tile].disordered);
                }
            }
            maps.curve = Some(CurveMap { nodes, gain: modes.gain || modes.over, packed });
            self.dither(&mut maps, &gpu_view, &depths);
            return maps;
        }
        let accumulated = each(tile_count, |index| {
            let pairs = filtering(index);
            let footprints = pairs.iter().map(|pair| pair.0);
            accumulate(records, index as u32, footprints, &opaque[index], self.modes)
        });
        let mut maps = self.store(view, &gpu_view, &accumulated, &opaque);
        self.dither(&mut maps, &gpu_view, &depths);
        maps
    }

    /// Stores the depths of coloured dithering, and softens dithered shadows.
    fn dither(&self, maps: &mut ViewMaps, view: &GpuView, depths: &[TileTexels<Vec3>]) {
        if self.colored {
            maps.colored = vec![[1.0; 3]; maps.opaque.len()];
            for (index, depths) in depths.iter().enumerate() {
                for (in_tile, texel) in Tile::new(view, index as u32).texels() {
                    let at = (texel.y as u32 * maps.view.size.x + texel.x as u32) as usize;
                    maps.colored[at] = depths[in_tile].to_array();
                }
            }
        }
        soften_curves(maps, self.soften_window);
        soften(maps, self.soften_window);
    }

    /// Records for the hit tests of one view.
    pub(super) fn hit_records<'b>(
        &'b self,
        view: &'b GpuView,
        gaussians: &'b [GaussianSetup],
        setups: &'b [TriangleSetup],
    ) -> Records<'b> {
        let Self { casters, bricks, capsules, axes, materials, absorptions, images, .. } = self;
        let capsules = &capsules.records;
        Records {
            view,
            casters,
            bricks,
            capsules,
            axes,
            gaussians,
            setups,
            materials,
            absorptions,
            images,
            detail: None,
        }
    }

    /// Whether footprint `i` belongs to a caster that filters light.
    fn filters(&self, i: usize) -> bool {
        let particle = self.casters.get(i).map(CasterRecord::material);
        let material = particle.unwrap_or_else(|| self.triangles[i - self.casters.len()].material);
        Class::FILTERING.contains(&Class::of(&self.materials[material as usize]))
    }

    /// Projects particles first, then triangles.
    pub(super) fn project(&self, view: &GpuView, params: ProjectParams) -> ViewCasters {
        let first_gaussian = self.casters.len() - self.axes.len();
        let chunks = each(self.casters.len().div_ceil(CHUNK), |chunk| {
            let first = chunk * CHUNK;
            let casters = &self.casters[first..(first + CHUNK).min(self.casters.len())];
            let project = |(i, caster): (usize, &CasterRecord)| {
                let material = &self.gpu_materials[caster.material() as usize];
                let id = (first + i) as u32;
                let Some(number) = (first + i).checked_sub(first_gaussian) else {
                    let shape = self.materials[caster.material() as usize].shape;
                    if shape == Shape::Capsule {
                        let record = &self.capsules.records[caster.id as usize];
                        let of = project_capsule(view, 0, (caster, id), record, material, params);
                        return (of, GaussianSetup::default());
                    }
                    let half_edges =
                        (shape == Shape::Brick).then(|| self.bricks.half_edges(caster.id));
                    let of = project_caster(view, 0, (caster, id), material, half_edges, params);
                    return (of, GaussianSetup::default());
                };
                let (axes, number) = (&self.axes[number], number as u32);
                project_gaussian(view, 0, caster, axes, id, number, material, params)
            };
            casters.iter().enumerate().map(project).collect::<Vec<_>>()
        });
        let count = self.casters.len() + self.triangles.len();
        let mut all = ViewCasters {
            footprints: Vec::with_capacity(count),
            keys: Vec::with_capacity(count),
            rects: Vec::with_capacity(count),
            gaussians: Vec::with_capacity(self.axes.len()),
            setups: Vec::new(),
        };
        let mut gaussians = Vec::with_capacity(self.axes.len());
        let mut setups = Vec::with_capacity(self.triangles.len());
        let mut push = |of: Projected, material: u32| {
            let casts = || Class::of(&self.materials[material as usize]).casts();
            let is_listed = params.include_non_casters || casts();
            let Projected { footprint, key, rect } =
                if is_listed { of } else { Projected::INVISIBLE };
            all.footprints.push(footprint);
            all.keys.push(key);
            all.rects.push(rect);
        };
        for (i, (of, setup)) in chunks.into_iter().flatten().enumerate() {
            push(of, self.casters[i].material());
            if i >= first_gaussian {
                gaussians.push(setup);
            }
        }
        for (i, triangle) in self.triangles.iter().enumerate() {
            let (of, setup) = project_triangle(view, 0, triangle, i as u32, i as u32, params);
            push(of, triangle.material);
            setups.push(setup);
        }
        ViewCasters { gaussians, setups, ..all }
    }

    fn store(
        &self,
        view: &View,
        gpu_view: &GpuView,
        accumulated: &[TileTexels<Accumulated>],
        opaque: &[TileTexels<f32>],
    ) -> ViewMaps {
        let texels = (view.size.x * view.size.y) as usize;
        let mut maps = ViewMaps {
            view: view.clone(),
            filter: vec![[1.0; 3]; texels],
            nearest: vec![1.0; texels],
            opaque: vec![1.0; texels],
            colored: Vec::new(),
            curve: None,
            sums: Vec::new(),
            caustics: Vec::new(),
            owner: if self.modes.owners { vec![NO_OWNER; texels] } else { Vec::new() },
        };
        for (index, (tile, opaque)) in accumulated.iter().zip(opaque).enumerate() {
            for (in_tile, texel) in Tile::new(gpu_view, index as u32).texels() {
                let at = (texel.y as u32 * view.size.x + texel.x as u32) as usize;
                maps.filter[at] = resolve(tile[in_tile].light, self.modes.gain);
                maps.nearest[at] = tile[in_tile].nearest;
                maps.opaque[at] = opaque[in_tile];
                if self.modes.owners {
                    maps.owner[at] = tile[in_tile].owner;
                }
            }
        }
        maps
    }
}

/// Visible footprints, front to back; equal keys in order of footprints.
pub(super) fn depth_order(keys: &[u32]) -> Vec<u32> {
    let visible = keys.iter().zip(0..).filter(|&(&key, _)| key != INVISIBLE);
    let mut pairs: Vec<Pair> = visible.map(|(&key, value)| Pair { key, value }).collect();
    sort(&mut pairs, 0..DEPTH_BITS);
    pairs.into_iter().map(|pair| pair.value).collect()
}

/// Counts the pairs that fit the budget, and those that do not.
fn count(counters: &mut Counters, bins: &Bins, binned: usize) {
    let overflowed = bins.overflowed.len();
    let per_tile = bins.tile_starts.windows(2).map(|w| (w[1] - w[0]) as usize);
    counters.visible += binned as u64;
    counters.pairs += bins.pairs.len() as u64;
    counters.segments += per_tile.map(|pairs| pairs.div_ceil(SEGMENT) as u64).sum::<u64>();
    counters.scattered += overflowed as u64;
    counters.overflowed += overflowed as u64;
}
