//! Generated volumes: clouds, plumes and explosions of noise, equal on all machines up to rounding.
use super::{
    SceneError, chest::hounsfield, generate::Chance, keys::Keys, lattice_noise::LatticeNoise,
    look::Look,
};
use glam::{DAffine3, DMat3, DVec3, IVec3, UVec3, Vec2, Vec3};
use gobo::{
    model::{BRICK_SIZE, Brick, Density, Voxels},
    records::pcg,
};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Kinds of generated volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum KindOfCloud {
    /// Round heaps on a flat base that boil slowly.
    Cloud,
    /// A column that rises, bends and widens.
    Plume,
    /// A ball that grows, rises and thins.
    Explosion,
    /// A chest in Hounsfield units, as a CT scanner records it; it does not move.
    Chest,
}

/// A generated volume: densities from 0 to 1, or a scanner's values, in a box that stands on the origin of
/// its own space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cloud {
    pub kind: KindOfCloud,
    pub seed: u32,
    /// Extent of the box \[m\].
    pub size: Vec3,
    /// Voxels along the longest edge of the box.
    pub voxels: u32,
    /// Speed of time; 0 for a still volume.
    pub speed: f32,
}

/// Fewest slices of voxels that share a cache of gradients.
const SLICES: usize = 8;
/// Octaves of noise.
const OCTAVES: usize = 5;

impl Cloud {
    const MOST_VOXELS: u32 = 320;

    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        let kind = keys.required("kind")?;
        let usual = match kind {
            KindOfCloud::Cloud => Vec3::new(4.0, 1.6, 3.0),
            KindOfCloud::Plume => Vec3::new(2.0, 4.0, 2.0),
            KindOfCloud::Explosion => Vec3::splat(3.0),
            KindOfCloud::Chest => Vec3::new(0.36, 0.4, 0.26),
        };
        let most = Self::MOST_VOXELS;
        let help = format!("8 to {most} voxels along the longest edge");
        let size = keys.three("size", 1e-3..=1e6, "0.001 to 1e6 m")?.unwrap_or(usual);
        if size.max_element() > 1e3 * size.min_element() {
            let help = "its longest edge is at most 1000 times its shortest";
            return Err(keys.fault("size", "size of a slab or a thread", help));
        }
        Ok(Self {
            kind,
            seed: keys.value("seed", 0)?,
            size,
            voxels: keys.whole("voxels", 80, 8..=most, &help)?,
            speed: keys.number("speed", -100.0..=100.0, "-100 to 100")?.unwrap_or(1.0),
        })
    }

    /// Whether the volume is animated.
    pub(super) fn moves(&self) -> bool {
        self.speed != 0.0 && self.kind != KindOfCloud::Chest
    }

    /// Edge of a voxel \[m\], and voxels along each edge of the box.
    fn lattice(&self) -> (f32, UVec3) {
        let edge = self.size.max_element() / self.voxels as f32;
        (edge, (self.size / edge).ceil().as_uvec3().clamp(UVec3::ONE, UVec3::splat(self.voxels)))
    }

    /// Upper bound of its bricks.
    pub(super) fn most_bricks(&self) -> u64 {
        let (_, count) = self.lattice();
        // Bricks also begin below the first voxel.
        (count / BRICK_SIZE + 2).as_u64vec3().element_product()
    }

    /// Its box as a brick without voxels.
    pub(super) fn outline(&self) -> Brick {
        let (_, size) = self.lattice();
        Brick::new(IVec3::ZERO, Density::Constant { size, density: 0.0 })
    }

    /// The middle of the box's floor \[voxels\].
    fn middle(&self) -> Vec3 {
        let (_, count) = self.lattice();
        (count.as_vec3() - 1.0) * Vec3::new(0.5, 0.0, 0.5) - Vec3::new(0.0, 0.5, 0.0)
    }

    /// The box's space from index space.
    pub(super) fn box_from_index(&self) -> DAffine3 {
        let edge = f64::from(self.lattice().0);
        let matrix3 = DMat3::from_diagonal(DVec3::splat(edge));
        DAffine3 { matrix3, translation: -self.middle().as_dvec3() * edge }
    }

    /// Its bricks at a time \[s\]. `kelvin`: the highest temperature of glowing volumes.
    pub(super) fn bricks(&self, seconds: f64, kelvin: Option<f32>, look: &Look) -> Vec<Brick> {
        let _phase = tracing::debug_span!("generate").entered();
        let (edge, count) = self.lattice();
        let field = Field::new(self, seconds * f64::from(self.speed));
        let unit = 2.0 / self.size.max_element();
        let middle = self.middle();
        let point = |voxel: IVec3| (voxel.as_vec3() - middle) * edge;
        let half = self.size * Vec3::new(0.5, 1.0, 0.5);
        let [width, height, depth] = count.to_array();
        let slice = |noise: &mut CloudNoise, z: u32| -> Vec<f32> {
            let voxels = (0..width * height).map(|i| UVec3::new(i % width, i / width, z));
            let density = |voxel: UVec3| {
                let at = point(voxel.as_ivec3());
                // Density falls to 0 before the box's border, so that nothing is cut off.
                let rim = ((half - at.abs()).min_element() * unit).min(at.y * unit);
                let rim = if self.kind == KindOfCloud::Chest { 1.0 } else { smooth(rim / 0.08) };
                field.density(noise, at / half, at * unit) * rim
            };
            voxels.map(density).collect()
        };
        let slices: Vec<Vec<f32>> = (0..depth)
            .into_par_iter()
            .with_min_len(SLICES)
            .map_init(|| field.noise(), slice)
            .collect();
        let density = |voxel: IVec3| {
            let [x, y, z] = voxel.as_uvec3().to_array();
            if !look.has(|| point(voxel).as_dvec3()) {
                return 0.0;
            }
            look.density(slices[z as usize][(y * width + x) as usize]).max(0.0)
        };
        let mut bricks = Brick::of_voxels(IVec3::ZERO, count.as_ivec3() - 1, density);
        if let Some(kelvin) = kelvin {
            let heat = |noise: &mut CloudNoise, brick: &mut Brick| {
                let origin = brick.origin;
                brick.temperature = Some(Voxels::new(|voxel| {
                    let at = point(origin + voxel.as_ivec3());
                    kelvin * field.heat(noise, at / half, at * unit)
                }));
            };
            bricks.par_iter_mut().with_min_len(64).for_each_init(|| field.noise(), heat);
        }
        bricks
    }
}

/// Smoothstep of `t`, clamped to 0 and 1.
fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The density of a cloud at one time.
struct Field {
    kind: KindOfCloud,
    seed: u32,
    time: f32,
    /// Centres and radii of heaps, in halves of the box.
    heaps: Vec<(Vec3, f32)>,
}

impl Field {
    fn new(cloud: &Cloud, time: f64) -> Self {
        let mut chance = Chance::new(cloud.seed.into());
        let mut heap = |i: u8| {
            let radius = chance.within(0.26, 0.48);
            let away = Vec2::from_angle(chance.within(0.0, TAU)) * chance.unit().sqrt();
            // The first heap is in the middle and the highest.
            let away = if i == 0 { Vec2::ZERO } else { away * (0.86 - radius) };
            let height = 0.74 - radius - away.length() * chance.within(0.5, 0.9);
            (Vec3::new(away.x, height.max(0.18), away.y), radius)
        };
        let heaps = (0..11).map(&mut heap).collect();
        // Speeds up to 100 leave an hour before `f32` loses the fractions.
        let time = time.clamp(-3.6e5, 3.6e5) as f32;
        Self { kind: cloud.kind, seed: pcg(cloud.seed), time, heaps }
    }

    /// Its noise, for one thread.
    fn noise(&self) -> CloudNoise {
        let age = match self.kind {
            KindOfCloud::Cloud => 0.1 * self.time,
            KindOfCloud::Plume => 0.3 * self.time,
            KindOfCloud::Explosion => 0.5 * self.age(),
            KindOfCloud::Chest => 0.0,
        };
        CloudNoise {
            octaves: std::array::from_fn(|i| {
                let scale = (1 << i) as f32;
                LatticeNoise::new(age * scale.sqrt(), pcg(self.seed ^ ((i as u32) << 24)))
            }),
            wind: [1, 2].map(|axis| LatticeNoise::new(0.0, self.seed ^ axis)),
        }
    }

    /// Time since an explosion \[s\].
    fn age(&self) -> f32 {
        (self.time + 0.12).max(0.0)
    }

    /// Density at a place, given in halves of the box (`part`) and in halves of its longest edge (`place`).
    fn density(&self, noise: &mut CloudNoise, part: Vec3, point: Vec3) -> f32 {
        /// No sum of octaves exceeds this.
        const MOST: f32 = 1.2;
        let time = self.time;
        match self.kind {
            KindOfCloud::Cloud => {
                let near = |&(center, radius): &(Vec3, f32)| {
                    1.0 - ((part - center) / Vec3::new(radius, radius * 0.9, radius)).length()
                };
                let shape = self.heaps.iter().map(near).fold(f32::NEG_INFINITY, f32::max);
                if shape + 0.55 * MOST <= 0.0 {
                    return 0.0;
                }
                let drift = Vec3::new(0.04, 0.02, 0.0) * time;
                let heaped = shape + 0.55 * noise.billows(point * 3.0 - drift);
                smooth(heaped / 0.3) * smooth(part.y / 0.14)
            }
            KindOfCloud::Plume => {
                let up = point.y * 2.5 - 0.7 * time;
                let high = part.y;
                let at = Vec3::new(0.0, up * 0.45, 0.3);
                let wind = noise.wind.each_mut().map(|wind| wind.at(at));
                let bend = Vec2::from_array(wind) * 0.9 * high;
                let width = 0.09 + 0.42 * high.max(0.0).powf(0.8);
                let away = (Vec2::new(part.x, part.z) - bend).length() / width;
                if 1.0 - away + MOST <= 0.0 {
                    return 0.0;
                }
                let at = Vec3::new(point.x * 2.5, up, point.z * 2.5) * 1.6;
                // The foot is too narrow for clefts.
                let depth = smooth(0.3 + 1.4 * high);
                let body = 1.0 - away + depth * noise.billows(at);
                let thin = 0.18 / (0.18 + high) * smooth((1.0 - high) / 0.25);
                smooth(body / 0.6) * thin * smooth(high / 0.02)
            }
            KindOfCloud::Chest => hounsfield(part, noise.billows(point * 4.0)),
            KindOfCloud::Explosion => {
                let age = self.age();
                let (from, at) = self.blown(part, age);
                let away = from.length();
                if 0.8 - away + 0.6 * MOST <= 0.0 {
                    return 0.0;
                }
                let body = 0.8 - away + 0.6 * noise.billows(at);
                // The shell is denser than the middle.
                let hollow = 0.35 + 0.65 * smooth(away);
                smooth(body / 0.35) * hollow / (1.0 + 1.5 * age)
            }
        }
    }

    /// Temperature of an explosion as a share of the highest, at a place as in [`Self::density`]: hottest in
    /// the middle and in clefts; it falls as the explosion grows.
    fn heat(&self, noise: &mut CloudNoise, part: Vec3, point: Vec3) -> f32 {
        let age = self.age();
        let (from, at) = self.blown(part, age);
        let clefts = noise.billows(at * 1.3 + point * 0.2);
        (1.0 - 0.35 * from.length() - 0.5 * clefts.max(0.0)).clamp(0.0, 1.0) / (1.0 + 0.8 * age)
    }

    /// Place in an explosion: in its radii, and as an argument of its noise.
    fn blown(&self, part: Vec3, age: f32) -> (Vec3, Vec3) {
        let grown = 0.82 * (1.0 - (-2.2 * age).exp());
        let center = Vec3::new(0.0, 0.3 + 0.25 * (1.0 - (-0.7 * age).exp()), 0.0);
        let from = (part * Vec3::new(1.0, 2.0, 1.0) - center * 2.0) / grown.max(1e-3);
        (from, from * 2.2 - Vec3::Y * 0.5 * age)
    }
}

/// The noise of a [`Field`], with cached gradients that make neighbours cheap.
struct CloudNoise {
    octaves: [LatticeNoise; OCTAVES],
    /// Noise that bends a plume along x and z.
    wind: [LatticeNoise; 2],
}

impl CloudNoise {
    /// Sum of octaves with round lumps and narrow clefts, mostly from -0.5 to 1.
    fn billows(&mut self, at: Vec3) -> f32 {
        let mut sum = 0.0;
        for (i, noise) in self.octaves.iter_mut().enumerate() {
            let scale = (1 << i) as f32;
            sum += (noise.at(at * scale).abs() * 2.4 - 0.45) / scale;
        }
        sum
    }
}
