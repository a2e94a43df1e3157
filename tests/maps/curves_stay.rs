//! Curves that are read from the device when they are asked for.
use crate::common::{
    Tier, gpu,
    scenes::{empty, light, material, random_discs},
    shadows, tiers,
};
use gobo::{
    Error, LightKind, Receiver, Transfer,
    glam::Vec3,
    model::{Scene, View},
    records::{CurveMap, curve},
    view::{atlas::MapSlot, shadow_views},
};
use gobo_picture::{Frame, RenderOptions, Renderer};

/// Discs around a lamp with six views and under a spot, of sizes that are no multiples of tiles.
fn scene() -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.particles = random_discs(200, 11);
    let lamp = light(LightKind::Point { position: Vec3::ZERO });
    let (position, direction) = (Vec3::Y * 6.0, Vec3::NEG_Y);
    let spot = light(LightKind::Spot { position, direction, angle: 1.0 });
    scene.lights = vec![lamp, spot];
    // The spot's is read in more than one part.
    (scene.lights[0].size, scene.lights[1].size) = (Some(40), Some(700));
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

/// Curves of all views, found in the whole texture.
fn in_texture(tier: Tier, scene: &Scene) -> Vec<Vec<[u32; 2]>> {
    let gpu = gpu(tier);
    let views = shadow_views(scene);
    let mut shadows = shadows(&gpu);
    let prepared = shadows.prepare(&scene.casters(), &views, &scene.shadow).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
    let maps = prepared.maps();
    let (size, pairs) = (maps.curves.size(), maps.nodes / 2);
    let texels: Vec<[[u32; 2]; 2]> = gpu.read_texture(&maps.curves);
    let of_view = |(view, slot): (&View, &MapSlot)| {
        let mut packed = Vec::new();
        // Tiles without a caster are zeros.
        let unused = curve::packed(0, 0.0, Vec3::ONE, maps.gain);
        for y in slot.origin.y..slot.origin.y + view.size.y {
            for x in slot.origin.x..slot.origin.x + view.size.x {
                for layer in slot.layer * pairs..(slot.layer + 1) * pairs {
                    let pair = texels[((layer * size.height + y) * size.width + x) as usize];
                    packed.extend(pair.map(|node| if node == [0; 2] { unused } else { node }));
                }
            }
        }
        packed
    };
    views.iter().zip(&maps.slots).map(of_view).collect()
}

#[test]
fn curves_that_stay_are_those_that_are_read_with_the_maps() {
    for tier in tiers(Tier::Core) {
        let mut scene = scene();
        let mut renderer = Renderer::on(gpu(tier)).unwrap();
        let in_texture = in_texture(tier, &scene);
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
                let first = if maps_of.is_some() { 6 } else { 0 };
                assert!(expected.packed == in_texture[first + number], "{tier}, view {number}");
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
