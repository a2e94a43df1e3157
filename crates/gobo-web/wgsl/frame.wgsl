// Bindings of all passes of the page: camera, surroundings, materials, and light at a point.

struct Frame {
    clip_from_world: mat4x4<f32>, // reversed z
    eye: vec4<f32>,
    right: vec4<f32>,   // w: half of the picture's width at 1 m
    up: vec4<f32>,      // w: half of its height
    forward: vec4<f32>, // w: near plane [m]
    size: vec2<f32>,    // of the picture [pixels]
    light_count: u32,
    sky_edge: u32,      // of the surroundings' map without its border [texels]; 0 without a map
    exposure: f32,      // factor
    tone: u32,
    middle: f32,        // distance of the scene's middle from the eye [m]
    far: f32,           // far plane [m]
    ambient: vec4<f32>,
    background: vec4<f32>,
    irradiance: array<vec4<f32>, 9>,
}

const FLAG_UNLIT: u32 = 1u;
const FLAG_PUFF: u32 = 2u;
const FLAG_SOFT: u32 = 4u;
const FLAG_SQUARE: u32 = 8u;
const FLAG_CUTOUT: u32 = 16u;
const FLAG_DITHER: u32 = 32u;
const FLAG_MEDIUM: u32 = 64u;

struct Look {
    tint: vec4<f32>,
    emission: vec3<f32>,
    transmission: f32,
    absorption: vec3<f32>, // of a volume [1/m]
    roughness: f32,
    metallic: f32,
    reflectivity: f32,
    cutoff: f32,
    flags: u32,
    transfer: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

const TRANSFER_FILTER: u32 = 0u;
const TRANSFER_STAIN: u32 = 1u;
const TRANSFER_SMOKE: u32 = 2u;
const TRANSFER_OVER: u32 = 3u;
const TRANSFER_GAIN: u32 = 4u;
const TRANSFER_NONE: u32 = 5u;

const PI: f32 = 3.14159265;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> looks: array<Look>;

// Light that arrives at a point without a surface, scattered evenly to all sides.
fn scattered_evenly(position: vec3<f32>) -> vec3<f32> {
    var sum = frame.ambient.rgb;
    for (var i = 0u; i < frame.light_count; i += 1u) {
        let arriving = gobo_incoming(gobo_light_record(i), position);
        sum += arriving.color * gobo_light_at(i, position) * (0.25 / PI);
    }
    return sum;
}

// Irradiance of a surface of normal `n` by the surroundings, divided by pi (Ramamoorthi and Hanrahan 2001).
fn surroundings(n: vec3<f32>) -> vec3<f32> {
    let linear = frame.irradiance[0].rgb + frame.irradiance[1].rgb * n.y + frame.irradiance[2].rgb * n.z
        + frame.irradiance[3].rgb * n.x;
    let mixed = frame.irradiance[4].rgb * (n.x * n.y) + frame.irradiance[5].rgb * (n.y * n.z)
        + frame.irradiance[7].rgb * (n.x * n.z);
    let squares = frame.irradiance[6].rgb * (3.0 * n.z * n.z - 1.0)
        + frame.irradiance[8].rgb * (n.x * n.x - n.y * n.y);
    return max(linear + mixed + squares, vec3(0.0));
}

// Transmittance of a hit of opacity `a` and colour `c`.
fn transmittance(transfer: u32, a: f32, c: vec3<f32>) -> vec3<f32> {
    switch transfer {
        case TRANSFER_STAIN: { return c * (1.0 - a); }
        case TRANSFER_SMOKE: { return (1.0 - a) * (vec3(1.0) - a * (vec3(1.0) - c)); }
        case TRANSFER_GAIN: { return c; }
        case TRANSFER_NONE: { return vec3(1.0); }
        default: { return vec3(1.0) - a * (vec3(1.0) - c); }
    }
}
