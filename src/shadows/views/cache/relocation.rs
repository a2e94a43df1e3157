//! Copies cached maps to their new rectangles, where the atlas was packed anew.
use crate::shadows::views::maps::Maps;
use crate::{frame::Commands, gpu::Memory, model::View, view::atlas::MapSlot};
use glam::UVec2;

/// Cached maps in their old rectangles, and their moves.
#[derive(Debug)]
pub(in crate::shadows) struct Relocation {
    maps: Maps,
    /// Maps before softening.
    raw: Option<Maps>,
    moves: Vec<Move>,
}

#[derive(Clone, Copy, Debug)]
struct Move {
    from: MapSlot,
    to: MapSlot,
    /// Size of the map \[texels\].
    size: UVec2,
}

impl Relocation {
    /// Moves the views `kept` of `old`, and of `raw`, its maps before softening, to their rectangles in
    /// `maps`. `None` if no view is kept.
    pub(in crate::shadows) fn new(
        old: Maps,
        raw: Option<Maps>,
        kept: impl Iterator<Item = usize>,
        views: &[View],
        maps: &Maps,
    ) -> Option<Self> {
        let moves: Vec<_> = kept
            .map(|index| Move {
                from: old.slots[index],
                to: maps.slots[index],
                size: views[index].size,
            })
            .collect();
        (!moves.is_empty()).then_some(Self { maps: old, raw, moves })
    }

    pub(in crate::shadows) fn count(&self, memory: &mut Memory) {
        for texture in self.raw.iter().chain([&self.maps]).flat_map(Maps::textures) {
            let size = texture.size();
            let texels =
                u64::from(size.width * size.height) * u64::from(size.depth_or_array_layers);
            let bytes = texture.format().block_copy_size(None).unwrap_or(4);
            memory.add("moved_maps", texels * u64::from(bytes));
        }
    }

    /// The copies, into `maps` and their maps before softening.
    pub(in crate::shadows) fn commands(&self, maps: &Maps, raw: Option<&Maps>) -> Commands {
        let mut commands = Commands::new();
        let raw = self.raw.as_ref().zip(raw);
        for (old, new) in [(&self.maps, maps)].into_iter().chain(raw) {
            for (old, new) in old.textures().into_iter().zip(new.textures()) {
                for &Move { from, to, size } in &self.moves {
                    let at = |texture, slot: MapSlot| wgpu::TexelCopyTextureInfo {
                        texture,
                        mip_level: 0,
                        origin: wgpu::Origin3d {
                            x: slot.origin.x,
                            y: slot.origin.y,
                            z: slot.layer,
                        },
                        aspect: wgpu::TextureAspect::All,
                    };
                    let extent =
                        wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
                    commands.copy_texture("gobo move", at(old, from), at(new, to), extent);
                }
            }
        }
        commands
    }
}
