//! Reports on constructed results.

use super::*;
use crate::dynamics::{Attractor, Exponent, LyapunovSpectrum, Motion, SolverStats};
use crate::report::markdown;

#[test]
fn non_finite_exponents_are_null_in_json() {
    let mut found = study(&[60.0, f64::NEG_INFINITY], None, None);
    found.tilt_rad = Some(0.1);
    let json = serde_json::to_value(concluded(found, Goal::Classification)).expect("JSON");
    assert_eq!(json["tilt_rad"], 0.1);
    assert_eq!(json["exponents_per_s"][0]["value"], 60.0);
    assert_eq!(json["exponents_over_omega_1"][0]["value"], 6e-3);
    assert_eq!(json["signs"][0], "positive");
    assert_eq!(json["steps_without_event_location"], 7);
    assert!(json["exponents_per_s"][1]["value"].is_null());
}

/// Impacts with a restitution of zero contract a direction to nothing.
#[test]
fn minus_infinity_is_printed_alike_everywhere_and_has_no_error() {
    let mut found = study(&[60.0, f64::NEG_INFINITY], Some(0.0), None);
    found.study.mean_trace_per_s = None;
    let report = text("made", &concluded(found, Goal::Time(2.0)));
    assert!(
        report.contains("| 2 | -inf |  | -inf | negative |"),
        "{report}"
    );
    assert!(report.contains("sum -inf 1/s\n"), "{report}");
}

fn text(name: &str, result: &LyapunovResult) -> String {
    markdown(&result.blocks(name))
}

fn exponents(values: &[(f64, f64)]) -> Vec<Exponent> {
    let values = values.iter();
    values
        .map(|&(value, half_width)| Exponent { value, half_width })
        .collect()
}

/// A study of 2 s in 1000 steps, of which 7 passed events. With a trace, all exponents are computed.
fn study(values: &[f64], trace: Option<f64>, tolerance: Option<f64>) -> LyapunovResult {
    let dimension = if trace.is_some() { values.len() } else { 22 };
    let values: Vec<_> = values.iter().map(|&value| (value, 0.1)).collect();
    let spectrum = LyapunovSpectrum {
        exponents: exponents(&values),
        time: 2.0,
        dimension,
        resolution: 1.0,
        kaplan_yorke: None,
    };
    LyapunovResult {
        study: LyapunovStudy {
            spectrum,
            mean_trace_per_s: trace,
            stats: SolverStats {
                steps: 1000,
                steps_without_event_location: 7,
                ..SolverStats::default()
            },
            simulated_s: 2.0,
            busy_seconds: 1.0,
            ..LyapunovStudy::default()
        },
        transient_s: 0.12,
        tolerance,
        omega_1_rad_per_s: 10_000.0,
        ..LyapunovResult::default()
    }
}

/// The result with its conclusions.
fn concluded(found: LyapunovResult, goal: Goal) -> LyapunovResult {
    let LyapunovResult {
        study,
        tolerance,
        omega_1_rad_per_s,
        ..
    } = found;
    LyapunovResult {
        study: study.concluded(goal, tolerance, omega_1_rad_per_s),
        ..found
    }
}

/// The report on such a study.
fn report_text(values: &[f64], trace: Option<f64>, tolerance: Option<f64>) -> String {
    let result = concluded(study(values, trace, tolerance), Goal::Time(2.0));
    // Numbers of exponents, and 95 % intervals.
    crate::report::agreement::check(&result, &[1.0, 2.0, 3.0, 95.0]);
    text("made", &result)
}

#[test]
fn steps_too_long_for_the_contractions_are_reported() {
    // The trace of a conservative system is zero.
    let conservative = report_text(&[3.0, 0.0, -3.0], Some(0.0), Some(1e-5));
    assert!(!conservative.contains("too long"), "{conservative}");
    let off = report_text(&[3.0, 0.0, -30.0], Some(-30.0), Some(1e-9));
    assert!(
        off.contains("differs from the mean trace by 9.1 %"),
        "{off}"
    );
    assert!(off.contains("set --tolerance 1e-11"), "{off}");
    // The mean step is 2 ms: the last tangent vector shrinks by e^0.6, or by e^2.
    let fine = report_text(&[3.0, -300.0], None, Some(1e-5));
    assert!(!fine.contains("resolved"), "{fine}");
    let coarse = report_text(&[3.0, -1000.0], None, Some(1e-5));
    assert!(
        coarse.contains("shrinks by a factor of e^2.0 per step on average; set --tolerance 5e-8"),
        "{coarse}"
    );
    assert!(coarse.contains("7 of 1000 steps passed events"), "{coarse}");
}

#[test]
fn the_motions_before_the_last_one_are_listed() {
    let mut found = study(&[0.0, -30.0], None, Some(1e-5));
    let segment = |start, end, values: &[f64]| {
        let spectrum = study(values, None, None).study.spectrum;
        MotionSegment {
            start_s: start,
            end_s: end,
            attractor: spectrum.attractor(),
            spectrum,
        }
    };
    let last = segment(0.83, 2.0, &[0.0, -30.0]);
    found.study.segments = vec![last.clone()];
    let text_of = |found: &LyapunovResult| text("made", &concluded(found.clone(), Goal::Time(2.0)));
    assert!(!text_of(&found).contains("start, s"));
    found.study.segments = vec![segment(0.31, 0.83, &[240.0, 140.0, 0.0, -30.0]), last];
    found.study.chaotic_transient_s = Some(0.83);
    let report = text_of(&found);
    let words = ": chaotic transient of 830 ms, then limit cycle: one exponent is zero";
    assert!(report.contains(words), "{report}");
    assert!(report.contains("0.830 | hyperchaos"), "{report}");
    let json = serde_json::to_value(concluded(found, Goal::Time(2.0))).expect("JSON");
    assert_eq!(json["chaotic_transient_s"], 0.83);
    assert_eq!(json["attractor"], "cycle");
    assert_eq!(json["segments"][0]["attractor"], "hyperchaos");
    assert_eq!(json["segments"][0]["end_s"], 0.83);
    assert_eq!(json["segments"][0]["exponents_per_s"][1]["value"], 140.0);
}

#[test]
fn unaligned_tangent_vectors_are_reported() {
    // The half-widths are 0.1.
    let found = study(&[-7.0, -12.7, -6.3, -6.2], None, Some(1e-5));
    let result = concluded(found, Goal::Classification);
    assert_eq!(result.study.unsettled, [2]);
    assert!(text("made", &result).contains("are not aligned (out-of-order exponents: 2)"));
    let found = study(&[3.0, 0.0, -3.0], None, Some(1e-5));
    let result = concluded(found, Goal::Classification);
    assert!(result.study.unsettled.is_empty());
}

#[test]
fn a_study_without_exponents_has_no_numbers() {
    let mut found = study(&[], None, Some(1e-5));
    found.study.ending = Ending::Stopped;
    found.study.spectrum.resolution = f64::INFINITY;
    let result = concluded(found, Goal::Classification);
    let json = serde_json::to_value(&result).expect("JSON");
    assert!(json["resolution_per_s"].is_null() && json["kaplan_yorke"].is_null());
    assert_eq!(json["attractor"], "undecided");
    assert_eq!(
        result.study.classification.description,
        "undecided: the averaging has not started"
    );
    let text = text("made", &result);
    assert!(
        !text.contains("NaN") && !text.contains("resolution"),
        "{text}"
    );
}

#[test]
fn the_description_has_the_attractor_and_the_reason() {
    let check = |values: &[f64], dimension, motion, expected: Attractor, reason: &str| {
        let mut found = study(values, None, None);
        let spectrum = &mut found.study.spectrum;
        (spectrum.time, spectrum.dimension, spectrum.resolution) = (10.0, dimension, 0.5);
        found.study.motion = motion;
        let classification = concluded(found, Goal::Classification).study.classification;
        assert_eq!(classification.attractor, expected);
        assert_eq!(classification.description, format!("{expected}: {reason}"));
    };
    check(
        &[0.0, 0.0],
        2,
        Motion::Free,
        Attractor::Torus(2),
        "2 exponents are zero",
    );
    check(
        &[0.0, -3.0],
        4,
        Motion::Free,
        Attractor::Cycle,
        "one exponent is zero, the others are negative",
    );
    check(
        &[0.0, -3.0],
        2,
        Motion::Driven,
        Attractor::Torus(2),
        "one frequency is that of the drive; one exponent is zero, the others are negative",
    );
    check(
        &[-1.0, -3.0],
        2,
        Motion::Driven,
        Attractor::PhaseLocked,
        "all exponents are negative",
    );
    check(
        &[-1.0, -3.0],
        2,
        Motion::Free,
        Attractor::FixedPoint,
        "all exponents are negative",
    );
    check(
        &[9.0, -3.0],
        2,
        Motion::Still,
        Attractor::UnstableEquilibrium,
        "the state is constant, but small perturbations grow",
    );
}
