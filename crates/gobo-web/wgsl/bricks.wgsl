// Boxes of voxels: light is looked up at their corners, density is summed along the ray up to solid surfaces.

struct Grid {
    index_from_world: mat4x4<f32>,
    world_from_index: mat4x4<f32>,
    extinction: vec3<f32>, // times the factor [1/m]
    look: u32,
    anisotropy: f32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

struct Brick {
    origin: vec3<f32>,  // lowest voxel
    grid: u32,
    size: vec3<f32>,    // [voxels]
    voxels: u32,        // index of the first pair of its half floats, or ALIKE
    density: f32,       // of a brick of constant density
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

const ALIKE: u32 = 0xffffffffu;
const EDGE: u32 = 9u;
// Steps through a brick.
const STEPS: u32 = 12u;
// Orders of scattering, as in the picture of the program (Wrenninge, Kulla and Lundqvist 2013).
const ORDERS: u32 = 4u;
const DARKEST: f32 = 1.0 / 1024.0;

@group(2) @binding(0) var<storage, read> bricks: array<Brick>;
@group(2) @binding(1) var<storage, read> order: array<u32>;
@group(2) @binding(2) var<storage, read> grids: array<Grid>;
@group(2) @binding(3) var<storage, read> voxels: array<u32>;
@group(2) @binding(4) var depths: texture_depth_multisampled_2d;

struct Face {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) light: vec3<f32>,
    @location(2) @interpolate(flat) brick: u32,
}

// Henyey and Greenstein 1941.
fn phase(cosine: f32, g: f32) -> f32 {
    let square = max(1.0 + g * g - 2.0 * g * cosine, 1e-4);
    return (1.0 - g * g) / (4.0 * PI * square * sqrt(square));
}

fn scattered_in(position: vec3<f32>, g: f32, albedo: vec3<f32>) -> vec3<f32> {
    let from_eye = normalize(position - frame.eye.xyz);
    var sum = frame.ambient.rgb * albedo;
    for (var i = 0u; i < frame.light_count; i += 1u) {
        let arriving = gobo_incoming(gobo_light_record(i), position);
        let cosine = dot(from_eye, arriving.toward);
        var light = max(gobo_light_at(i, position) - DARKEST, vec3(0.0)) / (1.0 - DARKEST);
        var before = vec3(0.0);
        var share = vec3(1.0);
        var lobe = g;
        for (var n = 0u; n < ORDERS; n += 1u) {
            sum += arriving.color * albedo * share * max(light - before, vec3(0.0)) * phase(cosine, lobe);
            before = light;
            light = sqrt(light);
            share *= 0.5 * albedo;
            lobe *= 0.5;
        }
    }
    return sum;
}

// Corners of the six sides of a box: bit 0 is x, bit 1 y, bit 2 z.
const CORNERS = array<u32, 36>(
    0u, 2u, 1u, 1u, 2u, 3u, 4u, 5u, 6u, 5u, 7u, 6u, 0u, 1u, 4u, 1u, 5u, 4u,
    2u, 6u, 3u, 3u, 6u, 7u, 0u, 4u, 2u, 2u, 4u, 6u, 1u, 3u, 5u, 3u, 7u, 5u,
);

@vertex
fn brick_corner(@builtin(vertex_index) number: u32, @builtin(instance_index) index: u32) -> Face {
    var corners = CORNERS;
    let corner = corners[number];
    let id = order[index];
    let brick = bricks[id];
    let grid = grids[brick.grid];
    let share = vec3(f32(corner & 1u), f32((corner >> 1u) & 1u), f32(corner >> 2u));
    let position = (grid.world_from_index * vec4(brick.origin + brick.size * share, 1.0)).xyz;
    let light = scattered_in(position, grid.anisotropy, looks[grid.look].tint.rgb);
    return Face(frame.clip_from_world * vec4(position, 1.0), position, light, id);
}

fn value(first: u32, at: vec3<u32>) -> f32 {
    let i = (at.z * EDGE + at.y) * EDGE + at.x;
    return unpack2x16float(voxels[first + i / 2u])[i & 1u];
}

// Density at a position in the brick [voxels].
fn density(brick: Brick, place: vec3<f32>) -> f32 {
    if brick.voxels == ALIKE {
        return brick.density;
    }
    let low = vec3<u32>(clamp(floor(place), vec3(0.0), vec3(7.0)));
    let part = clamp(place - vec3<f32>(low), vec3(0.0), vec3(1.0));
    let f = brick.voxels;
    let bottom = mix(
        mix(value(f, low), value(f, low + vec3(1u, 0u, 0u)), part.x),
        mix(value(f, low + vec3(0u, 1u, 0u)), value(f, low + vec3(1u, 1u, 0u)), part.x), part.y);
    let top = mix(
        mix(value(f, low + vec3(0u, 0u, 1u)), value(f, low + vec3(1u, 0u, 1u)), part.x),
        mix(value(f, low + vec3(0u, 1u, 1u)), value(f, low + vec3(1u, 1u, 1u)), part.x), part.y);
    return mix(bottom, top, part.z);
}

@fragment
fn brick_ray(face: Face) -> @location(0) vec4<f32> {
    let brick = bricks[face.brick];
    let grid = grids[brick.grid];
    let ray = normalize(face.position - frame.eye.xyz);
    // The box in its own space, which begins at 0; distances along the ray stay in metres.
    let eye = (grid.index_from_world * vec4(frame.eye.xyz, 1.0)).xyz - brick.origin;
    let along = (grid.index_from_world * vec4(ray, 0.0)).xyz;
    let safe = select(along, vec3(1e-12), abs(along) < vec3(1e-12));
    let a = -eye / safe;
    let b = (brick.size - eye) / safe;
    let near = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
    let far = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
    let depth = textureLoad(depths, vec2<i32>(face.clip.xy), 0);
    let solid = select(1e30, depth_of(depth) / max(dot(ray, frame.forward.xyz), 1e-6), depth > 0.0);
    // One of the two sides that the ray crosses counts: the first, unless the eye is inside.
    let is_first = distance(face.position, frame.eye.xyz) < 0.5 * (near + far);
    if is_first != (near > 0.0) {
        discard;
    }
    let first = max(near, 0.0);
    let last = min(far, solid);
    if last <= first {
        discard;
    }
    let step = (last - first) / f32(STEPS);
    var sum = 0.0;
    for (var i = 0u; i < STEPS; i += 1u) {
        sum += density(brick, eye + along * (first + (f32(i) + 0.5) * step));
    }
    let passed = exp(-sum * step * grid.extinction);
    let opacity = 1.0 - (passed.r + passed.g + passed.b) / 3.0;
    return vec4(face.light * (vec3(1.0) - passed), opacity);
}

// Distance along the axis of a depth [m].
fn depth_of(depth: f32) -> f32 {
    let near = frame.forward.w;
    return near * frame.far / (near + depth * (frame.far - near));
}
