//! Each kind of file that is read, from a host's memory where there is no file: as the same bytes in the file
//! system.
use crate::common::{
    arrays::{self, Kind, Vti},
    files::Folder,
    nano::{self, Codec},
    points::{self, DOTS},
    splats::{self, SPLATS},
    vdb::{self, VdbGrid},
};
use gobo::glam::IVec3;
use gobo_scene::{self as scene, FORMATS, Family, HeldFile, Scene, format_of, hold_files};
use image::{DynamicImage, ImageFormat, Rgb32FImage, RgbaImage};
use std::{
    fs,
    io::Cursor,
    path::{Path, PathBuf},
};

/// A file to read, and those that lie beside it.
type Files = Vec<(&'static str, Vec<u8>)>;

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl red\nf 1 2 3\n";
const MTL: &str = "newmtl red\nKd 1 0 0\nmap_Kd red.png\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
/// Its triangle is in a file beside it.
const GLTF: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "triangle.bin"}]}"#;
/// Two levels of one SOG, in a folder of its own.
const LEVELS: &str = r#"{"version": 1, "count": 4, "lodLevels": 2, "filenames": ["level/meta.json"], "tree": {"children": [
{"lods": {"0": {"file": 0, "offset": 0, "count": 2}, "1": {"file": 0, "offset": 1, "count": 1}}},
{"lods": {"0": {"file": 0, "offset": 2, "count": 1}}}]}}"#;

fn picture(format: ImageFormat) -> Vec<u8> {
    let image = RgbaImage::from_fn(4, 2, |x, y| image::Rgba([60 * x as u8, 99 * y as u8, 90, 255]));
    let image = match format {
        ImageFormat::Jpeg => DynamicImage::from(image).to_rgb8().into(),
        ImageFormat::OpenExr => {
            Rgb32FImage::from_fn(4, 2, |x, y| image::Rgb([x as f32, y as f32, 0.5])).into()
        }
        _ => DynamicImage::from(image),
    };
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn triangle() -> Vec<u8> {
    [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// KTX 2.0, section 3: 2 x 1 texels of RGBA8.
fn ktx2() -> Vec<u8> {
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let head = [37, 1, 2, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend(head.into_iter().flat_map(u32::to_le_bytes));
    bytes.extend([104_u64, 8, 8].into_iter().flat_map(u64::to_le_bytes));
    bytes.extend([250, 0, 0, 255, 0, 250, 0, 255]);
    bytes
}

fn grid() -> VdbGrid {
    let mut grid = VdbGrid::default();
    (0..5).for_each(|i| grid.set(IVec3::new(i, 2 * i, 3), 1.0 + i as f32));
    grid
}

/// An example of each of the [`FORMATS`], in their order.
fn examples() -> Vec<Files> {
    let png = || picture(ImageFormat::Png);
    let in_level = [
        "level/l.webp",
        "level/u.webp",
        "level/s.webp",
        "level/q.webp",
        "level/c.webp",
        "level/meta.json",
    ];
    let level = splats::sog_files(&SPLATS).into_iter().map(|(name, bytes)| {
        let own = in_level.into_iter().find(|path| path.ends_with(name));
        (own.expect("a file of a SOG"), bytes)
    });
    let array = || arrays::npy(Kind::F32, false, false);
    let nano =
        nano::segment(Codec::Zip, &[("density", nano::FLOAT, nano::grid(nano::FLOAT, 2, &grid()))]);
    let scene = "material = [{ name = \"m\", texture = \"red.png\" }]\n[[particles]]\nfile = \"dots.csv\"\nmaterial = \"m\"\n";
    let csv = || b"x,y,z,radius\n1,2,3,0.5\n4,5,6,0.25\n".to_vec();
    vec![
        vec![("scene.toml", scene.into()), ("dots.csv", csv()), ("red.png", png())],
        vec![("model.gltf", GLTF.into()), ("triangle.bin", triangle())],
        vec![("faces.ply", [PLY, FACES].concat().into())],
        vec![("mesh.obj", OBJ.into()), ("m.mtl", MTL.into()), ("red.png", png())],
        vec![("dots.ply", [PLY, "end_header\n0 0 0\n1 0 0\n1 1 0\n"].concat().into())],
        vec![("dots.csv", csv())],
        vec![("dots.las", points::las(2, &DOTS, [0.0; 3], 257))],
        vec![("dots.laz", points::laz(3, &DOTS, [0.0; 3]))],
        vec![("dots.pcd", points::pcd("binary_compressed", &DOTS))],
        vec![("dots.e57", points::e57(&DOTS))],
        vec![("splats.ply", splats::ply("binary_little_endian", &SPLATS, 9))],
        vec![("splats.compressed.ply", splats::packed_ply(&SPLATS))],
        vec![("splats.splat", splats::bare(&SPLATS))],
        vec![("splats.ksplat", splats::ksplat(1, &SPLATS))],
        vec![("splats.spz", splats::spz(3, &SPLATS))],
        vec![("splats.sog", splats::sog(&SPLATS))],
        [vec![("lod-meta.json", LEVELS.as_bytes().to_vec())], level.collect()].concat(),
        vec![("splats.gltf", splats::gltf(&SPLATS, false).into())],
        vec![("smoke.vdb", vdb::file(vdb::Format::default(), &[grid()]))],
        vec![("smoke.nvdb", nano)],
        vec![("array.npz", arrays::npz(&[("density", array())], true))],
        vec![("array.nrrd", arrays::nrrd(Kind::I16, true, "gzip"))],
        vec![("array.vti", arrays::vti(Kind::I16, false, Vti::Appended, None))],
        vec![("array.nii", arrays::nifti(Kind::I16, true))],
        vec![("array.mha", arrays::meta(Kind::F32, true, true))],
        vec![("array.tif", arrays::tiff(Kind::U16, false, false))],
        vec![("image.png", png())],
        vec![("image.jpg", picture(ImageFormat::Jpeg))],
        vec![("image.webp", picture(ImageFormat::WebP))],
        vec![("image.ktx2", ktx2())],
        vec![(
            "sky.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x64\x78\x8c\x80\x65\x78\x8c\x81"
                .to_vec(),
        )],
        vec![("sky.exr", picture(ImageFormat::OpenExr))],
    ]
}

/// A scene of the file alone, or one that names it.
fn scene_of(family: Family, name: &str) -> String {
    match family {
        Family::Texture => format!("material = [{{ name = \"m\", texture = \"{name}\" }}]\n"),
        Family::Surroundings => format!("[environment]\nfile = \"{name}\"\n"),
        Family::Volume => format!("[[volume]]\nfile = \"{name}\"\n"),
        _ => String::new(),
    }
}

/// All that was read, without the folder's name.
fn read(folder: &Path, file: &str) -> String {
    let read: Scene = scene::load(&folder.join(file)).unwrap_or_else(|error| panic!("{error}"));
    format!("{read:?}").replace(folder.to_str().unwrap(), "FOLDER")
}

#[test]
fn each_format_is_read_from_memory() {
    let examples = examples();
    assert_eq!(examples.len(), FORMATS.len());
    for (format, mut files) in FORMATS.iter().zip(examples) {
        let name = files[0].0;
        assert!(
            format.endings.iter().any(|ending| name.ends_with(ending)),
            "{name}: {}",
            format.name
        );
        let text = scene_of(format.family, name);
        let scene = if text.is_empty() { name } else { "of_file.toml" };
        files.push(("of_file.toml", text.into()));

        let stored = Folder::new();
        for (name, bytes) in &files {
            fs::create_dir_all(stored.0.join(name).parent().unwrap()).unwrap();
            stored.write(name, bytes);
        }
        let expected = read(&stored.0, scene);

        let folder = PathBuf::from(format!("held-{}", format.name.replace(' ', "-")));
        assert!(!folder.exists());
        let held = |(name, bytes): (&str, Vec<u8>)| (folder.join(name), HeldFile::of_bytes(bytes));
        let whole = hold_files(files.clone().into_iter().map(held));
        assert_eq!(
            format_of(&folder.join(name)).map(|it| it.name),
            format_of(&stored.0.join(name)).map(|it| it.name)
        );
        assert!(
            read(&folder, scene) == expected,
            "{}: another scene than of the file system",
            format.name
        );
        drop(whole);

        // A file that lies beside it and is not held is an error or a note, which names it.
        for (beside, _) in files.iter().skip(1).filter(|(name, _)| *name != "of_file.toml") {
            let others = files.iter().filter(|(name, _)| name != beside).cloned();
            let _others = hold_files(others.map(held));
            let told = match scene::load(&folder.join(scene)) {
                Ok(scene) => scene.notes.join("\n"),
                Err(error) => error.to_string(),
            };
            let name = beside.rsplit('/').next().unwrap();
            assert!(told.contains(name), "{}, without {name}: {told:?}", format.name);
        }
    }
}

/// All readers ask one file for bytes, which knows what a host holds.
#[test]
fn readers_have_no_way_of_their_own_to_files() {
    let mut pending = vec![Path::new(crate::common::ROOT).join("crates/gobo-scene/src")];
    let mut asking = Vec::new();
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        if ["fs::read", "fs::File", "fs::metadata", "use std::fs", "std::fs::"]
            .iter()
            .any(|way| text.contains(way))
        {
            asking.push(path.file_name().unwrap().to_owned());
        }
    }
    assert_eq!(asking, ["read.rs"]);
}
