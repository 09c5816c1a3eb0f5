//! Stick-slip of a mass on a belt.

use std::slice::from_ref;

use super::{cancelling, map_vectors};
use squeakscope_dynamics::{Differentiable, Switching, System};

/// A mass on a spring, driven by the dry friction of a moving belt: the classical stick-slip oscillator.
///
/// ```text
/// x'' + 2 zeta omega x' + omega^2 x = -n mu(|x' - belt|) sign(x' - belt)   while it slides
/// x' = belt                                                               while it sticks
/// mu(V) = mu_d + (mu_s - mu_d) exp(-stribeck V)                            or mu_d at any speed
/// ```
///
/// It sticks while the required force per unit mass, `hold = omega^2 x + 2 zeta omega belt`, does not
/// exceed `mu_s n`. It starts to stick when it reaches the belt speed under this condition. There are
/// three statuses: it slides *back* (slower than the belt), *sticks*, or slides *ahead*. While it
/// sticks, its velocity equals that of the belt bitwise.
///
/// If friction decreases with the sliding speed, it acts on a small vibration about steady sliding as
/// negative damping, and the vibration grows at the rate [`MassOnBelt::growth`]. Without a Stribeck law,
/// undamped and with `mu_s > mu_d`, the motion converges to a limit cycle: with `D = (mu_s - mu_d) n /
/// omega^2`, it slips for `2 (pi - atan(D omega / belt)) / omega` and sticks for `2 D / belt`.
///
/// Without event location it sticks only at states whose velocity equals that of the belt exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassOnBelt {
    /// Natural circular frequency, rad/s, 0 or more.
    pub omega: f64,
    /// Damping ratio, below 1.
    pub damping: f64,
    /// Normal force per unit mass, N/kg, 0 or more.
    pub load: f64,
    /// Static coefficient of friction (while sticking); at least `mu_d`.
    pub mu_s: f64,
    /// Kinetic coefficient of friction (at high sliding speed); 0 or more.
    pub mu_d: f64,
    /// Speed of the belt, m/s.
    pub belt: f64,
    /// Stribeck constant, s/m, positive: the coefficient decreases from `mu_s` to `mu_d` as
    /// `exp(-stribeck V)`; `None` for an immediate drop.
    pub stribeck: Option<f64>,
}

impl MassOnBelt {
    /// Status: slower than the belt.
    pub const SLOWER: u8 = 0;
    /// Status: as fast as the belt.
    pub const STICKING: u8 = 1;
    /// Status: faster than the belt.
    pub const FASTER: u8 = 2;

    /// Guard of the transitions to sliding back and from sliding ahead.
    pub(super) const BACKWARD: usize = 0;
    /// Guard of the transitions to sliding ahead and from sliding back.
    pub(super) const FORWARD: usize = 1;

    /// Coefficient of friction at a sliding speed (m/s).
    pub fn coefficient(&self, speed: f64) -> f64 {
        let above = |slope: f64| (self.mu_s - self.mu_d) * (-slope * speed).exp();
        self.mu_d + self.stribeck.map_or(0.0, above)
    }

    /// Derivative `dmu/dV` of the coefficient at a sliding speed (m/s), s/m.
    pub fn slope(&self, speed: f64) -> f64 {
        let fall = |slope: f64| -slope * (self.mu_s - self.mu_d) * (-slope * speed).exp();
        self.stribeck.map_or(0.0, fall)
    }

    /// Growth rate of a small vibration about steady sliding, 1/s: `-(n mu'(belt) + 2 zeta omega) / 2`,
    /// the real part of the eigenvalue.
    pub fn growth(&self) -> f64 {
        -0.5 * (self.load * self.slope(self.belt) + 2.0 * self.damping * self.omega)
    }

    /// Circular frequency of that vibration, rad/s; 0 if it is not oscillatory.
    pub fn small_omega(&self) -> f64 {
        (self.omega.powi(2) - self.growth().powi(2)).max(0.0).sqrt()
    }

    /// Force per unit mass that sticking requires, N/kg.
    fn sticking_force(&self, x: f64, v: f64) -> f64 {
        cancelling(self.omega, self.damping, x, v)
    }

    /// Maximum friction force per unit mass while sticking, N/kg.
    fn friction_limit(&self) -> f64 {
        self.mu_s * self.load
    }

    /// Status of a state at the belt speed.
    fn status_at_rest(&self, x: f64) -> u8 {
        let sticking_force = self.sticking_force(x, self.belt);
        if sticking_force.abs() <= self.friction_limit() {
            Self::STICKING
        } else if sticking_force > 0.0 {
            Self::SLOWER
        } else {
            Self::FASTER
        }
    }

    /// Status of a state.
    fn status(&self, _t: f64, z: &[f64]) -> u8 {
        if z[1] < self.belt {
            Self::SLOWER
        } else if z[1] > self.belt {
            Self::FASTER
        } else {
            self.status_at_rest(z[0])
        }
    }
}

system_of_status!(
    MassOnBelt,
    |self| from_ref(&self.omega),
    from_ref(&self.damping),
    autonomous: true
);

impl Switching for MassOnBelt {
    fn status_of(&self, t: f64, z: &[f64], status: &mut [u8]) {
        status[0] = self.status(t, z);
    }

    fn force_in(&self, status: &[u8], _t: f64, z: &[f64], out: &mut [f64]) {
        out[0] = match status[0] {
            Self::SLOWER => self.coefficient(self.belt - z[1]) * self.load,
            Self::FASTER => -self.coefficient(z[1] - self.belt) * self.load,
            _ => self.sticking_force(z[0], z[1]),
        };
    }

    fn guards(&self) -> usize {
        2
    }

    fn guard_values(&self, status: &[u8], _t: f64, z: &[f64], values: &mut [f64]) {
        // A guard that the status does not use stays positive.
        values.fill(1.0);
        match status[0] {
            Self::SLOWER => values[Self::FORWARD] = self.belt - z[1],
            Self::FASTER => values[Self::BACKWARD] = z[1] - self.belt,
            _ => {
                let sticking_force = self.sticking_force(z[0], self.belt);
                values[Self::BACKWARD] = self.friction_limit() - sticking_force;
                values[Self::FORWARD] = self.friction_limit() + sticking_force;
            }
        }
    }

    fn cross(&self, guard: usize, _t: f64, z: &mut [f64], status: &mut [u8]) {
        z[1] = self.belt;
        status[0] = match (status[0], guard) {
            (Self::STICKING, Self::BACKWARD) => Self::SLOWER,
            (Self::STICKING, _) => Self::FASTER,
            _ => self.status_at_rest(z[0]),
        };
    }

    /// The velocity becomes that of the belt.
    fn reset_tangents(
        &self,
        _status: &[u8],
        _guard: usize,
        _t: f64,
        _z: &[f64],
        (vectors, width, _rate): (&mut [f64], usize, f64),
    ) {
        vectors[width..].fill(0.0);
    }

    fn settle(&self, status: &[u8], _t: f64, z: &mut [f64], tangents: (&mut [f64], usize)) {
        if status[0] == Self::STICKING {
            z[1] = self.belt;
            tangents.0[tangents.1..].fill(0.0);
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
        let stiffness = self.omega * self.omega;
        gradient.copy_from_slice(&match status[0] {
            Self::SLOWER => [0.0, -1.0],
            Self::FASTER => [0.0, 1.0],
            _ => [sign * stiffness, 0.0],
        });
        0.0
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
        let status =
            status.map_or_else(|| self.status(record[0], &record[1..]), |status| status[0]);
        let slope = self.load * self.slope((record[2] - self.belt).abs());
        map_vectors(vectors, width, out, |x, v| {
            if status == Self::STICKING {
                self.sticking_force(x, v)
            } else {
                -slope * v
            }
        });
    }
}
