//! Estimate of the reference's work for a scene, from counts and a sample of its casters and tiles.
use super::{
    area::POINTS,
    caster_hit::Target,
    maps::{SceneRecords, depth_order},
    project::ProjectParams,
    tile::Tile,
};
use crate::records::air_columns;
use glam::UVec2;
use gobo::{
    model::{Casters, Class, Scene, ShadowFilter, Shape, View},
    records::TRIANGLE_BIT,
};

/// Casters of a kind in the sample; it stands for the others.
const CASTERS: usize = 2048;
/// Views in the sample, and tiles of each.
const VIEWS: usize = 8;
const TILES: usize = 64;

// Times of one core, for an optimised build [ns], fitted to scenes of `data/` that are each dominated by one
// of these.
/// Projecting and sorting a caster.
const CASTER: f64 = 250.0;
/// Storing a texel with its curve.
const TEXEL: f64 = 60.0;
/// Testing a texel against a disc.
const TEST: f64 = 12.0;
/// Looking up a light at a point by one texel of its map.
const TAP: f64 = 25.0;
/// Samples of a light per slice of air.
const AIR: f64 = 2.0;

/// Cost of a test against a shape, in tests against a disc.
fn tests_of(shape: Shape) -> f64 {
    match shape {
        Shape::Brick => 12.0,
        Shape::Gaussian | Shape::Capsule => 3.0,
        _ => 1.0,
    }
}

/// A sample of some casters, and the number that each stands for.
fn thinned<T: Clone>(all: &[T]) -> (Vec<T>, f64) {
    let step = all.len().div_ceil(CASTERS).max(1);
    let some: Vec<T> = all.iter().step_by(step).cloned().collect();
    let each = all.len() as f64 / some.len().max(1) as f64;
    (some, each)
}

fn texels<'a>(views: impl IntoIterator<Item = &'a View>) -> f64 {
    views.into_iter().map(|view| f64::from(view.size.x) * f64::from(view.size.y)).sum()
}

/// Work \[ns of the core that it was fitted on\].
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Work of all maps, including those of points on lights.
    pub maps: f64,
    /// Work of a picture with one sample per pixel.
    pub sample: f64,
}

impl Effort {
    /// `views`: of the scene's lights.
    pub fn new(scene: &Scene, views: &[View]) -> Self {
        let (particles, per_particle) = thinned(&scene.particles);
        let (gaussians, per_gaussian) = thinned(&scene.gaussians);
        let (triangles, per_triangle) = thinned(&scene.triangles);
        let (strands, per_strand) = thinned(&scene.strands);
        let casters = Casters {
            particles: &particles,
            gaussians: &gaussians,
            triangles: &triangles,
            strands: &strands,
            ..scene.casters()
        };
        let records = SceneRecords::new(casters, &scene.shadow);
        let standing_for = move |shape: Option<Shape>| match shape {
            None => per_triangle,
            Some(Shape::Brick) => 1.0,
            Some(Shape::Gaussian) => per_gaussian,
            Some(Shape::Capsule) => per_strand,
            Some(_) => per_particle,
        };
        let look = Look { records: &records, standing_for: &standing_for };

        let is_area = |view: &&View| view.light.is_some_and(|i| scene.lights[i].area().is_some());
        let whole = texels(views.iter());
        let (mut seen, mut of_seen) = (0.0, 0.0);
        for view in views.iter().step_by(views.len().div_ceil(VIEWS).max(1)) {
            seen += texels([view]);
            of_seen += look.at(view, false).work;
        }
        let maps = if seen > 0.0 { of_seen * whole / seen } else { 0.0 };
        let has_area = views.iter().any(|view| is_area(&view));
        let points = if has_area { POINTS as f64 } else { 1.0 };
        let of_areas = texels(views.iter().filter(is_area)) / whole.max(1.0) * maps * points;

        let camera = View::from_camera(&scene.camera, &scene.held_bounds());
        let Looked { work, lit } = look.at(&camera, true);
        let pixels = scene.camera.size;
        // A pixel's opaque surface, and one pane in front of it.
        let mut places = lit + 2.0 * f64::from(pixels.element_product());
        if let Some(air) = &scene.air {
            let columns = f64::from(air_columns(pixels).element_product());
            places += AIR * columns * f64::from(air.steps);
        }
        let taps = match scene.shadow.filter {
            ShadowFilter::None => 1,
            ShadowFilter::Bilinear => 4,
            ShadowFilter::Spline => 9,
            ShadowFilter::Pcf { taps } => (taps + 1) * (taps + 1),
            ShadowFilter::Vogel { taps, .. } => taps,
        };
        let lights = scene.lights.len() as f64;
        let look_ups = places * lights * f64::from(taps) * TAP;
        Self { maps: maps + of_areas, sample: points * (work + look_ups) }
    }
}

/// Casters of a scene, some standing for several.
struct Look<'a> {
    records: &'a SceneRecords<'a>,
    /// Casters of a shape that one stands for; `None`: triangles.
    standing_for: &'a dyn Fn(Option<Shape>) -> f64,
}

/// Work of a view \[ns\], and the number of its translucent points that are lit separately.
struct Looked {
    work: f64,
    lit: f64,
}

impl Look<'_> {
    fn at(&self, view: &View, is_camera: bool) -> Looked {
        let records = self.records;
        let gpu_view = view.to_gpu(0, UVec2::ZERO, 0);
        let include_non_casters = is_camera;
        let params = ProjectParams { scatter: false, include_non_casters, by_distance: false };
        let casters = records.project(&gpu_view, params);
        let tile_count = view.tiles().element_product();
        let sorted = depth_order(&casters.keys);
        let bins = casters.bins(&sorted, &gpu_view, tile_count, u32::MAX);
        let of = records.hit_records(&gpu_view, &casters.gaussians, &casters.setups);
        let step = (tile_count as usize).div_ceil(TILES).max(1);
        let mut tests = 0.0;
        for index in (0..tile_count).step_by(step) {
            let tile = Tile::new(&gpu_view, index);
            for pair in bins.tile(index as usize) {
                let footprint = &casters.footprints[pair.footprint as usize];
                let target = Target::new(of, footprint);
                let shape = (footprint.caster & TRIANGLE_BIT == 0).then_some(target.material.shape);
                let each = shape.map_or(1.0, tests_of) * (self.standing_for)(shape);
                tests += target.texels(&tile).count() as f64 * each;
            }
        }
        let (mut count, mut lit) = (0.0, 0.0);
        for &i in &sorted {
            let caster = records.casters.get(i as usize);
            let material = caster.map(|caster| &records.materials[caster.material() as usize]);
            let each = (self.standing_for)(material.map(|material| material.shape));
            count += each;
            let (Some(caster), Some(material)) = (caster, material) else { continue };
            if Class::BLENDED.contains(&Class::of(material)) {
                let bricks = &records.bricks;
                lit += each
                    * if material.shape == Shape::Brick {
                        let brick = &bricks.records[caster.id as usize];
                        f64::from(bricks.grid(brick).lattice_points())
                    } else {
                        1.0
                    };
            }
        }
        let texels = texels([view]);
        let work = CASTER * count + TEXEL * texels + TEST * tests * step as f64;
        Looked { work, lit }
    }
}
