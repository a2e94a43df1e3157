//! CPU reference of `wgsl/hit/disc.wgsl`: hits of a ray with a puff.
use super::{
    caster_hit::{Hit, added},
    hit::{absorption, transmittance},
};
use glam::{Vec2, Vec3};
use gobo::{
    model::Transfer,
    records::{Footprint, GpuView},
};

/// The part of a ray inside a puff.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    /// Length of the chord, in diameters.
    share: f32,
    /// Light depth at which the ray enters; 0 if it starts inside.
    depth: f32,
    /// Light depth at which the ray leaves or ends.
    end: f32,
}

pub(super) fn chord(
    view: &GpuView,
    footprint: &Footprint,
    texel: Vec2,
    opaque_depth: f32,
) -> Option<Chord> {
    let Footprint { center, radius, .. } = *footprint;
    let range = view.far - view.near;
    let distance = view.near + footprint.depth * range;
    // Squared distance of the ray from the centre [radii²]; metres along the axis per radius; depth along the
    // axis of the ray's point closest to the centre [m].
    let (miss2, radius_axis, closest);
    let w = ((texel - view.size * 0.5) / view.scale).extend(1.0);
    if let Some(beside) = footprint.beside() {
        let w2 = w.length_squared();
        miss2 = beside.cross(w).length_squared() / w2 / (radius * radius);
        radius_axis = -radius / w2.sqrt();
        closest = beside.dot(w) / w2;
    } else if view.perspective > 0.0 {
        let c = ((center - view.size * 0.5) / view.scale).extend(1.0);
        let apart = c.cross(w - c);
        let w2 = w.length_squared();
        let metres = radius * distance * c.length();
        miss2 = apart.length_squared() / w2 * (distance * distance) / (metres * metres);
        radius_axis = metres / w2.sqrt();
        closest = distance * c.dot(w) / w2;
    } else {
        miss2 = ((texel - center) / radius).length_squared();
        radius_axis = radius / view.scale;
        closest = distance;
    }
    let rest = 1.0 - miss2;
    if rest.is_nan() || rest <= 0.0 {
        return None;
    }
    let half_chord = rest.sqrt() * radius_axis;
    let first = (closest - half_chord).max(view.near);
    let last = (closest + half_chord).min(view.near + opaque_depth * range);
    let share = ((last - first) / (2.0 * radius_axis)).min(1.0);
    let at = |along: f32| (along - view.near) / range;
    (share > 0.0).then(|| Chord { share, depth: at(first), end: at(last) })
}

/// Hit of a puff: the transmittance of a whole diameter, to the power of the chord's length in diameters.
pub(super) fn puff_hit(
    transfer: Transfer,
    chord: Chord,
    color: Vec3,
    thin: f32,
    alpha: f32,
) -> Hit {
    // Powers of 0 differ between adapters.
    const MIN: f32 = 1e-9;
    let per_diameter = transmittance(transfer, thin, alpha, color).max(Vec3::splat(MIN));
    let opacity = 1.0 - (1.0 - alpha).max(MIN).powf(chord.share);
    let light = per_diameter.powf(chord.share);
    let added = added(transfer, opacity, color);
    let whole = absorption(transfer, thin, alpha, color).min(Vec3::splat(1.0 - MIN));
    let absorbed = whole.map(|x| -((-x).ln_1p() * chord.share).exp_m1());
    let Chord { depth, end, .. } = chord;
    let (presence, start) = (opacity, depth);
    Hit { light, absorbed, added, color, opacity, presence, depth, start, end }
}
