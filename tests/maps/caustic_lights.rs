//! Light refracted by glass in the maps of lamps and in cascades, by channel, and evenly, against rays in 64
//! bits.
use super::caustics::{INDEX, face, maps, on_floor, over_floor, refracted, renderers};
use crate::common::{Tier, files::read, map_frame};
use gobo::{
    glam::{DVec2, DVec3, Vec3},
    model::{Cascades, ReceiverPoint},
    records::caustic_light,
    view::shadow_views,
};
use gobo_reference::render_maps;

/// A sheet of glass that disperses light refracts each channel by its own index: an Abbe number of 2 here,
/// far below that of real glass.
#[test]
fn dispersed_light_lands_by_channel() {
    let toml = "[camera]\neye = [0, 9, 9]\n\
         [[light]]\nkind = 'directional'\ndirection = [1, -1, 0]\nsize = 512\ncaustics = 2\n\
         [[material]]\nname = 'water'\nior = 1.5\ndispersion = 10\n\
         [[shape]]\nmaterial = 'water'\nkind = 'plane'\ntranslation = [-1, 1, 0]\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [5, 1, 5]\n";
    let scene = read(toml).unwrap_or_else(|error| panic!("{error}"));
    // Abbe: V = (n - 1) / (n_blue - n_red).
    let half = (1.5 - 1.0) / 2.0 / 2.0;
    let wanted = [1.5 - half, 1.5, 1.5 + half].map(|index: f64| {
        let sine = 0.5f64.sqrt() / index;
        -1.0 + sine / (1.0 - sine * sine).sqrt()
    });
    for maps in maps(&scene) {
        let (mut sum, mut place) = (DVec3::ZERO, DVec3::ZERO);
        let inverse = maps.view.view_from_world.inverse();
        let ray = inverse.transform_vector3(Vec3::NEG_Z).as_dvec3();
        for (i, &texel) in maps.caustics.iter().enumerate() {
            let light = caustic_light(texel).as_dvec4().truncate();
            let at = on_floor(&maps, i);
            sum += light;
            place += light * (at + ray * (-at.y / ray.y)).x;
        }
        let found = place / sum;
        assert!((found - DVec3::from_array(wanted)).abs().max_element() < 0.01, "{found}");
        assert!((sum / sum.y - 1.0).abs().max_element() < 0.01, "{sum}");
    }
}

/// Light in the air, and a ball seen through the edge between two faces of a lamp's cube: light lands as rays
/// in 64 bits do, also in the other face.
#[test]
fn a_lamp_throws_light_across_the_faces_of_its_cube() {
    const RADIUS: f64 = 0.3;
    let (lamp, ball) = (DVec3::new(0.0, 1.6, 0.0), DVec3::new(1.0, 0.6, 0.0));
    let scene = read(
        "[camera]\neye = [0, 9, 9]\n\
         [[light]]\nkind = 'point'\nposition = [0, 1.6, 0]\nsize = 256\ncaustics = 2\n\
         [[material]]\nname = 'glass'\nior = 1.5\n[[shape]]\nmaterial = 'glass'\nkind = 'sphere'\n\
         level = 5\nscale = [0.6, 0.6, 0.6]\ntranslation = [1, 0.6, 0]\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [12, 1, 12]\n",
    )
    .unwrap_or_else(|error| panic!("{error}"));
    // Rays around the ball's middle, evenly in solid angle.
    let axis = (ball - lamp).normalize();
    let (right, up) = axis.any_orthonormal_pair();
    let distance = (ball - lamp).length();
    let least = (1.0 - (RADIUS / distance).powi(2)).sqrt();
    let (turns, rings) = (256, 400);
    let (mut whole, mut landing, mut middle) = (0.0, 0.0, DVec3::ZERO);
    for i in 0..turns * rings {
        let cosine = 1.0 - (1.0 - least) * (f64::from(i / turns) + 0.5) / f64::from(rings);
        let angle = std::f64::consts::TAU * (f64::from(i % turns) + 0.5) / f64::from(turns);
        let sine = (1.0 - cosine * cosine).sqrt();
        let ray = axis * cosine + (right * angle.cos() + up * angle.sin()) * sine;
        let part = std::f64::consts::TAU * (1.0 - least) / f64::from(turns * rings);
        let to = (ball - lamp).dot(ray);
        let start = lamp + ray * (to - (RADIUS * RADIUS - distance * distance + to * to).sqrt());
        let normal = (start - ball) / RADIUS;
        let light = part * face(-ray.dot(normal)).powi(2);
        let inside = refracted(ray, normal, 1.0 / INDEX);
        let end = start + inside * (-2.0 * (start - ball).dot(inside));
        let outside = refracted(inside, (ball - end) / RADIUS, INDEX);
        whole += light;
        let at = end - outside * (end.y / outside.y);
        if outside.y < 0.0 && at.abs().max_element() < 6.0 {
            landing += light;
            middle += at * light;
        }
    }
    middle /= landing;
    let (of_cpu, _) = render_maps(&scene, &shadow_views(&scene));
    for maps in [of_cpu, map_frame(Tier::Native, &scene).maps] {
        let (mut thrown, mut sum, mut place) = (0.0, 0.0, DVec3::ZERO);
        let mut faces = 0;
        for maps in &maps {
            let (scale, size) = (f64::from(maps.view.scale), maps.view.size.as_dvec2());
            let back = maps.view.view_from_world.inverse();
            let before = sum;
            for (i, &texel) in maps.caustics.iter().enumerate() {
                let width = size.x as usize;
                let texel_at = DVec2::new((i % width) as f64, (i / width) as f64) + 0.5;
                let slope = (texel_at - size * 0.5) / scale;
                let solid = (1.0 + slope.length_squared()).powf(-1.5) / (scale * scale);
                let light = caustic_light(texel).as_dvec4();
                thrown += light.w * f64::from(maps.filter[i][1]) * solid;
                let ray = DVec3::new(slope.x, -slope.y, -1.0);
                let ray = back.transform_vector3(ray.as_vec3()).as_dvec3();
                if light.y > 0.0 {
                    sum += light.y * solid;
                    place += (lamp - ray * (lamp.y / ray.y)) * light.y * solid;
                }
            }
            faces += usize::from(sum > before + 0.02 * landing);
        }
        place /= sum;
        assert!((thrown / whole - 1.0).abs() < 0.02, "{thrown} thrown of {whole}");
        assert!((sum / landing - 1.0).abs() < 0.02, "{sum} landed, not {landing}");
        assert!((place - middle).length() < 0.02, "around {place}, not {middle}");
        assert_eq!(faces, 2, "faces of the cube where light lands");
    }
}

/// Light that the sun throws is the same in cascades as in one map.
#[test]
fn cascades_throw_the_light_of_one_map() {
    let ball = "kind = 'sphere'\nlevel = 5\nscale = [1, 0.4, 1]";
    let one = over_floor(ball, 1.1, 512, 2);
    let mut cascaded = one.clone();
    cascaded.lights[0].cascades = Some(Cascades { count: 3, ..Cascades::default() });
    cascaded.camera.eye = Vec3::new(0.0, 2.0, 3.0);
    cascaded.camera.target = Vec3::new(0.0, -1.0, 0.0);
    let (edge, count) = (1.6, 160);
    let place = |i: usize| (i as f64 + 0.5) / count as f64 * edge - 0.5 * edge;
    let point = |i: usize| ReceiverPoint {
        position: DVec3::new(place(i % count), -1.1, place(i / count)).as_vec3(),
        normal: Vec3::Y,
    };
    let points: Vec<_> = (0..count * count).map(point).collect();
    for mut renderer in renderers() {
        let sum = |light: Vec<[f32; 3]>| light.iter().map(|it| f64::from(it[1])).sum::<f64>();
        let wanted = sum(renderer.light_points(&one, &points).unwrap());
        let found = sum(renderer.light_points(&cascaded, &points).unwrap());
        assert!((found / wanted - 1.0).abs() < 0.02, "{found} arrives, not {wanted}");
        let middle = ReceiverPoint { position: Vec3::new(0.0, -1.1, 0.0), normal: Vec3::Y };
        let focus = renderer.light_points(&cascaded, &[middle]).unwrap()[0];
        assert!(focus[1] > 2.0, "{focus:?} below the middle");
    }
}

/// Where a ball spreads light it is smooth, with one ray a texel.
#[test]
fn spread_light_has_no_speckle() {
    let scene = over_floor("kind = 'sphere'\nlevel = 6", 1.1, 256, 1);
    for maps in maps(&scene) {
        let scale = f64::from(maps.view.scale);
        let in_ring = |i: &usize| {
            let at = on_floor(&maps, *i);
            (0.42..0.46).contains(&(at.x * at.x + at.z * at.z).sqrt())
        };
        let ring = (0..maps.caustics.len()).filter(in_ring);
        let light: Vec<f64> = ring.map(|i| f64::from(caustic_light(maps.caustics[i]).y)).collect();
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        let apart = light.iter().map(|it| (it / mean - 1.0).powi(2)).sum::<f64>();
        let deviation = (apart / light.len() as f64).sqrt();
        assert!(light.len() > 50 && mean > 0.0, "{} texels of {scale} a metre", light.len());
        // The mean of rays in 64 bits; without footprints most of these texels are dark.
        assert!((mean / 0.2076 - 1.0).abs() < 0.03, "{mean} in a ring");
        assert!(deviation < 0.4, "texels of a ring deviate by {deviation} of their mean {mean}");
    }
}
