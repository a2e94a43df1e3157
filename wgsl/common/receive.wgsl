// The light that arrives at a point through the shadow maps. CPU twin: src/cpu/receive.rs.
// Needs common/light.wgsl; the kernel binds `params`, `lights`, `shadow_views`, `filters`,
// `nearests`, `opaques`.

// What one texel lets through to light depth z: rules 1 and 2 of the receiver.
fn receive_texel(view: GpuView, texel: vec2<i32>, z: f32, bias: f32) -> vec3<f32> {
    let at = vec2<i32>(view.origin) + clamp(texel, vec2(0), vec2<i32>(view.size) - 1);
    let solid = textureLoad(opaques, at, view.layer, 0).r;
    let nearest = textureLoad(nearests, at, view.layer, 0).r;
    let filtered = textureLoad(filters, at, view.layer, 0).rgb;
    let passed = select(vec3(1.0), filtered, z > nearest + bias);
    return select(passed, vec3(0.0), z > solid + bias);
}

// Nine texels, each asked for itself, weighted by a quadratic B-spline.
fn receive(view: GpuView, point: vec3<f32>, bias: f32) -> vec3<f32> {
    let p = view.view_from_world * vec4(point, 1.0);
    let distance = -p.z;
    let spread = select(view.scale, view.scale / max(distance, 1e-6), view.perspective > 0.0);
    let place = vec2(p.x, -p.y) * spread + view.size * 0.5;
    let range = view.far - view.near;
    let z = (distance - view.near) / range;
    if !(z >= 0.0 && z <= 1.0 && all(place >= vec2(0.0)) && all(place <= view.size)) {
        return vec3(1.0);
    }
    let middle = floor(place);
    let t = place - middle - 0.5;
    let low = 0.5 * (0.5 - t) * (0.5 - t);
    let high = 0.5 * (0.5 + t) * (0.5 + t);
    let mid = 0.75 - t * t;
    var light = vec3(0.0);
    for (var i = 0; i < 9; i += 1) {
        let step = vec2(i % 3, i / 3) - 1;
        let w = select(select(mid, low, step < vec2(0)), high, step > vec2(0));
        light += receive_texel(view, vec2<i32>(middle) + step, z, bias / range) * (w.x * w.y);
    }
    return light;
}

// The view of a point light's cube that looks towards `away` from the light.
fn cube_face(away: vec3<f32>) -> u32 {
    let size = abs(away);
    if size.x >= size.y && size.x >= size.z {
        return select(1u, 0u, away.x > 0.0);
    }
    if size.y >= size.z {
        return select(3u, 2u, away.y > 0.0);
    }
    return select(5u, 4u, away.z > 0.0);
}

struct Incoming {
    toward: vec3<f32>,   // the light, unit
    radiance: vec3<f32>, // before shadows
}

fn incoming(light: GpuLight, point: vec3<f32>) -> Incoming {
    if light.kind == LIGHT_DIRECTIONAL {
        return Incoming(-light.direction, light.color);
    }
    let away = point - light.position;
    let square = max(dot(away, away), 1e-8);
    let ray = away * inverseSqrt(square);
    var radiance = light.color / square;
    if light.kind == LIGHT_SPOT {
        radiance *= smoothstep(light.cone_outer, light.cone_inner, dot(ray, light.direction));
    }
    return Incoming(-ray, radiance);
}

// `normal` lifts the point off its own shadow; zero where there is none. `bias` [m].
fn shadow(light: GpuLight, point: vec3<f32>, normal: vec3<f32>, bias: f32) -> vec3<f32> {
    if light.view_count == 0u {
        return vec3(1.0);
    }
    // The views of a light share projection and scale.
    let is_perspective = shadow_views[light.first_view].perspective > 0.0;
    let distance = select(1.0, length(point - light.position), is_perspective);
    let texel = distance / shadow_views[light.first_view].scale;
    let lifted = point + normal * (params.normal_bias * texel);
    // By the lifted point: near a seam it may lie on the next face, and its own shows nothing there.
    var face = 0u;
    if light.kind == LIGHT_POINT {
        face = cube_face(lifted - light.position);
    }
    let view = shadow_views[light.first_view + face];
    return receive(view, lifted, bias);
}
