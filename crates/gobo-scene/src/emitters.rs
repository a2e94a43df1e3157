//! `[[emitter]]`: emitted particles that move and fade, with their trails and fluids.
use super::{
    Scene, SceneError,
    document::{EmitterTable, Numbers, Shades},
    keys::Keys,
    limits::{self, Limit},
    loader::Loader,
    particles::FARTHEST,
};
use glam::Vec3;
use gobo::{
    model::{
        Bounds, Motion, StrandVertex,
        emission::{Emission, Emitter, MAX_STOPS, Trail},
        emitter::{EmittedParticle, EmitterShape, Flock, Forces, MAX_BOXES, STEPS_PER_SECOND},
        fluid::Fluid,
        moved,
    },
    records::EmitterParams,
};
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

/// All emitters of a scene; their particles and trails follow all others.
#[derive(Clone)]
struct Emitters {
    first_particle: usize,
    first_strand: usize,
    emitters: Vec<Arc<Emitter>>,
    /// Whether a device simulates each emitter.
    on_device: Vec<bool>,
    /// States of each emitter after the last frame, at the moments that it needs; the next frame continues
    /// from them. They depend on the time alone.
    flocks: Arc<Mutex<Vec<Vec<Flock>>>>,
}

impl fmt::Debug for Emitters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first_particle, emitters, on_device, .. } = self;
        f.debug_tuple("Emitters").field(first_particle).field(emitters).field(on_device).finish()
    }
}

impl Emitters {
    /// Emitters on the CPU; their particles and trails follow those of the scene.
    fn new(scene: &Scene, emitters: Vec<Arc<Emitter>>) -> Self {
        Self {
            first_particle: scene.particles.len(),
            first_strand: scene.strands.len(),
            on_device: vec![false; emitters.len()],
            emitters,
            flocks: Arc::default(),
        }
    }
}

impl Motion for Emitters {
    fn apply(&self, scene: &mut Scene, seconds: f64) {
        scene.particles.truncate(self.first_particle);
        scene.strands.truncate(self.first_strand);
        scene.emissions.clear();
        let mut flocks = self.flocks.lock().unwrap_or_else(PoisonError::into_inner);
        let mut left_out = 0;
        flocks.resize_with(self.emitters.len(), Vec::new);
        for ((emitter, flocks), on_device) in
            self.emitters.iter().zip(flocks.iter_mut()).zip(&self.on_device)
        {
            if *on_device {
                scene.emissions.push(Emission::at(emitter, seconds));
            } else {
                flocks.resize_with(emitter.moments() as usize, Flock::default);
                let Scene { particles, strands, .. } = scene;
                let first = particles.len();
                left_out += emitter.send(&mut flocks[0], seconds, FARTHEST, particles);
                emitter.drag(&mut flocks[1..], seconds, FARTHEST, &particles[first..], strands);
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
        Some(Arc::new(Self { emitters, flocks: Arc::default(), ..self.clone() }))
    }

    fn moves_particles(&self) -> bool {
        true
    }

    fn reach(&self, wanted: &dyn Fn(u32) -> bool) -> Bounds {
        let steps = MAX_SAMPLED / 8 / self.emitters.len();
        let wanted = self.emitters.iter().filter(|emitter| {
            wanted(emitter.material) || emitter.trail.is_some_and(|trail| wanted(trail.material))
        });
        wanted.fold(Bounds::EMPTY, |all, emitter| all.with(&emitter.reach(FARTHEST, steps)))
    }

    fn first_particle(&self) -> Option<usize> {
        Some(self.first_particle)
    }

    fn most_particles(&self) -> u64 {
        let most = |emitter: &Arc<Emitter>| u64::from(emitter.forces.most_until(emitter.steps));
        self.emitters.iter().map(most).sum()
    }

    fn most_vertices(&self) -> u64 {
        self.emitters.iter().map(|emitter| emitter.most_vertices()).sum()
    }

    fn most_steps(&self) -> u64 {
        self.emitters.iter().map(|emitter| flown(emitter)).sum()
    }

    fn on_device(&self, most: u64) -> Option<(Arc<dyn Motion>, Vec<String>)> {
        let reason = |emitter: &Arc<Emitter>| {
            let count = emitter.forces.most_until(emitter.steps);
            if emitter.fluid.is_some() {
                Some("its particles are a fluid".to_owned())
            } else if emitter.trail.is_some() {
                Some("its particles have trails".to_owned())
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
        let moved = Self { on_device, flocks: Arc::default(), ..self.clone() };
        let named = |(i, reason)| format!("emitter {i} is simulated on the CPU: {reason}");
        let reasons = reasons.into_iter().enumerate().filter_map(|(i, reason)| Some((i, reason?)));
        Some((Arc::new(moved), reasons.map(named).collect()))
    }
}

/// Particle steps for a frame on its own: for one at time 0 or, without a fluid, at any time.
fn flown(emitter: &Emitter) -> u64 {
    let (most, longest) = (emitter.forces.most(), emitter.forces.longest());
    let moments = u64::from(emitter.moments());
    let Some(fluid) = &emitter.fluid else {
        return (u64::from(most) * u64::from(longest)).saturating_mul(moments);
    };
    // A fluid is simulated from its first step on. Each step visits a particle's neighbours twice, and there
    // may be twice as many as at rest.
    let past = (-emitter.start * STEPS_PER_SECOND).max(0.0);
    let pairs = 4.0 * f64::from(fluid.reach / fluid.spacing).powi(3);
    ((f64::from(most) * past.max(f64::from(longest)) * pairs.max(1.0)) as u64)
        .saturating_mul(moments)
}

impl Loader<'_> {
    /// Loads the emitters; their particles and trails follow all others.
    pub(super) fn emitters(&mut self, tables: &[Spanned<EmitterTable>]) -> Result<(), SceneError> {
        if tables.is_empty() {
            return Ok(());
        }
        let (mut have, mut have_vertices) = (self.scene.particles.len(), self.capsules());
        let (mut all_flown, mut bytes) = (0_u64, 0);
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
            let vertices = emitter.most_vertices() as usize;
            self.check_limit(Limit::Capsules, have_vertices, vertices, (&table.span(), "trail"))?;
            have_vertices += vertices;
            // A particle and its step, twice while it flies.
            let states = 2 * size_of::<(EmittedParticle, u32)>() * most as usize;
            bytes += states * emitter.moments() as usize + vertices * size_of::<StrandVertex>();
            self.next_id = self.next_id.wrapping_add(1 << 24);
            emitters.push(Arc::new(emitter));
        }
        let emitters = Emitters::new(&self.scene, emitters);
        self.ask_for(have - self.scene.particles.len(), bytes as u64)?;
        if self.makes_start {
            emitters.apply(&mut self.scene, 0.0);
            self.scene.motions.push(Arc::new(emitters));
        } else {
            let all = &emitters.emitters;
            let steps = MAX_SAMPLED / all.len();
            let sample = all.iter().flat_map(|emitter| emitter.sample(0.0, FARTHEST, steps));
            self.scene.particles.extend(sample);
            self.resting.push(Arc::new(emitters));
        }
        Ok(())
    }

    /// Requests memory for at most `most` live particles and for `bytes` of the emitters' own.
    fn ask_for(&mut self, most: usize, bytes: u64) -> Result<(), SceneError> {
        let path = self.source.path();
        limits::reserve(&mut self.scene.particles, most, "particles", path)?;
        if limits::has_memory(bytes) {
            return Ok(());
        }
        let message = format!("no memory for {most} particles of emitters ({} MiB)", bytes >> 20);
        Err(SceneError::memory(path, message))
    }

    fn emitter(&mut self, table: &Spanned<EmitterTable>) -> Result<Emitter, SceneError> {
        let EmitterTable { material: name, trail_material, emitter } = table.get_ref();
        let material = self.material_of_grains(&table.span(), name)?;
        let mut most = self.scene.materials[material as usize].transfer.max_color();
        let mut trail = emitter.trail;
        if let Some(trail) = &mut trail {
            let of_trail =
                self.strand_material(&table.span(), trail_material.as_ref().unwrap_or(name))?;
            most = most.min(of_trail.transfer.max_color());
            trail.material = self.add_material(of_trail, (&table.span(), "trail"))?;
        }
        let channels = emitter.color.iter().flat_map(Vec3::as_ref);
        if let Some(value) = channels.into_iter().find(|value| !(0.0..=most).contains(*value)) {
            let (message, help) =
                (format!("color is {value}"), format!("color must be 0 to {most}"));
            return Err(self.error(&table.span(), "color", &message, &help));
        }
        Ok(Emitter { material, trail, first_id: self.next_id, ..emitter.clone() })
    }
}

pub(super) fn table(keys: &Keys<'_>) -> Result<EmitterTable, SceneError> {
    let fluid = keys.one("fluid", fluid)?.map(Spanned::into_inner);
    let trail = keys.one("trail", trail)?.map(Spanned::into_inner);
    let (trail, trail_material) = trail.map_or((None, None), |(trail, name)| (Some(trail), name));
    let boxes = keys.many("boxes", solid_box)?;
    if boxes.len() > MAX_BOXES {
        let message = format!("{} boxes", boxes.len());
        return Err(keys.fault("boxes", message, &format!("at most {MAX_BOXES}")));
    }
    let material = keys.required("material")?;
    let stops = |key, usual: f32, range: RangeInclusive<f32>| -> Result<Vec<f32>, SceneError> {
        let values = keys.value(key, vec![usual])?;
        count_stops(keys, key, values.len())?;
        let words = format!("{} to {}", range.start(), range.end());
        keys.check(key, &values, range, &words)?;
        Ok(values)
    };
    let colors: Vec<Shades> = keys.value("color", vec![Shades([1.0; 3])])?;
    count_stops(keys, "color", colors.len())?;
    let start = keys.within("start", 0.0, -600.0..=1e6)?;
    let stop: Option<f32> = keys.given("stop")?;
    if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop > start)) {
        return Err(keys.fault("stop", format!("stop is {stop}"), "it ends after its start [s]"));
    }
    let lasts = stop.map_or(f64::from(u32::MAX), |stop| f64::from(stop - start) * STEPS_PER_SECOND);
    let emitter = Emitter {
        forces: forces(keys, boxes, start)?,
        fluid,
        material: 0,
        first_id: 0,
        start: f64::from(start),
        steps: lasts as u32,
        radius: stops("radius", 0.05, 1e-6..=1e5)?,
        color: colors.iter().map(|color| Vec3::from(color.0)).collect(),
        alpha: stops("alpha", 1.0, 0.0..=1.0)?,
        trail,
    };
    Ok(EmitterTable { material, trail_material, emitter })
}

/// Forces on the particles. `start`: of the emitter \[s\].
fn forces(
    keys: &Keys<'_>,
    boxes: Vec<Spanned<[Vec3; 2]>>,
    start: f32,
) -> Result<Forces, SceneError> {
    let vector = |key, usual: Vec3| Ok(keys.vector(key)?.unwrap_or(usual));
    let lifetime = match keys.required::<Numbers>("lifetime")?.values[..] {
        [one] => [one; 2],
        [least, most] if least <= most => [least, most],
        _ => {
            let help = "one number, or the shortest and the longest [s]";
            return Err(keys.fault("lifetime", "lifetime is no range", help));
        }
    };
    keys.check("lifetime", &lifetime, 0.02..=600.0, "0.02 to 600")?;
    let rate = keys.need("rate", keys.number("rate", 1e-3..=1e6, "0.001 to 1000000")?)?;
    let extent = vector("extent", Vec3::splat(0.2))?;
    if extent.min_element() < 0.0 {
        return Err(keys.fault("extent", "a negative extent", "use lengths of 0 or more [m]"));
    }
    let forces = Forces {
        seed: keys.value("seed", 0)?,
        rate: f64::from(rate),
        lifetime,
        shape: keys.value("shape", EmitterShape::default())?,
        position: vector("position", Vec3::ZERO)?,
        extent,
        velocity: vector("velocity", Vec3::Y)?,
        spread: keys.within("spread", 0.0, 0.0..=1e3)?,
        gravity: keys.within("gravity", 0.0, -1e3..=1e3)?,
        buoyancy: keys.within("buoyancy", 0.0, -1e3..=1e3)?,
        drag: keys.within("drag", 0.0, 0.0..=1e3)?,
        wind: vector("wind", Vec3::ZERO)?,
        turbulence: keys.within("turbulence", 0.0, 0.0..=1e3)?,
        frequency: keys.within("frequency", 1.0, 1e-3..=1e3)?,
        evolve: keys.within("evolve", 0.0, -1e3..=1e3)?,
        ground: keys.number("ground", -FARTHEST..=FARTHEST, "-10000000 to 10000000")?,
        boxes: boxes.into_iter().map(Spanned::into_inner).collect(),
        bounce: keys.within("bounce", 0.2, 0.0..=1.0)?,
        slide: keys.within("slide", 0.8, 0.0..=1.0)?,
        path: path(keys, start)?,
        origin: Vec3::ZERO,
    };
    if (forces.turbulence > 0.0 || forces.wind != Vec3::ZERO) && forces.drag == 0.0 {
        let key = if forces.turbulence > 0.0 { "turbulence" } else { "wind" };
        let help = "give it a drag, such as 1: that is how fast the air takes particles with it";
        return Err(keys.fault(key, "air that moves takes nothing with it", help));
    }
    Ok(forces)
}

/// A trail, and the name of its own material.
fn trail(keys: &Keys<'_>) -> Result<(Trail, Option<String>), SceneError> {
    let seconds = keys.number("seconds", 0.02..=60.0, "0.02 to 60 s")?;
    let trail = Trail {
        seconds: keys.need("seconds", seconds)?,
        segments: keys.whole("segments", 8, 1..=64, "1 to 64 capsules a trail")?,
        material: 0,
    };
    Ok((trail, keys.given("material")?))
}

fn fluid(keys: &Keys<'_>) -> Result<Fluid, SceneError> {
    let spacing = keys.need("spacing", keys.number("spacing", 1e-3..=1e3, "0.001 to 1000")?)?;
    let reach = keys.within("reach", 2.0 * spacing, spacing..=4.0 * spacing)?;
    // Limits that keep steps of 1/60 s stable: sound travels a fraction of the reach, and drag at most halves
    // the velocity difference of two particles.
    let (fastest, thickest) = ((24.0 * reach).powi(2), 2.0 * reach * reach);
    Ok(Fluid {
        spacing,
        reach,
        stiffness: keys.within("stiffness", fastest / 4.0, 0.0..=fastest)?,
        viscosity: keys.within("viscosity", thickest / 10.0, 0.0..=thickest)?,
    })
}

fn solid_box(keys: &Keys<'_>) -> Result<[Vec3; 2], SceneError> {
    let corner = |key| keys.need(key, keys.vector(key)?);
    let (low, high) = (corner("min")?, corner("max")?);
    if low.cmplt(high).all() {
        return Ok([low, high]);
    }
    Err(keys.fault("min", "min is not below max", "write the lower corner as min"))
}

/// Rows of seconds and an offset x, y, z, relative to the emitter's start.
fn path(keys: &Keys<'_>, start: f32) -> Result<Vec<[f32; 4]>, SceneError> {
    let mut rows: Vec<[f32; 4]> = Vec::new();
    for Numbers { values, .. } in keys.value("path", Vec::<Numbers>::new())? {
        let [seconds, x, y, z] = values[..] else {
            let message = format!("a row of {} numbers", values.len());
            return Err(keys.fault("path", message, "each row is [seconds, x, y, z]"));
        };
        keys.check("path", &[x, y, z], -1e7..=1e7, "finite and within 1e7")?;
        let ascends = rows.last().is_none_or(|last| last[0] < seconds - start);
        if !seconds.is_finite() || !ascends {
            let help = "write its rows in order, each time once [s]";
            return Err(keys.fault("path", "times that do not ascend", help));
        }
        rows.push([seconds - start, x, y, z]);
    }
    Ok(rows)
}

fn count_stops(keys: &Keys<'_>, key: &str, count: usize) -> Result<(), SceneError> {
    if (1..=MAX_STOPS).contains(&count) {
        return Ok(());
    }
    let help = format!("1 to {MAX_STOPS}, evenly spaced over a particle's life");
    Err(keys.fault(key, format!("{count} values of {key}"), &help))
}
