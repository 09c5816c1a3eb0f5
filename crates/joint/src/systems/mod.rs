//! Small reference systems with known behaviour, used in small scenes and in tests of the integrators.
//!
//! | system | property | equations |
//! |---|---|---|
//! | [`ImpactOscillator`] | impacts: the velocity is reversed at a wall | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t)`, `x >= wall`, `v+ = -r v-` |
//! | [`MassOnBelt`] | dry friction with sticking | `x'' + 2 zeta omega x' + omega^2 x = -n mu sign(x' - belt)` |
//! | [`TwoModesOnBelt`] | mode coupling by friction, separation | `q'' + W^2 q = -(N - n) e + mu (N - n) t`, `N = max(0, n + k e.q)` |
//! | [`DampedContact`] | a force that jumps at separation | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t) + contact`, `contact = -(k x + c x')/m` while `x < 0` |

use pulp::Scalar;

use crate::dual::Dual;

/// A number with its derivatives with respect to `N` inputs.
type Number<const N: usize> = Dual<Scalar, 1, N>;

/// Displacements and velocities of `M` modes, and time (s): the inputs of the derivatives, if there are any.
struct Motion<const M: usize, const N: usize> {
    z: [[Number<N>; M]; 2],
    t: Number<N>,
}

impl<const M: usize, const N: usize> Motion<M, N> {
    fn new(t: f64, z: &[f64]) -> Self {
        let number = |k: usize| Number::scalar(z[k], k);
        Self {
            z: std::array::from_fn(|part| std::array::from_fn(|i| number(part * M + i))),
            t: Number::scalar(t, 2 * M),
        }
    }

    /// Writes the state.
    fn write(&self, z: &mut [f64]) {
        for (z, x) in z.iter_mut().zip(self.z.as_flattened()) {
            *z = x.value();
        }
    }
}

/// Writes the derivatives of numbers along each of `width` vectors, and along the time at a rate. Both are stored component by
/// component, and may be the same.
fn derivatives<const N: usize>(
    numbers: &[Number<N>],
    (width, rate): (usize, f64),
    vectors: impl Fn(&[f64], usize) -> f64,
    out: &mut [f64],
) {
    for l in 0..width {
        let mut vector = [rate; N];
        for (component, x) in vector[..N - 1].iter_mut().enumerate() {
            *x = vectors(out, component * width + l);
        }
        for (out, number) in out.iter_mut().skip(l).step_by(width).zip(numbers) {
            let terms = number.slopes.iter().zip(&vector);
            *out = terms.map(|(slope, x)| slope.sum() * x).sum();
        }
    }
}

/// The laws of a system of `M` modes with a status of one byte, written for numbers with derivatives.
trait Piecewise<const M: usize> {
    /// Number of guards.
    const GUARDS: usize = 1;

    /// Whether state and law are continuous at the guards.
    const IS_CONTINUOUS: bool = false;

    /// Natural circular frequencies, rad/s, and damping ratios.
    fn linear(&self) -> [&[f64]; 2];

    fn is_autonomous(&self) -> bool {
        true
    }

    /// Status of a state.
    fn status(&self, at: &Motion<M, 0>) -> u8;

    /// A given status, or that of a state.
    fn status_or(&self, status: Option<&[u8]>, t: f64, z: &[f64]) -> u8 {
        status.map_or_else(|| self.status(&Motion::new(t, z)), |status| status[0])
    }

    /// Force of a status.
    fn law<const N: usize>(&self, status: u8, at: &Motion<M, N>) -> [Number<N>; M];

    /// A guard of a status; one that it does not use stays positive.
    fn guard<const N: usize>(&self, status: u8, guard: usize, at: &Motion<M, N>) -> Number<N>;

    /// Changes status and state at a guard.
    fn reset<const N: usize>(&self, status: &mut u8, guard: usize, at: &mut Motion<M, N>);

    /// Moves a state onto the constraint of its status.
    fn hold<const N: usize>(&self, _status: u8, _at: &mut Motion<M, N>) {}
}

/// Implements the interfaces of the integrators for a [`Piecewise`] system: its force is the law of the status of the
/// state.
macro_rules! implement {
    ($system:ident, $modes:literal) => {
        impl System for $system {
            fn omega(&self) -> &[f64] {
                self.linear()[0]
            }
            fn damping(&self) -> &[f64] {
                self.linear()[1]
            }
            fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
                self.force_in(&[self.status(&Motion::new(t, z))], t, z, out);
            }
            fn switching(&self) -> Option<&dyn Switching> {
                Some(self)
            }
            fn differentiable(&self) -> Option<&dyn Differentiable> {
                Some(self)
            }
            fn is_autonomous(&self) -> bool {
                Piecewise::is_autonomous(self)
            }
        }

        impl Switching for $system {
            fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
                status[0] = self.status(&Motion::new(t, z));
            }
            fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
                let force = self.law(status[0], &Motion::<$modes, 0>::new(t, z));
                out[..$modes].copy_from_slice(&force.map(Number::value));
            }
            fn guards(&self) -> usize {
                Self::GUARDS
            }
            fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]) {
                let at = Motion::<$modes, 0>::new(t, z);
                for (guard, value) in values.iter_mut().enumerate() {
                    *value = self.guard(status[0], guard, &at).value();
                }
            }
            fn cross(&self, guard: usize, t: f64, z: &mut [f64], status: &mut [u8]) {
                let mut at = Motion::<$modes, 0>::new(t, z);
                self.reset(&mut status[0], guard, &mut at);
                at.write(z);
            }
            fn settle(
                &self,
                status: &[u8],
                t: f64,
                z: &mut [f64],
                (vectors, width): (&mut [f64], usize),
            ) {
                let mut at = Motion::<$modes, { 2 * $modes + 1 }>::new(t, z);
                self.hold(status[0], &mut at);
                derivatives(at.z.as_flattened(), (width, 0.0), |of, k| of[k], vectors);
                at.write(z);
            }
            fn is_continuous(&self) -> bool {
                Self::IS_CONTINUOUS
            }
            fn guard_gradient(
                &self,
                status: &[u8],
                guard: usize,
                t: f64,
                z: &[f64],
                gradient: &mut [f64],
            ) -> f64 {
                let at = Motion::<$modes, { 2 * $modes + 1 }>::new(t, z);
                let slopes = self
                    .guard(status[0], guard, &at)
                    .slopes
                    .map(|slope| slope.sum());
                gradient.copy_from_slice(&slopes[..2 * $modes]);
                slopes[2 * $modes]
            }
            fn reset_tangents(
                &self,
                status: &[u8],
                guard: usize,
                t: f64,
                z: &[f64],
                (vectors, width, rate): (&mut [f64], usize, f64),
            ) {
                let mut at = Motion::<$modes, { 2 * $modes + 1 }>::new(t, z);
                self.reset(&mut status[0].clone(), guard, &mut at);
                derivatives(at.z.as_flattened(), (width, rate), |of, k| of[k], vectors);
            }
        }

        impl Differentiable for $system {
            fn product(
                &self,
                status: Option<&[u8]>,
                record: &mut [f64],
                vectors: &[f64],
                width: usize,
                out: &mut [f64],
            ) {
                let (t, z) = (record[0], &record[1..]);
                let status = self.status_or(status, t, z);
                let force = self.law(status, &Motion::<$modes, { 2 * $modes + 1 }>::new(t, z));
                derivatives(&force, (width, 0.0), |_, k| vectors[k], out);
            }
            fn time_derivative(&self, status: Option<&[u8]>, t: f64, z: &[f64], out: &mut [f64]) {
                let status = self.status_or(status, t, z);
                let force = self.law(status, &Motion::<$modes, { 2 * $modes + 1 }>::new(t, z));
                derivatives(&force, (1, 1.0), |_, _| 0.0, out);
            }
        }
    };
}

mod belt;
mod damped_contact;
mod impact;
mod two_modes;

pub use belt::MassOnBelt;
pub use damped_contact::DampedContact;
pub use impact::ImpactOscillator;
pub use two_modes::{CoupledMode, TwoModesOnBelt};

/// Acceleration `a cos(W t + p)` of a drive with this amplitude, circular frequency and phase.
fn drive<const N: usize>([amplitude, omega, phase]: [f64; 3], t: Number<N>) -> Number<N> {
    let cosine = (t * omega + phase).compose_scalar(|angle| {
        let (sin, cos) = angle.sin_cos();
        [cos, -sin]
    });
    cosine * amplitude
}

/// Force per unit mass that cancels the linear part of a mode.
fn cancelling<const N: usize>([omega, damping]: [f64; 2], x: Number<N>, v: Number<N>) -> Number<N> {
    x * (omega * omega) + v * (2.0 * damping * omega)
}

#[cfg(test)]
mod tests;
