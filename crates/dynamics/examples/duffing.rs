//! Lyapunov exponents of a driven Duffing oscillator.
//!
//! ```text
//! cargo run --release -p squeakscope-dynamics --example duffing
//! ```

use squeakscope_dynamics::{
    Accuracy, Differentiable, DynamicsError, Integrator, MethodName, System,
};

/// `x'' + 0.3 x' - x + x^3 = 0.5 cos(1.2 t)`. The linear part of a mode is that of a stable spring, `x'' + 0.3 x' + x`;
/// the rest is the force.
struct Duffing;

impl System for Duffing {
    fn omega(&self) -> &[f64] {
        &[1.0]
    }

    fn damping(&self) -> &[f64] {
        &[0.15]
    }

    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = 2.0 * z[0] - z[0].powi(3) + 0.5 * (1.2 * t).cos();
    }

    fn is_autonomous(&self) -> bool {
        false
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
}

impl Differentiable for Duffing {
    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        // The record is the time and the state.
        let slope = 2.0 - 3.0 * record[1].powi(2);
        for (out, displacement) in out.iter_mut().zip(&vectors[..width]) {
            *out = slope * displacement;
        }
    }
}

fn main() -> Result<(), DynamicsError> {
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-8), 0.5);
    let mut integrator = Integrator::new(method, &Duffing)?.with_tangents(2, 1)?;
    integrator.start(0.0, &[1.0, 0.0])?;
    integrator.integrate_to(100.0)?;
    integrator.reset_growth();
    integrator.integrate_to(5000.0)?;
    let spectrum = integrator.exponents().expect("vectors are followed");
    for exponent in &spectrum.exponents {
        println!("{:7.4} ± {:.4} 1/s", exponent.value, exponent.half_width);
    }
    // The exponents sum to the rate at which areas of the state space shrink.
    let sum: f64 = spectrum
        .exponents
        .iter()
        .map(|exponent| exponent.value)
        .sum();
    println!("sum {sum:.4} 1/s, exact -0.3; {:?}", spectrum.attractor());
    Ok(())
}
