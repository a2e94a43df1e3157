//! Generated fur: strands that grow from the triangles of a shape or mesh, equal on all machines up to
//! rounding.
use super::{
    SceneError,
    generate::Chance,
    keys::{ABOVE_ZERO, Keys},
};
use glam::{Quat, Vec3, Vec4};
use gobo::model::{Strand, StrandVertex, Triangle};
use rayon::prelude::*;
use std::f32::consts::TAU;

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
enum KindOfStrands {
    Fur,
}

/// Fur of a shape or mesh.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fur {
    /// Name of the shape or mesh.
    pub on: String,
    pub count: u32,
    /// Capsules of a strand.
    pub segments: u32,
    pub seed: u32,
    /// Mean length \[m\]; strands differ by a quarter of it.
    pub length: f32,
    /// Radius at the root; 0 at the tip \[m\].
    pub radius: f32,
    /// Turns of a strand around its axis.
    pub curl: f32,
    /// Radius of these turns at the tip \[m\].
    pub curl_radius: f32,
    /// Strength with which tips are drawn to the nearest guide.
    pub clump: f32,
    /// Direction of combing, added to the unit normal at the root.
    pub comb: Vec3,
    /// Sinking of the tip, in lengths.
    pub droop: f32,
    /// Colour at the root, linear rgba.
    pub root: Vec4,
    pub tip: Vec4,
}

/// Strands per guide of a clump.
const CLUMP: usize = 40;

impl Fur {
    const MOST: u32 = 1_000_000;
    const MOST_SEGMENTS: u32 = 64;

    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, SceneError> {
        let _kind: KindOfStrands = keys.required("kind")?;
        let (most, most_segments) = (Self::MOST, Self::MOST_SEGMENTS);
        let metres = |key, usual| {
            let value = keys.number(key, ABOVE_ZERO..=1e6, "above 0, up to 1e6 m")?;
            Ok::<f32, SceneError>(value.unwrap_or(usual))
        };
        let color = |key| {
            let values = keys.array::<f32, 4>(key)?;
            keys.check(key, values.as_ref().map_or(&[], |v| v), 0.0..=1.0, "from 0 to 1")?;
            Ok::<Vec4, SceneError>(values.map_or(Vec4::ONE, Vec4::from))
        };
        let length = metres("length", 0.1)?;
        Ok(Self {
            on: keys.required("on")?,
            count: keys.whole("count", 10_000, 1..=most, &format!("1 to {most} strands"))?,
            segments: keys.whole("segments", 6, 1..=most_segments, "1 to 64 capsules a strand")?,
            seed: keys.value("seed", 0)?,
            length,
            radius: metres("radius", length * 0.005)?,
            curl: keys.within("curl", 0.0, -100.0..=100.0)?,
            curl_radius: metres("curl_radius", length * 0.06)?,
            clump: keys.share("clump", 0.0)?,
            comb: keys.three("comb", -100.0..=100.0, "-100 to 100")?.unwrap_or(Vec3::ZERO),
            droop: keys.within("droop", 0.0, -2.0..=2.0)?,
            root: color("root")?,
            tip: color("tip")?,
        })
    }

    /// Number of its capsules.
    pub(super) fn capsules(&self) -> u64 {
        u64::from(self.count) * u64::from(self.segments)
    }

    /// Its strands on `triangles`, with ids from `first_id`.
    pub(super) fn strands(
        &self,
        triangles: &[Triangle],
        material: u32,
        first_id: u32,
    ) -> Vec<Strand> {
        let mut areas = Vec::with_capacity(triangles.len());
        let mut sum = 0.0;
        for triangle in triangles {
            let [a, b, c] = triangle.positions;
            sum += f64::from((b - a).cross(c - a).length());
            areas.push(sum);
        }
        let mut chance = Chance::new(self.seed.into());
        let hairs: Vec<_> =
            (0..self.count).map(|_| Hair::new(self, triangles, &areas, &mut chance)).collect();
        let guides = &hairs[..(hairs.len() / CLUMP).max(1)];
        let steps = self.segments as f32;
        let strand = |(i, hair): (u32, &Hair)| {
            let apart = |guide: &&Hair| guide.root.distance_squared(hair.root);
            let guide = guides.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let vertex = |step: u32| {
                let t = step as f32 / steps;
                let mut position = hair.at(self, t);
                if let Some(guide) = guide.filter(|_| self.clump > 0.0) {
                    position = position.lerp(guide.at(self, t), self.clump * t * t);
                }
                let mut color = self.root.lerp(self.tip, t);
                color = (color.truncate() * hair.shade).min(Vec3::ONE).extend(color.w);
                StrandVertex { position, radius: self.radius * (1.0 - t), color }
            };
            let vertices = (0..=self.segments).map(vertex).collect();
            Strand { vertices, material, id: first_id.wrapping_add(i) }
        };
        (0..self.count).into_par_iter().zip(&hairs).map(strand).collect()
    }
}

/// One hair before it is drawn to a guide.
struct Hair {
    root: Vec3,
    /// Direction, a unit vector.
    way: Vec3,
    length: f32,
    /// Start of its curl \[radians\].
    turn: f32,
    /// Factor of its colour.
    shade: f32,
}

impl Hair {
    /// `areas`: prefix sums of the triangles' areas.
    fn new(fur: &Fur, triangles: &[Triangle], areas: &[f64], chance: &mut Chance) -> Self {
        let [area_share, u, v] = [(); 3].map(|()| chance.unit());
        let [length, turn, shade] = [(); 3].map(|()| chance.unit());
        let aside = Vec3::from_array([(); 3].map(|()| chance.within(-0.15, 0.15)));
        let whole = areas.last().copied().unwrap_or(0.0);
        let at = areas.partition_point(|&area| area <= f64::from(area_share) * whole);
        let triangle = &triangles[at.min(triangles.len() - 1)];
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let weighted = |p: [Vec3; 3]| p[0] * (1.0 - u - v) + p[1] * u + p[2] * v;
        let normal = weighted(triangle.normals).normalize_or(Vec3::Y);
        Self {
            root: weighted(triangle.positions),
            way: (normal + fur.comb + aside).normalize_or(normal),
            length: fur.length * (0.75 + 0.5 * length),
            turn: turn * TAU,
            shade: 0.8 + 0.4 * shade,
        }
    }

    /// Its point at a share of its length.
    fn at(&self, fur: &Fur, t: f32) -> Vec3 {
        let aside = self.way.any_orthonormal_vector();
        let turned = Quat::from_axis_angle(self.way, self.turn + fur.curl * TAU * t) * aside;
        let start = Quat::from_axis_angle(self.way, self.turn) * aside;
        // It leaves the root in its direction.
        let curl = (turned - start) * (fur.curl_radius * t);
        self.root + self.way * (self.length * t) + curl
            - Vec3::Y * (fur.droop * self.length * t * t)
    }
}
