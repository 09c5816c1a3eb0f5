//! The promises of a scene file: presets, ranges, and one clear message for each fault.

use std::io::Write;

use proptest::prelude::*;

use super::keys::{ALL, split};
use super::*;
use crate::analysis::{Direction, DivergenceMethod, Norm, Threshold};
use crate::fem::Elements;
use crate::joint::{Frequencies, Friction, JointSpec, Stribeck};

/// The smallest scene: the required keys only.
const SMALLEST: &str = "\
[load]
load_n = 150
tilt_deg = 2.0
[time]
duration_ms = 10
";

fn smallest() -> Scene {
    Scene::parse("mine.toml", SMALLEST).expect("valid")
}

fn joint_of(scene: &Scene) -> &JointSpec {
    &scene.joint().expect("a joint").spec
}

fn tilt_of(scene: &Scene) -> &Schedule {
    &scene.joint().expect("a joint").tilt
}

/// The message about a text that must be refused.
fn refusal(text: impl AsRef<[u8]>) -> String {
    Scene::parse("mine.toml", text)
        .expect_err("must be refused")
        .to_string()
}

/// The message about the smallest scene with a line added at its end.
fn refusal_with(added: &str) -> String {
    refusal(format!("{SMALLEST}{added}"))
}

#[test]
fn defaults_are_the_papers() {
    let scene = smallest();
    let TiltedJoint {
        spec: joint, tilt, ..
    } = scene.joint().expect("a joint");
    assert_eq!(scene.name, "mine");
    assert_eq!(scene.title, "mine");
    let body = scene.ball_on_beam().expect("ball and beam");
    assert_eq!(body.geometry.ball_diameter, 0.03175);
    assert_eq!(body.geometry.beam_length, 0.2);
    assert_eq!(body.material.young, 207e9);
    assert_eq!(body.families.count(), 11);
    assert_eq!(body.frequencies, Frequencies::Published);
    assert_eq!(joint.socket.diameter, 0.03195);
    let speed: f64 = joint.rotation.iter().map(|x| x * x).sum();
    assert!((speed - 1.0).abs() < 1e-15);
    assert_eq!(joint.friction, Friction::None);
    assert!(joint.damping.is_empty());
    assert_eq!(scene.analysis, AnalysisSpec::default());
    assert_eq!(*tilt, Schedule::constant(2f64.to_radians()));
    assert_eq!(scene.duration, 0.01);
    assert_eq!(scene.sample_rate, 2e5);
    assert_eq!(scene.integrator.method, Method::Lawson54);
    assert!(scene.warnings().is_empty());
}

#[test]
fn every_default_is_valid() {
    let everything = "
        [body]\n[socket]\n[rotation]\n[contact]\n[start]\n[record]
        [analysis.spectrum]\n[analysis.spectrogram]
        [analysis.recurrence]\nthreshold_um = 0.25
        [analysis.delay]\n[analysis.section]\n[analysis.chaos]\n[analysis.regime]
        [analysis.quantification]\nthreshold_spread = 0.2
        [friction]\nmu_s = 0.5\nmu_d = 0.2
        [damping]\nratio = 0.001";
    let scene = Scene::parse("m", format!("{SMALLEST}{everything}")).expect("valid");
    assert!(scene.analysis.spectrum.is_some() && scene.analysis.spectrogram.is_some());
    let recurrence = scene.analysis.recurrence.expect("asked for");
    assert_eq!(recurrence.nearness.threshold, Threshold::Distance(2.5e-7));
    assert_eq!(recurrence.embedding.lag, Setting::Given(60e-6));
    let quantification = scene.analysis.quantification.expect("asked for");
    assert_eq!(quantification.nearness.threshold, Threshold::Spread(0.2));
    let chaos = scene.analysis.chaos.expect("asked for");
    assert_eq!(chaos.method, DivergenceMethod::Rosenstein);
    assert!(scene.analysis.delay.is_some() && scene.analysis.regime.is_some());
    assert_eq!(
        scene.analysis.section.as_ref().expect("asked for").surface,
        SectionSurface::Delay {
            lag: Setting::Given(60e-6),
            level: 0.0
        }
    );
    assert_eq!(joint_of(&scene).damping, [0.001; 11]);
    assert_eq!(
        joint_of(&scene).friction,
        Friction::Stribeck {
            law: Stribeck {
                mu_s: 0.5,
                mu_d: 0.2,
                creep: 1000.0,
                stribeck: 10.0
            },
            radial: true
        }
    );
}

#[test]
fn every_key_is_known_once_and_has_its_unit_in_its_name() {
    for key in ALL {
        let path = key.path();
        let row = key.guide_row();
        let suffix = match row.split('|').nth(3).map(str::trim) {
            Some("mm/s") => "_mm_per_s".to_owned(),
            Some("s/m") => "_s_per_m".to_owned(),
            Some("rad/s") => ".rad_s".to_owned(),
            Some("kg/m^3") => "_kg_m3".to_owned(),
            Some("N/kg") => "_n_per_kg".to_owned(),
            Some("m/s^2") => "_m_per_s2".to_owned(),
            Some("") => String::new(),
            Some(symbol) => format!("_{}", symbol.to_lowercase()),
            None => panic!("no unit column: {row}"),
        };
        assert!(path.ends_with(&suffix), "{path}: {suffix}");
        let twins = ALL.iter().filter(|other| other.path() == path).count();
        assert_eq!(twins, 1, "{path}");
    }
}

#[test]
fn the_guide_lists_every_key_as_the_program_knows_it() {
    let guide = include_str!("../guide/scenes.md");
    let reference = key_reference();
    let headings: Vec<&str> = reference
        .lines()
        .filter(|line| line.starts_with('#'))
        .collect();
    for (k, heading) in headings.iter().enumerate() {
        assert!(!headings[..k].contains(heading), "{heading} stands twice");
    }
    assert!(
        guide.ends_with(&reference),
        "src/guide/scenes.md must end with this reference:\n{reference}"
    );
}

#[test]
fn presets_are_valid_and_named_after_themselves() {
    for preset in PRESETS {
        let scene = preset.scene().unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.name, preset.name);
        assert_eq!(scene.text, preset.text);
        assert_ne!(scene.title, preset.name);
        assert!(scene.about.len() > 100, "{}", preset.name);
        assert!(scene.warnings().is_empty(), "{}", preset.name);
    }
    assert!(preset(DEFAULT_SCENE).is_some());
}

#[test]
fn a_printed_preset_is_the_same_scene_from_a_file() {
    for preset in PRESETS {
        let mut file = tempfile::NamedTempFile::new().expect("temporary file");
        file.write_all(preset.text.as_bytes()).expect("written");
        let path = file.path().to_str().expect("UTF-8 path");
        let from_file = Scene::load(path).expect("valid");
        assert_eq!(from_file, preset.scene().expect("valid"));
    }
}

#[test]
fn the_regimes_have_their_parameters() {
    let load = |name| Scene::load(name).expect("preset");
    let periodic = load("periodic-2deg");
    assert_eq!(joint_of(&periodic).azimuth, 0.0);
    assert_eq!(joint_of(&periodic).contact.stiffness_factor, 1.0);
    let shift = load("mode-shift-3.5deg");
    assert_eq!(joint_of(&shift).azimuth, 135f64.to_radians());
    assert_eq!(tilt_of(&shift).at(0.0), 3.5f64.to_radians());
    for name in ["torus-3deg", "chaos-5deg", "tilt-ramp"] {
        let scene = load(name);
        let natural = joint_of(&scene);
        assert_eq!(natural.azimuth, 0.0);
        assert_eq!(natural.contact.stiffness_factor, 2.75);
        let Friction::Stribeck {
            law: Stribeck {
                creep, stribeck, ..
            },
            ..
        } = natural.friction
        else {
            panic!("{name} has friction");
        };
        assert_eq!((creep, stribeck), (1000.0, 13.25));
    }
    let Friction::Stribeck {
        law: Stribeck {
            creep, stribeck, ..
        },
        ..
    } = joint_of(&load("printed-friction")).friction
    else {
        panic!("printed-friction has friction");
    };
    assert_eq!((creep, stribeck), (10.0, 1000.0));
    let ramp = load("tilt-ramp");
    assert_eq!(tilt_of(&ramp).at(0.0), 0.0);
    assert_eq!(tilt_of(&ramp).at(ramp.duration), 6f64.to_radians());
}

#[test]
fn unknown_keys_name_line_and_nearest() {
    assert_eq!(
        refusal("[load]\nload_n = 150\ntilt_deq = 2\n[time]\nduration_ms = 1\n"),
        "mine.toml:3: unknown key `load.tilt_deq` (did you mean `load.tilt_deg`?); \
         [load] knows load_n, load, load_steps, load_csv, tilt_deg, tilt, tilt_steps, tilt_csv, azimuth_deg, \
         load_sine, tilt_sine"
    );
    assert!(
        refusal_with("[record]\nenergy_rate = 1\n")
            .contains("did you mean `record.energy_rate_khz`")
    );
    assert!(!refusal_with("[analysis.nope]\n").contains("did you mean"));
    let wrong_table = refusal_with("azimuth_deg = 3\n");
    assert!(wrong_table.starts_with("mine.toml:6: unknown key `time.azimuth_deg`"));
    assert!(wrong_table.contains("did you mean `load.azimuth_deg`?"));
    assert!(
        refusal_with("[frction]\n")
            .contains(":6: unknown key `frction` (did you mean `friction`?)")
    );
    assert!(refusal_with("[analysis.spectrm]\n").contains("did you mean `analysis.spectrum`?"));
    assert!(refusal_with("[qqqqqqqqqqqq]\n").contains("`qqqqqqqqqqqq`; the top level knows name,"));
    let knot = "[load]\nload_n = 1\ntilt = [{ time_ms = 0, tilt_deg = 0, tlt = 1 }]\n";
    assert!(refusal(knot).contains(":3: unknown key `load.tilt.tlt`"));
}

#[test]
fn the_first_unknown_key_in_reading_order_is_named() {
    assert!(refusal("zzz = 1\naaa = 2\n").contains(":1: unknown key `zzz`"));
}

#[test]
fn missing_values_say_what_is_needed() {
    assert_eq!(
        refusal("# no load\n[load]\ntilt_deg = 1\n"),
        "mine.toml:2: `load.load_n` is missing; it must be a number above 0, at most 1000000 N \
         (exactly one of `load_n`, `load`, `load_steps`, `load_sine` and `load_csv`)"
    );
    assert!(refusal("").contains("mine.toml:1: `load.load_n` is missing"));
    let no_tilt = refusal("[load]\nload_n = 1\n[time]\nduration_ms = 1\n");
    assert!(no_tilt.contains(":1: `load.tilt_deg` is missing"));
    assert!(
        no_tilt.contains(
            "exactly one of `tilt_deg`, `tilt`, `tilt_steps`, `tilt_sine` and `tilt_csv`"
        )
    );
    let knot = "[load]\nload_n = 1\n[[load.tilt]]\ntime_ms = 0\n[time]\nduration_ms = 1\n";
    assert!(refusal(knot).contains(":3: `load.tilt.tilt_deg` is missing"));
    assert!(refusal_with("[friction]\nmu_s = 0.5\n").contains(":6: `friction.mu_d` is missing"));
    let threshold = refusal_with("[analysis.recurrence]\n");
    assert!(threshold.contains(":6: `analysis.recurrence.threshold_rate` is missing"));
}

#[test]
fn out_of_range_values_name_line_and_range() {
    assert_eq!(
        refusal(SMALLEST.replace("= 150", "= -150")),
        "mine.toml:2: `load.load_n` = -150 is out of range; it must be a number above 0, at most 1000000 N"
    );
    assert_eq!(
        refusal(SMALLEST.replace("= 2.0", "= 90.5")),
        "mine.toml:3: `load.tilt_deg` = 90.5 is out of range; it must be a number from -90 to 90 deg"
    );
    for order in [0, 9] {
        assert_eq!(
            refusal_with(&format!("[body]\nelement_order = {order}\n")),
            format!(
                "mine.toml:7: `body.element_order` = {order} is out of range; \
                 it must be a whole number from 1 to 8"
            )
        );
    }
    assert_eq!(
        refusal_with("[contact]\nnodes = 0\n"),
        "mine.toml:7: `contact.nodes` = 0 is out of range; \
         it must be a whole number from 1 to 10000"
    );
    for value in ["nan", "inf", "-inf", "1e999"] {
        let message = refusal(SMALLEST.replace("= 150", &format!("= {value}")));
        assert!(message.contains(&format!(":2: `load.load_n` = {value} is out of range")));
    }
    assert!(refusal_with("[start]\nseed = 99999999999999999999\n").contains("`start.seed` = 9"));
    assert!(refusal_with("[rotation]\nrad_s = [0, nan, 0]\n").contains("`rotation.rad_s`"));
}

/// Every number of every key is refused when it is not finite, whatever the table.
#[test]
fn no_key_takes_a_value_that_is_not_finite() {
    for key in ALL {
        let (table, name) = split(key.path());
        for value in ["nan", "inf", "-inf"] {
            let text = match table {
                "" => format!("{name} = {value}\n{SMALLEST}"),
                // What is a list of tables takes no number at all.
                _ if ALL.iter().any(|key| key.path() == table) => {
                    format!("{table} = [{{ {name} = {value} }}]\n")
                }
                "load" | "time" | "rotation" | "load.load_sine" | "load.tilt_sine" => {
                    format!("{table}.{name} = {value}\n")
                }
                table => format!("{SMALLEST}[{table}]\n{name} = {value}\n"),
            };
            let message = Scene::parse("mine.toml", text)
                .expect_err("refused")
                .to_string();
            assert!(!message.contains("unknown key"), "{message}");
        }
    }
}

#[test]
fn wrong_types_and_choices_say_what_fits() {
    assert_eq!(
        refusal(SMALLEST.replace("= 150", "= \"heavy\"")),
        "mine.toml:2: `load.load_n` is \"heavy\"; it must be a number above 0, at most 1000000 N"
    );
    assert_eq!(
        refusal_with("[contact]\nquadrature = \"gaus\"\n"),
        "mine.toml:7: `contact.quadrature` = \"gaus\" is not a choice \
         (did you mean `gauss`?); it must be \"rings\" or \"gauss\""
    );
    assert!(refusal_with("[contact]\nnodes = 10.5\n").contains("must be a whole number"));
    assert!(refusal("load = 3\n").contains(":1: `load` is a table"));
    assert!(refusal("[[load]]\nload_n = 3\n").contains(":1: `load` is a table"));
    let long = format!("title = [\"{}\"]\n", "x".repeat(1000));
    assert!(refusal(long).len() < 200);
}

#[test]
fn what_is_not_toml_or_not_text_says_where() {
    assert!(refusal("[load]\nload_n 150\n").starts_with("mine.toml:2: not valid TOML: "));
    assert!(refusal("a = 1\na = 2\n").starts_with("mine.toml:2: not valid TOML: duplicate key"));
    assert!(
        refusal(b"[load]\nload_n = \xff\n").starts_with("mine.toml:2: the scene file is not UTF-8")
    );
    assert!(refusal("[".repeat(100_000)).contains("not valid TOML"));
    assert!(refusal(format!("a = {}", "[".repeat(100_000))).contains("not valid TOML"));
}

#[test]
fn a_byte_order_mark_and_windows_lines_are_no_fault() {
    let marked = format!("\u{feff}{}", SMALLEST.replace('\n', "\r\n"));
    let scene = Scene::parse("mine.toml", &marked).expect("valid");
    assert_eq!(scene.subject, smallest().subject);
    let bad = marked.replace("2.0", "200");
    assert!(refusal(bad).starts_with("mine.toml:3: `load.tilt_deg`"));
}

#[test]
fn values_must_fit_together() {
    let cases = [
        (
            "[body]\nbeam_diameter_mm = 40\n",
            ":7: `body.beam_diameter_mm`",
        ),
        (
            "[body]\nball_diameter_mm = 15\n",
            ":7: `body.beam_diameter_mm`",
        ),
        (
            "[body]\nball_diameter_mm = 32\n",
            ":7: `socket.diameter_mm`",
        ),
        (
            "[socket]\ndiameter_mm = 31.75\n",
            ":7: `socket.diameter_mm`",
        ),
        (
            "[body]\nbeam_length_mm = 15\nbeam_reaches = \"centre\"\n",
            ":7: `body.beam_length_mm`",
        ),
        (
            "[body]\nbeam_length_mm = 5000\nelement_size_mm = 0.1\n",
            ":8: `body.element_size_mm`",
        ),
        // As many elements as that are allowed, but not of this order.
        (
            "[body]\nelement_size_mm = 2\nelement_order = 8\n",
            ":8: `body.element_size_mm`: a body of this size would take about 599 elements",
        ),
        (
            "[body]\nbending_pairs = 0\ntorsion = 0\naxial = 0\n",
            ":9: `body.bending_pairs`",
        ),
        ("[body]\ntorsion = 3\n", ":7: `body.frequencies`"),
        (
            "[damping]\nratio = [0.1, 0.1]\n",
            ":7: `damping.ratio`: 2 ratios for 11 modes",
        ),
        ("method = \"rk4\"\n", ":6: `time.max_step_us`"),
        (
            "[analysis.spectrum]\nwindow_ms = 0.1\n[analysis.spectrogram]\nmax_frequency_khz = 101\n",
            ":9: `analysis.spectrogram.max_frequency_khz`",
        ),
        (
            "sample_rate_khz = 100\n[analysis.spectrum]\nwindow_ms = 0.1\n",
            ":8: `analysis.spectrum.window_ms`",
        ),
        (
            "[analysis.recurrence]\nthreshold_rate = 0.1\nwindow_ms = 1\n",
            ":8: `analysis.recurrence.size`",
        ),
        (
            "[analysis.recurrence]\nthreshold_rate = 0.1\nlag_us = 4\n",
            ":8: `analysis.recurrence.lag_us`",
        ),
        (
            "[analysis.recurrence]\nthreshold_rate = 0.1\nthreshold_um = 4\n",
            ":8: `analysis.recurrence.threshold_um`",
        ),
        (
            "[analysis.recurrence]\nthreshold_rate = 0.1\nneighbours = 9\nthreshold_spread = 1\n",
            ":9: `analysis.recurrence.neighbours`",
        ),
        (
            "[analysis.recurrence]\nneighbours = 400\n",
            ":7: `analysis.recurrence.neighbours`: 400 neighbours among 400 states",
        ),
        (
            "[analysis.recurrence]\nthreshold_rate = 0.1\nlag_us = \"auto\"\n",
            ":8: `analysis.recurrence.lag_us`: \"auto\" takes what [analysis.delay] chooses",
        ),
        (
            "[analysis.delay]\nwindow_ms = 4\n",
            ":7: `analysis.delay.window_ms`: largest_lag_us, largest_dimension reach over 2.4 ms",
        ),
        (
            "[analysis.quantification]\nthreshold_rate = 0.1\nstep_us = 2000\n",
            ":8: `analysis.quantification.step_us`",
        ),
        (
            "[analysis.quantification]\nthreshold_rate = 0.1\ntheiler_us = 12e3\n",
            ":8: `analysis.quantification.window_ms`: theiler_us reach over 12 ms",
        ),
        (
            "[analysis.quantification]\nneighbours = 1988\n",
            ":7: `analysis.quantification.neighbours`: 1988 neighbours among 1988 states",
        ),
        (
            "[analysis.section]\noffset_um = 1\n",
            ":7: `analysis.section.offset_um`",
        ),
        (
            "[analysis.section]\nplane_q = [1]\nlevel_um = 0\nshown = [\"q1\", \"q2\"]\n",
            ":8: `analysis.section.level_um`",
        ),
        (
            "[analysis.section]\nplane_q = [0, 0]\nshown = [\"q1\", \"q2\"]\n",
            ":7: `analysis.section.plane_q`: a plane needs a normal",
        ),
        (
            "[analysis.section]\nplane_qdot_ms = [0,0,0,0,0,0,0,0,0,0,0,1]\nshown = [\"q1\", \"q2\"]\n",
            ":7: `analysis.section.plane_qdot_ms`: more numbers than modes, of which there are 11",
        ),
        (
            "[analysis.section]\nplane_q = [1]\nshown = [\"q1\", \"qdot12\"]\n",
            ":8: `analysis.section.shown`: a mode that is not there",
        ),
        (
            "[analysis.section]\nplane_q = [1]\n",
            ":6: `analysis.section.shown` is missing",
        ),
        (
            "[analysis.chaos]\nhorizon_ms = 45\n",
            ":7: `analysis.chaos.window_ms`",
        ),
        (
            "[analysis.chaos]\nradius = 0.1\n",
            ":7: `analysis.chaos.radius`: nearest neighbours have no radius",
        ),
        (
            "[analysis.chaos]\nmethod = \"kantz\"\n",
            ":6: `analysis.chaos.radius` is missing",
        ),
        (
            "[record]\nenergy_rate_khz = 201\n",
            ":7: `record.energy_rate_khz`",
        ),
    ];
    for (added, expected) in cases {
        let message = refusal_with(added);
        assert!(
            message.starts_with(&format!("mine.toml{expected}")),
            "{added}: {message}"
        );
    }
}

#[test]
fn the_laboratory_reads_its_keys_in_si() {
    let added = "
        [analysis.delay]
        window_ms = 10\nevery_ms = 5\nlargest_lag_us = 200\nlargest_dimension = 6\nfalse_share = 0.05
        [analysis.recurrence]
        lag_us = \"auto\"\ndimension = \"auto\"\nnorm = \"maximum\"\nneighbours = 20
        [analysis.section]
        plane_q = [0, 1]\nplane_qdot_ms = [2.0]\noffset_um = 0.5\nshown = [\"q1\", \"qdot11\"]
        direction = \"both\"
        [analysis.chaos]
        method = \"kantz\"\nradius = 0.1
        [analysis.regime]
        silence_um = 1.0";
    let scene = Scene::parse("m", format!("{SMALLEST}{added}")).expect("valid");
    let AnalysisSpec {
        delay,
        recurrence,
        section,
        chaos,
        regime,
        ..
    } = scene.analysis;
    let delay = delay.expect("asked for");
    assert_eq!((delay.sliding.window, delay.sliding.every), (10e-3, 5e-3));
    assert_eq!((delay.largest_lag, delay.largest_dimension), (200e-6, 6));
    assert_eq!((delay.bins, delay.false_share), (32, 0.05));
    let recurrence = recurrence.expect("asked for");
    assert_eq!(recurrence.embedding.lag, Setting::Auto);
    assert_eq!(recurrence.embedding.dimension, Setting::Auto);
    assert_eq!(recurrence.nearness.norm, Norm::Maximum);
    assert_eq!(recurrence.nearness.threshold, Threshold::Neighbours(20));
    assert_eq!(
        section.expect("asked for"),
        SectionSpec {
            every: 1e-3,
            surface: SectionSurface::State {
                normal_q: vec![0.0, 1.0],
                normal_qdot: vec![2e-3],
                offset: 0.5e-6,
                shown: [StateCoordinate::Q(0), StateCoordinate::Qdot(10)],
            },
            direction: Direction::Both,
        }
    );
    let method = chaos.expect("asked for").method;
    assert_eq!(method, DivergenceMethod::Kantz { radius: 0.1 });
    assert_eq!(regime.expect("asked for").silence, 1e-6);
}

#[test]
fn exponents_and_the_butterfly_read_their_keys() {
    let read = |added: &str| Scene::parse("m", format!("{SMALLEST}{added}")).expect("valid");
    let plain = read("");
    assert_eq!(plain.integrator.events, Events::Through);
    assert_eq!(
        (plain.analysis.exponents, plain.analysis.butterfly),
        (None, None)
    );
    let scene = read("events = \"exact\"\n[analysis.exponents]\n[analysis.butterfly]\n");
    assert_eq!(scene.integrator.events, Events::Exact);
    let default = ExponentsSpec {
        count: 3,
        settle: 50e-3,
        every: 1e-3,
    };
    assert_eq!(scene.analysis.exponents, Some(default));
    let butterfly = ButterflySpec {
        start: 50e-3,
        distance: 1e-9,
        every: 1e-3,
    };
    assert_eq!(scene.analysis.butterfly, Some(butterfly));
    let count = |added: &str| {
        let scene = read(&format!("[analysis.exponents]\n{added}"));
        scene.analysis.exponents.map(|spec| spec.count)
    };
    assert_eq!(count("count = \"all\""), Some(22));
    assert_eq!(count("count = 22"), Some(22));
    let one_mode = "[body]\nbending_pairs = 0\ntorsion = 1\naxial = 0";
    assert_eq!(count(one_mode), Some(2), "no more than there are");
}

#[test]
fn exponents_and_the_butterfly_refuse_what_cannot_be() {
    let cases = [
        (
            "events = \"exactly\"\n",
            "is not a choice (did you mean `exact`?)",
        ),
        ("[analysis.exponents]\ncount = 0\n", "out of range"),
        (
            "[analysis.exponents]\ncount = 23\n",
            ":7: `analysis.exponents.count`: 23 exponents of a motion that has 22",
        ),
        (
            "[analysis.exponents]\ncuont = 2\n",
            "did you mean `analysis.exponents.count`?",
        ),
        (
            "[analysis.exponent]\n",
            "did you mean `analysis.exponents`?",
        ),
        (
            "[analysis.butterfly]\ndistance = 0.5\n",
            "must be a number from 1e-12 to 0.01",
        ),
        (
            "[analysis.butterfly]\nstart = 3\n",
            "did you mean `analysis.butterfly.start_ms`?",
        ),
    ];
    for (added, expected) in cases {
        let message = refusal_with(added);
        assert!(message.contains(expected), "{added}: {message}");
    }
}

#[test]
fn what_never_begins_is_told() {
    let added = "[analysis.exponents]\nsettle_ms = 5\n[analysis.butterfly]\nstart_ms = 20\n";
    let scene = Scene::parse("m", format!("{SMALLEST}{added}")).expect("allowed");
    let scene = scene.with_duration(10.0).expect("valid");
    let warnings = scene.warnings();
    let [warning @ SceneWarning::NeverBegins { .. }] = &warnings[..] else {
        panic!("{warnings:?}")
    };
    let words = warning.to_string();
    assert!(
        words.contains("at 10 ms, before analysis.butterfly.start_ms = 20"),
        "{words}"
    );
}

#[test]
fn knots_increase_and_are_given_once() {
    let with = |knots: &str| format!("[load]\nload_n = 1\n{knots}\n[time]\nduration_ms = 10\n");
    let ramp = "tilt = [{ time_ms = 1, tilt_deg = 0 }, { time_ms = 3, tilt_deg = 6 }]";
    let scene = Scene::parse("ramp.toml", with(ramp)).expect("valid");
    assert!((tilt_of(&scene).at(0.002).to_degrees() - 3.0).abs() < 1e-12);
    assert!(refusal(with("tilt = []")).contains(":3: `load.tilt` = [] is out of range"));
    assert!(
        refusal(with(&format!("tilt_deg = 1\n{ramp}")))
            .contains(":4: `load.tilt`: the tilt is given twice")
    );
    let back = "[[load.tilt]]\ntime_ms = 3\ntilt_deg = 0\n[[load.tilt]]\ntime_ms = 3\ntilt_deg = 6";
    assert!(refusal(with(back)).contains(":6: `load.tilt.time_ms`: this time is not later"));
    let many: Vec<_> = (0..10_001)
        .map(|k| format!("{{ time_ms = {k}, tilt_deg = 0 }}"))
        .collect();
    assert!(
        refusal(with(&format!("tilt = [{}]", many.join(", "))))
            .contains("a list of 1 to 10000 tables")
    );
    let most = with(&format!("tilt = [{}]", many[..10_000].join(", ")));
    assert_eq!(
        tilt_of(&Scene::parse("m", most).expect("valid"))
            .values()
            .len(),
        10_000
    );
}

#[test]
fn the_load_never_lies_along_the_rotation() {
    let axial = format!("{SMALLEST}[rotation]\nrad_s = [0, 0, 1]\n");
    assert!(Scene::parse("m", &axial).is_ok());
    let along = axial.replace("tilt_deg = 2.0", "tilt_deg = 0");
    assert!(refusal(along).starts_with("mine.toml:7: `rotation.rad_s`: at a tilt of 0.000 deg"));
    let through = axial.replace(
        "tilt_deg = 2.0",
        "tilt = [{ time_ms = 0, tilt_deg = -3 }, { time_ms = 9, tilt_deg = 3 }]",
    );
    assert!(refusal(through).contains("at a tilt of 0.000 deg"));
    // The rotation leans by 30 degrees, towards an azimuth of 45 degrees, and points down.
    let lean = format!(
        "{SMALLEST}[rotation]\nrad_s = [-0.3535533905932738, -0.3535533905932738, -0.8660254037844387]\n"
    );
    let meet = lean.replace("tilt_deg = 2.0", "tilt_deg = -30\nazimuth_deg = 225");
    assert!(refusal(meet).contains("at a tilt of -30.000 deg"));
    let miss = lean.replace("tilt_deg = 2.0", "tilt_deg = 30\nazimuth_deg = 225");
    assert!(Scene::parse("m", miss).is_ok());
    assert!(smallest().with_tilt(90.0).is_ok());
    // Without rotation nothing slides at any tilt: the joint is at rest.
    let rest = format!("{SMALLEST}[rotation]\nrad_s = [0, 0, 0]\n");
    assert!(Scene::parse("m", rest.replace("tilt_deg = 2.0", "tilt_deg = 0")).is_ok());
    let axial = Scene::parse("m", axial).expect("valid");
    let message = axial.with_tilt(0.0).expect_err("refused").to_string();
    assert!(message.starts_with("override of scene m: `rotation.rad_s`"));
}

#[test]
fn neighbours_can_be_left_out() {
    let scene = Scene::load("chaos-5deg").unwrap();
    assert!(scene.follows_neighbours() && scene.mechanism.is_some());
    let scene = scene.without_neighbours();
    assert!(!scene.follows_neighbours());
    assert!(scene.analysis.regime.is_some(), "the rest stays");
    assert_eq!(scene.mechanism, None, "its picture was the second copy");
    for table in ["exponents", "butterfly"] {
        let line = format!("# overridden for this run: [analysis.{table}] = left out");
        assert!(scene.text.contains(&line), "{}", scene.text);
    }
    let torus = Scene::load("torus-3deg").unwrap().without_neighbours();
    assert!(torus.mechanism.is_some() && !torus.text.contains("butterfly"));
}

#[test]
fn overrides_obey_the_ranges_and_are_recorded() {
    let scene = smallest()
        .with_tilt(-3.5)
        .and_then(|scene| scene.with_duration(20.0))
        .expect("valid");
    assert_eq!(*tilt_of(&scene), Schedule::constant((-3.5f64).to_radians()));
    assert_eq!(scene.duration, 0.02);
    assert_eq!(
        scene.text,
        format!(
            "{SMALLEST}# overridden for this run: load.tilt_deg = -3.5\n\
             # overridden for this run: time.duration_ms = 20\n"
        )
    );
    for tilt in [90.1, -91.0, f64::NAN, f64::INFINITY] {
        let message = smallest().with_tilt(tilt).expect_err("refused").to_string();
        assert!(message.starts_with("override of scene mine: `load.tilt_deg` = "));
        assert!(message.ends_with("it must be a number from -90 to 90 deg"));
    }
    for duration in [0.0, -1.0, 1e6, f64::NAN] {
        assert!(smallest().with_duration(duration).is_err(), "{duration}");
    }
}

#[test]
fn warnings_are_typed() {
    let friction = "[friction]\nmu_s = 0.25\nmu_d = 0.55\n";
    let scene = Scene::parse("m", format!("{SMALLEST}{friction}")).expect("allowed");
    assert_eq!(
        scene.warnings(),
        [SceneWarning::KineticAboveStatic {
            mu_s: 0.25,
            mu_d: 0.55
        }]
    );
    let ramp = Scene::load("tilt-ramp").expect("preset");
    let cut = ramp.clone().with_duration(50.0).expect("valid");
    assert!(matches!(
        cut.warnings()[..],
        [SceneWarning::ScheduleCutShort { .. }]
    ));
    assert!(ramp.with_tilt(1.0).expect("valid").warnings().is_empty());
}

#[test]
fn names_that_are_no_scene_offer_the_nearest() {
    let message = |name: &str| Scene::load(name).expect_err("no scene").to_string();
    let near = message("chaos-5dg");
    assert!(near.starts_with("no scene is called `chaos-5dg` (did you mean `chaos-5deg`?)"));
    assert!(near.contains("tilt-ramp, printed-friction"));
    assert!(!message("").contains("did you mean"));
    assert!(
        message("absent/scene.toml").starts_with("cannot read the scene file `absent/scene.toml`")
    );
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().to_str().expect("UTF-8 path");
    assert!(message(path).starts_with("cannot read the scene file"));
}

#[cfg(unix)]
#[test]
fn an_endless_file_is_refused() {
    let message = Scene::load("/dev/zero").expect_err("refused").to_string();
    assert!(message.contains("is larger than"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = Scene::parse("random", bytes);
    }

    /// A preset with a stretch replaced: still a scene whose numbers are sane, or one message.
    #[test]
    fn mutated_presets_never_panic(
        which in 0..PRESETS.len(),
        start in any::<proptest::sample::Index>(),
        length in 0usize..12,
        replacement in r#"[-0-9.enaif\[\]{}=" \n_,x]{0,6}"#,
    ) {
        let mut text = PRESETS[which].text.as_bytes().to_vec();
        let start = start.index(text.len());
        let end = (start + length).min(text.len());
        text.splice(start..end, replacement.bytes());
        match Scene::parse("mutated", text) {
            Ok(scene) => {
                prop_assert!(scene.duration.is_finite() && scene.duration > 0.0);
                if let Ok(joint) = scene.joint() {
                    prop_assert!(joint.spec.load.is_finite() && joint.spec.load > 0.0);
                    prop_assert!(joint.tilt.max().abs() <= std::f64::consts::FRAC_PI_2);
                    prop_assert!((1..=10_000).contains(&joint.spec.contact.nodes));
                }
            }
            Err(error) => prop_assert!(error.to_string().contains("mutated")),
        }
    }
}

/// The defaults of the keys are the elements that `fem` recommends, and stated ones are taken.
#[test]
fn the_default_mesh_is_the_recommended_one() {
    let scene = Scene::load("tilt-ramp").expect("preset");
    let elements = scene.ball_on_beam().expect("a beam").elements;
    let recommended = Elements::default();
    assert!((elements.size - recommended.size).abs() < 1e-12);
    assert_eq!(elements.order, recommended.order);
    let quadratic = format!("{SMALLEST}[body]\nelement_order = 2\n");
    let stated = Scene::parse("m", quadratic).expect("valid");
    assert_eq!(stated.ball_on_beam().expect("a beam").elements.order, 2);
}
