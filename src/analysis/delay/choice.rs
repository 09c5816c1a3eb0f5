//! Lag and dimension chosen from the signal itself.
//!
//! The lag comes first, from the mutual information: long enough for a coordinate to say
//! something new. Then the dimension, from the false neighbours at that lag: large enough for the
//! attractor not to be seen in projection (H. D. I. Abarbanel et al., Rev. Mod. Phys. 65, 1331,
//! 1993, describe the two together).

use super::{
    FalseNeighbourSearch, FalseNeighbours, MutualInformation, false_neighbours, mutual_information,
};
use crate::analysis::AnalysisError;

use serde::{Deserialize, Serialize};

/// Lags in the Theiler window that is chosen.
const LAGS_APART: usize = 4;

/// How lag and dimension are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelaySearch {
    /// The largest lag tried, samples.
    pub largest_lag: usize,
    /// Bins along an axis of the joint histogram.
    pub bins: usize,
    /// The largest dimension tried.
    pub largest_dimension: usize,
    /// Share of false neighbours that is none, 0 to 1.
    pub false_share: f64,
    /// Pairs closer in time than this many samples are no neighbours; `None`: four lags. The
    /// first minimum of the mutual information lies about a quarter of a period away, so this
    /// leaves out about one mean period, as M. T. Rosenstein, J. J. Collins and C. J. De Luca
    /// (Physica D 65, 117, 1993) advise.
    pub theiler: Option<usize>,
}

impl DelaySearch {
    /// A search that `count` samples allow: lags up to a 25th of them (at most 500),
    /// dimensions up to 10, at most 1 % of false neighbours, four lags as Theiler window.
    ///
    /// The histogram has 64 bins for 50,000 samples or more, and for fewer so many that chance
    /// adds no more to the mutual information, about `(bins - 1)^2 / (2 N ln 2)` = 0.06 bit; at
    /// least 8.
    pub fn for_samples(count: usize) -> Self {
        let bins = 1.0 + 63.0 * (count as f64 / 50_000.0).sqrt();
        Self {
            largest_lag: (count / 25).clamp(1, 500),
            bins: (bins as usize).clamp(8, 64),
            largest_dimension: 10,
            false_share: 0.01,
            theiler: None,
        }
    }
}

/// Why this lag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LagReason {
    /// First clear minimum of the mutual information.
    #[serde(rename = "first minimum")]
    FirstMinimum,
    /// No minimum: where it first falls below 1/e of its value at lag 0.
    #[serde(rename = "first decay")]
    FirstDecay,
    /// Neither: the largest lag tried.
    #[serde(rename = "largest")]
    Largest,
}

/// Lag, dimension and the curves that led to them (Fig. 8).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DelayChoice {
    /// Delay, samples.
    #[serde(rename = "lag_samples")]
    pub lag: usize,
    /// Why this lag.
    #[serde(rename = "lag_reason")]
    pub reason: LagReason,
    /// Embedding dimension.
    pub dimension: usize,
    /// Whether the share of false neighbours came down to the limit at that dimension; if not it
    /// is the one with the smallest share.
    pub unfolded: bool,
    /// Theiler window used, samples.
    #[serde(rename = "theiler_samples")]
    pub theiler: usize,
    /// The mutual information.
    #[serde(rename = "mutual_information")]
    pub mutual: MutualInformation,
    /// The false neighbours at that lag.
    #[serde(rename = "false_neighbours")]
    pub neighbours: FalseNeighbours,
}

/// Chooses lag and dimension.
///
/// The lag is the first clear minimum of the [`mutual_information`]
/// ([`MutualInformation::first_clear_minimum`]); without one, where that first
/// falls below 1/e of its value at lag 0; else the largest tried. The dimension is the smallest
/// with a share of [`false_neighbours`] (15 and 2 as limits) of at most
/// [`DelaySearch::false_share`]. Noise never comes down to it, [`DelayChoice::unfolded`] tells. A
/// constant signal needs one dimension, at the largest lag.
///
/// # Errors
/// [`AnalysisError::NoDelay`] for a largest lag or dimension of zero; [`AnalysisError::Bins`];
/// [`AnalysisError::TooShort`] if the samples do not suffice for the largest lag, or for the
/// largest dimension at the lag chosen.
pub fn choose_delay(samples: &[f64], search: &DelaySearch) -> Result<DelayChoice, AnalysisError> {
    if search.largest_lag == 0 || search.largest_dimension == 0 {
        return Err(AnalysisError::NoDelay {
            lag: search.largest_lag,
            dimension: search.largest_dimension,
        });
    }
    let mutual = mutual_information(samples, search.largest_lag, search.bins)?;
    let (lag, reason) = if let Some(lag) = mutual.first_clear_minimum() {
        (lag, LagReason::FirstMinimum)
    } else if let Some(lag) = mutual.first_below((-1.0_f64).exp()) {
        (lag, LagReason::FirstDecay)
    } else {
        (search.largest_lag, LagReason::Largest)
    };
    let theiler = search.theiler.unwrap_or(LAGS_APART * lag);
    let neighbours = false_neighbours(
        samples,
        &FalseNeighbourSearch::new(lag, search.largest_dimension, theiler),
    )?;
    let unfolds_at = neighbours.dimension(search.false_share);
    let dimension = unfolds_at.unwrap_or_else(|| 1 + smallest(&neighbours.share));
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

/// The place of the smallest value, the first of several.
fn smallest(values: &[f64]) -> usize {
    let places = values.iter().enumerate();
    let least = places.min_by(|a, b| a.1.total_cmp(b.1));
    least.map_or(0, |(place, _)| place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::test_signals::{coordinate, lorenz, noise, roessler, sines};

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
    fn chaos_unfolds_however_it_is_sampled() {
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
    fn without_a_minimum_it_is_the_decay_and_without_that_the_end() {
        // A period far longer than the largest lag: the information only falls.
        let slow = sines(1000.0, 4000, &[(1.0, 1.0, 0.3)]);
        let search = |largest_lag| DelaySearch {
            largest_lag,
            largest_dimension: 2,
            ..DelaySearch::for_samples(slow.len())
        };
        let choice = choose_delay(&slow, &search(3)).unwrap();
        assert_eq!((choice.reason, choice.lag), (LagReason::Largest, 3));

        // A walk forgets slowly and never remembers again: half a period of a slow tone in noise.
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
    fn a_window_that_is_asked_for_is_used() {
        let signal = noise(5, 600, 1.0);
        let search = DelaySearch {
            theiler: Some(123),
            ..DelaySearch::for_samples(600)
        };
        assert_eq!(choose_delay(&signal, &search).unwrap().theiler, 123);
    }

    #[test]
    fn the_proposed_search_fits_the_samples() {
        for count in [30, 31, 50, 100, 333, 1000, 100_000] {
            let search = DelaySearch::for_samples(count);
            // Whatever lag is chosen.
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
