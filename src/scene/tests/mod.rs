//! Scene files: presets, ranges, error messages.

mod effects;
mod messages;
mod moving_patch;
mod schedules;
mod small;
mod together;

use std::io::Write;

use super::*;
use crate::analysis::{
    chaos::DivergenceMethod,
    poincare::Direction,
    recurrence::{Norm, Threshold},
};
use crate::dynamics::MethodName;
use crate::fem::Elements;
use crate::joint::{Frequencies, Friction, JointSpec, Stribeck};

/// A scene with the required keys only.
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

/// Error message for an invalid text.
fn refusal(text: impl AsRef<[u8]>) -> String {
    Scene::parse("mine.toml", text)
        .expect_err("must be rejected")
        .to_string()
}

/// Error message for [`SMALLEST`] with lines appended.
fn refusal_with(added: &str) -> String {
    refusal(format!("{SMALLEST}{added}"))
}

#[test]
fn defaults_are_those_of_the_paper() {
    let scene = smallest();
    let LoadedJoint {
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
    assert_eq!(scene.integrator.method, MethodName::Lawson54);
    assert!(scene.warnings().is_empty());
}

#[test]
fn every_default_is_valid() {
    let everything = "
        [body]\n[socket]\n[rotation]\n[contact]\n[start]\n[record]
        [analysis.spectrum]\n[analysis.spectrogram]
        [analysis.recurrence]\nthreshold_um = 0.25
        [analysis.delay]\n[analysis.section]\n[analysis.chaos]\n[analysis.regime]
        [analysis.quantification]\nthreshold_std = 0.2
        [friction]\nmu_s = 0.5\nmu_d = 0.2
        [damping]\nratio = 0.001";
    let scene = Scene::parse("m", format!("{SMALLEST}{everything}")).expect("valid");
    assert!(scene.analysis.spectrum.is_some() && scene.analysis.spectrogram.is_some());
    let recurrence = scene.analysis.recurrence.expect("present");
    assert_eq!(recurrence.criterion.threshold, Threshold::Distance(2.5e-7));
    assert_eq!(recurrence.embedding.lag, Some(60e-6));
    let quantification = scene.analysis.quantification.expect("present");
    assert_eq!(quantification.criterion.threshold, Threshold::Spread(0.2));
    let chaos = scene.analysis.chaos.expect("present");
    assert_eq!(chaos.method, DivergenceMethod::Rosenstein);
    assert!(scene.analysis.delay.is_some() && scene.analysis.regime.is_some());
    assert_eq!(
        scene.analysis.section.as_ref().expect("present").surface,
        SectionSurface::Delay {
            lag: Some(60e-6),
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
fn presets_are_valid_and_have_their_names() {
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
fn presets_have_their_parameters() {
    let load = |name| Scene::load(name).expect("preset");
    let periodic = load("periodic-2deg");
    assert_eq!(joint_of(&periodic).azimuth, 0.0);
    assert_eq!(joint_of(&periodic).contact.stiffness_factor, 1.0);
    let shift = load("mode-shift-3.5deg");
    assert_eq!(joint_of(&shift).azimuth, 135f64.to_radians());
    assert_eq!(tilt_of(&shift).at(0.0), 3.5f64.to_radians());
    for name in ["doubled-torus-3deg", "chaos-5deg", "tilt-ramp"] {
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
fn byte_order_marks_and_crlf_are_accepted() {
    let marked = format!("\u{feff}{}", SMALLEST.replace('\n', "\r\n"));
    let scene = Scene::parse("mine.toml", &marked).expect("valid");
    assert_eq!(scene.subject, smallest().subject);
    let bad = marked.replace("2.0", "200");
    assert!(refusal(bad).starts_with("mine.toml:3: `load.tilt_deg`"));
}

#[test]
fn analysis_keys_are_converted_to_si() {
    let added = "
        [analysis.delay]
        window_ms = 10\nevery_ms = 5\nmax_lag_us = 200\nmax_dimension = 6\nmax_false_neighbour_share = 0.05
        [analysis.recurrence]
        lag_us = \"auto\"\ndimension = \"auto\"\nnorm = \"maximum\"\nneighbours = 20
        [analysis.section]
        plane_q = [0, 1]\nplane_qdot_ms = [2.0]\noffset_um = 0.5\ncoordinates = [\"q1\", \"qdot11\"]
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
    let delay = delay.expect("present");
    assert_eq!((delay.window, delay.every), (10e-3, 5e-3));
    assert_eq!((delay.largest_lag, delay.largest_dimension), (200e-6, 6));
    assert_eq!((delay.bins, delay.false_share), (32, 0.05));
    let recurrence = recurrence.expect("present");
    assert_eq!(recurrence.embedding.lag, None);
    assert_eq!(recurrence.embedding.dimension, None);
    assert_eq!(recurrence.criterion.norm, Norm::Maximum);
    assert_eq!(recurrence.criterion.threshold, Threshold::Neighbours(20));
    assert_eq!(
        section.expect("present"),
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
    let method = chaos.expect("present").method;
    assert_eq!(method, DivergenceMethod::Kantz { radius: 0.1 });
    assert_eq!(regime.expect("present").silence, 1e-6);
}

#[test]
fn lyapunov_and_perturbed_trajectory_are_read() {
    let read = |added: &str| Scene::parse("m", format!("{SMALLEST}{added}")).expect("valid");
    let plain = read("");
    assert_eq!(plain.integrator.events, Events::Through);
    assert_eq!(
        (
            plain.analysis.exponents,
            plain.analysis.perturbed_trajectory
        ),
        (None, None)
    );
    let scene = read("events = \"exact\"\n[analysis.lyapunov]\n[analysis.perturbed_trajectory]\n");
    assert_eq!(scene.integrator.events, Events::Exact);
    let default = LyapunovSpec {
        count: 3,
        settle: 50e-3,
        every: 1e-3,
    };
    assert_eq!(scene.analysis.exponents, Some(default));
    let perturbed_trajectory = PerturbedTrajectorySpec {
        start: 50e-3,
        distance: 1e-9,
        every: 1e-3,
    };
    assert_eq!(
        scene.analysis.perturbed_trajectory,
        Some(perturbed_trajectory)
    );
    let count = |added: &str| {
        let scene = read(&format!("[analysis.lyapunov]\n{added}"));
        scene.analysis.exponents.map(|spec| spec.count)
    };
    assert_eq!(count("count = \"all\""), Some(22));
    assert_eq!(count("count = 22"), Some(22));
    let one_mode = "[body]\nbending_pairs = 0\ntorsion_modes = 1\naxial_modes = 0";
    assert_eq!(
        count(one_mode),
        Some(2),
        "at most the dimension of the phase space"
    );
}

/// The default elements are those that `fem` recommends.
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
