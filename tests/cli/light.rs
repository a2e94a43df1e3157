//! `gobo light`: points in, shares of lights out.
use super::commands::{Folder, npy};
use std::fs;

/// An array in the format of `numpy`.
pub(super) fn array(kind: &str, columns: usize, bytes: &[u8]) -> Vec<u8> {
    let size = if kind == "<f8" { 8 } else { 4 };
    let shape = (bytes.len() / size / columns, columns);
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape:?}, }}");
    let mut file = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    file.extend(format!("{header:<117}\n").into_bytes());
    file.extend(bytes);
    file
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Points over the glass, under it, on the floor under it, under the floor, and outside of everything.
const POINTS: [f32; 30] = [
    0.1, 1.2, 0.1, 0.0, 0.0, 0.0, //
    0.1, 0.5, 0.1, 0.0, 0.0, 0.0, //
    0.1, 0.0, 0.1, 0.0, 1.0, 0.0, //
    0.1, -0.5, 0.1, 0.0, 0.0, 0.0, //
    1.5, 0.5, 1.5, 0.0, 0.0, 0.0, //
];

#[test]
fn shares_are_as_paper_says() {
    let folder = Folder::new("light");
    fs::write(folder.0.join("p.npy"), array("<f4", 6, &floats(&POINTS))).unwrap();
    // A half covers of (1, 0.2, 0.1).
    let behind = [1.0, 0.6, 0.55];
    let expected = [[1.0; 3], behind, behind, [0.0; 3], [1.0; 3]];
    for backend in ["auto", "cpu"] {
        let arguments =
            ["light", "scene.toml", "--points", "p.npy", "-o", "l.npy", "--backend", backend];
        assert_eq!(folder.run(&arguments), "l.npy\n");
        let (shape, shares) = npy(&folder.0.join("l.npy")).unwrap();
        assert_eq!(shape, [5, 2, 3], "points, lights, channels");
        for (i, share) in shares.iter().enumerate() {
            let apart = (share - expected[i / 6][i % 3]).abs();
            assert!(apart <= 1e-3, "{backend} {i}: {share}");
        }
    }
    // The lamp moves below the glass; positions alone are enough.
    fs::write(folder.0.join("p.npy"), array("<f4", 3, &floats(&[0.1, 0.3, 0.1]))).unwrap();
    let moved = ["--backend", "cpu", "--set", "light.lamp.position=[0,0.5,0]"];
    let light = ["light", "scene.toml", "--points", "p.npy", "-o", "l.npy"];
    folder.run(&[&light[..], &moved].concat());
    let (shape, shares) = npy(&folder.0.join("l.npy")).unwrap();
    assert_eq!(shape, [1, 2, 3]);
    assert!((shares[1] - 0.6).abs() <= 1e-3 && (shares[4] - 1.0).abs() <= 1e-3, "{shares:?}");
}

/// A scene far from the origin is re-centred, and its points too.
#[test]
fn points_of_a_scene_far_away_are_in_the_world() {
    let folder = Folder::new("light-far");
    let scene = "[shadow]\nsize = 64\n[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\n\
                 [[material]]\nname = \"gel\"\ntint = [1, 0.5, 0.25, 1]\n\
                 [[shape]]\nkind = \"plane\"\nmaterial = \"gel\"\ntranslation = [16384, 1, 0]\n";
    fs::write(folder.0.join("far.toml"), scene).unwrap();
    let points = [16384.125, 0.5, 0.125, 16384.125, 1.5, 0.125];
    fs::write(folder.0.join("p.npy"), array("<f4", 3, &floats(&points))).unwrap();
    for backend in ["auto", "cpu"] {
        folder.run(&[
            "light",
            "far.toml",
            "--points",
            "p.npy",
            "-o",
            "l.npy",
            "--backend",
            backend,
        ]);
        let (_, shares) = npy(&folder.0.join("l.npy")).unwrap();
        let expected = [1.0, 0.5, 0.25, 1.0, 1.0, 1.0];
        let near = |(a, b): (&f32, f32)| (a - b).abs() <= 1e-3;
        assert!(shares.iter().zip(expected).all(near), "{backend}: {shares:?}");
    }
}

#[test]
fn points_that_are_none_are_refused() {
    let folder = Folder::new("light-bad");
    let refused = |points: Option<Vec<u8>>| {
        let path = folder.0.join("p.npy");
        let _ = fs::remove_file(&path);
        if let Some(bytes) = points {
            fs::write(path, bytes).unwrap();
        }
        let error = folder.fail(&["light", "scene.toml", "--points", "p.npy", "-o", "l.npy"], 2);
        assert!(error.contains("p.npy: ") && error.contains("help: "), "{error}");
        assert!(!folder.0.join("l.npy").exists());
        error
    };
    assert!(refused(None).contains("No such file"));
    let mut later = array("<f4", 3, &floats(&[0.0; 6]));
    later[6] = 9;
    assert!(refused(Some(later)).contains("its format is 9.0"));
    assert!(refused(Some(b"x y z\n".to_vec())).contains("numpy.save"));
    assert!(refused(Some(array("<f8", 3, &[0; 24]))).contains("astype"));
    assert!(refused(Some(array("<f4", 2, &floats(&[0.0; 4])))).contains("N x 3"));
    let nan = refused(Some(array("<f4", 3, &floats(&[0.0, 0.0, 0.0, 1.0, f32::NAN, 2.0]))));
    assert!(nan.contains("row 1 "), "{nan}");
    let mut cut = array("<f4", 3, &floats(&[0.0; 6]));
    cut.truncate(cut.len() - 1);
    assert!(refused(Some(cut)).contains("its shape [2, 3]"));
    fs::write(folder.0.join("p.npy"), array("<f4", 3, &[])).unwrap();
    folder.run(&["light", "scene.toml", "--points", "p.npy", "-o", "l.npy"]);
    assert_eq!(npy(&folder.0.join("l.npy")).unwrap(), (vec![0, 2, 3], vec![]));
}

/// Under an area light the map gives the surface, and there is no warning.
#[test]
fn points_on_a_surface_need_no_normal() {
    let folder = Folder::new("light-normals");
    // Slanted light: a floor without a slope would shadow itself.
    let soft = [
        "light.lamp.source={ kind = \"sphere\", radius = 0.1 }",
        "light.lamp.position=[1.5, 1.2, 0]",
        "light.lamp.size=64",
    ];
    let places = (0..144).map(|i: u8| [i % 12, i / 12].map(|v| f32::from(v) * 0.15 - 0.8));
    let points = |columns: usize| -> Vec<f32> {
        let row = |[x, z]: [f32; 2]| [x, 0.0, z, 0.0, 1.0, 0.0][..columns].to_vec();
        places.clone().flat_map(row).collect()
    };
    for backend in ["auto", "cpu"] {
        let [bare, with] = [3, 6].map(|columns| {
            fs::write(folder.0.join("p.npy"), array("<f4", columns, &floats(&points(columns))))
                .unwrap();
            let light = ["light", "scene.toml", "--points", "p.npy", "-o", "l.npy"];
            let set = soft.iter().flat_map(|value| ["--set", value]);
            let all: Vec<_> = light.into_iter().chain(["--backend", backend]).chain(set).collect();
            let output = folder.gobo(&all);
            let told = String::from_utf8(output.stderr).unwrap();
            assert!(output.status.success() && !told.contains("normal"), "{told}");
            npy(&folder.0.join("l.npy")).unwrap().1
        });
        let of_lamp = |i: &usize| i % 6 < 3;
        let apart = (0..bare.len()).filter(of_lamp).map(|i| (bare[i] - with[i]).abs());
        let mean = apart.sum::<f32>() / (3 * 144) as f32;
        assert!(mean < 0.002, "{backend}: {mean}");
        let shaded = (0..bare.len()).filter(of_lamp).filter(|&i| bare[i] < 0.9).count();
        assert!((20..400).contains(&shaded), "{backend}: {shaded}");
    }
}
