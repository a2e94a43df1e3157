//! Meshes without nodes: PLY with faces and OBJ with its materials; variants and hidden nodes of glTF.
use crate::common::files::Folder;
use gobo::{
    glam::{Vec2, Vec3},
    model::{Transfer, Triangle, VertexColor},
};
use gobo_scene as scene;
use gobo_scene::{Scene, SceneError, generate::Chance};
use image::{ImageFormat, Rgba, RgbaImage};
use std::io::Cursor;

fn refusal(result: Result<Scene, SceneError>) -> String {
    match result {
        Err(error) => format!("{error}; {}", error.help().expect("a remedy")),
        Ok(scene) => panic!("{} triangles read without an error", scene.triangles.len()),
    }
}

/// A single file, without its ground.
fn alone(name: &str, bytes: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
    let folder = Folder::new();
    let mut options = scene::LoadOptions::default();
    options.ground = false;
    scene::load_as(&folder.write(name, bytes), &options)
}

/// A square of two triangles as one polygon, and a triangle; vertices have normals and colours.
fn ply(format: &str, more: &str) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat {format} 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nelement face 2\n{more}property list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let corners = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0]];
    let faces: [&[i32]; 2] = [&[0, 1, 2, 3], &[1, 4, 2]];
    if format == "ascii" {
        for [x, y] in corners {
            file.extend(format!("{x} {y} 0 0 0.6 0.8 255 0 {}\n", 51 * x).bytes());
        }
        for face in faces {
            let words: Vec<String> = face.iter().map(i32::to_string).collect();
            let before = if more.is_empty() { "" } else { "7 " };
            file.extend(format!("{before}{} {}\n", face.len(), words.join(" ")).bytes());
        }
        return file;
    }
    let is_big = format == "binary_big_endian";
    let word =
        |bytes: [u8; 4]| if is_big { [bytes[3], bytes[2], bytes[1], bytes[0]] } else { bytes };
    for [x, y] in corners {
        let numbers = [x as f32, y as f32, 0.0, 0.0, 0.6, 0.8];
        file.extend(numbers.into_iter().flat_map(|number| word(number.to_le_bytes())));
        file.extend([255, 0, 51 * x as u8]);
    }
    for face in faces {
        if !more.is_empty() {
            file.push(7);
        }
        file.push(face.len() as u8);
        file.extend(face.iter().flat_map(|index| word(index.to_le_bytes())));
    }
    file
}

const FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

fn assert_square(triangles: &[Triangle]) {
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let (a, b, c, d, e) =
        (corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0), corner(2.0, 0.0));
    let positions: Vec<_> = triangles.iter().map(|triangle| triangle.positions).collect();
    assert_eq!(positions, [[a, b, c], [a, c, d], [b, e, c]]);
}

#[test]
fn a_ply_with_faces_is_a_mesh() {
    for format in FORMATS {
        for more in ["", "property uchar flags\n"] {
            let scene = alone("m.ply", ply(format, more)).unwrap();
            assert!(scene.particles.is_empty());
            assert_square(&scene.triangles);
            assert_eq!(scene.materials[0].transfer, Transfer::Opaque);
            for triangle in &scene.triangles {
                assert!(
                    triangle
                        .normals
                        .iter()
                        .all(|n| (*n - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6)
                );
                for (color, at) in triangle.colors.iter().zip(triangle.positions) {
                    // sRGB bytes: 51 is 0.0331, 102 is 0.133.
                    let blue = [0.0, 0.0331, 0.1329][at.x as usize];
                    assert_eq!(*color, VertexColor::new(Vec3::new(1.0, 0.0, blue).extend(1.0)));
                }
            }
            let said = scene.notes.iter().any(|note| note.contains("`flags` of faces"));
            assert_eq!(said, !more.is_empty(), "{:?}", scene.notes);
        }
    }
    // As a table, with a placement; and still as particles if a table says so.
    let folder = Folder::new();
    folder.write("m.ply", ply("ascii", ""));
    let text = "[[mesh]]\nfile = \"m.ply\"\ntranslation = [0, 0, 3]\nscale = [2, 2, 2]\n";
    let scene = scene::load(&folder.write("s.toml", text)).unwrap();
    assert_eq!(scene.triangles[2].positions[1], Vec3::new(4.0, 0.0, 3.0));
    let text = "[[material]]\nname = \"m\"\n[[particles]]\nfile = \"m.ply\"\nmaterial = \"m\"\n";
    let scene = scene::load(&folder.write("s.toml", text)).unwrap();
    assert_eq!((scene.particles.len(), scene.triangles.len()), (5, 0));
}

#[test]
fn a_ply_mesh_that_lies_is_refused() {
    let text = String::from_utf8(ply("ascii", "")).unwrap();
    for (from, to, words) in [
        ("face 2", "face 9", "face"),
        ("vertex 5", "vertex 9", "too few"),
        ("4 0 1 2 3", "5 0 1 2 3", "too few"),
        ("face 2", "face 90000000", "90000000"),
        ("property float y\n", "property float w\n", "no column `y`"),
    ] {
        let found = refusal(alone("m.ply", text.replace(from, to)));
        assert!(found.contains(words), "{words}: {found}");
    }
    // Missing corners, and equal ones.
    let scene =
        alone("m.ply", text.replace("3 1 4 2", "3 1 99 2").replace("4 0 1", "4 1 1")).unwrap();
    assert_eq!(scene.skipped.values().sum::<u64>(), 2, "{:?}", scene.skipped);
    let scene = alone("m.ply", text.replace("3 1 4 2", "3 -1 4 2")).unwrap();
    assert_eq!(scene.triangles.len(), 2);
}

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
    vt 0 1\n\
    vn 0 0 2\nusemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1\no second\nusemtl glass\nf -4 -1 -3\n";

const MTL: &str = "newmtl red\nKd 0.5 0.25 0\nmap_Kd -s 1 1 1 sub\\tiles.png\nNs 98\nillum 2\n\
    newmtl glass\nKd 0 1 1\nd 0.25\nKe 2 0 0\n";

fn obj(folder: &Folder, obj: &str, mtl: &str) -> Result<Scene, SceneError> {
    std::fs::create_dir_all(folder.0.join("sub")).unwrap();
    let image = RgbaImage::from_fn(2, 2, |x, y| Rgba([x as u8 * 255, y as u8 * 255, 0, 255]));
    let mut png = Cursor::new(Vec::new());
    image.write_to(&mut png, ImageFormat::Png).unwrap();
    folder.write("sub/tiles.png", png.into_inner());
    let holes = RgbaImage::from_fn(1, 2, |_, y| {
        let cover = y as u8 * 255;
        Rgba([cover, cover, cover, 255])
    });
    let mut png = Cursor::new(Vec::new());
    holes.write_to(&mut png, ImageFormat::Png).unwrap();
    folder.write("holes.png", png.into_inner());
    folder.write("m.mtl", mtl);
    let mut options = scene::LoadOptions::default();
    options.ground = false;
    scene::load_as(&folder.write("m.obj", obj), &options)
}

#[test]
fn an_obj_has_its_materials() {
    let folder = Folder::new();
    let scene = obj(&folder, OBJ, MTL).unwrap();
    assert_square(&scene.triangles);
    let [red, glass] = [0, 2].map(|i| &scene.materials[scene.triangles[i].material as usize]);
    assert_eq!((red.transfer, red.tint.to_array()), (Transfer::Opaque, [0.5, 0.25, 0.0, 1.0]));
    // Ns = 98: alpha^2 = 2 / 100.
    assert!((red.roughness.powi(4) - 0.02).abs() < 1e-4, "{}", red.roughness);
    assert_eq!((glass.transfer, glass.tint.to_array()), (Transfer::Smoke, [0.0, 1.0, 1.0, 0.25]));
    assert_eq!(glass.emission, Vec3::new(2.0, 0.0, 0.0));
    assert_eq!(scene.textures.len(), 1);
    assert!(red.texture.is_some() && glass.texture.is_none());
    // v counts from below.
    assert_eq!(
        scene.triangles[0].uvs,
        [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0)]
    );
    assert!(scene.triangles.iter().all(|triangle| triangle.normals == [Vec3::Z; 3]));
    assert_ne!(scene.triangles[0].id, scene.triangles[2].id);
    // Files for a copy, and another transfer.
    let named = scene::files(&folder.0.join("m.obj")).unwrap();
    assert_eq!(named.len(), 3, "{named:?}");
    let table = folder.write("s.toml", "[[mesh]]\nfile = \"m.obj\"\ntransfer = \"filter\"\n");
    let scene = scene::load(&table).unwrap();
    assert!(scene.materials.iter().any(|material| material.transfer == Transfer::Filter));
}

#[test]
fn an_obj_without_all_its_files_is_read() {
    let folder = Folder::new();
    let scene = obj(&folder, &OBJ.replace("m.mtl", "gone.mtl"), MTL).unwrap();
    assert_square(&scene.triangles);
    assert!(scene.notes.iter().any(|note| note.contains("`gone.mtl`")), "{:?}", scene.notes);
    let scene = obj(&folder, OBJ, &MTL.replace("tiles", "gone")).unwrap();
    assert!(scene.notes.iter().any(|note| note.contains("gone.png")), "{:?}", scene.notes);
    // Nothing outside of the folder is read.
    let scene = obj(&folder, &OBJ.replace("m.mtl", "../m.mtl"), MTL).unwrap();
    assert!(scene.notes.iter().any(|note| note.contains("`../m.mtl`")), "{:?}", scene.notes);
    // A line that cannot be parsed is skipped alone.
    let scene = obj(&folder, OBJ, &MTL.replace("Ns 98", "Ns many")).unwrap();
    assert_eq!(scene.materials[0].tint.to_array(), [0.5, 0.25, 0.0, 1.0]);
    // The alpha image cuts holes.
    let scene = obj(&folder, OBJ, &MTL.replace("illum 2", "map_d holes.png")).unwrap();
    let red = &scene.materials[scene.triangles[0].material as usize];
    assert_eq!(red.transfer, Transfer::Cutout);
    let alphas: Vec<u8> = scene.textures[0].rgba.chunks(4).map(|texel| texel[3]).collect();
    assert_eq!(alphas, [0, 0, 255, 255]);
}

#[test]
fn damaged_meshes_do_not_panic() {
    let folder = Folder::new();
    let mut chance = Chance::new(3);
    for (name, file) in [
        ("m.obj", OBJ.as_bytes().to_vec()),
        ("m.ply", ply("ascii", "")),
        ("m.ply", ply("binary_little_endian", "property uchar flags\n")),
    ] {
        folder.write("m.mtl", MTL);
        for _ in 0..300 {
            let mut changed = file.clone();
            for _ in 0..=chance.bits() % 3 {
                let at = (chance.bits() % file.len() as u64) as usize;
                changed[at] =
                    if chance.bits().is_multiple_of(2) { chance.bits() as u8 } else { b'9' };
            }
            let _ = scene::load(&folder.write(name, changed));
        }
        for length in (0..file.len()).step_by(5) {
            let _ = scene::load(&folder.write(name, &file[..length]));
        }
    }
}

/// A triangle with three materials, by variants; a second, hidden node, and its child with a lamp.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"extensionsUsed":["KHR_materials_variants","KHR_node_visibility","KHR_lights_punctual"],
"extensionsRequired":["KHR_materials_variants"],
"extensions":{"KHR_materials_variants":{"variants":[{"name":"day"},{"name":"night"},{"name":"dusk"}]},
"KHR_lights_punctual":{"lights":[{"type":"point"}]}},
"nodes":[{"mesh":0},{"mesh":0,"children":[2],"extensions":{"KHR_node_visibility":{"visible":false}}},
{"mesh":0,"extensions":{"KHR_lights_punctual":{"light":0}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0,"extensions":{"KHR_materials_variants":
{"mappings":[{"material":1,"variants":[0,2]},{"material":2,"variants":[1]}]}}}]}],
"materials":[{"name":"own"},{"name":"bright"},{"name":"dark"}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;

#[test]
fn the_variant_that_is_asked_for_is_shown() {
    let folder = Folder::new();
    folder.write("m.gltf", GLTF);
    let load = |key: &str| {
        let text = format!("[[mesh]]\nfile = \"m.gltf\"\n{key}\n");
        scene::load(&folder.write("s.toml", text))
    };
    for (key, name) in [
        ("", "own"),
        ("variant = \"day\"", "bright"),
        ("variant = \"night\"", "dark"),
        ("variant = \"dusk\"", "bright"),
    ] {
        let scene = load(key).unwrap();
        assert_eq!(scene.materials[scene.triangles[0].material as usize].name, name);
        let said = scene.notes.iter().any(|note| note.contains("`day`, `night`, `dusk`"));
        assert_eq!(said, key.is_empty(), "{:?}", scene.notes);
    }
    let text = refusal(load("variant = \"nigth\""));
    assert!(text.contains("no variant `nigth`") && text.contains("`night`"), "{text}");
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let other = folder.write("s.toml", "[[mesh]]\nfile = \"m.obj\"\nvariant = \"day\"\n");
    assert!(refusal(scene::load(&other)).contains("no variants"));
}

#[test]
fn hidden_nodes_are_not_shown() {
    let scene = alone("m.gltf", GLTF).unwrap();
    assert_eq!(scene.triangles.len(), 1);
    // The default sun.
    assert_eq!(scene.lights[0].name, "sun");
    assert!(
        scene.notes.iter().any(|note| note.contains("2 meshes are not shown")),
        "{:?}",
        scene.notes
    );
    let shown = GLTF.replace("\"visible\":false", "\"visible\":true");
    let scene = alone("m.gltf", shown).unwrap();
    assert_eq!((scene.triangles.len(), scene.lights.len()), (3, 1));
}

#[test]
fn usd_is_refused_by_name() {
    for (name, start) in
        [("m.usda", "#usda 1.0"), ("m.usd", "PXR-USDC"), ("m.usdz", "PK\x03\x04"), ("m.usdc", "")]
    {
        let text = refusal(alone(name, start));
        assert!(text.contains("is USD") && text.contains("glTF"), "{text}");
        let folder = Folder::new();
        folder.write(name, start);
        let table = folder.write("s.toml", format!("[[mesh]]\nfile = \"{name}\"\n"));
        let text = refusal(scene::load(&table));
        assert!(text.contains("is USD") && text.contains("s.toml:2"), "{text}");
    }
}
