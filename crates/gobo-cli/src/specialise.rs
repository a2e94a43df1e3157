//! Overrides that stay open: names of SPIR-V's specialisation constants, which naga does not write.
use gobo::{
    gpu::RecordForm,
    stage::{
        bin::WIDE_DISC_SEGMENT, buckets::BUCKET_PAIRS, features::Features, sort::Partition,
        tuning::Tuning,
    },
};
use std::collections::{BTreeMap, HashMap};

/// Overrides that are numbers and not flags: their values are resolved.
const NUMBERS: [&str; 2] = ["NODES", "CELLS_AT_ONCE"];

/// `SpecId` of each flag, the same in every kernel.
pub(crate) fn ids() -> impl Iterator<Item = (&'static str, u32)> {
    let tuning = Tuning {
        partition: Partition::Wide,
        disc_segment: WIDE_DISC_SEGMENT,
        bucket_pairs: BUCKET_PAIRS,
        scatter_tiny: true,
        columns: false,
        kinds_apart: false,
        wide: true,
        queued: false,
        interleaved: false,
        record_form: RecordForm::Buffers,
        loaded: false,
    };
    let flags = Features::NONE.constants().into_iter().chain(tuning.constants());
    flags.map(|(name, _)| name).filter(|name| !NUMBERS.contains(name)).zip(0..)
}

// Words of SPIR-V, by its specification 1.3, section 3.
const HEADER: usize = 5;
const OP_NAME: u32 = 5;
const OP_ENTRY_POINT: u32 = 15;
const TYPES: std::ops::RangeInclusive<u32> = 19..=39;
const OP_CONSTANT_TRUE: u32 = 41;
const OP_CONSTANT_FALSE: u32 = 42;
const OP_SPEC_CONSTANT_TRUE: u32 = 48;
const OP_SPEC_CONSTANT_FALSE: u32 = 49;
const OP_VARIABLE: u32 = 59;
const OP_LOAD: u32 = 61;
const OP_DECORATE: u32 = 71;
const OP_COPY_OBJECT: u32 = 83;
const SPEC_ID: u32 = 1;

/// Private variables with these names become specialisation constants: each load becomes a copy of the
/// constant.
pub(crate) fn specialised(words: &[u32], ids: &BTreeMap<String, u32>) -> Vec<u32> {
    let mut flags = HashMap::new();
    let mut constants = HashMap::new();
    for (op, words) in instructions(words) {
        match (op, words) {
            (OP_NAME, [_, target, name @ ..]) => {
                if let Some(&id) = ids.get(&text(name)) {
                    flags.insert(*target, id);
                }
            }
            (OP_CONSTANT_TRUE | OP_CONSTANT_FALSE, [_, ty, result]) => {
                constants.insert(*result, (*ty, op == OP_CONSTANT_TRUE));
            }
            _ => {}
        }
    }
    let mut out = words[..HEADER.min(words.len())].to_vec();
    let mut is_decorated = false;
    for (op, words) in instructions(words) {
        if TYPES.contains(&op) && !is_decorated {
            is_decorated = true;
            let mut sorted: Vec<_> = flags.iter().collect();
            sorted.sort();
            for (&target, &id) in sorted {
                out.extend([4 << 16 | OP_DECORATE, target, SPEC_ID, id]);
            }
        }
        match (op, words) {
            (OP_VARIABLE, &[_, _, result, _, initial])
                if flags.contains_key(&result) && constants.contains_key(&initial) =>
            {
                let (ty, value) = constants[&initial];
                let op = if value { OP_SPEC_CONSTANT_TRUE } else { OP_SPEC_CONSTANT_FALSE };
                out.extend([3 << 16 | op, ty, result]);
            }
            (OP_LOAD, &[_, ty, result, pointer, ..]) if flags.contains_key(&pointer) => {
                out.extend([4 << 16 | OP_COPY_OBJECT, ty, result, pointer]);
            }
            // Up to its name, then variables.
            (OP_ENTRY_POINT, words) => {
                let is_last = |word: &u32| word.to_le_bytes().contains(&0);
                let name = words.iter().skip(3).position(is_last).unwrap_or(0) + 4;
                let (head, variables) = words.split_at(name.min(words.len()));
                let variables: Vec<_> =
                    variables.iter().filter(|id| !flags.contains_key(id)).collect();
                let length = (head.len() + variables.len()) as u32;
                out.push(length << 16 | OP_ENTRY_POINT);
                out.extend(head[1..].iter().chain(variables));
            }
            _ => out.extend(words),
        }
    }
    out
}

/// Instructions, each with its opcode.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let &first = rest.first()?;
        let (words, next) =
            rest.split_at_checked((first >> 16) as usize).filter(|(words, _)| !words.is_empty())?;
        rest = next;
        Some((first & 0xffff, words))
    })
}

fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes());
    bytes.take_while(|&byte| byte != 0).map(char::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn private_flags_become_specialisation_constants() {
        let name = |text: &[u8; 4]| u32::from_le_bytes(*text);
        let mut words = vec![0x0723_0203, 0x0001_0300, 0, 20, 0];
        words.extend([3 << 16 | OP_NAME, 7, name(b"ON\0\0")]);
        words.extend([3 << 16 | OP_NAME, 8, name(b"X\0\0\0")]);
        words.extend([2 << 16 | 20, 1]);
        words.extend([3 << 16 | OP_CONSTANT_TRUE, 1, 2]);
        words.extend([5 << 16 | OP_VARIABLE, 3, 7, 6, 2]);
        words.extend([5 << 16 | OP_VARIABLE, 3, 8, 6, 2]);
        words.extend([4 << 16 | OP_LOAD, 1, 9, 7]);
        words.extend([4 << 16 | OP_LOAD, 1, 10, 8]);
        let mut wanted = words[..11].to_vec();
        wanted.extend([4 << 16 | OP_DECORATE, 7, SPEC_ID, 5]);
        wanted.extend(&words[11..16]);
        wanted.extend([3 << 16 | OP_SPEC_CONSTANT_TRUE, 1, 7]);
        wanted.extend(&words[21..26]);
        wanted.extend([4 << 16 | OP_COPY_OBJECT, 1, 9, 7]);
        wanted.extend(&words[30..]);
        assert_eq!(specialised(&words, &[("ON".to_owned(), 5)].into()), wanted);
        assert_eq!(specialised(&words, &BTreeMap::new()), words);
    }

    #[test]
    fn ids_are_all_different() {
        let ids: BTreeMap<_, _> = ids().collect();
        assert!(ids.len() > 20 && ids.contains_key("HAS_GAIN") && ids.contains_key("WIDE"));
        assert!(!ids.contains_key("NODES"));
    }
}
