use std::collections::HashSet;
use std::sync::Arc;

use super::template::names;
use super::*;
use crate::dynamics::{Exponent, LyapunovSpectrum};
use crate::joint::NamedMode;
use crate::pipeline::message::{
    AnalysisKind, Appearance, Circumstances, Computed, Coupling, Growth, Measurements, NodeShares,
    Parting, PartingLine, SpectralLine, StatusShares, TiltLoop, TiltedTone, ToneChange, Vibration,
    Way,
};
use crate::pipeline::synthetic_header as header;
use crate::scene::{Mechanism, Start};

fn lines() -> Vec<SpectralLine> {
    let line = |frequency: f64, label: &str| SpectralLine {
        frequency,
        amplitude: 1e-3,
        label: label.to_owned(),
    };
    vec![
        line(4110.0, "f1"),
        line(3870.0, "f2"),
        line(12_330.0, "3 f1"),
        line(240.0, "f1 - f2"),
    ]
}

fn vibration(appearance: Appearance) -> Vibration {
    Vibration {
        appearance,
        growth_rate: 100.0,
        lines: lines(),
        f1: Some(4110.0),
        f2: Some(3870.0),
        beat: Some(240.0),
        second_tone: 0.16,
        floor_share: 0.0231,
        peak_speed: 0.02,
        backward_speed: 0.017,
        half_range: 8e-7,
        now: Circumstances {
            tilt: 3.04f64.to_radians(),
            load: None,
            rotation_factor: None,
            sliding_speed: 0.016,
        },
    }
}

fn narrated(vibration: Vibration) -> String {
    fill_narration(&Observation::Vibration(Box::new(vibration))).unwrap()
}

const APPEARANCES: [Appearance; 8] = [
    Appearance::Silent,
    Appearance::Growing,
    Appearance::Fading,
    Appearance::Settling,
    Appearance::Tone,
    Appearance::TwoTones,
    Appearance::Broad,
    Appearance::Unsettled,
];

#[test]
fn every_appearance_has_its_words() {
    let texts: Vec<String> = APPEARANCES.map(vibration).map(narrated).into();
    let headings: HashSet<_> = texts
        .iter()
        .map(|text| text.lines().next().unwrap())
        .collect();
    assert_eq!(headings.len(), APPEARANCES.len());
    for text in &texts {
        assert!(text.starts_with("## ") && !text.contains("  "), "{text}");
        // Heading, what it looks like, how large it is, and the tilt.
        assert_eq!(text.split("\n\n").count(), 4, "{text}");
        // Without lines, too, and at rest.
    }
    for appearance in APPEARANCES {
        let mut bare = vibration(appearance);
        (bare.lines, bare.f1, bare.f2, bare.beat) = (Vec::new(), None, None, None);
        bare.now.sliding_speed = 0.0;
        assert_eq!(narrated(bare).split("\n\n").count(), 4);
    }
    assert_eq!(
        texts[4],
        "## Looks like a pure tone\n\nOne fundamental, f1 = **4.11 kHz**: the motion repeats about every \
         243 µs. Overtones: 3 f1 (12.3 kHz). A second tone, f2 = 3.87 kHz, is present but faint: 16 % of the \
         first.\n\nThe contact point swings ±800 nm, at up to 20.0 mm/s; backwards at up to 17.0 mm/s \
         against a sliding speed of 16.0 mm/s, so its slip reverses.\n\nTilt 3.0°."
    );
}

#[test]
fn what_varies_besides_the_tilt_is_shown() {
    let mut varying = vibration(Appearance::Tone);
    varying.now.load = Some(121.4);
    varying.now.rotation_factor = Some(0.5);
    let words = "Tilt 3.0°, load 121 N, rotation 0.50 times that of the scene.";
    assert!(narrated(varying).ends_with(words));
}

fn exponents(values: &[f64], motion: Motion) -> Exponents {
    let exponents = values.iter().map(|&value| Exponent {
        value,
        half_width: 0.5,
    });
    Exponents {
        time: 0.2,
        spectrum: LyapunovSpectrum {
            exponents: exponents.collect(),
            time: 10.0,
            dimension: values.len(),
            resolution: 1.0,
            kaplan_yorke: None,
        },
        motion,
        omega_1: 1e6,
    }
}

#[test]
fn every_attractor_has_its_words() {
    let mut headings = HashSet::new();
    for (values, motion) in [
        (&[-3.0, -4.0][..], Motion::Still),
        (&[3.0, -4.0], Motion::Still),
        (&[0.1, -4.0], Motion::Still),
        (&[-3.0, -4.0], Motion::Free),
        (&[-3.0, -4.0], Motion::Driven),
        (&[0.1, -4.0], Motion::Free),
        (&[0.1, 0.1, -4.0], Motion::Free),
        (&[3.0, 0.1, -4.0], Motion::Free),
        (&[3.0, 3.0, 0.1, -4.0], Motion::Free),
    ] {
        let exponents = exponents(values, motion);
        let text = fill_narration(&Observation::Exponents(Arc::new(exponents))).unwrap();
        let (heading, body) = text.split_once("\n\n").unwrap();
        assert!(body.starts_with("λ1 = ") && body.contains(" per s, averaged over 10.0 s. "));
        assert!(!body.contains("  ") && body.ends_with('.'), "{text}");
        headings.insert(heading.to_owned());
    }
    assert_eq!(headings.len(), 9, "{headings:?}");
}

fn mode(label: &str, frequency_hz: f64, growth: f64) -> NamedMode {
    NamedMode {
        label: label.to_owned(),
        frequency_hz,
        growth,
        unstable: growth > 0.0,
    }
}

fn computed(mechanism: Mechanism) -> Computed {
    let modes = vec![
        mode("1st bending", 700.0, 90.0),
        mode("2nd bending", 4100.0, 70.0),
    ];
    let reading = |growth: f64| FrictionReading {
        creep: 10.0,
        stribeck: 1000.0,
        mu: 0.3,
        slope: -1.25,
        modes: vec![mode("1st bending", 700.0, growth)],
    };
    Computed {
        mechanism,
        modes,
        natural_hz: 700.0,
        tilt: Some(0.05),
        sliding_speed: 0.016,
        start: Start {
            position: 0.0,
            velocity: 0.0,
            kick: 1e-6,
            seed: 6,
        },
        readings: Some([reading(-3.0), reading(90.0)]),
        coupling: Some(Coupling {
            mu: 0.4,
            critical: Some(0.273),
        }),
        picture: None,
    }
}

/// Everything measured.
fn measured() -> Measurements {
    let tone = |way| TiltedTone {
        tilt: 0.1,
        way,
        frequency: 2e3,
    };
    let change = |way| ToneChange {
        from: 4e3,
        to: tone(way),
    };
    let parting = Parting {
        time: 0.1,
        start: 0.01,
        distance: 1e-6,
        line: Some(PartingLine {
            rate: 50.0,
            half_width: 2.0,
            since: 0.02,
            intercept: -13.0,
        }),
        saturated: Some(0.09),
    };
    Measurements {
        growth: Some(Growth {
            rate: 80.0,
            half_width: 1.0,
        }),
        growth_ended: true,
        first_level: Some(1e-6),
        level: 0.01,
        lines: lines(),
        nodes: Some(NodeShares {
            stuck: 0.25,
            most_stuck: 0.75,
            half_stuck: 0.2,
            separated: 0.2,
            most_separated: 1.0,
            all_separated: 0.1,
            separations_per_s: 1e3,
        }),
        statuses: Some(StatusShares {
            held: 0.5,
            releases_per_s: 280.0,
        }),
        leader_at_end: Some("1st bending".to_owned()),
        leader: Some("2nd bending".to_owned()),
        tilt: Some(0.05),
        tilts: Some(TiltLoop {
            tilt: Some(0.05),
            has_come_down: true,
            up: vec![change(Way::Up)],
            down: vec![change(Way::Down)],
            differing: Some([0.06, 0.09]),
            last_up: Some(0.1),
            back: Some(0.05),
        }),
        separation: Some([parting; 2]),
        exponents: Some(Arc::new(exponents(&[0.1, 0.1, -4.0], Motion::Free))),
    }
}

fn lesson_text(mechanism: Mechanism, measured: Measurements) -> String {
    let computed = Arc::new(computed(mechanism));
    fill_lesson(&Lesson {
        time: 0.1,
        computed,
        measured,
    })
    .unwrap()
}

/// With everything measured, nothing is missing; with nothing measured, everything is.
#[test]
fn every_lesson_is_filled() {
    for &mechanism in Mechanism::ALL {
        let full = lesson_text(mechanism, measured());
        assert!(
            full.starts_with("## ") && !full.contains("not yet measured"),
            "{full}"
        );
        assert!(
            full.contains("\n\n**Look at** ") && !full.contains("  "),
            "{full}"
        );
        assert!(full.trim_end().ends_with('.'), "no conclusion: {full}");
        // A table is not broken by empty lines.
        for block in full.split("\n\n").filter(|block| block.contains("| ")) {
            assert!(
                block.trim().lines().all(|row| row.starts_with('|')),
                "{full}"
            );
        }
        let mut empty = Measurements::default();
        if mechanism == Mechanism::Hysteresis {
            empty.tilts = Some(TiltLoop {
                tilt: None,
                has_come_down: false,
                up: Vec::new(),
                down: Vec::new(),
                differing: None,
                last_up: None,
                back: None,
            });
        }
        let empty = lesson_text(mechanism, empty);
        assert!(empty.contains("not yet measured |\n"), "{empty}");
        assert!(
            empty.trim_end().ends_with('|'),
            "a conclusion of nothing: {empty}"
        );
    }
}

#[test]
fn a_moved_load_is_shown_where_something_is_computed() {
    let mut moved = measured();
    moved.tilt = Some(0.1);
    let words = "The load is now tilted to **5.7°**; the computed values are for 2.9°.";
    assert!(lesson_text(Mechanism::Prediction, moved.clone()).contains(words));
    assert!(!lesson_text(Mechanism::Torus, moved).contains("tilted to **"));
}

#[test]
fn each_name_is_used_by_a_text() {
    let lesson = Lesson {
        time: 0.0,
        computed: Arc::new(computed(Mechanism::Torus)),
        measured: measured(),
    };
    let given: HashSet<String> = of_lesson(&lesson)
        .try_iter()
        .unwrap()
        .map(|name| name.to_string())
        .collect();
    let used = Mechanism::ALL
        .iter()
        .flat_map(|&mechanism| names(&lesson_name(mechanism)));
    assert_eq!(given, used.collect::<HashSet<_>>());
    let exponents = of_exponents(&exponents(&[1.0], Motion::Free));
    let given: HashSet<String> = exponents
        .try_iter()
        .unwrap()
        .map(|name| name.to_string())
        .collect();
    assert_eq!(given, names("narration/exponents"));
}

#[test]
fn a_lesson_that_reads_the_same_is_not_repeated() {
    let mut lesson = Lesson {
        time: 0.0,
        computed: Arc::new(computed(Mechanism::Torus)),
        measured: measured(),
    };
    let mut text = LessonText::default();
    assert!(text.next(&lesson).is_some());
    lesson.measured.level *= 1.5;
    assert_eq!(text.next(&lesson), None);
    lesson.measured.lines[0].frequency = 4210.0;
    assert!(
        text.next(&lesson)
            .is_some_and(|text| text.contains("4.21 kHz"))
    );
}

#[test]
fn the_views_of_a_run_are_listed() {
    let mut header = header();
    let rows = |header: &Header| {
        let text = fill("views", of_views(header)).unwrap();
        assert!(text.lines().all(|row| row.starts_with('|')), "{text}");
        text.lines().count() - 2
    };
    assert_eq!(rows(&header), 3, "patch, phase portrait and health");
    header.analyses = vec![AnalysisKind::Recurrence, AnalysisKind::Delay];
    assert_eq!(rows(&header), 7);
    let given: HashSet<String> = of_views(&header)
        .try_iter()
        .unwrap()
        .map(|name| name.to_string())
        .collect();
    assert_eq!(given, names("views"));
}
