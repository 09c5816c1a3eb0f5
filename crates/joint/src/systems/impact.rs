//! A driven impact oscillator.

use std::slice::from_ref;

use super::{cancelling, drive, map_vectors};
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

    /// Drive acceleration at time `t` (s), m/s^2, and its time derivative.
    fn drive_at(&self, t: f64) -> [f64; 2] {
        drive([self.drive, self.drive_omega, self.drive_phase], t)
    }

    /// Contact force per unit mass at rest on the wall, m/s^2; negative if the mass is pulled away.
    fn contact_force(&self, t: f64) -> f64 {
        self.omega * self.omega * self.wall - self.drive_at(t)[0]
    }

    /// Force per unit mass that keeps it at rest.
    fn resting_force(&self, x: f64, v: f64) -> f64 {
        cancelling(self.omega, self.damping, x, v)
    }

    /// Status of a state.
    fn status(&self, t: f64, z: &[f64]) -> u8 {
        if z[0] == self.wall && z[1] == 0.0 && self.contact_force(t) > 0.0 {
            Self::RESTING
        } else {
            Self::FLYING
        }
    }

    /// Velocity after reaching the wall at time `t` (s) with velocity `v`, m/s; `None` if the sequence
    /// of impacts ends.
    fn velocity_after_impact(&self, t: f64, v: f64) -> Option<f64> {
        let after = if v < 0.0 { -self.restitution * v } else { v };
        let contact_force = self.contact_force(t);
        // A flight whose loss per bounce equals the rounding would repeat forever. Only the next flight
        // is compared: an elastic wall returns all energy.
        let loss = 1.0 - self.restitution * self.restitution;
        let least = ROUNDING / loss.max(MIN_LOSS);
        let too_short = 2.0 * after <= least * t.abs() * contact_force;
        let too_low = after * after <= least * self.wall.abs() * 2.0 * contact_force;
        let ends = contact_force > 0.0 && (too_short || too_low);
        (!ends).then_some(after)
    }
}

system_of_status!(
    ImpactOscillator,
    |self| from_ref(&self.omega),
    from_ref(&self.damping),
    autonomous: self.drive == 0.0 || self.drive_omega == 0.0
);

impl Switching for ImpactOscillator {
    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        status[0] = self.status(t, z);
    }

    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = match status[0] {
            Self::RESTING => self.resting_force(z[0], z[1]),
            _ => self.drive_at(t)[0],
        };
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]) {
        values[0] = match status[0] {
            Self::RESTING => self.contact_force(t),
            _ => z[0] - self.wall,
        };
    }

    fn cross(&self, _guard: usize, t: f64, z: &mut [f64], status: &mut [u8]) {
        if status[0] == Self::RESTING {
            status[0] = Self::FLYING;
            return;
        }
        z[0] = self.wall;
        z[1] = self.velocity_after_impact(t, z[1]).unwrap_or_else(|| {
            status[0] = Self::RESTING;
            0.0
        });
    }

    fn settle(&self, status: &[u8], _t: f64, z: &mut [f64], tangents: (&mut [f64], usize)) {
        if status[0] == Self::RESTING {
            z.copy_from_slice(&[self.wall, 0.0]);
            tangents.0.fill(0.0);
        }
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        _guard: usize,
        t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        if status[0] == Self::RESTING {
            gradient.fill(0.0);
            -self.drive_at(t)[1]
        } else {
            gradient.copy_from_slice(&[1.0, 0.0]);
            0.0
        }
    }

    /// The wall is at rest: nothing depends on time.
    fn reset_tangents(
        &self,
        status: &[u8],
        _guard: usize,
        t: f64,
        z: &[f64],
        (vectors, width, _rate): (&mut [f64], usize, f64),
    ) {
        if status[0] == Self::RESTING {
            return;
        }
        let slope = match self.velocity_after_impact(t, z[1]) {
            Some(_) if z[1] < 0.0 => -self.restitution,
            Some(_) => 1.0,
            None => 0.0,
        };
        let (x, v) = vectors.split_at_mut(width);
        x.fill(0.0);
        v.iter_mut().for_each(|v| *v *= slope);
    }
}

impl Differentiable for ImpactOscillator {
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
        let is_resting = status == Self::RESTING;
        map_vectors(vectors, width, out, |x, v| {
            if is_resting {
                self.resting_force(x, v)
            } else {
                0.0
            }
        });
    }

    fn time_derivative(&self, status: Option<&[u8]>, t: f64, _z: &[f64], out: &mut [f64]) {
        out[0] = match status {
            Some([Self::RESTING]) => 0.0,
            _ => self.drive_at(t)[1],
        };
    }
}
