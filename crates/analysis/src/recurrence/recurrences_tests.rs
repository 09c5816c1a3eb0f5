use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::recurrence::{Measures, RateBase, RecurrenceCounts, RecurrenceCriterion, Threshold};
use crate::test_signals::{noise, sines};

const NORMS: [Norm; 3] = [Norm::Euclidean, Norm::Maximum, Norm::Manhattan];

fn rule(norm: Norm, threshold: Threshold, theiler: usize) -> RecurrenceCriterion {
    RecurrenceCriterion {
        norm,
        threshold,
        theiler,
    }
}

fn quantify(vectors: &DelayVectors<'_>, rule: &RecurrenceCriterion) -> RecurrenceCounts {
    Recurrences::of(vectors, rule).unwrap().counts()
}

/// The definition, pair by pair.
fn one_by_one(vectors: &DelayVectors<'_>, rule: &RecurrenceCriterion) -> RecurrenceCounts {
    let n = vectors.len();
    let unrooted = |i: usize, j: usize| {
        let coordinates = vectors.vector(i).zip(vectors.vector(j));
        rule.norm.unrooted(coordinates.map(|(a, b)| a - b))
    };
    let limits: Vec<f64> = match rule.threshold {
        Threshold::Neighbours(wanted) => {
            let limit = |j: usize| {
                let others = (0..n).filter(|i| i.abs_diff(j) >= rule.theiler.max(1));
                let mut unrooted: Vec<f64> = others.map(|i| unrooted(i, j)).collect();
                unrooted.sort_by(f64::total_cmp);
                unrooted.get(wanted - 1).or(unrooted.last()).copied()
            };
            (0..n).map(|j| limit(j).unwrap_or(0.0)).collect()
        }
        _ => vec![
            rule.norm
                .unrooted_limit(Recurrences::of(vectors, rule).unwrap().distance().unwrap());
            n
        ],
    };
    RecurrenceCounts::of_matrix(n, n, rule.theiler, |i, j| unrooted(i, j) <= limits[j])
}

/// Irregular, smooth, and with many ties.
fn signals(n: usize) -> [Vec<f64>; 3] {
    let rough = noise(n as u64, n, 1.0);
    let smooth = sines(1.0, n, &[(0.021, 1.0, 0.3), (0.0034, 0.7, 1.0)]);
    let tied = rough.iter().map(|x| (2.0 * x).round()).collect();
    [rough, smooth, tied]
}

#[test]
fn counts_match_the_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for n in [1, 2, 3, 5, 63, 64, 65, 128, 129, 200] {
        for (lag, dimension) in [(1, 1), (1, 2), (3, 4), (40, 3)] {
            for signal in signals(DelayVectors::samples_for(n, lag, dimension)) {
                let vectors = DelayVectors::new(&signal, lag, dimension).unwrap();
                let norm = NORMS[rng.random_range(0..3)];
                for theiler in [0, 1, 5, n - 1, n, usize::MAX] {
                    for threshold in [
                        Threshold::Distance(0.3),
                        Threshold::Distance(0.0),
                        Threshold::Distance(1e9),
                        Threshold::Spread(0.5),
                        Threshold::Rate(0.1),
                        Threshold::Neighbours(3),
                    ] {
                        let rule = rule(norm, threshold, theiler);
                        assert_eq!(
                            quantify(&vectors, &rule),
                            one_by_one(&vectors, &rule),
                            "{n} states, lag {lag}, dimension {dimension}, {rule:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn the_number_of_threads_does_not_change_the_counts() {
    for signal in &signals(1_200)[..2] {
        let vectors = DelayVectors::new(signal, 10, 5).unwrap();
        for threshold in [Threshold::Rate(0.05), Threshold::Neighbours(40)] {
            for theiler in [0, 1, 30] {
                let rule = rule(Norm::Euclidean, threshold, theiler);
                let with = |threads| {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                    let pool = pool.build().unwrap();
                    pool.install(|| quantify(&vectors, &rule))
                };
                let one = with(1);
                assert_eq!(one, with(2));
                assert_eq!(one, with(7));
                // Long enough for several chunks along a diagonal.
                assert_eq!(one, one_by_one(&vectors, &rule));
            }
        }
    }
}

#[test]
fn shift_scale_and_reversal_do_not_change_the_counts() {
    // Integers are shifted and halved without rounding.
    let signal: Vec<f64> = noise(3, 400, 1e6).iter().map(|x| x.round()).collect();
    let count = |signal: &[f64], threshold| {
        let vectors = DelayVectors::new(signal, 4, 3).unwrap();
        quantify(&vectors, &rule(Norm::Euclidean, threshold, 1))
    };
    for (threshold, scaled) in [
        (Threshold::Rate(0.1), Threshold::Rate(0.1)),
        (Threshold::Spread(0.5), Threshold::Spread(0.5)),
        (Threshold::Distance(1e6), Threshold::Distance(1e6 / 1024.0)),
        (Threshold::Neighbours(20), Threshold::Neighbours(20)),
    ] {
        let counts = count(&signal, threshold);
        let small: Vec<f64> = signal.iter().map(|x| x / 1024.0).collect();
        assert_eq!(count(&small, scaled), counts);
        let reversed: Vec<f64> = signal.iter().rev().copied().collect();
        let backwards = count(&reversed, threshold);
        assert_eq!(backwards.recurrent, counts.recurrent);
        assert_eq!(backwards.diagonal, counts.diagonal);
        assert_eq!(backwards.vertical, counts.vertical);
        assert_eq!(backwards.gaps, counts.gaps);
    }
    let shifted: Vec<f64> = signal.iter().map(|x| x + 12_345_678.0).collect();
    let threshold = Threshold::Distance(1e6);
    assert_eq!(count(&shifted, threshold), count(&signal, threshold));
}

#[test]
fn a_sine_is_deterministic_and_noise_is_not() {
    let measures = |signal: &[f64], threshold| -> Measures {
        let vectors = DelayVectors::new(signal, 25, 2).unwrap();
        let counts = quantify(&vectors, &rule(Norm::Euclidean, threshold, 1));
        counts.measures(2, 2, RateBase::Counted)
    };
    // On the unit circle, successive states are 2 sin(pi / 100) = 0.063 apart.
    let signal = sines(100.0, 1065, &[(1.0, 1.0, 0.2)]);
    let sine = measures(&signal, Threshold::Distance(0.09));
    assert_eq!(sine.determinism, Some(1.0));
    assert_eq!(sine.longest_diagonal, 1039.0);
    let noise = measures(&noise(2, 1025, 1.0), Threshold::Rate(0.02));
    assert!(noise.determinism.unwrap() < 0.1, "{noise:?}");
}

#[test]
fn every_column_of_a_constant_signal_is_one_line() {
    for threshold in [
        Threshold::Distance(0.0),
        Threshold::Spread(0.3),
        Threshold::Rate(0.05),
        Threshold::Neighbours(2),
    ] {
        let signal = [2.5; 130];
        let vectors = DelayVectors::new(&signal, 2, 3).unwrap();
        let counts = quantify(&vectors, &rule(Norm::Manhattan, threshold, 0));
        assert_eq!(counts.recurrent, 126 * 126);
        assert_eq!(counts.vertical.of_length(126), 126);
        assert_eq!(counts.diagonal.longest(), 126);
        assert_eq!(counts.gaps.lines(), 0);
    }
}

#[test]
#[ignore = "5e9 pairs: `cargo test --release hundred_thousand -- --ignored --nocapture`"]
fn hundred_thousand_states_fit_in_memory() {
    let n = 100_080;
    let mut signal = sines(1.0, n, &[(0.0213, 1.0, 0.3), (0.00341, 0.7, 1.0)]);
    let white = noise(1, n, 0.1);
    signal.iter_mut().zip(white).for_each(|(x, e)| *x += e);
    let vectors = DelayVectors::new(&signal, 20, 5).unwrap();
    let clock = std::time::Instant::now();
    let rule = rule(Norm::Euclidean, Threshold::Rate(0.01), 1);
    let counts = quantify(&vectors, &rule);
    println!(
        "threshold and counts: {:.1} s",
        clock.elapsed().as_secs_f64()
    );
    let rate = counts.recurrent as f64 / counts.pairs() as f64;
    assert!((rate / 0.01 - 1.0).abs() < 5e-3, "{rate}");
    assert_eq!(counts.diagonal.points(), counts.recurrent);
    assert_eq!(counts.vertical.points(), counts.recurrent);
}

#[test]
#[ignore = "timing: run alone, with --release --nocapture"]
fn time_of_ten_thousand_states() {
    let signal = sines(1.0, 10_080, &[(0.0213, 1.0, 0.3), (0.00341, 0.7, 1.0)]);
    let rough: Vec<f64> = signal
        .iter()
        .zip(noise(1, 10_080, 0.1))
        .map(|(a, b)| a + b)
        .collect();
    let white = noise(1, 10_080, 1.0);
    for (name, signal) in [
        ("torus", &signal),
        ("noisy torus", &rough),
        ("noise", &white),
    ] {
        let vectors = DelayVectors::new(signal, 20, 5).unwrap();
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let by_rate = rule(Norm::Euclidean, Threshold::Rate(0.05), 1);
                let (mut a, mut b) = (f64::MAX, f64::MAX);
                let mut recurrent = 0;
                for _ in 0..20 {
                    let clock = std::time::Instant::now();
                    let found = Recurrences::of(&vectors, &by_rate).unwrap();
                    a = a.min(clock.elapsed().as_secs_f64());
                    let clock = std::time::Instant::now();
                    recurrent = found.counts().recurrent;
                    b = b.min(clock.elapsed().as_secs_f64());
                }
                println!(
                    "{name}, {threads} threads: {recurrent} points, threshold {:.1} ms, counts {:.1} ms",
                    1e3 * a, 1e3 * b
                );
            });
        }
    }
}

/// The plot of a signal with itself is its recurrence plot with the line of identity.
#[test]
fn a_signal_recurs_with_itself_as_in_its_own_plot() {
    let signal = noise(3, 120, 1.0);
    let vectors = DelayVectors::new(&signal, 2, 3).unwrap();
    for threshold in [
        Threshold::Distance(0.9),
        Threshold::Spread(0.6),
        Threshold::Neighbours(7),
    ] {
        let norm = Norm::Euclidean;
        let cross = Recurrences::cross(&vectors, &vectors, norm, threshold).unwrap();
        let rule = RecurrenceCriterion {
            norm,
            threshold,
            theiler: 0,
        };
        let own = quantify(&vectors, &rule);
        let neighbours = matches!(threshold, Threshold::Neighbours(_));
        // A state is its own nearest neighbour, which the plot of one signal does not count.
        assert_eq!(cross.counts() == own, !neighbours);
        assert_eq!(
            cross.counts().recurrent,
            if neighbours { 7 * 116 } else { own.recurrent }
        );
    }
}

#[test]
fn a_rate_is_that_of_all_pairs() {
    let (a, b) = (noise(1, 50, 1.0), noise(2, 80, 1.0));
    let [a, b] = [&a, &b].map(|x| DelayVectors::new(x, 1, 1).unwrap());
    let plot = Recurrences::cross(&a, &b, Norm::Maximum, Threshold::Rate(0.1)).unwrap();
    let counts = plot.counts();
    assert_eq!(
        (counts.rows, counts.columns, counts.recurrent),
        (50, 80, 400)
    );
    let matrix = plot.matrix().unwrap();
    let defined = RecurrenceCounts::of_matrix(50, 80, 0, |i, j| matrix[i * 80 + j]);
    assert_eq!(counts, defined);
}
