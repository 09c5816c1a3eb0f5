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
//! The plain form treats all components as such: without a mode that is integrated exactly, `y = z`, `N` is the
//! whole right-hand side, and a tableau is the standard explicit Runge–Kutta method (Hairer, Norsett and Wanner,
//! Solving Ordinary Differential Equations I, 2nd ed., Section II.1). Its step must resolve the highest natural
//! frequency, even if that mode is not excited.
//!
//! The last slope of a step is stored before its transformation to `y'`. Because the coordinates of each
//! step refer to its own start, this slope is also the first slope of the next step.

use pulp::{Arch, Simd, WithSimd};

use super::combination::{Aligned, Combination, lanes};
use super::system::add_linear;
use super::{System, trigonometry};
use crate::instruction_set::instruction_set;

/// Bound on the exponent `sigma h`. The backward map `exp(-h L)` amplifies by `exp(sigma h)`; the bound
/// prevents overflow. The forward map compensates the amplification, so long steps lose no accuracy.
const MAX_EXPONENT: f64 = 300.0;

/// Order of the components in a row: for each vector of modes that are integrated exactly the coordinates, then the
/// velocities; then all other components, called first-order here.
#[derive(Clone, Copy, Debug)]
struct Layout {
    modes: usize,
    first_order: usize,
    lanes: usize,
}

impl Layout {
    /// Number of vectors of modes.
    fn pairs(self) -> usize {
        self.modes.div_ceil(self.lanes)
    }

    /// Number of vectors of first-order components.
    fn rest(self) -> usize {
        self.first_order.div_ceil(self.lanes)
    }

    /// Vectors of numbers of the modes; zero beyond the last mode.
    fn packed(self) -> Aligned {
        Aligned::zeros(self.pairs() * self.lanes)
    }
}

/// Linear parts of all modes, in vectors.
#[derive(Clone, Debug)]
struct LinearModes {
    /// `omega^2`, 1/s^2.
    stiffness: Aligned,
    /// `sigma = zeta omega`, 1/s.
    decay: Aligned,
    /// `omega_d`, rad/s.
    damped: Aligned,
    /// `1 / omega_d`, s; zero for a mode with zero frequency.
    inverse: Aligned,
    /// Largest `omega_d`, rad/s.
    fastest: f64,
    /// Whether any mode is damped.
    is_damped: bool,
}

impl LinearModes {
    fn new(sys: &dyn System, layout: Layout) -> Self {
        let mut linear = Self {
            stiffness: layout.packed(),
            decay: layout.packed(),
            damped: layout.packed(),
            inverse: layout.packed(),
            fastest: 0.0,
            is_damped: false,
        };
        linear.read(sys, layout.modes);
        linear
    }

    /// Reads the linear part of a system with an unchanged number of modes.
    fn read(&mut self, sys: &dyn System, modes: usize) {
        for (i, &omega) in sys.omega()[..modes].iter().enumerate() {
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
        self.fastest = self.damped.iter().copied().fold(0.0, f64::max);
        self.is_damped = self.decay.iter().any(|&sigma| sigma != 0.0);
    }
}

/// Number of coefficients of a mode in a [`Propagator`].
const COEFFICIENTS: usize = 6;

/// The propagator of the free vibration, `exp(t L)`, and the column of `exp(-t L)` that acts on a force: for each
/// vector of modes the coefficients `qq`, `qv`, `vq`, `vv` of the former and `q`, `v` of the latter.
#[derive(Clone, Debug)]
struct Propagator {
    layout: Layout,
    numbers: Aligned,
}

impl Propagator {
    fn new(layout: Layout) -> Self {
        Self {
            layout,
            numbers: Aligned::zeros(COEFFICIENTS * layout.pairs() * layout.lanes),
        }
    }
}

/// The kernel that applies a propagator to `width` tangent vectors, stored component by component.
struct MapVectors<'a> {
    propagator: &'a Propagator,
    vectors: &'a mut [f64],
    width: usize,
    map: VectorMap,
}

/// What a propagator does to tangent vectors.
#[derive(Clone, Copy)]
enum VectorMap {
    /// Applies `exp(t L)`.
    Forward,
    /// Applies `exp(-t L)` to slopes `[0 | f | ..]`.
    Backward,
}

impl WithSimd for MapVectors<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let modes = self.propagator.layout.modes;
        let (q, v) = self.vectors.split_at_mut(modes * self.width);
        let numbers = &self.propagator.numbers[..];
        // The few vectors of most runs need no loop.
        macro_rules! constant {
            ($width:literal) => {{
                let (q, v) = (q.as_chunks_mut::<$width>().0, v.as_chunks_mut::<$width>().0);
                for (i, (q, v)) in q.iter_mut().zip(v).enumerate() {
                    self.map.apply::<S>(numbers, i, q, v);
                }
            }};
        }
        match self.width {
            1 => constant!(1),
            2 => constant!(2),
            3 => constant!(3),
            width => {
                let rows = q.chunks_exact_mut(width).zip(v.chunks_exact_mut(width));
                for (i, (q, v)) in rows.enumerate() {
                    self.map.apply::<S>(numbers, i, q, v);
                }
            }
        }
    }
}

impl VectorMap {
    /// Maps the coordinates and velocities of mode `i` of all vectors; `numbers` are those of the propagator.
    #[inline(always)]
    fn apply<S: Simd>(self, numbers: &[f64], i: usize, q: &mut [f64], v: &mut [f64]) {
        let lanes = S::F64_LANES;
        let numbers = &numbers[i / lanes * COEFFICIENTS * lanes..][..COEFFICIENTS * lanes];
        let at = |k: usize| numbers[k * lanes + i % lanes];
        for (q, v) in q.iter_mut().zip(v) {
            (*q, *v) = match self {
                Self::Forward => (at(0) * *q + at(1) * *v, at(2) * *q + at(3) * *v),
                Self::Backward => (at(4) * *v, at(5) * *v),
            };
        }
    }
}

/// The kernel that sets the propagators over several times (s).
struct SetPropagators<'a> {
    linear: &'a LinearModes,
    times: &'a [f64],
    propagators: &'a mut [Propagator],
}

impl WithSimd for SetPropagators<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (k, &t) in self.times.iter().enumerate() {
            let (set, rest) = self.propagators.split_at_mut(k);
            let propagator = &mut rest[0].numbers;
            match set.last() {
                // The last two stages of a step belong to the same time.
                Some(last) if t == self.times[k - 1] => propagator.copy_from_slice(&last.numbers),
                _ => self.linear.set(simd, t, propagator),
            }
        }
    }
}

impl LinearModes {
    /// Sets the propagator over `t` (s).
    #[inline(always)]
    fn set<S: Simd>(&self, simd: S, t: f64, propagator: &mut [f64]) {
        let are_small = self.fastest * t.abs() < trigonometry::MAX_REDUCED_ANGLE;
        let (propagators, _) = S::as_mut_simd_f64s(propagator).0.as_chunks_mut();
        let pairs = propagators.len();
        let vectors = |numbers| &S::as_simd_f64s(numbers).0[..pairs];
        let (damped, inverse) = (vectors(&self.damped), vectors(&self.inverse));
        let (decay, stiffness) = (vectors(&self.decay), vectors(&self.stiffness));
        let time = simd.splat_f64s(t);
        for p in 0..pairs {
            let angle = simd.mul_f64s(damped[p], time);
            let [sin, cos] = trigonometry::sin_cos(simd, angle, are_small);
            // A mode with zero frequency: sin(omega t) / omega -> t.
            let at_rest = simd.equal_f64s(inverse[p], simd.splat_f64s(0.0));
            let s = simd.select_f64s(at_rest, time, simd.mul_f64s(sin, inverse[p]));
            let decay_term = simd.mul_f64s(decay[p], s);
            let sum = simd.add_f64s(cos, decay_term);
            let vq = simd.mul_f64s(simd.neg_f64s(stiffness[p]), s);
            let vv = simd.sub_f64s(cos, decay_term);
            let mut row = [sum, s, vq, vv, simd.neg_f64s(s), sum];
            if self.is_damped {
                let attenuation = self.attenuation(simd, p, t);
                for forward in &mut row[..4] {
                    *forward = simd.mul_f64s(*forward, attenuation);
                }
                for backward in &mut row[4..] {
                    *backward = simd.div_f64s(*backward, attenuation);
                }
            }
            let out: &mut [S::f64s; COEFFICIENTS] = &mut propagators[p];
            *out = row;
        }
    }

    /// `exp(-sigma t)` of a vector of modes.
    #[inline(always)]
    fn attenuation<S: Simd>(&self, simd: S, pair: usize, t: f64) -> S::f64s {
        let mut factors = simd.splat_f64s(0.0);
        let decay = &self.decay[pair * S::F64_LANES..][..S::F64_LANES];
        let lanes = pulp::bytemuck::cast_slice_mut(std::slice::from_mut(&mut factors));
        for (factor, decay) in lanes.iter_mut().zip(decay) {
            *factor = f64::exp(-decay * t);
        }
        factors
    }
}

/// The kernel that applies `exp(t L)` to a combination of slopes, the last of which may be due.
struct Advance<'a> {
    propagator: &'a Propagator,
    rows: Combination<'a>,
    /// What the last slope is computed from, unless it is known.
    due: Option<PullBack<'a>>,
    out: &'a mut [f64],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            propagator,
            rows,
            due,
            out,
        } = self;
        if let Some(due) = due {
            let last = (rows.weights.len() - 1) * rows.start.len();
            due.write(simd, &mut rows.slopes[last..][..rows.start.len()]);
        }
        propagator.advance(simd, &rows, out);
    }
}

impl Propagator {
    /// Writes `exp(t L)` times a combination to `out`.
    ///
    /// The last vector of the coordinates reaches into the velocities, and the last vector of these beyond their end.
    /// Therefore the vectors are written from the last one to the first one.
    #[inline(always)]
    fn advance<S: Simd>(&self, simd: S, combination: &Combination<'_>, out: &mut [f64]) {
        let pairs = self.layout.pairs();
        let mut pair = pairs;
        while pair >= 2 {
            pair -= 2;
            let [q, v, next_q, next_v] = combination.vectors(simd, 2 * pair);
            self.rotate(simd, pair + 1, [next_q, next_v], out);
            self.rotate(simd, pair, [q, v], out);
        }
        if pair == 1 {
            let motion = combination.vectors(simd, 0);
            self.rotate(simd, 0, motion, out);
        }
        if self.layout.first_order > 0 {
            combination.write(simd, 2 * pairs, &mut out[2 * self.layout.modes..]);
        }
    }

    /// Writes `exp(t L)` times the coordinates and velocities of a vector of modes to `out`.
    #[inline(always)]
    fn rotate<S: Simd>(&self, simd: S, pair: usize, [q, v]: [S::f64s; 2], out: &mut [f64]) {
        let row = &S::as_simd_f64s(&self.numbers).0[pair * COEFFICIENTS..][..COEFFICIENTS];
        let first = pair * S::F64_LANES;
        for (by, at) in [(0, first), (2, self.layout.modes + first)] {
            let sum = simd.add_f64s(simd.mul_f64s(row[by], q), simd.mul_f64s(row[by + 1], v));
            // Adding zero turns a negative zero into zero, which keeps a state at rest bitwise at rest.
            let sum = simd.add_f64s(sum, simd.splat_f64s(0.0));
            S::as_mut_simd_f64s(&mut out[at..][..S::F64_LANES]).0[0] = sum;
        }
    }
}

/// The kernel that writes `exp(-t L) [0 | f | g]` for the force `[f | g]`.
struct PullBack<'a> {
    propagator: &'a Propagator,
    force: &'a [f64],
}

impl PullBack<'_> {
    #[inline(always)]
    fn write<S: Simd>(&self, simd: S, slope: &mut [f64]) {
        let Layout {
            modes, first_order, ..
        } = self.propagator.layout;
        let pairs = self.propagator.layout.pairs();
        let (slopes, rest) = slope.split_at_mut(2 * pairs * S::F64_LANES);
        let slopes = &mut S::as_mut_simd_f64s(slopes).0[..2 * pairs];
        let force = &S::as_simd_f64s(self.force).0[..pairs];
        let row = &S::as_simd_f64s(&self.propagator.numbers).0[..COEFFICIENTS * pairs];
        for p in 0..pairs {
            slopes[2 * p] = simd.mul_f64s(row[COEFFICIENTS * p + 4], force[p]);
            slopes[2 * p + 1] = simd.mul_f64s(row[COEFFICIENTS * p + 5], force[p]);
        }
        if first_order > 0 {
            rest[..first_order].copy_from_slice(&self.force[modes..][..first_order]);
        }
    }
}

/// The kernel that writes a slope.
struct WriteSlope<'a> {
    pull_back: PullBack<'a>,
    slope: &'a mut [f64],
}

impl WithSimd for WriteSlope<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.pull_back.write(simd, self.slope);
    }
}

/// The coordinates `y` in which a Runge–Kutta method is applied. `y` equals the state `z` at the start of the step.
///
/// States `z` and slopes of `y` enter combinations as rows of whole vectors. Outputs `out` and forces have
/// [`MAX_LANES`](super::combination::MAX_LANES) numbers more than needed, which are arbitrary.
///
/// The transformation is linear and also applies to tangent vectors, `width` of them stored component by component.
#[derive(Clone, Debug)]
pub(super) struct IntegratingFactor {
    layout: Layout,
    linear: LinearModes,
    /// Step length for which `stages` is valid, s.
    h: f64,
    /// Propagators from the start of the step to each stage; that of the first stage is not used.
    stages: Vec<Propagator>,
    /// Propagator from the start of the step to a sample.
    sample: Propagator,
    /// Times of the stages from the start of the step, s.
    times: Vec<f64>,
    arch: Arch,
}

impl IntegratingFactor {
    /// The form of a system for a method with `stages` stages that integrates `modes` modes exactly: all of them, or
    /// none.
    pub fn new(sys: &dyn System, stages: usize, modes: usize) -> Self {
        let arch = instruction_set();
        let layout = Layout {
            modes,
            first_order: sys.dim() - 2 * modes,
            lanes: lanes(arch),
        };
        Self {
            layout,
            linear: LinearModes::new(sys, layout),
            h: 0.0,
            stages: vec![Propagator::new(layout); stages],
            sample: Propagator::new(layout),
            times: vec![0.0; stages],
            arch,
        }
    }

    /// Applies a propagator to `width` tangent vectors.
    fn map_vectors(
        &self,
        propagator: &Propagator,
        vectors: &mut [f64],
        width: usize,
        map: VectorMap,
    ) {
        self.arch.dispatch(MapVectors {
            propagator,
            vectors,
            width,
            map,
        });
    }

    /// Sets the propagator to a sample at `offset` (s) after the start of the step.
    fn prepare_sample(&mut self, offset: f64) {
        self.arch.dispatch(SetPropagators {
            linear: &self.linear,
            times: &[offset],
            propagators: std::slice::from_mut(&mut self.sample),
        });
    }

    /// Number of modes that are integrated exactly.
    pub fn modes(&self) -> usize {
        self.layout.modes
    }

    /// Length of a row.
    pub fn row_len(&self) -> usize {
        let Layout { lanes, .. } = self.layout;
        (2 * self.layout.pairs() + self.layout.rest()) * lanes
    }

    /// Position of a component of the state in a row.
    pub fn position(&self, component: usize) -> usize {
        let Layout { modes, lanes, .. } = self.layout;
        match component {
            q if q < modes => q / lanes * 2 * lanes + q % lanes,
            v if v < 2 * modes => {
                let v = v - modes;
                (v / lanes * 2 + 1) * lanes + v % lanes
            }
            w => 2 * self.layout.pairs() * lanes + w - 2 * modes,
        }
    }

    /// Writes a state or slope to a row.
    pub fn pack(&self, z: &[f64], row: &mut [f64]) {
        let Layout { modes, lanes, .. } = self.layout;
        let (motion, rest) = row.split_at_mut(2 * self.layout.pairs() * lanes);
        let (q, others) = z.split_at(modes);
        let (v, w) = others.split_at(modes);
        let vectors = q.chunks(lanes).zip(v.chunks(lanes));
        for (pair, (q, v)) in motion.chunks_exact_mut(2 * lanes).zip(vectors) {
            let (to_q, to_v) = pair.split_at_mut(lanes);
            to_q.iter_mut().zip(q).for_each(|(to, q)| *to = *q);
            to_v.iter_mut().zip(v).for_each(|(to, v)| *to = *v);
        }
        rest.iter_mut().zip(w).for_each(|(to, w)| *to = *w);
    }

    /// Adds the linear part that the method integrates to the slopes `[. | f | g]` of tangent vectors `z`.
    /// Components that are integrated exactly become zero.
    pub fn add_linear_part(&self, sys: &dyn System, z: &[f64], slope: &mut [f64], width: usize) {
        if self.layout.modes < sys.modes() {
            add_linear(sys.omega(), sys.damping(), z, slope, width);
        } else {
            slope[..self.layout.modes * width].fill(0.0);
        }
    }

    /// Prepares a step of length `h` (s) with stages at the fractions `nodes` of it.
    pub fn prepare(&mut self, nodes: &[f64], h: f64) {
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
        });
    }

    /// Writes the state `z` at a stage for a combination `y`. The last slope of the combination is written first if it is
    /// `due`: that of another stage with the given force.
    pub fn advance(
        &self,
        stage: usize,
        due: Option<(usize, &[f64])>,
        rows: Combination<'_>,
        out: &mut [f64],
    ) {
        self.arch.dispatch(Advance {
            propagator: &self.stages[stage],
            rows,
            due: due.map(|(from, force)| PullBack {
                propagator: &self.stages[from],
                force,
            }),
            out,
        });
    }

    /// Writes the state `z` at `offset` (s) after the start of the step for a combination `y`.
    pub fn advance_by(&mut self, offset: f64, rows: Combination<'_>, out: &mut [f64]) {
        self.prepare_sample(offset);
        self.arch.dispatch(Advance {
            propagator: &self.sample,
            rows,
            due: None,
            out,
        });
    }

    /// Writes the slope of `y` for the force `[f | g]` at a stage after the first to a row.
    pub fn slope(&self, stage: usize, force: &[f64], slope: &mut [f64]) {
        self.arch.dispatch(WriteSlope {
            pull_back: PullBack {
                propagator: &self.stages[stage],
                force,
            },
            slope,
        });
    }

    /// Transforms slopes of tangent vectors at a stage into slopes of `y`, in place.
    pub fn pull_back(&self, stage: usize, slope: &mut [f64], width: usize) {
        self.map_vectors(&self.stages[stage], slope, width, VectorMap::Backward);
    }

    /// Transforms tangent vectors from `y` to `z` at a stage, in place.
    pub fn push_forward(&self, stage: usize, y: &mut [f64], width: usize) {
        self.map_vectors(&self.stages[stage], y, width, VectorMap::Forward);
    }

    /// Transforms tangent vectors from `y` to `z` at `offset` (s) after the start of the step, in place.
    pub fn push_forward_by(&mut self, offset: f64, y: &mut [f64], width: usize) {
        self.prepare_sample(offset);
        self.map_vectors(&self.sample, y, width, VectorMap::Forward);
    }

    /// Updates the linear part for a changed system with the same number of modes.
    pub fn update_linear_part(&mut self, sys: &dyn System) {
        self.linear.read(sys, self.layout.modes);
        self.h = f64::NAN;
    }

    /// Maximum step that the linear part allows, s.
    pub fn max_step_of_linear_part(&self) -> f64 {
        let decay = self.linear.decay.iter();
        let fastest = decay.fold(0.0, |max: f64, sigma| max.max(sigma.abs()));
        MAX_EXPONENT / fastest
    }
}
