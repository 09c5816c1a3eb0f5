//! Error tolerance and norm.
//!
//! The modes differ by orders of magnitude in frequency and amplitude, and the vibration grows over many
//! decades. Errors are therefore measured in the same norm as the vibration:
//!
//! * All modes together: `size = sum_i (omega_i |q_i| + |q_i'|)`. This lies between the square root of
//!   twice the vibration energy and `sqrt(2 m)` times that. It has the unit of a modal velocity and is
//!   nearly constant in free vibration.
//! * All first-order components without the quadratures together: `size = sum_j |w_j|`; in a system without modes,
//!   at its maximum since the start. Give them comparable units.
//! * All quadratures together: `size = sum_j |w_j|`, at its maximum since the start. A quadrature such as a work
//!   passes through zero without losing accuracy there.
//!
//! A step is accepted if each of the errors is at most `relative * (size + floor)`. At rest without
//! a force the error is exactly zero, and the step is accepted.

use super::{DynamicsError, System};

/// Error tolerance per step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Permitted error per step, relative to the present norm of the vibration and of the first-order
    /// components; 1e-13 to 0.1.
    pub relative: f64,
    /// Norm below which the permitted error no longer decreases, in the unit of a modal velocity and of
    /// the first-order components; positive. Raise it if the force has rounding noise that does not
    /// vanish with the state: no step size resolves noise.
    pub floor: f64,
}

impl Accuracy {
    /// A relative tolerance at every norm of the state down to 1e-290.
    pub const fn relative(relative: f64) -> Self {
        Self {
            relative,
            floor: 1e-290,
        }
    }

    /// Checks the ranges of both parameters.
    pub(super) fn check(&self) -> Result<(), DynamicsError> {
        if !(1e-13..=0.1).contains(&self.relative) {
            return Err(DynamicsError::Parameter {
                name: "the relative accuracy",
                value: self.relative,
                allowed: "from 1e-13 to 0.1",
            });
        }
        if !(self.floor >= f64::MIN_POSITIVE && self.floor.is_finite()) {
            return Err(DynamicsError::Parameter {
                name: "the floor of the accuracy",
                value: self.floor,
                allowed: "positive and finite (default 1e-290)",
            });
        }
        Ok(())
    }
}

/// Properties of a method that step control and event location use.
#[derive(Clone, Copy, Debug)]
pub(super) struct MethodTraits {
    /// Exponents of the PI controller: of the error ratio of an accepted step, of that of the preceding step, and of that of
    /// a rejected step.
    pub gain: [f64; 3],
    /// Number of subintervals of a step that event location samples five times each. One suffices for
    /// dense output of order 4, which five values determine; higher orders need more.
    pub pieces: usize,
    /// Whether a step may contract a direction by orders of magnitude.
    pub is_stiff: bool,
}

/// Norms of the parts of a state or of an error: of the modal part, in the unit of a modal velocity, of the first-order
/// components without the quadratures, and of the quadratures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct StateNorm(pub [f64; 3]);

impl StateNorm {
    /// The norm of a state `z = [q | q' | w]` of a system, or of a difference of two states, with or without the quadratures,
    /// which come last.
    pub fn of(z: &[f64], sys: &dyn System) -> Self {
        let omega = sys.omega();
        let (q, rest) = z.split_at(omega.len());
        let (v, w) = rest.split_at(omega.len());
        let modes = q.iter().zip(v).zip(omega);
        let (w, quadratures) = w.split_at(sys.tangent_dim() - 2 * omega.len());
        let sum = |w: &[f64]| w.iter().map(|w| w.abs()).sum();
        let vibration = modes.map(|((q, v), omega)| omega * q.abs() + v.abs()).sum();
        Self([vibration, sum(w), sum(quadratures)])
    }

    /// Combines each part with that of another norm.
    fn zip(self, other: Self, combine: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| combine(self.0[k], other.0[k])))
    }

    /// Maximum of each part.
    pub fn max(self, other: Self) -> Self {
        self.zip(other, f64::max)
    }

    /// Combines each part with that of a coarser estimate by [`sharpened`].
    pub fn sharpened(self, coarse: Self) -> Self {
        self.zip(coarse, sharpened)
    }

    /// The norms of the modal part and of the first-order components together.
    pub fn without_quadratures(self) -> f64 {
        self.0[0] + self.0[1]
    }

    /// Whether all norms are finite.
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|part| part.is_finite())
    }
}

/// Combines an estimate of the error with a coarser one into an estimate of higher order in the step: `e^2 /
/// sqrt(e^2 + (f / 10)^2)`, as in DOP853.
pub(super) fn sharpened(error: f64, coarse: f64) -> f64 {
    let scale = error.hypot(0.1 * coarse);
    if scale == 0.0 {
        0.0
    } else {
        error * (error / scale)
    }
}

/// The maximum step (s) at which the classical Runge–Kutta method does not amplify `exp(rate t)`, for a
/// rate `[real, imaginary]` (1/s). For a growing solution the real part counts as zero. Infinite for a
/// zero rate.
///
/// The method multiplies the solution by `R(x) = 1 + x + x^2/2 + x^3/6 + x^4/24` with `x = rate h`. `|R|
/// <= 1` holds up to `h |rate| = 2.785` on the negative real axis and `2 sqrt(2)` on the imaginary axis.
pub fn max_rk4_step(rate: [f64; 2]) -> f64 {
    let [re, im] = [rate[0].min(0.0), rate[1]];
    let size = re.hypot(im);
    if size == 0.0 {
        return f64::INFINITY;
    }
    let [re, im] = [re / size, im / size];
    let growth = |x: f64| {
        // Horner's scheme of R at x (re + i im).
        let (mut a, mut b) = (1.0, 0.0);
        for k in [4.0, 3.0, 2.0, 1.0] {
            (a, b) = (1.0 + x / k * (re * a - im * b), x / k * (re * b + im * a));
        }
        a.hypot(b)
    };
    // The stability boundary is crossed once, between 2.5 and 3.5, in all directions of the left half
    // plane.
    let (mut low, mut high) = (2.5, 3.5);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if growth(middle) <= 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low / size
}

#[cfg(test)]
mod tests {
    use super::max_rk4_step;

    #[test]
    fn maximum_fixed_step_lies_on_the_stability_boundary() {
        let close = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 1e-6, "{got} {want}");
        close(max_rk4_step([0.0, 2.0]), 2.0_f64.sqrt());
        close(max_rk4_step([-10.0, 0.0]), 0.278_529_356_3);
        // The real part of a growing rate counts as zero.
        assert_eq!(max_rk4_step([7.0, 2.0]), max_rk4_step([0.0, 2.0]));
        assert_eq!(max_rk4_step([0.0, 0.0]), f64::INFINITY);
        // In all directions between, the boundary lies within the search bracket.
        for k in 0..=90 {
            let (im, re) = f64::from(k).to_radians().sin_cos();
            let h = max_rk4_step([-re, im]);
            assert!((2.5..3.5).contains(&h), "{k}: {h}");
        }
    }
}
