// Hit of a ray with any caster: opacity, transmittance, depth. CPU reference:
// crates/gobo-reference/src/caster_hit.rs.

import package::bind::sampled::images;
import package::bind::uniform::materials;
import package::features::{
    HAS_BRICKS, HAS_CAPSULES, HAS_FACING, HAS_GAUSSIANS, HAS_PARTICLES, HAS_PUFFS, HAS_TEXTURES,
    HAS_TRIANGLES, only_capsules, only_gaussians,
};
import package::hit::brick::passage;
import package::hit::brick_light::{SHADES_BRICKS, brick_shown};
import package::hit::capsule::{CapsuleSetup, capsule_hit, capsule_setup};
import package::hit::disc::puff_hit;
import package::hit::gaussian::gaussian_hit;
import package::hit::hit::{
    Facing, Hit, MISS, absorption, coverage, face_passes, facing, facing_hit, transmittance,
};
import package::hit::texture::sample_texture;
import package::hit::triangle::triangle_hit;
import package::records::brick::{brick_of, grid_extinction, grid_of};
import package::records::caster::{
    GaussianSetup, gaussian_setup, is_capsule, is_gaussian, particle_object, rotation_of,
};
import package::records::footprint::{
    Footprint, caster_of, footprint_color, footprint_thin, opacity_slope, setup_of,
};
import package::records::material::{
    NO_TEXTURE, SHAPE_BRICK, SHAPE_CAPSULE, SHAPE_GAUSSIAN, SHAPE_PUFF, shows_clear,
};
import package::records::view::GpuView;
import package::sums::sums::tau_absorbed;
import choice::records::caster_record;

// A particle set up for texels.
struct Faced {
    plane: Facing,
    gaussian: GaussianSetup,
    capsule: CapsuleSetup,
    look: u32, // material and rotation, as in `casters`
}

// Material and rotation, as in `casters`.
fn look_of(footprint: Footprint) -> u32 {
    // A triangle has no record there.
    return caster_record(select(caster_of(footprint), 0u, footprint.is_triangle)).material_rotation;
}

fn plane_of(view: GpuView, footprint: Footprint, look: u32) -> Facing {
    var plane: Facing;
    if HAS_FACING {
        plane = facing(view, footprint.bounds, rotation_of(look));
    }
    return plane;
}

fn gaussian_of(footprint: Footprint) -> GaussianSetup {
    var setup: GaussianSetup;
    if HAS_GAUSSIANS && (only_gaussians() || is_gaussian(footprint)) {
        setup = gaussian_setup(footprint);
    }
    return setup;
}

fn capsule_in(view: GpuView, footprint: Footprint) -> CapsuleSetup {
    var setup: CapsuleSetup;
    if HAS_CAPSULES && (only_capsules() || is_capsule(footprint)) {
        setup = capsule_setup(view, caster_record(caster_of(footprint)));
    }
    return setup;
}

fn faced_of(view: GpuView, footprint: Footprint) -> Faced {
    let look = look_of(footprint);
    return Faced(plane_of(view, footprint, look), gaussian_of(footprint), capsule_in(view, footprint), look);
}

// Values that `faced_hit` needs, for any caster.
fn set_up(view: GpuView, footprint: Footprint) -> Faced {
    var faced: Faced;
    if HAS_PARTICLES && !(HAS_TRIANGLES && footprint.is_triangle) {
        faced = faced_of(view, footprint);
    }
    return faced;
}

fn caster_hit(view: GpuView, footprint: Footprint, texel: vec2<f32>, opaque_depth: f32) -> Hit {
    return faced_hit(view, footprint, set_up(view, footprint), texel, opaque_depth);
}

// `faced`: values of a particle.
fn faced_hit(view: GpuView, footprint: Footprint, faced: Faced, texel: vec2<f32>, opaque_depth: f32) -> Hit {
    var hit = MISS;
    if HAS_TRIANGLES && footprint.is_triangle {
        let setup = setup_of(footprint);
        hit = triangle_hit(setup, texel, face_passes(view, setup, texel));
    } else if HAS_PARTICLES {
        hit = particle_hit(view, footprint, faced, texel, opaque_depth);
    }
    if !(hit.depth >= 0.0 && hit.depth <= 1.0) {
        hit = MISS;
    }
    return hit;
}

fn plane_hit(plane: Facing, view: GpuView, texel: vec2<f32>) -> vec3<f32> {
    if HAS_FACING {
        return facing_hit(plane, view, texel);
    }
    return vec3(2.0, 2.0, -1.0);
}

fn particle_hit(
    view: GpuView,
    footprint: Footprint,
    faced: Faced,
    texel: vec2<f32>,
    opaque_depth: f32,
) -> Hit {
    let bounds = footprint.bounds;
    let material_id = faced.look & 0xffffu;
    let material = materials[material_id];
    if HAS_CAPSULES && (only_capsules() || material.shape == SHAPE_CAPSULE) {
        return capsule_hit(view, faced.capsule, texel, opaque_depth, material_id);
    }
    if HAS_GAUSSIANS && (only_gaussians() || material.shape == SHAPE_GAUSSIAN) {
        let hit = gaussian_hit(view, footprint, faced.gaussian, faced.look, texel, opaque_depth);
        let light = transmittance(material.transfer, hit.thin, hit.opacity, hit.color);
        let absorbed = absorption(material.transfer, hit.thin, hit.opacity, hit.color);
        return Hit(light, hit.color, hit.opacity, hit.start, hit.start, hit.end, material_id, absorbed);
    }
    let met = plane_hit(faced.plane, view, texel);
    let thin = footprint_thin(footprint);
    if HAS_PUFFS && material.shape == SHAPE_PUFF {
        let most = min(material.reflectivity * thin + opacity_slope(footprint), 1.0);
        let color = footprint_color(footprint, material.transfer);
        return puff_hit(view, bounds, color, thin, most, texel, opaque_depth, material_id);
    }
    if HAS_BRICKS && material.shape == SHAPE_BRICK {
        return brick_hit(view, footprint, texel, opaque_depth, material_id);
    }
    var color = footprint_color(footprint, material.transfer);
    let slope = opacity_slope(footprint);
    let covered = coverage(material.shape, material.profile, met.xy);
    var alpha = covered;
    if HAS_TEXTURES && material.texture != NO_TEXTURE {
        let uv = vec2(0.5 + 0.5 * met.x, 0.5 - 0.5 * met.y);
        let image = sample_texture(
            images,
            material.texture,
            material.texture_size,
            uv,
            shows_clear(material.transfer),
        );
        color *= image.rgb;
        alpha *= image.a;
    }
    let opacity = min(material.reflectivity * thin + slope * alpha, 1.0);
    let inside = max(abs(met.x), abs(met.y)) <= 1.0 && covered > 0.0;
    let depth = select(-1.0, met.z, inside);
    let light = transmittance(material.transfer, thin, opacity, color);
    let absorbed = absorption(material.transfer, thin, opacity, color);
    return Hit(light, color, opacity, depth, depth, depth, material_id, absorbed);
}

// Hit of a brick, which absorbs by its density along the ray in front of the opaque surface. Where bricks are
// shaded, the hit's colour is the light that the brick sends to the eye.
fn brick_hit(
    view: GpuView,
    footprint: Footprint,
    texel: vec2<f32>,
    opaque_depth: f32,
    material_id: u32,
) -> Hit {
    let id = particle_object(caster_of(footprint));
    let brick = brick_of(id);
    let grid = grid_of(brick);
    let range = view.far - view.near;
    let inside = passage(view, brick, grid, texel, view.near + opaque_depth * range);
    // The sign is 0: this way, the compiler reads the extinction again instead of keeping it in registers.
    let extinction = grid_extinction(brick.grid + (bitcast<u32>(inside.depth) >> 31u));
    let tau = inside.depth * extinction;
    let most = max(max(tau.x, tau.y), tau.z);
    if !(most > 0.0) {
        return MISS;
    }
    let absorbed = tau_absorbed(tau);
    let opacity = max(max(absorbed.x, absorbed.y), absorbed.z);
    let entered = (inside.first - view.near) / range;
    let ramp = (inside.ramp - view.near) / range;
    var shown = footprint_color(footprint, materials[material_id].transfer);
    if SHADES_BRICKS {
        let ends = vec3(inside.thirds, inside.depth);
        let depths = max(ends - vec3(0.0, inside.thirds), vec3(0.0));
        shown = brick_shown(view, id, brick, grid, texel, inside.ends, depths, extinction);
    }
    return Hit(exp(-tau), shown, opacity, entered, ramp.x, ramp.y, material_id, absorbed);
}
