//! Files of dense arrays: each voxel has the file's value, at its place.
use crate::common::{
    arrays::{
        KINDS, Kind, SIZE, Vti, bytes_of, gzip, meta, meta_head, nifti, npy, npy_of, npz, nrrd,
        nrrd_of, tiff, value, values, vti, zlib,
    },
    files::Folder,
    scenes::Chance,
};
use gobo::{
    glam::{IVec3, Vec3},
    model::{Brick, Density, Grid},
};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

/// A scene of a file with a meaningless name.
fn load(bytes: &[u8], keys: &str) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    folder.write("some.file", bytes);
    scene::load(&folder.write("scene.toml", format!("[[volume]]\nfile = \"some.file\"\n{keys}")))
}

fn refusal(bytes: &[u8], keys: &str) -> String {
    match load(bytes, keys) {
        Err(SceneError::Document { message, help, .. }) => {
            format!("{message}; {}", help.expect("a remedy"))
        }
        other => panic!("{other:?}"),
    }
}

pub(super) fn density(grid: &Grid, voxel: IVec3) -> f32 {
    let has = |brick: &&Brick| {
        let own = voxel - brick.origin;
        own.cmpge(IVec3::ZERO).all() && own.cmplt(brick.size().as_ivec3()).all()
    };
    grid.bricks.iter().find(has).map_or(0.0, |brick| match &brick.density {
        Density::Constant { density, .. } => *density,
        Density::Voxels(voxels) => voxels.at((voxel - brick.origin).as_uvec3()),
    }) * grid.factor
}

/// All voxels around and in the array.
fn voxels() -> impl Iterator<Item = IVec3> {
    let [width, height, depth] = SIZE.map(|size| size as i32 + 2);
    (0..width * height * depth)
        .map(move |i| IVec3::new(i % width - 1, i / width % height - 1, i / (width * height) - 1))
}

fn expected(voxel: IVec3) -> f32 {
    let size = IVec3::from_array(SIZE.map(|size| size as i32));
    let is_within = voxel.cmpge(IVec3::ZERO).all() && voxel.cmplt(size).all();
    if is_within { value(voxel.to_array().map(|at| at as usize)) as f32 } else { 0.0 }
}

/// All voxels of a grid equal the formula.
fn assert_values(scene: &Scene, what: &str) {
    assert_eq!(scene.grids.len(), 1, "{what}");
    for voxel in voxels() {
        assert_eq!(density(&scene.grids[0], voxel), expected(voxel), "{what}, {voxel}");
    }
    assert!(scene.skipped.is_empty(), "{what}: {:?}", scene.skipped);
}

/// Checks the world positions of voxels.
fn assert_places(scene: &Scene, places: &[([f32; 3], [f32; 3])], what: &str) {
    for &(voxel, place) in places {
        let found = scene.grids[0].world_from_index.transform_point3(Vec3::from(voxel));
        let most = 1e-5 * Vec3::from(place).length().max(1e-6);
        assert!((found - Vec3::from(place)).length() <= most, "{what}: {found}, {place:?}");
    }
}

#[test]
fn arrays_of_numpy_are_read_in_every_order() {
    for kind in KINDS {
        for (is_big, is_fortran) in [(false, false), (true, false), (false, true), (true, true)] {
            let what = format!("{kind:?}, {is_big}, {is_fortran}");
            let array = npy(kind, is_big, is_fortran);
            let scene = load(&array, "").unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_values(&scene, &what);
            assert_places(
                &scene,
                &[([0.0; 3], [0.0; 3]), ([3.0, 2.0, 1.0], [3.0, 2.0, 1.0])],
                &what,
            );
            if !is_big {
                let arrays = [("other", npy_of("<f8", false, "1", &[0; 8])), ("density", array)];
                for is_packed in [false, true] {
                    assert_values(&load(&npz(&arrays, is_packed), "").unwrap(), "npz");
                }
            }
        }
    }
    // A named array, and missing ones.
    let archive = npz(&[("heat", npy(Kind::F32, false, false))], true);
    assert_values(&load(&archive, "density = { grid = \"heat\" }").unwrap(), "named");
    let message = refusal(&archive, "density = { grid = \"hat\" }");
    assert!(message.contains("no array `hat`; did you mean `heat`"), "{message}");
}

#[test]
fn nrrd_is_read_in_every_encoding() {
    for kind in KINDS.into_iter().filter(|&kind| kind != Kind::F16) {
        for is_big in [false, true] {
            for encoding in ["raw", "gzip", "ascii"] {
                let what = format!("{kind:?}, {is_big}, {encoding}");
                let scene = load(&nrrd(kind, is_big, encoding), "");
                assert_values(&scene.unwrap_or_else(|e| panic!("{what}: {e}")), &what);
            }
        }
    }
    let data = bytes_of(Kind::U8, false, &values());
    let raw = "encoding: raw\n";
    // The columns are directions, x first; then spacings alone; then a body, which stands, faces +z, and is
    // in millimetres.
    let turned =
        "space dimension: 3\nspace directions: (0,2,0) (0,0,3) (4,0,0)\nspace origin: (7,8,9)\n";
    let spaced = "spacings: 2 3 4\n";
    let body = |space: &str| {
        format!(
            "space: {space}\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (7,8,9)\n"
        )
    };
    let microns = "spacings: 2 3 4\nspace dimension: 3\nspace units: \"um\" \"um\" \"um\"\n";
    for (fields, at_zero, at_one) in [
        (turned.to_owned(), [7.0, 8.0, 9.0], [11.0, 10.0, 12.0]),
        (spaced.to_owned(), [0.0; 3], [2.0, 3.0, 4.0]),
        (microns.to_owned(), [0.0; 3], [2e-6, 3e-6, 4e-6]),
        (body("left-posterior-superior"), [7e-3, 9e-3, -8e-3], [9e-3, 13e-3, -11e-3]),
        (body("RAS"), [-7e-3, 9e-3, 8e-3], [-9e-3, 13e-3, 11e-3]),
    ] {
        let scene = load(&nrrd_of("uchar", &(fields.clone() + raw), &data), "").unwrap();
        assert_values(&scene, &fields);
        assert_places(&scene, &[([0.0; 3], at_zero), ([1.0; 3], at_one)], &fields);
    }
    // Keys of the scene override the file.
    let file = nrrd_of("uchar", &(body("RAS") + raw), &data);
    let scene = load(&file, "unit = \"cm\"\nup = \"z\"\n").unwrap();
    assert_places(&scene, &[([1.0; 3], [0.09, 0.13, -0.11])], "keys");
    // Data in another file, after two lines and three bytes.
    let folder = Folder::new();
    folder.write("data.raw", [b"one\ntwo\nabc".as_slice(), &data].concat());
    let fields = format!("{raw}line skip: 2\nbyte skip: 3\ndata file: data.raw\n");
    folder.write("head.nhdr", nrrd_of("uchar", &fields, &[]));
    let path = folder.write("scene.toml", "[[volume]]\nfile = \"head.nhdr\"\n");
    assert_values(&scene::load(&path).unwrap(), "beside");
    let files = scene::files(&path).unwrap();
    assert!(files.iter().any(|file| file.ends_with("data.raw")), "{files:?}");
    for (name, says) in [
        ("../data.raw", "its data are in"),
        ("/etc/passwd", "its data are in"),
        ("no.raw", "no.raw"),
        ("LIST", "several files"),
    ] {
        let fields = format!("{raw}data file: {name}\n");
        let message = refusal(&nrrd_of("uchar", &fields, &[]), "");
        assert!(message.contains(says), "{name}: {message}");
    }
}

#[test]
fn image_data_of_vtk_is_read_in_every_way() {
    let packers = [None, Some("vtkZLibDataCompressor"), Some("vtkLZ4DataCompressor")];
    for kind in KINDS.into_iter().filter(|&kind| kind != Kind::F16) {
        for is_big in [false, true] {
            for way in [Vti::Ascii, Vti::Inline, Vti::Appended, Vti::Raw] {
                for packer in packers {
                    let what = format!("{kind:?}, {is_big}, {way:?}, {packer:?}");
                    let scene = load(&vti(kind, is_big, way, packer), "");
                    let scene = scene.unwrap_or_else(|e| panic!("{what}: {e}"));
                    assert_values(&scene, &what);
                    // The first point is at 2, 0, 1, with spacings 0.5, 2, 4, rotated by 90 degrees about z.
                    let places = [([0.0; 3], [1.0, 3.0, 7.0]), ([1.0; 3], [-1.0, 3.5, 11.0])];
                    assert_places(&scene, &places, &what);
                }
            }
        }
    }
    // Cells have their centres half a spacing later.
    let text = String::from_utf8(vti(Kind::U8, false, Vti::Ascii, None)).unwrap();
    let cells = text
        .replace("<PointData Scalars=\"s\">", "<CellData>")
        .replace("</PointData>\n<CellData>", "");
    let cells = cells.replace("2 11 0 3 1 3", "2 12 0 4 1 4");
    let scene = load(cells.as_bytes(), "density = { grid = \"s\" }").unwrap();
    assert_values(&scene, "cells");
    assert_places(&scene, &[([0.0; 3], [0.0, 3.25, 9.0])], "cells");
}

#[test]
fn nifti_is_read_with_its_scale_and_its_turn() {
    // Stored values reach 236.
    for kind in KINDS.into_iter().filter(|kind| {
        ![Kind::F16, Kind::I8, Kind::U8, Kind::U16, Kind::U32, Kind::U64].contains(kind)
    }) {
        for is_big in [false, true] {
            let file = nifti(kind, is_big);
            for (packed, bytes) in [(false, file.clone()), (true, gzip(&file))] {
                let what = format!("{kind:?}, {is_big}, {packed}");
                let scene = load(&bytes, "").unwrap_or_else(|e| panic!("{what}: {e}"));
                assert_values(&scene, &what);
                // In the body's space (10, 20, 30) and (10 - 2, 20 + 0.5, 30 + 4): right, front, up [mm].
                let places =
                    [([0.0; 3], [-10e-3, 30e-3, 20e-3]), ([1.0; 3], [-8e-3, 34e-3, 20.5e-3])];
                assert_places(&scene, &places, &what);
            }
        }
    }
    let mut beside = nifti(Kind::I16, false);
    let data = beside.split_off(352);
    beside[344..348].copy_from_slice(b"ni1\0");
    beside[108..112].copy_from_slice(&0_f32.to_le_bytes());
    let folder = Folder::new();
    folder.write("pair.img", data);
    let path = folder.write("pair.hdr", beside);
    assert_eq!(scene::load(&path).unwrap().grids.len(), 1);
    assert_eq!(scene::files(&path).unwrap().len(), 2);
}

#[test]
fn meta_images_are_read() {
    for kind in KINDS.into_iter().filter(|&kind| kind != Kind::F16) {
        for (is_big, is_packed) in [(false, false), (true, false), (false, true), (true, true)] {
            let what = format!("{kind:?}, {is_big}, {is_packed}");
            let scene = load(&meta(kind, is_big, is_packed), "");
            let scene = scene.unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_values(&scene, &what);
            // x of the array goes along y, y along -x.
            assert_places(
                &scene,
                &[([0.0; 3], [10.0, 20.0, 30.0]), ([1.0; 3], [8.0, 20.5, 34.0])],
                &what,
            );
        }
    }
    let folder = Folder::new();
    let data = zlib(&bytes_of(Kind::I16, true, &values()));
    folder.write("data.zraw", data);
    let path = folder.write("head.mhd", meta_head("MET_SHORT", true, true, "data.zraw"));
    folder.write("scene.toml", "[[volume]]\nfile = \"head.mhd\"\n");
    assert_values(&scene::load(&folder.0.join("scene.toml")).unwrap(), "beside");
    assert_eq!(scene::files(&path).unwrap().len(), 2);
    let body = meta_head("MET_UCHAR", false, false, "LOCAL")
        .replace("NDims", "AnatomicalOrientation = RAI\nNDims");
    let body = [body.into_bytes(), bytes_of(Kind::U8, false, &values())].concat();
    assert_places(&load(&body, "").unwrap(), &[([0.0; 3], [10e-3, 30e-3, -20e-3])], "a body");
}

#[test]
fn pages_of_tiff_are_slices() {
    for kind in KINDS {
        for (is_big, is_packed) in [(false, false), (true, false), (false, true), (true, true)] {
            let what = format!("{kind:?}, {is_big}, {is_packed}");
            let scene = load(&tiff(kind, is_big, is_packed), "");
            let scene = scene.unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_values(&scene, &what);
            assert_places(&scene, &[([1.0; 3], [0.5e-6, -0.25e-6, -3e-6])], &what);
        }
    }
}

/// Colours of voxels: each channel is a grid that absorbs no other channel.
#[test]
fn colours_of_voxels_are_three_grids() {
    let numbers: Vec<f64> = (0..2 * 2 * 2)
        .flat_map(|i| [0.0, 64.0, 128.0, 0.0].map(|c| c + f64::from(i) * 8.0))
        .collect();
    let array = npy_of("|u1", false, "2, 2, 2, 4", &bytes_of(Kind::U8, false, &numbers));
    let scene = load(&array, "color = [1, 0.5, 1]\n").unwrap();
    assert_eq!(scene.grids.len(), 3);
    for (channel, grid) in scene.grids.iter().enumerate() {
        assert_eq!(grid.extinction, Vec3::new(1.0, 0.5, 1.0) * Vec3::AXES[channel]);
        for (i, voxel) in numbers.chunks(4).enumerate() {
            let at = IVec3::new(i as i32 % 2, i as i32 / 2 % 2, i as i32 / 4);
            let wanted = voxel[channel] / 255.0 * voxel[3] / 255.0;
            let found = f64::from(density(grid, at));
            assert!((found - wanted).abs() < 1e-3 * wanted.max(1e-2), "{at}: {found}, {wanted}");
        }
    }
    for key in ["colors = \"bone\"\n", "window = [0, 1]\n"] {
        let message = refusal(&array, key);
        assert!(message.contains("colours of their own"), "{message}");
    }
}

#[test]
fn a_file_alone_is_a_scene_whatever_its_name() {
    let folder = Folder::new();
    for (name, bytes) in [
        ("a.npy", npy(Kind::F32, false, false)),
        ("b.ply", nrrd(Kind::U8, false, "gzip")),
        ("c.nii.gz", gzip(&nifti(Kind::I16, false))),
        ("d", vti(Kind::F32, false, Vti::Raw, None)),
        ("e.mha", meta(Kind::F32, false, true)),
        ("f.tif", tiff(Kind::U16, false, true)),
        ("g.npz", npz(&[("x", npy(Kind::F32, false, true))], true)),
    ] {
        let path = folder.write(name, bytes);
        let scene = scene::load(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(scene.grids.len(), 1, "{name}");
        assert!(scene.notes.iter().any(|note| note.contains("density of 1")), "{name}");
        assert!(scene::check(&path).is_ok());
    }
    let error = scene::load(&folder.0.join("none.nii")).unwrap_err().to_string();
    assert!(error.contains("none.nii") && error.contains("os error 2"), "{error}");
    let error = scene::load(&folder.write("h.nrrd", "NRRD0004\ntype: uchar\n\n")).unwrap_err();
    let text = format!("{error}; {}", error.help().unwrap());
    assert!(text.contains("h.nrrd") && text.contains("no field `sizes`"), "{text}");
}

/// Empty space has no bricks, and invalid values are counted.
#[test]
fn nothing_is_stored_of_empty_space() {
    let mut values = vec![0.0_f64; 64 * 64 * 64];
    values[(40 * 64 + 8) * 64 + 8] = 2.0;
    values[5] = -1.0;
    values[6] = f64::NAN;
    let array = npy_of("<f4", false, "64, 64, 64", &bytes_of(Kind::F32, false, &values));
    let scene = load(&array, "").unwrap();
    // The voxel is the first of its leaf, and so a corner of eight.
    assert_eq!(scene.grids[0].bricks.len(), 8);
    assert_eq!(density(&scene.grids[0], IVec3::new(8, 8, 40)), 2.0);
    let counts: Vec<_> = scene.skipped.iter().map(|(name, &count)| (*name, count)).collect();
    assert_eq!(counts, [("voxel below 0", 1), ("voxel not finite", 1)]);
    // The same value throughout is a box.
    let array = npy_of("|u1", false, "64, 64, 64", &[7; 64 * 64 * 64]);
    let scene = load(&array, "").unwrap();
    let boxes = scene.grids[0].bricks.iter().filter(|brick| brick.voxels().is_none());
    assert_eq!(boxes.map(|brick| brick.size().element_product()).sum::<u32>(), 56 * 56 * 56);
}

#[test]
fn what_lies_is_refused_before_memory_is_allocated() {
    let huge = "4000000, 4000, 4000";
    for (bytes, says) in [
        (npy_of("<f4", false, huge, &[0; 64]), "bytes, but"),
        (npy_of("<f4", false, "0, 4, 4", &[]), "no voxels"),
        (npy_of("<f4", false, "4, 4", &[0; 64]), "shape"),
        (npy_of("<c8", false, "1, 1, 1", &[0; 64]), "kind `<c8`"),
        (npz(&[("a", npy_of("<f4", false, "9000, 900, 900", &[0; 64]))], true), "in an archive"),
        (
            nrrd_of("uchar", "sizes: 4000000 4000 4000\nencoding: gzip\n", &gzip(&[0; 64])),
            "packed ones",
        ),
        (nrrd_of("uchar", "encoding: bzip2\n", &[]), "encoding is `bzip2`"),
        (nrrd_of("short", "encoding: raw\n", &[0; 240]), "endian"),
        (nrrd_of("uchar", "encoding: raw\n", &[1; 119]), "120 bytes, but 119"),
        (nrrd_of("uchar", "encoding: raw\nspacings: 0 1 1\n", &[1; 120]), "no volume"),
        (nrrd_of("uchar", "encoding: ascii\n", b"1 2 x"), "in 5 bytes of text"),
    ] {
        let message = refusal(&bytes, "");
        assert!(message.contains(says), "{says}: {message}");
    }
    let message = refusal(&npy(Kind::F32, false, false), "color_grid = \"Cd\"\n");
    assert!(message.contains("no grids of colours"), "{message}");
    let message = refusal(b"no volume at all", "");
    assert!(message.contains("of no known kind") && message.contains(".nrrd"), "{message}");
}

/// Bytes changed, cut out, cut off: each file gives a result or an error.
#[test]
fn changed_arrays_do_not_panic() {
    let seeds = [
        npy(Kind::F16, true, true),
        npz(&[("density", npy(Kind::I16, false, false))], true),
        nrrd(Kind::I16, true, "gzip"),
        nrrd(Kind::F32, false, "ascii"),
        nrrd_of(
            "uchar",
            "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n",
            &[9; 120],
        ),
        vti(Kind::F32, false, Vti::Raw, Some("vtkZLibDataCompressor")),
        vti(Kind::I16, true, Vti::Appended, Some("vtkLZ4DataCompressor")),
        vti(Kind::U8, false, Vti::Inline, None),
        nifti(Kind::I16, false),
        gzip(&nifti(Kind::F32, true)),
        meta(Kind::I16, true, true),
        tiff(Kind::U16, true, false),
        tiff(Kind::F32, false, true),
    ];
    let folder = Folder::new();
    let scene_path = folder.write("scene.toml", "[[volume]]\nfile = \"some.file\"\n");
    let mut chance = Chance::new(9);
    let (mut read, mut refused) = (0, 0);
    for i in 0..1300 {
        let mut bytes = seeds[i % seeds.len()].clone();
        for _ in 0..=chance.below(3) {
            let at = chance.below(bytes.len());
            match chance.below(5) {
                0 => bytes[at] = chance.below(256) as u8,
                1 => bytes[at] = b"0123456789-.e \n<>\""[chance.below(18)],
                2 => drop(bytes.drain(at..(at + 1 + chance.below(9)).min(bytes.len()))),
                3 => bytes.truncate(at.max(1)),
                _ => bytes.insert(at, b"09-.e"[chance.below(5)]),
            }
        }
        folder.write("some.file", &bytes);
        match scene::load(&scene_path) {
            Ok(scene) => {
                read += 1;
                let sound = |grid: &Grid| {
                    grid.problem().is_none() && grid.bricks.iter().all(|b| b.problem().is_none())
                };
                assert!(scene.grids.iter().all(sound));
            }
            Err(error) => {
                refused += 1;
                assert!(error.help().is_some_and(|help| !help.is_empty()), "{error}");
            }
        }
    }
    assert!(read > 100 && refused > 300, "{read} read, {refused} refused");
}
