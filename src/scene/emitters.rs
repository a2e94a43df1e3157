//! `[[emitter]]`: particles that are emitted, move and fade.
use super::{
    Scene, SceneError,
    document_motion::{BoxTable, EmitterTable, FluidTable, Shades},
    limits::{self, Limit},
    loader::Loader,
    particles::FARTHEST,
    tables::Table,
};
use crate::{
    model::{
        Motion,
        emission::{Emission, Emitter, MAX_STOPS},
        emitter::{EmittedParticle, Flock, Forces, MAX_BOXES, STEPS_PER_SECOND},
        fluid::Fluid,
        moved,
    },
    records::EmitterParams,
};
use glam::Vec3;
use std::{
    fmt,
    ops::RangeInclusive,
    sync::{Arc, Mutex, PoisonError},
};
use toml::Spanned;

/// Most particle steps of all emitters for one frame on its own: some minutes on two cores.
const MAX_FLOWN: u64 = 1 << 32;

/// Most particle steps of samples of all emitters: a second or two.
const MAX_SAMPLED: usize = 1 << 24;

/// All emitters of a scene; their particles come after all others.
#[derive(Clone)]
struct Emitters {
    first_particle: usize,
    emitters: Vec<Arc<Emitter>>,
    /// Those that a device simulates.
    on_device: Vec<bool>,
    /// State after the last frame, from which the next one continues. It depends on the time alone.
    flocks: Arc<Mutex<Vec<Flock>>>,
}

impl fmt::Debug for Emitters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first_particle, emitters, on_device, .. } = self;
        f.debug_tuple("Emitters").field(first_particle).field(emitters).field(on_device).finish()
    }
}

impl Emitters {
    fn new(first_particle: usize, emitters: Vec<Arc<Emitter>>, on_device: Vec<bool>) -> Self {
        Self { first_particle, emitters, on_device, flocks: Arc::default() }
    }
}

impl Motion for Emitters {
    fn apply(&self, scene: &mut Scene, seconds: f64) {
        scene.particles.truncate(self.first_particle);
        scene.emissions.clear();
        let mut flocks = self.flocks.lock().unwrap_or_else(PoisonError::into_inner);
        let mut left_out = 0;
        flocks.resize(self.emitters.len(), Flock::default());
        for ((emitter, flock), on_device) in
            self.emitters.iter().zip(flocks.iter_mut()).zip(&self.on_device)
        {
            if *on_device {
                scene.emissions.push(Emission::at(emitter, seconds));
            } else {
                left_out += emitter.send(flock, seconds, FARTHEST, &mut scene.particles);
            }
        }
        if left_out > 0 {
            *scene.skipped.entry(moved::PARTICLE).or_default() += left_out;
        }
    }

    fn moved(&self, by: Vec3) -> Option<Arc<dyn Motion>> {
        let moved = |emitter: &Arc<Emitter>| {
            Arc::new(Emitter { forces: emitter.forces.moved(by), ..(**emitter).clone() })
        };
        let emitters = self.emitters.iter().map(moved).collect();
        Some(Arc::new(Self::new(self.first_particle, emitters, self.on_device.clone())))
    }

    fn moves_particles(&self) -> bool {
        true
    }

    fn first_particle(&self) -> Option<usize> {
        Some(self.first_particle)
    }

    fn most_particles(&self) -> u64 {
        let most = |emitter: &Arc<Emitter>| u64::from(emitter.forces.most_until(emitter.steps));
        self.emitters.iter().map(most).sum()
    }

    fn on_device(&self, most: u64) -> Option<(Arc<dyn Motion>, Vec<String>)> {
        let reason = |emitter: &Arc<Emitter>| {
            let count = emitter.forces.most_until(emitter.steps);
            if emitter.fluid.is_some() {
                Some("its particles are a fluid".to_owned())
            } else if u64::from(count) > most {
                Some(format!("{count} particles, and a buffer of the device holds {most}"))
            } else if !EmitterParams::has_room(&emitter.forces) {
                Some("its path has too many rows in 1/60 s".to_owned())
            } else {
                None
            }
        };
        let reasons: Vec<_> = self.emitters.iter().map(reason).collect();
        let on_device = reasons.iter().map(Option::is_none).collect();
        let moved = Self::new(self.first_particle, self.emitters.clone(), on_device);
        let named = |(i, reason)| format!("emitter {i} is simulated on the CPU: {reason}");
        let reasons = reasons.into_iter().enumerate().filter_map(|(i, reason)| Some((i, reason?)));
        Some((Arc::new(moved), reasons.map(named).collect()))
    }
}

/// Particle steps for a frame on its own, at time 0 or, without a fluid, at any time.
fn flown(emitter: &Emitter) -> u64 {
    let (most, longest) = (emitter.forces.most(), emitter.forces.longest());
    let Some(fluid) = &emitter.fluid else { return u64::from(most) * u64::from(longest) };
    // A fluid is simulated from its first step on. Of a particle's neighbours, twice as many as at rest, twice.
    let past = (-emitter.start * STEPS_PER_SECOND).max(0.0);
    let pairs = 4.0 * f64::from(fluid.reach / fluid.spacing).powi(3);
    (f64::from(most) * past.max(f64::from(longest)) * pairs.max(1.0)) as u64
}

impl Loader<'_> {
    /// Loads the emitters, whose particles come after all others.
    pub(super) fn emitters(&mut self, tables: &[Spanned<EmitterTable>]) -> Result<(), SceneError> {
        if tables.is_empty() {
            return Ok(());
        }
        let first_particle = self.scene.particles.len();
        let (mut have, mut all_flown) = (first_particle, 0_u64);
        let mut emitters = Vec::with_capacity(tables.len());
        for table in tables {
            let emitter = self.emitter(table)?;
            let most = emitter.forces.most();
            self.check_limit(Limit::Particles, have, most as usize, (&table.span(), "rate"))?;
            all_flown = all_flown.saturating_add(flown(&emitter));
            if all_flown > MAX_FLOWN {
                let message = format!("{all_flown} steps of particles for one frame");
                let help = format!(
                    "at most {MAX_FLOWN} of all emitters: use a lower rate, shorter lives or a later start"
                );
                return Err(self.error(&table.span(), "lifetime", &message, &help));
            }
            if emitter.fluid.is_some() && most > Fluid::MAX {
                let message = format!("{most} particles that press each other");
                let help = format!("at most {}: use a lower rate or shorter lives", Fluid::MAX);
                return Err(self.error(&table.span(), "rate", &message, &help));
            }
            have += most as usize;
            self.next_id = self.next_id.wrapping_add(1 << 24);
            emitters.push(Arc::new(emitter));
        }
        self.ask_for(have - first_particle)?;
        let on_device = vec![false; emitters.len()];
        if self.sends_out {
            let emitters = Emitters::new(first_particle, emitters, on_device);
            emitters.apply(&mut self.scene, 0.0);
            self.scene.motions.push(Arc::new(emitters));
        } else {
            let steps = MAX_SAMPLED / emitters.len();
            let sample = emitters.iter().flat_map(|emitter| emitter.sample(0.0, FARTHEST, steps));
            self.scene.particles.extend(sample);
            self.resting = Some(Arc::new(Emitters::new(first_particle, emitters, on_device)));
        }
        Ok(())
    }

    /// Asks for the memory of the most particles that are alive at a time.
    fn ask_for(&mut self, most: usize) -> Result<(), SceneError> {
        let path = self.source.path();
        limits::reserve(&mut self.scene.particles, most, "particles", path)?;
        // Emitters keep theirs with a step each, twice while they fly.
        let bytes = (2 * size_of::<(EmittedParticle, u32)>() * most) as u64;
        if limits::has_memory(bytes) {
            return Ok(());
        }
        let message = format!("no memory for {most} particles of emitters ({} MiB)", bytes >> 20);
        Err(SceneError::memory(path, message))
    }

    fn emitter(&self, table: &Spanned<EmitterTable>) -> Result<Emitter, SceneError> {
        let check = Table { source: self.source, table };
        let given = table.get_ref();
        let material = self.material(&table.span(), &given.material)?;
        let number = |key: &str, value: Option<f32>, usual: f32, range: RangeInclusive<f32>| {
            let words = format!("{} to {}", range.start(), range.end());
            check.number(key, value.unwrap_or(usual), |v| range.contains(&v), &words)
        };
        let vector = |key: &str, value: Option<[f32; 3]>, usual: [f32; 3]| {
            check.vector(key, value.unwrap_or(usual))
        };
        let stops =
            |key: &str, given: &Option<Vec<f32>>, usual: &[f32], range: RangeInclusive<f32>| {
                let values = given.clone().unwrap_or_else(|| usual.to_vec());
                count_stops(&check, key, values.len())?;
                let words = format!("{} to {}", range.start(), range.end());
                for &value in &values {
                    check.number(key, value, |v| range.contains(&v), &words)?;
                }
                Ok(values)
            };
        let most_color = self.scene.materials[material as usize].transfer.max_color();
        let colors = given.color.clone().unwrap_or_else(|| vec![Shades([1.0; 3])]);
        count_stops(&check, "color", colors.len())?;
        for &value in colors.iter().flat_map(|color| &color.0) {
            let range = format!("0 to {most_color}");
            check.number("color", value, |v| (0.0..=most_color).contains(&v), &range)?;
        }
        let lifetime = match given.lifetime.0[..] {
            [one] => [one; 2],
            [least, most] if least <= most => [least, most],
            _ => {
                let help = "one number, or the shortest and the longest [s]";
                return Err(check.fault("lifetime", "lifetime is no range", help));
            }
        };
        for seconds in lifetime {
            number("lifetime", Some(seconds), 1.0, 0.02..=600.0)?;
        }
        let start = number("start", given.start, 0.0, -600.0..=1e6)?;
        let stop = match given.stop {
            Some(stop) if stop.is_finite() && stop > start => Some(stop),
            Some(stop) => {
                let help = "it ends after its start [s]";
                return Err(check.fault("stop", format!("stop is {stop}"), help));
            }
            None => None,
        };
        let extent = vector("extent", given.extent, [0.2; 3])?;
        if extent.min_element() < 0.0 {
            return Err(check.fault("extent", "a negative extent", "use lengths of 0 or more [m]"));
        }
        if given.boxes.len() > MAX_BOXES {
            let message = format!("{} boxes", given.boxes.len());
            return Err(check.fault("boxes", message, &format!("at most {MAX_BOXES}")));
        }
        let forces = Forces {
            seed: given.seed.unwrap_or(0),
            rate: f64::from(number("rate", Some(given.rate), 1.0, 1e-3..=1e6)?),
            lifetime,
            shape: given.shape.unwrap_or_default(),
            position: vector("position", given.position, [0.0; 3])?,
            extent,
            velocity: vector("velocity", given.velocity, [0.0, 1.0, 0.0])?,
            spread: number("spread", given.spread, 0.0, 0.0..=1e3)?,
            gravity: number("gravity", given.gravity, 0.0, -1e3..=1e3)?,
            buoyancy: number("buoyancy", given.buoyancy, 0.0, -1e3..=1e3)?,
            drag: number("drag", given.drag, 0.0, 0.0..=1e3)?,
            wind: vector("wind", given.wind, [0.0; 3])?,
            turbulence: number("turbulence", given.turbulence, 0.0, 0.0..=1e3)?,
            frequency: number("frequency", given.frequency, 1.0, 1e-3..=1e3)?,
            evolve: number("evolve", given.evolve, 0.0, -1e3..=1e3)?,
            ground: match given.ground {
                Some(height) => Some(number("ground", Some(height), 0.0, -FARTHEST..=FARTHEST)?),
                None => None,
            },
            boxes: given
                .boxes
                .iter()
                .map(|table| self.solid_box(table))
                .collect::<Result<_, _>>()?,
            bounce: number("bounce", given.bounce, 0.2, 0.0..=1.0)?,
            slide: number("slide", given.slide, 0.8, 0.0..=1.0)?,
            path: path(&check, start)?,
            origin: Vec3::ZERO,
        };
        if (forces.turbulence > 0.0 || forces.wind != Vec3::ZERO) && forces.drag == 0.0 {
            let key = if forces.turbulence > 0.0 { "turbulence" } else { "wind" };
            let help =
                "give it a drag, such as 1: that is how fast the air takes particles with it";
            return Err(check.fault(key, "air that moves takes nothing with it", help));
        }
        let lasts =
            stop.map_or(f64::from(u32::MAX), |stop| f64::from(stop - start) * STEPS_PER_SECOND);
        Ok(Emitter {
            forces,
            fluid: given.fluid.as_ref().map(|table| self.fluid(table)).transpose()?,
            material,
            first_id: self.next_id,
            start: f64::from(start),
            steps: lasts as u32,
            radius: stops("radius", &given.radius, &[0.05], 1e-6..=1e5)?,
            color: colors.iter().map(|color| Vec3::from(color.0)).collect(),
            alpha: stops("alpha", &given.alpha, &[1.0], 0.0..=1.0)?,
        })
    }

    fn fluid(&self, table: &Spanned<FluidTable>) -> Result<Fluid, SceneError> {
        let check = Table { source: self.source, table };
        let FluidTable { spacing, reach, stiffness, viscosity } = *table.get_ref();
        let within = |key: &str, value: f32, range: RangeInclusive<f32>| {
            let words = format!("{} to {}", range.start(), range.end());
            check.number(key, value, |v| range.contains(&v), &words)
        };
        let spacing = within("spacing", spacing, 1e-3..=1e3)?;
        let reach = within("reach", reach.unwrap_or(2.0 * spacing), spacing..=4.0 * spacing)?;
        // Limits for stable steps of 1/60 s: sound travels a fraction of the reach, and drag halves the
        // difference of two particles' velocities.
        let (fastest, thickest) = ((24.0 * reach).powi(2), 2.0 * reach * reach);
        let stiffness = stiffness.unwrap_or(fastest / 4.0);
        let viscosity = viscosity.unwrap_or(thickest / 10.0);
        Ok(Fluid {
            spacing,
            reach,
            stiffness: within("stiffness", stiffness, 0.0..=fastest)?,
            viscosity: within("viscosity", viscosity, 0.0..=thickest)?,
        })
    }

    fn solid_box(&self, table: &Spanned<BoxTable>) -> Result<[Vec3; 2], SceneError> {
        let check = Table { source: self.source, table };
        let BoxTable { min, max } = *table.get_ref();
        let (low, high) = (check.vector("min", min)?, check.vector("max", max)?);
        if low.cmplt(high).all() {
            return Ok([low, high]);
        }
        Err(check.fault("min", "min is not below max", "write the lower corner as min"))
    }
}

/// Rows of the path's table, relative to the emitter's start.
fn path(check: &Table<'_, EmitterTable>, start: f32) -> Result<Vec<[f32; 4]>, SceneError> {
    let mut rows: Vec<[f32; 4]> = Vec::new();
    for row in &check.table.get_ref().path {
        let &[seconds, x, y, z] = &row.0[..] else {
            let message = format!("a row of {} numbers", row.0.len());
            return Err(check.fault("path", message, "each row is [seconds, x, y, z]"));
        };
        check.vector("path", [x, y, z])?;
        let ascends = rows.last().is_none_or(|last| last[0] < seconds - start);
        if !seconds.is_finite() || !ascends {
            let message = "times that do not ascend";
            return Err(check.fault(
                "path",
                message,
                "write its rows in order, each time once [s]",
            ));
        }
        rows.push([seconds - start, x, y, z]);
    }
    Ok(rows)
}

fn count_stops(check: &Table<'_, EmitterTable>, key: &str, count: usize) -> Result<(), SceneError> {
    if (1..=MAX_STOPS).contains(&count) {
        return Ok(());
    }
    let help = format!("1 to {MAX_STOPS}, evenly spaced over a particle's life");
    Err(check.fault(key, format!("{count} values of {key}"), &help))
}
