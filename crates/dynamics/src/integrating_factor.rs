//! The integrating-factor (Lawson) form: the linear free vibration is integrated exactly.
//!
//! The system is written as `z' = L z + N(t, z)` with the free vibration `L` of the modes and the force
//! `N`. The coordinates `y = exp(-(t - t_n) L) z` are constant without a force, and satisfy
//!
//! ```text
//! y' = exp(-(t - t_n) L) N(t, exp((t - t_n) L) y)
//! ```
//!
//! A Runge–Kutta method applied to `y` is the integrating-factor method of J. D. Lawson, Generalized
//! Runge–Kutta processes for stable systems with large Lipschitz constants, SIAM J. Numer. Anal. 4
//! (1967) 372–380. It is exact without a force and keeps the order of the tableau. The dense output
//! keeps its order, too, when it is transformed back at the time of the sample. The local error depends on how fast the
//! transformed force `exp(-t L) N` turns, at the natural frequencies even if `N` is constant; equilibria with a force are
//! kept to the tolerance, not exactly. For mode `i`, with decay rate `sigma = zeta omega`, damped frequency
//! `omega_d = omega sqrt(1 - zeta^2)`, `c = cos(omega_d t)` and `s = sin(omega_d t) / omega_d`,
//!
//! ```text
//! exp(t L_i) = exp(-sigma t) [ c + sigma s      s           ]
//!                            [ -omega^2 s       c - sigma s ]      on (q, q')
//! ```
//!
//! First-order components have no linear part and are unchanged.
//!
//! The plain form treats all components as such: without a mode that is integrated exactly, `y = z`, `N` is the
//! whole right-hand side, and a tableau is the standard explicit Runge–Kutta method (Hairer, Norsett and Wanner,
//! Solving Ordinary Differential Equations I, 2nd ed., Section II.1). Its step must resolve the highest natural
//! frequency, even if that mode is not excited.
//!
//! The last slope of a step is stored before its transformation to `y'`. Because the coordinates of each
//! step refer to its own start, this slope is also the first slope of the next step.

use super::stepper::Law;
use super::{System, trigonometry};
use crate::simd::vectorised;

/// Bound on the exponent `sigma h`. The backward map `exp(-h L)` amplifies by `exp(sigma h)`; the bound
/// prevents overflow. The forward map compensates the amplification, so long steps lose no accuracy.
const MAX_EXPONENT: f64 = 300.0;

/// Numbers of modes that are processed together, in the widest vectors.
const LANES: usize = 8;

/// Numbers of a group of modes; zero beyond the last mode.
type Group = [f64; LANES];

/// Linear parts of all modes.
#[derive(Clone, Debug, Default)]
struct LinearModes {
    groups: Vec<LinearGroup>,
    /// Largest damped frequency, rad/s.
    fastest: f64,
    /// Whether any mode is damped.
    is_damped: bool,
}

/// Linear parts of a group of modes.
#[derive(Clone, Copy, Debug, Default)]
struct LinearGroup {
    /// `omega^2`, 1/s^2.
    stiffness: Group,
    /// `sigma = zeta omega`, 1/s.
    decay: Group,
    /// `omega_d`, rad/s.
    damped: Group,
    /// `1 / omega_d`, s; zero for a mode with zero frequency.
    inverse: Group,
}

impl LinearModes {
    /// Reads the linear part of a system, of which a number of modes are integrated exactly.
    fn read(&mut self, sys: &dyn System, modes: usize) {
        (self.fastest, self.is_damped) = (0.0, false);
        for (i, &omega) in sys.omega()[..modes].iter().enumerate() {
            let zeta = sys.damping().get(i).copied().unwrap_or(0.0);
            let (group, lane) = (&mut self.groups[i / LANES], i % LANES);
            let damped = omega * (1.0 - zeta * zeta).sqrt();
            group.stiffness[lane] = omega * omega;
            group.decay[lane] = zeta * omega;
            group.damped[lane] = damped;
            group.inverse[lane] = if omega > 0.0 { damped.recip() } else { 0.0 };
            self.fastest = self.fastest.max(damped);
            self.is_damped |= zeta * omega != 0.0;
        }
    }
}

/// Maps the coordinate and the velocity of a mode by the coefficients of a propagator.
trait Map: Fn(&[f64; 6], f64, f64) -> (f64, f64) + Copy {}

impl<F: Fn(&[f64; 6], f64, f64) -> (f64, f64) + Copy> Map for F {}

/// The propagator of the free vibration, `exp(t L)`, and the column of `exp(-t L)` that acts on a force: for each
/// group of modes the coefficients `qq`, `qv`, `vq`, `vv` of the former and `q`, `v` of the latter.
#[derive(Clone, Debug)]
struct Propagator(Vec<[Group; 6]>);

impl Propagator {
    /// Sets the propagator over `t` (s).
    fn set(&mut self, linear: &LinearModes, t: f64) {
        let are_small = linear.fastest * t.abs() < trigonometry::MAX_REDUCED_ANGLE;
        vectorised(
            #[inline(always)]
            || {
                for (row, linear) in self.0.iter_mut().zip(&linear.groups) {
                    *row = if are_small {
                        row_of(linear, t, trigonometry::sin_cos)
                    } else {
                        row_of(linear, t, f64::sin_cos)
                    };
                }
            },
        );
        if !linear.is_damped {
            return;
        }
        for (row, linear) in self.0.iter_mut().zip(&linear.groups) {
            let attenuation = linear.decay.map(|decay| f64::exp(-decay * t));
            for lane in 0..LANES {
                row[..4]
                    .iter_mut()
                    .for_each(|group| group[lane] *= attenuation[lane]);
                row[4..]
                    .iter_mut()
                    .for_each(|group| group[lane] /= attenuation[lane]);
            }
        }
    }

    /// Maps the coordinates and velocities of the first `modes` modes of `width` vectors.
    fn map(&self, z: &mut [f64], modes: usize, width: usize, map: impl Map) {
        let (q, v) = z[..2 * modes * width].split_at_mut(modes * width);
        vectorised(
            #[inline(always)]
            || match width {
                // The one vector of most runs needs no inner loop.
                1 => self.map_groups(q, v, 1, map),
                _ => self.map_groups(q, v, width, map),
            },
        );
    }

    /// Maps the coordinates and velocities of `width` vectors, group by group.
    #[inline(always)]
    fn map_groups(&self, q: &mut [f64], v: &mut [f64], width: usize, map: impl Map) {
        let groups = q.chunks_mut(LANES * width).zip(v.chunks_mut(LANES * width));
        for (row, (q, v)) in self.0.iter().zip(groups) {
            // A constant length of whole groups lets the compiler use whole vectors.
            if q.len() == LANES * width {
                map_group(
                    row,
                    &mut q[..LANES * width],
                    &mut v[..LANES * width],
                    width,
                    map,
                );
            } else {
                map_group(row, q, v, width, map);
            }
        }
    }
}

/// Maps the coordinates and velocities of a group of modes of `width` vectors.
#[inline(always)]
fn map_group(row: &[Group; 6], q: &mut [f64], v: &mut [f64], width: usize, map: impl Map) {
    for (i, (q, v)) in q.iter_mut().zip(v).enumerate() {
        let coefficients = std::array::from_fn(|k| row[k][i / width]);
        (*q, *v) = map(&coefficients, *q, *v);
    }
}

/// The coefficients of a group of modes over `t` (s) without damping.
#[inline(always)]
#[allow(
    clippy::needless_range_loop,
    reason = "a lane is an index of several arrays, and the loop is vectorised"
)]
fn row_of(linear: &LinearGroup, t: f64, sin_cos: impl Fn(f64) -> (f64, f64)) -> [Group; 6] {
    let mut row = [[0.0; LANES]; 6];
    for lane in 0..LANES {
        let (sin, cos) = sin_cos(linear.damped[lane] * t);
        let inverse = linear.inverse[lane];
        // A mode with zero frequency: sin(omega t) / omega -> t.
        let s = if inverse == 0.0 { t } else { sin * inverse };
        let decay = linear.decay[lane] * s;
        row[0][lane] = cos + decay;
        row[1][lane] = s;
        row[2][lane] = -linear.stiffness[lane] * s;
        row[3][lane] = cos - decay;
        row[4][lane] = -s;
        row[5][lane] = cos + decay;
    }
    row
}

/// The coordinates `y` in which a Runge–Kutta method is applied. `y` equals the state `z` at the start of the step.
///
/// The transformation is linear. It applies to `width` vectors that are stored component by component: the state, or
/// tangent vectors.
#[derive(Clone, Debug)]
pub(super) struct IntegratingFactor {
    /// Number of modes that are integrated exactly.
    modes: usize,
    linear: LinearModes,
    /// Step length for which `stages` is valid, s.
    h: f64,
    /// Propagators from the start of the step to each stage, and the last one to a sample. That of the first stage is
    /// not used.
    stages: Vec<Propagator>,
}

impl IntegratingFactor {
    /// The form of a system for a method with `stages` stages that integrates `modes` modes exactly: all of them, or
    /// none.
    pub fn new(sys: &dyn System, stages: usize, modes: usize) -> Self {
        let groups = modes.div_ceil(LANES);
        let propagator = Propagator(vec![[[0.0; LANES]; 6]; groups]);
        let mut linear = LinearModes {
            groups: vec![LinearGroup::default(); groups],
            ..LinearModes::default()
        };
        linear.read(sys, modes);
        Self {
            modes,
            linear,
            h: 0.0,
            stages: vec![propagator; stages + 1],
        }
    }

    /// Adds the linear part that the method integrates to the slopes `[. | f | g]` of tangent vectors `z`.
    /// Components that are integrated exactly become zero.
    pub fn add_linear_part(&self, law: Law<'_>, z: &[f64], slope: &mut [f64], width: usize) {
        if self.modes < law.sys.modes() {
            law.add_linear(z, slope, width);
        } else {
            slope[..self.modes * width].fill(0.0);
        }
    }

    /// Prepares a step of length `h` (s) with stages at the fractions `nodes` of it.
    pub fn prepare(&mut self, nodes: &[f64], h: f64) {
        if h == self.h {
            return;
        }
        self.h = h;
        // The first stage is the start of the step.
        for (propagator, node) in self.stages.iter_mut().zip(nodes).skip(1) {
            propagator.set(&self.linear, node * h);
        }
    }

    /// Prepares the propagator to a sample at `offset` (s) after the start of the step.
    pub fn prepare_sample(&mut self, offset: f64) {
        if let Some(sample) = self.stages.last_mut() {
            sample.set(&self.linear, offset);
        }
    }

    /// Transforms slopes `[. | f | g]` at a stage after the first into slopes of `y`, in place.
    pub fn pull_back(&self, stage: usize, slope: &mut [f64], width: usize) {
        self.stages[stage].map(slope, self.modes, width, backward);
    }

    /// Transforms vectors from `y` to `z` at a stage, in place.
    pub fn push_forward(&self, stage: usize, y: &mut [f64], width: usize) {
        self.stages[stage].map(y, self.modes, width, forward);
    }

    /// Updates the linear part for a changed system with the same number of modes.
    pub fn update_linear_part(&mut self, sys: &dyn System) {
        self.linear.read(sys, self.modes);
        self.h = f64::NAN;
    }

    /// Maximum step that the linear part allows, s.
    pub fn max_step_of_linear_part(&self) -> f64 {
        let decay = self.linear.groups.iter().flat_map(|group| group.decay);
        MAX_EXPONENT / decay.fold(0.0, |max, sigma| sigma.abs().max(max))
    }
}

/// Applies `exp(t L)`. Adding zero turns a negative zero into zero, which keeps a state at rest bitwise at rest.
#[inline(always)]
fn forward(c: &[f64; 6], q: f64, v: f64) -> (f64, f64) {
    (c[0] * q + c[1] * v + 0.0, c[2] * q + c[3] * v + 0.0)
}

/// Applies `exp(-t L)` to a slope without a change of the coordinate.
#[inline(always)]
fn backward(c: &[f64; 6], _: f64, v: f64) -> (f64, f64) {
    (c[4] * v, c[5] * v)
}
