//! Explicit Runge–Kutta methods: step and dense output.
//!
//! One implementation of the step serves all [`Tableau`]s and both forms of [`IntegratingFactor`].
//!
//! The stages of a step define a polynomial in the coordinates of the form, `y(t_n + theta h) = y_n + h
//! sum_i b_i(theta) k_i`. In the integrating-factor form the polynomial approximates only the effect of
//! the force. The free vibration up to the sample time is then applied exactly. Some tableaus need
//! additional stages for the dense output, which are evaluated on demand.

use super::System;
use super::error_control::{MethodTraits, StateNorm};
use super::integrating_factor::IntegratingFactor;
use super::stepper::{Law, Step, Stepper};
use super::tableau::{MAX_STAGES, Tableau};
use super::tangents::TangentBlock;
use crate::simd::vectorised;

/// A tableau in a form.
#[derive(Clone, Debug)]
pub(super) struct RungeKutta {
    /// The method's coefficients.
    pub tableau: &'static Tableau,
    /// Coordinates of the method.
    pub form: IntegratingFactor,
    pub step: Step,
    /// Slopes of `y` at the stages, `stages x dim`.
    slopes: Vec<f64>,
    /// State at the present stage.
    state: Vec<f64>,
    /// The second error estimate, if the tableau has one.
    coarse_error: Vec<f64>,
    /// Whether the dense-output stages belong to the last step.
    is_dense: bool,
    /// One record per stage if tangent vectors are propagated; otherwise empty.
    records: Vec<Vec<f64>>,
}

impl RungeKutta {
    /// A workspace for a system. The free vibration of `modes` modes is integrated exactly: all of them, or none.
    pub fn new(tableau: &'static Tableau, sys: &dyn System, modes: usize) -> Self {
        let (dim, stages) = (sys.dim(), tableau.nodes.len());
        Self {
            tableau,
            form: IntegratingFactor::new(sys, stages, modes),
            step: Step::new(dim),
            slopes: vec![0.0; stages * dim],
            state: vec![0.0; dim],
            coarse_error: vec![0.0; dim],
            is_dense: false,
            records: Vec::new(),
        }
    }

    /// Estimate of the fastest rate (1/s) of the force, from the changes of the slope and of the state between the last two
    /// stages of an attempted step.
    pub fn fastest_rate(&mut self, sys: &dyn System) -> f64 {
        let (end, dim) = (self.tableau.end, self.state.len());
        let mut state = [0.0; MAX_STAGES];
        for (sign, stage) in [(-1.0, end - 1), (1.0, end)] {
            for (sum, weight) in state.iter_mut().zip(self.tableau.stages[stage]) {
                *sum += sign * weight;
            }
        }
        let last = &self.slopes[(end - 1) * dim..];
        let sums: [(&[f64], &[f64]); 2] = [(last, &[-1.0, 1.0]), (&self.slopes, &state[..=end])];
        let [change, apart] = sums.map(|(slopes, weights)| {
            self.state.fill(0.0);
            accumulate(&mut self.state, 1.0, slopes, weights);
            StateNorm::of(&self.state, sys).without_quadratures()
        });
        let apart = self.step.length() * apart;
        let size = StateNorm::of(&self.step.end, sys).without_quadratures();
        // Below this the difference consists of rounding errors.
        if apart > 1e-13 * size {
            change / apart
        } else {
            0.0
        }
    }

    /// Exchanges the records at the two ends of the step.
    fn swap_end_records(&mut self) {
        if !self.records.is_empty() {
            self.records.swap(0, self.tableau.end);
        }
    }

    /// Writes the state at a stage.
    fn advance(&mut self, stage: usize) {
        self.state.copy_from_slice(&self.step.start);
        self.combine(&self.tableau.stages[stage][..stage], stage);
    }

    /// Adds a combination of slopes to `y` in `state`, and transforms it to a state: at a stage, or, after the last one, at
    /// the sample for which the form is prepared.
    fn combine(&mut self, weights: &[f64], stage: usize) {
        accumulate(&mut self.state, self.step.length(), &self.slopes, weights);
        self.form.push_forward(stage, &mut self.state, 1);
    }

    /// Evaluates the slope at a stage, which is not yet transformed to that of `y`.
    fn evaluate(&mut self, law: Law<'_>, stage: usize) {
        let dim = self.step.dim();
        let (z, slope) = (&self.state, &mut self.slopes[stage * dim..][..dim]);
        let time = self.step.start_time + self.tableau.nodes[stage] * self.step.length();
        let record = self.records.get_mut(stage);
        law.force(time, z, &mut slope[law.sys.modes()..], record);
        self.form.add_linear_part(law, z, slope, 1);
        self.step.stats.rhs_evals += 1;
        if stage == self.tableau.end {
            self.step.end_slope.copy_from_slice(slope);
        }
    }

    /// Transforms the slope at a stage to that of `y`.
    fn pull_back(&mut self, stage: usize) {
        let dim = self.step.dim();
        let slope = &mut self.slopes[stage * dim..][..dim];
        self.form.pull_back(stage, slope, 1);
    }

    /// Writes a combination of all slopes of the step to `state`, as a difference at its end.
    fn difference(&mut self, weights: &[f64]) {
        self.state.fill(0.0);
        self.combine(weights, self.tableau.end);
    }
}

impl Stepper for RungeKutta {
    fn step(&self) -> &Step {
        &self.step
    }

    fn step_mut(&mut self) -> &mut Step {
        &mut self.step
    }

    fn traits(&self) -> &'static MethodTraits {
        &self.tableau.traits
    }

    fn reinitialise(&mut self, law: Law<'_>) {
        self.step.full_end_time = self.step.end_time;
        self.step.start_time = self.step.end_time;
        self.state.copy_from_slice(&self.step.end);
        // The record stays at the end; the next step takes it from there.
        self.evaluate(law, self.tableau.end);
        self.step.start_at_end();
        self.slopes[..self.step.dim()].copy_from_slice(&self.step.end_slope);
    }

    fn begin_step(&mut self) {
        self.step.start_at_end();
        self.slopes[..self.step.dim()].copy_from_slice(&self.step.end_slope);
        self.swap_end_records();
    }

    fn reject_step(&mut self) {
        self.step.revert();
        let start_slope = &self.slopes[..self.step.dim()];
        self.step.end_slope.copy_from_slice(start_slope);
        self.swap_end_records();
    }

    fn attempt(&mut self, law: Law<'_>, end_time: f64) {
        self.step.end_time = end_time;
        self.step.full_end_time = end_time;
        self.is_dense = false;
        let (tableau, end) = (self.tableau, self.tableau.end);
        self.form.prepare(tableau.nodes, self.step.length());
        for stage in 1..=end {
            self.advance(stage);
            if stage == end {
                law.settle(end_time, &mut self.state, (&mut [], 0));
            }
            self.evaluate(law, stage);
            self.pull_back(stage);
        }
        self.step.end.copy_from_slice(&self.state);
        self.difference(&tableau.error[..=end]);
        self.step.error.copy_from_slice(&self.state);
        if let Some(weights) = tableau.coarse_error {
            self.difference(&weights[..=end]);
            self.coarse_error.copy_from_slice(&self.state);
        }
    }

    fn error(&self, sys: &dyn System) -> StateNorm {
        let error = StateNorm::of(&self.step.error, sys);
        match self.tableau.coarse_error {
            None => error,
            Some(_) => error.sharpened(StateNorm::of(&self.coarse_error, sys)),
        }
    }

    fn prepare_dense_output(&mut self, law: Law<'_>) {
        if self.is_dense || self.step.length() == 0.0 {
            return;
        }
        self.is_dense = true;
        for stage in self.tableau.end + 1..self.tableau.nodes.len() {
            self.advance(stage);
            self.evaluate(law, stage);
            self.pull_back(stage);
        }
    }

    fn interpolate_inside(&mut self, t: f64, out: &mut [f64]) {
        let h = self.step.length();
        let offset = t - self.step.start_time;
        self.form.prepare_sample(offset);
        self.state.copy_from_slice(&self.step.start);
        let weights = self.tableau.weights(offset / h);
        let stages = self.tableau.nodes.len();
        self.combine(&weights[..stages], stages);
        out.copy_from_slice(&self.state);
    }

    fn enable_tangents(&mut self, law: Law<'_>) -> usize {
        let stages = self.tableau.nodes.len();
        self.records = vec![vec![0.0; law.record_len()]; stages];
        stages
    }

    /// The vectors pass through the same stages as the state. The result is the exact derivative of the
    /// numerical map, whatever its tolerance.
    fn propagate_tangents(&mut self, law: Law<'_>, block: &mut TangentBlock) {
        let width = block.width;
        let numbers = block.end.len();
        let tableau = self.tableau;
        let h = self.step.length();
        let is_shortened = self.step.is_shortened();
        // The last stage of the step and later ones are needed only for dense output.
        let stages = if is_shortened {
            tableau.nodes.len()
        } else {
            tableau.end
        };
        for stage in 0..stages {
            block.stage.copy_from_slice(&block.start);
            if stage > 0 {
                let weights = &tableau.stages[stage][..stage];
                accumulate(&mut block.stage, h, &block.slopes, weights);
                self.form.push_forward(stage, &mut block.stage, width);
            }
            let slope = &mut block.slopes[stage * numbers..][..numbers];
            let out = &mut slope[law.sys.modes() * width..];
            law.product(&mut self.records[stage], &block.stage, width, out);
            self.form.add_linear_part(law, &block.stage, slope, width);
            if stage > 0 {
                self.form.pull_back(stage, slope, width);
            }
        }
        block.end.copy_from_slice(&block.start);
        let weights = if is_shortened {
            let offset = self.step.end_time - self.step.start_time;
            self.form.prepare_sample(offset);
            &tableau.weights(offset / h)[..stages]
        } else {
            &tableau.stages[stages][..stages]
        };
        accumulate(&mut block.end, h, &block.slopes, weights);
        self.form.push_forward(stages, &mut block.end, width);
    }
}

/// Adds `h sum_j weights[j] slopes[j]` to `y`.
pub(super) fn accumulate(y: &mut [f64], h: f64, slopes: &[f64], weights: &[f64]) {
    vectorised(
        #[inline(always)]
        || {
            let first = accumulate_groups::<8>(y, 0, h, slopes, weights);
            let first = accumulate_groups::<4>(y, first, h, slopes, weights);
            accumulate_groups::<1>(y, first, h, slopes, weights);
        },
    );
}

/// Adds the sums to whole groups of `N` components from `first` on, which stay in registers; returns the first
/// component after them.
#[inline(always)]
fn accumulate_groups<const N: usize>(
    y: &mut [f64],
    mut first: usize,
    h: f64,
    slopes: &[f64],
    weights: &[f64],
) -> usize {
    let dim = y.len();
    for y in y[first..].as_chunks_mut::<N>().0 {
        let mut sums = [0.0; N];
        for (j, weight) in weights.iter().enumerate() {
            for (sum, x) in sums.iter_mut().zip(&slopes[j * dim + first..][..N]) {
                *sum += weight * x;
            }
        }
        for (y, sum) in y.iter_mut().zip(sums) {
            *y += h * sum;
        }
        first += N;
    }
    first
}
