// The host's shader: a floor and puffs, lit through gobo's maps.

const COUNT: u32 = 9u;
const EYE: vec3<f32> = vec3(0.0, 2.6, 3.6);

struct Params {
    lamp: vec4<f32>,                 // position [m]
    puffs: array<vec4<f32>, COUNT>,  // centre, radius [m]
    colors: array<vec4<f32>, COUNT>, // rgb, opacity
}
@group(0) @binding(0) var<uniform> params: Params;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec2<f32>,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Corner(vec4(place, 0.0, 1.0), place);
}

// The lamp's light at a point, without its cosine.
fn lamp(away: vec3<f32>) -> f32 {
    return 9.0 / dot(away, away);
}

@fragment
fn shade(at: Corner) -> @location(0) vec4<f32> {
    let forward = normalize(vec3(0.0, 0.35, 0.0) - EYE);
    let right = normalize(cross(forward, vec3(0.0, 1.0, 0.0)));
    let ray = normalize(forward + 0.62 * (at.place.x * 1.6 * right + at.place.y * cross(right, forward)));

    var color = vec3(0.02, 0.025, 0.04);
    let distance = select(1e9, -EYE.y / ray.y, ray.y < 0.0);
    if distance < 20.0 {
        let position = EYE + ray * distance;
        let away = params.lamp.xyz - position;
        let arriving = gobo_light_through(0u, position, vec3(0.0, 1.0, 0.0)) * lamp(away);
        color += arriving * max(normalize(away).y, 0.0) * exp(-0.15 * dot(position.xz, position.xz)) * 0.8;
    }
    // Puffs filter what lies behind them, and scatter the light at their middle.
    for (var i = 0u; i < COUNT; i += 1u) {
        let puff = params.puffs[i];
        let to = puff.xyz - EYE;
        let along = dot(to, ray);
        let square = puff.w * puff.w - (dot(to, to) - along * along);
        if square > 0.0 {
            let share = sqrt(square) / puff.w;
            let passed = pow(vec3(1.0) - params.colors[i].a * (vec3(1.0) - params.colors[i].rgb), vec3(share));
            let light = gobo_light_at(0u, puff.xyz) * lamp(params.lamp.xyz - puff.xyz);
            color = color * passed + params.colors[i].rgb * light * (0.12 * share * params.colors[i].a);
        }
    }
    return vec4(pow(color / (color + 0.6), vec3(0.4545)), 1.0);
}
