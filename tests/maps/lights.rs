//! Composite shadows and the atlas: the shadow of a light does not depend on the maps that hold it.
use crate::common::{
    TIERS, Tier,
    files::read,
    gpu, reference_picture, render,
    rounding::{IN_ATLAS, on},
    scenes::{Chance, empty, light, material, particle, triangle},
    tiers,
};
use gobo::{
    glam::{UVec2, Vec3, Vec4},
    model::{
        Camera, Cascades, Light, LightKind, Material, Profile, Shadow, Transfer, Triangle, View,
    },
    records::{Picture, ViewMaps},
    view::{atlas::AtlasLimits, fitted_views, shadow_views},
};
use gobo_reference::{
    render_maps,
    shading::{Lighting, Receiver},
};
use gobo_scene::Scene;

const DOWN: LightKind = LightKind::Directional { direction: Vec3::NEG_Y };
pub(crate) const STONE: u32 = 0;
pub(crate) const GLASS: u32 = 1;

/// A rectangle over the ground at height `y`, with half extents `half`.
pub(crate) fn roof(y: f32, half: Vec3, material: u32) -> [Triangle; 2] {
    let corner = |x: f32, z: f32| Vec3::new(x * half.x, y, z * half.z);
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0));
    [[a, b, c], [a, c, d]].map(|p| Triangle { normals: [Vec3::Y; 3], ..triangle(p, material) })
}

pub(crate) fn moved(triangles: [Triangle; 2], by: Vec3) -> [Triangle; 2] {
    triangles.map(|t| Triangle { positions: t.positions.map(|p| p + by), ..t })
}

/// A long ground below a camera that looks along it, under a sun with cascades.
pub(crate) fn ground(cascades: Cascades, direction: Vec3) -> Scene {
    let glass = Material { tint: Vec4::new(1.0, 0.5, 0.25, 1.0), ..material(Transfer::Filter) };
    let mut scene = empty(vec![material(Transfer::Opaque), glass]);
    scene.shadow.size = 128;
    scene.camera = Camera {
        eye: Vec3::new(0.0, 2.0, 0.0),
        target: Vec3::new(0.0, 1.0, -8.0),
        up: Vec3::Y,
        fov_y: std::f32::consts::FRAC_PI_2,
        size: UVec2::splat(64),
    };
    let kind = LightKind::Directional { direction: direction.normalize() };
    scene.lights = vec![Light { cascades: Some(cascades), ..light(kind) }];
    scene.triangles.extend(roof(0.0, Vec3::splat(100.0), STONE));
    scene
}

pub(crate) fn maps(scene: &Scene) -> Vec<ViewMaps> {
    render_maps(scene, &shadow_views(scene)).0
}

/// Share of the channels that differ by more than 4 of 255.
fn share_apart(a: &Picture, b: &Picture) -> f64 {
    assert_eq!(a.size, b.size);
    let channels = a.rgb.iter().flatten().zip(b.rgb.iter().flatten());
    channels.filter(|(a, b)| a.abs_diff(**b) > 4).count() as f64 / (3 * a.rgb.len()) as f64
}

/// Light of the first light at points of the ground.
pub(crate) fn light_at(scene: &Scene, points: &[Vec3]) -> Vec<Vec3> {
    let views = shadow_views(scene);
    let maps = render_maps(scene, &views).0;
    let lighting = Lighting::new(scene, &views, &maps);
    let receiver = Receiver::new(&Material::default(), 0);
    let at = |&p: &Vec3| lighting.shadow(0, p, Vec3::Y, 0.01, receiver);
    points.iter().map(at).collect()
}

/// A spot over a pane in front of its own shadow's near plane, with further shadows that contain the pane.
fn composite(shadows: Vec<Shadow>) -> Scene {
    let mut scene = ground(Cascades::default(), Vec3::NEG_Y);
    let (position, direction) = (Vec3::Y * 8.0, Vec3::NEG_Y);
    let kind = LightKind::Spot { position, direction, angle: 1.2 };
    scene.lights = vec![Light { near: Some(4.0), shadows, ..light(kind) }];
    // One pane in front of the own shadow's near plane; another behind it.
    scene.triangles.extend(roof(6.0, Vec3::splat(9.0), GLASS));
    scene
        .materials
        .push(Material { tint: Vec4::new(0.5, 1.0, 0.5, 1.0), ..material(Transfer::Filter) });
    scene.triangles.extend(roof(1.0, Vec3::splat(9.0), 2));
    scene
}

#[test]
fn of_several_shadows_the_least_light_counts() {
    let own = composite(Vec::new());
    let LightKind::Spot { position, direction, .. } = own.lights[0].kind else { panic!() };
    let further = |kind, near, far| Shadow { kind, near, far, size: Some(64), cascades: None };
    let narrow = LightKind::Spot { position, direction, angle: 0.4 };
    // It contains the upper pane only: (1, 0.5, 0.25); the own shadow the lower: (0.5, 1, 0.5).
    let upper = Shadow { size: None, ..further(narrow, Some(0.5), Some(20.0)) };
    let around = further(LightKind::Point { position }, None, None);
    let above = further(DOWN, None, None);
    let points = [Vec3::ZERO, Vec3::new(4.0, 0.0, 0.0)];
    let close = |scene: &Scene, expected: [Vec3; 2]| {
        for (light, expected) in light_at(scene, &points).into_iter().zip(expected) {
            assert!((light - expected).abs().max_element() < 2e-3, "{light}, not {expected}");
        }
    };
    let (lower, both) = (Vec3::new(0.5, 1.0, 0.5), Vec3::new(0.5, 0.5, 0.125));
    close(&own, [lower, lower]);
    // The narrow shadow contains both panes in its cone, and nothing outside.
    close(&composite(vec![upper]), [both, lower]);
    close(&composite(vec![around]), [both, both]);
    close(&composite(vec![above]), [both, both]);
    close(&composite(vec![upper, around, above]), [both, both]);
    // The least, not the product: the same shadow twice counts once.
    let twice = further(own.lights[0].kind, Some(4.0), None);
    close(&composite(vec![twice, twice]), [lower, lower]);
    let views = shadow_views(&composite(vec![upper, around, above]));
    let names: Vec<_> = views.iter().map(|view| view.name).collect();
    let expected = ["0", "s1_0", "s2_px", "s2_nx", "s2_py", "s2_ny", "s2_pz", "s2_nz", "s3_0"];
    assert_eq!(names, expected);
}

/// Cascades, a composite, a cube: maps of many sizes side by side.
fn crowd() -> Scene {
    let mut scene = composite(Vec::new());
    let cascades = Cascades { count: 3, range: Some(40.0), ..Cascades::default() };
    let sun = LightKind::Directional { direction: Vec3::new(0.3, -1.0, 0.2).normalize() };
    let spot = scene.lights[0].kind;
    let narrow = LightKind::Spot { position: Vec3::Y * 8.0, direction: Vec3::NEG_Y, angle: 0.5 };
    let shadow =
        |kind, size| Shadow { kind, near: None, far: None, size: Some(size), cascades: None };
    let lamp = LightKind::Point { position: Vec3::new(2.0, 3.0, -6.0) };
    scene.lights = vec![
        Light { cascades: Some(cascades), intensity: 2.0, size: Some(200), ..light(sun) },
        Light {
            intensity: 60.0,
            near: Some(4.0),
            shadows: vec![shadow(narrow, 48), shadow(lamp, 40)],
            ..light(spot)
        },
        Light { intensity: 20.0, size: Some(72), ..light(lamp) },
    ];
    scene.materials.push(Material { profile: Profile::Flat, ..material(Transfer::Dither) });
    scene.shadow.soften = true;
    scene.triangles.extend(moved(roof(0.5, Vec3::splat(0.7), STONE), Vec3::new(1.0, 0.0, -4.0)));
    let mut chance = Chance::new(9);
    for id in 0..80 {
        let center = Vec3::new(chance.within(-4.0, 4.0), 1.5, chance.within(-12.0, 0.0));
        let disc = particle(center, 0.4, Vec4::new(0.9, 0.3, 0.2, 0.4));
        scene.particles.push(gobo::model::Particle {
            material: if id % 4 == 0 { 3 } else { 2 },
            id,
            ..disc
        });
    }
    scene.ambient = Vec3::splat(0.05);
    scene.camera.size = UVec2::new(160, 96);
    scene
}

/// On the CPU every view has maps of its own: if the look-up or the blur crossed a border in the atlas,
/// pictures and maps would differ.
#[test]
fn no_filter_crosses_a_border_of_the_atlas() {
    let scene = crowd();
    let expected = maps(&scene);
    let picture = reference_picture(&scene);
    for tier in tiers(Tier::Core) {
        let frame = render(tier, &scene);
        assert_eq!(frame.counters.shrunk, 0);
        for (ours, theirs) in frame.maps.iter().zip(&expected) {
            let name = theirs.view.name;
            assert_eq!(ours.view.size, theirs.view.size);
            let filters = ours.filter.as_flattened().iter().zip(theirs.filter.as_flattened());
            let opaques = ours.opaque.iter().zip(&theirs.opaque);
            let off = filters.filter(|(a, b)| (*a - *b).abs() > 2e-3).count()
                + opaques.filter(|(a, b)| (*a - *b).abs() > 1e-4).count();
            // Texels on an edge may fall on either side of it.
            let share = off as f64 / ours.opaque.len() as f64;
            assert!(share < on(&gpu(tier), IN_ATLAS), "{tier:?} {name}: {off} texels off");
        }
        let apart = share_apart(&frame.picture, &picture);
        assert!(apart < 1e-3, "{tier:?}: {apart} of the channels");
    }
    let mut wrong = scene.clone();
    wrong.lights[1].shadows.pop();
    assert!(
        share_apart(&reference_picture(&wrong), &picture) > 1e-3,
        "a lost shadow would not be noticed"
    );
}

#[test]
fn maps_that_do_not_fit_are_smaller_and_counted() {
    let mut scene = crowd();
    scene.lights[0].size = None;
    scene.shadow.texel_budget = 30_000;
    let views = shadow_views(&scene);
    assert_eq!(views.len(), 3 + 1 + 1 + 6 + 6);
    let limits = AtlasLimits { edge: 128, layers: 2, texels: u64::MAX };
    let (few, shrunk) = fitted_views(&crowd(), &limits);
    assert_eq!(few.len(), views.len());
    assert!(shrunk > 2 && few.iter().all(|view| view.size.x <= 128));
    let texels: u32 = views.iter().map(|view| view.size.element_product()).sum();
    assert!(texels <= 30_000, "{texels}");
    let frame = render(TIERS[1], &scene);
    let sizes = |views: &[View]| views.iter().map(|view| view.size).collect::<Vec<_>>();
    let rendered: Vec<View> = frame.maps.iter().map(|map| map.view.clone()).collect();
    assert_eq!(sizes(&rendered), sizes(&views));
    let wished = sizes(&shadow_views(&crowd()));
    assert!(frame.counters.shrunk > 0);
    let smaller = sizes(&views).iter().zip(&wished).filter(|(a, b)| a != b).count();
    assert!(frame.counters.shrunk as usize <= smaller);
    assert!(share_apart(&frame.picture, &reference_picture(&scene)) < 1e-3);
}

#[test]
fn the_scene_file_says_it() {
    let sun = "[[light]]\nname = 'sun'\nkind = 'directional'\ndirection = [0, -1, 0]\n";
    let scene = read(&format!(
        "{sun}cascades = 2\nlambda = 0.25\nfade = 0.5\nrange = 30\nsize = 96\n\
         [[light.shadow]]\nsize = 32\n[[light.shadow]]\nkind = 'spot'\nposition = [0, 5, 0]\n\
         angle = 60\nnear = 1\n[[light.shadow]]\ncascades = 6\n"
    ))
    .unwrap();
    let sun_light = &scene.lights[0];
    let expected = Cascades { count: 2, lambda: 0.25, fade: 0.5, range: Some(30.0) };
    assert_eq!(sun_light.cascades, Some(expected));
    let [whole, spot, six] = sun_light.shadows[..] else { panic!("{sun_light:?}") };
    assert_eq!((whole.kind, whole.size, whole.cascades), (sun_light.kind, Some(32), None));
    let LightKind::Spot { position, direction, .. } = spot.kind else { panic!("{spot:?}") };
    assert_eq!((position, direction, spot.near), (Vec3::Y * 5.0, Vec3::NEG_Y, Some(1.0)));
    assert_eq!(six.cascades, Some(Cascades { count: 6, ..Cascades::default() }));
    assert_eq!(shadow_views(&scene).len(), 2 + 1 + 1 + 6);

    let fault = |text: &str, words: &[&str]| {
        let error = read(text).unwrap_err();
        let error = format!("{error} {error:?}");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    fault(&format!("{sun}lambda = 0.5\n"), &["5:", "lambda without cascades", "cascades = 4"]);
    fault(&format!("{sun}cascades = 2\nfade = 0.6\n"), &["6:", "fade must be from 0 to 0.5"]);
    fault(&format!("{sun}cascades = 2\nlambda = nan\n"), &["6:", "lambda must be from 0 to 1"]);
    fault(
        &format!("{sun}cascades = 2\nrange = 0\n"),
        &["6:", "range must be a distance of 1e-3 to 1e7 m"],
    );
    fault(&format!("{sun}[[light.shadow]]\nkind = 'point'\n"), &["point shadow without position"]);
    fault(&format!("{sun}[[light.shadow]]\nangle = 9\n"), &["directional shadow has no angle"]);
    fault(&format!("{sun}[[light.shadow]]\ncolour = 9\n"), &["6:", "colour"]);
    fault(&format!("{sun}{}", "[[light.shadow]]\n".repeat(4)), &["at most 3"]);
    fault("[shadow]\ntexel_budget = 0\n", &["2:", "texel_budget is 0"]);
    let spot = "[[light]]\nkind = 'spot'\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\n";
    fault(&format!("{spot}cascades = 2\n"), &["5:", "only a directional light has cascades"]);
}
