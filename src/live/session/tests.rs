//! Tests of sessions.

use std::time::{Duration, Instant};

use super::*;
use crate::live::command::Command;

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
    };
    Arc::new(Session::new(plan))
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
    with_session("torus-3deg", |session| {
        let apply = |command| session.apply(&command).unwrap();
        apply(Command::Tilt { deg: 4.25 });
        let panel = until(session, |panel| panel.tilt_deg == Some(4.25));
        assert!(panel.events.iter().any(|e| e.text == "tilt 4.25 degrees"));
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

#[test]
fn another_scene_and_a_reset_start_new_runs() {
    with_session("torus-3deg", |session| {
        let apply = |command| session.apply(&command).unwrap();
        let name = "mass-on-belt".to_owned();
        apply(Command::Scene { name });
        let panel = until(session, |panel| panel.run == 2 && panel.time_s > 0.0);
        assert_eq!(
            (panel.scene.as_str(), panel.tilt_deg),
            ("mass-on-belt", None)
        );
        assert!(session.apply(&Command::Tilt { deg: 2.0 }).is_err());
        apply(Command::Reset {});
        until(session, |panel| panel.run == 3 && panel.time_s > 0.0);
    });
}

#[test]
fn commands_during_a_restart_apply_to_the_new_run() {
    with_session("torus-3deg", |session| {
        let apply = |command| session.apply(&command).unwrap();
        apply(Command::Reset {});
        apply(Command::Pause {});
        let panel = until(session, |panel| panel.run == 2 && panel.paused);
        assert!(panel.events.iter().any(|e| e.text == "torus-3deg starts"));
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
    with_session("torus-3deg", |session| {
        for (command, part) in [
            (
                Command::Tilt { deg: 10.1 },
                "the tilt must be between 0 and 10",
            ),
            (Command::Tilt { deg: f64::NAN }, "the tilt must be"),
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

#[test]
fn the_tilt_range_includes_that_of_the_scene() {
    let scene = Scene::load("torus-3deg").unwrap();
    assert_eq!(tilt_range_deg(&scene), Some([0.0, 10.0]));
    let steep = scene.with_tilt(14.0).unwrap();
    assert_eq!(tilt_range_deg(&steep), Some([0.0, 14.0]));
    assert_eq!(tilt_range_deg(&Scene::load("mass-on-belt").unwrap()), None);
}
