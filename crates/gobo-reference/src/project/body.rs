//! Appearance of a caster's sphere or disc in a map.
use super::{MIN_COSINE, MIN_RADIUS, TexelBox, tangents};
use glam::{Vec2, Vec3};
use gobo::records::GpuView;

/// A caster in view space.
pub(super) struct Body {
    pub center: Vec3,
    pub radius: f32,
    /// Reach of its corners, in radii.
    pub corner: f32,
    pub is_round: bool,
}

/// A caster in a map.
pub(super) struct Appearance {
    pub texel: Vec2,
    /// Radius in the map \[texels\]; in the plane at depth 1; or beside the view \[m\].
    pub radius: f32,
    /// Enlargement to the least radius that a map shows.
    pub grow: f32,
    pub bounds: TexelBox,
    /// Reach from its centre along the axis \[m\].
    pub depth_reach: f32,
}

impl Body {
    pub(super) fn is_beside(&self, view: &GpuView) -> bool {
        view.perspective > 0.0 && -self.center.z <= MIN_COSINE * self.center.length()
    }

    pub(super) fn appearance(&self, view: &GpuView) -> Appearance {
        match view.perspective > 0.0 {
            false => self.parallel(view),
            true if self.is_beside(view) => self.beside(view),
            true => self.ahead(view),
        }
    }

    /// Appearance in an orthographic view.
    fn parallel(&self, view: &GpuView) -> Appearance {
        let texel = Vec2::new(self.center.x, -self.center.y) * view.scale + view.size * 0.5;
        let projected = self.radius * view.scale;
        let grow = (MIN_RADIUS / projected).max(1.0);
        let radius = projected * grow;
        let reach = Vec2::splat(radius * self.corner);
        let bounds = TexelBox { min: texel - reach, max: texel + reach };
        let depth_reach = if self.is_round { self.radius * grow } else { 0.0 };
        Appearance { texel, radius, grow, bounds, depth_reach }
    }

    /// Appearance beside a perspective view, where its centre has no position.
    fn beside(&self, view: &GpuView) -> Appearance {
        let Self { center, corner, is_round, .. } = *self;
        let distance = -center.z;
        let grow = (MIN_RADIUS * distance / (self.radius * view.scale)).max(1.0);
        let radius = self.radius * grow;
        let away = center.length().max(f32::MIN_POSITIVE);
        let reach = radius * corner;
        let sphere =
            if is_round { radius } else { reach / (1.0 + reach / away * (reach / away)).sqrt() };
        let bounds = self.sphere_box(view, sphere);
        let sine = center.truncate().length() / away;
        let depth_reach = if is_round { radius } else { reach * sine };
        Appearance { texel: view.size * 0.5, radius, grow, bounds, depth_reach }
    }

    /// Appearance in a perspective view.
    fn ahead(&self, view: &GpuView) -> Appearance {
        let Self { center, corner, is_round, .. } = *self;
        let distance = -center.z;
        let slope = Vec2::new(center.x, -center.y) / distance;
        let texel = slope * view.scale + view.size * 0.5;
        let len2 = 1.0 + slope.length_squared();
        let projected = self.radius * view.scale / distance;
        let grow = (MIN_RADIUS / projected).max(1.0);
        let grown = self.radius * grow;
        let radius = grown / (distance * len2.sqrt());
        let reach = radius * corner;
        let sine = if is_round { reach } else { reach / (1.0 + reach * reach).sqrt() };
        let bounds = self.sphere_box(view, sine * distance * len2.sqrt());
        let depth_reach =
            if is_round { grown } else { grown * corner * (1.0 - 1.0 / len2).max(0.0).sqrt() };
        Appearance { texel, radius, grow, bounds, depth_reach }
    }

    /// Box of a sphere of radius `sphere` around the centre, in a perspective view.
    fn sphere_box(&self, view: &GpuView, sphere: f32) -> TexelBox {
        let (center, half) = (self.center, view.size * 0.5);
        let x = tangents(center.x, -center.z, sphere);
        let y = tangents(-center.y, -center.z, sphere);
        TexelBox {
            min: Vec2::new(x.x, y.x) * view.scale + half,
            max: Vec2::new(x.y, y.y) * view.scale + half,
        }
    }
}
