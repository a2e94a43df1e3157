//! CPU reference of `wgsl/caustics/light_views.wgsl`: the views in which a light's rays are followed.
use crate::caustics::place;
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles as _};
use gobo::records::{GpuView, ROLE_FACE};

/// Views of a shadow: one, or the faces of a cube. Rays are followed in the only view's space, or along the
/// world's axes around the lamp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightViews<'a> {
    pub(crate) views: &'a [GpuView],
}

/// A point of the rays as a view sees it.
pub(crate) struct SeenPoint {
    /// Index of the view.
    pub(crate) number: usize,
    /// The point in its space \[m\].
    pub(crate) point: Vec3,
    /// Its position in the map \[texels\].
    pub(crate) place: Vec2,
}

impl LightViews<'_> {
    pub(crate) fn is_cube(&self) -> bool {
        self.views[0].role == ROLE_FACE
    }

    /// A world-space point in the space of the rays.
    pub(crate) fn in_rays(&self, point: Vec3) -> Vec3 {
        let seen = self.views[0].view_from_world.transform_point3(point);
        if self.is_cube() { back(&self.views[0], seen) } else { seen }
    }

    /// A point of the rays in world space.
    pub(crate) fn in_world(&self, point: Vec3) -> Vec3 {
        let offset = self.views[0].view_from_world.w_axis.xyz();
        if self.is_cube() {
            point - back(&self.views[0], offset)
        } else {
            back(&self.views[0], point - offset)
        }
    }

    /// A world-space direction in the space of the rays.
    pub(crate) fn turned(&self, direction: Vec3) -> Vec3 {
        if self.is_cube() {
            direction
        } else {
            self.views[0].view_from_world.transform_vector3(direction)
        }
    }

    /// A direction of the rays in world space.
    pub(crate) fn turned_back(&self, direction: Vec3) -> Vec3 {
        if self.is_cube() { direction } else { back(&self.views[0], direction) }
    }

    /// A point or a direction of the rays, in the space of a view.
    pub(crate) fn in_view(&self, number: usize, point: Vec3) -> Vec3 {
        if self.is_cube() {
            self.views[number].view_from_world.transform_vector3(point)
        } else {
            point
        }
    }

    /// Start of the ray through a point of a map, and its step per metre along the view's axis.
    pub(crate) fn ray(&self, number: usize, texel: Vec2) -> (Vec3, Vec3) {
        let view = &self.views[number];
        let slope = (texel - view.size * 0.5) / view.scale;
        let aside = Vec3::new(slope.x, -slope.y, 0.0);
        let step = if view.perspective > 0.0 { aside + Vec3::NEG_Z } else { Vec3::NEG_Z };
        let step = if self.is_cube() { back(view, step) } else { step };
        (if view.perspective > 0.0 { Vec3::ZERO } else { aside }, step)
    }

    pub(crate) fn seen(&self, point: Vec3) -> SeenPoint {
        let number = if self.is_cube() { cube_face(point) } else { 0 };
        self.seen_in(number, point)
    }

    pub(crate) fn seen_in(&self, number: usize, point: Vec3) -> SeenPoint {
        let view = &self.views[number];
        let own = self.in_view(number, point);
        let at = place(view, own);
        // By rounding, a point between two faces of a cube may be beside both.
        let at = if self.is_cube() { at.clamp(Vec2::ZERO, view.size - 0.001) } else { at };
        SeenPoint { number, point: own, place: at }
    }

    /// Edge of a texel at a point of the rays \[m\].
    pub(crate) fn texel_at(&self, point: Vec3) -> f32 {
        let seen = self.seen(point);
        let view = &self.views[seen.number];
        if view.perspective > 0.0 { -seen.point.z / view.scale } else { 1.0 / view.scale }
    }

    /// Share of the light of a texel, relative to the middle of the map.
    pub(crate) fn texel_share(&self, number: usize, place: Vec2) -> f32 {
        let view = &self.views[number];
        let slope = (place - view.size * 0.5) / view.scale;
        let square = 1.0 + slope.length_squared();
        if view.perspective > 0.0 { 1.0 / (square.sqrt() * square) } else { 1.0 }
    }

    /// Length of a ray's way to the far plane, or to the first of a cube's far planes.
    pub(crate) fn way_to_end(&self, start: Vec3, ray: Vec3) -> f32 {
        if !self.is_cube() {
            return (self.views[0].far + start.z) / -ray.z;
        }
        let end = |axis: usize| {
            let (at, along) = (start[axis], ray[axis]);
            let far = self.views[2 * axis + usize::from(along <= 0.0)].far;
            let sign = if along == 0.0 { 0.0 } else { along.signum() };
            (far - at * sign) / along.abs().max(1e-12)
        };
        end(0).min(end(1)).min(end(2))
    }
}

/// A direction of a view in world space.
fn back(view: &GpuView, direction: Vec3) -> Vec3 {
    let rows: Vec4 = view.view_from_world.transpose() * direction.extend(0.0);
    rows.xyz()
}

/// Face of a cube that contains the direction `away` from its centre.
pub(crate) fn cube_face(away: Vec3) -> usize {
    let size = away.abs();
    if size.x >= size.y && size.x >= size.z {
        usize::from(away.x <= 0.0)
    } else if size.y >= size.z {
        2 + usize::from(away.y <= 0.0)
    } else {
        4 + usize::from(away.z <= 0.0)
    }
}
