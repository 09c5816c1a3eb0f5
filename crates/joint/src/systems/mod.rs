//! Small reference systems with known behaviour, used in small scenes and in tests of the integrators.
//!
//! | system | property | equations |
//! |---|---|---|
//! | [`ImpactOscillator`] | impacts: the velocity is reversed at a wall | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t)`, `x >= wall`, `v+ = -r v-` |
//! | [`MassOnBelt`] | dry friction with sticking | `x'' + 2 zeta omega x' + omega^2 x = -n mu sign(x' - belt)` |
//! | [`TwoModesOnBelt`] | mode coupling by friction, separation | `q'' + W^2 q = -(N - n) e + mu (N - n) t`, `N = max(0, n + k e.q)` |
//! | [`DampedContact`] | a force that jumps at separation | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t) + contact`, `contact = -(k x + c x')/m` while `x < 0` |

/// Implements [`System`](squeakscope_dynamics::System) for a system with a status of one byte: its force is the law of the
/// status of the state.
macro_rules! system_of_status {
    ($system:ident, |$self:ident| $omega:expr, $damping:expr, autonomous: $autonomous:expr) => {
        impl System for $system {
            fn omega(&$self) -> &[f64] {
                $omega
            }
            fn damping(&$self) -> &[f64] {
                $damping
            }
            fn force(&$self, t: f64, z: &[f64], out: &mut [f64]) {
                $self.force_in(&[$self.status(t, z)], t, z, out);
            }
            fn switching(&$self) -> Option<&dyn Switching> {
                Some($self)
            }
            fn differentiable(&$self) -> Option<&dyn Differentiable> {
                Some($self)
            }
            fn is_autonomous(&$self) -> bool {
                $autonomous
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

/// Acceleration `a cos(W t + p)` of a drive with this amplitude, circular frequency and phase, and its time derivative.
fn drive([amplitude, omega, phase]: [f64; 3], t: f64) -> [f64; 2] {
    let (sin, cos) = (omega * t + phase).sin_cos();
    [amplitude * cos, -amplitude * omega * sin]
}

/// Force per unit mass that cancels the linear part of a mode.
fn cancelling(omega: f64, damping: f64, x: f64, v: f64) -> f64 {
    omega * omega * x + 2.0 * damping * omega * v
}

/// Applies a function of displacement and velocity to each of `width` tangent vectors of one mode.
fn map_vectors(vectors: &[f64], width: usize, out: &mut [f64], f: impl Fn(f64, f64) -> f64) {
    let (x, v) = vectors.split_at(width);
    for ((out, x), v) in out.iter_mut().zip(x).zip(v) {
        *out = f(*x, *v);
    }
}

#[cfg(test)]
mod tests;
