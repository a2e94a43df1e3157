//! A share of a cloud: its points are kept, and of all points what the shares have in common.
use super::Point;
use crate::share::Share;
use glam::{DVec3, Vec3};

/// Remedy for a cloud whose share needs all points.
pub(super) const HELP: &str = "give its material a radius: without one the spacing of all points is measured, and they are too many";

/// Strengths of an echo in 16 bits.
const STRENGTHS: usize = 1 << 16;

/// State of reading a share.
#[derive(Debug)]
pub(super) struct Part {
    share: Share,
    /// Valid points of other shares so far.
    pub(super) others: u64,
    /// Box of the valid points of all shares, in the file's axes \[m\].
    pub(super) extent: [DVec3; 2],
    /// Whether a point of any share has a colour other than black.
    pub(super) is_colored: bool,
    /// Number of points of all shares by the strength of their echo.
    echoes: Vec<u64>,
    /// Classes of the points of all shares.
    pub(super) classes: [bool; 256],
}

impl Part {
    pub(super) fn new(share: Share) -> Self {
        Self {
            share,
            others: 0,
            extent: [DVec3::INFINITY, DVec3::NEG_INFINITY],
            is_colored: false,
            echoes: vec![0; STRENGTHS],
            classes: [false; 256],
        }
    }

    /// Notes a valid point; returns whether it belongs to the share.
    pub(super) fn takes(&mut self, row: u64, point: &Point) -> bool {
        let [min, max] = self.extent;
        self.extent = [min.min(point.position), max.max(point.position)];
        self.is_colored |= point.color.is_some_and(|color| color != Vec3::ZERO);
        if let Some(count) = point.intensity.and_then(|echo| self.echoes.get_mut(echo as usize)) {
            *count += 1;
        }
        if let Some(class) = point.class {
            self.classes[usize::from(class)] = true;
        }
        let is_own = self.share.has(row);
        self.others += u64::from(!is_own);
        is_own
    }

    /// Strength below which a share of the echoes above 0 lies; `None` without echoes.
    pub(super) fn quantile(&self, share: f64) -> Option<f32> {
        let count: u64 = self.echoes[1..].iter().sum();
        let at = (count.checked_sub(1)? as f64 * share) as u64;
        let mut sum = 0;
        let mut found = (1..STRENGTHS).filter(|&echo| {
            sum += self.echoes[echo];
            sum > at
        });
        found.next().map(|echo| echo as f32)
    }
}
