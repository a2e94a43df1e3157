//! Coplanar faces have one order: the one with the higher id, which is later in the file, is in front.
use crate::common::{TIERS, files::read, reference_picture, render};
use gobo_scene::Scene;

const SIZE: i32 = 160;

/// Ambient light alone, and shapes in the order of the file.
fn scene(shapes: &[&str]) -> Scene {
    read(&format!(
        "[camera]\neye = [1.3, 1.1, 2.1]\ntarget = [0.2, 0.2, 0]\nfov_y = 40\nsize = [{SIZE}, {SIZE}]\n\
         samples = 1\nocclusion = false\n[environment]\nambient = [0.5, 0.5, 0.5]\nbackground = [0, 0, 0.5]\n\
         [[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\nintensity = 0\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\ntint = [0.8, 0.1, 0.1, 1]\nroughness = 1\n\
         [[material]]\nname = 'card'\ntransfer = 'opaque'\ntint = [0.1, 0.7, 0.1, 1]\nroughness = 1\n\
         [[material]]\nname = 'glass'\ntint = [0.9, 0.3, 0.5, 0.7]\n\
         [[material]]\nname = 'flat'\ntint = [0.2, 0.9, 0.2, 0.9]\nemission = [0, 0.4, 0]\n\
         [[material]]\nname = 'poster'\ntint = [0.9, 0.2, 0.2, 0.9]\nemission = [0.4, 0, 0]\n{}",
        shapes.concat()
    ))
    .unwrap_or_else(|error| panic!("{error}"))
}

const FLOOR: &str = "[[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [40, 1, 40]\n";
const BOX: &str = "[[shape]]\nkind = 'box'\nmaterial = 'ground'\nscale = [0.7, 0.7, 0.7]\n\
    translation = [0, 0.35, 0]\nrotation = [0, 25, 0]\n";

/// A pane that lies in the floor.
fn lying(material: &str) -> String {
    format!(
        "[[shape]]\nkind = 'pane'\nmaterial = '{material}'\nscale = [0.8, 0.6, 1]\n\
         translation = [0.3, 0, 0.2]\nrotation = [-90, 0, 33]\n"
    )
}

/// A pane on the box's front: 0.35 m along its third axis, and a part of it to its right.
fn hanging(material: &str, right: f32) -> String {
    let (sine, cosine) = 25f32.to_radians().sin_cos();
    let (x, z) = (0.35 * sine + right * cosine, 0.35 * cosine - right * sine);
    format!(
        "[[shape]]\nkind = 'pane'\nmaterial = '{material}'\nscale = [0.4, 0.4, 1]\n\
         translation = [{x}, 0.4, {z}]\nrotation = [0, 25, 0]\n"
    )
}

/// Pixels whose whole surroundings show a shape when it is alone.
fn inside(shape: &str) -> Vec<usize> {
    let [bare, alone] =
        [&[][..], &[shape]].map(|shapes| render(TIERS[0], &scene(shapes)).picture.rgb);
    let covers: Vec<bool> = bare.iter().zip(&alone).map(|(a, b)| a != b).collect();
    let is_inside = |&at: &usize| {
        let (x, y) = (at as i32 % SIZE, at as i32 / SIZE);
        (-2..=2).all(|dy| {
            (-2..=2).all(|dx| {
                let (x, y) = (x + dx, y + dy);
                (0..SIZE).contains(&x) && (0..SIZE).contains(&y) && covers[(y * SIZE + x) as usize]
            })
        })
    };
    let all: Vec<usize> = (0..covers.len()).filter(is_inside).collect();
    assert!(all.len() > 200, "{}", all.len());
    all
}

/// The one colour of the pixels.
fn color(rgb: &[[u8; 3]], pixels: &[usize], what: &str) -> [u8; 3] {
    let range = |c: usize| {
        let values = pixels.iter().map(|&at| rgb[at][c]);
        (values.clone().min().unwrap(), values.max().unwrap())
    };
    [0, 1, 2].map(|c| {
        let (least, most) = range(c);
        assert!(most - least <= 2, "{what}: {least} to {most}");
        most
    })
}

#[test]
fn the_later_of_two_faces_in_a_plane_is_in_front() {
    let on_floor = [lying("card"), lying("glass")];
    let on_box = [hanging("card", 0.0), hanging("glass", 0.0)];
    for (shapes, base) in [(on_floor, FLOOR), (on_box, BOX)] {
        let pixels = inside(&shapes[0]);
        for tier in TIERS {
            let of = |shapes: &[&str], what: &str| {
                color(
                    &render(tier, &scene(shapes)).picture.rgb,
                    &pixels,
                    &format!("{tier}, {what}"),
                )
            };
            let [card, glass] = &shapes;
            let bare = of(&[base], "bare");
            assert_eq!(of(&[card, base], "a card before"), bare);
            assert_eq!(of(&[glass, base], "glass before"), bare);
            let later = of(&[base, card], "a card behind");
            assert!(later[1] > 2 * later[0], "{later:?}");
            let tinted = of(&[base, glass], "glass behind");
            assert!(tinted != bare && tinted[0] > tinted[1], "{tinted:?} {bare:?}");
        }
        let expected = reference_picture(&scene(&[base, &shapes[1]])).rgb;
        color(&expected, &pixels, "glass in the reference");
        let expected = reference_picture(&scene(&[base, &shapes[0]])).rgb;
        assert!(color(&expected, &pixels, "a card in the reference")[1] > 100);
    }
}

#[test]
fn panes_in_a_plane_have_one_order() {
    let [one, two] = [hanging("flat", 0.0), hanging("poster", 0.02)];
    let of_two = inside(&two);
    let pixels: Vec<_> = inside(&one).into_iter().filter(|at| of_two.contains(at)).collect();
    for tier in TIERS {
        let of = |shapes: &[&str]| {
            color(&render(tier, &scene(shapes)).picture.rgb, &pixels, &tier.to_string())
        };
        let [first, second] = [of(&[&one, &two]), of(&[&two, &one])];
        assert!(first[0] > second[0] + 10 && second[1] > first[1] + 10, "{first:?} {second:?}");
    }
}
