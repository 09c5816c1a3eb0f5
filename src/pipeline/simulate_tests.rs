//! Runs with a reduced contact.

use super::*;
use crate::joint::Quadrature;
use crate::pipeline::message::Record;
use crate::pipeline::{Monitor, run};

/// The torus with all nodes, or with a tolerance of the reduced contact.
fn torus(reduction: Option<f64>, milliseconds: f64) -> Scene {
    let scene = Scene::load("torus-3deg").unwrap();
    let mut scene = scene.with_duration(milliseconds).unwrap();
    let contact = &mut scene.joint_mut().unwrap().spec.contact;
    (contact.nodes, contact.quadrature, contact.reduction) = (100, Quadrature::Rings, reduction);
    scene
}

/// Displacement of the probe over a whole run, m, and its last frame.
fn displacement(simulation: &mut Simulation) -> (Vec<f64>, Frame) {
    let mut all = Vec::new();
    let mut last = Frame::default();
    while let Some(frame) = simulation.next_frame().unwrap() {
        all.extend_from_slice(&frame.displacement);
        last = frame;
    }
    (all, last)
}

#[test]
fn a_reduced_contact_moves_like_all_nodes_within_its_tolerance() {
    let of = |reduction| displacement(&mut Simulation::new(&torus(reduction, 10.0)).unwrap());
    let (exact, frame) = of(None);
    assert_eq!(frame.reduction, None);
    let (reduced, frame) = of(Some(1e-4));
    let largest = exact.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let pairs = exact.iter().zip(&reduced);
    let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
    // The error of the force grows with the motion.
    assert!(error > 0.0 && error < 1e-2, "{error:e}");
    let report = frame.reduction.unwrap();
    assert!(report.nodes == 100 && report.kept_nodes <= 40, "{report:?}");
    assert!(
        report.errors.checks > 10 && report.errors.rms <= 1e-4,
        "{report:?}"
    );
    assert_eq!(
        (report.nodes_changed_at_s, report.all_nodes_since_s),
        (None, None)
    );
    // The pictures show all nodes.
    assert_eq!(frame.geometry.areas.len(), 100);
    assert!(
        frame
            .patch
            .iter()
            .all(|picture| picture.states.len() == 100)
    );
}

/// With a tolerance that the nodes cannot meet, the run evaluates more and more nodes, and then all of them.
#[test]
fn an_inaccurate_reduction_is_replaced_and_the_energy_is_accounted_for() {
    let mut simulation = Simulation::new(&torus(Some(1e-3), 10.0)).unwrap();
    let exact = simulation.ball.full_nodes();
    simulation.full.as_mut().unwrap().set_tolerance(1e-9);
    let mut frames = Vec::new();
    while let Some(frame) = simulation.next_frame().unwrap() {
        frames.push(frame);
    }
    let report = frames.last().unwrap().reduction.unwrap();
    let since = report.all_nodes_since_s.expect("all nodes");
    assert!(since > 0.0 && since < 10e-3);
    assert_eq!(simulation.joint.contact_nodes(), exact);
    let energies = || frames.iter().flat_map(|frame| &frame.energy);
    let largest = energies().map(|e| e.total).fold(0.0, f64::max);
    let residual = energies().map(|e| e.residual.abs()).fold(0.0, f64::max);
    assert!(residual < 1e-3 * largest, "{residual:e} of {largest:e}");
}

/// With friction that has states, also across steps and ramps of the loading, the energy audit closes, and the motion
/// does not depend on the method.
#[test]
fn runs_with_states_of_friction_close_the_energy_audit() {
    for law in [
        "law = \"lugre\"\nmu_s = 0.55\nmu_d = 0.25\nbristle_stiffness_per_m = 1e6\n\
         bristle_damping_s_per_m = 1\n",
        "law = \"rate-and-state\"\nmu_0 = 0.5\ndirect_effect = 0.01\nevolution_effect = 0.06\n\
         reference_speed_m_per_s = 0.016\nslip_distance_um = 0.5\n",
    ] {
        let run = |method: &str| {
            let text = format!(
                "[load]\nload_n = 150\n\
                 tilt_steps = [{{ time_ms = 0, tilt_deg = 2 }}, {{ time_ms = 2, tilt_deg = 5 }}]\n\
                 [contact]\nnodes = 16\n[start]\nkick_mm_per_s = 2\n[record]\nenergy_rate_khz = 100\n\
                 [time]\nduration_ms = 4\ntolerance = 1e-7\nmethod = \"{method}\"\n[friction]\n{law}"
            );
            let scene = Scene::parse("mine.toml", text).unwrap();
            let mut simulation = Simulation::new(&scene).unwrap();
            let mut frames = Vec::new();
            while let Some(frame) = simulation.next_frame().unwrap() {
                frames.push(frame);
            }
            frames
        };
        let frames = run("lawson54");
        let energies = || frames.iter().flat_map(|frame| &frame.energy);
        let largest = energies().map(|e| e.total).fold(0.0, f64::max);
        let residual = energies().map(|e| e.residual.abs()).fold(0.0, f64::max);
        assert!(
            largest > 0.0 && residual < 1e-5 * largest,
            "{residual:e} of {largest:e}"
        );
        let displacement = |frames: &[Frame]| -> Vec<f64> {
            frames
                .iter()
                .flat_map(|frame| frame.displacement.clone())
                .collect()
        };
        let [one, other] = [&frames, &run("tsit5")].map(|frames| displacement(frames));
        let size = one.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        let pairs = one.iter().zip(&other);
        let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-4 * size, "{error:e} of {size:e}");
    }
}

#[test]
fn a_run_reports_the_reduction_in_its_summary_and_solver_state() {
    let mut records: Vec<Record> = Vec::new();
    let summary = run(
        &torus(Some(1e-5), 5.0),
        "test",
        &mut records,
        Monitor::default(),
    )
    .unwrap();
    let report = summary.reduction.unwrap();
    assert!(
        report.errors.rms > 0.0 && report.errors.rms <= 1e-5,
        "{report:?}"
    );
    let last = records.iter().rev().find_map(|record| match record {
        Record::Health(health) => Some(health.reduction),
        _ => None,
    });
    assert_eq!(last.unwrap(), Some(report));
}

#[test]
fn a_tolerance_out_of_reach_evaluates_all_nodes_and_says_so() {
    let mut scene = torus(Some(1e-7), 1.0);
    scene.joint_mut().unwrap().spec.contact.nodes = 12;
    let mut records: Vec<Record> = Vec::new();
    let summary = run(&scene, "test", &mut records, Monitor::default()).unwrap();
    let report = summary.reduction.unwrap();
    assert_eq!((report.kept_nodes, report.nodes), (12, 12));
    assert_eq!(report.all_nodes_since_s, Some(0.0));
    let warnings = records.iter().filter_map(|record| match record {
        Record::Warning { text, .. } => Some(text.as_str()),
        _ => None,
    });
    assert_eq!(
        warnings.collect::<Vec<_>>(),
        ["no few nodes reach contact.reduction = 1e-7: all 12 nodes are evaluated"]
    );
}
