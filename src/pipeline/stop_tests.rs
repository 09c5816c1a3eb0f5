//! A run that is stopped within a frame keeps its samples, which are identical to those of a complete run.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::{Simulation, Source};
use crate::scene::Scene;

/// A scene with a run of `duration` (s) in a single frame.
fn one_frame(name: &str, duration: f64) -> Scene {
    let mut scene = Scene::load(name).unwrap().without_analyses();
    scene.duration = duration;
    scene.frame_samples = usize::MAX;
    scene
}

#[test]
fn a_stopped_frame_ends_with_the_last_computed_sample() {
    // Durations that take minutes, so that the run is stopped before its end on any machine.
    for (name, duration) in [
        ("doubled-torus-3deg", 1e2),
        ("impact-oscillator", 1e6),
        ("tilt-ramp", 1e2),
    ] {
        let scene = one_frame(name, duration);
        let stop = Arc::new(AtomicBool::new(false));
        let mut stopped = Simulation::new(&scene).unwrap();
        stopped.set_stop_flag(&stop);
        let raised = Arc::clone(&stop);
        let raiser = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(100));
            raised.store(true, Ordering::Relaxed);
        });
        let frame = stopped.next_frame().unwrap().expect("some samples");
        raiser.join().unwrap();
        assert!(!stopped.is_finished(), "{name}");
        assert!(stopped.next_frame().unwrap().is_none(), "{name}");
        assert_eq!(frame.q.len(), frame.len() * frame.modes);
        assert_eq!(frame.velocity.len(), frame.len());

        let mut whole = scene.clone();
        whole.duration = frame.len() as f64 / scene.sample_rate;
        let whole = Simulation::new(&whole)
            .unwrap()
            .next_frame()
            .unwrap()
            .unwrap();
        assert_eq!(whole.len(), frame.len(), "{name}");
        assert!(whole.q == frame.q && whole.qdot == frame.qdot, "{name}");
        assert_eq!(whole.transitions, frame.transitions, "{name}");
    }
}

/// The initial state needs no step.
#[test]
fn a_run_stopped_before_its_first_step_has_the_initial_state() {
    for name in ["doubled-torus-3deg", "impact-oscillator"] {
        let mut source = Simulation::new(&one_frame(name, 1.0)).unwrap();
        source.set_stop_flag(&Arc::new(AtomicBool::new(true)));
        assert_eq!(source.next_frame().unwrap().expect("the start").len(), 1);
        assert!(source.next_frame().unwrap().is_none() && !source.is_finished());
    }
}
