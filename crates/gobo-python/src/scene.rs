//! The class that the package's `Scene` wraps.
use crate::{
    adapter,
    arrays::{array, column, rows},
    contents::{Added, Gaussians, KindOfSplats, Mesh, Particles, Voxels},
    fault::Fault,
    job::{self, Stop},
    look,
    maps::Maps,
    state::{LightName, State, Wanted, check_limit},
    tables,
};
use gobo::{
    RenderOptions, Renderer, Texture,
    glam::{DVec3, Mat4, Vec3},
    internals::cli::Needs,
    model::{ReceiverPoint, Skipped},
    render::{Receivers, set_to_relight},
    scene::{self, Limit, LoadOptions},
};
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::{
    Bound, FromPyObject, PyAny, PyResult, Python, pyclass, pymethods,
    types::{PyDict, PyDictMethods as _},
};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
use toml::Table;

/// Points that are looked up at a time, at most: between them a call can be interrupted.
const MOST_POINTS: usize = 1 << 20;
/// Shares that are looked up at a time, at most.
const MOST_SHARES: usize = 1 << 23;

/// A scene: one call at a time works with it.
#[pyclass(frozen, module = "gobo_shadows._native")]
#[derive(Debug)]
pub(crate) struct Scene {
    state: Arc<Mutex<State>>,
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A material as Python gives it: a name, or a dictionary and the index of an image.
#[derive(FromPyObject)]
enum Material<'py> {
    Named(String),
    Made(Bound<'py, PyDict>, Option<u32>),
}

impl Material<'_> {
    fn wanted(self) -> PyResult<Wanted> {
        Ok(match self {
            Self::Named(name) => Wanted::Named(name),
            Self::Made(dict, texture) => {
                Wanted::Made { table: tables::table("material", &dict)?, texture }
            }
        })
    }
}

/// A light as Python names it.
#[derive(FromPyObject)]
enum Light {
    Index(i64),
    Name(String),
}

impl From<Light> for LightName {
    fn from(light: Light) -> Self {
        match light {
            Light::Index(index) => Self::Index(index),
            Light::Name(name) => Self::Name(name),
        }
    }
}

/// Counts by reason for Python.
fn counts<'py>(py: Python<'py>, skipped: &Skipped) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (reason, count) in skipped {
        dict.set_item(*reason, *count)?;
    }
    Ok(dict)
}

type Counted<'py> = PyResult<(usize, Bound<'py, PyDict>)>;

impl Scene {
    fn of(state: State) -> Self {
        Self { state: Arc::new(Mutex::new(state)) }
    }

    /// What `change` returns, without the interpreter's lock.
    fn change<T: Send>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut State) -> Result<T, Fault> + Send,
    ) -> PyResult<T> {
        py.detach(|| change(&mut lock(&self.state))).map_err(|fault| fault.raised(py))
    }

    fn added<'py>(
        &self,
        py: Python<'py>,
        change: impl FnOnce(&mut State) -> Result<Added, Fault> + Send,
    ) -> Counted<'py> {
        let (count, skipped) = self.change(py, change)?;
        Ok((count, counts(py, &skipped)?))
    }

    /// A long call with a renderer.
    fn job<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut State, &mut Renderer, &Stop) -> Result<T, Fault> + Send + 'static,
    ) -> PyResult<T> {
        let state = Arc::clone(&self.state);
        job::run(py, move |stop| {
            let mut state = lock(&state);
            stop.check()?;
            adapter::with(|renderer| work(&mut state, renderer, stop))
        })
    }
}

/// Refuses what the host has no memory for.
fn check(needs: Needs, renderer: &Renderer, state: &State) -> Result<(), Fault> {
    let needs = Needs { backend_is_cpu: !renderer.has_device(), ..needs };
    needs.missing(&state.scene).map_or(Ok(()), |bytes| Err(Fault::Memory(bytes)))
}

#[pymethods]
impl Scene {
    #[new]
    fn new(tables: &Bound<'_, PyDict>, origin: [f64; 3]) -> PyResult<Self> {
        let py = tables.py();
        let mut empty =
            tables::scene_of("scene", &Table::new()).map_err(|fault| fault.raised(py))?;
        empty.lights.clear();
        let mut state = State::new(empty, DVec3::from(origin));
        let tables = tables::table("scene", tables)?;
        state.configure(&tables).map_err(|fault| fault.raised(py))?;
        Ok(Self::of(state))
    }

    #[staticmethod]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        set: Vec<(String, String)>,
        ground: bool,
    ) -> PyResult<Self> {
        let state = job::run(py, move |_| {
            let mut options = LoadOptions::default();
            (options.set, options.ground) = (set, ground);
            Ok(State::loaded(scene::load_as(&path, &options)?))
        });
        Ok(Self::of(state?))
    }

    fn configure(&self, py: Python<'_>, tables: &Bound<'_, PyDict>) -> PyResult<()> {
        let tables = tables::table("scene", tables)?;
        self.change(py, |state| state.configure(&tables))
    }

    fn place_camera(&self, py: Python<'_>, camera: &Bound<'_, PyDict>) -> PyResult<()> {
        let camera = tables::table("camera", camera)?;
        self.change(py, |state| look::place(state, &camera))
    }

    /// An image; returns its index.
    fn add_texture(&self, py: Python<'_>, rgba: PyReadonlyArray3<'_, u8>) -> PyResult<u32> {
        let [height, width, channels] = rgba.as_array().dim().into();
        let bytes = rgba.as_slice().map_err(|_| Fault::not_contiguous("texture").raised(py))?;
        self.change(py, |state| {
            let wrong = || {
                let message = format!("the texture's shape is ({height}, {width}, {channels})");
                Fault::input(message, "give it (height, width, 4) bytes, at least one texel")
            };
            let size = [width, height].map(u32::try_from);
            let [Ok(width), Ok(height)] = size else { return Err(wrong()) };
            if channels != 4 || bytes.is_empty() {
                return Err(wrong());
            }
            let textures = &mut state.scene.textures;
            check_limit(Limit::Textures, textures.len(), 1)?;
            let texels = textures.iter().map(|texture| texture.rgba.len() / 4).sum();
            check_limit(Limit::Texels, texels, bytes.len() / 4)?;
            let name = format!("array {}", textures.len());
            textures.push(Texture { name, width, height, rgba: bytes.to_vec() });
            Ok(textures.len() as u32 - 1)
        })
    }

    fn add_particles<'py>(
        &self,
        py: Python<'py>,
        positions: PyReadonlyArray2<'py, f32>,
        radii: PyReadonlyArray1<'py, f32>,
        colors: PyReadonlyArray2<'py, f32>,
        rotations: PyReadonlyArray1<'py, f32>,
        material: Material<'py>,
    ) -> Counted<'py> {
        let raised = |fault: Fault| fault.raised(py);
        let particles = Particles {
            positions: rows(&positions, "positions").map_err(raised)?,
            radii: column(&radii, "radius").map_err(raised)?,
            colors: rows(&colors, "color").map_err(raised)?,
            rotations: column(&rotations, "rotation").map_err(raised)?,
        };
        let material = material.wanted()?;
        self.added(py, |state| state.add_particles(particles, &material))
    }

    /// Returns the first of the splats in the scene, one past the last, what was left out by reason, and its rows.
    #[allow(clippy::too_many_arguments, clippy::type_complexity, reason = "arrays of Python")]
    fn add_gaussians<'py>(
        &self,
        py: Python<'py>,
        means: PyReadonlyArray2<'py, f32>,
        quats: PyReadonlyArray2<'py, f32>,
        scales: PyReadonlyArray2<'py, f32>,
        opacities: PyReadonlyArray1<'py, f32>,
        colors: PyReadonlyArray2<'py, f32>,
        material: Material<'py>,
        neutral: bool,
        casts: bool,
        density: Option<f32>,
    ) -> PyResult<((usize, usize), Bound<'py, PyDict>, Bound<'py, PyAny>)> {
        let raised = |fault: Fault| fault.raised(py);
        let gaussians = Gaussians {
            means: rows(&means, "means").map_err(raised)?,
            quats: rows(&quats, "quats").map_err(raised)?,
            scales: rows(&scales, "scales").map_err(raised)?,
            opacities: column(&opacities, "opacities").map_err(raised)?,
            colors: rows(&colors, "colors").map_err(raised)?,
        };
        let count = gaussians.means.len();
        let lengths = [
            ("quats", gaussians.quats.len()),
            ("scales", gaussians.scales.len()),
            ("opacities", gaussians.opacities.len()),
            ("colors", gaussians.colors.len()),
        ];
        if let Some((name, have)) = lengths.into_iter().find(|(_, have)| *have != count) {
            let message = format!("{name} has {have} rows, and means has {count}");
            return Err(Fault::input(message, "give one row for each splat").raised(py));
        }
        let (material, kind) = (material.wanted()?, KindOfSplats { neutral, casts, density });
        let ((added, skipped), left_out, end) = self.change(py, |state| {
            let (added, left_out) = state.add_gaussians(gaussians, &material, &kind)?;
            Ok((added, left_out, state.scene.gaussians.len()))
        })?;
        let left_out_count = left_out.len();
        let left_out = array(py, left_out, &[left_out_count])?;
        Ok(((end - added, end), counts(py, &skipped)?, left_out))
    }

    #[allow(clippy::too_many_arguments, reason = "arrays of Python")]
    fn add_mesh<'py>(
        &self,
        py: Python<'py>,
        vertices: PyReadonlyArray2<'py, f32>,
        faces: PyReadonlyArray2<'py, i64>,
        normals: PyReadonlyArray2<'py, f32>,
        uvs: PyReadonlyArray2<'py, f32>,
        colors: PyReadonlyArray2<'py, f32>,
        material: Material<'py>,
    ) -> Counted<'py> {
        let raised = |fault: Fault| fault.raised(py);
        let mesh = Mesh {
            vertices: rows(&vertices, "vertices").map_err(raised)?,
            faces: rows(&faces, "faces").map_err(raised)?,
            normals: rows(&normals, "normals").map_err(raised)?,
            uvs: rows(&uvs, "uvs").map_err(raised)?,
            colors: rows(&colors, "colors").map_err(raised)?,
        };
        let material = material.wanted()?;
        self.added(py, |state| state.add_mesh(mesh, &material))
    }

    fn add_shape(
        &self,
        py: Python<'_>,
        shape: &Bound<'_, PyDict>,
        material: Material<'_>,
    ) -> PyResult<usize> {
        let (shape, material) = (tables::table("shape", shape)?, material.wanted()?);
        self.change(py, |state| state.add_shape(shape, &material))
    }

    /// `matrix`: world from index, rows.
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn add_volume<'py>(
        &self,
        py: Python<'py>,
        density: PyReadonlyArray3<'py, f32>,
        matrix: [[f32; 4]; 4],
        factor: f32,
        color: [f32; 3],
        albedo: [f32; 3],
        anisotropy: f32,
        casts: bool,
        visible: bool,
    ) -> Counted<'py> {
        let values = density.as_slice().map_err(|_| Fault::not_contiguous("density").raised(py))?;
        let voxels = Voxels {
            values,
            size: density.as_array().dim().into(),
            world_from_index: Mat4::from_cols_array_2d(&matrix).transpose(),
            factor,
            color: color.into(),
            albedo: albedo.into(),
            anisotropy,
            casts,
            visible,
        };
        self.added(py, |state| state.add_volume(voxels))
    }

    fn add_light(&self, py: Python<'_>, light: &Bound<'_, PyDict>) -> PyResult<usize> {
        let light = tables::table("light", light)?;
        self.change(py, |state| state.add_light(light))
    }

    fn remove_lights(&self, py: Python<'_>) -> PyResult<()> {
        self.change(py, |state| {
            state.scene.lights.clear();
            Ok(())
        })
    }

    fn set_time(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        let state = Arc::clone(&self.state);
        job::run(py, move |_| {
            let mut state = lock(&state);
            state.seconds = seconds;
            state.scene.set_time(seconds);
            Ok(())
        })
    }

    /// Linear light, and the picture as it is shown.
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: &Bound<'py, PyDict>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let camera = tables::table("camera", camera)?;
        let picture = self.job(py, move |state, renderer, _| {
            look::with(state, &camera, None, |state| {
                check(Needs { picture: true, ..Needs::default() }, renderer, state)?;
                let options = RenderOptions { light: true, ..RenderOptions::default() };
                let step = 1.0 / scene::Scene::FRAME_RATE;
                let frame = if state.scene.shutter > 0.0 {
                    let seconds = state.seconds;
                    let frame = renderer.render_at(&mut state.scene, seconds, step, &options)?;
                    state.scene.set_time(seconds);
                    frame
                } else {
                    renderer.render(&state.scene, &options)?
                };
                Ok(frame.picture)
            })
        })?;
        let [width, height] = picture.size.to_array().map(|size| size as usize);
        let shape = [height, width, 3];
        let light = array(py, picture.light.into_flattened(), &shape)?;
        Ok((light, array(py, picture.rgb.into_flattened(), &shape)?))
    }

    /// Maps of all views of a light, in their order.
    fn maps<'py>(
        &self,
        py: Python<'py>,
        light: Light,
        camera: &Bound<'py, PyDict>,
        curve: Option<u32>,
    ) -> PyResult<Vec<(&'static str, Bound<'py, PyDict>)>> {
        let camera = tables::table("camera", camera)?;
        let light = LightName::from(light);
        let (all, origin) = self.job(py, move |state, renderer, _| {
            let index = state.light(&light)?;
            look::with(state, &camera, curve, |state| {
                // Pictures alone have them.
                state.scene.shadow.detail = false;
                check(Needs { maps: true, ..Needs::default() }, renderer, state)?;
                let options = RenderOptions {
                    maps: true,
                    maps_of: Some(index),
                    maps_only: true,
                    ..RenderOptions::default()
                };
                let frame = renderer.render(&state.scene, &options)?;
                let light = &state.scene.lights[index];
                let maps = frame.maps.into_iter().map(|maps| Maps::new(maps, light));
                Ok((maps.collect::<Result<Vec<_>, _>>()?, state.origin))
            })
        })?;
        all.into_iter().map(|maps| Ok((maps.name(), maps.dict(py, origin)?))).collect()
    }

    /// Share of each light that reaches points, which are less the origin.
    fn light<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f32>,
        normals: Option<PyReadonlyArray2<'py, f32>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let raised = |fault: Fault| fault.raised(py);
        let positions = rows::<f32, 3>(&points, "points").map_err(raised)?;
        let normals = normals.as_ref().map(|normals| rows::<f32, 3>(normals, "normals"));
        let normals = normals.transpose().map_err(raised)?;
        let points = py.detach(|| receivers(positions, normals)).map_err(raised)?;
        let count = points.len();
        let (shares, lights) = self.job(py, move |state, renderer, stop| {
            let lights = state.scene.lights.len();
            let needs = Needs { points: count as u64, ..Needs::default() };
            check(needs, renderer, state)?;
            let mut shares = Vec::new();
            let bytes = 12 * (count * lights) as u64;
            shares.try_reserve_exact(count * lights).map_err(|_| Fault::Memory(bytes))?;
            if count > 0 && lights > 0 {
                let mut receivers = Receivers::default();
                receivers.extend(points.iter().map(|point| point.position));
                let mut look_up = renderer.point_look_up(&state.scene, receivers)?;
                for some in points.chunks((MOST_SHARES / lights).clamp(1, MOST_POINTS)) {
                    stop.check()?;
                    shares.extend(look_up.shares(some)?);
                }
            }
            Ok((shares.into_flattened(), lights))
        })?;
        array(py, shares, &[count, lights, 3])
    }

    /// Share of the light that reaches the splats `start..end`.
    fn relight<'py>(
        &self,
        py: Python<'py>,
        start: usize,
        end: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let shares = self.job(py, move |state, renderer, _| {
            let (shadow, lights) = (state.scene.shadow, state.scene.lights.clone());
            set_to_relight(&mut state.scene);
            let count = end.saturating_sub(start) as u64;
            let points = count * state.scene.lights.len() as u64;
            let needs = Needs { points, ..Needs::default() };
            let shares = check(needs, renderer, state).and_then(|()| {
                let scene = &state.scene;
                let Some(splats) = scene.gaussians.get(start..end) else {
                    let have = scene.gaussians.len();
                    let message = format!("splats {start}..{end} of a scene of {have}");
                    return Err(Fault::input(message, "use splats that this scene returned"));
                };
                if splats.is_empty() {
                    Ok(Vec::new())
                } else {
                    Ok(renderer.relight(scene, splats)?)
                }
            });
            (state.scene.shadow, state.scene.lights) = (shadow, lights);
            shares
        })?;
        let count = shares.len();
        array(py, shares.into_flattened(), &[count, 3])
    }

    /// Colours of the splats `start..end`.
    fn colors<'py>(
        &self,
        py: Python<'py>,
        start: usize,
        end: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let colors = self.change(py, |state| {
            let splats = state.scene.gaussians.get(start..end).unwrap_or_default();
            Ok(splats.iter().map(|splat| splat.color.to_array()).collect::<Vec<_>>())
        })?;
        let count = colors.len();
        array(py, colors.into_flattened(), &[count, 3])
    }

    /// World position of what the library calls 0 [m].
    #[getter]
    fn origin(&self, py: Python<'_>) -> PyResult<[f64; 3]> {
        self.change(py, |state| Ok(state.origin.to_array()))
    }

    #[getter]
    fn lights(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.change(py, |state| {
            Ok(state.scene.lights.iter().map(|light| light.name.clone()).collect())
        })
    }

    #[getter]
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.change(py, |state| Ok(state.scene.notes.clone()))
    }

    #[getter]
    fn skipped<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let skipped = self.change(py, |state| Ok(state.scene.skipped.clone()))?;
        counts(py, &skipped)
    }

    /// Eye, target and up, field of view [degrees] and size [pixels], if somebody placed the camera.
    #[getter]
    #[allow(clippy::type_complexity, reason = "a tuple of Python")]
    fn camera(
        &self,
        py: Python<'_>,
    ) -> PyResult<Option<([f64; 3], [f64; 3], [f64; 3], f64, [u32; 2])>> {
        self.change(py, |state| {
            let camera = state.scene.camera;
            let place = |at: Vec3| (at.as_dvec3() + state.origin).to_array();
            let up = camera.up.as_dvec3().to_array();
            let fov = f64::from(camera.fov_y).to_degrees();
            let seen = (place(camera.eye), place(camera.target), up, fov, camera.size.to_array());
            Ok(state.has_camera.then_some(seen))
        })
    }

    /// Lowest and highest corner of all casters and receivers [m]; `None` of nothing.
    #[getter]
    fn bounds(&self, py: Python<'_>) -> PyResult<Option<[[f64; 3]; 2]>> {
        self.change(py, |state| {
            let bounds = state.scene.bounds();
            let corners = [bounds.min, bounds.max];
            let corners = corners.map(|corner| (corner.as_dvec3() + state.origin).to_array());
            Ok((!bounds.is_empty()).then_some(corners))
        })
    }

    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = self.change(py, |state| {
            let scene = &state.scene;
            let bricks = scene.grids.iter().map(|grid| grid.bricks.len()).sum::<usize>();
            Ok([
                ("particles", scene.particles.len()),
                ("gaussians", scene.gaussians.len()),
                ("triangles", scene.triangles.len()),
                ("bricks", bricks),
                ("strands", scene.strands.len()),
                ("lights", scene.lights.len()),
                ("materials", scene.materials.len()),
                ("textures", scene.textures.len()),
            ])
        })?;
        let dict = PyDict::new(py);
        for (name, count) in all {
            dict.set_item(name, count)?;
        }
        Ok(dict)
    }
}

/// Farthest coordinate of a point [m].
const FARTHEST: f32 = 1e7;

/// Points with normals, each checked.
fn receivers(
    positions: &[[f32; 3]],
    normals: Option<&[[f32; 3]]>,
) -> Result<Vec<ReceiverPoint>, Fault> {
    if let Some(normals) = normals.filter(|normals| normals.len() != positions.len()) {
        let message = format!("{} normals of {} points", normals.len(), positions.len());
        return Err(Fault::input(message, "give one normal for each point, or none"));
    }
    let mut points = Vec::new();
    let bytes = size_of_val(positions) as u64 * 2;
    points.try_reserve_exact(positions.len()).map_err(|_| Fault::Memory(bytes))?;
    for (row, &position) in positions.iter().enumerate() {
        let position = Vec3::from(position);
        let normal = normals.map_or(Vec3::ZERO, |normals| normals[row].into());
        let is_near = position.is_finite() && position.abs().max_element() <= FARTHEST;
        // A normal of length zero is none.
        let unit = if normal == Vec3::ZERO { Some(normal) } else { normal.try_normalize() };
        let (true, Some(normal)) = (is_near, unit) else {
            let message = format!("points: row {row} is {position:?}, normal {normal:?}");
            let remedy = "positions must be finite and within 1e7 m, normals finite";
            return Err(Fault::input(message, remedy));
        };
        points.push(ReceiverPoint { position, normal });
    }
    Ok(points)
}
