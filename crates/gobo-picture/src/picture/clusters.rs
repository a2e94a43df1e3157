//! Lights of a picture on the GPU, and the light lists of its camera's clusters.
use crate::stage::cluster;
use gobo::{
    Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, Gpu, Resources, write_records},
    model::{Scene, View},
    records::{
        ALL_LIGHTS, LightRecords, MAX_LIGHTS, MAX_SHADOW_VIEWS, MAX_TAPS, REACH_TEXELS, Reach,
    },
    shadows::light_texture,
    stage::features::Features,
};
use gobo_reference::records::{ClusterCounters, ClusterGrid};
use wgpu::{
    Buffer, BufferUsages, Texture,
    TextureFormat::{R32Uint, Rg32Float, Rgba32Uint},
    TextureUsages,
};

/// Lights of a picture, and the light lists of its clusters.
#[derive(Debug)]
pub(super) struct Clusters {
    pub grid: ClusterGrid,
    /// Records of all lights, then of all shadow views.
    pub lights: Texture,
    /// Two texels per cluster, then the lists.
    pub lists: Texture,
    counters: Buffer,
    /// Fills the lists.
    pub commands: Commands,
}

impl Clusters {
    /// `records`: of all lights, in order.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        scene: &Scene,
        camera: &View,
        records: &LightRecords,
    ) -> Result<Self, Error> {
        for (limit, have, need) in [
            ("lights of a picture", MAX_LIGHTS, scene.lights.len()),
            ("texels that a point compares", MAX_TAPS as usize, records.taps()),
            ("shadow views of a picture", MAX_SHADOW_VIEWS, records.views.len()),
        ] {
            let remedy = "use fewer lights, or filters of fewer taps";
            Error::check_limit(limit, have as u64, need as u64, remedy)?;
        }
        let light_count = scene.lights.len();
        let grid = ClusterGrid::new(&scene.clusters, camera, light_count);
        let params = grid.params(&scene.clusters, light_count);
        let params_buffer = allocator.uniform("cluster_params", &params);
        let cluster_count = u64::from(params.cluster_count);

        let reaches: Vec<_> = scene.lights.iter().map(|light| Reach::new(light, camera)).collect();
        let copied = TextureUsages::COPY_DST;
        let lights = light_texture(allocator, queue, records)?;
        let reach_texels = light_count as u64 * u64::from(REACH_TEXELS);
        let reach_records = allocator.records("light_reaches", Rgba32Uint, reach_texels, copied)?;
        write_records(queue, &reach_records, bytemuck::cast_slice(&reaches).to_vec());
        let cells =
            allocator.records("cluster_cells", Rg32Float, grid.bounds.len() as u64, copied)?;
        write_records(queue, &cells, bytemuck::cast_slice(&grid.bounds).to_vec());

        let storage = TextureUsages::STORAGE_BINDING;
        let words = cluster_count * u64::from(params.word_count);
        let masks = allocator.records("cluster_masks", R32Uint, words, storage)?;
        let texels = 2 * cluster_count + u64::from(params.capacity);
        let lists =
            allocator.records("clusters", R32Uint, texels, storage | TextureUsages::COPY_SRC)?;
        let none = BufferUsages::empty();
        let offsets = allocator.storage::<u32>("cluster_offsets", cluster_count, none)?;
        let counters =
            allocator.storage::<ClusterCounters>("cluster_counters", 1, BufferUsages::COPY_SRC)?;

        let resources = Resources::new()
            .with("cluster_params", &params_buffer)
            .with("cluster_counters", &counters)
            .with("cells", &cells)
            .with("reaches", &reach_records)
            .with("masks", &masks)
            .with("offsets", &offsets)
            .with("clusters", &lists);
        let run =
            |desc, groups: [u32; 3]| kernels.dispatch(desc, Features::NONE, &resources, groups);
        let groups = [grid.cluster_count().div_ceil(cluster::LANES), 1, 1];
        let passes = [
            run(&cluster::COUNT, groups)?,
            run(&cluster::SCAN, [1, 1, 1])?,
            run(&cluster::EMIT, groups)?,
        ];
        let mut commands = Commands::new();
        commands.clear("gobo cluster", &counters);
        commands.pass("gobo cluster", passes);
        Ok(Self { grid, lights, lists, counters, commands })
    }

    /// Reads the counters. Blocks.
    pub(super) fn read_counters(&self, gpu: &Gpu) -> Result<ClusterCounters, Error> {
        Ok(gpu.try_read::<ClusterCounters>(&self.counters)?[0])
    }

    /// The list of each cluster; `None` for all lights. Blocks.
    pub(super) fn read(&self, gpu: &Gpu) -> Result<Vec<Option<Vec<u32>>>, Error> {
        let texels: Vec<u32> = gpu.try_read_texture(&self.lists)?;
        let headers = texels.chunks_exact(2).take(self.grid.cluster_count() as usize);
        let list = |header: &[u32]| {
            let first = header[0] as usize;
            (header[0] != ALL_LIGHTS).then(|| texels[first..first + header[1] as usize].to_vec())
        };
        Ok(headers.map(list).collect())
    }
}
