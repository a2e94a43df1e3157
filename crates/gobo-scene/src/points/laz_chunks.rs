//! Chunks of LAZ: the table of their sizes, and the sizes of the layers in each.
use laz::laszip::{LazItem, LazItemType};

/// Refuses a table of more chunks than the file has bytes: the decoder allocates all of them.
pub(super) fn check_table(bytes: &[u8], start: u64) -> Result<(), &'static str> {
    let at = |offset: u64| usize::try_from(offset).ok().filter(|at| *at <= bytes.len());
    let offset = |place: u64| -> Option<u64> {
        let word = bytes.get(at(place)?..)?.first_chunk()?;
        u64::try_from(i64::from_le_bytes(*word)).ok()
    };
    let ends = "the file ends in its table of chunks";
    let mut table = offset(start).unwrap_or(0);
    if table <= start {
        // A program that could not seek back writes the offset last.
        table = (bytes.len() as u64).checked_sub(8).and_then(offset).ok_or(ends)?;
    }
    let table = at(table).and_then(|table| bytes.get(table..)).ok_or(ends)?;
    let count = word(table, 4).ok_or(ends)?;
    if count as usize > bytes.len() { Err("its table has more chunks than bytes") } else { Ok(()) }
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

/// Layers of an item of a record.
fn layers(item: &LazItem) -> usize {
    match item.item_type() {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(count) => count.into(),
        _ => 1,
    }
}

/// Refuses a chunk that is shorter than its layers: the decoder allocates all of them. Behind its first
/// record of `size` bytes stand the number of records and the sizes of the layers.
pub(super) fn check_layers(
    chunk: &[u8],
    items: &[LazItem],
    size: usize,
) -> Result<(), &'static str> {
    let first = size + 4;
    let count: usize = items.iter().map(layers).sum();
    let sizes = (0..count).map(|layer| word(chunk, first + 4 * layer).map(u64::from));
    let whole = sizes.sum::<Option<u64>>();
    let room = chunk.len().checked_sub(first + 4 * count);
    match (whole, room) {
        (Some(whole), Some(room)) if whole <= room as u64 => Ok(()),
        _ => Err("a chunk ends in its layers"),
    }
}
