//! Area lights, and the levels of their shadow views.
//!
//! A *level* of a map has a *block* for each 2^l x 2^l texels, and a border of [`SKIRT`] blocks around them,
//! which for a face of a cube come from the neighbouring faces. A block holds the mean light of its texels as
//! a function of depth.
use super::{
    AREA_SHIFT, FILTER_SPLINE, GpuLight, GpuView, LIGHT_TEXELS, ROLE_FACE, ROW, VIEW_TEXELS,
    VIEWPOINTS_SHIFT,
};
use crate::model::{Light, ShadowSettings, Source, View};
use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec3};
use std::ops::Range;

/// Blocks around a level. WGSL: `wgsl/records/area.wgsl`.
pub const SKIRT: u32 = 3;
/// Most levels of a view: a map of 4,096 texels has 11. WGSL: `wgsl/records/area.wgsl`.
pub const MAX_LEVELS: usize = 12;
/// Texels of a block: four nodes of a curve. WGSL: `wgsl/records/area.wgsl`.
pub const BLOCK_TEXELS: u32 = 2;
/// Nodes of a block.
pub const BLOCK_NODES: usize = 4;
/// Texels of a [`GpuArea`]. WGSL: `wgsl/records/area.wgsl`.
pub const AREA_TEXELS: u32 = 2;
const _: () = assert!(size_of::<GpuArea>() == AREA_TEXELS as usize * 16);
/// Texels of a [`LeveledView`]. WGSL: `wgsl/records/area.wgsl`.
pub const LEVELED_TEXELS: u32 = 4;
const _: () = assert!(size_of::<LeveledView>() == LEVELED_TEXELS as usize * 16);
/// Largest number of area lights, counting each viewpoint: a point that evaluates all of them stays below the
/// 65,535 iterations that llvmpipe allows an invocation.
pub const MAX_AREAS: usize = 64;

/// Numbers of [`Source`] in [`GpuArea::kind`].
pub const AREA_SPHERE: u32 = 0;
/// Kind of a rectangle or disc.
pub const AREA_FLAT: u32 = 1;
/// Kind of a sun's disc.
pub const AREA_SUN: u32 = 2;

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/area.wgsl`.
    pub struct GpuArea {
        /// First of [`Source::half_axes`] of a part of the source, world space \[m\]; for a sun, x is a
        /// slope.
        pub right: Vec3,
        pub kind: u32,
        pub up: Vec3,
        /// Index of the light's first view among the leveled views.
        pub first_leveled: u32,
    }
}

impl GpuArea {
    fn new(source: &Source, first_leveled: u32) -> Self {
        let kind = match source {
            Source::Sphere { .. } => AREA_SPHERE,
            Source::Disc { .. } | Source::Rect { .. } => AREA_FLAT,
            Source::Sun { .. } => AREA_SUN,
        };
        let [right, up] = source.half_axes();
        Self { right, kind, up, first_leveled }
    }
}

/// A shadow view of an area light. WGSL: `wgsl/records/area.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct LeveledView {
    /// First block of levels 1, 2 and so on.
    pub first_blocks: [u32; MAX_LEVELS],
    /// Index among the shadow views.
    pub view: u32,
    /// Number of levels.
    pub level_count: u32,
    /// First face of its cube, an index among the leveled views; itself where there is no cube.
    pub first_face: u32,
    /// Not read.
    pub pad: u32,
}

/// Size of level `level` without its border \[blocks\].
pub fn level_size(size: UVec2, level: u32) -> UVec2 {
    UVec2::new(size.x.div_ceil(1 << level), size.y.div_ceil(1 << level))
}

/// Number of levels of a map: the last has at most two blocks a side.
pub fn level_count(size: UVec2) -> u32 {
    let enough = |&level: &u32| level_size(size, level).max_element() <= 2;
    (1..MAX_LEVELS as u32).find(enough).unwrap_or(MAX_LEVELS as u32)
}

/// The lights of a look-up, their shadow views, and the levels of area lights.
#[derive(Clone, Debug, Default)]
pub struct LightRecords {
    /// The lights.
    pub lights: Vec<GpuLight>,
    /// Their shadow views.
    pub views: Vec<GpuView>,
    /// Sources of lights with a size.
    pub areas: Vec<GpuArea>,
    /// Views whose maps have levels.
    pub leveled: Vec<LeveledView>,
    /// End of each level in blocks: whole rows of records.
    pub level_ends: Vec<u32>,
}

/// Indices of the views of each light, which are neighbours.
fn views_by_light(views: &[View]) -> Vec<Range<u32>> {
    let count = views.iter().filter_map(|view| view.light).max().map_or(0, |last| last + 1);
    let mut by_light = vec![0..0; count];
    for (index, light) in (0..).zip(views).filter_map(|(i, view)| Some((i, view.light?))) {
        let gpu_light = &mut by_light[light];
        *gpu_light = if gpu_light.start == gpu_light.end {
            index..index + 1
        } else {
            gpu_light.start..gpu_light.end + 1
        };
    }
    by_light
}

impl LightRecords {
    /// `lights`: index among all lights, and the light; `models` and `views`: all shadow views.
    pub fn new<'a>(
        lights: impl Iterator<Item = (usize, &'a Light)>,
        models: &[View],
        views: Vec<GpuView>,
        settings: &ShadowSettings,
    ) -> Self {
        let mut records = Self { views, ..Self::default() };
        let by_light = views_by_light(models);
        for (index, light) in lights {
            let of_light = by_light.get(index).cloned().unwrap_or_default();
            let mut gpu_light = GpuLight::new(light, of_light, settings);
            let viewpoints = light.viewpoint_count();
            if let Some(source) = light.area().filter(|_| gpu_light.view_count > 0) {
                // Area lights filter by their spots instead.
                gpu_light.taps = FILTER_SPLINE;
                let first = records.leveled.len() as u32;
                records.areas.push(GpuArea::new(&source.part(viewpoints), first));
                gpu_light.traits |= (records.areas.len() as u32) << AREA_SHIFT;
                gpu_light.traits |= (viewpoints - 1) << VIEWPOINTS_SHIFT;
                for i in 0..gpu_light.view_count {
                    records.add_view(gpu_light.first_view + i);
                }
            }
            records.lights.push(gpu_light);
        }
        records.place_levels();
        records
    }

    fn add_view(&mut self, view: u32) {
        let GpuView { size, role, role_index, .. } = self.views[view as usize];
        let number = self.leveled.len() as u32;
        let face = if role == ROLE_FACE { role_index } else { 0 };
        self.leveled.push(LeveledView {
            first_blocks: [0; MAX_LEVELS],
            view,
            level_count: level_count(size.as_uvec2()),
            first_face: number - face,
            pad: 0,
        });
    }

    /// Places the levels one after another over all views: each level is read while the next is made.
    fn place_levels(&mut self) {
        let deepest = self.leveled.iter().map(|view| view.level_count).max().unwrap_or(0);
        let mut end = 0;
        for level in 1..=deepest {
            for i in 0..self.leveled.len() {
                let size = self.view_of(i).size.as_uvec2();
                let gpu_light = &mut self.leveled[i];
                if level <= gpu_light.level_count {
                    gpu_light.first_blocks[level as usize - 1] = end;
                    end += (level_size(size, level) + 2 * SKIRT).element_product();
                }
            }
            end = end.next_multiple_of(ROW / BLOCK_TEXELS);
            self.level_ends.push(end);
        }
    }

    /// The view record of a leveled view.
    pub fn view_of(&self, leveled: usize) -> &GpuView {
        &self.views[self.leveled[leveled].view as usize]
    }

    /// Texel of `lights` where areas begin.
    pub fn first_area(&self) -> u32 {
        self.lights.len() as u32 * LIGHT_TEXELS + self.views.len() as u32 * VIEW_TEXELS
    }

    /// Texels that a point reads from the maps of all lights, each light once.
    pub fn taps(&self) -> usize {
        self.lights.iter().map(GpuLight::tap_count).sum()
    }

    /// Whether some maps are read with a filter other than the spline.
    pub fn is_filtered(&self) -> bool {
        self.lights.iter().any(GpuLight::is_filtered)
    }

    /// Records that `wgsl/records/light.wgsl` and `area.wgsl` read.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = bytemuck::cast_slice(&self.lights).to_vec();
        bytes.extend_from_slice(bytemuck::cast_slice(&self.views));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.areas));
        if !self.areas.is_empty() {
            // The leveled views begin at an offset that does not depend on the number of areas.
            let unused = MAX_AREAS.saturating_sub(self.areas.len()) * size_of::<GpuArea>();
            bytes.resize(bytes.len() + unused, 0);
        }
        bytes.extend_from_slice(bytemuck::cast_slice(&self.leveled));
        bytes
    }
}
