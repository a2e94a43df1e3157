//! An array of voxels in memory.
use super::{array::Layout, space::Place};
use crate::{units::Up, vdb::VolumeFault};
use glam::DAffine3;

/// An array of voxels in memory.
#[derive(Debug)]
pub(crate) struct Dense {
    bytes: Vec<u8>,
    layout: Layout,
    /// Factor of each number, and the offset added after it.
    pub(super) scale: [f64; 2],
    place: Place,
    /// Parts of the file that are not shown, a sentence each.
    pub(crate) notes: Vec<String>,
}

impl Dense {
    /// `bytes`: from the first voxel on.
    pub(super) fn new(bytes: Vec<u8>, layout: Layout, place: Place) -> Result<Self, VolumeFault> {
        let (have, need) = (bytes.len(), layout.bytes());
        if have < need {
            return Err(VolumeFault::damaged(format!(
                "its voxels take {need} bytes, but {have} are there"
            )));
        }
        place.check()?;
        let mut notes = Vec::new();
        if layout.others > 1 {
            notes.push(format!("of its {} volumes, the first is shown", layout.others));
        }
        Ok(Self { bytes, layout, scale: [1.0, 0.0], place, notes })
    }

    /// Voxels along x, y and z.
    pub(crate) fn size(&self) -> [usize; 3] {
        self.layout.size
    }

    /// Numbers of a voxel: 1, or 3 or 4 of a colour.
    pub(crate) fn channels(&self) -> usize {
        self.layout.channels
    }

    /// The value of a voxel that has one number.
    pub(crate) fn value(&self, voxel: [usize; 3]) -> f32 {
        let [scale, offset] = self.scale;
        (self.layout.at(&self.bytes, voxel, 0) * scale + offset) as f32
    }

    /// A channel of a voxel's colour times its opacity, each of 0 to 1.
    pub(crate) fn color(&self, voxel: [usize; 3], channel: usize) -> f32 {
        let share =
            |channel| self.layout.at(&self.bytes, voxel, channel) / self.layout.number.one();
        let opacity = if self.layout.channels == 4 { share(3) } else { 1.0 };
        (share(channel) * opacity) as f32
    }

    /// The file's space \[m\] from index space, where voxel centres are whole numbers. `unit` \[m\] and `up`
    /// override the file's.
    pub(crate) fn volume_from_index(&self, unit: Option<f64>, up: Option<Up>) -> DAffine3 {
        self.place.volume_from_index(unit, up)
    }
}
