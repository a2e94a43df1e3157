//! Reading of maps from a device.
use super::RenderOptions;
use glam::UVec2;
use gobo::{
    Error,
    gpu::Gpu,
    model::View,
    records::{CausticTexel, CurveMap, NO_OWNER, PackedNode, ViewMaps, stored_tag},
    shadows::{Caustics, Maps},
    view::atlas::MapSlot,
};
use half::f16;

/// The maps of the views that `options` ask for. `owners`: whether the maps hold owner tags.
pub(super) fn read_maps(
    gpu: &Gpu,
    maps: &Maps,
    views: &[View],
    owners: bool,
    caustics: Option<&Caustics>,
    options: &RenderOptions<'_>,
) -> Result<Vec<ViewMaps>, Error> {
    let _phase = tracing::debug_span!("read_back").entered();
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
    let thrown: Vec<CausticTexel> = match caustics {
        Some(caustics) => gpu.try_read(&caustics.texels)?,
        None => Vec::new(),
    };
    let first = |index: usize| caustics.map_or(0, |caustics| caustics.firsts[index] as usize);
    let views = views.iter().enumerate();
    let shown: Vec<_> =
        views.zip(&maps.slots).filter(|((_, view), _)| options.shows(view)).collect();
    let slots: Vec<_> = shown.iter().map(|((_, view), slot)| (view.size, **slot)).collect();
    let mut curves = read_curves(gpu, maps, &slots)?.into_iter();
    let atlas = maps.filters.size();
    let view_maps = shown.into_iter().map(|((index, view), slot)| {
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
            curve: curves.next(),
            caustics: match first(index) {
                0 => Vec::new(),
                first => thrown[first..][..view.size.element_product() as usize].to_vec(),
            },
            sums: texels().filter_map(|t| sums.get(t)).copied().collect(),
            owner: if owners { texels().map(owner).collect() } else { Vec::new() },
        }
    });
    Ok(view_maps.collect())
}

/// The curves of views, with their sizes and rectangles; empty if the maps have none. Read row by row: they
/// are the largest maps.
fn read_curves(gpu: &Gpu, maps: &Maps, views: &[(UVec2, MapSlot)]) -> Result<Vec<CurveMap>, Error> {
    let nodes = maps.nodes as usize;
    if nodes == 0 {
        return Ok(Vec::new());
    }
    let curve = |&(size, _): &(UVec2, MapSlot)| {
        let packed = vec![PackedNode::default(); size.element_product() as usize * nodes];
        CurveMap { nodes, gain: maps.gain, packed }
    };
    let mut curves: Vec<_> = views.iter().map(curve).collect();
    let (height, pairs, mut number) = (maps.curves.height(), maps.nodes / 2, 0);
    gpu.read_rows(&maps.curves, |row: &[[PackedNode; 2]]| {
        let (y, layer, pair) = (number % height, number / height / pairs, number / height % pairs);
        number += 1;
        for ((size, slot), curve) in views.iter().zip(&mut curves) {
            let in_view = y.wrapping_sub(slot.origin.y);
            if layer != slot.layer || in_view >= size.y {
                continue;
            }
            let (from, width) = (slot.origin.x as usize, size.x as usize);
            let texels = curve.packed[in_view as usize * width * nodes..].chunks_exact_mut(nodes);
            for (texel, two) in texels.zip(&row[from..from + width]) {
                texel[2 * pair as usize..][..2].copy_from_slice(two);
            }
        }
    })?;
    Ok(curves)
}
