//! What the texts of the scenes with lessons claim, against a run of each scene.

use std::f64::consts::TAU;

use squeakscope::joint::BallJoint;
use squeakscope::pipeline::lesson::FactValue;
use squeakscope::pipeline::message::Record;
use squeakscope::scene::{Mechanism, PRESETS, Scene, SmallSystem, SystemSpec};
use squeakscope::study::stability;

use super::run::Run;

/// The words of a text, without punctuation.
fn words(text: &str) -> Vec<&str> {
    text.split_whitespace()
        .map(|word| word.trim_matches(|c: char| !c.is_alphanumeric()))
        .collect()
}

/// The frequencies (Hz) that a text states, also in lists such as `4.11 and 3.87 kHz`.
fn stated_frequencies(text: &str) -> Vec<f64> {
    let words = words(text);
    let mut stated = Vec::new();
    for (k, unit) in words.iter().enumerate() {
        let factor = match *unit {
            "kHz" => 1e3,
            "Hz" => 1.0,
            _ => continue,
        };
        let before = words[..k].iter().rev();
        let list = before.take_while(|word| **word == "and" || word.parse::<f64>().is_ok());
        stated.extend(list.filter_map(|word| Some(factor * word.parse::<f64>().ok()?)));
    }
    stated
}

/// The numbers of unstable modes that a text states: `four bending modes are unstable`, `no mode is unstable`.
fn stated_counts(text: &str) -> Vec<usize> {
    const NUMBERS: [&str; 6] = ["no", "one", "two", "three", "four", "five"];
    let text = text.to_lowercase().replace("bending ", "");
    words(&text)
        .windows(4)
        .filter(|words| words[1].starts_with("mode") && words[3] == "unstable")
        .filter_map(|words| NUMBERS.iter().position(|number| *number == words[0]))
        .collect()
}

/// Frequencies of a run, Hz: of its spectral lines above 1 % of the strongest, at the end or, if the tilt varies, at any time;
/// differences of their base frequencies; and what is computed before the run.
fn frequencies(scene: &Scene, run: &Run) -> Vec<f64> {
    let mut all = Vec::new();
    let varies = scene
        .joint()
        .is_ok_and(|joint| joint.tilt.varies() || joint.patch_moves());
    let spectra = run.records.iter().rev().filter_map(|record| match record {
        Record::Spectrum { peaks, .. } => Some(peaks),
        _ => None,
    });
    for peaks in spectra.take(if varies { usize::MAX } else { 1 }) {
        let strongest = peaks.first().map_or(0.0, |line| line.amplitude);
        let strong = peaks
            .iter()
            .filter(|line| line.amplitude > 0.01 * strongest);
        all.extend(strong.map(|line| line.frequency));
        let base = |name| peaks.iter().find(|line| line.label == name);
        if let (Some(f1), Some(f2)) = (base("f1"), base("f2")) {
            all.push((f1.frequency - f2.frequency).abs());
        }
    }
    if let Some(computed) = run.header.computed.as_deref() {
        all.push(computed.natural_hz);
        all.extend(computed.modes.iter().map(|mode| mode.frequency_hz));
        all.extend(computed.memory.iter().map(|memory| memory.follows_up_to_hz));
        let course = computed.torus.iter().flat_map(|torus| &torus.course);
        all.extend(course.map(|at| at.second_hz));
        let picture = computed.picture.iter();
        let flutter = picture.filter(|_| computed.coupling.is_some());
        all.extend(flutter.flat_map(|picture| picture.curves.iter().map(|curve| curve[0][1])));
    }
    if let SystemSpec::Small(SmallSystem::TwoModesOnBelt(system)) = &scene.subject {
        all.extend(system.omega.map(|omega| omega / TAU));
    }
    all
}

/// The description of a scene, and what the tour says of it.
fn texts(scene: &Scene) -> String {
    let tour = include_str!("../../../assets/tour/squeak.toml");
    let tour: serde_json::Value = toml_edit::de::from_str(tour).expect("TOML");
    let steps = tour["step"].as_array().expect("steps").iter();
    let own = steps.filter(|step| step["scene"].as_str() == Some(&scene.name));
    let said = own.flat_map(|step| [&step["say"], &step["notes"]]);
    let said = said.filter_map(|text| text.as_str());
    std::iter::once(&*scene.about)
        .chain(said)
        .collect::<Vec<_>>()
        .join("\n")
}

/// Each frequency and each number of unstable modes that a scene states is one of its run, and the lesson says of the run
/// what it explains.
#[test]
fn the_texts_of_every_scene_are_true_of_its_run() {
    for preset in PRESETS {
        let scene = preset.scene().expect("valid");
        let Some(mechanism) = scene.mechanism else {
            continue;
        };
        let run = Run::of(&scene);
        let text = texts(&scene);
        let mut known = frequencies(&scene, &run);
        // Scenes that compare their motion with another one.
        let other = match preset.name {
            "mode-shift-3.5deg" => Some(scene.clone().with_tilt(2.0).expect("in range")),
            "bristles" => Some(Scene::load("periodic-2deg").expect("preset")),
            _ => None,
        };
        known.extend(
            other
                .iter()
                .flat_map(|other| frequencies(other, &Run::of(other))),
        );
        for stated in stated_frequencies(&text) {
            let is_near = |hz: &f64| (hz / stated - 1.0).abs() < 0.02;
            assert!(known.iter().any(is_near), "{}: {stated} Hz", preset.name);
        }
        for stated in stated_counts(&text) {
            assert_eq!(run.computed().unstable().len(), stated, "{}", preset.name);
        }
        if let Some(claim) = claim(mechanism) {
            let fact = run.fact(claim);
            assert_eq!(fact.agrees, Some(true), "{}: {fact:?}", preset.name);
        }
        for fact in run.facts() {
            // Rates of several modes differ from that of the fastest, and the lesson on prediction is that modes do.
            let is_number = matches!(fact.measured, Some(FactValue::Number(_)));
            let may_differ = is_number || mechanism == Mechanism::Prediction;
            assert!(
                may_differ || fact.agrees != Some(false),
                "{}: {fact:?}",
                preset.name
            );
        }
        // The numbers of modes of the lesson are those of its prediction.
        if matches!(mechanism, Mechanism::Bristles | Mechanism::ContactAge) {
            let count = run.computed().unstable().len() as f64;
            assert_eq!(run.fact("unstable modes").predicted, Some(count.into()));
        }
    }
}

/// The fact that says what a mechanism is about.
fn claim(mechanism: Mechanism) -> Option<&'static str> {
    match mechanism {
        Mechanism::StickSlip => Some("contact"),
        Mechanism::Hysteresis => Some("line at the same tilt"),
        Mechanism::Torus => Some("second tone"),
        Mechanism::Chaos => Some("trajectories"),
        Mechanism::Articulation => Some("joint, rising tilt"),
        Mechanism::LiftOff | Mechanism::WhichModeWins => None,
        Mechanism::TorusBirth | Mechanism::Prediction => None,
        _ => Some("vibration"),
    }
}

/// The simple torus has no half lines, and the doubled one has: in the spectrum, the lesson and the commentary, which does not
/// take them for a floor.
#[test]
fn only_the_doubled_torus_has_half_lines() {
    for (name, doubled) in [("torus-1.75deg", false), ("doubled-torus-3deg", true)] {
        let scene = Scene::load(name).expect("preset");
        let scene = scene.with_duration(400.0).expect("in range");
        let run = Run::of(&scene.without_lyapunov().expect("valid"));
        let bases = ["f1", "f2"].map(|base| run.peaks().iter().any(|line| line.label == base));
        assert_eq!(bases, [true; 2], "{name}");
        let half = run.peaks().iter().find(|line| line.label == "(f1 + f2)/2");
        assert_eq!(half.is_some(), doubled, "{name}: {:?}", run.peaks());
        let says = run.facts().iter().any(|fact| fact.name == "torus");
        assert_eq!(says, doubled, "{name}");
        let narrations = run.narrations();
        let (_, last) = narrations.last().expect("commentary");
        assert_eq!(last.contains("has doubled"), doubled, "{last}");
        let floor = narrations.iter().find(|(_, text)| text.contains("floor"));
        assert_eq!(floor, None, "{name}");
    }
}

/// The growth rates that `bristles` states, with its friction and with that of `periodic-2deg`.
#[test]
fn bristles_slow_the_growth_of_the_higher_modes_as_stated() {
    let rates = |name: &str| {
        let scene = Scene::load(name).expect("preset");
        let joint = scene.joint().expect("a joint");
        let ball = BallJoint::new(&joint.spec).expect("a body");
        let at = stability(&ball, &[joint.tilt.at(0.0)]).expect("modes");
        let mut modes: Vec<_> = at[0].unstable().collect();
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let higher = modes[1..].iter();
        higher
            .map(|mode| format!("{:.0}", mode.growth))
            .collect::<Vec<_>>()
    };
    let [alone, with] = ["periodic-2deg", "bristles"].map(rates);
    let sentence = format!(
        "{}, {} and {} to {}, {} and {} 1/s",
        alone[0], alone[1], alone[2], with[0], with[1], with[2]
    );
    let about = Scene::load("bristles").expect("preset").about;
    assert!(about.replace('\n', " ").contains(&sentence), "{sentence}");
}
