//! Kinks and jumps that come together, hardly at all, or without end; and starts far from anything seen.

use squeakscope::dynamics::{Accuracy, DynamicsError, Integrator, Method, Switching, System};
use squeakscope::joint::{ContactDamping, Friction, Joint, Model};
use squeakscope::pipeline::PipelineError;
use squeakscope::scene::Scene;
use squeakscope::systems::ImpactOscillator;

use super::{Case, distance, holds, joint, scene, try_watch, watch};

/// As scenes have it: the power of friction has rounding noise that does not vanish with the state.
fn accuracy(tolerance: f64) -> Accuracy {
    Accuracy {
        floor: 1e-12,
        ..Accuracy::relative(tolerance)
    }
}

fn lawson(tolerance: f64) -> Method {
    Method::Lawson54 {
        accuracy: Accuracy::relative(tolerance),
        max_step: 0.1,
    }
}

/// A mass pressed onto one contact spring, all in units of one, frictionless: `q'' = -2 q` while it
/// presses (`q > -1`), `q'' = 1 - q` while it is off.
fn pressed() -> Joint {
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

/// The contact just opens, or just does not, a hundred times.
#[test]
fn grazing_contact() {
    let joint = pressed();
    let period = std::f64::consts::TAU / 2.0_f64.sqrt();
    for depth in [-1e-3, -1e-9, -1e-15, 0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3] {
        let start = [1.0 + depth, 0.0];
        let energy = joint.energy(&start).total();
        let [through, exact] = [false, true].map(|stops| {
            let mut integrator = Integrator::new(lawson(1e-10), &joint).unwrap();
            if stops {
                integrator = integrator.with_events(&joint).unwrap();
            }
            integrator.start(&joint, 0.0, &start).unwrap();
            integrator.land(&joint, 100.0 * period).unwrap();
            // Some 5000 steps of the tolerance, in each run.
            let kept = joint.energy(integrator.state()).total() / energy - 1.0;
            assert!(kept.abs() < 1e-6, "{depth:e}: {kept:e}");
            integrator
        });
        let off = distance(joint.omega(), through.state(), exact.state());
        assert!(off < 1e-6, "{depth:e}: {off:e}");
        let tally = exact.tally();
        println!(
            "| grazing contact, depth {depth:.0e} | {off:.1e} | {} |",
            tally.crossings
        );
        assert_eq!(tally.overrun, 0, "{depth:e}: {tally:?}");
        assert!(tally.crossings <= 200, "{depth:e}: {tally:?}");
        match depth {
            d if d >= 1e-6 => assert_eq!(tally.crossings, 200, "{depth:e}: {tally:?}"),
            d if d <= -1e-9 => assert_eq!(tally.crossings, 0, "{depth:e}: {tally:?}"),
            // Deeper or not by less than the errors of the steps: either is right.
            _ => {}
        }
        if depth <= 1e-12 {
            // As if the contact could not open.
            let linear = [start[0], 0.0];
            let off = distance(joint.omega(), exact.state(), &linear);
            assert!(off < 1e-6, "{depth:e}: {off:e}");
        }
    }
}

/// The wall is where the free vibration turns: it is touched at no speed, or hardly any.
#[test]
fn grazing_impacts() {
    for depth in [-1e-12, 0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
        let system = ImpactOscillator {
            omega: 1.0,
            damping: 0.0,
            drive: 0.0,
            drive_omega: 0.0,
            wall: -1.0 + depth,
            restitution: 0.8,
        };
        let integrator = Integrator::new(lawson(1e-10), &system).unwrap();
        let mut integrator = integrator.with_events(&system).unwrap();
        integrator.start(&system, 0.0, &[1.0, 0.0]).unwrap();
        let t = 20.0 * std::f64::consts::TAU;
        integrator.land(&system, t).unwrap();
        let z = integrator.state();
        // An impact comes with a phase of sqrt(2 depth) before the turn and leaves with 0.8 of that after
        // it: twenty turn the motion round by 51 sqrt(depth). The amplitude becomes that of the wall.
        let off = (z[0] - 1.0).hypot(z[1]);
        println!(
            "| grazing impacts, depth {depth:.0e} | {off:.1e} | {} |",
            integrator.tally().crossings
        );
        // A wall that is out of reach by less than rounding may be touched all the same.
        let depth = f64::max(depth, 1e-14);
        assert!(off < 60.0 * depth.sqrt(), "{depth:e}: {z:?}");
        assert!(integrator.tally().crossings <= 20 * 3, "{depth:e}");
    }
}

/// Rings of nodes that open at the same instant, by symmetry, are one event each, not one a node.
#[test]
fn simultaneous_crossings_by_symmetry() {
    let changes = [
        ("body.bending_pairs", "0"),
        ("body.torsion", "0"),
        ("load.tilt_deg", "0"),
        ("contact.quadrature", "\"gauss\""),
        ("start.kick_mm_per_s", "100"),
        ("time.duration_ms", "2"),
        ("time.events", "\"exact\""),
    ];
    let seen = holds(&Case {
        name: "simultaneous crossings by symmetry",
        changes: &changes,
        ..Case::default()
    });
    let tally = seen.summary.tally;
    // A hundred nodes in four rings.
    assert!(tally.crossings > 500 && tally.overrun == 0, "{tally:?}");
    assert!(tally.crossings >= 20 * tally.events, "{tally:?}");
}

fn impacts(wall_um: f64, drive: f64, restitution: f64) -> Scene {
    let text = format!(
        "[impact_oscillator]\nfrequency_hz = 200\ndrive_m_per_s2 = {drive}\ndrive_frequency_hz = 130\n\
         wall_um = {wall_um}\nrestitution = {restitution}\n[start]\nposition_um = 200\n\
         kick_mm_per_s = 0\n[time]\nduration_ms = 500\nsample_rate_khz = 20\ntolerance = 1e-9\n\
         max_step_us = 200\n"
    );
    Scene::parse("impacts", text).unwrap()
}

/// Bounces that add up to rest in a finite time, again and again: an infinity of events that must end.
#[test]
fn endless_chatter_of_the_impact_oscillator() {
    for restitution in [0.0, 0.3, 0.7, 0.9, 0.99, 1.0] {
        for drive in [0.0, 150.0, 400.0] {
            let scene = impacts(100.0, drive, restitution);
            let seen = watch(&scene);
            let states: Vec<f64> = seen.states().collect();
            assert!(states.iter().all(|x| x.is_finite() && x.abs() < 10.0));
            for frame in &seen.frames {
                let lowest = frame.q.iter().copied().fold(f64::INFINITY, f64::min);
                assert!(lowest >= 100e-6 - 1e-15, "{restitution} {drive}: {lowest}");
            }
            let statuses = seen.frames.iter().flat_map(|frame| &frame.status);
            let rests: Vec<bool> = statuses
                .map(|status| *status == ImpactOscillator::RESTING)
                .collect();
            let times = rests.windows(2).filter(|pair| !pair[0] && pair[1]).count();
            let transitions = seen.summary.transitions;
            let name = format!("{restitution} {drive}");
            println!(
                "| endless chatter, restitution {restitution}, drive {drive} m/s^2 | {times} | {transitions} |"
            );
            match (restitution, drive) {
                // Elastic and not driven it never rests, and keeps its energy to what the steps may err by.
                (1.0, 0.0) => {
                    let omega = 200.0 * std::f64::consts::TAU;
                    let end = seen.last();
                    let energy = (omega * end[0]).powi(2) + end[1].powi(2);
                    let start = (omega * 200e-6_f64).powi(2);
                    let allowed = 2e-9 * seen.summary.tally.steps as f64;
                    assert!((energy / start - 1.0).abs() < allowed, "{name}");
                    assert_eq!(times, 0, "{name}");
                }
                // Pressed against the wall all the time (158 m/s^2, less the drive), it comes to rest there
                // once, and for good.
                (r, drive) if r < 1.0 && drive < 158.0 => {
                    assert_eq!(seen.last(), [100e-6, 0.0], "{name}");
                    assert_eq!(times, 1, "{name}");
                }
                // Drawn off once in each of the 65 periods, it comes to rest as often, where it loses enough
                // in a bounce.
                (r, 400.0) if r < 0.5 => assert_eq!(times, 65, "{name}"),
                // Else it bounces on, and is back at least once a period.
                _ => assert!(transitions >= 65, "{name}: {transitions}"),
            }
        }
    }
}

/// Bounces a million times shorter than the steps, of a mass pressed with 4e10 times its weight: between
/// two impacts the wall is left by so little, for so short a time, that rounding soon is all that is seen.
#[test]
fn bounces_far_shorter_than_the_steps() {
    let omega = std::f64::consts::TAU * 1e5;
    let system = ImpactOscillator {
        omega,
        damping: 0.0,
        drive: 0.0,
        drive_omega: 0.0,
        wall: 1.0,
        restitution: 0.5,
    };
    let (accuracy, max_step) = (accuracy(1e-6), 20e-6);
    for method in [
        Method::Lawson54 { accuracy, max_step },
        Method::Lawson853 { accuracy, max_step },
        Method::Tsit54 { accuracy, max_step },
        Method::Dop853 { accuracy, max_step },
        Method::Rodas5p { accuracy, max_step },
        Method::Auto { accuracy, max_step },
    ] {
        let integrator = Integrator::new(method, &system).unwrap();
        let mut integrator = integrator.with_events(&system).unwrap();
        let (press, speed) = (omega * omega, 12.0);
        integrator.start(&system, 0.0, &[1.0, -speed]).unwrap();
        while integrator.status() == [ImpactOscillator::FLYING] {
            integrator.next_event(&system, 1e-9).unwrap();
            assert!(integrator.time() < 1e-9, "{method:?} must come to rest");
        }
        // Each flight lasts half as long as the one before: the first, 2 v / press, twice in all. Left out
        // is what 85 units in the last place of the wall's height are: 0.12 m/s.
        let first = 2.0 * 0.5 * speed / press;
        let off = (integrator.time() - 2.0 * first).abs();
        let impacts = integrator.tally().crossings;
        println!("| bounces far shorter than the steps | {off:.1e} s | {impacts} |");
        assert!(off < 2.0 * 2.0 * 0.12 / press, "{method:?}: {off:e}");
        // The speed halves from 12 to 0.12 m/s in seven; the last comes to rest.
        assert!(impacts <= 8, "{method:?}: {impacts}");
        integrator.land(&system, 1e-3).unwrap();
        assert_eq!(integrator.state(), [1.0, 0.0], "{method:?}");
    }
}

/// Behind the wall there is no start: the scene says so.
#[test]
fn a_start_behind_the_wall_is_refused() {
    let text = impacts(100.0, 0.0, 0.5)
        .text
        .replace("position_um = 200", "position_um = 99");
    let refused = Scene::parse("impacts", text).unwrap_err().to_string();
    assert!(refused.contains("behind the wall at 100 um"), "{refused}");
}

/// Ball and socket start apart, a hundred times as far as the load presses them together.
#[test]
fn a_start_outside_contact() {
    let scene = scene(&[
        ("body.bending_pairs", "0"),
        ("body.torsion", "0"),
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
        let method = Method::Auto {
            accuracy: accuracy(tolerance),
            max_step: 20e-6,
        };
        [false, true].map(|stops| {
            let mut integrator = Integrator::new(method, &joint).unwrap();
            if stops {
                integrator = integrator.with_events(&joint).unwrap();
            }
            integrator.start(&joint, 0.0, &start).unwrap();
            integrator.land(&joint, 2e-3).unwrap();
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

/// A kick of a metre a second in a scene, and starts with energies that no joint survives.
#[test]
fn a_start_with_huge_energy() {
    holds(&Case {
        name: "kick 1 m/s",
        changes: &[("start.kick_mm_per_s", "1000"), ("time.duration_ms", "2")],
        ..Case::default()
    });
    let scene = scene(&[("start.kick_mm_per_s", "1000")]);
    let joint = joint(&scene).with_audit();
    let m = joint.modes();
    for (size, survives) in [
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
                "lawson54" => Method::Lawson54 { accuracy, max_step },
                "rodas5p" => Method::Rodas5p { accuracy, max_step },
                _ => Method::Auto { accuracy, max_step },
            };
            let mut integrator = Integrator::new(method, &joint).unwrap();
            let end = integrator
                .start(&joint, 0.0, &start)
                .and_then(|()| integrator.land(&joint, 0.5e-3));
            let z = integrator.state();
            assert!(z.iter().all(|z| z.is_finite()), "{size:e}, {name}");
            let now = joint.energy(z).total();
            let audit = (now - energy - z[2 * m]).abs() / energy;
            let steps = integrator.tally().steps;
            println!("| a start of {size:.0e} m/s, {name} | {audit:.1e} | {steps} | {end:?} |");
            match end {
                // Measured: 3.3e-5.
                Ok(()) => assert!(
                    audit < 1e-3 && now < 1.1 * energy,
                    "{size:e}, {name}: {audit:e}"
                ),
                // A clear end, with the last good state: it crosses the contact within the shortest step.
                Err(fault) => {
                    assert!(!survives, "{size:e}, {name}: {fault:?}");
                    let said = fault.to_string();
                    assert!(
                        matches!(fault, DynamicsError::StepUnderflow { time: 0.0, .. })
                            && said.contains("crosses the contact")
                            && said.contains("start with less"),
                        "{size:e}, {name}: {said}"
                    );
                }
            }
        }
    }
}

/// Kicks below the smallest normal number, and far below anything that has a meaning.
#[test]
fn denormal_kicks() {
    // 5e-321 mm/s is the smallest that is not zero in m/s.
    for kick in ["5e-321", "1e-320", "1e-310", "1e-305", "1e-200", "1e-100"] {
        for method in [
            "lawson54",
            "lawson853",
            "tsit54",
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
            let seen = watch(&scene(&changes));
            let size: f64 = kick.parse::<f64>().unwrap() * 1e-3;
            assert!(seen.states().all(f64::is_finite));
            // The fastest growth is below 800 1/s: a factor of 55 at most, of kicks of eleven modes. Measured:
            // 8.6 times the kick.
            let loudest = seen.loudest(0.0);
            assert!(loudest <= 55.0 * size, "{kick} {method}: {loudest:e}");
            // 250 of the longest steps, and a few to find that they will do.
            let steps = seen.summary.tally.steps;
            assert!(steps < 270, "{kick} {method}: {steps}");
        }
    }
    assert!(joint(&scene(&[])).is_continuous());
}

/// A step far too large asked for by the user: a fixed one is refused, by the contact's stiffness too; an
/// adaptive one is only the largest, and the error decides.
#[test]
fn a_step_far_too_large() {
    let step = |changes: &[(&str, &str)]| {
        let fixed = [("time.method", "\"rk4\""), ("time.duration_ms", "1")];
        try_watch(&scene(&[&fixed[..], changes].concat()))
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
            &[("time.max_step_us", "20"), ("rotation.rad_s", "[0, 0, 0]")][..],
            2.5,
        ),
    ] {
        let fault = step(changes).err().unwrap();
        let PipelineError::Step { limit_us, .. } = fault else {
            panic!("{fault:?}")
        };
        assert!(limit_us < below && limit_us > 0.3 * below, "{limit_us}");
        let said = fault.to_string();
        assert!(said.contains("choose time.max_step_us below"), "{said}");
        // Just below, the run goes, and stays bounded.
        let just_below = format!("{}", 0.9 * limit_us);
        let mut fitting = changes.to_vec();
        fitting.push(("time.max_step_us", &just_below));
        let seen = step(&fitting).unwrap();
        assert!(seen.states().all(|x| x.is_finite() && x.abs() < 1.0));
    }
    let [usual, enormous] = ["20", "1000"].map(|step| {
        watch(&scene(&[
            ("time.max_step_us", step),
            ("start.kick_mm_per_s", "1"),
        ]))
    });
    let omega = joint(&scene(&[])).omega().to_vec();
    let off = distance(&omega, &enormous.last(), &usual.last());
    println!(
        "| a largest step of 1 ms | {off:.1e} | {} |",
        enormous.summary.tally.steps
    );
    // Two runs that may err by the tolerance in each of 2844 steps, 0.06; measured: 1.0e-5.
    assert!(off < 1e-4, "{off:e}");
    // It is the error that keeps the steps short, not the limit.
    assert!(2 * enormous.summary.tally.steps > usual.summary.tally.steps);
}
