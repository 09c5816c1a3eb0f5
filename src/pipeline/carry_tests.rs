//! What a change of the loading carries over: `time.carry`.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::dynamics::equilibrium::Linearised;
use crate::joint::{BallJoint, Joint};
use crate::pipeline::prepare::joint_integrator;
use crate::scene::Carry;

/// A joint at rest without friction whose contact is linear, with the given lines for load and tilt, updated
/// every `frame` samples of 5 us.
fn linear(lines: &str, frame: usize, milliseconds: f64) -> Scene {
    let tilt = if lines.contains("tilt") {
        ""
    } else {
        "load.tilt_deg = 3\n"
    };
    let load = if lines.contains("load_n") {
        ""
    } else {
        "load.load_n = 150\n"
    };
    let text = format!(
        "{lines}\n{tilt}{load}contact.unilateral = false\nstart.kick_mm_per_s = 0\n\
         record.energy_rate_khz = 200\n\
         time = {{ duration_ms = {milliseconds}, frame_samples = {frame}, tolerance = 1e-11, carry = \"displacement\" }}\n"
    );
    Scene::parse("mine.toml", text).unwrap_or_else(|error| panic!("{error}"))
}

const STEP: &str =
    "load.load_steps = [{ time_ms = 0, load_n = 75 }, { time_ms = 0.5, load_n = 150 }]";

/// A ramp of the load from 75 to 150 N that starts at 0.5 ms.
fn ramp(milliseconds: f64) -> String {
    let end = 0.5 + milliseconds;
    format!("load.load = [{{ time_ms = 0.5, load_n = 75 }}, {{ time_ms = {end}, load_n = 150 }}]")
}

fn frames(scene: &Scene) -> Vec<Frame> {
    let mut simulation = Simulation::new(scene).unwrap();
    std::iter::from_fn(|| simulation.next_frame().unwrap()).collect()
}

/// Modal coordinates at all samples, a row for each.
fn rows(frames: &[Frame]) -> Vec<Vec<f64>> {
    let of = |frame: &Frame| -> Vec<Vec<f64>> {
        frame.q.chunks(frame.modes).map(<[f64]>::to_vec).collect()
    };
    frames.iter().flat_map(of).collect()
}

/// Equilibrium of the joint of a scene under the loading at a time (s).
fn at_rest(scene: &Scene, time: f64) -> (Joint, DVector<f64>) {
    let tilted = scene.joint().unwrap();
    let mut ball = BallJoint::new(&tilted.spec).unwrap();
    let loading = tilted.loading(time);
    ball.set_loading(&loading);
    let joint = ball.joint(loading.tilt).unwrap();
    let q = DVector::from_column_slice(&joint.equilibrium().q);
    (joint, q)
}

fn largest(rows: &[Vec<f64>]) -> f64 {
    rows.iter().flatten().fold(0.0, |a, q| a.max(q.abs()))
}

/// After a step the linear joint oscillates about the new equilibrium as `cos(sqrt(K) t) (q_eq(old) - q_eq(new))`,
/// with the stiffness matrix `K` of modes and contact; the work of the load is the energy of this displacement.
#[test]
fn a_step_from_rest_excites_an_oscillation_with_the_shift_of_the_equilibrium() {
    for lines in [
        STEP,
        "load.tilt_steps = [{ time_ms = 0, tilt_deg = 1 }, { time_ms = 0.5, tilt_deg = 6 }]",
    ] {
        let scene = linear(lines, 64, 3.0);
        let (_, before) = at_rest(&scene, 0.0);
        let (joint, after) = at_rest(&scene, 1.0);
        let shift = before - after;
        let m = joint.modes();
        let at = Linearised::at(&joint, None, 0.0, &vec![0.0; joint.dim()]);
        let stiffness = DMatrix::from_fn(m, m, |i, j| -at.matrix[(m + i, j)] * at.scale[j]);
        let eigen = stiffness.clone().symmetric_eigen();
        let amplitudes = eigen.eigenvectors.transpose() * &shift;
        let found = frames(&scene);
        for (k, q) in rows(&found).iter().enumerate() {
            let since = k as f64 / 200e3 - 0.5e-3;
            let expected = if since < -1e-9 {
                DVector::zeros(m)
            } else {
                let swing = |k: usize| (eigen.eigenvalues[k].sqrt() * since).cos();
                let modal = DVector::from_fn(m, |k, _| amplitudes[k] * swing(k));
                &eigen.eigenvectors * modal
            };
            let error = (DVector::from_column_slice(q) - expected).amax();
            assert!(
                error < 1e-7 * shift.amax(),
                "{lines}: {error:e} at sample {k}"
            );
        }
        let work = 0.5 * shift.dot(&(&stiffness * &shift));
        let energies: Vec<_> = found.iter().flat_map(|frame| &frame.energy).collect();
        for sample in &energies {
            let stored = if sample.time < 0.49999e-3 { 0.0 } else { work };
            assert!(
                (sample.total - stored).abs() < 1e-8 * work,
                "{lines}: {sample:?}"
            );
            assert!(sample.residual.abs() < 1e-8 * work, "{lines}: {sample:?}");
        }
    }
}

#[test]
fn the_perturbation_of_a_joint_at_rest_stays_zero() {
    let mut scene = linear(STEP, 64, 2.0);
    scene.joint_mut().unwrap().carry = Carry::Perturbation;
    assert_eq!(largest(&rows(&frames(&scene))), 0.0);
}

/// During a ramp the equilibrium moves at a rate that is inversely proportional to its duration, and so does the
/// perturbation.
#[test]
fn the_response_to_a_ramp_decreases_with_its_duration() {
    let response = |milliseconds: f64| {
        let found = rows(&frames(&linear(&ramp(milliseconds), 1, 3.0)));
        // The slowest mode, 1.7 kHz, completes more than three cycles in 2.5 ms.
        largest(&found)
    };
    let [fast, slow, slower] = [10.0, 40.0, 160.0].map(response);
    for ratio in [slow / fast, slower / slow] {
        assert!(
            (0.22..0.28).contains(&ratio),
            "{fast:e} {slow:e} {slower:e}"
        );
    }
    let step = largest(&rows(&frames(&linear(STEP, 1, 3.0))));
    assert!(slower < 0.01 * step, "{slower:e} of {step:e}");
}

/// A ramp that is short compared with the periods of the joint acts like a step at its centre, up to the square of
/// its duration. It is updated at samples of 0.5 us, on average half of one late.
#[test]
fn a_fast_ramp_acts_like_a_step() {
    let at_end = |lines: &str| {
        let mut scene = linear(lines, 1, 1.0);
        scene.sample_rate = 2000e3;
        rows(&frames(&scene)).pop().unwrap()
    };
    let difference = |milliseconds: f64| {
        let centre = 0.5 + 0.5 * milliseconds + 0.25e-3;
        let step = STEP.replace("0.5", &centre.to_string());
        let [ramp, step] = [at_end(&ramp(milliseconds)), at_end(&step)];
        let pairs = ramp.iter().zip(&step).map(|(a, b)| (a - b).abs());
        pairs.fold(0.0, f64::max) / largest(std::slice::from_ref(&step))
    };
    let [long, short] = [0.02, 0.005].map(difference);
    assert!(short < 0.1 * long && short < 0.02, "{long:e} {short:e}");
}

/// Whatever the length of the frames of a live run, a ramp is updated at the frames of the scene.
#[test]
fn the_response_does_not_depend_on_the_length_of_the_frames() {
    let lines = format!(
        "{}\nload.tilt_steps = [{{ time_ms = 0, tilt_deg = 2 }}, {{ time_ms = 1.0013, tilt_deg = 4 }}]",
        ramp(2.0)
    );
    let scene = linear(&lines, 64, 3.0);
    let motion = |samples: usize| {
        let mut simulation = Simulation::new(&scene).unwrap();
        let (_, shown) = DisplayRates::at_speed(1e-3, 200e3);
        simulation.set_frame_length(samples, shown);
        let frames: Vec<Frame> = std::iter::from_fn(|| simulation.next_frame().unwrap()).collect();
        rows(&frames)
    };
    let planned = rows(&frames(&scene));
    assert!(largest(&planned) > 0.0);
    for samples in [1, 7, 64, 1000] {
        assert_eq!(motion(samples), planned, "{samples} samples");
    }
}

/// The audit of a squealing joint includes the work of each change.
#[test]
fn the_energy_of_a_squealing_joint_is_balanced() {
    let load =
        "load.load_steps = [{ time_ms = 0, load_n = 150 }, { time_ms = 7.0013, load_n = 60 }]";
    let tilt = "load.tilt_sine = { mean_deg = 2, amplitude_deg = 2, frequency_hz = 39 }";
    let text = format!(
        "{load}\n{tilt}\ncontact.stiffness_factor = 2.75\n\
         friction = {{ mu_s = 0.55, mu_d = 0.25, stribeck_slope_s_per_m = 13.25 }}\n\
         start = {{ kick_mm_per_s = 1, seed = 19 }}\n\
         time = {{ duration_ms = 20, tolerance = 1e-8, carry = \"displacement\" }}\n"
    );
    let scene = Scene::parse("mine.toml", text).unwrap();
    let found = frames(&scene);
    let energies = || found.iter().flat_map(|frame| &frame.energy);
    let turnover = energies().fold(0.0, |a: f64, e| a.max(e.total));
    let worst = energies().fold(0.0, |a: f64, e| a.max(e.residual.abs()));
    assert!(
        turnover > 1e-9 && worst < 1e-5 * turnover,
        "{worst:e} of {turnover:e}"
    );
}

/// A constant added to the state changes no distance of nearby states: tangent vectors continue as they are.
#[test]
fn a_jump_moves_state_and_perturbed_trajectory_alike() {
    let mut scene = linear("load.load_n = 150", 64, 0.5);
    scene.start.kick = 1e-3;
    let joint = Arc::new(at_rest(&scene, 0.0).0);
    let (integrator, z) = joint_integrator(&scene, &joint).unwrap();
    let mut integrator = integrator.with_tangents(3, 1).unwrap();
    integrator.start(0.0, &z).unwrap();
    integrator.integrate_to(1e-4).unwrap();
    let states =
        [0.0, 1e-9].map(|by| -> Vec<f64> { integrator.state().iter().map(|z| z + by).collect() });
    integrator.add_perturbed(&states[1]).unwrap();
    let tangents = integrator.tangent_vectors().unwrap().to_vec();
    let shift = vec![2e-6; joint.modes()];
    integrator.translate(&shift).unwrap();
    integrator.restart(Arc::new(&joint)).unwrap();
    assert_eq!(integrator.tangent_vectors().unwrap(), tangents);
    let mut found = states.clone();
    let [state, nearby] = &mut found;
    integrator.sample(1e-4, state).unwrap();
    integrator.sample_perturbed(1e-4, nearby).unwrap();
    for (before, after) in states.iter().zip(&found) {
        for (k, (before, after)) in before.iter().zip(after).enumerate() {
            let by = shift.get(k).copied().unwrap_or(0.0);
            assert_eq!(before + by, *after);
        }
    }
    let too_long = vec![0.0; 2 * joint.modes() + 1];
    assert!(integrator.translate(&too_long).is_err());
}
