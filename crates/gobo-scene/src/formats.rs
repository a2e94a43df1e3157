//! Formats of files, by their contents and names.
use super::{
    SceneError,
    format_table::{FORMATS, Family, Format, endings},
    models, particles, points, read, splat_file, splats,
    volume_file::VolumeFile,
};
use std::path::Path;

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
    let help =
        format!("a scene is a {} file: gobo info --formats", endings(Family::is_alone, "or"));
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
