//! Blocks of texels that subgroups cull casters for: none with a texel that meets a caster is passed by,
//! whatever its shape, and few others are visited. Strands: `tests/stages/strand_blocks.rs`.
use super::strand_blocks::SHAPES;
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, view_from_origin},
    wgsl_files,
};
use gobo::{
    Material, Shape,
    glam::{Quat, UVec2, Vec2, Vec3, Vec4},
    gpu::Library,
    model::{Gaussian, Projection},
    records::{CasterRecord, GaussianAxes, GpuMaterial, GpuView},
    wgpu::{self, BufferUsages},
};
use gobo_reference::{
    gaussian::project_gaussian,
    project::{ProjectParams, Projected},
};

const SIZE: u32 = 128;
const CASES: usize = 100_000;

/// A caster and a block.
#[derive(Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Case {
    /// Bounds of the footprint.
    bounds: Vec4,
    /// Further properties of the caster.
    setup: [Vec4; 3],
    /// First and last texel centre.
    block: [Vec2; 2],
}

/// Where `touches` and `meets` are about a kind of caster.
const COMMON: &str = "
import package::features::PERSPECTIVE;
import package::records::footprint::Footprint;
import package::records::view::GpuView;

struct Case {
    bounds: vec4<f32>,
    first: vec4<f32>,
    second: vec4<f32>,
    third: vec4<f32>,
    block: vec4<f32>,
}

@group(0) @binding(0) var<storage, read> cases: array<Case>;
@group(0) @binding(1) var<storage, read_write> found: array<vec2<u32>>;

fn test_view() -> GpuView {
    var view: GpuView;
    view.size = vec2(128.0);
    view.scale = select(10.0, 64.0, PERSPECTIVE);
    view.perspective = select(0.0, 1.0, PERSPECTIVE);
    view.near = 0.1;
    view.far = 20.0;
    return view;
}

fn test_footprint(it: Case) -> Footprint {
    return Footprint(it.bounds, vec4(0u), false);
}

@compute @workgroup_size(64)
fn test_block(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&cases) {
        return;
    }
    let it = cases[id.x];
    var is_met = false;
    for (var y = it.block.y; y <= it.block.w; y += 1.0) {
        for (var x = it.block.x; x <= it.block.z; x += 1.0) {
            is_met = is_met || meets(it, vec2(x, y));
        }
    }
    found[id.x] = vec2(u32(touches_block(it)), u32(is_met));
}
";

const DISCS: &str = "
import package::hit::disc::{disc_hit, disc_touches, prepare_disc};

fn touches_block(it: Case) -> bool {
    return disc_touches(test_view(), it.bounds, it.block.xy, it.block.zw);
}

fn meets(it: Case, texel: vec2<f32>) -> bool {
    let disc = prepare_disc(test_view(), test_footprint(it));
    return disc_hit(test_view(), disc, texel - disc.center, 1.0).profile > 0.0;
}
";

const GAUSSIANS: &str = "
import package::hit::gaussian::{approach, gaussian_touches};
import package::records::caster::GaussianSetup;

fn test_setup(it: Case) -> GaussianSetup {
    return GaussianSetup(it.first.xyz, it.first.w, it.second.xy, vec2(0u));
}

fn touches_block(it: Case) -> bool {
    return gaussian_touches(test_view(), test_setup(it), it.bounds, it.block.xy, it.block.zw);
}

fn meets(it: Case, texel: vec2<f32>) -> bool {
    let met = approach(test_view(), test_footprint(it), test_setup(it), texel);
    return met.squared <= it.bounds.z * it.bounds.z && met.depth >= 0.0 && met.depth <= 1.0;
}
";

const TRIANGLES: &str = "
import package::accumulator::triangles::{LaneCaster, TriangleSetup, touches, triangle_depth};

fn test_triangle(it: Case) -> TriangleSetup {
    return TriangleSetup(it.first, it.second, it.third, vec3(1.0), 7u, vec3(0.5));
}

fn touches_block(it: Case) -> bool {
    return touches(test_view(), LaneCaster(test_triangle(it), it.bounds.xyz), it.block.xy, it.block.zw);
}

fn meets(it: Case, texel: vec2<f32>) -> bool {
    return triangle_depth(test_triangle(it), texel) < 1.0;
}
";

/// Whether the block of each case is visited, and whether a texel in it meets the caster. `from`, `to`: an
/// edit of the library.
fn found(
    kind: &str,
    projection: Projection,
    cases: &[Case],
    [from, to]: [&str; 2],
) -> Vec<[u32; 2]> {
    let mut files = wgsl_files();
    let edited = files.iter().position(|(_, text)| text.contains(from)).expect("a file");
    files[edited].1 = files[edited].1.replace(from, to);
    files.push(("test_block.wgsl".to_owned(), format!("{kind}{COMMON}")));
    let leak = |text: String| -> &'static str { Box::leak(text.into_boxed_str()) };
    let files: Vec<_> = files.into_iter().map(|(path, text)| (leak(path), leak(text))).collect();
    let library = Library::new(&files).unwrap();
    let linked = library.link("test_block.wgsl", "test_block", &[("column", "choices.wgsl")]);
    let gpu = gpu(TIERS[0]);
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(linked.unwrap().wgsl.into()),
    });
    let is_perspective = f64::from(projection == Projection::Perspective);
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("test_block"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("PERSPECTIVE", is_perspective)],
            ..Default::default()
        },
        cache: None,
    });
    let cases = gpu.upload("cases", cases, BufferUsages::STORAGE);
    let found = gpu.storage::<[u32; 2]>("found", CASES);
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: cases.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: found.as_entire_binding() },
        ],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(CASES.div_ceil(64) as u32, 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&found)
}

/// As `test_view`.
fn view(projection: Projection) -> GpuView {
    view_from_origin(projection, SIZE, [0.1, 20.0], 10.0)
}

/// A block of a random shape, on its grid, within `reach` texels of `center`.
fn block(chance: &mut Chance, center: Vec2, reach: f32) -> [Vec2; 2] {
    let shape = UVec2::from(SHAPES[chance.below(SHAPES.len())]).as_vec2();
    let at = center + Vec2::new(chance.within(-reach, reach), chance.within(-reach, reach));
    let first = (at.clamp(Vec2::ZERO, Vec2::splat(SIZE as f32 - 1.0)) / shape).floor() * shape;
    [first + 0.5, first + shape - 0.5]
}

/// Radius of a caster: from less than a texel to a large part of the map [texels].
fn radius(chance: &mut Chance) -> f32 {
    0.7 * 50_f32.powf(chance.unit())
}

fn position(chance: &mut Chance) -> Vec2 {
    Vec2::new(chance.within(-8.0, 136.0), chance.within(-8.0, 136.0))
}

fn disc(chance: &mut Chance, projection: Projection) -> Case {
    let (center, radius) = (position(chance), radius(chance));
    let share = if projection == Projection::Perspective { 1.0 / 64.0 } else { 1.0 };
    let bounds = center.extend(radius * share).extend(0.5);
    Case { bounds, block: block(chance, center, radius + 8.0), ..Case::default() }
}

fn gaussian(chance: &mut Chance, projection: Projection) -> Case {
    let material = Material { shape: Shape::Gaussian, ..Material::default() };
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    loop {
        let long = 0.05 * 40_f32.powf(chance.unit());
        let [a, b] = [0; 2].map(|_| 100_f32.powf(-chance.unit()));
        let depth = chance.within(0.5, 12.0);
        let aside = if projection == Projection::Perspective { depth } else { 6.4 };
        let across = Vec2::new(chance.within(-aside, aside), chance.within(-aside, aside));
        let gaussian = Gaussian {
            center: across.extend(-depth),
            rotation: Quat::from_axis_angle(chance.vec3(-1.0, 1.0).normalize_or(Vec3::X), 2.0),
            sigma: Vec3::new(long, long * a, long * b),
            opacity: chance.within(0.01, 1.0),
            ..Gaussian::default()
        };
        let caster = CasterRecord::of_gaussian(&gaussian, &material, 0);
        let (axes, of_material) = (GaussianAxes::new(&gaussian), GpuMaterial::new(&material, &[]));
        let view = view(projection);
        let (projected, setup) =
            project_gaussian(&view, 0, &caster, &axes, 0, 0, &of_material, params);
        let footprint = projected.footprint;
        if projected == Projected::INVISIBLE || footprint.radius < 0.0 {
            continue;
        }
        let texels = 3.0 * long * view.scale / if view.perspective > 0.0 { depth } else { 1.0 };
        return Case {
            bounds: footprint.center.extend(footprint.radius).extend(footprint.depth),
            setup: [
                setup.whitening.extend(setup.spread),
                setup.tilt.extend(0.0).extend(0.0),
                Vec4::ZERO,
            ],
            block: block(chance, footprint.center, texels + 8.0),
        };
    }
}

/// In the map as after projection, of whichever view.
fn triangle(chance: &mut Chance, _: Projection) -> Case {
    let (center, reach) = (position(chance), 2.0 * radius(chance));
    let mut corner =
        || center + Vec2::new(chance.within(-reach, reach), chance.within(-reach, reach));
    let [a, mut b, mut c] = [corner(), corner(), corner()];
    if (b - a).perp_dot(c - a) < 0.0 {
        std::mem::swap(&mut b, &mut c);
    }
    let edge = |from: Vec2, to: Vec2| from.extend(to.x - from.x).extend(to.y - from.y);
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let middle = (low + high) * 0.5;
    Case {
        bounds: middle.extend((high - low).max_element() * 0.5 + 1.0 / 64.0).extend(0.0),
        setup: [edge(a, b), edge(b, c), edge(c, a)],
        block: block(chance, middle, reach + 4.0),
    }
}

/// Its kernel, how it is made, and most visits of blocks for one that meets it.
type Kind = (&'static str, fn(&mut Chance, Projection) -> Case, f64);

const KINDS: [Kind; 3] =
    [(DISCS, disc, 1.3), (GAUSSIANS, gaussian, 1.3), (TRIANGLES, triangle, 1.3)];
const SAME: [&str; 2] = ["const SLACK", "const SLACK"];

#[test]
fn no_block_with_a_hit_is_passed_by() {
    for (i, (kind, make, most)) in KINDS.into_iter().enumerate() {
        for projection in [Projection::Orthographic, Projection::Perspective] {
            let mut chance = Chance::new(i as u64);
            let cases: Vec<_> = (0..CASES).map(|_| make(&mut chance, projection)).collect();
            let found = found(kind, projection, &cases, SAME);
            let missed = found.iter().position(|&[visited, met]| met > visited);
            let what = format!("kind {i}, {projection:?}");
            let case = missed.map(|at| (cases[at].bounds, cases[at].setup, cases[at].block));
            assert_eq!(case, None, "{what}");
            let [visited, met] =
                [0, 1].map(|of| found.iter().map(|it| f64::from(it[of])).sum::<f64>());
            println!("{what}: {visited} visits, {met} met");
            assert!(met > 0.1 * CASES as f64 && visited < most * met, "{what}: {visited}, {met}");
        }
    }
}

/// The check can fail: by a block test that is a texel too tight.
#[test]
fn a_tight_block_test_is_noticed() {
    let tight = ["const SLACK: f32 = 0.015625", "const SLACK: f32 = -1.0"];
    for (i, (kind, make, _)) in KINDS.into_iter().take(2).enumerate() {
        let mut chance = Chance::new(i as u64);
        let projection = Projection::Orthographic;
        let cases: Vec<_> = (0..CASES).map(|_| make(&mut chance, projection)).collect();
        let found = found(kind, projection, &cases, tight);
        assert!(found.iter().any(|&[visited, met]| met > visited), "kind {i}");
    }
}
