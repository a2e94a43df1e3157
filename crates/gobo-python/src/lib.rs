//! Python's interface: scenes made of arrays. The package's Python files check arrays and hold the
//! documentation; they call the functions here.
mod adapter;
mod adding;
mod arrays;
mod asking;
mod contents;
mod fault;
mod job;
mod look;
mod maps;
mod progress;
mod scene;
mod state;
mod tables;
mod voxels;
mod work;

use pyo3::pymodule;

/// The compiled part of `gobo_shadows`.
#[pymodule]
mod _native {
    use crate::{adapter, fault::Fault, job};
    use pyo3::{Bound, PyResult, Python, pyfunction, types::PyBytes};
    use std::{borrow::Cow, ffi::OsString};

    #[pymodule_export]
    use crate::scene::Scene;

    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name")]
    const version: &str = env!("CARGO_PKG_VERSION");

    /// Runs the program; its name is the first argument. Returns the exit status.
    #[pyfunction]
    fn program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| gobo_cli::program(arguments))
    }

    /// Name of the adapter, or of the CPU reference, for users.
    #[pyfunction]
    fn adapter_name(py: Python<'_>) -> PyResult<String> {
        job::run(py, |_| adapter::with(|renderer| Ok(renderer.device())))
    }

    /// Sets the adapter of later calls; `name`: part of its name.
    #[pyfunction]
    fn use_adapter(py: Python<'_>, backend: &str, name: Option<String>) -> PyResult<()> {
        let backend = adapter::backend(backend).map_err(|fault| fault.raised(py))?;
        py.detach(|| adapter::choose(backend, name));
        Ok(())
    }

    /// Waits for interrupted calls and closes devices, before the interpreter ends.
    #[pyfunction]
    fn finish(py: Python<'_>) {
        py.detach(|| {
            if !job::is_forked() {
                job::wait_for_all();
                adapter::close();
            }
        });
    }

    /// Marks this process as forked.
    #[pyfunction]
    fn forked() {
        job::forked();
    }

    /// A PNG file of sRGB bytes, rows from the top.
    #[pyfunction]
    fn encode_png<'py>(
        py: Python<'py>,
        rgb: numpy::PyReadonlyArray3<'py, u8>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let [height, width, channels] = rgb.as_array().dim().into();
        let bytes = rgb.as_slice().map_err(|_| Fault::not_contiguous("rgb").raised(py))?;
        let size = (channels == 3).then_some([width, height]);
        let size = size.and_then(|size| Some([size[0].try_into().ok()?, size[1].try_into().ok()?]));
        let png = py.detach(|| size.and_then(|size| png_of(size, bytes)));
        let fault =
            || Fault::input("no picture of (height, width, 3) bytes", "give it some pixels");
        Ok(PyBytes::new(py, &png.ok_or_else(fault).map_err(|fault| fault.raised(py))?))
    }

    fn png_of([width, height]: [u32; 2], rgb: &[u8]) -> Option<Vec<u8>> {
        let mut file = Vec::new();
        let mut info = png::Info::with_size(width, height);
        info.color_type = png::ColorType::Rgb;
        info.bit_depth = png::BitDepth::Eight;
        info.srgb = Some(png::SrgbRenderingIntent::Perceptual);
        let encoder = png::Encoder::with_info(&mut file, info).ok()?;
        let mut writer = encoder.write_header().ok()?;
        writer.write_image_data(&Cow::Borrowed(rgb)).ok()?;
        writer.finish().ok()?;
        Some(file)
    }
}
