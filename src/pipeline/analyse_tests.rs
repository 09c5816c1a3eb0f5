//! Order, times and threads of the records of known signals.

#[path = "tests/narration.rs"]
mod narration;
#[path = "tests/results.rs"]
mod results;
#[path = "tests/summary.rs"]
mod summary;

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::*;
use crate::analysis::{AnalysisError, regime::Regime};
use crate::pipeline::stages::synthetic_tests::{
    EMBEDDING, Motion, RATE, SLIDING_SPEED, all_analyses, analyses, header,
};
use crate::pipeline::stages::{Context, Stage};
use crate::scene::{
    AnalysisSpec, ChaosSpec, QuantificationSpec, RecurrenceSpec, SectionSpec, SectionSurface,
};
use crate::test_signals::noise;

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
        assert_eq!(stages(&spec, &header()).len(), groups);
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
fn failing(have: Option<usize>) -> Stage {
    Box::new(move |_frame, _context| {
        Err(AnalysisError::TooShort {
            what: "test",
            have: have.expect("a stage that panics"),
            need: 9,
        })
    })
}

#[test]
fn errors_and_panics_of_any_thread_end_the_analysis() {
    let analyse = |have: [Option<usize>; 2]| {
        let groups = have.map(|have| StageGroup {
            context: Context::new(RATE),
            stages: vec![failing(have)],
        });
        let mut analyser = Analyser::new(&AnalysisSpec::default(), &header());
        analyser.groups = groups.into();
        let frames = Motion::tones(0.01, &CYCLE).frames(T0, 0.0, 256);
        analyser.push(&frames[0], &mut Vec::<Record>::new())
    };
    // The first in the order of the records, whichever fails first.
    let error = analyse([Some(1), Some(2)]).unwrap_err();
    assert!(
        matches!(
            error,
            PipelineError::Analysis(AnalysisError::TooShort { have: 1, .. })
        ),
        "{error:?}"
    );
    let panic = AssertUnwindSafe(|| analyse([Some(1), None]));
    assert!(catch_unwind(panic).is_err());
}

#[test]
fn events_that_steps_pass_over_are_reported() {
    let mut analyser = Analyser::new(&AnalysisSpec::default(), &header());
    let mut records: Vec<Record> = Vec::new();
    let frames = Motion::tones(0.01, &CYCLE).frames(T0, 0.0, 256);
    for (k, mut frame) in frames.into_iter().enumerate() {
        Arc::make_mut(&mut frame).unlocated_since = (k == 1).then_some(1e-3);
        analyser.push(&frame, &mut records).unwrap();
    }
    records.retain(|record| !matches!(record, Record::Samples(_)));
    let [Record::Warning { time, text }] = &records[..] else {
        panic!("{records:?}")
    };
    assert_eq!(*time, 1e-3);
    assert!(text.contains("from 1.000 ms on, contact nodes"), "{text}");
    assert!(!text.contains("  "), "{text}");
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
