//! A contact whose force jumps at separation.

use std::slice::from_ref;

use super::{drive, map_vectors};
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

    /// Drive acceleration at time `t` (s), m/s^2, and its time derivative.
    fn drive_at(&self, t: f64) -> [f64; 2] {
        drive([self.drive, self.drive_omega, self.drive_phase], t)
    }

    /// Contact force per unit mass, m/s^2.
    fn contact_force(&self, x: f64, v: f64) -> f64 {
        -self.contact_stiffness * x - self.contact_damping * v
    }

    /// Status of a state, by its position or, at zero, by the direction of its motion.
    fn status(&self, t: f64, z: &[f64]) -> u8 {
        let first = [z[0], z[1], self.drive_at(t)[0]]
            .into_iter()
            .find(|&x| x != 0.0);
        if first.is_some_and(|x| x < 0.0) {
            Self::TOUCHING
        } else {
            Self::FREE
        }
    }
}

system_of_status!(
    DampedContact,
    |self| from_ref(&self.omega),
    from_ref(&self.damping),
    autonomous: self.drive == 0.0 || self.drive_omega == 0.0
);

impl Switching for DampedContact {
    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        status[0] = self.status(t, z);
    }

    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = self.drive_at(t)[0];
        if status[0] == Self::TOUCHING {
            out[0] += self.contact_force(z[0], z[1]);
        }
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        values[0] = match status[0] {
            Self::TOUCHING => -z[0],
            _ => z[0],
        };
    }

    fn cross(&self, _guard: usize, _t: f64, _z: &mut [f64], status: &mut [u8]) {
        status[0] = match status[0] {
            Self::TOUCHING => Self::FREE,
            _ => Self::TOUCHING,
        };
    }

    /// The state does not jump.
    fn reset_tangents(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        _tangents: (&mut [f64], usize, f64),
    ) {
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let slope = match status[0] {
            Self::TOUCHING => -1.0,
            _ => 1.0,
        };
        gradient.copy_from_slice(&[slope, 0.0]);
        0.0
    }
}

impl Differentiable for DampedContact {
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let status =
            status.map_or_else(|| self.status(record[0], &record[1..]), |status| status[0]);
        if status != Self::TOUCHING {
            return out.fill(0.0);
        }
        map_vectors(vectors, width, out, |x, v| self.contact_force(x, v));
    }

    fn time_derivative(&self, _status: Option<&[u8]>, t: f64, _z: &[f64], out: &mut [f64]) {
        out[0] = self.drive_at(t)[1];
    }
}
