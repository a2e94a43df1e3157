//! Particles of emitters, loaded beside the uploaded casters. For each 256 of them the CPU learns their box,
//! number and least alpha, so that it lists and culls them like uploaded ones.
use super::{EmittedSlots, HostInputs, Shadows, Simulation};
use crate::{
    error::Error,
    frame::Commands,
    gpu::{Allocator, Memory, Resources},
    model::{Bounds, Casters, emission::Emission},
    records::{EmissionParams, HostGroup, LoadParams, MAX_MATERIALS},
    stage::{project::grid, simulate},
};
use wgpu::{Buffer, BufferUsages};

/// Load of the particles of all emitters.
#[derive(Debug)]
pub struct EmittedLoad {
    pub commands: Commands,
    /// Number of groups of each emitter.
    group_counts: Vec<u32>,
    /// `LoadCounters` for the visible particles: the number loaded, and the number too far away; then the
    /// [`HostGroup`]s of all emitters, one after the other.
    pub groups: Buffer,
    pub memory: Memory,
}

impl EmittedLoad {
    /// Box around the particles of each emitter. `found`: the groups.
    pub fn bounds<'a>(&'a self, found: &'a [HostGroup]) -> impl Iterator<Item = Bounds> + 'a {
        let mut found = found.iter();
        self.group_counts.iter().map(move |&group_count| {
            let groups = found.by_ref().take(group_count as usize).filter(|group| group.count > 0);
            groups.fold(Bounds::EMPTY, |all, group| {
                all.with(&Bounds { min: group.low, max: group.high })
            })
        })
    }
}

impl Shadows {
    /// Makes room for emitted particles beside `casters`, whose textures get all their levels, since pictures
    /// have emitters. Returns the identity of the set: another set has not loaded them.
    pub fn upload_emitted(
        &mut self,
        casters: &Casters<'_>,
        slots: &[EmittedSlots],
    ) -> Result<u64, Error> {
        self.upload(casters, &HostInputs::new().emitted(slots).image_levels())
    }

    /// Binds the kernels that load those emitters that have room.
    pub fn bind_emitted(&self, emitted: &[(&Emission, &Simulation)]) -> Result<EmittedLoad, Error> {
        let kernel = self.kernel_of(&simulate::CASTERS)?;
        let ((device, _), set) = (self.device(), self.casters()?);
        let mut memory = Memory::default();
        let mut allocator = Allocator::new(device, &mut memory);
        let slots: Vec<_> =
            emitted.iter().map(|(emission, _)| EmittedSlots::of(emission)).collect();
        let total: u32 = slots.iter().map(|emitter| emitter.group_count).sum();
        let copied = BufferUsages::COPY_SRC;
        let groups =
            allocator.storage::<HostGroup>("emitted_groups", u64::from(total) + 1, copied)?;
        // Bound because the kernel has it: nobody reads it.
        let no_counts = allocator.storage::<u32>("host_counts", 1, BufferUsages::empty())?;
        let mut dispatches = Vec::with_capacity(emitted.len());
        let mut first_group = 0;
        let (written, first_record) = set.casters.written();
        let runs = emitted.iter().zip(&slots).zip(set.emitted_records());
        for (((emission, simulation), emitter), records) in runs {
            let mut materials = [[0; 4]; MAX_MATERIALS / 128];
            let word = emitter.material as usize / 32;
            materials[word / 4][word % 4] = 1 << (emitter.material % 32);
            let params = LoadParams {
                capacity: emission.numbers().len() as u32,
                group_count: emitter.group_count,
                first_group,
                first_caster: records.start - first_record,
                first_record,
                quad_reach: 1.0,
                may_be_none: 1,
                materials,
                ..LoadParams::default()
            };
            let load_params = allocator.uniform("load_params", &params);
            let params = EmissionParams::new(emission, simulation.capacity());
            let emission_params = allocator.uniform("emission_params", &params);
            let resources = Resources::new()
                .with_any("casters", written)
                .with("materials", &set.materials)
                .with("load_params", &load_params)
                .with("emission_params", &emission_params)
                .with("emitted", simulation.particles())
                .with("host_counts", &no_counts)
                .with("host_groups", &groups);
            let groups = grid(emitter.group_count);
            dispatches.push(self.kernels().dispatch_of(kernel.clone(), &resources, groups)?);
            first_group += emitter.group_count;
        }
        let loaded = slots.iter().take(dispatches.len());
        let group_counts: Vec<_> = loaded.map(|slots| slots.group_count).collect();
        let mut commands = Commands::new();
        commands.pass("gobo load", dispatches);
        let mut records = set.emitted_records().take(group_counts.len());
        if let Some(first) = records.next() {
            let end = records.last().map_or(first.end, |last| last.end);
            set.casters.copy(&mut commands, "gobo load", &(first.start..end));
        }
        Ok(EmittedLoad { commands, group_counts, groups, memory })
    }

    /// Takes over the groups of an `EmittedLoad`.
    pub fn place_emitted(&mut self, found: &[HostGroup]) -> Result<(), Error> {
        self.casters_mut()?.place_emitted(found);
        Ok(())
    }
}
