// A receiver as data: records of the texture `points`. Kernels for visible surfaces write them;
// `light_points` evaluates the light that they send to the eye. Rust: crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::points;
import package::features::{HAS_COATS, HAS_FAR_SIDES};
import package::records::pack::{from_octahedral, octahedral};
import package::records::record::record_texel;

const POINT_TEXELS: u32 = 4u;

const POINT_NONE: u32 = 0u;
const POINT_SOLID: u32 = 1u;    // scatters light from its face's side
const POINT_PANE: u32 = 2u;    // scatters light from both sides
const POINT_PARTICLE: u32 = 3u; // scatters without a normal
const POINT_BRICK: u32 = 4u;    // in a brick of voxels: scatters several times
const POINT_STRAND: u32 = 5u;   // around an axis, its normal: scatters as a cylinder, and mirrors
const POINT_COVER: u32 = 6u;    // covers the scene behind it; scatters light from its face's side
const POINT_LEAF: u32 = 7u;     // scatters light from its face's side, and other light from its far side

// Whether a point is on a surface.
fn is_faced(kind: u32) -> bool {
    return (kind == POINT_SOLID) | (kind == POINT_PANE) | (kind == POINT_COVER) | (kind == POINT_LEAF);
}

// A clear coat over a surface.
struct Coat {
    share: f32,        // of the surface that it covers; 0: there is none
    roughness: f32,
    normal: vec3<f32>, // unit, on the eye's side
}

const NO_COAT: Coat = Coat(0.0, 0.0, vec3(0.0));

const MIN_COAT_ROUGHNESS: f32 = 1.6e-5; // not 0 in 16 bits

const POLISH_STEPS: f32 = 2047.0;
const METAL_STEPS: f32 = 255.0;

struct Point {
    kind: u32,            // POINT_*
    position: vec3<f32>,  // world space [m]
    face: vec3<f32>,      // normal of the plane, unit, on the eye's side; zero for none
    normal: vec3<f32>,    // interpolated, unit, on the eye's side
    reach: f32,           // distance that a caster in the maps may be off the point [m]
    cluster: u32,         // cluster of its lights; ALL_LIGHTS for all
    receives: u32,        // RECEIVES_*
    tag: u32,             // owner tag of its object
    albedo: vec3<f32>,    // share of the light that it scatters
    roughness: f32,       // in a brick (g + 1) / 2, with g of its phase function
    reflectivity: f32,
    polish: f32,          // 1: shines like glass
    emission: vec3<f32>,  // light that it emits, and mirrors from the environment
    metallic: f32,        // 1: mirrors in its own colour and scatters nothing
    pixel: u32,           // x and, from bit 16 on, y, each up to 4095; 0 for a particle
    brick: u32,           // of POINT_BRICK: the brick whose voxels shadow the point; 0 for none
    far: vec3<f32>,       // of POINT_LEAF: share of the light from its far side that it scatters
    coat: Coat,           // of POINT_SOLID
}

// Pixel, with the metalness in the last eight bits.
fn packed_pixel(p: Point) -> u32 {
    let metal = u32(saturate(p.metallic) * METAL_STEPS + 0.5);
    return (p.pixel & 0xfffu) | ((p.pixel >> 16u) << 12u) | (metal << 24u);
}

// Whether a point has a coat. Its record has the coat's roughness as a reflectivity, which is 0 of other
// opaque surfaces.
fn is_coated(p: Point) -> bool {
    return HAS_COATS && p.kind == POINT_SOLID && p.coat.share > 0.0;
}

// Albedo and, for a leaf, its scattered share of the far side's light: unsigned, 16 bits each; for what is
// coated, the coat's share as well, and its normal.
fn packed_shares(p: Point) -> vec3<u32> {
    if is_coated(p) {
        return vec3(
            pack2x16unorm(p.albedo.xy),
            pack2x16unorm(vec2(p.albedo.z, p.coat.share)),
            octahedral(p.coat.normal),
        );
    }
    if HAS_FAR_SIDES && p.kind == POINT_LEAF {
        return vec3(
            pack2x16unorm(p.albedo.xy),
            pack2x16unorm(vec2(p.albedo.z, p.far.x)),
            pack2x16unorm(p.far.yz),
        );
    }
    return bitcast<vec3<u32>>(p.albedo);
}

fn packed_point(p: Point) -> array<vec4<u32>, POINT_TEXELS> {
    let polish = u32(saturate(p.polish) * POLISH_STEPS + 0.5);
    let gloss = select(p.reflectivity, max(p.coat.roughness, MIN_COAT_ROUGHNESS), is_coated(p));
    let bits = p.kind | (p.receives << 3u) | (polish << 5u) | (p.tag << 16u);
    return array(
        vec4(bitcast<vec3<u32>>(p.position), bits),
        vec4(
            select(octahedral(p.face), p.brick, p.kind == POINT_BRICK),
            octahedral(p.normal),
            bitcast<u32>(p.reach),
            p.cluster,
        ),
        vec4(packed_shares(p), pack2x16unorm(vec2(p.roughness, gloss))),
        vec4(bitcast<vec3<u32>>(p.emission), packed_pixel(p)),
    );
}

fn load_point(index: u32) -> Point {
    let first = index * POINT_TEXELS;
    let words = textureLoad(points, record_texel(first), 0);
    let normals = textureLoad(points, record_texel(first + 1u), 0);
    let look = textureLoad(points, record_texel(first + 2u), 0);
    let surface = textureLoad(points, record_texel(first + 3u), 0);
    let kind = words.w & 7u;
    let shine = unpack2x16unorm(look.w);
    let has_face = is_faced(kind);
    var albedo = bitcast<vec3<f32>>(look.xyz);
    var far = vec3(0.0);
    if HAS_FAR_SIDES && kind == POINT_LEAF {
        let mixed = unpack2x16unorm(look.y);
        albedo = vec3(unpack2x16unorm(look.x), mixed.x);
        far = vec3(mixed.y, unpack2x16unorm(look.z));
    }
    var coat = NO_COAT;
    var reflectivity = shine.y;
    if HAS_COATS && ((kind == POINT_SOLID) & (shine.y > 0.0)) {
        let rest = unpack2x16unorm(look.y);
        albedo = vec3(unpack2x16unorm(look.x), rest.x);
        coat = Coat(rest.y, shine.y, from_octahedral(look.z));
        reflectivity = 0.0;
    }
    return Point(
        kind,
        bitcast<vec3<f32>>(words.xyz),
        select(vec3(0.0), from_octahedral(normals.x), has_face),
        from_octahedral(normals.y),
        bitcast<f32>(normals.z),
        normals.w,
        (words.w >> 3u) & 3u,
        words.w >> 16u,
        albedo,
        shine.x,
        reflectivity,
        f32((words.w >> 5u) & 2047u) / POLISH_STEPS,
        bitcast<vec3<f32>>(surface.xyz),
        f32(surface.w >> 24u) / METAL_STEPS,
        (surface.w & 0xfffu) | (((surface.w >> 12u) & 0xfffu) << 16u),
        select(0u, normals.x, kind == POINT_BRICK),
        far,
        coat,
    );
}
