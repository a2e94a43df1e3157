//! The parts of a picture, one after another.
use crate::picture::{lists::CameraList, shading::Shading};
use gobo::{
    frame::{Commands, Dispatch},
    stage::bin::BatchCounters,
};
use wgpu::Buffer;

pub(super) struct Parts<'a> {
    pub lists: &'a [CameraList; 2],
    pub shading: &'a Shading,
    /// Counters of the lists, part by part.
    pub counters: &'a Buffer,
    pub count: usize,
}

impl Parts<'_> {
    /// From the pairs of the only part, or from footprints, to pixels. `masking`: makes the masks of visible
    /// surfaces; empty without masks.
    pub(super) fn drawing(&self, masking: &[Dispatch]) -> Commands {
        let in_parts = self.count > 1;
        let mut commands = self.shading.casters();
        let has_masks = !masking.is_empty();
        if has_masks {
            for part in 0..self.count {
                if in_parts {
                    commands.append(self.pairs(part));
                }
                commands.append(self.shading.surfaces(part));
            }
            commands.pass("gobo mask", masking.iter().cloned());
        }
        for part in 0..self.count {
            if in_parts {
                commands.append(self.pairs(part));
            }
            commands.append(self.shading.part(part));
        }
        commands
    }

    /// From casters to the pairs of both lists of the only part, or to footprints.
    pub(super) fn listing(&self) -> Commands {
        let mut commands = Commands::new();
        self.lists.iter().for_each(|list| commands.append(list.footprints()));
        if self.count == 1 {
            commands.append(self.pairs(0));
        }
        commands
    }

    /// From footprints to the number of pairs of several parts.
    pub(super) fn counting(&self) -> Commands {
        let mut commands = Commands::new();
        (0..self.count)
            .filter(|_| self.count > 1)
            .for_each(|part| commands.append(self.pairs(part)));
        commands
    }

    fn pairs(&self, part: usize) -> Commands {
        const SIZE: u64 = size_of::<BatchCounters>() as u64;
        let mut commands = Commands::new();
        for (i, list) in (0..).zip(self.lists) {
            commands.append(list.pairs(part));
            let at = (2 * part as u64 + i) * SIZE;
            let counters = &list.list.counters;
            commands.copy_buffer("gobo bin", (counters, 0), (self.counters, at), SIZE);
        }
        commands
    }
}
