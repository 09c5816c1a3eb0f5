//! Equilibria and normal forms against closed forms.

use faer::Mat;
use squeakscope_dynamics::System;
use squeakscope_dynamics::equilibrium::*;
use squeakscope_joint::systems::MassOnBelt;

use crate::known::Lorenz;
use crate::systems::Equations;

/// Two first-order equations with the normal form of a Hopf bifurcation.
fn normal(growth: f64, omega: f64, [a, b]: [f64; 2]) -> impl System {
    let at = move |x: f64, y: f64| {
        let square = x * x + y * y;
        [growth + a * square, omega + b * square]
    };
    Equations {
        dimension: 2,
        rates: move |_: f64, z: &[f64], out: &mut [f64]| {
            let [growth, omega] = at(z[0], z[1]);
            out[0] = growth * z[0] - omega * z[1];
            out[1] = omega * z[0] + growth * z[1];
        },
        jacobian: move |_: f64, z: &[f64], out: &mut [f64]| {
            let (x, y) = (z[0], z[1]);
            let [growth, omega] = at(x, y);
            let [by_growth, by_omega] = [2.0 * (a * x - b * y), 2.0 * (b * x + a * y)];
            out[0] = growth + x * by_growth;
            out[1] = -omega + y * by_growth;
            out[2] = omega + x * by_omega;
            out[3] = growth + y * by_omega;
        },
        autonomous: true,
    }
}

/// `x'' + x = (mu - x^2) x'`, as two first-order equations with a quadratic change of coordinates that makes all
/// terms of the normal form appear: `y = x' + bend x^2`.
fn van_der_pol(mu: f64, bend: f64) -> impl System {
    Equations {
        dimension: 2,
        rates: move |_: f64, z: &[f64], out: &mut [f64]| {
            let x = z[0];
            let v = z[1] - bend * x * x;
            out[0] = v;
            out[1] = -x + (mu - x * x) * v + 2.0 * bend * x * v;
        },
        jacobian: move |_: f64, z: &[f64], out: &mut [f64]| {
            let x = z[0];
            let v = z[1] - bend * x * x;
            // Change of v with x; with y it is 1.
            let by_x = -2.0 * bend * x;
            let by_v = mu - x * x + 2.0 * bend * x;
            out[0] = by_x;
            out[1] = 1.0;
            out[2] = -1.0 + (2.0 * bend - 2.0 * x) * v + by_v * by_x;
            out[3] = by_v;
        },
        autonomous: true,
    }
}

fn hopf(system: &dyn System, guess: &[f64]) -> (Linearised, Eigenmode, FirstLyapunov) {
    let linearised = Linearised::new(system, guess).unwrap();
    let mode = linearised.modes().unwrap().remove(0);
    let found = FirstLyapunov::new(system, &linearised, &mode).unwrap();
    (linearised, mode, found)
}

#[test]
fn the_normal_form_of_a_hopf_point_is_its_own() {
    for cubic in [[-0.3, 0.7], [2.0, -1.0], [-1e4, 0.0]] {
        let system = normal(0.0, 3.0, cubic);
        let (_, mode, found) = hopf(&system, &[0.0; 2]);
        assert!(mode.value.re.abs() < 1e-14 && (mode.value.im - 3.0).abs() < 1e-14);
        // x = (1, -i)/sqrt(2): |z|^2 = 2 |w|^2.
        let expected = cubic.map(|c| 2.0 * c);
        let size = expected[0].abs();
        assert!(
            (found.growth - expected[0]).abs() < 1e-9 * size,
            "{found:?}"
        );
        assert!((found.omega - expected[1]).abs() < 1e-9 * size, "{found:?}");
        assert!(found.error < 1e-8 * size, "{found:?}");
        assert_eq!(found.smooth_amplitude, f64::INFINITY);
    }
}

#[test]
fn a_change_of_coordinates_keeps_the_first_lyapunov_coefficient() {
    // Averaging gives a' = mu a / 2 - a^3 / 8 for the amplitude a = 2 |w| |x_1| with |x_1|^2 = 1/2.
    for bend in [0.0, 0.4, -1.3] {
        let (_, _, found) = hopf(&van_der_pol(0.0, bend), &[0.0; 2]);
        assert!((found.growth + 0.25).abs() < 1e-8, "{bend}: {found:?}");
        assert!(found.error < 1e-7, "{found:?}");
    }
}

#[test]
fn the_lorenz_system_has_a_subcritical_hopf_point() {
    let [sigma, beta]: [f64; 2] = [10.0, 8.0 / 3.0];
    let rho = sigma * (sigma + beta + 3.0) / (sigma - beta - 1.0);
    let system = Lorenz { sigma, rho, beta };
    let far = (beta * (rho - 1.0)).sqrt();
    let (linearised, mode, found) = hopf(&system, &[far + 0.1, far - 0.1, rho - 1.5]);
    for (z, exact) in linearised.state.iter().zip([far, far, rho - 1.0]) {
        assert!((z - exact).abs() < 1e-11 * rho, "{z} {exact}");
    }
    assert!(mode.value.re.abs() < 1e-12, "{:?}", mode.value);
    // omega^2 = beta (sigma + rho).
    assert!((mode.value.im - (beta * (sigma + rho)).sqrt()).abs() < 1e-11);
    assert!(
        found.growth > 0.0 && found.error < 1e-6 * found.growth,
        "{found:?}"
    );
}

/// A mass on a belt whose damping balances the slope of friction.
fn belt() -> MassOnBelt {
    let (omega, load, fall, stribeck, speed) = (600.0, 30.0, 0.3, 5.0, 0.1_f64);
    let slope = -stribeck * fall * (-stribeck * speed).exp();
    MassOnBelt {
        omega,
        damping: -load * slope / (2.0 * omega),
        load,
        mu_s: 0.3 + fall,
        mu_d: 0.3,
        belt: speed,
        stribeck: Some(stribeck),
    }
}

#[test]
fn the_belt_has_a_subcritical_hopf_point() {
    let belt = belt();
    let (linearised, mode, found) = hopf(&belt, &[0.0; 2]);
    let rest = belt.load * belt.coefficient(belt.belt) / belt.omega.powi(2);
    assert!((linearised.state[0] - rest).abs() < 1e-15);
    assert!(mode.value.re.abs() < 1e-10 && belt.growth().abs() < 1e-10);
    assert!((mode.value.im - belt.small_omega()).abs() < 1e-10);
    // The force on the velocity v has the cubic term -n mu'''/6 v^3: averaging over an amplitude a = sqrt(2) |w| gives
    // the growth rate -n mu''' a^2 / 16. The quadratic term changes the frequency only.
    let third = -0.3 * 5.0_f64.powi(3) * (-0.5_f64).exp();
    let expected = -belt.load * third / 8.0;
    assert!(
        (found.growth / expected - 1.0).abs() < 1e-7,
        "{found:?} {expected}"
    );
    assert!(found.error < 1e-6 * expected, "{found:?}");
    // The guard is the belt's velocity.
    let limit = 0.1 / 2.0_f64.sqrt();
    assert!((found.smooth_amplitude - limit).abs() < 1e-9, "{found:?}");
}

#[test]
fn the_derivative_of_an_eigenvalue_is_that_of_its_difference() {
    let at = |mu: f64| Linearised::new(&van_der_pol(mu, 0.0), &[0.0; 2]).unwrap();
    let h = 1e-6;
    let (up, down) = (at(0.3 + h), at(0.3 - h));
    let slope = Mat::from_fn(2, 2, |i, j| {
        (up.matrix[(i, j)] - down.matrix[(i, j)]) / (2.0 * h)
    });
    let here = at(0.3);
    let mode = here.modes().unwrap().remove(0);
    // lambda = mu/2 + i sqrt(1 - mu^2/4).
    let derivative = eigenvalue_derivative(&here.left(&mode), &slope, &mode.vector);
    assert!((derivative.re - 0.5).abs() < 1e-9, "{derivative:?}");
    let expected = -0.25 * 0.3 / (1.0 - 0.25 * 0.09_f64).sqrt();
    assert!((derivative.im - expected).abs() < 1e-9, "{derivative:?}");
}

#[test]
fn a_driven_system_has_no_equilibrium() {
    let driven = squeakscope_joint::systems::ImpactOscillator {
        omega: 1.0,
        damping: 0.1,
        drive: 1.0,
        drive_omega: 2.0,
        drive_phase: 0.0,
        wall: -1.0,
        restitution: 0.8,
    };
    let error = Linearised::new(&driven, &[0.0; 2]).unwrap_err();
    assert_eq!(error, EquilibriumError::Driven);
}
