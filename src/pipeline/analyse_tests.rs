//! Known signals through all analyses.

#[path = "tests/narration.rs"]
mod narration;
#[path = "tests/summary.rs"]
mod summary;

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::*;
use crate::analysis::test_signals::noise;
use crate::analysis::{AnalysisError, Direction, RecurrenceImage, Regime, Threshold};
use crate::pipeline::message::SectionPoint;
use crate::pipeline::stages::synthetic_tests::{
    EMBEDDING, Motion, RATE, SLIDING_SPEED, all_analyses, analyses, header,
};
use crate::pipeline::stages::{Context, Emit, Stage};
use crate::scene::{
    AnalysisSpec, AutoOr, ChaosSpec, QuantificationSpec, RecurrenceSpec, SectionSpec,
    SectionSurface, StateCoordinate,
};

const T0: f64 = 0.25;

/// Torus of the natural parameter set: (Hz, m/s, rad).
const TORUS: [(f64, f64, f64); 4] = [
    (4110.0, 13e-3, 0.1),
    (3870.0, 3e-3, 0.7),
    (12_330.0, 2e-3, 1.9),
    (240.0, 0.1e-3, 2.5),
];

/// Limit cycle at 2 degrees.
const CYCLE: [(f64, f64, f64); 3] = [
    (4117.0, 16e-3, 0.0),
    (12_351.0, 2e-3, 0.4),
    (8234.0, 0.8e-3, 1.2),
];

fn run(spec: AnalysisSpec, motion: &Motion, frame: usize) -> Vec<Record> {
    let mut analyser = Analyser::new(&spec, &header());
    let mut records: Vec<Record> = Vec::new();
    for frame in motion.frames(T0, 0.05, frame) {
        analyser.push(&frame, &mut records).unwrap();
    }
    records
}

/// Times of the records selected by `pick`, in samples since the start, with fractions.
fn instants(records: &[Record], pick: fn(&Record) -> Option<f64>) -> Vec<f64> {
    let samples = |t: f64| (2.0 * (t - T0) * RATE).round() / 2.0;
    records.iter().filter_map(pick).map(samples).collect()
}

fn narrations(records: &[Record]) -> Vec<String> {
    let texts = records.iter().filter_map(|record| match record {
        Record::Narration { observation, .. } => Some(crate::text::narration(observation)),
        _ => None,
    });
    texts.collect()
}

fn headings(records: &[Record]) -> Vec<String> {
    let texts = narrations(records);
    let heading = |text: &String| text.lines().next().map(str::to_owned);
    let mut all: Vec<String> = texts.iter().filter_map(heading).collect();
    all.dedup();
    all
}

/// With a lower rate fewer windows are computed, and their results remain the same.
#[test]
fn a_lower_rate_leaves_exact_results() {
    let motion = Motion::tones(0.03, &TORUS);
    let mut analyser = Analyser::new(&analyses(), &header());
    analyser.set_rate_divisor(2);
    let mut fewer: Vec<Record> = Vec::new();
    for frame in motion.frames(T0, 0.05, 256) {
        analyser.push(&frame, &mut fewer).unwrap();
    }
    let plots = |records: &[Record]| -> Vec<String> {
        let plots = records.iter();
        let plots = plots.filter(|record| matches!(record, Record::Recurrence { .. }));
        plots.map(|plot| format!("{plot:?}")).collect()
    };
    let (all, fewer) = (plots(&run(analyses(), &motion, 256)), plots(&fewer));
    // Windows 3 to 12; the even ones remain.
    assert_eq!((all.len(), fewer.len()), (10, 5));
    assert!(all.iter().skip(1).step_by(2).eq(&fewer));
}

/// The records of all analyses on a number of threads, with all digits.
fn texts_on(threads: usize, spec: &AnalysisSpec, frames: &[Arc<Frame>]) -> Vec<String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(|| {
        let mut analyser = Analyser::new(spec, &header());
        let mut records: Vec<Record> = Vec::new();
        for frame in frames {
            analyser.push(frame, &mut records).unwrap();
        }
        analyser.finish(&mut records).unwrap();
        let mut texts: Vec<String> = records.iter().map(|record| format!("{record:?}")).collect();
        texts.push(format!("{:?}", analyser.summary()));
        texts
    })
}

/// With delays that the scene gives, all analyses are independent; with chosen ones some wait for the choice.
#[test]
fn threads_do_not_change_the_records_or_their_order() {
    let frames = Motion::tones(0.06, &TORUS).frames(T0, 0.05, 256);
    let chosen = all_analyses();
    let mut given = chosen.clone();
    given.recurrence = given.recurrence.map(|spec| RecurrenceSpec {
        embedding: EMBEDDING,
        ..spec
    });
    given.quantification = given.quantification.map(|spec| QuantificationSpec {
        embedding: EMBEDDING,
        ..spec
    });
    given.chaos = given.chaos.map(|spec| ChaosSpec {
        embedding: EMBEDDING,
        ..spec
    });
    given.section = given.section.map(|spec| SectionSpec {
        surface: SectionSurface::Delay {
            lag: EMBEDDING.lag,
            level: 0.0,
        },
        ..spec
    });
    for (spec, groups) in [(chosen, 4), (given, 8)] {
        assert_eq!(stages(&spec, &header()).independent.len(), groups);
        let one = texts_on(1, &spec, &frames);
        for kind in [
            "Spectrum {",
            "SpectrogramColumn",
            "Delay",
            "Recurrence",
            "Quantification",
            "Chaos",
            "Regime",
        ] {
            assert!(one.iter().any(|text| text.starts_with(kind)), "{kind}");
        }
        for threads in [2, 3, 4] {
            assert!(
                one == texts_on(threads, &spec, &frames),
                "{threads} threads"
            );
        }
    }
}

/// A stage that fails at the first frame: with a panic, or with an error that states a number.
struct Failing(Option<usize>);

impl Stage for Failing {
    fn push(
        &mut self,
        _frame: &Frame,
        _context: &mut Context,
        _emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let have = self.0.expect("a stage that panics");
        let error = AnalysisError::TooShort {
            what: "test",
            have,
            need: 9,
        };
        Err(error.into())
    }
}

#[test]
fn errors_and_panics_of_any_thread_end_the_analysis() {
    let analyse = |failing: [Failing; 2]| {
        let boxed = failing.map(|stage| vec![Box::new(stage) as Box<dyn Stage>]);
        let mut analyser = Analyser {
            groups: StageGroups::new(boxed.into(), Vec::new(), RATE),
        };
        let frames = Motion::tones(0.01, &CYCLE).frames(T0, 0.0, 256);
        analyser.push(&frames[0], &mut Vec::<Record>::new())
    };
    // The first in the order of the records, whichever fails first.
    let error = analyse([Failing(Some(1)), Failing(Some(2))]).unwrap_err();
    assert!(error.to_string().contains("1 sample"), "{error}");
    let panic = AssertUnwindSafe(|| analyse([Failing(Some(1)), Failing(None)]));
    assert!(catch_unwind(panic).is_err());
}

#[test]
fn records_have_their_times() {
    let records = run(analyses(), &Motion::tones(0.03, &TORUS), 256);
    let spectra = instants(&records, |r| match r {
        Record::Spectrum { time, .. } => Some(*time),
        _ => None,
    });
    // Times of the last sample of each window: every 1000 samples, from a quarter of 4000 on.
    assert_eq!(spectra, [999.0, 1999.0, 2999.0, 3999.0, 4999.0, 5999.0]);
    let columns = instants(&records, |r| match r {
        Record::SpectrogramColumn { time, .. } => Some(*time),
        _ => None,
    });
    let expected: Vec<f64> = (0..51).map(|j| 500.0 + 100.0 * f64::from(j)).collect();
    assert_eq!(columns, expected);
    // The window is full after 1000 + 4 * 12 samples; then every 500.
    let recurrences = instants(&records, |r| match r {
        Record::Recurrence { time, .. } => Some(*time),
        _ => None,
    });
    let expected: Vec<f64> = (3..=12).map(|j| 500.0 * f64::from(j) - 1.0).collect();
    assert_eq!(recurrences, expected);
    let trails = instants(&records, |r| match r {
        Record::Embedding { time, .. } => Some(*time),
        _ => None,
    });
    assert_eq!(trails, recurrences);
}

/// The records without the samples, as text with all digits, sorted by kind. The order of different kinds
/// depends on the frames and is ignored.
fn texts(spec: &AnalysisSpec, motion: &Motion, frame: usize) -> Vec<String> {
    let records = run(spec.clone(), motion, frame);
    let mut texts: Vec<String> = records
        .iter()
        .filter(|r| !matches!(r, Record::Samples(_)))
        .map(|r| format!("{r:?}"))
        .collect();
    let kind = |text: &str| text.split(' ').next().map(str::to_owned);
    texts.sort_by_key(|text| kind(text));
    texts
}

#[test]
fn the_frame_size_does_not_matter() {
    // The motion changes during the run, and with it the chosen delays.
    let slow = Motion::tones(0.016, &[(1310.0, 13e-3, 0.4)]);
    let motion = Motion::tones(0.031, &TORUS).then(&slow);
    let spec = all_analyses();
    let reference = texts(&spec, &motion, 256);
    let chosen = reference.iter().filter(|t| t.starts_with("Delay"));
    let lags: HashSet<&str> = chosen.filter_map(|t| t.split("lag: ").nth(1)).collect();
    assert!(lags.len() > 1, "the delay must change");
    assert!(reference.len() > 200, "{}", reference.len());
    for frame in [1, 7, 1000, 100_000] {
        assert!(
            texts(&spec, &motion, frame) == reference,
            "frames of {frame} samples give different records"
        );
    }
}

#[test]
fn all_analyses_report_at_their_times() {
    let motion = Motion::tones(0.031, &TORUS);
    let records = run(all_analyses(), &motion, 256);
    let delays = instants(&records, |r| match r {
        Record::Delay { time, .. } => Some(*time),
        _ => None,
    });
    // Windows of 1600 samples, every 800.
    assert_eq!(delays, [1599.0, 2399.0, 3199.0, 3999.0, 4799.0, 5599.0]);
    // Analyses that use the chosen delay start after the first choice.
    let first = |pick: fn(&Record) -> Option<f64>| instants(&records, pick)[0];
    let quantification = |r: &Record| match r {
        Record::Quantification { time, .. } => Some(*time),
        _ => None,
    };
    assert!((1599.0..1730.0).contains(&first(quantification)));
    let chaos = instants(&records, |r| match r {
        Record::Chaos { time, .. } => Some(*time),
        _ => None,
    });
    assert_eq!(chaos, [1999.0, 2999.0, 3999.0, 4999.0, 5999.0]);
    let regimes = instants(&records, |r| match r {
        Record::Regime { time, .. } => Some(*time),
        _ => None,
    });
    assert_eq!(regimes, [1999.0, 2999.0, 3999.0, 4999.0, 5999.0]);
    // Measures on the grid of the states: every fourth sample from the first one.
    let measures = instants(&records, quantification);
    assert!(measures.len() > 35 && measures.iter().all(|k| k % 4.0 == 0.0));
    assert!(
        measures
            .windows(2)
            .all(|w| [120.0, 124.0].contains(&(w[1] - w[0])))
    );
}

#[test]
fn section_points_agree_with_the_closed_form() {
    // y = A sin(w t) rises through 0 at t + lag = k T: y(t) = -A sin(w lag), y(t + 2 lag) = A sin(w lag).
    let (frequency, speed) = (4003.0, 10e-3);
    let motion = Motion::tones(0.01, &[(frequency, speed, 0.0)]);
    let spec = AnalysisSpec {
        section: Some(SectionSpec {
            every: 0.5e-3,
            surface: SectionSurface::Delay {
                lag: AutoOr::Given(60e-6),
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
        assert!((point.time - due).abs() < 1e-12, "{k}");
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
    assert!(all.is_sorted_by(|a, b| a.time < b.time));
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
fn every_frame_is_forwarded_before_its_results() {
    let motion = Motion::tones(0.01, &CYCLE);
    let records = run(analyses(), &motion, 256);
    assert!(matches!(records[0], Record::Samples(_)));
    let samples: usize = records
        .iter()
        .map(|r| {
            if let Record::Samples(frame) = r {
                frame.len()
            } else {
                0
            }
        })
        .sum();
    assert_eq!(samples, motion.velocity.len());
}

#[test]
fn analyses_that_are_off_emit_nothing() {
    let records = run(AnalysisSpec::default(), &Motion::tones(0.03, &TORUS), 256);
    assert!(records.iter().all(|r| matches!(r, Record::Samples(_))));
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
