//! `OpenVDB` files: the field of a grid's bricks equals the file's, for all encodings; damaged files are
//! refused.
use crate::common::{
    files::Folder,
    scenes::Chance,
    vdb::{Format, Packing, VdbGrid, doubles, file, placed, scaled},
};
use gobo::{
    glam::{DVec3, IVec3, UVec3, Vec3},
    model::{Density, Grid},
};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

const TOML: &str = "[[volume]]\nfile = \"smoke.vdb\"\n";

fn load_as(bytes: &[u8], keys: &str) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    folder.write("smoke.vdb", bytes);
    scene::load(&folder.write("scene.toml", TOML.to_owned() + keys))
}

fn load(format: Format, grid: &VdbGrid) -> Scene {
    load_as(&file(format, std::slice::from_ref(grid)), "").unwrap_or_else(|e| panic!("{e}"))
}

/// The problem of a file, and the remedy.
fn refusal(bytes: &[u8], keys: &str) -> String {
    match load_as(bytes, keys) {
        Err(SceneError::Document { path, line, message, help, .. }) => {
            assert!(path.ends_with("scene.toml") && line == 2, "{line}: {message}");
            assert!(message.contains("smoke.vdb"), "{message}");
            format!("{message}; {}", help.expect("a remedy"))
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("read without an error"),
    }
}

fn trilinear(place: DVec3, value: impl Fn(IVec3) -> f64) -> f64 {
    let cell = place.floor();
    let part = place - cell;
    let corner = |i: i32| {
        let upper = IVec3::new(i & 1, i >> 1 & 1, i >> 2);
        let weights = DVec3::select(upper.cmpeq(IVec3::ONE), part, 1.0 - part);
        weights.element_product() * value(cell.as_ivec3() + upper)
    };
    (0..8).map(corner).sum()
}

/// Density of a grid at a position in index space, times its factor.
fn density(grid: &Grid, place: DVec3) -> f64 {
    let cell = place.floor().as_ivec3();
    let has = |origin: IVec3, size: UVec3| {
        cell.cmpge(origin).all() && cell.cmplt(origin + size.as_ivec3()).all()
    };
    let mut owners = grid.bricks.iter().filter(|brick| has(brick.origin, brick.size()));
    let owner = owners.next();
    assert!(owners.next().is_none(), "two bricks have the cell {cell}");
    let of_brick = owner.map_or(0.0, |brick| match &brick.density {
        Density::Constant { density, .. } => f64::from(*density),
        Density::Voxels(voxels) => {
            trilinear(place, |voxel| voxels.at((voxel - brick.origin).as_uvec3()).into())
        }
    });
    of_brick * f64::from(grid.factor)
}

/// Compares the densities of a scene's grid with the file's at random positions between two corners.
fn assert_same(scene: &Scene, truth: &VdbGrid, (min, max): (DVec3, DVec3), what: &str) {
    let mut chance = Chance::new(3);
    let mut unit = || f64::from(chance.unit());
    let mut sum = 0.0;
    for _ in 0..4000 {
        let place = min + (max - min) * DVec3::new(unit(), unit(), unit());
        let wanted = trilinear(place, |voxel| truth.at(voxel));
        let found = density(&scene.grids[0], place);
        // Rounding of 64 bits: all values are half floats.
        assert!(
            (found - wanted).abs() <= 1e-12 * wanted,
            "{what}: {found}, not {wanted} at {place}"
        );
        sum += wanted;
    }
    assert!(sum > 100.0, "{what}: hardly any density");
}

/// Leaves on both sides of 0, tiles of 8 and 128 voxels beside them, inactive values.
fn lumpy(kind: &'static str, background: f32) -> VdbGrid {
    let mut grid = VdbGrid { kind, background, ..VdbGrid::default() };
    let mut chance = Chance::new(11);
    for _ in 0..900 {
        let mut axis = || (chance.unit() * 22.0) as i32 - 11;
        let voxel = IVec3::new(axis(), axis(), axis());
        grid.set(voxel, (chance.unit() * 64.0).floor() / 16.0);
    }
    grid.tiles.insert(([-8, 16, -8], 8), (0.5, true));
    grid.tiles.insert(([0, 16, -8], 8), (0.5, true));
    grid.tiles.insert(([16, 0, 0], 8), (0.75, false));
    grid.tiles.insert(([-256, 0, 0], 128), (0.25, true));
    // Kinds 2 to 5 of left out values.
    for (i, leaf) in grid.leaves.values_mut().enumerate() {
        let values: &[f32] = match i % 6 {
            1 => &[2.0],
            2 => &[2.0, background],
            3 => &[2.0, 3.0],
            4 => &[2.0, 3.0, 4.0],
            _ => &[background],
        };
        for (j, voxel) in leaf.iter_mut().filter(|(_, is_active)| !is_active).enumerate() {
            voxel.0 = values[j % values.len()];
        }
    }
    grid
}

#[test]
fn the_field_of_the_bricks_is_that_of_the_file() {
    let near = (DVec3::splat(-14.0), DVec3::new(26.0, 26.0, 18.0));
    let far = (DVec3::new(-260.0, -4.0, -4.0), DVec3::new(-110.0, 132.0, 132.0));
    for kind in ["Tree_float_5_4_3", "Tree_float_5_4_3_HalfFloat"] {
        for (version, packing, masked, has_offsets) in [
            (219, Packing::Zip, false, true),
            (220, Packing::Zip, false, true),
            (220, Packing::Plain, false, true),
            (221, Packing::Plain, false, true),
            (221, Packing::Zip, false, false),
            (222, Packing::Zip, true, true),
            (222, Packing::Plain, true, true),
            (223, Packing::Blosc, true, false),
            (224, Packing::Blosc, false, true),
            (225, Packing::Plain, false, true),
        ] {
            let format = Format { version, packing, masked, has_offsets };
            let grid = lumpy(kind, if masked { 0.5 } else { 0.0 });
            let scene = load(format, &grid);
            assert_same(&scene, &grid, near, &format!("{kind} {format:?}"));
            assert_same(&scene, &grid, far, &format!("{kind} {format:?}"));
            let notes = usize::from(masked);
            assert_eq!(scene.notes.len(), notes, "the background: {:?}", scene.notes);
            assert!(scene.skipped.is_empty());
        }
    }
}

#[test]
fn cells_below_a_leaf_have_bricks_and_empty_ones_none() {
    for (voxel, count) in [
        (IVec3::ZERO, 8),
        (IVec3::new(3, 3, 3), 1),
        (IVec3::new(7, 0, 3), 2),
        (IVec3::splat(-1), 1),
    ] {
        let mut grid = VdbGrid::default();
        grid.set(voxel, 1.0);
        grid.set(IVec3::splat(600), 0.0);
        let bricks = &load(Format::default(), &grid).grids[0].bricks;
        assert_eq!(bricks.len(), count, "{voxel}: {bricks:?}");
    }
}

#[test]
fn tiles_are_joined_boxes() {
    let mut grid = VdbGrid::default();
    grid.tiles.insert(([0, 0, 0], 128), (0.5, true));
    grid.tiles.insert(([128, 0, 0], 128), (0.5, true));
    let bricks = load(Format::default(), &grid).grids.remove(0).bricks;
    let boxes: Vec<_> = bricks.iter().filter(|brick| brick.voxels().is_none()).collect();
    // Cells of the last layers have corners in the neighbours.
    let sizes: Vec<UVec3> = boxes.iter().map(|brick| brick.size()).collect();
    assert_eq!(sizes, [UVec3::new(248, 120, 120)]);
    // Around a box of 32 x 16 x 16 bricks those below its first and at its last layers.
    assert_eq!(bricks.len() - 1, 33 * 17 * 17 - 31 * 15 * 15);
    // A node of 4096 voxels would have more bricks than a scene may have.
    grid.tiles.insert(([4096, 0, 0], 4096), (0.5, true));
    let message = refusal(&file(Format::default(), &[grid]), "");
    assert!(message.contains("more than 524288 bricks") && message.contains("larger voxels"));
}

#[test]
fn densities_that_halves_cannot_hold_are_scaled() {
    for scale in [1e6, 1.0, 1e-6f32] {
        let mut grid = VdbGrid::default();
        let values = [1.0, 0.5, 0.3, 0.0];
        for (x, value) in (0..).zip(values) {
            grid.set(IVec3::new(x, 1, 1), value * scale);
        }
        let scene = load(Format::default(), &grid);
        for x in 0..4 {
            let voxel = IVec3::new(x, 1, 1);
            let (found, wanted) = (density(&scene.grids[0], voxel.as_dvec3()), grid.at(voxel));
            // Half floats round by 2^-11, and 2^-25 of the largest becomes 0.
            let error = wanted / 2048.0 + f64::from(scale) * 2f64.powi(-24);
            assert!((found - wanted).abs() <= error, "{found}, not {wanted}");
        }
        assert!(scene.grids[0].bricks.iter().all(|brick| brick.problem().is_none()));
    }
}

#[test]
fn every_linear_transform_is_read() {
    // Row vectors: the last row is the translation.
    let rows =
        [[0.0, 0.5, 0.0, 0.0], [-2.0, 0.0, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0], [7.0, 8.0, 9.0, 1.0]];
    let affine = || doubles(rows.into_iter().flatten());
    let identity = || doubles((0..16).map(|i| f64::from(u8::from(i % 5 == 0))));
    let old = [vec![0; 24], affine(), identity(), identity(), identity()].concat();
    let (at, turned) = (DVec3::new(1.0, 2.0, 4.0), DVec3::new(3.0, 8.5, 21.0));
    let three = DVec3::new(1.0, -2.0, 0.5);
    let cases = [
        (218, ("LinearTransform", old), turned),
        (219, ("AffineMap", affine()), turned),
        (224, ("UnitaryMap", affine()), turned),
        (224, scaled(0.25), at * 0.25),
        (224, ("ScaleMap", doubles([[1.0, -2.0, 0.5]; 5].concat())), at * three),
        (224, ("TranslationMap", doubles([1.0, -2.0, 0.5])), at + three),
        (224, placed(three, DVec3::splat(6.0)), at * three + 6.0),
    ];
    for (version, transform, wanted) in cases {
        let name = transform.0;
        let mut grid = VdbGrid { transform, ..VdbGrid::default() };
        grid.set(IVec3::ONE, 1.0);
        let packing = if version < 220 { Packing::Zip } else { Packing::Plain };
        let bytes = file(Format { version, packing, ..Format::default() }, &[grid]);
        let world = |keys| {
            let grid =
                load_as(&bytes, keys).unwrap_or_else(|e| panic!("{name}: {e}")).grids.remove(0);
            grid.world_from_index.transform_point3(at.as_vec3()).as_dvec3()
        };
        assert!(world("").distance(wanted) < 1e-5, "{name}: {}, not {wanted}", world(""));
        let keys = "scale = [2, 2, 2]\nrotation = [0, 0, 90]\ntranslation = [0, 0, 1]\n";
        let moved = DVec3::new(-wanted.y, wanted.x, wanted.z) * 2.0 + DVec3::Z;
        assert!(world(keys).distance(moved) < 1e-4, "{name}: {}, not {moved}", world(keys));
    }
    let frustum = VdbGrid { transform: ("NonlinearFrustumMap", vec![]), ..VdbGrid::default() };
    let message = refusal(&file(Format::default(), &[frustum]), "");
    assert!(message.contains("`NonlinearFrustumMap`") && message.contains("linear transform"));
}

#[test]
fn a_file_that_ends_anywhere_is_refused() {
    let grid = lumpy("Tree_float_5_4_3", 0.5);
    for (packing, has_offsets) in [(Packing::Zip, false), (Packing::Blosc, true)] {
        let bytes =
            file(Format { packing, has_offsets, ..Format::default() }, std::slice::from_ref(&grid));
        let early = (0..600).chain((600..bytes.len()).step_by(1499)).chain([bytes.len() - 1]);
        for length in early {
            let message = refusal(&bytes[..length], "");
            let is_named = ["damaged", "outside of the file"].iter().any(|m| message.contains(m));
            assert!(is_named, "{length} bytes: {message}");
        }
    }
}

#[test]
fn files_that_lie_are_refused() {
    let mut grid = VdbGrid::default();
    grid.set(IVec3::ONE, 1.0);
    let plain = file(Format::default(), &[grid.clone()]);
    let with = |at: usize, bytes: &[u8]| {
        let mut lie = plain.clone();
        lie[at..at + bytes.len()].copy_from_slice(bytes);
        lie
    };
    let place = |what: &[u8]| plain.windows(what.len()).position(|bytes| bytes == what).unwrap();
    let head = place(b"Tree_float_5_4_3") + 16 + 4;
    let tree = place(&grid.transform.1) + grid.transform.1.len();
    for (lie, says) in [
        (with(0, b"PK"), "not an OpenVDB file"),
        (with(8, &[217]), "version 217"),
        (with(8, &[226]), "version 226"),
        (with(head + 16, &u64::MAX.to_le_bytes()), "outside of the file"),
        (with(head + 16, &[0; 8]), "outside of the file"),
        (with(head + 24, &[8]), "compression 8"),
        (with(tree + 8, &[1]), "there twice"),
        (with(tree + 12, &[2]), "not at a multiple of 4096"),
        (with(tree + 16, &[1]), "not at a multiple of 4096"),
        (with(tree + 16, &[0, 0, 0, 0x7f]), "too far from 0"),
        (with(tree + 28 + 8192, &[7]), "of kind 7"),
    ] {
        let message = refusal(&lie, "");
        assert!(message.contains(says) && message.contains("; "), "{message} without {says}");
    }
    // Lengths of compressed values: one number of 4 bytes, which zlib made longer.
    let zip = file(Format { packing: Packing::Zip, ..Format::default() }, &[grid.clone()]);
    let at = zip.len() - 12;
    assert_eq!(zip[at..at + 8], (-4i64).to_le_bytes());
    for length in [1 << 32, -5, -3, 4, i64::MIN] {
        let mut lie = zip.clone();
        lie[at..at + 8].copy_from_slice(&length.to_le_bytes());
        let message = refusal(&lie, "");
        assert!(message.contains("damaged"), "{length}: {message}");
    }
    // A transform without an inverse, and one without an end.
    for edge in [0.0, f64::NAN, f64::INFINITY] {
        let flat = VdbGrid { transform: scaled(edge), ..grid.clone() };
        let message = refusal(&file(Format::default(), &[flat]), "");
        assert!(message.contains("cannot be inverted"), "{message}");
    }
}

#[test]
fn grids_are_chosen_and_named() {
    let mut heat = VdbGrid { name: "heat", ..VdbGrid::default() };
    heat.set(IVec3::ONE, 7.0);
    let mut smoke = VdbGrid::default();
    smoke.set(IVec3::ONE, 3.0);
    let points = VdbGrid { name: "dots", kind: "Tree_ptdataidx32_5_4_3", ..VdbGrid::default() };
    let colour = VdbGrid { name: "Cd", kind: "Tree_vec3i_5_4_3", ..VdbGrid::default() };
    let copy = VdbGrid { name: "copy", instance_of: "density", ..VdbGrid::default() };
    let all = [heat.clone(), points.clone(), colour, smoke.clone(), copy];
    let bytes = file(Format::default(), &all);
    let value = |bytes: &[u8], keys| {
        let scene = load_as(bytes, keys).unwrap_or_else(|e| panic!("{e}"));
        (density(&scene.grids[0], DVec3::ONE), scene.notes)
    };
    let (density, notes) = value(&bytes, "");
    assert_eq!(density, 3.0);
    let notes = notes.join("\n");
    for word in
        ["`dots`", "points", "`Cd`", "`Tree_vec3i_5_4_3`", "`copy`", "instance of `density`"]
    {
        assert!(notes.contains(word), "{notes}");
    }
    assert_eq!(value(&bytes, "density = { grid = \"heat\", factor = 2 }\n").0, 14.0);
    // Without the usual name the first grid is taken, with a note.
    let other = VdbGrid { name: "soot", ..smoke.clone() };
    let (density, notes) = value(&file(Format::default(), &[heat.clone(), other]), "");
    assert!(density == 7.0 && notes[0].contains("`heat` is taken"), "{notes:?}");
    let message = refusal(&bytes, "density = { grid = \"heet\" }\n");
    assert!(message.contains("`heet`") && message.contains("`heat`"), "{message}");
    let message = refusal(&file(Format::default(), std::slice::from_ref(&points)), "");
    assert!(message.contains("no grid of numbers") && message.contains("points"), "{message}");
    let level = VdbGrid { class: "level set", ..heat.clone() };
    let message = refusal(&file(Format::default(), &[level]), "");
    assert!(message.contains("level set") && message.contains("fog volume"), "{message}");
    // Without offsets nothing after an unreadable grid can be found.
    let format = Format { has_offsets: false, ..Format::default() };
    let (density, notes) = value(&file(format, &[heat, points, smoke]), "");
    assert_eq!(density, 7.0);
    assert!(notes.join("\n").contains("1 grids behind it"), "{notes:?}");
}

#[test]
fn values_that_are_no_densities_are_counted() {
    let mut grid = VdbGrid::default();
    for (x, value) in (1..).zip([1.0, -1.0, f32::NAN, f32::INFINITY, -0.0]) {
        grid.set(IVec3::new(x, 1, 1), value);
    }
    let scene = load(Format::default(), &grid);
    let counts: Vec<_> = scene.skipped.into_iter().collect();
    assert_eq!(counts, [("voxel below 0", 1), ("voxel not finite", 2)]);
    let at = |x: f64| density(&scene.grids[0], DVec3::new(x, 1.0, 1.0));
    assert_eq!([1.0, 2.0, 3.0, 4.0, 5.0].map(at), [1.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(scene.grids[0].bounds().min.cmplt(Vec3::ONE).all());
}

/// Bytes changed, cut out, duplicated: each file gives a result or an error soon, and a grid that is read is
/// valid.
#[test]
fn mutated_files_do_not_panic() {
    let grid = lumpy("Tree_float_5_4_3", 0.5);
    let packings = [Packing::Plain, Packing::Zip, Packing::Blosc];
    let seeds = packings
        .map(|packing| file(Format { packing, ..Format::default() }, std::slice::from_ref(&grid)));
    let mut chance = Chance::new(7);
    let mut below = |end: usize| ((chance.unit() * end as f32) as usize).min(end - 1);
    let (mut read, mut refused) = (0, 0);
    for i in 0..480 {
        let mut bytes = seeds[i % 3].clone();
        for _ in 0..=below(3) {
            // Heads are short, and decide the meaning of everything else.
            let span = if below(2) == 0 { 400 } else { bytes.len() };
            let at = below(span);
            let end = (at + 1 + below(9)).min(bytes.len());
            match below(4) {
                0 => bytes[at] = below(256) as u8,
                1 => bytes[at..end].fill(255),
                2 => drop(bytes.drain(at..end)),
                _ => {
                    let more = bytes[at..end].to_vec();
                    bytes.splice(at..at, more);
                }
            }
        }
        match load_as(&bytes, "") {
            Ok(scene) => {
                read += 1;
                assert!(scene.grids[0].problem().is_none());
                assert!(scene.grids[0].bricks.iter().all(|brick| brick.problem().is_none()));
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains("smoke.vdb") && error.help().is_some());
            }
        }
    }
    assert!(read > 20 && refused > 60, "{read} read, {refused} refused");
}
