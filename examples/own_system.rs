//! Systems from closures: the Lyapunov exponents of a Duffing oscillator, and the stick-slip of a mass on a belt with
//! its events and its branch of periodic orbits over the speed of the belt.
//!
//! ```text
//! cargo run --release --example own_system
//! ```

use std::f64::consts::{PI, TAU};

use squeakscope::dynamics::continuation as branch;
use squeakscope::dynamics::{Accuracy, Integrator, MethodName};
use squeakscope::dynamics::{OwnSystem, piecewise_system, system};

/// `x'' + x` is the friction of a belt: up to 1 while the mass sticks (status 0), 1/2 while it slides (status 1).
fn stick_slip(belt: f64) -> OwnSystem {
    piecewise_system(
        [1.0],
        move |_, _, v| u8::from(v[0] < belt),
        |status, _, q, _, force| force[0] = [q[0], 0.5][usize::from(status)],
        1,
        move |status, _, q, v, guard| guard[0] = [1.0 - q[0], belt - v[0]][usize::from(status)],
        move |status, _, _, v| {
            v[0] = belt;
            1 - status
        },
    )
    .held(move |status, _, v| {
        if status == 0 {
            v[0] = belt;
        }
    })
}

/// The exact period: the mass slides for `2 (PI - atan(1 / (2 belt)))` and sticks for `1 / belt`.
fn period(belt: f64) -> f64 {
    2.0 * (PI - (0.5 / belt).atan()) + 1.0 / belt
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // x'' + 0.3 x' - x + x^3 = 0.5 cos(1.2 t), with the linear part of a stable spring.
    let duffing = system([1.0], |t, q, _, force| {
        force[0] = 2.0 * q[0] - q[0].powi(3) + 0.5 * (1.2 * t).cos();
    });
    let duffing = duffing.damped([0.15]).driven(TAU / 1.2);
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-8), 0.5);
    let mut run = Integrator::new(method, &duffing)?.with_tangents(2, 1)?;
    run.start(0.0, &[1.0, 0.0])?;
    run.integrate_to(100.0)?;
    run.reset_growth();
    run.integrate_to(3000.0)?;
    let spectrum = run.exponents().ok_or("without tangent vectors")?;
    for exponent in &spectrum.exponents {
        println!("{:7.4} +- {:.4} 1/s", exponent.value, exponent.half_width);
    }

    let on_belt = stick_slip(0.2);
    let mut run = Integrator::new(method, &on_belt)?.with_events()?;
    run.start(0.0, &[0.0, 0.2])?;
    for _ in 0..4 {
        run.next_event(100.0)?;
        println!("status {:?} from {:.6} s on", run.status(), run.time());
    }

    let options = branch::ContinuationOptions::new([0.1, 0.6], 0.1);
    let search = branch::ReturnSearch {
        settle_s: 20.0,
        max_period_s: 20.0,
        tolerance: 1e-6,
    };
    let start = branch::settled_orbit(&stick_slip, 0.2, &[0.0, 0.2], &search, &options)?;
    branch::continue_orbits(&stick_slip, &start.into(), &options, &mut |orbit| {
        let (belt, found) = (orbit.parameter, orbit.period_s);
        let error = found - period(belt);
        println!("belt {belt:.3}: period {found:.6} s, error {error:.0e} s");
        Ok(())
    })?;
    Ok(())
}
