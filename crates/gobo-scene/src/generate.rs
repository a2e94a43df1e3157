//! Seeded particles, identical on all machines.
use super::{Bounds, numbers::array, share::Share};
use glam::{Vec3, Vec4};
use gobo::model::Particle;
use std::ops::Range;

/// Particles generated instead of read from a file.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum Generate {
    /// A smoke column that rises from `base` and widens.
    Smoke {
        count: u32,
        #[serde(default)]
        seed: u64,
        /// Base of the column, world space \[m\].
        #[serde(default, deserialize_with = "array")]
        base: [f32; 3],
        /// Height of the column \[m\].
        #[serde(default = "two")]
        height: f32,
        /// Radius of the column at its top \[m\].
        #[serde(default = "half")]
        spread: f32,
        /// Radius of a particle at half the height \[m\].
        #[serde(default = "small")]
        radius: f32,
    },
    /// Dust, uniform in a box.
    Dust {
        count: u32,
        #[serde(default)]
        seed: u64,
        /// Corners, world space \[m\].
        #[serde(deserialize_with = "array")]
        min: [f32; 3],
        #[serde(deserialize_with = "array")]
        max: [f32; 3],
        #[serde(default = "small")]
        radius: f32,
    },
    /// A cloud of round heaps, densest in the middle.
    Cloud {
        count: u32,
        #[serde(default)]
        seed: u64,
        /// Centre of the cloud, world space \[m\].
        #[serde(default, deserialize_with = "array")]
        center: [f32; 3],
        /// Extent of the whole cloud along x, y and z \[m\].
        #[serde(default = "ones", deserialize_with = "array")]
        extent: [f32; 3],
        #[serde(default = "small")]
        radius: f32,
    },
}

fn two() -> f32 {
    2.0
}
fn half() -> f32 {
    0.5
}
fn small() -> f32 {
    0.05
}
fn ones() -> [f32; 3] {
    [1.0; 3]
}

/// Seeded random numbers (Steele et al. 2014, `SplitMix64`).
#[derive(Clone, Debug)]
pub struct Chance(u64);

impl Chance {
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    /// Largest magnitude of [`Self::normal`].
    const MAX_NORMAL: f32 = 5.7;

    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Skips `count` numbers.
    pub fn skip(&mut self, count: u64) {
        self.0 = self.0.wrapping_add(Self::STEP.wrapping_mul(count));
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(Self::STEP);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A random number in 0..1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A random number below `end`, which is not 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// A normally distributed number of deviation 1 (Box and Muller 1958).
    pub fn normal(&mut self) -> f32 {
        let r = (-2.0 * self.unit().max(1e-7).ln()).sqrt();
        r * (std::f32::consts::TAU * self.unit()).cos()
    }

    pub fn normal3(&mut self) -> Vec3 {
        Vec3::new(self.normal(), self.normal(), self.normal())
    }
}

impl Generate {
    pub fn count(&self) -> u32 {
        match *self {
            Self::Smoke { count, .. } | Self::Dust { count, .. } | Self::Cloud { count, .. } => {
                count
            }
        }
    }

    /// Seed of its numbers.
    pub(super) fn seed(&self) -> u64 {
        match *self {
            Self::Smoke { seed, .. } | Self::Dust { seed, .. } | Self::Cloud { seed, .. } => seed,
        }
    }

    /// Parameters that must be finite, with their names, and whether each must also be above 0.
    pub(super) fn numbers(&self) -> Vec<(&'static str, f32, bool)> {
        let all = |name, values: [f32; 3]| values.map(|value| (name, value, false)).to_vec();
        match *self {
            Self::Smoke { base, height, spread, radius, .. } => [
                all("base", base),
                vec![("height", height, true), ("spread", spread, true), ("radius", radius, true)],
            ]
            .concat(),
            Self::Dust { min, max, radius, .. } => {
                [all("min", min), all("max", max), vec![("radius", radius, true)]].concat()
            }
            Self::Cloud { center, extent, radius, .. } => {
                [all("center", center), all("extent", extent), vec![("radius", radius, true)]]
                    .concat()
            }
        }
    }

    /// Upper bound of the particles in a share, or of all.
    pub(super) fn count_of(&self, share: Option<Share>) -> u64 {
        let all = u64::from(self.count());
        share.map_or(all, |share| share.count_of(all))
    }

    /// Bounds of any number of particles.
    pub(super) fn bounds(&self) -> Bounds {
        let around = |middle: Vec3, half: Vec3, radius: f32| {
            Bounds::new(middle - half - radius, middle + half + radius)
        };
        match *self {
            Self::Smoke { base, height, spread, radius, .. } => {
                let wide = spread * 0.4 * (1.2 * Chance::MAX_NORMAL + 1.0);
                let half = Vec3::new(wide, height * 0.5 + wide * 0.3, wide);
                around(Vec3::from(base) + Vec3::Y * height * 0.5, half, radius * 1.5 * 1.3)
            }
            Self::Dust { min, max, radius, .. } => {
                let (min, max) = (Vec3::from(min), Vec3::from(max));
                around((min + max) * 0.5, (max - min).abs() * 0.5, radius * 1.5)
            }
            Self::Cloud { center, extent, radius, .. } => {
                let half = Vec3::from(extent).abs() * (0.27 + 0.11 * Chance::MAX_NORMAL);
                around(Vec3::from(center), half, radius * 1.4)
            }
        }
    }

    /// Random numbers per particle.
    fn draws(&self) -> u64 {
        match self {
            Self::Smoke { .. } => 10,
            Self::Dust { .. } => 6,
            Self::Cloud { .. } => 11,
        }
    }

    /// Generates the particles with these numbers; number 0 has id `first_id`.
    pub fn particles(
        &self,
        numbers: Range<u64>,
        material: u32,
        first_id: u32,
    ) -> impl Iterator<Item = Particle> + use<> {
        let generate = *self;
        let mut chance = Chance::new(self.seed());
        chance.skip(numbers.start * self.draws());
        numbers.map(move |number| {
            let (center, radius, alpha) = generate.one(&mut chance);
            let shade = chance.within(0.85, 1.0);
            Particle {
                center,
                radius,
                color: Vec4::new(shade, shade, shade, alpha),
                rotation: chance.within(0.0, std::f32::consts::TAU),
                material,
                id: first_id.wrapping_add(number as u32),
            }
        })
    }

    /// Centre, radius and alpha of one particle.
    fn one(&self, chance: &mut Chance) -> (Vec3, f32, f32) {
        match *self {
            Self::Smoke { base, height, spread, radius, .. } => {
                let t = chance.unit();
                // Whirls: the column's axis bends, and its width grows as it rises.
                let swirl = Vec3::new((t * 7.0).sin(), 0.0, (t * 5.0 + 1.0).cos()) * spread * 0.4;
                let swell = 0.25 + 0.75 * t + 0.2 * (t * 19.0).sin() * t;
                let away = chance.normal3() * spread * 0.4 * swell;
                let up = Vec3::new(0.0, t * height + away.y * 0.3, 0.0);
                let center = Vec3::from(base) + up + swirl * t + away * Vec3::new(1.0, 0.0, 1.0);
                let size = radius * (0.5 + t) * chance.within(0.7, 1.3);
                (center, size, 1.0 - 0.7 * t)
            }
            Self::Dust { min, max, radius, .. } => {
                let (min, max) = (Vec3::from(min), Vec3::from(max));
                let at = Vec3::new(chance.unit(), chance.unit(), chance.unit());
                (min + (max - min) * at, radius * chance.within(0.5, 1.5), 1.0)
            }
            Self::Cloud { center, extent, radius, .. } => {
                // Seven heaps around the centre.
                let heap = (chance.bits() % 7) as f32;
                let middle =
                    Vec3::new((heap * 2.4).cos(), (heap * 1.7).sin() * 0.4, (heap * 2.4).sin());
                let at = middle * 0.27 + chance.normal3() * 0.11;
                let size = radius * chance.within(0.6, 1.4);
                (Vec3::from(center) + at * Vec3::from(extent), size, chance.within(0.6, 1.0))
            }
        }
    }
}

/// Discs uniform in a box, of random colour and rotation, with ids from 0; radii \[m\] are uniform too.
pub fn uniform_discs(
    count: u32,
    bounds: Bounds,
    radii: Range<f32>,
    alpha: f32,
    seed: u64,
) -> Vec<Particle> {
    let mut chance = Chance::new(seed);
    let mut vector = || Vec3::new(chance.unit(), chance.unit(), chance.unit());
    (0..count)
        .map(|id| {
            let (at, color, more) = (vector(), vector(), vector());
            Particle {
                center: bounds.min + (bounds.max - bounds.min) * at,
                radius: radii.start + (radii.end - radii.start) * more.x,
                color: color.extend(alpha),
                rotation: more.y * std::f32::consts::TAU,
                material: 0,
                id,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [&str; 3] = [
        "kind = 'smoke'\nheight = 3\nbase = [1, 2, 3]",
        "kind = 'dust'\nmin = [-1, 0, 2]\nmax = [1, 5, 3]",
        "kind = 'cloud'\ncenter = [0, 9, 0]\nextent = [2, 1, 4]",
    ];

    #[test]
    fn shares_have_the_particles_of_the_whole() {
        for kind in KINDS {
            let generate: Generate = toml::from_str(&format!("{kind}\ncount = 5000")).unwrap();
            let all: Vec<_> = generate.particles(0..5000, 3, 70).collect();
            let mut found = vec![None; all.len()];
            for share in (0..3).map(|index| Share::new(index, 3).unwrap()) {
                let mut count = 0;
                for range in share.ranges(5000) {
                    count += range.end - range.start;
                    for (number, particle) in range.clone().zip(generate.particles(range, 3, 70)) {
                        assert!(share.has(number));
                        assert!(found[number as usize].replace(particle).is_none());
                    }
                }
                assert_eq!(generate.count_of(Some(share)), count);
            }
            let found: Vec<_> = found.into_iter().map(|particle| particle.unwrap()).collect();
            assert_eq!(found, all, "{kind}");
        }
    }

    #[test]
    fn bounds_hold_all_particles() {
        for kind in KINDS {
            let generate: Generate = toml::from_str(&format!("{kind}\ncount = 100000")).unwrap();
            let (bounds, all) = (generate.bounds(), generate.particles(0..100_000, 0, 0));
            let tight = all.fold(Bounds::EMPTY, |b, p| b.with_sphere(p.center, p.radius));
            assert_eq!(bounds.with(&tight), bounds, "{kind}");
            assert!(bounds.radius() < 2.5 * tight.radius(), "{kind}");
        }
    }
}
