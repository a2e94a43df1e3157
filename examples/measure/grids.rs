//! Grids of voxels, as curves and as other projects store their shadows, against an exact march in 64 bits.
use crate::{
    avsm::Adaptive,
    grid_truth::Line,
    moments::Moments,
    rays::{DEPTHS, Errors, Ray, depths, rays, under_a_sun},
    rivals::{Fourier, Hit},
};
use gobo::{
    glam::{DVec3, Vec3},
    internals::records::ViewMaps,
    scene::Scene,
};

/// Parts of each crossed cell that methods which add up hits are given.
const PARTS: u32 = 4;
/// Rays that lose less light are left out.
const LEAST_LOSS: f64 = 0.05;

/// What a ray meets of a grid.
#[derive(Clone, Debug)]
pub(crate) struct Met {
    /// Stretches in cells [light depth], front to back, and their optical depths.
    cells: Vec<([f64; 2], DVec3)>,
    /// Light at every depth.
    light: Vec<DVec3>,
}

/// All grids of the scene on a ray.
fn met(scene: &Scene, ray: &Ray) -> Met {
    let line = Line { start: ray.start, way: ray.way };
    let mut cells = Vec::new();
    let mut taus = vec![DVec3::ZERO; DEPTHS];
    for grid in &scene.grids {
        let extinction = f64::from(grid.factor) * grid.extinction.as_dvec3();
        let stretches = line.stretches(grid, [0.0, 1.0]);
        cells.extend(stretches.into_iter().map(|(ways, integral)| (ways, integral * extinction)));
        let depths = line.optical_depths(grid, [0.0, 1.0], DEPTHS);
        for (tau, integral) in taus.iter_mut().zip(depths) {
            *tau += integral * extinction;
        }
    }
    cells.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    Met { cells, light: taus.into_iter().map(|tau| (-tau).map(f64::exp)).collect() }
}

/// How the shadow of a grid is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Adaptive volumetric shadow maps, with their number of points.
    Adaptive(usize),
    Moments(usize),
    Fourier,
    /// The maps' curves, with their number of nodes.
    Curve(u32),
}

impl Method {
    pub(crate) const ALL: [Self; 9] = [
        Self::Adaptive(8),
        Self::Adaptive(16),
        Self::Moments(4),
        Self::Moments(6),
        Self::Moments(8),
        Self::Fourier,
        Self::Curve(4),
        Self::Curve(8),
        Self::Curve(16),
    ];

    pub(crate) fn name(self) -> String {
        match self {
            Self::Adaptive(count) => format!("AVSM, {count} points"),
            Self::Moments(count) => format!("{count} moments"),
            Self::Fourier => "Fourier, 15 coefficients".to_owned(),
            Self::Curve(nodes) => format!("gobo, K = {nodes}"),
        }
    }

    /// Memory of a map [bytes per texel] of a channel; of all three together for curves, with F and D.
    pub(crate) fn bytes(self) -> u32 {
        match self {
            Self::Adaptive(count) => 8 * count as u32,
            Self::Moments(count) => 4 * (count as u32 + 1),
            Self::Fourier => 2 * 15,
            Self::Curve(nodes) => 12 + 8 * nodes,
        }
    }
}

/// A grid, and rays through it.
#[derive(Debug)]
pub(crate) struct Volume {
    scene: Scene,
    size: u32,
    rays: Vec<(Ray, Met)>,
}

impl Volume {
    /// Rays of a map of `size` texels that lose light.
    pub(crate) fn new(scene: Scene, size: u32, count: usize) -> Self {
        let scene = under_a_sun(scene, size, 8);
        let rays = rays(&scene, count, |ray| {
            let met = met(&scene, ray);
            (met.light[DEPTHS - 1].min_element() < 1.0 - LEAST_LOSS).then_some(met)
        });
        Self { scene, size, rays }
    }

    /// `render`: the maps of a scene's only view.
    pub(crate) fn errors(&self, method: Method, render: impl FnOnce(&Scene) -> ViewMaps) -> Errors {
        let maps = match method {
            Method::Curve(nodes) => {
                Some(render(&under_a_sun(self.scene.clone(), self.size, nodes)))
            }
            _ => None,
        };
        let mut errors = Errors::default();
        for (ray, met) in &self.rays {
            let light = light_of(method, ray, met, maps.as_ref());
            for (z, expected) in depths().zip(&met.light) {
                errors.add(light(z), *expected);
            }
        }
        errors
    }
}

fn light_of<'a>(
    method: Method,
    ray: &Ray,
    met: &Met,
    maps: Option<&'a ViewMaps>,
) -> Box<dyn Fn(f64) -> DVec3 + 'a> {
    let passed = |tau: DVec3| (-tau).map(f64::exp);
    let mut hits: Vec<Hit> = Vec::new();
    for &([start, end], tau) in &met.cells {
        let light = passed(tau / f64::from(PARTS)).as_vec3();
        let middle = |i| start + (end - start) * (f64::from(i) + 0.5) / f64::from(PARTS);
        hits.extend((0..PARTS).map(|i| (middle(i) as f32, light)));
    }
    match method {
        Method::Adaptive(count) => {
            let mut map = Adaptive::new(count);
            met.cells.iter().for_each(|&(stretch, tau)| map.append(stretch, passed(tau)));
            Box::new(move |z| map.light_at(z))
        }
        Method::Moments(count) => {
            let map = Moments::new(&hits, count);
            Box::new(move |z| map.light_at(z as f32).as_dvec3())
        }
        Method::Fourier => {
            let map = Fourier::new(&hits);
            Box::new(move |z| map.light_at(z as f32).as_dvec3())
        }
        Method::Curve(_) => {
            let (curve, texel) = (maps.and_then(|maps| maps.curve.as_ref()), ray.texel);
            let light = move |z: f64| curve.map(|curve| curve.light_at(texel, z as f32));
            Box::new(move |z| light(z).map_or(DVec3::NAN, Vec3::as_dvec3))
        }
    }
}
