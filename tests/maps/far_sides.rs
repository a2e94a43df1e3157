//! Diffuse transmission of surfaces: shadows and pictures against Lambert's law.
use crate::common::{Tier, files::read, reference_picture, render, renderer, tiers};
use gobo::{
    glam::Vec3,
    model::{Material, ReceiverPoint},
};
use gobo_picture::Renderer;
use gobo_scene::Scene;
use std::f64::consts::PI;

const SHARE: f64 = 0.4;
const COLOR: [f64; 3] = [0.5, 1.0, 0.25];
const ALBEDO: f64 = 0.8;
const LEAF: &str = "transfer = 'opaque'\ntint = [0.8, 0.8, 0.8, 1]\ndiffuse_transmission = 0.4\n\
                    diffuse_transmission_color = [0.5, 1, 0.25]";
const SHEET: &str = "kind = 'plane'\nscale = [12, 1, 12]";

/// A light at an angle over a leaf, seen from straight above or below, in the dark.
fn lit(angle: f64, leaf: &str, shape: &str, eye: &str) -> Scene {
    let (sin, cos) = angle.to_radians().sin_cos();
    let toml = format!(
        "[camera]\neye = {eye}\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov_y = 2\nsize = [16, 16]\n\
         samples = 1\n\
         occlusion = false\n[environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n[shadow]\n\
         size = 256\n\
         [[light]]\nkind = 'directional'\nintensity = 2\ndirection = [{sin}, {}, 0]\n\
         [[material]]\nname = 'leaf'\nroughness = 1\n{leaf}\n[[shape]]\nname = 'leaf'\n\
         material = 'leaf'\n{shape}\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [14, 1, 14]\ntranslation = [0, -20, 0]\n",
        -cos
    );
    read(&toml).unwrap_or_else(|error| panic!("{error}"))
}

/// Light at a point, on the CPU and on devices.
fn light_at(scene: &Scene, position: Vec3) -> Vec<[f32; 3]> {
    let points = [ReceiverPoint { position, normal: Vec3::ZERO }];
    let on_cpu = Renderer::on_cpu().light_points(scene, &points).unwrap()[0];
    let on_gpu = tiers(Tier::Native).into_iter();
    let on_gpu = on_gpu.map(|tier| renderer(tier).light_points(scene, &points).unwrap()[0]);
    on_gpu.chain([on_cpu]).collect()
}

#[track_caller]
fn assert_near(found: [f32; 3], wanted: [f64; 3], most: f64, what: &str) {
    let apart = found.iter().zip(wanted).map(|(&a, b)| (f64::from(a) - b).abs());
    assert!(apart.fold(0.0, f64::max) < most, "{what}: {found:?}, not {wanted:?}");
}

/// The middle pixel of pictures.
fn seen(scene: &Scene) -> [[f32; 3]; 2] {
    [reference_picture(scene), render(Tier::Native, scene).picture].map(|it| it.light[8 * 16 + 8])
}

/// All transmitted light falls into the shadow: under a sheet that covers the sky, no other light arrives.
#[test]
fn shadows_have_the_colour_of_what_passes() {
    let passes = COLOR.map(|c| SHARE * c);
    for angle in [0.0, 60.0] {
        for light in light_at(&lit(angle, LEAF, SHEET, "[0, 9, 0]"), Vec3::new(0.0, -1.0, 0.0)) {
            assert_near(light, passes, 2e-3, "a sheet");
        }
    }
    let body = "kind = 'box'\nscale = [12, 0.1, 12]";
    for light in light_at(&lit(0.0, LEAF, body, "[0, 9, 0]"), Vec3::new(0.0, -1.0, 0.0)) {
        assert_near(light, passes.map(|t| t * t), 2e-3, "two sheets");
    }
    // A cutout is where it is solid.
    for (alpha, wanted) in [(0.6, passes), (0.4, [1.0; 3])] {
        let keys =
            LEAF.replace("'opaque'", "'cutout'").replace("0.8, 1]", &format!("0.8, {alpha}]"));
        for light in light_at(&lit(0.0, &keys, SHEET, "[0, 9, 0]"), Vec3::new(0.0, -1.0, 0.0)) {
            assert_near(light, wanted, 2e-3, "a cutout");
        }
    }
}

/// Lambert's law on both sides, and never more light than arrives.
#[test]
fn both_sides_scatter_their_shares() {
    for angle in [0.0, 60.0] {
        let arrives = 2.0 * f64::to_radians(angle).cos() / PI;
        let far = COLOR.map(|c| SHARE * c * arrives);
        for found in seen(&lit(angle, LEAF, SHEET, "[0, -9, 0]")) {
            assert_near(found, far, 2e-3, "the far side");
        }
        // Like a surface whose albedo is the remaining share.
        let plain = "transfer = 'opaque'\ntint = [0.48, 0.48, 0.48, 1]";
        let [wanted, _] = seen(&lit(angle, plain, SHEET, "[0, 9, 0]"));
        assert!(f64::from(wanted[0]) > 0.9 * (1.0 - SHARE) * ALBEDO * arrives);
        for found in seen(&lit(angle, LEAF, SHEET, "[0, 9, 0]")) {
            assert_near(found, wanted.map(f64::from), 1e-3, "the near side");
        }
    }
}

/// Light from all directions comes from behind, too.
#[test]
fn ambient_light_passes() {
    let mut scene = lit(0.0, LEAF, SHEET, "[0, -9, 0]");
    (scene.lights[0].intensity, scene.ambient) = (0.0, Vec3::ONE);
    // Two colours: 0.85 + 0.15 y of it.
    let wanted = COLOR.map(|c| (1.0 - SHARE) * ALBEDO * 0.7 + SHARE * c);
    for found in seen(&scene) {
        assert_near(found, wanted, 3e-3, "below");
    }
}

/// A lampshade shines evenly: it is not in its own shadow.
#[test]
fn a_lampshade_shines_evenly() {
    for receiver in ["curve", "nearest"] {
        let toml = format!(
            "[camera]\neye = [0, 0, 12]\ntarget = [0, 0, 0]\nfov_y = 22\nsize = [64, 64]\nsamples = 1\n\
             occlusion = false\n\
             [environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n[shadow]\nsize = 256\n\
             receiver = '{receiver}'\n\
             [[light]]\nkind = 'point'\nposition = [0, 0, 0]\nintensity = 8\nnear = 0.05\n\
             [[material]]\nname = 'leaf'\n{LEAF}\n\
             [[shape]]\nkind = 'sphere'\nmaterial = 'leaf'\nscale = [4, 4, 4]\nlevel = 5\n"
        );
        let scene = read(&toml).unwrap_or_else(|error| panic!("{error}"));
        let wanted = COLOR.map(|c| SHARE * c * 8.0 / 4.0 / PI);
        for picture in [reference_picture(&scene), render(Tier::Native, &scene).picture] {
            let mut count = 0;
            for (i, &light) in picture.light.iter().enumerate() {
                let off = Vec3::new((i % 64) as f32 - 31.5, (i / 64) as f32 - 31.5, 0.0).length();
                if off < 25.0 {
                    assert_near(light, wanted, 8e-3, "the shade");
                    count += 1;
                }
            }
            assert!(count > 1900, "{count} pixels");
        }
        for light in light_at(&scene, Vec3::new(0.1, -3.0, 0.2)) {
            assert_near(light, COLOR.map(|c| SHARE * c), 3e-3, "outside");
        }
    }
}

/// Shadows move with their casters.
#[test]
fn what_moves_takes_its_shadow_along() {
    let mut scene = lit(0.0, LEAF, "kind = 'plane'\nscale = [2, 1, 2]", "[0, 9, 0]");
    let toml = "[[animate]]\ntarget = 'shape.leaf.translation'\ntimes = [0, 1]\n\
        values = [[0, 0, 0], [4, 0, 0]]\n";
    assert!(scene.motions.is_empty());
    let text = format!(
        "[[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\n[[material]]\nname = 'leaf'\n{LEAF}\n\
         [[shape]]\nname = 'leaf'\nkind = 'plane'\nmaterial = 'leaf'\nscale = [2, 1, 2]\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n[[shape]]\nkind = 'plane'\nmaterial = 'ground'\n\
         scale = [14, 1, 14]\ntranslation = [0, -2, 0]\n{toml}"
    );
    scene = read(&text).unwrap_or_else(|error| panic!("{error}"));
    for (seconds, x) in [(0.0, 0.0), (1.0, 4.0)] {
        scene.set_time(seconds);
        let count = scene.triangles.len();
        for (at, wanted) in [(x, COLOR.map(|c| SHARE * c)), (4.0 - x, [1.0; 3])] {
            let light = light_at(&scene, Vec3::new(at, -1.0, 0.0));
            light.into_iter().for_each(|it| assert_near(it, wanted, 3e-3, "at its place"));
        }
        assert_eq!(count, scene.triangles.len());
    }
}

#[test]
fn keys_that_do_not_fit_are_refused() {
    let error = |keys: &str| {
        let text = format!("[[material]]\nname = 'a'\n{keys}\n");
        read(&text).unwrap_err().to_string()
    };
    let glass = error("diffuse_transmission = 0.5");
    assert!(glass.contains("opaque or cutout"), "{glass}");
    let alone = error("transfer = 'opaque'\ndiffuse_transmission_color = [1, 0, 0]");
    assert!(alone.contains("without a share that passes"), "{alone}");
    let much = error("transfer = 'opaque'\ndiffuse_transmission = 1.5");
    assert!(much.contains("1.5"), "{much}");
    let grains = format!(
        "[[material]]\nname = 'a'\n{LEAF}\n[[particles]]\nmaterial = 'a'\n\
         generate = {{ kind = 'smoke', count = 9 }}\n"
    );
    let error = read(&grains).unwrap_err().to_string();
    assert!(error.contains("far side"), "{error}");
    // Through the library's host interface.
    let mut scene = lit(0.0, LEAF, SHEET, "[0, 9, 0]");
    scene.materials.push(Material { far_side: Some(99), ..Material::default() });
    let point = [ReceiverPoint { position: Vec3::ZERO, normal: Vec3::ZERO }];
    let error = renderer(Tier::Native).light_points(&scene, &point).unwrap_err().to_string();
    assert!(error.contains("far side"), "{error}");
}
