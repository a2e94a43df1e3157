// `over` makes light an affine chain: light L behind a caster becomes L * light + added. CPU twin:
// src/cpu/accumulate.rs, `Passed`. Needs common/caster_hit.wgsl.

// A caster of the batch adds light: the order counts, and saturation is no end.
override HAS_OVER: bool;

fn added_light(hit: Hit) -> vec3<f32> {
    return select(vec3(0.0), hit.color * hit.opacity, materials[hit.material].transfer == TRANSFER_OVER);
}
