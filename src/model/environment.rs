//! Environment of a scene: it lights the scene, is mirrored, and is seen behind everything.
use super::image_sun::ImageSun;
use glam::{UVec2, Vec2, Vec3};
use half::f16;
use std::f32::consts::PI;

/// Radiance from all directions, as a sharp map and prefiltered for rough reflections.
///
/// Directions are octahedral (Cigolle et al. 2014). Level 0 is sharp; level k is the reflection at
/// roughness `k / (LEVELS - 1)`: the mean over the half vectors of GGX, seen head-on (Karis 2013), stored
/// as halves. Each level has a border of one texel, which continues the map across its edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Edge of level 0 without its border \[texels\].
    size: u32,
    /// Levels in order, row by row.
    texels: Vec<Vec3>,
    /// Irradiance as spherical harmonics, for [`irradiance_at`].
    irradiance: [Vec3; IRRADIANCE],
    /// Mean over all directions.
    mean: Vec3,
}

/// A gradient sky, radiance: linear rgb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Radiance straight up.
    pub zenith: Vec3,
    /// Radiance at the horizon.
    pub horizon: Vec3,
    /// Radiance below the horizon.
    pub ground: Vec3,
    /// Sun disc, seen and mirrored by smooth surfaces. It does not light the scene: add a light for that.
    pub sun: Option<SunDisc>,
}

/// A sun disc in the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunDisc {
    /// Direction in which its light travels, any length.
    pub direction: Vec3,
    /// Radiance: linear rgb.
    pub color: Vec3,
    /// Angular diameter \[radians\].
    pub angle: f32,
}

impl Default for Sky {
    /// A clear day's sky that fits a light of irradiance 3.
    fn default() -> Self {
        Self {
            zenith: Vec3::new(0.11, 0.17, 0.30),
            horizon: Vec3::new(0.62, 0.66, 0.70),
            ground: Vec3::new(0.40, 0.385, 0.36),
            sun: None,
        }
    }
}

impl Sky {
    /// Radiance from a unit direction, without the sun: a steep gradient above the horizon, constant below
    /// it.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        /// Height over which the ground blends into the horizon.
        const HAZE: f32 = 0.02;
        let up = direction.y.clamp(0.0, 1.0);
        let sky = self.zenith.lerp(self.horizon, (1.0 - up) * (1.0 - up));
        sky.lerp(self.ground, (-direction.y / HAZE).clamp(0.0, 1.0))
    }
}

impl SunDisc {
    /// Angular diameter of the sun \[radians\].
    pub const USUAL_ANGLE: f32 = 0.53 * PI / 180.0;
}

/// Number of coefficients of [`Environment::irradiance`]: spherical harmonics of order 2.
pub const IRRADIANCE: usize = 9;
/// Levels of a map: sharp, and at roughness 0.2 to 1.
pub const LEVELS: u32 = 6;
/// Edge of the rough levels without their border \[texels\].
pub const ROUGH_SIZE: u32 = 64;
/// Edge of a sky's sharp level \[texels\].
const SKY_SIZE: u32 = 256;
/// Largest edge of an image's sharp level \[texels\].
const MAX_SIZE: u32 = 1024;
/// Largest finite half.
const BRIGHTEST: f32 = 65504.0;

impl Environment {
    /// The environment of a sky, multiplied by `intensity`.
    pub fn of_sky(sky: &Sky, intensity: f32) -> Self {
        phase!("generate");
        let even = RadianceMap::new(SKY_SIZE, |direction| sky.radiance(direction) * intensity);
        let Some(sun) = sky.sun else { return Self::new(&even, &even) };
        let mut sharp = even.clone();
        sharp.add_disc(-sun.direction.normalize_or(Vec3::NEG_Y), sun.angle, sun.color * intensity);
        Self::new(&sharp, &even)
    }

    /// The environment of an equirectangular image: rows from +y to -y, its middle looks along -z; turned
    /// about +y by `turn` \[radians\]. Invalid radiance (negative, not a number) is black.
    pub fn of_image(size: UVec2, texels: &[[f32; 3]], turn: f32, intensity: f32) -> Self {
        let map = RadianceMap::of_image(size, texels, turn, intensity);
        Self::new(&map, &map)
    }

    /// Like [`Self::of_image`], but separates the image's sun, if it has one: the sky around the sun lights
    /// the scene and is mirrored by rough surfaces, and a light should replace the sun, which is still seen,
    /// and mirrored by smooth surfaces.
    pub fn of_image_without_sun(
        size: UVec2,
        texels: &[[f32; 3]],
        turn: f32,
        intensity: f32,
    ) -> (Self, Option<ImageSun>) {
        let sharp = RadianceMap::of_image(size, texels, turn, intensity);
        let mut even = sharp.clone();
        let sun = even.take_sun();
        (Self::new(&sharp, &even), sun)
    }

    /// `sharp` is seen and mirrored; `even` gives the irradiance.
    fn new(sharp: &RadianceMap, even: &RadianceMap) -> Self {
        let (irradiance, mean) = even.irradiance();
        let coarser = even.coarser();
        let mut texels = sharp.bordered();
        for level in 1..LEVELS {
            texels.extend(rough(&coarser, level as f32 / (LEVELS - 1) as f32).bordered());
        }
        Self { size: sharp.size, texels, irradiance, mean }
    }

    /// Edge of level 0 without its border \[texels\].
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Levels in order, each with its border, row by row: linear rgb, rounded to halves.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// Irradiance as spherical harmonics, for [`irradiance_at`].
    pub fn irradiance(&self) -> &[Vec3; IRRADIANCE] {
        &self.irradiance
    }

    /// Mean over all directions.
    pub fn mean(&self) -> Vec3 {
        self.mean
    }
}

/// Irradiance of a surface of normal `n`, divided by pi: spherical harmonics up to order 2 (Ramamoorthi and
/// Hanrahan 2001), as polynomials with their constants multiplied in.
pub fn irradiance_at(c: &[Vec3; IRRADIANCE], n: Vec3) -> Vec3 {
    let linear = c[0] + c[1] * n.y + c[2] * n.z + c[3] * n.x;
    let mixed = c[4] * (n.x * n.y) + c[5] * (n.y * n.z) + c[7] * (n.x * n.z);
    let squares = c[6] * (3.0 * n.z * n.z - 1.0) + c[8] * (n.x * n.x - n.y * n.y);
    (linear + mixed + squares).max(Vec3::ZERO)
}

/// Radiance by direction, octahedral.
#[derive(Clone, Debug)]
pub(super) struct RadianceMap {
    size: u32,
    pub(super) texels: Vec<Vec3>,
}

/// Unit vector of a point in -1..1 of the octahedral square.
fn direction_at(e: Vec2) -> Vec3 {
    let z = 1.0 - e.x.abs() - e.y.abs();
    let folded = (Vec2::ONE - Vec2::new(e.y, e.x).abs()) * sides(e);
    (if z < 0.0 { folded } else { e }).extend(z).normalize()
}

/// The inverse of `direction_at`.
pub fn octahedral(direction: Vec3) -> Vec2 {
    let n = direction / direction.abs().element_sum().max(1e-20);
    let flat = Vec2::new(n.x, n.y);
    if n.z < 0.0 { (Vec2::ONE - Vec2::new(n.y, n.x).abs()) * sides(flat) } else { flat }
}

fn sides(v: Vec2) -> Vec2 {
    Vec2::select(v.cmpge(Vec2::ZERO), Vec2::ONE, Vec2::NEG_ONE)
}

impl RadianceMap {
    /// A map of radiance, the mean of four samples per texel.
    fn new(size: u32, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let texel = |i: u32| {
            let corner = Vec2::new((i % size) as f32, (i / size) as f32);
            let point = |x: f32, y: f32| (corner + Vec2::new(x, y)) * (2.0 / size as f32) - 1.0;
            let four = [point(0.25, 0.25), point(0.75, 0.25), point(0.25, 0.75), point(0.75, 0.75)];
            four.map(|e| radiance(direction_at(e))).iter().sum::<Vec3>() * 0.25
        };
        Self { size, texels: (0..size * size).map(texel).collect() }
    }

    /// The map of an image, as [`Environment::of_image`].
    fn of_image(size: UVec2, texels: &[[f32; 3]], turn: f32, intensity: f32) -> Self {
        let texel = |x: i64, y: i64| {
            let x = x.rem_euclid(i64::from(size.x)) as usize;
            let y = y.clamp(0, i64::from(size.y) - 1) as usize;
            let rgb = texels.get(y * size.x as usize + x).copied().unwrap_or_default();
            Vec3::from_array(rgb.map(|v| if v > 0.0 { v.min(BRIGHTEST) } else { 0.0 }))
        };
        let at = |direction: Vec3| {
            let around = 0.5 + (direction.x.atan2(-direction.z) + turn) / (2.0 * PI);
            let down = direction.y.clamp(-1.0, 1.0).acos() / PI;
            let point = Vec2::new(around.rem_euclid(1.0), down) * size.as_vec2() - 0.5;
            let (low, part) = (point.floor(), point - point.floor());
            let (x, y) = (low.x as i64, low.y as i64);
            let top = texel(x, y).lerp(texel(x + 1, y), part.x);
            let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), part.x);
            top.lerp(bottom, part.y) * intensity
        };
        let edge = size.y.next_power_of_two().clamp(ROUGH_SIZE, MAX_SIZE);
        Self::new(edge, at)
    }

    pub(super) fn direction(&self, i: usize) -> Vec3 {
        let at = UVec2::new(i as u32 % self.size, i as u32 / self.size).as_vec2() + 0.5;
        direction_at(at * (2.0 / self.size as f32) - 1.0)
    }

    /// Solid angle of a texel: its area on the face of the octahedron, projected onto the sphere.
    pub(super) fn solid_angle(&self, i: usize) -> f32 {
        let edge = 2.0 / self.size as f32;
        let sum = self.direction(i).abs().element_sum();
        edge * edge * sum * sum * sum
    }

    /// Adds a disc; the sum over its texels has the disc's exact power.
    fn add_disc(&mut self, toward: Vec3, angle: f32, color: Vec3) {
        const SUN_SAMPLES: u32 = 8;
        let least = (0.5 * angle).cos();
        let covered = |i: usize| {
            let corner = Vec2::new((i as u32 % self.size) as f32, (i as u32 / self.size) as f32);
            // Bound of a texel's extent around its centre, in edges.
            let reach = 0.5 * angle + 8.0 / self.size as f32;
            if self.direction(i).dot(toward) < reach.min(PI).cos() {
                return 0.0;
            }
            let inside = (0..SUN_SAMPLES * SUN_SAMPLES).filter(|point| {
                let at = UVec2::new(point % SUN_SAMPLES, point / SUN_SAMPLES).as_vec2() + 0.5;
                let e = (corner + at / SUN_SAMPLES as f32) * (2.0 / self.size as f32) - 1.0;
                direction_at(e).dot(toward) >= least
            });
            inside.count() as f32 / (SUN_SAMPLES * SUN_SAMPLES) as f32
        };
        let shares: Vec<f32> = (0..self.texels.len()).map(covered).collect();
        let all: f32 = (0..shares.len()).map(|i| shares[i] * self.solid_angle(i)).sum();
        let whole = 2.0 * PI * (1.0 - least);
        for (texel, share) in self.texels.iter_mut().zip(shares) {
            *texel += color * (share * whole / all.max(f32::MIN_POSITIVE));
        }
    }

    fn irradiance(&self) -> ([Vec3; IRRADIANCE], Vec3) {
        let mut sums = [Vec3::ZERO; IRRADIANCE];
        let mut all = 0.0;
        for (i, &radiance) in self.texels.iter().enumerate() {
            let (n, angle) = (self.direction(i), self.solid_angle(i));
            let squares = [3.0 * n.z * n.z - 1.0, n.x * n.x - n.y * n.y];
            let [z2, x2_y2] = squares;
            let basis =
                [1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, z2, n.x * n.z, x2_y2].map(|b| b * angle);
            for (sum, basis) in sums.iter_mut().zip(basis) {
                *sum += radiance * basis;
            }
            all += angle;
        }
        // Squares of the basis functions' constants, times the cosine lobe's factor of each order: 1, 2/3,
        // 1/4.
        const FOUR_PI: f32 = 4.0 * PI;
        let factors = [1.0, 2.0, 2.0, 2.0, 3.75, 3.75, 0.3125, 3.75, 0.9375].map(|f| f / FOUR_PI);
        // Corrects the sum of solid angles to that of the sphere.
        let whole = FOUR_PI / all;
        let scaled = std::array::from_fn(|k| sums[k] * (factors[k] * whole));
        (scaled, sums[0] / all)
    }

    /// This map and its halvings, down to an edge of eight texels.
    fn coarser(&self) -> Vec<Self> {
        let mut maps = vec![self.clone()];
        while let Some(last) = maps.last().filter(|map| map.size > 8) {
            let size = last.size / 2;
            let texel = |i: u32| {
                let first = (i / size * 2 * last.size + i % size * 2) as usize;
                let below = first + last.size as usize;
                let four = [first, first + 1, below, below + 1];
                let weight = four.map(|i| last.solid_angle(i));
                let sum: Vec3 = (0..4).map(|k| last.texels[four[k]] * weight[k]).sum();
                sum / weight.iter().sum::<f32>()
            };
            let next = Self { size, texels: (0..size * size).map(texel).collect() };
            maps.push(next);
        }
        maps
    }

    fn nearest(&self, direction: Vec3) -> Vec3 {
        let at = (octahedral(direction) * 0.5 + 0.5) * self.size as f32;
        let at = at.as_uvec2().min(UVec2::splat(self.size - 1));
        self.texels[(at.y * self.size + at.x) as usize]
    }

    /// The map with a border of one texel that continues it across the edges, rounded to halves.
    fn bordered(&self) -> Vec<Vec3> {
        let size = i64::from(self.size);
        let row = |y: i64| {
            (-1..=size).map(move |x| {
                // Each edge of the square meets itself, mirrored at its middle.
                let (x, y) = if (0..size).contains(&x) { (x, y) } else { (x, size - 1 - y) };
                let (x, y) = if (0..size).contains(&y) { (x, y) } else { (size - 1 - x, y) };
                (x.clamp(0, size - 1), y.clamp(0, size - 1))
            })
        };
        let half = |v: f32| f16::from_f32(v.clamp(0.0, BRIGHTEST)).to_f32();
        let texel = |(x, y): (i64, i64)| self.texels[(y * size + x) as usize].map(half);
        (-1..=size).flat_map(row).map(texel).collect()
    }
}

/// Reflection at a roughness, seen head-on: half vectors of GGX (Walter et al. 2007), each sampling the map
/// whose texels match its solid angle (Colbert and Krivanek 2007).
fn rough(maps: &[RadianceMap], roughness: f32) -> RadianceMap {
    const SAMPLES: u32 = 128;
    let alpha = roughness * roughness;
    let square = alpha * alpha;
    let finest = &maps[0];
    // Sample rays about z: direction, weight and map.
    let rays: Vec<(Vec3, f32, usize)> = (0..SAMPLES)
        .filter_map(|i| {
            let u = (i as f32 + 0.5) / SAMPLES as f32;
            let turn = i.reverse_bits() as f32 / 4_294_967_296.0 * 2.0 * PI;
            let cosine = ((1.0 - u) / (1.0 + (square - 1.0) * u)).sqrt();
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            let middle = Vec3::new(sine * turn.cos(), sine * turn.sin(), cosine);
            let ray = middle * (2.0 * cosine) - Vec3::Z;
            let spread = cosine * cosine * (square - 1.0) + 1.0;
            let density = square / (PI * spread * spread) * 0.25;
            let angle = 1.0 / (SAMPLES as f32 * density.max(1e-6));
            let texel = 4.0 * PI / (finest.size * finest.size) as f32;
            let level = 0.5 * (angle / texel).max(1.0).log2();
            (ray.z > 0.0).then(|| (ray, ray.z, (level as usize).min(maps.len() - 1)))
        })
        .collect();
    let weights: f32 = rays.iter().map(|(_, weight, _)| weight).sum();
    let level = RadianceMap { size: ROUGH_SIZE, texels: Vec::new() };
    let texel = |i: usize| {
        let n = level.direction(i);
        let (x, y) = n.any_orthonormal_pair();
        let samples = rays.iter().map(|&(ray, weight, map)| {
            maps[map].nearest(x * ray.x + y * ray.y + n * ray.z) * weight
        });
        samples.sum::<Vec3>() / weights
    };
    RadianceMap {
        size: ROUGH_SIZE,
        texels: (0..(ROUGH_SIZE * ROUGH_SIZE) as usize).map(texel).collect(),
    }
}
