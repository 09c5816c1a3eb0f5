//! Exponents and the butterfly along a simulated run.

use super::message::{Exponents, Frame, Parting, Record};
use super::{Analyser, Simulation, Source};
use crate::scene::{AnalysisSpec, ButterflySpec, Events, ExponentsSpec, Scene};

const EXPONENTS: ExponentsSpec = ExponentsSpec {
    count: 3,
    settle: 4e-3,
    every: 0.5e-3,
};
const BUTTERFLY: ButterflySpec = ButterflySpec {
    start: 4.001e-3,
    distance: 1e-9,
    every: 1e-3,
};

/// A scene of the program without its analyses, run for so many ms.
fn plain(name: &str, duration_ms: f64) -> Scene {
    let mut scene = Scene::load(name).unwrap();
    scene.analysis = AnalysisSpec::default();
    scene.with_duration(duration_ms).unwrap()
}

fn frames(scene: &Scene) -> Vec<Frame> {
    let mut simulation = Simulation::new(scene).unwrap();
    std::iter::from_fn(|| simulation.next_frame().unwrap()).collect()
}

/// The exponents along a run.
fn exponents(frames: &[Frame]) -> Vec<&Exponents> {
    frames.iter().flat_map(|frame| &frame.exponents).collect()
}

#[test]
fn what_goes_along_leaves_the_motion_as_it_is() {
    for (name, duration_ms) in [("torus-3deg", 12.0), ("tilt-ramp", 60.0)] {
        for events in [Events::Through, Events::Exact] {
            let mut scene = plain(name, duration_ms);
            scene.integrator.events = events;
            let alone = frames(&scene);
            assert!(alone.iter().all(|frame| frame.exponents.is_empty()));
            assert!(alone.iter().all(|frame| frame.twin.is_none()));
            scene.analysis.exponents = Some(EXPONENTS);
            scene.analysis.butterfly = Some(BUTTERFLY);
            let together = frames(&scene);
            assert_eq!(alone.len(), together.len());
            for (alone, together) in alone.iter().zip(&together) {
                assert_eq!(alone.q, together.q, "{name}, {events:?}, {}", alone.t0);
                assert_eq!(alone.qdot, together.qdot);
                assert_eq!(alone.tally, together.tally);
            }
        }
    }
}

#[test]
fn exponents_come_when_they_are_due() {
    let mut scene = plain("torus-3deg", 10.0);
    scene.analysis.exponents = Some(EXPONENTS);
    let frames = frames(&scene);
    let exponents = exponents(&frames);
    for (k, exponents) in exponents.iter().enumerate() {
        let due = EXPONENTS.settle + (k + 1) as f64 * EXPONENTS.every;
        assert!((exponents.time - due).abs() < 1e-9, "{k}");
        let spectrum = &exponents.spectrum;
        assert_eq!((spectrum.exponents.len(), spectrum.dimension), (3, 22));
        // Growth is known up to a step or so from the sample.
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

/// What the analyses say of a scene with a butterfly.
fn parting(name: &str, duration_ms: f64, butterfly: ButterflySpec) -> (Parting, Vec<Record>) {
    let mut scene = plain(name, duration_ms);
    scene.analysis.butterfly = Some(butterfly);
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut analyser = Analyser::new(&scene.analysis, &simulation.header(""));
    let mut records: Vec<Record> = Vec::new();
    while let Some(frame) = simulation.next_frame().unwrap() {
        analyser.push(&frame.into(), &mut records).unwrap();
    }
    (analyser.summary().parting.unwrap(), records)
}

#[test]
fn two_copies_part_where_the_motion_is_chaotic() {
    // Far less than the tolerance of a step, 1e-5: both copies make the same errors.
    let butterfly = ButterflySpec {
        start: 50e-3,
        ..BUTTERFLY
    };
    let (end, records) = parting("chaos-5deg", 250.0, butterfly);
    let first = records.iter().find_map(|record| match record {
        Record::Parting(parting) => Some(*parting),
        _ => None,
    });
    let first = first.unwrap();
    // No larger than the displacement at the start, but for the way it turns at first.
    assert!(
        (0.1..10.0).contains(&(first.distance / butterfly.distance)),
        "{first:?}"
    );
    let rate = end.line.unwrap().rate;
    println!("rate {rate}, {end:?}");
    assert!((20.0..200.0).contains(&rate), "{rate}");
    assert!(end.distance > 1e3 * butterfly.distance, "{end:?}");
}

#[test]
fn two_copies_stay_together_on_a_cycle() {
    let butterfly = ButterflySpec {
        start: 60e-3,
        ..BUTTERFLY
    };
    let (end, _) = parting("periodic-2deg", 120.0, butterfly);
    println!("{end:?}");
    assert!(end.distance < 10.0 * butterfly.distance, "{end:?}");
    assert!(end.line.unwrap().rate < 10.0 && end.saturated.is_none());
}
