//! Shadows of the same scene in tenths of millimetres and in hundreds of kilometres.
use crate::common::{files::read, gpu, tiers};
use gobo::gpu::Tier;
use gobo_picture::{RenderOptions, Renderer};

/// Largest mean difference of pictures at two scales, over the whole picture and over its dark parts [of
/// 255].
const MEAN: f64 = 0.3;
const DARK_MEAN: f64 = 4.0;

/// A table, a ball on it and a pane beside it, `scale` times as large.
fn table(scale: f64) -> String {
    let vector = |v: [f64; 3]| format!("{:?}", v.map(|x| x * scale));
    let head = format!(
        "
[camera]
eye = {}
target = {}
fov_y = 40
size = [240, 160]
[[light]]
name = 'sun'
kind = 'directional'
direction = [-0.7, -1, -0.3]
intensity = 3
[[material]]
name = 'ground'
transfer = 'opaque'
tint = [0.7, 0.7, 0.7, 1]
[[material]]
name = 'glass'
tint = [0.1, 0.4, 0.9, 1]
transmission = 1
",
        vector([2.2, 1.8, 3.0]),
        vector([0.0, 0.4, 0.0]),
    );
    let leg = |x, z| ("box", "ground", [x, 0.34, z], [0.05, 0.68, 0.05]);
    let shapes = [
        ("plane", "ground", [0.0, 0.0, 0.0], [6.0, 1.0, 6.0]),
        ("box", "ground", [0.0, 0.7, 0.0], [1.0, 0.05, 0.8]),
        ("sphere", "ground", [0.1, 0.86, 0.1], [0.25; 3]),
        ("pane", "glass", [-0.9, 0.5, 0.4], [0.7, 1.0, 1.0]),
        leg(-0.45, -0.35),
        leg(-0.45, 0.35),
        leg(0.45, -0.35),
        leg(0.45, 0.35),
    ];
    shapes.iter().fold(head, |text, (kind, material, position, size)| {
        let [position, size] = [*position, *size].map(vector);
        text + &format!(
            "[[shape]]\nkind = '{kind}'\nmaterial = '{material}'\ntranslation = {position}\nscale = {size}\n"
        )
    })
}

fn picture(tier: Tier, toml: &str) -> Vec<[u8; 3]> {
    let mut renderer = Renderer::on(gpu(tier)).unwrap();
    renderer.render(&read(toml).unwrap(), &RenderOptions::default()).unwrap().picture.rgb
}

/// Mean difference over all pixels, and over those that are dark in the first.
fn means(first: &[[u8; 3]], second: &[[u8; 3]]) -> [f64; 2] {
    let mut greens: Vec<u8> = first.iter().map(|rgb| rgb[1]).collect();
    greens.sort_unstable();
    let dark = 0.75 * f64::from(greens[greens.len() / 2]);
    let mean = |is: &dyn Fn(&[u8; 3]) -> bool| {
        let pairs: Vec<_> = first.iter().zip(second).filter(|(a, _)| is(a)).collect();
        let sum: u32 =
            pairs.iter().flat_map(|(a, b)| (0..3).map(|i| u32::from(a[i].abs_diff(b[i])))).sum();
        f64::from(sum) / (3 * pairs.len()) as f64
    };
    [mean(&|_| true), mean(&|rgb| f64::from(rgb[1]) < dark)]
}

#[test]
fn scenes_of_any_size_have_the_same_shadows() {
    for tier in tiers(Tier::Native) {
        let usual = picture(tier, &table(1.0));
        for scale in [1e-4, 1e-2, 1e5] {
            let [all, dark] = means(&usual, &picture(tier, &table(scale)));
            assert!(all <= MEAN && dark <= DARK_MEAN, "{tier}, {scale}: {all}, {dark}");
        }
        // A bias of a centimetre swallows the shadows of smaller casters.
        let stated = format!("[shadow]\nbias = 0.01\n{}", table(1e-2));
        let [_, dark] = means(&usual, &picture(tier, &stated));
        assert!(dark > 2.0 * DARK_MEAN, "{dark}");
    }
}
