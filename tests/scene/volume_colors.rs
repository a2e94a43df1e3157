//! Volumes whose extinction has a grid of colours: each channel is a grid of the products.
use crate::common::{
    TIERS,
    files::Folder,
    map_frame,
    scenes::Chance,
    vdb::{Format, Packing, VdbGrid, file, scaled},
};
use gobo::{
    glam::{IVec3, UVec3, Vec3},
    model::{Brick, Density, Grid},
};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError};

const CHANNELS: [f32; 3] = [1.0, 0.5, 0.125];

fn load(bytes: &[u8], keys: &str) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    folder.write("smoke.vdb", bytes);
    scene::load(&folder.write("scene.toml", format!("[[volume]]\nfile = \"smoke.vdb\"\n{keys}")))
}

fn refusal(bytes: &[u8], keys: &str) -> String {
    match load(bytes, keys) {
        Err(SceneError::Document { message, help, .. }) => {
            format!("{message}; {}", help.expect("a remedy"))
        }
        other => panic!("{other:?}"),
    }
}

/// Voxels in leaves, tiles of 8 and of 128.
fn smoke() -> VdbGrid {
    let mut grid = VdbGrid::default();
    let mut chance = Chance::new(3);
    for _ in 0..600 {
        let mut axis = || (chance.unit() * 22.0) as i32 - 11;
        let voxel = IVec3::new(axis(), axis(), axis());
        grid.set(voxel, (chance.unit() * 16.0).floor() / 4.0);
    }
    grid.tiles.insert(([16, 0, 0], 8), (0.5, true));
    grid.tiles.insert(([16, 8, 0], 8), (0.5, true));
    grid.tiles.insert(([128, 0, 0], 128), (0.25, true));
    grid.tiles.insert(([-256, 0, 0], 128), (0.75, true));
    grid
}

/// Colours that change within a leaf, and within both kinds of tiles; elsewhere they are the background.
fn colors(kind: &'static str) -> VdbGrid {
    let background = 2.0;
    let mut grid = VdbGrid { name: "Cd", kind, channels: &CHANNELS, background, ..smoke() };
    (grid.leaves, grid.tiles) = Default::default();
    let mut chance = Chance::new(4);
    for voxel in (0..300).map(|i| IVec3::new(i % 10 - 3, i / 10 % 10 - 3, i / 100)) {
        grid.set(voxel, (chance.unit() * 8.0).floor() / 4.0);
    }
    grid.set(IVec3::new(17, 9, 3), 0.5);
    grid.set(IVec3::new(130, 3, 2), 0.0);
    grid.tiles.insert(([136, 64, 0], 8), (1.0, true));
    grid
}

/// Value of a voxel in the file.
fn raw(grid: &VdbGrid, voxel: IVec3) -> f32 {
    let floor = |edge: i32| (voxel.div_euclid(IVec3::splat(edge)) * edge).to_array();
    let [x, y, z] = voxel.to_array().map(|v| v.rem_euclid(8) as usize);
    let leaf = grid.leaves.get(&floor(8)).map(|leaf| leaf[(x * 8 + y) * 8 + z].0);
    let tile = || [8, 128].iter().find_map(|&edge| grid.tiles.get(&(floor(edge), edge)));
    leaf.or_else(|| tile().map(|&(value, _)| value)).unwrap_or(grid.background)
}

fn density(grid: &Grid, voxel: IVec3) -> f32 {
    let has = |brick: &&Brick| {
        let own = voxel - brick.origin;
        own.cmpge(IVec3::ZERO).all() && own.cmplt(brick.size().as_ivec3()).all()
    };
    grid.bricks.iter().find(has).map_or(0.0, |brick| match &brick.density {
        Density::Constant { density, .. } => *density,
        Density::Voxels(voxels) => voxels.at((voxel - brick.origin).as_uvec3()),
    }) * grid.factor
}

#[test]
fn channels_are_products() {
    let near = (0..40_000).map(|i| IVec3::new(i % 40 - 14, i / 40 % 32 - 12, i / 1280 - 14));
    let far = (0..4_096).map(|i| IVec3::new(124 + i % 16, i / 16 % 16 * 5, i / 256 - 1));
    let other = [IVec3::new(-200, 9, 9), IVec3::new(200, 100, 100), IVec3::new(143, 71, 7)];
    let voxels: Vec<IVec3> = near.chain(far).chain(other).collect();
    for (version, packing, masked, kind) in [
        (224, Packing::Plain, true, "Tree_vec3s_5_4_3"),
        (224, Packing::Blosc, true, "Tree_vec3s_5_4_3"),
        (224, Packing::Zip, false, "Tree_vec3s_5_4_3_HalfFloat"),
        (221, Packing::Plain, false, "Tree_vec3s_5_4_3"),
    ] {
        for has_offsets in [true, false] {
            let format = Format { version, packing, masked, has_offsets };
            let (smoke, colors) = (smoke(), colors(kind));
            let bytes = file(format, &[colors.clone(), smoke.clone()]);
            let scene = load(&bytes, "color = [1, 0.5, 1]\ncolor_grid = \"Cd\"\n").unwrap();
            assert_eq!(scene.grids.len(), 3);
            for (channel, grid) in scene.grids.iter().enumerate() {
                assert_eq!(grid.extinction, Vec3::new(1.0, 0.5, 1.0) * Vec3::AXES[channel]);
                let mut seen = 0;
                for &voxel in &voxels {
                    let smoke = smoke.at(voxel) as f32;
                    let wanted = smoke * raw(&colors, voxel) * CHANNELS[channel];
                    // All are multiples of 2^-9 that half floats can express.
                    assert_eq!(density(grid, voxel), wanted, "{format:?}, {voxel}");
                    seen += i32::from(wanted > 0.0);
                }
                assert!(seen > 3000, "{seen}");
            }
            assert!(scene.notes.is_empty(), "{:?}", scene.notes);
        }
    }
}

#[test]
fn colours_are_named() {
    let both = [smoke(), colors("Tree_vec3s_5_4_3")];
    let bytes = file(Format::default(), &both);
    let scene = load(&bytes, "").unwrap();
    assert_eq!(scene.grids.len(), 1);
    assert!(scene.notes[0].contains("`Cd`") && scene.notes[0].contains("color_grid"));
    let message = refusal(&bytes, "color_grid = \"cd\"\n");
    assert!(message.contains("no grid of colours `cd`, but `Cd`"), "{message}");
    let message = refusal(&file(Format::default(), &both[..1]), "color_grid = \"Cd\"\n");
    assert!(message.contains("no grid of colours is there"), "{message}");
    let elsewhere = VdbGrid { transform: scaled(0.25), ..both[1].clone() };
    let message =
        refusal(&file(Format::default(), &[both[0].clone(), elsewhere]), "color_grid = \"Cd\"\n");
    assert!(message.contains("`density` and `Cd` differ in place or scale"), "{message}");
    let generated = "[[volume]]\ngenerate = { kind = \"cloud\" }\ncolor_grid = \"Cd\"\n";
    let folder = Folder::new();
    let error = scene::load(&folder.write("scene.toml", generated)).unwrap_err();
    assert!(error.to_string().contains("a grid of what has no file"), "{error}");
}

/// A cube whose colours multiply: its transmittance for a sun, per channel.
#[test]
fn a_coloured_cube_is_beer_lambert() {
    let mut smoke = VdbGrid { transform: scaled(1.0), ..VdbGrid::default() };
    for i in 0..12 * 12 * 12 {
        smoke.set(IVec3::new(i % 12, i / 12 % 12, i / 144), 0.5);
    }
    let colors = VdbGrid {
        name: "Cd",
        kind: "Tree_vec3s_5_4_3",
        channels: &CHANNELS,
        transform: scaled(1.0),
        background: 0.5,
        ..VdbGrid::default()
    };
    let bytes = file(Format::default(), &[smoke, colors]);
    let light = "[[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nsize = 32\n";
    let keys = format!("density = {{ factor = 0.25 }}\ncolor_grid = \"Cd\"\n{light}");
    let scene = load(&bytes, &keys).unwrap();
    // Twelve voxels and half a cell at both ends, each worth a quarter of a voxel.
    let tau = 0.25 * 0.5 * 0.5 * 12.0;
    for tier in TIERS {
        let maps = map_frame(tier, &scene).maps;
        let (view, filter) = (&maps[0].view, &maps[0].filter);
        let at = UVec3::new(view.size.x / 2, view.size.y / 2, 0);
        let found = filter[(at.y * view.size.x + at.x) as usize];
        for (channel, found) in CHANNELS.iter().zip(found) {
            let wanted = (-tau * channel).exp();
            assert!((found - wanted).abs() < 2e-3, "{tier:?}: {found}, {wanted}");
        }
    }
}
