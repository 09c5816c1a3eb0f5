//! Lyapunov exponents with confidence intervals: averaging until a goal is reached.

mod report;

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;
use std::time::Instant;

use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::{
    Attractor, DynamicsError, Exponent, Integrator, LyapunovSpectrum, MIN_PERIODS_FOR_ZERO, Motion,
    Sign, SolverStats,
};

use super::{OnProgress, POLL, Stopped};
use crate::dynamics::equilibrium::Jacobian;
use crate::pipeline::message::{Classification, MotionSegment};
use crate::pipeline::{ChangeDetector, PipelineError, Simulation, Source as _};
use crate::report::Measured;
use crate::scene::{FixedAt, Scene};
pub use report::{LyapunovResult, title};

/// Goal of the averaging: the criterion that ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// A fixed averaging time, s.
    Time(f64),
    /// A target half-width of every exponent's 95 % interval, 1/s. Exponents of minus infinity count as
    /// known.
    HalfWidth(f64),
    /// A classified attractor, or at least a known sign of each computed exponent.
    Classification,
}

/// Plan of the averaging of Lyapunov exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LyapunovPlan {
    /// Settling time, s: the tangent vectors align with the Lyapunov directions before averaging starts.
    pub settle: f64,
    /// Goal that ends the averaging.
    pub goal: Goal,
    /// Minimum averaging time for a goal other than time, s. It prevents a goal from being reached by chance in a short
    /// average.
    pub min_time: f64,
    /// Maximum averaging time of one motion for a goal other than time, s, whether or not the goal is reached. If the motion
    /// changes, the time starts again, up to twice the maximum in total.
    pub max_time: f64,
    /// Sampling interval of the state, s: of the progress, the goal and the mean trace.
    pub sample_interval: f64,
    /// Time since which the parameters are constant, s. A chaotic transient counts from there.
    pub constant_since: f64,
}

/// The reason why averaging ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ending {
    /// The goal was reached.
    #[default]
    Reached,
    /// The maximum averaging time was reached before the goal.
    MaxTimeReached,
    /// The caller stopped it.
    Stopped,
}

/// Running estimates of the exponents after some averaging time.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RunningExponents {
    /// Averaging time so far, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Estimates of the exponents at that time, 1/s.
    #[serde(rename = "exponents_per_s")]
    pub exponents: Vec<Exponent>,
}

/// Result of a Lyapunov study, with its conclusions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct LyapunovStudy {
    /// Criterion that ends the averaging: `time`, `half_width` or `verdict`.
    pub goal: &'static str,
    /// Whether the criterion was met.
    pub goal_reached: bool,
    /// Whether the study was interrupted.
    pub interrupted: bool,
    /// What the exponents say.
    #[serde(flatten)]
    pub classification: Classification,
    /// Sum of all exponents, 1/s; `null` if not all are computed, or if one is minus infinity.
    pub sum_per_s: Option<f64>,
    /// Numbers, from 1, of exponents that are significantly below the next one: their tangent vectors are not
    /// aligned.
    pub unsettled: Vec<usize>,
    /// Simulated time over wall time; `null` if nothing was averaged.
    pub real_time_factor: Option<f64>,
    /// Reasons to distrust the result, each with its remedy.
    pub warnings: Vec<String>,
    /// Lifetime of the chaotic transient before the last motion, s: the time from the start of the run, or
    /// from the end of its schedules, to the end of the last chaotic motion before the last one. `None` if
    /// no earlier motion was chaotic.
    pub chaotic_transient_s: Option<f64>,
    /// The Lyapunov spectrum of the last motion; without exponents if the study was stopped before averaging.
    #[serde(flatten)]
    pub spectrum: LyapunovSpectrum,
    /// Properties of the motion that the classification uses besides the exponents.
    pub motion: Motion,
    /// Running estimates for the last motion at times spaced by 3 %; the last ones equal the spectrum.
    pub running: Vec<RunningExponents>,
    /// Successive motions since the averaging started, separated by changes of attractor; the last one has
    /// the exponents above.
    pub segments: Vec<MotionSegment>,
    /// Mean trace of `dF/dz` over time, 1/s. It equals the sum of all exponents. `None` if not all
    /// exponents are computed, if the motion changed, or if events make the state or the force law
    /// discontinuous.
    pub mean_trace_per_s: Option<f64>,
    /// Reason why averaging ended.
    #[serde(skip)]
    pub ending: Ending,
    /// Settling time of the tangent vectors, s.
    pub settle_s: f64,
    /// Solver statistics, including the settling time.
    #[serde(flatten)]
    pub stats: SolverStats,
    /// Simulated time, including the settling time, s.
    pub simulated_s: f64,
    /// Wall-clock time of the computation, s.
    #[serde(rename = "wall_s")]
    pub busy_seconds: f64,
}

impl LyapunovStudy {
    /// Classification of the attractor; undecided if there are no exponents.
    pub fn attractor(&self) -> Attractor {
        self.classification.attractor
    }

    /// Relative difference between the sum of all exponents and the mean trace: a check of how well the time
    /// steps resolve the contraction rates. The reference is the sum of the exponents' magnitudes. `None` if
    /// the sum or the trace is unknown.
    pub fn imbalance(&self) -> Option<f64> {
        let (sum, trace) = self.sum().zip(self.mean_trace_per_s)?;
        let sizes = self.spectrum.exponents.iter().map(|e| e.value.abs());
        // The trace of a conservative system is zero and cannot be the reference.
        let size = sizes.sum::<f64>().max(trace.abs());
        (size > 0.0).then(|| (sum - trace).abs() / size)
    }

    /// Contraction of the last computed direction in a mean time step, as a natural logarithm. Zero if the
    /// direction does not contract, or if its exponent is minus infinity.
    pub fn contraction_per_step(&self) -> f64 {
        let last = self.spectrum.exponents.last().map(|e| -e.value);
        let rate = last.filter(|rate| rate.is_finite()).unwrap_or(0.0);
        rate.max(0.0) * self.simulated_s / self.stats.steps.max(1) as f64
    }

    /// Numbers, from 1, of exponents that are smaller than the next one by more than both intervals. Aligned tangent
    /// vectors have descending growth rates, so such a pair shows that the settling time was too short. A
    /// drift that does not change the order widens the intervals.
    pub fn unsettled(&self) -> Vec<usize> {
        let pairs = (1..).zip(self.spectrum.exponents.windows(2));
        let swapped = pairs.filter(|(_, pair)| pair[0].high() < pair[1].low());
        swapped.map(|(k, _)| k).collect()
    }

    /// Sum of all exponents, 1/s; `None` if not all are computed.
    pub fn sum(&self) -> Option<f64> {
        let exponents = &self.spectrum.exponents;
        let all = !exponents.is_empty() && exponents.len() == self.spectrum.dimension;
        all.then(|| exponents.iter().map(|exponent| exponent.value).sum())
    }
}

/// Ratio of successive times at which running estimates are kept.
const SPACING: f64 = 1.03;
/// The first of these times, in sampling intervals.
const FIRST: f64 = 16.0;

/// Averages the growth of the tangent vectors of a started integrator ([`Integrator::with_tangents`]) until
/// the goal is reached, after a settling time. The statistics of the integrator begin here. An average never contains a
/// change of attractor: it starts again there, see [`LyapunovStudy::segments`].
///
/// # Errors
/// [`DynamicsError::MissingCapability`] if the integrator has no tangent vectors, and any error of the integration.
pub fn lyapunov(
    integrator: &mut Integrator<'_>,
    plan: &LyapunovPlan,
    progress: OnProgress<'_>,
) -> Result<LyapunovStudy, DynamicsError> {
    let began = Instant::now();
    let width = integrator.exponents().map_or(0, |s| s.exponents.len());
    if width == 0 {
        return Err(DynamicsError::MissingCapability {
            what: "tangent vectors",
            purpose: "exponents",
        });
    }
    integrator.reset_stats();
    let start = integrator.time();
    let sys = integrator.system();
    let is_smooth = width == sys.tangent_dim() && !sys.jumps();
    let law = sys.differentiable().filter(|_| is_smooth);
    let mut run = StudyRun {
        jacobian: law.map(Jacobian::new),
        trace: 0.0,
        z: integrator.state().to_vec(),
        integrator,
        plan,
        start,
        samples: 0,
        progress,
        needed: plan.min_time,
        begun: 0.0,
        study: LyapunovStudy::default(),
    };
    let settled = run.settle();
    run.integrator.reset_growth();
    run.study.settle_s = run.time() - start;
    run.study.ending = match settled.and_then(|()| run.average()) {
        Err(DynamicsError::Stopped(_)) => Ending::Stopped,
        ended => ended?,
    };
    run.study.simulated_s = run.time() - start;
    let mut study = run.study;
    let last = study.segments.last();
    let last = last.map(|segment| segment.spectrum.clone());
    study.spectrum = last.unwrap_or_else(|| run.integrator.exponents().unwrap_or_default());
    if study.spectrum.time == 0.0 {
        study.spectrum.exponents.clear();
        study.spectrum.resolution = f64::INFINITY;
    }
    keep(&mut study.running, &study.spectrum);
    let is_one = !study.spectrum.exponents.is_empty() && study.segments.len() == 1;
    study.mean_trace_per_s = run.jacobian.filter(|_| is_one).map(|_| run.trace);
    study.motion = run.integrator.motion();
    study.stats = run.integrator.stats();
    study.busy_seconds = began.elapsed().as_secs_f64();
    study.chaotic_transient_s =
        MotionSegment::chaotic_transient(&study.segments, plan.constant_since);
    let omega = run.integrator.system().omega().iter().copied();
    let omega_1 = omega.fold(f64::INFINITY, f64::min);
    Ok(study.concluded(plan.goal, run.integrator.tolerance(), omega_1))
}

impl LyapunovPlan {
    /// Whether the goal is reached after an averaging time, s. A fixed time is counted in sampling intervals by the caller.
    fn reached(&self, spectrum: &LyapunovSpectrum, motion: Motion, time: f64) -> bool {
        let is_reached = match self.goal {
            Goal::Time(_) => false,
            Goal::HalfWidth(wanted) => widest(spectrum) <= wanted,
            // All signs may be known although too few exponents are computed for a classification.
            Goal::Classification => {
                spectrum.attractor_of(motion).is_decided()
                    || spectrum.count(Sign::Undetermined) == 0
            }
        };
        is_reached && time >= self.min_time
    }

    /// Estimated total averaging time, s; half-widths decrease with its square root.
    fn needed(&self, spectrum: &LyapunovSpectrum, time: f64) -> f64 {
        let factor = match self.goal {
            Goal::HalfWidth(wanted) => (widest(spectrum) / wanted).powi(2),
            Goal::Time(_) | Goal::Classification => 1.2,
        };
        (factor * time).max(self.min_time).min(self.max_time)
    }
}

/// Keeps the current estimates unless their time is kept already: growth is known per time step, and two
/// samples may lie within the same step.
fn keep(running: &mut Vec<RunningExponents>, spectrum: &LyapunovSpectrum) {
    let newer = running.last().is_none_or(|last| last.time < spectrum.time);
    if newer && spectrum.time > 0.0 {
        running.push(RunningExponents {
            time: spectrum.time,
            exponents: spectrum.exponents.clone(),
        });
    }
}

/// The largest half-width of the finite exponents, 1/s.
fn widest(spectrum: &LyapunovSpectrum) -> f64 {
    let finite = spectrum.exponents.iter().filter(|e| e.value.is_finite());
    finite.fold(0.0, |most, e| most.max(e.half_width))
}

/// A Lyapunov study in progress.
struct StudyRun<'a, 's> {
    integrator: &'a mut Integrator<'s>,
    plan: &'a LyapunovPlan,
    start: f64,
    samples: u64,
    /// State at the last sample.
    z: Vec<f64>,
    progress: OnProgress<'a>,
    /// Estimated total averaging time, s.
    needed: f64,
    /// The result so far.
    study: LyapunovStudy,
    /// Averaging time before the average of the present motion started, s; 0 for a fixed averaging time.
    begun: f64,
    /// Workspace of the mean trace; `None` if not all exponents are computed, events make volumes jump, or there is no
    /// derivative.
    jacobian: Option<Jacobian>,
    /// Mean trace of `dF/dz` over the samples of the average, 1/s: the rate at which phase-space volume grows, by
    /// Liouville's theorem the sum of all exponents.
    trace: f64,
}

impl StudyRun<'_, '_> {
    /// Advances to the next sample.
    fn advance(&mut self) -> Result<(), DynamicsError> {
        self.samples += 1;
        let time = self.time();
        self.integrator.sample(time, &mut self.z)
    }

    /// Time of the last sample, s.
    fn time(&self) -> f64 {
        self.start + self.samples as f64 * self.plan.sample_interval
    }

    /// Lets the tangent vectors align.
    fn settle(&mut self) -> Result<(), DynamicsError> {
        let plan = self.plan;
        let last = (plan.settle / plan.sample_interval).ceil() as u64;
        for sample in 0..=last {
            let share = sample as f64 * plan.sample_interval / (plan.settle + self.needed);
            if sample.is_multiple_of(POLL) {
                (self.progress)(share, "aligning the tangent vectors")?;
            }
            if sample < last {
                self.advance()?;
            }
        }
        Ok(())
    }

    /// The task, with the largest exponent so far.
    fn averaging(&self) -> String {
        let running = &self.study.running;
        let largest = running.last().and_then(|last| last.exponents.first());
        let largest = largest.map(|largest| Measured::from(largest).unit("1/s"));
        largest.map_or("averaging".to_owned(), |largest| {
            format!("averaging, largest exponent {largest}")
        })
    }

    /// Averages the growth until the goal is reached.
    fn average(&mut self) -> Result<Ending, DynamicsError> {
        let plan = self.plan;
        let (start, interval) = (self.integrator.time(), plan.sample_interval);
        let mut detector = ChangeDetector::new(self.integrator, start, interval);
        let (mut sample, mut kept) = (0, FIRST);
        loop {
            self.advance()?;
            detector.push(self.integrator, &self.z);
            sample += 1;
            self.add_trace(sample);
            let time = sample as f64 * interval;
            let is_last = sample >= self.last_sample();
            let share = (plan.settle + time) / (plan.settle + self.needed.max(time));
            let task = (is_last || self.samples % POLL == 1).then(|| self.averaging());
            let stopped = task.is_some_and(|task| (self.progress)(share, &task).is_err());
            if stopped || is_last || sample as f64 >= kept {
                kept *= SPACING;
                if self.reached(&mut detector, time) {
                    return Ok(Ending::Reached);
                }
                // A change found at the last sample starts another average.
                if sample >= self.last_sample() {
                    return Ok(match plan.goal {
                        Goal::Time(_) => Ending::Reached,
                        Goal::HalfWidth(_) | Goal::Classification => Ending::MaxTimeReached,
                    });
                }
                if stopped {
                    return Err(Stopped.into());
                }
            }
        }
    }

    /// Divides the time so far into motions and keeps the current estimates, which start again with each change; returns
    /// whether they reach the goal after an averaging time, s.
    fn reached(&mut self, detector: &mut ChangeDetector, time: f64) -> bool {
        let LyapunovStudy {
            running, segments, ..
        } = &mut self.study;
        let before = std::mem::replace(segments, detector.segments(self.integrator));
        if segments.len() != before.len() {
            running.clear();
        }
        let last = segments.last().map(|segment| &segment.spectrum);
        let Some(spectrum) = last.filter(|spectrum| spectrum.time > 0.0) else {
            return false;
        };
        self.begun = match (self.plan.goal, segments.len()) {
            (Goal::Time(_), _) | (_, 1) => 0.0,
            _ => (time - spectrum.time).max(0.0),
        };
        let averaged = time - self.begun;
        keep(running, spectrum);
        self.needed = self.begun + self.plan.needed(spectrum, averaged);
        let motion = self.integrator.motion();
        self.plan.reached(spectrum, motion, averaged)
    }

    /// Number of samples after which the averaging ends, whether or not the goal is reached.
    fn last_sample(&self) -> u64 {
        let longest = match self.plan.goal {
            Goal::Time(time) => time,
            Goal::HalfWidth(_) | Goal::Classification => self.plan.max_time,
        };
        let samples = (self.begun.min(longest) + longest) / self.plan.sample_interval;
        samples.round().max(1.0) as u64
    }

    /// Adds the trace at the last sample to the mean of this number of samples.
    fn add_trace(&mut self, count: u64) {
        let (time, sys) = (self.time(), self.integrator.system());
        if let (Some(jacobian), Some(law)) = (&mut self.jacobian, sys.differentiable()) {
            let status = Some(self.integrator.status()).filter(|status| !status.is_empty());
            let diagonal = jacobian.at(law, status, time, &self.z).iter();
            let trace: f64 = diagonal.step_by(sys.tangent_dim() + 1).sum();
            self.trace += (trace - self.trace) / count as f64;
        }
    }
}

/// Request for the Lyapunov exponents of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LyapunovRequest {
    /// Number of largest exponents, at least 1; `None` for all.
    pub count: Option<usize>,
    /// Settling time of the tangent vectors, s; `None` for [`SETTLE_PERIODS`].
    pub settle: Option<f64>,
    /// Goal that ends the averaging.
    pub goal: Goal,
    /// Relative error tolerance of a time step during settling and averaging. `None` for the scene's
    /// tolerance; with all exponents, at most [`FULL_SPECTRUM_TOLERANCE`].
    pub tolerance: Option<f64>,
}

/// Default settling time of the tangent vectors, periods of the slowest mode.
pub const SETTLE_PERIODS: f64 = 100.0;
/// Minimum averaging time for a goal other than time, periods of the slowest mode.
pub const MIN_PERIODS: f64 = MIN_PERIODS_FOR_ZERO;
/// Maximum averaging time for a classification, periods of the slowest mode.
pub const MAX_PERIODS: f64 = 5000.0;
/// Maximum averaging time for a target half-width, s.
pub const MAX_TIME: f64 = 100.0;

/// Largest relative tolerance of a time step with all exponents. A node that nearly sticks contracts the
/// fastest direction of a joint by a factor `e` in 5 us on average, and at times much faster, which the error
/// of the state does not show. The sum of all exponents deviates from the mean trace by 12 % at the scenes'
/// tolerance of 1e-5, by 1.5 % at 1e-6, and by 0.04 % at 5e-8, which takes 2.3 times as long as 1e-5. A limit
/// on the step size instead takes 3.3 times as long for 0.2 %.
pub const FULL_SPECTRUM_TOLERANCE: f64 = 5e-8;

/// Computes the Lyapunov exponents of a scene.
///
/// First the scene runs to its end, including its transient and its schedules, at its own tolerance. Then
/// tilt, load and rotation are fixed at their final values, and the growth of tangent vectors is averaged
/// from the final state at [`LyapunovRequest::tolerance`].
///
/// A scene with an increasing tilt therefore gives the exponents of the motion continued up to the final
/// tilt, which may differ from the motion that a kick at that tilt leads to. A study stopped during the run
/// has no exponents.
///
/// # Errors
/// If the scene's system cannot be built, if more exponents are requested than exist, or if the integration
/// fails.
pub fn scene_lyapunov(
    scene: &Scene,
    request: &LyapunovRequest,
    progress: OnProgress<'_>,
) -> Result<LyapunovResult, PipelineError> {
    // The scene's own analyses are not needed.
    let mut run = Simulation::new(&scene.clone().without_analyses())?;
    let width = request.count.unwrap_or(run.system().tangent_dim());
    // Checked now, so that too many exponents fail before the transient.
    let all = width == run.system().tangent_dim();
    let with_tangents = |integrator: Integrator<'static>| {
        let own = integrator.tolerance().unwrap_or(scene.integrator.tolerance);
        let largest = if all {
            FULL_SPECTRUM_TOLERANCE
        } else {
            f64::INFINITY
        };
        let tolerance = request.tolerance.unwrap_or(own.min(largest));
        integrator
            .with_tolerance(tolerance)?
            .with_tangents(width, scene.start.seed)
    };
    with_tangents(run.integrator().clone())?;

    let slowest = run.system().omega().iter().copied();
    let omega_1 = slowest.fold(f64::INFINITY, f64::min);
    let period = TAU / omega_1;
    let [min_time, max_time] = match request.goal {
        Goal::Time(time) => [time; 2],
        Goal::HalfWidth(_) => [MIN_PERIODS * period, MAX_TIME],
        Goal::Classification => [MIN_PERIODS, MAX_PERIODS].map(|periods| periods * period),
    };
    let mut plan = LyapunovPlan {
        settle: request.settle.unwrap_or(SETTLE_PERIODS * period),
        goal: request.goal,
        min_time,
        max_time,
        // Only the mean trace, which needs all exponents, needs every sample.
        sample_interval: if all { 1.0 } else { 64.0 } / scene.sample_rate,
        constant_since: 0.0,
    };

    // Approximate cost of the tangent vectors relative to the state.
    let relative_cost = 1.0 + width as f64 / 3.0;
    let before = scene.duration / (scene.duration + relative_cost * (plan.settle + min_time));
    let mut stopped = false;
    while !stopped && run.next_frame()?.is_some() {
        let share = before * (run.time() / scene.duration).min(1.0);
        stopped = progress(share, "running the scene").is_err();
    }
    let transient = run.time();
    run.advance_loading(None)?;
    let loading = run.loading();
    let fixed_at = match (scene.joint(), loading) {
        (Ok(joint), Some(loading)) => joint.fixed_at(loading),
        _ => FixedAt::default(),
    };
    let integrator = run.into_integrator();
    let (time, state) = (integrator.time(), integrator.state().to_vec());
    let mut integrator = with_tangents(integrator)?;
    integrator.start(time, &state)?;
    if fixed_at != FixedAt::default() {
        plan.constant_since = transient;
    }
    let study = lyapunov(&mut integrator, &plan, &mut |share, task| {
        progress(before + (1.0 - before) * share, task)
    })?;
    Ok(LyapunovResult {
        study,
        tilt_rad: loading.map(|loading| loading.tilt),
        fixed_at,
        transient_s: transient,
        tolerance: integrator.tolerance(),
        omega_1_rad_per_s: omega_1,
    })
}
