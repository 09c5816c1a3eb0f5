//! Summaries, and errors of sinks.

use super::*;
use crate::pipeline::SinkError;

#[test]
fn the_summary_refers_to_the_last_window() {
    let motion = Motion::tones(0.03, &[(4100.0, 50e-3, 0.0)]).then(&Motion::tones(0.04, &CYCLE));
    let mut analyser = Analyser::new(&analyses(), &header());
    let mut records: Vec<Record> = Vec::new();
    let frames = motion.frames(T0, 0.0, 256);
    for frame in &frames {
        analyser.push(frame, &mut records).unwrap();
    }
    let summary = analyser.summary();
    assert!((summary.simulated_s - 0.07).abs() < 1e-12);
    assert_eq!(summary.transitions, 2 * frames.len() as u64);
    let largest = motion.velocity[10_000..]
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    assert_eq!(summary.peak_velocity_m_per_s, largest);
    let labels: Vec<&str> = summary.lines.iter().map(|p| p.label.as_str()).collect();
    assert_eq!(labels, ["f1", "3 f1", "2 f1"]);
    assert!((summary.lines[0].frequency - 4117.0).abs() < 0.1);
    // 16 mm/s at 4117 Hz is 0.62 um; the harmonics add at most a tenth.
    assert!(
        (summary.amplitude_m / 0.62e-6 - 1.0).abs() < 0.1,
        "{}",
        summary.amplitude_m
    );
}

#[test]
fn the_summary_of_a_short_run_has_no_lines() {
    let mut analyser = Analyser::new(&analyses(), &header());
    assert_eq!(analyser.summary(), Summary::default());
    let mut records: Vec<Record> = Vec::new();
    let frames = Motion::tones(10.0 / RATE, &CYCLE).frames(0.0, 0.0, 10);
    analyser.push(&frames[0], &mut records).unwrap();
    assert!(analyser.summary().lines.is_empty());
    assert!(analyser.summary().peak_velocity_m_per_s > 0.0);
}

#[test]
fn the_analyser_can_be_sent_to_another_thread() {
    fn movable<T: Send>(_: &T) {}
    movable(&Analyser::new(&analyses(), &header()));
}

#[test]
fn an_error_of_the_sink_stops_the_run() {
    struct Full;
    impl Sink for Full {
        fn accept(&mut self, _: Record) -> Result<(), SinkError> {
            Err("disk full".into())
        }
    }
    let mut analyser = Analyser::new(&analyses(), &header());
    let frames = Motion::tones(0.01, &CYCLE).frames(T0, 0.0, 256);
    let error = analyser.push(&frames[0], &mut Full).unwrap_err();
    assert!(
        matches!(&error, PipelineError::Sink(source) if source.to_string() == "disk full"),
        "{error:?}"
    );
}
