//! Tables of the scene file, checked as far as possible without the rest of the scene.
use super::{
    SceneError,
    clouds::Cloud,
    displace::Displace,
    error::quoted,
    fur::Fur,
    generate::Generate,
    keys::{ABOVE_ZERO, Keys},
    look::Look,
    particles::FARTHEST,
    rig::Placement,
    shapes::{self, KindOfShape},
    track::Mode,
    units::{Up, unit_named},
};
use glam::{UVec2, Vec2, Vec3};
use gobo::model::{
    Air, ClusterSettings, Lens, Light, MaskSettings, Material, Occlusion, ShadowSettings, Sky,
    Tone, Transfer, emission::Emitter,
};
use serde::Deserialize;
use std::path::PathBuf;
use toml::Spanned;

mod values;

pub(super) use values::{Numbers, Shades, TextureSource};

/// The whole file.
#[derive(Debug)]
pub(super) struct Document {
    pub shadow: ShadowSettings,
    pub mask: Option<MaskSettings>,
    pub clusters: ClusterSettings,
    pub environment: Option<Spanned<EnvironmentTable>>,
    pub air: Option<Air>,
    pub light: Vec<Spanned<Light>>,
    pub material: Vec<Spanned<MaterialTable>>,
    pub particles: Vec<Spanned<ParticlesTable>>,
    pub splats: Vec<Spanned<SplatsTable>>,
    pub emitter: Vec<Spanned<EmitterTable>>,
    pub shape: Vec<Spanned<ShapeTable>>,
    pub mesh: Vec<Spanned<MeshTable>>,
    pub volume: Vec<Spanned<VolumeTable>>,
    pub strands: Vec<Spanned<StrandsTable>>,
    pub animate: Vec<Spanned<AnimateTable>>,
    pub camera: Option<Spanned<CameraTable>>,
}

#[derive(Clone, Debug)]
pub(super) struct CameraTable {
    pub eye: Option<Vec3>,
    pub target: Option<Vec3>,
    /// Unit vector.
    pub up: Option<Vec3>,
    /// Vertical field of view \[radians\].
    pub fov_y: Option<f32>,
    /// Size of the picture \[pixels\].
    pub size: Option<UVec2>,
    /// Exposure \[stops\].
    pub exposure: Option<f32>,
    /// Samples per pixel.
    pub samples: u32,
    /// Offset right and down from the picture's middle to its axis \[pixels\].
    pub shift: Vec2,
    pub occlusion: Occlusion,
    /// Share of the light that spreads.
    pub bloom: f32,
    pub lens: Lens,
    /// Exposure time in frame intervals.
    pub shutter: f32,
    pub tone: Tone,
}

#[derive(Clone, Debug)]
pub(super) struct EnvironmentTable {
    pub ambient: Option<Vec3>,
    pub background: Option<Vec3>,
    pub sky: Option<Sky>,
    pub file: Option<PathBuf>,
    /// Rotation about +y \[radians\].
    pub rotation: f32,
    pub intensity: f32,
}

#[derive(Clone, Debug)]
pub(super) struct MaterialTable {
    /// The material without its texture.
    pub material: Material,
    /// Share of light that passes diffusely, and its colour.
    pub far_side: Option<(f32, Vec3)>,
    pub texture: Option<TextureSource>,
    /// Radius of particles whose file has none \[m\].
    pub radius: Option<f32>,
}

#[derive(Clone, Debug)]
pub(super) struct ParticlesTable {
    pub file: Option<PathBuf>,
    pub generate: Option<Generate>,
    pub point_budget: Option<u64>,
    /// Alphas of points by their class.
    pub classes: Option<Vec<(u8, f32)>>,
    pub material: String,
}

impl ParticlesTable {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        let classes: Option<Vec<(u8, f32)>> = keys.given("classes")?;
        let alphas: Vec<f32> = classes.iter().flatten().map(|(_, alpha)| *alpha).collect();
        keys.check("classes", &alphas, 0.0..=1.0, "rows of a class and its alpha, 0 to 1")?;
        Ok(Self {
            file: keys.given("file")?,
            generate: keys.one("generate", Keys::all)?.map(Spanned::into_inner),
            point_budget: keys.given("point_budget")?,
            classes,
            material: keys.required("material")?,
        })
    }
}

/// Kind of shadow that splats cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Cast {
    /// Shadow of the splats' opacity alone, as if they were black.
    #[default]
    Neutral,
    /// Shadow tinted by the splats' own colours.
    Own,
    None,
}

/// Meaning of the opacity of splats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Opacity {
    Splat,
    Medium,
}

#[derive(Clone, Debug)]
pub(super) struct SplatsTable {
    /// Name that animation keys refer to.
    pub name: Option<String>,
    pub file: Option<PathBuf>,
    /// Level of detail, in a file with several; 0 is the finest.
    pub lod: Option<u32>,
    pub generate: Option<Generate>,
    pub material: Option<String>,
    pub opacity: Option<Opacity>,
    /// Extinction of a medium per unit of opacity [1/m].
    pub density: Option<f32>,
    pub cast: Cast,
    pub placement: Placement,
}

impl SplatsTable {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        let words = "a number above 0, up to 1e6";
        let table = Self {
            name: keys.given("name")?,
            file: keys.given("file")?,
            lod: keys.given("lod")?,
            generate: keys.one("generate", Keys::all)?.map(Spanned::into_inner),
            material: keys.given("material")?,
            opacity: keys.given("opacity")?,
            density: keys.number("density", ABOVE_ZERO..=1e6, words)?,
            cast: keys.value("cast", Cast::default())?,
            placement: placement(keys)?,
        };
        if table.opacity == Some(Opacity::Splat) && table.density.is_some() {
            let help = "remove it, or set opacity = \"medium\"";
            return Err(keys.fault("density", "splats of opacity \"splat\" have no density", help));
        }
        Ok(table)
    }
}

/// A particle emitter.
#[derive(Clone, Debug)]
pub(super) struct EmitterTable {
    pub material: String,
    /// Material of the trail, if it is not the particles'.
    pub trail_material: Option<String>,
    /// The emitter without materials and ids.
    pub emitter: Emitter,
}

#[derive(Clone, Debug)]
pub(super) struct ShapeTable {
    /// Name that animation keys refer to.
    pub name: Option<String>,
    pub kind: KindOfShape,
    pub material: String,
    /// Subdivisions of a sphere.
    pub level: u32,
    /// Displacement, for spheres only.
    pub displace: Option<Displace>,
    pub placement: Placement,
}

impl ShapeTable {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        let most = shapes::MAX_LEVEL;
        let help = format!("at most {most}");
        let kind = keys.required("kind")?;
        let displace: Option<Displace> = keys.one("displace", Keys::all)?.map(Spanned::into_inner);
        if let Some((message, help)) = displace.and_then(|displace| displace.fault(kind)) {
            return Err(keys.fault("displace", message, help));
        }
        Ok(Self {
            name: keys.given("name")?,
            kind,
            material: keys.required("material")?,
            level: keys.whole("level", shapes::SPHERE_LEVEL, 0..=most, &help)?,
            displace,
            placement: placement(keys)?,
        })
    }
}

#[derive(Clone, Debug)]
pub(super) struct MeshTable {
    /// Name that animation keys refer to.
    pub name: Option<String>,
    pub file: PathBuf,
    pub casts: bool,
    /// Transfer of materials with alphaMode BLEND, if not the usual one.
    pub transfer: Option<Transfer>,
    /// Name of the materials' variant.
    pub variant: Option<String>,
    pub placement: Placement,
}

impl MeshTable {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            name: keys.given("name")?,
            file: keys.required("file")?,
            casts: keys.value("casts", true)?,
            transfer: keys.given("transfer")?,
            variant: keys.given("variant")?,
            placement: placement(keys)?,
        })
    }
}

/// Emission of a volume.
#[derive(Clone, Debug)]
pub(super) struct EmissionTable {
    /// Name of the grid of temperatures in the file.
    pub grid: Option<String>,
    /// Temperature of the value 1, or the highest of a generated volume \[K\].
    pub kelvin: Option<f32>,
    /// Radiance of an opaque body at 1500 K, in red.
    pub factor: f32,
}

impl EmissionTable {
    fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            grid: keys.given("grid")?,
            kelvin: keys.number("kelvin", 1e-6..=60_000.0, "above 0, at most 60000")?,
            factor: keys.number("factor", 0.0..=1e6, "0 to 1e6")?.unwrap_or(1.0),
        })
    }
}

/// A grid of voxels.
#[derive(Clone, Debug)]
pub(super) struct VolumeTable {
    pub file: Option<PathBuf>,
    /// First and last number of a sequence of files.
    pub frames: Option<[u32; 2]>,
    pub generate: Option<Cloud>,
    /// Name of the grid of densities in the file.
    pub grid: Option<String>,
    /// Optical depth of a metre of density 1 [1/m].
    pub factor: Option<f32>,
    /// Extinction per channel, relative to `factor`.
    pub color: Vec3,
    /// Name of the grid of colours in the file that multiply it.
    pub color_grid: Option<String>,
    pub albedo: Vec3,
    /// Asymmetry `g` of Henyey and Greenstein 1941.
    pub anisotropy: f32,
    pub emission: Option<EmissionTable>,
    pub look: Look,
    /// Share of the scattered light that goes straight on, in volumes with a table of colours.
    pub ahead: f32,
    /// Unit of the file \[m\], and its upward axis, if the scene sets them.
    pub unit: Option<f64>,
    pub up: Option<Up>,
    pub casts: bool,
    pub visible: bool,
    pub placement: Placement,
}

impl VolumeTable {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        let density = keys.one("density", |keys| {
            let factor = keys.number("factor", 0.0..=MOST_FACTOR, "0 to 1e6 per metre")?;
            Ok((keys.given("grid")?, factor))
        })?;
        let (grid, factor) = density.map(Spanned::into_inner).unwrap_or_default();
        let color = |key| Ok(keys.three(key, 0.0..=1.0, "from 0 to 1")?.unwrap_or(Vec3::ONE));
        let frames: Option<[u32; 2]> = keys.array("frames")?;
        if frames.is_some_and(|[first, last]| first > last || last - first >= MOST_FRAMES) {
            let help = "give the first and the last number, at most 100000 files";
            return Err(keys.fault("frames", "these are no frames", help));
        }
        let generate = keys.one("generate", Cloud::read)?.map(Spanned::into_inner);
        Ok(Self {
            file: keys.given("file")?,
            frames,
            generate,
            grid,
            factor,
            color: color("color")?,
            color_grid: keys.given("color_grid")?,
            albedo: color("albedo")?,
            anisotropy: keys
                .number("anisotropy", -0.95..=0.95, "from -0.95 to 0.95")?
                .unwrap_or(0.0),
            emission: keys.one("emission", EmissionTable::read)?.map(Spanned::into_inner),
            look: Look::read(keys)?,
            ahead: keys.share("ahead", USUAL_AHEAD)?,
            unit: unit(keys)?,
            up: keys.given("up")?,
            casts: keys.value("casts", true)?,
            visible: keys.value("visible", true)?,
            placement: placement(keys)?,
        })
    }
}

/// Hair, fur, ribbons and trails.
#[derive(Clone, Debug)]
pub(super) struct StrandsTable {
    /// Name that animation keys refer to.
    pub name: Option<String>,
    pub file: Option<PathBuf>,
    pub generate: Option<Fur>,
    pub material: String,
    /// Radius of strands in a file without radii \[m\].
    pub radius: Option<f32>,
    pub placement: Placement,
}

impl StrandsTable {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        Ok(Self {
            name: keys.given("name")?,
            file: keys.given("file")?,
            generate: keys.one("generate", Fur::read)?.map(Spanned::into_inner),
            material: keys.required("material")?,
            radius: keys.number("radius", ABOVE_ZERO..=1e7, "above 0")?,
            placement: placement(keys)?,
        })
    }
}

/// Half of the scattered light colours shadows, half is seen.
const USUAL_AHEAD: f32 = 0.5;

/// A unit of length \[m\].
fn unit(keys: &Keys<'_>) -> Result<Option<f64>, SceneError> {
    let Some(name) = keys.given::<String>("unit")? else { return Ok(None) };
    let known = unit_named(&name);
    let message = || format!("no unit is named {}", quoted(&name));
    let help = "name one of \"m\", \"cm\", \"mm\", \"um\" and \"nm\"";
    known.map(Some).ok_or_else(|| keys.fault("unit", message(), help))
}

/// Largest factor of a density [1/m].
pub(super) const MOST_FACTOR: f32 = 1e6;
/// Most files of a sequence.
const MOST_FRAMES: u32 = 100_000;

fn placement(keys: &Keys<'_>) -> Result<Placement, SceneError> {
    let vector = |key, usual| {
        let values = keys.array::<f32, 3>(key)?.unwrap_or([usual; 3]);
        if values.iter().all(|v| v.abs() <= FARTHEST) {
            return Ok(Vec3::from(values));
        }
        Err(keys.fault(key, format!("{key} is {values:?}"), "use finite numbers up to 1e7"))
    };
    let scale = vector("scale", 1.0)?;
    if scale.to_array().contains(&0.0) {
        let help = "use a small number to flatten a shape";
        return Err(keys.fault("scale", "scale has a 0", help));
    }
    Ok(Placement::still(vector("translation", 0.0)?, vector("rotation", 0.0)?, scale))
}

/// Keys of one animated value.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AnimateTable {
    /// Animated value, such as `camera.eye`.
    pub target: String,
    /// Times of the keys \[s\].
    pub times: Vec<f32>,
    pub values: Vec<Numbers>,
    #[serde(default)]
    pub mode: Mode,
}
