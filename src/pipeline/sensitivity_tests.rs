//! Lyapunov exponents and the perturbed trajectory of a simulated run.

use super::message::{Exponents, Frame, Record, TrajectoryDivergence};
use super::{Analyser, Simulation, Source};
use crate::scene::{AnalysisSpec, Events, LyapunovSpec, PerturbedTrajectorySpec, Scene};

const EXPONENTS: LyapunovSpec = LyapunovSpec {
    count: 3,
    settle: 4e-3,
    every: 0.5e-3,
};
const PERTURBED: PerturbedTrajectorySpec = PerturbedTrajectorySpec {
    start: 4.001e-3,
    distance: 1e-9,
    every: 1e-3,
};

/// A preset scene without its analyses, with the given duration in ms.
fn plain(name: &str, duration_ms: f64) -> Scene {
    let mut scene = Scene::load(name).unwrap();
    scene = scene.with_duration(duration_ms).unwrap();
    scene.analysis = AnalysisSpec::default();
    scene
}

fn frames(scene: &Scene) -> Vec<Frame> {
    let mut simulation = Simulation::new(scene).unwrap();
    std::iter::from_fn(|| simulation.next_frame().unwrap()).collect()
}

/// The exponents of a run.
fn exponents(frames: &[Frame]) -> Vec<&Exponents> {
    frames.iter().flat_map(|frame| &frame.exponents).collect()
}

#[test]
fn tangents_and_perturbed_trajectory_do_not_change_the_motion() {
    for (name, duration_ms) in [("doubled-torus-3deg", 12.0), ("tilt-ramp", 60.0)] {
        for events in [Events::Through, Events::Exact] {
            let mut scene = plain(name, duration_ms);
            scene.integrator.events = events;
            let alone = frames(&scene);
            assert!(alone.iter().all(|frame| frame.exponents.is_empty()));
            assert!(alone.iter().all(|frame| frame.perturbed.is_none()));
            scene.analysis.exponents = Some(EXPONENTS);
            scene.analysis.perturbed_trajectory = Some(PERTURBED);
            let together = frames(&scene);
            assert_eq!(alone.len(), together.len());
            for (alone, together) in alone.iter().zip(&together) {
                assert_eq!(alone.q, together.q, "{name}, {events:?}, {}", alone.t0);
                assert_eq!(alone.qdot, together.qdot);
                assert_eq!(alone.stats, together.stats);
            }
        }
    }
}

#[test]
fn exponents_are_reported_when_due() {
    let mut scene = plain("doubled-torus-3deg", 10.0);
    scene.analysis.exponents = Some(EXPONENTS);
    let frames = frames(&scene);
    let exponents = exponents(&frames);
    for (k, exponents) in exponents.iter().enumerate() {
        let due = EXPONENTS.settle + (k + 1) as f64 * EXPONENTS.every;
        assert!((exponents.time - due).abs() < 1e-9, "{k}");
        let spectrum = &exponents.spectrum;
        assert_eq!((spectrum.exponents.len(), spectrum.dimension), (3, 22));
        // The growth is known up to about one step from the sample.
        let averaged = exponents.time - EXPONENTS.settle;
        assert!(
            (spectrum.time - averaged).abs() < 0.1e-3,
            "{}",
            spectrum.time
        );
        assert!((exponents.omega_1 / std::f64::consts::TAU - 1698.0).abs() < 1e-6);
    }
    assert_eq!(exponents.len(), 11);
}

/// The divergence of the perturbed trajectory of a scene.
fn divergence(
    name: &str,
    duration_ms: f64,
    perturbed_trajectory: PerturbedTrajectorySpec,
) -> (TrajectoryDivergence, Vec<Record>) {
    let mut scene = plain(name, duration_ms);
    scene.analysis.perturbed_trajectory = Some(perturbed_trajectory);
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut analyser = Analyser::new(&scene.analysis, &simulation.header(""));
    let mut records: Vec<Record> = Vec::new();
    while let Some(frame) = simulation.next_frame().unwrap() {
        analyser.push(&frame.into(), &mut records).unwrap();
    }
    (analyser.summary().divergence.unwrap(), records)
}

#[test]
fn perturbed_trajectory_separates_in_chaotic_motion() {
    // Far less than the tolerance of a step, 1e-5: both trajectories have the same step errors.
    let perturbed_trajectory = PerturbedTrajectorySpec {
        start: 50e-3,
        ..PERTURBED
    };
    let (end, records) = divergence("chaos-5deg", 250.0, perturbed_trajectory);
    let first = records.iter().find_map(|record| match record {
        Record::TrajectoryDivergence(divergence) => Some(*divergence),
        _ => None,
    });
    let first = first.unwrap();
    // Close to the initial displacement, except for its rotation at the start.
    assert!(
        (0.1..10.0).contains(&(first.distance / perturbed_trajectory.distance)),
        "{first:?}"
    );
    let rate = end.line.unwrap().rate_per_s;
    println!("rate {rate}, {end:?}");
    assert!((20.0..200.0).contains(&rate), "{rate}");
    assert!(
        end.distance > 1e3 * perturbed_trajectory.distance,
        "{end:?}"
    );
}

#[test]
fn perturbed_trajectory_stays_close_on_a_limit_cycle() {
    let perturbed_trajectory = PerturbedTrajectorySpec {
        start: 60e-3,
        ..PERTURBED
    };
    let (end, _) = divergence("periodic-2deg", 120.0, perturbed_trajectory);
    println!("{end:?}");
    assert!(
        end.distance < 10.0 * perturbed_trajectory.distance,
        "{end:?}"
    );
    assert!(end.line.unwrap().rate_per_s < 10.0 && end.saturated_s.is_none());
}
