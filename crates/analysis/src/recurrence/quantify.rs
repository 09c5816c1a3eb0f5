//! Counts of a recurrence plot without storing it.

use rayon::prelude::*;

use super::diagonals::{Limits, Pairs};
use super::line_counter::LineCounter;
use super::threshold::ResolvedThreshold;
use super::{RecurrenceCounts, RecurrenceCriterion};
use crate::{AnalysisError, DelayVectors};

/// Counts the recurrence plot of delay vectors, as defined in [`RecurrenceCounts`].
///
/// The result is exact: every pair is compared in double precision and every line is counted. Work
/// beyond the comparison is needed only where adjacent diagonals of the plot differ. Time is
/// proportional to the number of pairs, memory to the number of vectors. The computation uses all cores;
/// the counts do not depend on their number.
///
/// # Errors
/// As [`find_threshold`](super::find_threshold).
pub fn quantify(
    vectors: &DelayVectors<'_>,
    rule: &RecurrenceCriterion,
) -> Result<RecurrenceCounts, AnalysisError> {
    let pairs = Pairs::new(vectors, rule.norm, rule.theiler);
    let threshold = ResolvedThreshold::find(&pairs, rule.threshold)?;
    let limits = threshold.limits(rule.norm);
    let symmetric = matches!(limits, Limits::One(_));
    let new = || LineCounter::new(pairs.states, symmetric);
    let counter = pairs
        .blocks()
        .into_par_iter()
        .fold(
            || None,
            |counter: Option<LineCounter>, block| {
                let mut counter = counter.unwrap_or_else(new);
                pairs.count(block, limits, &mut counter);
                Some(counter)
            },
        )
        .flatten()
        .reduce_with(LineCounter::append);
    Ok(counter.unwrap_or_else(new).finish(rule.theiler))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::diagonals::{Maximum, SumOfMagnitudes, SumOfSquares, Sweep};
    use super::*;
    use crate::test_signals::{noise, sines};
    use crate::{Norm, RateBase, Threshold, find_threshold};

    const NORMS: [Norm; 3] = [Norm::Euclidean, Norm::Maximum, Norm::Manhattan];

    fn rule(norm: Norm, threshold: Threshold, theiler: usize) -> RecurrenceCriterion {
        RecurrenceCriterion {
            norm,
            threshold,
            theiler,
        }
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
                    .unrooted_limit(find_threshold(vectors, rule).unwrap());
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
                                quantify(&vectors, &rule).unwrap(),
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
                        pool.install(|| quantify(&vectors, &rule).unwrap())
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
    fn every_instruction_set_gives_the_same_counts() {
        fn with(simd: impl pulp::Simd, pairs: &Pairs<'_>, limits: Limits<'_>) -> RecurrenceCounts {
            let mut counter = LineCounter::new(pairs.states, matches!(limits, Limits::One(_)));
            for block in pairs.blocks() {
                let counter = &mut counter;
                match pairs.norm {
                    Norm::Euclidean => {
                        simd.vectorize(Sweep(pairs, block, limits, counter, SumOfSquares));
                    }
                    Norm::Maximum => simd.vectorize(Sweep(pairs, block, limits, counter, Maximum)),
                    Norm::Manhattan => {
                        simd.vectorize(Sweep(pairs, block, limits, counter, SumOfMagnitudes));
                    }
                }
            }
            counter.finish(pairs.theiler)
        }
        for norm in NORMS {
            for signal in signals(700) {
                let vectors = DelayVectors::new(&signal, 9, 3).unwrap();
                let pairs = Pairs::new(&vectors, norm, 1);
                for threshold in [Threshold::Spread(0.4), Threshold::Neighbours(9)] {
                    let expected = quantify(&vectors, &rule(norm, threshold, 1)).unwrap();
                    let threshold = ResolvedThreshold::find(&pairs, threshold).unwrap();
                    let limits = threshold.limits(norm);
                    assert_eq!(with(pulp::Scalar::new(), &pairs, limits), expected);
                    #[cfg(target_arch = "x86_64")]
                    if let Some(avx2) = pulp::x86::V3::try_new() {
                        assert_eq!(with(avx2, &pairs, limits), expected);
                    }
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
            quantify(&vectors, &rule(Norm::Euclidean, threshold, 1)).unwrap()
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
        let measures = |signal: &[f64], threshold| {
            let vectors = DelayVectors::new(signal, 25, 2).unwrap();
            let counts = quantify(&vectors, &rule(Norm::Euclidean, threshold, 1)).unwrap();
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
            let counts = quantify(&vectors, &rule(Norm::Manhattan, threshold, 0)).unwrap();
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
        let counts = quantify(&vectors, &rule).unwrap();
        println!(
            "threshold and counts: {:.1} s",
            clock.elapsed().as_secs_f64()
        );
        let wanted = (0.01 * (counts.pairs() / 2) as f64).round() as u64;
        assert_eq!(counts.recurrent, 2 * wanted);
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
                        let distance = find_threshold(&vectors, &by_rate).unwrap();
                        a = a.min(clock.elapsed().as_secs_f64());
                        let rule = rule(Norm::Euclidean, Threshold::Distance(distance), 1);
                        let clock = std::time::Instant::now();
                        recurrent = quantify(&vectors, &rule).unwrap().recurrent;
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
}
