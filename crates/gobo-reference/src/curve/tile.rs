//! CPU reference of `wgsl/curve/gather.wgsl` and of the stores `tile.wgsl`, `segment.wgsl` and `resolve.wgsl`
//! beside it: the curves of a tile.
//!
//! [`two_walks`] makes the curves of casters that only filter light and are no bodies; for other casters,
//! each hit is inserted into its texel's curve as it comes.
use super::{
    Affine, DEPTHS, PackedNode, Streaming,
    two_walks::{self, RayHit, RayModes},
    volumes::{Inside, Ramp},
};
use crate::{
    accumulate::VISIBLE_PRESENCE,
    caster_hit::{Hit, Records, Target},
    order::HitOrder,
    resolve::passed,
    tile::{TEXELS, Tile, TileTexels},
};
use glam::{DVec3, IVec3, Vec3};
use gobo::records::{Footprint, curve::unpack};

/// Presence below which hits set no start or end.
pub const TRACE: f32 = 1.0 / 65536.0;

/// Rounding between light as fixed-point sums and as products: smaller differences are ignored.
pub const ROUNDING: f32 = 1.0 / 2048.0;

/// Properties of a batch's curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurveModes {
    /// Nodes of a curve (K).
    pub nodes: u32,
    /// Whether light may grow.
    pub gain: bool,
    /// Curves are made by two walks: no caster is a volume, brick, strand or Gaussian, or adds light.
    pub rays: bool,
    /// The cheapest pairs of a ray's few hits are joined: some caster is no soft disc.
    pub few: bool,
    /// An `over` caster may add light.
    pub over: bool,
    /// Closed meshes absorb along the ray.
    pub volumes: bool,
    /// Some hits are bodies, in which light falls exponentially.
    pub bodies: bool,
    /// Some filtering caster is faint: hits below [`TRACE`] share a place.
    pub faint: bool,
    /// Curves are softened: one more ramp will be inserted into each.
    pub softening: bool,
    /// Pairs of a segment.
    pub segment: usize,
}

impl CurveModes {
    /// Modes of curves by two walks; `bodies`: see [`RayModes`].
    fn of_rays(self, bodies: Option<u32>) -> RayModes {
        RayModes { nodes: self.nodes, few: self.few, faint: self.faint, grows: self.gain, bodies }
    }

    /// Whether faint absorption is summed separately: if hits only filter light.
    fn keeps(self) -> bool {
        self.faint && !self.over && !self.volumes
    }
}

/// A texel after its tile was walked.
#[derive(Clone, Debug)]
pub struct CurveTexel {
    /// Its curve, front to back.
    pub nodes: Vec<PackedNode>,
    /// Transmittance of all hits.
    pub passed: Vec3,
    /// Nearest depth `D`.
    pub nearest: f32,
    /// Hits that came after one behind them, which are counted.
    pub disordered: u32,
}

/// Hits that have not been inserted into the curve.
#[derive(Clone, Copy, Debug)]
struct OpenHits {
    start: f32,
    end: f32,
    light: Affine,
}

impl OpenHits {
    const NONE: Self = Self { start: 2.0, end: 0.0, light: Affine::NONE };

    fn in_tile(&mut self, start: f32, end: f32) {
        (self.start, self.end) = (self.start.min(start), self.end.max(end));
    }
}

/// A hit of a caster, together with its volume's face, if any.
#[derive(Clone, Copy, Debug)]
struct Event {
    hit: Option<Hit>,
    /// Change of the optical depth per light depth behind it.
    change: Vec3,
}

impl Event {
    const NONE: Self = Self { hit: None, change: Vec3::ZERO };
}

#[derive(Clone, Debug)]
struct Texel {
    curve: Streaming,
    open: OpenHits,
    passed: Affine,
    /// With [`CurveModes::keeps`]: `passed`, with the absorption of each of a million faint hits.
    precise: DVec3,
    /// Presence of the hits since the last that set a start or an end, with [`CurveModes::faint`].
    traces: f32,
    /// `passed` without volumes.
    surfaces: Affine,
    nearest: f32,
    inside: Inside,
    /// Order of hits and faces, for order-dependent blending and volumes.
    order: HitOrder<Event>,
}

impl Texel {
    /// Adds a hit; returns whether it has a depth of its own.
    fn meet(&mut self, hit: &Hit, modes: CurveModes) -> bool {
        let light = Affine { scale: hit.light, added: hit.added };
        self.open.light = self.open.light.then(light);
        self.passed = self.passed.then(light);
        self.surfaces = self.surfaces.then(light);
        self.precise *= DVec3::ONE - hit.absorbed.as_dvec3();
        self.traces = if modes.faint { self.traces + hit.presence } else { hit.presence };
        let is_placed = self.traces >= TRACE;
        if is_placed {
            self.open.in_tile(hit.start, hit.end);
            self.traces = 0.0;
        }
        is_placed
    }

    /// Adds an event that left the order, and the volumes up to its depth; returns whether it must be
    /// inserted.
    fn follow_order(&mut self, depth: f32, event: &Event, modes: CurveModes) -> bool {
        let mut placed = false;
        if modes.volumes
            && let Some(ramp) = self.inside.change(depth, event.change)
        {
            self.ramp(ramp);
            self.flush(modes);
            placed = true;
        }
        // A volume's clear surface takes no node.
        let acts = |hit: &Hit| !modes.volumes || hit.light != Vec3::ONE || hit.added != Vec3::ZERO;
        event.hit.filter(acts).is_some_and(|hit| self.meet(&hit, modes)) | placed
    }

    fn flush(&mut self, modes: CurveModes) {
        if self.open.start <= 1.0 {
            let OpenHits { start, end, light } = self.open;
            if modes.keeps() {
                self.curve.insert_to(start, end, light.scale, self.precise.as_vec3());
            } else {
                self.curve.insert_affine(start, end, light.scale, light.added);
            }
            self.open = OpenHits::NONE;
        }
    }

    fn ramp(&mut self, ramp: Ramp) {
        let light = Affine { scale: ramp.light, added: Vec3::ZERO };
        self.passed = self.passed.then(light);
        self.open.light = self.open.light.then(light);
        self.open.in_tile(ramp.start, ramp.end);
        // A ramp that brightens: the curve was too dark behind a late face.
        self.curve.disordered += u32::from(ramp.light.max_element() > 1.0);
    }
}

/// Curves of tile number `index` of the view; `footprints`: of its pairs, with their depth keys, front to
/// back.
pub fn curves(
    records: Records<'_>,
    index: u32,
    footprints: &[(&Footprint, u32)],
    opaque: &TileTexels<f32>,
    modes: CurveModes,
) -> TileTexels<CurveTexel> {
    let tile = Tile::new(records.view, index);
    let fresh = Texel {
        curve: Streaming::new(modes.nodes, modes.gain).with_over(modes.over),
        open: OpenHits::NONE,
        passed: Affine::NONE,
        precise: DVec3::ONE,
        traces: 0.0,
        surfaces: Affine::NONE,
        nearest: 1.0,
        inside: Inside::default(),
        order: HitOrder::new(Event::NONE),
    };
    let mut texels = TileTexels::filled(fresh.clone());
    if modes.rays {
        if footprints.len() <= modes.segment {
            let bodies = modes.bodies.then_some(u32::from(modes.softening));
            return by_two_walks(records, &tile, footprints, opaque, modes.of_rays(bodies));
        }
        let of_rays = modes.of_rays(None);
        let partials: Vec<_> = footprints
            .chunks(modes.segment)
            .map(|segment| by_two_walks(records, &tile, segment, opaque, of_rays))
            .collect();
        return resolved(&partials, of_rays);
    } else if footprints.len() <= modes.segment {
        walk(records, &tile, footprints, opaque, &mut texels, modes);
    } else {
        for segment in footprints.chunks(modes.segment) {
            let mut partial = TileTexels::filled(fresh.clone());
            walk(records, &tile, segment, opaque, &mut partial, modes);
            for in_tile in 0..TEXELS {
                follow(&mut texels[in_tile], &partial[in_tile], modes);
            }
        }
    }
    for in_tile in 0..TEXELS {
        finish(&mut texels[in_tile], modes);
        // With `over`, light may grow inside a body; ramps of several segments are merged ones.
        if modes.bodies && !modes.over && footprints.len() <= modes.segment {
            texels[in_tile].curve.split_bodies(usize::from(modes.softening));
        }
    }
    let mut done = TileTexels::filled(CurveTexel {
        nodes: Vec::new(),
        passed: Vec3::ONE,
        nearest: 1.0,
        disordered: 0,
    });
    for in_tile in 0..TEXELS {
        let Texel { curve, passed, nearest, .. } = &texels[in_tile];
        let (passed, nearest) = (passed.scale + passed.added, *nearest);
        let nodes = curve.pack().collect();
        done[in_tile] = CurveTexel { nodes, passed, nearest, disordered: curve.disordered };
    }
    done
}

/// Curves of hits that only filter light.
fn by_two_walks(
    records: Records<'_>,
    tile: &Tile,
    pairs: &[(&Footprint, u32)],
    opaque: &TileTexels<f32>,
    modes: RayModes,
) -> TileTexels<CurveTexel> {
    let mut hits = TileTexels::filled(Vec::new());
    let mut nearest = TileTexels::filled(1.0_f32);
    for target in pairs.iter().map(|pair| Target::new(records, pair.0)) {
        if !target.filters() {
            continue;
        }
        for (in_tile, at) in target.texels(tile) {
            let hit = target.hit(at, opaque[in_tile]);
            let Some(hit) = hit.filter(|hit| hit.depth < opaque[in_tile]) else { continue };
            let Hit { start, end, absorbed, presence, .. } = hit;
            if presence >= VISIBLE_PRESENCE {
                nearest[in_tile] = nearest[in_tile].min(hit.depth);
            }
            hits[in_tile].push(RayHit { start, end, absorbed, presence });
        }
    }
    let fresh = CurveTexel { nodes: Vec::new(), passed: Vec3::ONE, nearest: 1.0, disordered: 0 };
    let mut done = TileTexels::filled(fresh);
    for in_tile in 0..TEXELS {
        let (nodes, passed) = two_walks::curve(&hits[in_tile], modes);
        done[in_tile] = CurveTexel { nodes, passed, nearest: nearest[in_tile], disordered: 0 };
    }
    done
}

/// Joins the curves of a tile's segments: their nodes are inserted as hits.
fn resolved(segments: &[TileTexels<CurveTexel>], modes: RayModes) -> TileTexels<CurveTexel> {
    let mut done = segments[0].clone();
    for in_tile in 0..TEXELS {
        let mut hits = Vec::new();
        let (mut passed, mut nearest) = (Vec3::ONE, 1.0_f32);
        for segment in segments.iter().map(|segment| &segment[in_tile]) {
            passed *= segment.passed;
            nearest = nearest.min(segment.nearest);
            for &node in &segment.nodes {
                let (start, length, passed) = unpack(node, modes.grows);
                let (start, end) = (start / DEPTHS, (start + length) / DEPTHS);
                let hit = RayHit { start, end, absorbed: Vec3::ONE - passed, presence: TRACE };
                hits.extend((start > 0.0).then_some(hit));
            }
        }
        let (nodes, _) = two_walks::curve(&hits, RayModes { few: true, ..modes });
        done[in_tile] = CurveTexel { nodes, passed, nearest, disordered: 0 };
    }
    done
}

/// Composes a segment behind those before it.
fn follow(texel: &mut Texel, segment: &Texel, modes: CurveModes) {
    if modes.volumes
        && let Some(ramp) = texel.inside.follow(&segment.inside)
    {
        texel.ramp(ramp);
        texel.flush(modes);
    }
    let nodes: Vec<_> = segment.curve.pack().collect();
    texel.curve.append(&nodes, modes.over.then_some(segment.passed));
    texel.curve.disordered += segment.curve.disordered;
    texel.passed = texel.passed.then(segment.passed);
    texel.surfaces = texel.surfaces.then(segment.surfaces);
    texel.nearest = texel.nearest.min(segment.nearest);
}

/// Adds the absorption of volumes that no pair of faces has shown.
fn finish(texel: &mut Texel, modes: CurveModes) {
    if modes.volumes {
        for ramp in texel.inside.begin().into_iter().flatten() {
            texel.ramp(ramp);
            texel.flush(modes);
        }
    }
    let mut light = Vec3::ONE;
    if modes.volumes {
        // The sums of the faces are those of nearest-depth mode.
        let tau = texel.inside.tau;
        let tau = if modes.gain { tau } else { tau.max(IVec3::ZERO) };
        let is = texel.passed.scale + texel.passed.added;
        let should = (texel.surfaces.scale + texel.surfaces.added) * passed(tau);
        light = should / is.max(Vec3::splat(1e-9));
        if (light - Vec3::ONE).abs().max_element() < ROUNDING {
            light = Vec3::ONE;
        }
    }
    if light != Vec3::ONE {
        let depth = texel.nearest.max(texel.curve.last_end());
        texel.curve.insert(depth, depth, light);
        texel.passed = texel.passed.then(Affine { scale: light, added: Vec3::ZERO });
    }
    if texel.inside.leaves > 0 {
        // The light is inside a volume.
        texel.nearest = 0.0;
    }
}

fn walk(
    records: Records<'_>,
    tile: &Tile,
    pairs: &[(&Footprint, u32)],
    opaque: &TileTexels<f32>,
    texels: &mut TileTexels<Texel>,
    modes: CurveModes,
) {
    for target in pairs.iter().map(|pair| Target::new(records, pair.0)) {
        if !target.filters() {
            continue;
        }
        for (in_tile, at) in target.texels(tile) {
            let texel = &mut texels[in_tile];
            let face = target.face(at, opaque[in_tile]).filter(|_| modes.volumes);
            let count = target.ramp_count(modes.nodes);
            for part in 0..count {
                let hit = target.ramp_hit(at, opaque[in_tile], [part, count]);
                let hit = hit.filter(|hit| hit.depth < opaque[in_tile]);
                if let Some(hit) = hit.filter(|hit| hit.presence >= VISIBLE_PRESENCE) {
                    texel.nearest = texel.nearest.min(hit.depth);
                }
                let mut placed = false;
                if modes.over || modes.volumes {
                    let change = face.map_or(Vec3::ZERO, |face| texel.inside.count(&face));
                    if let Some(depth) = face.map(|face| face.depth).or(hit.map(|hit| hit.start))
                        && let Some((depth, event)) = texel.order.push(depth, Event { hit, change })
                    {
                        placed = texel.follow_order(depth, &event, modes);
                    }
                } else if let Some(hit) = hit {
                    placed = texel.meet(&hit, modes);
                }
                if placed {
                    texel.flush(modes);
                }
            }
        }
    }
    for in_tile in 0..TEXELS {
        let texel = &mut texels[in_tile];
        texel.flush(modes);
        let waiting: Vec<_> = texel.order.drain().collect();
        for (depth, event) in waiting {
            texel.follow_order(depth, &event, modes);
            texel.flush(modes);
        }
        if modes.keeps() {
            texel.passed.scale = texel.precise.as_vec3();
        }
    }
}
