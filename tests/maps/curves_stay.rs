//! Curves that are read from the device when they are asked for.
use crate::common::{
    Tier, gpu,
    scenes::{empty, light, material, random_discs},
    tiers,
};
use gobo::{Error, LightKind, Receiver, Transfer, glam::Vec3, model::Scene, records::CurveMap};
use gobo_picture::{Frame, RenderOptions, Renderer};

/// Discs around a lamp with six views and under a spot, of sizes that are no multiples of tiles.
fn scene() -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.particles = random_discs(200, 11);
    let lamp = light(LightKind::Point { position: Vec3::ZERO });
    let (position, direction) = (Vec3::Y * 6.0, Vec3::NEG_Y);
    let spot = light(LightKind::Spot { position, direction, angle: 1.0 });
    scene.lights = vec![lamp, spot];
    (scene.lights[0].size, scene.lights[1].size) = (Some(40), Some(100));
    scene.shadow.receiver = Receiver::Curve;
    scene
}

fn read(renderer: &Renderer, frame: &Frame, number: usize) -> CurveMap {
    let whole = frame.maps[number].curve.clone().expect("it has curves");
    let mut curve = CurveMap { packed: Vec::new(), ..whole };
    let take = |some: &CurveMap| {
        assert_eq!((some.nodes, some.gain), (curve.nodes, curve.gain));
        curve.packed.extend_from_slice(&some.packed);
        Ok::<_, Error>(())
    };
    renderer.read_curve(number, take).unwrap();
    curve
}

#[test]
fn curves_that_stay_are_those_that_are_read_with_the_maps() {
    for tier in tiers(Tier::Core) {
        let mut scene = scene();
        let mut renderer = Renderer::on(gpu(tier)).unwrap();
        let options = RenderOptions { maps: true, keep: true, ..RenderOptions::default() };
        for maps_of in [None, Some(1)] {
            let options = RenderOptions { maps_of, maps_only: true, ..options };
            let whole = renderer.render(&scene, &options).unwrap();
            let stay = RenderOptions { curves_stay: true, ..options };
            let left = renderer.render(&scene, &stay).unwrap();
            assert_eq!(left.maps.len(), if maps_of.is_some() { 1 } else { 7 });
            for (number, maps) in left.maps.iter().enumerate() {
                assert!(maps.curve.as_ref().unwrap().packed.is_empty());
                let found = read(&renderer, &left, number);
                let expected = whole.maps[number].curve.as_ref().unwrap();
                assert!(expected.packed.iter().any(|node| node[0] >> 16 > 0));
                assert!(found == *expected, "{tier}, view {number}");
            }
        }
        // Behind an open shutter they are the middle sample's, not the last one's.
        (scene.samples, scene.shutter) = (2, 0.5);
        scene.camera.size = [8, 8].into();
        let stay = RenderOptions { curves_stay: true, ..options };
        let frame = renderer.render_at(&mut scene, 1.0, 0.1, &stay).unwrap();
        assert!(frame.maps.iter().all(|maps| !maps.curve.as_ref().unwrap().packed.is_empty()));
    }
}
