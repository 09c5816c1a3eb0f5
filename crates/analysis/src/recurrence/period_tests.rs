use super::RecurrenceKind::{Beat, Doubled, Finest};
use super::*;
use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};
use crate::{
    delay::DelayVectors,
    norm::Norm,
    recurrence::{RecurrenceCriterion, Recurrences, Threshold},
};

fn counts(signal: &[f64], lag: usize, dimension: usize, rate: f64) -> RecurrenceCounts {
    let vectors = DelayVectors::new(signal, lag, dimension).unwrap();
    let rule = RecurrenceCriterion {
        norm: Norm::Euclidean,
        threshold: Threshold::Rate(rate),
        theiler: 1,
    };
    Recurrences::of(&vectors, &rule).unwrap().counts()
}

/// Periods of 20 ms of tones (Hz, amplitude) sampled at 200 kHz, in ms.
fn of_tones(tones: &[(f64, f64)], rate: f64) -> RecurrencePeriods {
    let phased = (0..).map(f64::from).zip(tones);
    let tones: Vec<_> = phased.map(|(k, &(f, a))| (f, a, 0.3 + 0.8 * k)).collect();
    let signal = sines(200e3, 4060, &tones);
    counts(&signal, 12, 5, rate).periods().in_seconds(5e-3)
}

/// The periods have these kinds and values, within a relative tolerance.
fn assert_periods(found: &RecurrencePeriods, expected: &[(RecurrenceKind, f64)], within: f64) {
    let kinds = |all: &[(RecurrenceKind, f64)]| all.iter().map(|p| p.0).collect::<Vec<_>>();
    let pairs: Vec<_> = found.0.iter().map(|p| (p.kind, p.period)).collect();
    assert_eq!(kinds(&pairs), kinds(expected), "{found:?}");
    for (found, expected) in pairs.iter().zip(expected) {
        assert!(
            (found.1 / expected.1 - 1.0).abs() < within,
            "{pairs:?} {expected:?}"
        );
    }
}

#[test]
fn the_period_of_a_sine_is_found() {
    for period in [20.0, 24.813, 41.37, 100.5, 163.0] {
        let signal = sines(1.0, 2000, &[(1.0 / period, 3.0, 0.7)]);
        for (lag, dimension, rate) in [(7, 2, 0.1), (10, 3, 0.2), (20, 5, 0.15)] {
            let found = counts(&signal, lag, dimension, rate).periods();
            assert_periods(&found, &[(Finest, period)], 1e-2 / period);
        }
    }
}

#[test]
fn the_period_is_found_with_harmonics_and_noise() {
    let tones = [(0.02, 1.0, 0.0), (0.04, 0.8, 1.0), (0.1, 0.3, 2.0)];
    let white = noise(5, 1500, 0.05);
    let signal = sines(1.0, 1500, &tones);
    let signal: Vec<f64> = signal.iter().zip(white).map(|(a, b)| a + b).collect();
    assert_periods(
        &counts(&signal, 9, 5, 0.05).periods(),
        &[(Finest, 50.0)],
        1e-3,
    );
    let found = of_tones(&[(4110.7, 1.0), (8221.4, 0.5), (12_332.1, 0.2)], 0.1);
    assert_periods(&found, &[(Finest, 1e3 / 4110.7)], 1e-4);
    let share = found.last(Finest).unwrap().share;
    assert!((0.5..1.0).contains(&share), "{share}");
}

/// The two tones of Kang et al. (2022) at 3.5 degrees, 3.87 kHz and 12.18 kHz. The plot repeats with
/// 0.57 kHz, the difference between the second tone and the third harmonic of the first.
#[test]
fn a_torus_has_two_periods() {
    let rate = 200e3;
    let signal = sines(rate, 2500, &[(3870.0, 1.0, 0.3), (12_180.0, 0.5, 1.1)]);
    let found = counts(&signal, 8, 5, 0.05).periods().in_seconds(1.0 / rate);
    assert_periods(&found, &[(Finest, 1.0 / 3870.0), (Beat, 1.0 / 570.0)], 5e-3);
}

#[test]
fn the_beat_is_found_at_any_ratio_and_depth() {
    for (second, amplitude, rate, beat) in [
        (12_180.0, 0.5, 0.1, 1e3 / 150.0),
        (3870.0, 0.5, 0.05, 1e3 / 240.0),
        (3870.0, 0.5, 0.1, 1e3 / 240.0),
        (3870.0, 0.1, 0.1, 1e3 / 240.0),
        (5930.0, 0.4, 0.1, 1e3 / 1820.0),
        (4110.0 * 1.618_034, 0.4, 0.1, 1e3 / (4110.0 * 0.381_966)),
    ] {
        let found = of_tones(&[(4110.0, 1.0), (second, amplitude)], rate);
        assert_periods(&found, &[(Finest, 1e3 / 4110.0), (Beat, beat)], 6e-3);
        let [finest, beat] = [found.last(Finest).unwrap(), found.last(Beat).unwrap()];
        assert!(beat.share < finest.share && beat.share > 0.0, "{found:?}");
        assert!(beat.uncertainty > finest.uncertainty && beat.uncertainty < 0.01 * beat.period);
    }
}

#[test]
fn doublings_are_told_from_beats() {
    let torus = [(4110.0, 1.0), (3870.0, 0.5), (3990.0, 0.2)];
    let expected = [(Finest, 0.2433), (Beat, 4.1667), (Doubled, 8.3333)];
    for rate in [0.05, 0.1] {
        assert_periods(&of_tones(&torus, rate), &expected, 3e-3);
    }
    let twice = [(Finest, 0.2433), (Doubled, 0.4866)];
    assert_periods(
        &of_tones(&[(4110.0, 1.0), (2055.0, 0.2)], 0.1),
        &twice,
        1e-3,
    );
    let four = [(4110.0, 1.0), (2055.0, 0.2), (1027.5, 0.1)];
    let expected = [twice[0], twice[1], (Doubled, 0.9732)];
    assert_periods(&of_tones(&four, 0.05), &expected, 1e-3);
}

/// The second beat, 333 Hz, is not listed.
#[test]
fn three_tones_have_the_shorter_beat() {
    let found = of_tones(&[(4110.0, 1.0), (4830.0, 0.4), (3777.0, 0.3)], 0.1);
    assert_periods(&found, &[(Finest, 0.24331), (Beat, 1e3 / 720.0)], 5e-3);
}

/// The Roessler system doubles its period at c = 2.83, 3.86 and 4.12 (a = b = 0.2).
#[test]
fn the_period_doublings_of_the_roessler_system_are_found() {
    for (c, expected) in [
        (2.5, &[(Finest, 5.749)][..]),
        (3.5, &[(Finest, 5.7726), (Doubled, 11.545)]),
        (
            4.0,
            &[(Finest, 5.7943), (Doubled, 11.589), (Doubled, 23.177)],
        ),
    ] {
        let states = roessler(4060, 0.12, [0.2, 0.2, c], [1.0, 1.0, 0.0]);
        let found = counts(&coordinate(&states, 0), 12, 5, 0.05).periods();
        assert_periods(&found.in_seconds(0.12), expected, 1e-3);
    }
}

#[test]
fn chaos_has_at_most_the_finest_period() {
    for start in [[1.0, 1.0, 20.0], [1.4, 1.0, 20.0], [-3.0, 2.0, 25.0]] {
        let states = lorenz(4060, 0.015, start);
        for c in [0, 2] {
            let found = counts(&coordinate(&states, c), 12, 5, 0.1).periods();
            assert!(
                found.0.iter().all(|period| period.kind == Finest),
                "{found:?}"
            );
        }
        let states = roessler(4060, 0.12, [0.2, 0.2, 5.7], [start[0], 1.0, 0.0]);
        let found = counts(&coordinate(&states, 0), 12, 5, 0.1).periods();
        // Its orbits take nearly equal times.
        assert_periods(&found.in_seconds(0.12), &[(Finest, 5.86)], 5e-3);
    }
}

#[test]
fn noise_and_constant_signals_have_no_period() {
    for seed in 0..20 {
        let white = noise(seed, 600, 1.0);
        for (lag, dimension) in [(1, 1), (1, 3), (20, 5)] {
            for rate in [0.01, 0.05, 0.2] {
                let found = counts(&white, lag, dimension, rate).periods();
                assert_eq!(
                    found,
                    RecurrencePeriods::default(),
                    "{seed} {lag} {dimension} {rate}"
                );
            }
        }
        let walk: Vec<f64> = noise(seed, 2000, 1.0)
            .iter()
            .scan(0.0, |sum, step| {
                *sum += step;
                Some(*sum)
            })
            .collect();
        let found = counts(&walk, 12, 5, 0.1).periods();
        assert_eq!(found, RecurrencePeriods::default(), "walk {seed}");
    }
    let none = RecurrencePeriods::default();
    assert_eq!(counts(&[1.0; 300], 2, 3, 0.05).periods(), none);
    assert_eq!(counts(&[1.0; 3], 1, 1, 0.05).periods(), none);
    assert_eq!(RecurrenceCounts::default().periods(), none);
    assert_eq!(none.last(Finest), None);
}

#[test]
fn the_number_of_threads_does_not_change_the_periods() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let of = || of_tones(&[(4110.0, 1.0), (3870.0, 0.5)], 0.1);
        pool.build().unwrap().install(of)
    };
    let one = with(1);
    assert!(one.last(Beat).is_some());
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}
