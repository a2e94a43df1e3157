//! `NanoVDB` files: each voxel has the file's value, for all types and compressions.
use super::arrays::density;
use crate::common::{
    files::Folder,
    nano::{Codec, DOUBLE, FLOAT, FP4, FP8, FP16, FPN, HALF, INT16, INT32, grid, segment},
    scenes::Chance,
    vdb::VdbGrid,
};
use gobo::glam::{IVec3, Vec3};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

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

/// Leaves with whole values of 0 to 14 on both sides of 0, and tiles of 8 and 128 voxels.
fn lumpy(background: f32) -> VdbGrid {
    let mut grid = VdbGrid { background, ..VdbGrid::default() };
    let mut chance = Chance::new(8);
    for _ in 0..500 {
        let mut axis = || (chance.unit() * 30.0) as i32 - 15;
        let voxel = IVec3::new(axis(), axis(), axis());
        grid.set(voxel, (chance.unit() * 14.9).floor());
    }
    grid.tiles.insert(([24, 0, 0], 8), (5.0, true));
    grid.tiles.insert(([32, 0, 0], 8), (6.0, false));
    grid.tiles.insert(([-256, 0, 0], 128), (2.0, true));
    grid
}

fn assert_voxels(scene: &Scene, truth: &VdbGrid, what: &str) {
    let near =
        (0..24_000).map(|i| IVec3::new(i % 60 - 18, i / 60 % 20 * 2 - 18, i / 1200 * 2 - 18));
    let far =
        (0..1_000).map(|i| IVec3::new(-260 + i % 10 * 14, i / 10 % 10 * 14 - 4, i / 100 * 14 - 4));
    let mut seen = 0;
    for voxel in near.chain(far) {
        let wanted = truth.at(voxel) as f32;
        assert_eq!(density(&scene.grids[0], voxel), wanted, "{what}, {voxel}");
        seen += i32::from(wanted > 0.0);
    }
    assert!(seen > 500, "{what}: {seen}");
    // The matrix that `grid` writes.
    let found = scene.grids[0].world_from_index.transform_point3(Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(found, Vec3::new(19.0, 10.0, 15.0), "{what}");
}

#[test]
fn grids_of_every_type_are_read() {
    for kind in [FLOAT, DOUBLE, INT16, INT32, HALF, FP4, FP8, FP16, FPN] {
        for background in [0.0, 3.0] {
            let truth = lumpy(background);
            let bytes = grid(kind, 2, &truth);
            for codec in [None, Some(Codec::Plain), Some(Codec::Zip), Some(Codec::Blosc)] {
                let what = format!("{kind}, {background}, {codec:?}");
                let file = match codec {
                    None => bytes.clone(),
                    Some(codec) => segment(codec, &[("density", kind, bytes.clone())]),
                };
                let scene = load(&file, "").unwrap_or_else(|e| panic!("{what}: {e}"));
                assert_voxels(&scene, &truth, &what);
            }
        }
    }
}

#[test]
fn grids_are_named_and_what_is_not_read_is_listed() {
    let truth = lumpy(0.0);
    let other = VdbGrid { name: "other", ..VdbGrid::default() };
    let own = grid(FLOAT, 2, &truth);
    let vectors = grid(6, 0, &other);
    let file = segment(
        Codec::Zip,
        &[
            ("vectors", 6, vectors),
            ("other", FLOAT, grid(FLOAT, 0, &other)),
            ("density", FLOAT, own.clone()),
        ],
    );
    let scene = load(&file, "").unwrap();
    assert_voxels(&scene, &truth, "the second");
    assert!(scene.notes.iter().any(|note| note.contains("`vectors` is not read: its type is 6")));
    assert!(load(&file, "density = { grid = \"other\" }").unwrap().grids[0].bricks.is_empty());
    let message = refusal(&file, "density = { grid = \"others\" }");
    assert!(message.contains("did you mean `other`"), "{message}");
    // Segments, and single grids, one after another.
    let two =
        [segment(Codec::Plain, &[("a", FLOAT, grid(FLOAT, 0, &other))]), own.clone()].concat();
    assert_voxels(&load(&two, "").unwrap(), &truth, "behind a segment");
    let folder = Folder::new();
    assert_eq!(scene::load(&folder.write("alone.nvdb", &file)).unwrap().grids.len(), 1);
    let message = refusal(&grid(FLOAT, 1, &truth), "");
    assert!(message.contains("level set"), "{message}");
    let mut old = own.clone();
    old[16..20].copy_from_slice(&(29_u32 << 21).to_le_bytes());
    let message = refusal(&old, "");
    assert!(message.contains("version 29") && message.contains("NanoVDB 32"), "{message}");
    let message = refusal(&own[..own.len() - 1], "");
    assert!(message.contains("outside of the file"), "{message}");
}

/// A root whose entries all point to one node, whose children all point to one leaf, would never end.
#[test]
fn nodes_that_are_shared_are_refused() {
    let mut truth = VdbGrid::default();
    truth.set(IVec3::ZERO, 1.0);
    let mut bytes = grid(FLOAT, 2, &truth);
    // All children of the lower node are the leaf, and all of the upper node the lower node.
    let (upper, lower) = (672 + 64 + 64 + 32, 672 + 64 + 64 + 32 + 270_400);
    for (node, count, table) in [(upper, 32_768, 8256), (lower, 4096, 1088)] {
        let first = bytes[node + table..node + table + 8].to_vec();
        bytes[node + 32 + count / 8..node + 32 + count / 4].fill(255);
        for i in 0..count {
            bytes[node + table + 8 * i..node + table + 8 * i + 8].copy_from_slice(&first);
        }
    }
    let message = refusal(&bytes, "");
    assert!(message.contains("many times"), "{message}");
}

#[test]
fn changed_files_do_not_panic() {
    let truth = lumpy(0.0);
    let seeds: Vec<_> = [FLOAT, FPN, FP8, DOUBLE]
        .into_iter()
        .zip([Codec::Plain, Codec::Plain, Codec::Zip, Codec::Blosc])
        .map(|(kind, codec)| segment(codec, &[("density", kind, grid(kind, 2, &truth))]))
        .collect();
    let folder = Folder::new();
    let scene_path = folder.write("scene.toml", "[[volume]]\nfile = \"some.file\"\n");
    let mut chance = Chance::new(10);
    let (mut read, mut refused) = (0, 0);
    for i in 0..240 {
        let mut bytes = seeds[i % seeds.len()].clone();
        for _ in 0..=chance.below(4) {
            // Heads and tables, more than voxels.
            let most = if chance.below(4) > 0 { 1200.min(bytes.len()) } else { bytes.len() };
            let at = chance.below(most);
            match chance.below(4) {
                0 => bytes[at] = chance.below(256) as u8,
                1 => bytes[at] ^= 1 << chance.below(8),
                2 => drop(bytes.drain(at..(at + 1 + chance.below(9)).min(bytes.len()))),
                _ => bytes.truncate(at.max(20)),
            }
        }
        folder.write("some.file", &bytes);
        match scene::load(&scene_path) {
            Ok(_) => read += 1,
            Err(error) => {
                refused += 1;
                assert!(error.help().is_some_and(|help| !help.is_empty()), "{error}");
            }
        }
    }
    assert!(read > 10 && refused > 50, "{read} read, {refused} refused");
}
