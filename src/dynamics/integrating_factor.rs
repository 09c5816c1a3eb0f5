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

    /// Sets the propagator over `t` (s). `angles` is scratch space, one element per mode.
    fn set(&mut self, linear: &LinearModes, t: f64, angles: &mut [f64]) {
        for (angle, omega) in angles.iter_mut().zip(&linear.damped) {
            *angle = omega * t;
        }
        trigonometry::sin_cos(angles, &mut self.qv, &mut self.qq);
        let modes = angles.len();
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
                qv[i] * inverse[i]
            };
            let (c, decay_term) = (qq[i], decay[i] * s);
            qq[i] = c + decay_term;
            qv[i] = s;
            vq[i] = -stiffness[i] * s;
            vv[i] = c - decay_term;
            back_q[i] = -s;
            back_v[i] = c + decay_term;
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

    /// Copies a propagator with the same number of modes.
    fn copy_from(&mut self, other: &Self) {
        self.qq.copy_from_slice(&other.qq);
        self.qv.copy_from_slice(&other.qv);
        self.vq.copy_from_slice(&other.vq);
        self.vv.copy_from_slice(&other.vv);
        self.back_q.copy_from_slice(&other.back_q);
        self.back_v.copy_from_slice(&other.back_v);
    }

    /// Applies `exp(t L)` to `[q | q' | ..]`.
    fn forward(&self, y: &mut [f64]) {
        let modes = self.qq.len();
        let (q, v) = y.split_at_mut(modes);
        let v = &mut v[..modes];
        let (qq, qv) = (&self.qq[..modes], &self.qv[..modes]);
        let (vq, vv) = (&self.vq[..modes], &self.vv[..modes]);
        for i in 0..modes {
            let (q0, v0) = (q[i], v[i]);
            // Adding zero turns a negative zero into zero, which keeps a state at rest bitwise at rest.
            q[i] = qq[i] * q0 + qv[i] * v0 + 0.0;
            v[i] = vq[i] * q0 + vv[i] * v0 + 0.0;
        }
    }

    /// Applies `exp(t L)` to one state or to `width` tangent vectors.
    fn forward_vectors(&self, y: &mut [f64], width: usize) {
        if width == 1 {
            return self.forward(y);
        }
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

    /// [`Propagator::backward`] for the slopes of `width` tangent vectors.
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

    /// Applies `exp(-t L)` to `[0 | f | ..]`.
    fn backward(&self, force: &mut [f64]) {
        let modes = self.qq.len();
        let (q, v) = force.split_at_mut(modes);
        let v = &mut v[..modes];
        let (back_q, back_v) = (&self.back_q[..modes], &self.back_v[..modes]);
        for i in 0..modes {
            q[i] = back_q[i] * v[i];
            v[i] *= back_v[i];
        }
    }
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
    /// Scratch space, one element per mode.
    angles: Vec<f64>,
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
        Self {
            linear,
            h: 0.0,
            stages: vec![Propagator::identity(modes); stages],
            sample: Propagator::identity(modes),
            angles: zeros,
        }
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
        for stage in 1..nodes.len() {
            let (before, from) = self.stages.split_at_mut(stage);
            if nodes[stage] == nodes[stage - 1] {
                from[0].copy_from(&before[stage - 1]);
            } else {
                from[0].set(&self.linear, nodes[stage] * h, &mut self.angles);
            }
        }
    }

    fn pull_back(&self, stage: usize, slope: &mut [f64], width: usize) {
        match width {
            1 => self.stages[stage].backward(slope),
            _ => self.stages[stage].backward_vectors(slope, width),
        }
    }

    fn push_forward(&self, stage: usize, y: &mut [f64], width: usize) {
        self.stages[stage].forward_vectors(y, width);
    }

    fn push_forward_by(&mut self, offset: f64, y: &mut [f64], width: usize) {
        self.sample.set(&self.linear, offset, &mut self.angles);
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
