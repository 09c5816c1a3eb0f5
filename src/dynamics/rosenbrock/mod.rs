//! A linearly implicit method, for a law so stiff that explicit steps are held down by stability.
//!
//! Where slip comes to rest, friction pulls velocities together at rates far above the natural
//! frequencies. An explicit step must resolve these rates even when all of it has died away; a step
//! that solves linear systems with the Jacobian need not. The method is that of Rosenbrock and Wanner
//! of order 5(4) by Steinebach, Rodas5P: stiffly accurate, without loss of order in
//! the stiff limit of parabolic problems, dense output of order 4. Its coefficients and their source
//! are in `coefficients`. The Jacobian is that of [`Differentiable`], at the start of each step.

mod coefficients;
mod quadrature;
mod resolvent;
mod sdirk;
mod tangents;

use super::control::{Rule, Size};
use super::runge_kutta::accumulate;
use super::stepper::{Step, Stepper, differentiable, force, switching};
use super::system::add_linear;
use super::tangents::Bundle;
use super::{Differentiable, System, Tally};
use coefficients::{DRIFTS, GAMMA, NODES, RULE, SLOPES, STAGES, STATES};
use resolvent::Resolvent;

/// The method at work.
#[derive(Clone, Debug)]
pub(super) struct Rosenbrock {
    pub step: Step,
    /// The stages `u_j`, `stages x n`, where `n` is the length of the state without quadratures.
    stages: Vec<f64>,
    /// The state at a stage.
    state: Vec<f64>,
    /// The slope at a stage.
    slope: Vec<f64>,
    /// Slope of the state at the start of the step.
    start_slope: Vec<f64>,
    /// How the slope changes by itself, `dF/dt`, without quadratures.
    drift: Vec<f64>,
    /// Flows of the quadratures at the places of their rule.
    flows: Vec<f64>,
    /// Records at the start of the step and at its end.
    records: [Vec<f64>; 2],
    /// A record between the ends.
    between: Vec<f64>,
    resolvent: Resolvent,
    /// Whether the Jacobian and the drift are those at the start of the step.
    is_read: bool,
    /// About the fastest rate of the force at the start of the step, 1/s.
    pub fastest_rate: f64,
}

impl Rosenbrock {
    /// A workspace for a system that has a derivative.
    pub fn new<Y: System + ?Sized>(sys: &Y, derivative: &dyn Differentiable) -> Self {
        let (dim, n) = (sys.dim(), sys.tangent_dim());
        let record = vec![0.0; derivative.record_len()];
        Self {
            step: Step::new(dim),
            stages: vec![0.0; STAGES * n],
            state: vec![0.0; dim],
            slope: vec![0.0; dim],
            start_slope: vec![0.0; dim],
            drift: vec![0.0; n],
            flows: vec![0.0; quadrature::PLACES.len() * (dim - n)],
            records: [record.clone(), record.clone()],
            between: record,
            resolvent: Resolvent::new(sys),
            is_read: false,
            fastest_rate: 0.0,
        }
    }

    /// Evaluates the slope at the end of the step, with its record.
    fn slope_at_end<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>) {
        let step = &mut self.step;
        let out = &mut step.end_slope[sys.modes()..];
        let record = &mut self.records[1];
        differentiable(sys).force_recorded(status, step.end_time, &step.end, out, record);
        add_linear(
            sys.omega(),
            sys.damping(),
            &step.end,
            &mut step.end_slope,
            1,
        );
    }

    /// Takes the derivatives at the start of the step.
    fn read<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>) {
        self.resolvent.read(sys, status, &mut self.records[0]);
        self.fastest_rate = self.resolvent.fastest_rate();
        let (t, z) = (self.step.start_time, &self.step.start);
        let drift = &mut self.drift[sys.modes()..];
        differentiable(sys).time_derivative(status, t, z, drift);
        self.is_read = true;
    }

    /// Evaluates a stage.
    fn stage<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, stage: usize) {
        let (n, h) = (self.drift.len(), self.step.length());
        self.state.copy_from_slice(&self.step.start);
        if stage == 0 {
            self.slope.copy_from_slice(&self.start_slope);
        } else {
            accumulate(&mut self.state[..n], 1.0, &self.stages, STATES[stage]);
            let time = self.step.start_time + NODES[stage] * h;
            let out = &mut self.slope[sys.modes()..];
            force(sys, status, time, &self.state, out);
            add_linear(sys.omega(), sys.damping(), &self.state, &mut self.slope, 1);
            accumulate(&mut self.slope[..n], 1.0 / h, &self.stages, SLOPES[stage]);
        }
        let out = &mut self.stages[stage * n..][..n];
        let right = self.slope.iter().zip(&self.drift);
        for (out, (slope, drift)) in out.iter_mut().zip(right) {
            *out = slope + DRIFTS[stage] * h * drift;
        }
        self.resolvent.solve(out, 1);
    }

    /// Completes the end of the step and its error by the quadratures.
    fn integrate_quadratures<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        tally: &mut Tally,
    ) {
        let (n, h) = (self.drift.len(), self.step.length());
        let count = self.step.dim() - n;
        if count == 0 {
            return;
        }
        let last = quadrature::PLACES.len() - 1;
        self.flows[..count].copy_from_slice(&self.start_slope[n..]);
        self.flows[last * count..].copy_from_slice(&self.step.end_slope[n..]);
        for place in 1..last {
            let theta = quadrature::PLACES[place];
            self.state.copy_from_slice(&self.step.start);
            let weights = coefficients::weights(theta);
            accumulate(&mut self.state[..n], 1.0, &self.stages, &weights);
            let time = self.step.start_time + theta * h;
            force(
                sys,
                status,
                time,
                &self.state,
                &mut self.slope[sys.modes()..],
            );
            self.flows[place * count..][..count].copy_from_slice(&self.slope[n..]);
        }
        accumulate(
            &mut self.step.end[n..],
            h,
            &self.flows,
            &quadrature::weights(1.0),
        );
        for (k, error) in self.step.error[n..].iter_mut().enumerate() {
            let flow = std::array::from_fn(|place| self.flows[place * count + k]);
            *error = h * quadrature::error(flow);
        }
        tally.calls += last as u64 - 1;
    }
}

impl Stepper for Rosenbrock {
    fn step(&self) -> &Step {
        &self.step
    }

    fn step_mut(&mut self) -> &mut Step {
        &mut self.step
    }

    fn rule(&self) -> &'static Rule {
        &RULE
    }

    fn refresh<Y: System + ?Sized>(&mut self, sys: &Y, status: Option<&[u8]>, tally: &mut Tally) {
        tally.calls += 1;
        self.slope_at_end(sys, status);
        self.step.reach_time = self.step.end_time;
        // The record stays at the end, where the next step takes it from.
        self.step.anchor();
        self.start_slope.copy_from_slice(&self.step.end_slope);
    }

    fn follow<Y: System + ?Sized>(&mut self, _sys: &Y, _status: Option<&[u8]>, _tally: &mut Tally) {
        self.step.anchor();
        self.start_slope.copy_from_slice(&self.step.end_slope);
        self.records.swap(0, 1);
        self.is_read = false;
    }

    fn rewind(&mut self) {
        self.step.undo();
        self.step.end_slope.copy_from_slice(&self.start_slope);
        self.records.swap(0, 1);
    }

    fn attempt<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        end_time: f64,
        tally: &mut Tally,
    ) {
        self.step.end_time = end_time;
        self.step.reach_time = end_time;
        if !self.is_read {
            self.read(sys, status);
            tally.jacobians += 1;
        }
        self.resolvent.factor(1.0 / (GAMMA * self.step.length()));
        let n = self.drift.len();
        for stage in 0..STAGES {
            self.stage(sys, status, stage);
            if let Some(component) = self.slope[..n].iter().position(|x| !x.is_finite()) {
                // The linear system would spread it over all components.
                tally.calls += stage as u64;
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
        if let Some(status) = status {
            switching(sys).settle(status, end_time, &mut self.step.end);
        }
        self.slope_at_end(sys, status);
        tally.calls += STAGES as u64;
        self.integrate_quadratures(sys, status, tally);
    }

    fn error(&self, omega: &[f64]) -> Size {
        Size::of(&self.step.error, omega)
    }

    fn densify<Y: System + ?Sized>(
        &mut self,
        _sys: &Y,
        _status: Option<&[u8]>,
        _tally: &mut Tally,
    ) {
    }

    fn interpolate(&mut self, t: f64, out: &mut [f64]) {
        if let Some(state) = self.step.at_end(t) {
            out.copy_from_slice(state);
            return;
        }
        out.copy_from_slice(&self.step.start);
        let (n, h) = (self.drift.len(), self.step.length());
        let theta = (t - self.step.start_time) / h;
        let (rest, quadratures) = out.split_at_mut(n);
        accumulate(rest, 1.0, &self.stages, &coefficients::weights(theta));
        accumulate(quadratures, h, &self.flows, &quadrature::weights(theta));
    }

    fn record<Y: System + ?Sized>(&mut self, _sys: &Y) -> usize {
        sdirk::STAGES
    }

    fn forget_records(&mut self) {}

    fn carry<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        status: Option<&[u8]>,
        bundle: &mut Bundle,
        tally: &mut Tally,
    ) {
        self.carry_along(sys, status, bundle, tally);
    }
}
