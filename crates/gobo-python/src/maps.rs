//! Maps of views as arrays.
use crate::{
    arrays::{array, matrix},
    fault::Fault,
};
use gobo::{
    Light, LightKind, View,
    glam::{DMat4, DVec3, Mat4, Vec3},
};
use gobo_picture::{CurveMap, ViewMaps};
use pyo3::{
    Bound, PyResult, Python,
    types::{PyDict, PyDictMethods as _},
};

/// Numbers of a node of a curve: start, end, red, green, blue.
const FIELDS: usize = 5;
/// Start of an unused node: beyond the far plane.
const UNUSED: f32 = 2.0;

/// The maps of a view, and their description.
#[derive(Debug)]
pub(crate) struct Maps {
    view: View,
    kind: LightKind,
    filter: Vec<f32>,
    nearest: Vec<f32>,
    opaque: Vec<f32>,
    colored: Vec<f32>,
    /// Nodes of a texel, and their numbers.
    curve: Option<(usize, Vec<f32>)>,
}

impl Maps {
    pub(crate) fn new(maps: ViewMaps, light: &Light) -> Result<Self, Fault> {
        let shadow = light.all_shadows().nth(maps.view.shadow_index(light));
        Ok(Self {
            kind: shadow.map_or(light.kind, |shadow| shadow.kind),
            filter: maps.filter.into_flattened(),
            nearest: maps.nearest,
            opaque: maps.opaque,
            colored: maps.colored.into_flattened(),
            curve: maps.curve.as_ref().map(nodes).transpose()?,
            view: maps.view,
        })
    }

    /// Name of the view.
    pub(crate) fn name(&self) -> &'static str {
        self.view.name
    }

    pub(crate) fn dict(self, py: Python<'_>, origin: DVec3) -> PyResult<Bound<'_, PyDict>> {
        let Self { view, kind, filter, nearest, opaque, colored, curve } = self;
        let [columns, rows] = view.size.to_array().map(|size| size as usize);
        let dict = PyDict::new(py);
        dict.set_item("filter", array(py, filter, &[rows, columns, 3])?)?;
        dict.set_item("nearest", array(py, nearest, &[rows, columns])?)?;
        dict.set_item("opaque", array(py, opaque, &[rows, columns])?)?;
        if !colored.is_empty() {
            dict.set_item("colored", array(py, colored, &[rows, columns, 3])?)?;
        }
        if let Some((nodes, values)) = curve {
            dict.set_item("curve", array(py, values, &[rows, columns, nodes, FIELDS])?)?;
        }
        let from_world = DMat4::from_translation(-origin);
        let of_world =
            |from_scene: Mat4| matrix(py, (from_scene.as_dmat4() * from_world).to_cols_array());
        dict.set_item("clip_from_world", of_world(view.clip_from_world())?)?;
        dict.set_item("view_from_world", of_world(view.view_from_world)?)?;
        dict.set_item("near", view.near)?;
        dict.set_item("far", view.far)?;
        dict.set_item("view", view.name)?;
        let place =
            |position: Vec3| array(py, (position.as_dvec3() + origin).to_array().to_vec(), &[3]);
        let (kind, place) = match kind {
            LightKind::Directional { direction } => {
                let direction = direction.as_dvec3().to_array().to_vec();
                ("directional", ("direction", array(py, direction, &[3])?))
            }
            LightKind::Spot { position, .. } => ("spot", ("position", place(position)?)),
            LightKind::Point { position } => ("point", ("position", place(position)?)),
        };
        dict.set_item("kind", kind)?;
        dict.set_item(place.0, place.1)?;
        Ok(dict)
    }
}

/// The nodes of all texels, as `gobo render --maps` writes them.
fn nodes(curve: &CurveMap) -> Result<(usize, Vec<f32>), Fault> {
    let count = curve.texel_count() * curve.nodes * FIELDS;
    let mut values = Vec::new();
    let bytes = count as u64 * size_of::<f32>() as u64;
    values.try_reserve_exact(count).map_err(|_| Fault::Memory(bytes))?;
    for texel in 0..curve.texel_count() {
        let mut behind = Vec3::ONE;
        let end = values.len() + curve.nodes * FIELDS;
        for (start, end, light) in curve.ramps(texel) {
            values.extend([start, end, light.x, light.y, light.z]);
            behind = light;
        }
        while values.len() < end {
            values.extend([UNUSED, UNUSED, behind.x, behind.y, behind.z]);
        }
    }
    Ok((curve.nodes, values))
}
