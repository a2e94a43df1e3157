//! Filter maps in layouts that hosts' receivers already read.
use super::{
    ShadowSettings, depths, materials, particles,
    rendered::{CONVENTIONS, world},
    shadows,
};
use crate::common::{TIERS, gpu};
use gobo::{
    Casters, Prepared, View,
    glam::DVec4,
    gpu::Gpu,
    host::{ConvertedMaps, FilterFormat, MapLayout},
};
use half::f16;

/// A spot and a sun, and their neighbours in the atlas.
fn prepared(gpu: &Gpu) -> (Prepared, Vec<View>) {
    let mut particles = particles(300, 13);
    particles.iter_mut().for_each(|particle| particle.material = 0);
    let materials = materials();
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let views = depths::views().to_vec();
    let prepared = shadows(gpu).prepare(&casters, &views, &ShadowSettings::default()).unwrap();
    (prepared, views)
}

fn submit(gpu: &Gpu, prepared: &Prepared, converted: &ConvertedMaps) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    converted.record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    gpu.check().unwrap();
}

/// All texels of all views: index into textures, view, its index, and position.
fn texels<'a>(prepared: &Prepared, views: &'a [View]) -> Vec<(usize, &'a View, usize, [u32; 2])> {
    let size = prepared.maps().filters.size();
    let mut all = Vec::new();
    for (index, (view, slot)) in views.iter().zip(&prepared.maps().slots).enumerate() {
        for i in 0..view.size.element_product() {
            let (x, y) = (i % view.size.x, i / view.size.x);
            let row = slot.layer * size.height + slot.origin.y + y;
            all.push(((row * size.width + slot.origin.x + x) as usize, view, index, [x, y]));
        }
    }
    all
}

#[test]
fn formats_lose_what_they_say() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let (prepared, views) = prepared(&gpu);
        let make = |format| prepared.converted(&MapLayout::new(format)).unwrap();
        let [whole, bytes, short] =
            [FilterFormat::Rgba16Float, FilterFormat::Rgba8Unorm, FilterFormat::Rg11b10Ufloat]
                .map(make);
        for converted in [&whole, &bytes, &short] {
            submit(&gpu, &prepared, converted);
        }
        let filters: Vec<[u16; 4]> = gpu.read_texture(&prepared.maps().filters);
        let whole: Vec<[u16; 4]> = gpu.read_texture(whole.texture());
        let bytes: Vec<[u8; 4]> = gpu.read_texture(bytes.texture());
        let short: Vec<u32> = gpu.read_texture(short.texture());
        let value = |bits: u16| f16::from_bits(bits).to_f32();
        let mut shade = 0;
        for (i, ..) in texels(&prepared, &views) {
            assert_eq!(whole[i][..3], filters[i][..3]);
            assert_eq!(value(whole[i][3]), 1.0);
            assert_eq!(bytes[i][3], 255);
            let shorts = [short[i] << 4, short[i] >> 11 << 4, short[i] >> 22 << 5];
            for c in 0..3 {
                let light = value(filters[i][c]);
                assert!((f32::from(bytes[i][c]) / 255.0 - light).abs() <= 1.0 / 509.0, "{light}");
                let found = value((shorts[c] & 0x7fff) as u16);
                let loss = if c == 2 { 1.0 / 64.0 } else { 1.0 / 128.0 };
                assert!((found - light).abs() <= light * loss, "{c}: {found} {light}");
                shade += usize::from(light < 0.9);
            }
        }
        assert!(shade > 1000, "{shade}");
    }
}

/// The depth in alpha is the host's own, and the host's comparison with the receiver gives the same result as
/// ours: light is filtered behind the nearest translucent hit, and not in front of it.
#[test]
fn alpha_is_the_hosts_depth_of_what_filters_first() {
    let gpu = gpu(TIERS[0]);
    let (prepared, views) = prepared(&gpu);
    for convention in CONVENTIONS {
        let cameras: Vec<_> = views.iter().map(|view| world(convention, view)).collect();
        let layout = MapLayout::new(FilterFormat::Rgba16Float).depth_in_alpha(&cameras);
        let converted = prepared.converted(&layout).unwrap();
        submit(&gpu, &prepared, &converted);
        let nearests: Vec<f32> = gpu.read_texture(&prepared.maps().nearests);
        let found: Vec<[u16; 4]> = gpu.read_texture(converted.texture());
        let is_reversed = convention.empty() == 0.0;
        let mut filtered = 0;
        for (i, view, ..) in texels(&prepared, &views) {
            let clip = convention.clip_from_view(view);
            let host_depth = |depth: f64| {
                let (near, far) = (f64::from(view.near), f64::from(view.far));
                let at = clip * DVec4::new(0.0, 0.0, -(near + depth * (far - near)), 1.0);
                (at.z / at.w) as f32
            };
            let alpha = f16::from_bits(found[i][3]).to_f32();
            if nearests[i] == 1.0 {
                assert_eq!(alpha, convention.empty());
                continue;
            }
            let expected = host_depth(nearests[i].into());
            assert!((alpha - expected).abs() <= 6e-4 * expected.abs() + 1e-6, "{alpha} {expected}");
            filtered += 1;
            // Half floats of a depth that is not reversed do not resolve distant depths: hosts use reversed
            // z.
            let [before, behind] = [-0.05, 0.05].map(|by| host_depth(f64::from(nearests[i]) + by));
            if is_reversed {
                assert!(alpha > behind && alpha < before, "{before} {alpha} {behind}");
            }
        }
        assert!(filtered > 1000, "{filtered}");
    }
}

#[test]
fn layouts_that_cannot_be_are_named() {
    let gpu = gpu(TIERS[0]);
    let (prepared, views) = prepared(&gpu);
    let cameras: Vec<_> = views.iter().map(|view| world(CONVENTIONS[0], view)).collect();
    let error = |layout: &MapLayout<'_>| prepared.converted(layout).map(|_| ()).unwrap_err();
    let swapped = [cameras[1], cameras[0]];
    for (layout, problem) in [
        (MapLayout::new(FilterFormat::Rg11b10Ufloat).depth_in_alpha(&cameras), "no alpha"),
        (MapLayout::new(FilterFormat::Rgba8Unorm).depth_in_alpha(&cameras[..1]), "each view"),
        (MapLayout::new(FilterFormat::Rgba8Unorm).depth_in_alpha(&swapped), "camera"),
    ] {
        let message = error(&layout).to_string();
        assert!(message.starts_with("map layout ") && message.contains(problem), "{message}");
    }
    assert!(gpu.check().is_ok());
}
