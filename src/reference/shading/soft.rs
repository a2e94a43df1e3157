//! Twin of `wgsl/shade/source_area.wgsl`: transmittance from an area light to a point.
//!
//! An occluder at distance d from the light hides, from a receiver at distance r, the part of the light
//! whose image through the receiver it covers. In the map that image is a spot with the light's outline,
//! scaled by `scale (1/d - 1/r)`. Each node of a block is filtered over the spot of its own depth, so that
//! every occluder on the way has the penumbra of its distance, in colour. Spots from one power of two of
//! texels to the next are filtered on one level, over windows up to four blocks wide.
//!
//! Levels are evaluated from the widest spots to the sharpest, from the light on. Each gives the light
//! behind its depths as a share of the light before them, and the shares are multiplied: an occluder behind
//! another removes only what the first left. Blocks that no ray from the light's centre reaches hold
//! nothing about the occluders behind; there, the share is that of the nearest block that is lit.
use super::{
    Lighting, Receiver,
    receive::{Plane, Surface},
    spot::{FADE, SHARP, Spot, WIDEST},
};
use crate::{
    records::{GpuLight, level_count},
    reference::{curve::DEPTHS, resolve::BLACK},
};
use glam::Vec3;

/// Weight of a level's result per light before the level, up to a weight of 1.
pub const EVIDENCE: f32 = 300.0;
/// Least light that a search for occluders relies on.
pub const LEAST_OPEN: f32 = 0.25;
/// Distance of texels' centres from the middle of a block of the first level [blocks].
pub const AROUND: f32 = 0.25;
/// Least light to divide by.
pub const LEAST: f32 = 1e-4;

/// Light that gets past occluders behind which a level, or the map, holds nothing.
#[derive(Default)]
struct Hidden {
    light: Vec3,
    /// Last level that holds nothing; 1 for the map.
    level: u32,
    /// Fade behind which the first of them holds nothing.
    since: [f32; 2],
}

impl Hidden {
    fn add(&mut self, light: Vec3, level: u32, since: [f32; 2]) {
        if light.cmpgt(Vec3::ZERO).any() {
            self.since = if self.light == Vec3::ZERO { since } else { self.since };
            self.light += light;
            self.level = level;
        }
    }
}

/// Weight of a level's result, per channel.
fn evidence(before: Vec3) -> Vec3 {
    (before * EVIDENCE).clamp(Vec3::ZERO, Vec3::ONE)
}

impl Lighting<'_> {
    /// [`Self::receive`] for an area light. `point`: lifted off the surface.
    pub(super) fn receive_area(
        &self,
        index: usize,
        light: &GpuLight,
        point: Vec3,
        surface: Surface,
        bias: f32,
        receiver: Receiver,
    ) -> Vec3 {
        let Some(area) = light.area().map(|area| &self.records.areas[area]) else {
            return Vec3::ONE;
        };
        let leveled = area.first_leveled as usize + index - light.first_view as usize;
        let view = &self.records.views[index];
        let Some(sharp) = self.taps(index, point) else { return Vec3::ONE };
        if sharp.z > 1.0 + bias / (view.far - view.near) {
            return Vec3::ZERO;
        }
        let range = view.far - view.near;
        let gain = self.maps[index].curve.as_ref().is_some_and(|curve| curve.gain);
        let spot = Spot::new(view, light, area, surface, bias, gain);
        let level = |level| (self.levels.level(leveled, level), (1 << level) as f32);
        let last = level_count(view.size.as_uvec2());
        // Finest level whose blocks are large enough; 0 for the map.
        let level_of = |radius: f32| {
            let filters = |level: &u32| radius <= WIDEST * (1 << level) as f32;
            if radius <= SHARP { 0 } else { (1..last).find(filters).unwrap_or(last) }
        };
        let mut light = Vec3::ONE;
        let mut hidden = Hidden::default();
        // Fade of the level before.
        let (mut since, mut number) = ([-1.0; 2], last);
        // Next occluder in the window of the level before.
        let mut rest = None;
        while number > 0 {
            // It is followed where it fades into the next level or into the map. Else ever finer levels are
            // asked: coarse blocks mix what is before the receiver with what is behind it. Where no light is
            // left, they know nothing, and the wider window is believed.
            let level_at = |depth: f32, most: u32| level_of(spot.radius_at(depth)).min(most);
            let mut cue = rest.take();
            let first = cue.map_or(number, |depth| level_at(depth, number));
            if cue.is_some() && (first == number || first == 0) {
                (rest, number) = (cue, first);
            } else {
                let mut above = (first + 1).min(last);
                loop {
                    let (map, edge) = level(above);
                    let (next, open) = spot.next_occluder(map, edge, since[0], 0.0, 0.0);
                    let is_dark = cue.is_some() && open < LEAST_OPEN;
                    let is_found = is_dark || next.is_some();
                    cue = if is_dark { cue } else { next.or(cue) };
                    number = match cue {
                        None => 0,
                        Some(depth) if is_found => level_at(depth, number),
                        Some(_) => above - 2,
                    };
                    if is_dark || number == 0 || (is_found && number + 1 >= above) {
                        break;
                    }
                    above = number + 1;
                }
            }
            let Some(radius) = cue.filter(|_| number > 0).map(|depth| spot.radius_at(depth)) else {
                break;
            };
            let (map, edge) = level(number);
            // Behind skipped levels, the rest of an occluder in the last one's fade counts as before: this
            // window is far narrower than its spot.
            if since[0] > 0.0 {
                let low = spot.fade_at(WIDEST * edge);
                since = [since[0].max(low[0]), since[1].max(low[1])];
            }
            let to = spot.fade_at(if number == 1 { SHARP } else { WIDEST * edge * 0.5 });
            let widest = WIDEST * (1.0 + FADE) * edge;
            let window = spot.evaluate(map, edge, radius.min(widest), since, to);
            let known = evidence(window.before);
            let left = (window.before - window.taken).min(window.most);
            let passed = left / window.before.max(Vec3::splat(LEAST));
            hidden.add(light * (Vec3::ONE - known), number, since);
            light *= known * passed.max(Vec3::ZERO);
            if !gain {
                light = Vec3::select(light.cmplt(Vec3::splat(BLACK)), Vec3::ZERO, light);
            }
            rest = window.next;
            since = to;
            number = if light == Vec3::ZERO { 0 } else { number - 1 };
        }
        // If levels were skipped, the rest of an occluder in the last one's fade has a spot far wider than the
        // map's texels: it counts as before.
        if since[0] > 0.0 {
            since = since.map(|depth| depth.max(spot.fade_at(SHARP)[0]));
        }
        let (map, edge) = level(1);
        // The map's look-up decides which filters within the bias tint an opaque receiver.
        let beyond = if receiver.solid { 2.0 * bias / range * DEPTHS } else { 0.0 };
        let near = || spot.next_occluder(map, edge, since[0], AROUND, beyond).0.is_some();
        let through = |hidden: &Hidden| {
            let Hidden { light, level, since } = *hidden;
            let share = || spot.nearest_lit(&self.levels, leveled, [level, last], since);
            if light == Vec3::ZERO { light } else { light * share() }
        };
        if light == Vec3::ZERO || !(rest.is_some() || near()) {
            return light + through(&hidden);
        }
        // Occluders close to the receiver, from the map itself.
        let plane = Plane::new(view, surface);
        let (mut before, mut behind) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..9 {
            let (texel, weight) = sharp.tap(i);
            behind +=
                weight * self.receive_texel(index, texel, sharp.z, plane, bias / range, receiver);
            before += weight * self.light_before(index, texel, since);
        }
        let known = evidence(before);
        let passed = behind / before.max(Vec3::splat(LEAST));
        let passed = if gain { passed } else { passed.min(Vec3::ONE) };
        hidden.add(light * (Vec3::ONE - known), 1, since);
        light * known * passed + through(&hidden)
    }
}
