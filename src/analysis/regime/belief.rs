//! Combination of evidence by Dempster's rule (G. Shafer, A Mathematical Theory of Evidence, Princeton
//! 1976, chapters 3 and 4).
//!
//! Evidence for a set of regimes with weight `w` assigns the belief mass `w` to that set as a whole and
//! leaves `1 - w` unassigned. Two pieces of evidence assign the product of their masses to the
//! intersection of their sets. The mass of empty intersections is the conflict; the rest is normalised
//! to 1. Agreeing pieces support each other (`1 - (1 - w1)(1 - w2)`), contradicting pieces weaken each
//! other, and a piece can support `chaos or noise` without a choice between them.

use super::Regime;

/// Regimes that evidence can support, one bit of a set each.
pub(super) const REGIMES: [Regime; 5] = [
    Regime::Transient,
    Regime::Periodic,
    Regime::QuasiPeriodic,
    Regime::Chaotic,
    Regime::Noise,
];

const SETS: usize = 1 << REGIMES.len();

/// Belief masses of the sets of regimes.
#[derive(Clone, Debug)]
pub(super) struct Belief {
    share: [f64; SETS],
    /// Share of all mass that contradicting pieces have not lost.
    agreement: f64,
}

impl Belief {
    /// All mass unassigned.
    pub(super) fn vacuous() -> Self {
        let mut share = [0.0; SETS];
        share[SETS - 1] = 1.0;
        Self {
            share,
            agreement: 1.0,
        }
    }

    /// Combines evidence of weight 0 to 1 (not 1 for two disjoint sets) for one of `regimes`.
    pub(super) fn combine(&mut self, regimes: &[Regime], weight: f64) {
        let member = |regime| usize::from(regimes.contains(regime));
        let numbered = REGIMES.iter().enumerate();
        let set = numbered.fold(0, |set, (bit, regime)| set | member(regime) << bit);
        let mut combined = self.share.map(|share| share * (1.0 - weight));
        for (other, share) in self.share.iter().enumerate() {
            combined[other & set] += share * weight;
        }
        combined[0] = 0.0;
        let agreed: f64 = combined.iter().sum();
        if agreed > 0.0 {
            self.share = combined.map(|share| share / agreed);
            self.agreement *= agreed;
        }
    }

    /// The regime with the largest mass of its own, and that mass; the first of equals.
    pub(super) fn strongest(&self) -> (Regime, f64) {
        let alone = |bit: usize| self.share[1 << bit];
        let best = (0..REGIMES.len()).fold(0, |a, b| if alone(b) > alone(a) { b } else { a });
        (REGIMES[best], alone(best))
    }

    /// Whether contradictions have cost more than half of all mass.
    pub(super) fn is_contradictory(&self) -> bool {
        self.agreement < 0.5
    }

    /// The two likeliest regimes, likeliest first, if the mass of each set is divided equally between its
    /// members (P. Smets and R. Kennes, Artif. Intell. 66, 191, 1994); only those that are likelier than without
    /// any evidence.
    pub(super) fn likeliest(&self) -> Vec<Regime> {
        let divided = |bit: usize| {
            let sets = (1..SETS).filter(|set| set >> bit & 1 == 1);
            let part = |set: usize| self.share[set] / f64::from(set.count_ones());
            sets.map(part).sum::<f64>()
        };
        let mut all: Vec<(f64, Regime)> = (0..REGIMES.len())
            .map(|bit| (divided(bit), REGIMES[bit]))
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let likelier = all
            .iter()
            .filter(|(mass, _)| *mass > 1.001 / REGIMES.len() as f64);
        likelier.take(2).map(|(_, regime)| *regime).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Regime::{Chaotic, Noise, Periodic, QuasiPeriodic};

    #[test]
    fn agreement_strengthens_and_conflict_weakens() {
        let mut belief = Belief::vacuous();
        assert_eq!(belief.strongest().1, 0.0);
        assert!(belief.likeliest().is_empty());
        belief.combine(&[Chaotic], 0.5);
        belief.combine(&[Chaotic], 0.5);
        assert_eq!(belief.strongest(), (Chaotic, 0.75));
        assert_eq!(belief.likeliest(), [Chaotic]);
        assert!(!belief.is_contradictory());
        // 0.75 (1 - 0.6) of 1 - 0.75 * 0.6.
        belief.combine(&[Periodic], 0.6);
        let (regime, share) = belief.strongest();
        assert!(regime == Chaotic && (share - 0.3 / 0.55).abs() < 1e-12);
        assert_eq!(belief.likeliest(), [Chaotic, Periodic]);
        belief.combine(&[Noise], 0.5);
        assert!(belief.is_contradictory());
    }

    #[test]
    fn two_sets_support_their_intersection() {
        let mut belief = Belief::vacuous();
        belief.combine(&[Chaotic, Noise], 0.8);
        assert_eq!(belief.strongest().1, 0.0);
        belief.combine(&[Periodic, QuasiPeriodic, Chaotic], 0.5);
        let (regime, share) = belief.strongest();
        assert!(regime == Chaotic && (share - 0.4).abs() < 1e-12);
        // The order does not matter.
        let mut other = Belief::vacuous();
        other.combine(&[Periodic, QuasiPeriodic, Chaotic], 0.5);
        other.combine(&[Chaotic, Noise], 0.8);
        assert!((other.strongest().1 - share).abs() < 1e-15);
    }
}
