//! Bit masks in 64-bit words.

use super::states::WORD;

/// Bit `k`; zero after the end.
pub(super) fn bit(mask: &[u64], k: usize) -> bool {
    word(mask, k / WORD) >> (k % WORD) & 1 == 1
}

/// Word `w`; zero after the end.
pub(super) fn word(mask: &[u64], w: usize) -> u64 {
    mask.get(w).copied().unwrap_or(0)
}

/// Word `w` of the mask shifted by one bit: its bit `k` is bit `k - 1` of `mask`.
pub(super) fn word_before(mask: &[u64], w: usize) -> u64 {
    let carry = w.checked_sub(1).map_or(0, |w| word(mask, w) >> (WORD - 1));
    word(mask, w) << 1 | carry
}

/// Word `w` of the mask shifted by one bit: its bit `k` is bit `k + 1` of `mask`.
pub(super) fn word_after(mask: &[u64], w: usize) -> u64 {
    word(mask, w) >> 1 | word(mask, w + 1) << (WORD - 1)
}

/// Positions of the set bits in word `w` of a mask.
pub(super) fn ones(w: usize, mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let k = w * WORD + word.trailing_zeros() as usize;
        let one = word != 0;
        word &= word.wrapping_sub(1);
        one.then_some(k)
    })
}

/// Runs of set bits as (start, end), with `end` exclusive.
pub(super) fn runs(words: impl Iterator<Item = u64>) -> impl Iterator<Item = (usize, usize)> {
    let mut begin = None;
    let mut last = false;
    let changes = words.chain([0]).enumerate().flat_map(move |(w, word)| {
        let changed = word ^ (word << 1 | u64::from(last));
        last = word >> (WORD - 1) == 1;
        ones(w, changed)
    });
    changes.filter_map(move |k| match begin.take() {
        Some(begin) => Some((begin, k)),
        None => {
            begin = Some(k);
            None
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cross_words_and_reach_the_end() {
        let found = |words: &[u64]| runs(words.iter().copied()).collect::<Vec<_>>();
        assert_eq!(found(&[]), []);
        assert_eq!(found(&[0b1_0110]), [(1, 3), (4, 5)]);
        assert_eq!(found(&[1 << 63, 1]), [(63, 65)]);
        assert_eq!(found(&[u64::MAX, u64::MAX]), [(0, 128)]);
        assert_eq!(found(&[1 << 63, 0, 3 << 62]), [(63, 64), (190, 192)]);
    }

    #[test]
    fn neighbouring_bits_cross_words() {
        let mask = [1 << 63 | 1, 1];
        let all = |of: fn(&[u64], usize) -> u64| [of(&mask, 0), of(&mask, 1), of(&mask, 2)];
        assert_eq!(all(word_before), [2, 3, 0]);
        assert_eq!(all(word_after), [3 << 62, 0, 0]);
        assert!(bit(&mask, 64) && !bit(&mask, 65) && !bit(&mask, 500));
    }
}
