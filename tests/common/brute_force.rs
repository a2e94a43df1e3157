//! A renderer in 64 bits, straight from the formulas: every texel tests every caster. It shares no code
//! with the crate's, and uses no tricks.
use super::{compare::ExpectedTexel, gaussian_truth, grid_truth, strand_truth};
use gobo::{
    glam::{DMat3, DVec2, DVec3, DVec4, Vec2, Vec3},
    model::{
        Brick, Camera, Gaussian, Grid, LightKind, Material, Particle, Profile, Shape, Strand,
        Texture, Transfer, Triangle, View,
    },
};
use gobo_scene::Scene;

mod meet;

use meet::{meet_brick, meet_gaussian, meet_particle, meet_strand, meet_triangle};

/// Distance to an edge below which rounding decides [texels].
const EDGE: f64 = 0.05;
/// The same for a strand, whose chord falls as a root.
const EDGE_OF_STRAND: f64 = 0.01;
/// Distance of a capsule's opacity from 1/255 below which rounding decides.
const OPACITY_OF_STRAND: f64 = 1e-3;
/// Distance of a cutout's opacity from its cutoff, and of a dithered one from 0 and 1, below which a pattern
/// or rounding decides.
const SOLID_MARGIN: f64 = 1e-3;
/// Distance of a presence from 1/255 below which rounding decides.
const OPACITY_MARGIN: f64 = 1e-4;
/// Distance to the opaque surface or the near plane below which rounding decides [light depth].
const DEPTH_MARGIN: f64 = 1e-5;
/// Distance between two hits below which rounding decides their order [light depth].
const ORDER_MARGIN: f64 = 1e-6;

fn f64s(v: Vec3) -> DVec3 {
    v.as_dvec3()
}

struct Eye {
    position: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    parallel: bool,
    /// Texels per metre; in a perspective view, at 1 m along the axis.
    scale: f64,
    size: DVec2,
    near: f64,
    far: f64,
    /// The scene's Gaussians in this view.
    gaussians: Vec<gaussian_truth::Seen>,
}

/// Ray from the eye's plane (parallel: from the near plane); `way` advances 1 m along the axis.
struct Ray {
    start: DVec3,
    way: DVec3,
    texel: DVec2,
}

#[derive(Clone, Copy)]
struct Hit {
    /// Light `L` becomes `L * light + added`.
    light: DVec3,
    added: DVec3,
    opacity: f64,
    /// Strength by which the hit sets the nearest depth: the opacity, or the light that `stain` and `gain`
    /// change without opacity.
    presence: f64,
    depth: f64,
    /// Tolerance of `depth`: the start of a medium depends on its ramp.
    reach: f64,
}

enum Met {
    Nothing,
    /// Too close to an edge to decide.
    Edge,
    Hit(Hit),
}

impl Eye {
    fn new(scene: &Scene, view: &View) -> Self {
        let forward = f64s(view.direction()).normalize();
        let up = if forward.y.abs() > 0.99 { DVec3::Z } else { DVec3::Y };
        let right = forward.cross(up).normalize();
        let size = view.size.as_dvec2();
        let (parallel, scale) = match scene.lights[view.light.expect("a light's view")].kind {
            LightKind::Directional { .. } => (true, f64::from(view.scale)),
            LightKind::Spot { angle, .. } => (false, size.x * 0.5 / (f64::from(angle) * 0.5).tan()),
            LightKind::Point { .. } => (false, size.x * 0.5),
        };
        Self {
            position: f64s(view.position()),
            forward,
            right,
            up: right.cross(forward),
            parallel,
            scale,
            size,
            near: f64::from(view.near),
            far: f64::from(view.far),
            gaussians: Vec::new(),
        }
    }

    /// The picture's view; every depth in front of it is within its planes.
    fn of_camera(camera: &Camera) -> Self {
        let forward = f64s(camera.target - camera.eye).normalize();
        let right = forward.cross(f64s(camera.up)).normalize();
        let size = camera.size.as_dvec2();
        Self {
            position: f64s(camera.eye),
            forward,
            right,
            up: right.cross(forward),
            parallel: false,
            scale: size.y * 0.5 / (f64::from(camera.fov_y) * 0.5).tan(),
            size,
            near: NEAREST_SEEN,
            far: 1e3,
            gaussians: Vec::new(),
        }
    }

    fn ray(&self, texel: DVec2) -> Ray {
        let x = (texel.x - self.size.x * 0.5) / self.scale;
        let y = (self.size.y * 0.5 - texel.y) / self.scale;
        let aside = self.right * x + self.up * y;
        if self.parallel {
            Ray { start: self.position + aside, way: self.forward, texel }
        } else {
            Ray { start: self.position, way: self.forward + aside, texel }
        }
    }

    /// Light depth of the point at `t` along the ray.
    fn depth(&self, t: f64) -> f64 {
        let behind_near = if self.parallel { t } else { t - self.near };
        behind_near / (self.far - self.near)
    }

    fn ways(&self, depth: f64) -> f64 {
        depth * (self.far - self.near) + if self.parallel { 0.0 } else { self.near }
    }

    fn along_axis(&self, point: DVec3) -> f64 {
        (point - self.position).dot(self.forward)
    }

    /// World size of a texel at `point` [m]; zero or negative behind the eye.
    fn texel_size(&self, point: DVec3) -> f64 {
        if self.parallel { 1.0 / self.scale } else { self.along_axis(point) / self.scale }
    }

    fn project(&self, point: DVec3) -> DVec2 {
        let p = point - self.position;
        let per_metre = if self.parallel { self.scale } else { self.scale / p.dot(self.forward) };
        self.size * 0.5 + DVec2::new(p.dot(self.right), -p.dot(self.up)) * per_metre
    }

    /// The part of an edge beyond half the near plane's distance [texels]; `None` if it has none.
    fn edge(&self, from: DVec3, to: DVec3) -> Option<[DVec2; 2]> {
        let ends = [from, to].map(|end| self.along_axis(end));
        let least = if self.parallel { f64::NEG_INFINITY } else { self.near * 0.5 };
        if ends[0].max(ends[1]) <= least {
            return None;
        }
        let cut = from + (to - from) * ((least - ends[0]) / (ends[1] - ends[0]));
        let shown =
            [(from, ends[0]), (to, ends[1])].map(|(end, at)| if at < least { cut } else { end });
        Some(shown.map(|end| self.project(end)))
    }
}

/// Cosine to a perspective view's axis up to which a Gaussian is beside it and is not enlarged.
const BESIDE: f64 = 0.05;

/// A Gaussian for the view's rays: no smaller than a texel.
fn seen_by(eye: &Eye, gaussian: &Gaussian) -> gaussian_truth::Seen {
    let to_eye = DMat3::from_cols(eye.right, -eye.up, eye.forward).transpose();
    let center = to_eye * (f64s(gaussian.center) - eye.position);
    if !eye.parallel && center.z <= BESIDE * center.length() {
        return gaussian_truth::Seen::whole(gaussian);
    }
    // Linear about the centre: x and y over the distance along the axis.
    let (per_metre, slope) = if eye.parallel {
        (eye.scale, DVec2::ZERO)
    } else {
        (eye.scale / center.z, center.truncate() / center.z)
    };
    let project = DMat3::from_cols(
        DVec3::X * per_metre,
        DVec3::Y * per_metre,
        (-slope * per_metre).extend(1.0),
    );
    let middle = eye.project(f64s(gaussian.center));
    let line = |place| {
        let ray = eye.ray(middle + place);
        [ray.start, ray.way]
    };
    let least = std::f64::consts::FRAC_1_SQRT_2;
    gaussian_truth::Seen::widened(gaussian, project * to_eye, least, line)
}

/// Distance from the camera within which its near plane decides [m].
const NEAREST_SEEN: f64 = 1e-2;
/// Distance between two surfaces below which rounding decides which is visible [m].
const SURFACE_MARGIN: f64 = 1e-3;

/// Material of the visible solid particle or triangle at each pixel; `None` without one; an error if rounding
/// decides.
pub(crate) fn seen(scene: &Scene) -> Vec<Result<Option<u32>, ()>> {
    let eye = Eye::of_camera(&scene.camera);
    let pixel = |i: u32| {
        let width = scene.camera.size.x;
        let ray = eye.ray(DVec2::new(f64::from(i % width), f64::from(i / width)) + 0.5);
        let material_of = |material: u32| &scene.materials[material as usize];
        let particles = scene.particles.iter().map(|it| {
            (it.material, meet_particle(scene, &eye, &ray, it, material_of(it.material), 1.0))
        });
        let triangles = scene.triangles.iter().map(|it| {
            (it.material, meet_triangle(scene, &eye, &ray, it, material_of(it.material)))
        });
        let mut hits = Vec::new();
        for (material, met) in particles.chain(triangles) {
            match met {
                Met::Hit(hit) => hits.push((eye.ways(hit.depth), material)),
                Met::Edge => return Err(()),
                Met::Nothing => {}
            }
        }
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_close = |pair: &[(f64, u32)]| pair[1].0 - pair[0].0 < SURFACE_MARGIN;
        if hits.first().is_some_and(|hit| hit.0 < NEAREST_SEEN)
            || hits.windows(2).take(1).any(is_close)
        {
            return Err(());
        }
        Ok(hits.first().map(|hit| hit.1))
    };
    (0..scene.camera.size.element_product()).map(pixel).collect()
}

/// Expected maps of `view`.
pub(crate) fn render(scene: &Scene, view: &View) -> Vec<ExpectedTexel> {
    render_before(scene, view, 1.0)
}

/// Expected maps of `view`, with the light left at a light depth.
pub(crate) fn render_before(scene: &Scene, view: &View, end: f64) -> Vec<ExpectedTexel> {
    let mut eye = Eye::new(scene, view);
    eye.gaussians = scene.gaussians.iter().map(|gaussian| seen_by(&eye, gaussian)).collect();
    let count = view.size.x * view.size.y;
    let texel = |i: u32| {
        let at = DVec2::new(f64::from(i % view.size.x), f64::from(i / view.size.x));
        render_texel(scene, &eye, &eye.ray(at + 0.5), end)
    };
    (0..count).map(texel).collect()
}

fn render_texel(scene: &Scene, eye: &Eye, ray: &Ray, end: f64) -> ExpectedTexel {
    let mut texel =
        ExpectedTexel { filter: [1.0; 3], nearest: [1.0; 2], opaque: 1.0, undecided: false };
    let material_of = |material: u32| &scene.materials[material as usize];
    let meet_all = |opaque: bool, end: f64, visit: &mut dyn FnMut(Met)| {
        for particle in &scene.particles {
            let material = material_of(particle.material);
            if material.transfer.is_opaque() == opaque {
                visit(meet_particle(scene, eye, ray, particle, material, end));
            }
        }
        for (gaussian, seen) in scene.gaussians.iter().zip(&eye.gaussians) {
            let material = material_of(gaussian.material);
            if material.transfer.is_opaque() == opaque {
                visit(meet_gaussian(eye, ray, gaussian, seen, material, end));
            }
        }
        for triangle in &scene.triangles {
            let material = material_of(triangle.material);
            if material.transfer.is_opaque() == opaque {
                visit(meet_triangle(scene, eye, ray, triangle, material));
            }
        }
        for strand in &scene.strands {
            let material = material_of(strand.material);
            if material.transfer.is_opaque() == opaque {
                meet_strand(eye, ray, strand, material, end, visit);
            }
        }
        for grid in scene.grids.iter().filter(|_| !opaque) {
            for brick in &grid.bricks {
                visit(meet_brick(eye, ray, grid, brick, end));
            }
        }
    };
    let inside = |depth: f64| (0.0..=1.0).contains(&depth);
    let mut undecided = false;
    meet_all(true, 1.0, &mut |met| match met {
        Met::Hit(hit) if inside(hit.depth) => texel.opaque = texel.opaque.min(hit.depth),
        Met::Edge => undecided = true,
        Met::Hit(_) | Met::Nothing => {}
    });
    let mut hits = Vec::new();
    let end = texel.opaque.min(end);
    meet_all(false, end, &mut |met| match met {
        Met::Hit(hit) if inside(hit.depth) => {
            undecided |= end < 1.0 && (hit.depth - end).abs() < DEPTH_MARGIN;
            if hit.depth < end {
                hits.push(hit);
                for (nearest, margin) in texel.nearest.iter_mut().zip([-1.0, 1.0]) {
                    if hit.presence >= 1.0 / 255.0 + margin * OPACITY_MARGIN {
                        *nearest = nearest.min(hit.depth + margin * hit.reach);
                    }
                }
            }
        }
        Met::Edge => undecided = true,
        Met::Hit(_) | Met::Nothing => {}
    });
    hits.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let adds = |hit: &Hit| hit.added != DVec3::ZERO;
    undecided |= hits
        .windows(2)
        .any(|pair| (pair[1].depth - pair[0].depth).abs() < ORDER_MARGIN && pair.iter().any(adds));
    let filter = hits.iter().fold(DVec3::ONE, |light, hit| light * hit.light + hit.added);
    texel.filter = filter.to_array();
    texel.undecided = undecided;
    texel
}
