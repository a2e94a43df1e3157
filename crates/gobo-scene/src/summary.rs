//! Summary of a scene's contents, for people and scripts.
use super::Scene;
use gobo::model::{Skipped, SoftLight};
use std::fmt;

/// Counts of a scene.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Summary {
    /// Particles, without those of emitters.
    pub particles: usize,
    /// Splats: anisotropic Gaussians.
    pub splats: usize,
    /// Most live particles of emitters.
    pub emitted: u64,
    /// Most particle steps for a frame on its own, with those of neighbours in fluids.
    pub steps: u64,
    /// Triangles.
    pub triangles: usize,
    /// Grids of voxels.
    pub grids: usize,
    /// Bricks of all grids.
    pub bricks: usize,
    /// Strands.
    pub strands: usize,
    /// Materials.
    pub materials: usize,
    /// Textures.
    pub textures: usize,
    /// Lights.
    pub lights: usize,
    /// Shadow views of all lights.
    pub views: usize,
    /// Texels and viewpoints chosen for lights with a size.
    pub soft: Vec<SoftLight>,
    /// Corners of the box around all casters and receivers, world space \[m\].
    pub bounds: Option<[[f32; 3]; 2]>,
    /// Inputs left out, by reason.
    pub skipped: Skipped,
}

impl Summary {
    /// Summary of a scene's contents.
    pub fn of(scene: &Scene) -> Self {
        let bounds = scene.bounds();
        let first_emitted = scene.motions.iter().find_map(|motion| motion.first_particle());
        Self {
            particles: first_emitted.unwrap_or(scene.particles.len()),
            splats: scene.gaussians.len(),
            emitted: scene.motions.iter().map(|motion| motion.most_particles()).sum(),
            steps: scene.motions.iter().map(|motion| motion.most_steps()).sum(),
            triangles: scene.triangles.len(),
            grids: scene.grids.len(),
            bricks: scene.grids.iter().map(|grid| grid.bricks.len()).sum(),
            strands: scene.strands.len(),
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            lights: scene.lights.len(),
            views: gobo::view::shadow_views(scene).len(),
            soft: scene.soft.clone(),
            bounds: (!bounds.is_empty())
                .then(|| [bounds.min, bounds.max].map(|corner| (corner + scene.origin).into())),
            skipped: scene.skipped.clone(),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { particles, splats, emitted, steps, triangles, grids, bricks, materials, .. } =
            self;
        let Self { strands, textures, lights, views, soft, .. } = self;
        writeln!(f, "casters    {particles} particles, {triangles} triangles")?;
        if *splats > 0 {
            writeln!(f, "splats     {splats}")?;
        }
        if *grids > 0 {
            writeln!(f, "volumes    {grids}, of {bricks} bricks")?;
        }
        if *strands > 0 {
            writeln!(f, "strands    {strands}")?;
        }
        if *emitted > 0 {
            writeln!(
                f,
                "emitters   at most {emitted} particles at a time, {steps} steps of them for a frame"
            )?;
        }
        writeln!(f, "materials  {materials}, with {textures} textures")?;
        writeln!(f, "lights     {lights}, with {views} shadow views")?;
        for SoftLight { light, asked, size, viewpoints } in soft {
            let from =
                if *viewpoints == 1 { "1 viewpoint" } else { &format!("{viewpoints} viewpoints") };
            writeln!(
                f,
                "penumbrae  {light}: {asked} texels asked for, maps of {size} from {from}"
            )?;
        }
        match &self.bounds {
            Some([min, max]) => write!(f, "bounds     {min:?} to {max:?} m")?,
            None => write!(f, "bounds     none: there is nothing to see")?,
        }
        for (reason, count) in &self.skipped {
            write!(f, "\nskipped    {count}: {reason}")?;
        }
        Ok(())
    }
}
