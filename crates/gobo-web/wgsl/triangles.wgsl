// Triangles: solid ones, ones that cover their background, and panes, which filter it in one pass and add
// their own light in another. Filters commute, so panes are drawn in any order.

@group(2) @binding(0) var image: texture_2d<f32>;
@group(2) @binding(1) var image_sampler: sampler;

struct Corner {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) color: vec4<f32>,
    @location(4) look: u32,
}

struct Point {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) color: vec4<f32>,
    @location(4) @interpolate(flat) look: u32,
}

@vertex
fn triangle_corner(corner: Corner) -> Point {
    let clip = frame.clip_from_world * vec4(corner.position, 1.0);
    // Square roots of red, green and blue are stored.
    let color = vec4(corner.color.rgb * corner.color.rgb, corner.color.a);
    return Point(clip, corner.position, corner.normal, corner.uv, color, corner.look);
}

struct Surface {
    look: Look,
    color: vec3<f32>,
    opacity: f32,
    normal: vec3<f32>, // on the eye's side
    to_eye: vec3<f32>,
}

fn surface(point: Point) -> Surface {
    let look = looks[point.look];
    let texel = textureSample(image, image_sampler, point.uv);
    let color = look.tint * texel * point.color;
    let to_eye = normalize(frame.eye.xyz - point.position);
    let normal = normalize(point.normal);
    let opacity = 1.0 - (1.0 - color.a) * (1.0 - look.reflectivity);
    return Surface(look, color.rgb, opacity, normal * select(-1.0, 1.0, dot(normal, to_eye) > 0.0), to_eye);
}

// Highlight of a light: Blinn 1977, the exponent from the roughness (Walter et al. 2007, section 6).
fn highlight(at: Surface, toward: vec3<f32>) -> vec3<f32> {
    let middle = normalize(toward + at.to_eye);
    let width = max(at.look.roughness * at.look.roughness, 0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = pow(max(dot(at.normal, middle), 1e-6), exponent);
    let head_on = mix(vec3(0.04), at.color, at.look.metallic);
    let rising = pow(saturate(1.0 - dot(at.to_eye, middle)), 5.0);
    return (exponent + 6.0) / (8.0 * PI) * lobe * (head_on + (1.0 - head_on) * rising);
}

// Light that a surface sends to the eye; a pane sends it from both sides.
fn sent(position: vec3<f32>, at: Surface, is_pane: bool) -> vec3<f32> {
    if (at.look.flags & FLAG_UNLIT) != 0u {
        return at.color + at.look.emission;
    }
    let albedo = at.color * (1.0 - at.look.metallic);
    var sum = surroundings(at.normal) * mix(albedo, at.color, 0.5 * at.look.metallic) + at.look.emission;
    for (var i = 0u; i < frame.light_count; i += 1u) {
        let arriving = gobo_incoming(gobo_light_record(i), position);
        let cosine = dot(at.normal, arriving.toward);
        let share = gobo_light_through(i, position, at.normal);
        let seen = select(max(cosine, 0.0), abs(cosine), is_pane);
        let shine = select(vec3(0.0), highlight(at, arriving.toward) * max(cosine, 0.0), !is_pane);
        sum += arriving.color * share * (albedo * seen / PI + shine);
    }
    return sum;
}

@fragment
fn triangle_solid(point: Point) -> @location(0) vec4<f32> {
    let at = surface(point);
    let light = sent(point.position, at, false);
    let least = select(0.5, at.look.cutoff, (at.look.flags & FLAG_CUTOUT) != 0u);
    if (at.look.flags & (FLAG_CUTOUT | FLAG_DITHER)) != 0u && at.opacity < least {
        discard;
    }
    return vec4(light, 1.0);
}

@fragment
fn triangle_cover(point: Point) -> @location(0) vec4<f32> {
    let at = surface(point);
    return vec4(sent(point.position, at, false) * at.opacity, at.opacity);
}

@fragment
fn triangle_filter(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let at = surface(point);
    var passed = transmittance(at.look.transfer, at.opacity, at.color);
    // The inside of a body absorbs from where the ray enters to where it leaves: distances are from the
    // scene's middle.
    let beyond = clamp(distance(frame.eye.xyz, point.position) - frame.middle, -1e3, 1e3);
    let inside = exp(clamp(at.look.absorption * beyond * select(-1.0, 1.0, front), vec3(-8.0), vec3(8.0)));
    let is_body = any(at.look.absorption > vec3(0.0));
    return vec4(select(passed, inside, is_body), 1.0);
}

@fragment
fn triangle_glow(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let at = surface(point);
    let is_body = any(at.look.absorption > vec3(0.0));
    let scatters = select(0.5 * (1.0 - at.look.transmission) * at.opacity, 0.0, is_body);
    let rising = pow(saturate(1.0 - dot(at.normal, at.to_eye)), 5.0);
    // A body mirrors on its outside.
    let shines = select(max(at.opacity, at.look.transmission), f32(front), is_body);
    let mirrored = (0.04 + 0.96 * rising) * (1.0 - at.look.roughness) * shines;
    let sky = surroundings(reflect(-at.to_eye, at.normal));
    return vec4(sent(point.position, at, true) * scatters + sky * mirrored, 0.0);
}
