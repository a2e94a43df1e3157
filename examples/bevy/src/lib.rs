//! Coloured shadows on Bevy's meshes: smoke, glass and any particles of compute shaders filter the light of
//! the sun.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_gobo::{ColoredShadows, GoboCaster, GoboMaterial, GoboPlugin, lit};
//!
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, GoboPlugin::default())).add_systems(Startup, set_up).run();
//! }
//!
//! fn set_up(
//!     mut commands: Commands,
//!     mut meshes: ResMut<Assets<Mesh>>,
//!     mut materials: ResMut<Assets<GoboMaterial>>,
//! ) {
//!     commands.spawn((Camera3d::default(), Msaa::Off, ColoredShadows, Transform::from_xyz(0.0, 2.0, 6.0)));
//!     commands.spawn((DirectionalLight::default(), Transform::default().looking_to(Vec3::NEG_Y, Vec3::X)));
//!     let ground = meshes.add(Plane3d::default().mesh().size(9.0, 9.0));
//!     let white = materials.add(lit(StandardMaterial::default()));
//!     commands.spawn((Mesh3d(ground.clone()), MeshMaterial3d(white), GoboCaster::Blocks));
//!     let pane = Transform::from_xyz(0.0, 1.0, 0.0).with_scale(Vec3::splat(0.1));
//!     commands.spawn((Mesh3d(ground), pane, GoboCaster::Tints(LinearRgba::RED)));
//! }
//! ```
//!
//! gobo borrows Bevy's device, queue and encoders, and submits nothing. Bevy's light and shading stay
//! unchanged: the fragment shader of [`GoboMaterial`] multiplies the light of the
//! [`DirectionalLight`](bevy::light::DirectionalLight) by a mask of the picture, which gobo makes from Bevy's
//! depth and normal prepass.
mod casters;
mod guest;
mod material;
mod plugin;

pub use casters::GoboCaster;
pub use gobo;
pub use guest::{Guest, ParticleSet};
pub use material::{ColoredLight, GoboMaterial, lit};
pub use plugin::{ColoredShadows, GoboPlugin, GoboSystems};
