//! Reading of maps from a device.
use super::RenderOptions;
use crate::{
    error::Error,
    gpu::Gpu,
    model::View,
    records::{CurveMap, NO_OWNER, ViewMaps, stored_tag},
    shadows::Maps,
};
use half::f16;

/// The maps of the views that `options` ask for. `owners`: whether the maps hold owner tags.
pub(super) fn read_maps(
    gpu: &Gpu,
    maps: &Maps,
    views: &[View],
    owners: bool,
    options: &RenderOptions<'_>,
) -> Result<Vec<ViewMaps>, Error> {
    phase!("read_back");
    let filters: Vec<[u16; 4]> = gpu.try_read_texture(&maps.filters)?;
    let nearests: Vec<f32> = gpu.try_read_texture(&maps.nearests)?;
    let opaques: Vec<f32> = gpu.try_read_texture(&maps.opaques)?;
    let colored: Vec<[f32; 4]> = match &maps.colored {
        Some(colored) => gpu.try_read_texture(colored)?,
        None => Vec::new(),
    };
    let sums: Vec<[u32; 4]> = match &maps.sums {
        Some(sums) => gpu.try_read_texture(sums)?,
        None => Vec::new(),
    };
    let curves: Vec<[[u32; 2]; 2]> =
        if maps.nodes > 0 { gpu.try_read_texture(&maps.curves)? } else { Vec::new() };
    let atlas = maps.filters.size();
    let layer = (atlas.width * atlas.height) as usize;
    let nodes_of = |texel: usize| {
        let (z, rest) = (texel / layer, texel % layer);
        let pairs = maps.nodes as usize / 2;
        (0..pairs).flat_map(|pair| curves[(z * pairs + pair) * layer + rest]).collect::<Vec<_>>()
    };
    let shown = views.iter().zip(&maps.slots).filter(|(view, _)| options.shows(view));
    let view_maps = shown.map(|(view, slot)| {
        let texels = || {
            (0..view.size.y).flat_map(move |y| {
                let row = slot.layer * atlas.height + slot.origin.y + y;
                let first = (row * atlas.width + slot.origin.x) as usize;
                first..first + view.size.x as usize
            })
        };
        let owner = |t: usize| match nearests[t] {
            1.0 => NO_OWNER,
            nearest => stored_tag(f16::from_bits(filters[t][3]).to_f32(), nearest),
        };
        let rgb = |t: usize| [0, 1, 2].map(|i| f16::from_bits(filters[t][i]).to_f32());
        ViewMaps {
            view: view.clone(),
            filter: texels().map(rgb).collect(),
            nearest: texels().map(|t| nearests[t]).collect(),
            opaque: texels().map(|t| opaques[t]).collect(),
            colored: texels()
                .filter_map(|t| colored.get(t))
                .map(|&[r, g, b, _]| [r, g, b])
                .collect(),
            curve: (maps.nodes > 0).then(|| CurveMap {
                nodes: maps.nodes as usize,
                gain: maps.gain,
                packed: texels().flat_map(nodes_of).collect(),
            }),
            sums: texels().filter_map(|t| sums.get(t)).copied().collect(),
            owner: if owners { texels().map(owner).collect() } else { Vec::new() },
        }
    });
    Ok(view_maps.collect())
}
