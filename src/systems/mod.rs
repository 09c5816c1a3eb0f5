//! Small systems with known motions: what the engine is tested by, and what small scenes show.
//!
//! | system | what it has | its law |
//! |---|---|---|
//! | [`ImpactOscillator`] | a reset: the velocity turns round at a wall | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t)`, `x >= wall`, `v+ = -r v-` |
//! | [`MassOnBelt`] | a force with a sign, and true sticking | `x'' + 2 zeta omega x' + omega^2 x = -n mu sign(x' - belt)` |
//! | [`DampedContact`] | a force that jumps at lift-off | `x'' + 2 zeta omega x' + omega^2 x = a cos(W t) + contact`, `contact = -(k x + c x')/m` while `x < 0` |

/// A driven oscillator with a wall that it bounces off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactOscillator {
    /// Natural circular frequency, rad/s.
    pub omega: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Amplitude of the driving acceleration, m/s^2.
    pub drive: f64,
    /// Circular frequency of the drive, rad/s.
    pub drive_omega: f64,
    /// Where the wall is, m: the mass moves at or above it.
    pub wall: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
}

/// A mass on a spring that a belt drags along, with dry friction: the textbook stick-slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassOnBelt {
    /// Natural circular frequency, rad/s.
    pub omega: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Normal force by the mass, N/kg.
    pub load: f64,
    /// Static coefficient of friction: holds while sticking.
    pub mu_s: f64,
    /// Kinetic coefficient of friction: holds while sliding, at any speed.
    pub mu_d: f64,
    /// Speed of the belt, m/s.
    pub belt: f64,
}

/// A driven oscillator that meets a spring with a damper: as it leaves, the force of the damper
/// jumps to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedContact {
    /// Natural circular frequency, rad/s.
    pub omega: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Amplitude of the driving acceleration, m/s^2.
    pub drive: f64,
    /// Circular frequency of the drive, rad/s.
    pub drive_omega: f64,
    /// Stiffness of the contact by the mass, 1/s^2.
    pub contact_stiffness: f64,
    /// Damping of the contact by the mass, 1/s.
    pub contact_damping: f64,
}
