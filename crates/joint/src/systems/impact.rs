//! A driven impact oscillator.

use std::slice::from_ref;

use super::{Motion, Number, Piecewise, cancelling, derivatives, drive};
use squeakscope_dynamics::{Differentiable, Switching, System};

/// A driven oscillator with impacts on a rigid wall.
///
/// ```text
/// x'' + 2 zeta omega x' + omega^2 x = a cos(W t + p)       x > wall
/// v+ = -r v-                                           at x = wall
/// ```
///
/// With zero natural frequency and zero drive frequency it is a ball that bounces on a floor under the
/// gravitational acceleration `-a`.
///
/// If it is pressed against the wall, an infinite sequence of impacts ends in finite time, and the mass
/// rests on the wall until the contact force falls to zero. There are two statuses: *flying* and
/// *resting*. An impact ends the sequence if the next flight would be too short, of duration `2 v+ /
/// press`, or too low, of height `v+^2 / (2 press)`: if its change from bounce to bounce is smaller than
/// the rounding of the time or of the wall position. With the wall at zero only the duration counts.
///
/// The wall is implemented as a reset map and therefore requires event location.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactOscillator {
    /// Natural circular frequency, rad/s, 0 or more.
    pub omega: f64,
    /// Damping ratio, below 1.
    pub damping: f64,
    /// Amplitude of the drive acceleration, m/s^2.
    pub drive: f64,
    /// Circular frequency of the drive, rad/s.
    pub drive_omega: f64,
    /// Phase `p` of the drive, rad: a run whose drive frequency changes shifts it, so that the drive is continuous.
    pub drive_phase: f64,
    /// Position of the wall, m: the mass moves at or above it.
    pub wall: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
}

/// Relative rounding error of the time of an impact and of the position there: a few units in the last
/// place each, times ten.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Minimum fraction of its energy that an impact is assumed to lose. Near an elastic wall the flights
/// shrink so slowly that too many are needed to reach the rounding.
const MIN_LOSS: f64 = 1e-3;

impl ImpactOscillator {
    /// Status: above the wall, or at an impact.
    pub const FLYING: u8 = 0;
    /// Status: at rest on the wall under a positive contact force.
    pub const RESTING: u8 = 1;

    /// Contact force per unit mass at rest on the wall at a time (s), m/s^2; negative if the mass is pulled away.
    fn contact_force<const N: usize>(&self, t: Number<N>) -> Number<N> {
        Number::number(self.omega * self.omega * self.wall) - self.drive_at(t)
    }

    /// Drive acceleration at a time (s), m/s^2.
    fn drive_at<const N: usize>(&self, t: Number<N>) -> Number<N> {
        drive([self.drive, self.drive_omega, self.drive_phase], t)
    }

    /// Whether the sequence of impacts ends with one at time `t` (s) after which the velocity would be `after` (m/s).
    fn ends(&self, t: f64, after: f64) -> bool {
        let contact_force = self.contact_force(Number::<0>::number(t)).value();
        // A flight whose loss per bounce equals the rounding would repeat forever. Only the next flight
        // is compared: an elastic wall returns all energy.
        let loss = 1.0 - self.restitution * self.restitution;
        let least = ROUNDING / loss.max(MIN_LOSS);
        let too_short = 2.0 * after <= least * t.abs() * contact_force;
        let too_low = after * after <= least * self.wall.abs() * 2.0 * contact_force;
        contact_force > 0.0 && (too_short || too_low)
    }
}

implement!(ImpactOscillator, 1);

impl Piecewise<1> for ImpactOscillator {
    fn linear(&self) -> [&[f64]; 2] {
        [from_ref(&self.omega), from_ref(&self.damping)]
    }

    fn is_autonomous(&self) -> bool {
        self.drive == 0.0 || self.drive_omega == 0.0
    }

    fn status(&self, at: &Motion<1, 0>) -> u8 {
        let [[x], [v]] = at.z.map(|part| part.map(Number::value));
        if x == self.wall && v == 0.0 && self.contact_force(at.t).value() > 0.0 {
            Self::RESTING
        } else {
            Self::FLYING
        }
    }

    fn law<const N: usize>(&self, status: u8, at: &Motion<1, N>) -> [Number<N>; 1] {
        let [[x], [v]] = at.z;
        [match status {
            Self::RESTING => cancelling([self.omega, self.damping], x, v),
            _ => self.drive_at(at.t),
        }]
    }

    fn guard<const N: usize>(&self, status: u8, _guard: usize, at: &Motion<1, N>) -> Number<N> {
        match status {
            Self::RESTING => self.contact_force(at.t),
            _ => at.z[0][0] + -self.wall,
        }
    }

    fn reset<const N: usize>(&self, status: &mut u8, _guard: usize, at: &mut Motion<1, N>) {
        if *status == Self::RESTING {
            *status = Self::FLYING;
            return;
        }
        let [[x], [v]] = &mut at.z;
        *x = Number::number(self.wall);
        if v.value() < 0.0 {
            *v = *v * -self.restitution;
        }
        if self.ends(at.t.value(), v.value()) {
            *status = Self::RESTING;
            *v = Number::number(0.0);
        }
    }

    fn hold<const N: usize>(&self, status: u8, at: &mut Motion<1, N>) {
        if status == Self::RESTING {
            at.z = [[Number::number(self.wall)], [Number::number(0.0)]];
        }
    }
}
