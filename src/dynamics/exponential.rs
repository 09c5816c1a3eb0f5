//! The interaction picture: the free vibration is taken out exactly.
//!
//! Write the system as `z' = L z + N(t, z)`, where `L` is the free vibration of the modes and `N`
//! the force. The coordinates `y = exp(-(t - t_n) L) z` stand still when no force acts, and
//!
//! ```text
//! y' = exp(-(t - t_n) L) N(t, exp((t - t_n) L) y)
//! ```
//!
//! A Runge–Kutta method applied to `y` is the integrating-factor method of J. D. Lawson,
//! Generalized Runge–Kutta processes for stable systems with large Lipschitz constants, SIAM J.
//! Numer. Anal. 4 (1967) 372–380. It is exact without a force, keeps the tableau's order (also
//! that of its dense output, turned back at the sample's own time), and its error comes from the
//! change of the force alone. For mode `i`, with decay rate `sigma = zeta omega`, damped frequency
//! `omega_d = omega sqrt(1 - zeta^2)`, `c = cos(omega_d t)` and `s = sin(omega_d t) / omega_d`,
//!
//! ```text
//! exp(t L_i) = exp(-sigma t) [ c + sigma s      s           ]
//!                            [ -omega^2 s       c - sigma s ]      on (q, q')
//! ```
//!
//! First-order components have no linear part and pass through unchanged.
//!
//! The last slope of a step is kept before it is turned into `y'`; as each step's coordinates are
//! anchored at its own start, it is at once the first slope of the next step.

use super::runge_kutta::Picture;
use super::{System, trigonometry};

/// The backward map `exp(-h L)` amplifies by `exp(sigma h)`; this bound on the exponent keeps it
/// far from overflow. Steps that long lose nothing else: the amplification is undone by the
/// forward map.
const LARGEST_EXPONENT: f64 = 300.0;

/// The linear parts of all modes.
#[derive(Clone, Debug, Default)]
struct Spectrum {
    /// `omega^2`, 1/s^2.
    stiffness: Vec<f64>,
    /// `sigma = zeta omega`, 1/s.
    decay: Vec<f64>,
    /// `omega_d`, rad/s.
    damped: Vec<f64>,
    /// `1 / omega_d`, s; zero for a mode without stiffness.
    inverse: Vec<f64>,
    /// Whether any mode is damped.
    is_damped: bool,
}

impl Spectrum {
    /// Reads the linear part of a system with as many modes as there were before.
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

/// The free vibration over some time: `exp(t L)`, and the column of `exp(-t L)` that a force needs.
#[derive(Clone, Debug)]
struct Flow {
    qq: Vec<f64>,
    qv: Vec<f64>,
    vq: Vec<f64>,
    vv: Vec<f64>,
    back_q: Vec<f64>,
    back_v: Vec<f64>,
}

impl Flow {
    /// The flow over no time.
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

    /// Sets the flow to that over `t` (s). `angles` is scratch, one element a mode.
    fn set(&mut self, spectrum: &Spectrum, t: f64, angles: &mut [f64]) {
        for (angle, omega) in angles.iter_mut().zip(&spectrum.damped) {
            *angle = omega * t;
        }
        trigonometry::sin_cos(angles, &mut self.qv, &mut self.qq);
        let modes = angles.len();
        let (qq, qv) = (&mut self.qq[..modes], &mut self.qv[..modes]);
        let (vq, vv) = (&mut self.vq[..modes], &mut self.vv[..modes]);
        let (back_q, back_v) = (&mut self.back_q[..modes], &mut self.back_v[..modes]);
        let (stiffness, decay) = (&spectrum.stiffness[..modes], &spectrum.decay[..modes]);
        let inverse = &spectrum.inverse[..modes];
        for i in 0..modes {
            // A mode without stiffness moves freely: sin(omega t) / omega -> t.
            let s = if inverse[i] == 0.0 {
                t
            } else {
                qv[i] * inverse[i]
            };
            let (c, turn) = (qq[i], decay[i] * s);
            qq[i] = c + turn;
            qv[i] = s;
            vq[i] = -stiffness[i] * s;
            vv[i] = c - turn;
            back_q[i] = -s;
            back_v[i] = c + turn;
        }
        if spectrum.is_damped {
            for i in 0..modes {
                let shrink = (-decay[i] * t).exp();
                qq[i] *= shrink;
                qv[i] *= shrink;
                vq[i] *= shrink;
                vv[i] *= shrink;
                back_q[i] /= shrink;
                back_v[i] /= shrink;
            }
        }
    }

    /// Takes over another flow of as many modes.
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
            // Adding zero turns a negative zero into zero: rest stays rest to the last bit.
            q[i] = qq[i] * q0 + qv[i] * v0 + 0.0;
            v[i] = vq[i] * q0 + vv[i] * v0 + 0.0;
        }
    }

    /// Applies `exp(t L)` to so many tangent vectors side by side, or to one state.
    fn forward_any(&self, y: &mut [f64], width: usize) {
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

    /// [`Flow::backward`] of the slopes of so many tangent vectors side by side.
    fn backward_side_by_side(&self, slopes: &mut [f64], width: usize) {
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

/// The coordinates that stand still in free vibration.
#[derive(Clone, Debug)]
pub(super) struct Interaction {
    spectrum: Spectrum,
    /// Length of the step that `stages` belongs to, s.
    h: f64,
    /// The flow from the step's start to each stage.
    stages: Vec<Flow>,
    /// The flow from the step's start to a sample.
    sample: Flow,
    /// Scratch, one element a mode.
    angles: Vec<f64>,
}

impl Interaction {
    /// The interaction picture of a system, for a method of so many stages.
    pub fn new<Y: System + ?Sized>(sys: &Y, stages: usize) -> Self {
        let modes = sys.modes();
        let zeros = vec![0.0; modes];
        let mut spectrum = Spectrum {
            stiffness: zeros.clone(),
            decay: zeros.clone(),
            damped: zeros.clone(),
            inverse: zeros.clone(),
            is_damped: false,
        };
        spectrum.read(sys);
        Self {
            spectrum,
            h: 0.0,
            stages: vec![Flow::identity(modes); stages],
            sample: Flow::identity(modes),
            angles: zeros,
        }
    }
}

impl Picture for Interaction {
    fn complete<Y: System + ?Sized>(&self, _: &Y, _: &[f64], slope: &mut [f64], width: usize) {
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
                from[0].set(&self.spectrum, nodes[stage] * h, &mut self.angles);
            }
        }
    }

    fn pull(&self, stage: usize, slope: &mut [f64], width: usize) {
        match width {
            1 => self.stages[stage].backward(slope),
            _ => self.stages[stage].backward_side_by_side(slope, width),
        }
    }

    fn push(&self, stage: usize, y: &mut [f64], width: usize) {
        self.stages[stage].forward_any(y, width);
    }

    fn push_by(&mut self, offset: f64, y: &mut [f64], width: usize) {
        self.sample.set(&self.spectrum, offset, &mut self.angles);
        self.sample.forward_any(y, width);
    }

    fn reread<Y: System + ?Sized>(&mut self, sys: &Y) {
        self.spectrum.read(sys);
        self.h = f64::NAN;
    }

    fn longest_step(&self) -> f64 {
        let fastest = self
            .spectrum
            .decay
            .iter()
            .fold(0.0, |max: f64, sigma| max.max(sigma.abs()));
        LARGEST_EXPONENT / fastest
    }
}
