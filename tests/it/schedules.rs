//! Load, tilt and rotation as functions of time: energy balance, exact times of steps, and results that are
//! bit-identical for constant functions.

use std::sync::Arc;

use squeakscope::export::SamplesSink;
use squeakscope::joint::BallJoint;
use squeakscope::numpy::read_npz;
use squeakscope::pipeline::message::{Frame, Header, JointInfo, Record};
use squeakscope::pipeline::{Monitor, Simulation, Source, prepare, run};
use squeakscope::scene::{LoadedJoint, Scene};
use squeakscope::study::lyapunov::{Goal, LyapunovRequest, scene_lyapunov};

/// A squealing joint with the given lines for load, tilt and rotation; 150 N and 2 degrees by default.
fn scene(lines: &str) -> Scene {
    let given = |key: &str| lines.lines().any(|line| line.starts_with(key));
    let load = if given("load.load") {
        ""
    } else {
        "load.load_n = 150\n"
    };
    let tilt = if given("load.tilt") {
        ""
    } else {
        "load.tilt_deg = 2\n"
    };
    let text = format!(
        "{lines}\n{load}{tilt}contact.stiffness_factor = 2.75\n\
         friction = {{ mu_s = 0.55, mu_d = 0.25, stribeck_slope_s_per_m = 13.25 }}\n\
         start = {{ kick_mm_per_s = 1, seed = 19 }}\n\
         time = {{ duration_ms = 20, tolerance = 1e-8 }}\n"
    );
    Scene::parse("mine.toml", text).unwrap_or_else(|error| panic!("{error}"))
}

/// The frames of a run without timing.
fn frames(scene: &Scene) -> Vec<Frame> {
    let mut simulation = Simulation::new(scene).unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = simulation.next_frame().unwrap() {
        frames.push(Frame {
            busy_seconds: 0.0,
            ..frame
        });
    }
    frames
}

fn joint(scene: &Scene) -> &LoadedJoint {
    scene.joint().unwrap()
}

const CHANGING: [&str; 9] = [
    "load.load = [{ time_ms = 2, load_n = 150 }, { time_ms = 15, load_n = 250 }]",
    "load.load_steps = [{ time_ms = 0, load_n = 150 }, { time_ms = 7.0013, load_n = 60 }]",
    "load.load_sine = { mean_n = 150, amplitude_n = 80, frequency_hz = 39 }",
    "load.tilt = [{ time_ms = 2, tilt_deg = 2 }, { time_ms = 15, tilt_deg = 5 }]",
    "load.tilt_steps = [{ time_ms = 0, tilt_deg = 2 }, { time_ms = 7.0013, tilt_deg = 3 }]",
    "load.tilt_sine = { mean_deg = 2, amplitude_deg = 2, frequency_hz = 39 }",
    "rotation.factor = [{ time_ms = 2, factor = 1 }, { time_ms = 15, factor = 3 }]",
    "rotation.factor_steps = [{ time_ms = 0, factor = 1 }, { time_ms = 7.0013, factor = 0.4 }]",
    "rotation.factor_sine = { mean = 1, amplitude = 0.7, frequency_hz = 39 }",
];

/// Energy balance for each changing quantity, and reproducible runs.
#[test]
fn energy_is_balanced_and_runs_are_reproducible() {
    let steady = frames(&scene(""));
    for lines in CHANGING {
        let scene = scene(lines);
        let found = frames(&scene);
        let energy = || found.iter().flat_map(|frame| &frame.energy);
        let turnover = energy().fold(0.0, |a: f64, e| a.max(e.total));
        let worst = energy().fold(0.0, |a: f64, e| a.max(e.residual.abs()));
        assert!(
            turnover > 1e-9,
            "{lines}: the joint does not squeal: {turnover} J"
        );
        assert!(
            worst < 1e-5 * turnover,
            "{lines}: {worst:e} J of {turnover:e} J"
        );
        assert_eq!(found, frames(&scene), "{lines}");

        // The run starts like the steady one and then differs.
        assert_eq!(found[0].q, steady[0].q, "{lines}");
        let (last, steadily) = (&found[found.len() - 1], &steady[steady.len() - 1]);
        assert_ne!(
            last.q[last.q.len() - 11..],
            steadily.q[steadily.q.len() - 11..],
            "{lines}"
        );
        let samples: usize = found.iter().map(Frame::len).sum();
        assert_eq!(samples, 4000, "{lines}");
    }
}

/// A constant function gives bit-identical results to the constant.
#[test]
fn constant_functions_equal_constants() {
    let steady = frames(&scene(""));
    for lines in [
        "load.load = [{ time_ms = 2, load_n = 150 }, { time_ms = 15, load_n = 150 }]",
        "load.load_steps = [{ time_ms = 3, load_n = 150 }, { time_ms = 5, load_n = 150 }]",
        "load.load_sine = { mean_n = 150, amplitude_n = 0, frequency_hz = 25 }",
        "load.tilt_steps = [{ time_ms = 3, tilt_deg = 2 }, { time_ms = 5, tilt_deg = 2 }]",
        "load.tilt_sine = { mean_deg = 2, amplitude_deg = 0, frequency_hz = 25 }",
        "rotation.factor = [{ time_ms = 3, factor = 1 }, { time_ms = 5, factor = 1 }]",
        "rotation.factor_steps = [{ time_ms = 0, factor = 1 }]",
        "rotation.factor_sine = { mean = 1, amplitude = 0, frequency_hz = 25 }",
    ] {
        assert_eq!(frames(&scene(lines)), steady, "{lines}");
    }
    let twice = "rotation.angular_velocity_rad_per_s = [0, 2, 0]";
    let scaled = "rotation.angular_velocity_rad_per_s = [0, 1, 0]\nrotation.factor = [{ time_ms = 0, factor = 2 }]";
    let [twice, scaled] = [twice, scaled].map(|lines| frames(&scene(lines)));
    for (one, other) in twice.iter().zip(&scaled) {
        assert_eq!((&one.q, &one.patch), (&other.q, &other.patch));
    }
}

/// Hertz: the patch radius is proportional to the cube root of the load, and the pre-stress balances the load.
#[test]
fn the_patch_follows_the_load() {
    let steps = "load.load_steps = [{ time_ms = 0, load_n = 150 }, { time_ms = 8, load_n = 1200 }]";
    let found = frames(&scene(steps));
    let (first, last) = (&found[0], &found[found.len() - 1]);
    assert_eq!((first.load, last.load), (150.0, 1200.0));
    assert!((last.geometry.radius / first.geometry.radius - 2.0).abs() < 1e-12);
    let geometry = &last.geometry;
    let carried = geometry.areas.iter().zip(&geometry.pre_stress);
    let carried: f64 = carried.map(|(a, p)| a * p).sum();
    assert!((carried / 1200.0 - 1.0).abs() < 1e-12);
}

/// A frame ends at a step, between samples or at a sample, and the next frame has the new values.
#[test]
fn frames_end_at_steps() {
    for (time, first_sample) in [(7.0, 1400), (7.0013, 1401), (0.005, 1), (0.001, 1)] {
        let lines = format!(
            "load.load_steps = [{{ time_ms = 0, load_n = 150 }}, {{ time_ms = {time}, load_n = 100 }}]"
        );
        let found = frames(&scene(&lines));
        let after = found.iter().position(|frame| frame.load == 100.0).unwrap();
        let before: usize = found[..after].iter().map(Frame::len).sum();
        assert_eq!(before, first_sample, "{time} ms");
        assert!(found[..after].iter().all(|frame| frame.load == 150.0));
        assert!(found[after..].iter().all(|frame| frame.load == 100.0));
        assert!(found.iter().all(|frame| !frame.is_empty()));
    }
}

/// The joint changes exactly at the time of the step, between two samples: equal to a run that is stopped there and
/// continued with another joint.
#[test]
fn steps_take_effect_at_their_exact_time() {
    let mut changing = scene(CHANGING[7]);
    changing.integrator.tolerance = 1e-11;
    let found = frames(&changing);
    let after = found.iter().find(|frame| frame.rotation_factor == 0.4);
    let after = after.unwrap();
    let (sample, m) = (20, after.modes);
    let row = sample * m..(sample + 1) * m;
    let z = [&after.q[row.clone()], &after.qdot[row]].concat();

    // Relative deviation of a run that changes the joint at a given time (s).
    let by_hand = |change: f64| {
        let before = prepare(&changing).unwrap();
        let mut integrator = before.integrator;
        integrator.start(0.0, &before.state).unwrap();
        integrator.integrate_to(change).unwrap();
        let mut ball = BallJoint::new(&joint(&changing).spec).unwrap();
        ball.set_loading(&joint(&changing).loading(1.0));
        let slower = ball.joint(joint(&changing).tilt.at(0.0)).unwrap();
        integrator.restart(Arc::new(slower)).unwrap();
        let mut state = vec![0.0; 2 * m];
        let time = after.time(sample);
        integrator.sample(time, &mut state).unwrap();
        let deviation = z.iter().zip(&state).map(|(x, y)| (x - y).abs());
        let size = state.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        deviation.fold(0.0, f64::max) / size
    };
    let (at_step, at_sample) = (by_hand(7.0013e-3), by_hand(7.005e-3));
    assert!(at_step < 1e-8, "{at_step:e}");
    assert!(
        at_sample > 100.0 * at_step,
        "{at_sample:e} compared with {at_step:e}"
    );
}

/// A load for which the patch later reaches the beam is rejected before the run.
#[test]
fn unreachable_patches_are_rejected_before_the_run() {
    let lines = "load.tilt_deg = 89\n\
                 load.load_steps = [{ time_ms = 0, load_n = 1 }, { time_ms = 9, load_n = 1e6 }]\n\
                 contact.pressure = [{ radius_mm = 0, pressure_mpa = 1 }, \
                 { radius_mm = 15.4, pressure_mpa = 0 }]";
    let error = Simulation::new(&scene(lines)).err().unwrap();
    let source = std::error::Error::source(&error).map(ToString::to_string);
    let message = format!("{error}: {}", source.unwrap_or_default());
    assert!(message.contains("reaches the beam"), "{message}");
}

/// Load and rotation factor are recorded and exported only if they vary.
#[test]
fn varying_quantities_are_recorded_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.npz");
    let export = |scene: &Scene| {
        let mut sink = SamplesSink::new(path.clone());
        run(scene, "test", &mut sink, Monitor::default()).unwrap();
        read_npz(&path).unwrap()
    };
    let info_of = |scene: &Scene| -> JointInfo {
        let mut records: Vec<Record> = Vec::new();
        run(scene, "test", &mut records, Monitor::default()).unwrap();
        let Some(Record::Header(header)) = records.first() else {
            panic!("no header")
        };
        Header::joint(header).unwrap().clone()
    };
    let steady = scene("");
    let arrays = export(&steady);
    assert!(!arrays.contains_key("load_n") && !arrays.contains_key("rotation_factor"));
    let info = info_of(&steady);
    assert!(!info.load_varies() && !info.rotation_varies());

    let arrays = export(&scene(CHANGING[1]));
    let load = &arrays["load_n"];
    assert_eq!(load.shape, [4000]);
    assert_eq!((load.values[1400], load.values[1401]), (150.0, 60.0));
    assert!(!arrays.contains_key("rotation_factor"));

    let slow = scene(CHANGING[7]);
    let arrays = export(&slow);
    let factor = &arrays["rotation_factor"].values;
    assert_eq!((factor[1400], factor[1401]), (1.0, 0.4));
    assert!(!arrays.contains_key("load_n"));
    let info = info_of(&slow);
    assert_eq!(
        (info.rotation_span, info.load_span),
        ([0.4, 1.0], [150.0; 2])
    );
    assert_eq!(info.sliding_speed, info_of(&steady).sliding_speed);
}

/// Studies of a single state use the initial values; Lyapunov exponents use the final values.
#[test]
fn studies_use_initial_values_and_exponents_final_values() {
    let lines = "load.load_steps = [{ time_ms = 0, load_n = 60 }, { time_ms = 7, load_n = 150 }]\n\
                 rotation.factor = [{ time_ms = 0, factor = 0.5 }, { time_ms = 20, factor = 1 }]";
    let changing = scene(lines);
    let half = std::f64::consts::FRAC_1_SQRT_2 / 2.0;
    let held = scene(&format!(
        "load.load_n = 60\nrotation.angular_velocity_rad_per_s = [{half}, {half}, 0]"
    ));
    let rate = |scene: &Scene| {
        let prepared = prepare(scene).unwrap();
        let z: Vec<f64> = (0..22).map(|k| 1e-7 * f64::from(k)).collect();
        let mut dz = vec![0.0; 11];
        prepared.integrator.system().force(0.0, &z, &mut dz);
        dz
    };
    assert_eq!(rate(&changing), rate(&held));

    let request = LyapunovRequest {
        count: Some(1),
        settle: Some(0.0),
        goal: Goal::Time(1e-3),
        tolerance: None,
    };
    let found = scene_lyapunov(&changing, &request, &mut |_, _| Ok(())).unwrap();
    assert_eq!(
        (found.fixed_at.load_n, found.fixed_at.rotation_factor),
        (Some(150.0), Some(1.0))
    );
    assert_eq!(found.fixed_at.tilt_rad, None);
}
