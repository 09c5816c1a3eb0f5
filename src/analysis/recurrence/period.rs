//! Periods of a motion, from the spacing of diagonals in its recurrence plot.
//!
//! Whatever the wave form, a motion of period `P` is back after `P`, `2 P`, ...: the recurrence
//! rate along the diagonals stands up in stripes there (the tau-recurrence rate, Marwan et al.,
//! Phys. Rep. 438, 237, 2007, section 3.7). On a torus the stripes of the faster rhythm stand
//! highest where the slower one is back as well: the highest of the stripes are stripes of their
//! own, wider apart. Kang et al. (2022) read their periods off the plots in this way.

use super::RecurrenceCounts;

/// Where recurrences gather: a diagonal, or a stripe of several.
#[derive(Clone, Copy, Debug)]
struct Stripe {
    /// Centre, samples.
    offset: f64,
    /// Recurrence rate along its highest diagonal.
    height: f64,
    /// Least difference of rates there that is not chance.
    floor: f64,
}

impl RecurrenceCounts {
    /// The most frequent spacing of diagonals, samples: the (fastest) period of the motion. The
    /// first of [`RecurrenceCounts::periods`].
    pub fn period(&self) -> Option<f64> {
        self.periods().first().copied()
    }

    /// The spacings of diagonals, samples, finest first: one of a periodic motion, two of one on
    /// a torus (if the slower rhythm shows at this threshold); none of noise.
    ///
    /// A stripe is a maximum of the recurrence rate over the offset that stands out: it falls to
    /// less than half on both sides, and by more than chance explains. At least half of the
    /// successive stripes must be equally far apart, within a sample or a twentieth (stripes of
    /// stripes: within the finer spacing); a least-squares fit of all multiples refines the
    /// spacing below a sample. Stripes narrower than a sample escape: the recurrence rate should
    /// be at least `2 / P`.
    pub fn periods(&self) -> Vec<f64> {
        let mut periods = Vec::new();
        let mut stripes = gather(&self.diagonals());
        while stripes.len() >= 2 {
            let finer = periods.last().copied().unwrap_or(1.0);
            periods.extend(most_frequent_spacing(&stripes, finer));
            stripes = gather(&stripes);
        }
        periods
    }

    /// Every diagonal by itself.
    fn diagonals(&self) -> Vec<Stripe> {
        let offsets = self.reliable_offsets();
        let mean = offsets.clone().map(|k| self.rate_at(k)).sum::<f64>() / offsets.len() as f64;
        let diagonal = |k: usize| Stripe {
            offset: k as f64,
            height: self.rate_at(k),
            // Eight standard deviations of the rate along a diagonal on which points fall at
            // random: the overlap of delay vectors makes runs of them.
            floor: 8.0 * (mean / self.rows.min(self.columns - k) as f64).sqrt(),
        };
        offsets.map(diagonal).collect()
    }
}

/// The stripes around those maxima that stand out: before and after them the height is less than
/// half, by more than the floor. The centre is that of what is above half.
fn gather(parts: &[Stripe]) -> Vec<Stripe> {
    let stripe = |peak: usize| {
        let half = 0.5 * parts[peak].height;
        let low = |part: &Stripe| part.height <= half;
        let begin = parts[..peak].iter().rposition(low).map_or(0, |at| at + 1);
        let end = parts[peak..].iter().position(low);
        let end = end.map_or(parts.len(), |length| peak + length);
        let (mut moment, mut weight) = (0.0, 0.0);
        for part in &parts[begin..end] {
            moment += part.offset * (part.height - half);
            weight += part.height - half;
        }
        Stripe {
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
            None if part.height > 2.0 * valley + part.floor => peak = Some(at),
            Some(top) if part.height > parts[top].height => peak = Some(at),
            Some(top) if 2.0 * part.height + part.floor < parts[top].height => {
                found.push(stripe(top));
                (peak, valley) = (None, part.height);
            }
            _ => {}
        }
    }
    found
}

/// The spacing that at least half of the successive stripes have, the line of identity being the
/// first, if stripes can only lie at multiples of a finer spacing.
fn most_frequent_spacing(stripes: &[Stripe], finer: f64) -> Option<f64> {
    let befores = std::iter::once(0.0).chain(stripes.iter().map(|stripe| stripe.offset));
    let spacings: Vec<f64> = stripes
        .iter()
        .zip(befores)
        .map(|(stripe, before)| stripe.offset - before)
        .collect();
    let alike = |spacing: f64| {
        let tolerance = finer.max(0.05 * spacing);
        let near = move |other: &&f64| (**other - spacing).abs() <= tolerance;
        spacings.iter().filter(near)
    };
    let most = spacings.iter().map(|&s| alike(s).count()).max()?;
    if 2 * most < spacings.len() {
        return None;
    }
    let candidates = spacings.iter().filter(|s| alike(**s).count() == most);
    let spacing = candidates.fold(f64::INFINITY, |least, &s| least.min(s));
    let mut period = alike(spacing).sum::<f64>() / most as f64;
    // Each further multiple sharpens the period enough to tell the next. A second rhythm draws
    // stripes to and fro, on average to none.
    let (mut product, mut square) = (0.0, 0.0);
    for stripe in stripes {
        let multiple = (stripe.offset / period).round();
        if multiple > 0.0 && (stripe.offset - multiple * period).abs() <= 0.25 * period {
            product += multiple * stripe.offset;
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
        DelayVectors, Norm, RecurrenceCounts, RecurrenceRule, Threshold, quantify,
    };

    fn counts(signal: &[f64], lag: usize, dimension: usize, rate: f64) -> RecurrenceCounts {
        let vectors = DelayVectors::new(signal, lag, dimension).unwrap();
        let rule = RecurrenceRule {
            norm: Norm::Euclidean,
            threshold: Threshold::Rate(rate),
            theiler: 1,
        };
        quantify(&vectors, &rule).unwrap()
    }

    #[test]
    fn a_sine_has_its_period() {
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
    fn overtones_and_noise_do_not_hide_the_period() {
        let tones = [(0.02, 1.0, 0.0), (0.04, 0.8, 1.0), (0.1, 0.3, 2.0)];
        let hiss = noise(5, 1500, 0.05);
        let signal: Vec<f64> = sines(1.0, 1500, &tones)
            .iter()
            .zip(hiss)
            .map(|(a, b)| a + b)
            .collect();
        let periods = counts(&signal, 9, 5, 0.05).periods();
        assert_eq!(periods.len(), 1, "{periods:?}");
        assert!((periods[0] - 50.0).abs() < 0.05, "{periods:?}");
    }

    /// The two tones of Kang et al. (2022) at 3.5 degrees: 3.87 kHz and 12.18 kHz, whose plot
    /// repeats with 0.57 kHz, the distance of the second from the third harmonic of the first.
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
    fn noise_and_silence_have_none() {
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
