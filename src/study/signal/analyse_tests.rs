//! The analysis of a signal: thresholds, ranges.

use super::*;
use crate::analysis::poincare::SectionShape;
use crate::test_signals::{noise, sines};

fn report(samples: Vec<f64>, threshold: Threshold) -> Result<SignalAnalysis, SignalError> {
    let signal = Signal {
        name: "u".to_owned(),
        unit: String::new(),
        rate: 1000.0,
        start: 0.0,
        samples,
    };
    let search = SignalOptions {
        threshold: Some(threshold),
        ..SignalOptions::default()
    };
    analyse_signal(signal, &search, &mut |_, _| Ok(()))
}

#[test]
fn the_report_has_the_numbers_of_the_result() {
    let tones = sines(1000.0, 2000, &[(23.0, 1.0, 0.2), (61.7, 0.4, 0.0)]);
    let found = report(tones, Threshold::Rate(0.05)).unwrap();
    // JSON has the logarithms of these factors.
    let evidence = &found.verdict.get().unwrap().evidence;
    let factors: Vec<f64> = evidence.iter().map(|piece| piece.factor()).collect();
    crate::report::agreement::check(&found, &factors);
}

#[test]
fn the_picture_uses_the_requested_threshold() {
    let tone = sines(1000.0, 1500, &[(23.0, 1.0, 0.2)]);
    let signal: Vec<f64> = tone
        .iter()
        .zip(noise(1, 1500, 0.02))
        .map(|(a, b)| a + b)
        .collect();
    let share = |threshold| {
        let recurrence = report(signal.clone(), threshold).unwrap().recurrence;
        let pixels = &recurrence.get().unwrap().picture.recurrent;
        let black = pixels.iter().filter(|&&p| p == 255).count() as f64;
        black / pixels.len() as f64
    };
    // All distances are below this threshold.
    assert_eq!(share(Threshold::Distance(100.0)), 1.0);
    assert_eq!(share(Threshold::Spread(100.0)), 1.0);
    assert_eq!(share(Threshold::Neighbours(10_000)), 1.0);
    assert!((share(Threshold::Rate(0.3)) - 0.3).abs() < 0.01);
}

/// A modulated tone in noise: after ten periods nearby states differ by the noise, which is no chaos.
#[test]
fn a_tone_in_noise_is_not_called_chaotic() {
    const RATE: f64 = 16_000.0;
    let mut samples = noise(3, 64_000, 0.02);
    for (i, x) in samples.iter_mut().enumerate() {
        let t = i as f64 / RATE;
        let ramp = ((t - 1.0).min(3.0 - t) / 0.02).clamp(0.0, 1.0);
        let modulation = 1.0 + 0.4 * (std::f64::consts::TAU * 12.0 * t).cos();
        *x += 0.1 * ramp * modulation * (std::f64::consts::TAU * 2100.0 * t).sin();
    }
    let signal = Signal {
        name: "squeak".to_owned(),
        unit: "FS".to_owned(),
        rate: RATE,
        start: 0.0,
        samples,
    };
    let report = analyse_signal(signal, &SignalOptions::default(), &mut |_, _| Ok(()));
    let report = report.unwrap();
    assert_eq!(report.stretch.event, Some(1));
    // That the noise hides the motion is an answer, too.
    let is_chaotic = |verdict: &Verdict| verdict.regime == Regime::Chaotic;
    assert!(
        !report.verdict.get().is_ok_and(is_chaotic),
        "{:?}",
        report.verdict
    );
}

/// The third harmonic has 2.6 samples per period: between them, a polynomial is wrong by 3 % of the amplitude.
#[test]
fn section_and_recurrences_of_a_periodic_signal_have_its_period() {
    const RATE: f64 = 48_000.0;
    const F1: f64 = 6200.7;
    let tones: Vec<_> = (1..=3)
        .map(f64::from)
        .map(|k| (k * F1, 0.3 / k, 1.7 * k))
        .collect();
    let signal = Signal {
        name: "squeak".to_owned(),
        unit: "FS".to_owned(),
        rate: RATE,
        start: 2.0,
        samples: sines(RATE, 30_000, &tones),
    };
    let report = analyse_signal(signal, &SignalOptions::default(), &mut |_, _| Ok(())).unwrap();
    let section = report.section.get().unwrap();
    assert_eq!(section.shape, SectionShape::Points(1));
    let period = section.mean_return_time_s.unwrap();
    assert!((period * F1 - 1.0).abs() < 1e-6, "{period}");
    // The samples are 20 / 48 kHz = 2.6 periods apart where they recur.
    let recurrence = report.recurrence.get().unwrap();
    let time = recurrence.measures.recurrence_time_2.unwrap();
    assert!((0.9..1.2).contains(&(time * F1)), "{time}");
    // Times are those of the recording.
    for crossing in &section.crossings {
        let tone = |(f, a, phase): &(f64, f64, f64)| {
            a * (std::f64::consts::TAU * f * (crossing.time_s - 2.0) + phase).sin()
        };
        let value: f64 = tones.iter().map(tone).sum();
        assert!((value - crossing.at[0]).abs() < 1e-3, "{crossing:?}");
    }
}

#[test]
fn the_options_of_recurrence_analysis_apply() {
    let tone = sines(1000.0, 2000, &[(23.0, 1.0, 0.2), (61.7, 0.4, 0.0)]);
    let recurrence = |options: SignalOptions| {
        let signal = Signal {
            name: "tone".to_owned(),
            unit: String::new(),
            rate: 1000.0,
            start: 0.0,
            samples: tone.clone(),
        };
        let report = analyse_signal(signal, &options, &mut |_, _| Ok(())).unwrap();
        report.recurrence.get().unwrap().clone()
    };
    let plain = recurrence(SignalOptions::default());
    assert_eq!(
        (plain.min_diagonal_states, plain.min_vertical_states),
        (2, 2)
    );
    assert!(!plain.line_of_identity);
    let given = recurrence(SignalOptions {
        norm: Norm::Maximum,
        theiler: Some(0),
        min_diagonal: Some(40),
        min_vertical: Some(3),
        ..SignalOptions::default()
    });
    assert_eq!(given.rule.norm, Norm::Maximum);
    assert_eq!(given.rule.theiler, 0);
    assert!(given.line_of_identity);
    // The line of identity is the longest diagonal.
    let states = given.states as f64 * given.stride_samples as f64 / 1000.0;
    assert_eq!(given.measures.longest_diagonal, states);
    let longer = recurrence(SignalOptions {
        min_diagonal: Some(40),
        min_vertical: Some(3),
        ..SignalOptions::default()
    });
    assert!(longer.measures.determinism < plain.measures.determinism);
    assert!(longer.measures.laminarity < plain.measures.laminarity);
    let apart = recurrence(SignalOptions {
        theiler: Some(101),
        ..SignalOptions::default()
    });
    assert_eq!(apart.rule.theiler, 101_usize.div_ceil(apart.stride_samples));
}

#[test]
fn samples_whose_squares_overflow_or_underflow_are_rejected() {
    let tone = sines(1000.0, 600, &[(23.0, 1.0, 0.2)]);
    for factor in [1e-200, 1e-145, 1e145, 1e300] {
        let scaled = tone.iter().map(|x| factor * x).collect();
        let error = report(scaled, Threshold::Rate(0.05)).unwrap_err();
        assert_eq!(
            error,
            SignalError::Analysis(AnalysisError::SampleRange),
            "{factor}"
        );
    }
    for factor in [1e-130, 1e130] {
        let scaled = tone.iter().map(|x| factor * x).collect();
        let report = report(scaled, Threshold::Rate(0.05)).unwrap();
        assert_eq!(
            report.embedding.get().unwrap().choice.dimension,
            2,
            "{factor}"
        );
        assert!((report.tones.lines[0].line.frequency - 23.0).abs() < 0.01);
    }
}
