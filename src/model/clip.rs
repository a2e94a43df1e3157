//! Views from the matrices of an engine's own shadow cameras.
use super::{Projection, View, ViewRole};
use glam::{DMat4, DVec3, DVec4, Mat4, UVec2};

/// Largest deviation of a matrix from a camera's \[share\].
const SLACK: f64 = 1e-4;

/// Error of a matrix that is not a camera's, or not one that a view can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is no shadow camera's: {problem}")]
pub struct InvalidClip {
    /// The problem, and what to do.
    pub problem: &'static str,
}

impl View {
    /// The view of an engine's own shadow camera, with any roll: `clip_from_world` takes world space \[m\] to
    /// clip space, NDC x and y in -1..1 with y up, z in 0..1 or reversed. The view has no light yet: set
    /// [`Self::light`], and [`Self::role`] if the light has several. A mirrored orthographic matrix reads as
    /// one that looks the other way with z reversed.
    ///
    /// # Errors
    /// If a number is not finite, the axes are not orthogonal or not right-handed, the far plane is infinite,
    /// the frustum is not symmetric, or texels of a map of `size` would not be square.
    pub fn from_clip(clip_from_world: &Mat4, size: UVec2) -> Result<Self, InvalidClip> {
        let camera = ClipCamera::new(&clip_from_world.as_dmat4())?;
        let across = camera.scale * size.as_dvec2() * 0.5;
        if size.min_element() == 0 || (across.x - across.y).abs() > SLACK * across.x {
            return Err(invalid("its texels are not square: give the size of the engine's map"));
        }
        let [right, up, back] = camera.axes;
        let origin = camera.origin;
        let row = |axis: DVec3, at: f64| axis.extend(at);
        let view_from_world = DMat4::from_cols(
            row(right, origin.x),
            row(up, origin.y),
            row(back, origin.z),
            DVec4::W,
        )
        .transpose();
        Ok(Self {
            light: None,
            name: "clip",
            role: ViewRole::Whole,
            projection: camera.projection,
            size,
            near: camera.near as f32,
            far: camera.far as f32,
            view_from_world: view_from_world.as_mat4(),
            scale: across.x as f32,
        })
    }
}

fn invalid(problem: &'static str) -> InvalidClip {
    InvalidClip { problem }
}

/// Camera of a matrix.
struct ClipCamera {
    projection: Projection,
    /// Right, up and back, unit.
    axes: [DVec3; 3],
    /// The world's origin in view space \[m\].
    origin: DVec3,
    /// NDC per metre (at 1 m along the axis), x and y.
    scale: glam::DVec2,
    near: f64,
    far: f64,
}

impl ClipCamera {
    fn new(clip_from_world: &DMat4) -> Result<Self, InvalidClip> {
        if !clip_from_world.is_finite() {
            return Err(invalid("a number is not finite"));
        }
        let rows = [0, 1, 2, 3].map(|i| clip_from_world.row(i));
        let is_perspective = rows[3].truncate().length() > 0.0;
        // Rows may be scaled together.
        let unit = if is_perspective { rows[3].truncate().length() } else { rows[3].w };
        let [x, y, z, w] = rows.map(|row| row / unit);
        if !(x.is_finite() && y.is_finite() && z.is_finite()) {
            return Err(invalid("its last row is zero"));
        }
        let scale = glam::DVec2::new(x.truncate().length(), y.truncate().length());
        let (right, up) = (x.truncate() / scale.x, y.truncate() / scale.y);
        let back = right.cross(up);
        if !(back.is_finite() && right.dot(up).abs() <= SLACK) {
            return Err(invalid(
                "right and up are not orthogonal, or the frustum is not symmetric",
            ));
        }
        let mut origin = DVec3::new(x.w / scale.x, y.w / scale.y, 0.0);
        let along = -back;
        let (near, far);
        if is_perspective {
            let axis = w.truncate();
            if axis.dot(along) < 0.0 {
                return Err(invalid("it is left-handed: negate its y row"));
            }
            if (axis - along).length() > SLACK {
                return Err(invalid(
                    "right and up are not orthogonal, or the frustum is not symmetric",
                ));
            }
            origin.z = -w.w;
            // NDC z = a + b / depth
            let a = z.truncate().dot(along);
            let b = z.w - a * w.w;
            // An infinite far plane has depth 0 or 1 at the end of all depths.
            if a.abs() < 1e-7 || (1.0 - a).abs() < 1e-7 {
                return Err(invalid(
                    "its far plane is infinite: give the depth of the farthest receiver",
                ));
            }
            (near, far) = order(-b / a, b / (1.0 - a));
        } else {
            let a = z.truncate().dot(along);
            if (z.truncate() - a * along).length() > SLACK * a.abs() || a == 0.0 {
                return Err(invalid("its depth is not along its axis"));
            }
            (near, far) = order(-z.w / a, (1.0 - z.w) / a);
        }
        if !(near < far && near.is_finite() && far.is_finite() && (near > 0.0 || !is_perspective)) {
            return Err(invalid("its near and far planes enclose no depth"));
        }
        let projection =
            if is_perspective { Projection::Perspective } else { Projection::Orthographic };
        Ok(Self { projection, axes: [right, up, back], origin, scale, near, far })
    }
}

/// Puts the two depths in order: with reversed z the far plane comes first.
fn order(a: f64, b: f64) -> (f64, f64) {
    (a.min(b), a.max(b))
}
