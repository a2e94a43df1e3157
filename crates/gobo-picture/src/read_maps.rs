//! Reading of maps from a device.
use super::RenderOptions;
use glam::{UVec2, Vec3};
use gobo::{
    Error,
    gpu::Gpu,
    model::{TILE_SIZE, View},
    records::{CausticTexel, CurveMap, NO_OWNER, PackedNode, ViewMaps, curve::packed, stored_tag},
    shadows::{Caustics, Maps},
    view::atlas::MapSlot,
};
use half::f16;
use rayon::prelude::*;

/// The maps of the views that `options` ask for. `owners`: whether the maps hold owner tags.
pub(super) fn read_maps(
    gpu: &Gpu,
    maps: &Maps,
    views: &[View],
    owners: bool,
    caustics: Option<&Caustics>,
    options: &RenderOptions<'_>,
    curves: Option<&DeviceCurves>,
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
    let atlas = maps.filters.size();
    let view_maps = shown.into_iter().enumerate().map(|(number, ((index, view), slot))| {
        let mut curve = curves.map(DeviceCurves::empty);
        if let (Some(curve), Some(curves), false) = (&mut curve, curves, options.curves_stay) {
            curve.packed.reserve_exact(view.size.element_product() as usize * curve.nodes);
            curves.read(gpu, number, |some| {
                curve.packed.extend_from_slice(&some.packed);
                Ok::<_, Error>(())
            })?;
        }
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
        Ok(ViewMaps {
            view: view.clone(),
            filter: texels().map(rgb).collect(),
            nearest: texels().map(|t| nearests[t]).collect(),
            opaque: texels().map(|t| opaques[t]).collect(),
            colored: texels()
                .filter_map(|t| colored.get(t))
                .map(|&[r, g, b, _]| [r, g, b])
                .collect(),
            curve,
            caustics: match first(index) {
                0 => Vec::new(),
                first => thrown[first..][..view.size.element_product() as usize].to_vec(),
            },
            sums: texels().filter_map(|t| sums.get(t)).copied().collect(),
            owner: if owners { texels().map(owner).collect() } else { Vec::new() },
        })
    });
    view_maps.collect()
}

/// The curves of views on the device.
#[derive(Debug)]
pub(super) struct DeviceCurves {
    maps: Maps,
    /// Size and rectangle of each view.
    places: Vec<(UVec2, MapSlot)>,
}

impl DeviceCurves {
    /// Those of the views whose maps `options` ask for; none without curves.
    pub(super) fn of(maps: &Maps, views: &[View], options: &RenderOptions<'_>) -> Option<Self> {
        let shown = views.iter().zip(&maps.slots).filter(|(view, _)| options.shows(view));
        let places = shown.map(|(view, slot)| (view.size, *slot)).collect();
        (maps.nodes > 0).then(|| Self { maps: maps.clone(), places })
    }

    /// Curves of no texels.
    pub(super) fn empty(&self) -> CurveMap {
        CurveMap { nodes: self.maps.nodes as usize, gain: self.maps.gain, packed: Vec::new() }
    }

    /// Gives the texels of a view in turn, some rows at a time; `number`: of the views that are shown.
    pub(super) fn read<E: From<Error>>(
        &self,
        gpu: &Gpu,
        number: usize,
        mut take: impl FnMut(&CurveMap) -> Result<(), E>,
    ) -> Result<(), E> {
        /// Nodes that are read at once.
        const MOST: u32 = 1 << 21;
        const TILE: usize = TILE_SIZE as usize;
        let (size, slot) = self.places[number];
        let maps = &self.maps;
        let (nodes, pairs) = (maps.nodes as usize, maps.nodes as usize / 2);
        let unused = packed(0, 0.0, Vec3::ONE, maps.gain);
        // Tiles without a caster may be zeros.
        let used = |node: PackedNode| if node == PackedNode::default() { unused } else { node };
        let places = maps.curve_places(gpu, slot, size)?;
        let (across, width) = (size.x.div_ceil(TILE_SIZE) as usize, size.x as usize);
        let most = (MOST / (size.x * TILE_SIZE * maps.nodes)).max(1) as usize;
        let part = wgpu::Extent3d {
            width: TILE_SIZE,
            height: TILE_SIZE,
            depth_or_array_layers: pairs as u32,
        };
        let mut curve = self.empty();
        for (some, first) in places.chunks(most * across).zip((0..).step_by(most * TILE)) {
            let height = (some.len() / across * TILE).min(size.y as usize - first);
            curve.packed.clear();
            curve.packed.resize(height * width * nodes, unused);
            // Pages are read one behind the other.
            let pages: Vec<_> = some.iter().flatten().copied().collect();
            let mut number = 0..;
            let numbers: Vec<_> =
                some.iter().map(|place| place.and_then(|_| number.next())).collect();
            let fill = |rows: &[&[[PackedNode; 2]]]| {
                let lines = curve.packed.par_chunks_exact_mut(width * nodes);
                lines.enumerate().for_each(|(y, line)| {
                    let numbers = &numbers[y / TILE * across..][..across];
                    for (tile, number) in line.chunks_mut(TILE * nodes).zip(numbers) {
                        let Some(number) = number else { continue };
                        let twos = tile.as_chunks_mut::<2>().0.chunks_exact_mut(pairs);
                        for (x, twos) in twos.enumerate() {
                            for (pair, two) in twos.iter_mut().enumerate() {
                                let row = (number * pairs + pair) * TILE + y % TILE;
                                *two = rows[row][x].map(used);
                            }
                        }
                    }
                });
            };
            tracing::debug_span!("read_back")
                .in_scope(|| gpu.read_parts(&maps.curves, &pages, part, fill))?;
            take(&curve)?;
        }
        Ok(())
    }
}
