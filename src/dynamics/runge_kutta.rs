//! Explicit Runge–Kutta methods: step and dense output.
//!
//! One implementation of the step serves all [`Tableau`]s and both [`Form`]s.
//!
//! The stages of a step define a polynomial in the coordinates of the form, `y(t_n + theta h) = y_n + h
//! sum_i b_i(theta) k_i`. In the integrating-factor form the polynomial approximates only the effect of
//! the force. The free vibration up to the sample time is then applied exactly. Some tableaus need
//! additional stages for the dense output, which are evaluated on demand.

use super::combination::Combination;
use super::error_control::{MethodTraits, StateNorm};
use super::stepper::{Step, Stepper, differentiable, force, switching};
use super::tableau::Tableau;
use super::tangents::TangentBlock;
use super::{SolverStats, System};

/// The coordinates `y` in which a Runge–Kutta method is applied. `y` equals the state `z` at the start
/// of the step.
///
/// The transformation is linear and also applies to tangent vectors, `width` of them stored component by
/// component.
pub(super) trait Form {
    /// Adds the linear part that the method integrates to the slopes `[. | f | g]` of tangent vectors `z`.
    /// Components that the form integrates exactly become zero.
    fn add_linear_part<Y: System + ?Sized>(
        &self,
        sys: &Y,
        z: &[f64],
        slope: &mut [f64],
        width: usize,
    );

    /// Prepares a step of length `h` (s) with stages at the fractions `nodes` of it.
    fn prepare(&mut self, nodes: &[f64], h: f64);

    /// Writes the state `z` at a stage for a combination `y`.
    fn advance(&self, stage: usize, combination: Combination<'_>, out: &mut [f64]);

    /// Writes the state `z` at `offset` (s) after the start of the step for a combination `y`.
    fn advance_by(&mut self, offset: f64, combination: Combination<'_>, out: &mut [f64]);

    /// Writes the slope of `y` for the state `z` at a stage and the force `[f | g]` there. Stage 0 is the
    /// start of a step.
    fn slope<Y: System + ?Sized>(
        &self,
        sys: &Y,
        stage: usize,
        z: &[f64],
        force: &[f64],
        slope: &mut [f64],
    );

    /// Transforms slopes of tangent vectors at a stage into slopes of `y`, in place.
    fn pull_back(&self, stage: usize, slope: &mut [f64], width: usize);

    /// Transforms tangent vectors from `y` to `z` at a stage, in place.
    fn push_forward(&self, stage: usize, y: &mut [f64], width: usize);

    /// Transforms tangent vectors from `y` to `z` at `offset` (s) after the start of the step, in place.
    fn push_forward_by(&mut self, offset: f64, y: &mut [f64], width: usize);

    /// Updates the linear part for a changed system with the same number of modes.
    fn update_linear_part<Y: System + ?Sized>(&mut self, _sys: &Y) {}

    /// Maximum step that the linear part allows, s.
    fn max_step_of_linear_part(&self) -> f64 {
        f64::INFINITY
    }
}

/// A tableau in a form.
#[derive(Clone, Debug)]
pub(super) struct RungeKutta<P, const S: usize> {
    /// The method's coefficients.
    pub tableau: &'static Tableau<S>,
    /// Coordinates of the method.
    pub form: P,
    pub step: Step,
    /// Slopes of `y` at the stages, `stages x dim`, row-major.
    pub slopes: Vec<f64>,
    /// Force `[f | g]` at the present stage.
    force: Vec<f64>,
    /// State at a stage of the dense output.
    scratch: Vec<f64>,
    /// The start of a combination that is a difference.
    zeros: Vec<f64>,
    /// The second error estimate, if the tableau has one.
    coarse_error: Vec<f64>,
    /// Whether the dense-output stages belong to the last step.
    is_dense: bool,
    /// One record per stage if tangent vectors are propagated; otherwise empty.
    records: Vec<Vec<f64>>,
}

impl<P: Form, const S: usize> RungeKutta<P, S> {
    /// A workspace for a system.
    pub fn new<Y: System + ?Sized>(tableau: &'static Tableau<S>, form: P, sys: &Y) -> Self {
        let dim = sys.dim();
        Self {
            tableau,
            form,
            step: Step::new(dim),
            slopes: vec![0.0; S * dim],
            force: vec![0.0; dim - sys.modes()],
            scratch: vec![0.0; dim],
            zeros: vec![0.0; dim],
            coarse_error: vec![0.0; dim],
            is_dense: false,
            records: Vec::new(),
        }
    }

    /// Exchanges the records at the two ends of the step.
    fn swap_end_records(&mut self) {
        if !self.records.is_empty() {
            self.records.swap(0, self.tableau.end);
        }
    }

    /// Copies the slope at the end of the step to its start.
    fn reuse_end_slope(&mut self) {
        let dim = self.step.dim();
        self.slopes[..dim].copy_from_slice(&self.step.end_slope);
    }

    /// Writes the state at a stage.
    fn advance(&mut self, stage: usize, storage: StageState) {
        let combination = Combination {
            start: &self.step.start,
            h: self.step.length(),
            slopes: &self.slopes,
            weights: &self.tableau.stages[stage][..stage],
        };
        let out = match storage {
            StageState::End => &mut self.step.end,
            StageState::Scratch => &mut self.scratch,
        };
        self.form.advance(stage, combination, out);
    }

    /// Evaluates the force at a stage and writes the slope.
    fn evaluate<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        stage: usize,
        storage: StageState,
    ) {
        let z = match storage {
            StageState::End => &self.step.end,
            StageState::Scratch => &self.scratch,
        };
        let time = self.step.start_time + self.tableau.nodes[stage] * self.step.length();
        match self.records.get_mut(stage) {
            None => force(sys, status, time, z, &mut self.force),
            Some(record) => {
                differentiable(sys).force_recorded(status, time, z, &mut self.force, record);
            }
        }
        let slope = &mut self.slopes[stage * z.len()..][..z.len()];
        self.form.slope(sys, stage, z, &self.force, slope);
        if stage == self.tableau.end {
            // The same slope in the coordinates of the next step.
            let slope = &mut self.step.end_slope;
            self.form.slope(sys, 0, z, &self.force, slope);
        }
    }
}

/// Storage of the state at a stage.
#[derive(Clone, Copy)]
enum StageState {
    /// The end of the step.
    End,
    /// Scratch space for stages of the dense output.
    Scratch,
}

impl<P: Form, const S: usize> Stepper for RungeKutta<P, S> {
    fn step(&self) -> &Step {
        &self.step
    }

    fn step_mut(&mut self) -> &mut Step {
        &mut self.step
    }

    fn traits(&self) -> &'static MethodTraits {
        &self.tableau.traits
    }

    fn update_linear_part<Y: System + ?Sized>(&mut self, sys: &Y) {
        self.form.update_linear_part(sys);
    }

    fn max_step_of_linear_part(&self) -> f64 {
        self.form.max_step_of_linear_part()
    }

    fn reinitialise<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        stats: &mut SolverStats,
    ) {
        stats.rhs_evals += 1;
        self.step.full_end_time = self.step.end_time;
        self.step.start_time = self.step.end_time;
        self.evaluate(sys, status, self.tableau.end, StageState::End);
        // The record stays at the end; the next step takes it from there.
        self.step.start_at_end();
        self.reuse_end_slope();
    }

    fn begin_step<Y: System + ?Sized>(
        &mut self,
        _sys: &Y,
        _status: Option<&[u8]>,
        _tally: &mut SolverStats,
    ) {
        self.step.start_at_end();
        self.reuse_end_slope();
        self.swap_end_records();
    }

    fn reject_step(&mut self) {
        let dim = self.step.dim();
        self.step.revert();
        self.step.end_slope.copy_from_slice(&self.slopes[..dim]);
        self.swap_end_records();
    }

    fn attempt<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        end_time: f64,
        stats: &mut SolverStats,
    ) {
        self.step.end_time = end_time;
        self.step.full_end_time = end_time;
        self.is_dense = false;
        let h = self.step.length();
        let tableau = self.tableau;
        let end = tableau.end;
        self.form.prepare(&tableau.nodes, h);
        for stage in 1..=end {
            self.advance(stage, StageState::End);
            if let (true, Some(status)) = (stage == end, status) {
                switching(sys).settle(status, end_time, &mut self.step.end);
            }
            self.evaluate(sys, status, stage, StageState::End);
        }
        let difference = |weights| Combination {
            start: &self.zeros,
            h,
            slopes: &self.slopes,
            weights,
        };
        let error = difference(&tableau.error[..=end]);
        self.form.advance(end, error, &mut self.step.error);
        if let Some(weights) = &tableau.coarse_error {
            let error = difference(&weights[..=end]);
            self.form.advance(end, error, &mut self.coarse_error);
        }
        stats.rhs_evals += end as u64;
    }

    fn error(&self, omega: &[f64], quadratures: usize) -> StateNorm {
        let norm = |of: &[f64]| StateNorm::of(of, omega, quadratures);
        let error = norm(&self.step.error);
        match self.tableau.coarse_error {
            None => error,
            Some(_) => error.sharpened(norm(&self.coarse_error)),
        }
    }

    fn prepare_dense_output<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        stats: &mut SolverStats,
    ) {
        let tableau = self.tableau;
        if self.is_dense || self.step.length() == 0.0 {
            return;
        }
        self.is_dense = true;
        for stage in tableau.end + 1..S {
            self.advance(stage, StageState::Scratch);
            self.evaluate(sys, status, stage, StageState::Scratch);
        }
        stats.rhs_evals += (S - 1 - tableau.end) as u64;
    }

    fn interpolate(&mut self, t: f64, out: &mut [f64]) {
        if let Some(state) = self.step.at_end(t) {
            out.copy_from_slice(state);
            return;
        }
        let h = self.step.length();
        let offset = t - self.step.start_time;
        let combination = Combination {
            start: &self.step.start,
            h,
            slopes: &self.slopes,
            weights: &self.tableau.weights(offset / h),
        };
        self.form.advance_by(offset, combination, out);
    }

    fn enable_tangents<Y: System + ?Sized>(&mut self, sys: &Y) -> usize {
        self.records = vec![vec![0.0; differentiable(sys).record_len()]; S];
        S
    }

    fn disable_tangents(&mut self) {
        self.records.clear();
    }

    /// The vectors pass through the same stages as the state. The result is the exact derivative of the
    /// numerical map, whatever its tolerance.
    fn propagate_tangents<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        block: &mut TangentBlock,
        _tally: &mut SolverStats,
    ) {
        let width = block.width;
        let numbers = block.end.len();
        let derivative = differentiable(sys);
        let tableau = self.tableau;
        let h = self.step.length();
        let is_shortened = self.step.is_shortened();
        // The last stage of the step and later ones are needed only for dense output.
        let stages = if is_shortened { S } else { tableau.end };
        for stage in 0..stages {
            block.stage.copy_from_slice(&block.start);
            if stage > 0 {
                let weights = &tableau.stages[stage][..stage];
                accumulate(&mut block.stage, h, &block.slopes, weights);
                self.form.push_forward(stage, &mut block.stage, width);
            }
            let slope = &mut block.slopes[stage * numbers..][..numbers];
            derivative.product(
                status,
                &mut self.records[stage],
                &block.stage,
                width,
                &mut slope[sys.modes() * width..],
            );
            self.form.add_linear_part(sys, &block.stage, slope, width);
            if stage > 0 {
                self.form.pull_back(stage, slope, width);
            }
        }
        block.end.copy_from_slice(&block.start);
        if is_shortened {
            let offset = self.step.end_time - self.step.start_time;
            let weights = tableau.weights(offset / h);
            accumulate(&mut block.end, h, &block.slopes, &weights);
            self.form.push_forward_by(offset, &mut block.end, width);
        } else {
            let weights = &tableau.stages[tableau.end][..tableau.end];
            accumulate(&mut block.end, h, &block.slopes, weights);
            self.form.push_forward(tableau.end, &mut block.end, width);
        }
    }
}

/// Adds `h sum_j weights[j] slopes[j]` to `y`.
pub(super) fn accumulate(y: &mut [f64], h: f64, slopes: &[f64], weights: &[f64]) {
    // A constant number of terms lets the compiler keep the sum of each component in a register.
    match weights.len() {
        1 => accumulate_terms::<1>(y, h, slopes, weights),
        2 => accumulate_terms::<2>(y, h, slopes, weights),
        3 => accumulate_terms::<3>(y, h, slopes, weights),
        4 => accumulate_terms::<4>(y, h, slopes, weights),
        5 => accumulate_terms::<5>(y, h, slopes, weights),
        6 => accumulate_terms::<6>(y, h, slopes, weights),
        7 => accumulate_terms::<7>(y, h, slopes, weights),
        _ => {
            let (slopes, rest) = slopes.split_at(8 * y.len());
            accumulate_terms::<8>(y, h, slopes, &weights[..8]);
            if weights.len() > 8 {
                accumulate(y, h, rest, &weights[8..]);
            }
        }
    }
}

/// [`accumulate`] with `N` terms.
fn accumulate_terms<const N: usize>(y: &mut [f64], h: f64, slopes: &[f64], weights: &[f64]) {
    let dim = y.len();
    let weights: [f64; N] = std::array::from_fn(|j| weights[j]);
    let slopes: [&[f64]; N] = std::array::from_fn(|j| &slopes[j * dim..][..dim]);
    for (i, y) in y.iter_mut().enumerate() {
        let mut sum = weights[0] * slopes[0][i];
        for j in 1..N {
            sum += weights[j] * slopes[j][i];
        }
        *y += h * sum;
    }
}
