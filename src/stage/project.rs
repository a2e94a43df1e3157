//! project: casters to footprints, depth keys and tile rectangles, per view.
//!
//! In: chunks of `casters` or `triangles`, `views`, `materials`. Out: one footprint, key and
//! rectangle per (caster, view), at a place the CPU knows; of triangles also a setup.
use crate::{
    gpu::{Binding, KernelDesc, Tier},
    records::{GpuMaterial, GpuView},
};
use bytemuck::{Pod, Zeroable};
use wgpu::{
    TextureFormat::{Rg32Uint, Rgba32Uint},
    TextureSampleType::Uint,
};

/// Casters of a chunk: invocations of a workgroup.
pub const CHUNK_SIZE: u32 = 256;

pub const PARTICLES: KernelDesc = KernelDesc {
    name: "project_particles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/chunk.wgsl",
        "project_particles.wgsl"
    ],
    bindings: &[
        Binding::uniform::<ProjectParams>("params"),
        Binding::uniform::<[GpuView; crate::records::MAX_VIEWS]>("views"),
        Binding::uniform::<[GpuMaterial; crate::records::MAX_MATERIALS]>("materials"),
        Binding::read::<Chunk>("chunks"),
        Binding::texture("casters", Uint),
        Binding::texture_write("footprints", Rgba32Uint),
        Binding::texture_write("keys", Rg32Uint),
        Binding::texture_write("rects", Rg32Uint),
    ],
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    tier: Tier::Core,
};

pub const TRIANGLES: KernelDesc = KernelDesc {
    name: "project_triangles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/tile_rect.wgsl",
        "common/chunk.wgsl",
        "common/octahedral.wgsl",
        "common/triangle_edges.wgsl",
        "project_triangles.wgsl"
    ],
    bindings: &[
        Binding::uniform::<ProjectParams>("params"),
        Binding::uniform::<[GpuView; crate::records::MAX_VIEWS]>("views"),
        Binding::read::<Chunk>("chunks"),
        Binding::texture("triangles", Uint),
        Binding::texture_write("footprints", Rgba32Uint),
        Binding::texture_write("keys", Rg32Uint),
        Binding::texture_write("rects", Rg32Uint),
        Binding::texture_write("setups", Rgba32Uint),
    ],
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    tier: Tier::Core,
};

/// A run of casters for one view. WGSL: `wgsl/common/chunk.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Chunk {
    /// Of the batch.
    pub view: u32,
    pub first_caster: u32,
    /// At most [`CHUNK_SIZE`].
    pub count: u32,
    pub first_footprint: u32,
}
crate::gpu_layout!(Chunk { view, first_caster, count, first_footprint });

/// WGSL: `wgsl/common/chunk.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ProjectParams {
    pub chunk_count: u32,
    /// 1: tiny particles take the scatter path.
    pub scatter: u32,
    /// Footprint of the first triangle, whose setup is number 0.
    pub first_setup: u32,
    /// 1: the camera sees what casts nothing.
    pub unseen: u32,
}
crate::gpu_layout!(ProjectParams { chunk_count, scatter, first_setup, unseen });

/// Workgroups for `count` chunks or tiles: rows of a length that every adapter allows.
pub fn grid(count: u32) -> [u32; 3] {
    const MAX_X: u32 = 32768;
    [count.clamp(1, MAX_X), count.div_ceil(MAX_X).max(1), 1]
}
