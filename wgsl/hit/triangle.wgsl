// Hit of a ray with a triangle. CPU reference: crates/gobo-reference/src/caster_hit.rs,
// crates/gobo-reference/src/project.rs.

import package::bind::sampled::images;
import package::bind::uniform::{materials, picture_params};
import package::features::{HAS_FRESNEL, HAS_TEXTURES, HAS_VERTEX_COLORS};
import package::hit::hit::{Hit, absorption, transmittance};
import package::hit::texture::{Sampled, sample_area, sample_texture};
import package::records::footprint::setup_texel;
import package::records::material::{MAX_GAIN, NO_TEXTURE, TRANSFER_CUTOUT, TRANSFER_GAIN, shows_clear};

// Whether images are filtered over the area that a sample of the picture sees. Maps read single texels.
override FILTERS_IMAGES: bool = false;

fn edge(setup: u32, i: u32, texel: vec2<f32>) -> f32 {
    let products = edge_products(edge_of(setup, i), texel);
    return products.x - products.y;
}

fn edge_of(setup: u32, i: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(setup_texel(setup, i));
}

// Barycentric weights of the corners, and light depth; depth -1 outside.
fn triangle_weights(setup: u32, texel: vec2<f32>) -> vec4<f32> {
    let weights_ties = setup_texel(setup, 3u);
    let a = edge_products(edge_of(setup, 0u), texel);
    let b = edge_products(edge_of(setup, 1u), texel);
    let c = edge_products(edge_of(setup, 2u), texel);
    let e = vec3(a.x - a.y, b.x - b.y, c.x - c.y);
    let inside = is_inside(a, b, c, (vec3(weights_ties.w) & vec3(1u, 2u, 4u)) != vec3(0u));
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

// Colour, interpolated between the corners, which store square roots of linear light, and alpha.
fn triangle_color(setup: u32, barycentric: vec3<f32>) -> vec4<f32> {
    if !HAS_VERTEX_COLORS {
        return vec4(1.0);
    }
    let bits = setup_texel(setup, 7u).xyz;
    if all(bits == vec3(0xffffffffu)) {
        return vec4(1.0);
    }
    return corner_color(bits.x) * barycentric.x + corner_color(bits.y) * barycentric.y
        + corner_color(bits.z) * barycentric.z;
}

fn corner_color(bits: u32) -> vec4<f32> {
    let corner = unpack4x8unorm(bits);
    return vec4(corner.rgb * corner.rgb, corner.a);
}

// An image at `texel`, over the area that a sample of the picture sees. `all_colors`: as `shows_clear`.
fn triangle_image(
    layer: u32,
    size: vec2<f32>,
    setup: u32,
    texel: vec2<f32>,
    barycentric: vec3<f32>,
    all_colors: bool,
) -> Sampled {
    let uv = triangle_uv(setup, barycentric);
    let weights = bitcast<vec3<f32>>(setup_texel(setup, 3u).xyz);
    let ab = bitcast<vec4<f32>>(setup_texel(setup, 5u));
    let c = bitcast<vec2<f32>>(setup_texel(setup, 6u).xy);
    let first = bitcast<vec2<f32>>(setup_texel(setup, 0u).zw) * weights.x;
    let second = bitcast<vec2<f32>>(setup_texel(setup, 1u).zw) * weights.y;
    let third = bitcast<vec2<f32>>(setup_texel(setup, 2u).zw) * weights.z;
    let sum = edge(setup, 0u, texel) * weights.x + edge(setup, 1u, texel) * weights.y
        + edge(setup, 2u, texel) * weights.z;
    // Changes of the weighted corners from one pixel to the next, divided by those of their sum.
    let right = -((ab.xy - uv) * first.y + (ab.zw - uv) * second.y + (c - uv) * third.y);
    let down = (ab.xy - uv) * first.x + (ab.zw - uv) * second.x + (c - uv) * third.x;
    let reach = picture_params.image_reach / sum;
    return sample_area(images, layer, size, uv, right * reach, down * reach, all_colors);
}

// `passes`: share of light that the surface does not reflect.
fn triangle_hit(setup: u32, texel: vec2<f32>, passes: f32) -> Hit {
    let met = triangle_weights(setup, texel);
    let material_id = setup_texel(setup, 4u).w;
    let material = materials[material_id];
    var image = Sampled(vec4(1.0), 0.0);
    if HAS_TEXTURES && material.texture != NO_TEXTURE {
        let all_colors = shows_clear(material.transfer);
        if FILTERS_IMAGES {
            image = triangle_image(
                material.texture,
                material.texture_size,
                setup,
                texel,
                met.xyz,
                all_colors,
            );
        } else {
            let uv = triangle_uv(setup, met.xyz);
            image.rgba = sample_texture(images, material.texture, material.texture_size, uv, all_colors);
        }
    }
    // Read behind the image, which needs registers.
    let tint = materials[material_id].tint * triangle_color(setup, met.xyz) * image.rgba;
    var opacity = 1.0 - (1.0 - tint.a) * (1.0 - material.reflectivity);
    if FILTERS_IMAGES && material.transfer == TRANSFER_CUTOUT {
        // Where texels are smaller than a pixel, the mean opacity is the share that is solid.
        opacity += (material.cutoff - picture_params.cutout_threshold) * saturate(image.level);
    }
    var color = select(tint.rgb, tint.rgb / MAX_GAIN, material.transfer == TRANSFER_GAIN);
    if HAS_FRESNEL {
        color *= passes;
    }
    let light = transmittance(material.transfer, 1.0, opacity, color);
    let absorbed = absorption(material.transfer, 1.0, opacity, color);
    return Hit(light, color, opacity, met.w, met.w, met.w, material_id, absorbed);
}

// Edge functions of a triangle in the map.
fn precedes(a: vec2<f32>, b: vec2<f32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Line of the edge from `a` to `b`: a point and its direction. Both triangles of a shared edge must start
// from the same corner, so that their edge functions are each other's negative to the last bit. `area`: its
// sign is the triangle's orientation.
fn edge_line(a: vec2<f32>, b: vec2<f32>, area: f32) -> vec4<f32> {
    let forward = precedes(a, b);
    let start = select(b, a, forward);
    let end = select(a, b, forward);
    return vec4(start, (end - start) * select(-1.0, 1.0, owns_edge(a, b, area)));
}

// Whether texel centres exactly on the edge from `a` to `b` belong to the triangle.
fn owns_edge(a: vec2<f32>, b: vec2<f32>, area: f32) -> bool {
    return precedes(a, b) == (area > 0.0);
}

// Distance of an edge whose line is farther away [texels]: beside it, the place of a texel makes no
// difference in 32 bits.
const FAR_EDGE: f32 = 1099511627776.0;

// Line of an edge with a corner that has no position in the map: a plane through the eye (Olano and Greer
// 1997, section 3). `a` and `b`: homogeneous corners; `turn`: its sign is the triangle's orientation.
fn edge_plane(a: vec3<f32>, b: vec3<f32>, turn: f32) -> vec4<f32> {
    let forward = precedes(a.xy, b.xy);
    let sign = select(-1.0, 1.0, forward == (turn > 0.0));
    let plane = select(cross(b, a), cross(a, b), forward) * sign;
    let along = vec2(plane.y, -plane.x);
    let constant = plane.z / FAR_EDGE;
    let foot = plane.xy * (-plane.z / dot(along, along));
    // In the plane through the eye across the axis, an edge is at infinity: its function is constant.
    let is_far = max(abs(along.x), abs(along.y)) <= abs(constant);
    return select(vec4(foot, along), vec4(0.0, -FAR_EDGE, constant, 0.0), is_far);
}

// The two products whose difference is an edge's function.
fn edge_products(line: vec4<f32>, texel: vec2<f32>) -> vec2<f32> {
    return vec2(line.z * (texel.y - line.y), line.w * (texel.x - line.x));
}

// Whether a texel is inside of all edges, by their products. These are compared, not subtracted: of a
// difference a compiler may round one product only, another one in the triangle on the other side
// (tests/stages/edges.rs).
fn is_inside(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, ties: vec3<bool>) -> bool {
    let first = vec3(a.x, b.x, c.x);
    let second = vec3(a.y, b.y, c.y);
    return all((first > second) | ((first == second) & ties));
}
