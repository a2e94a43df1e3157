//! Loading of scene files; everything is validated here.
use super::{
    Scene, SceneError,
    animate::{Placed, animate},
    defaults,
    document::{
        CameraTable, Document, MeshTable, ParticlesTable, ShapeTable, SplatsTable, StrandsTable,
        VolumeTable,
    },
    emitters, environment,
    exposure::exposure,
    far_sides, formats,
    gltf::Wanted,
    keys::Keys,
    light_tables,
    limits::Limit,
    loader::{Loader, error_of_line},
    models,
    origin::recentre,
    points, read,
    rig::Placement,
    share::Share,
    source::{self, SceneText},
    splat_file::{FoundSplats, harmonics_of_level, kind_of_file, load_level},
    splats::{Harmonics, SplatCloud, SplatKind},
    tables,
    volume_file::VolumeFile,
};
use glam::Vec3;
use gobo::model::{Environment, Gaussian, Motion, Occlusion, Sky};
use std::{
    ops::Range,
    path::Path,
    sync::{Arc, OnceLock},
};
use toml::Spanned;

/// Options of loading besides the file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadOptions {
    /// Values that replace those of the scene file before they are checked: dotted keys such as
    /// `shadow.size`, `light.sun.intensity` or `material.0.tint`, and TOML values.
    pub set: Vec<(String, String)>,
    /// Whether a model or particle file that is loaded as a scene gets a floor.
    pub ground: bool,
    /// Whether emitters' particles and animated volumes are made for time 0. If not, the first
    /// [`Scene::set_time`] makes them, unless the camera is placed to frame them: for a scene that is
    /// rendered at another time, or whose particles a device simulates.
    pub start: bool,
    /// Share of the filtering casters to load; `None` for all. [`Share::keep`] removes the rest once the
    /// scene's time is set.
    pub share: Option<Share>,
    /// Whether lights with a size get texels and viewpoints for the camera's picture, and not for everything
    /// that they reach.
    pub of_picture: bool,
    /// Whether nothing is simulated, not even to place the camera, and no texture is generated.
    only_checks: bool,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            set: Vec::new(),
            ground: true,
            start: true,
            share: None,
            of_picture: true,
            only_checks: false,
        }
    }
}

/// Reads a scene file, or any of the [`super::FORMATS`] that alone makes a scene.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_as(path, &LoadOptions::default())
}

/// Like [`load`]; `set` as in [`LoadOptions`].
pub fn load_with(path: &Path, set: &[(String, String)]) -> Result<Scene, SceneError> {
    load_as(path, &LoadOptions { set: set.to_vec(), ..LoadOptions::default() })
}

/// Like [`load`], for a scene that is not rendered: emitters are empty, animated volumes are their boxes, a
/// camera that frames the contents frames those, and generated textures are a single white texel.
pub fn check(path: &Path) -> Result<Scene, SceneError> {
    check_with(path, &[])
}

/// Like [`check`]; `set` as in [`LoadOptions`].
pub fn check_with(path: &Path, set: &[(String, String)]) -> Result<Scene, SceneError> {
    let set = set.to_vec();
    load_as(path, &LoadOptions { set, start: false, only_checks: true, ..LoadOptions::default() })
}

/// Like [`check`], without the ground that a single file gets: for the contents of the file.
pub fn inspect(path: &Path) -> Result<Scene, SceneError> {
    let (start, ground, only_checks) = (false, false, true);
    load_as(path, &LoadOptions { start, ground, only_checks, ..LoadOptions::default() })
}

/// All keys that the reader of a scene file asks for, as [`LoadOptions::set`] names them, sorted.
#[doc(hidden)]
pub fn asked_keys(path: &Path) -> Result<Vec<String>, SceneError> {
    let text = scene_text(path)?;
    let source = SceneText::parse(path, &text, text.len(), &[])?;
    let mut read = Ok(());
    let mut keys = source.asked(|source| read = document(source).map(drop));
    keys.sort_unstable();
    keys.dedup();
    read.map(|()| keys)
}

/// Like [`load`], with options.
pub fn load_as(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    load_all(path, options, None).map(|(scene, _)| scene)
}

/// Like [`load_as`], for the text of a scene file. `path`: its name in messages, beside which it finds files.
pub fn load_text(text: &str, path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let _phase = tracing::debug_span!("read").entered();
    Limit::Text.grown_in(path, 0, text.len() as u64)?;
    let contents =
        Contents { extension: "toml", splats: None, is_volume: false, tables: text.to_owned() };
    load_contents(path, options, contents, None).map(|(scene, _)| scene)
}

/// A scene with the splats of a file among its casters.
#[derive(Debug)]
pub struct Relit {
    /// The scene.
    pub scene: Scene,
    /// The file's splats, as the file places them.
    pub cloud: SplatCloud,
    /// Range of the file's splats in the scene, in the same order.
    pub range: Range<usize>,
    found: FoundSplats,
}

impl Relit {
    /// Higher harmonics of the file's splats, as of [`super::load_harmonics`]. `path`: of the file.
    pub fn harmonics(&self, path: &Path) -> Result<Option<Harmonics>, SceneError> {
        harmonics_of_level(path, self.found.detail)
    }

    /// Index in the cloud of one of the scene's splats.
    pub fn index_of(&self, gaussian: &Gaussian) -> usize {
        let row = gaussian.id.wrapping_sub(self.found.first_id);
        self.cloud.rows.binary_search(&row).unwrap_or(row as usize)
    }
}

/// Like [`load_as`], with the splats of a file. They are placed as in the scene; if the scene does not name
/// the file, as in the file, with a neutral shadow.
pub fn load_with_splats(
    path: &Path,
    options: &LoadOptions,
    splats: &Path,
) -> Result<Relit, SceneError> {
    let (scene, found) = load_all(path, options, Some(splats))?;
    let found = found.unwrap_or_default();
    let cloud = load_level(splats, found.detail)?;
    Ok(Relit { scene, cloud, range: found.range.clone(), found })
}

/// Loads a scene, with the splats of a file if one is given.
fn load_all(
    path: &Path,
    options: &LoadOptions,
    with: Option<&Path>,
) -> Result<(Scene, Option<FoundSplats>), SceneError> {
    let _phase = tracing::debug_span!("read").entered();
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let is_alone = extension != "toml";
    if is_alone {
        formats::refuse_foreign(path)?;
    }
    let is_known = is_alone && VolumeFile::is(path);
    let splats = (is_alone && !is_known).then(|| kind_of_file(path)).flatten();
    // A file that is damaged or missing is recognised by its name.
    let is_named = || VolumeFile::extensions().any(|own| own == extension);
    let is_volume = is_known || splats.is_none() && is_named();
    let tables = match is_volume {
        true => defaults::VOLUME.to_owned(),
        false => tables_of(path, &extension, splats)?,
    };
    let contents = Contents { extension: &extension, splats, is_volume, tables };
    load_contents(path, options, contents, with)
}

/// Contents of a file by its name, head and text.
struct Contents<'a> {
    /// Extension in lower case.
    extension: &'a str,
    /// Kind of its splats, if it holds any.
    splats: Option<SplatKind>,
    /// Whether it is a volume.
    is_volume: bool,
    /// Its tables, or generated ones for a file of another format.
    tables: String,
}

fn load_contents(
    path: &Path,
    options: &LoadOptions,
    Contents { extension, splats, is_volume, tables: file }: Contents<'_>,
    with: Option<&Path>,
) -> Result<(Scene, Option<FoundSplats>), SceneError> {
    let is_alone = extension != "toml";
    // A default sun lets `light.sun.size` be set if the file has no light.
    let set = &options.set;
    let adds_sun = set.iter().any(|(key, _)| key.starts_with("light."))
        && file.parse::<toml::Table>().is_ok_and(|table| !table.contains_key("light"));
    let file = if adds_sun { file + defaults::SUN } else { file };
    let text = source::joined(&file, set);
    let source = SceneText::parse(path, &text, file.len(), set)?;
    let mut document = document(&source)?;
    if splats == Some(SplatKind::SogLevels) {
        // A folder may be called `..`.
        let name = path.file_name().map(Into::into).or_else(|| path.canonicalize().ok());
        document.splats.iter_mut().for_each(|table| table.get_mut().file.clone_from(&name));
    }
    if is_volume {
        let file = path.file_name().map(Into::into);
        document.volume.iter_mut().for_each(|table| table.get_mut().file.clone_from(&file));
    }
    let mut loader = Loader::new(&source, path);
    loader.share = options.share;
    loader.makes_start = options.start || !options.only_checks && !is_placed(&document);
    loader.paints = !options.only_checks;
    loader.document(&document)?;
    let found = with.map(|with| loader.found_splats(with)).transpose()?;
    if !is_volume {
        loader.contents_of(path, extension, splats)?;
    }
    let Loader { mut scene, model_camera, mut placed, mut still, resting, .. } = loader;
    if has_own_camera(&document) {
        for moving in placed.iter_mut().filter_map(|placed| placed.moving.as_mut()) {
            moving.camera = None;
        }
    }
    let around = document.environment.as_ref().map(Spanned::get_ref);
    let is_said = around.is_some_and(|table| table.ambient.is_some() || table.background.is_some());
    let has_usual_sky = is_alone && scene.environment.is_none() && !is_said;
    if has_usual_sky {
        scene.environment = Some(usual_sky());
    }
    // Before the ground is added: the camera looks at the contents of the file.
    let bounds = defaults::contents(&scene);
    let alone = is_alone.then_some(&scene);
    let usual = model_camera.unwrap_or_else(|| {
        let usual = defaults::camera(&bounds);
        alone.map_or(usual, |scene| defaults::framed(usual, scene, false))
    });
    scene.camera = match &document.camera {
        Some(table) => tables::placed_camera(&source, table, model_camera, &bounds, alone)?,
        None => usual,
    };
    expose(&mut scene, document.camera.as_ref().map(Spanned::get_ref));
    if is_alone && options.ground {
        let image = around.is_some_and(|table| table.file.is_some());
        defaults::add_ground(&mut scene, model_camera.as_ref(), image);
    }
    let given = document.camera.as_ref().and_then(|table| table.get_ref().exposure);
    if is_alone && given.is_none() && document.light.is_empty() && !scene.lights.is_empty() {
        scene.exposure = exposure(&scene, &scene.camera, has_usual_sky);
        if has_usual_sky && scene.exposure != 0.0 {
            let sky = Environment::of_sky(&Sky::default(), (-scene.exposure).exp2());
            scene.environment = Some(Arc::new(sky));
        }
    }
    if scene.lights.is_empty() {
        scene.lights.push(defaults::sun());
    }
    let is_aimed =
        set.iter().any(|(key, _)| key.starts_with("light.") && key.ends_with(".direction"));
    let is_usual = adds_sun || document.light.is_empty() && scene.lights[0] == defaults::sun();
    if is_alone && is_usual && !is_aimed {
        let mut light = scene.lights[0].clone();
        if model_camera.is_some() || !defaults::hang_lamp(&mut light, &scene) {
            defaults::aim_sun(&mut light, &usual);
        }
        scene.lights[0] = light;
    }
    let moving = animate(&source, &document, placed, &mut scene)?;
    still.extend(moving.into_iter().map(|moving| Arc::new(moving) as _));
    recentre(&mut scene);
    place_again(&mut scene, still);
    far_sides::add_filters(&mut scene, path)?;
    let by = -scene.origin;
    let resting = resting.into_iter().map(|resting| resting.moved(by).unwrap_or(resting));
    scene.motions.extend(resting);
    if !options.only_checks {
        scene.follow_motions();
    }
    scene.fit_soft_lights(options.of_picture);
    Ok((scene, found))
}

/// The tables of a scene file, or generated ones for a file of another format.
fn tables_of(
    path: &Path,
    extension: &str,
    splats: Option<SplatKind>,
) -> Result<String, SceneError> {
    Ok(match extension {
        _ if splats == Some(SplatKind::SogLevels) => defaults::SPLATS.to_owned(),
        _ if splats.is_some() => String::new(),
        _ if points::kind_of_file(path).is_some() => defaults::POINTS_MATERIAL.to_owned(),
        "toml" => scene_text(path)?,
        "glb" | "gltf" => String::new(),
        _ if models::kind_of_file(path).is_some() => String::new(),
        "ply" | "csv" => defaults::PARTICLE_MATERIAL.to_owned(),
        _ => return Err(formats::unknown(path)),
    })
}

impl Loader<'_> {
    /// Loads the contents of a file that is itself the scene, unlike tables that name files.
    fn contents_of(
        &mut self,
        path: &Path,
        extension: &str,
        splats: Option<SplatKind>,
    ) -> Result<(), SceneError> {
        let is_model = matches!(extension, "glb" | "gltf") || models::kind_of_file(path).is_some();
        match extension {
            _ if splats == Some(SplatKind::SogLevels) => {
                self.note_turned(path);
                Ok(())
            }
            _ if splats.is_some() => self.splats_alone(path, splats),
            _ if is_model => {
                let still = Placement::still(Vec3::ZERO, Vec3::ZERO, Vec3::ONE);
                let moving = self.model(path, still, Wanted::default())?;
                let triangles = 0..self.scene.triangles.len();
                self.placed.push(Placed { kind: "mesh", name: None, triangles, moving });
                if self.leaves_splats { self.splats_alone(path, None) } else { Ok(()) }
            }
            "ply" | "csv" => self.particle_file(path, 0, None, None),
            _ if points::kind_of_file(path).is_some() => self.particle_file(path, 0, None, None),
            _ => Ok(()),
        }
    }
}

/// Sets the camera's exposure; without a table, the defaults.
fn expose(scene: &mut Scene, table: Option<&CameraTable>) {
    (scene.samples, scene.occlusion) = (defaults::SAMPLES, Occlusion::Usual);
    if let Some(table) = table {
        let &CameraTable { exposure, samples, shift, occlusion, .. } = table;
        let &CameraTable { bloom, lens, shutter, tone, .. } = table;
        scene.exposure = exposure.unwrap_or(0.0);
        (scene.samples, scene.shift) = (samples, shift);
        (scene.occlusion, scene.bloom, scene.lens) = (occlusion, bloom, lens);
        (scene.shutter, scene.tone) = (shutter, tone);
    }
}

/// Makes the corners of a re-centred scene anew: far from the origin they were rounded. `still`: parts that
/// do not move, before re-centring.
fn place_again(scene: &mut Scene, still: Vec<Arc<dyn Motion>>) {
    if scene.origin == Vec3::ZERO {
        return;
    }
    let still = still.into_iter().filter_map(|part| part.moved(-scene.origin));
    let moving = scene.motions.iter().filter(|motion| !motion.moves_particles()).cloned();
    for part in still.chain(moving).collect::<Vec<_>>() {
        part.apply(scene, 0.0);
    }
    scene.leave_out_far_triangles();
}

/// Whether the file sets the camera's position and target.
fn is_placed(document: &Document) -> bool {
    document.camera.as_ref().is_some_and(|table| {
        let CameraTable { eye, target, .. } = table.get_ref();
        eye.is_some() && target.is_some()
    })
}

/// Whether the file itself sets the camera's position, so that no model does.
fn has_own_camera(document: &Document) -> bool {
    let places = document.camera.as_ref().is_some_and(|table| {
        let CameraTable { eye, target, up, .. } = table.get_ref();
        eye.is_some() || target.is_some() || up.is_some()
    });
    let keys = ["camera.eye", "camera.target", "camera.up"];
    places || document.animate.iter().any(|keyed| keys.contains(&keyed.get_ref().target.as_str()))
}

/// The default sky, made once: it takes as long as a small model.
fn usual_sky() -> Arc<Environment> {
    static SKY: OnceLock<Arc<Environment>> = OnceLock::new();
    SKY.get_or_init(|| Arc::new(Environment::of_sky(&Sky::default(), 1.0))).clone()
}

pub(super) fn scene_text(path: &Path) -> Result<String, SceneError> {
    let length = read::length(path)?;
    Limit::Text.grown_in(path, 0, length)?;
    String::from_utf8(read::bytes(path)?).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|&&byte| byte == b'\n').count();
        error_of_line(path, line, "the text is not UTF-8", "save the file as UTF-8")
    })
}

/// All tables of the file, each checked as far as possible on its own.
pub(super) fn document(source: &SceneText<'_>) -> Result<Document, SceneError> {
    Keys::of_file(source, |keys| {
        let mut lights = 0..;
        Ok(Document {
            shadow: keys
                .one("shadow", tables::shadow)?
                .map_or_else(tables::usual_shadow, Spanned::into_inner),
            mask: keys.one("mask", tables::mask)?.map(Spanned::into_inner),
            clusters: (keys.one("clusters", tables::clusters)?)
                .map(Spanned::into_inner)
                .unwrap_or_default(),
            environment: keys.one("environment", environment::table)?,
            air: keys.one("air", tables::air)?.and_then(Spanned::into_inner),
            light: keys
                .many("light", |keys| light_tables::light(keys, lights.next().unwrap_or(0)))?,
            material: keys.many("material", tables::material)?,
            particles: keys.many("particles", ParticlesTable::read)?,
            splats: keys.many("splats", SplatsTable::read)?,
            emitter: keys.many("emitter", emitters::table)?,
            shape: keys.many("shape", ShapeTable::read)?,
            mesh: keys.many("mesh", MeshTable::read)?,
            volume: keys.many("volume", VolumeTable::read)?,
            strands: keys.many("strands", StrandsTable::read)?,
            animate: keys.many("animate", Keys::all)?,
            camera: keys.one("camera", tables::camera)?,
        })
    })
}
