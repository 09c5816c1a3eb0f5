use super::*;
use crate::recurrence::RecurrenceCounts;
use crate::test_signals::{noise, sines};

fn rule(norm: Norm, threshold: Threshold, theiler: usize) -> RecurrenceCriterion {
    RecurrenceCriterion {
        norm,
        threshold,
        theiler,
    }
}

fn find(
    vectors: &DelayVectors<'_>,
    rule: &RecurrenceCriterion,
) -> Result<(RecurrenceCounts, Option<f64>), AnalysisError> {
    let found = Recurrences::of(vectors, rule)?;
    Ok((found.counts(), found.distance()))
}

#[test]
fn the_distance_for_a_rate_is_the_smallest_that_reaches_it() {
    let signal = noise(2, 700, 1.0);
    let vectors = DelayVectors::new(&signal, 7, 5).unwrap();
    for norm in [Norm::Euclidean, Norm::Maximum, Norm::Manhattan] {
        for theiler in [0, 1, 40] {
            for rate in [1e-4, 0.01, 0.05, 0.3, 0.999, 1.0] {
                let by_rate = rule(norm, Threshold::Rate(rate), theiler);
                let (by_rate_counts, distance) = find(&vectors, &by_rate).unwrap();
                let distance = distance.unwrap();
                let reached = |distance| {
                    let rule = rule(norm, Threshold::Distance(distance), theiler);
                    find(&vectors, &rule).unwrap().0
                };
                let counts = reached(distance);
                if distance > 0.0 {
                    let count = rate * counts.pairs() as f64;
                    let below = reached(distance.next_down()).recurrent;
                    // Pairs occur twice, once per triangle.
                    assert!(counts.recurrent as f64 >= count - 1.0, "{by_rate:?}");
                    assert!((below as f64) < count + 1.0, "{by_rate:?}");
                    // No two sums over noise are equal.
                    if norm != Norm::Maximum {
                        assert_eq!(counts.recurrent - below, 2, "{by_rate:?}");
                    }
                }
                assert_eq!(counts, by_rate_counts);
            }
        }
    }
}

#[test]
fn the_rate_of_many_states_is_exact() {
    let n = 6000;
    let mut signal = sines(1.0, n, &[(0.0213, 1.0, 0.3), (0.00341, 0.7, 1.0)]);
    let white = noise(1, n, 0.1);
    signal.iter_mut().zip(white).for_each(|(x, e)| *x += e);
    let vectors = DelayVectors::new(&signal, 20, 3).unwrap();
    for rate in [0.01, 0.1, 0.4] {
        let rule = rule(Norm::Euclidean, Threshold::Rate(rate), 1);
        let (counts, _) = find(&vectors, &rule).unwrap();
        let wanted = rate * counts.pairs() as f64;
        // Pairs occur twice, once per triangle.
        assert!((counts.recurrent as f64 - wanted).abs() <= 2.0, "{rate}");
    }
}

/// More equal distances than are kept in memory.
#[test]
fn the_distance_for_a_rate_may_be_that_of_most_pairs() {
    let signal: Vec<f64> = (0..6000).map(|i| f64::from(i % 2)).collect();
    let vectors = DelayVectors::new(&signal, 1, 1).unwrap();
    for (rate, expected) in [(0.3, 0.0), (0.8, 1.0)] {
        let rule = rule(Norm::Maximum, Threshold::Rate(rate), 1);
        assert_eq!(find(&vectors, &rule).unwrap().1, Some(expected));
    }
}

#[test]
fn a_spread_is_a_multiple_of_the_standard_deviation() {
    let signal = [1.0, -1.0, 1.0, -1.0, 3.0, -3.0];
    let vectors = DelayVectors::new(&signal, 1, 2).unwrap();
    let spread = rule(Norm::Maximum, Threshold::Spread(0.5), 1);
    let distance = find(&vectors, &spread).unwrap().1;
    assert_eq!(distance, Some(0.5 * (22.0_f64 / 6.0).sqrt()));
}

#[test]
fn each_column_has_the_given_number_of_neighbours() {
    let signal = noise(6, 150, 1.0);
    let vectors = DelayVectors::new(&signal, 1, 2).unwrap();
    for theiler in [1, 10] {
        let neighbours = rule(Norm::Euclidean, Threshold::Neighbours(7), theiler);
        let (counts, distance) = find(&vectors, &neighbours).unwrap();
        assert_eq!(distance, None);
        assert_eq!(counts.recurrent, 7 * 149);
    }
    let all = rule(Norm::Euclidean, Threshold::Neighbours(1000), 1);
    let (counts, _) = find(&vectors, &all).unwrap();
    assert_eq!(counts.recurrent, counts.pairs());
}

#[test]
fn thresholds_out_of_range_are_rejected() {
    let signal = [0.0, 1.0, 2.0];
    let vectors = DelayVectors::new(&signal, 1, 1).unwrap();
    for threshold in [
        Threshold::Distance(-1.0),
        Threshold::Distance(f64::NAN),
        Threshold::Spread(-0.1),
        Threshold::Spread(f64::INFINITY),
        Threshold::Rate(-0.1),
        Threshold::Rate(1.1),
        Threshold::Rate(f64::NAN),
        Threshold::Neighbours(0),
    ] {
        let rule = rule(Norm::Euclidean, threshold, 1);
        assert!(find(&vectors, &rule).is_err(), "{threshold:?}");
    }
}
