//! Stick-slip of a mass on a belt.

use std::slice::from_ref;

use crate::dynamics::{Differentiable, Switching, System};

/// A mass on a spring that a belt drags along, with dry friction: the textbook stick-slip.
///
/// ```text
/// x'' + 2 zeta omega x' + omega^2 x = -n mu(|x' - belt|) sign(x' - belt)   while it slides
/// x' = belt                                                               while it sticks
/// mu(V) = mu_d + (mu_s - mu_d) exp(-stribeck V)                            or mu_d at any speed
/// ```
///
/// It sticks as long as the force that this takes, `hold = omega^2 x + 2 zeta omega belt`, is at
/// most `mu_s n`, and starts to stick where it comes to the belt's speed with no more than that.
/// Three statuses therefore: it slides *back* (slower than the belt), *sticks*, or slides *ahead*.
/// While it sticks, its velocity is that of the belt to the last bit.
///
/// Where friction falls with the speed it feeds a small vibration about steady sliding, as a negative
/// damping would: it grows at the rate [`MassOnBelt::growth`]. Where it falls at once instead,
/// undamped and with `mu_s > mu_d`, it comes to a cycle: with `D = (mu_s - mu_d) n / omega^2`, it
/// slips for `2 (pi - atan(D omega / belt)) / omega` and sticks for `2 D / belt`.
///
/// Where steps do not stop at events, it sticks only at states where its velocity is exactly that of
/// the belt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassOnBelt {
    /// Natural circular frequency, rad/s, 0 or more.
    pub omega: f64,
    /// Damping ratio, below 1.
    pub damping: f64,
    /// Normal force by the mass, N/kg, 0 or more.
    pub load: f64,
    /// Static coefficient of friction: holds while sticking; at least `mu_d`.
    pub mu_s: f64,
    /// Kinetic coefficient of friction: holds while sliding fast; 0 or more.
    pub mu_d: f64,
    /// Speed of the belt, m/s.
    pub belt: f64,
    /// Slope factor, s/m, positive, by which the coefficient falls from `mu_s` to `mu_d` with the
    /// sliding speed; `None` where it falls at once.
    pub stribeck: Option<f64>,
}

impl MassOnBelt {
    /// Status: slower than the belt.
    pub const BACK: u8 = 0;
    /// Status: as fast as the belt.
    pub const STICKS: u8 = 1;
    /// Status: faster than the belt.
    pub const AHEAD: u8 = 2;

    /// The guard by which the mass comes to slide back, or ceases to slide ahead.
    const BACKWARD: usize = 0;
    /// The guard by which the mass comes to slide ahead, or ceases to slide back.
    const FORWARD: usize = 1;

    /// The coefficient of friction while it slides at a speed (m/s) against the belt.
    pub fn coefficient(&self, speed: f64) -> f64 {
        let above = |slope: f64| (self.mu_s - self.mu_d) * (-slope * speed).exp();
        self.mu_d + self.stribeck.map_or(0.0, above)
    }

    /// `dmu/dV` there, s/m.
    pub fn slope(&self, speed: f64) -> f64 {
        let fall = |slope: f64| -slope * (self.mu_s - self.mu_d) * (-slope * speed).exp();
        self.stribeck.map_or(0.0, fall)
    }

    /// Rate at which a small vibration about steady sliding grows, 1/s:
    /// `-(n mu'(belt) + 2 zeta omega) / 2`, the real part of the eigenvalue.
    pub fn growth(&self) -> f64 {
        -0.5 * (self.load * self.slope(self.belt) + 2.0 * self.damping * self.omega)
    }

    /// Circular frequency of that vibration, rad/s; 0 where it creeps away without swinging.
    pub fn small_omega(&self) -> f64 {
        (self.omega.powi(2) - self.growth().powi(2)).max(0.0).sqrt()
    }

    /// The force by the mass that cancels the linear part, N/kg: what sticking takes.
    fn hold(&self, x: f64, v: f64) -> f64 {
        self.omega * self.omega * x + 2.0 * self.damping * self.omega * v
    }

    /// The force by the mass up to which it sticks, N/kg.
    fn grip(&self) -> f64 {
        self.mu_s * self.load
    }

    /// The status at the speed of the belt.
    fn status_at_rest(&self, x: f64) -> u8 {
        let hold = self.hold(x, self.belt);
        if hold.abs() <= self.grip() {
            Self::STICKS
        } else if hold > 0.0 {
            Self::BACK
        } else {
            Self::AHEAD
        }
    }

    /// The status in a state.
    fn status(&self, z: &[f64]) -> u8 {
        if z[1] < self.belt {
            Self::BACK
        } else if z[1] > self.belt {
            Self::AHEAD
        } else {
            self.status_at_rest(z[0])
        }
    }
}

impl System for MassOnBelt {
    fn omega(&self) -> &[f64] {
        from_ref(&self.omega)
    }

    fn damping(&self) -> &[f64] {
        from_ref(&self.damping)
    }

    fn force(&self, t: f64, z: &[f64], out: &mut [f64]) {
        self.force_in(&[self.status(z)], t, z, out);
    }

    fn switching(&self) -> Option<&dyn Switching> {
        Some(self)
    }

    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
}

impl Switching for MassOnBelt {
    fn status_len(&self) -> usize {
        1
    }

    fn status_of(&self, _t: f64, z: &[f64], status: &mut [u8]) {
        status[0] = self.status(z);
    }

    fn force_in(&self, status: &[u8], _t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = match status[0] {
            Self::BACK => self.coefficient(self.belt - z[1]) * self.load,
            Self::AHEAD => -self.coefficient(z[1] - self.belt) * self.load,
            _ => self.hold(z[0], z[1]),
        };
    }

    fn guards(&self) -> usize {
        2
    }

    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        // A guard that a status does not need never falls.
        values.fill(1.0);
        match status[0] {
            Self::BACK => values[Self::FORWARD] = self.belt - z[1],
            Self::AHEAD => values[Self::BACKWARD] = z[1] - self.belt,
            _ => {
                let hold = self.hold(z[0], self.belt);
                values[Self::BACKWARD] = self.grip() - hold;
                values[Self::FORWARD] = self.grip() + hold;
            }
        }
    }

    fn cross(&self, guard: usize, _t: f64, z: &mut [f64], status: &mut [u8]) {
        z[1] = self.belt;
        status[0] = match (status[0], guard) {
            (Self::STICKS, Self::BACKWARD) => Self::BACK,
            (Self::STICKS, _) => Self::AHEAD,
            _ => self.status_at_rest(z[0]),
        };
    }

    fn settle(&self, status: &[u8], _t: f64, z: &mut [f64]) {
        if status[0] == Self::STICKS {
            z[1] = self.belt;
        }
    }

    fn settle_tangents(&self, status: &[u8], vectors: &mut [f64], width: usize) {
        if status[0] == Self::STICKS {
            vectors[width..].fill(0.0);
        }
    }

    fn guard_gradient(
        &self,
        status: &[u8],
        guard: usize,
        _t: f64,
        _z: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let sign = if guard == Self::FORWARD { 1.0 } else { -1.0 };
        let of_hold = self.omega * self.omega;
        gradient.copy_from_slice(&match status[0] {
            Self::BACK => [0.0, -1.0],
            Self::AHEAD => [0.0, 1.0],
            _ => [sign * of_hold, 0.0],
        });
        0.0
    }

    fn reset_tangents(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        (vectors, width): (&mut [f64], usize),
    ) {
        vectors[width..].fill(0.0);
    }
}

impl Differentiable for MassOnBelt {
    fn product(
        &self,
        status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let status = status.map_or_else(|| self.status(&record[1..]), |status| status[0]);
        let (x, v) = vectors.split_at(width);
        if status != Self::STICKS {
            let slope = self.load * self.slope((record[2] - self.belt).abs());
            for (out, v) in out.iter_mut().zip(v) {
                *out = -slope * v;
            }
            return;
        }
        for ((out, x), v) in out.iter_mut().zip(x).zip(v) {
            *out = self.hold(*x, *v);
        }
    }
}
