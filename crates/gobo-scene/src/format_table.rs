//! File formats that are read: a row each.
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

/// Endings of the formats of some families, each once: `.ply, .csv or .las`.
pub(super) fn endings(is_wanted: impl Fn(Family) -> bool, last_word: &str) -> String {
    let mut known: Vec<&str> = Vec::new();
    for format in FORMATS.iter().filter(|format| is_wanted(format.family)) {
        for ending in format.endings.iter().filter(|ending| !ending.contains('.')) {
            if !known.contains(ending) {
                known.push(ending);
            }
        }
    }
    let (last, others) = known.split_last().unwrap_or((&"", &[]));
    format!(".{} {last_word} .{last}", others.join(", ."))
}
