//! Cloud Optimized Point Cloud 1.0 (Hobu, copc.io): LAZ whose chunks are the nodes of an octree. Each level
//! holds points that no coarser level has, so that levels 0 to n are a thinned cloud.
use super::{DAMAGED, Fault};
use std::{collections::HashSet, ops::RangeInclusive};

/// Offset of the first record's head and of its contents, which describe the octree \[bytes\].
const RECORD: usize = 375;
const INFO: usize = RECORD + 54;

/// Offset and size of the first page of nodes, in the contents \[bytes\].
const ROOT: usize = 40;

/// Size of a node in a page \[bytes\].
const ENTRY: usize = 32;

/// Deepest level.
const DEEPEST: u32 = 31;

/// A node with points.
#[derive(Clone, Copy, Debug)]
pub(super) struct OctreeNode {
    pub(super) level: u32,
    pub(super) count: u64,
    /// Offset and size of its compressed points \[bytes\].
    pub(super) offset: u64,
    pub(super) size: u64,
}

/// Whether a file, by its first bytes, has an octree.
pub(super) fn has_octree(head: &[u8]) -> bool {
    head.get(RECORD + 2..RECORD + 7) == Some(b"copc\0")
        && head.get(RECORD + 18..RECORD + 20) == Some(&[1, 0])
}

fn word(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// Nodes of a file's octree, in the order of their points in the file.
pub(super) fn nodes(bytes: &[u8]) -> Result<Vec<OctreeNode>, Fault> {
    let ends = || ("the file ends in its octree".to_owned(), DAMAGED);
    let root = [ROOT, ROOT + 8].map(|at| word(bytes, INFO + at));
    let [Some(offset), Some(size)] = root else { return Err(ends()) };
    let (mut pages, mut seen, mut nodes) = (vec![(offset, size)], HashSet::new(), Vec::new());
    while let Some((offset, size)) = pages.pop() {
        if !seen.insert(offset) {
            return Err(("a page of its octree is named twice".to_owned(), DAMAGED));
        }
        for entry in part(bytes, offset, size).ok_or_else(ends)?.as_chunks::<ENTRY>().0 {
            let number =
                |at: usize| i32::from_le_bytes(std::array::from_fn(|byte| entry[at + byte]));
            let (level, size, count) = (number(0), number(24), number(28));
            let (Some(offset), Ok(size)) = (word(entry, 16), u64::try_from(size)) else {
                return Err(ends());
            };
            match (u32::try_from(level), u64::try_from(count)) {
                (_, Err(_)) if count == -1 => pages.push((offset, size)),
                (Ok(level @ 0..=DEEPEST), Ok(count)) => {
                    if count > 0 {
                        part(bytes, offset, size).ok_or_else(ends)?;
                        nodes.push(OctreeNode { level, count, offset, size });
                    }
                }
                _ => {
                    let message = format!("a node of its octree has level {level}, {count} points");
                    return Err((message, DAMAGED));
                }
            }
        }
    }
    nodes.sort_unstable_by_key(|node| node.offset);
    Ok(nodes)
}

/// A part of a file; `None` if the file ends before.
pub(super) fn part(bytes: &[u8], offset: u64, size: u64) -> Option<&[u8]> {
    let at = |offset: u64| usize::try_from(offset).ok();
    bytes.get(at(offset)?..at(offset.checked_add(size)?)?)
}

/// The finest levels from 0 on with at most `most` points; `None` if level 0 alone has more.
pub(super) fn levels(nodes: &[OctreeNode], most: u64) -> Option<RangeInclusive<u32>> {
    let mut of_level = [0_u64; DEEPEST as usize + 1];
    for node in nodes {
        let sum = &mut of_level[node.level as usize];
        *sum = sum.saturating_add(node.count);
    }
    let deepest = nodes.iter().map(|node| node.level).max()?;
    let mut sum = 0_u64;
    let fits = |&level: &u32| {
        sum = sum.saturating_add(of_level[level as usize]);
        sum <= most
    };
    (0..=deepest).take_while(fits).last().map(|level| 0..=level)
}
