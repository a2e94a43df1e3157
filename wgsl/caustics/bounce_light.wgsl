// caustics, bounce: the points of a map that send on the light that arrives there (Dachsbacher and Stamminger
// 2005). One invocation per point. `views` has the view with SAMPLES^2 texels per point, and then the view of
// the map. CPU reference: crates/gobo-reference/src/bounce.rs. Rust: src/stage/caustics.rs.

import package::bind::changed::bounced;
import package::bind::read::{glass, glass_owners};
import package::bind::sampled::filters;
import package::bind::uniform::{bounce_params, views};
import package::caustics::glass_face::{glass_face, glass_normal, light_ray, meets_face};
import package::caustics::light_views::{in_world, opaque_along, seen_in, texel_at, turned_back};
import package::records::bounce::BOUNCE_VECTORS;
import package::records::glass::{GLASS_VECTORS, NEAR_SURFACE};
import package::records::light::LIGHT_POINT;
import package::shade::incoming::incoming;

const PER_PI: f32 = 0.31830989;

override WORKGROUP_SIZE: u32;

// Samples of a point's part of the map, along its edge.
const SAMPLES: u32 = 4u;
// Least cosine of the light's angle by which a point's disc is larger than its part of the map.
const LEAST_FACING: f32 = 0.05;
// Samples of a point are on one surface if the cosine of their normals is more, and their distance to the
// other's plane less [edges of its part of the map].
const SAME_NORMAL: f32 = 0.8;
const SAME_PLANE: f32 = 0.5;

// A sample on an opaque triangle.
struct Sent {
    is_there: bool,
    point: vec3<f32>,  // in the space of the rays [m]
    along: f32,        // depth [m]
    normal: vec3<f32>, // in the space of the rays
    area: f32,         // across the light's ray [m^2]
    facing: f32,       // cosine of the light's angle
    light: vec3<f32>,  // that it sends, over pi
}

fn sample_of(point: u32, number: u32) -> Sent {
    let nothing = Sent(false, vec3(0.0), 0.0, vec3(0.0), 0.0, 0.0, vec3(0.0));
    let edge = bounce_params.edge;
    let first = vec2(point % edge, point / edge) * SAMPLES;
    let texel = first + vec2(number % SAMPLES, number / SAMPLES);
    let stored = glass_owners[2u * (texel.y * edge * SAMPLES + texel.x)];
    if stored == 0u {
        return nothing;
    }
    let owner = ~stored;
    let face = glass_face(owner);
    let ray = light_ray(0u, vec2<f32>(texel) + 0.5);
    let met = meets_face(face, ray);
    let place = ray.start + ray.step * met.along;
    let at = seen_in(1u, place);
    // A face that something else hides in the map sends no light on.
    let off = abs(-at.point.z - opaque_along(1u, at.place));
    if !met.is_met || off > NEAR_SURFACE * texel_at(views[1], at.point) {
        return nothing;
    }
    let way = normalize(ray.step);
    let normal = glass_normal(owner, face, met.weights, way);
    let width = texel_at(views[0], at.point);
    let area = width * width / length(ray.step);
    let seen = vec2<u32>(clamp(at.place, vec2(0.0), views[1].size - 1.0));
    let filtered = textureLoad(filters, views[1].origin + seen, views[1].layer, 0).rgb;
    var light = bounce_params.light;
    // No branch depends on uniforms alone.
    light.kind = select(LIGHT_POINT, light.kind, stored != 0u);
    let arriving = incoming(light, in_world(place)).color * filtered;
    let normals = owner * GLASS_VECTORS + 3u;
    let albedo = vec3(glass[normals].w, glass[normals + 1u].w, glass[normals + 2u].w);
    return Sent(
        true,
        place,
        -at.point.z,
        normal,
        area,
        max(-dot(normal, way), LEAST_FACING),
        arriving * albedo * (area * PER_PI),
    );
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn bounce_light(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= bounce_params.edge * bounce_params.edge {
        return;
    }
    var nearest = sample_of(id.x, 0u);
    for (var i = 1u; i < SAMPLES * SAMPLES; i += 1u) {
        let sent = sample_of(id.x, i);
        if sent.is_there && (!nearest.is_there || sent.along < nearest.along) {
            nearest = sent;
        }
    }
    // All samples send light, from the middle of those on the surface nearest to the light.
    let apart = SAME_PLANE * f32(SAMPLES) * sqrt(nearest.area);
    var count = 0.0;
    var place = vec3(0.0);
    var normal = vec3(0.0);
    var square = 0.0;
    var light = vec3(0.0);
    for (var i = 0u; i < SAMPLES * SAMPLES; i += 1u) {
        let sent = sample_of(id.x, i);
        light += sent.light;
        square += sent.area * PER_PI / max(sent.facing, LEAST_FACING);
        let off = abs(dot(nearest.normal, sent.point - nearest.point));
        if sent.is_there && off <= apart && dot(sent.normal, nearest.normal) >= SAME_NORMAL {
            count += 1.0;
            place += sent.point;
            normal += sent.normal;
        }
    }
    let to = 1u + BOUNCE_VECTORS * (bounce_params.first + id.x);
    let middle = in_world(place / max(count, 1.0));
    let side = turned_back(normal);
    bounced[to] = vec4(middle, max(square, 1e-12));
    bounced[to + 1u] = vec4(side / max(length(side), 1e-12), 0.0);
    bounced[to + 2u] = vec4(light, 0.0);
}
