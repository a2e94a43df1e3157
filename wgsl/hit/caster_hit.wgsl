// Hit of a ray with any caster: opacity, transmittance, depth. CPU reference: src/reference/caster_hit.rs.

import package::bind::sampled::images;
import package::bind::uniform::materials;
import package::features::{
    HAS_BRICKS, HAS_FACING, HAS_GAUSSIANS, HAS_PARTICLES, HAS_PUFFS, HAS_TEXTURES, HAS_TRIANGLES,
};
import package::hit::brick::passage;
import package::hit::brick_light::{SHADES_BRICKS, start_weights};
import package::hit::gaussian::gaussian_hit;
import package::hit::hit::{Facing, absorption, coverage, facing, facing_hit, transmittance};
import package::hit::texture::sample_texture;
import package::records::brick::{brick_of, grid_of};
import package::records::caster::{caster_look, look_rotation, particle_object};
import package::records::footprint::{
    Footprint, caster_of, footprint_color, opacity_base, opacity_slope, setup_of,
};
import package::records::gaussian::{GaussianSetup, gaussian_setup, is_gaussian};
import package::records::material::{
    MAX_GAIN, NO_TEXTURE, SHAPE_BRICK, SHAPE_GAUSSIAN, SHAPE_PUFF, TRANSFER_GAIN, TRANSFER_STAIN,
};
import package::records::setup::setup_texel;
import package::records::view::{GpuView, is_beside};
import package::sums::faint::{tau_absorbed, whole_tau};

struct Hit {
    light: vec3<f32>, // transmittance
    color: vec3<f32>,
    opacity: f32,
    depth: f32,       // light depth; -1 for a miss
    start: f32,       // ramp of a curve, in light depth: up to where the whole hit is in front
    end: f32,
    material: u32,
    absorbed: vec3<f32>, // 1 - light, with full precision where light is next to 1
}

const MISS: Hit = Hit(vec3(1.0), vec3(0.0), 0.0, -1.0, -1.0, -1.0, 0u, vec3(0.0));

// What a hit must have to set depths: its opacity, or the light that `stain` and `gain` change without any.
fn presence_of(hit: Hit) -> f32 {
    let transfer = materials[hit.material].transfer;
    let changes = transfer == TRANSFER_STAIN || transfer == TRANSFER_GAIN;
    let changed = abs(hit.absorbed);
    return select(hit.opacity, max(hit.opacity, max(max(changed.r, changed.g), changed.b)), changes);
}

// A particle set up for texels.
struct Faced {
    plane: Facing,
    gaussian: GaussianSetup,
    look: u32, // material and rotation, as in `casters`
}

fn faced_of(view: GpuView, footprint: Footprint) -> Faced {
    // A triangle has no record in `casters`.
    let own = caster_look(select(caster_of(footprint), 0u, footprint.is_triangle));
    var faced: Faced;
    if HAS_FACING {
        faced.plane = facing(view, footprint.place, look_rotation(own));
    }
    if HAS_GAUSSIANS && (!HAS_FACING || is_gaussian(footprint)) {
        faced.gaussian = gaussian_setup(footprint);
    }
    faced.look = own.z;
    return faced;
}

// What `faced_hit` needs of any caster.
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

// `faced`: of a particle.
fn faced_hit(view: GpuView, footprint: Footprint, faced: Faced, texel: vec2<f32>, opaque_depth: f32) -> Hit {
    var hit = MISS;
    if HAS_TRIANGLES && footprint.is_triangle {
        hit = triangle_hit(setup_of(footprint), texel);
    } else if HAS_PARTICLES {
        hit = particle_hit(view, footprint, faced, texel, opaque_depth);
    }
    if !(hit.depth >= 0.0 && hit.depth <= 1.0) {
        hit = MISS;
    }
    return hit;
}

fn particle_hit(view: GpuView, footprint: Footprint, faced: Faced, texel: vec2<f32>, opaque_depth: f32) -> Hit {
    let place = footprint.place;
    let material_id = faced.look & 0xffffu;
    let material = materials[material_id];
    if HAS_GAUSSIANS && (!HAS_FACING || material.shape == SHAPE_GAUSSIAN) {
        let hit = gaussian_hit(view, footprint, faced.gaussian, faced.look, texel, opaque_depth);
        let light = transmittance(material.transfer, hit.opacity, hit.color);
        let absorbed = absorption(material.transfer, hit.opacity, hit.color);
        return Hit(light, hit.color, hit.opacity, hit.start, hit.start, hit.end, material_id, absorbed);
    }
    let met = facing_hit(faced.plane, view, texel);
    var color = footprint_color(footprint);
    let base = opacity_base(footprint);
    let slope = opacity_slope(footprint);
    if HAS_PUFFS && material.shape == SHAPE_PUFF {
        return puff_hit(view, place, color, min(base + slope, 1.0), texel, opaque_depth, material_id);
    }
    if HAS_BRICKS && material.shape == SHAPE_BRICK {
        return brick_hit(view, footprint, color, texel, opaque_depth, material_id);
    }
    let covered = coverage(material.shape, material.profile, met.xy);
    var alpha = covered;
    if HAS_TEXTURES && material.texture != NO_TEXTURE {
        let uv = vec2(0.5 + 0.5 * met.x, 0.5 - 0.5 * met.y);
        let image = sample_texture(images, material.texture, material.texture_size, uv);
        color *= image.rgb;
        alpha *= image.a;
    }
    let opacity = min(base + slope * alpha, 1.0);
    let inside = max(abs(met.x), abs(met.y)) <= 1.0 && covered > 0.0;
    let depth = select(-1.0, met.z, inside);
    let light = transmittance(material.transfer, opacity, color);
    let absorbed = absorption(material.transfer, opacity, color);
    return Hit(light, color, opacity, depth, depth, depth, material_id, absorbed);
}

// Hit of a puff, which absorbs along the chord of the ray through the sphere in front of the opaque
// surface: the transfer along a whole diameter, to the power of the chord's share of it.
fn puff_hit(
    view: GpuView,
    place: vec4<f32>,
    color: vec3<f32>,
    alpha: f32,
    texel: vec2<f32>,
    opaque_depth: f32,
    material_id: u32,
) -> Hit {
    let range = view.far - view.near;
    let center = view.near + place.w * range; // along the axis [m]
    let w = vec3((texel - view.size * 0.5) / view.scale, 1.0);
    let middle = (place.xy - view.size * 0.5) / view.scale;
    // Squared distance of the ray from the centre [radii²], and metres along the axis per radius.
    var miss2: f32;
    var radius_axis: f32;
    var closest: f32;
    if is_beside(place) {
        let apart = cross(place.xyw, w);
        miss2 = dot(apart, apart) / dot(w, w) / (place.z * place.z);
        radius_axis = -place.z / length(w);
        closest = dot(place.xyw, w) / dot(w, w);
    } else if view.perspective > 0.0 {
        let c = vec3(middle, 1.0);
        let distance = center * length(c);
        let radius = place.z * distance;
        let apart = cross(c, w - c);
        miss2 = dot(apart, apart) / dot(w, w) * (center * center) / (radius * radius);
        radius_axis = radius / length(w);
        closest = center * dot(c, w) / dot(w, w);
    } else {
        let delta = (texel - place.xy) / place.z;
        miss2 = dot(delta, delta);
        radius_axis = place.z / view.scale;
        closest = center;
    }
    if miss2 >= 1.0 {
        return MISS;
    }
    let half_chord = sqrt(1.0 - miss2); // [radii]
    let first = max(closest - half_chord * radius_axis, view.near);
    let last = min(closest + half_chord * radius_axis, view.near + opaque_depth * range);
    let share = clamp((last - first) / (2.0 * radius_axis), 0.0, 1.0);
    let per_diameter = max(transmittance(materials[material_id].transfer, alpha, color), vec3(1e-9));
    let opacity = 1.0 - pow(max(1.0 - alpha, 1e-9), share);
    let entered = (first - view.near) / range;
    let left = (last - view.near) / range;
    let light = pow(per_diameter, vec3(share));
    let absorbed = tau_absorbed(whole_tau(absorption(materials[material_id].transfer, alpha, color)) * share);
    let depth = select(-1.0, entered, share > 0.0);
    return Hit(light, color, opacity, depth, depth, left, material_id, absorbed);
}

// Hit of a brick, which absorbs by its density along the ray in front of the opaque surface.
fn brick_hit(
    view: GpuView,
    footprint: Footprint,
    color: vec3<f32>,
    texel: vec2<f32>,
    opaque_depth: f32,
    material_id: u32,
) -> Hit {
    let id = particle_object(caster_of(footprint));
    if SHADES_BRICKS {
        start_weights(id);
    }
    let brick = brick_of(id);
    let grid = grid_of(brick);
    let range = view.far - view.near;
    let inside = passage(view, brick, grid, texel, view.near + opaque_depth * range);
    let tau = inside.depth * grid.extinction;
    let most = max(max(tau.x, tau.y), tau.z);
    if !(most > 0.0) {
        return MISS;
    }
    let absorbed = tau_absorbed(tau);
    let opacity = max(max(absorbed.x, absorbed.y), absorbed.z);
    let entered = (inside.first - view.near) / range;
    let ramp = (inside.ramp - view.near) / range;
    return Hit(exp(-tau), color, opacity, entered, ramp.x, ramp.y, material_id, absorbed);
}

fn edge(setup: u32, i: u32, texel: vec2<f32>) -> f32 {
    let line = bitcast<vec4<f32>>(setup_texel(setup, i));
    return line.z * (texel.y - line.y) - line.w * (texel.x - line.x);
}

// Barycentric weights of the corners, and light depth; depth -1 outside.
fn triangle_weights(setup: u32, texel: vec2<f32>) -> vec4<f32> {
    let weights_ties = setup_texel(setup, 3u);
    let a = edge(setup, 0u, texel);
    let b = edge(setup, 1u, texel);
    let c = edge(setup, 2u, texel);
    let e = vec3(a, b, c);
    let tie = (vec3(weights_ties.w) & vec3(1u, 2u, 4u)) != vec3(0u);
    let inside = all((e > vec3(0.0)) | ((e == vec3(0.0)) & tie));
    let weighted = e * bitcast<vec3<f32>>(weights_ties.xyz);
    let sum = weighted.x + weighted.y + weighted.z;
    let barycentric = weighted / sum;
    let depths = bitcast<vec3<f32>>(setup_texel(setup, 4u).xyz);
    return vec4(barycentric, select(-1.0, dot(depths, barycentric), inside && sum > 0.0));
}

fn triangle_uv(setup: u32, barycentric: vec3<f32>) -> vec2<f32> {
    let ab = bitcast<vec4<f32>>(setup_texel(setup, 5u));
    let c = bitcast<vec2<f32>>(setup_texel(setup, 6u).xy);
    return ab.xy * barycentric.x + ab.zw * barycentric.y + c * barycentric.z;
}

fn triangle_hit(setup: u32, texel: vec2<f32>) -> Hit {
    let met = triangle_weights(setup, texel);
    let material_id = setup_texel(setup, 4u).w;
    let material = materials[material_id];
    var tint = material.tint;
    if HAS_TEXTURES && material.texture != NO_TEXTURE {
        let uv = triangle_uv(setup, met.xyz);
        tint *= sample_texture(images, material.texture, material.texture_size, uv);
    }
    let opacity = 1.0 - (1.0 - tint.a) * (1.0 - material.reflectivity);
    let color = select(tint.rgb, tint.rgb / MAX_GAIN, material.transfer == TRANSFER_GAIN);
    let light = transmittance(material.transfer, opacity, color);
    let absorbed = absorption(material.transfer, opacity, color);
    return Hit(light, color, opacity, met.w, met.w, met.w, material_id, absorbed);
}
