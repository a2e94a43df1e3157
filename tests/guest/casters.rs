//! Casters in the host's buffers give the same maps as uploads of them, to the last bit.
use super::{
    HostBuffers, Particle, ShadowSettings, Vec3, Vec4, count_buffer, counted, materials, on_device,
    particles, shadows, submit, uploaded, views,
};
use crate::common::{TIERS, counted_gpu, gpu, scenes::nearest_depth, tiers};
use gobo::{
    Bounds, CasterCount, Casters, HostCasters, HostInputs, Light, Receiver,
    gpu::{RecordForm, Tier},
    light_views,
};

const SETTINGS: fn() -> ShadowSettings = nearest_depth;

/// Fixed and indirect counts: none, few, one more than a group, and many.
#[test]
fn maps_equal_those_of_uploads() {
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        for count in [0, 1, 255, 257, 5000] {
            let all = particles(count, 7);
            let expected = uploaded(&gpu, &mut shadows, &all, &SETTINGS());
            let host = HostBuffers::new(&gpu, &all);
            let loader = host.loader(&shadows);
            let counts = count_buffer(&gpu, count as u32);
            for counter in [CasterCount::Fixed(count as u32), counted(&counts, count as u32 + 300)]
            {
                let set = HostCasters::new(&loader, &host.bindings, counter, &[0, 1]);
                let prepared = on_device(&mut shadows, &[], &[set.least_alpha(0.01)], &SETTINGS());
                let bits = submit(&gpu, &prepared);
                assert!(bits == expected, "{tier}: {counter:?}");
                let counters = prepared.counters().unwrap();
                assert_eq!((counters.casters, counters.skipped.len()), (count as u64, 0));
            }
            let shade = expected.filters.iter().filter(|texel| texel[1] < 0x3b00).count();
            assert!(count < 255 || shade > 500, "{count}: {shade} texels are in shade");
        }
    }
}

/// Curves, order-dependent blending, amplification, and opaque discs; each tier tests half of the kernels.
#[test]
fn all_that_filters_or_blocks_can_come_from_the_host() {
    let [nearest, curve] = receivers();
    bits_are_those_of_uploads(Tier::Core, &[(&[0], curve), (&[0, 4], nearest), (&[2], nearest)]);
    bits_are_those_of_uploads(Tier::Native, &[(&[3], nearest), (&[3], curve)]);
}

#[test]
#[ignore = "kernels of the other tier: make test-all"]
fn all_that_filters_or_blocks_can_come_from_the_host_on_the_other_tier() {
    let [nearest, curve] = receivers();
    bits_are_those_of_uploads(Tier::Native, &[(&[0], curve), (&[0, 4], nearest), (&[2], nearest)]);
    bits_are_those_of_uploads(Tier::Core, &[(&[3], nearest), (&[3], curve)]);
}

fn receivers() -> [ShadowSettings; 2] {
    [SETTINGS(), ShadowSettings::default()]
}

/// Materials of the particles, and settings.
type Case<'a> = (&'a [u32], ShadowSettings);

fn bits_are_those_of_uploads(tier: Tier, cases: &[Case<'_>]) {
    let gpu = gpu(tier);
    let mut shadows = shadows(&gpu);
    for &(used, settings) in cases {
        let mut all = particles(700, 9);
        for (i, particle) in all.iter_mut().enumerate() {
            particle.material = used[i % used.len()];
            if particle.material == 4 {
                particle.color *= Vec4::new(16.0, 3.0, 2.0, 1.0);
            }
        }
        let expected = uploaded(&gpu, &mut shadows, &all, &settings);
        let host = HostBuffers::new(&gpu, &all);
        let loader = host.loader(&shadows);
        let set = HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(700), used);
        // In buffers as on GPUs; to textures, where the uploaded ones were, records are copied.
        for form in [RecordForm::Buffers, RecordForm::Textures] {
            shadows.configure(|config| config.tuning.record_form = form);
            let prepared = on_device(&mut shadows, &[], &[set.least_alpha(0.01)], &settings);
            let what = format!("{tier}: {used:?} {:?}, {form:?}", settings.receiver);
            assert!(submit(&gpu, &prepared) == expected, "{what}");
            let copied = prepared.memory().0.iter().any(|(name, _)| *name == "loaded_casters");
            assert_eq!(copied, form == RecordForm::Textures, "{what}");
        }
    }
}

/// Some casters uploaded and some in two sets of the host, one of them opaque, give the same maps as all
/// uploaded.
#[test]
fn uploads_and_sets_are_one_frame() {
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let (first, second) = (particles(300, 1), particles(520, 2));
        let mut blocking = particles(40, 3);
        blocking.iter_mut().for_each(|particle| particle.material = 2);
        let all = [&first[..], &second, &blocking].concat();
        let expected = uploaded(&gpu, &mut shadows, &all, &SETTINGS());
        let [of_second, of_blocking] =
            [&second, &blocking].map(|particles| HostBuffers::new(&gpu, particles));
        let loader = of_second.loader(&shadows);
        let counts = count_buffer(&gpu, 520);
        let sets = [
            HostCasters::new(&loader, &of_second.bindings, counted(&counts, 1000), &[0, 1])
                .least_alpha(0.01),
            HostCasters::new(&loader, &of_blocking.bindings, CasterCount::Fixed(40), &[2]),
        ];
        let prepared = on_device(&mut shadows, &first, &sets, &SETTINGS());
        let bits = submit(&gpu, &prepared);
        assert!(bits == expected, "{tier}");
        assert!(bits.opaques.iter().any(|&depth| depth < 1.0_f32.to_bits()));
        let counters = prepared.counters().unwrap();
        assert_eq!(counters.casters, 860);
        assert!(prepared.memory().0.iter().any(|(name, _)| *name == "host_groups"));
    }
}

#[test]
fn what_cannot_be_used_is_counted_and_changes_nothing() {
    let good = Particle { material: 0, ..particles(1, 5)[0] };
    let wrong = [
        Particle { center: Vec3::new(0.0, f32::NAN, 0.0), ..good },
        Particle { center: Vec3::new(f32::INFINITY, 0.0, 0.0), ..good },
        Particle { center: Vec3::new(0.0, 0.0, -1.1e7), ..good },
        Particle { radius: 0.0, ..good },
        Particle { radius: -1.0, ..good },
        Particle { radius: f32::NAN, ..good },
        Particle { radius: f32::INFINITY, ..good },
        Particle { rotation: f32::NAN, ..good },
        Particle { color: Vec4::new(0.5, 1.1, 0.5, 0.5), ..good },
        Particle { color: Vec4::new(0.5, f32::NAN, 0.5, 0.5), ..good },
        Particle { color: Vec4::new(0.5, 0.5, 0.5, -0.1), ..good },
        Particle { color: Vec4::new(0.5, 0.5, 0.5, f32::INFINITY), ..good },
        // Material indices past the set's end, and past the bits that store them.
        Particle { material: 99, ..good },
        Particle { material: 2, ..good },
        Particle { material: u32::MAX, ..good },
    ];
    // Casters outside of all views, and at the largest valid distance.
    let far = [
        Particle { center: Vec3::new(900.0, -300.0, 20.0), ..good },
        Particle { center: Vec3::splat(1e7), ..good },
        Particle { color: Vec4::new(0.0, -0.0, 1.0, 1.0), ..good },
    ];
    for tier in tiers(Tier::Core) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let mut usable = particles(400, 6);
        let mut all = usable.clone();
        for (i, &particle) in wrong.iter().enumerate() {
            all.insert(i * 23, particle);
        }
        usable.extend(far);
        all.extend(far);
        let expected = uploaded(&gpu, &mut shadows, &usable, &SETTINGS());
        let host = HostBuffers::new(&gpu, &all);
        let loader = host.loader(&shadows);
        let count = CasterCount::Fixed(all.len() as u32);
        let set = HostCasters::new(&loader, &host.bindings, count, &[0, 1]).least_alpha(0.01);
        let prepared = on_device(&mut shadows, &[], &[set], &SETTINGS());
        assert!(submit(&gpu, &prepared) == expected, "{tier}");
        let counters = prepared.counters().unwrap();
        let skipped: u64 = counters.skipped.values().sum();
        assert_eq!((counters.casters, skipped), (403, wrong.len() as u64), "{counters:?}");
    }
}

/// Several frames from one `prepare`: casters move, appear and vanish, and nothing is allocated.
#[test]
fn frames_follow_the_buffers_and_make_nothing() {
    for tier in tiers(Tier::Core) {
        let (gpu, _alone) = counted_gpu(tier);
        let mut shadows = shadows(&gpu);
        let frames: Vec<_> =
            [500, 80, 613, 0].into_iter().zip(20..).map(|(n, seed)| particles(n, seed)).collect();
        let expected: Vec<_> =
            frames.iter().map(|all| uploaded(&gpu, &mut shadows, all, &SETTINGS())).collect();
        let host = HostBuffers::new(&gpu, &particles(700, 1));
        let loader = host.loader(&shadows);
        let counts = count_buffer(&gpu, 700);
        let set = HostCasters::new(&loader, &host.bindings, counted(&counts, 700), &[0, 1])
            .least_alpha(0.01);
        let prepared = on_device(&mut shadows, &[], &[set], &SETTINGS());
        submit(&gpu, &prepared);
        for (particles, expected) in frames.iter().zip(&expected) {
            host.write(&gpu, particles);
            gpu.queue.write_buffer(&counts, 8, bytemuck::bytes_of(&(particles.len() as u32)));
            assert!(submit(&gpu, &prepared) == *expected, "{tier}: {}", particles.len());
        }
        let made = || {
            let hal = gpu.device.get_internal_counters().hal;
            [hal.buffers.read(), hal.texture_views.read(), hal.bind_groups.read()]
        };
        let before = made();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        (0..3).for_each(|_| prepared.record(&mut encoder).unwrap());
        assert_eq!(made(), before);
        gpu.queue.submit([encoder.finish()]);
        gpu.check().unwrap();
    }
}

/// A host that alternates between two buffers.
#[test]
fn sets_are_read_by_other_bindings() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let mut blocking = particles(30, 3);
    blocking.iter_mut().for_each(|particle| particle.material = 2);
    let [first, second] = [particles(300, 1), particles(300, 2)];
    let expected = [&first, &second].map(|particles| {
        uploaded(&gpu, &mut shadows, &[&particles[..], &blocking].concat(), &SETTINGS())
    });
    let [first, second, of_blocking] =
        [first, second, blocking].map(|particles| HostBuffers::new(&gpu, &particles));
    let loader = first.loader(&shadows);
    // The filtering set is the host's first set, and the last that is loaded.
    let sets = [
        HostCasters::new(&loader, &first.bindings, CasterCount::Fixed(300), &[0, 1])
            .least_alpha(0.01),
        HostCasters::new(&loader, &of_blocking.bindings, CasterCount::Fixed(30), &[2]),
    ];
    let prepared = on_device(&mut shadows, &[], &sets, &SETTINGS());
    let [of_first, of_second] = &expected;
    for (host, expected) in [(&first, of_first), (&second, of_second), (&first, of_first)] {
        prepared.rebind(0, &host.bindings).unwrap();
        assert!(submit(&gpu, &prepared) == *expected);
    }
    assert!(prepared.rebind(2, &first.bindings).is_err());
}

/// Views whose casters may have changed are rendered again, and no others.
#[test]
fn maps_stay_where_nothing_of_the_hosts_changed() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let mut all = particles(50, 4);
    // All particles to the right of the lamp.
    for particle in &mut all {
        particle.center = Vec3::new(1.5, 0.0, 0.0) + particle.center * 0.1;
    }
    let host = HostBuffers::new(&gpu, &all);
    let loader = host.loader(&shadows);
    let set = HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(50), &[0, 1]);
    let around = Bounds { min: Vec3::new(1.2, -0.3, -0.3), max: Vec3::new(1.8, 0.3, 0.3) };
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let lamp = &views()[..6];
    let mut rendered = |set: Option<HostCasters<'_>>| {
        let sets = Vec::from_iter(set);
        let inputs = HostInputs::new().casters(&sets);
        let prepared = shadows.prepare_with(&casters, lamp, &SETTINGS(), &inputs).unwrap();
        submit(&gpu, &prepared);
        prepared.counters().unwrap().views_rendered
    };
    assert_eq!(rendered(Some(set)), 6);
    assert_eq!(rendered(Some(set)), 6, "nobody says that it is unchanged");
    assert_eq!(rendered(Some(set.bounds(around))), 6);
    assert_eq!(rendered(Some(set.bounds(around))), 1, "of the face that looks there");
    assert_eq!(rendered(Some(set.bounds(around).version(3))), 1);
    assert_eq!(rendered(Some(set.bounds(around).version(3))), 0);
    assert_eq!(rendered(Some(set.bounds(around).version(4))), 1);
    assert_eq!(rendered(None), 1, "its shadow goes");
    assert_eq!(rendered(None), 0);
}

/// Each view may contain all casters of the host; memory for that is per batch, not per frame, also for large
/// maps.
#[test]
fn many_views_of_many_casters_take_little_memory() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let host = HostBuffers::new(&gpu, &particles(4, 1));
    let loader = host.loader(&shadows);
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let small = ShadowSettings { size: 128, ..SETTINGS() };
    let bounds = Bounds { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };
    // Memory of curves, and of everything but maps and casters [MiB].
    let mut memory = |settings: &ShadowSettings, capacity, count: usize| {
        let count_buffer = count_buffer(&gpu, 4);
        let sets =
            [HostCasters::new(&loader, &host.bindings, counted(&count_buffer, capacity), &[0])];
        let spot = Light::spot(Vec3::Y * 5.0, Vec3::NEG_Y, 0.8);
        let [view] = &light_views(0, &spot, settings.size, None, &bounds).unwrap()[..] else {
            unreachable!("a spot has one view")
        };
        let views = vec![view.clone(); count];
        let inputs = HostInputs::new().casters(&sets);
        let prepared = shadows.prepare_with(&casters, &views, settings, &inputs).unwrap();
        let memory = &prepared.memory().0;
        let of = |named: &dyn Fn(&str) -> bool| {
            memory.iter().filter(|(name, _)| named(name)).map(|(_, bytes)| bytes).sum::<u64>() >> 20
        };
        let maps = ["filters", "nearests", "opaques", "casters", "loaded_casters", "curves"];
        (of(&|name| name == "curves"), of(&|name| !maps.contains(&name)))
    };
    let [(_, some), (_, many)] = [15, 64].map(|views| memory(&small, 100_000, views));
    let (_, alone) = memory(&small, 1_000_000, 1);
    println!("{many} MiB for 64 views of 100,000, {some} for 15, {alone} for one of a million");
    assert!(many < 112 && many <= some + 4, "{some} MiB for 15 views of 100,000, {many} for 64");
    let (_, four) = memory(&small, 1_000_000, 4);
    assert!(four < alone + alone / 8, "{alone} MiB for one view of a million, {four} for four");
    let large = ShadowSettings { size: 2048, receiver: Receiver::Curve, nodes: 4, ..small };
    let ((curves, one), (all_curves, three)) = (memory(&large, 1000, 1), memory(&large, 1000, 3));
    println!("{curves} and {one} MiB for a map of 2048, {all_curves} and {three} for three");
    // Eight bytes per node and texel.
    assert_eq!([curves, all_curves], [4 * 32, 3 * 4 * 32]);
    assert!(three < one + one / 8, "{one} MiB beside a map of 2048, {three} beside three");
}
