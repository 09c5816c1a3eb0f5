//! Event location at jumps: impacts, stick-slip, separation from a damped contact.

use super::closed_form::Oscillator;
use super::events::run_exact;
use super::*;
use squeakscope_joint::systems::{DampedContact, ImpactOscillator, MassOnBelt};

pub const BOUNCING: ImpactOscillator = ImpactOscillator {
    omega: 1.0,
    damping: 0.02,
    drive: 1.0,
    drive_omega: 2.8,
    drive_phase: 0.0,
    wall: 0.0,
    restitution: 0.8,
};

/// Closed-form motion of an [`ImpactOscillator`] between impacts.
fn free_motion(sys: &ImpactOscillator) -> Oscillator {
    Oscillator {
        decay: sys.damping * sys.omega,
        stiffness: sys.omega * sys.omega,
        drive: sys.drive,
        drive_omega: sys.drive_omega,
    }
}

#[test]
fn a_hundred_impacts_agree_with_the_closed_form() {
    let free_motion = free_motion(&BOUNCING);
    for method in &adaptive_methods(1e-11, 0.2) {
        let mut integrator = run_exact(*method, &BOUNCING, &[0.5, 0.0], 0.0);
        let (mut t, mut z) = (0.0, [0.5, 0.0]);
        for impact in 0..100 {
            integrator.next_event(t + 50.0).unwrap();
            let now = integrator.time();
            let exact = free_motion
                .fall(t, z, t + 50.0, 1.0, 0.0)
                .expect("an impact");
            assert!((now - exact).abs() < 1e-8, "{impact}: {now} for {exact}");
            let before = free_motion.at(t, z, exact);
            let state = integrator.state();
            assert_eq!(state[0], 0.0);
            assert!(
                (state[1] + 0.8 * before[1]).abs() < 1e-8,
                "{state:?} {before:?}"
            );
            // Continue from the computed state, because impacts amplify any difference.
            (t, z) = (now, [state[0], state[1]]);
        }
    }
}

/// The state of [`BOUNCING`] at time `end`, by closed-form motion from impact to impact.
pub fn bouncing_exact(z0: [f64; 2], end: f64) -> [f64; 2] {
    let free_motion = free_motion(&BOUNCING);
    let (mut t, mut z) = (0.0, z0);
    while let Some(impact) = free_motion.fall(t, z, end, 1.0, 0.0) {
        z = [0.0, -0.8 * free_motion.at(t, z, impact)[1]];
        t = impact;
    }
    free_motion.at(t, z, end)
}

#[test]
fn a_ball_comes_to_rest_at_the_sum_of_its_bounce_times() {
    // Twice the time of fall for each bounce: a geometric series.
    let rest = (2.0 * 1.3 / 9.81_f64).sqrt() * (1.0 + 0.8) / (1.0 - 0.8);
    // With the wall at zero, exact to the rounding of the time; otherwise to that of the wall position,
    // on which the time depends by a square root.
    for (wall, allowed) in [(0.0, 1e-11), (-0.3, 1e-6)] {
        let ball = ImpactOscillator {
            omega: 0.0,
            damping: 0.0,
            drive: -9.81,
            drive_omega: 0.0,
            drive_phase: 0.0,
            wall,
            restitution: 0.8,
        };
        for method in all_methods(1e-9, 0.5, 0.05) {
            let mut integrator = run_exact(method, &ball, &[wall + 1.3, 0.0], 0.0);
            while integrator.status() == [ImpactOscillator::FLYING] {
                integrator.next_event(10.0).unwrap();
                assert!(integrator.time() < 10.0, "bouncing must end");
            }
            let error = (integrator.time() - rest).abs();
            assert!(error < allowed, "{method:?}: {error:e}");
            let mut z = [0.0; 2];
            for k in 0..10 {
                let t = 5.0 + 0.5 * f64::from(k);
                integrator.sample(t, &mut z).unwrap();
                assert_eq!(z, [wall, 0.0]);
            }
            let bounces = integrator.stats().events;
            assert!((50..300).contains(&bounces), "{bounces}");
        }
    }
}

#[test]
fn a_resting_mass_separates_when_the_contact_force_vanishes() {
    let sys = ImpactOscillator {
        omega: 1.0,
        damping: 0.05,
        drive: -1.0,
        drive_omega: 0.5,
        drive_phase: 0.0,
        wall: 0.2,
        restitution: 0.5,
    };
    // The contact force per unit mass is omega^2 wall - a cos(W t).
    let release = (-0.2_f64).acos() / 0.5;
    for method in all_methods(1e-9, 0.5, 0.01) {
        let mut integrator = run_exact(method, &sys, &[0.2, 0.0], 0.0);
        assert_eq!(integrator.status(), [ImpactOscillator::RESTING]);
        integrator.next_event(10.0).unwrap();
        assert_eq!(integrator.status(), [ImpactOscillator::FLYING]);
        assert!((integrator.time() - release).abs() < 1e-13);
        assert_eq!(integrator.state(), [0.2, 0.0]);
        let t = integrator.time();
        integrator.integrate_to(t + 2.0).unwrap();
        let exact = free_motion(&sys).at(t, [0.2, 0.0], t + 2.0);
        assert!(distance(integrator.state(), &exact) < 1e-8);
        assert_eq!(integrator.stats().events, 1, "{method:?}");
    }
}

const BELT: MassOnBelt = MassOnBelt {
    omega: 1.0,
    damping: 0.0,
    load: 1.0,
    mu_s: 1.0,
    mu_d: 0.5,
    belt: 0.2,
    stribeck: None,
};

#[test]
fn stick_and_slip_durations_agree_with_the_closed_form() {
    let slip = 2.0 * (std::f64::consts::PI - (0.5 / 0.2_f64).atan());
    assert!((slip - 3.9026054).abs() < 5e-8);
    for method in all_methods(1e-12, 0.1, 1e-3) {
        // It starts sticking, with the spring unloaded.
        let mut integrator = run_exact(method, &BELT, &[0.0, 0.2], 0.0);
        assert_eq!(integrator.status(), [MassOnBelt::STICKING]);
        integrator.next_event(20.0).unwrap();
        assert!((integrator.time() - 5.0).abs() < 1e-10);
        for _ in 0..5 {
            let released = integrator.time();
            assert_eq!(integrator.status(), [MassOnBelt::SLOWER]);
            assert!((integrator.state()[0] - 1.0).abs() < 1e-10);
            integrator.next_event(released + 20.0).unwrap();
            let caught = integrator.time();
            assert_eq!(integrator.status(), [MassOnBelt::STICKING]);
            assert!((caught - released - slip).abs() < 1e-9, "{method:?}");
            // 2 D / belt = 5 s; the mass follows the belt exactly.
            let x = integrator.state()[0];
            assert!(x.abs() < 1e-9, "{x}");
            let mut z = [0.0; 2];
            for k in 1..50 {
                let t = caught + 0.1 * f64::from(k);
                integrator.sample(t, &mut z).unwrap();
                assert_eq!(
                    z[1], 0.2,
                    "the velocity must equal that of the belt bitwise"
                );
                assert!((z[0] - x - 0.2 * (t - caught)).abs() < 1e-10);
            }
            integrator.next_event(caught + 20.0).unwrap();
            assert!((integrator.time() - caught - 5.0).abs() < 1e-9);
        }
    }
}

#[test]
fn the_slip_amplitude_agrees_with_the_closed_form() {
    let [lawson, ..] = all_methods(1e-12, 0.1, 1e-3);
    let mut integrator = run_exact(lawson, &BELT, &[0.0, 0.2], 0.0);
    let mut z = [0.0; 2];
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..=89_026 {
        integrator
            .sample(5.0 + 1e-4 * f64::from(k), &mut z)
            .unwrap();
        low = low.min(z[0]);
        high = high.max(z[0]);
    }
    let amplitude = (0.5_f64.powi(2) + 0.2_f64.powi(2)).sqrt();
    assert!((amplitude - 0.5385165).abs() < 5e-8);
    assert!(
        (0.5 * (high - low) - amplitude).abs() < 1e-8,
        "{low} {high}"
    );
}

pub const DAMPED: DampedContact = DampedContact {
    omega: 1.0,
    damping: 0.05,
    drive: 0.8,
    drive_omega: 1.7,
    drive_phase: 0.0,
    contact_stiffness: 9.0,
    contact_damping: 1.2,
};

/// The state of [`DAMPED`] at time `end`, by the closed form of each contact and each free phase.
pub fn damped_exact(z0: [f64; 2], end: f64) -> [f64; 2] {
    let free = Oscillator {
        decay: 0.05,
        stiffness: 1.0,
        drive: 0.8,
        drive_omega: 1.7,
    };
    let touching = Oscillator {
        decay: 0.05 + 0.6,
        stiffness: 10.0,
        ..free
    };
    let (mut t, mut z, mut touches) = (0.0, z0, z0[0] < 0.0);
    loop {
        let (law, sign) = if touches {
            (touching, -1.0)
        } else {
            (free, 1.0)
        };
        let Some(event) = law.fall(t, z, end, sign, 0.0) else {
            return law.at(t, z, end);
        };
        z = law.at(t, z, event);
        (t, touches) = (event, !touches);
    }
}

#[test]
fn grazing_is_distinguished_from_crossing() {
    // x = speed sin(t): its minimum is -speed.
    let sys = ImpactOscillator {
        omega: 1.0,
        damping: 0.0,
        drive: 0.0,
        drive_omega: 0.0,
        drive_phase: 0.0,
        wall: -0.7,
        restitution: 0.8,
    };
    for step in [0.1, 0.33, 0.5, 1.0] {
        let [lawson, ..] = all_methods(1e-9, step, step);
        let stats = |speed: f64| run_exact(lawson, &sys, &[0.0, speed], 6.0).stats();
        for depth in [1e-9, 1e-6, 1e-3] {
            let above = stats(0.7 * (1.0 - depth));
            assert_eq!((above.events, above.grazings), (0, 0), "{step} {depth}");
            let below = stats(0.7 * (1.0 + depth));
            assert_eq!((below.events, below.grazings), (1, 0), "{step} {depth}");
        }
        let touch = stats(0.7);
        assert_eq!((touch.events, touch.grazings), (0, 1), "{step}");
    }
}

/// Bouncing ends only when a flight is below rounding: on an elastic wall it never ends.
#[test]
fn a_drop_onto_an_elastic_wall_bounces_forever() {
    for restitution in [1.0, 1.0 - 1e-12, 1.0 - 1e-7] {
        let ball = ImpactOscillator {
            omega: 0.0,
            damping: 0.0,
            drive: -10.0,
            drive_omega: 0.0,
            drive_phase: 0.0,
            wall: 0.1,
            restitution,
        };
        for method in all_methods(1e-10, 0.1, 0.01) {
            let mut motion = Integrator::new(method, ball)
                .and_then(|new| new.with_events())
                .unwrap();
            motion.start(0.0, &[0.15, 0.0]).unwrap();
            let mut bounces = 0;
            while motion.time() < 200.0 {
                bounces += motion.next_event(200.0).unwrap().len();
            }
            // Each flight lasts 0.2 s.
            assert!((999..=1001).contains(&bounces), "{method:?}: {bounces}");
            assert_eq!(motion.status(), [ImpactOscillator::FLYING]);
            let [x, v] = [motion.state()[0], motion.state()[1]];
            let energy = 0.5 * v * v + 10.0 * (x - 0.1);
            // Each bounce multiplies the energy by the squared coefficient of restitution.
            let energy_ratio = restitution.powi(2 * bounces as i32);
            assert!(
                (energy / (0.5 * energy_ratio) - 1.0).abs() < 1e-6,
                "{method:?}: {energy}"
            );
        }
    }
}
