//! Small systems with known motions: what the engine is tested by, and what small scenes show.
//!
//! | system | what it has | its law |
//! |---|---|---|
//! | [`ImpactOscillator`] | a reset: the velocity turns round at a wall | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t)`, `x >= wall`, `v+ = -r v-` |
//! | [`MassOnBelt`] | a force with a sign, and true sticking | `x'' + 2 zeta omega x' + omega^2 x = -n mu sign(x' - belt)` |
//! | [`DampedContact`] | a force that jumps at lift-off | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t) + contact`, `contact = -(k x + c x')/m` while `x < 0` |

mod belt;
mod damped_contact;
mod impact;

pub use belt::MassOnBelt;
pub use damped_contact::DampedContact;
pub use impact::ImpactOscillator;
