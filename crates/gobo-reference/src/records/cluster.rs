//! Grid of light clusters (froxels).
use glam::{UVec3, Vec2, Vec3};
use gobo::{
    model::{ClusterSettings, View},
    records::MAX_TILE,
};

/// Most words of light bits, of 32 lights each: 8 MiB. So every invocation stays far below the 65,535
/// iterations that llvmpipe allows.
const MAX_WORDS: u32 = 1 << 21;

gobo::gpu_struct! {
    /// WGSL: `crates/gobo-picture/wgsl/records/picture.wgsl`.
    #[derive(Default, Eq)]
    pub struct ClusterParams {
        pub cells: UVec3,
        pub cluster_count: u32,
        pub light_count: u32,
        /// Words of light bits per cluster.
        pub word_count: u32,
        /// Capacity of all lists together \[lights\].
        pub capacity: u32,
        pub pad: u32,
    }
}

gobo::gpu_struct! {
    /// WGSL: `crates/gobo-picture/wgsl/records/picture.wgsl`.
    #[derive(Default, Eq)]
    pub struct ClusterCounters {
        /// Combinations (cluster, light) found.
        pub needed: u32,
        /// Clusters whose list did not fit, which are shaded with all lights.
        pub overflowed: u32,
        /// Length of the longest list \[lights\].
        pub longest: u32,
        pub pad: u32,
    }
}

/// Grid of clusters in the camera's frustum.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusterGrid {
    /// Number of cells in x, y and depth.
    pub cells: UVec3,
    /// Edge of a cluster \[pixels\].
    pub tile: u32,
    /// End of the first slice \[m\].
    pub first_slice: f32,
    /// Slices from a distance to twice that.
    pub slices_per_doubling: f32,
    /// Near plane of the camera \[m\].
    pub near: f32,
    /// Distance from the camera's near to its far plane \[m\].
    pub depth_range: f32,
    /// Low and high end of the cells: slopes in x, then in y (downwards), then depths \[m\], padded by the
    /// rounding error of a point.
    pub bounds: Vec<[f32; 2]>,
}

/// Padding of cells in x and y \[pixels\].
const PIXEL_MARGIN: f32 = 1.0 / 64.0;
/// Padding of slices, relative to the depth: far above the error of a logarithm.
const DEPTH_MARGIN: f32 = 1e-4;

impl ClusterGrid {
    /// A grid coarser than the settings if the bits of `light_count` lights would exceed `MAX_WORDS`.
    pub fn new(settings: &ClusterSettings, camera: &View, light_count: usize) -> Self {
        let words = word_count(light_count);
        let mut tile = settings.tile.clamp(16, MAX_TILE);
        let mut slices = settings.slices.clamp(1, ClusterSettings::MAX_SLICES);
        let cells = |tile: u32, slices: u32| {
            UVec3::new(camera.size.x.div_ceil(tile), camera.size.y.div_ceil(tile), slices)
        };
        let words_of = |cells: UVec3| u64::from(cells.element_product()) * u64::from(words);
        while words_of(cells(tile, slices)) > u64::from(MAX_WORDS)
            && (tile < MAX_TILE || slices > 1)
        {
            if tile < MAX_TILE {
                tile = (tile * 2).min(MAX_TILE);
            } else {
                slices /= 2;
            }
        }
        let cells = cells(tile, slices);
        let (near, far) = (camera.near, camera.far);
        let wanted = settings.near.unwrap_or(far * 0.01);
        let first_slice = wanted.max(near).min(far * 0.99);
        let slices_per_doubling = (slices - 1) as f32 / (far / first_slice).log2();
        let half = camera.size.as_vec2() * 0.5;
        let slope = |pixel: f32, half: f32| (pixel - half) / camera.scale;
        let mut bounds = Vec::new();
        for (count, half) in [(cells.x, half.x), (cells.y, half.y)] {
            bounds.extend((0..count).map(|i| {
                let low = (i * tile) as f32 - PIXEL_MARGIN;
                [slope(low, half), slope(low + tile as f32 + 2.0 * PIXEL_MARGIN, half)]
            }));
        }
        let end = |slice: u32| {
            if slice + 1 == slices {
                far
            } else {
                first_slice * (slice as f32 / slices_per_doubling).exp2()
            }
        };
        bounds.extend((0..slices).map(|slice| {
            let low = if slice == 0 { near } else { end(slice - 1) };
            [low * (1.0 - DEPTH_MARGIN), end(slice) * (1.0 + DEPTH_MARGIN)]
        }));
        let depth_range = far - near;
        Self { cells, tile, first_slice, slices_per_doubling, near, depth_range, bounds }
    }

    /// Number of clusters.
    pub fn cluster_count(&self) -> u32 {
        self.cells.element_product()
    }

    /// Low and high corner of a cluster: x to the right, y down, z along the view axis \[m\].
    pub fn cluster_box(&self, cluster: u32) -> (Vec3, Vec3) {
        let UVec3 { x: width, y: height, .. } = self.cells;
        let (x, y, z) = (cluster % width, cluster / width % height, cluster / (width * height));
        let [x, y, [near, far]] =
            [x, width + y, width + height + z].map(|i| self.bounds[i as usize]);
        let low = |[low, _]: [f32; 2]| (low * near).min(low * far);
        let high = |[_, high]: [f32; 2]| (high * near).max(high * far);
        (Vec3::new(low(x), low(y), near), Vec3::new(high(x), high(y), far))
    }

    /// The cluster of a pixel at light depth `depth`; `None` outside the picture or the depth range.
    pub fn cluster(&self, pixel: Vec2, depth: f32) -> Option<u32> {
        let distance = self.near + depth * self.depth_range;
        let doublings = (distance / self.first_slice).max(1.0).log2();
        let beyond = (doublings * self.slices_per_doubling) as u32 + 1;
        let slice = if distance >= self.first_slice { beyond } else { 0 }.min(self.cells.z - 1);
        let cell = pixel.max(Vec2::ZERO).as_uvec2() / self.tile;
        let inside = pixel.cmpge(Vec2::ZERO).all()
            && cell.cmplt(self.cells.truncate()).all()
            && (0.0..=1.0).contains(&depth);
        inside.then(|| (slice * self.cells.y + cell.y) * self.cells.x + cell.x)
    }

    /// Capacity of all lists together, bounded by the settings \[lights\].
    pub fn capacity(&self, settings: &ClusterSettings, light_count: usize) -> u32 {
        let most = u64::from(self.cluster_count()) * light_count as u64;
        most.min(u64::from(settings.budget)) as u32
    }

    /// Parameters of the kernels.
    pub fn params(&self, settings: &ClusterSettings, light_count: usize) -> ClusterParams {
        ClusterParams {
            cells: self.cells,
            cluster_count: self.cluster_count(),
            light_count: light_count as u32,
            word_count: word_count(light_count),
            capacity: self.capacity(settings, light_count),
            pad: 0,
        }
    }
}

fn word_count(light_count: usize) -> u32 {
    (light_count as u32).div_ceil(32).max(1)
}
