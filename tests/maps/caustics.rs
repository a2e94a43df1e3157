//! Light refracted by glass: lenses with a known focus, and water, against rays in 64 bits.
use crate::common::{ROOT, Tier, files::read, map_frame};
use gobo::{
    glam::{DVec3, Vec3},
    model::ReceiverPoint,
    records::{ViewMaps, caustic_light},
    view::{atlas::AtlasLimits, picture_views, shadow_views},
};
use gobo_picture::Renderer;
use gobo_reference::render_maps;
use gobo_scene::Scene;
use std::path::Path;

pub(super) const INDEX: f64 = 1.5;

/// Glass over a floor, under a light straight down.
pub(super) fn over_floor(glass: &str, floor: f64, size: u32, rays: u32) -> Scene {
    let toml = format!(
        "[camera]\neye = [0, 9, 9]\n[shadow]\nsize = {size}\n\
         [[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\nsize = {size}\ncaustics = {rays}\n\
         [[material]]\nname = 'glass'\nior = 1.5\n[[shape]]\nmaterial = 'glass'\n{glass}\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [3, 1, 3]\ntranslation = [0, {}, 0]\n",
        -floor
    );
    read(&toml).unwrap_or_else(|error| panic!("{error}"))
}

/// The maps of the only view, by the CPU and by a device.
pub(super) fn maps(scene: &Scene) -> Vec<ViewMaps> {
    let (mut of_cpu, _) = render_maps(scene, &shadow_views(scene));
    let mut of_gpu = map_frame(Tier::Native, scene).maps;
    vec![of_cpu.remove(0), of_gpu.remove(0)]
}

/// Position of a texel's centre on the floor [m].
pub(super) fn on_floor(maps: &ViewMaps, index: usize) -> DVec3 {
    let (view, width) = (&maps.view, maps.view.size.x as usize);
    let texel = [(index % width) as f32, (index / width) as f32].map(|t| t + 0.5);
    let half = view.size.as_vec2() * 0.5;
    let aside = Vec3::new(texel[0] - half.x, half.y - texel[1], 0.0) / view.scale;
    view.view_from_world.inverse().transform_point3(aside).as_dvec3()
}

/// Light that lands by distance from the axis, and the refracted light [m^2].
fn landed(maps: &ViewMaps) -> (Vec<(f64, f64)>, f64) {
    let area = f64::from(maps.view.scale).powi(-2);
    let (mut all, mut thrown) = (Vec::new(), 0.0);
    for (i, &texel) in maps.caustics.iter().enumerate() {
        let light = caustic_light(texel).as_dvec4();
        let at = on_floor(maps, i);
        all.push(((at.x * at.x + at.z * at.z).sqrt(), light.y * area));
        thrown += light.w * f64::from(maps.filter[i][1]) * area;
    }
    (all, thrown)
}

/// Radius that encloses a share of the light.
fn radius_of(mut light: Vec<(f64, f64)>, share: f64) -> f64 {
    light.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = light.iter().map(|it| it.1).sum();
    let mut sum = 0.0;
    for (radius, part) in light {
        sum += part;
        if sum >= share * whole {
            return radius;
        }
    }
    f64::INFINITY
}

pub(super) fn refracted(ray: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let cosine = -ray.dot(normal);
    let inside = (1.0 - ratio * ratio * (1.0 - cosine * cosine)).sqrt();
    ray * ratio + normal * (ratio * cosine - inside)
}

/// Transmittance of a face.
pub(super) fn face(cosine: f64) -> f64 {
    let inside = (1.0 - (1.0 - cosine * cosine) / (INDEX * INDEX)).sqrt();
    let across = (cosine - INDEX * inside) / (cosine + INDEX * inside);
    let along = (INDEX * cosine - inside) / (INDEX * cosine + inside);
    1.0 - (across * across + along * along) / 2.0
}

/// Rays straight down through an ellipsoid of a half width and a half height, to a floor: distance from the
/// axis, NaN at total internal reflection, and light.
fn through_ellipsoid(wide: f64, high: f64, floor: f64) -> Vec<(f64, f64)> {
    const RAYS: usize = 4000;
    let normal = |p: DVec3| {
        DVec3::new(p.x / (wide * wide), p.y / (high * high), p.z / (wide * wide)).normalize()
    };
    let step = wide / RAYS as f64;
    let ray = |i: usize| {
        let x = (i as f64 + 0.5) * step;
        let start = DVec3::new(x, high * (1.0 - x * x / (wide * wide)).sqrt(), 0.0);
        let inside = refracted(DVec3::NEG_Y, normal(start), 1.0 / INDEX);
        let (from, along) =
            (start / DVec3::new(wide, high, wide), inside / DVec3::new(wide, high, wide));
        let way = -2.0 * from.dot(along) / along.length_squared();
        let end = start + inside * way;
        let outside = refracted(inside, -normal(end), INDEX);
        let at = end + outside * ((-floor - end.y) / outside.y);
        let passes = face(normal(start).y).powi(2);
        (at.x.abs(), passes * std::f64::consts::TAU * x * step)
    };
    (0..RAYS).map(ray).collect()
}

/// A flat lens and a ball, at their focus and elsewhere: all transmitted light lands, at the rays' positions.
#[test]
fn lenses_throw_light_where_rays_land() {
    // The lens: radii of curvature of 2.5 m, so a focus at 2.5 m. The ball: at 0.75 m from its middle.
    for (wide, high, floor, texels) in
        [(0.5, 0.1, 2.45, 2.0), (0.5, 0.1, 1.2, 1.5), (0.5, 0.5, 0.75, 2.0), (0.5, 0.5, 1.1, 2.0)]
    {
        let shape =
            format!("kind = 'sphere'\nlevel = 6\nscale = [{0}, {1}, {0}]", 2.0 * wide, 2.0 * high);
        let scene = over_floor(&shape, floor, 512, 2);
        let all = through_ellipsoid(wide, high, floor);
        let whole: f64 = all.iter().map(|it| it.1).sum();
        let truth: Vec<_> = all.into_iter().filter(|it| it.0 < 1.5).collect();
        let landing: f64 = truth.iter().map(|it| it.1).sum();
        for maps in maps(&scene) {
            let (light, thrown) = landed(&maps);
            let sum: f64 = light.iter().map(|it| it.1).sum();
            let what = format!("{wide} x {high} over {floor}");
            assert!((thrown / whole - 1.0).abs() < 0.02, "{what}: {thrown} thrown of {whole}");
            assert!((sum / landing - 1.0).abs() < 0.02, "{what}: {sum} landed, not {landing}");
            let texel = f64::from(1.0 / maps.view.scale);
            for share in [0.3, 0.6, 0.9] {
                let (found, wanted) =
                    (radius_of(light.clone(), share), radius_of(truth.clone(), share));
                assert!(
                    (found - wanted).abs() < texels * texel + 0.05 * wanted,
                    "{what}: {share} within {found}, not {wanted}"
                );
            }
        }
    }
}

/// The light of the floor is moved: the sum found by `light_points` equals the light that arrives less the
/// glass's reflection.
#[test]
fn light_is_moved_and_not_added() {
    let scene = over_floor("kind = 'sphere'\nlevel = 6\nscale = [1, 0.2, 1]", 2.45, 256, 3);
    let rays = through_ellipsoid(0.5, 0.1, 2.45).into_iter().filter(|it| it.0 < 1.45);
    let lands: f64 = rays.map(|it| it.1).sum();
    let silhouette = std::f64::consts::PI * 0.25;
    let (edge, count) = (2.9, 290);
    let place = |i: usize| (i as f64 + 0.5) / count as f64 * edge - 0.5 * edge;
    let point = |i: usize| ReceiverPoint {
        position: DVec3::new(place(i % count), -2.45, place(i / count)).as_vec3(),
        normal: Vec3::Y,
    };
    let points: Vec<_> = (0..count * count).map(point).collect();
    for mut renderer in renderers() {
        let light = renderer.light_points(&scene, &points).unwrap();
        let sum: f64 = light.iter().map(|it| f64::from(it[1])).sum();
        let found = sum * (edge / count as f64).powi(2);
        let wanted = edge * edge - silhouette + lands;
        let apart = (found - wanted).abs() / lands;
        assert!(apart < 0.02, "{found} arrives, not {wanted}");
        let at =
            |x: f32, y: f32| ReceiverPoint { position: Vec3::new(x, y, 0.0), normal: Vec3::ZERO };
        let places = [at(0.0, -2.45), at(0.4, -2.45), at(1.3, -2.45), at(0.2, -1.0)];
        let [focus, shadow, open, between] = renderer.light_points(&scene, &places).unwrap()[..]
        else {
            unreachable!()
        };
        assert!(focus[1] > 50.0, "{focus:?} at the focus");
        // By rays in 64 bits, between 0.39 and 0.41 m from the axis.
        assert!((shadow[1] - 0.137).abs() < 0.02, "{shadow:?} beside the focus");
        assert!((open[1] - 1.0).abs() < 0.02, "{open:?} beside the lens");
        // Between the lens and the floor light goes straight.
        assert!((between[1] - 0.92).abs() < 0.02, "{between:?} above the floor");
    }
}

/// A renderer on the CPU, and one on a device.
pub(super) fn renderers() -> [Renderer; 2] {
    [Renderer::on_cpu(), crate::common::renderer(Tier::Native)]
}

/// A sheet of water under slanted light refracts it by Snell's law; coloured water colours it.
#[test]
fn water_bends_light_once() {
    let toml = "[camera]\neye = [0, 9, 9]\n\
         [[light]]\nkind = 'directional'\ndirection = [1, -1, 0]\nsize = 512\ncaustics = 2\n\
         [[material]]\nname = 'water'\ntint = [0.5, 1, 0.25, 1]\nior = 1.33\n\
         [[shape]]\nmaterial = 'water'\nkind = 'plane'\ntranslation = [-1, 1, 0]\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'plane'\nmaterial = 'ground'\nscale = [5, 1, 5]\n";
    let scene = read(toml).unwrap_or_else(|error| panic!("{error}"));
    let sine = 0.5f64.sqrt() / 1.33;
    let middle = -1.0 + sine / (1.0 - sine * sine).sqrt();
    for maps in maps(&scene) {
        let (mut sum, mut place, mut thrown) = (DVec3::ZERO, 0.0, 0.0);
        let inverse = maps.view.view_from_world.inverse();
        for (i, &texel) in maps.caustics.iter().enumerate() {
            let light = caustic_light(texel).as_dvec4();
            // Along the light to the floor.
            let at = on_floor(&maps, i);
            let ray = inverse.transform_vector3(Vec3::NEG_Z).as_dvec3();
            let x = (at + ray * (-at.y / ray.y)).x;
            sum += light.truncate();
            place += light.y * x;
            thrown += light.w * f64::from(maps.filter[i][1]);
        }
        assert!((sum.y / thrown - 1.0).abs() < 0.01, "{sum} of {thrown}");
        assert!((place / sum.y - middle).abs() < 0.01, "around {}, not {middle}", place / sum.y);
        let color = sum / sum.y;
        assert!((color - DVec3::new(0.5, 1.0, 0.25)).length() < 2e-3, "{color}");
    }
}

/// Bits depend neither on the run nor on other outputs.
#[test]
fn caustics_are_the_same_each_time_and_off_by_default() {
    let ball = "kind = 'sphere'\nlevel = 4";
    let scene = over_floor(ball, 1.0, 128, 2);
    let mut straight = over_floor(ball, 1.0, 128, 0);
    // Lights that throw nothing have windows, too.
    straight.shadow.detail = false;
    for (first, second) in maps(&scene).into_iter().zip(maps(&scene)) {
        assert_eq!(first.caustics, second.caustics);
        assert_eq!(first.caustics.len(), 128 * 128);
    }
    for (plain, thrown) in maps(&straight).into_iter().zip(maps(&scene)) {
        assert!(plain.caustics.is_empty());
        assert!(plain.filter == thrown.filter && plain.opaque == thrown.opaque);
    }
}

#[test]
fn lights_that_throw_nothing_are_refused() {
    let error = |keys: &str| {
        let text = format!("[[light]]\ncaustics = 2\n{keys}\n");
        read(&text).unwrap_err().to_string()
    };
    let down = "kind = 'directional'\ndirection = [0, -1, 0]";
    let lamp = "kind = 'point'\nposition = [0, 1, 0]";
    for (keys, words) in [
        (format!("{down}\nsource = {{ kind = 'sun' }}"), "source elsewhere"),
        (format!("{down}\ncasts = false"), "casts no shadow"),
        (format!("{down}\nsize = 4096"), "2048"),
        (format!("{lamp}\nsize = 2048"), "1024"),
        (format!("{down}\n[[light.shadow]]\ndirection = [0, -1, 0.1]"), "further shadow"),
    ] {
        assert!(error(&keys).contains(words), "{}", error(&keys));
    }
    for keys in [lamp.to_owned(), format!("{down}\ncascades = 3")] {
        let text = format!("[[light]]\ncaustics = 2\n{keys}\n");
        assert_eq!(read(&text).unwrap().lights[0].caustics, 2);
    }
    let glass = |keys: &str| {
        let text = format!("[[material]]\nname = 'glass'\n{keys}\n");
        read(&text).unwrap_err().to_string()
    };
    assert!(glass("dispersion = 1").contains("does not refract"));
    assert!(glass("ior = 1.5\ndispersion = 21").contains("dispersion"));
}

/// A window of finer texels lacks what glass outside of it throws into it: caustics would end at its border.
#[test]
fn lights_with_caustics_have_no_finer_maps() {
    let mut scene = gobo_scene::load(&Path::new(ROOT).join("data/lens.toml")).unwrap();
    let windows = |scene: &Scene| {
        let (views, _) = picture_views(scene, &AtlasLimits::CORE);
        views.iter().filter(|view| view.is_detail()).count()
    };
    assert_eq!(windows(&scene), 0);
    scene.lights[0].caustics = 0;
    assert_ne!(windows(&scene), 0);
}
