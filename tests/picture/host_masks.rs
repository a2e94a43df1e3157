//! Shadow masks of a host's depths, normals and shadow functions, compared with the picture's masks and with
//! known values of a function.
use super::masks::{OFF, room};
use crate::common::{TIERS, gpu, shadows};
use gobo::{
    Error, Light, Prepared, Shadows, View,
    glam::{DMat4, DVec3, DVec4, Mat4, UVec2, Vec3},
    gpu::{Gpu, Timeline},
    host::{LightMasks, MaskSlot, MaskView, ShadowFunction},
    model::MaskSettings,
    view::shadow_views,
    wgpu::{self, TextureFormat},
};
use gobo_picture::picture::{PictureCapacity, PictureRequest, PreparedPicture};
use gobo_scene::Scene;

const SIZE: UVec2 = UVec2::new(96, 64);

fn texture<T: bytemuck::NoUninit>(gpu: &Gpu, format: TextureFormat, texels: &[T]) -> wgpu::Texture {
    let own = gpu.texture("host", SIZE.to_array(), format);
    gpu.write_texture(&own, texels);
    own
}

/// Surfaces and masks of a frame of the picture.
struct Shown {
    camera: View,
    /// Light depth.
    depths: Vec<f32>,
    masks: Vec<[u8; 4]>,
}

fn shown(gpu: &Gpu, scene: &Scene) -> Shown {
    let mut shadows = shadows(gpu);
    let prepared = &shadows.prepare(&scene.casters(), &shadow_views(scene), &scene.shadow).unwrap();
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    let capacity = PictureCapacity::default();
    let request = PictureRequest { scene, camera: &camera, prepared, capacity };
    let picture = PreparedPicture::new(&shadows, &request, &mut Default::default()).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    picture.record(&mut encoder, &mut Timeline::untimed());
    gpu.queue.submit([encoder.finish()]);
    let depths = picture.read_radiance(gpu).unwrap().iter().map(|texel| texel[3]).collect();
    Shown { camera, depths, masks: picture.read_masks(gpu).unwrap() }
}

/// Position of a pixel's surface, in 64 bits.
fn place(camera: &View, pixel: usize, depth: f32) -> DVec3 {
    let at = UVec2::new(pixel as u32 % SIZE.x, pixel as u32 / SIZE.x).as_dvec2() + 0.5;
    let slope = (at - SIZE.as_dvec2() * 0.5) / f64::from(camera.scale);
    let (near, far) = (f64::from(camera.near), f64::from(camera.far));
    let ray = DVec3::new(slope.x, -slope.y, -1.0) * (near + f64::from(depth) * (far - near));
    camera.view_from_world.as_dmat4().inverse().transform_point3(ray)
}

/// Normal of the ground or of the wall.
fn normal(place: DVec3) -> [f32; 4] {
    if place.y.abs() < (place.z + 2.0).abs() { [0.0, 1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0, 0.0] }
}

/// A host on the device, with the maps of a scene.
struct Host {
    gpu: Gpu,
    shadows: Shadows,
    prepared: Prepared,
}

impl Host {
    fn new(scene: &Scene) -> Self {
        let gpu = gpu(TIERS[0]);
        let mut shadows = shadows(&gpu);
        let views = shadow_views(scene);
        let prepared = shadows.prepare(&scene.casters(), &views, &scene.shadow).unwrap();
        Self { gpu, shadows, prepared }
    }

    fn run(&self, masks: &LightMasks) -> Vec<[u8; 4]> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.prepared.record(&mut encoder).unwrap();
        masks.record(&mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
        let mut texels = self.gpu.read_texture(masks.texture().unwrap());
        texels.truncate((masks.count() * SIZE.x * SIZE.y) as usize);
        texels
    }
}

fn opaque_room() -> Scene {
    let mut scene = room(false);
    scene.materials.truncate(1);
    scene
}

/// From the picture's depths and normals a host gets the picture's bytes.
#[test]
fn a_hosts_depths_and_normals_give_the_masks_of_the_picture() {
    for (glass, half, taps) in
        [(false, false, 1), (false, true, 7), (true, true, 11), (true, false, 5)]
    {
        let settings = MaskSettings { half, taps, ..OFF };
        let mut scene = if glass { room(true) } else { opaque_room() };
        scene.mask = Some(settings);
        let host = Host::new(&scene);
        let seen = shown(&host.gpu, &scene);
        let normals =
            (0..).zip(&seen.depths).map(|(i, &depth)| normal(place(&seen.camera, i, depth)));
        let normals: Vec<[f32; 4]> = normals.collect();
        let depth = texture(&host.gpu, TextureFormat::R32Float, &seen.depths);
        let normals = texture(&host.gpu, TextureFormat::Rgba32Float, &normals);
        let view = MaskView::light_depth(&seen.camera, &depth).normals(&normals);
        let mut masks = LightMasks::new();
        masks.prepare(&host.prepared, &scene.lights, &[0, 1], &view, &settings).unwrap();
        let own = host.run(&masks);
        let dark = seen.masks.iter().filter(|texel| texel[0].min(texel[1]) < 100).count();
        assert!(dark > 30, "{dark}: nothing is in the shadow");
        assert!(own == seen.masks, "glass {glass} half {half} taps {taps}");
        // The check can fail.
        let other = MaskSettings { taps: taps + 2, ..settings };
        masks.prepare(&host.prepared, &scene.lights, &[0, 1], &view, &other).unwrap();
        assert!(host.run(&masks) != seen.masks);
    }
}

/// Reversed depth without a far plane, and normals derived from it.
#[test]
fn normals_may_come_from_reversed_depths() {
    let settings = MaskSettings { taps: 7, ..OFF };
    let mut scene = opaque_room();
    scene.mask = Some(settings);
    let host = Host::new(&scene);
    let seen = shown(&host.gpu, &scene);
    let camera = &seen.camera;
    let half = SIZE.as_dvec2() * 0.5 / f64::from(camera.scale);
    let near = 0.1;
    let clip_from_view = DMat4::from_cols(
        DVec4::X / half.x,
        DVec4::Y / half.y,
        DVec4::new(0.0, 0.0, 0.0, -1.0),
        DVec4::new(0.0, 0.0, near, 0.0),
    );
    let clip = clip_from_view * camera.view_from_world.as_dmat4();
    let clip: Mat4 = clip.as_mat4();
    let reversed = |(i, &depth): (usize, &f32)| {
        let at = camera.view_from_world.as_dmat4().transform_point3(place(camera, i, depth));
        if depth < 1.0 { (near / -at.z) as f32 } else { 0.0 }
    };
    let depths: Vec<f32> = seen.depths.iter().enumerate().map(reversed).collect();
    let depth = texture(&host.gpu, TextureFormat::R32Float, &depths);
    let view = MaskView::new(clip.to_cols_array_2d(), &depth);
    let mut masks = LightMasks::new();
    masks.prepare(&host.prepared, &scene.lights, &[0, 1], &view, &settings).unwrap();
    let own = host.run(&masks);
    let far = |(a, b): (&[u8; 4], &[u8; 4])| a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])) > 4;
    let differ = own.iter().zip(&seen.masks).filter(|&pair| far(pair)).count();
    // On the edge between ground and wall a derived normal is between the two.
    assert!(differ <= 120, "{differ}");
    let shifted = own.iter().skip(3).zip(&seen.masks).filter(|&pair| far(pair)).count();
    assert!(shifted > 300, "{shifted}: the check sees nothing");
}

const CLOUDS: &str = "\
struct Clouds { share: vec3<f32>, edge: f32 }
@group(1) @binding(0) var<uniform> clouds: Clouds;

fn host_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let covered = position.x > clouds.edge && light == 1u;
    return select(vec3(1.0), clouds.share * (0.5 + 0.5 * normal.y), covered);
}
";

struct Clouds {
    function: ShadowFunction,
    bindings: wgpu::BindGroup,
}

fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("clouds"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

fn clouds(host: &Host, share: Vec3, edge: f32) -> Clouds {
    let Host { gpu, shadows, .. } = host;
    let layout = layout(gpu);
    let values = [share.x, share.y, share.z, edge];
    let buffer = gpu.upload("clouds", &values, wgpu::BufferUsages::UNIFORM);
    let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("clouds"),
        layout: &layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
    });
    let function = shadows.shadow_function("clouds.wgsl", CLOUDS, &layout).unwrap();
    Clouds { function, bindings }
}

/// A host's function multiplies the maps' share.
#[test]
fn a_hosts_function_multiplies_what_the_maps_say() {
    let share = Vec3::new(0.2, 0.6, 0.9);
    let mut scene = opaque_room();
    scene.mask = Some(OFF);
    // The lamp has no shadow map: only the host's function shadows it.
    scene.lights[1].casts = false;
    for lamp_casts in [false, true] {
        scene.lights[1].casts = lamp_casts;
        let host = Host::new(&scene);
        let seen = shown(&host.gpu, &scene);
        let clouds = clouds(&host, share, 0.2);
        let depth = texture(&host.gpu, TextureFormat::R32Float, &seen.depths);
        let normals =
            (0..).zip(&seen.depths).map(|(i, &depth)| normal(place(&seen.camera, i, depth)));
        let normals: Vec<[f32; 4]> = normals.collect();
        let normals = texture(&host.gpu, TextureFormat::Rgba32Float, &normals);
        let view = MaskView::light_depth(&seen.camera, &depth).normals(&normals).joined(
            &clouds.function,
            &clouds.bindings,
            &[1],
        );
        let mut masks = LightMasks::new();
        masks.prepare(&host.prepared, &scene.lights, &[0, 1], &view, &OFF).unwrap();
        let slots = masks.slots();
        assert_eq!(slots[0], Some(MaskSlot { layer: 0, channel: Some(0) }));
        assert_eq!(slots[1], Some(MaskSlot { layer: 1, channel: None }));
        let own = host.run(&masks);
        let pixels = (SIZE.x * SIZE.y) as usize;
        let (mut covered, mut wrong) = (0, 0);
        for i in (0..pixels).filter(|&i| seen.depths[i] < 1.0) {
            // The sun is shadowed as in the picture.
            assert_eq!(own[i][0], seen.masks[i][0]);
            let place = place(&seen.camera, i, seen.depths[i]);
            if (place.x - 0.2).abs() < 1e-3 {
                continue;
            }
            let is_covered = place.x > 0.2;
            let facing = 0.5 + 0.5 * f64::from(normal(place)[1]);
            let by_maps = if lamp_casts { f64::from(seen.masks[i][1]) / 255.0 } else { 1.0 };
            let by_host = if is_covered { share.as_dvec3() * facing } else { DVec3::ONE };
            let known = by_host * by_maps * 255.0;
            covered += usize::from(is_covered);
            let error = (0..3).map(|c| (f64::from(own[pixels + i][c]) - known[c]).abs());
            wrong += usize::from(error.fold(0.0, f64::max) > 1.01);
        }
        assert!(covered > 500 && covered < pixels - 500, "{covered}");
        assert_eq!(wrong, 0, "lamp casts: {lamp_casts}");
    }
}

#[test]
fn errors_point_into_the_hosts_function() {
    let host = Host::new(&opaque_room());
    let layout = layout(&host.gpu);
    let error = |text: &str| {
        host.shadows.shadow_function("clouds.wgsl", text, &layout).unwrap_err().to_string()
    };
    let line = |of: &str| 1 + CLOUDS.lines().position(|line| line.contains(of)).unwrap();
    for (from, to) in [
        ("let covered = position", "let = position"),
        ("position.x > clouds", "positions.x > clouds"),
    ] {
        let message = error(&CLOUDS.replace(from, to));
        let at = format!("clouds.wgsl:{}:", line(from));
        assert!(message.contains(&at), "{at} {message}");
    }
    let none = error("fn other() {}");
    assert!(none.contains("host_shadow") && none.contains("wgsl/mask/"), "{none}");
    assert!(host.gpu.check().is_ok());
}

#[test]
fn views_that_cannot_be_used_are_named() {
    let scene = opaque_room();
    let host = Host::new(&scene);
    let depth = texture(&host.gpu, TextureFormat::R32Float, &[0.5_f32; 96 * 64]);
    let color = texture(&host.gpu, TextureFormat::Rgba32Float, &[[0.0_f32; 4]; 96 * 64]);
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    let other = View { size: UVec2::new(64, 64), ..camera.clone() };
    let clip = camera.clip_from_world().to_cols_array_2d();
    let mut masks = LightMasks::new();
    let mut error = |view: MaskView<'_>, settings: MaskSettings| -> Error {
        masks.prepare(&host.prepared, &scene.lights, &[0], &view, &settings).unwrap_err()
    };
    for (view, problem) in [
        (MaskView::new(clip, &color), "format"),
        (MaskView::new(clip, &depth).layer(1), "no such layer"),
        (MaskView::new(clip, &depth).normals(&depth), "normals"),
        (MaskView::new([[0.0; 4]; 4], &depth), "perspective"),
        (MaskView::light_depth(&other, &depth), "size"),
    ] {
        let message = error(view, OFF).to_string();
        assert!(message.contains("view of masks") && message.contains(problem), "{message}");
    }
    for settings in [MaskSettings { taps: 4, ..OFF }, MaskSettings { limit: 0, ..OFF }] {
        let message = error(MaskView::new(clip, &depth), settings).to_string();
        assert!(message.contains("mask setting"), "{message}");
    }
}

/// Textures are kept while lights are added and removed.
#[test]
fn textures_are_taken_over_from_frame_to_frame() {
    let mut scene = opaque_room();
    let lamp = scene.lights[1].clone();
    scene.lights = (0..9)
        .map(|i| Light { name: format!("lamp{i}"), size: Some(16), ..lamp.clone() })
        .collect();
    let host = Host::new(&scene);
    let depth = texture(&host.gpu, TextureFormat::R32Float, &[0.5_f32; 96 * 64]);
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    let view = MaskView::light_depth(&camera, &depth);
    let settings = MaskSettings { half: true, taps: 3, ..OFF };
    let mut masks = LightMasks::new();
    let prepare = |masks: &mut LightMasks, count: usize| {
        let chosen: Vec<usize> = (0..count).collect();
        masks.prepare(&host.prepared, &scene.lights, &chosen, &view, &settings).unwrap();
        assert_eq!(masks.count() as usize, count.div_ceil(4));
        (masks.texture().unwrap().clone(), masks.memory().total())
    };
    let (few, little) = prepare(&mut masks, 2);
    let (all, most) = prepare(&mut masks, 9);
    assert!(few != all && little < most, "nine lights need more room: {little} {most}");
    for frame in 0..20 {
        let (texture, bytes) = prepare(&mut masks, 1 + frame * 7 % 9);
        assert!(texture == all, "frame {frame}: another texture");
        assert!(bytes <= most, "frame {frame}: {bytes} of {most}");
    }
    // The check can fail: another size needs other textures.
    let whole = MaskSettings { half: false, ..settings };
    masks.prepare(&host.prepared, &scene.lights, &[0], &view, &whole).unwrap();
    assert!(*masks.texture().unwrap() != all);
}
