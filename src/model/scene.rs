//! The scene: all inputs of a frame.
use super::{
    Air, Bounds, Camera, Casters, ClusterSettings, Course, Environment, FARTHEST, Gaussian, Grid,
    IRRADIANCE, Lens, Light, MaskSettings, Material, Occlusion, Particle, ShadowSettings, Skipped,
    SoftLight, Strand, Texture, Tone, Triangle, emission::Emission,
};
use glam::{DVec2, Vec2, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Most samples per pixel of a picture.
pub const MAX_SAMPLES: u32 = 64;

/// All inputs of a frame, in world space (less [`Self::origin`]). Every number is finite and in range:
/// invalid inputs are counted in `skipped`.
#[derive(Clone, Debug)]
pub struct Scene {
    /// World position of the scene's (0, 0, 0) \[m\]: distant scenes are re-centred.
    pub origin: Vec3,
    /// Camera of the picture.
    pub camera: Camera,
    /// Exposure of the picture \[stops\]: light is shown 2 to this power as bright.
    pub exposure: f32,
    /// Samples per pixel of the picture, clamped to 1..=[`MAX_SAMPLES`].
    pub samples: u32,
    /// Offset of the camera's axis from the picture's middle, right and down \[pixels\], at most a pixel.
    pub shift: Vec2,
    /// Lens of the camera; each sample has its own point on it.
    pub lens: Lens,
    /// Share of the time between two frames for which the camera's shutter is open, 0..=1:
    /// `Renderer::render_at` gives each sample its own time.
    pub shutter: f32,
    /// Occlusion of the picture's ambient light.
    pub occlusion: Occlusion,
    /// Share of the picture's light that spreads as in a lens, 0..=1.
    pub bloom: f32,
    /// Tone curve of the picture.
    pub tone: Tone,
    /// Shadow settings, shared by all lights.
    pub shadow: ShadowSettings,
    /// Light clusters (froxels) of the picture.
    pub clusters: ClusterSettings,
    /// Shadow masks that light opaque surfaces; without them every point reads the maps.
    pub mask: Option<MaskSettings>,
    /// Lights, at most 4,096.
    pub lights: Vec<Light>,
    /// Materials, at most 512, indexed by casters.
    pub materials: Vec<Material>,
    /// Textures, indexed by materials.
    pub textures: Vec<Texture>,
    /// Discs, quads and puffs.
    pub particles: Vec<Particle>,
    /// Anisotropic Gaussians.
    pub gaussians: Vec<Gaussian>,
    /// Emitters whose particles a device simulates: they are not among [`Self::particles`]. See
    /// [`Self::simulate_on_device`].
    pub emissions: Vec<Emission>,
    /// Triangles of meshes and shapes, world space.
    pub triangles: Vec<Triangle>,
    /// Grids of voxels.
    pub grids: Vec<Grid>,
    /// Hair, ribbons and trails.
    pub strands: Vec<Strand>,
    /// Bounds of casters that are left out but counted when views are fitted: those of other shares.
    pub around: Bounds,
    /// Values that the frames of a moving scene share, so that their views are the same.
    pub course: Course,
    /// Choices for lights with a size when the scene was loaded.
    pub soft: Vec<SoftLight>,
    /// Ambient radiance if there is no environment: linear rgb.
    pub ambient: Vec3,
    /// Background radiance that the camera and mirrors see if there is no environment: linear rgb.
    pub background: Vec3,
    /// Environment that lights the scene, is mirrored and is seen.
    pub environment: Option<Arc<Environment>>,
    /// Scattering air; `None` for clear air.
    pub air: Option<Air>,
    /// Animated parts: flowing textures, deforming bodies.
    pub motions: Vec<Arc<dyn Motion>>,
    /// Inputs left out, by reason.
    pub skipped: Skipped,
    /// Contents of its files that are ignored, a sentence each.
    pub notes: Vec<String>,
}

/// An animated part of a scene.
pub trait Motion: std::fmt::Debug + Send + Sync {
    /// Sets the part to its state at `seconds` from the start.
    fn apply(&self, scene: &mut Scene, seconds: f64);

    /// Whether particles move, or come and go.
    fn moves_particles(&self) -> bool {
        false
    }

    /// Largest number of particles that it emits at a time.
    fn most_particles(&self) -> u64 {
        0
    }

    /// Largest number of bricks of its volume.
    fn most_bricks(&self) -> u64 {
        0
    }

    /// Largest number of vertices of its particles' trails at a time.
    fn most_vertices(&self) -> u64 {
        0
    }

    /// Largest number of particle steps that a single frame takes.
    fn most_steps(&self) -> u64 {
        0
    }

    /// Index of its first particle in the scene, if it emits any.
    fn first_particle(&self) -> Option<usize> {
        None
    }

    /// First and last time at which it moves triangles, lights or the camera \[s\]; `None` if it moves none.
    fn span(&self) -> Option<[f64; 2]> {
        None
    }

    /// Sets only lights and the camera to their state at `seconds` from the start.
    fn steer(&self, _scene: &mut Scene, _seconds: f64) {}

    /// Approximate box around all places, over all time, of its moving parts whose material is `wanted`
    /// \[m\]; empty where that is not known.
    fn reach(&self, _wanted: &dyn Fn(u32) -> bool) -> Bounds {
        Bounds::EMPTY
    }

    /// The motion with its particles left to a device, if it has emitters, and for each emitter that stays on
    /// the CPU the reason. `most`: particles that a buffer of the device holds.
    fn on_device(&self, _most: u64) -> Option<(Arc<dyn Motion>, Vec<String>)> {
        None
    }

    /// The motion in a scene that is translated \[m\]; `None` if nothing in it has a position.
    fn moved(&self, _by: Vec3) -> Option<Arc<dyn Motion>> {
        None
    }
}

/// Reasons in [`Scene::skipped`] for parts that motions leave out at the present time.
pub mod moved {
    /// A particle is too far away.
    pub const PARTICLE: &str = "particle moved too far";
    pub(crate) const TRIANGLE: &str = "triangle moved too far";
    /// A Gaussian is too far away.
    pub const GAUSSIAN: &str = "gaussian moved too far";
    /// A strand is too far away.
    pub const STRAND: &str = "strand moved too far";
    /// A light or the camera is too far away.
    pub const NODE: &str = "light or camera moved too far";
    /// The file of a volume at that time cannot be read.
    pub const FRAME: &str = "file of a volume's frame not read";
    /// A voxel of a volume at that time is invalid.
    pub const VOXEL: &str = "voxel of a volume's frame below 0 or not finite";
    pub(super) const ALL: [&str; 7] = [PARTICLE, TRIANGLE, GAUSSIAN, STRAND, NODE, FRAME, VOXEL];
}

impl Scene {
    /// Sample offsets from the pixel's centre \[pixels\]: the R2 sequence (Roberts 2018), with its mean at
    /// the centre, less [`Self::shift`].
    pub fn sample_offsets(&self) -> impl Iterator<Item = Vec2> {
        const STEP: DVec2 = DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053);
        let count = self.samples.clamp(1, MAX_SAMPLES);
        let offset = |i| (0.5 + STEP * f64::from(i)).fract() - 0.5;
        let mean = (0..count).map(offset).sum::<DVec2>() / f64::from(count);
        let shift = self.shift.clamp(Vec2::NEG_ONE, Vec2::ONE);
        (0..count).map(move |i| (offset(i) - mean).as_vec2() - shift)
    }

    /// Places of the samples on the lens \[m\], to the right and up: a spiral of equal areas around its
    /// middle (Vogel 1979).
    pub fn lens_points(&self) -> impl Iterator<Item = Vec2> {
        let count = self.samples.clamp(1, MAX_SAMPLES);
        let radius = self.lens.radius;
        let turn = std::f32::consts::PI * (3.0 - 5f32.sqrt());
        (0..count).map(move |i| {
            let far = ((i as f32 + 0.5) / count as f32).sqrt();
            Vec2::from_angle(i as f32 * turn) * (far * radius)
        })
    }

    /// Ambient radiance, the mean over all directions: linear rgb.
    pub fn mean_ambient(&self) -> Vec3 {
        self.environment.as_ref().map_or(self.ambient, |environment| environment.mean())
    }

    /// Irradiance of the environment as spherical harmonics, for [`irradiance_at`](super::irradiance_at).
    pub fn irradiance(&self) -> [Vec3; IRRADIANCE] {
        if let Some(environment) = &self.environment {
            return *environment.irradiance();
        }
        // Slightly brighter from above.
        let mut of_two_colours = [Vec3::ZERO; IRRADIANCE];
        (of_two_colours[0], of_two_colours[1]) = (self.ambient * 0.85, self.ambient * 0.15);
        of_two_colours
    }

    /// Bounds of all casters and receivers, now.
    pub fn bounds(&self) -> Bounds {
        self.bounds_with(self.around)
    }

    /// Bounds of all casters and receivers in all frames: the camera's and the lights' views hold them.
    pub fn held_bounds(&self) -> Bounds {
        self.bounds_with(self.held())
    }

    fn bounds_with(&self, around: Bounds) -> Bounds {
        let particles =
            self.particles.iter().fold(around, |b, p| b.with_sphere(p.center, p.radius));
        let gaussians = self.gaussians.iter().fold(particles, |b, g| {
            b.with(&g.bounds(self.materials[g.material as usize].gaussian))
        });
        let emitted = self.emissions.iter().fold(gaussians, |b, e| b.with(&e.bounds()));
        let emitted = self.grids.iter().fold(emitted, |b, grid| b.with(&grid.bounds()));
        let emitted = self.strands.iter().fold(emitted, |b, strand| b.with(&strand.bounds()));
        let of_triangles = |triangles: &[Triangle]| {
            triangles.iter().fold(Bounds::EMPTY, |mut all, triangle| {
                for p in triangle.positions {
                    all = all.with_sphere(p, 0.0);
                }
                all
            })
        };
        let parts = self.triangles.par_chunks(4096).map(of_triangles);
        parts.reduce(|| Bounds::EMPTY, |a, b| a.with(&b)).with(&emitted)
    }

    /// Casters and visible surfaces, for [`crate::shadows::Shadows::prepare`].
    pub fn casters(&self) -> Casters<'_> {
        let Self { particles, gaussians, triangles, grids, strands, materials, textures, .. } =
            self;
        // A frame must not depend on how particles were grouped in an earlier one.
        let in_order = self.motions.iter().any(|motion| motion.moves_particles());
        Casters { particles, gaussians, triangles, grids, strands, materials, textures, in_order }
    }

    /// Frames per second of numbered frames.
    pub const FRAME_RATE: f64 = 24.0;

    /// Sets the animated parts to their state at a time \[s\].
    pub fn set_time(&mut self, seconds: f64) {
        phase!("generate");
        for reason in moved::ALL {
            self.skipped.remove(reason);
        }
        let motions = std::mem::take(&mut self.motions);
        for motion in &motions {
            motion.apply(self, seconds);
        }
        if !motions.is_empty() {
            let count = self.leave_out_far_triangles();
            if count > 0 {
                self.skipped.insert(moved::TRIANGLE, count);
            }
        }
        self.motions = motions;
    }

    /// Turns triangles that reach too far into points of another triangle, so that they change neither a
    /// texel nor the bounds. Returns their number.
    pub fn leave_out_far_triangles(&mut self) -> u64 {
        let is_near = |triangle: &Triangle| {
            let mut corners = triangle.positions.into_iter();
            corners.all(|p| p.is_finite() && p.abs().max_element() <= FARTHEST)
        };
        let far: Vec<usize> =
            (0..self.triangles.len()).filter(|&i| !is_near(&self.triangles[i])).collect();
        let near = self.triangles.iter().find(|triangle| is_near(triangle));
        let point = near.map_or(Vec3::ZERO, |triangle| triangle.positions[0]);
        for &i in &far {
            self.triangles[i].positions = [point; 3];
        }
        far.len() as u64
    }

    /// Leaves emitters to the device that renders, from the next [`Self::set_time`] on. `most`: particles
    /// that a buffer of the device holds. Returns the reason for each emitter that stays on the CPU.
    pub fn simulate_on_device(&mut self, most: u64) -> Vec<String> {
        let mut all = Vec::new();
        for motion in &mut self.motions {
            if let Some((moved, reasons)) = motion.on_device(most) {
                *motion = moved;
                all.extend(reasons);
            }
        }
        all
    }
}

impl Default for Scene {
    /// An empty scene without lights, under an overcast sky.
    fn default() -> Self {
        Self {
            origin: Vec3::ZERO,
            camera: Camera::default(),
            exposure: 0.0,
            samples: 1,
            shift: Vec2::ZERO,
            occlusion: Occlusion::None,
            lens: Lens::default(),
            shutter: 0.0,
            bloom: 0.0,
            tone: Tone::Neutral,
            shadow: ShadowSettings::default(),
            clusters: ClusterSettings::default(),
            mask: None,
            lights: Vec::new(),
            materials: Vec::new(),
            textures: Vec::new(),
            particles: Vec::new(),
            gaussians: Vec::new(),
            emissions: Vec::new(),
            triangles: Vec::new(),
            grids: Vec::new(),
            strands: Vec::new(),
            around: Bounds::EMPTY,
            course: Course::default(),
            soft: Vec::new(),
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
