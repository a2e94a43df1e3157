//! Transfer from a volume's values to density and colour: windows, tables of colours, clipping, units and
//! axes, for arrays, `OpenVDB` files and generated volumes.
use super::arrays::density;
use crate::common::{
    TIERS,
    arrays::{Kind, SIZE, bytes_of, npy, npy_of, value},
    files::{Folder, read},
    map_frame,
    vdb::{Format, VdbGrid, file, placed, scaled},
};
use gobo::{
    glam::{DVec3, IVec3, UVec3, Vec3},
    model::Grid,
};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

fn load(bytes: &[u8], keys: &str) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    let name = if bytes.starts_with(b" BDV") { "some.vdb" } else { "some.npy" };
    folder.write(name, bytes);
    scene::load(&folder.write("scene.toml", format!("[[volume]]\nfile = \"{name}\"\n{keys}")))
}

fn refusal(keys: &str) -> (usize, String) {
    match load(&npy(Kind::F32, false, false), keys) {
        Err(SceneError::Document { line, message, help, .. }) => {
            (line, format!("{message}; {}", help.expect("a remedy")))
        }
        other => panic!("{keys}: {other:?}"),
    }
}

fn voxels() -> impl Iterator<Item = IVec3> {
    let [width, height, depth] = SIZE.map(|size| size as i32);
    (0..width * height * depth)
        .map(move |i| IVec3::new(i % width, i / width % height, i / (width * height)))
}

fn of_array(voxel: IVec3) -> f32 {
    value(voxel.to_array().map(|at| at as usize)) as f32
}

fn near(found: f32, wanted: f32, what: &str) {
    // Densities are half floats.
    assert!((found - wanted).abs() <= 1e-3 * wanted.abs().max(1e-3), "{what}: {found}, {wanted}");
}

#[test]
fn a_window_is_from_0_to_1() {
    let array = npy(Kind::F32, false, false);
    let scene = load(&array, "window = [20, 100]\n").unwrap();
    for voxel in voxels() {
        let wanted = ((of_array(voxel) - 20.0) / 80.0).clamp(0.0, 1.0);
        near(density(&scene.grids[0], voxel), wanted, &format!("{voxel}"));
    }
    // Values below the window are no fault, even below 0.
    let numbers = bytes_of(Kind::I16, false, &[-1000.0, -500.0, 0.0, 1000.0]);
    let scanned = npy_of("<i2", false, "1, 1, 4", &numbers);
    let scene = load(&scanned, "window = [-1000, 1000]\n").unwrap();
    for (x, wanted) in [(0, 0.0), (1, 0.25), (2, 0.5), (3, 1.0)] {
        near(density(&scene.grids[0], IVec3::new(x, 0, 0)), wanted, "a scan");
    }
    assert!(scene.skipped.is_empty());
    assert_eq!(load(&scanned, "").unwrap().skipped.get("voxel below 0"), Some(&2));
}

const TABLE: &str =
    "colors = [[10, [1, 0.5, 0], 0], [20, [0.8, 0.2, 0.1], 0.5], [60, [0.2, 0.9, 0.4], 1]]\n";

#[test]
fn each_row_of_a_table_is_a_grid_of_its_share() {
    let array = npy(Kind::F32, false, false);
    let scene =
        load(&array, &format!("{TABLE}ahead = 0.25\nalbedo = [1, 0.5, 1]\ncolor = [1, 1, 0.5]\n"))
            .unwrap();
    // The first row is invisible everywhere.
    let [low, high] = &scene.grids[..] else { panic!("{} grids", scene.grids.len()) };
    for voxel in voxels() {
        let value = of_array(voxel);
        let rise = ((value - 10.0) / 10.0).clamp(0.0, 1.0);
        let way = ((value - 20.0) / 40.0).clamp(0.0, 1.0);
        near(density(low, voxel), 0.5 * rise * (1.0 - way), &format!("low, {voxel}"));
        near(density(high, voxel), way, &format!("high, {voxel}"));
    }
    for (grid, color) in [(low, [0.8, 0.2, 0.1]), (high, [0.2, 0.9, 0.4])] {
        let color = Vec3::from(color);
        // A quarter of the scattered light goes straight on.
        let (taken, scattered) = (1.0 - 0.25 * color, 0.75 * color);
        assert!((grid.extinction - taken * Vec3::new(1.0, 1.0, 0.5)).length() < 1e-6);
        let albedo = scene.materials[grid.material as usize].tint.truncate();
        assert!(
            (albedo - scattered / taken * Vec3::new(1.0, 0.5, 1.0)).length() < 1e-6,
            "{albedo}"
        );
    }
    assert_ne!(low.material, high.material);
}

/// A slab of one value between two rows: its transmittance for a sun, per channel.
#[test]
fn a_classified_slab_is_beer_lambert() {
    let array = npy_of("|u1", false, "12, 12, 12", &[40; 12 * 12 * 12]);
    let light = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nsize = 32\n";
    let scene = load(&array, &format!("density = {{ factor = 0.2 }}\n{TABLE}{light}")).unwrap();
    // Half of each row: half of 0.5, and half of 1. Half of the scattered light goes straight on.
    let [one, other] =
        [[0.8, 0.2, 0.1], [0.2, 0.9, 0.4]].map(|color| 1.0 - 0.5 * Vec3::from(color));
    let tau = 0.2 * 12.0 * (0.25 * one + 0.5 * other);
    for tier in TIERS {
        let maps = map_frame(tier, &scene).maps;
        let (view, filter) = (&maps[0].view, &maps[0].filter);
        let at = UVec3::new(view.size.x / 2, view.size.y / 2, 0);
        let found = filter[(at.y * view.size.x + at.x) as usize];
        for (channel, found) in found.into_iter().enumerate() {
            let wanted = (-tau[channel]).exp();
            assert!((found - wanted).abs() < 2e-3, "{tier:?}: {found}, {wanted}");
        }
    }
}

#[test]
fn tables_have_names() {
    let array =
        npy_of("<i2", false, "1, 1, 3", &bytes_of(Kind::I16, false, &[-1000.0, 50.0, 1500.0]));
    for (name, seen) in [("bone", [0.0, 0.0, 1.0]), ("skin", [0.0, 1.0, 1.0])] {
        let scene = load(&array, &format!("colors = \"{name}\"\n")).unwrap();
        for (x, wanted) in seen.into_iter().enumerate() {
            let at = IVec3::new(x as i32, 0, 0);
            near(scene.grids.iter().map(|grid| density(grid, at)).sum(), wanted, name);
        }
    }
    for name in ["heat", "ice", "hues"] {
        let scene =
            load(&array, &format!("window = [-1000, 2000]\ncolors = \"{name}\"\n")).unwrap();
        let all = scene.grids.iter().map(|grid| density(grid, IVec3::new(1, 0, 0))).sum();
        near(all, 0.35, name);
    }
    for (keys, says) in [
        ("colors = \"bones\"\n", "did you mean `bone`"),
        ("window = [0, 1]\ncolors = \"bone\"\n", "remove the window"),
        ("colors = \"heat\"\n", "add window"),
        ("colors = [[1, [1, 1, 1]]]\n", "row 1 of colors has 2 parts"),
        ("colors = [[1, [1, 1], 1]]\n", "not of 1, 3 and 1 numbers"),
        ("colors = [[1, [1, 2, 1], 1]]\n", "out of range"),
        ("colors = [[1, [1, 1, 1], 1], [1, [1, 1, 1], 1]]\n", "do not ascend"),
        ("colors = [[1, [1, 1, 1], 0]]\n", "above 0"),
        ("window = [1, 1]\n", "window is [1.0, 1.0]"),
        ("ahead = 2\n", "from 0 to 1"),
        ("unit = \"foot\"\n", "no unit is named `foot`"),
        ("up = \"x\"\n", "`x`"),
        ("clip = { planes = [[0, 0, 0, 1]] }\n", "without a normal"),
        ("clip = { box = [[0, 0, 0]] }\n", "two corners"),
        ("clip = { box = [[0, 0], [1, 1, 1]] }\n", "two corners"),
    ] {
        let (line, message) = refusal(keys);
        assert!(line >= 3 && message.contains(says), "{keys}: {line}, {message}");
    }
}

/// Voxels whose centres are outside are 0.
#[test]
fn arrays_are_cut() {
    let array = npy(Kind::F32, false, false);
    let place = |voxel: IVec3| voxel.as_dvec3();
    let within = |p: DVec3| p.x >= 2.5 && p.x <= 7.0 && p.y <= 2.0;
    let above = |p: DVec3| p.x + p.y - 4.0 >= 0.0 && 9.0 - 2.0 * p.z >= 0.0;
    for (clip, has) in [
        ("box = [[2.5, 0, -1], [7, 2, 9]]", &within as &dyn Fn(DVec3) -> bool),
        ("planes = [[1, 1, 0, -4], [0, 0, -2, 9]]", &above),
        ("box = [[7, 2, -1], [2.5, 0, 9]], planes = [[1, 1, 0, -4]]", &|p| within(p) && above(p)),
    ] {
        let scene = load(&array, &format!("clip = {{ {clip} }}\n")).unwrap();
        let mut shown = 0;
        for voxel in voxels() {
            let wanted = if has(place(voxel)) { of_array(voxel) } else { 0.0 };
            assert_eq!(density(&scene.grids[0], voxel), wanted, "{clip}, {voxel}");
            shown += i32::from(wanted > 0.0);
        }
        assert!((10..110).contains(&shown), "{clip}: {shown}");
    }
}

/// Leaves, and tiles that a plane crosses.
#[test]
fn trees_are_cut_and_windowed() {
    let mut grid =
        VdbGrid { transform: placed(DVec3::splat(0.5), DVec3::splat(-1.0)), ..VdbGrid::default() };
    for i in 0..300 {
        grid.set(IVec3::new(i % 10 - 5, i / 10 % 10, i / 100), 1.0 + (i % 3) as f32);
    }
    grid.tiles.insert(([16, 0, 0], 8), (4.0, true));
    grid.tiles.insert(([128, 0, 0], 128), (2.0, true));
    let bytes = file(Format::default(), &[grid.clone()]);
    let keys = "window = [0, 4]\n\
        clip = { planes = [[-1, -0.25, 0, 90]], box = [[-3, -9, -9], [999, 999, 30]] }\n";
    let scene = load(&bytes, keys).unwrap();
    let has = |voxel: IVec3| {
        let at = voxel.as_dvec3() * 0.5 - 1.0;
        at.x >= -3.0 && at.z <= 30.0 && 90.0 - at.x - 0.25 * at.y >= 0.0
    };
    let near = (0..8_000).map(|i| IVec3::new(i % 40 - 10, i / 40 % 20 - 4, i / 800 - 2));
    let far =
        (0..20_000).map(|i| IVec3::new(120 + i % 40 * 4, i / 40 % 50 * 3 - 5, i / 2000 * 9 - 3));
    let (mut kept, mut cut) = (0, 0);
    for voxel in near.chain(far) {
        let value = grid.at(voxel) as f32 / 4.0;
        let wanted = if has(voxel) { value } else { 0.0 };
        assert_eq!(density(&scene.grids[0], voxel), wanted, "{voxel}");
        kept += i32::from(wanted > 0.0);
        cut += i32::from(value > 0.0 && wanted == 0.0);
    }
    assert!(kept > 3000 && cut > 1000, "{kept} kept, {cut} cut");
    // A table of colours for a tree.
    let scene = load(&bytes, "colors = [[0, [1, 1, 1], 0], [4, [1, 0, 0], 1]]\n").unwrap();
    assert_eq!(density(&scene.grids[0], IVec3::new(130, 3, 3)), 0.5);
}

#[test]
fn units_and_axes_are_those_of_the_scene() {
    let mut grid = VdbGrid { transform: scaled(2.0), ..VdbGrid::default() };
    grid.set(IVec3::ONE, 1.0);
    let bytes = file(Format::default(), &[grid]);
    let at = |grid: &Grid| grid.world_from_index.transform_point3(Vec3::new(1.0, 2.0, 3.0));
    for (keys, wanted) in [
        ("", Vec3::new(2.0, 4.0, 6.0)),
        ("unit = \"mm\"\n", Vec3::new(2e-3, 4e-3, 6e-3)),
        ("up = \"z\"\n", Vec3::new(2.0, 6.0, -4.0)),
        ("up = \"y\"\nunit = \"cm\"\n", Vec3::new(0.02, 0.04, 0.06)),
    ] {
        let scene = load(&bytes, keys).unwrap();
        assert!((at(&scene.grids[0]) - wanted).length() < 1e-6, "{keys}: {}", at(&scene.grids[0]));
    }
}

/// A scan of a chest has air around it and in its lungs, muscle, and dense bone; a clip is in its own space.
#[test]
fn a_chest_is_a_scan() {
    let chest = |keys: &str| {
        let table = format!("[[volume]]\ngenerate = {{ kind = \"chest\", voxels = 48 }}\n{keys}");
        read(&table).unwrap_or_else(|error| panic!("{error}"))
    };
    let scene = chest("colors = \"body\"\n");
    assert!(scene.motions.is_empty() && scene.grids.len() == 4, "{}", scene.grids.len());
    let windowed = chest("window = [-1000, 1600]\n");
    let grid = &windowed.grids[0];
    let hounsfield = |x: f32, y: f32, z: f32| {
        let index = grid.world_from_index.inverse().transform_point3(Vec3::new(x, y, z));
        density(grid, index.round().as_ivec3()) * 2600.0 - 1000.0
    };
    assert!(hounsfield(0.17, 0.2, 0.12) < -950.0, "the corner is air");
    assert!((-950.0..-300.0).contains(&hounsfield(0.075, 0.2, 0.01)), "a lung");
    assert!((20.0..250.0).contains(&hounsfield(0.03, 0.16, 0.02)), "the heart");
    assert!(hounsfield(0.0, 0.2, -0.065) > 200.0, "the spine");
    let half = chest("window = [-1000, 1600]\nclip = { planes = [[-1, 0, 0, 0]] }\n");
    let most = half.grids[0].bounds().max.x;
    assert!((0.0..0.075).contains(&most) && windowed.grids[0].bounds().max.x > 0.15, "{most}");
}
