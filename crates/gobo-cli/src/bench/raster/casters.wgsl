// Soft discs that face a directional light, or splats, as quads: a caster's record is an instance, or is
// repeated for each of its four vertices.
override IS_SPLAT: bool = false;

struct View {
    clip_from_world: mat4x4<f32>,
    // From metres across the view to clip space.
    clip_per_metre: vec2<f32>,
}
@group(0) @binding(0) var<uniform> view: View;

struct Disc {
    @builtin(vertex_index) index: u32,
    @location(0) center_radius: vec4<f32>,
    @location(1) shade: vec4<f32>, // a(1 - c), a
}

struct Splat {
    @builtin(vertex_index) index: u32,
    @location(0) center_reach: vec4<f32>, // in clip space; where it ends [deviations]
    @location(1) axes: vec4<f32>,         // half axes, in clip space
    @location(2) tilt: vec2<f32>,         // change of the depth over each
    @location(3) shade: vec4<f32>,
}

struct Fragment {
    @builtin(position) position: vec4<f32>,
    @location(0) q: vec2<f32>,
    @location(1) @interpolate(flat) shade: vec4<f32>,
}

fn corner_of(index: u32) -> vec2<f32> {
    return vec2<f32>(vec2(index, index >> 1u) & vec2(1u)) * 2.0 - 1.0;
}

@vertex
fn splat(vertex: Splat) -> Fragment {
    let corner = corner_of(vertex.index);
    let aside = corner.x * vertex.axes.xy + corner.y * vertex.axes.zw;
    let position = vertex.center_reach.xyz + vec3(aside, dot(corner, vertex.tilt));
    return Fragment(vec4(position, 1.0), corner * vertex.center_reach.w, vertex.shade);
}

@vertex
fn disc(vertex: Disc) -> Fragment {
    let corner = corner_of(vertex.index);
    var position = view.clip_from_world * vec4(vertex.center_radius.xyz, 1.0);
    position += vec4(corner * vertex.center_radius.w * view.clip_per_metre, 0.0, 0.0);
    return Fragment(position, corner, vertex.shade);
}

fn profile(q: vec2<f32>) -> f32 {
    if IS_SPLAT {
        return exp(-0.5 * dot(q, q));
    }
    let inside = max(1.0 - dot(q, q), 0.0);
    return inside * inside;
}

const SEEN: f32 = 1.0 / 255.0;

// Colour blends by multiplication, alpha by MIN.
@fragment
fn filter_and_depth(fragment: Fragment) -> @location(0) vec4<f32> {
    let shade = fragment.shade * profile(fragment.q);
    return vec4(1.0 - shade.rgb, select(1.0, fragment.position.z, shade.a >= SEEN));
}

@fragment
fn filter_only(fragment: Fragment) -> @location(0) vec4<f32> {
    return vec4(1.0 - fragment.shade.rgb * profile(fragment.q), 1.0);
}

// The depth test keeps the nearest.
@fragment
fn depth_only(fragment: Fragment) {
    if fragment.shade.a * profile(fragment.q) < SEEN {
        discard;
    }
}
