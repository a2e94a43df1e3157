//! Mip levels of the filter map, made for all views after some of them changed.
use super::GROUP_SIZE;
use crate::shadows::{batch::context::view_uniform, views::maps::Maps};
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, level_view},
    model::View,
    records::{GpuView, MAX_VIEWS},
    stage::{
        blur::{BlurParams, FILTER_MIP},
        features::Features,
    },
};
use glam::UVec2;
use wgpu::{TextureView, TextureViewDimension::D2Array};

/// Makes the largest level first. `is_new`: some view is rendered, or has another place in the atlas.
pub(in crate::shadows) fn filter_mips(
    allocator: &mut Allocator<'_>,
    kernels: &Kernels,
    views: &[View],
    maps: &Maps,
    is_new: bool,
) -> Result<Commands, Error> {
    let mut commands = Commands::new();
    let level_count = maps.filters.mip_level_count();
    if level_count == 1 || !is_new {
        return Ok(commands);
    }
    let levels: Vec<TextureView> =
        (0..level_count).map(|level| level_view(&maps.filters, level, D2Array)).collect();
    let placed = views.iter().zip(&maps.slots);
    let all: Vec<GpuView> =
        placed.map(|(view, slot)| view.to_gpu(0, slot.origin, slot.layer)).collect();
    let largest = views.iter().fold(UVec2::ZERO, |size, view| size.max(view.size));
    let mut dispatches = Vec::new();
    for (level, pair) in (1..).zip(levels.windows(2)) {
        let value = BlurParams { level, ..BlurParams::default() };
        let params = allocator.uniform("blur_params", &value);
        for some in all.chunks(MAX_VIEWS) {
            let views = view_uniform(allocator, some);
            let resources = maps
                .resources()
                .with("filters", &pair[0])
                .with("filter_mip", &pair[1])
                .with("blur_params", &params)
                .with("views", &views);
            let groups = largest.map(|edge| edge.div_ceil(GROUP_SIZE << level));
            let groups = [groups.x, groups.y, some.len() as u32];
            dispatches.push(kernels.dispatch(&FILTER_MIP, Features::NONE, &resources, groups)?);
        }
    }
    commands.pass("gobo mips", dispatches);
    Ok(commands)
}
