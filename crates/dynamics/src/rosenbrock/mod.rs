//! A linearly implicit (Rosenbrock) method for systems whose stiffness limits explicit steps.
//!
//! During the transition from sliding to sticking, friction equalises velocities at rates far above the
//! natural frequencies. An explicit step must resolve these rates even after the transient has decayed.
//! A step that solves linear systems with the Jacobian need not. The method is Rodas5P of Steinebach, a
//! Rosenbrock–Wanner method of order 5(4): stiffly accurate, without order reduction for stiff parabolic
//! problems, dense output of order 4. The coefficients and their source are in `coefficients`. The
//! Jacobian is that of [`Differentiable`] at the start of each step.

mod coefficients;
mod quadrature;
mod resolvent;

use super::error_control::{MethodTraits, StateNorm};
use super::runge_kutta::accumulate;
use super::stepper::{Law, Step, Stepper};
use super::tangents::TangentBlock;
use super::{Differentiable, System};
use coefficients::{DRIFTS, GAMMA, NODES, SLOPES, STAGES, STATES, TRAITS};
use resolvent::Resolvent;

/// Share of a stage over which the Jacobian is differenced: no smaller, because a kink of the law within it changes the
/// difference in inverse proportion.
const DIFFERENCE: f64 = 1e-3;

/// The method with its workspace.
#[derive(Clone, Debug)]
pub(super) struct Rosenbrock {
    pub step: Step,
    /// Stages `u_j`, `stages x n`, where `n` is the length of the state without quadratures.
    stages: Vec<f64>,
    /// State at a stage.
    state: Vec<f64>,
    /// Slope at a stage.
    slope: Vec<f64>,
    /// Slope at the start of the step.
    start_slope: Vec<f64>,
    /// Partial time derivative of the slope, `dF/dt`, without quadratures.
    time_derivative: Vec<f64>,
    /// Integrands of the quadratures at the nodes of the quadrature rule.
    integrands: Vec<f64>,
    /// Records at the start and the end of the step.
    records: [Vec<f64>; 2],
    /// Records at the stages after the first, if tangent vectors are propagated; otherwise empty.
    stage_records: Vec<Vec<f64>>,
    /// Record at a state beside the start.
    beside: Vec<f64>,
    resolvent: Resolvent,
    /// Whether the Jacobian and the time derivative belong to the start of the step.
    is_jacobian_current: bool,
    /// Estimate of the fastest rate of the force at the start of the step, 1/s.
    pub fastest_rate: f64,
}

impl Rosenbrock {
    /// Workspace for a system with a derivative.
    pub fn new(sys: &dyn System, derivative: &dyn Differentiable) -> Self {
        let (dim, n) = (sys.dim(), sys.tangent_dim());
        let record = vec![0.0; derivative.record_len()];
        Self {
            step: Step::new(dim),
            stages: vec![0.0; STAGES * n],
            state: vec![0.0; dim],
            slope: vec![0.0; dim],
            start_slope: vec![0.0; dim],
            time_derivative: vec![0.0; n],
            integrands: vec![0.0; quadrature::NODES.len() * (dim - n)],
            records: [record.clone(), record.clone()],
            stage_records: Vec::new(),
            beside: record,
            resolvent: Resolvent::new(sys),
            is_jacobian_current: false,
            fastest_rate: 0.0,
        }
    }

    /// Evaluates the slope at the end of the step and stores its record.
    fn slope_at_end(&mut self, law: Law<'_>) {
        let (step, record) = (&mut self.step, Some(&mut self.records[1]));
        law.rhs(step.end_time, &step.end, &mut step.end_slope, record);
        step.stats.rhs_evals += 1;
    }

    /// Evaluates the derivatives at the start of the step.
    fn update_jacobian(&mut self, law: Law<'_>) {
        self.resolvent.update_jacobian(law, &mut self.records[0]);
        self.fastest_rate = self.resolvent.fastest_rate();
        let (t, z) = (self.step.start_time, &self.step.start);
        if !law.sys.is_autonomous() {
            law.time_derivative(t, z, &mut self.time_derivative[law.sys.modes()..]);
        }
        self.is_jacobian_current = true;
        self.step.stats.jacobians += 1;
    }

    /// Evaluates one stage.
    fn stage(&mut self, law: Law<'_>, stage: usize) {
        let (n, h) = (self.time_derivative.len(), self.step.length());
        self.state.copy_from_slice(&self.step.start);
        if stage == 0 {
            self.slope.copy_from_slice(&self.start_slope);
        } else {
            accumulate(&mut self.state[..n], 1.0, &self.stages, STATES[stage]);
            let time = self.step.start_time + NODES[stage] * h;
            let record = self.stage_records.get_mut(stage - 1);
            law.rhs(time, &self.state, &mut self.slope, record);
            self.step.stats.rhs_evals += 1;
            accumulate(&mut self.slope[..n], 1.0 / h, &self.stages, SLOPES[stage]);
        }
        let out = &mut self.stages[stage * n..][..n];
        let right = self.slope.iter().zip(&self.time_derivative);
        for (out, (slope, time_derivative)) in out.iter_mut().zip(right) {
            *out = slope + DRIFTS[stage] * h * time_derivative;
        }
        self.resolvent.solve(out, 1);
    }

    /// Computes the quadratures at the end of the step and their error estimates.
    fn integrate_quadratures(&mut self, law: Law<'_>) {
        let (n, h) = (self.time_derivative.len(), self.step.length());
        let count = self.step.dim() - n;
        if count == 0 {
            return;
        }
        let last = quadrature::NODES.len() - 1;
        self.integrands[..count].copy_from_slice(&self.start_slope[n..]);
        self.integrands[last * count..].copy_from_slice(&self.step.end_slope[n..]);
        for place in 1..last {
            let theta = quadrature::NODES[place];
            self.state.copy_from_slice(&self.step.start);
            let weights = coefficients::weights(theta);
            accumulate(&mut self.state[..n], 1.0, &self.stages, &weights);
            let time = self.step.start_time + theta * h;
            law.force(time, &self.state, &mut self.slope[law.sys.modes()..], None);
            self.step.stats.rhs_evals += 1;
            self.integrands[place * count..][..count].copy_from_slice(&self.slope[n..]);
        }
        let weights = quadrature::weights(1.0);
        accumulate(&mut self.step.end[n..], h, &self.integrands, &weights);
        for (k, error) in self.step.error[n..].iter_mut().enumerate() {
            let integrand = std::array::from_fn(|place| self.integrands[place * count + k]);
            *error = h * quadrature::error(integrand);
        }
    }
}

impl Stepper for Rosenbrock {
    fn step(&self) -> &Step {
        &self.step
    }

    fn step_mut(&mut self) -> &mut Step {
        &mut self.step
    }

    fn traits(&self) -> &'static MethodTraits {
        &TRAITS
    }

    fn reinitialise(&mut self, law: Law<'_>) {
        self.slope_at_end(law);
        self.step.full_end_time = self.step.end_time;
        // The record stays at the end; the next step takes it from there.
        self.step.start_at_end();
        self.start_slope.copy_from_slice(&self.step.end_slope);
    }

    fn begin_step(&mut self) {
        self.step.start_at_end();
        self.start_slope.copy_from_slice(&self.step.end_slope);
        self.records.swap(0, 1);
        self.is_jacobian_current = false;
    }

    fn reject_step(&mut self) {
        self.step.revert();
        self.step.end_slope.copy_from_slice(&self.start_slope);
        self.records.swap(0, 1);
    }

    fn attempt(&mut self, law: Law<'_>, end_time: f64) {
        self.step.end_time = end_time;
        self.step.full_end_time = end_time;
        if !self.is_jacobian_current {
            self.update_jacobian(law);
        }
        self.resolvent.factor(1.0 / (GAMMA * self.step.length()));
        let n = self.time_derivative.len();
        for stage in 0..STAGES {
            self.stage(law, stage);
            if let Some(component) = self.slope[..n].iter().position(|x| !x.is_finite()) {
                // The linear solve would spread the non-finite value to all components.
                self.step.end.copy_from_slice(&self.step.start);
                self.step.end[component] = f64::NAN;
                return;
            }
        }
        self.step.end.copy_from_slice(&self.state);
        self.step.error[..n].copy_from_slice(&self.stages[(STAGES - 1) * n..]);
        for (end, error) in self.step.end[..n].iter_mut().zip(&self.step.error) {
            *end += error;
        }
        law.settle(end_time, &mut self.step.end, (&mut [], 0));
        self.slope_at_end(law);
        self.integrate_quadratures(law);
    }

    fn error(&self, sys: &dyn System) -> StateNorm {
        StateNorm::of(&self.step.error, sys)
    }

    fn interpolate_inside(&mut self, t: f64, out: &mut [f64]) {
        out.copy_from_slice(&self.step.start);
        let (n, h) = (self.time_derivative.len(), self.step.length());
        let theta = (t - self.step.start_time) / h;
        let (rest, quadratures) = out.split_at_mut(n);
        accumulate(rest, 1.0, &self.stages, &coefficients::weights(theta));
        let weights = quadrature::weights(theta);
        accumulate(quadratures, h, &self.integrands, &weights);
    }

    fn enable_tangents(&mut self, _law: Law<'_>) -> usize {
        self.stage_records = vec![self.beside.clone(); STAGES - 1];
        STAGES
    }

    /// The vectors pass through the same stages as the state. The result is the derivative of the numerical map. The
    /// derivative of the Jacobian at the start, along the stage `(u_i, d_i h)`, is a central difference.
    fn propagate_tangents(&mut self, law: Law<'_>, block: &mut TangentBlock) {
        let (h, n) = (self.step.length(), self.time_derivative.len());
        let (width, numbers) = (block.width, block.end.len());
        let modes = law.sys.modes() * width;
        for stage in 0..STAGES {
            block.stage.copy_from_slice(&block.start);
            accumulate(&mut block.stage, 1.0, &block.slopes, STATES[stage]);
            let (before, rest) = block.slopes.split_at_mut(stage * numbers);
            let out = &mut rest[..numbers];
            let record = match stage {
                0 => &mut self.records[0],
                _ => &mut self.stage_records[stage - 1],
            };
            law.product(record, &block.stage, width, &mut out[modes..]);
            law.add_linear(&block.stage, out, width);
            accumulate(out, 1.0 / h, before, SLOPES[stage]);
            for step in [DIFFERENCE, -DIFFERENCE] {
                self.state.copy_from_slice(&self.step.start);
                let along = &self.stages[stage * n..][..n];
                accumulate(&mut self.state[..n], step, along, &[1.0]);
                let time = self.step.start_time + step * DRIFTS[stage] * h;
                let force = &mut self.slope[law.sys.modes()..];
                law.force(time, &self.state, force, Some(&mut self.beside));
                self.step.stats.rhs_evals += 1;
                let change = &mut block.end[modes..];
                law.product(&mut self.beside, &block.start, width, change);
                accumulate(&mut out[modes..], 0.5 / step, change, &[1.0]);
            }
            self.resolvent.solve(out, width);
        }
        block.end.copy_from_slice(&block.start);
        let theta = (self.step.end_time - self.step.start_time) / h;
        let weights = coefficients::weights(theta);
        accumulate(&mut block.end, 1.0, &block.slopes, &weights);
    }
}
