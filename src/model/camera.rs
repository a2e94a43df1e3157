//! The camera of the picture.
use glam::{DMat3, DMat4, DVec3, UVec2, Vec3};

/// The camera of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye, world space \[m\].
    pub eye: Vec3,
    /// Point that the camera looks at, world space \[m\].
    pub target: Vec3,
    /// Approximate up direction, world space.
    pub up: Vec3,
    /// Vertical field of view \[radians\].
    pub fov_y: f32,
    /// Size of the picture \[pixels\].
    pub size: UVec2,
}

impl Default for Camera {
    /// A view of the origin from the side and above, 45 degrees high.
    fn default() -> Self {
        Self {
            eye: Vec3::new(4.0, 3.0, 6.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov_y: std::f32::consts::FRAC_PI_4,
            size: UVec2::new(960, 540),
        }
    }
}

/// Error of a matrix that is no perspective projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the camera's matrix cannot be used: {0}")]
pub struct InvalidCamera(pub(crate) &'static str);

impl Camera {
    /// Reason why no view fits the camera.
    pub(crate) fn problem(&self) -> Option<&'static str> {
        let &Self { eye, target, up, fov_y, size } = self;
        let is_finite = eye.is_finite() && target.is_finite() && up.is_finite();
        let turns = (target - eye).normalize_or_zero().cross(up) != Vec3::ZERO;
        let is_cone = fov_y > 0.0 && fov_y < std::f32::consts::PI;
        let is_valid = is_finite && turns && is_cone && size.min_element() > 0;
        (!is_valid).then_some(
            "the camera that its cascades follow must be finite, look somewhere, not along its up vector, \
             have a field of view of 0 to pi radians, and pixels",
        )
    }

    /// The camera of a perspective projection: `clip_from_world` as columns, reversed z or not, infinite far
    /// plane or not; `size` of the picture \[pixels\]. An off-axis frustum (of one of two eyes, or jittered
    /// within a pixel) becomes a symmetric one that encloses it.
    /// # Errors
    /// If a number is not finite, the picture has no pixel, or the projection is orthographic.
    pub fn from_clip(
        clip_from_world: [[f32; 4]; 4],
        size: impl Into<[u32; 2]>,
    ) -> Result<Self, InvalidCamera> {
        let size = UVec2::from(size.into());
        let clip = DMat4::from_cols_array_2d(&clip_from_world.map(|column| column.map(f64::from)));
        if !clip.is_finite() || size.min_element() == 0 {
            return Err(InvalidCamera("its numbers must be finite, its picture not empty"));
        }
        let [x, y, w] = [0, 1, 3].map(|row| clip.row(row));
        // x, y and w as functions of a point; w grows ahead.
        let rows = DMat3::from_cols(x.truncate(), y.truncate(), w.truncate()).transpose();
        let steepness = w.truncate().length();
        let volume = x.truncate().length() * y.truncate().length() * steepness;
        if rows.determinant().abs() <= 1e-9 * volume {
            return Err(InvalidCamera("it must be a perspective one, whose rays meet in an eye"));
        }
        let eye = -(rows.inverse() * DVec3::new(x.w, y.w, w.w));
        let forward = w.truncate() / steepness;
        // Slopes of the farther borders: clip.x = -w and clip.x = w.
        let slope = |row: DVec3| {
            let ahead = row.dot(forward);
            (ahead.abs() + steepness) / (row - ahead * forward).length()
        };
        let aspect = f64::from(size.x) / f64::from(size.y);
        let tall = slope(y.truncate()).max(slope(x.truncate()) / aspect);
        let up = y.truncate() - y.truncate().dot(forward) * forward;
        Ok(Self {
            eye: eye.as_vec3(),
            target: (eye + forward).as_vec3(),
            up: up.normalize().as_vec3(),
            fov_y: (2.0 * tall.atan()) as f32,
            size,
        })
    }
}
