//! Emitters with the looks of their particles, and their state at a moment.
use super::{
    Bounds, Particle, Strand, StrandVertex,
    emitter::{EmittedParticle, Flock, Forces, STEP, STEPS_PER_SECOND},
    fluid::Fluid,
    hash::pcg,
};
use glam::Vec3;
use std::{
    ops::Range,
    sync::{Arc, OnceLock},
};

/// Most values of a look over a particle's life.
pub const MAX_STOPS: usize = 16;

/// An emitter of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// Region where its particles start, and the forces on them.
    pub forces: Forces,
    /// Interaction of its particles; `None` without.
    pub fluid: Option<Fluid>,
    /// Index into [`crate::model::Scene::materials`].
    pub material: u32,
    /// Caster id of its first particle.
    pub first_id: u32,
    /// Time of its first particle \[s\].
    pub start: f64,
    /// Duration of the emission \[steps\].
    pub steps: u32,
    /// Radii over a particle's life, evenly spaced, 1 to [`MAX_STOPS`] of them \[m\].
    pub radius: Vec<f32>,
    /// Colours, spaced in the same way: linear rgb.
    pub color: Vec<Vec3>,
    /// Alphas, spaced in the same way.
    pub alpha: Vec<f32>,
    /// Trail that each particle drags; `None` without.
    pub trail: Option<Trail>,
}

/// A strand through the last places of a particle, with its looks there, tapering to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trail {
    /// Age of its end \[s\].
    pub seconds: f32,
    /// Number of its capsules, of equal times.
    pub segments: u32,
    /// Index into [`crate::model::Scene::materials`], of a material whose shape is [`super::Shape::Capsule`].
    pub material: u32,
}

impl Emitter {
    /// Time steps that have passed, and the passed share of the next one.
    fn moment(&self, seconds: f64) -> (u32, f32) {
        // A frame at the time of a step is at that step in spite of rounding.
        let steps = ((seconds - self.start) * STEPS_PER_SECOND + 1e-6).max(0.0);
        let step = steps as u32;
        (step, (steps - f64::from(step)) as f32)
    }

    /// Adds the live particles that are at most `farthest` from the origin along each axis \[m\]. Returns the
    /// number of the others.
    pub fn send(
        &self,
        flock: &mut Flock,
        seconds: f64,
        farthest: f32,
        particles: &mut Vec<Particle>,
    ) -> u64 {
        let (step, part) = self.moment(seconds);
        match &self.fluid {
            Some(fluid) => flock.advance_fluid_to(&self.forces, fluid, step, self.steps),
            None => flock.advance_to(&self.forces, step, self.steps),
        }
        let mut left_out = 0;
        for particle in flock.emitted().iter().filter_map(|emitted| self.particle(emitted, part)) {
            if is_within(&particle, farthest) {
                particles.push(particle);
            } else {
                left_out += 1;
            }
        }
        left_out
    }

    /// Moments of each particle that a frame needs: the present one, and those of its trail.
    pub fn moments(&self) -> u32 {
        1 + self.trail.map_or(0, |trail| trail.segments)
    }

    /// Most vertices of its trails: one per moment, and one where the particle started.
    pub fn most_vertices(&self) -> u64 {
        let most = u64::from(self.forces.most_until(self.steps));
        self.trail.map_or(0, |trail| most * u64::from(trail.segments + 2))
    }

    /// Adds the trails of the particles `now`. `past`: a flock for each moment of the trail.
    pub fn drag(
        &self,
        past: &mut [Flock],
        seconds: f64,
        farthest: f32,
        now: &[Particle],
        strands: &mut Vec<Strand>,
    ) {
        let Some(trail) = self.trail else { return };
        let whole = f64::from(trail.seconds);
        let vertex = |particle: &Particle, ago: f64| StrandVertex {
            position: particle.center,
            radius: particle.radius * (1.0 - ago / whole) as f32,
            color: particle.color,
        };
        let number = |id: u32| id.wrapping_sub(self.first_id);
        let begun = |particle: &Particle| Strand {
            vertices: vec![vertex(particle, 0.0)],
            material: trail.material,
            id: particle.id,
        };
        let mut dragged: Vec<Strand> = now.iter().map(begun).collect();
        let mut then = Vec::new();
        for (i, flock) in (1..).zip(past) {
            let ago = whole * f64::from(i) / f64::from(trail.segments);
            then.clear();
            self.send(flock, seconds - ago, farthest, &mut then);
            for strand in &mut dragged {
                let found = then.binary_search_by_key(&number(strand.id), |p| number(p.id));
                strand.vertices.extend(found.ok().map(|at| vertex(&then[at], ago)));
            }
        }
        for strand in &mut dragged {
            let number = number(strand.id);
            let started = f64::from(self.forces.starts_in(number)) / STEPS_PER_SECOND;
            let ago = seconds - self.start - started;
            if ago < whole {
                let first = self.particle(&self.forces.start(number), 0.0);
                strand.vertices.extend(first.map(|first| vertex(&first, ago)));
            }
        }
        // The trail of a particle at rest is a point.
        dragged.retain(|strand| strand.problem(f32::INFINITY).is_none());
        strands.append(&mut dragged);
    }

    /// A few of the live particles, evenly chosen, simulated without a fluid: enough to see how far they
    /// reach. `most_steps`: bound of their steps together.
    pub fn sample(&self, seconds: f64, farthest: f32, most_steps: usize) -> Vec<Particle> {
        const MAX: usize = 1000;
        let most = MAX.min(most_steps / self.forces.longest() as usize);
        let (step, part) = self.moment(seconds);
        let numbers = self.numbers(step);
        let every = numbers.len().div_ceil(most.max(1)).max(1);
        let flown = |number| {
            let mut emitted = self.forces.start(number);
            for step in self.forces.starts_in(number)..step {
                if emitted.age >= emitted.life {
                    return None;
                }
                self.forces.advance(&mut emitted, step);
            }
            self.particle(&emitted, part).filter(|particle| is_within(particle, farthest))
        };
        numbers.step_by(every).take(most).filter_map(flown).collect()
    }

    /// Box around the places of a few particles over all time \[m\], evenly chosen from those that start on
    /// the emitter's path, or within one lifetime of its end, simulated without a fluid. `most_steps`: bound
    /// of their steps together.
    pub fn reach(&self, farthest: f32, most_steps: usize) -> Bounds {
        const MAX: usize = 512;
        let longest = self.forces.longest();
        let most = MAX.min(most_steps / longest as usize).max(1);
        let way = self.forces.path.last().map_or(0.0, |row| f64::from(row[0].max(0.0)));
        let way = (way * STEPS_PER_SECOND) as u32;
        let last = self.steps.min(way.saturating_add(longest));
        let numbers = 0..self.forces.started_before(last.max(1));
        let every = numbers.len().div_ceil(most).max(1);
        let radius = self.radius.iter().copied().fold(0.0, f32::max);
        let mut all = Bounds::EMPTY;
        for number in numbers.step_by(every) {
            let mut emitted = self.forces.start(number);
            let first = self.forces.starts_in(number);
            for step in first..first.saturating_add(emitted.life) {
                if emitted.position.is_finite() && emitted.position.abs().max_element() <= farthest
                {
                    all = all.with_sphere(emitted.position, radius);
                }
                self.forces.advance(&mut emitted, step);
            }
        }
        all
    }

    /// Numbers of the particles that may be alive at a step.
    fn numbers(&self, step: u32) -> Range<u32> {
        let before = |step: u32| self.forces.started_before(step.min(self.steps));
        before(step.saturating_sub(self.forces.longest()))..before(step)
    }

    /// The particle at share `part` of the step after its last whole one, if it is visible.
    fn particle(&self, emitted: &EmittedParticle, part: f32) -> Option<Particle> {
        let share = ((emitted.age as f32 + part) / emitted.life as f32).min(1.0);
        let alpha = mixed(&self.alpha, share, |a, b, t| a + (b - a) * t);
        let center = emitted.position + emitted.velocity * (part * STEP);
        let turn = (pcg(emitted.number ^ self.forces.seed) >> 8) as f32 / (1 << 24) as f32;
        (alpha > 0.0).then(|| Particle {
            center,
            radius: mixed(&self.radius, share, |a, b, t| a + (b - a) * t),
            color: mixed(&self.color, share, Vec3::lerp).extend(alpha),
            rotation: turn * std::f32::consts::TAU,
            material: self.material,
            id: self.first_id.wrapping_add(emitted.number),
        })
    }
}

/// Whether its position is finite, and at most `farthest` from the origin along each axis \[m\].
fn is_within(particle: &Particle, farthest: f32) -> bool {
    particle.center.is_finite() && particle.center.abs().max_element() <= farthest
}

/// Linear interpolation between evenly spaced values.
fn mixed<T: Copy>(values: &[T], share: f32, mix: impl Fn(T, T, f32) -> T) -> T {
    let at = share * (values.len() - 1) as f32;
    let low = (at as usize).min(values.len() - 1);
    let high = (low + 1).min(values.len() - 1);
    mix(values[low], values[high], at - low as f32)
}

/// State of an emitter at a moment, for a device to simulate.
#[derive(Clone, Debug)]
pub struct Emission {
    /// The emitter.
    pub emitter: Arc<Emitter>,
    /// Time steps that have passed.
    pub step: u32,
    /// Share of the next step that has passed.
    pub part: f32,
    /// Box around the particles, once a device has simulated them.
    bounds: OnceLock<Bounds>,
}

impl Emission {
    /// The emission at a time of the scene \[s\].
    pub fn at(emitter: &Arc<Emitter>, seconds: f64) -> Self {
        let (step, part) = emitter.moment(seconds);
        Self { emitter: Arc::clone(emitter), step, part, bounds: OnceLock::new() }
    }

    /// Whether both hold the same particles at the same moment.
    pub fn is(&self, other: &Self) -> bool {
        (self.step, self.part) == (other.step, other.part) && self.emitter == other.emitter
    }

    /// Numbers of the particles that may be alive.
    pub fn numbers(&self) -> Range<u32> {
        self.emitter.numbers(self.step)
    }

    /// Box around the particles \[m\]; empty until a device has simulated them.
    pub fn bounds(&self) -> Bounds {
        self.bounds.get().copied().unwrap_or(Bounds::EMPTY)
    }

    /// Sets [`Self::bounds`], once.
    pub fn set_bounds(&self, bounds: Bounds) {
        let _ = self.bounds.set(bounds);
    }
}
