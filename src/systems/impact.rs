//! A driven oscillator with a wall.

use std::slice::from_ref;

use crate::dynamics::{Differentiable, Switching, System};

/// A driven oscillator with a wall that it bounces off.
///
/// ```text
/// x'' + 2 zeta omega x' + omega^2 x = a cos(W t)       x > wall
/// v+ = -r v-                                           at x = wall
/// ```
///
/// Without stiffness, and with a drive of circular frequency zero, it is a ball that bounces on a
/// floor under the gravity `-a`.
///
/// Pressed against the wall, it bounces infinitely often in a finite time, and then rests there
/// until the force that presses it falls through zero. Two statuses therefore: *flying* and
/// *resting*. A rebound counts as the last one if the next flight would be too brief, `2 v+ / press`,
/// or too low, `v+^2 / (2 press)`: if the rounding of the time, or of the wall's place, would make more
/// of a difference to it than a bounce does. With the wall at zero only the time counts.
///
/// The wall is met by a reset map, so that it is there only where steps stop at events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactOscillator {
    /// Natural circular frequency, rad/s, 0 or more.
    pub omega: f64,
    /// Damping ratio, below 1.
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

/// Rounding of the time of an impact, and of the place found there, relative to time and place: some
/// units in the last place each, and ten times that.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Share of its energy that a bounce counts as losing at least. The flights of a wall that is nearly
/// elastic shrink so slowly that it takes too many to come down to rounding.
const LEAST_LOSS: f64 = 1e-3;

impl ImpactOscillator {
    /// Status: above the wall, or just bouncing off.
    pub const FLYING: u8 = 0;
    /// Status: at rest on the wall, pressed against it.
    pub const RESTING: u8 = 1;

    /// The driving acceleration at time `t` (s), m/s^2.
    fn push(&self, t: f64) -> f64 {
        self.drive * (self.drive_omega * t).cos()
    }

    /// The force by the mass that presses the mass at rest against the wall, m/s^2; negative where
    /// it is drawn away.
    fn press(&self, t: f64) -> f64 {
        self.omega * self.omega * self.wall - self.push(t)
    }

    /// The force by the mass that holds it at rest: it cancels the linear part.
    fn hold(&self, x: f64, v: f64) -> f64 {
        self.omega * self.omega * x + 2.0 * self.damping * self.omega * v
    }

    /// The velocity after meeting the wall at time `t` (s) with velocity `v`, m/s; `None` where the
    /// bouncing ends.
    fn rebound(&self, t: f64, v: f64) -> Option<f64> {
        let after = if v < 0.0 { -self.restitution * v } else { v };
        let press = self.press(t);
        // Rounding that gives a flight as much as its bounce took keeps it from shrinking, for ever. But
        // only the next flight counts: an elastic wall returns all that it gets.
        let loss = 1.0 - self.restitution * self.restitution;
        let least = ROUNDING / loss.max(LEAST_LOSS);
        let brief = 2.0 * after <= least * t.abs() * press;
        let low = after * after <= least * self.wall.abs() * 2.0 * press;
        let ends = press > 0.0 && (brief || low);
        (!ends).then_some(after)
    }
}

impl System for ImpactOscillator {
    fn omega(&self) -> &[f64] {
        from_ref(&self.omega)
    }

    fn damping(&self) -> &[f64] {
        from_ref(&self.damping)
    }

    fn force(&self, t: f64, _z: &[f64], out: &mut [f64]) {
        out[0] = self.push(t);
    }

    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }

    fn is_autonomous(&self) -> bool {
        self.drive == 0.0 || self.drive_omega == 0.0
    }
}

impl Switching for ImpactOscillator {
    fn status_len(&self) -> usize {
        1
    }

    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        let rests = z[0] == self.wall && z[1] == 0.0 && self.press(t) > 0.0;
        status[0] = if rests { Self::RESTING } else { Self::FLYING };
    }

    fn force_in(&self, status: &[u8], t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = match status[0] {
            Self::RESTING => self.hold(z[0], z[1]),
            _ => self.push(t),
        };
    }

    fn guards(&self) -> usize {
        1
    }

    fn guard_values(&self, status: &[u8], t: f64, z: &[f64], values: &mut [f64]) {
        values[0] = match status[0] {
            Self::RESTING => self.press(t),
            _ => z[0] - self.wall,
        };
    }

    fn cross(&self, _guard: usize, t: f64, z: &mut [f64], status: &mut [u8]) {
        if status[0] == Self::RESTING {
            status[0] = Self::FLYING;
            return;
        }
        z[0] = self.wall;
        z[1] = self.rebound(t, z[1]).unwrap_or_else(|| {
            status[0] = Self::RESTING;
            0.0
        });
    }

    fn settle(&self, status: &[u8], _t: f64, z: &mut [f64]) {
        if status[0] == Self::RESTING {
            z.copy_from_slice(&[self.wall, 0.0]);
        }
    }

    fn settle_tangents(&self, status: &[u8], vectors: &mut [f64], _width: usize) {
        if status[0] == Self::RESTING {
            vectors.fill(0.0);
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
            self.drive * self.drive_omega * (self.drive_omega * t).sin()
        } else {
            gradient.copy_from_slice(&[1.0, 0.0]);
            0.0
        }
    }

    fn reset_tangents(
        &self,
        status: &[u8],
        _guard: usize,
        t: f64,
        z: &[f64],
        (vectors, width): (&mut [f64], usize),
    ) {
        if status[0] == Self::RESTING {
            return;
        }
        let slope = match self.rebound(t, z[1]) {
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
        _record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        match status {
            Some([Self::RESTING]) => {
                let (x, v) = vectors.split_at(width);
                for ((out, x), v) in out.iter_mut().zip(x).zip(v) {
                    *out = self.hold(*x, *v);
                }
            }
            _ => out.fill(0.0),
        }
    }

    fn time_derivative(&self, status: Option<&[u8]>, t: f64, _z: &[f64], out: &mut [f64]) {
        out[0] = match status {
            Some([Self::RESTING]) => 0.0,
            _ => -self.drive * self.drive_omega * (self.drive_omega * t).sin(),
        };
    }
}
