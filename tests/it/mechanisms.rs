//! The mechanisms: what each scene of one claims, checked on the records of a run.

use std::sync::Arc;

use squeakscope::pipeline::message::{
    Computed, Course, Header, NodeState, Parting, PatchSnapshot, Record, SpectralLine, Way,
};
use squeakscope::pipeline::{Monitor, run};
use squeakscope::scene::{Mechanism, PRESETS, Parameter, Scene};
use squeakscope::text::LessonText;

/// All that a run says.
struct Run {
    header: Arc<Header>,
    records: Vec<Record>,
    /// Its lessons in words, each with its time, s.
    lessons: Vec<(f64, String)>,
}

impl Run {
    fn of(scene: &Scene) -> Self {
        let mut records: Vec<Record> = Vec::new();
        run(scene, "", &mut records, Monitor::default()).expect("runs");
        let Some(Record::Header(header)) = records.first() else {
            panic!("the header comes first");
        };
        let mut text = LessonText::default();
        let lessons = records.iter().filter_map(|record| match record {
            Record::Lesson(lesson) => Some((lesson.time, text.next(lesson)?.to_owned())),
            _ => None,
        });
        Self {
            header: Arc::clone(header),
            lessons: lessons.collect(),
            records,
        }
    }

    fn named(name: &str) -> Self {
        Self::of(&Scene::load(name).expect("preset"))
    }

    /// A preset with a line of it replaced.
    fn with(name: &str, from: &str, to: &str) -> Self {
        Self::of(&changed(name, from, to))
    }

    fn computed(&self) -> &Computed {
        self.header.computed.as_deref().expect("a mechanism")
    }

    fn lessons(&self) -> Vec<(f64, &str)> {
        let lessons = self.lessons.iter();
        lessons.map(|(time, text)| (*time, text.as_str())).collect()
    }

    fn last_lesson(&self) -> &str {
        &self.lessons.last().expect("a lesson").1
    }

    /// The words that stand beside a name in the last lesson's tables.
    fn told(&self, name: &str) -> &str {
        let lesson = self.last_lesson();
        let row = lesson
            .lines()
            .find(|line| line.starts_with(&format!("| {name} |")));
        let row = row.unwrap_or_else(|| panic!("no row `{name}` in\n{lesson}"));
        row.split('|')
            .nth(2)
            .expect("two columns")
            .trim()
            .trim_matches('*')
    }

    /// The first number beside a name.
    fn number(&self, name: &str) -> f64 {
        let told = self.told(name);
        let word = told.split([' ', '°']).next().expect("a word");
        word.parse()
            .unwrap_or_else(|_| panic!("`{name}` is `{told}`"))
    }

    /// Samples of the velocity, m/s.
    fn velocity(&self) -> Vec<f64> {
        let frames = self.records.iter().filter_map(|record| match record {
            Record::Samples(frame) => Some(&frame.velocity),
            _ => None,
        });
        frames.flatten().copied().collect()
    }

    fn courses(&self) -> Vec<Course> {
        let courses = self.records.iter().filter_map(|record| match record {
            Record::Course(course) => Some(*course),
            _ => None,
        });
        courses.collect()
    }

    fn snapshots(&self) -> Vec<PatchSnapshot> {
        let frames = self.records.iter().filter_map(|record| match record {
            Record::Samples(frame) => Some(frame.patch.clone()),
            _ => None,
        });
        frames.flatten().collect()
    }

    fn peaks(&self) -> &[SpectralLine] {
        let peaks = self.records.iter().rev().find_map(|record| match record {
            Record::Spectrum { peaks, .. } => Some(peaks),
            _ => None,
        });
        peaks.expect("a spectrum")
    }

    /// The strongest line at the end, Hz.
    fn tone(&self) -> f64 {
        self.peaks()[0].frequency
    }

    /// Growth rate (1/s) of the root mean square from one half of a stretch of time (s) to the other.
    fn growth(&self, [from, to]: [f64; 2]) -> f64 {
        let rate = self.header.sample_rate;
        let part = &self.velocity()[(from * rate) as usize..(to * rate) as usize];
        let (first, second) = part.split_at(part.len() / 2);
        let power = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
        (power(second) / power(first)).ln() / (to - from)
    }
}

fn changed(name: &str, from: &str, to: &str) -> Scene {
    let text = Scene::load(name).expect("preset").text;
    assert!(text.contains(from), "{name} has no `{from}`");
    Scene::parse(&format!("{name}.toml"), text.replacen(from, to, 1)).expect("valid")
}

fn near(found: f64, expected: f64, share: f64) {
    let off = (found / expected - 1.0).abs();
    assert!(off < share, "{found} is not {expected} to {share}");
}

#[test]
fn every_mechanism_has_its_scene() {
    let shown: Vec<Mechanism> = PRESETS
        .iter()
        .filter_map(|preset| preset.scene().expect("valid").mechanism)
        .collect();
    for &mechanism in Mechanism::ALL {
        assert!(shown.contains(&mechanism), "{}", mechanism.name());
    }
}

/// What is not there yet is said to be so: at the start no lesson has a measured number.
#[test]
fn nothing_is_measured_before_it_is() {
    for preset in PRESETS {
        let scene = preset.scene().expect("valid");
        if scene.mechanism.is_none() {
            continue;
        }
        let run = Run::of(&scene.with_duration(2.0).expect("valid"));
        let (time, first) = run.lessons()[0];
        assert_eq!(time, 0.0);
        let (_, measured) = first.split_once("| measured").expect("a table");
        let rows: Vec<&str> = measured
            .lines()
            .skip(2)
            .take_while(|l| !l.is_empty())
            .collect();
        assert!(!rows.is_empty());
        for row in rows {
            assert!(
                row.ends_with("| not yet measured |"),
                "{}: {row}",
                preset.name
            );
        }
        assert!(!measured.contains("**"), "{}: {measured}", preset.name);
    }
}

#[test]
fn a_lesson_does_not_flicker() {
    let run = Run::named("negative-slope");
    let lessons = run.lessons();
    for pair in lessons.windows(2) {
        assert_ne!(pair[0].1, pair[1].1);
        // The last one is told at the end, whenever that is.
        assert!(pair[1].0 - pair[0].0 > 0.024 || pair[1].0 > run.header.duration - 1e-3);
    }
    assert!((5..=13).contains(&lessons.len()), "{}", lessons.len());
}

#[test]
fn how_samples_are_cut_into_frames_does_not_matter() {
    let whole = Run::named("stick-slip");
    let rate = "sample_rate_khz = 200";
    let cut = Run::with("stick-slip", rate, &format!("{rate}\nframe_samples = 333"));
    assert_eq!(whole.lessons().len(), cut.lessons().len());
    for ((time, text), (time_2, text_2)) in whole.lessons().into_iter().zip(cut.lessons()) {
        assert!((time - time_2).abs() < 1e-12);
        assert_eq!(text, text_2);
    }
    assert_eq!(whole.courses().len(), cut.courses().len());
}

#[test]
fn a_falling_friction_feeds_at_the_computed_rate() {
    let run = Run::named("negative-slope");
    // -(n mu' + 2 zeta omega) / 2, by hand from the scene's numbers.
    let slope = -50.0 * 0.3 * (-50.0 * 0.02f64).exp();
    let expected = -0.5 * (20.0 * slope + 2.0 * 0.002 * std::f64::consts::TAU * 400.0);
    near(run.computed().fastest().expect("a mode"), expected, 1e-9);
    near(run.growth([0.01, 0.06]), expected, 0.01);
    near(
        run.number("growth rate of the velocity level, while small"),
        expected,
        0.01,
    );
    near(run.number("growth rate"), expected, 0.01);
    // It ends where the mass is as fast as the belt.
    let fastest = run.velocity().into_iter().fold(0.0, f64::max);
    near(fastest, 0.02, 0.05);
    assert!(run.number("share of time sticking, last 25 ms") > 1.0);

    // With more damping than friction feeds, the kick dies away.
    let damped = Run::with(
        "negative-slope",
        "damping_ratio = 0.002",
        "damping_ratio = 0.05",
    );
    let rate = damped.computed().fastest().expect("a mode");
    assert!(rate < -50.0 && damped.computed().unstable().is_empty());
    near(damped.growth([0.01, 0.06]), rate, 0.02);
    assert!(damped.last_lesson().contains("does not grow, as computed"));
}

#[test]
fn two_modes_flutter_above_the_critical_coefficient_and_not_below() {
    let critical = Run::named("mode-coupling")
        .computed()
        .coupling
        .expect("coupled")
        .critical;
    let critical = critical.expect("they couple");
    let at = |mu: f64| Run::with("mode-coupling", "mu = 0.4 ", &format!("mu = {mu} "));

    let below = at(0.95 * critical);
    assert_eq!(below.computed().fastest(), Some(0.0));
    assert!(below.growth([0.1, 0.3]).abs() < 3.0);
    let loudest = below.velocity().into_iter().fold(0.0, f64::max);
    assert!(loudest < 1e-4, "{loudest}");
    assert!(below.last_lesson().contains("does not grow, as computed"));

    for mu in [1.1 * critical, 0.4] {
        let above = at(mu);
        let rate = above.computed().fastest().expect("modes");
        assert!(rate > 20.0);
        // What does not grow has died away by then, and the contact is still closed.
        near(above.growth([3.0 / rate, 5.0 / rate]), rate, 0.05);
        let told = above.number("growth rate of the velocity level, while small");
        near(told, rate, 0.1);
    }
    let run = at(0.4);
    near(run.tone(), run.computed().modes[0].frequency_hz, 0.01);
    let open = run.number("share of time separated, last 25 ms");
    assert!((10.0..60.0).contains(&open), "{open}");
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
    // Half of the nodes come to stick and let go again, all of them, in every period.
    let holds: Vec<bool> = stuck.iter().map(|count| 2 * count >= nodes).collect();
    let captures = holds.windows(2).filter(|pair| !pair[0] && pair[1]).count() as f64;
    near(captures / 0.025, run.tone(), 0.1);
    assert!(stuck.contains(&0));
    let share = holds.iter().filter(|holds| **holds).count() as f64 / holds.len() as f64;
    assert!((0.2..0.8).contains(&share), "{share}");
    let told = run.number("share of time with at least half of the nodes sticking");
    assert!((told - 100.0 * share).abs() < 3.0, "{told} {share}");
    // The flat edge: while they hold, the contact point goes with the socket.
    let (velocity, rate) = (run.velocity(), run.header.sample_rate);
    for (snapshot, holds) in last.iter().zip(&holds) {
        let v = velocity[(snapshot.time * rate).round() as usize];
        assert!(!holds || (v + speed).abs() < 0.1 * speed, "{v}");
    }
    assert!(run.tone() < 0.5 * run.computed().natural_hz);
}

/// The belt that releases at once sticks for as long as the closed form says.
#[test]
fn the_lesson_of_the_belt_has_the_share_of_the_closed_form() {
    let run = Run::of(
        &Scene::load("mass-on-belt")
            .unwrap()
            .with_duration(150.0)
            .unwrap(),
    );
    let (slip, stick) = (1.552, 1.996);
    let share = 100.0 * stick / (slip + stick);
    let told = run.number("share of time sticking, last 25 ms");
    assert!((told - share).abs() < 4.0, "{told} {share}");
    near(run.number("releases"), 1e3 / (slip + stick), 0.1);
}

#[test]
fn the_contact_opens_and_strikes_again() {
    let run = Run::named("lift-off");
    let snapshots = run.snapshots();
    let from = run.header.duration - 0.025;
    let last: Vec<_> = snapshots.iter().filter(|s| s.time >= from).collect();
    let nodes = last[0].states.len();
    let open: Vec<usize> = last.iter().map(|s| s.count(NodeState::Separated)).collect();
    let mean = open.iter().sum::<usize>() as f64 / (open.len() * nodes) as f64;
    let all = open.iter().filter(|count| **count == nodes).count() as f64 / open.len() as f64;
    assert!(mean > 0.1 && all > 0.05, "{mean} {all}");
    let told = run.number("nodes separated, mean over the last 25 ms");
    assert!((told - 100.0 * mean).abs() < 2.0, "{told} {mean}");
    // Open, nothing presses; striking, it presses harder than the load.
    for (snapshot, open) in last.iter().zip(&open) {
        let force: f64 = snapshot.normal_force.iter().sum();
        assert!(*open < nodes || force == 0.0);
    }
    let strongest = last
        .iter()
        .map(|s| s.normal_force.iter().sum())
        .fold(0.0, f64::max);
    assert!(strongest > 300.0, "{strongest}");
    near(run.number("separations per node"), run.tone(), 0.1);
    assert!(run.last_lesson().contains("leaves the socket completely"));
}

#[test]
fn the_printed_parameters_are_silent_and_exchanged_they_squeal() {
    let printed = Run::named("printed-friction");
    let exchanged = Run::named("exchanged-friction");
    // Each computes both readings, and they agree on them.
    let [own, other] = printed.computed().readings.as_ref().expect("Eq. (5)");
    let [own_2, other_2] = exchanged.computed().readings.as_ref().expect("Eq. (5)");
    assert_eq!((own, other), (other_2, own_2));
    assert_eq!((own.unstable().len(), other.unstable().len()), (0, 4));
    assert!(own.slope > 0.0 && other.slope < 0.0);

    let speed = printed.computed().sliding_speed;
    let loudest = |run: &Run| {
        let velocity = run.velocity();
        let last = &velocity[velocity.len() * 3 / 4..];
        last.iter().fold(0.0, |a: f64, v| a.max(v.abs()))
    };
    assert!(loudest(&printed) < 1e-3 * speed);
    assert!(printed.last_lesson().contains("**not grow**"));
    assert_eq!(printed.told("strongest line"), "none");

    assert!(loudest(&exchanged) > 0.5 * speed);
    assert!(exchanged.last_lesson().contains("grown into a **squeal**"));
    // Four modes grow at once: the sum grows about as fast as they do.
    let rates: Vec<f64> = other.unstable().iter().map(|mode| mode.growth).collect();
    let measured = exchanged.number("growth rate of the velocity level, while small");
    let [fastest, .., slowest] = rates[..] else {
        panic!("four modes");
    };
    assert!(
        (0.9 * slowest..1.1 * fastest).contains(&measured),
        "{measured} {rates:?}"
    );
}

#[test]
fn the_kick_decides_which_mode_wins() {
    let run = Run::named("which-mode-wins");
    let other = Run::with("which-mode-wins", "seed = 6", "seed = 1");
    // The same joint: what is computed does not know the kick.
    assert_eq!(run.computed().modes, other.computed().modes);
    near(run.tone(), 12_430.0, 0.01);
    near(other.tone(), 4113.0, 0.01);
    assert!(run.last_lesson().contains("**4th bending** has won"));
    assert!(other.last_lesson().contains("**2nd bending** has won"));
    assert!(run.told("initial kick").contains("seed 6"));
    assert_eq!(
        run.told("mode with the most energy, last 25 ms"),
        "4th bending"
    );
    assert_eq!(run.computed().unstable().len(), 4);
}

#[test]
fn the_way_down_differs_from_the_way_up() {
    let run = Run::named("hysteresis");
    let heard: Vec<_> = run
        .courses()
        .iter()
        .filter_map(|course| course.tone)
        .collect();
    // At 7 degrees, one way and the other.
    let at_seven = |way: Way| {
        let on = heard.iter().filter(|tone| tone.way == way);
        let off = |tilt: f64| (tilt.to_degrees() - 7.0).abs();
        let nearest = on.min_by(|a, b| off(a.tilt).total_cmp(&off(b.tilt)));
        let nearest = nearest.expect("heard");
        assert!(off(nearest.tilt) < 0.1);
        nearest.frequency
    };
    let (up, down) = (at_seven(Way::Up), at_seven(Way::Down));
    near(up, 4140.0, 0.02);
    near(down, 2050.0, 0.05);
    // The tilts told are those at which the strongest line leaves the one and comes to it again.
    let is_high = |frequency: f64| frequency > 3000.0;
    let left = heard
        .iter()
        .rfind(|tone| tone.way == Way::Up && is_high(tone.frequency));
    let back = heard
        .iter()
        .find(|tone| tone.way == Way::Down && is_high(tone.frequency));
    let (left, back) = (left.expect("left").tilt, back.expect("back").tilt);
    assert!(left > back + 2f64.to_radians(), "{left} {back}");
    let lesson = run.last_lesson();
    let says = lesson.lines().last().expect("a conclusion");
    let told: Vec<f64> = says
        .split("**")
        .filter_map(|part| part.strip_suffix('°')?.parse().ok())
        .collect();
    let [up, down] = told[..] else {
        panic!("two tilts in `{says}`");
    };
    assert!((up - left.to_degrees()).abs() < 0.5, "{up} {left}");
    assert!((down - back.to_degrees()).abs() < 0.5, "{down} {back}");
}

#[test]
fn two_tones_beat_at_their_difference() {
    let run = Run::named("torus-3deg");
    let line = |name: &str| {
        let peak = run.peaks().iter().find(|peak| peak.label == name);
        peak.unwrap_or_else(|| panic!("no {name}")).frequency
    };
    let difference = (line("f1") - line("f2")).abs();
    near(difference, 240.0, 0.05);
    near(run.number("difference frequency"), difference, 0.01);
    near(line("f1 + f2"), line("f1") + line("f2"), 1e-3);
    assert!(run.last_lesson().contains("times a second"));
    // A pure tone has no second one to tell of.
    let pure = Run::with(
        "which-mode-wins",
        "\"which-mode-wins\"\n\n",
        "\"torus\"\n\n",
    );
    assert_eq!(pure.told("second tone f2"), "not yet measured");
}

#[test]
fn two_copies_part() {
    let run = Run::named("chaos-5deg");
    let partings: Vec<&Parting> = run
        .records
        .iter()
        .filter_map(|record| match record {
            Record::Parting(parting) => Some(parting),
            _ => None,
        })
        .collect();
    let (first, last) = (partings[0], partings[partings.len() - 1]);
    assert!(last.distance > 100.0 * first.distance);
    let line = last.line.expect("a line");
    assert!(line.grows(), "{line:?}");
    let told = run.told("doubling time");
    let doubling: f64 = told
        .split(' ')
        .next()
        .expect("a number")
        .parse()
        .expect("ms");
    assert!(told.ends_with(" ms"));
    near(doubling, 1e3 * std::f64::consts::LN_2 / line.rate, 0.06);
}

#[test]
fn what_is_heard_is_not_what_was_computed_to_grow_fastest() {
    let run = Run::named("mode-shift-3.5deg");
    let computed = run.computed();
    let bet = computed.unstable()[0];
    assert_eq!(bet.label, "1st bending");
    assert!(run.tone() > 5.0 * bet.frequency_hz);
    assert!(run.last_lesson().contains("they disagree"));
    // As long as it is tiny the linear theory holds.
    let rates: Vec<f64> = computed.unstable().iter().map(|mode| mode.growth).collect();
    let measured = run.number("growth rate of the velocity level, while small");
    assert!(
        (0.9 * rates[3]..1.1 * rates[0]).contains(&measured),
        "{measured} {rates:?}"
    );
    // The other way round it says so, too.
    let mut agreeing = String::new();
    for mode in computed.unstable() {
        if (mode.frequency_hz / run.tone() - 1.0).abs() < 0.05 {
            agreeing.clone_from(&mode.label);
        }
    }
    assert_eq!(agreeing, "4th bending");
}

#[test]
fn a_mechanism_that_the_scene_cannot_show_is_refused() {
    let refusal = |name: &str, from: &str, to: &str| {
        let text = Scene::load(name).expect("preset").text;
        assert!(text.contains(from));
        let error = Scene::parse("mine.toml", text.replacen(from, to, 1));
        error.expect_err("must be refused").to_string()
    };
    let misspelt = refusal("torus-3deg", "\"torus\"", "\"stickslip\"");
    assert!(
        misspelt.contains("`mechanism` = \"stickslip\""),
        "{misspelt}"
    );
    assert!(misspelt.starts_with("mine.toml:12: "), "{misspelt}");
    assert!(
        misspelt.contains("did you mean `stick-slip`?"),
        "{misspelt}"
    );
    assert!(misspelt.contains("\"negative-slope\""), "{misspelt}");
    for (mechanism, remedy) in [
        ("negative-slope", "stribeck_slope_s_per_m"),
        ("mode-coupling", "[two_modes_on_belt]"),
        ("hysteresis", "[[load.tilt]]"),
        ("chaos", "[analysis.butterfly]"),
    ] {
        let said = refusal("torus-3deg", "\"torus\"", &format!("\"{mechanism}\""));
        assert!(
            said.contains("`mechanism`") && said.contains(remedy),
            "{said}"
        );
    }
    let said = refusal("lift-off", "patch_rate_khz = 40", "patch_rate_khz = 0");
    assert!(said.contains("record.patch_rate_khz above 0"), "{said}");
    let said = refusal("mass-on-belt", "\"stick-slip\"", "\"prediction\"");
    assert!(said.contains("needs the modes of a joint"), "{said}");
}

/// What a study makes of a scene may not show its mechanism any more, and is no less a scene.
#[test]
fn a_changed_scene_keeps_its_mechanism_as_far_as_it_shows_it() {
    let swept = |name: &str, key: &str, value: f64| {
        let scene = Scene::load(name).expect("preset");
        let key = Parameter::named(key).expect("a number of a scene");
        let changed = scene.with_values(&[(key, value)]);
        changed.expect("a scene").mechanism
    };
    assert_eq!(swept("hysteresis", "load.tilt_deg", 3.0), None);
    assert_eq!(swept("lift-off", "record.patch_rate_khz", 0.0), None);
    let kept = swept("torus-3deg", "load.tilt_deg", 3.5);
    assert_eq!(kept, Some(Mechanism::Torus));
    let held = Scene::load("hysteresis").expect("preset").with_tilt(3.0);
    assert_eq!(held.expect("a scene").mechanism, None);
}
