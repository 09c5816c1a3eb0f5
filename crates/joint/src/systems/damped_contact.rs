//! A contact whose force jumps at separation.

use std::slice::from_ref;

use super::{Motion, Number, Piecewise, derivatives, drive};
use squeakscope_dynamics::{Differentiable, Switching, System};

/// A driven oscillator with a unilateral spring and damper. At separation the damper force jumps to
/// zero.
///
/// ```text
/// x'' + 2 zeta omega x' + omega^2 x = a cos(W t + p)                   x > 0
///                                   = a cos(W t + p) - k x - c x'      x < 0
/// ```
///
/// There are two statuses: *free* and *touching*. The force jumps by `c x'` at both ends of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedContact {
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
    /// Contact stiffness per unit mass, 1/s^2, 0 or more.
    pub contact_stiffness: f64,
    /// Contact damping per unit mass, 1/s, 0 or more.
    pub contact_damping: f64,
}

impl DampedContact {
    /// Status: no contact.
    pub const FREE: u8 = 0;
    /// Status: in contact.
    pub const TOUCHING: u8 = 1;

    /// Drive acceleration at a time (s), m/s^2.
    fn drive_at<const N: usize>(&self, t: Number<N>) -> Number<N> {
        drive([self.drive, self.drive_omega, self.drive_phase], t)
    }
}

implement!(DampedContact, 1);

impl Piecewise<1> for DampedContact {
    fn linear(&self) -> [&[f64]; 2] {
        [from_ref(&self.omega), from_ref(&self.damping)]
    }

    fn is_autonomous(&self) -> bool {
        self.drive == 0.0 || self.drive_omega == 0.0
    }

    /// By the position or, at zero, by the direction of the motion.
    fn status(&self, at: &Motion<1, 0>) -> u8 {
        let [[x], [v]] = at.z;
        let ways = [x, v, self.drive_at(at.t)].map(Number::value);
        let first = ways.into_iter().find(|&x| x != 0.0);
        if first.is_some_and(|x| x < 0.0) {
            Self::TOUCHING
        } else {
            Self::FREE
        }
    }

    fn law<const N: usize>(&self, status: u8, at: &Motion<1, N>) -> [Number<N>; 1] {
        let ([[x], [v]], drive) = (at.z, self.drive_at(at.t));
        [match status {
            Self::TOUCHING => drive + (x * -self.contact_stiffness - v * self.contact_damping),
            _ => drive,
        }]
    }

    fn guard<const N: usize>(&self, status: u8, _guard: usize, at: &Motion<1, N>) -> Number<N> {
        let [[x], _] = at.z;
        match status {
            Self::TOUCHING => x * -1.0,
            _ => x,
        }
    }

    fn reset<const N: usize>(&self, status: &mut u8, _guard: usize, _at: &mut Motion<1, N>) {
        // The other one of the two statuses, 0 and 1.
        *status = 1 - *status;
    }
}
