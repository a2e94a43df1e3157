//! `gobo maps` and `gobo merge`: maps of shares of the casters, joined.
use super::commands::{Folder, files};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::{fs, path::Path};

/// Particles of several blocks behind and in front of panes, fur, a blocking box, and a lamp of each kind
/// with one view.
const SCENE: &str = "[shadow]\nsize = 48\n[[light]]\nname = 'sun'\nkind = 'directional'\n\
    direction = [0.2, -1, 0.1]\n\
    [[light]]\nname = 'spot'\nkind = 'spot'\nposition = [1, 4, 1]\ndirection = [-0.2, -1, -0.2]\nangle = 60\n\
    [[material]]\nname = 'smoke'\ntint = [0.9, 0.5, 0.3, 0.05]\n[[material]]\nname = 'puff'\nshape = 'puff'\n\
    tint = [0.2, 0.5, 0.9, 0.1]\n[[material]]\nname = 'glass'\ntint = [0.3, 0.9, 0.4, 0.6]\n\
    [[material]]\nname = 'solid'\ntransfer = 'opaque'\n\
    [[particles]]\nmaterial = 'smoke'\n\
    generate = { kind = 'cloud', count = 4000, radius = 0.06, center = [0, 1, 0] }\n\
    [[particles]]\nmaterial = 'puff'\n\
    generate = { kind = 'dust', count = 1500, radius = 0.05, min = [-1, 0, -1], max = [1, 2, 1] }\n\
    [[shape]]\nkind = 'pane'\nmaterial = 'glass'\ntranslation = [0, 1.5, 0]\nrotation = [90, 0, 0]\n\
    [[shape]]\nkind = 'box'\nmaterial = 'solid'\nscale = [0.5, 0.5, 0.5]\n\
    [[shape]]\nname = 'ball'\nkind = 'sphere'\nmaterial = 'glass'\ntranslation = [0.4, 0.8, 0]\n\
    scale = [0.4, 0.4, 0.4]\n\
    [[strands]]\nmaterial = 'glass'\n\
    generate = { kind = 'fur', on = 'ball', count = 150, length = 0.2, radius = 0.01 }\n";

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    fs::write(folder.0.join("own.toml"), SCENE).unwrap();
    folder
}

/// Writes the parts of all shares; returns their names.
fn parts(folder: &Folder, count: u32, more: &[&str]) -> Vec<String> {
    let part = |index: u32| {
        let (share, name) = (format!("{index}/{count}"), format!("{index}of{count}.gobo"));
        let all = ["maps", "own.toml", "--casters", &share, "-o", &name].into_iter();
        folder.run(&all.chain(more.iter().copied()).collect::<Vec<_>>());
        name
    };
    (0..count).map(part).collect()
}

fn merge(folder: &Folder, parts: &[String], out: &str) {
    let all = ["merge"].into_iter().chain(parts.iter().map(String::as_str)).chain(["-o", out]);
    folder.run(&all.collect::<Vec<_>>());
}

fn same(a: &Path, b: &Path) {
    let names = files(a);
    assert_eq!(names, files(b));
    for name in names {
        assert!(fs::read(a.join(&name)).unwrap() == fs::read(b.join(&name)).unwrap(), "{name}");
    }
}

/// A part with a changed head, and a digest that fits.
fn forged(part: &[u8], change: impl Fn(&mut Value)) -> Vec<u8> {
    let length = u64::from_le_bytes(part[12..20].try_into().unwrap()) as usize;
    let mut head = serde_json::from_slice(&part[20..20 + length]).unwrap();
    change(&mut head);
    let json = serde_json::to_vec(&head).unwrap();
    let mut bytes = part[..12].to_vec();
    bytes.extend((json.len() as u64).to_le_bytes());
    bytes.extend(json);
    bytes.extend(&part[20 + length..part.len() - 32]);
    let digest = Sha256::digest(&bytes);
    bytes.extend(&digest[..]);
    bytes
}

/// A part can name only plain files in the folder, whoever wrote it.
#[test]
fn a_part_names_no_files_elsewhere() {
    let folder = Folder::new("shares-forged");
    fs::create_dir(folder.0.join("o")).unwrap();
    folder.run(&["maps", "scene.toml", "-o", "a.gobo", "--backend", "cpu"]);
    let part = fs::read(folder.0.join("a.gobo")).unwrap();
    let merge = |bytes: &[u8]| {
        fs::write(folder.0.join("b.gobo"), bytes).unwrap();
        folder.gobo(&["merge", "b.gobo", "-o", "o"])
    };
    let absolute = folder.0.join("evil").display().to_string();
    let long = "n".repeat(5000);
    let names = [
        &absolute,
        "../evil",
        "../../../evil",
        "a/b",
        "a\\b",
        "..",
        ".",
        "",
        ".evil",
        "c:evil",
        "a\u{1b}[2Jb",
        "a\0b",
        "a\u{202e}b",
        &long,
    ];
    let before = files(&folder.0).len() + 1;
    let refused = |change: &dyn Fn(&mut Value), what: &str| {
        let output = merge(&forged(&part, change));
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{what:?}: {said}");
        assert!(said.len() < 1000 && !said.contains('\u{1b}'), "{what:?}: {said}");
        assert_eq!(files(&folder.0).len(), before, "{what:?} writes");
    };
    for name in names {
        let rename = |head: &mut Value| {
            let mut views: Value = serde_json::from_str(head["views"].as_str().unwrap()).unwrap();
            head["names"][0] = name.into();
            // Even where the views agree.
            let (light, view) = name.split_once('.').unwrap_or((name, ""));
            (views[0]["light"], views[0]["view"]) = (light.into(), view.into());
            head["views"] = views.to_string().into();
        };
        refused(&rename, name);
    }
    refused(&|head| head["names"][1] = head["names"][0].clone(), "twice");
    refused(&|head| head["views"] = "[]".into(), "no views");
    refused(&|head| head["views"] = "\u{1b}[2J".into(), "no JSON");
    refused(&|head| head["gobo"] = long.clone().into(), "a long version");
    refused(&|head| head["scene"] = "\u{1b}".into(), "a digest that is none");
    refused(&|head| head["nodes"] = 1_000_000_000.into(), "nodes");
    refused(&|head| head["sizes"][0] = [0, 0].into(), "no texels");
    refused(&|head| head["sizes"][0] = [u32::MAX, u32::MAX].into(), "many texels");
    refused(&|head| head["sizes"][0] = [4096, 4096].into(), "texels that are not there");
    let mut claims = part.clone();
    claims[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    assert_eq!(merge(&claims).status.code(), Some(2));
    // The first texel's nearest depth, after three sums.
    let mut deep = part.clone();
    let first = 20 + u64::from_le_bytes(part[12..20].try_into().unwrap()) as usize;
    deep[first + 12..first + 16].fill(0xff);
    assert_eq!(merge(&forged(&deep, |_| ())).status.code(), Some(2), "a depth that is none");
    // The same with nothing changed.
    assert_eq!(merge(&forged(&part, |_| ())).status.code(), Some(0));
}

/// Values of an array.
fn array(path: &Path) -> Vec<f32> {
    let bytes = fs::read(path).unwrap();
    let first = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    bytes[first..].chunks_exact(4).map(|v| f32::from_le_bytes(v.try_into().unwrap())).collect()
}

/// Largest difference between the arrays of two folders whose names have this ending.
fn apart(a: &Path, b: &Path, end: &str) -> f32 {
    let names: Vec<_> = files(a).into_iter().filter(|name| name.ends_with(end)).collect();
    assert_eq!(names.len(), 2, "one of each light");
    let apart = names.iter().flat_map(|name| {
        let (a, b) = (array(&a.join(name)), array(&b.join(name)));
        assert_eq!(a.len(), b.len());
        a.into_iter().zip(b).map(|(a, b)| (a - b).abs())
    });
    apart.fold(0.0, f32::max)
}

#[test]
fn any_number_of_shares_in_any_order_gives_the_same_maps() {
    let folder = folder("shares");
    // Joined curves are as good as those of one share, but not the same.
    let nearest = ["--set", "shadow.receiver=nearest"];
    let one = parts(&folder, 1, &nearest);
    let mut five = parts(&folder, 5, &nearest);
    five.swap(0, 3);
    merge(&folder, &one, "one");
    merge(&folder, &five, "five");
    let [one, five, whole] = ["one", "five", "whole"].map(|name| folder.0.join(name));
    same(&one, &five);
    folder.run(&["render", "own.toml", "--maps", "-o", "whole", nearest[0], nearest[1]]);
    fs::remove_file(whole.join("frame_0000.png")).unwrap();
    assert_eq!(files(&one), files(&whole));
    // A dither rounds each caster's optical depth to 2^-16; the maps hold half floats.
    assert!(apart(&one, &whole, ".filter.npy") <= 1.0 / 1024.0);
    assert!(array(&one.join("maps/frame_0000/sun.0.filter.npy")).iter().any(|&f| f < 0.5));
    assert!(apart(&one, &whole, ".nearest.npy") <= 0.0);
    assert!(apart(&one, &whole, ".opaque.npy") <= 0.0);
    let json = "maps/frame_0000/views.json";
    assert_eq!(fs::read(one.join(json)).unwrap(), fs::read(whole.join(json)).unwrap());
}

#[test]
fn the_cpu_reference_adds_up_the_same() {
    let folder = folder("shares-cpu");
    for (backend, out) in [("cpu", "cpu"), ("auto", "auto")] {
        let parts = parts(&folder, 2, &["--backend", backend]);
        merge(&folder, &parts, out);
    }
    let [cpu, auto] = ["cpu", "auto"].map(|name| folder.0.join(name));
    // Logarithms differ by a step of 2^-16 per caster, on either side of the dither, and half floats round.
    assert!(apart(&cpu, &auto, ".filter.npy") <= 2.0 / 1024.0);
    assert!(apart(&cpu, &auto, ".nearest.npy") <= 1e-5);
}

#[test]
fn curves_are_joined_within_their_bound() {
    let folder = folder("shares-curve");
    let three = parts(&folder, 3, &[]);
    merge(&folder, &three, "three");
    folder.run(&["render", "own.toml", "--maps", "-o", "whole"]);
    let [three, whole] = ["three", "whole"].map(|name| folder.0.join(name));
    fs::remove_file(whole.join("frame_0000.png")).unwrap();
    assert_eq!(files(&three), files(&whole));
    assert!(apart(&three, &whole, ".filter.npy") <= 2.0 / 1024.0);
    // Light at depths, from the nodes: start, end, light behind.
    let light = |nodes: &[f32], z: f32| {
        let mut before = 1.0;
        for node in nodes.chunks_exact(5) {
            if z < node[0] {
                break;
            }
            let share = ((z - node[0]) / (node[1] - node[0]).max(1e-9)).min(1.0);
            if share < 1.0 {
                return before + (node[2] - before) * share;
            }
            before = node[2];
        }
        before
    };
    let [ours, theirs] =
        [&three, &whole].map(|dir| array(&dir.join("maps/frame_0000/sun.0.curve.npy")));
    let (mut sum, mut count) = (0.0, 0);
    for (a, b) in ours.chunks_exact(8 * 5).zip(theirs.chunks_exact(8 * 5)) {
        for z in (1..32).map(|i| i as f32 / 32.0) {
            sum += f64::from((light(a, z) - light(b, z)).abs());
            count += 1;
        }
    }
    let mean = sum / f64::from(count);
    // Both are within 0.004 of the truth, as in tests/maps/curve.rs.
    assert!(mean <= 0.004, "{mean}");
}

#[test]
fn parts_that_do_not_belong_together_are_refused() {
    let folder = folder("shares-wrong");
    let parts = parts(&folder, 2, &["--backend", "cpu"]);
    let (a, b) = (parts[0].as_str(), parts[1].as_str());
    assert!(folder.fail(&["merge", a], 2).contains("share 1/2 is missing"));
    assert!(folder.fail(&["merge", b, b], 2).contains("name each share once"));
    let foreign =
        ["maps", "own.toml", "--casters", "1/2", "-o", "c.gobo", "--set", "shadow.size=32"];
    folder.run(&[&foreign[..], &["--backend", "cpu"]].concat());
    let error = folder.fail(&["merge", a, "c.gobo"], 2);
    let named = format!("c.gobo: is of another scene, or of other options, than {a}\n");
    assert!(error.contains(&named), "{error}");
    let late = ["maps", "own.toml", "--casters", "1/2", "-o", "c.gobo", "--frame", "1"];
    folder.run(&[&late[..], &["--backend", "cpu"]].concat());
    let error = folder.fail(&["merge", a, "c.gobo"], 2);
    assert!(error.contains(&format!("c.gobo: is of another frame than {a}\n")), "{error}");
    // The scene's own file is the same, but not the file that it names.
    let named = format!("{SCENE}[[material]]\nname = 'gel'\ntexture = 'gel.png'\n");
    fs::write(folder.0.join("named.toml"), named).unwrap();
    for (name, red) in [("d.gobo", 200), ("e.gobo", 201)] {
        let image = image::RgbImage::from_pixel(2, 2, image::Rgb([red, 90, 40]));
        image.save(folder.0.join("gel.png")).unwrap();
        let share = if red == 200 { "0/2" } else { "1/2" };
        folder.run(&["maps", "named.toml", "--casters", share, "-o", name, "--backend", "cpu"]);
    }
    assert!(folder.fail(&["merge", "d.gobo", "e.gobo"], 2).contains("another scene"));
    let bytes = fs::read(folder.0.join(a)).unwrap();
    let mut changed = bytes.clone();
    let middle = bytes.len() / 2;
    changed[middle] ^= 1;
    for (wrong, what) in [
        (&changed[..], "digest"),
        (&bytes[..middle], "damaged"),
        (&bytes[..5], "no part"),
        (b"", "no part"),
    ] {
        fs::write(folder.0.join("wrong.gobo"), wrong).unwrap();
        assert!(folder.fail(&["merge", "wrong.gobo", b], 2).contains(what), "{what}");
    }
    assert!(!folder.0.join("out").exists(), "nothing is written of what is refused");
    for (key, value, what) in [
        ("material.smoke.transfer", "over", "order"),
        ("material.glass.transfer", "gain", "amplifies"),
        ("shadow.blur", "2", "blurred"),
    ] {
        let set = format!("{key}={value}");
        let all = ["maps", "own.toml", "-o", "d.gobo", "--backend", "cpu", "--set", &set];
        assert!(folder.fail(&all, 2).contains(what), "{set}");
    }
    assert!(
        folder.fail(&["maps", "own.toml", "-o", "d.gobo", "--casters", "2/2"], 2).contains("2/2")
    );
}
