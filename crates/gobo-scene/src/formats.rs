//! File formats that are read: a row each.
use super::{
    SceneError, models, particles, points, read, splat_file, splats, volume_file::VolumeFile,
};
use std::path::Path;

/// Contents of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Family {
    /// A scene file.
    Scene,
    /// A model: triangles.
    Model,
    /// Particles or strands, a row each.
    Particles,
    /// A point cloud, as discs.
    Points,
    /// Anisotropic Gaussians.
    Splats,
    /// Voxels.
    Volume,
    /// A material's texture.
    Texture,
    /// An environment image.
    Surroundings,
}

impl Family {
    /// Name in lists.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Model => "model",
            Self::Particles => "particles",
            Self::Points => "points",
            Self::Splats => "splats",
            Self::Volume => "volume",
            Self::Texture => "texture",
            Self::Surroundings => "surroundings",
        }
    }

    /// Whether such a file alone makes a scene.
    pub const fn is_alone(self) -> bool {
        !matches!(self, Self::Texture | Self::Surroundings)
    }
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct Format {
    /// Name for users.
    pub name: &'static str,
    /// Endings of file names, without a dot.
    pub endings: &'static [&'static str],
    /// Contents that the file is read as.
    pub family: Family,
    /// Feature that identifies the format.
    pub known_by: &'static str,
    /// Parts of the file that are read.
    pub read: &'static str,
}

const fn row(
    family: Family,
    name: &'static str,
    endings: &'static [&'static str],
    known_by: &'static str,
    read: &'static str,
) -> Format {
    Format { name, endings, family, known_by, read }
}

/// Identified by the name alone.
const NAME: &str = "name";
/// Identified by the first bytes.
const START: &str = "first bytes";

/// All formats, grouped by family.
pub const FORMATS: &[Format] = &[
    row(Family::Scene, "TOML", &["toml"], NAME, "tables of docs/scene.md"),
    row(
        Family::Model,
        "glTF 2.0",
        &["glb", "gltf"],
        NAME,
        "meshes, materials, lights, cameras, animations, skins",
    ),
    row(
        Family::Model,
        "PLY with faces",
        &["ply"],
        "element `face`",
        "polygons, normals and colours of vertices",
    ),
    row(
        Family::Model,
        "OBJ",
        &["obj"],
        NAME,
        "polygons, normals, textures, colours of vertices, MTL",
    ),
    row(Family::Particles, "PLY", &["ply"], NAME, "a row a particle, by the names of columns"),
    row(Family::Particles, "CSV", &["csv"], NAME, "a row a particle, by the names of columns"),
    row(Family::Points, "LAS 1.0 to 1.4", &["las"], START, "coordinates, colour, intensity, class"),
    row(Family::Points, "LAZ", &["laz"], START, "as LAS"),
    row(
        Family::Points,
        "PCD 0.7",
        &["pcd"],
        START,
        "x y z, rgb, intensity; text, binary and compressed",
    ),
    row(Family::Points, "E57", &["e57"], START, "coordinates, colour, intensity, poses"),
    row(
        Family::Splats,
        "PLY of 3D Gaussian splatting",
        &["ply"],
        "columns",
        "base colours; `relight` keeps harmonics",
    ),
    row(
        Family::Splats,
        "compressed PLY",
        &["compressed.ply"],
        "columns",
        "base colours; `relight` keeps harmonics",
    ),
    row(Family::Splats, "splat", &["splat"], "numbers of its records", "all"),
    row(
        Family::Splats,
        "ksplat 0.1",
        &["ksplat"],
        "its headers",
        "base colours; `relight` keeps harmonics",
    ),
    row(Family::Splats, "SPZ 1 to 4", &["spz"], START, "base colours; `relight` keeps harmonics"),
    row(
        Family::Splats,
        "SOG 2",
        &["sog", "meta.json"],
        "zip, or keys",
        "base colours; `relight` keeps harmonics",
    ),
    row(Family::Splats, "streamed SOG 1", &["lod-meta.json"], "keys", "one level of detail"),
    row(
        Family::Splats,
        "glTF with splats",
        &["glb", "gltf"],
        "primitives",
        "KHR_gaussian_splatting, plain or by SPZ",
    ),
    row(Family::Volume, "OpenVDB", &["vdb"], START, "grids of floats, halves and colours"),
    row(Family::Volume, "NanoVDB", &["nvdb"], START, "grids of numbers, plain and quantised"),
    row(
        Family::Volume,
        "NumPy",
        &["npy", "npz"],
        START,
        "an array of 3 axes, or of 4 with channels",
    ),
    row(Family::Volume, "NRRD", &["nrrd", "nhdr"], START, "raw, gzip and text; its space"),
    row(Family::Volume, "VTK image", &["vti"], START, "raw, base64, zlib and text"),
    row(Family::Volume, "NIfTI-1", &["nii", "nii.gz", "hdr"], START, "its space"),
    row(Family::Volume, "MetaImage", &["mha", "mhd"], START, "raw and zlib; its space"),
    row(Family::Volume, "stack of TIFF pages", &["tif", "tiff"], START, "grey and colour"),
    row(Family::Texture, "PNG", &["png"], START, "8 bits a channel"),
    row(Family::Texture, "JPEG", &["jpg", "jpeg"], START, "8 bits a channel"),
    row(Family::Texture, "WebP", &["webp"], START, "8 bits a channel"),
    row(Family::Texture, "KTX2", &["ktx2"], START, "Basis Universal, plain bytes"),
    row(Family::Surroundings, "Radiance", &["hdr"], START, "an equirectangular image"),
    row(
        Family::Surroundings,
        "OpenEXR",
        &["exr"],
        START,
        "an equirectangular image, red green blue",
    ),
];

/// A format that is not read: its endings, first bytes, and how to convert it.
struct Foreign {
    name: &'static str,
    endings: &'static [&'static str],
    start: &'static [u8],
    help: &'static str,
}

const USD_HELP: &str =
    "convert it to glTF (.glb), for example by Blender: import the USD file, export glTF 2.0";

const FOREIGN: [Foreign; 4] = [
    Foreign { name: "USD", endings: &["usda"], start: b"#usda", help: USD_HELP },
    Foreign { name: "USD", endings: &["usd", "usdc"], start: b"PXR-USDC", help: USD_HELP },
    Foreign { name: "USD in a zip", endings: &["usdz"], start: b"", help: USD_HELP },
    Foreign {
        name: "FBX",
        endings: &["fbx"],
        start: b"Kaydara FBX Binary",
        help: "convert it to glTF (.glb), for example by Blender",
    },
];

fn ending(path: &Path) -> String {
    path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// Refuses formats that are known but not read, by name.
pub(super) fn refuse_foreign(path: &Path) -> Result<(), SceneError> {
    let ending = ending(path);
    let head = read::head(path, 64).map(|(head, _)| head).unwrap_or_default();
    let found = FOREIGN.iter().find(|foreign| {
        foreign.endings.contains(&ending.as_str())
            || !foreign.start.is_empty() && head.starts_with(foreign.start)
    });
    let Some(Foreign { name, help, .. }) = found else { return Ok(()) };
    Err(SceneError::invalid(path, format!("is {name}, which gobo does not read"), help))
}

/// The error of a file of unknown format.
pub(super) fn unknown(path: &Path) -> SceneError {
    if let Err(error) = refuse_foreign(path) {
        return error;
    }
    let mut endings: Vec<&str> = Vec::new();
    for format in FORMATS.iter().filter(|format| format.family.is_alone()) {
        endings.extend(format.endings.iter().filter(|ending| !ending.contains('.')));
    }
    let mut known = Vec::new();
    for ending in endings {
        if !known.contains(&ending) {
            known.push(ending);
        }
    }
    let (last, others) = known.split_last().expect("kinds");
    let help = format!("a scene is a .{} or .{last} file: gobo info --formats", others.join(", ."));
    let message = format!("no known kind of scene: {:?}", ending(path));
    SceneError::invalid(path, message, &help)
}

/// Format of a file, or of a folder of splats; `None` if it is unknown, or the file cannot be read.
pub fn format_of(path: &Path) -> Option<&'static Format> {
    let named = |name: &str| FORMATS.iter().find(|format| format.name == name);
    if let Some(kind) = splat_file::kind_of_file(path) {
        return named(match kind {
            splats::SplatKind::Ply => "PLY of 3D Gaussian splatting",
            splats::SplatKind::Packed => "compressed PLY",
            splats::SplatKind::Bare => "splat",
            splats::SplatKind::Ksplat => "ksplat 0.1",
            splats::SplatKind::Spz => "SPZ 1 to 4",
            splats::SplatKind::Sog | splats::SplatKind::SogFolder => "SOG 2",
            splats::SplatKind::SogLevels => "streamed SOG 1",
        });
    }
    if let Some(kind) = points::kind_of_file(path) {
        return named(match kind {
            points::PointsKind::Las => {
                if ending(path) == "laz" {
                    "LAZ"
                } else {
                    "LAS 1.0 to 1.4"
                }
            }
            points::PointsKind::Pcd => "PCD 0.7",
            points::PointsKind::E57 => "E57",
        });
    }
    if let Some(kind) = models::kind_of_file(path) {
        return named(match kind {
            models::ModelKind::Ply => "PLY with faces",
            models::ModelKind::Obj => "OBJ",
        });
    }
    if let Some(endings) = VolumeFile::endings_of(path) {
        return FORMATS.iter().find(|format| format.endings.contains(&endings[0]));
    }
    let ending = ending(path);
    let is_named = |format: &&Format| format.endings.contains(&ending.as_str());
    // A PLY with neither faces nor splats holds a particle per row.
    let is_ply = |format: &&Format| ending != "ply" || format.family == Family::Particles;
    FORMATS.iter().filter(is_ply).find(is_named)
}

/// Contents by the file's head: names and values.
pub fn facts(path: &Path) -> Vec<(&'static str, String)> {
    let Some(format) = format_of(path) else { return Vec::new() };
    match format.family {
        Family::Points => points::facts(path),
        Family::Particles | Family::Model | Family::Splats if ending(path) == "ply" => {
            particles::facts(path)
        }
        Family::Model if format.name == "glTF 2.0" => models::facts(path),
        _ => Vec::new(),
    }
}
