// The light that arrives at a point through the shadow maps. CPU twin: src/cpu/receive.rs.
// Needs common/light.wgsl; the kernel binds `params`, `lights`, `shadow_views`, `filters`,
// `nearests`, `opaques`.

// What one texel lets through to light depth z: rules 1 and 2 of the receiver. Texels beside the
// view's map are those on its border.
fn receive_texel(view: GpuView, texel: vec2<f32>, z: f32, bias: f32) -> vec3<f32> {
    let at = view.origin + vec2<u32>(clamp(texel, vec2(0.0), view.size - 1.0));
    let depths = textureLoad(opaques, at, view.layer, 0).rgb;
    let solid = select(depths.rrr, depths, params.colored != 0u);
    let nearest = textureLoad(nearests, at, view.layer, 0).r;
    let filtered = textureLoad(filters, at, view.layer, 0).rgb;
    let passed = select(vec3(1.0), filtered, z > nearest + bias);
    return select(passed, vec3(0.0), vec3(z) > solid + bias);
}

fn receive_row(view: GpuView, texel: vec2<f32>, w: vec3<f32>, z: f32, bias: f32) -> vec3<f32> {
    return receive_texel(view, texel - vec2(1.0, 0.0), z, bias) * w.x
        + receive_texel(view, texel, z, bias) * w.y
        + receive_texel(view, texel + vec2(1.0, 0.0), z, bias) * w.z;
}

// Weights of a quadratic B-spline around t in -0.5..0.5.
fn spline(t: f32) -> vec3<f32> {
    return vec3(0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t));
}

// Nine texels, each asked for itself, weighted by the spline.
fn receive(view: GpuView, point: vec3<f32>, bias: f32) -> vec3<f32> {
    let p = (view.view_from_world * vec4(point, 1.0)).xyz;
    let distance = -p.z;
    let perspective = view.perspective > 0.0;
    let place = vec2(p.x, -p.y) * (view.scale / select(1.0, max(distance, 1e-6), perspective)) + view.size * 0.5;
    let range = view.far - view.near;
    let z = (distance - view.near) / range;
    let inside = all(place >= vec2(0.0)) && all(place <= view.size);
    // A cone or a cube's face ends where its map does.
    if !(z >= 0.0 && (inside || perspective)) {
        return vec3(1.0);
    }
    let middle = clamp(floor(place), vec2(-1e6), vec2(1e6));
    let t = clamp(place - middle - 0.5, vec2(-0.5), vec2(0.5));
    let x = spline(t.x);
    let y = spline(t.y);
    return receive_row(view, middle - vec2(0.0, 1.0), x, z, bias / range) * y.x
        + receive_row(view, middle, x, z, bias / range) * y.y
        + receive_row(view, middle + vec2(0.0, 1.0), x, z, bias / range) * y.z;
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
    toward: vec3<f32>, // the light, unit
    color: vec3<f32>,  // irradiance of what faces the light, before shadows
}

fn incoming(light: GpuLight, point: vec3<f32>) -> Incoming {
    if light.kind == LIGHT_DIRECTIONAL {
        return Incoming(-light.direction, light.color);
    }
    let away = point - light.position;
    let square = max(dot(away, away), 1e-4);
    let ray = away * inverseSqrt(square);
    var color = light.color / square;
    if light.kind == LIGHT_SPOT {
        color *= smoothstep(light.cone_outer, light.cone_inner, dot(ray, light.direction));
    }
    return Incoming(-ray, color);
}

// `normal`, on the light's side, lifts the point off its own shadow by what the slope of the
// surface hides within nine texels; zero where there is none. `bias` [m].
fn shadow(light: GpuLight, point: vec3<f32>, normal: vec3<f32>, toward: vec3<f32>, bias: f32) -> vec3<f32> {
    if light.view_count == 0u {
        return vec3(1.0);
    }
    let face = select(0u, cube_face(point - light.position), light.kind == LIGHT_POINT);
    let view = shadow_views[light.first_view + face];
    let along = -(view.view_from_world * vec4(point, 1.0)).z;
    let texel = select(1.0, max(along, 0.0), view.perspective > 0.0) / view.scale; // [m]
    let cosine = dot(normal, toward);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    return receive(view, point + normal * ((params.normal_bias + 0.5) * sine * texel), bias);
}
