//! Friction laws with an internal state at each contact node: LuGre, and rate-and-state friction.
//!
//! A law gives the friction force divided by the normal force, `-c(V, s)`, and the rate of the state, `ds/dt =
//! g(V, s)`, for a slip velocity `V` and a state `s` without unit. Neither depends on the normal force, so that
//! the force of a node remains proportional to it. The state of a separated node follows the slip velocity, too.

use pulp::Simd;

use super::exponential::Exponential;
use super::simd::Vector;
use super::vector::{norm, scale};

/// Largest number of contact nodes of a scene whose friction has states. The effort of linear stability and of implicit
/// steps increases with the cube of their number.
pub const MAX_NODES_WITH_STATES: usize = 400;

/// Friction force of a node divided by its normal force, with the opposite sign, and the rate of its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateResponse {
    /// `c`, along the axes of the slip velocity.
    pub coefficient: [f64; 3],
    /// `ds/dt`, 1/s; zero for components that the law does not have.
    pub rate: [f64; 3],
}

/// Derivatives of a [`StateResponse`]; `[i][j]` is that of component `i` with respect to component `j`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateSlopes {
    /// `dc/dV`, s/m.
    pub coefficient_by_velocity: [[f64; 3]; 3],
    /// `dc/ds`.
    pub coefficient_by_state: [[f64; 3]; 3],
    /// `dg/dV`, 1/m.
    pub rate_by_velocity: [[f64; 3]; 3],
    /// `dg/ds`, 1/s.
    pub rate_by_state: [[f64; 3]; 3],
}

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
    /// Coefficient and rate of the state for several nodes at once; inlined into the hot loop.
    #[inline(always)]
    pub(super) fn responses<S: Simd>(
        &self,
        velocity: [Vector<S>; 3],
        state: [Vector<S>; 3],
    ) -> [[Vector<S>; 3]; 2] {
        let [along, across, outward] = velocity;
        let number = |x: f64| along.broadcast(x);
        let square = outward.mul_add(outward, across.mul_add(across, along * along));
        let speed = square.sqrt();
        let slide = Exponential::of(speed, self.stribeck);
        let below = slide.below();
        let falling = number(self.mu_s - self.mu_d) * slide.above();
        let steady = below.mul_add(number(self.mu_d), falling);
        let wear = number(self.stiffness) * speed * below / steady;
        let time = number(self.damping / self.stiffness);
        let (mut coefficient, mut rate) = (state, velocity);
        let axes = velocity.into_iter().zip(state);
        for ((c, rate), (v, s)) in coefficient.iter_mut().zip(&mut rate).zip(axes) {
            *rate = v * number(self.stiffness) - wear * s;
            *c = rate.mul_add(time, v.mul_add(number(self.viscous), s));
        }
        [coefficient, rate]
    }

    /// `mu(V)` and its slope at a slip speed (m/s).
    fn steady(&self, speed: f64) -> [f64; 2] {
        let falling = (self.mu_s - self.mu_d) * (-self.stribeck * speed).exp();
        [self.mu_d + falling, -self.stribeck * falling]
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
    /// `c` at a positive speed (m/s) and a state, and its derivative with respect to `ln |V|`.
    fn coefficient(&self, speed: f64, state: f64) -> [f64; 2] {
        let exponent = (self.mu_0 + self.evolution * state) / self.direct
            + (speed / (2.0 * self.reference_speed)).ln();
        // From here on, asinh(x) is ln(2 x) within rounding, without overflow.
        if exponent > 20.0 {
            return [
                self.direct * (exponent + std::f64::consts::LN_2),
                self.direct,
            ];
        }
        let x = exponent.exp();
        [self.direct * x.asinh(), self.direct * x / x.hypot(1.0)]
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

/// Slip speed below which friction vanishes, m/s. It permits a division by the speed.
const LEAST_SPEED: f64 = 1e-250;

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
            Self::LuGre(law) if speed > 0.0 => [law.steady(speed)[0], 0.0, 0.0],
            Self::LuGre(_) => [0.0; 3],
            Self::RateAndState(law) => {
                let slowest = LEAST_STEADY_SPEED * law.reference_speed;
                [(law.reference_speed / speed.max(slowest)).ln(), 0.0, 0.0]
            }
        }
    }

    /// Response at a slip velocity (m/s) and a state.
    pub fn response(&self, velocity: [f64; 3], state: [f64; 3]) -> StateResponse {
        let speed = norm(velocity);
        match self {
            Self::LuGre(law) => {
                let wear = law.stiffness * speed / law.steady(speed)[0];
                let rate = std::array::from_fn(|i| law.stiffness * velocity[i] - wear * state[i]);
                let time = law.damping / law.stiffness;
                StateResponse {
                    coefficient: std::array::from_fn(|i| {
                        state[i] + time * rate[i] + law.viscous * velocity[i]
                    }),
                    rate,
                }
            }
            Self::RateAndState(law) => {
                let speed = speed.max(LEAST_SPEED);
                let [coefficient, _] = law.coefficient(speed, state[0]);
                let ageing = law.reference_speed * (-state[0]).exp();
                StateResponse {
                    coefficient: scale(velocity, coefficient / speed),
                    rate: [(ageing - speed) / law.distance, 0.0, 0.0],
                }
            }
        }
    }

    /// Friction for small oscillations of the slip speed about steady sliding at a positive speed (m/s).
    pub fn oscillating(&self, speed: f64) -> OscillatingFriction {
        let slopes = self.slopes([speed, 0.0, 0.0], self.steady_state(speed));
        OscillatingFriction {
            at_once: slopes.coefficient_by_velocity[0][0],
            delayed: slopes.coefficient_by_state[0][0] * slopes.rate_by_velocity[0][0],
            relaxation: -slopes.rate_by_state[0][0],
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

    /// Derivatives at a slip velocity (m/s) and a state.
    pub fn slopes(&self, velocity: [f64; 3], state: [f64; 3]) -> StateSlopes {
        let speed = norm(velocity);
        let direction = scale(velocity, 1.0 / speed.max(LEAST_SPEED));
        let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
        match self {
            Self::LuGre(law) => {
                let [steady, slope] = law.steady(speed);
                let wear = law.stiffness * speed / steady;
                // d(|V| / mu)/d|V|
                let bend = law.stiffness * (1.0 - speed * slope / steady) / steady;
                let time = law.damping / law.stiffness;
                let rate_by_velocity =
                    matrix(|i, j| law.stiffness * unit(i, j) - bend * state[i] * direction[j]);
                StateSlopes {
                    coefficient_by_velocity: matrix(|i, j| {
                        time * rate_by_velocity[i][j] + law.viscous * unit(i, j)
                    }),
                    coefficient_by_state: matrix(|i, j| (1.0 - time * wear) * unit(i, j)),
                    rate_by_velocity,
                    rate_by_state: matrix(|i, j| -wear * unit(i, j)),
                }
            }
            Self::RateAndState(law) => {
                let speed = speed.max(LEAST_SPEED);
                let [coefficient, slope] = law.coefficient(speed, state[0]);
                let (ratio, bend) = (coefficient / speed, (slope - coefficient) / speed);
                let by_state = slope * law.evolution / law.direct;
                let ageing = law.reference_speed * (-state[0]).exp();
                let first = |j: usize| unit(0, j);
                StateSlopes {
                    coefficient_by_velocity: matrix(|i, j| {
                        ratio * unit(i, j) + bend * direction[i] * direction[j]
                    }),
                    coefficient_by_state: matrix(|i, j| by_state * direction[i] * first(j)),
                    rate_by_velocity: matrix(|i, j| -first(i) * direction[j] / law.distance),
                    rate_by_state: matrix(|i, j| -first(i) * first(j) * ageing / law.distance),
                }
            }
        }
    }
}

fn matrix(of: impl Fn(usize, usize) -> f64) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| of(i, j)))
}

#[cfg(test)]
mod tests;
