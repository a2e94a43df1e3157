//! Questions to the package's `Scene`.
use crate::{
    arrays::{array, rows},
    fault::Fault,
    look,
    maps::Maps,
    progress::Progress,
    scene::Scene,
    state::LightName,
    tables, work,
};
use gobo_picture::Watch;
use numpy::PyReadonlyArray2;
use pyo3::{Bound, FromPyObject, Py, PyAny, PyResult, Python, pymethods, types::PyDict};

/// A light by its name or index.
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

#[pymethods]
impl Scene {
    /// Seconds that the CPU reference will take for a picture; `None` with a device.
    fn estimate(&self, py: Python<'_>, camera: &Bound<'_, PyDict>) -> PyResult<Option<f64>> {
        let camera = tables::table("camera", camera)?;
        self.job(py, move |state, renderer, _| {
            look::with(state, &camera, None, |state| Ok(renderer.estimate(&state.scene)))
        })
    }

    /// Linear light, the displayed picture, and warnings.
    #[allow(clippy::type_complexity, reason = "a tuple of Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        camera: &Bound<'py, PyDict>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<String>)> {
        let camera = tables::table("camera", camera)?;
        let progress = Progress::new(progress);
        let (picture, warnings) = self.job(py, move |state, renderer, stop| {
            let watch = |share| progress.tell(stop, share);
            work::render(state, renderer, &camera, Watch(&watch))
                .map_err(|fault| progress.cause_of(fault))
        })?;
        let [width, height] = picture.size.to_array().map(|size| size as usize);
        let shape = [height, width, 3];
        let light = array(py, picture.light.into_flattened(), &shape)?;
        Ok((light, array(py, picture.rgb.into_flattened(), &shape)?, warnings))
    }

    /// Maps of all views of a light, in their order, and warnings.
    #[allow(clippy::type_complexity, reason = "a tuple of Python")]
    fn maps<'py>(
        &self,
        py: Python<'py>,
        light: Light,
        camera: &Bound<'py, PyDict>,
        curve: Option<u32>,
    ) -> PyResult<(Vec<(&'static str, Bound<'py, PyDict>)>, Vec<String>)> {
        let camera = tables::table("camera", camera)?;
        let light = LightName::from(light);
        let (all, origin, warnings) = self.job(py, move |state, renderer, _| {
            let (maps, warnings) = work::maps(state, renderer, &light, &camera, curve)?;
            Ok((maps, state.origin, warnings))
        })?;
        let named = |maps: Maps| Ok((maps.name(), maps.dict(py, origin)?));
        Ok((all.into_iter().map(named).collect::<PyResult<_>>()?, warnings))
    }

    /// Share of each light that reaches points, and a warning; their positions are less the origin.
    fn light<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f32>,
        normals: Option<PyReadonlyArray2<'py, f32>>,
    ) -> PyResult<(Bound<'py, PyAny>, Option<String>)> {
        let raised = |fault: Fault| fault.raised(py);
        let positions = rows::<f32, 3>(&points, "points").map_err(raised)?;
        let normals = normals.as_ref().map(|normals| rows::<f32, 3>(normals, "normals"));
        let normals = normals.transpose().map_err(raised)?;
        let points = py.detach(|| work::receivers(positions, normals)).map_err(raised)?;
        let count = points.len();
        let (shares, warning, lights) = self.job(py, move |state, renderer, stop| {
            let (shares, warning) = work::light(state, renderer, &points, stop)?;
            Ok((shares, warning, state.scene.lights.len()))
        })?;
        Ok((array(py, shares, &[count, lights, 3])?, warning))
    }

    /// Share of the light that reaches the splats `start..end`, and a warning.
    fn relight<'py>(
        &self,
        py: Python<'py>,
        start: usize,
        end: usize,
    ) -> PyResult<(Bound<'py, PyAny>, Option<String>)> {
        let (shares, warning) =
            self.job(py, move |state, renderer, _| work::relight(state, renderer, start..end))?;
        let count = shares.len();
        Ok((array(py, shares.into_flattened(), &[count, 3])?, warning))
    }
}
