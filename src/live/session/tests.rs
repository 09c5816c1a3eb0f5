//! Tests of sessions.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::live::command::{Command, Promise};
use crate::live::tour::TourStep;

fn session(scene: &str) -> Arc<Session> {
    let plan = SessionOptions {
        scene: Scene::load(scene).unwrap(),
        command: "squeakscope live".to_owned(),
        speed: 0.02,
        lyapunov: true,
        viewer: None,
        computes_diagram: true,
        folder: std::env::temp_dir(),
        save: None,
        wav: None,
        source: Source::default(),
        tour: Tour::shipped(),
    };
    Arc::new(Session::new(plan))
}

fn set(key: &str, value: f64) -> Command {
    let key = key.to_owned();
    Command::Set { key, value }
}

/// Runs a session while `control` sends commands.
fn with_session(scene: &str, control: impl FnOnce(&Session)) {
    let session = session(scene);
    let runner = {
        let session = Arc::clone(&session);
        std::thread::spawn(move || session.run().map(drop))
    };
    until(&session, |panel| panel.time_s > 0.0);
    control(&session);
    session.end();
    runner.join().unwrap().unwrap();
}

fn until(session: &Session, holds: impl Fn(&Panel) -> bool) -> Panel {
    let began = Instant::now();
    loop {
        let panel = session.panel();
        if holds(&panel) {
            return panel;
        }
        assert!(began.elapsed() < Duration::from_secs(30), "{panel:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn commands_take_effect() {
    with_session("doubled-torus-3deg", |session| {
        let apply = |command| session.apply(&command).unwrap();
        apply(set("tilt_deg", 4.25));
        let panel = until(session, |panel| panel.tilt_deg == Some(4.25));
        assert!(panel.events.iter().any(|e| e.text == "tilt 4.25 deg"));
        apply(Command::Pause {});
        let at = until(session, |panel| panel.paused);
        apply(Command::Step {});
        until(session, |panel| panel.time_s > at.time_s && panel.paused);
        apply(Command::Speed { ms_per_s: 5.0 });
        apply(Command::Resume {});
        until(session, |panel| !panel.paused && panel.speed == 5e-3);
        apply(Command::Kick { mm_per_s: None });
        apply(Command::Kick {
            mm_per_s: Some(2.0),
        });
        let panel = until(session, |panel| {
            panel
                .events
                .iter()
                .any(|e| e.text.starts_with("kick of 2 mm/s"))
        });
        let kicks = panel.events.iter().filter(|e| e.text.starts_with("kick"));
        assert_eq!(kicks.count(), 2);
    });
}

/// A number other than the tilt is a slider too; the diagram says for which values it holds.
#[test]
fn every_number_of_the_scene_is_a_control() {
    with_session("doubled-torus-3deg", |session| {
        session.apply(&set("load_n", 200.0)).unwrap();
        let value = |panel: &Panel, key: &str| {
            let mut sliders = panel.controls.iter();
            sliders.find(|slider| slider.key == key).unwrap().value
        };
        let panel = until(session, |panel| value(panel, "load.load_n") == 200.0);
        assert!(panel.events.iter().any(|event| event.text == "load 200 N"));
        assert_eq!(
            panel.diagram_condition.as_deref(),
            Some("rows and branches hold for load 150 N")
        );
        session.apply(&set("contact.radius_factor", 1.1)).unwrap();
        until(session, |panel| {
            value(panel, "contact.radius_factor") == 1.1
        });
        // A restart is that of the scene.
        session.apply(&Command::Reset {}).unwrap();
        let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
        assert_eq!(
            (value(&panel, "load.load_n"), panel.diagram_condition),
            (150.0, None)
        );
    });
}

#[test]
fn another_scene_and_a_reset_start_new_runs() {
    with_session("doubled-torus-3deg", |session| {
        let apply = |command| session.apply(&command).unwrap();
        let name = "mass-on-belt".to_owned();
        apply(Command::Scene { name });
        let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
        assert_eq!(
            (panel.scene.as_str(), panel.tilt_deg),
            ("mass-on-belt", None)
        );
        assert!(session.apply(&set("tilt_deg", 2.0)).is_err());
        apply(Command::Reset {});
        until(session, |panel| panel.run == 3 && panel.time_s > 0.0);
    });
}

#[test]
fn commands_during_a_restart_apply_to_the_new_run() {
    with_session("doubled-torus-3deg", |session| {
        let apply = |command| session.apply(&command).unwrap();
        apply(Command::Reset {});
        apply(Command::Pause {});
        let panel = until(session, |panel| panel.run == 2 && panel.paused);
        assert!(
            panel
                .events
                .iter()
                .any(|e| e.text == "doubled-torus-3deg starts")
        );
        // Recording works while the run is paused.
        apply(Command::Record {});
        until(session, |panel| panel.recording.is_some());
        apply(Command::StopRecording {});
        until(session, |panel| panel.recording.is_none());
        apply(Command::Resume {});
        until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
    });
}

#[test]
fn lyapunov_analyses_can_be_switched_off() {
    with_session("chaos-5deg", |session| {
        assert_eq!(session.panel().lyapunov, Some(true));
        let apply = |command| session.apply(&command).unwrap();
        apply(Command::Lyapunov { enabled: false });
        let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
        assert_eq!(panel.lyapunov, Some(false));
        // A repeated command does not restart the scene.
        apply(Command::Lyapunov { enabled: false });
        // A scene without these analyses does not have the option.
        let name = "mass-on-belt".to_owned();
        apply(Command::Scene { name });
        let panel = until(session, |panel| panel.run == 3 && panel.time_s > 0.0);
        assert_eq!(panel.lyapunov, None);
    });
}

#[test]
fn values_out_of_range_are_rejected_with_their_names() {
    with_session("doubled-torus-3deg", |session| {
        for (command, part) in [
            (
                set("tilt_deg", 10.1),
                "the tilt must be between 0 and 10 deg",
            ),
            (set("load.tilt_deg", f64::NAN), "the tilt must be"),
            (set("load.load_m", 10.0), "load.load_n"),
            (set("contact.nodes", 36.0), "cannot change `contact.nodes`"),
            (set("ball_diameter_mm", 31.0), "cannot change"),
            (
                Command::Speed { ms_per_s: 0.0 },
                "the playback speed must be",
            ),
            (
                Command::Kick {
                    mm_per_s: Some(-1.0),
                },
                "a kick must be",
            ),
            (
                Command::Scene {
                    name: "../etc/passwd".to_owned(),
                },
                "unknown scene `../etc/passwd`",
            ),
        ] {
            let refused = session.apply(&command).unwrap_err().to_string();
            assert!(refused.contains(part), "{refused}");
        }
        let panel = session.panel();
        let tilt = panel.tilt_deg.unwrap();
        assert!((tilt - 3.0).abs() < 1e-9 && panel.run == 1, "{panel:?}");
    });
}

/// Opens a step in real time.
fn open(session: &Session, step: &TourStep) {
    let step = TourStep {
        speed_ms_per_s: Some(1000.0),
        ..step.clone()
    };
    session.apply(&Command::Open(Box::new(step))).unwrap();
}

/// Opens all steps of the tour and all bookmarks in a random order, and waits for the motion that each promises.
fn open_in_random_order(session: &Session, seed: u64) {
    let tours = [Tour::shipped(), Tour::bookmarks()].map(Option::unwrap);
    let mut steps: Vec<_> = tours.iter().flat_map(|tour| &tour.steps).collect();
    steps.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    for step in steps {
        let before = session.panel().run;
        open(session, step);
        let promise = step.promise.as_ref();
        let after = promise.map_or(0.0, |promise| 1e-3 * promise.after_ms);
        let settled = |panel: &Panel| {
            let known = promise.is_none() || panel.confidence.is_some();
            panel.run > before && panel.time_s > after && known
        };
        let panel = until(session, settled);
        assert_eq!(panel.departure, None, "{}, order {seed}", step.say);
        // What a lecturer does in between.
        let _ = session.apply(&set("tilt_deg", 8.0));
        session
            .apply(&Command::Kick {
                mm_per_s: Some(30.0),
            })
            .unwrap();
        let panel = session.panel();
        assert_eq!(panel.departure, None);
    }
}

#[test]
fn steps_and_bookmarks_reach_the_motions_that_they_promise() {
    with_session("hysteresis", |session| open_in_random_order(session, 1));
}

/// A bookmark of a motion that depends on the history, from anywhere.
#[test]
fn an_own_bookmark_reaches_its_motion_from_anywhere() {
    with_session("hysteresis", |session| {
        open(session, &TourStep::of_scene("hysteresis"));
        let falling = |panel: &Panel| panel.run == 2 && panel.time_s > 0.55;
        let deg = until(session, falling).tilt_deg.unwrap();
        session.apply(&set("tilt_deg", deg)).unwrap();
        let held = session.panel().time_s + 0.2;
        until(session, |panel| {
            panel.time_s > held && panel.confidence.is_some()
        });
        let own = session.bookmark();
        let kept = own.promise.as_ref().expect("a settled motion");
        for seed in [1, 2] {
            let mut others = Tour::bookmarks().unwrap().steps;
            others.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            for step in &others[..3] {
                let before = session.panel().run;
                open(session, step);
                until(session, |panel| panel.run > before && panel.time_s > 0.02);
            }
            let before = session.panel().run;
            open(session, &own);
            let classified = |panel: &Panel| {
                panel.run > before && panel.confidence.is_some() && !panel.lines.is_empty()
            };
            let panel = until(session, classified);
            let line = Some(panel.lines[0].frequency);
            let motion = panel.regime.as_deref().unwrap();
            assert!(kept.is_kept(motion, line), "{kept}, not {motion} {line:?}");
            assert_eq!(panel.departure, None);
        }
        // From the start of the scene, another motion wins at this tilt.
        let before = session.panel().run;
        open(
            session,
            &TourStep {
                state: None,
                ..own.clone()
            },
        );
        until(session, |panel| {
            panel.run > before && panel.departure.is_some()
        });
        // A state of another scene.
        let foreign = TourStep {
            scene: "mass-on-belt".to_owned(),
            set: BTreeMap::new(),
            ..own.clone()
        };
        let refused = session
            .apply(&Command::Open(Box::new(foreign)))
            .unwrap_err();
        assert!(
            refused
                .to_string()
                .contains("another version of `mass-on-belt`"),
            "{refused}"
        );
    });
}

#[test]
#[ignore = "takes some minutes: cargo test --release --lib thirty_orders -- --ignored"]
fn thirty_orders_reach_the_promised_motions() {
    with_session("hysteresis", |session| {
        (0..30).for_each(|seed| open_in_random_order(session, seed));
    });
}

#[test]
fn another_motion_than_promised_is_reported() {
    with_session("periodic-2deg", |session| {
        let promise = |motion: &str, line_khz| Promise {
            motion: motion.to_owned(),
            line_khz,
            after_ms: 0.0,
        };
        let wrong = promise("periodic", Some(12.43));
        let opening = TourStep {
            promise: Some(wrong),
            ..TourStep::of_scene("periodic-2deg")
        };
        open(session, &opening);
        let panel = until(session, |panel| panel.departure.is_some());
        let text = panel.departure.unwrap();
        assert!(
            text.starts_with("expected here: periodic, 12.43 kHz; reached: "),
            "{text}"
        );
        // The user's own change ends the promise.
        session.apply(&set("tilt_deg", 1.0)).unwrap();
        assert_eq!(session.panel().departure, None);
    });
}
