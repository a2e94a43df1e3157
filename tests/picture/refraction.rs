//! `ior` and `frost`: the background of glass against Snell's law and the law of sines, and kernels against
//! the CPU reference.
use crate::common::{
    TIERS, Tier,
    files::{Folder, read},
    model::Glb,
    reference_picture, render, tiers,
};
use gobo::{
    glam::{DVec2, Vec3},
    model::View,
    records::Picture,
};
use gobo_scene::Scene;
use serde_json::json;

const SIZE: u32 = 96;

/// Glass in front of a wall that shines left of x = 0; given are the eye, and the wall's distance behind z
/// = 0.
fn glass(material: &str, shape: &str, eye: [f32; 3], wall: f32) -> Scene {
    let toml = format!(
        "[camera]\neye = {eye:?}\ntarget = [0, 0, 0]\nfov_y = 20\nsize = [{SIZE}, {SIZE}]\nsamples = 1\n\
         occlusion = false\n[shadow]\nsize = 16\n\
         [environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n\
         [[light]]\nkind = 'point'\nposition = [0, 50, 0]\nintensity = 0\n\
         [[material]]\nname = 'glass'\ntransmission = 1\nreflectivity = 0\n{material}\n\
         [[material]]\nname = 'wall'\ntransfer = 'opaque'\ntint = [0, 0, 0, 1]\nemission = [1, 1, 1]\n\
         [[material]]\nname = 'dark'\ntransfer = 'opaque'\ntint = [0, 0, 0, 1]\n\
         [[shape]]\nmaterial = 'glass'\n{shape}\n\
         [[shape]]\nkind = 'pane'\nmaterial = 'wall'\ntranslation = [-10, 0, {wall}]\nscale = [20, 20, 1]\n\
         [[shape]]\nkind = 'pane'\nmaterial = 'dark'\ntranslation = [10, 0, {wall}]\nscale = [20, 20, 1]\n"
    );
    read(&toml).unwrap_or_else(|error| panic!("{error}"))
}

/// Light of the middle row, relative to that of the unhidden wall.
fn row(picture: &Picture) -> Vec<f32> {
    let first = (SIZE / 2 * SIZE) as usize;
    let row: Vec<f32> = picture.light[first..][..SIZE as usize].iter().map(|l| l[0]).collect();
    let most = row.iter().copied().fold(0.0, f32::max);
    row.into_iter().map(|light| light / most).collect()
}

/// Position in the row where the light falls below a share, interpolated between pixels [pixels].
fn edge(row: &[f32], share: f32) -> f64 {
    let after = row.iter().position(|&light| light < share).expect("an edge");
    let (a, b) = (row[after.max(1) - 1], row[after]);
    after as f64 - 0.5 + f64::from((a - share) / (a - b).max(1e-6))
}

fn light_of(scene: &Scene) -> Vec<Picture> {
    let mut pictures = vec![reference_picture(scene)];
    for tier in tiers(Tier::Native) {
        let mut scene = scene.clone();
        // The light is read back with the samples.
        scene.samples = 2;
        let picture = render(tier, &scene).picture;
        pictures.push(picture);
    }
    pictures
}

/// A slab seen at 40 degrees, with an edge behind it: Snell's law says where the ray leaves.
#[test]
fn slabs_shift_what_is_behind() {
    const THICK: f64 = 0.5;
    let (sin, cos) = 40f32.to_radians().sin_cos();
    let eye = [3.0 * sin, 0.0, 3.0 * cos];
    let shape =
        format!("kind = 'box'\ntranslation = [0, 0, {}]\nscale = [6, 6, {THICK}]", -THICK / 2.0);
    let wall = -0.501;
    let straight = glass("", &shape, eye, wall);
    let camera = View::from_camera(&straight.camera, &straight.bounds());
    let pixel = |x: f64| {
        let clip = camera.clip_from_world() * Vec3::new(x as f32, 0.0, 0.0).extend(1.0);
        (f64::from(clip.x / clip.w) * 0.5 + 0.5) * f64::from(SIZE)
    };
    let from = DVec2::new(f64::from(eye[0]), f64::from(eye[2]));
    let mut edges = Vec::new();
    for ior in [1.0, 1.33, 1.5, 2.4] {
        // Point of the front whose ray leaves at x = 0.
        let leaves = |front: f64| {
            let sine = (from.x - front) / (DVec2::new(from.x - front, from.y)).length() / ior;
            front - THICK * sine / (1.0 - sine * sine).sqrt()
        };
        let (mut low, mut high) = (-1.0, 1.5);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if leaves(middle) < 0.0 { low = middle } else { high = middle }
        }
        let exact = pixel(low);
        for picture in light_of(&glass(&format!("ior = {ior:?}"), &shape, eye, wall)) {
            let found = edge(&row(&picture), 0.5);
            assert!((found - exact).abs() < 1.2, "{ior}: at {found}, not at {exact}");
        }
        edges.push(exact);
    }
    assert!(edges[0] - edges[2] > 5.0, "{edges:?}");
}

/// Objects that touch a frosted pane are sharp; the farther behind it, the more blurred they are; no light is
/// lost.
#[test]
fn frost_blurs_with_the_distance_behind_it() {
    let pane = "kind = 'pane'\nscale = [6, 6, 1]";
    let width = |frost: f32, wall: f32| {
        let scene = glass(&format!("frost = {frost:?}"), pane, [0.0, 0.0, 4.0], wall);
        let widths = light_of(&scene).into_iter().map(|picture| {
            let row = row(&picture);
            let (start, end) = (edge(&row, 0.84), edge(&row, 0.16));
            assert!((0.5 * (start + end) - 48.0).abs() < 1.0, "{frost}, {wall}: {start} to {end}");
            end - start
        });
        widths.collect::<Vec<_>>()
    };
    let scale = 48.0 / 10f64.to_radians().tan();
    for (sharp, wide) in width(0.1, -0.01).iter().zip(width(0.1, -2.0)) {
        // Two standard deviations of the spline for the mip level whose texels are twice the radius.
        let radius = 0.1 * 2.0 / 6.0 * scale;
        let wide = wide / radius;
        assert!(*sharp < 2.0 && wide > 1.0 && wide < 3.5, "{sharp} and {wide} radii");
    }
    assert!(width(0.0, -2.0).iter().all(|&width| width < 1.5));
}

#[test]
fn kernels_match_the_reference() {
    let ball = "kind = 'sphere'\ntranslation = [0.2, 0.1, 0]\nscale = [1, 1, 1]\nlevel = 4";
    let colored = "tint = [0.6, 0.9, 1, 1]\nior = 1.5\nfrost = 0.02\nattenuation_distance = 1\n\
                   attenuation_color = [0.9, 0.5, 0.2]";
    let mut scene = glass(colored, ball, [0.6, 0.5, 4.0], -1.0);
    for samples in [1, 2] {
        scene.samples = samples;
        let expected = reference_picture(&scene);
        for tier in TIERS {
            let picture = render(tier, &scene).picture;
            let pairs = picture.rgb.iter().flatten().zip(expected.rgb.iter().flatten());
            let off = pairs.filter(|(a, b)| a.abs_diff(**b) > 4).count();
            assert!(off < 30, "{tier:?}, {samples}: {off} channels");
        }
    }
    // The ball shows the edge elsewhere.
    let mut clear = scene.clone();
    clear.materials[0].ior = 1.0;
    let (bent, straight) = (reference_picture(&scene), reference_picture(&clear));
    let differ = bent.rgb.iter().zip(&straight.rgb).filter(|(a, b)| a[0].abs_diff(b[0]) > 40);
    assert!(differ.count() > 50);
}

/// Objects in front of glass are not seen through it.
#[test]
fn what_is_in_front_is_not_behind() {
    let ball = "kind = 'sphere'\nscale = [1.2, 1.2, 1.2]\n\
                [[shape]]\nkind = 'pane'\nmaterial = 'wall'\ntranslation = [0.45, 0, 1.2]\n\
                scale = [0.1, 4, 1]";
    let scene = glass("ior = 1.5\nattenuation_distance = 1e6", ball, [0.0, 0.0, 4.0], -1.0);
    for picture in light_of(&scene) {
        // Right of the middle the wall is dark; only the post shines.
        let row = row(&picture);
        let bright = (52..96).filter(|&x| row[x] > 0.3).count();
        // The post is 0.1 m at 2.8 m.
        let wide = 0.1 / 2.8 * 48.0 / 10f32.to_radians().tan();
        assert!((bright as f32 - wide).abs() < 2.5, "{bright} pixels, not {wide}");
    }
}

/// Glass of a glTF file is rougher the rougher its surface is, by the square of its roughness.
#[test]
fn rough_glass_of_a_model_is_rougher_than_smooth() {
    let width = |roughness: f32| {
        let mut model = Glb::new();
        let pane = model.square(json!({
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": roughness },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } },
        }));
        let node = model.place(pane, [0.0; 3]);
        model.json["nodes"][node]["scale"] = json!([6, 1, 6]);
        let folder = Folder::new();
        folder.write("pane.glb", model.bytes());
        let toml = format!(
            "[camera]\neye = [0, 4, 0]\ntarget = [0, 0, 0]\nup = [0, 0, -1]\nfov_y = 20\n\
             size = [{SIZE}, {SIZE}]\nsamples = 1\nocclusion = false\n[shadow]\nsize = 16\n\
             [environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n\
             [[light]]\nkind = 'point'\nposition = [0, 50, 0]\nintensity = 0\n\
             [[material]]\nname = 'bright'\ntransfer = 'opaque'\ntint = [0, 0, 0, 1]\n\
             emission = [1, 1, 1]\n\
             [[material]]\nname = 'dark'\ntransfer = 'opaque'\ntint = [0, 0, 0, 1]\n\
             [[mesh]]\nfile = 'pane.glb'\n\
             [[shape]]\nkind = 'plane'\nmaterial = 'bright'\ntranslation = [-10, -1, 0]\n\
             scale = [20, 1, 20]\n\
             [[shape]]\nkind = 'plane'\nmaterial = 'dark'\ntranslation = [10, -1, 0]\nscale = [20, 1, 20]\n"
        );
        let scene = gobo_scene::load(&folder.write("scene.toml", toml)).unwrap();
        light_of(&scene).iter().map(row).map(|row| edge(&row, 0.16) - edge(&row, 0.84)).collect()
    };
    let [smooth, rough, rougher]: [Vec<f64>; 3] = [0.0, 0.2, 0.35].map(width);
    for ((smooth, rough), rougher) in smooth.iter().zip(&rough).zip(&rougher) {
        assert!(*smooth < 1.5 && *rough > 3.0 * smooth, "{smooth}, {rough}, {rougher}");
        // Levels of an image are twice as coarse as each other, so the ratio is not exact.
        assert!((1.4..4.5).contains(&(rougher / rough)), "{smooth}, {rough}, {rougher}");
    }
}
