//! Levels of area lights in hosts: made once for each rendering of the maps, for all look-ups.
use super::{materials, particles, shadows};
use crate::common::{TIERS, gpu};
use gobo::{
    Bounds, Casters, HostInputs, Light, ShadowSettings, Shadows, glam::Vec3, host::PointBuffers,
    light_views, model::Source, wgpu::BufferUsages,
};

#[test]
fn still_frames_and_further_look_ups_make_no_levels() {
    let gpu = gpu(TIERS[0]);
    let (mut particles, materials) = (particles(300, 5), materials());
    let bounds = Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
    let source = Some(Source::Sphere { radius: 0.2 });
    let mut lights = [Light { source, ..Light::spot(Vec3::Y * 4.0, Vec3::NEG_Y, 0.9) }];
    let settings = ShadowSettings { size: 64, ..ShadowSettings::default() };
    let places: Vec<[f32; 3]> = (0..64).map(|i| [i as f32 * 0.05 - 1.6, -2.0, 0.1]).collect();
    let positions = gpu.upload("positions", &places, BufferUsages::STORAGE);
    let points = PointBuffers { count: 64, positions: &positions, normals: None };
    // Light at the points: bindings make the levels, and a look-up reuses them.
    let frame = |shadows: &mut Shadows, particles: &[_], lights: &[Light]| {
        let casters = Casters { particles, materials: &materials, ..Casters::default() };
        let views = light_views(0, &lights[0], 64, None, &bounds).unwrap();
        let inputs = HostInputs::new().area_lights();
        let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs).unwrap();
        let bound = prepared.bind_area_lights(lights, &[0]).unwrap();
        let lit = prepared.light_points(lights, &[0], &points).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder).unwrap();
        bound.record(&mut encoder);
        lit.record(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        gpu.read::<[f32; 3]>(lit.shares())
    };
    let mut moving = shadows(&gpu);
    let mut last = Vec::new();
    for (number, (what, made)) in
        [("first", 1), ("still", 1), ("a caster moves", 2), ("still", 2), ("the light moves", 3)]
            .into_iter()
            .enumerate()
    {
        match what {
            "a caster moves" => particles[..100].iter_mut().for_each(|p| p.center.x += 0.3),
            "the light moves" => {
                lights[0] = Light { source, ..Light::spot(Vec3::Y * 3.9, Vec3::NEG_Y, 0.9) };
            }
            _ => {}
        }
        let shares = frame(&mut moving, &particles, &lights);
        assert_eq!(moving.levels_made(), made, "{what}, frame {number}");
        let alone = frame(&mut shadows(&gpu), &particles, &lights);
        assert!(shares == alone, "{what}, frame {number}");
        assert_eq!(shares == last, what == "still", "{what}, frame {number}");
        last = shares;
    }
}
