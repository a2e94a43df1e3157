//! CPU reference of `wgsl/hit/caster_hit.wgsl`: hits of a ray with any caster.
use super::{
    brick::{Passage, VOXEL_PARTS, dense_light, passage},
    brick_light::Lattice,
    capsule::{CapsuleSetup, capsule_half, capsule_hit},
    fresnel::face_passes,
    gaussian::{approach, gaussian_hit},
    hit::{Facing, absorption, coverage, transmittance},
    puff::{chord, puff_hit},
    texture::{Image, Sampled},
};
use crate::{
    dither::{PatternPoint, cell, threshold},
    hit::HitTriangle,
    project::SLACK,
    tile::Tile,
};
use glam::{Vec2, Vec3, Vec4};
use gobo::{
    model::{MAX_GAIN, Material, Pattern, Shape, Transfer},
    records::{
        BACK_BIT, BrickRecord, Bricks, CapsuleRecord, CasterRecord, Footprint, GaussianAxes,
        GaussianSetup, GpuView, ImageDetail, LATTICE_EDGE, MEDIUM_BIT, TRIANGLE_BIT, TriangleSetup,
    },
};

mod hit;

pub use hit::{Crossing, Hit, SurfaceCrossing, metres_per_depth};

/// Records that the hit tests of one view read.
#[derive(Clone, Copy, Debug)]
pub struct Records<'a> {
    /// The view.
    pub view: &'a GpuView,
    /// Particles, then Gaussians.
    pub casters: &'a [CasterRecord],
    /// Bricks of all grids.
    pub bricks: &'a Bricks,
    /// Capsules of all strands.
    pub capsules: &'a [CapsuleRecord],
    /// Axes of each Gaussian.
    pub axes: &'a [GaussianAxes],
    /// Gaussians set up for the view's texels.
    pub gaussians: &'a [GaussianSetup],
    /// Triangles set up for the view's texels.
    pub setups: &'a [TriangleSetup],
    /// Materials, by the casters' numbers.
    pub materials: &'a [Material],
    /// Absorption coefficient of each material [1/m].
    pub absorptions: &'a [Vec3],
    /// Images, by the materials' numbers.
    pub images: &'a [Image<'a>],
    /// Sampling of images in the picture; `None` for maps, which read single texels.
    pub detail: Option<ImageDetail>,
}

impl Records<'_> {
    /// An image where a ray of the picture hits a triangle.
    pub fn seen_image(
        &self,
        texture: u32,
        setup: &TriangleSetup,
        texel: Vec2,
        uv: Vec2,
        shows_clear: bool,
    ) -> Sampled {
        let image = &self.images[texture as usize];
        match self.detail {
            None => Sampled { rgba: image.sample(uv, shows_clear), level: 0.0 },
            Some(detail) => {
                let [right, down] = setup.uv_steps(texel, uv).map(|step| step * detail.reach);
                image.sample_area(uv, right, down, shows_clear)
            }
        }
    }
}

/// A caster set up for the texels of a view.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    records: Records<'a>,
    /// The caster's material.
    pub material: &'a Material,
    /// Seed of dither patterns.
    pub id: u32,
    form: Form<'a>,
    /// Centre in the map, and reach along each axis \[texels\].
    bounds: (Vec2, f32),
}

#[derive(Clone, Copy, Debug)]
enum Form<'a> {
    Facing { facing: Facing, color: Vec3, opacity: Opacity },
    Puff { facing: Facing, footprint: Footprint, color: Vec3, opacity: Opacity },
    Gaussian { footprint: Footprint, setup: &'a GaussianSetup, is_medium: bool },
    Brick { brick: &'a BrickRecord, color: Vec3 },
    Capsule { setup: CapsuleSetup, color: Vec4, middle: Vec2 },
    Triangle(&'a TriangleSetup),
}

/// Opacity of a particle, reduced if it was enlarged.
#[derive(Clone, Copy, Debug)]
struct Opacity {
    /// Ratio of the areas.
    thin: f32,
    /// Value where texture and profile are 0.
    base: f32,
    slope: f32,
}

impl Opacity {
    /// `alpha`: of texture and profile.
    fn at(&self, alpha: f32) -> f32 {
        // The slope is rounded: the sum may exceed 1.
        (self.base + self.slope * alpha).min(1.0)
    }
}

impl<'a> Target<'a> {
    /// Sets the caster of a footprint up.
    pub fn new(records: Records<'a>, footprint: &Footprint) -> Self {
        let bounds = |shape| (footprint.center, reach(records.view, footprint, shape));
        if footprint.caster & TRIANGLE_BIT != 0 {
            let setup = &records.setups[footprint.red_green as usize];
            let material = &records.materials[setup.material as usize];
            let (form, bounds) = (Form::Triangle(setup), bounds(None));
            return Self { records, material, id: setup.id, form, bounds };
        }
        let caster = &records.casters[footprint.caster as usize];
        let material = &records.materials[caster.material() as usize];
        if material.shape == Shape::Gaussian {
            let setup = &records.gaussians[footprint.red_green as usize];
            let is_medium = caster.material_rotation & MEDIUM_BIT != 0;
            let form = Form::Gaussian { footprint: *footprint, setup, is_medium };
            let id = records.axes[caster.id as usize].id;
            return Self { records, material, id, form, bounds: (Vec2::ZERO, f32::INFINITY) };
        }
        if material.shape == Shape::Capsule {
            let record = &records.capsules[caster.id as usize];
            let setup = CapsuleSetup::new(records.view, record);
            let color = caster.color(material.transfer as u32) * material.tint;
            let form = Form::Capsule { setup, color, middle: footprint.center };
            let reach = capsule_half(footprint).abs().max_element() + footprint.radius + SLACK;
            let reach = if footprint.radius < 0.0 { f32::INFINITY } else { reach };
            return Self {
                records,
                material,
                id: record.id,
                form,
                bounds: (footprint.center, reach),
            };
        }
        let facing = Facing::new(records.view, footprint, caster.rotation());
        let (color, thin, slope) =
            (footprint.color(material.transfer as u32), footprint.thin(), footprint.slope());
        let opacity = Opacity { thin, base: material.reflectivity * thin, slope };
        let form = match material.shape {
            Shape::Puff => Form::Puff { facing, footprint: *footprint, color, opacity },
            Shape::Brick => {
                Form::Brick { brick: &records.bricks.records[caster.id as usize], color }
            }
            Shape::Disc | Shape::Quad | Shape::Gaussian | Shape::Capsule => {
                Form::Facing { facing, color, opacity }
            }
        };
        Self { records, material, id: caster.id, form, bounds: bounds(Some(material.shape)) }
    }

    /// Texels of a tile that the caster may touch, as [`Tile::texels`].
    pub fn texels(&self, tile: &Tile) -> impl Iterator<Item = (usize, Vec2)> + use<> {
        let (center, reach) = self.bounds;
        tile.texels_near(center, reach)
    }

    /// Whether hits filter the light, rather than block it or have no effect.
    pub fn filters(&self) -> bool {
        !self.material.transfer.is_opaque() && self.material.transfer != Transfer::None
    }

    /// Hit of the ray through `texel` (view's map), which ends at light depth `opaque_depth`.
    pub fn hit(&self, texel: Vec2, opaque_depth: f32) -> Option<Hit> {
        self.ramp_hit(texel, opaque_depth, [0, 1])
    }

    /// Hits of a ray that a curve of `nodes` nodes takes one by one: a brick is several.
    pub fn ramp_count(&self, nodes: u32) -> u32 {
        match self.form {
            Form::Brick { brick, .. } if brick.density < 0.0 => VOXEL_PARTS,
            Form::Brick { .. } => nodes,
            _ => 1,
        }
    }

    /// Like [`Self::hit`], for one of [`Self::ramp_count`] parts: its index, and their number.
    pub fn ramp_hit(&self, texel: Vec2, opaque_depth: f32, part: [u32; 2]) -> Option<Hit> {
        let hit = match self.form {
            Form::Facing { facing, color, opacity } => {
                self.facing_hit(&facing, color, opacity, texel)
            }
            Form::Puff { ref footprint, color, opacity, .. } => {
                let (thin, alpha) = (opacity.thin, opacity.at(1.0));
                let chord = chord(self.records.view, footprint, texel, opaque_depth);
                chord.map(|chord| puff_hit(self.material.transfer, chord, color, thin, alpha))
            }
            Form::Gaussian { ref footprint, setup, is_medium } => {
                let (view, transfer) = (self.records.view, self.material.transfer);
                gaussian_hit(view, footprint, setup, is_medium, transfer, texel, opaque_depth)
            }
            Form::Brick { brick, color } => self.brick_hit(brick, color, texel, opaque_depth, part),
            Form::Capsule { ref setup, color, .. } => {
                let (view, transfer) = (self.records.view, self.material.transfer);
                capsule_hit(view, setup, transfer, color, texel, opaque_depth)
            }
            Form::Triangle(setup) => self.triangle_hit(setup, texel),
        };
        let hit = hit.filter(|hit| hit.depth >= 0.0 && hit.depth <= 1.0)?;
        let changes = matches!(self.material.transfer, Transfer::Stain | Transfer::Gain);
        let changed = if changes { hit.absorbed.abs().max_element() } else { 0.0 };
        Some(Hit { presence: hit.opacity.max(changed), ..hit })
    }

    /// Light of a brick along the ray through `texel`, which ends at light depth `opaque_depth`, by the light
    /// of its lattice.
    pub fn brick_light(
        &self,
        texel: Vec2,
        opaque_depth: f32,
        lattices: &[Option<Lattice>],
    ) -> Vec3 {
        let Form::Brick { brick, .. } = self.form else { return Vec3::ZERO };
        let Records { view, bricks, .. } = self.records;
        let end = view.near + opaque_depth * (view.far - view.near);
        let Some(lattice) = &lattices[self.id as usize] else { return Vec3::ZERO };
        if lattice.edge > LATTICE_EDGE {
            return dense_light(view, bricks, brick, texel, end, lattice);
        }
        let passage = passage(view, bricks, brick, texel, end, [0, 1]);
        passage.map_or(Vec3::ZERO, |passage| passage.thirds.light(lattice))
    }

    /// Face of a volume on the ray that ends at light depth `opaque_depth`. Faces behind its end are moved
    /// to its end.
    pub fn face(&self, texel: Vec2, opaque_depth: f32) -> Option<SurfaceCrossing> {
        let Form::Triangle(setup) = self.form else { return None };
        let absorption = self.records.absorptions[setup.material as usize];
        if absorption == Vec3::ZERO {
            return None;
        }
        let depth = setup.hit(texel)?.depth;
        if depth.is_nan() || depth < 0.0 {
            return None;
        }
        let leaves = if setup.ties & BACK_BIT != 0 { 1 } else { -1 };
        let metres = metres_per_depth(self.records.view, texel);
        Some(SurfaceCrossing { depth: depth.min(opaque_depth), metres, absorption, leaves })
    }

    /// Dither threshold at `texel` for a `dither` material: a hit blocks the light if its opacity exceeds
    /// it.
    pub fn threshold(&self, texel: Vec2) -> f32 {
        self.threshold_of(texel, self.id)
    }

    /// Like [`Self::threshold`], for one channel of coloured dithering.
    pub fn channel_threshold(&self, texel: Vec2, channel: u32) -> f32 {
        self.threshold_of(texel, self.id.wrapping_mul(3).wrapping_add(channel))
    }

    fn threshold_of(&self, texel: Vec2, id: u32) -> f32 {
        let (pattern, scale) = (self.material.pattern, self.material.pattern_scale);
        let (on_caster, step) = match self.form {
            _ if pattern != Pattern::Hashed => (Vec2::ZERO, Vec2::ONE),
            // Grids are not opaque.
            Form::Brick { .. } => (Vec2::ZERO, Vec2::ONE),
            Form::Capsule { middle, .. } => (texel - middle, Vec2::ONE),
            Form::Triangle(setup) => setup.on_triangle(texel),
            Form::Gaussian { ref footprint, setup, .. } => {
                let [a, b, c] = setup.whitening.to_array();
                let met = approach(self.records.view, footprint, setup, texel);
                (met.position, Vec2::new(a.abs().max(b.abs()), c.abs()))
            }
            Form::Facing { facing, .. } | Form::Puff { facing, .. } => {
                let met = facing.hit(self.records.view, texel);
                let step = |axis: Vec2| axis.abs().max_element();
                let step = Vec2::new(step(facing.frame_x), step(facing.frame_y));
                (met.map_or(Vec2::splat(2.0), |met| met.q), step)
            }
        };
        let point = PatternPoint { cell: cell(self.records.view, scale, texel), on_caster, step };
        threshold(pattern, scale, &point, id)
    }

    fn facing_hit(
        &self,
        facing: &Facing,
        color: Vec3,
        opacity: Opacity,
        texel: Vec2,
    ) -> Option<Hit> {
        let met = facing.hit(self.records.view, texel)?;
        let covered = coverage(self.material.shape, self.material.profile, met.q);
        if covered <= 0.0 {
            return None;
        }
        let (mut color, mut alpha) = (color, covered);
        if let Some(texture) = self.material.texture {
            let uv = Vec2::new(0.5 + 0.5 * met.q.x, 0.5 - 0.5 * met.q.y);
            let shows_clear = self.material.transfer.shows_clear();
            let image = self.records.images[texture as usize].sample(uv, shows_clear);
            color *= image.truncate();
            alpha *= image.w;
        }
        Some(self.optics(opacity.thin, opacity.at(alpha), color, met.depth))
    }

    fn brick_hit(
        &self,
        brick: &BrickRecord,
        color: Vec3,
        texel: Vec2,
        opaque_depth: f32,
        part: [u32; 2],
    ) -> Option<Hit> {
        let Records { view, bricks, .. } = self.records;
        let range = view.far - view.near;
        let end = view.near + opaque_depth * range;
        let Passage { first, ramp, tau, .. } = passage(view, bricks, brick, texel, end, part)?;
        let absorbed = tau.map(|tau| -(-tau).exp_m1());
        let at = |along: f32| (along - view.near) / range;
        Some(Hit {
            light: (-tau).map(f32::exp),
            absorbed,
            added: Vec3::ZERO,
            color,
            opacity: absorbed.max_element(),
            presence: absorbed.max_element(),
            depth: at(first),
            start: at(ramp[0]),
            end: at(ramp[1]),
        })
    }

    fn triangle_hit(&self, setup: &TriangleSetup, texel: Vec2) -> Option<Hit> {
        let met = setup.hit(texel)?;
        let mut tint = self.material.tint * setup.color(met.barycentric);
        let mut level = 0.0;
        if let Some(texture) = self.material.texture {
            let shows_clear = self.material.transfer.shows_clear();
            let seen = self.records.seen_image(texture, setup, texel, met.uv, shows_clear);
            tint *= seen.rgba;
            level = seen.level;
        }
        let mut opacity = 1.0 - (1.0 - tint.w) * (1.0 - self.material.reflectivity);
        if let Some(detail) = self.records.detail
            && self.material.transfer == Transfer::Cutout
        {
            opacity += (self.material.cutoff - detail.threshold) * level.min(1.0);
        }
        let gathers = self.material.transfer == Transfer::Gain;
        let mut color = tint.truncate() / if gathers { MAX_GAIN } else { 1.0 };
        // The picture mirrors light instead.
        if self.records.detail.is_none() {
            let index = self.material.fresnel.index();
            color *= face_passes(self.records.view, index, setup.normal, texel);
        }
        Some(self.optics(1.0, opacity, color, met.depth))
    }

    fn optics(&self, thin: f32, opacity: f32, color: Vec3, depth: f32) -> Hit {
        let transfer = self.material.transfer;
        let added = added(transfer, opacity, color);
        let light = transmittance(transfer, thin, opacity, color);
        let absorbed = absorption(transfer, thin, opacity, color);
        let (presence, start, end) = (opacity, depth, depth);
        Hit { light, absorbed, added, color, opacity, presence, depth, start, end }
    }
}

/// Distance from the centre along either axis beyond which a footprint touches no texel \[texels\]; `shape`:
/// of a particle. CPU reference of `wgsl/traversal/lane_caster.wgsl`.
fn reach(view: &GpuView, footprint: &Footprint, shape: Option<Shape>) -> f32 {
    let Some(shape) = shape else { return footprint.radius };
    if footprint.beside().is_some() {
        return f32::INFINITY;
    }
    let corner = if shape == Shape::Quad { std::f32::consts::SQRT_2 } else { 1.0 };
    let mut reach = footprint.radius * corner;
    if view.perspective > 0.0 {
        if matches!(shape, Shape::Puff | Shape::Brick) {
            // The sine of a sphere's cone, not its tangent, is radius over distance.
            reach = if reach < 1.0 { reach / (1.0 - reach * reach).sqrt() } else { f32::INFINITY };
        }
        // tan(axis + cone) - tan(axis), outwards from the view's centre.
        let slope = (footprint.center - view.size * 0.5).length() / view.scale;
        let rest = 1.0 - slope * reach;
        let ends = rest > 0.0 && reach.is_finite();
        reach =
            if ends { view.scale * reach * (1.0 + slope * slope) / rest } else { f32::INFINITY };
    }
    reach + SLACK
}

/// Light added by a hit of `over`.
pub(super) fn added(transfer: Transfer, a: f32, c: Vec3) -> Vec3 {
    if transfer == Transfer::Over { c * a } else { Vec3::ZERO }
}
