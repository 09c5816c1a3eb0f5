//! Small systems in the pipeline: the properties that each scene states.

use super::message::{Frame, Record, Subject};
use super::{Monitor, Simulation, Source, prepare, run};
use crate::analysis::regime::Regime;
use crate::scene::{AnalysisSpec, Scene, SmallSystem, SystemSpec};
use crate::systems::{ImpactOscillator, MassOnBelt};

/// The frames of a scene, without analyses.
fn frames(scene: &Scene) -> Vec<Frame> {
    let mut source = Simulation::new(scene).unwrap();
    std::iter::from_fn(|| source.next_frame().unwrap()).collect()
}

fn load(name: &str) -> Scene {
    Scene::load(name).unwrap()
}

/// Intervals of constant status: the status, its first sample and its number of samples.
fn stretches(frames: &[Frame]) -> Vec<(u8, usize, usize)> {
    let status: Vec<u8> = frames.iter().flat_map(|f| f.status.clone()).collect();
    let mut start = 0;
    let chunks = status.chunk_by(|a, b| a == b);
    chunks
        .map(|same| {
            start += same.len();
            (same[0], start - same.len(), same.len())
        })
        .collect()
}

#[test]
fn samples_are_displacement_velocity_and_status() {
    for name in ["impact-oscillator", "mass-on-belt", "damped-contact"] {
        let scene = load(name).with_duration(20.0).unwrap();
        let mut time = 0.0;
        for frame in frames(&scene) {
            assert!((frame.t0 - time).abs() < 1e-12, "{name}");
            time = frame.end();
            let samples = frame.len();
            assert_eq!(frame.status.len(), samples);
            assert_eq!(frame.q, frame.displacement);
            assert_eq!(frame.qdot, frame.velocity);
            assert_eq!(frame.qdot.len(), samples);
            assert!(frame.patch.is_empty() && frame.energy.is_empty());
            assert!(frame.stats.rhs_evals > 0);
        }
        assert!((time - scene.duration).abs() < 1e-12, "{name}");
        let header = Simulation::new(&scene).unwrap().header("");
        assert!(header.joint().is_none());
        let Subject::Small(small) = header.subject else {
            panic!("{name} runs a small system");
        };
        assert!(small.highest_frequency <= 0.5 * scene.sample_rate);
    }
}

/// Closed form: the slip phase lasts `2 (pi - atan(D w / v)) / w`, the stick phase `2 D / v`.
#[test]
fn stick_and_slip_times_agree_with_the_closed_form() {
    let scene = load("mass-on-belt").with_duration(60.0).unwrap();
    let SystemSpec::Small(SmallSystem::MassOnBelt(system)) = scene.subject else {
        panic!("a mass on a belt");
    };
    let excess = (system.mu_s - system.mu_d) * system.load / system.omega.powi(2);
    let slip =
        2.0 * (std::f64::consts::PI - (excess * system.omega / system.belt).atan()) / system.omega;
    let stick = 2.0 * excess / system.belt;
    let frames = frames(&scene);
    let rate = scene.sample_rate;
    let velocity: Vec<f64> = frames.iter().flat_map(|f| f.velocity.clone()).collect();
    // The first interval contains the transient, and the last one is incomplete.
    let stretches = stretches(&frames);
    let whole = &stretches[2..stretches.len() - 1];
    assert!(whole.len() > 20);
    for &(status, start, length) in whole {
        let expected = match status {
            MassOnBelt::STICKING => stick,
            MassOnBelt::SLOWER => slip,
            other => panic!("status {other}"),
        };
        assert!((length as f64 - expected * rate).abs() <= 1.0);
        if status == MassOnBelt::STICKING {
            let held = &velocity[start..start + length];
            assert!(held.iter().all(|v| *v == system.belt), "sticks exactly");
        }
    }
    let changes: u64 = frames.iter().map(|frame| frame.transitions).sum();
    assert!(changes.abs_diff(stretches.len() as u64 - 1) <= 1);
}

#[test]
fn impacts_reverse_the_velocity() {
    let scene = load("impact-oscillator").with_duration(200.0).unwrap();
    let SystemSpec::Small(SmallSystem::ImpactOscillator(system)) = scene.subject else {
        panic!("an impact oscillator");
    };
    // Counts the impacts with the integrator's own events.
    let mut prepared = prepare(&scene).unwrap();
    prepared.integrator.start(0.0, &prepared.state).unwrap();
    let mut impacts = 0;
    while prepared.integrator.time() < scene.duration {
        let crossed = prepared.integrator.next_event(scene.duration).unwrap();
        if crossed.is_empty() {
            break;
        }
        impacts += 1;
        assert_eq!(prepared.integrator.state()[0], system.wall);
        assert!(prepared.integrator.state()[1] > 0.0);
    }
    let frames = frames(&scene);
    let counted: u64 = frames.iter().map(|frame| frame.transitions).sum();
    assert!(counted.abs_diff(impacts) <= 1, "{counted} and {impacts}");
    // 0.47125 impacts per 1/omega: REFERENCES of the impact oscillator, undamped.
    let rate = impacts as f64 / (scene.duration * system.omega);
    assert!((rate / 0.47125 - 1.0).abs() < 0.1, "{rate}");
    for frame in &frames {
        assert!(frame.displacement.iter().all(|x| *x >= system.wall - 1e-15));
        assert!(frame.status.iter().all(|s| *s == ImpactOscillator::FLYING));
    }
}

/// The last regime of a scene.
fn verdict(name: &str, duration_ms: f64) -> Regime {
    let mut scene = load(name).with_duration(duration_ms).unwrap();
    scene.analysis = AnalysisSpec {
        regime: scene.analysis.regime,
        ..AnalysisSpec::default()
    };
    let mut records: Vec<Record> = Vec::new();
    run(&scene, "", &mut records, Monitor::default()).unwrap();
    let verdicts = records.iter().rev().filter_map(|record| match record {
        Record::Regime { verdict, .. } => Some(verdict.regime),
        _ => None,
    });
    verdicts.into_iter().next().expect("a verdict")
}

#[test]
fn each_scene_has_its_regime() {
    assert_eq!(verdict("mass-on-belt", 400.0), Regime::Periodic);
    assert_eq!(verdict("damped-contact", 800.0), Regime::Periodic);
    assert_eq!(verdict("impact-oscillator", 1000.0), Regime::Chaotic);
}

/// At separation the acceleration changes by the force of the damper.
#[test]
fn the_force_is_discontinuous_at_separation() {
    let scene = load("damped-contact").with_duration(300.0).unwrap();
    let SystemSpec::Small(SmallSystem::DampedContact(system)) = scene.subject else {
        panic!("a damped contact");
    };
    let mut prepared = prepare(&scene).unwrap();
    let run = prepared.integrator.clone().into_system();
    let switching = run.switching().expect("guards");
    prepared.integrator.start(0.0, &prepared.state).unwrap();
    let mut jumps = 0;
    while !prepared
        .integrator
        .next_event(scene.duration)
        .unwrap()
        .is_empty()
    {
        let (t, z) = (prepared.integrator.time(), prepared.integrator.state());
        let mut force = [[0.0]; 2];
        for (status, force) in force.iter_mut().enumerate() {
            switching.force_in(&[status as u8], t, z, force);
        }
        let jump = force[1][0] - force[0][0];
        assert!((jump + system.contact_damping * z[1]).abs() < 1e-6 * jump.abs() + 1e-9);
        jumps += usize::from(jump.abs() > 1.0);
    }
    assert!(jumps > 100, "{jumps}");
}

#[test]
fn a_prepared_joint_starts_like_its_simulation() {
    let scene = load("periodic-2deg").with_duration(1.0).unwrap();
    let mut prepared = prepare(&scene).unwrap();
    prepared.integrator.start(0.0, &prepared.state).unwrap();
    let modes = prepared.integrator.system().modes();
    let frames = frames(&scene);
    let mut z = prepared.state.clone();
    prepared.integrator.sample(1e-4, &mut z).unwrap();
    let k = (1e-4 * scene.sample_rate).round() as usize;
    // The simulation audits its energy, which may shorten its steps: the motions agree within the tolerance,
    // 1e-5.
    let simulated = &frames[0].q[k * modes..(k + 1) * modes];
    let size = simulated.iter().fold(0.0, |size: f64, q| size.max(q.abs()));
    for (prepared, simulated) in z[..modes].iter().zip(simulated) {
        assert!(
            (prepared - simulated).abs() < 1e-4 * size,
            "{prepared} {simulated}"
        );
    }
}
