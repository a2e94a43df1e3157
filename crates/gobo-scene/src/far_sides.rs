//! Surfaces that transmit light diffusely, such as leaves and lampshades: the visible triangles cast no
//! shadow, and invisible filters in their place do.
use super::{
    Scene, SceneError,
    limits::{self, Limit},
};
use glam::Vec3;
use gobo::model::{Material, Motion, Transfer, Triangle, VertexColor};
use std::{path::Path, sync::Arc};

/// Material that filters the transmitted light: a gel with the visible material's coverage. The light falls
/// where the straight ray does. `passes`: transmitted share per channel; `lacks`: share that the near side,
/// without textures, no longer scatters; `index`: of the new material. The visible material stops casting.
pub(super) fn far_side(seen: &mut Material, index: u32, lacks: f32, passes: Vec3) -> Material {
    let casts = std::mem::replace(&mut seen.casts, false);
    let alpha = match seen.transfer {
        Transfer::Cutout if seen.tint.w < seen.cutoff => 0.0,
        Transfer::Cutout => 1.0,
        _ => seen.tint.w,
    };
    seen.far_side = Some(index);
    Material {
        name: format!("{} (far side)", seen.name),
        transfer: Transfer::Filter,
        tint: ((1.0 - seen.metallic) * passes).extend(alpha),
        texture: seen.texture,
        transmission: lacks,
        visible: false,
        casts,
        ..Material::default()
    }
}

/// Adds filter triangles to a placed scene, for all frames.
pub(super) fn add_filters(scene: &mut Scene, path: &Path) -> Result<(), SceneError> {
    let Scene { triangles, materials, motions, .. } = scene;
    if let Some(filters) = Filters::add(triangles, materials, path)?
        && !motions.is_empty()
    {
        motions.push(Arc::new(filters));
    }
    Ok(())
}

/// Filter triangles in the place of visible ones.
#[derive(Clone, Debug)]
pub(super) struct Filters {
    /// Index of the first, after all other triangles.
    first: usize,
    /// Indices of the visible triangles.
    seen: Vec<u32>,
}

impl Filters {
    /// Appends the filters to all triangles, if any are needed.
    pub(super) fn add(
        triangles: &mut Vec<Triangle>,
        materials: &[Material],
        path: &Path,
    ) -> Result<Option<Self>, SceneError> {
        let first = triangles.len();
        let seen = (0..).zip(triangles.iter());
        let seen = seen.filter(|(_, t)| materials[t.material as usize].far_side.is_some());
        let seen: Vec<u32> = seen.map(|(index, _)| index).collect();
        if seen.is_empty() {
            return Ok(None);
        }
        Limit::Triangles.grown_in(path, first as u64, seen.len() as u64)?;
        limits::reserve(triangles, seen.len(), "triangles", path)?;
        let filters = Self { first, seen };
        filters.place(triangles, materials);
        Ok(Some(filters))
    }

    fn place(&self, triangles: &mut Vec<Triangle>, materials: &[Material]) {
        triangles.truncate(self.first);
        for &index in &self.seen {
            let mut triangle = triangles[index as usize];
            let far = materials[triangle.material as usize].far_side;
            triangle.material = far.unwrap_or(triangle.material);
            // A corner's alpha is coverage; its colour is that of the near side.
            let covers = |VertexColor([.., alpha])| VertexColor([255, 255, 255, alpha]);
            triangle.colors = triangle.colors.map(covers);
            triangles.push(triangle);
        }
    }
}

impl Motion for Filters {
    fn apply(&self, scene: &mut Scene, _seconds: f64) {
        self.place(&mut scene.triangles, &scene.materials);
    }
}
