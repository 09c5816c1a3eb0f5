//! Forces with kinks: unilateral springs.

use super::reference::unilateral;
use super::systems::Unilateral;
use super::*;

const END: f64 = 30.0;

#[test]
fn all_springs_open_and_close_repeatedly() {
    let mut integrator = run(
        all_methods(1e-8, 0.1, 1e-3)[0],
        &Unilateral,
        &Unilateral::START,
        0.0,
    );
    let mut z = [0.0; 7];
    let mut changes = [0; 3];
    let mut closed = [true; 3];
    for k in 0..3000 {
        integrator.sample(0.01 * f64::from(k), &mut z).unwrap();
        for n in 0..3 {
            let now = Unilateral::gap(n, &z) > 0.0;
            changes[n] += u32::from(now != closed[n]);
            closed[n] = now;
        }
    }
    assert!(changes.iter().all(|&c| c > 10), "{changes:?}");
}

#[test]
fn all_methods_converge_to_the_event_located_reference() {
    let exact = unilateral(&Unilateral::START, END);
    let mut before = [f64::INFINITY; METHODS.len()];
    for (relative, step) in [(1e-5, 1e-2), (1e-7, 1e-3), (1e-9, 1e-4), (1e-11, 2e-5)] {
        for (k, method) in all_methods(relative, 0.5, step).into_iter().enumerate() {
            let integrator = run(method, &Unilateral, &Unilateral::START, END);
            let error = distance(&integrator.state()[..6], &exact);
            let eighth = METHODS[k].order > 5.0;
            // The steps are so long that they can miss a short contact between two stages.
            let allowed = if eighth {
                300.0 * relative + 1e-6
            } else {
                0.5 * before[k]
            };
            assert!(
                error < allowed,
                "{method:?}: {error:e} after {:e}",
                before[k]
            );
            before[k] = error;
        }
    }
    let others = METHODS.iter().zip(before).filter(|(m, _)| m.order <= 5.0);
    assert!(
        others.into_iter().all(|(_, error)| error < 1e-8),
        "{before:?}"
    );
}

#[test]
fn the_work_of_the_springs_equals_the_energy_change() {
    let energy = |z: &[f64]| -> f64 {
        (0..3)
            .map(|i| 0.5 * (z[3 + i].powi(2) + (Unilateral::OMEGA[i] * z[i]).powi(2)))
            .sum()
    };
    for relative in [1e-6, 1e-9] {
        for method in &adaptive_methods(relative, 0.5) {
            let integrator = run(*method, &Unilateral, &Unilateral::START, END);
            let gained = energy(integrator.state()) - energy(&Unilateral::START);
            assert!(
                (integrator.state()[6] - gained).abs() < 100.0 * relative,
                "{method:?}"
            );
        }
    }
}

#[test]
fn samples_are_as_accurate_as_step_ends() {
    for method in all_methods(1e-9, 0.5, 1e-4) {
        let mut integrator = run(method, &Unilateral, &Unilateral::START, 0.0);
        let mut z = [0.0; 7];
        for k in 1..40 {
            let t = 0.237 * f64::from(k);
            integrator.sample(t, &mut z).unwrap();
            let error = distance(&z[..6], &unilateral(&Unilateral::START, t));
            assert!(error < 1e-6, "{method:?} at {t}: {error:e}");
        }
    }
}

#[test]
fn jumps_of_dry_friction_are_integrated_without_event_location() {
    // q'' + q = -F sign(q'): each half cycle reduces the amplitude by exactly 2 F.
    let friction = 0.03;
    let dry_friction = systems::Forced {
        omega: [1.0],
        force: |_, _, v: f64| {
            if v == 0.0 {
                0.0
            } else {
                -friction * v.signum()
            }
        },
    };
    for method in &adaptive_methods(1e-8, 0.5) {
        let integrator = run(
            *method,
            &dry_friction,
            &[1.0, 0.0],
            10.0 * std::f64::consts::PI,
        );
        assert!(
            distance(integrator.state(), &[1.0 - 20.0 * friction, 0.0]) < 1e-6,
            "{:?}",
            integrator.state()
        );
        assert!(
            integrator.stats().rejections > 30,
            "jumps must cause rejected steps"
        );
    }
}
