//! Interface of the library for hosts.
use crate::common::{
    TIERS,
    scenes::{material, nearest_depth, particle, random_discs},
};
use gobo::{
    Bounds, Camera, Casters, Error, Gpu, Light, Material, Particle, Prepared, ShadowSettings,
    Shadows, Texture, Transfer, Triangle, View,
    glam::{Mat4, UVec2, Vec3, Vec4},
    gpu::{Selection, Tier},
    light_views, wgpu,
};

fn open(tier: Tier) -> (Gpu, Shadows) {
    let gpu = Gpu::new(&Selection { tier: Some(tier), ..Selection::default() });
    let gpu = gpu.unwrap_or_else(|error| panic!("{error}"));
    let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter).unwrap();
    shadows.configure(|config| {
        assert_eq!(config.tier, tier);
        config.toggles.scatter_tiny = false;
    });
    (gpu, shadows)
}

fn views() -> Vec<View> {
    let bounds = Bounds { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };
    let lamp = Light::point(Vec3::Y * 4.0);
    light_views(0, &lamp, 64, None, &bounds).unwrap()
}

fn submit(gpu: &Gpu, prepared: &Prepared) -> Vec<[u16; 4]> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
    gpu.read_texture(&prepared.maps().filters)
}

fn of<'a>(particles: &'a [Particle], materials: &'a [Material]) -> Casters<'a> {
    Casters { particles, materials, ..Casters::default() }
}

#[test]
fn a_host_that_grows_has_no_overflow_and_the_same_map() {
    let (gpu, mut shadows) = open(TIERS[1]);
    // Each covers all tiles of a face: more pairs than the initial capacity of any frame.
    let particles: Vec<_> = (0..70_000_u32)
        .map(|i| {
            let alpha = if i % 8 == 0 { 2.5e-4 } else { 0.0 };
            particle(Vec3::Y * (i as f32 * 1e-6), 3.0, Vec4::new(1.0, 0.5, 1.0, alpha))
        })
        .collect();
    let materials = [material(Transfer::Filter)];
    let (casters, views) = (of(&particles, &materials), &views()[3..4]);
    let settings = ShadowSettings::default();
    let prepared = shadows.prepare(&casters, views, &settings).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record_counts(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
    let first = prepared.counters().unwrap();
    let crowded = submit(&gpu, &prepared);
    let counters = prepared.counters().unwrap();
    assert!(counters.overflowed > 0, "{counters:?}");
    assert_eq!(
        (first.pairs_needed, first.pair_capacity),
        (counters.pairs_needed, counters.pair_capacity)
    );
    assert!(shadows.grow_from(&counters));
    let prepared = shadows.prepare(&casters, views, &settings).unwrap();
    let roomy = submit(&gpu, &prepared);
    let counters = prepared.counters().unwrap();
    assert_eq!((counters.overflowed, counters.views_rendered), (0, 1), "{counters:?}");
    assert!(!shadows.grow_from(&counters));
    let green = |texel: &[u16; 4]| half::f16::from_bits(texel[1]).to_f32();
    let pairs = || crowded.iter().map(green).zip(roomy.iter().map(green));
    // A scattered hit of 8 units of fixed point is off by at most half a unit.
    assert!(pairs().all(|(a, b)| (a - b).abs() <= 0.04));
    assert!(pairs().any(|(a, _)| a < 0.7), "there is a shadow");
}

#[test]
fn maps_stay_until_something_changes_and_old_handles_are_void() {
    let (gpu, mut shadows) = open(TIERS[1]);
    let materials = [material(Transfer::Filter)];
    let mut particles = random_discs(500, 3);
    let (views, settings) = (views(), ShadowSettings::default());
    let first = shadows.prepare(&of(&particles, &materials), &views, &settings).unwrap();
    submit(&gpu, &first);
    assert_eq!(first.counters().unwrap().views_rendered, 6);
    let second = shadows.prepare(&of(&particles, &materials), &views, &settings).unwrap();
    let before = submit(&gpu, &second);
    let counters = second.counters().unwrap();
    assert_eq!((counters.views_rendered, counters.views_kept), (0, 6));
    assert!(matches!(first.counters(), Err(Error::Superseded)));

    particles.iter_mut().for_each(|particle| particle.center = Vec3::new(0.1, 0.0, 0.1));
    let third = shadows.prepare(&of(&particles, &materials), &views, &settings).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    assert!(matches!(second.record(&mut encoder), Err(Error::Superseded)));
    gpu.queue.submit([encoder.finish()]);
    let kept = gpu.read_texture::<[u16; 4]>(&second.maps().filters);
    assert!(kept == before, "a superseded frame records nothing");
    assert!(submit(&gpu, &third) != before);
    shadows.forget();
    assert!(matches!(third.counters(), Err(Error::Superseded)));
    let fresh = shadows.prepare(&of(&particles, &materials), &views, &settings).unwrap();
    submit(&gpu, &fresh);
    assert_eq!(fresh.counters().unwrap().views_rendered, 6);
}

#[test]
fn what_cannot_be_used_is_named() {
    let (_, mut shadows) = open(TIERS[0]);
    let settings = ShadowSettings::default();
    let mut error = |casters: &Casters<'_>, views: &[View], settings: &ShadowSettings| {
        shadows.prepare(casters, views, settings).map(|_| ()).unwrap_err().to_string()
    };
    let good = particle(Vec3::ZERO, 0.1, Vec4::ONE);
    let materials = [material(Transfer::Filter)];
    let endless = Particle { center: Vec3::new(0.0, f32::NAN, 0.0), ..good };
    for (bad, problem) in [
        (Particle { material: 1, ..good }, "material"),
        (Particle { radius: 0.0, ..good }, "radius"),
        (endless, "centre"),
    ] {
        let message = error(&of(&[good, bad], &materials), &views(), &settings);
        assert!(message.starts_with("particle 1 ") && message.contains(problem), "{message}");
    }
    let textured = [Material { texture: Some(0), ..materials[0].clone() }];
    assert!(error(&of(&[good], &textured), &views(), &settings).starts_with("material 0 "));
    let one = [good];
    let textures = [Texture { name: String::new(), width: 2, height: 2, rgba: vec![0; 15] }];
    let casters = Casters { textures: &textures, ..of(&one, &textured) };
    assert!(error(&casters, &views(), &settings).starts_with("texture 0 "));
    let many = vec![materials[0].clone(); 513];
    assert!(error(&of(&[good], &many), &views(), &settings).contains("512"));
    let mut flat = views();
    flat[2].far = flat[2].near;
    assert!(error(&of(&[good], &materials), &flat, &settings).starts_with("view 2 "));
    let odd = ShadowSettings { nodes: 7, ..settings };
    assert!(error(&of(&[good], &materials), &views(), &odd).contains("nodes"));
    shadows.prepare(&of(&[good], &materials), &views(), &settings).unwrap();
}

/// A host that requests the features and leaves the limits at their defaults, which are too low for the
/// native kernels.
#[test]
fn a_device_of_usual_limits_is_enough() {
    let adapters = gobo::gpu::adapters(&Selection::default());
    let adapter = adapters.first().expect("there is an adapter");
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: Tier::Native.features(),
        ..Default::default()
    }))
    .unwrap();
    let mut shadows = Shadows::new(&device, &queue, &adapter.get_info()).unwrap();
    let (particles, materials) = (random_discs(50, 3), [material(Transfer::Filter)]);
    for settings in [ShadowSettings::default(), nearest_depth()] {
        let prepared = shadows.prepare(&of(&particles, &materials), &views(), &settings).unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder).unwrap();
        queue.submit([encoder.finish()]);
        assert!(prepared.counters().unwrap().visible > 0);
    }
}

/// For any near and far planes and either direction of depth.
#[test]
fn a_camera_is_what_its_matrix_says() {
    let camera = Camera {
        eye: Vec3::new(40.0, 3.0, -6.0),
        target: Vec3::new(38.0, 2.5, 1.0),
        up: Vec3::new(0.1, 1.0, 0.0),
        fov_y: 0.9,
        size: UVec2::new(640, 400),
    };
    let back = (camera.eye - camera.target).normalize();
    let right = camera.up.cross(back).normalize();
    let pose = [right, back.cross(right), back].map(|axis| axis.extend(0.0));
    let view = Mat4::from_cols(pose[0], pose[1], pose[2], camera.eye.extend(1.0)).inverse();
    // Depth is (a z + b) / -z.
    let scale = 1.0 / (0.5 * camera.fov_y).tan();
    let project = |a: f32, b: f32| {
        let diagonal = Mat4::from_scale(Vec3::new(scale / 1.6, scale, 1.0));
        Mat4 {
            z_axis: Vec4::new(0.0, 0.0, a, -1.0),
            w_axis: Vec4::new(0.0, 0.0, b, 0.0),
            ..diagonal
        }
    };
    let (near, far) = (0.1, 900.0);
    let finite = project(far / (near - far), near * far / (near - far));
    let reversed = project(near / (far - near), near * far / (far - near));
    let (infinite, both) = (project(-1.0, -near), project(0.0, near));
    for projection in [finite, reversed, infinite, both] {
        let clip = (projection * view).to_cols_array_2d();
        let read = Camera::from_clip(clip, camera.size).unwrap();
        assert!(read.eye.distance(camera.eye) < 1e-3, "{read:?}");
        let [ahead, expected] = [read, camera].map(|c| (c.target - c.eye).normalize());
        assert!(ahead.distance(expected) < 1e-4, "{read:?}");
        assert!((read.fov_y - camera.fov_y).abs() < 1e-4 && read.size == camera.size, "{read:?}");
        assert!(read.up.distance(camera.up.reject_from(expected).normalize()) < 1e-4, "{read:?}");
    }
    // An off-axis frustum is enclosed, here one shifted by half its picture.
    let aside = Mat4 { z_axis: finite.z_axis - 0.5 * Vec4::X, ..finite };
    let read = Camera::from_clip((aside * view).to_cols_array_2d(), [640, 400]).unwrap();
    let wide = 2.0 * (1.5 * (0.5 * camera.fov_y).tan()).atan();
    assert!((read.fov_y - wide).abs() < 1e-3, "{read:?}");
    let flat = Mat4::from_scale(Vec3::new(0.5, 0.8, -0.1)) * view;
    let bad = [flat, Mat4::ZERO, Mat4::from_cols_array(&[f32::NAN; 16])];
    for (matrix, problem) in bad.into_iter().zip(["perspective", "perspective", "finite"]) {
        let error = Camera::from_clip(matrix.to_cols_array_2d(), [64, 64]).unwrap_err();
        assert!(error.to_string().contains(problem), "{error}");
    }
    assert!(Camera::from_clip(finite.to_cols_array_2d(), [0, 64]).is_err());
}

/// The interface takes plain arrays from any vector library.
#[test]
fn plain_numbers_are_enough() {
    let lamp = Light::spot([0.0, 3.0, 0.0], [0.0, -1.0, 0.0], 0.8);
    assert_eq!(lamp, Light::spot(Vec3::Y * 3.0, Vec3::NEG_Y, 0.8));
    let floor = Triangle::flat([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]], 2);
    assert_eq!((floor.normals, floor.material), ([Vec3::Y; 3], 2));
    let smoke = Particle::new([1.0, 2.0, 3.0], 0.2).with_color([0.5, 0.5, 0.5, 0.1]);
    assert_eq!((smoke.center, smoke.radius), (Vec3::new(1.0, 2.0, 3.0), 0.2));
    assert_eq!(smoke.color, Vec4::new(0.5, 0.5, 0.5, 0.1));
    let bounds = Bounds::new([-1.0; 3], Vec3::ONE);
    assert_eq!(bounds, Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE });
}
