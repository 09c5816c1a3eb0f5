//! Damaged copies of a file: what disks, transfers and strangers make of it. The same seed gives the
//! same damage in every run.

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Half of all damage is within so many bytes of the start, where headers are.
const HEAD: usize = 512;

/// How many damaged copies a test takes: as many as `SQUEAKSCOPE_MUTANTS` says, for a long search.
pub fn count(usual: usize) -> usize {
    let asked = std::env::var("SQUEAKSCOPE_MUTANTS").ok();
    asked.and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// A damaged copy.
pub struct Mutant {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// What was done, to be printed where it breaks something.
    pub damage: String,
}

/// Damaged copies of `original`, without end.
pub fn mutants(original: &[u8], seed: u64) -> impl Iterator<Item = Mutant> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    std::iter::repeat_with(move || {
        let mut bytes = original.to_vec();
        let count = random.random_range(1..4);
        let damage: Vec<String> = (0..count)
            .map_while(|_| (!bytes.is_empty()).then(|| damage(&mut bytes, &mut random)))
            .collect();
        Mutant {
            bytes,
            damage: damage.join(", "),
        }
    })
}

/// Damages bytes in one place, and says how.
fn damage(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) -> String {
    let at = match random.random() {
        true => random.random_range(0..bytes.len().min(HEAD)),
        false => random.random_range(0..bytes.len()),
    };
    let length = 1 << random.random_range(0..12);
    let range = at..bytes.len().min(at + length);
    match random.random_range(0..8) {
        0..3 => {
            let bit = random.random_range(0..8);
            bytes[at] ^= 1 << bit;
            format!("bit {bit} of byte {at} flipped")
        }
        3..5 => {
            let claim = claim(bytes.len() as u64, random);
            let width = if random.random() { 4 } else { 8 };
            // Fields are mostly aligned.
            let at = if random.random() { at / 8 * 8 } else { at };
            let field = at..bytes.len().min(at + width);
            bytes[field.clone()].copy_from_slice(&claim.to_le_bytes()[..field.len()]);
            format!("{claim:#x} at bytes {field:?}")
        }
        5 => {
            bytes.truncate(at);
            format!("cut at {at}")
        }
        6 => {
            bytes[range.clone()].fill(0);
            format!("zeros at bytes {range:?}")
        }
        _ => moved(bytes, range, random),
    }
}

/// What a field of a length may claim that is not so.
fn claim(length: u64, random: &mut ChaCha8Rng) -> u64 {
    let claims = [
        0,
        1,
        u64::MAX,
        i64::MAX as u64,
        1 << 63,
        1 << random.random_range(0..64),
        u64::from(u32::MAX),
        i32::MAX as u64,
        length,
        length + 1,
        random.random(),
    ];
    claims[random.random_range(0..claims.len())]
}

/// Bytes of one place removed, repeated, or put over those of another.
fn moved(bytes: &mut Vec<u8>, from: Range<usize>, random: &mut ChaCha8Rng) -> String {
    let part = bytes[from.clone()].to_vec();
    let to = random.random_range(0..=bytes.len() - part.len());
    match random.random_range(0..3) {
        0 => {
            bytes.drain(from.clone());
            format!("bytes {from:?} removed")
        }
        1 => {
            bytes.splice(from.start..from.start, part);
            format!("bytes {from:?} repeated")
        }
        _ => {
            bytes[to..to + part.len()].copy_from_slice(&part);
            format!("bytes {from:?} put at {to}")
        }
    }
}

#[test]
fn a_seed_gives_the_same_damage_and_each_copy_another() {
    let original: Vec<u8> = (0..4000_u32).map(|k| (k % 251) as u8).collect();
    let some = |seed| -> Vec<Vec<u8>> {
        let all = mutants(&original, seed);
        all.take(200).map(|mutant| mutant.bytes).collect()
    };
    let first = some(1);
    assert_eq!(first, some(1));
    assert_ne!(first, some(2));
    let changed = first.iter().filter(|bytes| **bytes != original).count();
    assert!(changed > 180, "{changed}");
}
