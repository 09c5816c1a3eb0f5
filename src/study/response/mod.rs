//! The settled response of a scene: where the motion goes, and everything that is told of it there.
//!
//! A run from the scene's kick, or from a state carried on from another run, until its transient is
//! over; then a stretch of the settled motion on which everything is measured at once, the Lyapunov
//! exponents by tangent vectors that go along.

mod columns;
mod measure;
mod recurrence;
mod settle;
mod settled;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use crate::analysis::AnalysisError;
use crate::dynamics::{DynamicsError, Integrator, System};
use crate::joint::BallJoint;
use crate::pipeline::{PipelineError, Prepared, prepare_on};
use crate::scene::Scene;

use super::pool::Heed;
use super::{StudyError, Watch, stability};
use measure::Samples;
pub use measure::section_lag;
use settle::Settling;
pub use settled::{Portrait, Response};

/// How a response is taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponsePlan {
    /// The least time before a transient counts as over, s.
    pub least: f64,
    /// The longest time waited for that, s. A motion that only looked settled may take one measurement
    /// more.
    pub most: f64,
    /// Time over which the settled motion is measured, s.
    pub measure: f64,
    /// How many of the largest Lyapunov exponents are followed; 0 for none. No more than there are.
    pub exponents: usize,
    /// Whether pieces of the motion are kept to draw from.
    pub portrait: bool,
    /// The most calls of the right-hand side: a motion that needs more is given up. `None` for no limit.
    pub most_calls: Option<u64>,
}

impl Default for ResponsePlan {
    fn default() -> Self {
        Self {
            least: 0.05,
            most: 1.0,
            // A thousand periods of the slowest mode: before that no exponent is told to be zero.
            measure: 0.6,
            exponents: 3,
            portrait: true,
            most_calls: None,
        }
    }
}

/// How a run starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum From<'a> {
    /// From the scene's own start, with its kick.
    Cold,
    /// From the state `[q | dq/dt]` that another run has come to.
    State(&'a [f64]),
}

/// What is being done, for a caller who waits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseProgress {
    /// Time simulated so far, s.
    pub simulated: f64,
    /// Time that it will probably take in all, s.
    pub expected: f64,
}

/// Periods of the slowest mode in a block of energies.
const BLOCK: f64 = 5.0;

/// Periods of the slowest mode in which the tangent vectors turn to their own directions.
const ALIGN: f64 = 40.0;

/// A joint whose displacement stays below this is silent, m; the same as the default of
/// `analysis.regime.silence_um`.
const SILENCE: f64 = 3e-10;

/// Takes the settled response of a scene. `ball` keeps the joint from one call to the next, so that
/// the body's modes are computed once only. The tilt is that at the scene's start.
///
/// `None` if `watch` says no.
///
/// # Errors
/// If the scene's system cannot be made, or its motion cannot be followed.
pub fn response(
    scene: &Scene,
    from: From<'_>,
    plan: &ResponsePlan,
    ball: &mut Option<BallJoint>,
    watch: Watch<'_, ResponseProgress>,
) -> Result<Option<Response>, ResponseError> {
    let mut prepared = prepare_on(scene, ball)?;
    let linear = match (scene.joint(), &ball) {
        (Ok(tilted), Some(ball)) => stability(ball, &[tilted.tilt.at(0.0)])?.pop(),
        _ => None,
    };
    if let From::State(z) = from {
        // What follows the vibration, such as a work, starts afresh.
        prepared.state.fill(0.0);
        let common = z.len().min(prepared.state.len());
        prepared.state[..common].copy_from_slice(&z[..common]);
    }
    let mut run = Run::new(prepared, scene, plan, watch)?;
    let Some(settled) = run.settle()? else {
        return Ok(None);
    };
    let transient = run.time();
    let width = plan.exponents.min(run.system.tangent_dim());
    if width > 0 && !run.follow(width, scene.start.seed)? {
        return Ok(None);
    }
    let Some(measured) = run.measure(transient)? else {
        return Ok(None);
    };
    let exponents = run.integrator.exponents();
    let silence = match linear {
        Some(_) => SILENCE,
        None => 0.0,
    };
    let by_samples = measured.samples.response(scene, silence)?;
    Ok(Some(Response {
        transient: measured.transient,
        settled: settled && !measured.changed,
        exponents: exponents.filter(|spectrum| spectrum.time > 0.0),
        linear,
        portrait: by_samples.portrait.filter(|_| plan.portrait),
        state: run.z[..2 * run.system.modes()].to_vec(),
        tally: run.integrator.tally(),
        ..by_samples
    }))
}

/// Why a response cannot be taken.
#[derive(Debug, thiserror::Error)]
pub enum ResponseError {
    /// The scene's system cannot be made.
    #[error(transparent)]
    Scene(#[from] PipelineError),
    /// The linear modes cannot be found.
    #[error(transparent)]
    Linear(#[from] StudyError),
    /// The integration cannot go on.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// The motion needs more work than it is worth.
    #[error(
        "given up after {calls} calls of the right-hand side at {:.3} ms: the motion needs very short \
         steps",
        1e3 * time
    )]
    Effort {
        /// Calls so far.
        calls: u64,
        /// Time reached, s.
        time: f64,
    },
    /// An analysis does not take the samples.
    #[error("the settled motion cannot be analysed")]
    Analysis(#[from] AnalysisError),
}

/// A motion on its way.
struct Run<'a> {
    system: Box<dyn System + Send>,
    probe: Vec<f64>,
    /// Samples a second.
    rate: f64,
    integrator: Integrator,
    /// State at the last sample.
    z: Vec<f64>,
    samples: u64,
    watch: Watch<'a, ResponseProgress>,
    heed: Heed,
    expected: f64,
    plan: &'a ResponsePlan,
}

/// A stretch of the motion after its transient.
struct Measured {
    samples: Samples,
    /// Time before it began, s.
    transient: f64,
    /// Whether it begins in one motion and ends in another.
    changed: bool,
}

impl<'a> Run<'a> {
    /// At the prepared state.
    fn new(
        prepared: Prepared,
        scene: &Scene,
        plan: &'a ResponsePlan,
        watch: Watch<'a, ResponseProgress>,
    ) -> Result<Self, ResponseError> {
        let mut run = Self {
            system: prepared.system,
            probe: prepared.probe,
            rate: scene.sample_rate,
            integrator: prepared.integrator,
            z: prepared.state,
            samples: 0,
            watch,
            heed: Heed::default(),
            expected: plan.least + plan.measure,
            plan,
        };
        run.integrator.start(&*run.system, 0.0, &run.z)?;
        Ok(run)
    }

    /// Time of the last sample, s.
    fn time(&self) -> f64 {
        self.samples as f64 / self.rate
    }

    /// Period of the slowest mode, s.
    fn period(&self) -> f64 {
        let slowest = self.system.omega().iter().copied().filter(|w| *w > 0.0);
        std::f64::consts::TAU / slowest.fold(f64::INFINITY, f64::min).min(f64::MAX)
    }

    /// Samples in a block of energies.
    fn block(&self) -> usize {
        (BLOCK * self.period() * self.rate).round().min(1e9) as usize
    }

    /// On to the next sample; whether to go on from there.
    fn on(&mut self) -> Result<bool, ResponseError> {
        self.samples += 1;
        let time = self.time();
        self.integrator.sample(&*self.system, time, &mut self.z)?;
        let calls = self.integrator.tally().calls;
        if self.plan.most_calls.is_some_and(|most| calls > most) {
            return Err(ResponseError::Effort { calls, time });
        }
        Ok(!self.heed.is_due() || self.goes_on())
    }

    /// Displacement (m) and velocity (m/s) of the probe.
    fn probe(&self) -> [f64; 2] {
        let (q, rest) = self.z.split_at(self.system.modes());
        let row = |x: &[f64]| self.probe.iter().zip(x).map(|(a, b)| a * b).sum();
        [row(q), row(rest)]
    }

    fn goes_on(&mut self) -> bool {
        let simulated = self.time();
        (self.watch)(ResponseProgress {
            simulated,
            expected: self.expected.max(simulated),
        })
    }

    /// Runs until the transient is over; whether it was. `None` if it was told to stop.
    fn settle(&mut self) -> Result<Option<bool>, ResponseError> {
        let plan = self.plan;
        let omega = self.system.omega().to_vec();
        let mut settling = Settling::new(omega.len(), self.block());
        let mut largest: f64 = 0.0;
        let mut look = 0;
        while self.time() < plan.most {
            if !self.on()? {
                return Ok(None);
            }
            largest = largest.max(self.probe()[0].abs());
            if !settling.push(&self.z, &omega) {
                continue;
            }
            let silent = largest < SILENCE && settling.blocks() > 1;
            largest = 0.0;
            // Looking again and again would end at the first chance: each look is a tenth later.
            if settling.blocks() < look || self.time() < plan.least {
                continue;
            }
            look = settling.blocks() + settling.blocks() / 10 + 1;
            if settling.is_over() || silent {
                return Ok(Some(true));
            }
            self.expected = 1.1 * self.time() + plan.measure;
        }
        Ok(Some(false))
    }

    /// Lets tangent vectors go along from here on, and find their directions. Whether it was not told to
    /// stop.
    fn follow(&mut self, width: usize, seed: u64) -> Result<bool, ResponseError> {
        let time = self.time();
        self.integrator.land(&*self.system, time)?;
        let start = self.integrator.state().to_vec();
        let mut with = self
            .integrator
            .clone()
            .with_tangents(&*self.system, width, seed)?;
        with.start(&*self.system, time, &start)?;
        self.integrator = with;
        let align = (ALIGN * self.period() * self.rate).min(1e9) as u64;
        for _ in 0..align {
            if !self.on()? {
                return Ok(false);
            }
        }
        let time = self.time();
        self.integrator.land(&*self.system, time)?;
        self.integrator.forget_growth();
        Ok(true)
    }

    /// Samples the settled motion after a transient, s. `None` if it was told to stop.
    fn measure(&mut self, mut transient: f64) -> Result<Option<Measured>, ResponseError> {
        loop {
            self.expected = self.time() + self.plan.measure;
            let Some((samples, changed)) = self.stretch()? else {
                return Ok(None);
            };
            if !changed || self.time() >= self.plan.most + self.plan.measure {
                return Ok(Some(Measured {
                    samples,
                    transient,
                    changed,
                }));
            }
            // What looked settled gave way to another motion: that one is measured.
            transient = self.time();
            self.integrator.forget_growth();
        }
    }

    /// Samples one stretch, and tells whether the motion has changed meanwhile. `None` if it was told to
    /// stop.
    fn stretch(&mut self) -> Result<Option<(Samples, bool)>, ResponseError> {
        let count = (self.plan.measure * self.rate).round().max(1.0) as usize;
        let mut samples = Samples::new(self.rate, count);
        let omega = self.system.omega().to_vec();
        let mut settling = Settling::new(omega.len(), self.block());
        let mut largest: f64 = 0.0;
        for _ in 0..count {
            if !self.on()? {
                return Ok(None);
            }
            let probe = self.probe();
            samples.push(probe);
            settling.push(&self.z, &omega);
            largest = largest.max(probe[0].abs());
        }
        let time = self.time();
        self.integrator.land(&*self.system, time)?;
        self.z.copy_from_slice(self.integrator.state());
        let changed = largest >= SILENCE && settling.has_changed();
        Ok(Some((samples, changed)))
    }
}
