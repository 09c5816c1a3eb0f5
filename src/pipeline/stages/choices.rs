//! Delays and dimensions in samples: those that a scene gives, and those that the signal chose.

use crate::analysis::DelayChoice;
use crate::scene::{DelaySpec, EmbeddingSpec, Setting};

use super::clock::samples;

/// Delay and dimension of delay vectors, Eq. (25).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Embedding {
    /// Delay `tau`, samples.
    pub lag: usize,
    /// Dimension `m`.
    pub dimension: usize,
}

/// What was chosen, and when: stages that look later than others still see what was known at
/// their instant, whatever the frames.
#[derive(Debug, Default)]
pub struct Choices {
    /// How many samples had been seen, and what was chosen then; only changes are kept.
    made: Vec<(u64, Embedding)>,
}

impl Choices {
    /// Notes a choice made when `seen` samples had been seen.
    pub fn note(&mut self, seen: u64, choice: &DelayChoice) {
        let embedding = Embedding {
            lag: choice.lag,
            dimension: choice.dimension,
        };
        if self.made.last().is_none_or(|(_, last)| *last != embedding) {
            self.made.push((seen, embedding));
        }
    }

    /// The last choice made by the time when `seen` samples had been seen.
    fn at(&self, seen: u64) -> Option<Embedding> {
        let known = self.made.partition_point(|(when, _)| *when <= seen);
        known.checked_sub(1).map(|last| self.made[last].1)
    }
}

/// Delay and dimension of a stage, each given or chosen.
#[derive(Clone, Copy, Debug)]
pub struct Unfolding {
    lag: Setting<usize>,
    dimension: Setting<usize>,
    most: Embedding,
}

impl Unfolding {
    /// For samples at `rate` (Hz); `delay` bounds what can be chosen. A delay is rounded to whole
    /// samples, one at least.
    pub fn new(spec: &EmbeddingSpec, delay: Option<&DelaySpec>, rate: f64) -> Self {
        let lag = spec.lag.map(|lag| samples(lag, rate, 1));
        let largest_lag = delay.map_or(1, |delay| samples(delay.largest_lag, rate, 1));
        Self {
            lag,
            dimension: spec.dimension,
            most: Embedding {
                lag: lag.or(largest_lag),
                dimension: spec
                    .dimension
                    .or(delay.map_or(1, |delay| delay.largest_dimension)),
            },
        }
    }

    /// The longest delay and largest dimension that there can be.
    pub fn most(&self) -> Embedding {
        self.most
    }

    /// What holds when `seen` samples have been seen; `None` as long as something is yet to be
    /// chosen.
    pub fn at(&self, seen: u64, choices: &Choices) -> Option<Embedding> {
        match (self.lag, self.dimension) {
            (Setting::Given(lag), Setting::Given(dimension)) => Some(Embedding { lag, dimension }),
            (lag, dimension) => choices.at(seen).map(|chosen| Embedding {
                lag: lag.or(chosen.lag),
                dimension: dimension.or(chosen.dimension),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{FalseNeighbours, LagReason, MutualInformation};

    fn choice(lag: usize, dimension: usize) -> DelayChoice {
        DelayChoice {
            lag,
            reason: LagReason::FirstMinimum,
            dimension,
            unfolded: true,
            theiler: 1,
            mutual: MutualInformation {
                bins: 2,
                bits: Vec::new(),
            },
            neighbours: FalseNeighbours {
                lag,
                share: Vec::new(),
                judged: Vec::new(),
            },
        }
    }

    #[test]
    fn a_choice_holds_from_its_instant_until_the_next() {
        let mut choices = Choices::default();
        choices.note(100, &choice(7, 3));
        choices.note(200, &choice(7, 3));
        choices.note(300, &choice(9, 4));
        assert_eq!(choices.made.len(), 2);
        let lag = |seen| choices.at(seen).map(|embedding| embedding.lag);
        assert_eq!(
            [lag(99), lag(100), lag(299), lag(300)],
            [None, Some(7), Some(7), Some(9)]
        );
    }

    #[test]
    fn what_is_given_is_not_chosen() {
        let mut choices = Choices::default();
        let spec = |lag, dimension| EmbeddingSpec { lag, dimension };
        let given = spec(Setting::Given(60e-6), Setting::Given(5));
        let given = Unfolding::new(&given, None, 200e3).at(0, &choices);
        assert_eq!(
            given,
            Some(Embedding {
                lag: 12,
                dimension: 5
            })
        );
        let half = spec(Setting::Auto, Setting::Given(5));
        let half = Unfolding::new(&half, None, 200e3);
        assert_eq!(half.at(10, &choices), None);
        choices.note(10, &choice(7, 3));
        assert_eq!(
            half.at(10, &choices),
            Some(Embedding {
                lag: 7,
                dimension: 5
            })
        );
    }
}
