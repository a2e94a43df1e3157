//! Opaque discs and triangles in the tiles of two views, and the depths that they leave.
use super::by_hand::{TILES, place_of, texel_of, views};
use crate::common::scenes::{Chance, triangle};
use gobo::{
    glam::{Vec2, Vec3},
    records::TriangleRecord,
};
use std::ops::Range;

/// Pairs of each tile: none, one, and around the sizes of subgroups.
const COUNTS: [u32; TILES as usize] = [1, 0, 7, 9, 8, 65, 33, 150];
/// Pairs between those of two tiles, belonging to none.
const GAP: u32 = 3;
/// Distance to an edge below which rounding decides [texels].
const EDGE: f32 = 1e-2;

/// A flat disc or a triangle of one depth, in the texels of a view.
#[derive(Clone, Copy, Debug)]
pub(super) enum Blocker {
    Disc { center: Vec2, radius: f32, depth: f32 },
    Triangle { corners: [Vec2; 3], depth: f32 },
}

impl Blocker {
    pub(super) fn random(chance: &mut Chance, corner: Vec2, depth: f32, triangles: bool) -> Self {
        let mut near = || corner + Vec2::new(chance.within(-9.0, 25.0), chance.within(-9.0, 25.0));
        if triangles {
            return Self::Triangle { corners: [near(), near(), near()], depth };
        }
        Self::Disc { center: near(), radius: chance.within(0.8, 9.0), depth }
    }

    pub(super) fn depth(&self) -> f32 {
        let (Self::Disc { depth, .. } | Self::Triangle { depth, .. }) = self;
        *depth
    }

    /// Distance of a texel's centre from the edge, positive inside [texels].
    pub(super) fn inside(&self, texel: Vec2) -> f32 {
        match *self {
            Self::Disc { center, radius, .. } => radius - texel.distance(center),
            Self::Triangle { corners, .. } => {
                let turn = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).signum();
                let edge = |i: usize| {
                    let along = (corners[(i + 1) % 3] - corners[i]).normalize();
                    along.perp_dot(texel - corners[i]) * turn
                };
                edge(0).min(edge(1)).min(edge(2))
            }
        }
    }

    /// Its record in view 0 or 1: where `texel` is in the world.
    pub(super) fn record(&self, view: usize) -> TriangleRecord {
        let Self::Triangle { corners, depth } = *self else { panic!("a disc") };
        let half = views()[view].size * 0.5;
        let world = |p: Vec2| Vec3::new(p.x - half.x, half.y - p.y, -depth);
        TriangleRecord::new(&triangle(corners.map(world), 0))
    }
}

/// Possible depths of a texel: of the nearest hit, or of a nearer one that rounding decides.
pub(super) fn depths<'a>(blockers: impl Iterator<Item = &'a Blocker>, texel: Vec2) -> Vec<f32> {
    let (mut sure, mut open) = (1.0_f32, Vec::new());
    for blocker in blockers {
        match blocker.inside(texel) {
            inside if inside > EDGE => sure = sure.min(blocker.depth()),
            inside if inside > -EDGE => open.push(blocker.depth()),
            _ => {}
        }
    }
    open.retain(|&depth| depth < sure);
    open.push(sure);
    open
}

/// Blockers front to back in each tile, and each tile's run of `pairs`.
pub(super) struct Batch {
    pub(super) blockers: Vec<Blocker>,
    /// View of each blocker.
    pub(super) view_of: Vec<usize>,
    pub(super) pairs: Vec<u32>,
    pub(super) runs: [Range<u32>; TILES as usize],
}

impl Batch {
    /// The first blocker is in front of everything, and in no tile.
    pub(super) fn new(triangles: bool, seed: u64) -> Self {
        let mut chance = Chance::new(seed);
        let everywhere = if triangles {
            let corners = [Vec2::splat(-99.0), Vec2::new(300.0, -99.0), Vec2::new(-99.0, 300.0)];
            Blocker::Triangle { corners, depth: 0.001 }
        } else {
            Blocker::Disc { center: Vec2::splat(20.0), radius: 1e3, depth: 0.001 }
        };
        let (mut blockers, mut view_of, mut pairs) = (vec![everywhere], vec![0], Vec::new());
        let runs = [0, 1, 2, 3, 4, 5, 6, 7].map(|tile: u32| {
            pairs.extend([0; GAP as usize]);
            let first = pairs.len() as u32;
            let corner = texel_of(tile, 0).0;
            let count = COUNTS[tile as usize];
            for i in 0..count {
                let depth = 0.01 + 0.98 * (i as f32 + chance.unit()) / count as f32;
                pairs.push(blockers.len() as u32);
                blockers.push(Blocker::random(&mut chance, corner, depth, triangles));
                view_of.push(place_of(tile).0);
            }
            first..pairs.len() as u32
        });
        pairs.extend([0; GAP as usize]);
        Self { blockers, view_of, pairs, runs }
    }

    pub(super) fn of(&self, run: Range<u32>) -> impl Iterator<Item = &Blocker> {
        let ids = self.pairs[run.start as usize..run.end as usize].iter();
        ids.map(|&id| &self.blockers[id as usize])
    }
}
