//! The class that the package's `Scene` wraps.
use crate::{
    adapter,
    arrays::array,
    contents::Added,
    fault::Fault,
    job::{self, Stop},
    look,
    state::State,
    tables,
};
use gobo::{
    glam::{DVec3, Vec3},
    model::Skipped,
};
use gobo_picture::Renderer;
use gobo_scene as scene;
use gobo_scene::LoadOptions;
use pyo3::{
    Bound, PyAny, PyResult, Python, pyclass, pymethods,
    types::{PyDict, PyDictMethods as _},
};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
use toml::Table;

/// A scene: one call at a time works with it.
#[pyclass(frozen, module = "gobo_shadows._native")]
#[derive(Debug)]
pub(crate) struct Scene {
    state: Arc<Mutex<State>>,
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Counts by reason for Python.
pub(crate) fn counts<'py>(py: Python<'py>, skipped: &Skipped) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (reason, count) in skipped {
        dict.set_item(*reason, *count)?;
    }
    Ok(dict)
}

pub(crate) type Counted<'py> = PyResult<(usize, Bound<'py, PyDict>)>;

impl Scene {
    fn of(state: State) -> Self {
        Self { state: Arc::new(Mutex::new(state)) }
    }

    /// Result of `change`, which runs without the interpreter's lock.
    pub(crate) fn change<T: Send>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut State) -> Result<T, Fault> + Send,
    ) -> PyResult<T> {
        py.detach(|| change(&mut lock(&self.state))).map_err(|fault| fault.raised(py))
    }

    pub(crate) fn added<'py>(
        &self,
        py: Python<'py>,
        change: impl FnOnce(&mut State) -> Result<Added, Fault> + Send,
    ) -> Counted<'py> {
        let (count, skipped) = self.change(py, change)?;
        Ok((count, counts(py, &skipped)?))
    }

    /// A long call with a renderer.
    pub(crate) fn job<T: Send + 'static>(
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

    /// World position of the library's origin [m].
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

    /// Eye, target and up, field of view [degrees] and size [pixels], if the camera was placed.
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

    /// Lowest and highest corner of all casters and receivers [m]; `None` if there are none.
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
