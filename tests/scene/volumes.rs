//! Volumes of a scene file: sequences, generated clouds, placement, limits, and a single `.vdb` as a scene.
use crate::common::{
    files::{Folder, read},
    vdb::{Format, VdbGrid, file, placed},
};
use gobo::{
    glam::{DVec3, IVec3, Vec3},
    model::{Bounds, LightKind, Shape, Voxels},
};
use gobo_scene as scene;
use gobo_scene::{LoadOptions, Scene, SceneError};
use std::process::Command;

/// Line, message and remedy of a refusal.
fn refused(scene: Result<Scene, SceneError>) -> (usize, String) {
    match scene {
        Err(SceneError::Document { line, message, help, .. }) => {
            (line, format!("{message}; {}", help.expect("a remedy")))
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("read without an error"),
    }
}

/// A file of voxels of one value in a cube of 12 voxels of 1 m.
fn cube(value: f32) -> Vec<u8> {
    let mut grid =
        VdbGrid { transform: placed(DVec3::ONE, DVec3::splat(0.5)), ..VdbGrid::default() };
    for i in 0..12 * 12 * 12 {
        grid.set(IVec3::new(i % 12, i / 12 % 12, i / 144), value);
    }
    file(Format::default(), &[grid])
}

#[test]
fn a_volume_has_the_material_and_the_place_of_its_table() {
    let folder = Folder::new();
    folder.write("cube.vdb", cube(2.0));
    let keys = "density = { factor = 0.25 }\ncolor = [1, 0.5, 0]\nalbedo = [0.9, 0.8, 0.7]\n\
                scale = [2, 1, 1]\ntranslation = [0, 10, 0]\ncasts = false\n";
    let toml = format!("[[volume]]\nfile = \"cube.vdb\"\n{keys}");
    let scene = scene::load(&folder.write("scene.toml", toml)).unwrap();
    let [grid] = &scene.grids[..] else { panic!("one grid") };
    let material = &scene.materials[grid.material as usize];
    assert_eq!((material.shape, material.casts, material.visible), (Shape::Brick, false, true));
    assert_eq!(material.tint.truncate(), Vec3::new(0.9, 0.8, 0.7));
    assert_eq!((grid.extinction, grid.factor), (Vec3::new(1.0, 0.5, 0.0), 0.25));
    // The cells below the first voxel and after the last: bricks of 8 from -8 to 16.
    let bounds = grid.bounds();
    assert_eq!(
        (bounds.min, bounds.max),
        (Vec3::new(-15.0, 2.5, -7.5), Vec3::new(33.0, 26.5, 16.5))
    );
    let summary = gobo_scene::Summary::of(&scene);
    assert_eq!((summary.grids, summary.bricks), (1, 27));
    assert!(summary.to_string().contains("volumes    1, of 27 bricks\n"), "{summary}");
}

#[test]
fn a_sequence_shows_a_file_a_frame() {
    let folder = Folder::new();
    for frame in 7..10 {
        folder.write(&format!("cube_{frame:03}.vdb"), cube(frame as f32));
    }
    let toml = "[[volume]]\nfile = \"cube_%03d.vdb\"\nframes = [7, 9]\n";
    let path = folder.write("scene.toml", toml);
    let mut scene = scene::load(&path).unwrap();
    let value = |scene: &Scene| {
        let values = scene.grids[0].bricks.iter().filter_map(|brick| brick.voxels());
        values.flat_map(Voxels::values).fold(0.0, f32::max)
    };
    assert_eq!(value(&scene), 7.0);
    for (frame, wanted) in [(1, 8.0), (2, 9.0), (0, 7.0), (50, 9.0)] {
        scene.set_time(f64::from(frame) / Scene::FRAME_RATE);
        assert_eq!(value(&scene), wanted, "frame {frame}");
    }
    let names = scene::files(&path).unwrap();
    let names: Vec<_> = names.iter().map(|name| name.file_name().unwrap()).collect();
    assert_eq!(names, ["scene.toml", "cube_007.vdb", "cube_008.vdb", "cube_009.vdb"]);
    // A file that is damaged later is empty in its frame, and counted there.
    folder.write("cube_008.vdb", "PK");
    scene.set_time(1.0 / Scene::FRAME_RATE);
    assert!(scene.grids[0].bricks.is_empty());
    assert_eq!(scene.skipped.get("file of a volume's frame not read"), Some(&1));
    scene.set_time(2.0 / Scene::FRAME_RATE);
    assert!(value(&scene) == 9.0 && scene.skipped.is_empty(), "{:?}", scene.skipped);
    // A distant scene is moved near the origin, also in later frames.
    let far = format!("{toml}translation = [4000000, 0, 0]\n");
    let mut scene = scene::load(&folder.write("far.toml", far)).unwrap();
    let before = scene.grids[0].bounds();
    assert!(scene.origin.x > 3e6 && before.max.x < 1e3, "{before:?}");
    scene.set_time(2.0 / Scene::FRAME_RATE);
    assert_eq!(scene.grids[0].bounds(), before);
    for (toml, says) in [
        (toml.replace("9]", "11]"), "cube_010.vdb"),
        (toml.replace("[7, 9]", "[9, 7]"), "no frames"),
        (toml.replace("frames", "#"), "without frames"),
        (toml.replace("%03d", "007"), "without a number"),
    ] {
        let (line, message) = refused(scene::load(&folder.write("wrong.toml", toml)));
        assert!((2..=3).contains(&line) && message.contains(says), "{line}: {message}");
    }
}

#[test]
fn generated_volumes_repeat_and_move() {
    for kind in ["cloud", "plume", "explosion"] {
        let table = |keys: &str| {
            let keys = format!("kind = \"{kind}\", voxels = 24, {keys}");
            read(&format!("[[volume]]\ngenerate = {{ {keys} }}\n"))
                .unwrap_or_else(|e| panic!("{e}"))
        };
        let mut scene = table("seed = 3");
        let start = scene.grids.clone();
        assert!(!start[0].bricks.is_empty(), "{kind}");
        assert_eq!(table("seed = 3").grids, start);
        assert_ne!(table("seed = 4").grids, start, "{kind}: the seed");
        scene.set_time(1.0);
        assert_ne!(scene.grids, start, "{kind}: time");
        scene.set_time(0.0);
        assert_eq!(scene.grids, start);
        assert!(table("speed = 0").motions.is_empty());
        // It stands on its origin, and nothing is cut off at its box.
        let bricks = &start[0].bricks;
        let place = |brick: &gobo::model::Brick, i: u32| {
            let voxel = brick.origin + IVec3::new(i as i32 % 9, i as i32 / 9 % 9, i as i32 / 81);
            start[0].world_from_index.transform_point3(voxel.as_vec3())
        };
        let half = match kind {
            "cloud" => Vec3::new(2.0, 1.6, 1.5),
            "plume" => Vec3::new(1.0, 4.0, 1.0),
            _ => Vec3::new(1.5, 3.0, 1.5),
        };
        for brick in bricks {
            let values = brick.voxels().expect("no constant brick").values();
            for (value, i) in values.zip(0..) {
                let at = place(brick, i);
                assert!((0.0..=1.0).contains(&value), "{kind}: {value}");
                let is_inside = at.abs().cmple(half).all() && at.y >= 0.0;
                assert!(value == 0.0 || is_inside, "{kind}: {value} at {at}");
            }
        }
    }
}

/// `--frame N` generates a volume once, at its own time.
#[test]
fn generated_volumes_that_move_are_made_at_the_first_time_asked_for() {
    let folder = Folder::new();
    let of_start = |start: bool, path: &std::path::Path| {
        let mut options = LoadOptions::default();
        options.start = start;
        scene::load_as(path, &options).unwrap_or_else(|e| panic!("{e}"))
    };
    for x in [0, 400_000] {
        let toml = format!(
            "[camera]\neye = [0, 1, 9]\ntarget = [0, 1, 0]\n[[light]]\nkind = \"directional\"\n\
             direction = [0, -1, 0]\n[[volume]]\ntranslation = [{x}, 0, 0]\n\
             generate = {{ kind = \"plume\", voxels = 16 }}\n"
        );
        let path = folder.write("plume.toml", toml);
        let (mut late, mut whole) = (of_start(false, &path), of_start(true, &path));
        let outline = &late.grids[0].bricks;
        assert!(outline.len() == 1 && outline[0].voxels().is_none(), "{outline:?}");
        assert!(whole.grids[0].bricks.len() > 1);
        assert_eq!(late.origin, whole.origin);
        assert_eq!(late.origin == Vec3::ZERO, x == 0);
        for seconds in [0.5, 0.0] {
            late.set_time(seconds);
            whole.set_time(seconds);
            assert_eq!(late.grids, whole.grids, "{seconds} s");
        }
    }
}

/// Generated contents do not depend on the number of threads.
#[test]
fn threads_do_not_change_what_is_generated() {
    let toml = "[[volume]]\ngenerate = { kind = \"explosion\", voxels = 40 }\nemission = {}\n\
        [[material]]\nname = \"m\"\n\
        [[shape]]\nkind = \"sphere\"\nname = \"ball\"\nmaterial = \"m\"\nlevel = 5\n\
        displace = { amplitude = 0.2 }\n\
        [[strands]]\nmaterial = \"m\"\ngenerate = { kind = \"fur\", on = \"ball\", count = 300 }\n\
        [[emitter]]\nmaterial = \"m\"\nrate = 3000\nlifetime = [1, 2]\n\
        [[particles]]\nmaterial = \"m\"\n\
        generate = { kind = \"dust\", count = 40000, min = [0, 0, 0], max = [1, 1, 1], radius = 0.01 }\n";
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut scene = read(toml).unwrap_or_else(|e| panic!("{e}"));
            scene.set_time(0.7);
            let Scene { grids, triangles, strands, particles, .. } = scene;
            assert!(particles.len() > 1000 && strands.len() == 300);
            (grids, triangles, strands, particles)
        })
    };
    let one = made(1);
    for threads in [2, 7] {
        assert!(made(threads) == one, "{threads} threads");
    }
}

#[test]
fn tables_that_contradict_themselves_are_refused() {
    let generate = "generate = { kind = \"cloud\", voxels = 16 }";
    for (keys, says) in [
        ("", "either a file or generate"),
        (&format!("{generate}\nfile = \"a.vdb\""), "either a file or generate"),
        (&format!("{generate}\nframes = [0, 1]"), "has no file"),
        (&format!("{generate}\ndensity = {{ grid = \"a\" }}"), "has no file"),
        (&format!("{generate}\ndensity = {{ factor = -1 }}"), "factor is -1"),
        (&format!("{generate}\ndensity = {{ factr = 1 }}"), "`factor`"),
        (&format!("{generate}\ncolor = [1, 2, 1]"), "color is 2"),
        (&format!("{generate}\nscale = [1, 0, 1]"), "scale has a 0"),
        (&format!("{generate}\ntranslation = [9999999, 0, 0]"), "beyond 1e7 m"),
        ("generate = { kind = \"fog\" }", "`fog`"),
        ("generate = { kind = \"cloud\", voxels = 7 }", "voxels is 7"),
        ("generate = { kind = \"cloud\", size = [1, 0, 1] }", "size is 0"),
        ("generate = { kind = \"cloud\", size = [1e4, 1, 1] }", "slab"),
        ("file = \"nothing.vdb\"", "nothing.vdb"),
        ("file = \".\"", "is a folder"),
    ] {
        let (line, message) = refused(read(&format!("[[volume]]\n{keys}\n")));
        assert!((1..=3).contains(&line) && message.contains(says), "{line}: {message}");
    }
}

#[test]
fn bricks_are_summed_up_before_they_are_made() {
    let cloud = "[[volume]]\ngenerate = { kind = \"explosion\", voxels = 320 }\n";
    let now = std::time::Instant::now();
    let (line, message) = refused(read(&cloud.repeat(8)));
    // 42^3 bricks each: seven fit into 524,288.
    assert!(line == 16 && message.contains("592704 bricks"), "{line}: {message}");
    // Generating one would take minutes.
    assert!(now.elapsed().as_secs() < 10);
    let folder = Folder::new();
    let mut grid = VdbGrid::default();
    for i in 0..1000 {
        grid.tiles.insert(([i % 10 * 128, i / 10 % 10 * 128, i / 100 * 128], 128), (1.0, true));
    }
    folder.write("tiles.vdb", file(Format::default(), &[grid]));
    let table = "[[volume]]\nfile = \"tiles.vdb\"\n";
    let path = folder.write("scene.toml", table.repeat(600));
    let (line, message) = refused(scene::load(&path));
    assert!(line == 525 * 2 && message.contains("525000 bricks"), "{line}: {message}");
}

#[test]
fn a_vdb_file_alone_is_found_by_a_relative_path() {
    let folder = Folder::new();
    std::fs::create_dir(folder.0.join("smoke")).unwrap();
    folder.write("smoke/cube.vdb", cube(3.0));
    for name in ["smoke/cube.vdb", "./smoke/cube.vdb", "smoke/../smoke/cube.vdb"] {
        let mut gobo = Command::new(env!("CARGO_BIN_EXE_gobo"));
        let output = gobo.args(["check", name]).current_dir(&folder.0).output().unwrap();
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn a_vdb_file_alone_is_framed_and_stands_on_a_ground() {
    let folder = Folder::new();
    let path = folder.write("cube.vdb", cube(3.0));
    let scene = scene::load(&path).unwrap();
    // Its bricks reach from -8 to 16.
    let dense = Bounds::new([0.0; 3], [12.0; 3]);
    assert_eq!(scene.triangles.len(), 2);
    let ground = scene.triangles[0].positions[0].y;
    assert!((-0.02..0.0).contains(&ground), "{ground}");
    // The middle of the picture is not the middle of a body that is seen from close by.
    assert!((scene.camera.target - dense.center()).length() < 0.2 * dense.radius());
    assert!(matches!(scene.lights[0].kind, LightKind::Directional { .. }));
    assert!(scene.environment.is_some());
    // An optical depth of 4, in the mean of the columns with bricks.
    let [note] = &scene.notes[..] else { panic!("{:?}", scene.notes) };
    assert!(note.contains("volume.0.density.factor"), "{note}");
    let mean = 3.0 * 12f32.powi(3) / (24.0 * 24.0);
    assert!((scene.grids[0].factor * mean - 4.0).abs() < 0.2, "{}", scene.grids[0].factor);
    let mut options = LoadOptions::default();
    options.set = vec![("volume.0.density.factor".to_owned(), "0.5".to_owned())];
    options.ground = false;
    let scene = scene::load_as(&path, &options).unwrap();
    assert!(scene.grids[0].factor == 0.5 && scene.notes.is_empty() && scene.triangles.is_empty());
    // No key names a file that is the scene.
    let error = scene::load(&folder.write("bad.vdb", "PK")).unwrap_err();
    let SceneError::Invalid { path, message, help } = error else { panic!("{error}") };
    assert!(
        path.ends_with("bad.vdb") && help.is_some() && message.contains("cut off"),
        "{message}"
    );
}
