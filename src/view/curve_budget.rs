//! Curves within their budget of bytes: fewer nodes, then none.
use super::atlas::{Atlas, AtlasLimits, area, rectangle};
use crate::model::{Receiver, ShadowSettings, View};
use glam::UVec2;

/// Fewest nodes of a curve.
const LEAST: u32 = 4;
/// Size of a node \[bytes\].
pub(crate) const NODE_BYTES: u64 = 8;

impl ShadowSettings {
    /// These settings with as many nodes as the curves of `views` have within [`Self::curve_budget`]: half of
    /// them until they fit, and [`Receiver::Nearest`] where four do not. What [`Shadows`](crate::Shadows)
    /// renders; a host whose maps must not change when views are added asks with all of them.
    #[must_use]
    pub fn within_curve_budget(&self, views: &[View]) -> Self {
        let mut settings = *self;
        let sizes: Vec<UVec2> = views.iter().map(|view| view.size).collect();
        while settings.curve_nodes() > 0 && !settings.fit(&sizes) {
            if settings.nodes > LEAST {
                settings.nodes /= 2;
            } else {
                settings.receiver = Receiver::Nearest;
            }
        }
        settings
    }

    fn fit(&self, sizes: &[UVec2]) -> bool {
        // Softening writes other curves than it reads.
        let copies = 1 + u64::from(self.soften);
        let texel = copies * u64::from(self.nodes) * NODE_BYTES;
        let within = |texels: u64| texels.saturating_mul(texel) <= self.curve_budget;
        let areas = sizes.iter().map(|&size| area(rectangle(size)));
        // Layers as large as the largest map, a map each, are an atlas, too.
        if within(areas.clone().max().unwrap_or(0).saturating_mul(sizes.len() as u64)) {
            return true;
        }
        let limits =
            AtlasLimits { layers: AtlasLimits::CORE.layers * 2 / self.nodes, ..AtlasLimits::CORE };
        within(areas.sum())
            && Atlas::pack(sizes, &limits).is_none_or(|atlas| within(atlas.texels()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Bounds, Camera};

    fn views(sizes: &[u32]) -> Vec<View> {
        let view = View::from_camera(&Camera::default(), &Bounds::EMPTY);
        sizes.iter().map(|&size| View { size: UVec2::splat(size), ..view.clone() }).collect()
    }

    #[test]
    fn nodes_are_halved_until_they_fit() {
        let given = |nodes, soften, sizes: &[u32], curve_budget| {
            let asked = ShadowSettings { nodes, soften, curve_budget, ..Default::default() };
            let fitting = asked.within_curve_budget(&views(sizes));
            let back = ShadowSettings { receiver: Receiver::Curve, nodes, ..fitting };
            assert_eq!(back, asked, "other settings stay");
            fitting.curve_nodes()
        };
        // 64 x 64 texels of 8 nodes of 8 bytes are 2^18 bytes.
        assert_eq!(given(8, false, &[64], 1 << 18), 8);
        assert_eq!(given(8, false, &[64], (1 << 18) - 1), 4);
        assert_eq!(given(8, false, &[64], 1 << 17), 4);
        assert_eq!(given(8, false, &[64], (1 << 17) - 1), 0);
        assert_eq!(given(16, false, &[64], 1 << 18), 8);
        assert_eq!(given(16, false, &[64], 1 << 17), 4);
        assert_eq!(given(8, true, &[64], 1 << 18), 4);
        assert_eq!(given(8, false, &[64; 4], 1 << 20), 8);
        assert_eq!(given(8, false, &[64; 5], 1 << 20), 4);
        // Maps are whole tiles, four beside each other: 66 x 66 texels take 128 x 80.
        assert_eq!(given(8, false, &[66], 64 * 128 * 80), 8);
        assert_eq!(given(8, false, &[66], 64 * 128 * 80 - 1), 4);
        // Two that are smaller share a layer; where none does, layers have more texels than maps.
        assert_eq!(given(8, false, &[64, 32, 32], 64 * 64 * 128), 8);
        assert_eq!(given(8, false, &[64, 32, 32], 64 * 64 * 128 - 1), 4);
        assert_eq!(given(8, false, &[64, 48], 64 * 64 * (64 + 48)), 4);
        assert_eq!(given(8, false, &[], 0), 8);
    }

    /// Settings that state nothing: 8 nodes for 32 maps of 1024 x 1024, 4 for twice as many.
    #[test]
    fn an_enormous_scene_has_fewer_nodes_by_default() {
        for (maps, nodes) in [(1, 8), (32, 8), (33, 4), (64, 4), (65, 0), (1537, 0)] {
            let fitting = ShadowSettings::default().within_curve_budget(&views(&vec![1024; maps]));
            assert_eq!(fitting.curve_nodes(), nodes, "{maps} maps");
        }
    }
}
