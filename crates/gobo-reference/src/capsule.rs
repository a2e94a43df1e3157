//! CPU reference of `wgsl/hit/capsule.wgsl` and `wgsl/project/extent.wgsl`: segments of strands.
//!
//! A capsule is the part of a cone between two planes. Along a ray inside it, opacity accumulates with the
//! length in local diameters, `s = integral of dl / (2 r)`: `T = (1 - a (1 - c))^s`, so that a ray straight
//! through the axis meets the opacity `a`. Where the cone is thinner than a texel at its point closest to the
//! ray, it becomes a texel wide, and the ray's path through the whole cone, of `S` diameters, covers the
//! texel by the ratio of radii: `T = (1 - thin (1 - (1 - a (1 - c))^S))^(s / S)`. Both multiply over the
//! pieces of a strand.
use super::{
    caster_hit::Hit,
    gaussian::ENDLESS,
    hit::absorption,
    project::{ProjectParams, Projected, SLACK, TexelBox, depth_key, tangents, tile_rect},
};
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles as _};
use gobo::{
    model::{TILE_SIZE, Transfer, mitre},
    records::{
        CAPSULE_MARK, CapsuleRecord, CasterRecord, Footprint, GpuMaterial, GpuView, MIN_RADIUS,
        TileRect,
    },
};

/// Least squared sine between a ray and the axis.
pub const PARALLEL: f32 = 1e-8;
/// Longest path that covers anything: beyond it the capsule is seen along its axis \[diameters\].
pub const LONGEST_WAY: f32 = 1e6;
/// Largest change of the radius along a ray, in mean radii.
pub const TIP: f32 = 0.9999;
/// Least transmittance of a diameter, so that its optical depth is finite.
pub const LEAST_PASSED: f32 = 1e-9;

/// The touched tiles of a small rectangle.
fn touched_tiles(rect: TileRect, touches: impl Fn(Vec2, Vec2) -> bool) -> TileRect {
    let (xs, ys) = (rect.x(), rect.y());
    let (x0, y0) = (*xs.start(), *ys.start());
    if xs.end() - x0 >= 4 || ys.end() - y0 >= 4 {
        return rect;
    }
    let mut mask = 0;
    for (x, y) in rect.tiles(None) {
        let lo = Vec2::new(x as f32, y as f32) * TILE_SIZE as f32 + 0.5;
        if touches(lo, lo + (TILE_SIZE - 1) as f32) {
            mask |= 1 << ((y - y0) * 4 + x - x0);
        }
    }
    if mask == 0 {
        return TileRect::EMPTY;
    }
    TileRect { mask_view: rect.mask_view & 0xffff_0000 | mask, ..rect }
}

/// Components to the right, down and along the axis.
fn to_map(v: Vec3) -> Vec3 {
    v * Vec3::new(1.0, -1.0, -1.0)
}

/// A capsule in a view, in components to the right, down and along the view's axis \[m\].
#[derive(Clone, Copy, Debug)]
pub struct CapsuleSetup {
    first: Vec3,
    /// Direction of its axis, unit.
    axis: Vec3,
    length: f32,
    planes: [Vec3; 2],
    /// Its radius, and the least visible radius.
    taper: Line,
    least: Line,
}

/// A radius that is linear along the axis.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// At the first end \[m\].
    start: f32,
    slope: f32,
}

impl Line {
    fn new([first, last]: [f32; 2], length: f32) -> Self {
        Self { start: first, slope: (last - first) / length }
    }

    fn at(self, point: f32) -> f32 {
        self.start + self.slope * point
    }

    /// Integral of 1 / (2 r) along a ray: over `length` steps of `metres` each, `step` along the axis each;
    /// `point`: their middle along the axis.
    fn diameters(self, point: f32, step: f32, length: f32, metres: f32) -> f32 {
        let mean = self.at(point);
        let rise = (0.5 * self.slope * step * length / mean).clamp(-TIP, TIP);
        let square = rise * rise;
        // The integral of 1 / r over a linear r.
        let stretch = if rise.abs() < 0.1 {
            1.0 + square * (1.0 / 3.0 + square * 0.2)
        } else {
            rise.atanh() / rise
        };
        if mean > 0.0 { metres * length / (2.0 * mean) * stretch } else { 0.0 }
    }
}

/// Least visible radius at a place in view space \[m\]; negative behind the eye, where no ray is.
fn least_radius(view: &GpuView, along: f32) -> f32 {
    MIN_RADIUS * if view.perspective > 0.0 { along } else { 1.0 } / view.scale
}

impl CapsuleSetup {
    /// Sets a capsule up for the texels of a view.
    pub fn new(view: &GpuView, record: &CapsuleRecord) -> Self {
        let ends = [record.first, record.last]
            .map(|end| to_map(view.view_from_world.transform_point3(end)));
        let planes = [record.first_plane, record.last_plane]
            .map(|normal| to_map(view.view_from_world.transform_vector3(normal)));
        let [first, last] = ends;
        let length = first.distance(last).max(f32::MIN_POSITIVE);
        let taper = Line::new([record.first_radius, record.last_radius], length);
        let least = Line::new(ends.map(|end| least_radius(view, end.z)), length);
        Self { first, axis: (last - first) / length, length, planes, taper, least }
    }

    /// Path of the ray through `texel` inside the capsule, up to light depth `opaque_depth`.
    fn passage(&self, view: &GpuView, texel: Vec2, opaque_depth: f32) -> Option<Way> {
        let slope = (texel - view.size * 0.5) / view.scale;
        let (start, way) = if view.perspective > 0.0 {
            (Vec3::ZERO, slope.extend(1.0))
        } else {
            (slope.extend(0.0), Vec3::Z)
        };
        // Relative to the first end, from the ray's closest point to it.
        let square = way.length_squared();
        let to_first = self.first - start;
        let closest = to_first.dot(way) / square;
        let off = way * closest - to_first;
        let (begin, step) = (off.dot(self.axis), way.dot(self.axis));
        let across = self.axis.cross(way);
        let (turn, least_turn) = (across.length_squared(), PARALLEL * square);
        let is_along = turn < least_turn;
        let sine = turn.max(least_turn);
        // The ray's point closest to the axis. A ray along the axis keeps its distance: its start.
        let (middle, miss2) = if is_along {
            let start = (begin + (view.near - closest) * step).clamp(0.0, self.length);
            ((start - begin) / step, (off - self.axis * begin).length_squared())
        } else {
            (begin * step / sine, off.dot(across).powi(2) / sine)
        };
        let closest_place = begin + middle * step;
        // One cone for the whole ray, the same for all pieces of a strand.
        let nearest = closest_place.clamp(0.0, self.length);
        let is_thin = self.taper.at(nearest) < self.least.at(nearest);
        let line = if is_thin { self.least } else { self.taper };
        let radius = line.at(closest_place);
        let grows = line.slope * step;
        let open = sine - grows * grows;
        let square_root = sine * radius * radius - open * miss2;
        if square_root.is_nan() || square_root < 0.0 {
            return None;
        }
        let b = radius * grows;
        let q = b + square_root.sqrt().copysign(b);
        // Both are 0 for a ray from the tip of the cone.
        let roots = [q / open, if q == 0.0 { 0.0 } else { (miss2 - radius * radius) / q }];
        let (low, high) = (roots[0].min(roots[1]), roots[0].max(roots[1]));
        // A ray within the cone's own angle stays inside.
        let endless = LONGEST_WAY * self.length;
        let (enters, leaves) = match (open >= 0.0, grows > 0.0) {
            (true, _) if is_along => (-endless, endless),
            (true, _) => (low, high),
            (false, true) => (high, endless),
            (false, false) => (-endless, low),
        };
        let whole = [enters + middle, leaves + middle];
        let [first, last] = self.between_planes(off, way, whole);
        let range = view.far - view.near;
        let first = first.max(view.near - closest);
        let last = last.min(view.near + opaque_depth * range - closest);
        if first.is_nan() || last.is_nan() || first >= last {
            return None;
        }
        let along = |at: f32| begin + at * step;
        let metres = square.sqrt();
        let diameters =
            |from: f32, to: f32| line.diameters(along(0.5 * (from + to)), step, to - from, metres);
        let inside = diameters(first, last);
        let point = along(0.5 * (first + last));
        // A ray that begins inside enters at the near plane, and not in front of it by rounding.
        let depth = |at: f32| ((closest + at - view.near) / range).max(0.0);
        // Exactly 1 on every device, although divisions may round otherwise.
        let share = (self.taper.at(point) / line.at(point)).clamp(0.0, 1.0);
        (inside > 0.0).then(|| Way {
            inside,
            whole: if open > 0.0 && !is_along {
                diameters(whole[0], whole[1]).max(inside)
            } else {
                LONGEST_WAY
            },
            thin: if is_thin { share } else { 1.0 },
            depth: depth(first),
            end: depth(last),
        })
    }

    /// The part of a path between the planes of both ends. `off`: its start, from the first end.
    fn between_planes(&self, off: Vec3, way: Vec3, [mut first, mut last]: [f32; 2]) -> [f32; 2] {
        for (normal, back, sign) in
            [(self.planes[0], 0.0, 1.0), (self.planes[1], self.length, -1.0)]
        {
            let inside = normal.dot(off - self.axis * back) * sign;
            let change = normal.dot(way) * sign;
            if change > 0.0 {
                first = first.max(-inside / change);
            } else if change < 0.0 {
                last = last.min(-inside / change);
            } else if inside < 0.0 || (inside == 0.0 && sign < 0.0) {
                // A ray in a shared plane belongs to the capsule behind it.
                last = f32::NEG_INFINITY;
            }
        }
        [first, last]
    }
}

/// A ray's path through a capsule.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Length inside the capsule \[local diameters\].
    inside: f32,
    /// Length in the whole cone \[local diameters\].
    whole: f32,
    /// Ratio of the true radius to the widened one.
    thin: f32,
    /// Light depths at which it enters and leaves.
    depth: f32,
    end: f32,
}

/// Optical depth of an absorbed share.
fn tau_of(absorbed: f32) -> f32 {
    if absorbed < 0.5 { -(-absorbed).ln_1p() } else { -(1.0 - absorbed).max(LEAST_PASSED).ln() }
}

/// Hit of the ray through `texel`, which ends at light depth `opaque_depth`. `color`: tinted, with alpha.
pub fn capsule_hit(
    view: &GpuView,
    setup: &CapsuleSetup,
    transfer: Transfer,
    color: Vec4,
    texel: Vec2,
    opaque_depth: f32,
) -> Option<Hit> {
    let Way { inside, whole, thin, depth, end } = setup.passage(view, texel, opaque_depth)?;
    let (rgb, alpha) = (color.truncate().min(Vec3::ONE), color.w.min(1.0));
    let absorbed = |of_diameter: f32| {
        let tau = tau_of(of_diameter);
        if thin >= 1.0 {
            return -(-tau * inside).exp_m1();
        }
        let covered = thin * -(-tau * whole).exp_m1();
        -(-tau_of(covered) * (inside / whole)).exp_m1()
    };
    let all = absorption(transfer, 1.0, alpha, rgb).map(absorbed);
    let opacity = absorbed(alpha);
    let added = if transfer == Transfer::Over { rgb * opacity } else { Vec3::ZERO };
    let light = Vec3::ONE - all;
    let (presence, start) = (opacity, depth);
    Some(Hit { light, absorbed: all, added, color: rgb, opacity, presence, depth, start, end })
}

/// Projects one capsule to view number `view_index` of its batch.
pub fn project_capsule(
    view: &GpuView,
    view_index: u32,
    (caster, caster_id): (&CasterRecord, u32),
    record: &CapsuleRecord,
    material: &GpuMaterial,
    params: ProjectParams,
) -> Projected {
    let setup = CapsuleSetup::new(view, record);
    let CapsuleSetup { first, axis, length, planes, taper, least: shown } = setup;
    let last = first + axis * length;
    let slope = taper.slope.abs().max(shown.slope.abs());
    let radii = [0.0, length].map(|point| taper.at(point).max(shown.at(point)));
    let reaches = [0, 1].map(|i| radii[i] * mitre(planes[i].dot(axis), slope));
    let ends = [first.extend(reaches[0]), last.extend(reaches[1])];
    let range = view.far - view.near;
    let nearest = ((first.z - reaches[0]).min(last.z - reaches[1]) - view.near) / range;
    let farthest = ((first.z + reaches[0]).max(last.z + reaches[1]) - view.near) / range;
    let part = (-first.dot(axis)).clamp(0.0, length);
    let least = ((first + axis * part).length() - reaches[0].max(reaches[1])).max(0.0);
    let unseen = material.transfer == Transfer::None as u32 && !params.include_non_casters;
    // Written so that a NaN is invisible.
    if unseen || !(farthest >= 0.0 && nearest <= 1.0) {
        return Projected::INVISIBLE;
    }
    let extent = Extent::new(view, ends, least);
    let Extent { middle, half, width, bounds } = extent;
    let Some(rect) = tile_rect(view, view_index, bounds, middle, f32::INFINITY, false) else {
        return Projected::INVISIBLE;
    };
    let footprint = Footprint {
        center: middle,
        radius: width,
        depth: (0.5 * (first.z + last.z) - view.near) / range,
        red_green: half.x.to_bits(),
        blue_slope: half.y.to_bits(),
        thin: CAPSULE_MARK,
        caster: caster_id,
    };
    let touches = |lo, hi| capsule_touches(&footprint, lo, hi);
    let rect = touched_tiles(rect, touches);
    if rect == TileRect::EMPTY || caster.color(material.transfer).w * material.tint.w <= 0.0 {
        return Projected::INVISIBLE;
    }
    let front = if params.by_distance && view.perspective > 0.0 {
        view.distance_key(least)
    } else {
        nearest
    };
    Projected { footprint, key: depth_key(front), rect }
}

/// Extent of a capsule in the map \[texels\].
struct Extent {
    /// Middle of its axis, and the offset from there to its last end.
    middle: Vec2,
    half: Vec2,
    /// Reach to each side of its axis; negative if an end is beside the view.
    width: f32,
    bounds: TexelBox,
}

impl Extent {
    /// `ends`: to the right, down and along the axis, with the radii of the spheres whose hull contains it
    /// \[m\]; `least`: its distance from the light, 0 if the light may be inside.
    fn new(view: &GpuView, ends: [Vec4; 2], least: f32) -> Self {
        let center = view.size * 0.5;
        if view.perspective == 0.0 {
            let [a, b] = ends.map(|end| end.xy() * view.scale + center);
            let width = ends[0].w.max(ends[1].w) * view.scale;
            let bounds = TexelBox { min: a.min(b) - width, max: a.max(b) + width };
            return Self { middle: (a + b) * 0.5, half: (b - a) * 0.5, width, bounds };
        }
        // Spheres behind the near plane do not reach the map.
        let clip = |end: Vec4, other: Vec4| {
            let [ahead, beyond] = [end, other].map(|end| end.z + end.w);
            let part = (view.near - ahead) / (beyond - ahead);
            if ahead < view.near && beyond > ahead { end.lerp(other, part.min(1.0)) } else { end }
        };
        let ends = [clip(ends[0], ends[1]), clip(ends[1], ends[0])];
        let mut bounds = TexelBox { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY };
        let mut width = 0.0_f32;
        for end in ends {
            let x = tangents(end.x, end.z, end.w);
            let y = tangents(end.y, end.z, end.w);
            bounds.min = bounds.min.min(Vec2::new(x.x, y.x) * view.scale + center);
            bounds.max = bounds.max.max(Vec2::new(x.y, y.y) * view.scale + center);
            width = width.max(circle(view, end.truncate(), end.w));
        }
        if least == 0.0 {
            bounds = TexelBox { min: Vec2::splat(-ENDLESS), max: Vec2::splat(ENDLESS) };
        }
        let is_beside = ends.iter().any(|end| end.z < f32::MIN_POSITIVE);
        let [a, b] = ends.map(|end| end.xy() / end.z * view.scale + center);
        if is_beside || width >= ENDLESS {
            return Self { middle: center, half: Vec2::ZERO, width: -1.0, bounds };
        }
        Self { middle: (a + b) * 0.5, half: (b - a) * 0.5, width, bounds }
    }
}

/// Radius of a circle that contains a sphere's image, around the image of the sphere's centre \[texels\].
fn circle(view: &GpuView, center: Vec3, radius: f32) -> f32 {
    let sine = radius / center.length();
    let slope = center.truncate().length() / center.z;
    if sine.is_nan() || sine >= 1.0 {
        return ENDLESS;
    }
    let tangent = sine / (1.0 - sine * sine).sqrt();
    // tan(axis + cone) - tan(axis), outwards from the view's centre.
    let rest = 1.0 - slope * tangent;
    if rest > 0.0 { view.scale * tangent * (1.0 + slope * slope) / rest } else { ENDLESS }
}

/// Whether the capsule may contain a texel centre in the box `lo..hi`, by a rectangle around its axis.
pub fn capsule_touches(footprint: &Footprint, lo: Vec2, hi: Vec2) -> bool {
    let half = capsule_half(footprint);
    let width = footprint.radius + SLACK;
    let (apart, reach) = ((lo + hi) * 0.5 - footprint.center, (hi - lo) * 0.5);
    let length = half.length();
    let along = if length > 0.0 { half / length } else { Vec2::ZERO };
    let across = (along.x * apart.y - along.y * apart.x).abs();
    let off = along.dot(apart).abs();
    footprint.radius < 0.0
        || (across <= width + along.x.abs() * reach.y + along.y.abs() * reach.x
            && off <= length + width + along.x.abs() * reach.x + along.y.abs() * reach.y)
}

/// Offset from the middle of a capsule to its last end \[texels\].
pub fn capsule_half(footprint: &Footprint) -> Vec2 {
    Vec2::new(f32::from_bits(footprint.red_green), f32::from_bits(footprint.blue_slope))
}
