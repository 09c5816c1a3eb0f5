use std::collections::HashSet;
use std::sync::Arc;

use super::template::environment;
use super::*;
use crate::dynamics::{Exponent, LyapunovSpectrum, Motion};
use crate::joint::NamedMode;
use crate::pipeline::message::{
    Appearance, Coupling, DivergenceFit, Exponents, FrictionMemory, FrictionReading, Kick,
    Measurements, MechanismPrediction, NodeShares, OperatingPoint, Regime, SecondToneGrowth,
    SecondToneLevel, SpectralLine, SqueakPass, StatusShares, TableReading, TiltDirection, TiltLoop,
    TiltedTone, ToneChange, ToneGrowth, TorusBirth, TrajectoryDivergence, UnstablePass, Vibration,
};
use crate::pipeline::synthetic_header as header;
use crate::report::Measured;
use crate::scene::{AnalysisSpec, Mechanism, Scene, Start};

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
        broadband_share: 0.0231,
        peak_speed: 0.02,
        backward_speed: 0.017,
        half_range: 8e-7,
        now: OperatingPoint {
            tilt: 3.04f64.to_radians(),
            load: None,
            rotation_factor: None,
            sliding_speed: 0.016,
        },
    }
}

/// A text whose template has no error.
fn complete(text: String) -> String {
    assert!(!text.starts_with("## Text missing"), "{text}");
    text
}

fn narrated(vibration: Vibration) -> String {
    complete(narration(&Observation::Vibration(Box::new(vibration))))
}

const APPEARANCES: [Appearance; 9] = [
    Appearance::Silent,
    Appearance::Growing,
    Appearance::Fading,
    Appearance::Settling,
    Appearance::Tone,
    Appearance::TwoTones,
    Appearance::Broad,
    Appearance::Unsettled,
    Appearance::AtRest,
];

/// The variables that a template expects from outside.
fn variables(name: &str) -> HashSet<String> {
    let environment = environment().unwrap();
    let template = environment.get_template(name).unwrap();
    template.undeclared_variables(false)
}

#[test]
fn every_appearance_has_a_text() {
    let texts: Vec<String> = APPEARANCES.map(vibration).map(narrated).into();
    let headings: HashSet<_> = texts
        .iter()
        .map(|text| text.lines().next().unwrap())
        .collect();
    assert_eq!(headings.len(), APPEARANCES.len());
    for text in &texts {
        assert!(text.starts_with("## ") && !text.contains("  "), "{text}");
        // Heading, appearance, amplitude and tilt.
        assert_eq!(text.split("\n\n").count(), 4, "{text}");
        // The same without spectral lines, and at zero sliding speed.
    }
    for appearance in APPEARANCES {
        let mut bare = vibration(appearance);
        (bare.lines, bare.f1, bare.f2, bare.beat) = (Vec::new(), None, None, None);
        bare.now.sliding_speed = 0.0;
        assert_eq!(narrated(bare).split("\n\n").count(), 4);
    }
    assert_eq!(
        texts[4],
        "## Looks like one tone with harmonics\n\nOne fundamental, f1 = **4.11 kHz**: the period is about \
         243 µs. Harmonics: 3 f1 (12.3 kHz). A second tone, f2 = 3.87 kHz, is present but weak: \
         its amplitude is 16 % of that of f1.\n\nThe contact point oscillates by ±800 nm, at up to \
         20.0 mm/s. Against the sliding direction it reaches 17.0 mm/s; the sliding speed is \
         16.0 mm/s, so the slip reverses.\n\nTilt 3.0°."
    );
}

#[test]
fn varying_load_and_rotation_are_reported() {
    let mut varying = vibration(Appearance::Tone);
    varying.now.load = Some(121.4);
    varying.now.rotation_factor = Some(0.5);
    let words = "Tilt 3.0°, load 121 N, rotation factor 0.50.";
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
        segments: Vec::new(),
        chaotic_transient: None,
    }
}

#[test]
fn every_attractor_has_a_text() {
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
        let text = complete(narration(&Observation::Exponents(Arc::new(exponents))));
        let (heading, body) = text.split_once("\n\n").unwrap();
        assert!(body.contains(" averaged over 10 s up to 200 ms."), "{text}");
        let is_unstable = values[0] > 1.0;
        assert_eq!(body.contains("e-fold every 330 ms."), is_unstable, "{text}");
        headings.insert(heading.to_owned());
    }
    assert_eq!(headings.len(), 9, "{headings:?}");
}

#[test]
fn a_chaotic_transient_is_named_with_its_lifetime() {
    let mut found = exponents(&[0.1, -4.0], Motion::Free);
    let segment = |start, end, values: &[f64]| MotionSegment {
        start_s: start,
        end_s: end,
        spectrum: exponents(values, Motion::Free).spectrum,
        attractor: exponents(values, Motion::Free).attractor(),
    };
    found.segments = vec![segment(0.1, 0.83, &[240.0, 140.0, 0.1, -4.0])];
    let words =
        |found: &Exponents| complete(narration(&Observation::Exponents(Arc::new(found.clone()))));
    assert!(!words(&found).contains(", then "));
    found.segments.push(segment(0.83, 2.0, &[0.1, -4.0]));
    let text = words(&found);
    assert!(
        text.contains("\nhyperchaos until 830 ms, then limit cycle: one exponent is zero"),
        "{text}"
    );
    found.chaotic_transient = Some(0.83);
    let text = words(&found);
    assert!(
        text.contains("\nchaotic transient of 830 ms, then limit cycle: one exponent is zero"),
        "{text}"
    );
}

fn mode(label: &str, frequency_hz: f64, growth: f64) -> NamedMode {
    NamedMode {
        label: label.to_owned(),
        frequency_hz,
        growth,
        unstable: growth > 0.0,
    }
}

fn computed(mechanism: Mechanism) -> MechanismPrediction {
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
    MechanismPrediction {
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
        memory: Some(FrictionMemory {
            steady_slope: -2.5,
            follows_up_to_hz: 1e3,
            damping_above_hz: Some(5e3),
            fastest_slope: Some(-0.7),
            modes_of_speed_alone: vec![mode("1st bending", 700.0, 785.0)],
        }),
        table: Some(TableReading {
            points: 9,
            speeds: [1e-4, 0.02],
            mu: 0.4,
            slope: -2.0,
            secants: Some([-3.0, -1.0]),
        }),
        passes: Some(vec![UnstablePass {
            way: TiltDirection::Up,
            unstable: Some([-0.12, 0.12]),
            largest_growth_per_s: 700.0,
        }]),
        torus: Some(TorusBirth {
            tilt: 0.04,
            course: [0.0, 0.1]
                .map(|tilt| SecondToneGrowth {
                    tilt,
                    frequency_hz: 4110.0,
                    second_hz: 240.0,
                    growth_per_s: 2e3 * (tilt - 0.04),
                })
                .into(),
        }),
        picture: None,
    }
}

fn tone_growth(rate: f64) -> ToneGrowth {
    ToneGrowth {
        tilts: [0.01, 0.02],
        growth: Measured::new(rate, 0.2),
        computed_per_s: 1.002 * rate,
    }
}

/// Measurements without a missing value.
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
    let separation = TrajectoryDivergence {
        time_s: 0.1,
        start_s: 0.01,
        distance: 1e-6,
        line: Some(DivergenceFit {
            rate_per_s: 50.0,
            half_width_per_s: 2.0,
            since_s: 0.02,
            intercept: -13.0,
        }),
        saturated_s: Some(0.09),
    };
    Measurements {
        growth: Some(Measured::new(80.0, 1.0)),
        growth_ended: true,
        small_frequency: Some(Measured::new(700.4, 0.3)),
        peak_speed: Some(0.03),
        first_level: Some(1e-6),
        level: 0.01,
        at_rest: false,
        regime: Some(Regime::QuasiPeriodic),
        kicks: 0,
        last_kick: None,
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
        changed: vec!["load 200 N".to_owned()],
        tilts: Some(TiltLoop {
            tilt: Some(0.05),
            has_decreased: true,
            up: vec![change(TiltDirection::Up)],
            down: vec![change(TiltDirection::Down)],
            differing: Some([0.06, 0.09]),
            last_up: Some(0.1),
            back: Some(0.05),
        }),
        passes: vec![SqueakPass {
            way: TiltDirection::Up,
            squeak: Some([-0.11, 0.13]),
            has_ended: true,
        }],
        second_tone: Some(SecondToneLevel {
            ratio: 0.02,
            decay: Some(tone_growth(-50.0)),
            growth: Some(tone_growth(50.0)),
        }),
        separation: Some([separation; 2]),
        exponents: Some(Arc::new(exponents(&[0.1, 0.1, -4.0], Motion::Free))),
    }
}

fn lesson_of(mechanism: Mechanism, measured: Measurements) -> Lesson {
    Lesson {
        time: 0.1,
        computed: Arc::new(computed(mechanism)),
        measured,
    }
}

fn lesson_text(mechanism: Mechanism, measured: Measurements) -> String {
    lesson(&lesson_of(mechanism, measured))
}

/// A complete set of measurements fills every fact; an empty one fills none.
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
        let (_, list) = full.split_once("\n\n* ").expect("a list");
        assert!(list.lines().skip(1).all(|line| line.starts_with("* ")));
        assert!(list.contains("**"), "no measurement: {full}");
        let names: Vec<String> = lesson_of(mechanism, measured())
            .facts()
            .into_iter()
            .map(|fact| fact.name)
            .collect();
        let different: HashSet<_> = names.iter().collect();
        assert_eq!(different.len(), names.len(), "{names:?}");
        let mut empty = Measurements::default();
        if mechanism == Mechanism::Hysteresis {
            empty.tilts = Some(TiltLoop {
                tilt: None,
                has_decreased: false,
                up: Vec::new(),
                down: Vec::new(),
                differing: None,
                last_up: None,
                back: None,
            });
        }
        let facts = lesson_of(mechanism, empty).facts();
        assert!(!facts.is_empty());
        for fact in facts {
            let open = (&fact.measured, fact.half_width, fact.agrees);
            assert_eq!(open, (&None, None, None), "{mechanism:?}: {fact:?}");
        }
    }
}

#[test]
fn a_changed_tilt_is_reported_in_lessons_at_one_tilt() {
    let mut moved = measured();
    moved.tilt = Some(0.1);
    let words = "The load is now tilted by **5.7°**; the lesson is for 2.9°.";
    assert!(lesson_text(Mechanism::Prediction, moved.clone()).contains(words));
    assert!(!lesson_text(Mechanism::Hysteresis, moved).contains("tilted by **"));
}

#[test]
fn a_lesson_states_that_numbers_have_changed() {
    let words =
        "**Changed in this run: load 200 N.** The computed numbers hold for the scene as written.";
    assert!(lesson_text(Mechanism::Prediction, measured()).contains(words));
}

#[test]
fn a_lesson_states_a_motion_that_contradicts_it() {
    let mut now = measured();
    assert!(!lesson_text(Mechanism::Torus, now.clone()).contains("**The motion is now"));
    for (mechanism, regime) in [
        (Mechanism::Torus, Regime::Chaotic),
        (Mechanism::Chaos, Regime::Periodic),
    ] {
        (now.regime, now.tilt) = (Some(regime), Some(0.1));
        let text = lesson_text(mechanism, now.clone());
        let words = format!("\n\n**The motion is now classified as {regime}.** This lesson");
        assert!(text.contains(&words), "{text}");
        assert!(text.contains("now tilted by **5.7°**"), "{text}");
        // An unclear type contradicts nothing.
        now.regime = Some(Regime::Undetermined);
        let text = lesson_text(mechanism, now.clone());
        assert!(!text.contains("**The motion is now"), "{text}");
    }
}

/// Growth that is predicted may follow; growth that is not predicted contradicts the lesson.
#[test]
fn a_vibration_that_grows_without_prediction_contradicts_it() {
    let agrees = |growth: f64, is_unstable: bool| {
        let mut computed = computed(Mechanism::NegativeSlope);
        for mode in &mut computed.modes {
            mode.unstable = is_unstable;
        }
        let lesson = Lesson {
            time: 0.1,
            computed: Arc::new(computed),
            measured: Measurements {
                growth: Some(Measured::new(growth, 1.0)),
                ..measured()
            },
        };
        let facts = lesson.facts();
        facts
            .iter()
            .find(|fact| fact.name == "vibration")
            .expect("a claim")
            .agrees
    };
    assert_eq!(agrees(80.0, true), Some(true));
    assert_eq!(agrees(-80.0, false), Some(true));
    assert_eq!(agrees(80.0, false), Some(false));
    assert_eq!(agrees(-80.0, true), None);
}

#[test]
fn a_later_kick_is_not_the_one_at_the_start() {
    let text = |kicks, last_kick| {
        let measured = Measurements {
            kicks,
            last_kick,
            ..measured()
        };
        lesson_text(Mechanism::WhichModeWins, measured)
    };
    let first = text(0, None);
    assert!(!first.contains("* last kick: "), "{first}");
    let kick = Kick {
        time_s: 0.05,
        size: 1e-3,
        seed: 9,
    };
    let later = text(2, Some(kick));
    for line in [
        "* kick at the start: 1.00 µm/s √kg\n",
        "* kicks since the start: **2**\n",
        "* last kick: **1.00 mm/s √kg**\n",
        "* seed of the last kick: **9**\n",
        "* time of the last kick: **50.0 ms**\n",
    ] {
        assert!(later.contains(line), "{later}");
    }
}

#[test]
fn a_motion_at_rest_is_called_so() {
    let rest = Measurements {
        at_rest: true,
        level: 1e-13,
        lines: Vec::new(),
        ..measured()
    };
    for mechanism in [Mechanism::ExchangedFriction, Mechanism::Prediction] {
        let text = lesson_text(mechanism, rest.clone());
        assert!(
            text.contains("* strongest line: **none, at rest**\n"),
            "{text}"
        );
    }
}

#[test]
fn a_lesson_changes_with_the_numbers_that_it_shows() {
    let mut now = lesson_of(Mechanism::Torus, measured());
    let text = lesson(&now);
    now.measured.level *= 1.5;
    assert_eq!(lesson(&now), text);
    now.measured.lines[0].frequency = 4210.0;
    assert!(lesson(&now).contains("4.21 kHz"));
}

#[test]
fn the_views_of_a_run_are_listed() {
    let mut header = header();
    let rows = |header: &Header| {
        let text = fill("views", view_values(header)).unwrap();
        let (table, _) = text.split_once("\n\nDrag the time cursor").unwrap();
        assert!(table.lines().all(|row| row.starts_with('|')), "{text}");
        table.lines().count() - 2
    };
    assert_eq!(rows(&header), 3, "patch, phase portrait and health");
    let AnalysisSpec {
        recurrence, delay, ..
    } = Scene::load("chaos-5deg").unwrap().analysis;
    header.analysis = AnalysisSpec {
        recurrence,
        delay,
        ..AnalysisSpec::default()
    };
    assert_eq!(rows(&header), 7);
    let given: HashSet<String> = view_values(&header)
        .try_iter()
        .unwrap()
        .map(|name| name.to_string())
        .collect();
    assert_eq!(given, variables("views"));
}
