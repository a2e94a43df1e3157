//! Splats, as curves and as other projects store or trace their shadows, against the definition in 64 bits.
use crate::{
    moments::Moments,
    rays::{Errors, Ray, depths, rays, under_a_sun},
    rivals::{Fourier, Hit},
};
use gobo::{
    glam::{DMat3, DVec3, Vec3},
    model::GaussianOpacity,
    records::ViewMaps,
};
use gobo_scene::Scene;
use std::f64::consts::TAU;

/// A Gaussian on a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    /// Light depth of its highest density, and its standard deviation along the ray.
    pub(crate) depth: f64,
    pub(crate) deviation: f64,
    /// Absorbed share of the light.
    pub(crate) alpha: f64,
    /// Its optical depth as a medium; a splat becomes a medium that absorbs its opacity along a ray through
    /// its centre.
    pub(crate) thickness: f64,
    pub(crate) is_medium: bool,
}

impl Met {
    /// Share of a medium's optical depth in front of `z`.
    fn share(&self, z: f64) -> f64 {
        normal_share((z - self.depth) / self.deviation)
    }

    fn passed(&self, z: f64) -> f64 {
        match self.is_medium {
            true => (-self.thickness * self.share(z)).exp(),
            false if self.depth < z => 1.0 - self.alpha,
            false => 1.0,
        }
    }

    /// Hits for methods that add them up: one for a splat, a few for a medium.
    fn hits(&self) -> Vec<Hit> {
        /// Stretches of a medium, and its end [standard deviations].
        const STRETCHES: u32 = 16;
        const END: f64 = 3.2;
        let hit = |depth: f64, light: f64| (depth as f32, Vec3::splat(light as f32));
        if !self.is_medium {
            return vec![hit(self.depth, 1.0 - self.alpha)];
        }
        let end = |i: u32| (2.0 * f64::from(i) / f64::from(STRETCHES) - 1.0) * END;
        let stretch = |i: u32| {
            let share = normal_share(end(i + 1)) - normal_share(end(i));
            let middle = self.depth + 0.5 * (end(i) + end(i + 1)) * self.deviation;
            hit(middle, (-self.thickness * share / (1.0 - 2.0 * normal_share(-END))).exp())
        };
        (0..STRETCHES).map(stretch).collect()
    }
}

/// Farthest distance from a Gaussian's centre at which a ray meets it [standard deviations].
const REACH: f64 = 8.0;
/// Rays that lose less light are left out.
const LEAST_LOSS: f64 = 0.05;
/// Least opacity of a Gaussian that counts as a hit, as for a pixel in 3DGS.
const LEAST_ALPHA: f64 = 1.0 / 255.0;
/// Opacity of the densest splat that becomes a medium.
const DENSEST: f64 = 1.0 - 1e-6;

/// The Gaussians on a ray, nearest first.
fn met(scene: &Scene, ray: &Ray) -> Vec<Met> {
    let along = ray.way.normalize();
    let mut all = Vec::new();
    for gaussian in &scene.gaussians {
        let from = ray.start - gaussian.center.as_dvec3();
        let reach = REACH * f64::from(gaussian.sigma.max_element());
        if (from - along * from.dot(along)).length_squared() > reach * reach {
            continue;
        }
        let rotation = DMat3::from_quat(gaussian.rotation.as_dquat().normalize());
        let own = |v: DVec3| rotation.transpose() * v / gaussian.sigma.as_dvec3();
        let (from, way) = (own(from), own(ray.way));
        let depth = -from.dot(way) / way.length_squared();
        let share = (-0.5 * (from + way * depth).length_squared()).exp();
        let deviation = 1.0 / way.length();
        let material = &scene.materials[gaussian.material as usize];
        let opacity = f64::from(gaussian.opacity * material.tint.w);
        all.push(match material.gaussian {
            GaussianOpacity::Medium { density } => {
                let length = TAU.sqrt() * deviation * ray.way.length();
                let thickness = f64::from(density) * opacity * share * length;
                let alpha = 1.0 - (-thickness).exp();
                Met { depth, deviation, alpha, thickness, is_medium: true }
            }
            _ => {
                let thickness = -(1.0 - opacity.min(DENSEST)).ln() * share;
                Met { depth, deviation, alpha: opacity * share, thickness, is_medium: false }
            }
        });
    }
    all.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    all
}

/// The neutral shadow: the product of all Gaussians' transmittances up to `z`.
pub(crate) fn exact(met: &[Met], z: f64) -> f64 {
    met.iter().map(|met| met.passed(z)).product()
}

/// `vk_gaussian_splatting` of NVIDIA (`traceShadowRayParticle`, without colour and offset, its default): the
/// `count` hits nearest to the receiver; light up to 0.8 becomes black, the rest is stretched.
pub(crate) fn nearest_hits(met: &[Met], z: f64, count: usize) -> f64 {
    const THRESHOLD: f64 = 0.8;
    let in_front = met[..met.partition_point(|met| met.depth < z)].iter().rev();
    let hits = in_front.filter(|met| met.alpha >= LEAST_ALPHA).take(count);
    let light: f64 = hits.map(|met| 1.0 - met.alpha).product();
    ((light - THRESHOLD) / (1.0 - THRESHOLD)).clamp(0.0, 1.0)
}

/// Gaussians as a medium, by the closed form of deep Gaussian shadow maps (arXiv 2601.01660), exact if they
/// are one.
pub(crate) fn as_medium(met: &[Met], z: f64) -> f64 {
    (-met.iter().map(|met| met.thickness * met.share(z)).sum::<f64>()).exp()
}

/// Share of a normal distribution below `x` deviations (Abramowitz and Stegun 1964, 7.1.26, to 1.5e-7).
fn normal_share(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs() / 2f64.sqrt());
    let terms = [1.061_405_429, -1.453_152_027, 1.421_413_741, -0.284_496_736, 0.254_829_592];
    let rest = terms.iter().fold(0.0, |sum, term| sum * t + term) * t * (-0.5 * x * x).exp();
    if x < 0.0 { 0.5 * rest } else { 1.0 - 0.5 * rest }
}

/// Format of the shadows of splats, or tracing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// `vk_gaussian_splatting`, with its number of hits.
    NearestHits(usize),
    /// Deep Gaussian shadow maps.
    Medium,
    Moments(usize),
    Fourier,
    /// The maps' curves, with their number of nodes.
    Curve(u32),
}

impl Method {
    pub(crate) const ALL: [Self; 10] = [
        Self::NearestHits(16),
        Self::NearestHits(32),
        Self::Medium,
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
            Self::NearestHits(count) => format!("vk_gaussian_splatting, {count} hits"),
            Self::Medium => "as a medium (DGSM)".to_owned(),
            Self::Moments(count) => format!("{count} moments, grey"),
            Self::Fourier => "Fourier, 15 coefficients, grey".to_owned(),
            Self::Curve(nodes) => format!("gobo, K = {nodes}"),
        }
    }

    /// Memory of a map [bytes per texel]; 0 if the ray is traced, or the casters are summed again.
    pub(crate) fn bytes(self) -> u32 {
        match self {
            Self::NearestHits(_) | Self::Medium => 0,
            Self::Moments(count) => 4 * (count as u32 + 1),
            Self::Fourier => 2 * 15,
            Self::Curve(nodes) => 12 + 8 * nodes,
        }
    }
}

/// A cloud of splats, and rays through it.
#[derive(Debug)]
pub(crate) struct Cloud {
    scene: Scene,
    size: u32,
    rays: Vec<(Ray, Vec<Met>)>,
}

impl Cloud {
    /// Rays of a map of `size` texels that lose light.
    pub(crate) fn new(scene: Scene, size: u32, count: usize) -> Self {
        let scene = under_a_sun(scene, size, 8);
        let rays = rays(&scene, count, |ray| {
            let met = met(&scene, ray);
            (exact(&met, 2.0) < 1.0 - LEAST_LOSS).then_some(met)
        });
        Self { scene, size, rays }
    }

    /// Mean number of Gaussians per ray that absorb at least a 255th of the light.
    pub(crate) fn hits(&self) -> f64 {
        let visible = |met: &Vec<Met>| met.iter().filter(|met| met.alpha >= LEAST_ALPHA).count();
        self.rays.iter().map(|ray| visible(&ray.1)).sum::<usize>() as f64 / self.rays.len() as f64
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
            let light = light_of(method, ray, met, maps.as_ref());
            for z in depths() {
                errors.add(DVec3::splat(light(z)), DVec3::splat(exact(met, z)));
            }
        }
        errors
    }
}

fn light_of<'a>(
    method: Method,
    ray: &'a Ray,
    met: &'a [Met],
    maps: Option<&'a ViewMaps>,
) -> Box<dyn Fn(f64) -> f64 + 'a> {
    let hits: Vec<Hit> = met.iter().flat_map(Met::hits).collect();
    match method {
        Method::NearestHits(count) => Box::new(move |z| nearest_hits(met, z, count)),
        Method::Medium => Box::new(|z| as_medium(met, z)),
        Method::Moments(count) => {
            let map = Moments::new(&hits, count);
            Box::new(move |z| map.light_at(z as f32).x.into())
        }
        Method::Fourier => {
            let map = Fourier::new(&hits);
            Box::new(move |z| map.light_at(z as f32).x.into())
        }
        Method::Curve(_) => {
            let curve = maps.and_then(|maps| maps.curve.as_ref());
            Box::new(move |z| {
                curve.map_or(f64::NAN, |curve| curve.light_at(ray.texel, z as f32).x.into())
            })
        }
    }
}
