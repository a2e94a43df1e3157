//! Splats in folders: unzipped SOG, and streamed SOG at several levels of detail.
use crate::common::{
    files::Folder,
    splats::{SPLATS, Stored, sog_files},
};
use gobo::model::Gaussian;
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError, load_splats};
use std::{fs, path::Path};

fn write_sog(folder: &Path, splats: &[Stored]) {
    fs::create_dir_all(folder).unwrap();
    for (name, bytes) in sog_files(splats) {
        fs::write(folder.join(name), bytes).unwrap();
    }
}

fn refusal<T>(result: Result<T, SceneError>) -> String {
    match result {
        Err(error) => format!("{error}; {}", error.help().expect("a remedy")),
        Ok(_) => panic!("read without an error"),
    }
}

fn at(splat: &Gaussian, stored: &Stored) -> bool {
    (0..3).all(|k| (f64::from(splat.center[k]) - stored.center[k]).abs() < 3e-4)
}

/// By the folder and by its `meta.json`, as a single file and named by a scene.
#[test]
fn a_sog_in_a_folder_is_read() {
    let folder = Folder::new();
    let own = folder.0.join("capture");
    write_sog(&own, &SPLATS);
    for path in [own.clone(), own.join("meta.json")] {
        let cloud = load_splats(&path).unwrap();
        assert_eq!(cloud.splats.len(), 3);
        assert!(cloud.splats.iter().zip(&SPLATS).all(|(splat, stored)| at(splat, stored)));
        assert_eq!(scene::load(&path).unwrap().gaussians.len(), 3);
    }
    // By its contents, whatever its name.
    fs::copy(own.join("meta.json"), own.join("other.txt")).unwrap();
    fs::write(own.join("meta.json"), "{}").unwrap();
    assert_eq!(load_splats(&own.join("other.txt")).unwrap().splats.len(), 3);
    fs::rename(own.join("other.txt"), own.join("meta.json")).unwrap();
    let table = folder.write("s.toml", "[[splats]]\nfile = \"capture\"\n");
    assert_eq!(scene::load(&table).unwrap().gaussians.len(), 3);
    // Files for a copy of the scene.
    let named = scene::files(&table).unwrap();
    assert_eq!(named.len(), 1 + 6, "{named:?}");
    assert!(named.contains(&own.join("q.webp")), "{named:?}");
}

#[test]
fn a_sog_in_a_folder_that_is_not_whole_is_refused() {
    let folder = Folder::new();
    let own = folder.0.join("capture");
    write_sog(&own, &SPLATS);
    let meta = fs::read_to_string(own.join("meta.json")).unwrap();
    for (from, to, words) in [
        ("l.webp", "gone.webp", "`gone.webp`"),
        ("l.webp", "../l.webp", "leaves the folder"),
        ("l.webp", "/l.webp", "leaves the folder"),
        ("\"count\": 3", "\"count\": 9", "4 texels for 9 splats"),
        ("\"count\": 3", "\"count\": 99000000", "99000000 splats, but a scene has at most"),
        ("\"version\": 2", "\"version\": 1", "version 2"),
        ("\"quats\"", "\"quads\"", "quats"),
    ] {
        fs::write(own.join("meta.json"), meta.replacen(from, to, 1)).unwrap();
        let text = refusal(load_splats(&own));
        assert!(text.contains(words), "{words}: {text}");
    }
    // By its name, whatever its contents.
    for bytes in ["", "{}", "[1]"] {
        fs::write(own.join("meta.json"), bytes).unwrap();
        let text = refusal(load_splats(&own.join("meta.json")));
        assert!(text.contains("meta.json"), "{text}");
    }
    let text = refusal(load_splats(&folder.0));
    assert!(text.contains("is a folder"), "{text}");
}

/// Two regions: the first has splats 0 and 1 at level 0 and one splat at level 1, the second only splat 2 at
/// level 0.
const TREE: &str = r#"{"version": 1, "count": 4, "counts": [3, 1], "lodLevels": 2,
"filenames": ["0_0/meta.json", "1_0/meta.json"], "environment": "env/meta.json",
"tree": {"bound": {"min": [0, 0, 0], "max": [1, 1, 1]}, "children": [
{"bound": {}, "lods": {"0": {"file": 0, "offset": 0, "count": 2}, "1": {"file": 1, "offset": 0, "count": 1}}},
{"bound": {}, "lods": {"0": {"file": 0, "offset": 2, "count": 1}}}]}}"#;

fn streamed(tree: &str) -> (Folder, std::path::PathBuf) {
    let folder = Folder::new();
    write_sog(&folder.0.join("0_0"), &SPLATS);
    write_sog(&folder.0.join("1_0"), &SPLATS[1..2]);
    write_sog(&folder.0.join("env"), &SPLATS[..1]);
    let path = folder.write("lod-meta.json", tree);
    (folder, path)
}

#[test]
fn the_level_that_is_asked_for_is_read() {
    let (folder, path) = streamed(TREE);
    let load = |lod: &str| {
        let text = format!("[[splats]]\nfile = \"lod-meta.json\"\n{lod}\n");
        scene::load(&folder.write("s.toml", text))
    };
    let says = |scene: &Scene, words: &str| scene.notes.iter().any(|note| note.contains(words));
    for (lod, all, words) in [
        ("", &[0, 1, 2, 0][..], "level 0 of detail of 0 to 1 is read, with 3 splats"),
        ("lod = 0", &[0, 1, 2, 0], "level 0 of detail"),
        ("lod = 1", &[1, 0], "level 1 of detail of 0 to 1 is read, with 1 splats"),
    ] {
        let scene = load(lod).unwrap();
        assert_eq!(scene.gaussians.len(), all.len(), "{lod}");
        for (splat, &stored) in scene.gaussians.iter().zip(all) {
            assert!(at(splat, &SPLATS[stored]), "{lod}: {} of {stored}", splat.center);
        }
        assert!(says(&scene, words), "{:?}", scene.notes);
        assert!(says(&scene, "1 splats of its surroundings"), "{:?}", scene.notes);
        assert_eq!(says(&scene, "1 of 2 regions have no such level"), lod == "lod = 1");
    }
    assert!(refusal(load("lod = 2")).contains("levels 0 to 1"));
    // As a single file, by the folder, too.
    for alone in [&path, &folder.0] {
        let set = [("splats.0.lod".to_owned(), "1".to_owned())];
        assert_eq!(scene::load_with(alone, &set).unwrap().gaussians.len(), 2);
        assert_eq!(scene::load(alone).unwrap().gaussians.len(), 4);
    }
    let other = folder.write("s.toml", "[[splats]]\nfile = \"0_0/meta.json\"\nlod = 0\n");
    assert!(refusal(scene::load(&other)).contains("without levels of detail"));
    assert_eq!(
        scene::files(&folder.write("s.toml", "[[splats]]\nfile = \".\"\n")).unwrap().len(),
        20
    );
}

/// Without a key, the finest level with at most four million splats.
#[test]
fn the_budget_takes_a_coarser_level() {
    let large = TREE.replace("\"count\": 2}", "\"count\": 4000001}");
    let (_folder, path) = streamed(&large);
    let cloud = load_splats(&path).unwrap();
    assert!(at(&cloud.splats[0], &SPLATS[1]), "{:?}", cloud.splats);
    assert!(cloud.notes.iter().any(|note| note.contains("level 1 of detail")), "{:?}", cloud.notes);
    let set = [("splats.0.lod".to_owned(), "0".to_owned())];
    let text = refusal(scene::load_with(&path, &set));
    assert!(text.contains("has 3 splats, and the tree names 4000001"), "{text}");
    let (_folder, path) = streamed(&TREE.replace("\"count\": 2}", "\"count\": 40000000}"));
    let text = refusal(scene::load_with(&path, &set));
    assert!(text.contains("40000002 splats") && text.contains("coarser level"), "{text}");
}

/// A box whose second-longest side is 2, with one region whose largest face is 1/4 x 1/4: levels of 64, 16
/// and 4 splats are 1/32, 1/16 and 1/8 apart.
const BOXED: &str = r#"{"version": 1, "count": 84, "counts": [64, 16, 4], "lodLevels": 3,
"filenames": ["0_0/meta.json"], "tree": {"bound": {"min": [-1, 0, 3], "max": [2, 1, 5]}, "children": [
{"bound": {"min": [0, 0, 3], "max": [0.25, 0.125, 3.25]}, "lods": {"0": {"file": 0, "offset": 0, "count": 64},
"1": {"file": 0, "offset": 0, "count": 16}, "2": {"file": 0, "offset": 0, "count": 4}}}]}}"#;

/// Without a key, the coarsest level whose splats are no farther apart than texels of the largest map, or
/// pixels where those are more.
#[test]
fn texels_choose_the_level() {
    let folder = Folder::new();
    let many: Vec<Stored> = SPLATS.iter().cycle().take(64).copied().collect();
    write_sog(&folder.0.join("0_0"), &many);
    folder.write("lod-meta.json", BOXED);
    let chosen = |map: u32, light: u32, picture: u32, words: &str| {
        let scene = scene::load(&folder.write(
            "s.toml",
            format!(
                "[shadow]\nsize = {map}\n[camera]\nsize = [4, {picture}]\n\
                 [[light]]\nkind = 'directional'\ndirection = [0, -1, 0]\nsize = {light}\n\
                 [[splats]]\nfile = 'lod-meta.json'\n"
            ),
        ));
        let notes = scene.unwrap().notes.join("; ");
        assert!(notes.contains(words), "{map}, {light}, {picture}: {notes}");
    };
    let coarsest = "level 2 of detail of 0 to 2 is read, with 4 splats of 64, the coarsest whose splats are no \
                    farther apart than 1/16 of its extent";
    chosen(16, 16, 16, coarsest);
    for (map, light, picture) in [(17, 16, 16), (16, 32, 16), (16, 16, 32)] {
        chosen(map, light, picture, "level 1 of detail of 0 to 2 is read, with 16 splats of 64");
    }
    for (map, light, picture) in [(33, 16, 16), (16, 64, 16), (16, 16, 64)] {
        chosen(
            map,
            light,
            picture,
            "level 0 of detail of 0 to 2 is read, with 64 splats of 64, the coarsest",
        );
    }
    chosen(65, 16, 16, "the finest: its splats are farther apart than 1/65 of its extent");
    // A level that some regions lack leaves holes.
    let region = "\"2\": {\"file\": 0, \"offset\": 0, \"count\": 4}}}";
    let holed = format!(
        "{region}, {{\"lods\": {{\"0\": {{\"file\": 0, \"offset\": 0, \"count\": 0}}, \
                         \"1\": {{\"file\": 0, \"offset\": 0, \"count\": 0}}}}}}"
    );
    folder.write("lod-meta.json", BOXED.replace(region, &holed));
    chosen(16, 16, 16, "level 1 of detail");
}

#[test]
fn trees_that_lie_are_refused() {
    for (from, to, words) in [
        ("\"file\": 1", "\"file\": 7", "names file 7 of 2"),
        ("\"lodLevels\": 2", "\"lodLevels\": 1", "level 1 of 1"),
        ("\"lodLevels\": 2", "\"lodLevels\": 0", "0 levels"),
        ("1_0/meta.json", "../1_0/meta.json", "leaves the folder"),
        ("1_0/meta.json", "2_0/meta.json", "2_0/meta.json"),
        ("env/meta.json", "../env/meta.json", "leaves the folder"),
        ("\"tree\"", "\"trees\"", "tree"),
        (
            "\"offset\": 0, \"count\": 1}",
            "\"offset\": 18446744073709551615, \"count\": 1}",
            "the tree names",
        ),
    ] {
        let (_folder, path) = streamed(&TREE.replacen(from, to, 1));
        let set = [("splats.0.lod".to_owned(), "1".to_owned())];
        let text = refusal(scene::load_with(&path, &set));
        assert!(text.contains(words), "{words}: {text}");
    }
    for length in 0..TREE.len() {
        let (_folder, path) = streamed(&TREE[..length]);
        assert!(load_splats(&path).is_err(), "{length} bytes");
    }
}
