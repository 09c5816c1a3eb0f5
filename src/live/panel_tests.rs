//! Tests of the panel.

#[path = "../../tests/it/live/contradictions.rs"]
mod contradictions;

use self::contradictions::contradictions;
use super::*;
use crate::live::frames_tests::run_frames;
use crate::pipeline::{Simulation, Source as _};
use crate::scene::Scene;

#[test]
fn the_last_events_are_kept_and_numbered() {
    let store = Arc::new(StatusStore::default());
    let mut sink = StatusSink(Arc::clone(&store));
    for k in 0..20 {
        let text = format!("event {k}");
        sink.accept(Record::Event { time: 0.1, text }).unwrap();
    }
    let panel = store.read();
    assert_eq!(panel.events.len(), EVENTS);
    assert_eq!(panel.events[EVENTS - 1].text, "event 19");
    assert_eq!(panel.events[EVENTS - 1].number, 20);
}

fn update(store: &StatusStore, frame: &Frame) {
    lock(&store.0).update(frame);
}

/// The panel after a run of a scene, in frames of the given playback speed (simulated seconds per second).
fn panel_at(scene: &str, speed: f64, duration_ms: f64) -> Panel {
    follow(scene, speed, duration_ms, |_| {}).read()
}

/// The same, with a function that is called after each frame.
fn follow(
    scene: &str,
    speed: f64,
    duration_ms: f64,
    mut after: impl FnMut(&StatusStore),
) -> Arc<StatusStore> {
    let store = Arc::new(StatusStore::default());
    let mut sink = StatusSink(Arc::clone(&store));
    let scene = Scene::load(scene).unwrap();
    run_frames(scene, speed, duration_ms, &mut sink, || after(&store));
    store
}

#[test]
fn the_numbers_do_not_depend_on_the_playback_speed() {
    let slow = panel_at("stick-slip", 1e-3, 52.0);
    let [stick, slip, separated] = slow.nodes.expect("nodes");
    assert!(stick > 1.0 && slip > 1.0, "{stick} {slip} {separated}");
    assert!(slow.regime.is_some() && !slow.lines.is_empty() && !slow.narration.is_empty());
    for speed in [0.02, 0.25, 1.0] {
        let mut panel = panel_at("stick-slip", speed, 52.0);
        // The end of a frame is a sum of rounded numbers.
        assert!((panel.time_s - slow.time_s).abs() < 1e-12);
        panel.time_s = slow.time_s;
        assert_eq!(panel, slow, "at {speed} s/s");
    }
}

#[test]
fn the_present_motion_is_told_from_the_scene() {
    let store = Arc::new(StatusStore::default());
    let mut sink = StatusSink(Arc::clone(&store));
    let mut header = crate::pipeline::synthetic_header();
    header.title = "Torus".to_owned();
    header.rest_speed = 1e-6;
    sink.accept(Record::Header(Arc::new(header))).unwrap();
    let frame = |t0, tilt: f64, velocity| Frame {
        t0,
        dt: 1e-5,
        tilt,
        velocity: vec![velocity; 1000],
        displacement: vec![0.0; 1000],
        ..Frame::default()
    };
    update(&store, &frame(0.0, 0.0, 1e-3));
    assert_eq!(store.read().now, "not yet classified");
    lock(&store.0).panel.regime = Some("chaotic".to_owned());
    lock(&store.0).panel.confidence = Some(0.9);
    update(&store, &frame(0.01, 5f64.to_radians(), 1e-3));
    let motion = |store: &StatusStore| store.read().motion;
    assert_eq!(motion(&store), "the tilt moves");
    assert_eq!(store.bookmark().promise, None);
    update(&store, &frame(0.06, 5f64.to_radians(), 1e-3));
    let panel = store.read();
    let words = "chaotic, at a tilt of 5.00° instead of the scene's 0.00°";
    assert_eq!((panel.title.as_str(), panel.now.as_str()), ("Torus", words));
    assert_eq!(store.bookmark().promise.unwrap().motion, "chaotic");
    update(&store, &frame(0.12, 0.0, 1e-7));
    let panel = store.read();
    assert_eq!((panel.now.as_str(), panel.confidence), ("at rest", None));
}

/// Header, commentary, bookmark and lines never contradict each other, in a run that passes silence, tones, tori and chaos
/// and in one with a hysteresis.
#[test]
fn there_is_one_verdict() {
    for (scene, duration_ms) in [
        ("tilt-ramp", 280.0),
        ("hysteresis", 400.0),
        ("chaos-5deg", 150.0),
    ] {
        let mut verdicts = std::collections::HashSet::new();
        follow(scene, 0.25, duration_ms, |store| {
            let panel = store.read();
            let found = contradictions(&serde_json::to_value(&panel).unwrap());
            assert_eq!(found, [""; 0], "{scene}");
            verdicts.insert(panel.motion);
        });
        assert!(verdicts.len() > 1, "{scene}: {verdicts:?}");
    }
}

/// The window of the classification still contains the growth, which the vibration has left.
#[test]
fn a_growth_that_is_over_is_no_transient() {
    let mut verdicts = [Vec::new(), Vec::new()];
    follow("negative-slope", 0.02, 190.0, |store| {
        let panel = store.read();
        verdicts[usize::from(panel.time_s > 0.17)].extend(panel.regime);
    });
    assert!(verdicts[0].iter().any(|regime| regime == "transient"));
    assert!(!verdicts[1].iter().any(|regime| regime == "transient"));
}

#[test]
fn a_new_run_resets_the_numbers_but_keeps_the_events() {
    let store = StatusStore::default();
    let scene = Scene::load("periodic-2deg").unwrap();
    let mut source = Simulation::new(&scene).unwrap();
    source.run_until_stopped();
    store.begin_run(&source.header(""), Some(true));
    store.log(0.0, "message");
    store.set_recording(Some("a.rrd".to_owned()));
    let frame = Frame {
        dt: 1e-5,
        velocity: vec![1e-3, -2e-3],
        displacement: vec![0.0; 2],
        ..Frame::default()
    };
    update(&store, &frame);
    assert_eq!(store.read().peak_velocity_mm_per_s, 2.0);
    store.begin_run(&crate::pipeline::synthetic_header(), None);
    let panel = store.read();
    assert_eq!(
        (
            panel.run,
            panel.peak_velocity_mm_per_s,
            panel.controls.len()
        ),
        (2, 0.0, 0)
    );
    assert_eq!(panel.recording.as_deref(), Some("a.rrd"));
    assert_eq!(panel.events.len(), 1);
}
