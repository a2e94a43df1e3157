//! Cases with more casters than one list holds: each share of them makes a map of sums, and the sums are
//! added.
use super::{
    case::Case,
    measure::{Bench, Measured, Row},
};
use crate::failure::Failure;
use gobo::{
    Shadows,
    glam::{DVec2, DVec3},
    model::{Casters, Particle, View},
    records::{FIXED_ONE, added},
    shadows::Config,
    view::atlas::MapSlot,
};
use gobo_scene::generate::Chance;
use std::time::Instant;

/// Casters per share.
pub(super) const SHARE: u32 = 1 << 22;

/// Makes the map of each light of a case, and times it all, including the generation of casters.
pub(super) fn run(bench: &Bench, case: Case) -> Result<Row, Failure> {
    let gpu = &bench.gpu;
    let (views, materials) = (case.views(), [case.material()]);
    let mut config = Config::new(gpu.tier, &gpu.adapter);
    config.toggles.sums = true;
    let mut shadows = Shadows::sharing(&gpu.device, &gpu.queue, config, gpu.kernels.clone())?;
    let settings = bench.settings;
    let mut samples = Samples::new(&views[0]);
    let mut sums = Vec::new();
    let mut slots: Vec<MapSlot> = Vec::new();
    let (mut width, mut bytes) = (0, Vec::new());
    let started = Instant::now();
    let mut of_casters = 0.0;
    let mut share_from = |first: u32| {
        let _generating = tracing::debug_span!("generate").entered();
        let started = Instant::now();
        let particles = case.particles(first..case.casters.min(first.saturating_add(SHARE)));
        samples.add(&particles);
        of_casters += started.elapsed().as_secs_f64() * 1e3;
        particles
    };
    let mut particles = share_from(0);
    for first in (0..case.casters).step_by(SHARE as usize) {
        // Sums do not depend on order: grouping neighbours would only cull better.
        let casters = Casters {
            particles: &particles,
            materials: &materials,
            in_order: true,
            ..Casters::default()
        };
        let prepared = shadows.prepare(&casters, &views, &settings)?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder)?;
        gpu.queue.submit([encoder.finish()]);
        // The next share is generated while this one is summed.
        let next =
            first.checked_add(SHARE).filter(|&next| next < case.casters).map(&mut share_from);
        let maps = prepared.maps();
        let texture = maps.sums.as_ref().expect("they were asked for");
        let of_share: Vec<[u32; 4]> = gpu.try_read_texture(texture)?;
        sums.resize(of_share.len(), [0; 4]);
        for (sum, other) in sums.iter_mut().zip(of_share) {
            *sum = added(*sum, other);
        }
        (width, slots, bytes) =
            (texture.width() as usize, maps.slots.clone(), prepared.memory().0.clone());
        particles = next.unwrap_or_default();
    }
    let all = started.elapsed().as_secs_f64() * 1e3;
    let first = slots[0].origin.y as usize * width + slots[0].origin.x as usize;
    samples
        .check(|x, y| sums[first + y as usize * width + x as usize])
        .map_err(|wrong| Failure::Wrong(format!("{case}: the map is wrong: {wrong}")))?;
    let compute = Measured {
        runs: 1,
        compute_ms: all,
        compute_min: all,
        compute_max: all,
        milliseconds: Vec::new(),
        kernels: Vec::new(),
        stages: vec![("casters", of_casters), ("maps", all - of_casters)],
        bytes,
        pairs: 0,
        pairs_needed: 0,
        segments: 0,
        scattered: u64::from(case.casters) * views.len() as u64,
        overflowed: 0,
    };
    Ok(Row { case, compute, raster: None })
}

/// Texels whose optical depth is computed in 64 bits, caster by caster.
struct Samples<'a> {
    view: &'a View,
    /// Samples that a caster may touch, by cell of the map.
    cells: Vec<Vec<usize>>,
    texels: Vec<([u32; 2], DVec3)>,
}

/// Edge of a cell [texels].
const CELL: u32 = 16;
const COUNT: usize = 64;
/// Casters are projected in 32 bits and have 16-bit opacities; their sums are rounded to 2^-16 each by a
/// dither.
const TOLERANCE: f64 = 2e-3;
const ROUNDING: f64 = 64.0 / FIXED_ONE as f64;

impl<'a> Samples<'a> {
    fn new(view: &'a View) -> Self {
        let mut chance = Chance::new(13);
        let edge = view.size.x.div_ceil(CELL);
        let mut cells = vec![Vec::new(); (edge * edge) as usize];
        let mut texels = Vec::new();
        for sample in 0..COUNT {
            let at = [0, 1].map(|_| chance.below(view.size.x as usize) as u32);
            let near = |i: usize| {
                let cell = at[i] / CELL;
                cell.saturating_sub(1)..=(cell + 1).min(edge - 1)
            };
            for y in near(1) {
                for x in near(0) {
                    cells[(y * edge + x) as usize].push(sample);
                }
            }
            texels.push((at, DVec3::ZERO));
        }
        Self { view, cells, texels }
    }

    fn add(&mut self, particles: &[Particle]) {
        let edge = self.view.size.x.div_ceil(CELL);
        let scale = f64::from(self.view.scale);
        let from_world = self.view.view_from_world.as_dmat4();
        let middle = self.view.size.as_dvec2() * 0.5;
        for particle in particles {
            let p = from_world.transform_point3(particle.center.as_dvec3());
            let at = DVec2::new(p.x, -p.y) * scale + middle;
            let cell = (at / f64::from(CELL)).clamp(DVec2::ZERO, DVec2::splat(f64::from(edge - 1)));
            let cell = cell.y as u32 * edge + cell.x as u32;
            for &sample in &self.cells[cell as usize] {
                let (texel, sum) = &mut self.texels[sample];
                let texel = DVec2::new(f64::from(texel[0]), f64::from(texel[1])) + 0.5;
                *sum += optical_depth(particle, at.distance(texel), scale);
            }
        }
    }

    /// `sums`: of the texel at a position. Texels near black are skipped: their sums saturate.
    fn check(&self, sums: impl Fn(u32, u32) -> [u32; 4]) -> Result<(), String> {
        const DARK: f64 = 6.5;
        for &([x, y], expected) in &self.texels {
            let found = sums(x, y);
            for channel in 0..3 {
                let (found, expected) =
                    (f64::from(found[channel]) / f64::from(FIXED_ONE), expected[channel]);
                let off = (found.min(DARK) - expected.min(DARK)).abs();
                if off > TOLERANCE * expected + ROUNDING {
                    return Err(format!(
                        "texel ({x}, {y}) has an optical depth of {found:.5} for {expected:.5}"
                    ));
                }
            }
        }
        Ok(())
    }
}

/// Optical depth of a soft disc at a distance from its centre [texels]; a disc smaller than a texel is
/// enlarged to one.
fn optical_depth(particle: &Particle, distance: f64, scale: f64) -> DVec3 {
    let projected = f64::from(particle.radius) * scale;
    let radius = projected.max(std::f64::consts::FRAC_1_SQRT_2);
    let share = projected * projected / (radius * radius);
    let profile = (1.0 - (distance / radius).powi(2)).max(0.0).powi(2);
    let opacity = f64::from(particle.color.w) * share * profile;
    let [red, green, blue] = particle.color.truncate().as_dvec3().to_array();
    DVec3::from([red, green, blue].map(|c| -(-opacity * (1.0 - c)).ln_1p()))
}
