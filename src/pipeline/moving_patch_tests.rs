//! Rotations that move the contact patch.

use super::*;

/// The paper's rotation, with the tilt from -1 degree through zero, and the given lines.
fn moving(lines: &str, milliseconds: f64) -> Scene {
    let text = format!(
        "{lines}\nload = {{ load_n = 150, tilt_deg = -1, azimuth_deg = 135 }}\nrotation.moves_patch = true\n\
         friction = {{ mu_s = 0.55, mu_d = 0.25, stribeck_slope_s_per_m = 13.25 }}\n\
         time = {{ duration_ms = {milliseconds}, tolerance = 1e-8, carry = \"displacement\" }}\n"
    );
    Scene::parse("mine.toml", text).unwrap_or_else(|error| panic!("{error}"))
}

fn joint(simulation: &Simulation) -> &JointBody {
    match &simulation.body {
        Body::Joint(body) => body,
        Body::Small(_) => panic!("a joint"),
    }
}

fn without_moved_patch(simulation: &Simulation) -> Loading {
    Loading {
        patch: None,
        ..simulation.loading().unwrap()
    }
}

fn frames(simulation: &mut Simulation) -> Vec<Frame> {
    std::iter::from_fn(|| simulation.next_frame().unwrap()).collect()
}

/// The patch moves over the ball against the material, which slides through it with `Omega x x`.
#[test]
fn the_patch_moves_against_the_sliding_direction() {
    let mut simulation = Simulation::new(&moving("", 40.0)).unwrap();
    let found = frames(&mut simulation);
    let ball = &joint(&simulation).ball;
    for pair in found.windows(2) {
        let [a, b] = [&pair[0], &pair[1]];
        let step = b.t0 - a.t0;
        assert!((b.tilt - a.tilt - step).abs() < 1e-14);
        let middle = 0.5 * (a.tilt + b.tilt);
        let mut at_middle = ball.clone();
        at_middle.set_loading(&without_moved_patch(&simulation));
        let velocity = at_middle.sliding_velocity(middle);
        for k in 0..3 {
            let moved = ball.ball_radius() * (b.geometry.direction[k] - a.geometry.direction[k]);
            // The chord is shorter than the arc by a relative 7e-8.
            assert!(
                (moved / step + velocity[k]).abs() < 1e-8,
                "{moved:e} {velocity:?}"
            );
        }
    }
    assert!(found[0].tilt < 0.0 && found[found.len() - 1].tilt > 0.02);
}

/// A joint whose patch the rotation has moved is the one at that tilt.
#[test]
fn a_moved_patch_is_that_of_its_tilt() {
    let mut simulation = Simulation::new(&moving("", 40.0)).unwrap();
    let last = frames(&mut simulation).pop().unwrap();
    let mut ball = joint(&simulation).ball.clone();
    let moved = ball.model(last.tilt).unwrap();
    ball.set_loading(&without_moved_patch(&simulation));
    let tilted = ball.model(last.tilt).unwrap();
    let vectors = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        let size = b
            .as_flattened()
            .iter()
            .fold(0.0, |a: f64, x| a.max(x.abs()));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / size
    };
    for (a, b) in [
        (&moved.positions, &tilted.positions),
        (&moved.normals, &tilted.normals),
        (&moved.shapes, &tilted.shapes),
        (&moved.sliding_velocity, &tilted.sliding_velocity),
    ] {
        assert!(vectors(a, b) < 1e-12, "{:e}", vectors(a, b));
    }
}

/// The energy is balanced along the path, and the motion does not depend on the length of the frames.
#[test]
fn energy_is_balanced_and_frames_do_not_matter() {
    let scene = moving("start.kick_mm_per_s = 1", 20.0);
    let planned = frames(&mut Simulation::new(&scene).unwrap());
    let energies = || planned.iter().flat_map(|frame| &frame.energy);
    let turnover = energies().fold(0.0, |a: f64, e| a.max(e.total));
    let worst = energies().fold(0.0, |a: f64, e| a.max(e.residual.abs()));
    assert!(
        turnover > 1e-9 && worst < 1e-5 * turnover,
        "{worst:e} of {turnover:e}"
    );
    let mut short = Simulation::new(&scene).unwrap();
    let (_, shown) = DisplayRates::at_speed(1e-3, 200e3);
    short.set_frame_length(100, shown);
    let rows = |frames: &[Frame]| -> Vec<f64> {
        frames.iter().flat_map(|frame| frame.q.clone()).collect()
    };
    assert_eq!(rows(&frames(&mut short)), rows(&planned));
}

/// A reversal of the rotation changes neither the sign of the probe nor its direction in the body.
#[test]
fn the_probe_keeps_its_direction_when_the_rotation_reverses() {
    let lines = "rotation.factor_steps = [{ time_ms = 0, factor = 1 }, { time_ms = 1, factor = 0 }, \
                 { time_ms = 2, factor = -1 }]";
    let mut simulation = Simulation::new(&moving(lines, 3.0)).unwrap();
    let forward = joint(&simulation).joint.probe().to_vec();
    let found = frames(&mut simulation);
    assert_eq!(found[found.len() - 1].rotation_factor, -1.0);
    let size = forward.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    for (now, forward) in joint(&simulation).joint.probe().iter().zip(&forward) {
        assert!((now - forward).abs() < 0.01 * size, "{now} {forward}");
    }
}

/// A live tilt replaces the direction that the rotation has reached; the rotation then moves the patch from there.
#[test]
fn a_commanded_tilt_moves_on_with_the_rotation() {
    let mut simulation = Simulation::new(&moving("", 20.0)).unwrap();
    simulation.next_frame().unwrap();
    simulation
        .set(Parameter::tilt(), 0.05_f64.to_degrees())
        .unwrap();
    let [commanded, next] = [(); 2].map(|()| simulation.next_frame().unwrap().unwrap());
    assert!((commanded.tilt - 0.05).abs() < 1e-15);
    assert!((next.tilt - 0.05 - (next.t0 - commanded.t0)).abs() < 1e-14);
}

#[test]
fn a_path_that_reaches_the_beam_is_rejected_before_the_run() {
    let error = Simulation::new(&moving("", 3000.0)).err().unwrap();
    let source = std::error::Error::source(&error).map(ToString::to_string);
    let message = format!("{error}: {}", source.unwrap_or_default());
    assert!(message.contains("reaches the beam"), "{message}");
}

/// The shipped scene turns to 8 degrees and back. It sticks at the reversals and squeaks on the way.
#[test]
fn the_articulated_joint_squeaks_on_its_way() {
    let scene = Scene::load("articulation").unwrap().without_analyses();
    let found = frames(&mut Simulation::new(&scene).unwrap());
    let peak = |from: f64, to: f64| {
        let within = found
            .iter()
            .filter(|frame| frame.t0 >= from && frame.t0 < to);
        within
            .flat_map(|frame| &frame.velocity)
            .fold(0.0, |a: f64, v| a.max(v.abs()))
    };
    let highest = found
        .iter()
        .fold(0.0, |a: f64, frame| a.max(frame.tilt.to_degrees()));
    assert!((highest - 8.0).abs() < 1e-9, "{highest}");
    assert!(found[0].tilt < -0.139 && found[found.len() - 1].tilt < -0.139);
    for way in [0.0, 0.25] {
        let squeak = peak(way + 0.08, way + 0.17);
        let stuck = peak(way + 0.01, way + 0.02);
        assert!(
            (0.03..0.05).contains(&squeak) && stuck < 1e-3,
            "{squeak} {stuck}"
        );
    }
}
