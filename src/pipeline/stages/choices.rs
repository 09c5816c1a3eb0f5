//! Delays and dimensions in samples, given by the scene or chosen from the signal.

use crate::analysis::delay::DelayChoice;
use crate::scene::{DelaySpec, EmbeddingSpec};

use super::clock::samples;

/// Delay and dimension of delay vectors, Eq. (25).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Embedding {
    /// Delay `tau`, samples.
    pub lag: usize,
    /// Dimension `m`.
    pub dimension: usize,
}

/// The choices with their instants. A stage that evaluates an earlier instant sees the choice of that
/// instant, independent of the frames.
#[derive(Debug, Default)]
pub struct DelayChoices {
    /// Number of samples at the choice, and the choice; only changes are stored.
    made: Vec<(u64, Embedding)>,
}

impl DelayChoices {
    /// Stores a choice made after `seen` samples.
    pub fn note(&mut self, seen: u64, choice: &DelayChoice) {
        let embedding = Embedding {
            lag: choice.lag,
            dimension: choice.dimension,
        };
        if self.made.last().is_none_or(|(_, last)| *last != embedding) {
            self.made.push((seen, embedding));
        }
    }

    /// The last choice made after at most `seen` samples.
    fn at(&self, seen: u64) -> Option<Embedding> {
        let known = self.made.partition_point(|(when, _)| *when <= seen);
        known.checked_sub(1).map(|last| self.made[last].1)
    }
}

/// Delay and dimension of a stage, each given or chosen.
#[derive(Clone, Copy, Debug)]
pub struct StageEmbedding {
    lag: Option<usize>,
    dimension: Option<usize>,
    max: Embedding,
}

impl StageEmbedding {
    /// For samples at `rate` (Hz); `delay` limits the automatic choice. A delay is rounded to whole samples,
    /// at least one.
    pub fn new(spec: &EmbeddingSpec, delay: Option<&DelaySpec>, rate: f64) -> Self {
        let lag = spec.lag.map(|lag| samples(lag, rate, 1));
        let largest_lag = delay.map_or(1, |delay| samples(delay.largest_lag, rate, 1));
        Self {
            lag,
            dimension: spec.dimension,
            max: Embedding {
                lag: lag.unwrap_or(largest_lag),
                dimension: spec
                    .dimension
                    .unwrap_or(delay.map_or(1, |delay| delay.largest_dimension)),
            },
        }
    }

    /// Largest possible delay and dimension.
    pub fn max(&self) -> Embedding {
        self.max
    }

    /// Delay and dimension after `seen` samples; `None` until both are known.
    pub fn at(&self, seen: u64, choices: &DelayChoices) -> Option<Embedding> {
        match (self.lag, self.dimension) {
            (Some(lag), Some(dimension)) => Some(Embedding { lag, dimension }),
            (lag, dimension) => choices.at(seen).map(|chosen| Embedding {
                lag: lag.unwrap_or(chosen.lag),
                dimension: dimension.unwrap_or(chosen.dimension),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::delay::{FalseNeighbours, LagReason, MutualInformation};

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
                evaluated: Vec::new(),
            },
        }
    }

    #[test]
    fn a_choice_applies_from_its_instant_to_the_next() {
        let mut choices = DelayChoices::default();
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
    fn given_values_are_not_replaced_by_a_choice() {
        let mut choices = DelayChoices::default();
        let spec = |lag, dimension| EmbeddingSpec { lag, dimension };
        let given = spec(Some(60e-6), Some(5));
        let given = StageEmbedding::new(&given, None, 200e3).at(0, &choices);
        assert_eq!(
            given,
            Some(Embedding {
                lag: 12,
                dimension: 5
            })
        );
        let half = spec(None, Some(5));
        let half = StageEmbedding::new(&half, None, 200e3);
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
