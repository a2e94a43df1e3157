//! Particle emitters, simulated in fixed time steps. The state of a particle depends on its number and age
//! alone, so a frame is the same whichever frame was made before it.
//!
//! Random numbers are integer hashes (Jarzynski and Olano 2020, `pcg`); a step uses only sums, products,
//! divisions and square roots. The CPU reference of `wgsl/simulate/simulate.wgsl`.
use super::{fluid::Fluid, hash::pcg};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

mod check;
mod curl_noise;

pub use curl_noise::curl_noise;

/// Time step \[s\].
pub const STEP: f32 = 1.0 / 60.0;
/// Longest life, in 16 bits \[steps\].
pub const LONGEST: u32 = 65_535;
/// Time steps per second.
pub const STEPS_PER_SECOND: f64 = 60.0;
/// Most collision boxes of an emitter.
pub const MAX_BOXES: usize = 8;

/// Region where particles start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum EmitterShape {
    #[default]
    /// The emitter's position.
    Point,
    /// A box of the emitter's extent.
    Box,
    /// The ellipsoid in that extent.
    Sphere,
    /// The ellipse of that extent's x and z.
    Disc,
}

/// Parameters of an emitter and the forces on its particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Forces {
    /// Seed of every random number of the emitter. Default 0.
    pub seed: u32,
    /// Particles emitted per second, 0.001..=1e6 [1/s]. Default 100.
    pub rate: f64,
    /// Shortest and longest lifetime, 0.02..=600 \[s\]. Default 1.
    pub lifetime: [f32; 2],
    /// Region where particles start. Default a point.
    pub shape: EmitterShape,
    /// Position of the emitter, this and all other vectors within 1e7 of 0 \[m\]. Default the origin.
    pub position: Vec3,
    /// Full size of the region, 0 or more \[m\]. Default 0.2.
    pub extent: Vec3,
    /// Mean initial velocity \[m/s\]. Default 1 upward.
    pub velocity: Vec3,
    /// Largest deviation of a particle's initial velocity, 0..=1000 \[m/s\]. Default 0.
    pub spread: f32,
    /// Downward acceleration, -1000..=1000 [m/s^2]. Default 0.
    pub gravity: f32,
    /// Upward acceleration at birth, -1000..=1000; it falls to 0 at the end of a particle's life [m/s^2].
    /// Default 0.
    pub buoyancy: f32,
    /// Rate at which a particle's velocity approaches that of the air, 0..=1000 [1/s]. Default 0: the air
    /// moves nothing.
    pub drag: f32,
    /// Velocity of the air \[m/s\]. Default 0.
    pub wind: Vec3,
    /// Speed of the air's turbulence (curl noise), 0..=1000 \[m/s\]. Default 0.
    pub turbulence: f32,
    /// Spatial frequency of the turbulence, 0.001..=1000 [1/m]. Default 1.
    pub frequency: f32,
    /// Speed at which the turbulence rises through the air, -1000..=1000 \[m/s\]. Default 0.
    pub evolve: f32,
    /// Height of a ground plane that particles collide with \[m\]. Default none.
    pub ground: Option<f32>,
    /// Lower and upper corners of the boxes that particles collide with, at most [`MAX_BOXES`] \[m\]. Default
    /// none.
    pub boxes: Vec<[Vec3; 2]>,
    /// Restitution: share of the normal velocity that a particle keeps in a collision, 0..=1. Default 0.2.
    pub bounce: f32,
    /// Share of the tangential velocity that a particle keeps in a collision, 0..=1. Default 0.8.
    pub slide: f32,
    /// Path of the emitter: rows of seconds from its start, ascending, and an offset x, y, z from `position`
    /// \[m\]. Linear between rows, constant before the first and after the last. Default none.
    pub path: Vec<[f32; 4]>,
    /// World position of the scene's origin, so that the turbulence stays in place \[m\]. Default the origin.
    pub origin: Vec3,
}

/// A live particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmittedParticle {
    /// Index among the particles of its emitter.
    pub number: u32,
    /// Position \[m\].
    pub position: Vec3,
    /// Velocity \[m/s\].
    pub velocity: Vec3,
    /// Age \[steps\].
    pub age: u32,
    /// Lifetime \[steps\].
    pub life: u32,
}

/// Random number `index` of particle `number`, 0..1.
fn draw(seed: u32, number: u32, index: u32) -> f32 {
    (pcg(number ^ pcg(index ^ pcg(seed))) >> 8) as f32 / (1 << 24) as f32
}

/// Random points in a cube that are tried for one in the ball.
pub const TRIES: u32 = 8;

/// A random point in the unit ball, or in its section where `axes` has zeros: the first of several points
/// in the cube that is inside.
fn in_ball(seed: u32, number: u32, index: u32, axes: Vec3) -> Vec3 {
    for i in 0..TRIES {
        let axis = |k: u32| draw(seed, number, index + 3 * i + k) * 2.0 - 1.0;
        let place = Vec3::new(axis(0), axis(1), axis(2)) * axes;
        if place.length_squared() <= 1.0 {
            return place;
        }
    }
    Vec3::ZERO
}

impl Forces {
    /// Particle `number` as it starts.
    pub fn start(&self, number: u32) -> EmittedParticle {
        let axis = |k: u32| draw(self.seed, number, k) - 0.5;
        let aside = match self.shape {
            EmitterShape::Point => Vec3::ZERO,
            EmitterShape::Box => Vec3::new(axis(1), axis(2), axis(3)),
            EmitterShape::Sphere => in_ball(self.seed, number, 8, Vec3::ONE) * 0.5,
            EmitterShape::Disc => in_ball(self.seed, number, 8, Vec3::new(1.0, 0.0, 1.0)) * 0.5,
        };
        let [least, most] = self.lifetime;
        let life = least + (most - least) * draw(self.seed, number, 0);
        EmittedParticle {
            number,
            position: self.position
                + self.gone(f64::from(number) / self.rate)
                + aside * self.extent,
            velocity: self.velocity + in_ball(self.seed, number, 40, Vec3::ONE) * self.spread,
            age: 0,
            life: ((life * STEPS_PER_SECOND as f32) as u32).clamp(1, LONGEST),
        }
    }

    /// Offset of the emitter along its path at a time \[s\].
    fn gone(&self, seconds: f64) -> Vec3 {
        let place = |row: &[f32; 4]| Vec3::new(row[1], row[2], row[3]);
        let after = self.path.partition_point(|row| f64::from(row[0]) <= seconds);
        match (after.checked_sub(1).map(|i| &self.path[i]), self.path.get(after)) {
            (Some(a), Some(b)) => {
                let share = (seconds - f64::from(a[0])) / f64::from(b[0] - a[0]);
                place(a).lerp(place(b), share as f32)
            }
            (Some(end), None) | (None, Some(end)) => place(end),
            (None, None) => Vec3::ZERO,
        }
    }

    /// The path from one time to another \[s from the start\]: rows of seconds since the first, and the
    /// offset.
    pub fn path_between(&self, begin: f64, end: f64) -> Vec<Vec4> {
        if self.path.is_empty() {
            return vec![Vec4::ZERO];
        }
        let row = |seconds: f64, place: Vec3| {
            Vec4::new((seconds - begin) as f32, place.x, place.y, place.z)
        };
        let inside = self.path.iter().filter(|row| {
            let seconds = f64::from(row[0]);
            seconds > begin && seconds < end
        });
        let inside = inside.map(|&[s, x, y, z]| row(f64::from(s), Vec3::new(x, y, z)));
        let ends = [begin, end].map(|seconds| row(seconds, self.gone(seconds)));
        [ends[0]].into_iter().chain(inside).chain([ends[1]]).collect()
    }

    /// Time step in which particle `number` starts; particle 0 starts in step 0.
    pub fn starts_in(&self, number: u32) -> u32 {
        (f64::from(number) / self.rate * STEPS_PER_SECOND) as u32
    }

    /// Particles that have started before the end of step `step`.
    pub fn started(&self, step: u32) -> u32 {
        /// Bound of the particles that an emitter starts.
        const MAX: u32 = 1 << 31;
        let guess = (f64::from(step) + 1.0) / STEPS_PER_SECOND * self.rate;
        if guess >= f64::from(MAX) {
            return MAX;
        }
        if guess.is_nan() || guess <= 0.0 {
            return 0;
        }
        // Corrects the rounding of the guess.
        let mut count = guess as u32;
        while self.starts_in(count) <= step {
            count += 1;
        }
        while count > 0 && self.starts_in(count - 1) > step {
            count -= 1;
        }
        count
    }

    /// Longest life \[steps\].
    pub fn longest(&self) -> u32 {
        steps_of(self.lifetime[1])
    }

    /// Advances a particle by one time step, number `step`.
    pub fn advance(&self, emitted: &mut EmittedParticle, step: u32) {
        let share = emitted.age as f32 / emitted.life as f32;
        let lift = self.buoyancy * (1.0 - share) - self.gravity;
        let mut air = self.wind;
        if self.turbulence > 0.0 {
            let rise = Vec3::Y * (self.evolve * STEP * step as f32);
            air += curl_noise((emitted.position + self.origin - rise) * self.frequency, self.seed)
                * self.turbulence;
        }
        // Implicit drag: it never overshoots.
        let pushed = emitted.velocity + (Vec3::Y * lift + air * self.drag) * STEP;
        emitted.velocity = pushed / (1.0 + self.drag * STEP);
        emitted.position += emitted.velocity * STEP;
        emitted.age += 1;
        if let Some(ground) = self.ground
            && emitted.position.y < ground
        {
            emitted.position.y = ground;
            self.collide(emitted, Vec3::Y);
        }
        for corners in &self.boxes {
            if let Some((place, out)) = pushed_out(emitted.position, corners) {
                emitted.position = place;
                self.collide(emitted, out);
            }
        }
    }

    /// Collides with a surface of normal `out`.
    fn collide(&self, emitted: &mut EmittedParticle, out: Vec3) {
        let into = emitted.velocity.dot(out);
        if into < 0.0 {
            let along = emitted.velocity - out * into;
            emitted.velocity = along * self.slide - out * (into * self.bounce);
        }
    }
}

/// The point moved out through the nearest side of the box, and that side's normal; `None` outside the box.
fn pushed_out(place: Vec3, &[min, max]: &[Vec3; 2]) -> Option<(Vec3, Vec3)> {
    if !(place.cmpgt(min).all() && place.cmplt(max).all()) {
        return None;
    }
    let mut nearest = (f32::INFINITY, Vec3::ZERO, place);
    for axis in 0..3 {
        for (side, sign) in [(min[axis], -1.0), (max[axis], 1.0)] {
            let distance = (side - place[axis]) * sign;
            if distance < nearest.0 {
                let (mut out, mut at) = (Vec3::ZERO, place);
                (out[axis], at[axis]) = (sign, side);
                nearest = (distance, out, at);
            }
        }
    }
    Some((nearest.2, nearest.1))
}

/// Live particles of one emitter, oldest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flock {
    /// Time steps that have passed.
    step: u32,
    emitted: Vec<EmittedParticle>,
}

impl Flock {
    /// Live particles in the order of their numbers.
    pub fn emitted(&self) -> &[EmittedParticle] {
        &self.emitted
    }

    /// Advances to time step `step` from the present one, with the same result as from step 0. No particle
    /// starts after step `last`.
    pub fn advance_to(&mut self, forces: &Forces, step: u32, last: u32) {
        if step < self.step {
            *self = Self::default();
        }
        if step == 0 {
            return;
        }
        let longest = forces.longest();
        let first = forces.started_before(self.step.min(last));
        // Particles that start and end in between are never seen.
        let oldest = forces.started_before(step.saturating_sub(longest).min(last));
        let end = forces.started_before(step.min(last));
        let older = self.emitted.iter().copied().map(|emitted| (emitted, self.step));
        let newer = (first.max(oldest)..end).map(|n| (forces.start(n), forces.starts_in(n)));
        let mut all: Vec<(EmittedParticle, u32)> = older.chain(newer).collect();
        let fly = |(emitted, from): &mut (EmittedParticle, u32)| {
            for step in *from..step {
                if emitted.age >= emitted.life {
                    break;
                }
                forces.advance(emitted, step);
            }
        };
        all.par_iter_mut().with_min_len(1024).for_each(fly);
        self.emitted = all.into_iter().map(|(f, _)| f).filter(|f| f.age < f.life).collect();
        self.step = step;
    }

    /// [`Self::advance_to`] for a fluid: all particles advance together, step by step from the first on.
    pub fn advance_fluid_to(&mut self, forces: &Forces, fluid: &Fluid, step: u32, last: u32) {
        if step < self.step {
            *self = Self::default();
        }
        while self.step < step {
            let started = |step: u32| forces.started_before(step.min(last));
            let new = started(self.step)..started(self.step + 1);
            self.emitted.extend(new.map(|number| forces.start(number)));
            let pushes = fluid.accelerations(&self.emitted);
            for (emitted, push) in self.emitted.iter_mut().zip(pushes) {
                emitted.velocity += push * STEP;
                forces.advance(emitted, self.step);
            }
            self.emitted.retain(|emitted| emitted.age < emitted.life);
            self.step += 1;
        }
    }
}

/// A life \[s\] in steps.
fn steps_of(life: f32) -> u32 {
    ((life * STEPS_PER_SECOND as f32) as u32).clamp(1, LONGEST)
}

/// Largest number of particles alive at once, if `rate` start per second and live at most `longest_life`
/// \[s\].
pub fn most_alive(rate: f64, longest_life: f32) -> u32 {
    // Particles that start within the longest life and one more step.
    let seconds = f64::from(steps_of(longest_life) + 1) / STEPS_PER_SECOND;
    (rate * seconds).ceil() as u32 + 1
}

impl Forces {
    /// Largest number of particles that are alive at once.
    pub fn most(&self) -> u32 {
        most_alive(self.rate, self.lifetime[1])
    }

    /// Like [`Self::most`], if no particle starts from step `last` on.
    pub fn most_until(&self, last: u32) -> u32 {
        self.most().min(self.started_before(last))
    }

    /// The emitter in a scene that is translated \[m\].
    #[must_use]
    pub fn moved(&self, by: Vec3) -> Self {
        Self {
            position: self.position + by,
            ground: self.ground.map(|ground| ground + by.y),
            boxes: self.boxes.iter().map(|corners| corners.map(|corner| corner + by)).collect(),
            origin: self.origin - by,
            ..self.clone()
        }
    }

    /// Particles that have started before step `step`.
    pub fn started_before(&self, step: u32) -> u32 {
        step.checked_sub(1).map_or(0, |last| self.started(last))
    }
}
