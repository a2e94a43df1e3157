//! Small pictures of a scene's triangles, on the CPU: the surfaces that a view sees at each texel.
use super::View;
use crate::model::{Material, Projection, Scene};
use glam::{DMat3, DMat4, DVec2, DVec3, IVec2, UVec2, Vec3};

/// Surface that a texel sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// World space \[m\].
    pub point: DVec3,
    /// Index of the triangle.
    pub triangle: u32,
}

/// Edge of a small map of a light \[texels\].
pub(super) const SMALL_MAP: u32 = 512;
/// Triangles kept per texel.
pub(super) const LAYERS: usize = 4;

/// A triangle at a texel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    /// Along the view's axis \[m\]; infinite without a triangle.
    pub depth: f32,
    /// Index.
    pub triangle: u32,
    /// Whether its front is seen.
    pub is_front: bool,
}

/// Triangles at a texel, the nearest first.
pub(super) type Layers = [Layer; LAYERS];

impl Default for Layer {
    /// No triangle.
    fn default() -> Self {
        Self { depth: f32::INFINITY, triangle: u32::MAX, is_front: false }
    }
}

/// A view with few texels.
pub(super) struct Raster {
    size: IVec2,
    perspective: bool,
    position: DVec3,
    world_from_view: DMat4,
    view_from_world: DMat4,
    /// Texels per unit of the view's plane.
    scale: DVec2,
    planes: [f64; 2],
}

/// Surface that each texel sees.
pub(super) struct Image {
    size: IVec2,
    seen: Vec<Option<Nearest>>,
}

impl Raster {
    /// The view with `size` texels in all.
    pub(super) fn new(view: &View, size: UVec2) -> Self {
        let size = size.max(UVec2::ONE);
        let view_from_world = view.view_from_world.as_dmat4();
        Self {
            size: size.as_ivec2(),
            perspective: view.projection == Projection::Perspective,
            position: view_from_world.inverse().w_axis.truncate(),
            world_from_view: view_from_world.inverse(),
            view_from_world,
            scale: size.as_dvec2() / view.size.as_dvec2() * f64::from(view.scale),
            planes: [f64::from(view.near), f64::from(view.far)],
        }
    }

    /// Homogeneous place of a point \[texels\], and its weight.
    fn project(&self, point: DVec3) -> DVec3 {
        let p = self.view_from_world.transform_point3(point);
        let weight = if self.perspective { -p.z } else { 1.0 };
        let middle = self.size.as_dvec2() * 0.5 * weight;
        (DVec2::new(p.x, -p.y) * self.scale + middle).extend(weight)
    }

    /// The texel that a point is in.
    pub(super) fn texel_of(&self, point: DVec3) -> Option<IVec2> {
        let in_map = self.project(point);
        let texel = (in_map.truncate() / in_map.z).floor().as_ivec2();
        (in_map.z > 0.0 && self.contains(texel)).then_some(texel)
    }

    pub(super) fn contains(&self, texel: IVec2) -> bool {
        texel.cmpge(IVec2::ZERO).all() && texel.cmplt(self.size).all()
    }

    /// The ray through a texel's centre: its start, and its direction with length 1 along the axis.
    fn ray(&self, texel: IVec2) -> (DVec3, DVec3) {
        let off = (texel.as_dvec2() + 0.5 - self.size.as_dvec2() * 0.5) / self.scale;
        let off = DVec2::new(off.x, -off.y);
        if self.perspective {
            (self.position, self.world_from_view.transform_vector3(off.extend(-1.0)))
        } else {
            let start = self.world_from_view.transform_point3(off.extend(0.0));
            (start, self.world_from_view.transform_vector3(DVec3::NEG_Z))
        }
    }

    /// The nearest triangles whose material is `wanted`.
    pub(super) fn nearest(&self, scene: &Scene, wanted: impl Fn(&Material) -> bool) -> Image {
        let texels = (self.size.x * self.size.y) as usize;
        let mut depths = vec![f64::INFINITY; texels];
        let mut owners = vec![u32::MAX; texels];
        self.visit(scene, wanted, |at, depth, index, _| {
            if depth < depths[at] {
                (depths[at], owners[at]) = (depth, index);
            }
        });
        let seen = (0..texels).map(|at| {
            let point = self.point(at, depths[at]);
            (owners[at] != u32::MAX).then_some(Nearest { point, triangle: owners[at] })
        });
        Image { size: self.size, seen: seen.collect() }
    }

    /// The nearest [`LAYERS`] triangles of each texel whose material is `wanted`.
    pub(super) fn layers(&self, scene: &Scene, wanted: impl Fn(&Material) -> bool) -> Vec<Layers> {
        let texels = (self.size.x * self.size.y) as usize;
        let mut all = vec![[Layer::default(); LAYERS]; texels];
        self.visit(scene, wanted, |at, depth, triangle, is_front| {
            let mut layer = Layer { depth: depth as f32, triangle, is_front };
            for kept in &mut all[at] {
                if layer.depth < kept.depth {
                    std::mem::swap(kept, &mut layer);
                }
            }
        });
        all
    }

    /// World position at a depth in the texel with an index \[m\].
    pub(super) fn point(&self, at: usize, depth: f64) -> DVec3 {
        let texel = IVec2::new(at as i32 % self.size.x, at as i32 / self.size.x);
        let (start, way) = self.ray(texel);
        start + way * depth
    }

    /// Calls `hit` for each texel and triangle that covers its centre, with the texel's index, the depth, the
    /// triangle, and whether its front is seen.
    fn visit(
        &self,
        scene: &Scene,
        wanted: impl Fn(&Material) -> bool,
        mut hit: impl FnMut(usize, f64, u32, bool),
    ) {
        let wanted: Vec<bool> = scene.materials.iter().map(wanted).collect();
        for (index, triangle) in (0..).zip(&scene.triangles) {
            if !wanted[triangle.material as usize] {
                continue;
            }
            let corners = triangle.positions.map(Vec3::as_dvec3);
            let corners_in_map = corners.map(|corner| self.project(corner));
            let Some([first, last]) = self.covered(corners_in_map) else { continue };
            // Edge functions of homogeneous points (Olano and Greer 1997).
            let inside = DMat3::from_cols_array_2d(&corners_in_map.map(|in_map| in_map.to_array()))
                .inverse();
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a);
            if !inside.is_finite() {
                continue;
            }
            for y in first.y..=last.y {
                for x in first.x..=last.x {
                    let weights = inside * (IVec2::new(x, y).as_dvec2() + 0.5).extend(1.0);
                    if !weights.cmpge(DVec3::ZERO).all() {
                        continue;
                    }
                    let (start, way) = self.ray(IVec2::new(x, y));
                    let along = way.dot(normal);
                    let depth = (a - start).dot(normal) / along;
                    if depth >= self.planes[0] && depth <= self.planes[1] {
                        hit((y * self.size.x + x) as usize, depth, index, along < 0.0);
                    }
                }
            }
        }
    }

    /// First and last texel whose centres a triangle may cover.
    fn covered(&self, corners_in_map: [DVec3; 3]) -> Option<[IVec2; 2]> {
        let behind = corners_in_map.iter().filter(|in_map| in_map.z <= 1e-9).count();
        let (first, last) = match behind {
            0 => {
                let flat = corners_in_map.map(|in_map| in_map.truncate() / in_map.z);
                let low = flat[0].min(flat[1]).min(flat[2]);
                let high = flat[0].max(flat[1]).max(flat[2]);
                ((low - 0.5).ceil().as_ivec2(), (high - 0.5).floor().as_ivec2())
            }
            3 => return None,
            _ => (IVec2::ZERO, self.size - 1),
        };
        let (first, last) = (first.max(IVec2::ZERO), last.min(self.size - 1));
        first.cmple(last).all().then_some([first, last])
    }
}

impl Image {
    pub(super) fn hits(&self) -> impl Iterator<Item = &Nearest> {
        self.seen.iter().flatten()
    }

    pub(super) fn at(&self, texel: IVec2) -> Option<&Nearest> {
        self.seen[(texel.y * self.size.x + texel.x) as usize].as_ref()
    }

    pub(super) fn contains(&self, texel: IVec2) -> bool {
        texel.cmpge(IVec2::ZERO).all() && texel.cmplt(self.size).all()
    }

    /// The picture with a texel for 2 x 2: the surface with the least `depth`.
    pub(super) fn halved(&self, depth: impl Fn(&Nearest) -> f64) -> Self {
        let size = self.size / 2;
        let texels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| IVec2::new(x, y) * 2));
        let nearest = |at: IVec2| {
            let four = [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE];
            let seen = four.into_iter().filter_map(|step| self.at(at + step));
            seen.min_by(|a, b| depth(a).total_cmp(&depth(b))).copied()
        };
        Self { size, seen: texels.map(nearest).collect() }
    }
}
