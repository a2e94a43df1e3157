//! Frames in which everything moves: what `prepare` makes on the device, and their maps.
use super::{HostBuffers, count_buffer, counted, materials, particles, shadows, submit};
use crate::common::{TIERS, counted_gpu, gpu};
use gobo::{
    Bounds, CasterCount, Casters, HostCasters, HostInputs, Light, Particle, Prepared, Receiver,
    ShadowSettings, Shadows, View, glam::Vec3, light_views, wgpu,
};

const SPOTS: u32 = 16;

fn spots(frame: u32) -> Vec<View> {
    let bounds = Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
    let spot = |i: u32| {
        let angle = i as f32 * 0.39 + frame as f32 * 0.05;
        let position = Vec3::new(4.0 * angle.cos(), 4.0, 4.0 * angle.sin());
        light_views(i as usize, &Light::spot(position, -position, 0.6), 64, None, &bounds).unwrap()
    };
    (0..SPOTS).flat_map(spot).collect()
}

/// Buffers, textures, views of these, bind groups and pipelines that live.
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
    let inputs = HostInputs::new().casters(sets);
    shadows.prepare_with(&casters, &spots(frame), settings, &inputs).unwrap()
}

/// Every frame is held, so that what it makes is seen even if an earlier one drops as much.
#[test]
fn nothing_is_made_where_everything_moves() {
    let nearest = ShadowSettings { size: 64, ..ShadowSettings::default() };
    let curve = ShadowSettings { receiver: Receiver::Curve, nodes: 8, ..nearest };
    for (tier, settings) in TIERS.into_iter().zip([nearest, curve]) {
        let (gpu, _guard) = counted_gpu(tier);
        let mut moving = shadows(&gpu);
        let mut all = particles(600, 4);
        let host = HostBuffers::new(&gpu, &all);
        let loader = host.loader(&moving);
        let mut uploaded = particles(300, 8);
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
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder).unwrap();
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            held.push(prepared);
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

/// Lists of the host's casters, whose counts kernels write over those of uploads, and back.
#[test]
fn counts_that_kernels_wrote_are_written_anew() {
    let gpu = gpu(TIERS[0]);
    let mut changing = shadows(&gpu);
    let all = particles(600, 5);
    let host = HostBuffers::new(&gpu, &all[..256]);
    let (loader, few) = (host.loader(&changing), count_buffer(&gpu, 100));
    let settings = ShadowSettings { size: 64, ..ShadowSettings::default() };
    for (frame, is_host) in [(0, true), (1, false), (2, true), (2, false), (2, true)] {
        // Room for as many as are uploaded, but fewer.
        let set = HostCasters::new(&loader, &host.bindings, counted(&few, 256), &[0, 1]);
        let sets = if is_host { vec![set] } else { Vec::new() };
        let uploaded = if is_host { &all[..0] } else { &all[..256] };
        let prepared = prepare(&mut changing, uploaded, &sets, &settings, frame);
        let found = submit(&gpu, &prepared);
        let mut fresh = shadows(&gpu);
        let expected = submit(&gpu, &prepare(&mut fresh, uploaded, &sets, &settings, frame));
        assert!(found == expected, "frame {frame}, of the host's: {is_host}");
    }
}
