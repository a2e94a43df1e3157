//! Seed files: scenes of the project, and small files of each other kind.
use super::{
    Reader,
    arrays::{self, Kind, Vti},
    beside, models,
    nano::{self, Codec},
    points::{self, DOTS},
    splats::{self, SPLATS},
    vdb::{Format, Packing, VdbGrid, file},
};
use flate2::{Compression, write::ZlibEncoder};
use gobo::{
    glam::{IVec3, Vec3},
    model::Gaussian,
};
use gobo_scene::splats::{Harmonics, to_sog};
use image::{DynamicImage, ImageFormat, RgbaImage};
use std::{
    fmt::Write as _,
    fs,
    io::{self, Cursor, Write as _},
    path::{Path, PathBuf},
};

const PLANE: &str = "shape = [{ kind = \"pane\", material = \"m\" }]\n";
/// Largest seed; larger ones are slow to read and add nothing new [bytes].
const LARGEST: usize = 6000;

/// Model whose texture file `ktx2` changes.
const TEXTURED: &str = "textured.gltf";

/// All readers; models that scenes name are written to `out`.
pub(super) fn readers(out: &Path) -> io::Result<Vec<Reader>> {
    fs::write(out.join(TEXTURED), models::textured("current.ktx2"))?;
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let alone = |name, extension, seeds| Reader { name, extension, seeds, scene: None };
    // In a scene with a point light: the default sun of a single file has a size, for which the CPU renders
    // 64 maps.
    let in_table = |table: &str, name, extension: &'static str, seeds| Reader {
        name,
        extension,
        seeds,
        scene: Some(format!("[[{table}]]\nfile = \"current.{extension}\"\n")),
    };
    let textured = |name, extension, seed| Reader {
        name,
        extension,
        seeds: vec![seed],
        scene: Some(format!(
            "material = [{{ name = \"m\", texture = \"current.{extension}\" }}]\n{PLANE}"
        )),
    };
    let surroundings = Reader {
        name: "hdr",
        extension: "hdr",
        seeds: vec![hdr()],
        scene: Some(format!(
            "material = [{{ name = \"m\" }}]\n{PLANE}[environment]\nfile = \"current.hdr\"\n"
        )),
    };
    let exr = Reader {
        name: "exr",
        extension: "exr",
        seeds: vec![exr()?],
        scene: Some(format!(
            "material = [{{ name = \"m\" }}]\n{PLANE}[environment]\nfile = \"current.exr\"\n"
        )),
    };
    let colored = Reader {
        name: "vdb_colors",
        extension: "vdb",
        seeds: vdb(),
        scene: Some("[[volume]]\nfile = \"current.vdb\"\ncolor_grid = \"Cd\"\n".to_owned()),
    };
    let basis = Reader {
        name: "ktx2",
        extension: "ktx2",
        seeds: vec![
            include_bytes!("../../tests/scene/tiles_etc1s.ktx2").to_vec(),
            include_bytes!("../../tests/scene/tiles_uastc.ktx2").to_vec(),
            ktx2(false)?,
            ktx2(true)?,
        ],
        scene: Some(format!("[[mesh]]\nfile = \"{TEXTURED}\"\n")),
    };
    let models = models::seeds().map(|(name, seeds)| alone(name, "gltf", seeds));
    let glass = fs::read(root.join("data/gallery/wine_glass.glb"))?;
    let mut readers = vec![
        alone("toml", "toml", scenes()?),
        alone("csv", "csv", vec![csv()]),
        alone(
            "ply",
            "ply",
            vec![ply("ascii"), ply("binary_little_endian"), ply("binary_big_endian")],
        ),
        in_table("volume", "vdb", "vdb", vdb()),
        alone("gltf", "gltf", vec![gltf()]),
        alone("glb", "glb", vec![glb(&gltf()), glass]),
        textured("png", "png", picture(ImageFormat::Png)?),
        textured("jpeg", "jpg", picture(ImageFormat::Jpeg)?),
        textured("webp", "webp", picture(ImageFormat::WebP)?),
        surroundings,
        exr,
        basis,
        alone("draco", "glb", models::draco()?),
        colored,
    ];
    readers.extend(models);
    let splats = |(name, extension, seeds)| in_table("splats", name, extension, seeds);
    readers.extend(splat_files().map(splats));
    readers.extend(mesh_files().map(|(name, extension, seeds)| alone(name, extension, seeds)));
    readers.extend(point_files().map(|(name, extension, seeds)| alone(name, extension, seeds)));
    let octree = Reader {
        name: "copc",
        extension: "laz",
        seeds: vec![points::copc(&[&DOTS[..1], &DOTS[1..3], &DOTS[3..]])],
        scene: Some(
            "[[material]]\nname = \"m\"\n[[particles]]\nfile = \"current.laz\"\nmaterial = \"m\"\n\
             point_budget = 3\nclasses = [[5, 0.5], [6, 0]]\n"
                .to_owned(),
        ),
    };
    readers.push(octree);
    let arrays = |(name, extension, seeds)| in_table("volume", name, extension, seeds);
    readers.extend(array_files().map(arrays));
    readers.extend(beside::readers(out)?);
    Ok(readers)
}

/// Point clouds in each format.
fn point_files() -> [Files; 3] {
    let still = [0.0; 3];
    let las = [2, 7].map(|format| points::las(format, &DOTS, still, 257));
    let laz = [3, 7].map(|format| points::laz(format, &DOTS, still));
    let encodings = ["ascii", "binary", "binary_compressed"];
    [
        ("las", "las", [las, laz].concat()),
        ("pcd", "pcd", encodings.map(|name| points::pcd(name, &DOTS)).into()),
        ("e57", "e57", vec![points::e57(&DOTS)]),
    ]
}

/// Meshes without nodes.
fn mesh_files() -> [Files; 2] {
    let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n\
        property list uchar int vertex_indices\nend_header\n";
    let rows = "0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 9 9 9\n0 1 1 7 8 9\n4 0 1 2 3\n3 0 2 1\n";
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\nusemtl red\n\
        f 1/1/1 2/2/1 3/2/1 4/1/1\no second\nf -4 -1 -3\nf 1//1 2//1 3//1\n";
    [
        ("mesh_ply", "ply", vec![(head.to_owned() + rows).into_bytes()]),
        ("obj", "obj", vec![obj.as_bytes().to_vec()]),
    ]
}

/// Name of a reader, extension of its files, and seeds.
type Files = (&'static str, &'static str, Vec<Vec<u8>>);

/// A SOG of a splat with harmonics of degree 1.
fn sog_with_harmonics() -> Vec<u8> {
    let splat = Gaussian { sigma: Vec3::splat(0.1), ..Gaussian::default() };
    let harmonics = Harmonics { count: 3, coefficients: vec![[0.25; 3]; 3] };
    to_sog(&[splat], &[Vec3::ONE], &harmonics).expect("a splat of finite numbers")
}

/// Splats in each format.
fn splat_files() -> [Files; 9] {
    let encodings = ["ascii", "binary_little_endian", "binary_big_endian"];
    let of_gltf = |logarithms| splats::gltf(&SPLATS, logarithms).into_bytes();
    [
        ("splats_ply", "ply", encodings.map(|name| splats::ply(name, &SPLATS, 9)).into()),
        ("compressed_ply", "ply", vec![splats::packed_ply(&SPLATS)]),
        ("splat", "splat", vec![splats::bare(&SPLATS)]),
        ("spz", "spz", [1, 2, 3, 4].map(|version| splats::spz(version, &SPLATS)).into()),
        ("sog", "sog", vec![splats::sog(&SPLATS), sog_with_harmonics()]),
        ("khr_splats", "gltf", [false, true].map(of_gltf).into()),
        ("medium_ply", "ply", vec![medium()]),
        ("ksplat", "ksplat", [0, 1, 2].map(|level| splats::ksplat(level, &SPLATS)).into()),
        ("spz_gltf", "gltf", vec![splats::gltf_spz(&SPLATS).into_bytes()]),
    ]
}

/// Dense arrays in each format.
fn array_files() -> [(&'static str, &'static str, Vec<Vec<u8>>); 8] {
    let mut grid = VdbGrid::default();
    grid.set(IVec3::new(1, 2, 3), 4.0);
    grid.tiles.insert(([8, 0, 0], 8), (2.0, true));
    let nano =
        |(kind, codec)| nano::segment(codec, &[("density", kind, nano::grid(kind, 2, &grid))]);
    let nano =
        [(nano::FLOAT, Codec::Zip), (nano::FPN, Codec::Zip), (nano::HALF, Codec::Blosc)].map(nano);
    let packers = [None, Some("vtkZLibDataCompressor"), Some("vtkLZ4DataCompressor")];
    let ways = [Vti::Ascii, Vti::Inline, Vti::Appended, Vti::Raw];
    let vti = |way| packers.map(|packer| arrays::vti(Kind::I16, false, way, packer));
    let array = arrays::npy(Kind::F16, false, false);
    let archive = |is_packed| arrays::npz(&[("density", array.clone())], is_packed);
    [
        ("npy_volume", "npy", vec![array.clone(), arrays::npy(Kind::I16, true, true)]),
        ("nvdb", "nvdb", nano.into()),
        ("npz", "npz", [false, true].map(archive).into()),
        (
            "nrrd",
            "nrrd",
            ["raw", "gzip", "ascii"].map(|name| arrays::nrrd(Kind::I16, true, name)).into(),
        ),
        ("vti", "vti", ways.map(vti).concat()),
        (
            "nii",
            "nii",
            vec![arrays::nifti(Kind::I16, true), arrays::gzip(&arrays::nifti(Kind::F32, false))],
        ),
        ("mha", "mha", [false, true].map(|packed| arrays::meta(Kind::F32, packed, packed)).into()),
        ("tif", "tif", [false, true].map(|packed| arrays::tiff(Kind::U16, packed, packed)).into()),
    ]
}

/// Volumetric primitives: a medium of two.
fn medium() -> Vec<u8> {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 2\n".to_owned();
    for column in
        "x y z albedo_0 albedo_1 albedo_2 sigma_t_0 scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3"
            .split(' ')
    {
        let _ = writeln!(text, "property float {column}");
    }
    text += "end_header\n1 2 3 0.9 0.8 0.7 0.002 -2.3 -2.5 -1 1 0 0 0\n";
    text += "0 0 0 0.9 0.8 0.7 0.001 -2 -2.3 -2 0.5 0.5 0.5 0.5\n";
    text.into_bytes()
}

/// A few voxels and a tile, and colours that change within both, in each encoding. Only one has a tile of
/// many bricks, which take most of the time.
fn vdb() -> Vec<Vec<u8>> {
    let mut grid = VdbGrid::default();
    for i in 0..40 {
        grid.set(IVec3::new(i * 7 % 19, i * 5 % 17, i * 3 % 11) - 4, i as f32 / 8.0);
    }
    let written = |(packing, edge): (Packing, i32)| {
        let mut grid = grid.clone();
        let mut colors = VdbGrid {
            name: "Cd",
            kind: "Tree_vec3s_5_4_3",
            channels: &[1.0, 0.5, 0.125],
            background: 1.0,
            ..grid.clone()
        };
        colors.set(IVec3::new(edge + 2, 1, 1), 0.5);
        grid.tiles.insert(([edge, 0, 0], edge), (0.25, true));
        file(Format { packing, ..Format::default() }, &[grid, colors])
    };
    [(Packing::Plain, 128), (Packing::Plain, 8), (Packing::Zip, 8), (Packing::Blosc, 8)]
        .map(written)
        .into()
}

fn scenes() -> io::Result<Vec<Vec<u8>>> {
    let mut found = Vec::new();
    for folder in folders() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                found.push((path.clone(), fs::read(path)?));
            }
        }
    }
    found.push(("emitter".into(), EMITTER.as_bytes().to_vec()));
    // Sorted, so that the same seed gives the same inputs for any order of the folder.
    found.sort();
    let few = |text: &[u8]| String::from_utf8_lossy(text).replace("000,", ",").into_bytes();
    Ok(found.iter().map(|(_, text)| few(text)).filter(|text| text.len() < LARGEST).collect())
}

/// Folders of the project's scene files.
pub(super) fn folders() -> Vec<PathBuf> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    ["data", "data/issues", "data/gallery", "examples/fuzz"].map(|folder| root.join(folder)).into()
}

const EMITTER: &str = r#"material = [{ name = "m", tint = [1, 0.5, 0.2, 0.1] }]
[[emitter]]
material = "m"
rate = 40
lifetime = [1, 2]
start = -1
shape = "disc"
extent = [0.4, 0, 0.4]
velocity = [0, 0.8, 0]
path = [[0, 0, 0, 0], [2, 1, 0, 1]]
buoyancy = 0.6
drag = 1.5
turbulence = 0.8
ground = 0
boxes = [{ min = [0, 0, 0], max = [1, 1, 1] }]
fluid = { spacing = 0.2, reach = 0.4, stiffness = 9, viscosity = 0.02 }
radius = [0.04, 0.25]
alpha = [0, 0.12, 0.06, 0]
"#;

const COLUMNS: [&str; 9] = ["x", "y", "z", "radius", "red", "green", "blue", "alpha", "rotation"];

fn row(i: usize) -> impl Iterator<Item = f32> {
    (0..COLUMNS.len()).map(move |column| ((i * 7 + column * 3) % 10) as f32 / 10.0 + 0.05)
}

fn csv() -> Vec<u8> {
    let mut text = COLUMNS.join(",") + "\n";
    for i in 0..12 {
        let values: Vec<String> = row(i).map(|value| value.to_string()).collect();
        text += &(values.join(",") + "\n");
    }
    text.into_bytes()
}

fn ply(encoding: &str) -> Vec<u8> {
    let mut text = format!("ply\nformat {encoding} 1.0\ncomment seed\nelement vertex 12\n");
    for column in COLUMNS {
        let _ = writeln!(text, "property float {column}");
    }
    text += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let mut bytes = text.into_bytes();
    for i in 0..12 {
        match encoding {
            "ascii" => {
                let values: Vec<String> = row(i).map(|value| value.to_string()).collect();
                bytes.extend((values.join(" ") + "\n").into_bytes());
            }
            "binary_little_endian" => bytes.extend(row(i).flat_map(f32::to_le_bytes)),
            _ => bytes.extend(row(i).flat_map(f32::to_be_bytes)),
        }
    }
    match encoding {
        "ascii" => bytes.extend(b"3 0 1 2\n"),
        "binary_little_endian" => bytes.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]),
        _ => bytes.extend([3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2]),
    }
    bytes
}

/// A triangle of glass, moved by an animation, and a lamp.
fn gltf() -> Vec<u8> {
    br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"extensionsUsed":["KHR_lights_punctual","KHR_materials_transmission","KHR_materials_volume"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","color":[1,1,1],"intensity":5,"range":9,
"spot":{"innerConeAngle":0.2,"outerConeAngle":0.6}}]}},
"nodes":[{"mesh":0,"translation":[0,1,0],"rotation":[0,0,0,1],"scale":[1,2,1]},
{"translation":[0,3,0],"extensions":{"KHR_lights_punctual":{"light":0}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0,"mode":4},
{"attributes":{"POSITION":0},"indices":1,"material":1}]}],
"materials":[{"alphaMode":"BLEND","alphaCutoff":0.5,"doubleSided":true,
"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.2,0.5],"metallicFactor":0,"roughnessFactor":0.3},
"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.9},
"KHR_materials_volume":{"thicknessFactor":0.1,"attenuationDistance":1,"attenuationColor":[1,0.2,0.1]}}},
{"alphaMode":"MASK","extensions":{"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.5,
"diffuseTransmissionColorFactor":[1,0.5,0.2]}}}],
"animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],
"samplers":[{"input":2,"output":0,"interpolation":"LINEAR"}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"},
{"bufferView":2,"componentType":5126,"count":3,"type":"SCALAR","min":[0],"max":[2]}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6},
{"buffer":0,"byteOffset":44,"byteLength":12}],
"buffers":[{"byteLength":56,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAAAAAAAAACAPwAAAEA="}]}"#
        .to_vec()
}

fn glb(json: &[u8]) -> Vec<u8> {
    let mut text = json.to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = |bytes: usize| (bytes as u32).to_le_bytes();
    [
        &b"glTF"[..],
        &2_u32.to_le_bytes(),
        &length(20 + text.len()),
        &length(text.len()),
        b"JSON",
        &text,
    ]
    .concat()
}

pub(super) fn picture(format: ImageFormat) -> io::Result<Vec<u8>> {
    let image = RgbaImage::from_fn(9, 7, |x, y| {
        image::Rgba([x as u8 * 28, y as u8 * 36, 90, 255 - x as u8 * 9])
    });
    let image = DynamicImage::from(image);
    let image = if format == ImageFormat::Jpeg { image.to_rgb8().into() } else { image };
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}

/// A KTX2 of 5 x 3 texels of RGBA8 (KTX 2.0, section 3), compressed by zlib or not.
fn ktx2(is_packed: bool) -> io::Result<Vec<u8>> {
    let plain: Vec<u8> = (0..60).map(|i| i * 4).collect();
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    packed.write_all(&plain)?;
    let stored = if is_packed { packed.finish()? } else { plain.clone() };
    let scheme = if is_packed { 3 } else { 0 };
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let head = [37, 1, 5, 3, 0, 0, 1, 1, scheme, 0, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend(head.into_iter().flat_map(u32::to_le_bytes));
    let level = [104, stored.len() as u64, plain.len() as u64];
    bytes.extend(level.into_iter().flat_map(u64::to_le_bytes));
    bytes.extend(stored);
    Ok(bytes)
}

/// A Radiance image of 4 x 2 texels, without runs.
fn hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    bytes.extend((0..8_u8).flat_map(|i| [100 + i, 120, 140 - i, 128 + i % 3]));
    bytes
}

/// An `OpenEXR` image of 4 x 2 texels.
fn exr() -> io::Result<Vec<u8>> {
    let image = image::Rgb32FImage::from_fn(4, 2, |x, y| image::Rgb([x as f32, y as f32, 0.5]));
    let mut bytes = Cursor::new(Vec::new());
    let image = DynamicImage::from(image);
    image.write_to(&mut bytes, ImageFormat::OpenExr).map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}
