//! Curves that kernels make of the discs of `gobo bench`, beside exact light.
use crate::rays::Errors;
use gobo::{
    Casters, Error,
    glam::{DVec2, DVec3, UVec2},
    gpu::Gpu,
    model::{Material, Particle, ShadowSettings, View},
    records::{PackedNode, curve::light_at},
    shadows::{Config, Shadows},
    wgpu,
};
use gobo_scene::generate::Chance;

/// Mean diameter of the discs \[texels\].
pub(crate) const FOOTPRINT: f32 = 16.0;
/// Random texels of a case, and depths of each.
const RAYS: usize = 300;
const DEPTHS: u32 = 400;

/// A case of the bench, and what rays through random texels meet.
#[derive(Debug)]
pub(crate) struct Discs {
    particles: Vec<Particle>,
    view: View,
    rays: Vec<Ray>,
}

#[derive(Clone, Debug)]
struct Ray {
    texel: UVec2,
    /// Light depths, front to back, and what passes.
    hits: Vec<(f64, DVec3)>,
}

impl Discs {
    pub(crate) fn new(casters: u32) -> Self {
        let (particles, view) = gobo_cli::bench_discs(casters, FOOTPRINT);
        let mut chance = Chance::new(13);
        let mut random = |size: u32| chance.below(size as usize) as u32;
        let texels = (0..RAYS).map(|_| UVec2::new(random(view.size.x), random(view.size.y)));
        let mut rays: Vec<_> = texels.map(|texel| Ray { texel, hits: Vec::new() }).collect();
        for particle in &particles {
            meet(&mut rays, particle, &view);
        }
        for ray in &mut rays {
            ray.hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        Self { particles, view, rays }
    }

    /// Hits of a ray, in the mean.
    pub(crate) fn hits(&self) -> f64 {
        self.rays.iter().map(|ray| ray.hits.len()).sum::<usize>() as f64 / RAYS as f64
    }

    /// Errors of curves of `nodes` nodes.
    ///
    /// # Errors
    /// Those of a device.
    pub(crate) fn errors(&self, gpu: &Gpu, nodes: u32) -> Result<Errors, Error> {
        let curves = self.curves(gpu, nodes)?;
        let mut errors = Errors::default();
        for (Ray { hits, .. }, curve) in self.rays.iter().zip(&curves) {
            for depth in (0..DEPTHS).map(|i| (f64::from(i) + 0.5) / f64::from(DEPTHS)) {
                let in_front = hits.partition_point(|hit| hit.0 < depth);
                let exact = hits[..in_front].iter().map(|hit| hit.1).product();
                errors.add(light_at(curve, depth as f32, false).as_dvec3(), exact);
            }
        }
        Ok(errors)
    }

    /// Nodes of each ray's texel.
    fn curves(&self, gpu: &Gpu, nodes: u32) -> Result<Vec<Vec<PackedNode>>, Error> {
        let mut config = Config::new(gpu.tier, &gpu.adapter);
        config.toggles.count_first = true;
        let mut shadows = Shadows::sharing(&gpu.device, &gpu.queue, config, gpu.kernels.clone())?;
        let materials = [Material::default()];
        let casters =
            Casters { materials: &materials, particles: &self.particles, ..Casters::default() };
        let settings = ShadowSettings { nodes, ..ShadowSettings::default() };
        let prepared = shadows.prepare(&casters, std::slice::from_ref(&self.view), &settings)?;
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        prepared.record(&mut encoder)?;
        gpu.queue.submit([encoder.finish()]);
        let maps = prepared.maps();
        let mut curves = vec![Vec::new(); RAYS];
        // The only map of its atlas: two nodes to a layer.
        let (height, mut number) = (maps.curves.height(), 0);
        gpu.read_rows(&maps.curves, |row: &[[PackedNode; 2]]| {
            for (ray, curve) in self.rays.iter().zip(&mut curves) {
                let texel = ray.texel + maps.slots[0].origin;
                if texel.y == number % height {
                    curve.extend(row[texel.x as usize]);
                }
            }
            number += 1;
        })?;
        Ok(curves)
    }
}

/// Adds a soft disc that faces the light, with the `filter` transfer, to the rays that it meets.
fn meet(rays: &mut [Ray], disc: &Particle, view: &View) {
    let scale = f64::from(view.scale);
    let at = view.view_from_world.as_dmat4().transform_point3(disc.center.as_dvec3());
    let middle = DVec2::new(at.x, -at.y) * scale + view.size.as_dvec2() * 0.5;
    let depth = (-at.z - f64::from(view.near)) / f64::from(view.far - view.near);
    let radius = f64::from(disc.radius) * scale;
    let (color, opacity) = (disc.color.truncate().as_dvec3(), f64::from(disc.color.w));
    for ray in rays {
        let q = (ray.texel.as_dvec2() + 0.5 - middle).length_squared() / (radius * radius);
        if q < 1.0 {
            let opacity = opacity * (1.0 - q) * (1.0 - q);
            ray.hits.push((depth, 1.0 - opacity * (1.0 - color)));
        }
    }
}

/// Line of the table of errors of kernels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) mean: f64,
    pub(crate) high: f64,
    pub(crate) most: f64,
}

impl Row {
    pub(crate) fn of(errors: &Errors) -> Self {
        Self { mean: errors.mean(), high: errors.quantile(0.99), most: errors.quantile(1.0) }
    }

    pub(crate) fn start(casters: u32, nodes: u32) -> String {
        format!("| {} x {FOOTPRINT} | {nodes} |", named(casters))
    }
}

/// As in the arguments of `gobo bench`.
fn named(casters: u32) -> String {
    match casters {
        1_000_000.. => format!("{}m", casters / 1_000_000),
        _ => format!("{}k", casters / 1000),
    }
}
