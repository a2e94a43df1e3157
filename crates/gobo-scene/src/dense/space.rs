//! Placement of a voxel array in space.
use crate::{units::Up, vdb::VolumeFault};
use glam::{DAffine3, DMat3, DVec3};

/// Placement of a file's voxels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The file's space, in its units, from index space, where voxel centres are whole numbers.
    pub(super) file_from_index: DAffine3,
    /// Unit that the file states \[m\].
    pub(super) unit: Option<f64>,
    /// Anatomical axes, if the file states them.
    pub(super) body: Option<BodyAxes>,
}

/// Sides of the body that x and y grow towards; z grows towards the head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodyAxes {
    /// Left and back, as in DICOM.
    LeftBack,
    /// Right and front, as in `NIfTI`.
    RightFront,
    /// Left and front.
    LeftFront,
}

impl BodyAxes {
    /// Rotation to a body that stands and faces +z: x to its left, y to its head, as glTF wants of models.
    fn standing(self) -> DMat3 {
        let (left, front) = match self {
            Self::LeftBack => (1.0, -1.0),
            Self::RightFront => (-1.0, 1.0),
            Self::LeftFront => (1.0, 1.0),
        };
        DMat3::from_cols(DVec3::X * left, DVec3::Z * front, DVec3::Y)
    }
}

impl Default for Place {
    fn default() -> Self {
        Self { file_from_index: DAffine3::IDENTITY, unit: None, body: None }
    }
}

impl Place {
    pub(super) fn new(axes: [DVec3; 3], origin: DVec3) -> Self {
        let [x, y, z] = axes;
        let matrix3 = DMat3::from_cols(x, y, z);
        let file_from_index = DAffine3 { matrix3, translation: origin };
        Self { file_from_index, ..Self::default() }
    }

    /// Refuses voxels without volume.
    pub(super) fn check(&self) -> Result<(), VolumeFault> {
        let (affine, matrix) = (self.file_from_index, self.file_from_index.matrix3);
        if !affine.is_finite() || !matrix.determinant().is_normal() || !matrix.inverse().is_finite()
        {
            let message = "its voxels have no volume, or none that is finite";
            return Err(VolumeFault::new(
                message,
                "write finite spacings that are not 0, and axes in three directions",
            ));
        }
        Ok(())
    }

    /// The volume's space \[m\] from index space.
    pub(super) fn volume_from_index(&self, unit: Option<f64>, up: Option<Up>) -> DAffine3 {
        let axes = match (up, self.body) {
            (Some(up), _) => up.turn(),
            (None, Some(body)) => body.standing(),
            (None, None) => DMat3::IDENTITY,
        };
        let unit = unit.or(self.unit).unwrap_or(1.0);
        DAffine3::from_mat3(axes * unit) * self.file_from_index
    }
}
