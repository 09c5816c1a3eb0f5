//! The first Lyapunov coefficient of a Hopf bifurcation, by its normal form.

use faer::c64;

use super::multilinear::TangentDerivatives;
use super::{Eigenmode, EquilibriumError, Linearised};
use crate::System;
use crate::normal_form::{ComplexVector, Critical};

/// Rounding error of the projection of the cubic term relative to its terms.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// The cubic term of the normal form `dw/dt = lambda w + c w |w|^2` of a Hopf bifurcation.
///
/// The motion is `z - z0 = 2 Re(w x)` with the eigenvector `x` of length 1 in the scaled coordinates `[omega q | dq/dt
/// | w]`. A negative value is a supercritical bifurcation: a stable cycle is born, on the side on which the equilibrium
/// is unstable. A positive value is a subcritical bifurcation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstLyapunov {
    /// `Re c`: change of the growth rate with `|w|^2`, in 1/s per square of the scaled coordinates.
    pub growth: f64,
    /// `Im c`: change of the angular frequency with `|w|^2`, in rad/s per square of the scaled coordinates.
    pub omega: f64,
    /// Error estimate of `Re c`.
    pub error: f64,
    /// Amplitude `|w|` at which the first guard of the status is reached; infinite without guards.
    pub smooth_amplitude: f64,
}

impl FirstLyapunov {
    /// Computes the coefficient for a mode of a system at an equilibrium. The growth rate of the mode is taken as zero.
    ///
    /// # Errors
    /// If the mode does not oscillate, or the system has no derivative.
    pub fn new(
        system: &dyn System,
        linearised: &Linearised,
        mode: &Eigenmode,
    ) -> Result<Self, EquilibriumError> {
        if !mode.oscillates() {
            return Err(EquilibriumError::NoOscillation);
        }
        let mut derivatives =
            TangentDerivatives::new(system, linearised).ok_or(EquilibriumError::NoDerivative)?;
        let vectors = [mode.vector.clone(), linearised.left(mode)].map(ComplexVector::from_vec);
        let critical = Critical::new(
            vectors,
            |i, j| linearised.matrix[(i, j)],
            [c64::ZERO, c64::new(0.0, 2.0 * mode.value.im)],
        );
        let [(best, size), (again, _)] = [false, true].map(|finer| {
            derivatives.finer = finer;
            let unknown = (c64::new(f64::NAN, f64::NAN), f64::NAN);
            critical
                .of_pair(&mut |u| Some(derivatives.along(u)))
                .unwrap_or(unknown)
        });
        Ok(Self {
            growth: best.re,
            omega: best.im,
            error: (best.re - again.re).abs() + ROUNDING * size,
            smooth_amplitude: smooth_amplitude(system, linearised, mode),
        })
    }

    /// Kuznetsov's first Lyapunov coefficient, `Re c / omega`.
    pub fn coefficient(&self, mode: &Eigenmode) -> f64 {
        self.growth / mode.value.im
    }
}

/// Amplitude `|w|` of a mode at which the first guard is reached.
fn smooth_amplitude(system: &dyn System, linearised: &Linearised, mode: &Eigenmode) -> f64 {
    let (Some(switching), Some(status)) = (system.switching(), &linearised.status) else {
        return f64::INFINITY;
    };
    let mut z = vec![0.0; system.dim()];
    z[..linearised.dim()].copy_from_slice(&linearised.state);
    let mut values = vec![0.0; switching.guards()];
    switching.guard_values(status, 0.0, &z, &mut values);
    let mut gradient = vec![0.0; system.dim()];
    let reached = values.iter().enumerate().map(|(guard, value)| {
        gradient.fill(0.0);
        switching.guard_gradient(status, guard, 0.0, &z, &mut gradient);
        let parts =
            (0..linearised.dim()).map(|i| mode.vector[i] * (gradient[i] / linearised.scale[i]));
        let swing = 2.0 * parts.sum::<c64>().norm();
        // A guard on which the equilibrium rests limits the amplitude to zero.
        value.max(0.0) / swing
    });
    reached
        .filter(|amplitude| !amplitude.is_nan())
        .fold(f64::INFINITY, f64::min)
}
