//! Grids of voxels and strands, as curves and in other projects' shadow formats, against 64 bits.
use crate::{
    avsm::Adaptive,
    deep::Layers,
    grid_truth::Line,
    moments::Moments,
    rays::{DEPTHS, Errors, Ray, depths, rays, under_a_sun},
    rivals::{Fourier, Hit},
    strands,
};
use gobo::{
    glam::{DVec3, Vec3},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_scene::Scene;

/// Parts of each crossed cell for methods that add up hits.
const PARTS: u32 = 4;
/// Rays that lose less light are left out.
const LEAST_LOSS: f64 = 0.05;

/// Stretches of casters on a ray.
#[derive(Clone, Debug)]
pub(crate) struct Met {
    /// Disjoint stretches [light depth], front to back, and their optical depths: of cells and strands.
    cells: Vec<([f64; 2], DVec3)>,
    /// Light at all depths.
    light: Vec<DVec3>,
}

/// Stretches of all grids and strands of the scene on a ray.
fn met(scene: &Scene, ray: &Ray, texel: f64) -> Met {
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
    let capsules = strands::met(scene, ray, texel);
    for (tau, depth) in taus.iter_mut().zip(depths()) {
        *tau += capsules.iter().map(|capsule| capsule.tau(depth)).sum::<DVec3>();
    }
    cells.extend(strands::stretches(&capsules));
    cells.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    Met { cells, light: taus.into_iter().map(|tau| (-tau).map(f64::exp)).collect() }
}

impl Met {
    /// Start of its first stretch and end of its last.
    fn ends(&self) -> [f64; 2] {
        match (self.cells.first(), self.cells.last()) {
            (Some(([start, _], _)), Some(([_, end], _))) => [*start, *end],
            _ => [0.0; 2],
        }
    }
}

/// Format of the shadow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Adaptive volumetric shadow maps, with their number of points.
    Adaptive(usize),
    Moments(usize),
    Fourier,
    /// A deep opacity map, with its number of layers.
    Layers(usize),
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

    /// Methods for hair too.
    pub(crate) const OF_HAIR: [Self; 10] = {
        let [a, b, c, d, e, f, g, h, i] = Self::ALL;
        [Self::Layers(8), a, b, c, d, e, f, g, h, i]
    };

    pub(crate) fn name(self) -> String {
        match self {
            Self::Adaptive(count) => format!("AVSM, {count} points"),
            Self::Moments(count) => format!("{count} moments"),
            Self::Fourier => "Fourier, 15 coefficients".to_owned(),
            Self::Layers(count) => format!("deep opacity map, {count} layers"),
            Self::Curve(nodes) => format!("gobo, K = {nodes}"),
        }
    }

    /// Memory of a map [bytes per texel]: per channel; for curves of all three together, with F and D.
    pub(crate) fn bytes(self) -> u32 {
        match self {
            Self::Adaptive(count) => 8 * count as u32,
            Self::Moments(count) => 4 * (count as u32 + 1),
            Self::Fourier => 2 * 15,
            Self::Layers(count) => 4 + 2 * count as u32,
            Self::Curve(nodes) => 12 + 8 * nodes,
        }
    }
}

/// Grids and strands, and rays through them.
#[derive(Debug)]
pub(crate) struct Volume {
    scene: Scene,
    size: u32,
    rays: Vec<(Ray, Met)>,
    /// Largest distance from a ray's first stretch to its last [light depth].
    span: f64,
    /// Whether receivers are only between a ray's first stretch and its last.
    is_inside: bool,
}

impl Volume {
    /// Rays of a map of `size` texels that lose light.
    pub(crate) fn new(scene: Scene, size: u32, count: usize) -> Self {
        let scene = under_a_sun(scene, size, 8);
        let texel = 1.0 / f64::from(shadow_views(&scene)[0].scale);
        let rays = rays(&scene, count, |ray| {
            let met = met(&scene, ray, texel);
            (met.light[DEPTHS - 1].min_element() < 1.0 - LEAST_LOSS).then_some(met)
        });
        let span = |(_, met): &(Ray, Met)| met.ends()[1] - met.ends()[0];
        let span = rays.iter().map(span).fold(0.0, f64::max);
        Self { scene, size, rays, span, is_inside: false }
    }

    /// Like [`Self::new`], with receivers among the hairs.
    pub(crate) fn of_hair(scene: Scene, size: u32, count: usize) -> Self {
        Self { is_inside: true, ..Self::new(scene, size, count) }
    }

    /// `render`: renders the maps of a scene's only view.
    pub(crate) fn errors(&self, method: Method, render: impl FnOnce(&Scene) -> ViewMaps) -> Errors {
        let maps = match method {
            Method::Curve(nodes) => {
                Some(render(&under_a_sun(self.scene.clone(), self.size, nodes)))
            }
            _ => None,
        };
        let mut errors = Errors::default();
        for (ray, met) in &self.rays {
            let light = self.light_of(method, ray, met, maps.as_ref());
            let [start, end] = if self.is_inside { met.ends() } else { [0.0, 1.0] };
            for (z, expected) in depths().zip(&met.light).filter(|(z, _)| (start..=end).contains(z))
            {
                errors.add(light(z), *expected);
            }
        }
        errors
    }

    fn light_of<'a>(
        &self,
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
            Method::Layers(count) => {
                let map = Layers::new(&met.cells, self.span, count);
                Box::new(move |z| map.light_at(z))
            }
            Method::Curve(_) => {
                let (curve, texel) = (maps.and_then(|maps| maps.curve.as_ref()), ray.texel);
                let light = move |z: f64| curve.map(|curve| curve.light_at(texel, z as f32));
                Box::new(move |z| light(z).map_or(DVec3::NAN, Vec3::as_dvec3))
            }
        }
    }
}
