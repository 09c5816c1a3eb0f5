//! A band-pass filter without phase shift, and interpolation between samples.

use std::f64::consts::PI;

use realfft::RealFftPlanner;

use crate::tones::Line;

/// Width of the transition beyond each edge of the pass band, relative to the frequency of the edge.
const TRANSITION: f64 = 0.2;

/// Samples that passed a filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Filtered {
    /// The samples in the pass band.
    pub samples: Vec<f64>,
    /// Share of the power outside the pass band, 0 to 1. The mean of the samples does not count; it is removed.
    pub outside_share: f64,
}

/// Filters samples at `rate` (Hz) with a pass band (lower and upper edge, Hz). The gain falls from 1 at the
/// edges to 0 a fifth of their frequency beyond them, as a cosine, and no phase is shifted.
///
/// The samples are taken as one period of a periodic signal. At both ends, the first and last ten periods
/// of the lower edge depend on the other end: filter more samples than are needed.
pub fn band_pass(samples: &[f64], rate: f64, [low, high]: [f64; 2]) -> Filtered {
    let count = samples.len();
    if count == 0 {
        return Filtered {
            samples: Vec::new(),
            outside_share: 0.0,
        };
    }
    let mean = samples.iter().sum::<f64>() / count as f64;
    let (mut power, mut outside) = (0.0, 0.0);
    let gain = |bin: usize, square: f64| {
        let frequency = bin as f64 * rate / count as f64;
        let beyond = ((low - frequency) / low).max((frequency - high) / high);
        let gain = 0.5 + 0.5 * (PI * (beyond / TRANSITION).clamp(0.0, 1.0)).cos();
        power += square;
        outside += square * (1.0 - gain);
        gain
    };
    let samples = with_gain(samples.iter().map(|x| x - mean).collect(), gain);
    Filtered {
        samples,
        outside_share: if power > 0.0 { outside / power } else { 0.0 },
    }
}

/// One period of a periodic signal, each bin of whose transform is multiplied by the gain that a function gives for its
/// index and its squared magnitude.
pub(super) fn with_gain(
    mut samples: Vec<f64>,
    mut gain: impl FnMut(usize, f64) -> f64,
) -> Vec<f64> {
    let count = samples.len();
    let mut planner = RealFftPlanner::new();
    let forward = planner.plan_fft_forward(count);
    let mut bins = forward.make_output_vec();
    let lengths = "the buffers have the lengths of the plan";
    forward.process(&mut samples, &mut bins).expect(lengths);
    for (k, bin) in bins.iter_mut().enumerate() {
        *bin *= gain(k, bin.norm_sqr()) / count as f64;
    }
    let inverse = planner.plan_fft_inverse(count);
    inverse.process(&mut bins, &mut samples).expect(lengths);
    samples
}

/// Half of the samples used per interpolated sample.
pub const HALF_TAPS: usize = 24;

/// Weights of the samples from `1 - HALF_TAPS` to `HALF_TAPS` after one, for the value a share (0 to 1) of a sample
/// after it: a windowed sinc. Frequencies up to 0.45 of the rate are kept to 60 dB.
pub(super) fn taps(share: f64) -> [f64; 2 * HALF_TAPS] {
    // sin(pi (share - k)) differs from sin(pi share) by its sign only.
    let sine = (PI * share).sin() / PI;
    std::array::from_fn(|i| {
        let k = i as f64 - (HALF_TAPS as f64 - 1.0);
        let x = share - k;
        if x == 0.0 {
            return 1.0;
        }
        let sign = if k.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
        let window = (0.5 * PI * x / (HALF_TAPS as f64 + 1.0)).cos().powi(2);
        sign * sine / x * window
    })
}

/// Least samples per period of the highest line of at least a hundredth of the strongest one, for sections and
/// neighbours. Twelve take half as long again, and no more is right.
const DENSE: usize = 8;

/// The factor by which [`upsampled`] makes a signal with these lines, strongest first, dense enough for sections and
/// neighbours; 1 if it is.
pub fn upsampling(lines: &[Line], sample_rate: f64) -> usize {
    let strong = lines
        .iter()
        .filter(|line| line.amplitude > 0.01 * lines[0].amplitude);
    let highest = strong.map(|line| line.frequency).fold(0.0, f64::max);
    ((DENSE as f64 * highest / sample_rate).ceil() as usize).max(1)
}

/// Samples at `factor` times the rate, band-limited. The first is the sample with the index `HALF_TAPS - 1`, as each
/// depends on [`HALF_TAPS`] samples on either side; there are none from fewer than twice as many samples.
pub fn upsampled(samples: &[f64], factor: usize) -> Vec<f64> {
    let phases: Vec<_> = (0..factor)
        .map(|phase| taps(phase as f64 / factor as f64))
        .collect();
    let between = |around: &[f64], taps: &[f64]| -> f64 {
        around.iter().zip(taps).map(|(x, tap)| x * tap).sum()
    };
    samples
        .windows(2 * HALF_TAPS)
        .flat_map(|around| phases.iter().map(move |taps| between(around, taps)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::sines;

    const RATE: f64 = 10_000.0;

    #[test]
    fn tones_pass_unchanged_and_others_are_removed() {
        // Whole periods, and a mean that is removed as well.
        let inside = sines(RATE, 5000, &[(1000.0, 1.0, 0.4), (2500.0, 0.3, 1.0)]);
        let outside = sines(RATE, 5000, &[(100.0, 2.0, 0.0), (4000.0, 0.5, 0.2)]);
        let mixed: Vec<f64> = inside
            .iter()
            .zip(&outside)
            .map(|(a, b)| a + b + 3.0)
            .collect();
        let filtered = band_pass(&mixed, RATE, [900.0, 2600.0]);
        for (found, expected) in filtered.samples.iter().zip(&inside) {
            assert!((found - expected).abs() < 1e-12);
        }
        let share = (4.0 + 0.25) / (4.0 + 0.25 + 1.0 + 0.09);
        assert!((filtered.outside_share - share).abs() < 1e-12);
    }

    #[test]
    fn the_gain_is_a_half_in_the_middle_of_the_transition() {
        let tone = sines(RATE, 5000, &[(900.0, 1.0, 0.0)]);
        let filtered = band_pass(&tone, RATE, [1000.0, 2000.0]);
        for (found, sample) in filtered.samples.iter().zip(&tone) {
            assert!((found - 0.5 * sample).abs() < 1e-12);
        }
    }

    #[test]
    fn empty_and_constant_signals_are_valid() {
        assert!(band_pass(&[], RATE, [1.0, 2.0]).samples.is_empty());
        for count in [1, 7] {
            let filtered = band_pass(&vec![2.0; count], RATE, [100.0, 200.0]);
            assert!(filtered.samples.iter().all(|x| x.abs() < 1e-12));
            assert_eq!(filtered.outside_share, 0.0);
        }
    }
}
