//! Friction laws with an internal state at each contact node: LuGre, and rate-and-state friction.
//!
//! A law gives the friction force divided by the normal force, `-c(V, s)`, and the rate of the state, `ds/dt =
//! g(V, s)`, for a slip velocity `V` and a state `s` without unit. Neither depends on the normal force, so that
//! the force of a node remains proportional to it. The state of a separated node follows the slip velocity, too.

use pulp::{Scalar, Simd};

use super::dual::Dual;
use super::friction::{ContactLaw, sliding, slip_speed};

/// Largest number of contact nodes of a scene whose friction has states. The effort of linear stability and of implicit
/// steps increases with the cube of their number.
pub const MAX_NODES_WITH_STATES: usize = 400;

/// LuGre friction: elastic bristles that bend before the contact slides. C. Canudas de Wit, H. Olsson, K. J. Astrom,
/// P. Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419. The state is `s = sigma_0 z`, the share of the
/// coefficient that the deflection `z` of the bristles carries, a vector in the axes of the slip velocity:
///
/// ```text
/// ds/dt = sigma_0 (V - |V| s / mu(|V|))
/// c     = s + (sigma_1 / sigma_0) ds/dt + sigma_2 V
/// mu(V) = mu_d + (mu_s - mu_d) exp(-stribeck V)
/// ```
///
/// In steady sliding `c = mu(V) + sigma_2 V`. At a constant normal force the law is passive, with the storage function
/// `N s^2 / (2 sigma_0)`, while `sigma_1 |V| <= 4 mu(|V|)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuGre {
    /// Coefficient `mu_s` of slow steady sliding, positive.
    pub mu_s: f64,
    /// Coefficient `mu_d` of fast steady sliding, positive.
    pub mu_d: f64,
    /// Slope factor of the decrease from `mu_s` to `mu_d`, s/m, non-negative.
    pub stribeck: f64,
    /// Stiffness `sigma_0` of the bristles per normal force, 1/m, positive.
    pub stiffness: f64,
    /// Damping `sigma_1` of the bristles per normal force, s/m, non-negative.
    pub damping: f64,
    /// Viscous friction `sigma_2` per normal force, s/m, non-negative.
    pub viscous: f64,
}

impl LuGre {
    /// `mu_s`, `mu_d` and the Stribeck slope factor.
    fn curve(&self) -> [f64; 3] {
        [self.mu_s, self.mu_d, self.stribeck]
    }

    /// `mu(V)` at a slip speed (m/s).
    fn steady(&self, speed: f64) -> f64 {
        let (above, below) = sliding(self.curve(), Dual::<_, 1, 0>::scalar(speed, 0));
        above.value.sum() / below.sum()
    }

    #[inline(always)]
    fn response<S: Simd, const K: usize, const N: usize>(
        &self,
        slip: [Dual<S, K, N>; 3],
        state: [Dual<S, K, N>; 3],
    ) -> [[Dual<S, K, N>; 3]; 2] {
        let speed = slip_speed(slip, true);
        let (steady, below) = sliding(self.curve(), speed);
        let wear = speed.times(below * below.broadcast(self.stiffness)) / steady;
        let (mut coefficient, mut rate) = (state, slip);
        for i in 0..3 {
            rate[i] = slip[i].scale(self.stiffness) - wear * state[i];
            let time = self.damping / self.stiffness;
            coefficient[i] = state[i] + rate[i].scale(time) + slip[i].scale(self.viscous);
        }
        [coefficient, rate]
    }
}

/// Rate-and-state friction with the ageing law (J. H. Dieterich, J. Geophys. Res. 84 (1979) 2161; A. Ruina, J. Geophys.
/// Res. 88 (1983) 10359), regularised at zero speed (J. R. Rice, N. Lapusta, K. Ranjith, J. Mech. Phys. Solids 49 (2001)
/// 1865). The state is `s = ln(V_0 theta / D_c)`, with the age `theta` of the contact:
///
/// ```text
/// dtheta/dt = 1 - |V| theta / D_c
/// c         = a asinh(|V| / (2 V_0) exp((mu_0 + b s) / a)) V / |V|
/// ```
///
/// In steady sliding `c = mu_0 + (a - b) ln(V / V_0)`. With `b > a` it falls with the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateAndState {
    /// Coefficient `mu_0` of steady sliding at the reference speed, positive.
    pub mu_0: f64,
    /// Direct effect `a`, positive.
    pub direct: f64,
    /// Evolution effect `b`, non-negative.
    pub evolution: f64,
    /// Reference speed `V_0`, m/s, positive.
    pub reference_speed: f64,
    /// Slip distance `D_c` over which the state evolves, m, positive.
    pub distance: f64,
}

impl RateAndState {
    #[inline(always)]
    fn response<S: Simd, const K: usize, const N: usize>(
        &self,
        slip: [Dual<S, K, N>; 3],
        [state, ..]: [Dual<S, K, N>; 3],
    ) -> [[Dual<S, K, N>; 3]; 2] {
        let speed = slip_speed(slip, true);
        let one = speed.value.broadcast(1.0);
        let exponent = speed.compose_scalar(
            #[inline(always)]
            |speed| [(speed / (2.0 * self.reference_speed)).ln(), 1.0 / speed],
        );
        let healed = state.times_plus(
            one.broadcast(self.evolution / self.direct),
            one.broadcast(self.mu_0 / self.direct),
        );
        let coefficient = (exponent + healed).compose_scalar(
            #[inline(always)]
            |exponent| {
                // From here on, asinh(x) is ln(2 x) within rounding, without overflow.
                if exponent > 20.0 {
                    return [
                        self.direct * (exponent + std::f64::consts::LN_2),
                        self.direct,
                    ];
                }
                let x = exponent.exp();
                [self.direct * x.asinh(), self.direct * x / x.hypot(1.0)]
            },
        );
        let ageing = state.compose_scalar(
            #[inline(always)]
            |state| {
                let ageing = self.reference_speed * (-state).exp();
                [ageing, -ageing]
            },
        );
        let ratio = coefficient / speed;
        let zero = Dual::constant(one.broadcast(0.0));
        let mut friction = slip;
        for i in 0..3 {
            friction[i] = ratio * slip[i];
        }
        let rate = (ageing - speed).scale(1.0 / self.distance);
        [friction, [rate, zero, zero]]
    }
}

/// Friction law with an internal state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DynamicFriction {
    /// Bristles.
    LuGre(LuGre),
    /// Rate-and-state friction.
    RateAndState(RateAndState),
}

/// A law with a state for small oscillations of the slip speed, at the angular frequency `w`, about steady sliding in
/// the same direction. Linearised, the coefficient changes with the speed by the complex slope
///
/// ```text
/// dc/dV = p + d / (i w + r)
/// ```
///
/// Its real part, `p + d r / (w^2 + r^2)`, acts like the slope of a friction curve: negative, it drives a vibration at
/// this frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OscillatingFriction {
    /// Change of the coefficient with the speed at a constant state `p`, s/m.
    pub at_once: f64,
    /// Change of the coefficient through the state `d`, 1/m.
    pub delayed: f64,
    /// Rate `r` at which the state approaches steady sliding, 1/s. LuGre: `sigma_0 V / mu`; rate and state: `V / D_c`.
    pub relaxation: f64,
}

impl OscillatingFriction {
    /// Slope that acts at an angular frequency (rad/s), s/m; at 0 that of steady sliding.
    pub fn slope(&self, omega: f64) -> f64 {
        let rate = self.relaxation;
        self.at_once + self.delayed * rate / (omega * omega + rate * rate)
    }

    /// Angular frequency (rad/s) above which friction damps, although in steady sliding it falls with the speed;
    /// `None` if it falls at all frequencies or rises in steady sliding. Rate and state: `V / D_c sqrt(b/a - 1)`, the
    /// frequency at the critical stiffness (J. R. Rice, A. L. Ruina, J. Appl. Mech. 50 (1983) 343).
    pub fn damping_above(&self) -> Option<f64> {
        let rate = self.relaxation;
        let square = -rate * (self.delayed / self.at_once + rate);
        (self.slope(0.0) < 0.0 && self.at_once > 0.0).then(|| square.sqrt())
    }
}

/// Slip speed relative to the reference speed below which the age of a contact in steady sliding does not increase.
const LEAST_STEADY_SPEED: f64 = 1e-6;

impl DynamicFriction {
    /// Number of components of the state for slip velocities with two or three components.
    pub fn states(&self, axes: usize) -> usize {
        match self {
            Self::LuGre(_) => axes,
            Self::RateAndState(_) => 1,
        }
    }

    /// Whether the state is a vector in the axes of the slip velocity.
    pub fn has_vector_state(&self) -> bool {
        matches!(self, Self::LuGre(_))
    }

    /// The state of steady sliding at a speed (m/s) along the first axis. At rest bristles are straight, and the
    /// age of a contact is that of very slow sliding.
    pub fn steady_state(&self, speed: f64) -> [f64; 3] {
        match self {
            Self::LuGre(law) if speed > 0.0 => [law.steady(speed), 0.0, 0.0],
            Self::LuGre(_) => [0.0; 3],
            Self::RateAndState(law) => {
                let slowest = LEAST_STEADY_SPEED * law.reference_speed;
                [(law.reference_speed / speed.max(slowest)).ln(), 0.0, 0.0]
            }
        }
    }

    /// Coefficient `c`, along the axes of the slip velocity, and `ds/dt` (1/s), zero for components that the law does not
    /// have, at a slip velocity (m/s) and a state.
    pub fn response(&self, velocity: [f64; 3], state: [f64; 3]) -> [[f64; 3]; 2] {
        let both = self.duals::<0>(velocity, state);
        both.map(|all| all.map(|one| one.value.sum()))
    }

    /// Coefficient and rate of the state with their derivatives with respect to the first inputs, the components of the slip
    /// velocity (m/s) and of the state.
    fn duals<const N: usize>(
        &self,
        velocity: [f64; 3],
        state: [f64; 3],
    ) -> [[Dual<Scalar, 1, N>; 3]; 2] {
        let inputs = |of: [f64; 3], first| [0, 1, 2].map(|i| Dual::scalar(of[i], first + i));
        let law = Evolving {
            law: self,
            radial: true,
        };
        law.response(inputs(velocity, 0), inputs(state, 3))
    }

    /// Friction for small oscillations of the slip speed about steady sliding at a positive speed (m/s).
    pub fn oscillating(&self, speed: f64) -> OscillatingFriction {
        let [coefficient, rate] = self.duals::<6>([speed, 0.0, 0.0], self.steady_state(speed));
        let slopes = |of: Dual<_, 1, 6>| [0, 3].map(|input| of.slopes[input].sum());
        let ([at_once, by_state], [rise, decay]) = (slopes(coefficient[0]), slopes(rate[0]));
        OscillatingFriction {
            at_once,
            delayed: by_state * rise,
            relaxation: -decay,
        }
    }

    /// The law with a state that follows the speed `factor` times faster; for large factors friction depends on the
    /// speed alone, and in steady sliding on the same.
    pub fn with_faster_state(self, factor: f64) -> Self {
        match self {
            Self::LuGre(law) => Self::LuGre(LuGre {
                stiffness: factor * law.stiffness,
                ..law
            }),
            Self::RateAndState(law) => Self::RateAndState(RateAndState {
                distance: law.distance / factor,
                ..law
            }),
        }
    }
}

/// A law with a state, and whether it includes the radial slip velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evolving<'a> {
    pub law: &'a DynamicFriction,
    pub radial: bool,
}

impl ContactLaw for Evolving<'_> {
    #[inline(always)]
    fn radial(&self) -> bool {
        self.radial
    }

    #[inline(always)]
    fn states(&self) -> usize {
        self.law.states(if self.radial { 3 } else { 2 })
    }

    #[inline(always)]
    fn response<S: Simd, const K: usize, const N: usize>(
        &self,
        slip: [Dual<S, K, N>; 3],
        state: [Dual<S, K, N>; 3],
    ) -> [[Dual<S, K, N>; 3]; 2] {
        match self.law {
            DynamicFriction::LuGre(law) => law.response(slip, state),
            DynamicFriction::RateAndState(law) => law.response(slip, state),
        }
    }
}

#[cfg(test)]
mod tests;
