//! Coloured dithering: each channel dithers for itself, into an opaque depth of its own, so that
//! three depth maps hold coloured layers in any order (McGuire and Enderton 2011). An option for
//! engines without filters; the twin only.
use super::{
    caster_hit::{Records, Target},
    filter::filter,
    maps::SceneRecords,
    project::ProjectParams,
    tile::Tile,
};
use crate::{frame::ViewMaps, scene::Scene, view::View};
use glam::{UVec2, Vec3};

/// A view's opaque depths by channel.
#[derive(Clone, Debug)]
pub struct ColoredMaps {
    /// Of red, green and blue: `opaque` holds the channel's depth.
    pub channels: [ViewMaps; 3],
}

impl ColoredMaps {
    /// Light that reaches light depth `z` at texel `at`.
    pub fn light(&self, at: usize, z: f32, bias: f32) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|channel| {
            let maps = &self.channels[channel];
            let texel = super::MapTexel {
                filter: maps.filter[at].into(),
                nearest: maps.nearest[at],
                opaque: maps.opaque[at],
            };
            super::receive(z, &texel, bias)[channel]
        }))
    }

    /// As `filter` does; `window` as in [`crate::dither::window`].
    pub fn soften(&mut self, window: u32) {
        for maps in &mut self.channels {
            filter(maps, window);
        }
    }
}

/// Every caster that filters dithers by its material's pattern: a channel of transmittance `T` is
/// blocked where `1 - T` exceeds the channel's own threshold.
pub fn render_colored(scene: &Scene, view: &View) -> ColoredMaps {
    let records = SceneRecords::new(scene);
    let gpu_view = view.to_gpu(0, UVec2::ZERO, 0);
    let casters = records.project(&gpu_view, ProjectParams { scatter: false, unseen: false });
    let hits = Records {
        view: &gpu_view,
        casters: &records.casters,
        setups: &casters.setups,
        materials: records.materials,
        absorptions: &records.absorptions,
        images: &records.images,
    };
    let texels = view.size.element_product() as usize;
    let empty = || ViewMaps {
        view: view.clone(),
        filter: vec![[1.0; 3]; texels],
        nearest: vec![1.0; texels],
        opaque: vec![1.0; texels],
        curve: None,
        owner: Vec::new(),
    };
    let mut channels = [empty(), empty(), empty()];
    for (footprint, rect) in casters.footprints.iter().zip(&casters.rects) {
        for (x, y) in rect.tiles() {
            let target = Target::new(hits, footprint);
            for (_, texel) in Tile::new(&gpu_view, y * gpu_view.tiles_x + x).texels() {
                let Some(hit) = target.hit(texel, 1.0) else { continue };
                let at = (texel.y as u32 * view.size.x + texel.x as u32) as usize;
                for (channel, maps) in channels.iter_mut().enumerate() {
                    let whole = target.material.transfer.is_opaque();
                    let passed = if whole { 0.0 } else { hit.light[channel] };
                    if 1.0 - passed > target.channel_threshold(texel, channel as u32) {
                        let bits = hit.depth.to_bits() & !1 | u32::from(!whole);
                        maps.opaque[at] = maps.opaque[at].min(f32::from_bits(bits));
                    }
                }
            }
        }
    }
    ColoredMaps { channels }
}
