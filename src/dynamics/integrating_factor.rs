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
//! keeps its order, too, when it is transformed back at the time of the sample. The local error depends
//! only on the change of the force. For mode `i`, with decay rate `sigma = zeta omega`, damped frequency
//! `omega_d = omega sqrt(1 - zeta^2)`, `c = cos(omega_d t)` and `s = sin(omega_d t) / omega_d`,
//!
//! ```text
//! exp(t L_i) = exp(-sigma t) [ c + sigma s      s           ]
//!                            [ -omega^2 s       c - sigma s ]      on (q, q')
//! ```
//!
//! First-order components have no linear part and are unchanged.
//!
//! The last slope of a step is stored before its transformation to `y'`. Because the coordinates of each
//! step refer to its own start, this slope is also the first slope of the next step.

use pulp::{Arch, Simd, WithSimd};

use super::combination::{Combination, load, positions, store};
use super::runge_kutta::Form;
use super::{System, trigonometry};

/// Bound on the exponent `sigma h`. The backward map `exp(-h L)` amplifies by `exp(sigma h)`; the bound
/// prevents overflow. The forward map compensates the amplification, so long steps lose no accuracy.
const MAX_EXPONENT: f64 = 300.0;

/// Linear parts of all modes.
#[derive(Clone, Debug, Default)]
struct LinearModes {
    /// `omega^2`, 1/s^2.
    stiffness: Vec<f64>,
    /// `sigma = zeta omega`, 1/s.
    decay: Vec<f64>,
    /// `omega_d`, rad/s.
    damped: Vec<f64>,
    /// `1 / omega_d`, s; zero for a mode with zero frequency.
    inverse: Vec<f64>,
    /// Whether any mode is damped.
    is_damped: bool,
}

impl LinearModes {
    /// Reads the linear part of a system with an unchanged number of modes.
    fn read<Y: System + ?Sized>(&mut self, sys: &Y) {
        for (i, &omega) in sys.omega().iter().enumerate() {
            let zeta = sys.damping().get(i).copied().unwrap_or(0.0);
            self.stiffness[i] = omega * omega;
            self.decay[i] = zeta * omega;
            self.damped[i] = omega * (1.0 - zeta * zeta).sqrt();
            self.inverse[i] = if omega > 0.0 {
                self.damped[i].recip()
            } else {
                0.0
            };
        }
        self.is_damped = self.decay.iter().any(|&sigma| sigma != 0.0);
    }
}

/// The propagator of the free vibration, `exp(t L)`, and the column of `exp(-t L)` that acts on a force.
#[derive(Clone, Debug)]
struct Propagator {
    qq: Vec<f64>,
    qv: Vec<f64>,
    vq: Vec<f64>,
    vv: Vec<f64>,
    back_q: Vec<f64>,
    back_v: Vec<f64>,
}

impl Propagator {
    /// The propagator over zero time.
    fn identity(modes: usize) -> Self {
        let (zeros, ones) = (vec![0.0; modes], vec![1.0; modes]);
        Self {
            qq: ones.clone(),
            qv: zeros.clone(),
            vq: zeros.clone(),
            vv: ones.clone(),
            back_q: zeros,
            back_v: ones,
        }
    }

    /// Sets the propagator over `t` (s) from the sines and cosines of the angles `omega_d t`.
    #[inline(always)]
    fn set(&mut self, linear: &LinearModes, t: f64, sin: &[f64], cos: &[f64]) {
        let modes = self.qq.len();
        let (sin, cos) = (&sin[..modes], &cos[..modes]);
        let (qq, qv) = (&mut self.qq[..modes], &mut self.qv[..modes]);
        let (vq, vv) = (&mut self.vq[..modes], &mut self.vv[..modes]);
        let (back_q, back_v) = (&mut self.back_q[..modes], &mut self.back_v[..modes]);
        let (stiffness, decay) = (&linear.stiffness[..modes], &linear.decay[..modes]);
        let inverse = &linear.inverse[..modes];
        for i in 0..modes {
            // A mode with zero frequency: sin(omega t) / omega -> t.
            let s = if inverse[i] == 0.0 {
                t
            } else {
                sin[i] * inverse[i]
            };
            let decay_term = decay[i] * s;
            qq[i] = cos[i] + decay_term;
            qv[i] = s;
            vq[i] = -stiffness[i] * s;
            vv[i] = cos[i] - decay_term;
            back_q[i] = -s;
            back_v[i] = cos[i] + decay_term;
        }
        if linear.is_damped {
            for i in 0..modes {
                let attenuation = (-decay[i] * t).exp();
                qq[i] *= attenuation;
                qv[i] *= attenuation;
                vq[i] *= attenuation;
                vv[i] *= attenuation;
                back_q[i] /= attenuation;
                back_v[i] /= attenuation;
            }
        }
    }

    /// Applies `exp(t L)` to `width` tangent vectors.
    fn forward_vectors(&self, y: &mut [f64], width: usize) {
        let (q, v) = y.split_at_mut(self.qq.len() * width);
        let rows = q.chunks_exact_mut(width).zip(v.chunks_exact_mut(width));
        for (i, (q, v)) in rows.enumerate() {
            let (qq, qv, vq, vv) = (self.qq[i], self.qv[i], self.vq[i], self.vv[i]);
            for (q, v) in q.iter_mut().zip(v) {
                let (q0, v0) = (*q, *v);
                *q = qq * q0 + qv * v0;
                *v = vq * q0 + vv * v0;
            }
        }
    }

    /// Applies `exp(-t L)` to the slopes `[0 | f | ..]` of `width` tangent vectors.
    fn backward_vectors(&self, slopes: &mut [f64], width: usize) {
        let (q, v) = slopes.split_at_mut(self.qq.len() * width);
        let rows = q.chunks_exact_mut(width).zip(v.chunks_exact_mut(width));
        for (i, (q, v)) in rows.enumerate() {
            let (back_q, back_v) = (self.back_q[i], self.back_v[i]);
            for (q, v) in q.iter_mut().zip(v) {
                *q = back_q * *v;
                *v *= back_v;
            }
        }
    }
}

/// The kernel that sets the propagators over several times (s).
struct SetPropagators<'a> {
    linear: &'a LinearModes,
    times: &'a [f64],
    propagators: &'a mut [Propagator],
    angles: &'a mut Angles,
}

impl WithSimd for SetPropagators<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let damped = &self.linear.damped[..];
        let modes = damped.len();
        let count = self.times.len() * modes;
        let Angles { angles, sin, cos } = self.angles;
        let (angles, sin, cos) = (&mut angles[..count], &mut sin[..count], &mut cos[..count]);
        for (angles, t) in angles.chunks_exact_mut(modes.max(1)).zip(self.times) {
            for (angle, omega) in angles.iter_mut().zip(damped) {
                *angle = omega * t;
            }
        }
        trigonometry::sin_cos(simd, angles, sin, cos);
        for (k, (propagator, &t)) in self.propagators.iter_mut().zip(self.times).enumerate() {
            propagator.set(self.linear, t, &sin[k * modes..], &cos[k * modes..]);
        }
    }
}

/// The kernel that applies `exp(t L)` to a combination of slopes.
struct Advance<'a> {
    propagator: &'a Propagator,
    combination: Combination<'a>,
    out: &'a mut [f64],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            propagator,
            combination,
            out,
        } = self;
        let modes = propagator.qq.len();
        let dim = out.len();
        combination.write(simd, 2 * modes..dim, out);
        let (q, rest) = out.split_at_mut(modes);
        let v = &mut rest[..modes];
        for at in positions::<S>(modes) {
            let q0 = combination.vector(simd, 0..modes, at);
            let v0 = combination.vector(simd, modes..2 * modes, at);
            let Propagator { qq, qv, vq, vv, .. } = propagator;
            store(simd, q, at, product(simd, [qq, qv], at, [q0, v0]));
            store(simd, v, at, product(simd, [vq, vv], at, [q0, v0]));
        }
    }
}

/// A row of the propagators at a position times the vectors `[q | q']`.
#[inline(always)]
fn product<S: Simd>(
    simd: S,
    [by_q, by_v]: [&[f64]; 2],
    at: usize,
    [q, v]: [S::f64s; 2],
) -> S::f64s {
    let by_q = simd.mul_f64s(load(simd, by_q, at), q);
    let by_v = simd.mul_f64s(load(simd, by_v, at), v);
    // Adding zero turns a negative zero into zero, which keeps a state at rest bitwise at rest.
    simd.add_f64s(simd.add_f64s(by_q, by_v), simd.splat_f64s(0.0))
}

/// The kernel that writes `exp(-t L) [0 | f | g]` for the force `[f | g]`.
struct PullBack<'a> {
    propagator: &'a Propagator,
    force: &'a [f64],
    slope: &'a mut [f64],
}

impl WithSimd for PullBack<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let modes = self.propagator.qq.len();
        let (force, rest) = self.force.split_at(modes);
        let (q, others) = self.slope.split_at_mut(modes);
        let (v, w) = others.split_at_mut(modes);
        w.copy_from_slice(rest);
        for at in positions::<S>(modes) {
            let f = load(simd, force, at);
            let back_q = load(simd, &self.propagator.back_q, at);
            let back_v = load(simd, &self.propagator.back_v, at);
            store(simd, q, at, simd.mul_f64s(back_q, f));
            store(simd, v, at, simd.mul_f64s(back_v, f));
        }
    }
}

/// Scratch space: angles of the modes at several times, with sines and cosines.
#[derive(Clone, Debug)]
struct Angles {
    angles: Vec<f64>,
    sin: Vec<f64>,
    cos: Vec<f64>,
}

/// Coordinates that are constant in free vibration.
#[derive(Clone, Debug)]
pub(super) struct IntegratingFactor {
    linear: LinearModes,
    /// Step length for which `stages` is valid, s.
    h: f64,
    /// Propagators from the start of the step to each stage.
    stages: Vec<Propagator>,
    /// Propagator from the start of the step to a sample.
    sample: Propagator,
    /// Times of the stages from the start of the step, s.
    times: Vec<f64>,
    angles: Angles,
    arch: Arch,
}

impl IntegratingFactor {
    /// The integrating-factor form of a system for a method with `stages` stages.
    pub fn new<Y: System + ?Sized>(sys: &Y, stages: usize) -> Self {
        let modes = sys.modes();
        let zeros = vec![0.0; modes];
        let mut linear = LinearModes {
            stiffness: zeros.clone(),
            decay: zeros.clone(),
            damped: zeros.clone(),
            inverse: zeros.clone(),
            is_damped: false,
        };
        linear.read(sys);
        let angles = vec![0.0; stages * modes];
        Self {
            linear,
            h: 0.0,
            stages: vec![Propagator::identity(modes); stages],
            sample: Propagator::identity(modes),
            times: vec![0.0; stages],
            angles: Angles {
                sin: angles.clone(),
                cos: angles.clone(),
                angles,
            },
            arch: Arch::new(),
        }
    }

    /// Sets the propagator to a sample at `offset` (s) after the start of the step.
    fn prepare_sample(&mut self, offset: f64) {
        self.arch.dispatch(SetPropagators {
            linear: &self.linear,
            times: &[offset],
            propagators: std::slice::from_mut(&mut self.sample),
            angles: &mut self.angles,
        });
    }
}

impl Form for IntegratingFactor {
    fn add_linear_part<Y: System + ?Sized>(
        &self,
        _: &Y,
        _: &[f64],
        slope: &mut [f64],
        width: usize,
    ) {
        slope[..self.sample.qq.len() * width].fill(0.0);
    }

    fn prepare(&mut self, nodes: &[f64], h: f64) {
        if h == self.h {
            return;
        }
        self.h = h;
        for (time, node) in self.times.iter_mut().zip(nodes) {
            *time = node * h;
        }
        // The first stage is the start of the step.
        self.arch.dispatch(SetPropagators {
            linear: &self.linear,
            times: &self.times[1..],
            propagators: &mut self.stages[1..],
            angles: &mut self.angles,
        });
    }

    fn advance(&self, stage: usize, combination: Combination<'_>, out: &mut [f64]) {
        self.arch.dispatch(Advance {
            propagator: &self.stages[stage],
            combination,
            out,
        });
    }

    fn advance_by(&mut self, offset: f64, combination: Combination<'_>, out: &mut [f64]) {
        self.prepare_sample(offset);
        self.arch.dispatch(Advance {
            propagator: &self.sample,
            combination,
            out,
        });
    }

    fn slope<Y: System + ?Sized>(
        &self,
        _: &Y,
        stage: usize,
        _: &[f64],
        force: &[f64],
        slope: &mut [f64],
    ) {
        self.arch.dispatch(PullBack {
            propagator: &self.stages[stage],
            force,
            slope,
        });
    }

    fn pull_back(&self, stage: usize, slope: &mut [f64], width: usize) {
        self.stages[stage].backward_vectors(slope, width);
    }

    fn push_forward(&self, stage: usize, y: &mut [f64], width: usize) {
        self.stages[stage].forward_vectors(y, width);
    }

    fn push_forward_by(&mut self, offset: f64, y: &mut [f64], width: usize) {
        self.prepare_sample(offset);
        self.sample.forward_vectors(y, width);
    }

    fn update_linear_part<Y: System + ?Sized>(&mut self, sys: &Y) {
        self.linear.read(sys);
        self.h = f64::NAN;
    }

    fn max_step_of_linear_part(&self) -> f64 {
        let fastest = self
            .linear
            .decay
            .iter()
            .fold(0.0, |max: f64, sigma| max.max(sigma.abs()));
        MAX_EXPONENT / fastest
    }
}
