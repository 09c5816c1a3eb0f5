use super::*;
use crate::test_signals::{coordinate, lorenz, noise, roessler, sines};
use Regime::{Chaotic, Noise, Periodic, QuasiPeriodic, Silent, Transient, Undetermined};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// Sample rate of these signals: 50 samples per period at 1 Hz.
const RATE: f64 = 50.0;

fn verdict(samples: &[f64]) -> Verdict {
    let search = RegimeSearch {
        sample_rate: RATE,
        silence: 0.0,
        background: 0.0,
    };
    classify(samples, &search).unwrap()
}

#[track_caller]
fn expect(regime: Regime, what: &str, samples: &[f64]) -> f64 {
    let found = verdict(samples);
    assert_eq!(found.regime, regime, "{what}: {found:#?}");
    found.confidence
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

fn tones(n: usize, tones: &[(f64, f64)]) -> Vec<f64> {
    let phased = tones.iter().zip([0.2, 1.1, 0.7]);
    let list: Vec<(f64, f64, f64)> = phased.map(|(&(f, a), phase)| (f, a, phase)).collect();
    sines(RATE, n, &list)
}

/// Two tones through a nonlinear function.
fn nonlinear(n: usize) -> Vec<f64> {
    let two = tones(n, &[(1.0, 1.0), (0.618_034, 0.6)]);
    two.iter()
        .map(|x| x + 0.4 * x * x - 0.2 * x * x * x)
        .collect()
}

fn roessler_x(n: usize, dt: f64, c: f64) -> Vec<f64> {
    coordinate(&roessler(n, dt, [0.2, 0.2, c], [1.0, 1.0, 0.0]), 0)
}

fn lorenz_x(n: usize, dt: f64) -> Vec<f64> {
    coordinate(&lorenz(n, dt, [1.0, 1.0, 1.0]), 0)
}

/// Coloured noise: `x_n = a x_(n-1) + b x_(n-2) + e_n`.
fn coloured(seed: u64, n: usize, a: f64, b: f64) -> Vec<f64> {
    let mut past = [0.0; 2];
    let step = |e: &f64| {
        past = [a * past[0] + b * past[1] + e, past[0]];
        past[0]
    };
    noise(seed, n + 2000, 1.0)
        .iter()
        .map(step)
        .skip(2000)
        .collect()
}

#[test]
fn tones_are_periodic() {
    for n in [3000, 8000] {
        for (seed, deviation) in [(1, 0.0), (2, 1e-3), (3, 1e-2), (4, 3e-2)] {
            let floor = noise(seed, n, deviation);
            let sine = sum(&tones(n, &[(1.03, 1.0)]), &floor);
            expect(Periodic, "sine", &sine);
            let rich = tones(n, &[(1.03, 1.0), (2.06, 0.3), (3.09, 0.2)]);
            expect(Periodic, "harmonics", &sum(&rich, &floor));
        }
    }
}

#[test]
fn harmonics_that_sampling_folds_belong_to_their_tone() {
    for frequency in [7.3, 9.1, 13.7] {
        let tone = sum(&tones(8000, &[(frequency, 1.0)]), &noise(5, 8000, 3e-3));
        let clipped: Vec<f64> = tone.iter().map(|x| x.clamp(-0.6, 0.6)).collect();
        let found = verdict(&clipped);
        let one_tone = found.evidence.iter().find(|it| it.criterion == "one tone");
        let (share, _) = one_tone.unwrap().description.split_once(" %").unwrap();
        assert!(share.parse::<f64>().unwrap() < 0.01, "{found:#?}");
        assert_ne!(found.regime, QuasiPeriodic, "{found:#?}");
    }
}

#[test]
fn two_tones_are_quasi_periodic() {
    for n in [4000, 8000] {
        for (seed, deviation) in [(1, 0.0), (2, 1e-3), (3, 1e-2)] {
            let floor = noise(seed, n, deviation);
            for (f, a) in [(0.618_034, 0.4), (1.618_034, 0.3), (1.0718, 0.4)] {
                let two = sum(&tones(n, &[(1.0, 1.0), (f, a)]), &floor);
                expect(QuasiPeriodic, "two tones", &two);
            }
            expect(QuasiPeriodic, "nonlinear", &sum(&nonlinear(n), &floor));
            let envelope = |i: usize| 1.0 + 0.3 * (TAU * 0.0618 * i as f64 / RATE).sin();
            let beat = tones(n, &[(1.0, 1.0), (2.0, 0.2)]);
            let beat: Vec<f64> = beat
                .iter()
                .enumerate()
                .map(|(i, x)| x * envelope(i))
                .collect();
            expect(QuasiPeriodic, "modulated", &sum(&beat, &floor));
        }
    }
    let three = tones(8000, &[(1.0, 1.0), (0.618_034, 0.4), (0.2723, 0.3)]);
    expect(QuasiPeriodic, "three tones", &three);
}

#[test]
fn roessler_doubles_its_period_and_becomes_chaotic() {
    for c in [2.5, 3.5, 4.0, 4.15] {
        assert!(expect(Periodic, "doubled", &roessler_x(8000, 0.1, c)) > 0.8);
    }
    for (dt, c) in [
        (0.1, 4.5),
        (0.1, 5.0),
        (0.05, 5.7),
        (0.1, 5.7),
        (0.2, 5.7),
        (0.1, 9.0),
    ] {
        assert!(expect(Chaotic, "chaos", &roessler_x(8000, dt, c)) > 0.8);
    }
    let floor = noise(7, 8000, 0.05);
    expect(Periodic, "noisy", &sum(&roessler_x(8000, 0.1, 4.0), &floor));
    expect(Chaotic, "noisy", &sum(&roessler_x(8000, 0.1, 5.7), &floor));
    // Four thin bands visited cyclically: nearly periodic, but not classified as periodic.
    assert_ne!(verdict(&roessler_x(8000, 0.1, 4.3)).regime, Periodic);
}

#[test]
fn lorenz_is_chaotic() {
    for dt in [0.01, 0.02, 0.04, 0.1] {
        expect(Chaotic, "x", &lorenz_x(8000, dt));
    }
    expect(Chaotic, "x", &lorenz_x(3000, 0.04));
    let z = coordinate(&lorenz(8000, 0.02, [1.0, 1.0, 1.0]), 2);
    expect(Chaotic, "z", &z);
    expect(
        Chaotic,
        "noisy",
        &sum(&lorenz_x(8000, 0.02), &noise(7, 8000, 0.2)),
    );
}

/// A tone and its octave with amplitudes modulated by a slow Roessler system, ten periods of the tone
/// per cycle of the system.
fn slowly_modulated(n: usize, c: f64) -> Vec<f64> {
    let slow = roessler(n, 5.86 / (10.0 * RATE), [0.2, 0.2, c], [1.0, 1.0, 0.0]);
    let tone = tones(n, &[(1.0309, 1.0)]).into_iter();
    let both = tone.zip(tones(n, &[(2.0618, 1.0)])).zip(slow);
    both.map(|((tone, octave), [x, y, _])| (1.0 + 0.08 * x) * tone + (0.3 + 0.04 * y) * octave)
        .collect()
}

#[test]
fn chaos_slower_than_the_tone_is_distinguished_from_a_torus() {
    // At 5.7 neighbours diverge by 4 % per period of the tone; at 2.5 the modulation is periodic.
    for n in [20_000, 40_000] {
        expect(Chaotic, "weak chaos", &slowly_modulated(n, 5.7));
        expect(QuasiPeriodic, "torus", &slowly_modulated(n, 2.5));
    }
}

#[test]
fn a_growing_torus_is_not_classified_as_chaotic() {
    for growth in [0.1, 0.3] {
        let n = 8000;
        let second = tones(n, &[(0.94, growth)]);
        let grows = |i: usize| i as f64 / n as f64;
        let second: Vec<f64> = second
            .iter()
            .enumerate()
            .map(|(i, x)| x * grows(i))
            .collect();
        let found = verdict(&sum(&tones(n, &[(1.0, 1.0)]), &second));
        assert_ne!(found.regime, Chaotic, "{found:#?}");
    }
}

#[test]
fn noise_of_any_colour_is_noise() {
    for seed in 1..6 {
        assert!(expect(Noise, "white", &noise(seed, 8000, 1.0)) > 0.8);
        expect(Noise, "white", &noise(seed, 2500, 1.0));
        for memory in [0.3, 0.6, 0.8, 0.9, 0.99] {
            for n in [2500, 8000] {
                let found = verdict(&coloured(seed, n, memory, 0.0));
                let accepted = [Noise, Undetermined].contains(&found.regime);
                assert!(accepted, "{memory} {n} {seed}: {found:#?}");
            }
        }
        // Resonances of decreasing bandwidth.
        for radius in [0.9_f64, 0.99, 0.997] {
            let a = 2.0 * radius * (TAU * 0.02).cos();
            let found = verdict(&coloured(seed, 8000, a, -radius * radius));
            let accepted = [Noise, Undetermined].contains(&found.regime);
            assert!(accepted, "{radius} {seed}: {found:#?}");
        }
    }
    expect(Noise, "coloured", &coloured(1, 8000, 0.8, 0.0));
}

#[test]
fn nonstationary_signals_are_transient() {
    let n = 6000;
    let shaped = |envelope: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let tone = tones(n, &[(1.0, 1.0)]).into_iter().enumerate();
        tone.map(|(i, x)| x * envelope(i as f64 / n as f64))
            .collect()
    };
    for rate in [-3.0, -1.0, -0.4, 1.0, 4.0, 12.0] {
        expect(Transient, "exponential", &shaped(&|t| (rate * t).exp()));
    }
    expect(Transient, "fade", &shaped(&|t| 1.0 - t));
    expect(
        Transient,
        "onset",
        &shaped(&|t| (12.0 * (t - 0.5)).exp().min(1.0)),
    );
    for widening in [0.05, 0.2, 1.0] {
        let phase = |i: usize| {
            let t = i as f64 / n as f64;
            TAU * 0.02 * (1.0 + 0.5 * widening * t) * i as f64
        };
        let chirp: Vec<f64> = (0..n).map(|i| phase(i).sin()).collect();
        let found = verdict(&chirp).regime;
        assert!(
            [Transient, Undetermined].contains(&found),
            "chirp {widening}: {found}"
        );
    }
}

#[test]
fn a_chirp_over_octaves_is_a_transient() {
    let n = 20_000;
    for (from, to) in [(200.0, 3800.0), (100.0, 10_000.0), (1000.0, 1500.0)] {
        let phase = |i: usize| {
            let t = i as f64 / 44_100.0;
            let length = n as f64 / 44_100.0;
            TAU * (from * t + (to - from) * t * t / (2.0 * length))
        };
        let chirp: Vec<f64> = (0..n).map(|i| phase(i).sin()).collect();
        expect(Transient, "chirp", &chirp);
    }
}

#[test]
fn spikes_and_bursts_are_transient() {
    let mut spike = vec![0.0; 4000];
    spike[2000] = 1.0;
    expect(Transient, "spike", &spike);
    let mut burst = tones(6000, &[(1.0, 1.0)]);
    burst[..3000].fill(0.0);
    burst[4500..].fill(0.0);
    expect(Transient, "burst", &burst);
}

#[test]
fn maps_are_not_noise() {
    let mut x = 0.3;
    let logistic: Vec<f64> = (0..5000)
        .map(|_| {
            x = 3.99 * x * (1.0 - x);
            x
        })
        .collect();
    expect(Chaotic, "logistic map", &logistic);
    let mut at = [0.1, 0.1];
    let henon: Vec<f64> = (0..5000)
        .map(|_| {
            at = [1.0 - 1.4 * at[0] * at[0] + at[1], 0.3 * at[0]];
            at[0]
        })
        .collect();
    expect(Chaotic, "Henon map", &henon);
}

#[test]
fn constant_signals_are_silent() {
    for still in [0.0, 1.0, -3e8, 1e-300] {
        let found = verdict(&[still; 500]);
        assert_eq!((found.regime, found.confidence), (Silent, 1.0));
    }
    let rounding: Vec<f64> = (0..500)
        .map(|i| 1.0 + f64::EPSILON * f64::from(i % 3))
        .collect();
    assert_eq!(verdict(&rounding).regime, Silent);
    let tone = tones(4000, &[(1.03, 1e-6)]);
    let within = |silence| {
        let search = RegimeSearch {
            sample_rate: RATE,
            silence,
            background: 0.0,
        };
        classify(&tone, &search).unwrap()
    };
    assert_eq!(within(2e-6).regime, Silent);
    assert!(within(1e-4).confidence > within(2e-6).confidence);
    assert_eq!(within(0.9e-6).regime, Periodic);
}

#[test]
fn short_records_are_undetermined() {
    for signal in [
        tones(400, &[(1.0, 1.0)]),
        roessler_x(500, 0.1, 5.7),
        lorenz_x(400, 0.02),
    ] {
        let found = verdict(&signal);
        assert_eq!(found.regime, Undetermined);
    }
    for n in [64, 65, 100, 200] {
        for signal in [tones(n, &[(1.0, 1.0)]), noise(3, n, 1.0)] {
            assert_eq!(verdict(&signal).regime, Undetermined, "{n}");
        }
    }
    let rejected = classify(
        &[0.0; 63],
        &RegimeSearch {
            sample_rate: 1.0,
            silence: 0.0,
            background: 0.0,
        },
    );
    assert!(matches!(
        rejected,
        Err(AnalysisError::TooShort {
            have: 63,
            need: 64,
            ..
        })
    ));
}

#[test]
fn confidence_follows_the_evidence() {
    let confidence = |signal: &[f64]| verdict(signal).confidence;
    let sine = |n, deviation| sum(&tones(n, &[(1.03, 1.0)]), &noise(1, n, deviation));
    assert!(confidence(&sine(8000, 0.0)) > confidence(&sine(8000, 0.05)));
    assert!(confidence(&sine(8000, 0.0)) > confidence(&sine(1200, 0.0)));
    assert!(confidence(&roessler_x(8000, 0.1, 5.7)) > confidence(&roessler_x(8000, 0.1, 4.3)));
    assert!(confidence(&lorenz_x(8000, 0.02)) > confidence(&lorenz_x(1500, 0.02)));
}

#[test]
fn amplitude_offset_and_time_unit_do_not_change_the_verdict() {
    for signal in [
        nonlinear(4000),
        roessler_x(4000, 0.1, 5.7),
        noise(1, 4000, 1.0),
    ] {
        let plain = verdict(&signal);
        // A power of two scales without rounding.
        let scaled: Vec<f64> = signal.iter().map(|x| x * 2.0_f64.powi(-60)).collect();
        assert_eq!(verdict(&scaled), plain);
        let moved: Vec<f64> = signal.iter().map(|x| 1e-9 * (x + 5.0)).collect();
        let moved = verdict(&moved);
        assert_eq!(moved.regime, plain.regime);
        assert!((moved.confidence - plain.confidence).abs() < 0.02);
        let fast = RegimeSearch {
            sample_rate: 4000.0 * RATE,
            silence: 0.0,
            background: 0.0,
        };
        let fast = classify(&signal, &fast).unwrap();
        assert_eq!(fast.regime, plain.regime);
        assert!((fast.confidence - plain.confidence).abs() < 1e-6);
    }
}

#[test]
fn all_parts_of_a_long_record_count() {
    // Coarsely sampled, so that none are averaged: four intervals of a torus, and one of a tone.
    let mut signal = tones(40_000, &[(8.03, 1.0), (5.1, 0.6)]);
    signal.extend(tones(10_000, &[(8.03, 1.0)]));
    let found = verdict(&signal);
    assert_eq!(found.regime, QuasiPeriodic, "{found:#?}");
    assert!(found.confidence < 0.85, "{}", found.confidence);
    let starts: Vec<f64> = found.intervals.iter().map(|it| it.start_s).collect();
    assert_eq!(starts, [0.0, 200.0, 400.0, 600.0, 800.0]);
    assert_eq!(found.intervals[4].end_s, 1000.0);
    // With 50 samples per period, four are averaged: one interval is the whole record.
    let found = verdict(&tones(40_000, &[(1.03, 1.0)]));
    assert_eq!((found.regime, found.intervals.len()), (Periodic, 1));
    // A part that is silent belongs to a transient.
    let mut signal = vec![0.0; 20_000];
    signal.extend(tones(20_000, &[(8.03, 1.0)]));
    assert_ne!(verdict(&signal).regime, Periodic);
}

#[test]
fn a_tone_is_not_averaged_away() {
    let tone = tones(30_000, &[(11.0, 1.0)]);
    let rumble = coloured(1, 30_000, 0.97, 0.0);
    let signal: Vec<f64> = tone.iter().zip(rumble).map(|(x, e)| x + 0.3 * e).collect();
    let found = verdict(&signal);
    let one_tone = found.evidence.iter().find(|it| it.criterion == "one tone");
    let description = &one_tone.unwrap().description;
    assert!(description.contains("11.0 Hz"), "{description}");
}

#[test]
fn a_torus_at_the_rate_of_a_sound_is_quasi_periodic() {
    // The lines of `torus-1.75deg` as a sound of 0.2 s: 12 samples per period, 822 periods.
    let (f1, f2) = (4108.738, 3868.889);
    let lines = [
        (f1, 0.607),
        (3.0 * f1, 0.239),
        (f1 + f2, 0.073),
        (f2, 0.068),
        (2.0 * f1, 0.051),
        (4.0 * f1, 0.044),
        (2.0 * f1 + f2, 0.038),
        (4.0 * f1 - f2, 0.032),
        (5.0 * f1, 0.021),
    ];
    let phased = lines.iter().zip(0..);
    let phased: Vec<_> = phased
        .map(|(&(f, a), k)| (f, a, 0.7 * f64::from(k)))
        .collect();
    let search = RegimeSearch {
        sample_rate: 48_000.0,
        silence: 0.0,
        background: 0.0,
    };
    let found = classify(&sines(48_000.0, 9600, &phased), &search).unwrap();
    assert_eq!(found.regime, QuasiPeriodic, "{found:#?}");
}

#[test]
fn evidence_is_sorted_and_in_sentences() {
    let signals = [
        tones(3000, &[(1.03, 1.0)]),
        nonlinear(3000),
        roessler_x(6000, 0.1, 5.7),
        noise(2, 3000, 1.0),
        tones(300, &[(1.0, 1.0)]),
        vec![1.0; 100],
    ];
    for signal in &signals {
        let found = verdict(signal);
        assert!(!found.evidence.is_empty());
        for piece in &found.evidence {
            assert!(piece.description.ends_with('.') && piece.contribution >= 0.0);
        }
        assert!(
            found
                .evidence
                .is_sorted_by(|a, b| a.contribution >= b.contribution)
        );
    }
}

#[test]
fn an_undetermined_verdict_gives_its_reason_instead_of_a_confidence() {
    let short = verdict(&tones(400, &[(1.0, 1.0)]));
    assert_eq!(
        (short.regime, short.limitation),
        (Undetermined, Some(Limitation::TooShort))
    );
    assert!(!short.summary().contains('%') && short.decided_confidence().is_none());
    assert!(
        verdict(&roessler_x(8000, 0.1, 5.7))
            .summary()
            .starts_with("chaotic, confidence ")
    );
}

#[test]
fn a_modulated_tone_is_named_as_such() {
    let envelope = |i: usize| 1.0 + 0.4 * (TAU * 0.0618 * i as f64 / RATE).sin();
    let tone = tones(8000, &[(1.0, 1.0), (2.0, 0.2)]);
    let tone: Vec<f64> = tone
        .iter()
        .enumerate()
        .map(|(i, x)| x * envelope(i))
        .collect();
    let found = verdict(&tone);
    assert_eq!(
        (found.regime, found.limitation),
        (QuasiPeriodic, Some(Limitation::Modulation))
    );
    assert_eq!(verdict(&nonlinear(8000)).limitation, None);
    // Slower than a fiftieth of the frequency, as a squeak is modulated.
    for depth in [0.3, 0.7] {
        let envelope = |i: usize| 1.0 + depth * (TAU * 0.019 * i as f64 / RATE).sin();
        let squeak = tones(16_000, &[(1.0, 1.0), (2.0, 0.2)]);
        let squeak = squeak.iter().enumerate().map(|(i, x)| x * envelope(i));
        let found = verdict(&squeak.collect::<Vec<f64>>());
        assert_eq!(
            (found.regime, found.limitation),
            (Periodic, Some(Limitation::Modulated))
        );
    }
    assert_eq!(verdict(&tones(8000, &[(1.0, 1.0)])).limitation, None);
}

#[test]
fn a_change_from_chaos_to_a_limit_cycle_is_a_transient() {
    let mut both = roessler_x(4000, 0.1, 5.7);
    both.extend(roessler_x(4000, 0.1, 3.0));
    expect(Transient, "change", &both);
}

#[test]
fn threads_do_not_change_the_verdict() {
    let signal = roessler_x(5000, 0.1, 5.7);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| verdict(&signal))
    };
    assert_eq!(with(1), with(3));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Every finite signal gets a verdict with finite numbers.
    #[test]
    fn any_signal_gets_a_verdict(
        n in 64..900_usize,
        seed in 0..1000_u64,
        levels in 1..6_i32,
        frequency in 0.001..0.5_f64,
        deviation in prop::sample::select(vec![0.0, 1e-6, 0.1, 10.0]),
        run in 1..40_usize,
    ) {
        // Steps of a few levels with runs of equal samples; impulses if there are few levels.
        let e = noise(seed, n, deviation);
        let step = |i: usize| {
            let i = i / run * run;
            let x = (TAU * frequency * i as f64).sin() + e[i];
            (x * f64::from(levels)).round() / f64::from(levels)
        };
        let signal: Vec<f64> = (0..n).map(step).collect();
        let found = verdict(&signal);
        prop_assert!((0.0..=1.0).contains(&found.confidence));
        prop_assert!(!found.evidence.is_empty());
        for piece in &found.evidence {
            prop_assert!(piece.contribution.is_finite(), "{piece:?}");
        }
    }
}
