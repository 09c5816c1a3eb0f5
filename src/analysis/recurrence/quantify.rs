//! All counts of a recurrence plot without ever storing it.

use rayon::prelude::*;

use super::sweep::{Limits, Pairs};
use super::tally::Tally;
use super::threshold::Nearness;
use super::{RecurrenceCounts, RecurrenceRule};
use crate::analysis::{AnalysisError, DelayVectors};

/// Counts the recurrence plot of these vectors, as defined with [`RecurrenceCounts`].
///
/// Exact: every pair is compared in double precision, every line counted; only where something
/// changes from one diagonal of the plot to the next is there more to do than a comparison. Time
/// is proportional to the number of pairs, memory to the number of vectors. All cores are used;
/// the counts do not depend on how many there are.
///
/// # Errors
/// As [`find_threshold`](super::find_threshold).
pub fn quantify(
    vectors: &DelayVectors<'_>,
    rule: &RecurrenceRule,
) -> Result<RecurrenceCounts, AnalysisError> {
    let pairs = Pairs::new(vectors, rule.norm, rule.theiler);
    let nearness = Nearness::find(&pairs, rule.threshold)?;
    let (limits, symmetric) = match &nearness {
        Nearness::Everywhere(distance) => (Limits::One(rule.norm.extent_within(*distance)), true),
        Nearness::Columns(extents) => (Limits::Columns(extents), false),
    };
    let new = || Tally::new(pairs.states, symmetric);
    let tally = pairs
        .pieces()
        .into_par_iter()
        .fold(
            || None,
            |tally: Option<Tally>, piece| {
                let mut tally = tally.unwrap_or_else(new);
                pairs.visit(piece, limits, &mut tally);
                Some(tally)
            },
        )
        .flatten()
        .reduce_with(Tally::join);
    Ok(tally.unwrap_or_else(new).finish(rule.theiler))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::analysis::test_signals::{noise, sines};
    use crate::analysis::{Norm, Threshold, find_threshold};

    const NORMS: [Norm; 3] = [Norm::Euclidean, Norm::Maximum, Norm::Manhattan];

    fn rule(norm: Norm, threshold: Threshold, theiler: usize) -> RecurrenceRule {
        RecurrenceRule {
            norm,
            threshold,
            theiler,
        }
    }

    /// The definition: every pair by itself.
    fn one_by_one(vectors: &DelayVectors<'_>, rule: &RecurrenceRule) -> RecurrenceCounts {
        let n = vectors.len();
        let extent = |i: usize, j: usize| {
            let coordinates = vectors.vector(i).zip(vectors.vector(j));
            rule.norm.extent(coordinates.map(|(a, b)| a - b))
        };
        let limits: Vec<f64> = match rule.threshold {
            Threshold::Neighbours(wanted) => {
                let limit = |j: usize| {
                    let others = (0..n).filter(|i| i.abs_diff(j) >= rule.theiler.max(1));
                    let mut extents: Vec<f64> = others.map(|i| extent(i, j)).collect();
                    extents.sort_by(f64::total_cmp);
                    extents.get(wanted - 1).or(extents.last()).copied()
                };
                (0..n).map(|j| limit(j).unwrap_or(0.0)).collect()
            }
            _ => vec![
                rule.norm
                    .extent_within(find_threshold(vectors, rule).unwrap());
                n
            ],
        };
        RecurrenceCounts::of_matrix(n, n, rule.theiler, |i, j| extent(i, j) <= limits[j])
    }

    /// Rough, smooth and with many ties.
    fn signals(n: usize) -> [Vec<f64>; 3] {
        let rough = noise(n as u64, n, 1.0);
        let smooth = sines(1.0, n, &[(0.021, 1.0, 0.3), (0.0034, 0.7, 1.0)]);
        let tied = rough.iter().map(|x| (2.0 * x).round()).collect();
        [rough, smooth, tied]
    }

    #[test]
    fn counts_are_those_of_the_definition() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for n in [1, 2, 3, 5, 63, 64, 65, 127, 128, 129, 200, 300] {
            for (lag, dimension) in [(1, 1), (1, 2), (3, 4), (40, 3)] {
                for signal in signals(DelayVectors::samples_for(n, lag, dimension)) {
                    let vectors = DelayVectors::new(&signal, lag, dimension).unwrap();
                    let norm = NORMS[rng.random_range(0..3)];
                    for theiler in [0, 1, 5, n - 1, n, n + 1] {
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
                    for _ in 0..7 {
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
