//! Casters in the host's buffers: their sets, and the conversion to records.
use crate::shadows::{
    casters::{
        CasterSet,
        host_bricks::{self, HostBricks},
        host_kinds::{HostKinds, list_of},
    },
    cull::widened,
    host_grids::HostGrid,
    host_inputs::{CasterCount, HostCasters, HostInputs},
};
use crate::{
    error::{Error, Input},
    frame::{Commands, Dispatch, HostBindings, Kernels},
    gpu::{Allocator, Resources},
    model::{Bounds, Material},
    records::{DIAGONAL, GaussianLook, GpuView, HostGroup, LoadParams, MAX_MATERIALS},
    stage::{
        features::Features,
        load::{self, group_count},
        project::{CHUNK_SIZE, grid},
    },
};
use glam::Vec4;
use std::{ops::Range, sync::Arc};
use wgpu::{BindGroup, Buffer, BufferUsages};

/// Bound sets of a frame, and the groups that they are loaded into.
#[derive(Debug)]
pub(crate) struct HostSets {
    /// Copies of grids' voxels to bricks, before the sets are loaded.
    packs: Vec<Dispatch>,
    sets: Vec<HostSet>,
    /// Copy of the records to where kernels read them.
    copy: Commands,
    /// `LoadCounters` and the boxes of all groups, which only the device knows.
    pub groups: Buffer,
    /// Record of the first group's first caster.
    pub first_caster: u32,
    /// Spans by list.
    pub spans: [HostSpan; 2],
    /// Looks of the materials of Gaussians; empty without Gaussians.
    looks: Vec<GaussianLook>,
}

/// Host casters of a list.
#[derive(Clone, Debug, Default)]
pub(crate) struct HostSpan {
    pub groups: Range<u32>,
    /// Most casters of the groups.
    pub capacity: u32,
    pub kinds: HostKinds,
}

#[derive(Debug)]
struct HostSet {
    /// Index among the host's sets; `None` for a grid.
    index: Option<usize>,
    /// Index in [`Class::LISTS`].
    list: usize,
    load: Dispatch,
    capacity: u32,
    /// Buffer of the count and index in it; `None` for a fixed count.
    counts: (Option<Buffer>, u32),
    materials: Vec<u32>,
    kinds: HostKinds,
}

/// State of a set or grid that the host declares in each frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct HostSeen {
    kinds: HostKinds,
    bounds: Option<Bounds>,
    version: Option<u64>,
}

/// A set of casters, or the bricks of a grid, before records are assigned to them.
struct Given<'a> {
    /// Index among the host's sets; `None` for a grid.
    index: Option<usize>,
    /// Index in [`Class::LISTS`].
    list: usize,
    count: CasterCount<'a>,
    materials: &'a [u32],
    kinds: HostKinds,
    source: HostSource<'a>,
}

enum HostSource<'a> {
    Set(&'a HostCasters<'a>),
    Bricks(&'a HostBricks),
}

impl<'a> Given<'a> {
    fn of_set(index: usize, list: usize, set: &'a HostCasters<'a>) -> Self {
        let &HostCasters { loader, count, materials, .. } = set;
        let kinds = HostKinds { gaussians: loader.gaussians, particles: !loader.gaussians };
        Self { index: Some(index), list, count, materials, kinds, source: HostSource::Set(set) }
    }

    fn of_grid(grid: &'a HostGrid<'a>, bricks: &'a HostBricks) -> Self {
        Self {
            index: None,
            list: 1,
            count: CasterCount::Fixed(bricks.count),
            materials: std::slice::from_ref(&grid.grid.material),
            kinds: HostKinds { gaussians: false, particles: true },
            source: HostSource::Bricks(bricks),
        }
    }

    /// Parameters, without the first record and group.
    fn params(&self) -> LoadParams {
        let (counts, count_index) = self.count.buffer();
        let mut materials = [[0; 4]; MAX_MATERIALS / 128];
        for &material in self.materials {
            let word = material as usize / 32;
            materials[word / 4][word % 4] |= 1 << (material % 32);
        }
        LoadParams {
            capacity: self.count.capacity(),
            is_counted: u32::from(counts.is_some()),
            count_index,
            group_count: group_count(self.count.capacity()),
            quad_reach: DIAGONAL,
            may_be_none: u32::from(matches!(self.source, HostSource::Bricks(_))),
            materials,
            ..LoadParams::default()
        }
    }

    /// Dispatch that loads it. `looks`: of the Gaussians' materials.
    fn load(
        &self,
        kernels: &Kernels,
        resources: Resources,
        looks: Option<&Buffer>,
        group_count: u32,
    ) -> Result<Dispatch, Error> {
        let resources = resources.with_any("host_counts", self.count.buffer().0);
        match self.source {
            HostSource::Set(set) => {
                let looks = looks.filter(|_| self.kinds.gaussians);
                let resources = resources.with_any("gaussian_looks", looks);
                let kernel = set.loader.kernel.clone();
                let load = kernels.dispatch_of(kernel, &resources, grid(group_count))?;
                check(Input::HostCasters, self.index.unwrap_or_default(), &load, set.bindings)?;
                Ok(load.with_host(HostBindings::new(set.bindings)))
            }
            HostSource::Bricks(bricks) => {
                let resources = resources.and(&bricks.resources);
                let groups = grid(group_count);
                Ok(kernels.dispatch(&load::BRICKS, Features::NONE, &resources, groups)?)
            }
        }
    }

    fn bound(&self, load: Dispatch) -> HostSet {
        let &Given { index, list, count, kinds, .. } = self;
        let (counts, at) = count.buffer();
        let (counts, capacity) = ((counts.cloned(), at), count.capacity());
        HostSet { index, list, load, capacity, counts, materials: self.materials.to_vec(), kinds }
    }
}

/// The span of each list's groups, one after the other.
fn spans(by_list: &[Vec<Given<'_>>; 2]) -> [HostSpan; 2] {
    let mut end = 0;
    by_list.each_ref().map(|list| {
        let start = end;
        end += list.iter().map(|given| group_count(given.count.capacity())).sum::<u32>();
        let capacity = list.iter().map(|given| given.count.capacity()).sum();
        let kinds = list.iter().fold(HostKinds::default(), |all, given| all.or(given.kinds));
        HostSpan { groups: start..end, capacity, kinds }
    })
}

impl HostSets {
    /// Whether these sets serve `inputs`, whose bindings they then take over: with the same loaders, counts
    /// and materials, and no grids.
    pub(super) fn follow(
        &self,
        materials: &[Material],
        first_caster: u32,
        inputs: &HostInputs<'_>,
    ) -> Result<bool, Error> {
        let given = inputs.casters;
        let loaded = given.iter().enumerate().filter(|(_, set)| set.count.capacity() > 0);
        let looks = materials.iter().map(GaussianLook::new);
        let keeps_looks = self.looks.is_empty() || looks.eq(self.looks.iter().copied());
        if self.first_caster != first_caster
            || loaded.clone().count() != self.sets.len()
            || !inputs.grids.is_empty()
            || !keeps_looks
        {
            return Ok(false);
        }
        for (index, casters) in loaded {
            let list = list_of(index, casters, materials)?;
            let Some(set) = self.set(index) else { return Ok(false) };
            let (counts, at) = casters.count.buffer();
            let is_alike = set.list == list
                && set.load.kernel == casters.loader.kernel
                && set.capacity == casters.count.capacity()
                && (set.counts.0.as_ref(), set.counts.1) == (counts, at)
                && set.materials == casters.materials;
            if !is_alike {
                return Ok(false);
            }
            check(Input::HostCasters, index, &set.load, casters.bindings)?;
        }
        for set in &self.sets {
            if let (Some(index), Some(host)) = (set.index, &set.load.host) {
                host.replace(given[index].bindings);
            }
        }
        Ok(true)
    }

    fn set(&self, index: usize) -> Option<&HostSet> {
        self.sets.iter().find(|set| set.index == Some(index))
    }

    /// Declared state of each set in `inputs`, in their order, then of the grids.
    pub(super) fn seen<'a>(
        &'a self,
        inputs: &'a HostInputs<'_>,
    ) -> impl Iterator<Item = HostSeen> + 'a {
        let mut grids = inputs.grids.iter();
        self.sets.iter().filter_map(move |set| {
            let kinds = set.kinds;
            match set.index {
                Some(index) => {
                    let HostCasters { bounds, version, .. } = inputs.casters[index];
                    Some(HostSeen { kinds, bounds, version })
                }
                None => grids.next().map(|grid| HostSeen {
                    kinds,
                    bounds: Some(grid.bounds()),
                    version: grid.version,
                }),
            }
        })
    }

    /// Binds the sets and grids to the records that [`record_count`] has reserved. `None` without any.
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        kernels: &Kernels,
        set: &CasterSet,
        materials: &[Material],
        inputs: &HostInputs<'_>,
    ) -> Result<Option<Arc<Self>>, Error> {
        host_bricks::check(inputs.grids, materials)?;
        let none = BufferUsages::empty();
        let mut by_list = [Vec::new(), Vec::new()];
        for (index, casters) in inputs.casters.iter().enumerate() {
            let list = list_of(index, casters, materials)?;
            if casters.count.capacity() > 0 {
                by_list[list].push(Given::of_set(index, list, casters));
            }
        }
        if by_list.iter().all(Vec::is_empty) && inputs.grids.is_empty() {
            return Ok(None);
        }
        let of_sets = by_list.iter().flatten().map(|given| given.count.capacity());
        let of_bricks = set.bricks.of_host().map(|(bricks, _)| bricks.len() as u32);
        let total: u32 = of_sets.chain(of_bricks).map(group_count).sum();
        let groups = allocator.storage::<HostGroup>(
            "host_groups",
            u64::from(total) + 1,
            BufferUsages::COPY_SRC,
        )?;
        let of_grids = inputs.grids.iter().enumerate().zip(set.bricks.of_host());
        let mut bind_grid =
            |(grid, bricks)| HostBricks::new(allocator, kernels, set, grid, bricks, &groups);
        let bricks = of_grids.map(&mut bind_grid).collect::<Result<Vec<_>, _>>()?;
        by_list[1].extend(inputs.grids.iter().zip(&bricks).map(|(g, b)| Given::of_grid(g, b)));
        let all = by_list.iter().flatten();
        // Bound in place of counts where they are fixed, and then never read.
        let no_counts = allocator.storage::<u32>("host_counts", 1, none)?;
        let has_gaussians = all.clone().any(|given| given.kinds.gaussians);
        let of_gaussians = if has_gaussians { materials } else { &[] };
        let looks: Vec<_> = of_gaussians.iter().map(GaussianLook::new).collect();
        let bound_looks = has_gaussians.then(|| {
            let mut padded = looks.clone();
            padded.resize(MAX_MATERIALS, GaussianLook::default());
            allocator.filled("gaussian_looks", &padded, BufferUsages::UNIFORM)
        });
        let (written, first_record) = set.casters.written();
        let resources = Resources::new()
            .with_any("casters", written)
            .with("materials", &set.materials)
            .with("host_counts", &no_counts)
            .with("host_groups", &groups);
        let first_caster = set.host_records.start;
        let (mut first_group, mut first_axes) = (0, first_caster + total * CHUNK_SIZE);
        let mut bind = |given: &Given<'_>| {
            let of_set = given.params();
            let place = first_caster + first_group * CHUNK_SIZE;
            let values = LoadParams {
                first_group,
                first_caster: place - first_record,
                first_axes: first_axes - first_record,
                first_record,
                ..of_set
            };
            let params = allocator.uniform("load_params", &values);
            first_group += values.group_count;
            if given.kinds.gaussians {
                first_axes += values.group_count * CHUNK_SIZE;
            }
            let resources = resources.clone().with("load_params", &params);
            let load = given.load(kernels, resources, bound_looks.as_ref(), values.group_count)?;
            Ok::<_, Error>(given.bound(load))
        };
        let sets = all.map(&mut bind).collect::<Result<_, _>>()?;
        let mut copy = Commands::new();
        set.casters.copy(&mut copy, "gobo load", &(first_caster..first_axes));
        let spans = spans(&by_list);
        let packs = bricks.into_iter().map(|bricks| bricks.pack).collect();
        Ok(Some(Arc::new(Self { packs, sets, copy, groups, first_caster, spans, looks })))
    }

    /// The loading: makes records and boxes from the contents that the host's buffers have when the frame
    /// runs.
    pub(in crate::shadows) fn commands(&self) -> Commands {
        let mut commands = Commands::new();
        commands.clear("gobo load", &self.groups);
        let loads = self.sets.iter().map(|set| &set.load);
        commands.pass("gobo load", self.packs.iter().chain(loads).cloned());
        commands.append(self.copy.clone());
        commands
    }

    /// Replaces the host's bindings of one of its sets. Returns whether the set exists.
    pub(in crate::shadows) fn rebind(
        &self,
        index: usize,
        bindings: &BindGroup,
    ) -> Result<bool, Error> {
        rebound(Input::HostCasters, index, self.set(index).map(|set| &set.load), bindings)
    }

    /// Replaces the host's bindings of one of its grids. Returns whether a loader reads it.
    pub(in crate::shadows) fn rebind_grid(
        &self,
        index: usize,
        bindings: &BindGroup,
    ) -> Result<bool, Error> {
        rebound(Input::HostGrid, index, self.packs.get(index), bindings)
    }
}

/// Replaces the host's bindings of a loader. Returns whether it has any.
fn rebound(
    input: Input,
    index: usize,
    load: Option<&Dispatch>,
    bindings: &BindGroup,
) -> Result<bool, Error> {
    let Some((load, host)) = load.and_then(|load| Some((load, load.host.as_ref()?))) else {
        return Ok(false);
    };
    check(input, index, load, bindings)?;
    host.replace(bindings);
    Ok(true)
}

/// Whether bindings of the host have their loader's layout.
pub(crate) fn check(
    input: Input,
    index: usize,
    load: &Dispatch,
    bindings: &BindGroup,
) -> Result<(), Error> {
    let problem = "its bind group is not of the layout that its loader was made for";
    load.takes(bindings).then_some(()).ok_or(input.invalid(index, problem))
}

impl HostSeen {
    /// The set's version, if a view may see it.
    pub(super) fn version(&self, view: &GpuView) -> Option<Option<u64>> {
        let bounds = self.bounds.as_ref().and_then(widened);
        let frustum = self.kinds.frustum(view);
        bounds.is_none_or(|bounds| frustum.sees(&bounds)).then_some(self.version)
    }
}

/// Six frustum planes of each view, for [`crate::stage::load::CULL_GROUPS`].
pub(in crate::shadows) fn planes(views: &[GpuView], kinds: HostKinds) -> Vec<Vec4> {
    views.iter().flat_map(|view| kinds.frustum(view).planes()).collect()
}
