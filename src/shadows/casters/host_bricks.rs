//! Grids of voxels in the host's textures and buffers: their bricks as casters.
use crate::shadows::{
    casters::{CasterSet, check::material_problem, host_casters},
    host_grids::{HostGrid, VoxelSource},
};
use crate::{
    error::{Error, Input},
    frame::{Dispatch, HostBindings, Kernels},
    gpu::{Allocator, Resources},
    model::{Class, Material, Particle},
    records::HostGridParams,
    stage::{features::Features, load, project::grid},
};
use wgpu::{Buffer, BufferUsages, TextureViewDescriptor};

/// Buffers of a grid's bricks, by which they are loaded as casters.
#[derive(Debug)]
pub(super) struct HostBricks {
    /// Copy of the voxels to the slots of bricks.
    pub pack: Dispatch,
    /// Number of bricks, with density or without.
    pub count: u32,
    /// Resources of `load_bricks`.
    pub resources: Resources,
}

/// Checks the materials of grids.
pub(super) fn check(grids: &[HostGrid<'_>], materials: &[Material]) -> Result<(), Error> {
    for (index, of_host) in grids.iter().enumerate() {
        let problem = match materials.get(of_host.grid.material as usize) {
            None => Some("its material is not among the materials"),
            Some(material) => material_problem(material).or_else(|| {
                let casts = Class::FILTERING.contains(&Class::of(material));
                (!casts).then_some("its material casts nothing")
            }),
        };
        problem.map_or(Ok(()), |problem| Err(Input::HostGrid.invalid(index, problem)))?;
    }
    Ok(())
}

impl HostBricks {
    /// `index`: the grid's; `bricks`, `first_slot`: as uploaded; `groups`: of the host's casters.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        kernels: &Kernels,
        set: &CasterSet,
        (index, of_host): (usize, &HostGrid<'_>),
        (bricks, first_slot): (&[Particle], u32),
        groups: &Buffer,
    ) -> Result<Self, Error> {
        let count = bricks.len() as u32;
        let values = HostGridParams {
            size: of_host.size,
            first_slot,
            bricks: of_host.bricks().truncate(),
            slots: set.bricks.slots(),
            brick_count: count,
            first_record: bricks.first().map_or(0, |brick| brick.id),
            material: of_host.grid.material,
            pad: 0,
        };
        let params = allocator.uniform("host_grid", &values);
        let spheres: Vec<[f32; 4]> =
            bricks.iter().map(|brick| brick.center.extend(brick.radius).to_array()).collect();
        let spheres = allocator.filled("brick_spheres", &spheres, BufferUsages::STORAGE);
        let none = BufferUsages::empty();
        let states = allocator.storage::<u32>("brick_states", count.into(), none)?;
        let loaded = Resources::new()
            .with("host_grid", &params)
            .with("brick_spheres", &spheres)
            .with("brick_states", &states);
        let resources =
            loaded.clone().with("host_groups", groups).with("voxels", &set.bricks.voxels);
        let groups = grid(count);
        let pack = match of_host.source {
            VoxelSource::Texture(texture) => {
                let view = texture.create_view(&TextureViewDescriptor {
                    label: Some("host_voxels"),
                    mip_level_count: Some(1),
                    ..Default::default()
                });
                let resources = resources.with("host_voxels", &view);
                kernels.dispatch(&load::VOXELS, Features::NONE, &resources, groups)?
            }
            VoxelSource::Loader(loader, bindings) => {
                let kernel = loader.kernel.clone();
                let dispatch = kernels.dispatch_of(kernel, &resources, groups)?;
                host_casters::check(Input::HostGrid, index, &dispatch, bindings)?;
                dispatch.with_host(HostBindings::new(bindings))
            }
        };
        Ok(Self { pack, count, resources: loaded })
    }
}
