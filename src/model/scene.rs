//! Everything a frame is made from.
use super::{
    Air, Bounds, Camera, Casters, ClusterSettings, Environment, IRRADIANCE, Light, MaskSettings,
    Material, Particle, ShadowSettings, Skipped, Texture, Triangle,
};
use glam::{DVec2, Vec2, Vec3};
use std::sync::Arc;

/// Most places in a pixel that a picture is the mean of.
pub const MAX_SAMPLES: u32 = 16;

/// Everything a frame is made from, in world space (less [`Self::origin`]). Every number in it is finite and in range:
/// what was not is in `skipped`.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Where in the world the scene's own (0, 0, 0) is [m]: scenes far away are moved near it.
    pub origin: Vec3,
    /// Camera of the picture.
    pub camera: Camera,
    /// Exposure of the picture [stops]: light is shown 2 to this power as bright.
    pub exposure: f32,
    /// Places in a pixel that the picture is the mean of: 1 to [`MAX_SAMPLES`], less or more count as
    /// these.
    pub samples: u32,
    /// Shadow settings, shared by all lights.
    pub shadow: ShadowSettings,
    /// Light clusters (froxels) of the picture.
    pub clusters: ClusterSettings,
    /// Masks through which what is solid is lit; none where every point asks the maps.
    pub mask: Option<MaskSettings>,
    /// At most 4,096.
    pub lights: Vec<Light>,
    /// At most 512, named by casters.
    pub materials: Vec<Material>,
    /// Named by materials.
    pub textures: Vec<Texture>,
    /// Discs, quads and puffs.
    pub particles: Vec<Particle>,
    /// Triangles of meshes and shapes, world space.
    pub triangles: Vec<Triangle>,
    /// Light that comes from everywhere, where there is no environment: linear rgb.
    pub ambient: Vec3,
    /// What the camera sees where there is nothing, and mirrors show, where there is no environment:
    /// linear rgb.
    pub background: Vec3,
    /// What lights, is mirrored and is seen all around.
    pub environment: Option<Arc<Environment>>,
    /// What scatters light on its way to the eye; `None` where it is clear.
    pub air: Option<Air>,
    /// What follows the time: textures that flow, bodies that swell.
    pub motions: Vec<Arc<dyn Motion>>,
    /// Inputs left out, by reason.
    pub skipped: Skipped,
    /// What its files hold and nobody reads, a sentence each.
    pub notes: Vec<String>,
}

/// A part of a scene that follows the time.
pub trait Motion: std::fmt::Debug + Send + Sync {
    /// Makes the part what it is at `seconds` from the start.
    fn apply(&self, scene: &mut Scene, seconds: f64);

    /// Whether particles change their places, or come and go.
    fn moves_particles(&self) -> bool {
        false
    }

    /// The same, of a scene that is moved [m]; `None` for what has no place.
    fn moved(&self, _by: Vec3) -> Option<Arc<dyn Motion>> {
        None
    }
}

impl Scene {
    /// Places in a pixel, from its middle [pixels]: evenly (Roberts 2018, the R2 sequence), with their
    /// mean in the middle.
    pub fn sample_offsets(&self) -> impl Iterator<Item = Vec2> {
        const STEP: DVec2 = DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053);
        let count = self.samples.clamp(1, MAX_SAMPLES);
        let place = |i| (0.5 + STEP * f64::from(i)).fract() - 0.5;
        let mean = (0..count).map(place).sum::<DVec2>() / f64::from(count);
        (0..count).map(move |i| (place(i) - mean).as_vec2())
    }

    /// Light that comes from everywhere, the mean over all directions: linear rgb.
    pub fn mean_ambient(&self) -> Vec3 {
        self.environment.as_ref().map_or(self.ambient, |environment| environment.mean())
    }

    /// What a white surface sends back of the light from everywhere, for
    /// [`irradiance_at`](super::irradiance_at).
    pub fn irradiance(&self) -> [Vec3; IRRADIANCE] {
        if let Some(environment) = &self.environment {
            return *environment.irradiance();
        }
        // A little brighter from above.
        let mut of_two_colours = [Vec3::ZERO; IRRADIANCE];
        (of_two_colours[0], of_two_colours[1]) = (self.ambient * 0.85, self.ambient * 0.15);
        of_two_colours
    }

    /// Bounds of all casters and receivers.
    pub fn bounds(&self) -> Bounds {
        let particles =
            self.particles.iter().fold(Bounds::EMPTY, |b, p| b.with_sphere(p.center, p.radius));
        self.triangles
            .iter()
            .flat_map(|t| t.positions)
            .fold(particles, |b, p| b.with_sphere(p, 0.0))
    }

    /// What casts and what is seen, as [`crate::shadows::Shadows::prepare`] takes it.
    pub fn casters(&self) -> Casters<'_> {
        let Self { particles, triangles, materials, textures, .. } = self;
        // What a frame looks like must not depend on who was whose neighbour in the one before.
        let in_order = self.motions.iter().any(|motion| motion.moves_particles());
        Casters { particles, triangles, materials, textures, in_order }
    }

    /// Frames of a second of [`Self::set_time`], where frames are numbered.
    pub const FRAME_RATE: f64 = 24.0;

    /// Makes the textures and triangles that follow the time what they are then [s].
    pub fn set_time(&mut self, seconds: f64) {
        let motions = std::mem::take(&mut self.motions);
        for motion in &motions {
            motion.apply(self, seconds);
        }
        self.motions = motions;
    }
}

impl Default for Scene {
    /// No casters and no lights, under an overcast sky.
    fn default() -> Self {
        Self {
            origin: Vec3::ZERO,
            camera: Camera::default(),
            exposure: 0.0,
            samples: 1,
            shadow: ShadowSettings::default(),
            clusters: ClusterSettings::default(),
            mask: None,
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            particles: Vec::new(),
            triangles: Vec::new(),
            ambient: Vec3::new(0.18, 0.20, 0.24),
            background: Vec3::new(0.52, 0.62, 0.75),
            environment: None,
            air: None,
            motions: Vec::new(),
            skipped: Skipped::new(),
            notes: Vec::new(),
        }
    }
}
