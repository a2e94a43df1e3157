//! What light passes diffusely, such as leaves and lampshades: the triangles that are seen cast no shadow,
//! and hidden ones in their place filter.
use super::{
    Scene, SceneError,
    limits::{self, Limit},
};
use glam::Vec3;
use gobo::model::{Material, Motion, Transfer, Triangle, VertexColor};
use std::{path::Path, sync::Arc};

/// The material of the light that passes: a gel of the seen one's coverage, behind which that light falls
/// where the straight ray does. `passes`: share of light, per channel, and `lacks`, without textures, what
/// the near side does not scatter for it; `index`: of the new material. The seen one casts no more.
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

/// Adds the triangles that filter to a scene that is placed, for all frames.
pub(super) fn add_filters(scene: &mut Scene, path: &Path) -> Result<(), SceneError> {
    let Scene { triangles, materials, motions, .. } = scene;
    if let Some(filters) = Filters::add(triangles, materials, path)?
        && !motions.is_empty()
    {
        motions.push(Arc::new(filters));
    }
    Ok(())
}

/// Triangles that filter in the place of those that are seen.
#[derive(Clone, Debug)]
pub(super) struct Filters {
    /// The first of them, behind all others.
    first: usize,
    /// Those that are seen.
    seen: Vec<u32>,
}

impl Filters {
    /// Adds them to all triangles, if some are needed.
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
            // Of a corner's colour the alpha covers; the rest is that of the near side.
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
