//! Small reference systems with known behaviour, used in tests and small scenes.
//!
//! | system | property | equations |
//! |---|---|---|
//! | [`ImpactOscillator`] | impacts: the velocity is reversed at a wall | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t)`, `x >= wall`, `v+ = -r v-` |
//! | [`MassOnBelt`] | dry friction with sticking | `x'' + 2 zeta omega x' + omega^2 x = -n mu sign(x' - belt)` |
//! | [`TwoModesOnBelt`] | mode coupling by friction, separation | `q'' + W^2 q = -(N - n) e + mu (N - n) t`, `N = max(0, n + k e.q)` |
//! | [`DampedContact`] | a force that jumps at separation | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t) + contact`, `contact = -(k x + c x')/m` while `x < 0` |
//! | [`Lorenz`] | chaos, known sum of exponents | `x' = sigma (y - x)`, `y' = x (rho - z) - y`, `z' = x y - beta z` |
//! | [`Roessler`] | chaos | `x' = -y - z`, `y' = x + a y`, `z' = b + z (x - c)` |
//! | [`HenonHeiles`] | energy conservation, exponents in pairs | `x'' + x = -2 x y`, `y'' + y = y^2 - x^2` |

mod belt;
mod damped_contact;
mod henon_heiles;
mod impact;
mod lorenz;
mod roessler;
mod two_modes;

pub use belt::MassOnBelt;
pub use damped_contact::DampedContact;
pub use henon_heiles::HenonHeiles;
pub use impact::ImpactOscillator;
pub use lorenz::Lorenz;
pub use roessler::Roessler;
pub use two_modes::{CoupledMode, TwoModesOnBelt};

#[cfg(test)]
mod tests;
