//! Simultaneous, grazing and accumulating contact changes; extreme initial states.

use squeakscope::dynamics::{
    Accuracy, DynamicsError, Integrator, Method, MethodName, Switching, System,
};
use squeakscope::joint::{ContactDamping, Friction, Joint, Model};
use squeakscope::pipeline::PipelineError;
use squeakscope::scene::Scene;
use squeakscope::systems::ImpactOscillator;

use super::{Case, assert_stable, distance, geometric_mean, joint, run_scene, scene, try_run};

/// Accuracy as in scenes: the power of friction has rounding noise that does not vanish with the state.
fn accuracy(tolerance: f64) -> Accuracy {
    Accuracy {
        floor: 1e-12,
        ..Accuracy::relative(tolerance)
    }
}

fn lawson(tolerance: f64) -> Method {
    MethodName::Lawson54.with(Accuracy::relative(tolerance), 0.1)
}

/// A mass on one preloaded contact spring without friction, with unit parameters: `q'' = -2 q` in
/// contact (`q > -1`), `q'' = 1 - q` when separated.
fn preloaded_mass() -> Joint {
    Joint::new(&Model {
        positions: vec![[0.0, 0.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0]],
        areas: vec![1.0],
        pre_stress: vec![1.0],
        stiffness: vec![1.0],
        shapes: vec![[0.0, 0.0, 1.0]],
        omega: vec![1.0],
        damping: vec![],
        sliding_velocity: vec![[0.0; 3]],
        friction: Friction::None,
        unilateral: true,
        contact_damping: ContactDamping::None,
        convection: None,
        probe: vec![1.0],
    })
}

/// The contact barely separates, or barely does not, a hundred times.
#[test]
fn grazing_contact() {
    let joint = preloaded_mass();
    let period = std::f64::consts::TAU / 2.0_f64.sqrt();
    for depth in [-1e-3, -1e-9, -1e-15, 0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3] {
        let start = [1.0 + depth, 0.0];
        let energy = joint.energy(&start).total();
        let [through, exact] = [false, true].map(|stops| {
            let mut integrator = Integrator::new(lawson(1e-10), &joint).unwrap();
            if stops {
                integrator = integrator.with_events().unwrap();
            }
            integrator.start(0.0, &start).unwrap();
            integrator.integrate_to(100.0 * period).unwrap();
            // About 5000 steps at the tolerance in each run.
            let energy_change = joint.energy(integrator.state()).total() / energy - 1.0;
            assert!(energy_change.abs() < 1e-6, "{depth:e}: {energy_change:e}");
            integrator
        });
        let error = distance(joint.omega(), through.state(), exact.state());
        assert!(error < 1e-6, "{depth:e}: {error:e}");
        let stats = exact.stats();
        println!(
            "| grazing contact, depth {depth:.0e} | {error:.1e} | {} |",
            stats.crossings
        );
        assert_eq!(
            stats.steps_without_event_location, 0,
            "{depth:e}: {stats:?}"
        );
        assert!(stats.crossings <= 200, "{depth:e}: {stats:?}");
        match depth {
            d if d >= 1e-6 => assert_eq!(stats.crossings, 200, "{depth:e}: {stats:?}"),
            d if d <= -1e-9 => assert_eq!(stats.crossings, 0, "{depth:e}: {stats:?}"),
            // If the depth is within the errors of the steps, either result is valid.
            _ => {}
        }
        if depth <= 1e-12 {
            // As if the contact could not separate.
            let linear = [start[0], 0.0];
            let error = distance(joint.omega(), exact.state(), &linear);
            assert!(error < 1e-6, "{depth:e}: {error:e}");
        }
    }
}

/// The wall is at the turning point of the free vibration: it is reached at zero or very low speed.
#[test]
fn grazing_impacts() {
    for depth in [-1e-12, 0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
        let system = ImpactOscillator {
            omega: 1.0,
            damping: 0.0,
            drive: 0.0,
            drive_omega: 0.0,
            drive_phase: 0.0,
            wall: -1.0 + depth,
            restitution: 0.8,
        };
        let integrator = Integrator::new(lawson(1e-10), system).unwrap();
        let mut integrator = integrator.with_events().unwrap();
        integrator.start(0.0, &[1.0, 0.0]).unwrap();
        let t = 20.0 * std::f64::consts::TAU;
        integrator.integrate_to(t).unwrap();
        let z = integrator.state();
        // An impact comes at a phase of sqrt(2 depth) before the turning point and leaves at 0.8 of that
        // after it: twenty impacts shift the phase by 51 sqrt(depth). The amplitude becomes that of the
        // wall.
        let error = (z[0] - 1.0).hypot(z[1]);
        println!(
            "| grazing impacts, depth {depth:.0e} | {error:.1e} | {} |",
            integrator.stats().crossings
        );
        // A wall out of reach by less than rounding may still be touched.
        let depth = f64::max(depth, 1e-14);
        assert!(error < 60.0 * depth.sqrt(), "{depth:e}: {z:?}");
        assert!(integrator.stats().crossings <= 20 * 3, "{depth:e}");
    }
}

/// Rings of nodes that change contact at the same instant by symmetry are one event each, not one per
/// node.
#[test]
fn simultaneous_crossings_by_symmetry() {
    let changes = [
        ("body.bending_pairs", "0"),
        ("body.torsion_modes", "0"),
        ("load.tilt_deg", "0"),
        ("contact.quadrature", "\"gauss\""),
        ("start.kick_mm_per_s", "100"),
        ("time.duration_ms", "2"),
        ("time.events", "\"exact\""),
    ];
    let result = assert_stable(&Case {
        name: "simultaneous crossings by symmetry",
        changes: &changes,
        ..Case::default()
    });
    let stats = result.summary.stats;
    // A hundred nodes in four rings.
    assert!(
        stats.crossings > 500 && stats.steps_without_event_location == 0,
        "{stats:?}"
    );
    assert!(stats.crossings >= 20 * stats.events, "{stats:?}");
}

fn impacts(wall_um: f64, drive: f64, restitution: f64) -> Scene {
    let text = format!(
        "[impact_oscillator]\nnatural_frequency_hz = 200\ndrive_amplitude_m_per_s2 = {drive}\ndrive_frequency_hz = 130\n\
         wall_position_um = {wall_um}\nrestitution = {restitution}\n[start]\nposition_um = 200\n\
         kick_mm_per_s = 0\n[time]\nduration_ms = 500\nsample_rate_khz = 20\ntolerance = 1e-9\n\
         max_step_us = 200\n"
    );
    Scene::parse("impacts", text).unwrap()
}

/// Repeated sequences of impacts that accumulate at rest in a finite time: an infinite number of events
/// that must end.
#[test]
fn chatter_of_the_impact_oscillator() {
    for restitution in [0.0, 0.3, 0.7, 0.9, 0.99, 1.0] {
        for drive in [0.0, 150.0, 400.0] {
            let scene = impacts(100.0, drive, restitution);
            let result = run_scene(&scene);
            let states: Vec<f64> = result.states().collect();
            assert!(states.iter().all(|x| x.is_finite() && x.abs() < 10.0));
            for frame in &result.frames {
                let lowest = frame.q.iter().copied().fold(f64::INFINITY, f64::min);
                assert!(lowest >= 100e-6 - 1e-15, "{restitution} {drive}: {lowest}");
            }
            let statuses = result.frames.iter().flat_map(|frame| &frame.status);
            let resting: Vec<bool> = statuses
                .map(|status| *status == ImpactOscillator::RESTING)
                .collect();
            let times = resting
                .windows(2)
                .filter(|pair| !pair[0] && pair[1])
                .count();
            let transitions = result.summary.transitions;
            let name = format!("{restitution} {drive}");
            println!(
                "| endless chatter, restitution {restitution}, drive {drive} m/s^2 | {times} | {transitions} |"
            );
            match (restitution, drive) {
                // Elastic and not driven: it never rests and conserves its energy within the permitted
                // error of the steps.
                (1.0, 0.0) => {
                    let omega = 200.0 * std::f64::consts::TAU;
                    let end = result.final_state();
                    let energy = (omega * end[0]).powi(2) + end[1].powi(2);
                    let start = (omega * 200e-6_f64).powi(2);
                    let allowed = 2e-9 * result.summary.stats.steps as f64;
                    assert!((energy / start - 1.0).abs() < allowed, "{name}");
                    assert_eq!(times, 0, "{name}");
                }
                // If it is always pressed against the wall (158 m/s^2 minus the drive), it comes to rest
                // there once.
                (r, drive) if r < 1.0 && drive < 158.0 => {
                    assert_eq!(result.final_state(), [100e-6, 0.0], "{name}");
                    assert_eq!(times, 1, "{name}");
                }
                // If it is pulled off once in each of the 65 periods, it comes to rest as often,
                // provided that the impacts dissipate enough.
                (r, 400.0) if r < 0.5 => assert_eq!(times, 65, "{name}"),
                // Otherwise it keeps bouncing, with at least one impact per period.
                _ => assert!(transitions >= 65, "{name}: {transitions}"),
            }
        }
    }
}

/// Flights a million times shorter than the steps, for a mass pressed with 4e10 times its weight:
/// between two impacts the distance from the wall and the duration soon approach rounding.
#[test]
fn flights_much_shorter_than_the_steps() {
    let omega = std::f64::consts::TAU * 1e5;
    let system = ImpactOscillator {
        omega,
        damping: 0.0,
        drive: 0.0,
        drive_omega: 0.0,
        drive_phase: 0.0,
        wall: 1.0,
        restitution: 0.5,
    };
    let (accuracy, max_step) = (accuracy(1e-6), 20e-6);
    for method in [
        MethodName::Lawson54.with(accuracy, max_step),
        MethodName::Lawson853.with(accuracy, max_step),
        MethodName::Tsit5.with(accuracy, max_step),
        MethodName::Dop853.with(accuracy, max_step),
        MethodName::Rodas5P.with(accuracy, max_step),
        MethodName::Auto.with(accuracy, max_step),
    ] {
        let integrator = Integrator::new(method, system).unwrap();
        let mut integrator = integrator.with_events().unwrap();
        let (press, speed) = (omega * omega, 12.0);
        integrator.start(0.0, &[1.0, -speed]).unwrap();
        while integrator.status() == [ImpactOscillator::FLYING] {
            integrator.next_event(1e-9).unwrap();
            assert!(
                integrator.time() < 1e-9,
                "{method:?}: the mass must come to rest"
            );
        }
        // Each flight lasts half as long as the one before, so the total is twice the first one, 2 v /
        // press. The remainder corresponds to 85 units in the last place of the wall position: 0.12 m/s.
        let first = 2.0 * 0.5 * speed / press;
        let error = (integrator.time() - 2.0 * first).abs();
        let impacts = integrator.stats().crossings;
        println!("| bounces far shorter than the steps | {error:.1e} s | {impacts} |");
        assert!(error < 2.0 * 2.0 * 0.12 / press, "{method:?}: {error:e}");
        // The speed halves from 12 to 0.12 m/s in seven impacts; the next one ends at rest.
        assert!(impacts <= 8, "{method:?}: {impacts}");
        integrator.integrate_to(1e-3).unwrap();
        assert_eq!(integrator.state(), [1.0, 0.0], "{method:?}");
    }
}

/// An initial position behind the wall is rejected by the scene.
#[test]
fn an_initial_position_behind_the_wall_is_rejected() {
    let text = impacts(100.0, 0.0, 0.5)
        .text
        .replace("position_um = 200", "position_um = 99");
    let rejected = Scene::parse("impacts", text).unwrap_err().to_string();
    assert!(rejected.contains("below the wall at 100 µm"), "{rejected}");
}

/// Ball and socket start separated, at a hundred times the static indentation.
#[test]
fn an_initial_state_out_of_contact() {
    let scene = scene(&[
        ("body.bending_pairs", "0"),
        ("body.torsion_modes", "0"),
        ("load.tilt_deg", "0"),
    ]);
    let joint = joint(&scene).with_audit();
    let mut gaps = vec![0.0; joint.contact_nodes()];
    joint.gaps(&[1.0], &mut gaps);
    let sign = -gaps[0].signum();
    let mut far = 1e-9;
    let mut open = |q: f64| {
        joint.gaps(&[q], &mut gaps);
        gaps.iter().all(|gap| *gap < 0.0)
    };
    while !open(sign * far) {
        far *= 1.1;
    }
    let start = [100.0 * sign * far, 0.0, 0.0];
    let energy = joint.energy(&start).total();
    let ends = ["1e-6", "1e-8", "1e-10"].map(|tolerance| {
        let tolerance: f64 = tolerance.parse().unwrap();
        let method = MethodName::Auto.with(accuracy(tolerance), 20e-6);
        [false, true].map(|stops| {
            let mut integrator = Integrator::new(method, &joint).unwrap();
            if stops {
                integrator = integrator.with_events().unwrap();
            }
            integrator.start(0.0, &start).unwrap();
            integrator.integrate_to(2e-3).unwrap();
            let z = integrator.state().to_vec();
            let audit = (joint.energy(&z).total() - energy - z[2]) / energy;
            (z, audit.abs())
        })
    });
    for stops in [false, true] {
        let [coarse, fine, finest] = ends.each_ref().map(|both| &both[usize::from(stops)]);
        let audits = [coarse.1, fine.1, finest.1];
        let errors = [coarse, fine].map(|end| distance(joint.omega(), &end.0, &finest.0));
        println!("| a start outside contact | {audits:?} | {errors:?} |");
        // Measured: 4.2e-5 and 7.8e-8 at most.
        assert!(audits[0] < 1e-4 && audits[2] < 1e-6, "{audits:?}");
        assert!(
            errors[1] < 0.2 * errors[0] || errors[1] < 1e-9,
            "{errors:?}"
        );
    }
}

/// A kick of 1 m/s in a scene, and initial states with extreme energies.
#[test]
fn an_initial_state_with_extreme_energy() {
    assert_stable(&Case {
        name: "kick 1 m/s",
        changes: &[("start.kick_mm_per_s", "1000"), ("time.duration_ms", "2")],
        ..Case::default()
    });
    let scene = scene(&[("start.kick_mm_per_s", "1000")]);
    let joint = joint(&scene).with_audit();
    let m = joint.modes();
    for (size, is_stable) in [
        (10.0, true),
        (1e3, true),
        (1e9, false),
        (1e100, false),
        (1e150, false),
    ] {
        let mut start = squeakscope::pipeline::initial_state(&scene, m);
        start.iter_mut().for_each(|z| *z *= size);
        start.push(0.0);
        let energy = joint.energy(&start).total();
        for name in ["lawson54", "rodas5p", "auto"] {
            let (accuracy, max_step) = (accuracy(1e-5), 20e-6);
            let method = match name {
                "lawson54" => MethodName::Lawson54.with(accuracy, max_step),
                "rodas5p" => MethodName::Rodas5P.with(accuracy, max_step),
                _ => MethodName::Auto.with(accuracy, max_step),
            };
            let mut integrator = Integrator::new(method, &joint).unwrap();
            let end = integrator
                .start(0.0, &start)
                .and_then(|()| integrator.integrate_to(0.5e-3));
            let z = integrator.state();
            assert!(z.iter().all(|z| z.is_finite()), "{size:e}, {name}");
            let now = joint.energy(z).total();
            let audit = (now - energy - z[2 * m]).abs() / energy;
            let steps = integrator.stats().steps;
            println!("| a start of {size:.0e} m/s, {name} | {audit:.1e} | {steps} | {end:?} |");
            match end {
                // Measured: 3.3e-5.
                Ok(()) => assert!(
                    audit < 1e-3 && now < 1.1 * energy,
                    "{size:e}, {name}: {audit:e}"
                ),
                // An error with the last accepted state: the contact is crossed within the minimum step.
                Err(fault) => {
                    assert!(!is_stable, "{size:e}, {name}: {fault:?}");
                    let message = fault.to_string();
                    assert!(
                        matches!(fault, DynamicsError::StepUnderflow { time: 0.0, .. })
                            && message.contains("crosses the whole contact")
                            && message.contains("reduce the initial velocity"),
                        "{size:e}, {name}: {message}"
                    );
                }
            }
        }
    }
}

/// Kicks below the smallest normal number and other very small ones.
#[test]
fn denormal_kicks() {
    // 5e-321 mm/s is the smallest value that is not zero in m/s.
    for kick in ["5e-321", "1e-320", "1e-310", "1e-305", "1e-200", "1e-100"] {
        for method in [
            "lawson54",
            "lawson853",
            "tsit5",
            "dop853",
            "rodas5p",
            "auto",
        ] {
            let method = format!("\"{method}\"");
            let changes = [
                ("start.kick_mm_per_s", kick),
                ("time.duration_ms", "5"),
                ("time.method", method.as_str()),
            ];
            let result = run_scene(&scene(&changes));
            let size: f64 = kick.parse::<f64>().unwrap() * 1e-3;
            assert!(result.states().all(f64::is_finite));
            // The fastest growth rate is below 800 1/s: a factor of at most 55 for the kick of eleven
            // modes. Measured: 8.6 times the kick.
            let max_speed = result.max_speed(0.0);
            assert!(max_speed <= 55.0 * size, "{kick} {method}: {max_speed:e}");
            // 250 maximum steps, and a few initial ones.
            let steps = result.summary.stats.steps;
            assert!(steps < 270, "{kick} {method}: {steps}");
        }
    }
    assert!(joint(&scene(&[])).is_continuous());
}

/// A much too large step: a fixed step is rejected, also because of the contact stiffness; for an
/// adaptive method it is only the maximum, and the error controls the step.
#[test]
fn a_step_much_too_large() {
    let step = |changes: &[(&str, &str)]| {
        let fixed = [("time.method", "\"rk4\""), ("time.duration_ms", "1")];
        try_run(&scene(&[&fixed[..], changes].concat()))
    };
    for (changes, below) in [
        (&[("time.max_step_us", "1000")][..], 36.2),
        (
            &[
                ("time.max_step_us", "20"),
                ("contact.stiffness_factor", "1e4"),
            ][..],
            1.3,
        ),
        // Friction damps faster than the modes vibrate: 1e6 1/s and more.
        (
            &[
                ("time.max_step_us", "20"),
                ("rotation.angular_velocity_rad_per_s", "[0, 0, 0]"),
            ][..],
            2.5,
        ),
    ] {
        let fault = step(changes).err().unwrap();
        let PipelineError::Step { limit_us, .. } = fault else {
            panic!("{fault:?}")
        };
        assert!(limit_us < below && limit_us > 0.3 * below, "{limit_us}");
        let message = fault.to_string();
        assert!(message.contains("set time.max_step_us below"), "{message}");
        // Slightly below the limit the run succeeds and stays bounded.
        let just_below = format!("{}", 0.9 * limit_us);
        let mut changed = changes.to_vec();
        changed.push(("time.max_step_us", &just_below));
        let result = step(&changed).unwrap();
        assert!(result.states().all(|x| x.is_finite() && x.abs() < 1.0));
    }
    let omega = joint(&scene(&[])).omega().to_vec();
    let kicks = [
        "0.96", "0.97", "0.98", "0.99", "1", "1.01", "1.02", "1.03", "1.04",
    ];
    let errors = kicks.map(|kick| {
        let [usual, enormous] = ["20", "1000"].map(|step| {
            run_scene(&scene(&[
                ("time.max_step_us", step),
                ("start.kick_mm_per_s", kick),
            ]))
        });
        // The error limits the steps, not the maximum step.
        assert!(2 * enormous.summary.stats.steps > usual.summary.stats.steps);
        distance(&omega, &enormous.final_state(), &usual.final_state())
    });
    let error = geometric_mean(&errors);
    println!("| a maximum step of 1 ms | {error:.1e} |");
    // Two runs with an error of at most the tolerance in each of 2844 steps, 0.06.
    assert!(error < 1e-4, "{error:e}");
}
