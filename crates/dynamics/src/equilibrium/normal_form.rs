//! The first Lyapunov coefficient of a Hopf bifurcation, by its normal form.

use faer::prelude::Solve;
use faer::{Mat, c64};

use super::multilinear::TangentProduct;
use super::{Eigenmode, EquilibriumError, Linearised, inner};
use crate::System;

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
    /// Computes the coefficient for a mode of a system at an equilibrium: Yu. A. Kuznetsov, Elements of Applied
    /// Bifurcation Theory, Eq. (5.39). The growth rate of the mode is taken as zero.
    ///
    /// ```text
    /// c = 1/2 <y, C(x, x, x*) - 2 B(x, A^-1 B(x, x*)) + B(x*, (2 i omega - A)^-1 B(x, x))>
    /// ```
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
        let mut product =
            TangentProduct::new(system, linearised).ok_or(EquilibriumError::NoDerivative)?;
        let omega = mode.value.im;
        let left = linearised.left(mode);
        let (a, b): (Vec<f64>, Vec<f64>) = mode.vector.iter().map(|x| (x.re, x.im)).unzip();
        let along_a = product.along(&a, &[&a, &b]);
        let along_b = product.along(&b, &[&a, &b]);
        let [first, second] = [0, 1].map(|step| {
            let (a2, b2) = (&along_a.second[step], &along_b.second[step]);
            let (a3, b3) = (&along_a.third[step], &along_b.third[step]);
            // B(x, x) and B(x, x*) by bilinearity, with x = a + i b.
            let square = complex(&sum(&a2[0], &b2[1], -1.0), &sum(&a2[1], &b2[0], 1.0));
            let mixed = sum(&a2[0], &b2[1], 1.0);
            // C(x, x, x*) = C(a,a,a) + C(b,b,a) + i (C(a,a,b) + C(b,b,b)).
            let cubic = complex(&sum(&a3[0], &b3[0], 1.0), &sum(&a3[1], &b3[1], 1.0));
            (square, mixed, cubic)
        });
        let mut coefficient = |(square, mixed, cubic): &(Vec<c64>, Vec<f64>, Vec<c64>)| -> c64 {
            let steady = linearised.solve(c64::new(0.0, 0.0), &complex(mixed, &[]));
            let double = linearised.solve(c64::new(0.0, 2.0 * omega), square);
            // The steady part is real: A^-1 B(x, x*) = -(0 - A)^-1 B(x, x*).
            let steady: Vec<f64> = steady.iter().map(|v| -v.re).collect();
            let (re, im): (Vec<f64>, Vec<f64>) = double.iter().map(|v| (v.re, v.im)).unzip();
            let with_steady = [&a, &b].map(|of| product.along(of, &[&steady]).second);
            let with_steady = complex(&with_steady[0][0][0], &with_steady[1][0][0]);
            let [from_a, from_b] = [&a, &b].map(|of| product.along(of, &[&re, &im]).second);
            // B(x*, u) with x* = a - i b and u = re + i im.
            let with_double = complex(
                &sum(&from_a[0][0], &from_b[0][1], 1.0),
                &sum(&from_a[0][1], &from_b[0][0], -1.0),
            );
            let terms = cubic.iter().zip(&with_steady).zip(&with_double);
            let total: Vec<c64> = terms.map(|((c, s), d)| *c - *s * 2.0 + *d).collect();
            inner(&left, &total) * 0.5
        };
        let (best, again) = (coefficient(&first), coefficient(&second));
        Ok(Self {
            growth: best.re,
            omega: best.im,
            error: (best.re - again.re).abs() + rounding(&left, &first.2),
            smooth_amplitude: smooth_amplitude(system, linearised, mode),
        })
    }

    /// Kuznetsov's first Lyapunov coefficient, `Re c / omega`.
    pub fn coefficient(&self, mode: &Eigenmode) -> f64 {
        self.growth / mode.value.im
    }
}

impl Linearised {
    /// Solves `(shift - A) u = right`.
    fn solve(&self, shift: c64, right: &[c64]) -> Vec<c64> {
        let dim = self.dim();
        let matrix = Mat::from_fn(dim, dim, |i, j| {
            let entry = c64::new(-self.matrix[(i, j)], 0.0);
            if i == j { entry + shift } else { entry }
        });
        let right = Mat::from_fn(dim, 1, |i, _| right[i]);
        let solution = matrix.partial_piv_lu().solve(&right);
        (0..dim).map(|i| solution[(i, 0)]).collect()
    }
}

/// Rounding error of the projection of the cubic term.
fn rounding(left: &[c64], cubic: &[c64]) -> f64 {
    let size: f64 = left
        .iter()
        .zip(cubic)
        .map(|(y, c)| y.norm() * c.norm())
        .sum();
    64.0 * f64::EPSILON * size
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

/// `a + factor b`.
fn sum(a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

/// Complex vector of real and imaginary parts; a missing part is zero.
fn complex(re: &[f64], im: &[f64]) -> Vec<c64> {
    let im = |i: usize| im.get(i).copied().unwrap_or(0.0);
    re.iter()
        .enumerate()
        .map(|(i, re)| c64::new(*re, im(i)))
        .collect()
}
