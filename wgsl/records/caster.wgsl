// Casters as uploaded: records of `casters`, all of one size. Rust: src/records/caster.rs,
// src/records/gaussian.rs, src/records/capsule.rs.

import package::features::{HAS_CAPSULES, HAS_GAUSSIANS, HAS_TRIANGLES};
import package::records::footprint::{Footprint, caster_of, setup_of, setup_texel};
import package::records::pack::unpack_color;
import package::records::record::{CasterRecord, OPACITY_SCALE};
import choice::records::{caster_record, setup_words};

// Linear rgba, before the material's tint. `transfer`: of its material.
fn caster_color(record: CasterRecord, transfer: u32) -> vec4<f32> {
    let color = unpack_color(vec2(record.red_green, record.blue_alpha), transfer);
    return vec4(color, unpack2x16float(record.blue_alpha).y / OPACITY_SCALE);
}

// Rotation about the ray [radians].
fn rotation_of(material_rotation: u32) -> f32 {
    return f32(material_rotation >> 16u) * (6.2831853 / 65536.0);
}

fn material_of(record: CasterRecord) -> u32 {
    return record.material_rotation & 0xffffu;
}

fn caster_rotation(caster: u32) -> f32 {
    return rotation_of(caster_record(caster).material_rotation);
}

// Id of the particle's object.
fn particle_object(caster: u32) -> u32 {
    return caster_record(caster).id;
}

// Gaussians as uploaded, behind the particles in `casters`, and projected to one view, at the start of
// `setups`.

// The record that the id of a Gaussian's own states.
struct GaussianAxes {
    rotation: vec4<f32>, // unit quaternion x, y, z, w: from its own space to the world
    sigma: vec3<f32>,    // standard deviations [m]
    id: u32,
}

fn gaussian_axes(index: u32) -> GaussianAxes {
    let record = caster_record(index);
    return GaussianAxes(vec4(record.center, record.radius), second_vector(record), record.id);
}

// The words of a particle's colour, material and rotation, in records that have a vector there.
fn second_vector(record: CasterRecord) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3(record.red_green, record.blue_alpha, record.material_rotation));
}

const GAUSSIAN_TEXELS: u32 = 3u;
const OUTLINE_TEXEL: u32 = 2u; // of a setup: the outline for `bin`
const NEUTRAL_BIT: u32 = 0x10000u; // of a look: black in shadow views
const MEDIUM_BIT: u32 = 0x20000u;  // of a look: alpha is an extinction
const GAUSSIAN_MARK: u32 = 0xffffu; // in place of a footprint's base opacity

// With u = (whitening.x delta.x + whitening.y delta.y, whitening.z delta.y) and delta from the centre
// [texels], the ray's least distance from the centre in the Gaussian's own space is q^2 = |u|^2 / (e^2 +
// spread |u|^2), where e = 1 + tilt . u; in an orthographic view, q^2 = |u|^2.
struct GaussianSetup {
    whitening: vec3<f32>, // [1/texels]
    spread: f32,
    tilt: vec2<f32>,
    color: vec2<u32>, // colour, unorm16, and thinness, f16
}

fn is_gaussian(footprint: Footprint) -> bool {
    return (footprint.look.z & 0xffffu) == GAUSSIAN_MARK;
}

fn gaussian_setup(footprint: Footprint) -> GaussianSetup {
    let at = footprint.look.x * GAUSSIAN_TEXELS;
    let a = bitcast<vec4<f32>>(setup_words(at));
    let b = setup_words(at + 1u);
    return GaussianSetup(a.xyz, a.w, bitcast<vec2<f32>>(b.xy), b.zw);
}

// Opacity of a splat at its centre, or a medium's extinction there times the root of 2 pi [1/m].
fn gaussian_amplitude(footprint: Footprint) -> f32 {
    return bitcast<f32>(footprint.look.y);
}

// Capsules of strands as uploaded, behind the Gaussians' axes in `casters`.

const CAPSULE_MARK: u32 = 0xfffeu; // in place of a footprint's base opacity

struct Capsule {
    first: vec3<f32>, // ends, world space [m]
    last: vec3<f32>,
    radii: vec2<f32>, // [m]
    first_plane: vec3<f32>, // unit normals of the planes through the ends, from the first to the last
    last_plane: vec3<f32>,
}

fn is_capsule(footprint: Footprint) -> bool {
    return (footprint.look.z & 0xffffu) == CAPSULE_MARK;
}

// `index`: of the first of the capsule's two records, stated by its particle's id.
fn capsule_of(index: u32) -> Capsule {
    let first = caster_record(index);
    let last = caster_record(index + 1u);
    return Capsule(
        first.center,
        last.center,
        vec2(first.radius, last.radius),
        second_vector(first),
        second_vector(last),
    );
}

// Id of the object that a footprint belongs to.
fn object_of(footprint: Footprint) -> u32 {
    if HAS_TRIANGLES && footprint.is_triangle {
        return setup_texel(setup_of(footprint), 6u).w;
    }
    if (HAS_GAUSSIANS && is_gaussian(footprint)) || (HAS_CAPSULES && is_capsule(footprint)) {
        // The further record of a Gaussian or capsule begins like a particle's, with the id at the same
        // offset.
        return particle_object(particle_object(caster_of(footprint)));
    }
    return particle_object(caster_of(footprint));
}
