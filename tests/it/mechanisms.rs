//! The mechanisms: claims of their scenes and lessons, checked on the records of a run.

mod claims;
mod friction;
mod run;
mod second_tone;
mod turning;

use squeakscope::pipeline::message::{
    NodeState, Record, TiltDirection, TrajectoryDivergence, unstable,
};
use squeakscope::scene::{Mechanism, PRESETS, Parameter, Scene};

use run::{Run, assert_close};

#[test]
fn every_mechanism_has_a_scene() {
    let shown: Vec<Mechanism> = PRESETS
        .iter()
        .filter_map(|preset| preset.scene().expect("valid").mechanism)
        .collect();
    for &mechanism in Mechanism::ALL {
        assert!(shown.contains(&mechanism), "{}", mechanism.name());
    }
}

/// At the start of a run no lesson contains a measurement.
#[test]
fn initial_lessons_contain_no_measured_numbers() {
    for preset in PRESETS {
        let scene = preset.scene().expect("valid");
        if scene.mechanism.is_none() {
            continue;
        }
        let run = Run::of(&scene.with_duration(2.0).expect("valid"));
        assert_eq!(run.lessons()[0].0, 0.0);
        let facts = run.first_facts();
        assert!(!facts.is_empty(), "{}", preset.name);
        for fact in facts {
            let is_open = (&fact.measured, fact.agrees) == (&None, None);
            assert!(is_open, "{}: {fact:?}", preset.name);
        }
    }
}

#[test]
fn lessons_change_at_most_every_24_ms() {
    let run = Run::named("negative-slope");
    let lessons = run.lessons();
    for pair in lessons.windows(2) {
        assert_ne!(pair[0].1, pair[1].1);
        // The last lesson is issued at the end of the run.
        assert!(pair[1].0 - pair[0].0 > 0.024 || pair[1].0 > run.header.duration - 1e-3);
    }
    assert!((5..=13).contains(&lessons.len()), "{}", lessons.len());
}

#[test]
fn lessons_are_independent_of_the_frame_length() {
    let default = Run::named("stick-slip");
    let rate = "sample_rate_khz = 200";
    let other = Run::with("stick-slip", rate, &format!("{rate}\nframe_samples = 333"));
    assert_eq!(default.lessons().len(), other.lessons().len());
    for ((time, text), (time_2, text_2)) in default.lessons().into_iter().zip(other.lessons()) {
        assert!((time - time_2).abs() < 1e-12);
        assert_eq!(text, text_2);
    }
    assert_eq!(default.courses().len(), other.courses().len());
}

/// The texts are equal; their times differ by rounding at most.
fn assert_same_texts(found: &[(f64, String)], expected: &[(f64, String)], context: &str) {
    assert_eq!(found.len(), expected.len(), "{context}");
    for ((time, text), (time_2, text_2)) in found.iter().zip(expected) {
        assert!((time - time_2).abs() < 1e-12, "{context}");
        assert_eq!(text, text_2, "{context}");
    }
}

/// Pictures are thinned by the playback speed; the numbers are not. The ramp also tilts the joint at the same
/// instants at every speed.
#[test]
fn numbers_are_independent_of_the_playback_speed() {
    for (name, duration_ms) in [
        ("stick-slip", 55.0),
        ("which-mode-wins", 30.0),
        ("tilt-ramp", 30.0),
        ("bristles", 30.0),
        ("articulation", 60.0),
    ] {
        let scene = Scene::load(name).expect("preset");
        let scene = scene.with_duration(duration_ms).expect("valid");
        let planned = Run::of(&scene);
        assert!(!planned.narrations().is_empty(), "{name}");
        assert_eq!(
            planned.lessons.len() > 1,
            scene.mechanism.is_some(),
            "{name}"
        );
        // Frames of a few samples, the longest ones, and for one scene of the length between.
        let middle = Some(20.0).filter(|_| name == "tilt-ramp");
        for ms_per_s in [1.0, 1000.0].into_iter().chain(middle) {
            let live = Run::at_speed(&scene, 1e-3 * ms_per_s);
            let context = format!("{name} at {ms_per_s} ms/s");
            assert_eq!(live.velocity(), planned.velocity(), "{context}");
            assert_same_texts(&live.lessons, &planned.lessons, &context);
            assert_same_texts(&live.narrations(), &planned.narrations(), &context);
            assert_same_texts(&live.regimes(), &planned.regimes(), &context);
        }
    }
}

#[test]
fn negative_slope_grows_at_the_computed_rate() {
    let run = Run::named("negative-slope");
    // -(n mu' + 2 zeta omega) / 2 with the parameters of the scene.
    let slope = -50.0 * 0.3 * (-50.0 * 0.02f64).exp();
    let expected = -0.5 * (20.0 * slope + 2.0 * 0.002 * std::f64::consts::TAU * 400.0);
    assert_close(run.computed().fastest().expect("a mode"), expected, 1e-9);
    assert_close(run.growth([0.01, 0.06]), expected, 0.01);
    assert_close(run.number("growth rate, while small"), expected, 0.01);
    run.assert_confirmed("vibration", "growth");
    // The growth ends at the belt speed.
    let fastest = run.velocity().into_iter().fold(0.0, f64::max);
    assert_close(fastest, 0.02, 0.05);
    assert!(run.number("share of time sticking") > 0.01);

    // With more damping the vibration decays.
    let damped = Run::with(
        "negative-slope",
        "damping_ratio = 0.002",
        "damping_ratio = 0.05",
    );
    let rate = damped.computed().fastest().expect("a mode");
    assert!(rate < -50.0 && damped.computed().unstable().is_empty());
    assert_close(damped.growth([0.01, 0.06]), rate, 0.02);
    damped.assert_confirmed("vibration", "no growth");
}

#[test]
fn two_modes_flutter_above_the_critical_coefficient_only() {
    let critical = Run::named("mode-coupling")
        .computed()
        .coupling
        .expect("coupled")
        .critical;
    let critical = critical.expect("a critical coefficient");
    let at = |mu: f64| Run::with("mode-coupling", "mu = 0.4 ", &format!("mu = {mu} "));

    let below = at(0.95 * critical);
    assert_eq!(below.computed().fastest(), Some(0.0));
    assert!(below.growth([0.1, 0.3]).abs() < 3.0);
    let peak = below.velocity().into_iter().fold(0.0, f64::max);
    assert!(peak < 1e-4, "{peak}");
    below.assert_confirmed("vibration", "no growth");

    for mu in [1.1 * critical, 0.4] {
        let above = at(mu);
        let rate = above.computed().fastest().expect("modes");
        assert!(rate > 20.0);
        // The stable mode has decayed by then, and the contact is still closed.
        assert_close(above.growth([3.0 / rate, 5.0 / rate]), rate, 0.05);
        let reported = above.number("growth rate, while small");
        assert_close(reported, rate, 0.1);
    }
    let run = at(0.4);
    assert_close(
        run.dominant_hz(),
        run.computed().modes[0].frequency_hz,
        0.01,
    );
    let separated = run.number("share of time separated");
    assert!((0.1..0.6).contains(&separated), "{separated}");
}

#[test]
fn nodes_stick_for_part_of_each_period() {
    let run = Run::named("stick-slip");
    let snapshots = run.snapshots();
    let nodes = snapshots[0].states.len();
    let speed = run.computed().sliding_speed;
    let from = run.header.duration - 0.025;
    let last: Vec<_> = snapshots.iter().filter(|s| s.time >= from).collect();
    let stuck: Vec<usize> = last.iter().map(|s| s.count(NodeState::Stick)).collect();
    // In every period at least half of the nodes stick, and later all nodes slip.
    let sticks: Vec<bool> = stuck.iter().map(|count| 2 * count >= nodes).collect();
    let captures = sticks.windows(2).filter(|pair| !pair[0] && pair[1]).count() as f64;
    assert_close(captures / 0.025, run.dominant_hz(), 0.1);
    assert!(stuck.contains(&0));
    let share = sticks.iter().filter(|sticks| **sticks).count() as f64 / sticks.len() as f64;
    assert!((0.2..0.8).contains(&share), "{share}");
    let reported = run.number("time with half of the nodes sticking");
    assert!((reported - share).abs() < 0.03, "{reported} {share}");
    // While the nodes stick, the contact point moves with the socket.
    let (velocity, rate) = (run.velocity(), run.header.sample_rate);
    for (snapshot, sticks) in last.iter().zip(&sticks) {
        let v = velocity[(snapshot.time * rate).round() as usize];
        assert!(!sticks || (v + speed).abs() < 0.1 * speed, "{v}");
    }
    assert!(run.dominant_hz() < 0.5 * run.computed().natural_hz);
}

/// The stick phase on the belt has the duration of the closed form.
#[test]
fn stick_time_on_the_belt_agrees_with_the_closed_form() {
    let run = Run::of(
        &Scene::load("mass-on-belt")
            .unwrap()
            .with_duration(150.0)
            .unwrap(),
    );
    let (slip, stick) = (1.552, 1.996);
    let share = stick / (slip + stick);
    let reported = run.number("share of time sticking");
    assert!((reported - share).abs() < 0.04, "{reported} {share}");
    assert_close(run.number("releases"), 1e3 / (slip + stick), 0.1);
}

#[test]
fn the_contact_separates_and_impacts() {
    let run = Run::named("lift-off");
    let snapshots = run.snapshots();
    let from = run.header.duration - 0.025;
    let last: Vec<_> = snapshots.iter().filter(|s| s.time >= from).collect();
    let nodes = last[0].states.len();
    let separated: Vec<usize> = last.iter().map(|s| s.count(NodeState::Separated)).collect();
    let mean = separated.iter().sum::<usize>() as f64 / (separated.len() * nodes) as f64;
    let all =
        separated.iter().filter(|count| **count == nodes).count() as f64 / separated.len() as f64;
    assert!(mean > 0.1 && all > 0.05, "{mean} {all}");
    let reported = run.number("separated nodes, mean");
    assert!((reported - mean).abs() < 0.02, "{reported} {mean}");
    // A separated contact has no normal force; the peak force at impact exceeds the load.
    for (snapshot, separated) in last.iter().zip(&separated) {
        let force: f64 = snapshot.normal_force.iter().sum();
        assert!(*separated < nodes || force == 0.0);
    }
    let peak = last
        .iter()
        .map(|s| s.normal_force.iter().sum())
        .fold(0.0, f64::max);
    assert!(peak > 300.0, "{peak}");
    assert_close(run.number("separations per node"), run.dominant_hz(), 0.1);
    assert_eq!(run.text("separation"), "of the whole contact");
}

#[test]
fn printed_parameters_are_stable_and_exchanged_ones_squeal() {
    let printed = Run::named("printed-friction");
    let exchanged = Run::named("exchanged-friction");
    // Both scenes compute both readings with equal results.
    let [own, other] = printed.computed().readings.as_ref().expect("Eq. (5)");
    let [own_2, other_2] = exchanged.computed().readings.as_ref().expect("Eq. (5)");
    assert_eq!((own, other), (other_2, own_2));
    assert_eq!(
        (unstable(&own.modes).len(), unstable(&other.modes).len()),
        (0, 4)
    );
    assert!(own.slope > 0.0 && other.slope < 0.0);

    let speed = printed.computed().sliding_speed;
    let peak = |run: &Run| {
        let velocity = run.velocity();
        let last = &velocity[velocity.len() * 3 / 4..];
        last.iter().fold(0.0, |a: f64, v| a.max(v.abs()))
    };
    assert!(peak(&printed) < 1e-3 * speed);
    printed.assert_confirmed("vibration", "no growth");
    assert_eq!(printed.text("strongest line"), "none, silent");
    // Lines below the limit of rest are not named, and below a larger limit the joint is at rest.
    let floor = printed.header.rest_speed;
    assert!(printed.peaks().iter().all(|line| line.amplitude >= floor));
    let spectrum = "every_ms = 5";
    let floored = format!("{spectrum}\nrest_mm_per_s = 1");
    let still = Run::with("printed-friction", spectrum, &floored);
    assert_eq!(still.text("strongest line"), "none, at rest");
    assert!(still.peaks().is_empty());
    let (_, narrated) = still.narrations().pop().expect("commentary");
    assert!(narrated.starts_with("## At rest"), "{narrated}");

    assert!(peak(&exchanged) > 0.5 * speed);
    exchanged.assert_confirmed("vibration", "growth");
    assert!(exchanged.measured().growth_ended);
    // Four modes grow; the growth rate of their sum lies between theirs.
    let rates: Vec<f64> = unstable(&other.modes)
        .iter()
        .map(|mode| mode.growth)
        .collect();
    let measured = exchanged.number("growth rate, while small");
    let [fastest, .., slowest] = rates[..] else {
        panic!("four modes");
    };
    assert!(
        (0.9 * slowest..1.1 * fastest).contains(&measured),
        "{measured} {rates:?}"
    );
}

#[test]
fn the_kick_determines_the_dominant_mode() {
    let run = Run::named("which-mode-wins");
    let other = Run::with("which-mode-wins", "seed = 6", "seed = 1");
    // The linear modes are independent of the kick.
    assert_eq!(run.computed().modes, other.computed().modes);
    assert_close(run.dominant_hz(), 12_430.0, 0.01);
    assert_close(other.dominant_hz(), 4113.0, 0.01);
    assert_eq!(run.text("mode of the strongest line"), "4th bending");
    assert_eq!(other.text("mode of the strongest line"), "2nd bending");
    assert_eq!(run.text("seed of the first kick"), "6");
    assert_eq!(run.text("strongest mode, last 25 ms"), "4th bending");
    assert_eq!(run.computed().unstable().len(), 4);
}

#[test]
fn downward_and_upward_ramps_differ() {
    let run = Run::named("hysteresis");
    let dominant: Vec<_> = run
        .courses()
        .iter()
        .filter_map(|course| course.tone)
        .collect();
    // Dominant frequency at 7 degrees on both ramps.
    let at_seven = |way: TiltDirection| {
        let branch = dominant.iter().filter(|tone| tone.way == way);
        let off = |tilt: f64| (tilt.to_degrees() - 7.0).abs();
        let nearest = branch.min_by(|a, b| off(a.tilt).total_cmp(&off(b.tilt)));
        let nearest = nearest.expect("a spectral line");
        assert!(off(nearest.tilt) < 0.1);
        nearest.frequency
    };
    let (up, down) = (at_seven(TiltDirection::Up), at_seven(TiltDirection::Down));
    assert_close(up, 4140.0, 0.02);
    assert_close(down, 2050.0, 0.05);
    // The lesson reports the tilts at which the strongest line leaves the upper branch and returns to it.
    let is_high = |frequency: f64| frequency > 3000.0;
    let left = dominant
        .iter()
        .rfind(|tone| tone.way == TiltDirection::Up && is_high(tone.frequency));
    let back = dominant
        .iter()
        .find(|tone| tone.way == TiltDirection::Down && is_high(tone.frequency));
    let (left, back) = (left.expect("left").tilt, back.expect("back").tilt);
    assert!(left > back + 2f64.to_radians(), "{left} {back}");
    let jumps = ["last jump with rising tilt", "jump back, at a smaller tilt"];
    let [up, down] = jumps.map(|name| run.number(name));
    assert!((up - left).to_degrees().abs() < 0.5, "{up} {left}");
    assert!((down - back).to_degrees().abs() < 0.5, "{down} {back}");
    assert_eq!(run.fact("line at the same tilt").agrees, Some(true));
}

#[test]
fn the_torus_beats_at_the_difference_frequency() {
    let run = Run::named("torus-1.75deg");
    let line = |name: &str| {
        let peak = run.peaks().iter().find(|peak| peak.label == name);
        peak.unwrap_or_else(|| panic!("no {name}")).frequency
    };
    let difference = (line("f1") - line("f2")).abs();
    assert_close(difference, 240.0, 0.05);
    assert_close(run.number("difference frequency"), difference, 0.01);
    assert_close(run.number("period of the beat"), 1.0 / difference, 0.01);
    assert_close(line("f1 + f2"), line("f1") + line("f2"), 1e-3);
    run.assert_confirmed("second tone", "present");
    // A periodic motion has no second frequency.
    let periodic = Run::with(
        "which-mode-wins",
        "\"which-mode-wins\"\n\n",
        "\"torus\"\n\n",
    );
    assert_eq!(periodic.fact("second tone f2").measured, None);
    assert_ne!(periodic.fact("second tone").agrees, Some(true));
}

#[test]
fn the_perturbed_trajectory_diverges() {
    let run = Run::named("chaos-5deg");
    let divergence: Vec<&TrajectoryDivergence> = run
        .records
        .iter()
        .filter_map(|record| match record {
            Record::TrajectoryDivergence(sample) => Some(sample),
            _ => None,
        })
        .collect();
    let (first, last) = (divergence[0], divergence[divergence.len() - 1]);
    assert!(last.distance > 100.0 * first.distance);
    let line = last.line.expect("a line");
    assert!(line.grows(), "{line:?}");
    let doubling = std::f64::consts::LN_2 / line.rate_per_s;
    assert_close(run.number("doubling time"), doubling, 0.01);
    run.assert_confirmed("trajectories", "separating");
}

#[test]
fn the_dominant_mode_is_not_the_fastest_growing_one() {
    let run = Run::named("mode-shift-3.5deg");
    let computed = run.computed();
    let fastest = computed.unstable()[0];
    assert_eq!(fastest.label, "1st bending");
    assert!(run.dominant_hz() > 5.0 * fastest.frequency_hz);
    let dominates = run.fact("mode of the strongest line");
    assert_eq!(dominates.predicted, Some("1st bending".into()));
    assert_eq!(dominates.agrees, Some(false), "{dominates:?}");
    // Linear theory is valid for small amplitudes.
    let rates: Vec<f64> = computed.unstable().iter().map(|mode| mode.growth).collect();
    let measured = run.number("growth rate, while small");
    assert!(
        (0.9 * rates[3]..1.1 * rates[0]).contains(&measured),
        "{measured} {rates:?}"
    );
    // The dominant frequency is that of another unstable mode.
    let mut dominant = String::new();
    for mode in computed.unstable() {
        if (mode.frequency_hz / run.dominant_hz() - 1.0).abs() < 0.05 {
            dominant.clone_from(&mode.label);
        }
    }
    assert_eq!(dominant, "4th bending");
}

#[test]
fn mechanisms_that_a_scene_cannot_demonstrate_are_rejected() {
    let refusal = |name: &str, from: &str, to: &str| {
        let text = Scene::load(name).expect("preset").text;
        assert!(text.contains(from));
        let error = Scene::parse("mine.toml", text.replacen(from, to, 1));
        error.expect_err("must be rejected").to_string()
    };
    let misspelt = refusal("doubled-torus-3deg", "\"torus\"", "\"stickslip\"");
    assert!(
        misspelt.contains("`mechanism` = \"stickslip\""),
        "{misspelt}"
    );
    assert!(misspelt.starts_with("mine.toml:11: "), "{misspelt}");
    assert!(
        misspelt.contains("did you mean `stick-slip`?"),
        "{misspelt}"
    );
    assert!(misspelt.contains("\"negative-slope\""), "{misspelt}");
    for (mechanism, remedy) in [
        ("negative-slope", "stribeck_slope_s_per_m"),
        ("mode-coupling", "[two_modes_on_belt]"),
        ("hysteresis", "[[load.tilt]]"),
        ("chaos", "[analysis.perturbed_trajectory]"),
    ] {
        let message = refusal(
            "doubled-torus-3deg",
            "\"torus\"",
            &format!("\"{mechanism}\""),
        );
        assert!(
            message.contains("`mechanism`") && message.contains(remedy),
            "{message}"
        );
    }
    let message = refusal("lift-off", "patch_rate_khz = 40", "patch_rate_khz = 0");
    assert!(
        message.contains("record.patch_rate_khz above 0"),
        "{message}"
    );
    let message = refusal("mass-on-belt", "\"stick-slip\"", "\"prediction\"");
    assert!(
        message.contains("requires the modes of a ball joint"),
        "{message}"
    );
}

/// A study can change a scene so that it no longer demonstrates its mechanism.
#[test]
fn a_changed_scene_keeps_a_mechanism_it_can_demonstrate() {
    let swept = |name: &str, key: &str, value: f64| {
        let scene = Scene::load(name).expect("preset");
        let key = Parameter::named(key).expect("a number of a scene");
        let changed = scene.with_values(&[(key, value)]);
        changed.expect("a scene").mechanism
    };
    assert_eq!(swept("hysteresis", "load.tilt_deg", 3.0), None);
    assert_eq!(swept("lift-off", "record.patch_rate_khz", 0.0), None);
    let kept = swept("doubled-torus-3deg", "load.tilt_deg", 3.5);
    assert_eq!(kept, Some(Mechanism::Torus));
    let fixed = Scene::load("hysteresis").expect("preset").with_tilt(3.0);
    assert_eq!(fixed.expect("a scene").mechanism, None);
}
