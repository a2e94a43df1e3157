//! Umbrae under the sun of a file alone: parts behind one another in the light, and narrow rings.
use super::steady::VISIBLE;
use crate::common::{files::Folder, gpu};
use gobo::{
    glam::{EulerRot, Quat, Vec3},
    gpu::Tier,
};
use gobo_picture::{RenderOptions, Renderer};
use std::f32::consts::{PI, TAU};

/// Pixels that may be off by more than [`VISIBLE`].
const FEW: usize = 30;

/// Corners in rows of `columns`, each a round.
struct Part {
    corners: Vec<Vec3>,
    columns: usize,
}

impl Part {
    /// A body of revolution, by its radii and heights.
    fn turned(outline: impl IntoIterator<Item = [f32; 2]>, columns: usize) -> Self {
        let round = |[radius, y]: [f32; 2]| {
            (0..columns).map(move |j| {
                let (sine, cosine) = (TAU * j as f32 / columns as f32).sin_cos();
                Vec3::new(radius * sine, y, radius * cosine)
            })
        };
        Self { corners: outline.into_iter().flat_map(round).collect(), columns }
    }

    /// A tilted ring of 24 mm.
    fn ring(radius: f32, tilt: [f32; 2]) -> Self {
        let outline = (0..=12).map(|i| {
            let (up, out) = (TAU * i as f32 / 12.0).sin_cos();
            [radius + 0.012 * out, 0.012 * up]
        });
        let mut ring = Self::turned(outline, 96);
        let tilt = Quat::from_euler(EulerRot::XYZ, tilt[0], 0.0, tilt[1]);
        ring.corners.iter_mut().for_each(|at| *at = tilt * *at + Vec3::Y * 0.75);
        ring
    }

    /// An object of an OBJ file, after `count` corners.
    fn object(&self, count: usize) -> String {
        let places = self.corners.iter().map(|at| format!("v {} {} {}\n", at.x, at.y, at.z));
        let face = |k: usize| {
            let (i, j) = (k / self.columns, k % self.columns);
            let corner = |i: usize, j: usize| count + 1 + i * self.columns + j % self.columns;
            let [a, b, c, d] = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)];
            let [a, b, c, d] = [a, b, c, d].map(|(i, j)| corner(i, j));
            format!("f {a} {b} {c} {d}\n")
        };
        let faces = (0..self.corners.len() - self.columns).map(face);
        format!("o part{count}\n") + &places.chain(faces).collect::<String>()
    }
}

/// An OBJ file: a ball with three rings around it, on a post and a plinth.
fn globe(tilts: [[f32; 2]; 3]) -> String {
    let ball = (0..=24).map(|i| {
        let (y, radius) = (PI * (i as f32 / 24.0 - 0.5)).sin_cos();
        [0.5 * radius.max(1e-4), 0.75 + 0.5 * y]
    });
    let mut parts = vec![
        Part::turned(ball, 48),
        Part::turned([[0.3, 0.0], [0.3, 0.1]], 48),
        Part::turned([[0.3, 0.1], [1e-4, 0.1]], 48),
        Part::turned([[0.03, 0.1], [0.03, 0.3]], 48),
    ];
    parts.extend(
        [0.62, 0.72, 0.8].into_iter().zip(tilts).map(|(radius, at)| Part::ring(radius, at)),
    );
    let object = |(text, count): (String, usize), part: &Part| {
        (text + &part.object(count), count + part.corners.len())
    };
    parts.iter().fold((String::new(), 0), object).0
}

/// Texels that the default sun chooses are as good as the largest number that a file can state.
#[test]
fn umbrae_are_as_by_the_largest_maps() {
    let folder = Folder::new();
    let path = folder.write("globe.obj", globe([[-0.67, 0.0], [0.23, 0.24], [0.0, 0.62]]));
    let mut renderer = Renderer::on(gpu(Tier::Native)).unwrap();
    let mut picture = |set: &[(&str, &str)]| {
        let set: Vec<_> = set.iter().map(|&(key, value)| (key.into(), value.into())).collect();
        let scene = gobo_scene::load_with(&path, &set).unwrap_or_else(|error| panic!("{error}"));
        let given = scene.soft.first().map(|light| light.size);
        (renderer.render(&scene, &RenderOptions::default()).unwrap().picture.rgb, given)
    };
    let (expected, _) = picture(&[("shadow.size", "4096")]);
    let mut off = |set: &[(&str, &str)]| {
        let (found, given) = picture(set);
        let apart = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|i| a[i].abs_diff(b[i]) > VISIBLE);
        (found.iter().zip(&expected).filter(|&both| apart(both)).count(), given)
    };
    let (usual, given) = off(&[]);
    let (coarse, none) = off(&[("shadow.soft_detail", "false")]);
    println!("{usual} pixels with {given:?} texels, {coarse} with 1,024");
    assert!(usual <= FEW && given > Some(1024), "{usual} pixels with {given:?} texels");
    // The check must notice coarse maps.
    assert!(coarse > 10 * FEW && none.is_none(), "{coarse} pixels");
}
