//! Small reference systems with known behaviour, used in small scenes and in tests of the integrators.
//!
//! | system | property | equations |
//! |---|---|---|
//! | [`ImpactOscillator`] | impacts: the velocity is reversed at a wall | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t)`, `x >= wall`, `v+ = -r v-` |
//! | [`MassOnBelt`] | dry friction with sticking | `x'' + 2 zeta omega x' + omega^2 x = -n mu sign(x' - belt)` |
//! | [`TwoModesOnBelt`] | mode coupling by friction, separation | `q'' + W^2 q = -(N - n) e + mu (N - n) t`, `N = max(0, n + k e.q)` |
//! | [`DampedContact`] | a force that jumps at separation | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t) + contact`, `contact = -(k x + c x')/m` while `x < 0` |

mod belt;
mod damped_contact;
mod impact;
mod two_modes;

pub use belt::MassOnBelt;
pub use damped_contact::DampedContact;
pub use impact::ImpactOscillator;
pub use two_modes::{CoupledMode, TwoModesOnBelt};

#[cfg(test)]
mod tests;
