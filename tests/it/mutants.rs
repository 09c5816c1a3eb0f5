//! Damaged copies of a file, as from faulty disks, broken transfers or attackers. A seed always gives the
//! same damage.

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Half of the damage is within this many bytes of the start, where headers are.
const HEAD: usize = 512;

/// Number of damaged copies of a test; `SQUEAKSCOPE_MUTANTS` overrides it for a long search.
pub fn count(usual: usize) -> usize {
    let asked = std::env::var("SQUEAKSCOPE_MUTANTS").ok();
    asked.and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// A damaged copy.
pub struct Mutant {
    /// Content of the damaged file.
    pub bytes: Vec<u8>,
    /// Description of the damage, for failure messages.
    pub damage: String,
}

/// An endless series of damaged copies of `original`.
pub fn mutants(original: &[u8], seed: u64) -> impl Iterator<Item = Mutant> {
    damaged(original, seed, damage)
}

/// An endless series of damaged copies of a text. Half of the damage is to tokens, the other half to bytes.
pub fn text_mutants(original: &[u8], seed: u64) -> impl Iterator<Item = Mutant> {
    damaged(original, seed, |text, random| match random.random() {
        true => damage_tokens(text, random),
        false => damage(text, random),
    })
}

/// Damages bytes in one place, and returns a description.
type Damage = fn(&mut Vec<u8>, &mut ChaCha8Rng) -> String;

fn damaged(original: &[u8], seed: u64, damage: Damage) -> impl Iterator<Item = Mutant> {
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

/// Damages arbitrary bytes.
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
            // Binary fields are usually aligned.
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

/// A wrong value for a length field.
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

/// Removes or repeats the bytes of one place, or copies them over another.
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

/// Numbers at the limits of all types, and invalid numbers.
const EXTREMES: [&str; 16] = [
    "0",
    "-0",
    "-1",
    "1e308",
    "-1e308",
    "5e-324",
    "1e999999999",
    "nan",
    "-inf",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "0.1e",
    "0x7fffffffffffffff",
    "1_000_000_000_000",
];

/// Text that ends, nests or hides other text.
const SCRAPS: [&str; 22] = [
    "[",
    "]",
    "{",
    "}",
    "(",
    ")",
    "\"",
    "'",
    "\"\"\"",
    "`",
    "\n",
    "\r\n",
    "\r",
    "\0",
    ",",
    ";",
    "=",
    "#",
    "\\",
    "\\u0000",
    "\u{1b}[2J",
    "\u{202e}",
];

/// Damages a text in one place: removes, repeats or swaps tokens, replaces a number, inserts text.
fn damage_tokens(text: &mut Vec<u8>, random: &mut ChaCha8Rng) -> String {
    let tokens = tokens(text);
    let token = tokens[random.random_range(0..tokens.len())].clone();
    match random.random_range(0..6) {
        0 => {
            text.drain(token.clone());
            format!("token {token:?} removed")
        }
        1 => {
            let times = 1 << random.random_range(0..8);
            let part = text[token.clone()].repeat(times);
            text.splice(token.start..token.start, part);
            format!("token {token:?} repeated {times} times")
        }
        2 => {
            let other = tokens[random.random_range(0..tokens.len())].clone();
            swap(text, token, other)
        }
        3..5 => {
            let is_number = |token: &&Range<usize>| text[token.start].is_ascii_digit();
            let numbers: Vec<&Range<usize>> = tokens.iter().filter(is_number).collect();
            let number = match numbers.len() {
                0 => token,
                count => numbers[random.random_range(0..count)].clone(),
            };
            let extreme = EXTREMES[random.random_range(0..EXTREMES.len())];
            text.splice(number.clone(), extreme.bytes());
            format!("{extreme} at token {number:?}")
        }
        _ => {
            let scrap = SCRAPS[random.random_range(0..SCRAPS.len())];
            text.splice(token.start..token.start, scrap.bytes());
            format!("{scrap:?} before token {token:?}")
        }
    }
}

/// Words and numbers, and every other byte as a token.
fn tokens(text: &[u8]) -> Vec<Range<usize>> {
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"_.-+".contains(byte);
    let mut tokens: Vec<Range<usize>> = Vec::new();
    for (at, byte) in text.iter().enumerate() {
        match tokens.last_mut() {
            Some(last) if is_word(byte) && is_word(&text[last.start]) => last.end = at + 1,
            _ => tokens.push(at..at + 1),
        }
    }
    tokens
}

/// Swaps two tokens.
fn swap(text: &mut Vec<u8>, one: Range<usize>, other: Range<usize>) -> String {
    let (first, second) = match one.start <= other.start {
        true => (one, other),
        false => (other, one),
    };
    let [a, b] = [&first, &second].map(|token| text[token.clone()].to_vec());
    // The later one first, so that the earlier indices stay valid.
    text.splice(second.clone(), a);
    text.splice(first.clone(), b);
    format!("tokens {first:?} and {second:?} swapped")
}

#[test]
fn a_seed_gives_the_same_damage_and_the_copies_differ() {
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

#[test]
fn tokens_cover_the_text_and_their_damage_is_reproducible() {
    let text = b"[load]\nload_n = 150.5e-3 # N\n";
    let tokens = tokens(text);
    assert!(tokens.windows(2).all(|pair| pair[0].end == pair[1].start));
    assert_eq!(tokens.last().map(|last| last.end), Some(text.len()));
    assert!(
        tokens
            .iter()
            .any(|token| &text[token.clone()] == b"150.5e-3")
    );
    let mut swapped = text.to_vec();
    swap(&mut swapped, 14..22, 1..5);
    swap(&mut swapped, 1..5, 1..5);
    assert_eq!(swapped.len(), text.len());
    let some = |seed| -> Vec<Vec<u8>> {
        let all = text_mutants(text, seed);
        all.take(200).map(|mutant| mutant.bytes).collect()
    };
    assert_eq!(some(1), some(1));
    assert_ne!(some(1), some(2));
}
