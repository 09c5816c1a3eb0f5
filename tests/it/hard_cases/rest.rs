//! Steady sliding, creep and sticking: sliding velocities at or near zero.

use std::f64::consts::TAU;

use squeakscope::dynamics::equilibrium::Linearised;
use squeakscope::dynamics::{Accuracy, Integrator, MethodName, System};
use squeakscope::joint::{BallJoint, ContactDamping, Friction, Joint, Model, Stribeck};
use squeakscope::pipeline::message::NodeState;

use super::{Case, assert_stable, joint, run_scene, scene};

const AT_REST: (&str, &str) = ("rotation.angular_velocity_rad_per_s", "[0, 0, 0]");

/// A ball that does not rotate: nothing slides, friction is regularised to mu(0) = 0 and only damps.
#[test]
fn rotation_exactly_zero() {
    let sliding = joint(&scene(&[]));
    let resting = joint(&scene(&[AT_REST]));
    let m = resting.modes();
    let rest = vec![0.0; m];
    for node in 0..resting.contact_nodes() {
        let action = resting.node_action(node, &rest, &rest, &[]);
        assert_eq!(action.speed, 0.0);
        assert_eq!(action.friction, [0.0; 3].map(|x: f64| -x));
        // The whole creep region counts as sticking: there is no steady sliding as reference.
        assert_eq!(resting.stick_speed(node), 1e-3);
    }
    // No steady friction: the equilibrium is that of the load alone.
    let load_alone = joint(&scene(&[
        AT_REST,
        ("friction.mu_s", "0"),
        ("friction.mu_d", "0"),
    ]));
    let (with, without) = (resting.equilibrium(), load_alone.equilibrium());
    let error = with.force.iter().zip(&without.force);
    assert!(
        error
            .into_iter()
            .all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs().max(1.0))
    );
    assert_ne!(with.force, sliding.equilibrium().force);
    let linear = resting.linear_modes().unwrap();
    assert!(linear.iter().all(|mode| !mode.unstable()), "{linear:?}");
    // The explanation of the growth rates includes friction although it has no direction.
    let tilted = scene(&[AT_REST]).joint().unwrap().clone();
    let ball = BallJoint::new(&tilted.spec).unwrap();
    let explained = ball.model(tilted.tilt.at(0.0)).unwrap().explained_modes();
    for mode in explained.unwrap() {
        let close = linear.iter().any(|linear| {
            let omega = TAU * linear.frequency_hz;
            let error = (TAU * mode.frequency_hz - omega).hypot(mode.growth_per_s - linear.growth);
            error < 1e-6 * omega.hypot(linear.growth)
        });
        let shares: f64 = mode.causes.iter().map(|cause| cause.share_per_s).sum();
        assert!(close && mode.growth_per_s < 0.0, "{mode:?} of {linear:?}");
        assert!((shares / mode.growth_per_s - 1.0).abs() < 1e-6, "{mode:?}");
    }

    for method in ["lawson54", "auto", "rodas5p", "dop853"] {
        let name = format!("rotation exactly zero, {method}");
        let method = format!("\"{method}\"");
        let result = assert_stable(&Case {
            name: &name,
            changes: &[
                AT_REST,
                ("start.kick_mm_per_s", "10"),
                ("time.method", &method),
            ],
            ..Case::default()
        });
        // Friction always dissipates energy, and the remaining motion creeps to rest. The slowest linear
        // mode alone, 166 1/s, would keep 1.3e-3 of the energy after 20 ms; 1.1e-5 measured, and 1.5e-4
        // of the speed.
        let energies: Vec<_> = result.energies().collect();
        let start = energies[0][0];
        for pair in energies.windows(2) {
            assert!(pair[1][0] <= pair[0][0] + 1e-5 * start, "{name}: {pair:?}");
        }
        assert!(energies.last().unwrap()[0] < 1.3e-3 * start, "{name}");
        assert!(
            result.max_speed(0.015) < 1e-3 * result.max_speed(0.0),
            "{name}"
        );
        let snapshots = result.frames.last().unwrap().patch.iter();
        let states: Vec<_> = snapshots.flat_map(|patch| &patch.states).collect();
        assert!(
            states.iter().all(|state| **state == NodeState::Stick),
            "{name}"
        );
    }
}

/// A kick of zero: the state stays bitwise zero, sliding or resting, with every method.
#[test]
fn a_kick_of_zero() {
    for rotation in ["[0, 0, 0]", "[0.7, 0.7, 0]", "[0, 1e-6, 0.5]"] {
        for method in [
            "lawson54",
            "lawson853",
            "tsit5",
            "dop853",
            "rodas5p",
            "auto",
            "rk4",
        ] {
            for events in ["\"through\"", "\"exact\""] {
                let method = format!("\"{method}\"");
                let result = run_scene(&scene(&[
                    ("rotation.angular_velocity_rad_per_s", rotation),
                    ("start.kick_mm_per_s", "0"),
                    ("time.method", &method),
                    ("time.max_step_us", "2"),
                    ("time.events", events),
                    ("time.duration_ms", "2"),
                ]));
                assert!(result.states().all(|x| x == 0.0), "{method} {rotation}");
                assert!(
                    result.energies().flatten().all(|x| x == 0.0),
                    "{method} {rotation}"
                );
                assert_eq!(result.summary.energy_residual, Some(0.0));
            }
        }
    }
}

/// A mass on a belt at 0.2 m/s with the friction of Eq. (5) and unit parameters.
fn belt(creep: f64) -> Joint {
    Joint::new(&Model {
        positions: vec![[0.0, 0.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0]],
        areas: vec![1.0],
        pre_stress: vec![1.0],
        stiffness: vec![1.0],
        shapes: vec![[1.0, 0.0, 0.0]],
        omega: vec![1.0],
        damping: vec![],
        sliding_velocity: vec![[-0.2, 0.0, 0.0]],
        friction: Friction::Stribeck {
            law: Stribeck {
                mu_s: 1.0,
                mu_d: 0.5,
                creep,
                stribeck: 10.0,
            },
            radial: true,
        },
        unilateral: true,
        contact_damping: ContactDamping::None,
        convection: None,
        probe: vec![1.0],
    })
}

/// The sliding velocity is exactly zero at the start and changes its sign repeatedly.
#[test]
fn slip_velocity_exactly_zero() {
    for creep in [1e2, 1e4, 1e6, 1e8] {
        let joint = belt(creep);
        // The mass moves with the belt: the sliding velocity is bitwise zero.
        let action = joint.node_action(0, &[0.3], &[0.2], &[]);
        assert_eq!((action.speed, action.friction), (0.0, [-0.0, -0.0, -0.0]));
        // Only the spring force minus the steady friction acts. The slope is that of the law at zero
        // speed, mu'(0) = creep mu_s.
        let steady = joint.equilibrium().force[0];
        let z = [0.0, 0.2];
        let mut force = [0.0];
        joint.force(0.0, &z, &mut force);
        assert_eq!(force[0], -steady);
        let slope = Linearised::at(&joint, None, 0.0, &z).matrix[(1, 1)];
        assert!((slope / -creep - 1.0).abs() < 1e-12, "{slope}");

        // The errors must be small compared with the creep speed, not only with the motion.
        let accuracy = Accuracy::relative(1e-9);
        let max_step = 0.05;
        let run = |method| {
            let mut integrator = Integrator::new(method, &joint).unwrap();
            integrator.start(0.0, &z).unwrap();
            integrator.integrate_to(10.0).unwrap();
            (integrator.state().to_vec(), integrator.stats())
        };
        let (implicit, work) = run(MethodName::Rodas5P.with(accuracy, max_step));
        let (auto, both) = run(MethodName::Auto.with(accuracy, max_step));
        assert!(implicit.iter().all(|x| x.abs() < 1.0), "{implicit:?}");
        let error = (auto[0] - implicit[0]).hypot(auto[1] - implicit[1]);
        println!(
            "| slip velocity exactly zero, creep {creep:.0e} | {error:.1e} | {} | {} |",
            work.steps, both.steps
        );
        // The accumulated tolerance of both runs.
        let allowed = accuracy.relative * (work.steps + both.steps) as f64;
        assert!(error < allowed, "{creep}: {auto:?} {implicit:?}");
        // Measured: at most 451 and 821.
        assert!(
            work.steps < 1000 && both.steps < 2000,
            "{creep}: {work:?} {both:?}"
        );
    }
}

/// A ball that hardly rotates: after the kick the patch sticks for the remaining time.
#[test]
fn rotation_of_one_microradian_per_second() {
    for kick in ["0.01", "10"] {
        let name = format!("rotation 1e-6 rad/s, kick {kick} mm/s");
        let result = assert_stable(&Case {
            name: &name,
            changes: &[
                (
                    "rotation.angular_velocity_rad_per_s",
                    "[7.07e-7, 7.07e-7, 0]",
                ),
                ("start.kick_mm_per_s", kick),
                ("time.method", "\"auto\""),
            ],
            ..Case::default()
        });
        // Friction is nearly fully developed at the creep speed, 1 mm/s: a tenth of it balances a tenth
        // of that speed, and the node sticks. Measured: 3.9e-5 and 2.8e-8 m/s.
        assert!(
            result.max_speed(0.010) < 1e-4,
            "{name}: {:e}",
            result.max_speed(0.010)
        );
        assert!(result.summary.stats.switches > 0, "{name}");
    }
}

/// A slow ball and steeply falling friction: the joint sticks, breaks loose, and sticks again, for most
/// of each period.
#[test]
fn sticking_for_most_of_a_period() {
    let changes = [
        ("rotation.angular_velocity_rad_per_s", "[0.0071, 0.0071, 0]"),
        ("friction.creep_slope_s_per_m", "1e6"),
        ("friction.stribeck_slope_s_per_m", "1000"),
        ("time.method", "\"auto\""),
        ("time.duration_ms", "30"),
    ];
    let result = assert_stable(&Case {
        name: "sticking for most of a period",
        changes: &changes,
        ..Case::default()
    });
    let joint = joint(&scene(&changes));
    let m = joint.modes();
    let sliding = joint
        .node_action(0, &vec![0.0; m], &vec![0.0; m], &[])
        .speed;
    let speeds: Vec<f64> = result
        .frames
        .iter()
        .filter(|frame| frame.t0 > 0.010)
        .flat_map(|frame| {
            let states = frame.q.chunks(m).zip(frame.qdot.chunks(m));
            states.map(|(q, v)| joint.node_action(0, q, v, &[]).speed)
        })
        .collect();
    // Sticking means creeping at a small fraction of the speed of steady sliding.
    let stuck = speeds
        .iter()
        .filter(|speed| **speed < 0.1 * sliding)
        .count();
    let share = stuck as f64 / speeds.len() as f64;
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    println!(
        "| sticking for most of a period | {share:.2} of the time, then up to {:.0} times the speed of steady sliding |",
        fastest / sliding
    );
    assert!(share > 0.5, "{share}");
    assert!(
        fastest > 10.0 * sliding,
        "the joint must break loose: {fastest:e} m/s, steady sliding {sliding:e} m/s"
    );
}
