//! Waves of water gather light on a floor: those of an open surface and of a body that ends in the floor,
//! against rays in 64 bits.
use super::caustics::{maps, on_floor, refracted};
use crate::common::files::read;
use gobo::{
    glam::{DVec3, Vec3},
    model::Triangle,
    records::caustic_light,
};
use gobo_scene::Scene;
use std::f64::consts::TAU;

const INDEX: f64 = 1.33;
/// Amplitude of waves a metre long [m]: crests focus light at 1.33 / (0.33 k^2 a) = 1.02 m.
const HEIGHT: f64 = 0.1;
/// Floor and half the width of the water [m].
const FLOOR: f64 = -1.0;
const HALF: f64 = 1.0;
/// Light lands as far from its rays as four texels around a point are wide, and half a texel of its own.
const TEXELS: f64 = 2.0;

/// Height and normal of the surface.
fn surface(x: f64) -> (f64, DVec3) {
    let slope = TAU * HEIGHT * (TAU * x).cos();
    (HEIGHT * (TAU * x).sin(), DVec3::new(-slope, 1.0, 0.0).normalize())
}

/// Place and light of rays straight down, evenly over the width.
fn truth() -> Vec<(f64, f64)> {
    const RAYS: usize = 40_000;
    let step = 2.0 * HALF / RAYS as f64;
    let ray = |i: usize| {
        let x = (i as f64 + 0.5) * step - HALF;
        let (height, normal) = surface(x);
        let inside = refracted(DVec3::NEG_Y, normal, 1.0 / INDEX);
        let (cosine, below) = (normal.y, -inside.dot(normal));
        let across = (cosine - INDEX * below) / (cosine + INDEX * below);
        let along = (INDEX * cosine - below) / (INDEX * cosine + below);
        let passes = 1.0 - (across * across + along * along) / 2.0;
        (x + inside.x / inside.y * (FLOOR - height), passes * step)
    };
    (0..RAYS).map(ray).collect()
}

/// Water of a metre's depth over a floor under a sun at noon. `bottom`: height of the lower side of a body.
fn water(bottom: Option<f64>) -> Scene {
    const COLUMNS: u32 = 256;
    let toml = format!(
        "[camera]\neye = [0, 9, 9]\n\
         [[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\nsize = 1024\ncaustics = 2\n\
         [[material]]\nname = 'water'\nior = {INDEX}\n\
         [[material]]\nname = 'ground'\ntransfer = 'opaque'\n\
         [[shape]]\nkind = 'box'\nmaterial = 'ground'\nscale = [2.6, 0.2, 1.4]\ntranslation = [0, {}, 0]\n",
        FLOOR - 0.1
    );
    let mut scene = read(&toml).unwrap_or_else(|error| panic!("{error}"));
    let x = |column: u32| f64::from(column) / f64::from(COLUMNS) * 2.0 * HALF - HALF;
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).as_vec3();
    let mut add = |corners: [Vec3; 4], normals: Option<[Vec3; 2]>| {
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
            let mut face = Triangle::flat([a, b, c].map(|i| corners[i]), 0);
            if let Some([left, right]) = normals {
                face.normals = [a, b, c].map(|i| if i == 0 || i == 1 { left } else { right });
            }
            scene.triangles.push(face);
        }
    };
    for column in 0..COLUMNS {
        let [left, right] = [x(column), x(column + 1)];
        let [(high, normal), (next_high, next_normal)] = [left, right].map(surface);
        let top = [
            corner(left, high, -0.5),
            corner(left, high, 0.5),
            corner(right, next_high, 0.5),
            corner(right, next_high, -0.5),
        ];
        add(top, Some([normal.as_vec3(), next_normal.as_vec3()]));
        let Some(bottom) = bottom else { continue };
        let low = top.map(|corner| Vec3 { y: bottom as f32, ..corner });
        add([low[3], low[2], low[1], low[0]], None);
        add([top[1], low[1], low[2], top[2]], None);
        add([top[3], low[3], low[0], top[0]], None);
        if column == 0 {
            add([top[0], low[0], low[1], top[1]], None);
        }
        if column + 1 == COLUMNS {
            add([top[2], low[2], low[3], top[3]], None);
        }
    }
    scene
}

#[test]
fn waves_gather_light_where_rays_land() {
    const BINS: usize = 40;
    let (truth, edge) = (truth(), 2.0 * HALF / BINS as f64);
    let between = |from: f64, to: f64| -> f64 {
        truth.iter().filter(|(x, _)| (from..to).contains(x)).map(|it| it.1).sum()
    };
    let whole = between(-9.0, 9.0);
    for bottom in [None, Some(FLOOR - 0.05)] {
        for maps in maps(&water(bottom)) {
            let texel = f64::from(1.0 / maps.view.scale);
            let mut bins = [0.0; BINS];
            let mut sum = 0.0;
            for (i, &light) in maps.caustics.iter().enumerate() {
                let light = f64::from(caustic_light(light).y) * texel * texel;
                sum += light;
                let bin = (on_floor(&maps, i).x + HALF) / edge;
                if (0.0..BINS as f64).contains(&bin) {
                    bins[bin as usize] += light;
                }
            }
            assert!((sum / whole - 1.0).abs() < 0.02, "{bottom:?}: {sum} landed, not {whole}");
            for (i, found) in bins.into_iter().enumerate() {
                let (from, to, aside) =
                    (i as f64 * edge - HALF, (i + 1) as f64 * edge - HALF, TEXELS * texel);
                let (least, most) =
                    (between(from + aside, to - aside), between(from - aside, to + aside));
                assert!(
                    (0.98 * least..=1.02 * most).contains(&found),
                    "{bottom:?}: {found} from {from:.2} to {to:.2} m, not {least} to {most}"
                );
            }
            // Bright lines: a crest throws what falls on half a metre into a few bins.
            let brightest = bins.into_iter().fold(0.0, f64::max);
            assert!(brightest > 4.0 * whole / BINS as f64, "{bottom:?}: {brightest} at most");
        }
    }
}
