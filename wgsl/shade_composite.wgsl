// shade, composite: translucent casters over the surfaces, front to back, and the picture's
// pixels. One workgroup per tile, four pixels per invocation.
// CPU twin: src/cpu/shade.rs. Host: src/stage/shade.rs. Needs common/caster_hit.wgsl,
// walk_uniform.wgsl, surface.wgsl, light.wgsl and what they need.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(2) var<uniform> params: PictureParams;
@group(0) @binding(3) var<uniform> lights: array<GpuLight, MAX_LIGHTS>;
@group(0) @binding(4) var<storage, read> tiles: array<Tile>;
@group(0) @binding(5) var<storage, read_write> pixels: array<u32>;
@group(0) @binding(6) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(7) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(8) var casters: texture_2d<u32>;
@group(0) @binding(9) var setups: texture_2d<u32>;
@group(0) @binding(10) var images: texture_2d_array<f32>;
@group(0) @binding(11) var triangles: texture_2d<u32>;
@group(0) @binding(12) var surfaces: texture_2d<f32>;
@group(0) @binding(13) var lit: texture_2d<f32>;

const FAINT: f32 = 0.0009765625; // what is behind less than this is not seen

var<private> corner: vec2<f32>; // first of the four pixels
var<private> opaque_depth: vec4<f32>;
var<private> passed: array<vec3<f32>, 4>;
var<private> color: array<vec3<f32>, 4>;

// The sky and the lights in a pane, by the face normal.
fn reflection(view: GpuView, pixel: vec2<f32>, depth: f32, id: u32, setup: u32, roughness: f32) -> vec3<f32> {
    let point = world_point(view, pixel, depth);
    let toward_eye = normalize(params.world_from_view[3].xyz - point);
    var normal = triangle_normal(id, triangle_weights(setup, pixel).xyz);
    normal = select(-normal, normal, dot(normal, toward_eye) >= 0.0);
    // Schlick 1994, of glass.
    let fresnel = 0.04 + 0.96 * pow(1.0 - clamp(dot(normal, toward_eye), 0.0, 1.0), 5.0);
    var light = (params.background * 0.6 + params.ambient) * fresnel;
    let shine = 2.0 / max(roughness * roughness, 0.002);
    for (var i = 0u; i < params.light_count; i += 1u) {
        let away = select(lights[i].position - point, -lights[i].direction, lights[i].kind == LIGHT_DIRECTIONAL);
        let half_way = normalize(normalize(away) + toward_eye);
        let square = select(max(dot(away, away), 1e-4), 1.0, lights[i].kind == LIGHT_DIRECTIONAL);
        light += lights[i].color / square * (0.5 * pow(max(dot(normal, half_way), 0.0), shine));
    }
    return light;
}

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    let arriving = textureLoad(lit, record_texel(footprint), 0).rgb;
    visit_pixel(view, place, look, arriving, 0u);
    visit_pixel(view, place, look, arriving, 1u);
    visit_pixel(view, place, look, arriving, 2u);
    visit_pixel(view, place, look, arriving, 3u);
}

fn visit_pixel(view: GpuView, place: vec4<u32>, look: vec4<u32>, arriving: vec3<f32>, i: u32) {
    let pixel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = caster_hit(view, place, look, pixel, opaque_depth[i]);
    if hit.depth >= 0.0 && hit.depth < opaque_depth[i] && any(passed[i] >= vec3(FAINT)) {
        let material = materials[hit.material];
        let own = hit.color * arriving + material.emission;
        if material.transfer == TRANSFER_NONE {
            color[i] += passed[i] * hit.opacity * (hit.color + material.emission);
        } else if (look.w & TRIANGLE_BIT) != 0u && material.transmission > 0.0 {
            let id = look.w & ~TRIANGLE_BIT;
            let shine = reflection(view, pixel, hit.depth, id, look.x, material.roughness);
            color[i] += passed[i] * (shine + (1.0 - material.transmission) * hit.opacity * own);
            passed[i] *= mix(vec3(1.0 - hit.opacity), hit.light, material.transmission);
        } else {
            color[i] += passed[i] * hit.opacity * own;
            passed[i] *= 1.0 - hit.opacity;
        }
    }
}

fn settled(front: f32) -> bool {
    var open = false;
    for (var i = 0u; i < 4u; i += 1u) {
        open = open || (any(passed[i] >= vec3(FAINT)) && opaque_depth[i] > front);
    }
    return !open;
}

// Extended curve of Reinhard et al. 2002 on the brightest channel: hues stay as they are.
fn tone(light: vec3<f32>) -> vec3<f32> {
    const WHITE: f32 = 4.0;
    let bright = max(max(light.r, max(light.g, light.b)), 1e-6);
    let curved = bright * (1.0 + bright / (WHITE * WHITE)) / (1.0 + bright * 0.6);
    return clamp(light * (curved / bright), vec3(0.0), vec3(1.0));
}

fn to_srgb(v: vec3<f32>) -> vec3<f32> {
    return select(1.055 * pow(max(v, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055, v * 12.92, v <= vec3(0.0031308));
}

@compute @workgroup_size(LANES)
fn shade_composite(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile_id = interleaved(workgroup.x, workgroups.x);
    let tile = tiles[tile_id];
    let view = views[0];
    let pixel = tile_texel(view, tile_id) + lane_texel(lane);
    corner = vec2<f32>(pixel);
    for (var i = 0u; i < 4u; i += 1u) {
        opaque_depth[i] = textureLoad(surfaces, pixel + vec2(0u, i), 0).a;
        passed[i] = vec3(1.0);
        color[i] = vec3(0.0);
    }
    walk(view, tile.first, min(tile.end, tile.first + MAX_WALK));
    let size = vec2<u32>(view.size);
    for (var i = 0u; i < 4u; i += 1u) {
        let at = pixel + vec2(0u, i);
        if all(at < size) {
            let surface = textureLoad(surfaces, at, 0).rgb;
            let light = tone(color[i] + passed[i] * surface);
            pixels[at.y * size.x + at.x] = pack4x8unorm(vec4(to_srgb(light), 1.0));
        }
    }
}
