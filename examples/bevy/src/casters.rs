//! Bevy's meshes as gobo's casters, and its sun.
use bevy::{prelude::*, render::RenderApp, render::extract_resource::ExtractResource};
use gobo::{Material, Transfer, Triangle};
use std::sync::Arc;

/// Effect of a mesh on the sun's light. The mesh need not be drawn.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub enum GoboCaster {
    /// Blocks all light.
    Blocks,
    /// Filters light like coloured glass: alpha is the share of the mesh that is glass, the colour its
    /// transmittance.
    Tints(LinearRgba),
}

impl GoboCaster {
    fn material(self) -> Material {
        match self {
            Self::Blocks => Material { transfer: Transfer::Opaque, ..Default::default() },
            Self::Tints(LinearRgba { red, green, blue, alpha }) => Material {
                transfer: Transfer::Filter,
                tint: [red, green, blue, alpha].into(),
                ..Default::default()
            },
        }
    }
}

/// Triangles of all casters, world space [m].
#[derive(Resource, Clone, Default, ExtractResource)]
#[extract_app(RenderApp)]
pub(crate) struct SceneCasters {
    pub triangles: Arc<Vec<Triangle>>,
    pub materials: Arc<Vec<Material>>,
}

/// Direction in which the directional light travels; `None` without one.
#[derive(Resource, Clone, Copy, Default, PartialEq, ExtractResource)]
#[extract_app(RenderApp)]
pub(crate) struct Sun(pub Option<Vec3>);

type Moved = Or<(Changed<GlobalTransform>, Changed<GoboCaster>, Changed<Mesh3d>)>;

/// Gathers all triangles anew if a caster has moved, appeared or vanished.
pub(crate) fn gather(
    moved: Query<(), (With<GoboCaster>, Moved)>,
    mut gone: RemovedComponents<GoboCaster>,
    all: Query<(&Mesh3d, &GlobalTransform, &GoboCaster)>,
    meshes: Res<Assets<Mesh>>,
    mut waits: Local<bool>,
    mut scene: ResMut<SceneCasters>,
) {
    if moved.is_empty() && gone.read().count() == 0 && !*waits {
        return;
    }
    *waits = false;
    let (mut kinds, mut triangles) = (Vec::<GoboCaster>::new(), Vec::new());
    for (mesh, place, caster) in &all {
        // Loaded in a later frame.
        let Some(mesh) = meshes.get(&mesh.0) else {
            *waits = true;
            continue;
        };
        let Ok(faces) = mesh.triangles() else { continue };
        let known = kinds.iter().position(|kind| kind == caster);
        let material = known.unwrap_or_else(|| {
            kinds.push(*caster);
            kinds.len() - 1
        });
        let world = |corner| place.transform_point(corner).to_array();
        let cast = faces.map(|face| Triangle::flat(face.vertices.map(world), material as u32));
        triangles.extend(cast);
    }
    let materials = kinds.into_iter().map(GoboCaster::material).collect();
    *scene = SceneCasters { triangles: Arc::new(triangles), materials: Arc::new(materials) };
}

/// Follows the directional light, the first of several.
pub(crate) fn follow_sun(
    lights: Query<&GlobalTransform, With<DirectionalLight>>,
    mut sun: ResMut<Sun>,
) {
    sun.set_if_neq(Sun(lights.iter().next().map(|place| place.forward().as_vec3())));
}
