//! Maps that stay as they are but change their places: those of an atlas that was packed anew.
use super::{filter::Filter, maps::Maps};
use crate::{gpu::Memory, model::View, view::atlas::MapPlace};
use glam::UVec2;

/// Where kept maps are until they are recorded.
#[derive(Debug)]
pub(super) struct Moved {
    maps: Maps,
    /// As in [`Filter`].
    raw: Option<Maps>,
    moves: Vec<Move>,
}

#[derive(Clone, Copy, Debug)]
struct Move {
    from: MapPlace,
    to: MapPlace,
    /// [texels]
    size: UVec2,
}

impl Moved {
    /// The views `kept` of `old` to their places in `maps`. `None` where there are none.
    pub(super) fn new(
        old: Maps,
        old_filter: Option<Filter>,
        kept: impl Iterator<Item = usize>,
        views: &[View],
        maps: &Maps,
    ) -> Option<Self> {
        let moves: Vec<_> = kept
            .map(|index| Move {
                from: old.places[index],
                to: maps.places[index],
                size: views[index].size,
            })
            .collect();
        let raw = old_filter.map(|filter| filter.raw);
        (!moves.is_empty()).then_some(Self { maps: old, raw, moves })
    }

    pub(super) fn count(&self, memory: &mut Memory) {
        for texture in self.raw.iter().chain([&self.maps]).flat_map(Maps::textures) {
            let size = texture.size();
            let texels =
                u64::from(size.width * size.height) * u64::from(size.depth_or_array_layers);
            let bytes = texture.format().block_copy_size(None).unwrap_or(4);
            memory.add("moved_maps", texels * u64::from(bytes));
        }
    }

    pub(super) fn record(
        &self,
        maps: &Maps,
        filter: Option<&Filter>,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let raw = self.raw.as_ref().zip(filter.map(|filter| &filter.raw));
        for (old, new) in [(&self.maps, maps)].into_iter().chain(raw) {
            for (old, new) in old.textures().into_iter().zip(new.textures()) {
                for &Move { from, to, size } in &self.moves {
                    let at = |texture, place: MapPlace| wgpu::TexelCopyTextureInfo {
                        texture,
                        mip_level: 0,
                        origin: wgpu::Origin3d {
                            x: place.origin.x,
                            y: place.origin.y,
                            z: place.layer,
                        },
                        aspect: wgpu::TextureAspect::All,
                    };
                    let extent =
                        wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
                    encoder.copy_texture_to_texture(at(old, from), at(new, to), extent);
                }
            }
        }
    }
}
