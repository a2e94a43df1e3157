//! Emitters on the device: particles match the CPU reference's, and cast shadows without a read-back.
use super::{Particle, ShadowSettings, Vec3, Vec4, on_device, shadows, submit, uploaded};
use crate::common::{
    TIERS, Tier, gpu,
    rounding::{LOADED, rounds_as_the_cpu},
    tiers,
};
use gobo::{
    CasterCount, HostCasters,
    gpu::Gpu,
    model::emitter::{EmittedParticle, EmitterShape, Flock, Forces},
    records::GpuEmitted,
    shadows::{EMITTED_WGSL, Simulation},
    wgpu,
};

fn calm() -> Forces {
    Forces {
        seed: 11,
        rate: 700.0,
        lifetime: [0.3, 1.2],
        shape: EmitterShape::Sphere,
        position: Vec3::new(0.2, -1.0, 0.1),
        extent: Vec3::new(1.0, 0.4, 0.8),
        velocity: Vec3::new(0.2, 1.5, 0.0),
        spread: 0.7,
        gravity: 1.0,
        buoyancy: 2.5,
        drag: 1.2,
        wind: Vec3::new(0.4, 0.0, -0.3),
        turbulence: 0.0,
        frequency: 1.3,
        evolve: 0.5,
        ground: None,
        boxes: Vec::new(),
        bounce: 0.4,
        slide: 0.8,
        path: Vec::new(),
        origin: Vec3::new(3.0, 0.0, 1.0),
    }
}

/// Turbulence, a ground and boxes.
fn wild() -> Forces {
    Forces {
        turbulence: 1.5,
        ground: Some(-1.1),
        boxes: vec![
            [Vec3::new(0.4, -2.0, -1.0), Vec3::new(0.9, -0.2, 1.0)],
            [Vec3::new(-1.0, -0.4, -1.0), Vec3::new(0.0, -0.2, 1.0)],
        ],
        ..calm()
    }
}

/// A path with two corners in one step.
fn on_path() -> Forces {
    let path = [[0.0, 0.0], [0.105, 4.0], [0.108, 3.0], [4.0, 1.0]];
    Forces { path: path.map(|[t, x]| [t, x, 0.5 * x, 0.0]).to_vec(), ..calm() }
}

fn advance(gpu: &Gpu, simulation: &mut Simulation, steps: u32) {
    let mut left = steps;
    while left > 0 {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        left -= simulation.record(&mut encoder, left);
        gpu.queue.submit([encoder.finish()]);
    }
    gpu.check().unwrap();
}

/// Live particles, by number.
fn read(gpu: &Gpu, simulation: &Simulation) -> Vec<EmittedParticle> {
    let records: Vec<GpuEmitted> = gpu.read(simulation.particles());
    let mut emitted: Vec<_> = records.iter().filter_map(GpuEmitted::emitted).collect();
    emitted.sort_by_key(|emitted| emitted.number);
    emitted
}

/// Asserts that both hold the same particles of the same ages. Returns the share whose positions differ by
/// more than `near` [m].
fn share_off(found: &[EmittedParticle], expected: &[EmittedParticle], near: f32) -> f64 {
    let whole = |emitted: &[EmittedParticle]| {
        emitted.iter().map(|f| (f.number, f.age, f.life)).collect::<Vec<_>>()
    };
    assert_eq!(whole(found), whole(expected));
    let pairs = found.iter().zip(expected);
    let off = pairs.filter(|(a, b)| a.position.distance(b.position) > near).count();
    off as f64 / expected.len().max(1) as f64
}

#[test]
fn the_kernel_flies_as_the_reference() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        let shadows = shadows(&gpu);
        // Turbulence amplifies rounding, and another face of a box may be the nearest.
        let cases = [
            (calm(), u32::MAX, 1e-5, 0.0),
            (wild(), u32::MAX, 1e-3, 0.01),
            (on_path(), u32::MAX, 1e-5, 0.0),
            (on_path(), 130, 1e-5, 0.0),
        ];
        for (forces, last, near, off) in cases {
            let mut simulation = shadows.simulation_until(&forces, last).unwrap();
            let mut flock = Flock::default();
            let mut step = 0;
            for steps in [1, 2, 9, 60, 64, 100] {
                advance(&gpu, &mut simulation, steps);
                step += steps;
                assert_eq!(simulation.step(), step);
                flock.advance_to(&forces, step, last);
                let found = read(&gpu, &simulation);
                let share = share_off(&found, flock.emitted(), near);
                assert!(share <= off, "{tier}, step {step}: {share} of the particles");
                assert!(found.len() as u32 <= simulation.capacity());
            }
            if last < step {
                // All have ended, and each had a slot.
                assert!(flock.emitted().is_empty() && simulation.capacity() > 700);
                continue;
            }
            assert!(flock.emitted().len() > 300);
            // Another seed makes other smoke.
            let mut other = Flock::default();
            other.advance_to(&Forces { seed: 12, ..forces.clone() }, step, u32::MAX);
            let [a, b] = [&other, &flock].map(|flock| flock.emitted()[0].position);
            assert!(a.distance(b) > near);
        }
    }
}

#[test]
#[ignore = "a million particles: make test-all"]
fn a_million_fly_as_the_reference() {
    let gpu = gpu(TIERS[0]);
    let forces = Forces { rate: 4e5, lifetime: [2.0, 3.0], turbulence: 1.0, ..calm() };
    let mut simulation = shadows(&gpu).simulation(&forces).unwrap();
    let mut flock = Flock::default();
    flock.advance_to(&forces, 168, u32::MAX);
    advance(&gpu, &mut simulation, 168);
    let (found, expected) = (read(&gpu, &simulation), flock.emitted());
    assert!(expected.len() > 950_000, "{}", expected.len());
    let share = share_off(&found, expected, 1e-3);
    assert!(share < 1e-3, "{share} of the particles");
    let start = std::time::Instant::now();
    advance(&gpu, &mut simulation, 12);
    let _ = read(&gpu, &simulation);
    println!("{} particles: {:?} for 12 steps", simulation.capacity(), start.elapsed());
}

/// Particles leave a moving emitter along its path, not at its position at the end of their step.
#[test]
fn particles_start_along_the_path() {
    let gpu = gpu(TIERS[0]);
    let still = Forces {
        rate: 1200.0,
        lifetime: [2.0; 2],
        shape: EmitterShape::Point,
        velocity: Vec3::ZERO,
        spread: 0.0,
        gravity: 0.0,
        buoyancy: 0.0,
        drag: 0.0,
        ..on_path()
    };
    let mut simulation = shadows(&gpu).simulation(&still).unwrap();
    advance(&gpu, &mut simulation, 60);
    let found = read(&gpu, &simulation);
    assert!(found.len() >= 1199);
    for particle in found {
        let seconds = particle.number as f32 / 1200.0;
        let x = match seconds {
            t if t < 0.105 => 4.0 * t / 0.105,
            t if t < 0.108 => 4.0 - (t - 0.105) / 0.003,
            t => 3.0 - 2.0 * (t - 0.108) / 3.892,
        };
        let place = particle.position - still.position;
        assert!(place.distance(Vec3::new(x, 0.5 * x, 0.0)) < 1e-4, "{particle:?} {x}");
    }
}

#[test]
fn a_path_of_too_many_rows_is_refused() {
    let gpu = gpu(TIERS[0]);
    let path = |every: f32| (0..40).map(|i| [i as f32 * every, 0.0, 0.0, 0.0]).collect();
    let simulation = |every| shadows(&gpu).simulation(&Forces { path: path(every), ..calm() });
    let error = simulation(0.0005).unwrap_err().to_string();
    assert!(error.contains("path"), "{error}");
    simulation(0.0006).unwrap();
}

/// After a restart at a later step, the missing particles are the older ones.
#[test]
fn a_restart_misses_what_started_before() {
    let gpu = gpu(TIERS[0]);
    let forces = wild();
    let (shadows, at) = (shadows(&gpu), 400);
    let mut whole = shadows.simulation(&forces).unwrap();
    advance(&gpu, &mut whole, at);
    for from in [at - forces.longest(), at - 30] {
        let mut late = shadows.simulation(&forces).unwrap();
        advance(&gpu, &mut late, 7);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        late.restart(&mut encoder, from);
        gpu.queue.submit([encoder.finish()]);
        advance(&gpu, &mut late, at - from);
        let first = forces.started_before(from);
        let expected: Vec<_> =
            read(&gpu, &whole).into_iter().filter(|one| one.number >= first).collect();
        assert!(read(&gpu, &late) == expected && expected.len() > 200, "{from}");
    }
}

const LOADER: &str = "
fn load_caster(index: u32) -> Caster {
    let one = emitted_particles[index];
    let share = life_share(one);
    // Ended particles have no radius and are left out.
    let radius = select(0.0, 0.02 + 0.1 * share, share < 1.0);
    return Caster(one.position, radius, vec4(0.9, 0.6, 0.3, 0.5), 0.0, 0u, one.number);
}";

#[test]
fn smoke_on_the_device_casts_the_shadow_of_an_upload() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let mut simulation = shadows.simulation(&wild()).unwrap();
        advance(&gpu, &mut simulation, 90);
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: simulation.particles().as_entire_binding(),
            }],
        });
        let text = format!("{EMITTED_WGSL}{LOADER}");
        let loader = shadows.caster_loader("smoke.wgsl", &text, &layout).unwrap();
        let count = CasterCount::Fixed(simulation.capacity());
        let set = HostCasters::new(&loader, &bindings, count, &[0]).least_alpha(0.01);
        let settings = ShadowSettings::default();
        // In the order of the ring.
        let records: Vec<GpuEmitted> = gpu.read(simulation.particles());
        let particle = |emitted: EmittedParticle| Particle {
            center: emitted.position,
            radius: 0.02 + 0.1 * (emitted.age as f32 / emitted.life as f32),
            color: Vec4::new(0.9, 0.6, 0.3, 0.5),
            rotation: 0.0,
            material: 0,
            id: emitted.number,
        };
        let all: Vec<_> = records.iter().filter_map(GpuEmitted::emitted).map(particle).collect();
        let expected = uploaded(&gpu, &mut shadows, &all, &settings);
        let prepared = on_device(&mut shadows, &[], &[set], &settings);
        let found = submit(&gpu, &prepared);
        let share = found.share_apart(&expected);
        let is_same = if rounds_as_the_cpu(&gpu) { found == expected } else { share <= LOADED };
        assert!(is_same, "{tier}: {share} of the texels");
        let shade = expected.filters.iter().filter(|texel| texel[2] < 0x3a00).count();
        assert!(shade > 300, "{shade} texels are in shade");
        // The next steps cast other shadows without another `prepare`.
        advance(&gpu, &mut simulation, 10);
        assert!(submit(&gpu, &prepared) != expected, "{tier}");
    }
}
