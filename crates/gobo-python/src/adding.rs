//! Additions by the package's `Scene`.
use crate::{
    arrays::{array, column, rows},
    contents::{Gaussians, KindOfSplats, Mesh, Particles},
    fault::Fault,
    scene::{Counted, Scene, counts},
    state::{Wanted, check_limit},
    tables,
    voxels::Voxels,
};
use gobo::{Texture, glam::Mat4};
use gobo_scene::Limit;
use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, PyReadonlyArray4};
use pyo3::{Bound, FromPyObject, PyAny, PyResult, Python, pymethods, types::PyDict};

/// A material from Python: a name, or a dictionary and the index of an image.
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

#[pymethods]
impl Scene {
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

    /// Returns the index of the first splat in the scene, one past the last, the left out ones by reason, and
    /// their rows.
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

    /// `density`: x, y, z and one channel or three; `matrix`: world from index, rows.
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn add_volume<'py>(
        &self,
        py: Python<'py>,
        density: PyReadonlyArray4<'py, f32>,
        matrix: [[f32; 4]; 4],
        factor: f32,
        color: [f32; 3],
        albedo: [f32; 3],
        anisotropy: f32,
        casts: bool,
        visible: bool,
    ) -> Counted<'py> {
        let values = density.as_slice().map_err(|_| Fault::not_contiguous("density").raised(py))?;
        let (x, y, z, channels) = density.as_array().dim();
        let voxels = Voxels {
            values,
            size: [x, y, z],
            channels,
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
}
