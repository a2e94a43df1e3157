//! Reflection of panes and faces of glass: maps, look-ups and pictures against Fresnel's formulas in sines
//! and tangents.
use crate::common::{Tier, files::read, map_frame, reference_picture, render, renderer, tiers};
use gobo::{
    glam::Vec3,
    model::{Fresnel, LightKind, Material, ReceiverPoint},
    view::shadow_views,
};
use gobo_picture::Renderer;
use gobo_reference::render_maps;
use gobo_scene::Scene;

const INDEX: f64 = 1.5;
const ANGLES: [f64; 4] = [0.0, 45.0, 60.0, 80.0];
/// Rounding of half floats near 1, and of normals in 16 bits at steep angles.
const ROUNDING: f64 = 2e-3;

/// Reflectance of both polarisations, at an angle to the normal [radians].
fn reflected(index: f64, angle: f64) -> [f64; 2] {
    if angle < 1e-6 {
        let head_on = ((index - 1.0) / (index + 1.0)).powi(2);
        return [head_on; 2];
    }
    let inside = (angle.sin() / index).asin();
    let across = (angle - inside).sin() / (angle + inside).sin();
    let along = (angle - inside).tan() / (angle + inside).tan();
    [across * across, along * along]
}

/// Transmittance of one face.
fn face(index: f64, angle: f64) -> f64 {
    1.0 - reflected(index, angle).iter().sum::<f64>() / 2.0
}

/// Transmittance of a pane: the sum over all internal reflections.
fn pane(index: f64, angle: f64) -> f64 {
    let passed = |r: f64| (0..60).map(|k| (1.0 - r).powi(2) * r.powi(2 * k)).sum::<f64>();
    reflected(index, angle).map(passed).iter().sum::<f64>() / 2.0
}

/// A light at an angle over glass, and a receiver below.
fn lit(angle: f64, keys: &str, shape: &str) -> Scene {
    let (sin, cos) = angle.to_radians().sin_cos();
    let toml = format!(
        "[camera]\neye = [0, 9, 9]\n[shadow]\nsize = 256\n\
         [[light]]\nkind = 'directional'\ndirection = [{sin}, {}, 0]\n\
         [[material]]\nname = 'glass'\n{keys}\n[[shape]]\nmaterial = 'glass'\n{shape}\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [14, 1, 14]\ntranslation = [0, -1, 0]\n",
        -cos
    );
    read(&toml).unwrap_or_else(|error| panic!("{error}"))
}

const SHEET: &str = "kind = 'plane'\nscale = [12, 1, 12]";
const SLAB: &str = "kind = 'box'\nscale = [12, 0.1, 12]";

/// Light just below the middle.
fn below(scene: &Scene) -> Vec<f64> {
    let points = [ReceiverPoint { position: Vec3::new(0.0, -0.3, 0.0), normal: Vec3::ZERO }];
    let on_cpu = Renderer::on_cpu().light_points(scene, &points).unwrap()[0];
    let on_gpu = tiers(Tier::Native).into_iter().map(|tier| {
        let light = renderer(tier).light_points(scene, &points).unwrap()[0];
        for (a, b) in light.into_iter().zip(on_cpu) {
            assert!((a - b).abs() < 1e-3, "{tier:?}: {light:?}, not {on_cpu:?}");
        }
        light
    });
    on_gpu.chain([on_cpu]).map(|light| f64::from(light[0])).collect()
}

#[track_caller]
fn assert_passes(scene: &Scene, wanted: f64, what: &str) {
    for found in below(scene) {
        assert!((found - wanted).abs() < ROUNDING, "{what}: {found}, not {wanted}");
    }
    let (maps, _) = render_maps(scene, &shadow_views(scene));
    let middle = maps[0].filter[128 * 256 + 128];
    assert!((f64::from(middle[0]) - wanted).abs() < ROUNDING, "{what}: {middle:?} in the map");
}

#[test]
fn panes_and_bodies_lose_what_they_reflect() {
    for angle in ANGLES {
        let (radians, what) = (angle.to_radians(), format!("{angle} degrees"));
        let thin = lit(angle, "ior = 1.5\nthin = true", SHEET);
        assert_passes(&thin, pane(INDEX, radians), &format!("pane, {what}"));
        let closed = lit(angle, "ior = 1.5", SLAB);
        assert_passes(&closed, face(INDEX, radians).powi(2), &format!("slab, {what}"));
        // A surface of water, and glass that also absorbs.
        let water = lit(angle, "ior = 1.33", SHEET);
        assert_passes(&water, face(1.33, radians), &format!("water, {what}"));
        let keys = "ior = 1.5\nattenuation_color = [0.5, 0.5, 0.5]\nattenuation_distance = 0.1";
        let way = 0.5f64.powf(1.0 / radians.cos());
        let tinted = face(INDEX, radians).powi(2) * way;
        assert_passes(&lit(angle, keys, SLAB), tinted, &format!("grey slab, {what}"));
    }
    assert!((1.0 - pane(INDEX, 0.0) - 0.0769).abs() < 1e-4, "both faces");
    assert!((1.0 - face(INDEX, 0.0) - 0.04).abs() < 1e-4, "one face");
}

/// The share multiplies the colour in every transfer.
#[test]
fn transfers_take_the_share_as_colour() {
    let share = pane(INDEX, 0.0);
    for (transfer, wanted) in [
        ("filter", 1.0 - 0.5 * (1.0 - 0.8 * share)),
        ("stain", 0.5 * 0.8 * share),
        ("smoke", 0.5 * (1.0 - 0.5 * (1.0 - 0.8 * share))),
        ("over", 0.5 + 0.5 * 0.8 * share),
        ("gain", 0.8 * share),
    ] {
        let keys =
            format!("ior = 1.5\nthin = true\ntransfer = '{transfer}'\ntint = [0.8, 0.8, 0.8, 0.5]");
        assert_passes(&lit(0.0, &keys, SHEET), wanted, transfer);
    }
}

/// Each of a lamp's rays meets a pane at its own angle, even in one triangle; in curves, too.
#[test]
fn lamps_meet_panes_at_many_angles() {
    for receiver in ["nearest", "curve"] {
        let mut scene = lit(0.0, "ior = 1.5\nthin = true", SHEET);
        scene.shadow.receiver = match receiver {
            "nearest" => gobo::model::Receiver::Nearest,
            _ => gobo::model::Receiver::Curve,
        };
        scene.lights[0].kind = LightKind::Point { position: Vec3::new(0.0, 1.0, 0.0) };
        let points: Vec<_> = (0..9)
            .map(|i| ReceiverPoint {
                position: Vec3::new(0.6 * i as f32 + 0.05, -0.2, 0.1),
                normal: Vec3::ZERO,
            })
            .collect();
        let all = |renderer: &mut Renderer| renderer.light_points(&scene, &points).unwrap();
        let of_cpu = all(&mut Renderer::on_cpu());
        let of_gpu = tiers(Tier::Core).into_iter().map(|tier| all(&mut renderer(tier)));
        for light in of_gpu.chain([of_cpu]) {
            for (found, point) in light.iter().zip(&points) {
                let way = point.position - Vec3::Y;
                let wanted = pane(INDEX, f64::from(-way.y / way.length()).acos());
                let found = f64::from(found[0]);
                assert!((found - wanted).abs() < 4e-3, "{receiver}: {found}, not {wanted}");
            }
        }
    }
}

#[test]
fn without_an_index_nothing_is_reflected() {
    let same = |keys: &str, shape: &str| {
        let scene = lit(60.0, keys, shape);
        let maps = map_frame(Tier::Native, &scene).maps;
        assert!(maps[0].filter.iter().all(|f| *f == [1.0; 3]), "{keys}");
    };
    same("", SHEET);
    same("ior = 1", SLAB);
    same("ior = 1\nthin = true", SHEET);
    let wrong = "[[material]]\nname = 'a'\nthin = true\n";
    let error = read(wrong).unwrap_err().to_string();
    assert!(error.contains("thin") && error.contains("ior"), "{error}");
    assert_eq!(Material::default().fresnel, Fresnel::None);
    // Through the library's host interface.
    let mut scene = lit(0.0, "ior = 1.5", SHEET);
    let point = [ReceiverPoint { position: Vec3::ZERO, normal: Vec3::ZERO }];
    for fresnel in [f32::NAN, 0.5, 3.5].map(|ior| Fresnel::Face { ior }) {
        scene.materials[0].fresnel = fresnel;
        let error = Renderer::on_cpu().light_points(&scene, &point).unwrap_err().to_string();
        assert!(error.contains("index of refraction"), "{error}");
    }
}

/// Maps with curves and pictures of every transfer: `ior = 1` mirrors nothing and takes no other branch.
#[test]
fn an_index_of_one_changes_no_bit() {
    for transfer in ["filter", "over", "stain", "gain", "opaque", "dither"] {
        let scenes = ["", "ior = 1"].map(|ior| {
            let keys = format!("transfer = '{transfer}'\ntint = [0.9, 0.5, 0.2, 0.6]\n{ior}");
            let mut scene = lit(60.0, &keys, SHEET);
            scene.camera.size = [32, 32].into();
            scene.shadow.size = 64;
            scene
        });
        let [without, one] = scenes.each_ref().map(|scene| render(Tier::Native, scene));
        let [a, b] = [&without.maps[0], &one.maps[0]];
        assert!(
            a.filter == b.filter && a.nearest == b.nearest && a.opaque == b.opaque,
            "{transfer}"
        );
        assert!(a.curve == b.curve && without.picture.light == one.picture.light, "{transfer}");
        assert!(
            a.opaque.iter().chain(&a.nearest).any(|depth| *depth < 1.0),
            "{transfer}: no shadow"
        );
        let [without, one] = scenes.each_ref().map(reference_picture);
        assert!(without.light == one.light, "{transfer}: of the CPU reference");
    }
}

/// The eye sees through a pane the light that the pane does not mirror at the eye's angle, and the picture
/// loses no light twice.
#[test]
fn the_picture_loses_the_same_share() {
    for (angle, shape, keys) in
        [(0.0, "pane", "thin = true"), (60.0, "pane", "thin = true"), (60.0, "pane", "")]
    {
        let (sin, cos) = f64::to_radians(angle).sin_cos();
        let scene = |ior: &str| {
            let toml = format!(
                "[camera]\neye = [{}, 0, {}]\ntarget = [0, 0, 0]\nfov_y = 2\nsize = [16, 16]\nsamples = 2\n\
                 [environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n[shadow]\nsize = 16\n\
                 [[light]]\nkind = 'point'\nposition = [0, 50, 0]\nintensity = 0\n\
                 [[material]]\nname = 'glass'\ntransmission = 1\n{ior}\n\
                 [[material]]\nname = 'wall'\ntransfer = 'opaque'\ntint = [0, 0, 0, 1]\n\
                 emission = [1, 1, 1]\n\
                 [[shape]]\nkind = '{shape}'\nmaterial = 'glass'\nscale = [9, 9, 1]\n\
                 [[shape]]\nkind = 'pane'\nmaterial = 'wall'\ntranslation = [0, 0, -1]\n\
                 scale = [90, 90, 1]\n",
                sin * 9.0,
                cos * 9.0
            );
            read(&toml).unwrap_or_else(|error| panic!("{error}"))
        };
        let glass = scene(&format!("ior = 1.5\n{keys}"));
        let share = if keys.is_empty() { face } else { pane }(INDEX, angle.to_radians());
        for picture in [reference_picture(&glass), render(Tier::Native, &glass).picture] {
            let found = f64::from(picture.light[8 * 16 + 8][0]);
            assert!((found - share).abs() < 5e-3, "{angle}: {found}, not {share}");
        }
    }
}
