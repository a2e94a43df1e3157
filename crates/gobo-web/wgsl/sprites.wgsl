// Particles and Gaussians as squares that face the eye, farthest first; light is looked up at their middles.

struct Sprite {
    center: vec3<f32>,
    look: u32,
    // Particle: radius [m], kind. Gaussian: covariance xx, xy, xz [m2], kind.
    first: vec4<f32>,
    // Gaussian: covariance yy, yz, zz.
    second: vec4<f32>,
    color: vec4<f32>,
}

@group(2) @binding(0) var<storage, read> sprites: array<Sprite>;
@group(2) @binding(1) var<storage, read> order: array<u32>;

struct Spot {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec2<f32>, // from the middle, 1 at the border
    @location(1) @interpolate(flat) light: vec3<f32>,
    @location(2) @interpolate(flat) color: vec4<f32>,
    @location(3) @interpolate(flat) look: u32,
    @location(4) @interpolate(flat) reach: f32, // of a Gaussian [standard deviations]; 0 for a particle
}

fn hidden() -> Spot {
    return Spot(vec4(0.0, 0.0, 2.0, 1.0), vec2(0.0), vec3(0.0), vec4(0.0), 0u, 0.0);
}

@vertex
fn sprite_corner(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Spot {
    let sprite = sprites[order[index]];
    let look = looks[sprite.look];
    let place = vec2(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let away = sprite.center - frame.eye.xyz;
    let seen = vec3(dot(away, frame.right.xyz), dot(away, frame.up.xyz), dot(away, frame.forward.xyz));
    if seen.z <= frame.forward.w {
        return hidden();
    }
    var color = look.tint * sprite.color;
    color.a = 1.0 - (1.0 - color.a) * (1.0 - look.reflectivity);
    var aside: vec2<f32>; // at the sprite's depth [m]
    var reach = 0.0;
    if sprite.first.w > 0.5 {
        // Zwicker et al. 2001, "EWA splatting": the conic on the plane through the middle, enlarged to two
        // thirds of a pixel.
        let slope = seen.xy / seen.z;
        let x = frame.right.xyz - slope.x * frame.forward.xyz;
        let y = frame.up.xyz - slope.y * frame.forward.xyz;
        let sx = vec3(dot(sprite.first.xyz, x), dot(vec3(sprite.first.y, sprite.second.xy), x),
            dot(vec3(sprite.first.z, sprite.second.yz), x));
        let sy = vec3(dot(sprite.first.xyz, y), dot(vec3(sprite.first.y, sprite.second.xy), y),
            dot(vec3(sprite.first.z, sprite.second.yz), y));
        let pixel = 2.0 * frame.up.w * seen.z / frame.size.y;
        let least = 0.3 * pixel * pixel;
        let exact = vec3(dot(x, sx), dot(x, sy), dot(y, sy));
        let wide = exact + vec3(least, 0.0, least);
        let area = max(exact.x * exact.z - exact.y * exact.y, 0.0);
        color.a *= sqrt(area / max(wide.x * wide.z - wide.y * wide.y, 1e-30));
        let mean = 0.5 * (wide.x + wide.z);
        let apart = sqrt(max(mean * mean - (wide.x * wide.z - wide.y * wide.y), 0.0));
        let is_slanted = abs(wide.y) > 1e-12 * mean;
        let axis = normalize(vec2(mean + apart - wide.z, wide.y));
        let major = select(vec2(1.0, 0.0), axis, is_slanted || wide.x < wide.z);
        let turned = select(major, vec2(0.0, 1.0), !is_slanted && wide.x < wide.z);
        reach = sqrt(max(2.0 * log(255.0 * min(color.a, 1.0)), 0.0));
        let minor = vec2(-turned.y, turned.x);
        let sides = place * sqrt(max(vec2(mean + apart, mean - apart), vec2(0.0)));
        aside = reach * (turned * sides.x + minor * sides.y);
    } else {
        aside = place * sprite.first.x;
    }
    let position = sprite.center + frame.right.xyz * aside.x + frame.up.xyz * aside.y;
    let clip = frame.clip_from_world * vec4(position, 1.0);
    let light = scattered_evenly(sprite.center);
    let shown = select(light, vec3(1.0), (look.flags & FLAG_UNLIT) != 0u);
    return Spot(clip, place, shown, color, sprite.look, reach);
}

// Share of the sprite's opacity at a position.
fn opacity_at(spot: Spot, flags: u32) -> f32 {
    let square = dot(spot.place, spot.place);
    if spot.reach > 0.0 {
        return spot.color.a * exp(-0.5 * spot.reach * spot.reach * square);
    }
    if (flags & FLAG_SQUARE) != 0u {
        return spot.color.a;
    }
    let inside = max(1.0 - square, 0.0);
    if (flags & FLAG_PUFF) != 0u {
        return 1.0 - pow(max(1.0 - spot.color.a, 0.0), sqrt(inside));
    }
    let profile = select(select(0.0, 1.0, square < 1.0), inside * inside, (flags & FLAG_SOFT) != 0u);
    return spot.color.a * profile;
}

@fragment
fn sprite_blended(spot: Spot) -> @location(0) vec4<f32> {
    let look = looks[spot.look];
    let opacity = opacity_at(spot, look.flags);
    if opacity < 1.0 / 512.0 {
        discard;
    }
    let covers = select(opacity, 0.0, look.transfer == TRANSFER_NONE);
    let scattered = spot.color.rgb * spot.light * (1.0 - 0.5 * look.transmission);
    return vec4((scattered + look.emission) * opacity, covers);
}

@fragment
fn sprite_solid(spot: Spot) -> @location(0) vec4<f32> {
    let look = looks[spot.look];
    let opacity = opacity_at(spot, look.flags);
    let least = select(0.5, look.cutoff, (look.flags & FLAG_CUTOUT) != 0u);
    if opacity < least {
        discard;
    }
    return vec4(spot.color.rgb * spot.light + look.emission, 1.0);
}
