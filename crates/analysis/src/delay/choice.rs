//! Choice of lag and embedding dimension from the signal.
//!
//! The lag comes first, from the mutual information: long enough for the coordinates to be nearly
//! independent. The dimension follows from the false neighbours at that lag: large enough to unfold the
//! attractor (H. D. I. Abarbanel et al., Rev. Mod. Phys. 65, 1331, 1993, describe both).

use super::{
    FalseNeighbourSearch, FalseNeighbours, MutualInformation, false_neighbours, mutual_information,
};
use crate::AnalysisError;

use schemars::JsonSchema;
use serde::Serialize;

/// Lags per mean period: the first minimum of the mutual information is at about a quarter period. The Theiler window is
/// one mean period, as M. T. Rosenstein, J. J. Collins and C. J. De Luca (Physica D 65, 117, 1993) advise.
pub(crate) const LAGS_PER_PERIOD: usize = 4;

/// Limits of the search for lag and dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelaySearch {
    /// Largest lag tried, samples.
    pub largest_lag: usize,
    /// Bins per axis of the joint histogram.
    pub bins: usize,
    /// Largest dimension tried.
    pub largest_dimension: usize,
    /// Share of false neighbours that counts as none, 0 to 1.
    pub false_share: f64,
}

impl DelaySearch {
    /// Limits suited to `count` samples: lags up to `count / 25` (at most 500), dimensions up to 10, at
    /// most 1 % of false neighbours, and a Theiler window of four lags.
    ///
    /// The histogram has 64 bins from 50,000 samples on. For fewer samples the number of bins keeps the
    /// bias of the mutual information, about `(bins - 1)^2 / (2 N ln 2)`, at 0.06 bit, with at least 8
    /// bins.
    pub fn for_samples(count: usize) -> Self {
        let bins = 1.0 + 63.0 * (count as f64 / 50_000.0).sqrt();
        Self {
            largest_lag: (count / 25).clamp(1, 500),
            bins: (bins as usize).clamp(8, 64),
            largest_dimension: 10,
            false_share: 0.01,
        }
    }
}

/// Criterion that determined the lag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub enum LagReason {
    /// First clear minimum of the mutual information.
    #[serde(rename = "first minimum")]
    FirstMinimum,
    /// No minimum: the first lag below 1/e of the value at lag 0.
    #[serde(rename = "first decay")]
    FirstDecay,
    /// No minimum and no decay: the largest lag tried.
    #[serde(rename = "largest")]
    Largest,
}

/// Lag, dimension and the curves from which they are chosen (Fig. 8).
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DelayChoice {
    /// Lag, samples.
    #[serde(rename = "lag_samples")]
    pub lag: usize,
    /// Criterion that determined the lag.
    #[serde(rename = "lag_reason")]
    pub reason: LagReason,
    /// Embedding dimension.
    pub dimension: usize,
    /// Whether the share of false neighbours falls below the limit at this dimension. If not, the
    /// dimension is the one with the smallest share.
    pub unfolded: bool,
    /// Theiler window used, samples.
    #[serde(rename = "theiler_samples")]
    pub theiler: usize,
    /// Mutual information by lag.
    #[serde(rename = "mutual_information")]
    pub mutual: MutualInformation,
    /// False neighbours by dimension, at the chosen lag.
    #[serde(rename = "false_neighbours")]
    pub neighbours: FalseNeighbours,
}

/// Chooses lag and embedding dimension.
///
/// The lag is the first clear minimum of the [`mutual_information`]
/// ([`MutualInformation::first_clear_minimum`]). Without one it is the first lag below 1/e of the value
/// at lag 0, else the largest lag tried. The dimension is the smallest with a share of
/// [`false_neighbours`] (limits 15 and 2) of at most [`DelaySearch::false_share`]. Noise never falls
/// below that limit; [`DelayChoice::unfolded`] is then false. A constant signal gives one dimension and
/// the largest lag.
///
/// # Errors
/// [`AnalysisError::InvalidDelay`] for a largest lag or dimension of 0; [`AnalysisError::Bins`];
/// [`AnalysisError::TooShort`] if the samples do not suffice for the largest lag, or for the largest
/// dimension at the chosen lag.
pub fn choose_delay(samples: &[f64], search: &DelaySearch) -> Result<DelayChoice, AnalysisError> {
    let mutual = mutual_information(samples, search.largest_lag, search.bins)?;
    let (lag, reason) = mutual.lag();
    let theiler = LAGS_PER_PERIOD * lag;
    let neighbours = false_neighbours(
        samples,
        &FalseNeighbourSearch::new(lag, search.largest_dimension, theiler),
    )?;
    let unfolds_at = neighbours.dimension(search.false_share);
    let least_false = || {
        let places = (1..).zip(&neighbours.share);
        let least = places.min_by(|a, b| a.1.total_cmp(b.1));
        least.map_or(1, |(dimension, _)| dimension)
    };
    let dimension = unfolds_at.unwrap_or_else(least_false);
    Ok(DelayChoice {
        lag,
        reason,
        dimension,
        unfolded: unfolds_at.is_some(),
        theiler,
        mutual,
        neighbours,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};

    fn choose(samples: &[f64]) -> DelayChoice {
        choose_delay(samples, &DelaySearch::for_samples(samples.len())).unwrap()
    }

    #[test]
    fn chaos_unfolds_at_the_known_lag_and_dimension() {
        let x = coordinate(&lorenz(50_000, 0.01, [1.0, 1.0, 1.0]), 0);
        let choice = choose(&x);
        assert_eq!(
            (choice.lag, choice.dimension, choice.unfolded),
            (16, 3, true)
        );
        assert_eq!(choice.reason, LagReason::FirstMinimum);
        assert_eq!(choice.theiler, 64);
        assert_eq!(choice.mutual.bits.len(), 501);
        assert_eq!(choice.neighbours.share.len(), 10);

        let x = coordinate(&roessler(20_000, 0.1, [0.2, 0.2, 5.7], [1.0, 1.0, 0.0]), 0);
        let choice = choose(&x);
        assert!((12..=16).contains(&choice.lag), "{}", choice.lag);
        assert!((3..=5).contains(&choice.dimension) && choice.unfolded);
    }

    #[test]
    fn chaos_unfolds_at_any_sampling_rate() {
        for (dt, count) in [(0.1, 2000), (0.05, 4000), (0.02, 8000)] {
            let x = coordinate(&lorenz(count, dt, [1.0, 1.0, 1.0]), 0);
            let choice = choose(&x);
            let lag = choice.lag as f64 * dt;
            assert!((0.14..0.26).contains(&lag), "{dt}: {}", choice.lag);
            assert!(choice.unfolded && choice.dimension == 3, "{dt}: {choice:?}");
        }
    }

    #[test]
    fn a_tone_is_a_closed_curve_and_two_are_a_torus() {
        for period in [12.0, 12.34, 40.5, 162.1] {
            let choice = choose(&sines(period, 8000, &[(1.0, 1.0, 0.3)]));
            let quarters = choice.lag as f64 / (0.25 * period);
            assert!((0.4..1.4).contains(&quarters), "{period}: {}", choice.lag);
            assert_eq!((choice.dimension, choice.unfolded), (2, true), "{period}");
        }
        let choice = choose(&sines(
            50.0,
            8000,
            &[(1.0, 1.0, 0.3), (2.0_f64.sqrt(), 0.5, 0.3)],
        ));
        assert!((3..=4).contains(&choice.dimension) && choice.unfolded);
    }

    #[test]
    fn noise_never_unfolds() {
        for seed in 0..3 {
            let choice = choose(&noise(seed, 4000, 1.0));
            assert!(!choice.unfolded);
            let share = choice.neighbours.share[choice.dimension - 1];
            assert!(choice.neighbours.share.iter().all(|&other| other >= share));
        }
    }

    #[test]
    fn the_lag_falls_back_to_the_decay_and_then_to_the_largest() {
        // The period is far longer than the largest lag: the information only decreases.
        let slow = sines(1000.0, 4000, &[(1.0, 1.0, 0.3)]);
        let search = |largest_lag| DelaySearch {
            largest_lag,
            largest_dimension: 2,
            ..DelaySearch::for_samples(slow.len())
        };
        let choice = choose_delay(&slow, &search(3)).unwrap();
        assert_eq!((choice.reason, choice.lag), (LagReason::Largest, 3));

        // The correlation of a random walk decays slowly and does not recur.
        let mut walk = noise(1, 4000, 1.0);
        for n in 1..walk.len() {
            walk[n] += 0.9 * walk[n - 1];
        }
        let choice = choose_delay(&walk, &search(8)).unwrap();
        assert_eq!(choice.reason, LagReason::FirstDecay);
        let limit = choice.mutual.bits[0] / std::f64::consts::E;
        assert!(choice.mutual.bits[choice.lag] < limit);
        assert!(choice.mutual.bits[choice.lag - 1] >= limit);
    }

    #[test]
    fn a_constant_signal_needs_one_dimension() {
        let choice = choose(&[0.7; 1000]);
        assert_eq!((choice.lag, choice.reason), (40, LagReason::Largest));
        assert_eq!((choice.dimension, choice.unfolded), (1, true));
    }

    #[test]
    fn the_default_search_fits_the_samples() {
        for count in [30, 31, 50, 100, 333, 1000, 100_000] {
            let search = DelaySearch::for_samples(count);
            // The bound holds for any chosen lag.
            let lag = search.largest_lag;
            let need = lag * search.largest_dimension + 4 * lag + 1;
            assert!(need <= count, "{count}: {need}");
        }
        assert!(choose_delay(&[1.0; 10], &DelaySearch::for_samples(10)).is_err());
        let search = DelaySearch::for_samples(100);
        for (largest_lag, largest_dimension) in [(0, 3), (4, 0)] {
            let search = DelaySearch {
                largest_lag,
                largest_dimension,
                ..search
            };
            assert!(choose_delay(&[1.0; 100], &search).is_err());
        }
    }
}
