//! Evidence joined: Dempster's rule (G. Shafer, A Mathematical Theory of Evidence, Princeton
//! 1976, chapters 3 and 4).
//!
//! A piece of evidence that speaks for a set of kinds with weight `w` commits the share `w` of
//! all belief to that set, undivided, and leaves `1 - w` to no set in particular. Two pieces
//! together commit the product of their shares to what both sets have in common; what falls on
//! nothing in common is the conflict, and the rest is scaled up to 1. Pieces that agree support
//! each other (`1 - (1 - w1)(1 - w2)`), pieces that contradict weaken each other, and a piece may
//! say `chaos or noise` without saying which.

use super::Regime;

/// The kinds that evidence can be for, each a bit of a set.
pub(super) const KINDS: [Regime; 5] = [
    Regime::Transient,
    Regime::Periodic,
    Regime::QuasiPeriodic,
    Regime::Chaotic,
    Regime::Noise,
];

const SETS: usize = 1 << KINDS.len();

/// How belief is shared out among the sets of kinds.
#[derive(Clone, Debug)]
pub(super) struct Belief {
    share: [f64; SETS],
}

impl Belief {
    /// Nothing known.
    pub(super) fn open() -> Self {
        let mut share = [0.0; SETS];
        share[SETS - 1] = 1.0;
        Self { share }
    }

    /// Takes in evidence of weight 0 to 1 (not 1 for two disjoint sets) for one of `kinds`.
    pub(super) fn join(&mut self, kinds: &[Regime], weight: f64) {
        let member = |kind| usize::from(kinds.contains(kind));
        let places = KINDS.iter().enumerate();
        let set = places.fold(0, |set, (bit, kind)| set | member(kind) << bit);
        let mut joined = self.share.map(|share| share * (1.0 - weight));
        for (other, share) in self.share.iter().enumerate() {
            joined[other & set] += share * weight;
        }
        joined[0] = 0.0;
        let agreed: f64 = joined.iter().sum();
        if agreed > 0.0 {
            self.share = joined.map(|share| share / agreed);
        }
    }

    /// The kind with the largest share committed to it alone, and that share; the first of
    /// equals.
    pub(super) fn strongest(&self) -> (Regime, f64) {
        let alone = |bit: usize| self.share[1 << bit];
        let best = (0..KINDS.len()).fold(0, |a, b| if alone(b) > alone(a) { b } else { a });
        (KINDS[best], alone(best))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Regime::{Chaotic, Noise, Periodic, QuasiPeriodic};

    #[test]
    fn agreement_strengthens_and_conflict_weakens() {
        let mut belief = Belief::open();
        assert_eq!(belief.strongest().1, 0.0);
        belief.join(&[Chaotic], 0.5);
        belief.join(&[Chaotic], 0.5);
        assert_eq!(belief.strongest(), (Chaotic, 0.75));
        // 0.75 (1 - 0.6) of 1 - 0.75 * 0.6.
        belief.join(&[Periodic], 0.6);
        let (kind, share) = belief.strongest();
        assert!(kind == Chaotic && (share - 0.3 / 0.55).abs() < 1e-12);
    }

    #[test]
    fn two_sets_point_at_what_they_share() {
        let mut belief = Belief::open();
        belief.join(&[Chaotic, Noise], 0.8);
        assert_eq!(belief.strongest().1, 0.0);
        belief.join(&[Periodic, QuasiPeriodic, Chaotic], 0.5);
        let (kind, share) = belief.strongest();
        assert!(kind == Chaotic && (share - 0.4).abs() < 1e-12);
        // The order does not matter.
        let mut other = Belief::open();
        other.join(&[Periodic, QuasiPeriodic, Chaotic], 0.5);
        other.join(&[Chaotic, Noise], 0.8);
        assert!((other.strongest().1 - share).abs() < 1e-15);
    }
}
