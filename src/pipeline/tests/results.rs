//! Results of the analyses of known signals.

use std::f64::consts::TAU;

use super::*;
use crate::analysis::{
    poincare::Direction,
    recurrence::{RecurrenceImage, Threshold},
};
use crate::pipeline::message::SectionPoint;
use crate::scene::StateCoordinate;

#[test]
fn section_points_agree_with_the_closed_form() {
    // y = A sin(w t) rises through 0 at t + lag = k T: y(t) = -A sin(w lag), y(t + 2 lag) = A sin(w lag).
    let (frequency, speed) = (4003.0, 10e-3);
    let motion = Motion::tones(0.01, &[(frequency, speed, 0.0)]);
    let spec = AnalysisSpec {
        section: Some(SectionSpec {
            every: 0.5e-3,
            surface: SectionSurface::Delay {
                lag: Some(60e-6),
                level: 0.0,
            },
            direction: Direction::Rising,
        }),
        ..AnalysisSpec::default()
    };
    let points = passages(&run(spec, &motion, 256));
    assert!(points.len() >= 38, "{}", points.len());
    let amplitude = speed / (TAU * frequency);
    let side = amplitude * (TAU * frequency * 60e-6).sin();
    // The first crossing is so close to the start that it is interpolated linearly.
    for (k, point) in points.iter().enumerate().skip(1) {
        // The velocity is a sine: the displacement rises through 0 after 1/4, 5/4, ... periods.
        let due = T0 + (k as f64 + 0.25) / frequency - 60e-6;
        assert!((point.time_s - due).abs() < 1e-12, "{k}");
        assert!((point.at[0] + side).abs() < 1e-6 * amplitude);
        assert!((point.at[1] - side).abs() < 1e-6 * amplitude);
    }
}

#[test]
fn a_plane_cuts_the_modal_state() {
    // q1 = sin, q2 = 2 cos; through q1 = 0.5 upwards, q2 is 2 cos(30 deg) and dq1/dt is w cos(30 deg).
    let omega = TAU * 4003.0;
    let frames = Motion::tones(0.005, &CYCLE).frames(T0, 0.05, 256);
    let with_modes = |(index, frame): (usize, &Arc<Frame>)| {
        let phases = (0..frame.len()).map(|k| omega * (256 * index + k) as f64 / RATE);
        let phases: Vec<f64> = phases.collect();
        Arc::new(Frame {
            modes: 2,
            q: phases
                .iter()
                .flat_map(|p| [p.sin(), 2.0 * p.cos()])
                .collect(),
            qdot: phases
                .iter()
                .flat_map(|p| [omega * p.cos(), -2.0 * omega * p.sin()])
                .collect(),
            ..Frame::clone(frame)
        })
    };
    let spec = AnalysisSpec {
        section: Some(SectionSpec {
            every: 1e-3,
            surface: SectionSurface::State {
                normal_q: vec![1.0],
                normal_qdot: Vec::new(),
                offset: 0.5,
                shown: [StateCoordinate::Q(1), StateCoordinate::Qdot(0)],
            },
            direction: Direction::Rising,
        }),
        ..AnalysisSpec::default()
    };
    let mut analyser = Analyser::new(&spec, &header());
    let mut records: Vec<Record> = Vec::new();
    for frame in frames.iter().enumerate().map(with_modes) {
        analyser.push(&frame, &mut records).unwrap();
    }
    let points = passages(&records);
    assert_eq!(points.len(), 20);
    let cosine = 0.75_f64.sqrt();
    for point in points {
        assert!(
            (point.at[0] / (2.0 * cosine) - 1.0).abs() < 1e-6,
            "{point:?}"
        );
        assert!(
            (point.at[1] / (omega * cosine) - 1.0).abs() < 1e-6,
            "{point:?}"
        );
    }
}

fn passages(records: &[Record]) -> Vec<SectionPoint> {
    let mut all = Vec::new();
    for record in records {
        if let Record::Section { points, .. } = record {
            all.extend_from_slice(points);
        }
    }
    assert!(all.is_sorted_by(|a, b| a.time_s < b.time_s));
    all
}

#[test]
fn plot_and_quantification_accept_every_threshold() {
    let motion = Motion::tones(0.01, &TORUS);
    let thresholds = [
        Threshold::Distance(3e-7),
        Threshold::Spread(0.3),
        Threshold::Rate(0.1),
        Threshold::Neighbours(10),
    ];
    for threshold in thresholds {
        let mut spec = AnalysisSpec {
            recurrence: all_analyses().recurrence,
            quantification: all_analyses().quantification,
            ..AnalysisSpec::default()
        };
        let recurrence = spec.recurrence.as_mut().unwrap();
        recurrence.embedding = EMBEDDING;
        recurrence.criterion.threshold = threshold;
        let quantification = spec.quantification.as_mut().unwrap();
        quantification.embedding = EMBEDDING;
        quantification.criterion.threshold = threshold;
        let records = run(spec, &motion, 256);
        let (mut plots, mut measured) = (0, 0);
        for record in &records {
            match record {
                Record::Recurrence { image, .. } => {
                    assert!(image.rate > 0.0 && image.rate < 1.0, "{threshold:?}");
                    plots += 1;
                }
                Record::Quantification {
                    measures,
                    threshold: distance,
                    ..
                } => {
                    let rate = measures.recurrence_rate;
                    assert!(rate > 0.0 && rate < 1.0, "{threshold:?}");
                    assert_eq!(
                        distance.is_none(),
                        matches!(threshold, Threshold::Neighbours(_))
                    );
                    measured += 1;
                }
                _ => {}
            }
        }
        assert!(plots > 3 && measured > 10, "{threshold:?}");
    }
}

#[test]
fn the_spectrum_has_named_lines() {
    let records = run(analyses(), &Motion::tones(0.03, &TORUS), 256);
    let Some(Record::Spectrum {
        bin,
        amplitude,
        peaks,
        ..
    }) = records
        .iter()
        .rfind(|r| matches!(r, Record::Spectrum { .. }))
    else {
        panic!("no spectrum");
    };
    assert_eq!((*bin, amplitude.len()), (50.0, 2001));
    let labels: Vec<&str> = peaks.iter().map(|p| p.label.as_str()).collect();
    assert_eq!(labels, ["f1", "f2", "3 f1", "f1 - f2"]);
    for (peak, (frequency, amplitude, _)) in peaks.iter().zip(TORUS) {
        assert!((peak.frequency - frequency).abs() < 1.0);
        assert!((peak.amplitude / amplitude - 1.0).abs() < 0.02);
    }
}

#[test]
fn the_spectrogram_is_in_db_re_1_mm_per_s() {
    // 4 kHz is bin 20 of a 5 ms window; 10 mm/s is 20 dB.
    let records = run(
        analyses(),
        &Motion::tones(0.01, &[(4000.0, 10e-3, 0.3)]),
        256,
    );
    let mut columns = 0;
    for record in &records {
        if let Record::SpectrogramColumn { bin, level_db, .. } = record {
            assert_eq!((*bin, level_db.len()), (200.0, 101));
            assert!((level_db[20] - 20.0).abs() < 1e-4);
            assert!(level_db.iter().all(|l| (-160.0..=20.001).contains(l)));
            columns += 1;
        }
    }
    assert_eq!(columns, 11);
}

#[test]
fn recurrence_plot_has_lag_rate_and_diagonals() {
    // 4 kHz: a period is 50 samples, 20 points of the plot's 400 over 5 ms. A slight offset from a whole
    // number of samples makes all distances different.
    let records = run(
        analyses(),
        &Motion::tones(0.02, &[(4003.0, 10e-3, 0.3)]),
        256,
    );
    let mut plots = 0;
    for record in &records {
        if let Record::Recurrence { image, .. } = record {
            let RecurrenceImage {
                size,
                rate,
                lag,
                recurrent,
                threshold,
                window,
                ..
            } = &**image;
            assert_eq!((*size, *window), (400, 5e-3));
            assert!((lag - 60e-6).abs() < 1e-12);
            assert!((rate - 0.05).abs() <= 1.0 / (400.0 * 399.0 / 2.0));
            assert!(threshold.is_some_and(|t| t > 0.0 && t < 1e-6));
            let full =
                |offset: usize| (0..400 - offset).all(|i| recurrent[i * 400 + i + offset] == 255);
            let empty =
                |offset: usize| (0..400 - offset).all(|i| recurrent[i * 400 + i + offset] == 0);
            for period in 0..10 {
                assert!(
                    full(20 * period) && empty(20 * period + 10),
                    "period {period}"
                );
            }
            plots += 1;
        }
    }
    assert_eq!(plots, 6);
}

#[test]
fn a_distance_threshold_is_used_unchanged() {
    let mut spec = analyses();
    let recurrence = spec.recurrence.as_mut().unwrap();
    recurrence.criterion.threshold = Threshold::Distance(1e-7);
    let records = run(spec, &Motion::tones(0.01, &CYCLE), 256);
    let thresholds: Vec<f64> = records
        .iter()
        .filter_map(|r| {
            if let Record::Recurrence { image, .. } = r {
                image.threshold
            } else {
                None
            }
        })
        .collect();
    assert_eq!(thresholds, [1e-7, 1e-7]);
}

#[test]
fn the_reconstruction_starts_with_the_newest_coordinate() {
    let motion = Motion::tones(0.01, &CYCLE);
    let records = run(analyses(), &motion, 256);
    let Some(Record::Embedding { time, points }) = records
        .iter()
        .find(|r| matches!(r, Record::Embedding { .. }))
    else {
        panic!("no reconstruction");
    };
    let newest = ((time - T0) * RATE).round() as usize;
    assert_eq!(points.len(), 1000);
    for (back, point) in points.iter().rev().enumerate() {
        let now = newest - back;
        let expected = [now, now - 12, now - 24].map(|k| motion.displacement[k] as f32);
        assert_eq!(*point, expected);
    }
}

#[test]
fn silence_is_reported_without_nan() {
    let silence = Motion {
        displacement: vec![0.0; 8000],
        velocity: vec![0.0; 8000],
    };
    let spec = AnalysisSpec {
        recurrence: analyses().recurrence,
        ..all_analyses()
    };
    let records = run(spec, &silence, 256);
    assert_eq!(headings(&records), ["## Silent"]);
    for record in &records {
        match record {
            Record::Quantification { measures, .. } => {
                assert_eq!(measures.recurrence_rate, 1.0);
            }
            Record::Section { .. } => panic!("silence passes through nothing"),
            Record::Regime { verdict, .. } => assert_eq!(verdict.regime, Regime::Silent),
            Record::Spectrum {
                amplitude, peaks, ..
            } => {
                assert!(amplitude.iter().all(|&a| a == 0.0) && peaks.is_empty());
            }
            Record::SpectrogramColumn { level_db, .. } => {
                assert!(level_db.iter().all(|&l| l == -160.0));
            }
            Record::Recurrence { image, .. } => {
                assert_eq!((image.rate, image.threshold), (1.0, Some(0.0)));
                assert!(image.distance.iter().all(|&d| d == 0));
            }
            Record::Embedding { points, .. } => assert!(points.iter().flatten().all(|&x| x == 0.0)),
            _ => {}
        }
    }
}
