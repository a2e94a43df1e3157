// shade, surfaces: what the camera sees of opaque casters, lit through the shadow maps. One
// workgroup per tile, four pixels per invocation.
// CPU twin: src/cpu/shade.rs. Host: src/stage/shade.rs. Needs common/solid.wgsl, walk_uniform.wgsl,
// receive.wgsl, surface.wgsl and what they need.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(2) var<uniform> params: PictureParams;
@group(0) @binding(3) var<uniform> lights: array<GpuLight, MAX_LIGHTS>;
@group(0) @binding(4) var<uniform> shadow_views: array<GpuView, MAX_SHADOW_VIEWS>;
@group(0) @binding(5) var<storage, read> tiles: array<Tile>;
@group(0) @binding(6) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(7) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(8) var casters: texture_2d<u32>;
@group(0) @binding(9) var setups: texture_2d<u32>;
@group(0) @binding(10) var images: texture_2d_array<f32>;
@group(0) @binding(11) var triangles: texture_2d<u32>;
@group(0) @binding(12) var filters: texture_2d_array<f32>;
@group(0) @binding(13) var nearests: texture_2d_array<f32>;
@group(0) @binding(14) var opaques: texture_2d_array<f32>;
@group(0) @binding(15) var surfaces: texture_storage_2d<rgba32float, write>;

var<private> corner: vec2<f32>; // first of the four pixels
var<private> nearest: vec4<f32>;
var<private> seen: vec4<u32>;   // caster
var<private> setup_of: vec4<u32>;

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    visit_pixel(view, place, look, 0u);
    visit_pixel(view, place, look, 1u);
    visit_pixel(view, place, look, 2u);
    visit_pixel(view, place, look, 3u);
}

fn visit_pixel(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) {
    let pixel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = caster_hit(view, place, look, pixel, 1.0);
    if is_solid(view, place, look, pixel, hit) && hit.depth < nearest[i] {
        nearest[i] = hit.depth;
        seen[i] = look.w;
        setup_of[i] = look.x;
    }
}

fn settled(front: f32) -> bool {
    return all(nearest <= vec4(front));
}

fn sky(view: GpuView, y: f32) -> vec3<f32> {
    let up = 1.0 - y / view.size.y;
    return params.background * mix(0.75, 1.15, up);
}

fn shade(view: GpuView, pixel: vec2<f32>, depth: f32, id: u32, setup: u32) -> vec3<f32> {
    let point = world_point(view, pixel, depth);
    let eye = params.world_from_view[3].xyz;
    let toward_eye = normalize(eye - point);
    var normal = toward_eye;
    var material: GpuMaterial;
    var albedo: vec3<f32>;
    if (id & TRIANGLE_BIT) != 0u {
        let met = triangle_weights(setup, pixel);
        material = materials[setup_texel(setup, 4u).w];
        normal = triangle_normal(id & ~TRIANGLE_BIT, met.xyz);
        normal = select(-normal, normal, dot(normal, toward_eye) >= 0.0);
        albedo = material.tint.rgb;
        if HAS_TEXTURES && material.texture != NO_TEXTURE {
            let uv = triangle_uv(setup, met.xyz);
            albedo *= sample_texture(images, material.texture, material.texture_size, uv).rgb;
        }
    } else {
        let look = textureLoad(casters, record_texel(2u * id + 1u), 0);
        material = materials[look.z & 0xffffu];
        albedo = material.tint.rgb * vec3(unpack2x16unorm(look.x), unpack2x16unorm(look.y).x);
    }
    let shine = 2.0 / max(material.roughness * material.roughness, 0.01);
    let gloss = 0.04 * (shine + 8.0) / 8.0;
    var light = params.ambient * mix(0.7, 1.0, normal.y * 0.5 + 0.5) * albedo + material.emission;
    for (var i = 0u; i < params.light_count; i += 1u) {
        let source = lights[i];
        let arriving = incoming(source, point);
        let facing = dot(normal, arriving.toward);
        if facing > 0.0 && any(arriving.radiance > vec3(1e-4)) {
            let half_way = normalize(arriving.toward + toward_eye);
            let highlight = gloss * pow(max(dot(normal, half_way), 0.0), shine);
            // Grazing light needs the point lifted more.
            let lift = normal * min(1.0 / max(facing, 0.25), 4.0) * 0.5;
            let passed = shadow(source, point, lift, params.bias);
            light += (albedo / 3.14159265 + highlight) * facing * arriving.radiance * passed;
        }
    }
    return light;
}

@compute @workgroup_size(LANES)
fn shade_surfaces(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile_id = interleaved(workgroup.x, workgroups.x);
    let tile = tiles[tile_id];
    let view = views[0];
    let pixel = tile_texel(view, tile_id) + lane_texel(lane);
    corner = vec2<f32>(pixel);
    nearest = vec4(1.0);
    seen = vec4(0u);
    setup_of = vec4(0u);
    walk(view, tile.first, min(tile.end, tile.first + MAX_WALK));
    for (var i = 0u; i < 4u; i += 1u) {
        let at = corner + vec2(0.5, f32(i) + 0.5);
        var color = sky(view, at.y);
        if nearest[i] < 1.0 && all(at < view.size) {
            color = shade(view, at, nearest[i], seen[i], setup_of[i]);
        }
        textureStore(surfaces, pixel + vec2(0u, i), vec4(color, nearest[i]));
    }
}
