//! Stick-slip of a mass on a belt.

use std::slice::from_ref;

use super::{Motion, Number, Piecewise, cancelling, derivatives};
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
        self.friction(Number::<0>::number(speed)).value()
    }

    /// Derivative `dmu/dV` of the coefficient at a sliding speed (m/s), s/m.
    pub fn slope(&self, speed: f64) -> f64 {
        let [slope] = self.friction(Number::scalar(speed, 0)).slopes;
        slope.sum()
    }

    /// Coefficient of friction at a sliding speed, m/s.
    fn friction<const N: usize>(&self, speed: Number<N>) -> Number<N> {
        let Some(slope) = self.stribeck else {
            return Number::number(self.mu_d);
        };
        let fall = (speed * -slope).compose_scalar(|x| [x.exp(), x.exp()]);
        fall * (self.mu_s - self.mu_d) + self.mu_d
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
    fn sticking_force<const N: usize>(&self, x: Number<N>, v: Number<N>) -> Number<N> {
        cancelling([self.omega, self.damping], x, v)
    }

    /// Maximum friction force per unit mass while sticking, N/kg.
    fn friction_limit(&self) -> f64 {
        self.mu_s * self.load
    }

    /// Status of a state at the belt speed.
    fn status_at_rest(&self, x: f64) -> u8 {
        let [x, belt] = [x, self.belt].map(Number::<0>::number);
        let sticking_force = self.sticking_force(x, belt).value();
        if sticking_force.abs() <= self.friction_limit() {
            Self::STICKING
        } else if sticking_force > 0.0 {
            Self::SLOWER
        } else {
            Self::FASTER
        }
    }
}

implement!(MassOnBelt, 1);

impl Piecewise<1> for MassOnBelt {
    const GUARDS: usize = 2;

    fn linear(&self) -> [&[f64]; 2] {
        [from_ref(&self.omega), from_ref(&self.damping)]
    }

    fn status(&self, at: &Motion<1, 0>) -> u8 {
        let [[x], [v]] = at.z.map(|part| part.map(Number::value));
        if v < self.belt {
            Self::SLOWER
        } else if v > self.belt {
            Self::FASTER
        } else {
            self.status_at_rest(x)
        }
    }

    fn law<const N: usize>(&self, status: u8, at: &Motion<1, N>) -> [Number<N>; 1] {
        let [[x], [v]] = at.z;
        let belt = Number::number(self.belt);
        [match status {
            Self::SLOWER => self.friction(belt - v) * self.load,
            Self::FASTER => self.friction(v - belt) * -self.load,
            _ => self.sticking_force(x, v),
        }]
    }

    fn guard<const N: usize>(&self, status: u8, guard: usize, at: &Motion<1, N>) -> Number<N> {
        let [[x], [v]] = at.z;
        let [belt, limit] = [self.belt, self.friction_limit()].map(Number::number);
        match (status, guard) {
            (Self::SLOWER, Self::FORWARD) => belt - v,
            (Self::FASTER, Self::BACKWARD) => v - belt,
            (Self::STICKING, Self::BACKWARD) => limit - self.sticking_force(x, belt),
            (Self::STICKING, Self::FORWARD) => limit + self.sticking_force(x, belt),
            _ => Number::number(1.0),
        }
    }

    fn reset<const N: usize>(&self, status: &mut u8, guard: usize, at: &mut Motion<1, N>) {
        at.z[1] = [Number::number(self.belt)];
        *status = match (*status, guard) {
            (Self::STICKING, Self::BACKWARD) => Self::SLOWER,
            (Self::STICKING, _) => Self::FASTER,
            _ => self.status_at_rest(at.z[0][0].value()),
        };
    }

    fn hold<const N: usize>(&self, status: u8, at: &mut Motion<1, N>) {
        if status == Self::STICKING {
            at.z[1] = [Number::number(self.belt)];
        }
    }
}
