// Bricks of a host's grid as casters, in order. A brick without density has no radius: it is no caster
// (`may_be_none`).

import package::bind::read::{brick_spheres, brick_states};
import package::bind::uniform::host_grid;
import package::records::host::Caster;

fn load_caster(index: u32) -> Caster {
    let sphere = brick_spheres[index];
    let radius = select(0.0, sphere.w, brick_states[index] != 0u);
    return Caster(sphere.xyz, radius, vec4(1.0), 0.0, host_grid.material, host_grid.first_record + index);
}
