//! Lyapunov exponents of a motion, with their errors: how long to average, and what it came to.

mod scene;
mod trace;

#[cfg(test)]
mod tests;

use std::time::Instant;

use serde::Serialize;

use crate::dynamics::{
    Attractor, DynamicsError, Exponent, Integrator, LyapunovSpectrum, Motion, Sign, System, Tally,
};

use super::Watch;
use super::pool::Heed;
pub use scene::{
    LEAST_PERIODS, LONGEST, LyapunovRequest, MOST_PERIODS, RESOLVING, SETTLE_PERIODS,
    SceneLyapunov, scene_lyapunov,
};
use trace::MeanTrace;

/// How many exponents are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// All that there are.
    All,
    /// The largest ones, 1 or more.
    Largest(usize),
}

impl Count {
    /// The number of tangent vectors for a system.
    pub fn width<Y: System + ?Sized>(self, sys: &Y) -> usize {
        match self {
            Self::All => sys.tangent_dim(),
            Self::Largest(count) => count,
        }
    }
}

/// When enough has been averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// After so much time, s.
    Time(f64),
    /// Once each exponent is known to so much on either side, 1/s; an exponent that is minus
    /// infinity is known.
    HalfWidth(f64),
    /// Once it can be told what the motion comes to, or at least the sign of each exponent followed.
    Verdict,
}

/// How to average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LyapunovPlan {
    /// Time in which the tangent vectors turn to their own directions before growth counts, s.
    pub settle: f64,
    /// When to end.
    pub goal: Goal,
    /// The least time averaged before a goal other than time counts as reached, s: in a short time
    /// every exponent is near enough to zero.
    pub least: f64,
    /// The longest time averaged, s, whether the goal is reached or not.
    pub most: f64,
    /// Time between looks at the state, s, by which the mean trace is sampled.
    pub look: f64,
}

/// How averaging ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The goal was reached.
    Reached,
    /// The longest time was over before that.
    OutOfTime,
    /// The caller stopped it.
    Stopped,
}

/// The exponents as known after some time of averaging.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunningExponents {
    /// Time averaged so far, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// The exponents so far.
    #[serde(rename = "exponents_per_s")]
    pub exponents: Vec<Exponent>,
}

/// What averaging came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LyapunovStudy {
    /// The exponents; none where it was stopped before any growth was averaged.
    #[serde(flatten)]
    pub spectrum: LyapunovSpectrum,
    /// What is known of the motion beside them.
    pub motion: Motion,
    /// The exponents along the way, at times that grow by a few per cent; the last ones are those of
    /// the spectrum.
    pub running: Vec<RunningExponents>,
    /// Mean of the trace of `dF/dz` along the motion, 1/s, to which all exponents add up; `None`
    /// where not all are followed or where events make the state or the law jump.
    #[serde(rename = "mean_trace_per_s")]
    pub mean_trace: Option<f64>,
    /// How it ended.
    #[serde(skip)]
    pub ending: Ending,
    /// Time in which the vectors settled, s.
    #[serde(rename = "settle_s")]
    pub settled: f64,
    /// Work done, settling included.
    #[serde(flatten)]
    pub tally: Tally,
    /// Time followed, settling included, s.
    #[serde(rename = "followed_s")]
    pub followed: f64,
    /// Time that took, s.
    #[serde(rename = "wall_s")]
    pub busy_seconds: f64,
}

impl LyapunovStudy {
    /// What a study came to that was stopped before it began.
    pub(crate) fn stopped(dimension: usize) -> Self {
        let spectrum = LyapunovSpectrum {
            dimension,
            resolution: f64::INFINITY,
            ..LyapunovSpectrum::default()
        };
        Self {
            spectrum,
            motion: Motion::default(),
            running: Vec::new(),
            mean_trace: None,
            ending: Ending::Stopped,
            settled: 0.0,
            tally: Tally::default(),
            followed: 0.0,
            busy_seconds: 0.0,
        }
    }

    /// What the motion comes to; undecided where there are no exponents.
    pub fn attractor(&self) -> Attractor {
        if self.spectrum.exponents.is_empty() {
            return Attractor::Undecided;
        }
        self.spectrum.attractor_of(self.motion)
    }

    /// How far the sum of all exponents is off the mean trace, over the sum of their sizes: how well
    /// the steps resolve the contractions. `None` where there is no sum or no trace.
    pub fn imbalance(&self) -> Option<f64> {
        let (sum, trace) = self.sum().zip(self.mean_trace)?;
        let sizes = self.spectrum.exponents.iter().map(|e| e.value.abs());
        // The trace of conservative motion is zero, and is no measure.
        let size = sizes.sum::<f64>().max(trace.abs());
        (size > 0.0).then(|| (sum - trace).abs() / size)
    }

    /// By how much, as a natural logarithm, the last direction followed shrinks in a mean step; zero
    /// where it does not shrink, or collapses.
    pub fn contraction_per_step(&self) -> f64 {
        let last = self.spectrum.exponents.last().map_or(0.0, |e| e.value);
        let step = self.followed / self.tally.steps.max(1) as f64;
        if last.is_finite() {
            (-last).max(0.0) * step
        } else {
            0.0
        }
    }

    /// Numbers, from 0, of exponents that stand below the next one by more than the two intervals: the
    /// vectors have not settled, since settled ones have falling rates. Drifts that leave the order as
    /// it is widen the intervals.
    pub fn unsettled(&self) -> Vec<usize> {
        let pairs = self.spectrum.exponents.windows(2).enumerate();
        let swapped = pairs.filter(|(_, pair)| pair[0].high() < pair[1].low());
        swapped.map(|(k, _)| k).collect()
    }

    /// The sum of all exponents, 1/s; `None` where not all are followed.
    pub fn sum(&self) -> Option<f64> {
        let exponents = &self.spectrum.exponents;
        let all = !exponents.is_empty() && exponents.len() == self.spectrum.dimension;
        all.then(|| exponents.iter().map(|exponent| exponent.value).sum())
    }
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The motion runs by itself, until its transient is over.
    Transient,
    /// The tangent vectors turn to their own directions.
    Settling,
    /// Their growth is averaged.
    Averaging,
}

/// How far it is, for a caller who waits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LyapunovProgress {
    /// What is being done.
    pub phase: Phase,
    /// Share of the work done, 0 to 1, by what is known now.
    pub share: f64,
    /// The largest exponent so far; `None` before any growth was averaged.
    pub largest: Option<Exponent>,
}

/// Times at which the running values are kept grow by this factor.
const SPACING: f64 = 1.03;
/// The first of them, in looks.
const FIRST: f64 = 16.0;

/// Follows the tangent vectors of an integrator that has been started
/// ([`Integrator::with_tangents`]), lets them settle, and averages their growth until the goal is
/// reached. `watch` is told how far it is every 50 ms and answers whether to go on.
///
/// # Errors
/// [`DynamicsError::Lacks`] for an integrator without tangent vectors; else when the integration
/// cannot go on.
pub fn lyapunov<Y: System + ?Sized>(
    sys: &Y,
    integrator: &mut Integrator,
    plan: &LyapunovPlan,
    watch: Watch<'_, LyapunovProgress>,
) -> Result<LyapunovStudy, DynamicsError> {
    let began = Instant::now();
    let width = integrator.exponents().map_or(0, |s| s.exponents.len());
    if width == 0 {
        return Err(DynamicsError::Lacks {
            what: "tangent vectors",
            wish: "exponents",
        });
    }
    let (start, before) = (integrator.time(), integrator.tally());
    let mut walk = Walk {
        sys,
        integrator,
        plan,
        start,
        looks: 0,
        z: vec![0.0; sys.dim()],
        watch,
        heed: Heed::default(),
        largest: None,
        needed: plan.expected(),
        running: Vec::new(),
        trace: MeanTrace::new(sys, width),
    };
    let goes_on = walk.settle()?;
    let settled = walk.time() - start;
    let ending = match goes_on {
        true => walk.average()?,
        false => Ending::Stopped,
    };
    let followed = walk.time() - start;
    let Walk {
        mut running, trace, ..
    } = walk;
    let mut spectrum = integrator.exponents().unwrap_or_default();
    if spectrum.time == 0.0 {
        spectrum.exponents.clear();
        spectrum.resolution = f64::INFINITY;
    }
    keep(&mut running, &spectrum);
    let mean_trace = trace.and_then(|trace| trace.mean());
    Ok(LyapunovStudy {
        mean_trace: mean_trace.filter(|_| !spectrum.exponents.is_empty()),
        motion: integrator.motion(sys),
        spectrum,
        running,
        ending,
        settled,
        tally: since(integrator.tally(), before),
        followed,
        busy_seconds: began.elapsed().as_secs_f64(),
    })
}

impl LyapunovPlan {
    /// The longest time of averaging, s.
    fn longest(&self) -> f64 {
        match self.goal {
            Goal::Time(time) => time,
            Goal::HalfWidth(_) | Goal::Verdict => self.most,
        }
    }

    /// The time that averaging will take if nothing is known yet, s.
    fn expected(&self) -> f64 {
        match self.goal {
            Goal::Time(time) => time,
            Goal::HalfWidth(_) | Goal::Verdict => self.least.min(self.most),
        }
    }

    /// Whether the goal is reached after a time of averaging, s.
    fn reached(&self, spectrum: &LyapunovSpectrum, motion: Motion, time: f64) -> bool {
        match self.goal {
            // That one is counted in looks.
            Goal::Time(_) => false,
            Goal::HalfWidth(wanted) => time >= self.least && widest(spectrum) <= wanted,
            Goal::Verdict => time >= self.least && is_clear(spectrum, motion),
        }
    }

    /// The time that the goal will probably need in all, s: half widths shrink with its square root.
    fn needed(&self, spectrum: &LyapunovSpectrum, time: f64) -> f64 {
        let guess = match self.goal {
            Goal::Time(all) => all,
            Goal::HalfWidth(wanted) => time * (widest(spectrum) / wanted).powi(2),
            Goal::Verdict if time < self.least => self.least,
            Goal::Verdict => 1.2 * time,
        };
        guess.max(self.least).min(self.longest())
    }
}

/// Whether more time would tell no more: it is decided what the motion comes to, or all signs are
/// known but too few exponents are followed.
fn is_clear(spectrum: &LyapunovSpectrum, motion: Motion) -> bool {
    spectrum.attractor_of(motion).is_decided() || spectrum.count(Sign::Doubtful) == 0
}

/// Keeps the exponents so far, unless those of the same time are kept already: growth is known from
/// step to step, and a look may lie within the step of the one before.
fn keep(running: &mut Vec<RunningExponents>, spectrum: &LyapunovSpectrum) {
    let newer = running.last().is_none_or(|last| last.time < spectrum.time);
    if newer && spectrum.time > 0.0 {
        running.push(RunningExponents {
            time: spectrum.time,
            exponents: spectrum.exponents.clone(),
        });
    }
}

/// The largest half width of exponents that are numbers, 1/s.
fn widest(spectrum: &LyapunovSpectrum) -> f64 {
    let finite = spectrum.exponents.iter().filter(|e| e.value.is_finite());
    finite.fold(0.0, |most, e| most.max(e.half_width))
}

/// The system on its way.
struct Walk<'a, Y: System + ?Sized> {
    sys: &'a Y,
    integrator: &'a mut Integrator,
    plan: &'a LyapunovPlan,
    start: f64,
    looks: u64,
    /// State at the last look.
    z: Vec<f64>,
    watch: Watch<'a, LyapunovProgress>,
    heed: Heed,
    /// The largest exponent so far.
    largest: Option<Exponent>,
    /// The time that averaging will probably take, s.
    needed: f64,
    running: Vec<RunningExponents>,
    trace: Option<MeanTrace>,
}

impl<Y: System + ?Sized> Walk<'_, Y> {
    /// On to the next look.
    fn on(&mut self) -> Result<(), DynamicsError> {
        self.looks += 1;
        let time = self.time();
        self.integrator.sample(self.sys, time, &mut self.z)
    }

    /// Time of the last look, s.
    fn time(&self) -> f64 {
        self.start + self.looks as f64 * self.plan.look
    }

    fn goes_on(&mut self, phase: Phase, share: f64) -> bool {
        (self.watch)(LyapunovProgress {
            phase,
            share,
            largest: self.largest,
        })
    }

    /// Lets the tangent vectors find their directions. Whether to go on.
    fn settle(&mut self) -> Result<bool, DynamicsError> {
        let plan = self.plan;
        let mut goes_on = true;
        for look in 0..(plan.settle / plan.look).ceil() as u64 {
            self.on()?;
            let share = (look + 1) as f64 * plan.look / (plan.settle + self.needed);
            goes_on = !self.heed.is_due() || self.goes_on(Phase::Settling, share);
            if !goes_on {
                break;
            }
        }
        self.integrator.forget_growth();
        Ok(goes_on)
    }

    /// Averages their growth until the goal is reached.
    fn average(&mut self) -> Result<Ending, DynamicsError> {
        let plan = self.plan;
        let last = (plan.longest() / plan.look).round().max(1.0) as u64;
        let (mut look, mut kept) = (0, FIRST);
        loop {
            self.on()?;
            look += 1;
            let now = self.time();
            if let Some(trace) = &mut self.trace {
                trace.add(self.sys, self.integrator.status(), now, &self.z);
            }
            let time = look as f64 * plan.look;
            let mut ending = None;
            if look as f64 >= kept || look == last {
                kept *= SPACING;
                if self.reached(time) {
                    ending = Some(Ending::Reached);
                }
            }
            if look == last && ending.is_none() {
                ending = Some(match plan.goal {
                    Goal::Time(_) => Ending::Reached,
                    Goal::HalfWidth(_) | Goal::Verdict => Ending::OutOfTime,
                });
            }
            let share = (plan.settle + time) / (plan.settle + self.needed.max(time));
            let is_due = ending.is_some() || self.heed.is_due();
            if is_due && !self.goes_on(Phase::Averaging, share) {
                ending = ending.or(Some(Ending::Stopped));
            }
            if let Some(ending) = ending {
                return Ok(ending);
            }
        }
    }

    /// Keeps the exponents so far; whether they reach the goal after a time of averaging, s.
    fn reached(&mut self, time: f64) -> bool {
        let found = self.integrator.exponents();
        let Some(spectrum) = found.filter(|spectrum| spectrum.time > 0.0) else {
            return false;
        };
        self.largest = spectrum.exponents.first().copied();
        keep(&mut self.running, &spectrum);
        self.needed = self.plan.needed(&spectrum, time);
        let motion = self.integrator.motion(self.sys);
        self.plan.reached(&spectrum, motion, time)
    }
}

/// The work done between two readings of the counters.
fn since(now: Tally, before: Tally) -> Tally {
    Tally {
        steps: now.steps - before.steps,
        rejections: now.rejections - before.rejections,
        calls: now.calls - before.calls,
        jacobians: now.jacobians - before.jacobians,
        switches: now.switches - before.switches,
        crossings: now.crossings - before.crossings,
        events: now.events - before.events,
        grazings: now.grazings - before.grazings,
        overrun: now.overrun - before.overrun,
    }
}
