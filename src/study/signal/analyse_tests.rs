//! The analysis of a signal: thresholds, results as JSON, ranges.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::*;
use crate::analysis::test_signals::{noise, sines};

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
    let report = analyse_signal(signal, &search, &mut |_, _| true);
    report.map(|report| report.expect("the callback never stops it"))
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

fn assert_read_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(result: &T) {
    let json = serde_json::to_value(result).unwrap();
    assert_eq!(&T::deserialize(json).unwrap(), result);
}

#[test]
fn results_survive_a_json_round_trip() {
    let tones = sines(1000.0, 3000, &[(23.0, 1.0, 0.2), (37.3, 0.6, 1.0)]);
    for threshold in [Threshold::Spread(0.3), Threshold::Neighbours(20)] {
        let report = report(tones.clone(), threshold).unwrap();
        assert_read_back(&report.facts);
        assert_read_back(&report.verdict);
        assert_read_back(&report.tones);
        assert_read_back(&report.embedding);
        assert_read_back(&report.section);
        assert_read_back(&report.rosenstein);
        assert_read_back(&report.kantz);
        assert_read_back(&ZeroOne {
            path: Vec::new(),
            ..report.zero_one.get().unwrap().clone()
        });
        assert_read_back(&RecurrenceAnalysis {
            picture: RecurrenceImage::default(),
            ..report.recurrence.get().unwrap().clone()
        });
    }
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
