//! Gradient noise on an infinite lattice (Perlin 2002), whose gradients rotate with time (Perlin and Neyret
//! 2001).
use glam::{UVec3, Vec3};
use gobo::records::pcg;

/// One noise at one time. Places near the last ones are cheap: their gradients are cached.
pub(super) struct LatticeNoise {
    /// Turns of the gradients.
    turns: f32,
    seed: u32,
    /// Cache of lattice points and gradients; the last bits of the coordinates choose the slot.
    kept: Vec<(UVec3, Vec3)>,
}

/// Bits of each coordinate that choose a slot: rows and slices of a volume are walked along x, then y.
const BITS: [u32; 3] = [7, 6, 2];

impl LatticeNoise {
    pub(super) fn new(age: f32, seed: u32) -> Self {
        let mut noise = Self { turns: age.fract(), seed, kept: Vec::new() };
        let origin = (UVec3::ZERO, noise.gradient(UVec3::ZERO));
        noise.kept = vec![origin; 1 << BITS.iter().sum::<u32>()];
        noise
    }

    /// Noise at a place, mostly from -0.7 to 0.7.
    pub(super) fn at(&mut self, place: Vec3) -> f32 {
        let low = place.floor();
        let part = place - low;
        let fade = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
        let cell = low.as_ivec3().as_uvec3();
        let mut corner = |x: u32, y: u32, z: u32| {
            let gradient = self.kept_gradient(cell.wrapping_add(UVec3::new(x, y, z)));
            gradient.dot(part - Vec3::new(x as f32, y as f32, z as f32))
        };
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let mut row = |y: u32, z: u32| mix(corner(0, y, z), corner(1, y, z), fade.x);
        let mut slice = |z: u32| mix(row(0, z), row(1, z), fade.y);
        mix(slice(0), slice(1), fade.z)
    }

    #[inline]
    fn kept_gradient(&mut self, point: UVec3) -> Vec3 {
        let [x, y, z] = BITS;
        let low = |value: u32, bits: u32| value & ((1 << bits) - 1);
        let slot = low(point.x, x) | low(point.y, y) << x | low(point.z, z) << (x + y);
        let (kept, gradient) = self.kept[slot as usize];
        if kept == point {
            return gradient;
        }
        let gradient = self.gradient(point);
        self.kept[slot as usize] = (point, gradient);
        gradient
    }

    fn gradient(&self, point: UVec3) -> Vec3 {
        let hash = pcg(point.x ^ pcg(point.y ^ pcg(point.z ^ self.seed)));
        // Two perpendicular axes: the gradient rotates in their plane, in either direction.
        let unit = |bits: u32| (bits & 0xffff) as f32 / 32767.5 - 1.0;
        let (bits, more) = (pcg(hash), pcg(hash ^ 0x9e37_79b9));
        let first = Vec3::new(unit(bits), unit(bits >> 16), unit(more)).normalize_or(Vec3::X);
        let second = first.any_orthonormal_vector();
        let turns = unit(more >> 16) + if hash & 1 == 0 { self.turns } else { -self.turns };
        let (sin, cos) = (turns * std::f32::consts::TAU).sin_cos();
        first * cos + second * sin
    }
}
