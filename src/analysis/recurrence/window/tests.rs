use proptest::prelude::*;

use super::*;
use crate::analysis::test_signals::{noise, sines};
use crate::analysis::{DelayVectors, RecurrenceCriterion, quantify};

const NORMS: [Norm; 3] = [Norm::Euclidean, Norm::Maximum, Norm::Manhattan];

/// Parameters of a window.
#[derive(Clone, Copy, Debug)]
struct Case {
    length: Option<usize>,
    lag: usize,
    dimension: usize,
    norm: Norm,
    epsilon: f64,
    theiler: usize,
}

impl Case {
    fn window(&self) -> RecurrenceWindow {
        let Self {
            length,
            lag,
            dimension,
            norm,
            epsilon,
            theiler,
        } = *self;
        match length {
            Some(n) => RecurrenceWindow::sliding(n, lag, dimension, norm, epsilon, theiler),
            None => RecurrenceWindow::growing(lag, dimension, norm, epsilon, theiler),
        }
        .unwrap()
    }

    /// Counts by the definition, of the states in the window after these samples.
    fn reference(&self, samples: &[f64]) -> RecurrenceCounts {
        let Ok(all) = DelayVectors::new(samples, self.lag, self.dimension) else {
            return RecurrenceCounts::of_matrix(0, 0, self.theiler, |_, _| false);
        };
        let size = all.len().min(self.length.unwrap_or(usize::MAX));
        let oldest = all.len() - size;
        RecurrenceCounts::of_matrix(size, size, self.theiler, |i, j| {
            let pairs = all.vector(oldest + i).zip(all.vector(oldest + j));
            let unrooted = self.norm.unrooted(pairs.map(|(a, b)| a - b));
            unrooted <= self.norm.unrooted_limit(self.epsilon)
        })
    }

    /// Pushes the signal in blocks of the given lengths, repeated cyclically, and compares after each.
    fn check(&self, signal: &[f64], blocks: &[usize]) {
        let mut window = self.window();
        assert_eq!(window.counts(), self.reference(&[]), "{self:?}");
        let mut taken = 0;
        for &block in blocks.iter().cycle() {
            let block = block.min(signal.len() - taken);
            window.push(&signal[taken..taken + block]);
            taken += block;
            assert_eq!(
                window.counts(),
                self.reference(&signal[..taken]),
                "{self:?} after {taken} samples"
            );
            if taken == signal.len() {
                break;
            }
        }
    }
}

/// Checks all kinds of windows on a signal with a suitable number of recurrences at `epsilon`.
fn check_all(signal: &[f64], epsilon: f64) {
    for (norm, theiler) in NORMS.iter().flat_map(|&norm| [0, 1, 5].map(|w| (norm, w))) {
        for length in [None, Some(40), Some(64), Some(65)] {
            let case = Case {
                length,
                lag: 3,
                dimension: 3,
                norm,
                epsilon,
                theiler,
            };
            case.check(signal, &[1, 2, 7, 1, 13]);
        }
    }
}

#[test]
fn noise_matches_a_full_count() {
    check_all(&noise(1, 180, 1.0), 1.2);
}

#[test]
fn long_lines_match_a_full_count() {
    // Periods of 12 samples, and a second tone that occasionally breaks the lines.
    check_all(&sines(12.0, 180, &[(1.0, 1.0, 0.3)]), 0.3);
    check_all(&sines(12.0, 180, &[(1.0, 1.0, 0.3), (0.13, 0.3, 0.0)]), 0.4);
}

#[test]
fn a_constant_signal_is_always_recurrent() {
    check_all(&[2.5; 120], 0.0);
    check_all(&[0.0; 120], 1.0);
}

#[test]
fn transitions_match_a_full_count() {
    // Noise, constant signal, tone, constant signal: lines of a whole window start and end at once.
    let mut signal = noise(2, 70, 1.0);
    signal.extend([0.1; 90]);
    signal.extend(sines(9.0, 90, &[(1.0, 1.0, 0.0)]));
    signal.extend([0.1; 60]);
    check_all(&signal, 0.5);
}

#[test]
fn values_on_a_grid_match_the_threshold_exactly() {
    let signal: Vec<f64> = noise(3, 150, 1.5).iter().map(|x| x.round()).collect();
    check_all(&signal, 1.0);
    check_all(&signal, 2.0);
}

#[test]
fn short_windows_are_valid() {
    let signal = noise(4, 60, 1.0);
    for (length, lag, dimension) in [(1, 1, 1), (2, 1, 1), (2, 7, 3), (5, 11, 2), (3, 1, 4)] {
        for theiler in [0, 1, 2, 5, 90] {
            let case = Case {
                length: Some(length),
                lag,
                dimension,
                norm: Norm::Maximum,
                epsilon: 1.0,
                theiler,
            };
            case.check(&signal, &[1]);
        }
    }
}

#[test]
fn a_window_matches_the_batch_computation() {
    let signal = noise(5, 400, 1.0);
    let case = Case {
        length: Some(100),
        lag: 4,
        dimension: 3,
        norm: Norm::Euclidean,
        epsilon: 1.5,
        theiler: 1,
    };
    let mut whole = case.window();
    whole.push(&signal);
    assert_eq!(whole.counts(), case.reference(&signal));
    assert_eq!(whole.size(), 100);
    let in_window =
        &signal[signal.len() - DelayVectors::samples_for(100, case.lag, case.dimension)..];
    let rule = RecurrenceCriterion {
        norm: case.norm,
        threshold: Threshold::Distance(case.epsilon),
        theiler: case.theiler,
    };
    let vectors = DelayVectors::new(in_window, case.lag, case.dimension).unwrap();
    assert_eq!(Ok(whole.counts()), quantify(&vectors, &rule));
}

#[test]
fn invalid_windows_are_rejected() {
    let sliding = |length, lag, dimension| {
        RecurrenceWindow::sliding(length, lag, dimension, Norm::Euclidean, 1.0, 1).map(|_| ())
    };
    let no_delay = |lag, dimension| Err(AnalysisError::InvalidDelay { lag, dimension });
    assert_eq!(sliding(9, 0, 3), no_delay(0, 3));
    assert_eq!(sliding(9, 3, 0), no_delay(3, 0));
    assert!(sliding(0, 3, 3).is_err());
    // The stream is shorter than this delay: there are no states.
    let mut waiting = RecurrenceWindow::growing(1 << 63, 3, Norm::Euclidean, 1.0, 1).unwrap();
    waiting.push(&[1.0; 50]);
    assert_eq!(waiting.size(), 0);
    assert!(RecurrenceWindow::growing(0, 3, Norm::Euclidean, 1.0, 1).is_err());
    for epsilon in [-1.0, f64::NAN] {
        assert!(RecurrenceWindow::growing(3, 3, Norm::Euclidean, epsilon, 1).is_err());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn any_window_matches_a_full_count(
        seed in 0_u64..1000,
        length in prop::option::of(1_usize..90),
        (lag, dimension) in (1_usize..9, 1_usize..5),
        norm in prop::sample::select(NORMS.to_vec()),
        epsilon in 0.0..3.0,
        theiler in 0_usize..7,
        tone in 0.0..4.0,
        blocks in prop::collection::vec(1_usize..30, 1..5),
    ) {
        // From pure noise to almost pure tone.
        let tones = sines(23.7, 150, &[(1.0, tone, 0.0)]);
        let signal: Vec<f64> = noise(seed, 150, 0.5).iter().zip(tones).map(|(a, b)| a + b).collect();
        Case { length, lag, dimension, norm, epsilon, theiler }.check(&signal, &blocks);
    }
}

/// Distances computed per sample once the window is full.
fn evaluations(signal: &[f64], length: usize, epsilon: f64) -> f64 {
    let mut window = RecurrenceWindow::sliding(length, 3, 3, Norm::Euclidean, epsilon, 1).unwrap();
    let (before, after) = signal.split_at(2 * length);
    window.push(before);
    let start = window.states.evaluations.get();
    window.push(after);
    (window.states.evaluations.get() - start) as f64 / after.len() as f64
}

#[test]
fn the_cost_per_sample_is_proportional_to_the_window() {
    let mut bursts = Vec::new();
    for k in 0..20 {
        bursts.extend(noise(k, 290, 1.0));
        bursts.extend([0.0; 290]);
    }
    let signals = [
        (noise(6, 10_000, 1.0), 0.7),
        (noise(6, 10_000, 1.0), 2.0),
        (sines(37.3, 10_000, &[(1.0, 1.0, 0.0)]), 0.2),
        (vec![0.0; 10_000], 0.1),
        (bursts, 0.5),
    ];
    // One for the new state, one for the one that leaves. A line or gap of one pair takes 8, as part of
    // a column and of a diagonal. A full count would take hundreds.
    let limit = 1.0 + 1.0 + 8.0 + 8.0;
    for (signal, epsilon) in &signals {
        for length in [250, 1000] {
            let cost = evaluations(signal, length, *epsilon) / length as f64;
            assert!(
                (2.0..=limit).contains(&cost),
                "{cost} times the window of {length}"
            );
        }
    }
}

#[test]
#[ignore = "timing: run alone, in release, with --nocapture"]
fn time_per_sample() {
    let torus = sines(1000.0, 40_000, &[(20.0, 1.0, 0.0), (33.1, 0.8, 0.0)]);
    let mixed = |n: &[f64]| n.iter().zip(&torus).map(|(a, b)| a + b).collect::<Vec<_>>();
    let signals = [
        ("torus", torus.clone(), 0.6),
        ("torus in noise", mixed(&noise(7, 40_000, 0.1)), 0.6),
        ("noise", noise(8, 40_000, 1.0), 1.35),
    ];
    for (name, signal, epsilon) in &signals {
        for length in [1000, 4000] {
            let mut window =
                RecurrenceWindow::sliding(length, 12, 5, Norm::Euclidean, *epsilon, 1).unwrap();
            let (before, after) = signal.split_at(2 * length);
            let grown = std::time::Instant::now();
            window.push(&before[..length]);
            let growing = grown.elapsed().as_secs_f64() * 1e6 / length as f64;
            window.push(&before[length..]);
            let start = std::time::Instant::now();
            window.push(after);
            let each = start.elapsed().as_secs_f64() * 1e6 / after.len() as f64;
            let clock = std::time::Instant::now();
            let counts = window.counts();
            let clock = clock.elapsed().as_secs_f64() * 1e6;
            let share = counts.recurrent as f64 / (length * (length - 1)) as f64;
            println!(
                "{name}: {length} states, rate {share:.3}: {each:.1} us per sample sliding, \
                 {growing:.1} us per sample growing, {clock:.0} us for the counts"
            );
        }
    }
}
