//! Emitters that the device simulates: their particles become casters without passing through the CPU.
use super::engine::GpuEngine;
use gobo::{
    Error,
    gpu::Memory,
    model::{
        Scene,
        emission::{Emission, Emitter},
    },
    records::{HostGroup, LoadCounters},
    shadows::{EmittedSlots, Simulation},
};
use std::sync::Arc;

/// Emitters of a scene, and the particles that were loaded.
#[derive(Debug, Default)]
pub(super) struct DeviceEmitters {
    flying: Vec<(Arc<Emitter>, Simulation)>,
    /// Emissions whose particles are among the casters, and the set of these particles.
    loaded: Vec<Emission>,
    set: Option<u64>,
    pub(super) slots: Vec<EmittedSlots>,
    /// Particles that were not loaded: they are too far away.
    pub(super) left_out: u64,
    pub(super) memory: Memory,
}

impl GpuEngine {
    /// Simulates the scene's emitters up to its time, and loads their particles. Called before views are
    /// fitted: waits for the box around each 256 particles.
    pub(super) fn emit(&mut self, scene: &Scene) -> Result<(), Error> {
        if scene.emissions.is_empty() {
            self.emitters = DeviceEmitters::default();
            return Ok(());
        }
        let slots: Vec<_> = scene.emissions.iter().map(EmittedSlots::of).collect();
        let set = self.shadows.upload_emitted(&scene.casters(), &slots)?;
        self.emitters.slots = slots;
        let loaded = &self.emitters.loaded;
        let is_loaded = self.emitters.set == Some(set)
            && loaded.len() == scene.emissions.len()
            && loaded.iter().zip(&scene.emissions).all(|(a, b)| a.is(b));
        if is_loaded {
            for (emission, loaded) in scene.emissions.iter().zip(loaded) {
                emission.set_bounds(loaded.bounds());
            }
            return Ok(());
        }
        self.fly(scene)?;
        let flying = self.emitters.flying.iter().map(|(_, simulation)| simulation);
        let all: Vec<_> = scene.emissions.iter().zip(flying).collect();
        let load = self.shadows.bind_emitted(&all)?;
        self.work.submit(&self.gpu, |encoder, timeline| {
            load.commands.record(encoder, timeline);
        });
        let read: Vec<HostGroup> = self.gpu.try_read(&load.groups)?;
        let (counters, found) = LoadCounters::split(&read);
        self.emitters.left_out = counters.skipped.into();
        let found =
            &found[..self.emitters.slots.iter().map(|slot| slot.group_count as usize).sum()];
        self.shadows.place_emitted(found)?;
        for (emission, bounds) in scene.emissions.iter().zip(load.bounds(found)) {
            emission.set_bounds(bounds);
        }
        let mut memory = load.memory.clone();
        for (_, simulation) in &self.emitters.flying {
            memory.add_all(simulation.memory());
        }
        self.emitters.memory = memory;
        self.emitters.loaded.clone_from(&scene.emissions);
        self.emitters.set = Some(set);
        Ok(())
    }

    /// Advances each emitter to its step. For an earlier step, or one so much later that no particle is still
    /// alive, it starts again where the oldest particle that may be alive starts: the result is the same.
    fn fly(&mut self, scene: &Scene) -> Result<(), Error> {
        let Self { gpu, shadows, work, emitters, .. } = self;
        let same = emitters.flying.iter().map(|(emitter, _)| emitter);
        if !same.eq(scene.emissions.iter().map(|emission| &emission.emitter)) {
            emitters.flying.clear();
            for Emission { emitter, .. } in &scene.emissions {
                let simulation = shadows.simulation_until(&emitter.forces, emitter.steps)?;
                emitters.flying.push((Arc::clone(emitter), simulation));
            }
        }
        for ((emitter, simulation), emission) in emitters.flying.iter_mut().zip(&scene.emissions) {
            let oldest = emission.step.saturating_sub(emitter.forces.longest());
            let restarts = emission.step < simulation.step() || oldest > simulation.step();
            let mut from = restarts.then_some(oldest);
            while from.is_some() || simulation.step() < emission.step {
                work.submit(gpu, |encoder, timeline| {
                    if let Some(step) = from.take() {
                        simulation.restart(encoder, step);
                    }
                    let left = emission.step - simulation.step();
                    simulation.record_timed(encoder, timeline, left);
                });
            }
        }
        Ok(())
    }
}
