//! Casters in the host's buffers: their sets, and the conversion to records.
use crate::shadows::{
    casters::CasterSet,
    cull::{Frustum, widened},
    host_inputs::HostCasters,
};
use crate::{
    error::{Error, Input},
    frame::{Commands, Dispatch, HostBindings},
    gpu::{Allocator, Resources, Shelf},
    model::{Bounds, Class, Material, Shape},
    records::{DIAGONAL, GpuView, HostGroup, LoadCounters, LoadParams, MAX_MATERIALS},
    stage::{
        load::group_count,
        project::{CHUNK_SIZE, grid},
    },
};
use glam::Vec4;
use std::{ops::Range, sync::Arc};
use wgpu::{BindGroup, Buffer, BufferUsages};

/// Bound sets of a frame, and the groups that they are loaded into.
#[derive(Debug)]
pub(crate) struct HostSets {
    sets: Vec<HostSet>,
    /// Boxes of all groups, known on the device only.
    pub groups: Buffer,
    /// [`LoadCounters`].
    pub(in crate::shadows) counters: Buffer,
    /// Record of the first group's first caster.
    pub first_caster: u32,
    /// Spans by list.
    pub spans: [HostSpan; 2],
}

/// Host casters of a list.
#[derive(Clone, Debug, Default)]
pub(crate) struct HostSpan {
    pub groups: Range<u32>,
    /// Most casters of the groups.
    pub capacity: u32,
}

#[derive(Debug)]
struct HostSet {
    /// Index among the host's sets.
    index: usize,
    load: Dispatch,
    /// The host's bind group.
    host_bindings: HostBindings,
    bounds: Option<Bounds>,
    version: Option<u64>,
}

/// Index of the list in [`Class::LISTS`] that the set belongs to.
fn list_of(index: usize, set: &HostCasters<'_>, materials: &[Material]) -> Result<usize, Error> {
    let invalid = |problem| Input::HostCasters.invalid(index, problem);
    let mut list = None;
    for &material in set.materials {
        let material = materials.get(material as usize);
        let material = material.ok_or(invalid("a material of it is not among the materials"))?;
        if matches!(material.shape, Shape::Gaussian | Shape::Capsule) {
            return Err(invalid("a material of it is of Gaussians or strands, which are uploaded"));
        }
        let class = Class::of(material);
        let of = (0..Class::LISTS.len()).find(|&i| Class::LISTS[i].contains(&class));
        let of = of.ok_or(invalid("a material of it casts nothing"))?;
        if *list.get_or_insert(of) != of {
            return Err(invalid(
                "some of its materials block light and some filter it: make two sets",
            ));
        }
    }
    list.ok_or(invalid("it has no material"))
}

/// Number of records that sets need: whole groups.
pub(in crate::shadows) fn record_count(sets: &[HostCasters<'_>]) -> u32 {
    sets.iter()
        .map(|set| group_count(set.count.capacity()).saturating_mul(CHUNK_SIZE))
        .fold(0, u32::saturating_add)
}

impl HostSets {
    /// Binds the sets. `first_caster`: first record reserved in `casters`, see [`record_count`]. `None` without
    /// sets.
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        shelf: &Shelf,
        set: &CasterSet,
        materials: &[Material],
        first_caster: u32,
        given: &[HostCasters<'_>],
    ) -> Result<Option<Arc<Self>>, Error> {
        let mut by_list = [Vec::new(), Vec::new()];
        for (index, casters) in given.iter().enumerate() {
            casters.check(index)?;
            let list = list_of(index, casters, materials)?;
            if casters.count.capacity() > 0 {
                by_list[list].push((index, casters));
            }
        }
        let total: u32 =
            by_list.iter().flatten().map(|(_, set)| group_count(set.count.capacity())).sum();
        if total == 0 {
            return Ok(None);
        }
        let none = BufferUsages::empty();
        let groups = allocator.storage::<HostGroup>("host_groups", u64::from(total), none)?;
        let counters =
            allocator.storage::<LoadCounters>("host_counters", 1, BufferUsages::COPY_SRC)?;
        // Bound in place of the counts of sets with a fixed count, which are never read.
        let no_counts = allocator.storage::<u32>("host_counts", 1, none)?;
        let mut sets = Vec::new();
        let mut first_group = 0;
        let spans = by_list.map(|casters| {
            let start = first_group;
            let capacity = casters.iter().map(|(_, casters)| casters.count.capacity()).sum();
            for (index, casters) in casters {
                let group_count = group_count(casters.count.capacity());
                sets.push((index, casters, first_group, group_count));
                first_group += group_count;
            }
            HostSpan { groups: start..first_group, capacity }
        });
        type Placed<'a> = (usize, &'a HostCasters<'a>, u32, u32);
        let mut bind = |(index, casters, first_group, group_count): Placed<'_>| {
            let (counts, count_index) = casters.count.buffer();
            let mut bits = [[0; 4]; MAX_MATERIALS / 128];
            for &material in casters.materials {
                let word = material as usize / 32;
                bits[word / 4][word % 4] |= 1 << (material % 32);
            }
            let values = LoadParams {
                capacity: casters.count.capacity(),
                is_counted: u32::from(counts.is_some()),
                count_index,
                group_count,
                first_group,
                first_caster: first_caster + first_group * CHUNK_SIZE,
                quad_reach: DIAGONAL,
                materials: bits,
                ..LoadParams::default()
            };
            let params = allocator.filled("load_params", &[values], BufferUsages::UNIFORM);
            let resources = Resources::new()
                .with("casters", &set.casters)
                .with("materials", &set.materials)
                .with("load_params", &params)
                .with("host_counts", counts.unwrap_or(&no_counts))
                .with("host_groups", &groups)
                .with("host_counters", &counters);
            let kernel = casters.loader.kernel.clone();
            let host_bindings = HostBindings::new(casters.bindings);
            let load = Dispatch::on_shelf(shelf, kernel, &resources, grid(group_count))?
                .with_host(host_bindings.clone());
            let HostCasters { bounds, version, .. } = *casters;
            Ok::<_, Error>(HostSet { index, load, host_bindings, bounds, version })
        };
        let sets = sets.into_iter().map(&mut bind).collect::<Result<_, _>>()?;
        Ok(Some(Arc::new(Self { sets, groups, counters, first_caster, spans })))
    }

    /// Identity and version of each set that a view may see.
    pub(in crate::shadows) fn versions<'a>(
        &'a self,
        view: &GpuView,
    ) -> impl Iterator<Item = (usize, Option<u64>)> + use<'a> {
        let frustum = Frustum::new(view);
        let sees = move |set: &HostSet| {
            set.bounds.as_ref().and_then(widened).is_none_or(|bounds| frustum.sees(&bounds))
        };
        let seen = self.sets.iter().enumerate().filter(move |(_, set)| sees(set));
        seen.map(|(index, set)| (index, set.version))
    }

    /// The loading: records and boxes from the contents of the host's buffers at that time.
    pub(in crate::shadows) fn commands(&self) -> Commands {
        let mut commands = Commands::new();
        commands.clear("gobo load", &self.counters);
        commands.pass("gobo load", self.sets.iter().map(|set| set.load.clone()));
        commands
    }

    /// Replaces the host's bindings of one of its sets. Returns whether the set exists.
    pub(in crate::shadows) fn rebind(&self, index: usize, bindings: &BindGroup) -> bool {
        let set = self.sets.iter().find(|set| set.index == index);
        if let Some(set) = set {
            set.host_bindings.replace(bindings);
        }
        set.is_some()
    }
}

/// Six frustum planes of each view, for [`crate::stage::load::GROUPS`].
pub(in crate::shadows) fn planes(views: &[GpuView]) -> Vec<Vec4> {
    views.iter().flat_map(|view| Frustum::new(view).planes()).collect()
}
