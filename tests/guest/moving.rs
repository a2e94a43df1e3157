//! Frames in which everything moves: their allocations on the device, and their maps.
use super::{
    HostBuffers, assert_equal, count_buffer, counted, materials, particles, shadows, submit,
};
use crate::common::{TIERS, Tier, counted_gpu, gpu};
use gobo::{
    Bounds, CasterCount, Casters, HostCasters, HostInputs, Light, Particle, Prepared, Receiver,
    ShadowSettings, Shadows, View,
    glam::Vec3,
    gpu::RecordForm,
    host::{FilterFormat, LightMasks, MapLayout, MaskView, PointBuffers},
    light_views,
    model::{MaskSettings, Source},
    wgpu,
};

const SPOTS: u32 = 16;

fn lights(frame: u32) -> Vec<Light> {
    let spot = |i: u32| {
        let angle = i as f32 * 0.39 + frame as f32 * 0.05;
        let position = Vec3::new(4.0 * angle.cos(), 4.0, 4.0 * angle.sin());
        let source = i.is_multiple_of(2).then_some(Source::Sphere { radius: 0.1 });
        Light { source, ..Light::spot(position, -position, 0.6) }
    };
    (0..SPOTS).map(spot).collect()
}

fn spots(frame: u32) -> Vec<View> {
    let bounds = Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
    let views = (0..).zip(lights(frame));
    views.flat_map(|(i, light)| light_views(i, &light, 64, None, &bounds).unwrap()).collect()
}

/// Number of living buffers, textures, texture views, bind groups and pipelines.
fn living(device: &wgpu::Device) -> isize {
    let hal = device.get_internal_counters().hal;
    hal.buffers.read()
        + hal.textures.read()
        + hal.texture_views.read()
        + hal.bind_groups.read()
        + hal.compute_pipelines.read()
}

fn prepare(
    shadows: &mut Shadows,
    uploaded: &[Particle],
    sets: &[HostCasters<'_>],
    settings: &ShadowSettings,
    frame: u32,
) -> Prepared {
    let materials = materials();
    let casters = Casters { particles: uploaded, materials: &materials, ..Casters::default() };
    let inputs = HostInputs::new().casters(sets).area_lights();
    shadows.prepare_with(&casters, &spots(frame), settings, &inputs).unwrap()
}

/// A host's depths or normals.
fn seen(device: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("seen"),
        size: wgpu::Extent3d { width: 64, height: 64, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Every frame is kept alive, so that its allocations show even if an earlier one drops as much.
#[test]
fn nothing_is_made_where_everything_moves() {
    let curve = ShadowSettings { size: 64, ..ShadowSettings::default() };
    let nearest = ShadowSettings { receiver: Receiver::Nearest, ..curve };
    for (tier, settings) in TIERS.into_iter().zip([nearest, curve]) {
        let (gpu, _guard) = counted_gpu(tier);
        let mut moving = shadows(&gpu);
        let mut all = particles(600, 4);
        let host = HostBuffers::new(&gpu, &all);
        let loader = host.loader(&moving);
        let mut uploaded = particles(300, 8);
        let mut masks = LightMasks::new();
        let [depths, normals] = [wgpu::TextureFormat::R32Float, wgpu::TextureFormat::Rgba16Float]
            .map(|format| seen(&gpu.device, format));
        let positions =
            gpu.upload("positions", &[[0.1f32, 0.2, 0.3]; 50], wgpu::BufferUsages::STORAGE);
        let points = PointBuffers { count: 50, positions: &positions, normals: None };
        let (mut held, mut before) = (Vec::new(), 0);
        for frame in 0..8 {
            if frame == 3 {
                before = living(&gpu.device);
            }
            for particle in all.iter_mut().chain(&mut uploaded) {
                particle.center.y += 0.01;
            }
            host.write(&gpu, &all);
            let count = CasterCount::Fixed(600);
            let sets = [HostCasters::new(&loader, &host.bindings, count, &[0, 1])];
            let prepared = prepare(&mut moving, &uploaded, &sets, &settings, frame);
            let (lights, chosen) = (lights(frame), [2, 0, 3, 5]);
            let bound = prepared.bind_lights(&lights, &chosen).unwrap();
            let areas = prepared.bind_area_lights(&lights, &chosen).unwrap();
            let lit = prepared.light_points(&lights, &chosen, &points).unwrap();
            let views = spots(frame);
            let clip = |view: &View| view.clip_from_world().to_cols_array_2d();
            let cameras: Vec<_> = views.iter().map(clip).collect();
            let layout = MapLayout::new(FilterFormat::Rgba16Float).depth_in_alpha(&cameras);
            let converted = prepared.converted(&layout).unwrap();
            let view = MaskView::light_depth(&views[1], &depths).normals(&normals);
            masks.prepare(&prepared, &lights, &chosen, &view, &MaskSettings::default()).unwrap();
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder).unwrap();
            areas.record(&mut encoder);
            lit.record(&mut encoder);
            converted.record(&mut encoder);
            masks.record(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            held.push((prepared, bound, areas, lit, converted));
        }
        let made = living(&gpu.device) - before;
        let another = gpu.upload("counted", &[0u32], wgpu::BufferUsages::STORAGE);
        assert!(living(&gpu.device) - before > made, "{another:?} is counted");
        assert_eq!(made, 0, "{tier:?}");
        // The same maps as without earlier frames.
        let sets = [HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(600), &[0, 1])];
        let last = submit(&gpu, &prepare(&mut moving, &uploaded, &sets, &settings, 7));
        let mut fresh = shadows(&gpu);
        let expected = submit(&gpu, &prepare(&mut fresh, &uploaded, &sets, &settings, 7));
        assert!(last == expected, "{tier:?}");
        let shade = expected.filters.iter().filter(|texel| texel[1] < 0x3b00).count();
        assert!(shade > 500, "{shade}");
    }
}

/// Lists of the host's casters: kernels write their counts over those of uploads, and back.
#[test]
fn counts_that_kernels_wrote_are_written_anew() {
    let gpu = gpu(TIERS[0]);
    let mut changing = shadows(&gpu);
    let all = particles(600, 5);
    let host = HostBuffers::new(&gpu, &all[..256]);
    let (loader, few) = (host.loader(&changing), count_buffer(&gpu, 100));
    let settings = ShadowSettings { size: 64, ..ShadowSettings::default() };
    for (frame, is_host) in [(0, true), (1, false), (2, true), (2, false), (2, true)] {
        // Capacity for as many as are uploaded, but fewer casters.
        let set = HostCasters::new(&loader, &host.bindings, counted(&few, 256), &[0, 1]);
        let sets = if is_host { vec![set] } else { Vec::new() };
        let uploaded = if is_host { &all[..0] } else { &all[..256] };
        let prepared = prepare(&mut changing, uploaded, &sets, &settings, frame);
        let found = submit(&gpu, &prepared);
        let mut fresh = shadows(&gpu);
        let expected = submit(&gpu, &prepare(&mut fresh, uploaded, &sets, &settings, frame));
        assert_equal(&found, &expected, &format!("frame {frame}, of the host's: {is_host}"));
    }
}

/// Frames that differ only in contents, with some between them that differ in more, equal frames without
/// earlier ones.
#[test]
fn repeated_commands_have_the_contents_of_their_frame() {
    let gpu = gpu(TIERS[0]);
    let mut repeating = shadows(&gpu);
    let all = particles(600, 6);
    let host = HostBuffers::new(&gpu, &all[..400]);
    let loader = host.loader(&repeating);
    let settings = ShadowSettings { size: 64, ..ShadowSettings::default() };
    let blurred = ShadowSettings { blur: 2, ..settings };
    let frames = [
        (0, 400, settings),
        (1, 400, settings),
        (2, 400, settings),
        (3, 300, settings),
        (4, 300, settings),
        (4, 300, blurred),
        (5, 300, blurred),
        (6, 300, blurred),
        (6, 300, settings),
    ];
    for (frame, count, settings) in frames {
        let uploaded = &all[400..500];
        let set = HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(count), &[0, 1]);
        let found = submit(&gpu, &prepare(&mut repeating, uploaded, &[set], &settings, frame));
        let mut fresh = shadows(&gpu);
        let expected = submit(&gpu, &prepare(&mut fresh, uploaded, &[set], &settings, frame));
        let what = format!("frame {frame} of {count} casters, blur {}", settings.blur);
        assert_equal(&found, &expected, &what);
    }
}

/// All dispatches of a frame share a pass, unless each is timed or records are copied to a texture before
/// they are read, and all views of a batch share dispatches.
#[test]
fn few_passes_render_many_views() {
    for tier in TIERS {
        assert_passes(tier, RecordForm::Textures, 2);
        assert_passes(tier, RecordForm::Buffers, 1);
    }
}

fn assert_passes(tier: Tier, form: RecordForm, passes: usize) {
    let gpu = gpu(tier);
    let mut moving = shadows(&gpu);
    moving.configure(|config| config.tuning.record_form = form);
    let host = HostBuffers::new(&gpu, &particles(600, 4));
    let loader = host.loader(&moving);
    let settings = ShadowSettings { size: 16, ..ShadowSettings::default() };
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let sets = [HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(600), &[0, 1])];
    let inputs = HostInputs::new().casters(&sets);
    let views: Vec<_> = (0..16).flat_map(spots).collect();
    assert_eq!(views.len(), 256);
    for views in [&views[..1], &views, &views] {
        let prepared = moving.prepare_with(&casters, views, &settings, &inputs).unwrap();
        assert_eq!(prepared.commands().pass_count(), passes, "{tier}: {} views", views.len());
        let listed = format!("{:?}", prepared.commands());
        let projected = listed.matches("\n  project_particles ").count();
        assert_eq!(projected, 1, "{} views", views.len());
    }
}
