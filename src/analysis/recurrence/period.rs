//! Periods of a motion from the spacing of the diagonals in its recurrence plot.
//!
//! A motion of period `P` recurs after `P`, `2 P`, ... for any waveform: the recurrence rate along the
//! diagonals (the tau-recurrence rate, Marwan et al., Phys. Rep. 438, 237, 2007, section 3.7) has peaks
//! there. On a torus the peaks of the shorter period are highest where the longer period recurs as well:
//! the highest peaks form a second series with a wider spacing. Kang et al. (2022) read the periods from
//! the plots in this way.

use super::RecurrenceCounts;

/// A peak of the recurrence rate over the offset: one diagonal, or several adjacent ones.
#[derive(Clone, Copy, Debug)]
struct Peak {
    /// Centre, samples.
    offset: f64,
    /// Recurrence rate along the highest diagonal.
    height: f64,
    /// Smallest significant difference of rates there.
    noise_floor: f64,
}

impl RecurrenceCounts {
    /// Most frequent spacing of diagonals, samples: the (shortest) period of the motion. The first of
    /// [`RecurrenceCounts::periods`].
    pub fn period(&self) -> Option<f64> {
        self.periods().first().copied()
    }

    /// Spacings of the diagonals, samples, shortest first. A periodic motion has one, a torus two (if
    /// the longer period is visible at this threshold), noise none.
    ///
    /// A peak is a significant maximum of the recurrence rate over the offset: on both sides the rate
    /// falls below half, by more than the statistical fluctuation. At least half of the successive peaks
    /// must have equal spacing, within one sample or 5 % (for the second series, within the shorter
    /// spacing). A least-squares fit to all multiples refines the spacing to a fraction of a sample.
    /// Peaks narrower than a sample are missed: the recurrence rate should be at least `2 / P`.
    pub fn periods(&self) -> Vec<f64> {
        let mut periods = Vec::new();
        let mut peaks = find_peaks(&self.diagonals());
        while peaks.len() >= 2 {
            let finer = periods.last().copied().unwrap_or(1.0);
            periods.extend(most_frequent_spacing(&peaks, finer));
            peaks = find_peaks(&peaks);
        }
        periods
    }

    /// Every diagonal as a separate peak candidate.
    fn diagonals(&self) -> Vec<Peak> {
        let offsets = self.reliable_offsets();
        let mean = offsets.clone().map(|k| self.rate_at(k)).sum::<f64>() / offsets.len() as f64;
        let diagonal = |k: usize| Peak {
            offset: k as f64,
            height: self.rate_at(k),
            // Eight standard deviations of the rate along a diagonal with random points, because the
            // overlap of delay vectors causes runs of points.
            noise_floor: 8.0 * (mean / self.rows.min(self.columns - k) as f64).sqrt(),
        };
        offsets.map(diagonal).collect()
    }
}

/// Significant maxima: on both sides the height falls below half, by more than the noise floor. The
/// centre is that of the part above half.
fn find_peaks(parts: &[Peak]) -> Vec<Peak> {
    let peak_at = |peak: usize| {
        let half = 0.5 * parts[peak].height;
        let low = |part: &Peak| part.height <= half;
        let begin = parts[..peak].iter().rposition(low).map_or(0, |at| at + 1);
        let end = parts[peak..].iter().position(low);
        let end = end.map_or(parts.len(), |length| peak + length);
        let (mut moment, mut weight) = (0.0, 0.0);
        for part in &parts[begin..end] {
            moment += part.offset * (part.height - half);
            weight += part.height - half;
        }
        Peak {
            offset: moment / weight,
            ..parts[peak]
        }
    };
    let mut found = Vec::new();
    let mut valley = f64::INFINITY;
    let mut peak = None;
    for (at, part) in parts.iter().enumerate() {
        match peak {
            None if part.height < valley => valley = part.height,
            None if part.height > 2.0 * valley + part.noise_floor => peak = Some(at),
            Some(top) if part.height > parts[top].height => peak = Some(at),
            Some(top) if 2.0 * part.height + part.noise_floor < parts[top].height => {
                found.push(peak_at(top));
                (peak, valley) = (None, part.height);
            }
            _ => {}
        }
    }
    found
}

/// The spacing of at least half of the successive peaks, counted from the line of identity. Peaks can
/// only be at multiples of the finer spacing.
fn most_frequent_spacing(peaks: &[Peak], finer: f64) -> Option<f64> {
    let previous = std::iter::once(0.0).chain(peaks.iter().map(|peak| peak.offset));
    let spacings: Vec<f64> = peaks
        .iter()
        .zip(previous)
        .map(|(peak, previous_offset)| peak.offset - previous_offset)
        .collect();
    let similar = |spacing: f64| {
        let tolerance = finer.max(0.05 * spacing);
        let near = move |other: &&f64| (**other - spacing).abs() <= tolerance;
        spacings.iter().filter(near)
    };
    let most = spacings.iter().map(|&s| similar(s).count()).max()?;
    if 2 * most < spacings.len() {
        return None;
    }
    let candidates = spacings.iter().filter(|s| similar(**s).count() == most);
    let spacing = candidates.fold(f64::INFINITY, |least, &s| least.min(s));
    let mut period = similar(spacing).sum::<f64>() / most as f64;
    // Each further multiple refines the period enough to identify the next. A second period shifts the
    // peaks in both directions with zero mean.
    let (mut product, mut square) = (0.0, 0.0);
    for peak in peaks {
        let multiple = (peak.offset / period).round();
        if multiple > 0.0 && (peak.offset - multiple * period).abs() <= 0.25 * period {
            product += multiple * peak.offset;
            square += multiple * multiple;
            period = product / square;
        }
    }
    Some(period)
}

#[cfg(test)]
mod tests {
    use crate::analysis::test_signals::{noise, sines};
    use crate::analysis::{
        DelayVectors, Norm, RecurrenceCounts, RecurrenceCriterion, Threshold, quantify,
    };

    fn counts(signal: &[f64], lag: usize, dimension: usize, rate: f64) -> RecurrenceCounts {
        let vectors = DelayVectors::new(signal, lag, dimension).unwrap();
        let rule = RecurrenceCriterion {
            norm: Norm::Euclidean,
            threshold: Threshold::Rate(rate),
            theiler: 1,
        };
        quantify(&vectors, &rule).unwrap()
    }

    #[test]
    fn the_period_of_a_sine_is_found() {
        for period in [20.0, 24.813, 41.37, 100.5, 163.0] {
            let signal = sines(1.0, 2000, &[(1.0 / period, 3.0, 0.7)]);
            for (lag, dimension, rate) in [(7, 2, 0.1), (10, 3, 0.2), (20, 5, 0.15)] {
                let periods = counts(&signal, lag, dimension, rate).periods();
                assert_eq!(periods.len(), 1, "{period}: {periods:?}");
                assert!((periods[0] - period).abs() < 1e-2, "{period}: {periods:?}");
            }
        }
    }

    #[test]
    fn the_period_is_found_with_harmonics_and_noise() {
        let tones = [(0.02, 1.0, 0.0), (0.04, 0.8, 1.0), (0.1, 0.3, 2.0)];
        let white = noise(5, 1500, 0.05);
        let signal: Vec<f64> = sines(1.0, 1500, &tones)
            .iter()
            .zip(white)
            .map(|(a, b)| a + b)
            .collect();
        let periods = counts(&signal, 9, 5, 0.05).periods();
        assert_eq!(periods.len(), 1, "{periods:?}");
        assert!((periods[0] - 50.0).abs() < 0.05, "{periods:?}");
    }

    /// The two tones of Kang et al. (2022) at 3.5 degrees, 3.87 kHz and 12.18 kHz. The plot repeats with
    /// 0.57 kHz, the difference between the second tone and the third harmonic of the first.
    #[test]
    fn a_torus_has_two_periods() {
        let rate = 200e3;
        let tones = [(3870.0, 1.0, 0.3), (12180.0, 0.5, 1.1)];
        let signal = sines(rate, 2500, &tones);
        let periods = counts(&signal, 8, 5, 0.05).periods();
        assert_eq!(periods.len(), 2, "{periods:?}");
        assert!((rate / periods[0] - 3870.0).abs() < 2.0, "{periods:?}");
        assert!((rate / periods[1] - 570.0).abs() < 3.0, "{periods:?}");
    }

    #[test]
    fn noise_and_constant_signals_have_no_period() {
        for seed in 0..20 {
            for (lag, dimension) in [(1, 1), (1, 3), (20, 5)] {
                for rate in [0.01, 0.05, 0.2] {
                    let periods = counts(&noise(seed, 600, 1.0), lag, dimension, rate).periods();
                    assert!(
                        periods.is_empty(),
                        "{seed} {lag} {dimension} {rate}: {periods:?}"
                    );
                }
            }
        }
        assert_eq!(counts(&[1.0; 300], 2, 3, 0.05).period(), None);
        assert_eq!(counts(&[1.0; 3], 1, 1, 0.05).period(), None);
        assert_eq!(RecurrenceCounts::default().period(), None);
    }
}
