// Particles of an emitter as casters, in the order of their numbers. A particle that has ended, or has no
// alpha, has no radius: it is no caster (`may_be_none`). CPU reference: src/model/emission.rs.

import package::bind::read::emitted;
import package::bind::uniform::emission_params;
import package::hit::hash::{pcg, unit_float};
import package::load::load_casters::TURN;
import package::records::emitter::STEP_SECONDS;
import package::records::host::Caster;

// Place among `count` values at even distances: index of the value before, of the value behind, and share of
// the latter.
struct Between {
    low: u32,
    high: u32,
    share: f32,
}

fn between(share: f32, count: u32) -> Between {
    let at = share * f32(count - 1u);
    let low = min(u32(at), count - 1u);
    return Between(low, min(low + 1u, count - 1u), at - f32(low));
}

fn mixed(a: f32, b: f32, share: f32) -> f32 {
    return a + (b - a) * share;
}

fn load_caster(index: u32) -> Caster {
    let number = emission_params.first + index;
    let one = emitted[number % emission_params.capacity];
    let age = one.age_life & 0xffffu;
    let life = one.age_life >> 16u;
    let share = min((f32(age) + emission_params.part) / f32(max(life, 1u)), 1.0);
    let sized = between(share, emission_params.radius_count);
    let low = emission_params.radii[sized.low / 4u][sized.low % 4u];
    let high = emission_params.radii[sized.high / 4u][sized.high % 4u];
    let tinted = between(share, emission_params.color_count);
    let before = emission_params.shades[tinted.low].rgb;
    let behind = emission_params.shades[tinted.high].rgb;
    let faded = between(share, emission_params.alpha_count);
    let alpha = mixed(emission_params.shades[faded.low].a, emission_params.shades[faded.high].a, faded.share);
    let is_seen = one.number == number && age < life && alpha > 0.0;
    var caster: Caster;
    caster.center = one.position + one.velocity * (emission_params.part * STEP_SECONDS);
    caster.radius = select(0.0, mixed(low, high, sized.share), is_seen);
    caster.color = vec4(before * (1.0 - tinted.share) + behind * tinted.share, alpha);
    caster.rotation = unit_float(pcg(number ^ emission_params.seed)) * TURN;
    caster.material = emission_params.material;
    caster.id = emission_params.first_id + number;
    return caster;
}
