//! Growth of the cost with problem size: CPU time and peak memory against contact nodes, modes, exponents,
//! states of a recurrence plot, threads, and the length of a run.
//!
//! Accuracy is constant here; its cost is the subject of [`cost`](super::cost).

#[cfg(test)]
mod tests;

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::OnProgress;
use super::cost::{
    CostError, DIMENSION, SAMPLES_PER_LAG, displacement, recurrence_rule, samples_for, timed,
};
use super::pool::ThreadSpawnError;
use super::response::{InitialState, ResponsePlan, response};
use super::sweep::{
    Axis, Shard, Start, SweepObserver, SweepPlan, SweepPoint, SweepProgress, sweep,
};
use crate::analysis::{DelayVectors, deviation, quantify};
use crate::joint::{BallJoint, Frequencies};
use crate::pipeline::{Prepared, prepare_reusing_body};
use crate::scene::{Parameter, Scene};

/// The problem size that is varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Size {
    /// Number of contact nodes.
    Nodes,
    /// Number of modes of the body.
    Modes,
    /// Number of Lyapunov exponents computed.
    Exponents,
    /// Number of states of a recurrence plot.
    Recurrence,
    /// Number of threads of a sweep.
    Threads,
    /// Simulated time of a run, s.
    Duration,
}

impl Size {
    /// All sizes.
    pub const ALL: [Self; 6] = [
        // First, while the process holds little memory.
        Self::Recurrence,
        Self::Nodes,
        Self::Modes,
        Self::Exponents,
        Self::Threads,
        Self::Duration,
    ];

    /// Name of the size, with its unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nodes => "contact nodes",
            Self::Modes => "modes",
            Self::Exponents => "Lyapunov exponents",
            Self::Recurrence => "states of a recurrence plot",
            Self::Threads => "threads",
            Self::Duration => "simulated time, s",
        }
    }
}

/// The work that is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Work {
    /// One evaluation of the right-hand side.
    RhsEvaluation,
    /// Integration of 1 ms of the settled vibration with the scene's integrator.
    Vibration,
    /// Quantification of a recurrence plot.
    Quantification,
    /// A sweep of [`SWEPT`] points; wall-clock time.
    Sweep,
    /// A complete run with its analyses and its recording; wall-clock time.
    Run,
}

impl Work {
    /// Name of the work, for tables and figures.
    pub fn name(self) -> &'static str {
        match self {
            Self::RhsEvaluation => "one right-hand-side evaluation",
            Self::Vibration => "1 ms of the settled vibration",
            Self::Quantification => "recurrence quantification",
            Self::Sweep => "a sweep, wall-clock time",
            Self::Run => "a run with analyses and recording, wall-clock time",
        }
    }
}

/// Growth of the cost of one work with one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// The size that is varied.
    pub size: Size,
    /// The work that is timed.
    pub work: Work,
    /// The points in ascending order of size.
    pub points: Vec<GrowthPoint>,
}

/// A point of the growth: the cost at one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrowthPoint {
    /// The size, in the unit of [`Size::name`].
    pub value: f64,
    /// CPU time of all threads (for sweeps and runs: wall-clock time), s; the median of the repeats.
    #[serde(rename = "time_s")]
    pub seconds: f64,
    /// Peak memory of the process, bytes; `None` if the system does not report it, and for sizes on which it
    /// hardly depends.
    #[serde(rename = "peak_memory_bytes")]
    pub memory: Option<u64>,
}

impl Growth {
    /// Exponent `p` of `seconds ~ size^p` over the upper half of the points; `None` for fewer than two
    /// points.
    pub fn exponent(&self) -> Option<f64> {
        let half = self.points.len().saturating_sub(1) / 2;
        let [a, .., b] = &self.points[half..] else {
            return None;
        };
        Some((b.seconds / a.seconds).ln() / (b.value / a.value).ln())
    }
}

/// Plan of a growth study: the sizes to measure. Sizes that a scene does not have are omitted.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowthPlan {
    /// The scene; tilt, load and rotation are fixed at their initial values.
    pub scene: Scene,
    /// Repeats at each size, at least 1.
    pub repeats: usize,
    /// Numbers of contact nodes.
    pub nodes: Vec<usize>,
    /// Numbers of bending pairs, torsion modes and axial modes of the finite-element body.
    pub modes: Vec<[usize; 3]>,
    /// Numbers of Lyapunov exponents.
    pub exponents: Vec<usize>,
    /// Numbers of states of a recurrence plot.
    pub states: Vec<usize>,
    /// Numbers of threads of a sweep.
    pub threads: Vec<usize>,
    /// Simulated times of a run, s.
    pub durations: Vec<f64>,
}

impl GrowthPlan {
    /// The default sizes, with up to `threads` threads.
    pub fn new(scene: Scene, threads: usize) -> Self {
        Self {
            scene,
            repeats: 5,
            nodes: vec![16, 32, 64, 100, 200, 500, 1000, 2000, 5000, 10_000],
            modes: vec![
                [1, 0, 0],
                [2, 1, 0],
                [4, 2, 1],
                [8, 4, 2],
                [16, 8, 8],
                [34, 16, 16],
            ],
            exponents: vec![1, 2, 3, 5, 8, 12, 16, 22],
            states: vec![500, 1000, 2000, 4000, 8000, 16_000, 32_000],
            threads: (1..=threads).collect(),
            durations: vec![0.05, 0.1, 0.2, 0.4, 0.8, 1.6],
        }
    }
}

/// Runs a scene for a simulated time (s) with its analyses and its recording; for the memory figure, best in
/// a separate process. It calls back to ask whether to continue; `None` if stopped.
pub type Run<'a> =
    &'a mut dyn FnMut(&Scene, f64, &mut dyn FnMut() -> bool) -> Result<Option<RunCost>, Cause>;

/// Cost of one run: time and memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunCost {
    /// Wall-clock time, s.
    pub seconds: f64,
    /// Peak memory, bytes; `None` if the system does not report it.
    pub memory: Option<u64>,
}

/// Cause of a failed run.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Result of a growth study: the growths measured, and whether it is complete.
pub type GrowthResult = (Vec<Growth>, bool);

/// Number of points of the timed sweep.
pub const SWEPT: usize = 8;

/// Right-hand-side evaluations timed together, times nodes times modes.
const CALLS: usize = 20_000_000;

/// Length of the timed vibration, s.
const TIMED: f64 = 4e-3;

/// Measures how the cost of a scene grows with each size. If `watch` returns `false`, returns the results so
/// far and `false`.
///
/// # Errors
/// If a scene with one of the sizes cannot be built or run.
pub fn growth(
    plan: &GrowthPlan,
    run: Run<'_>,
    watch: OnProgress<'_, (Size, f64)>,
) -> Result<GrowthResult, CostError> {
    let held = plan.scene.clone().without_analyses();
    let has_joint = held.joint().is_ok();
    // Modes and nodes from a file cannot be varied.
    let has_beam = held.ball_on_beam().is_ok();
    let mut timer = Timer {
        repeats: plan.repeats,
        ball: None,
    };
    let mut found = Vec::new();
    for (done, size) in Size::ALL.into_iter().enumerate() {
        let mut should_continue =
            |part: f64| watch((size, (done as f64 + part) / Size::ALL.len() as f64));
        if !should_continue(0.0) {
            return Ok((found, false));
        }
        let grown = match size {
            Size::Threads if !has_joint => Some(Vec::new()),
            Size::Nodes | Size::Modes if !has_beam => Some(Vec::new()),
            Size::Nodes => {
                let with = |nodes: &usize| {
                    let mut scene = held.clone();
                    let contact = &mut scene.joint_mut()?.spec.contact;
                    contact.nodes = *nodes;
                    Ok(scene)
                };
                timer.system(size, &plan.nodes, with, &mut should_continue)?
            }
            Size::Modes => {
                let with = |[bending, torsion, axial]: &[usize; 3]| {
                    let mut scene = held.clone();
                    let body = scene.ball_on_beam_mut()?;
                    body.frequencies = Frequencies::FiniteElement;
                    body.families.bending_pairs = *bending;
                    body.families.torsion = *torsion;
                    body.families.axial = *axial;
                    Ok(scene)
                };
                timer.system(size, &plan.modes, with, &mut should_continue)?
            }
            Size::Exponents => timer.exponents(&held, &plan.exponents, &mut should_continue)?,
            Size::Recurrence => timer.recurrence(&held, &plan.states, &mut should_continue)?,
            Size::Threads => timer.threads(&held, &plan.threads, &mut should_continue)?,
            Size::Duration => runs(&plan.scene, &plan.durations, run, &mut should_continue)?,
        };
        let Some(grown) = grown else {
            return Ok((found, false));
        };
        found.extend(grown.into_iter().filter(|growth| !growth.points.is_empty()));
    }
    Ok((found, true))
}

/// Measures the points.
struct Timer {
    repeats: usize,
    /// The previous joint, whose body may be reused.
    ball: Option<BallJoint>,
}

impl Timer {
    /// Times some work (CPU time); returns the point, or `None` if stopped.
    fn point<T>(
        &self,
        value: f64,
        share: f64,
        should_continue: &mut dyn FnMut() -> bool,
        mut work: impl FnMut() -> T,
    ) -> Option<(GrowthPoint, T)> {
        let mut goes = true;
        let (result, seconds) = timed(self.repeats, || {
            goes = goes && should_continue();
            goes.then(&mut work)
        });
        let point = GrowthPoint {
            value,
            seconds: seconds * share,
            memory: None,
        };
        Some((point, result?))
    }

    /// A scene prepared in its settled state.
    fn settled(
        &mut self,
        scene: &Scene,
        should_continue: &mut dyn FnMut() -> bool,
    ) -> Result<Option<Prepared>, CostError> {
        let look = ResponsePlan {
            exponents: 0,
            orbits: false,
            portrait: false,
            max_transient: 0.1,
            measurement_time: 0.01,
            ..ResponsePlan::default()
        };
        let on = &mut |_| should_continue();
        let Some(settled) = response(scene, InitialState::Fresh, &look, &mut self.ball, on)? else {
            return Ok(None);
        };
        let prepared = prepare_reusing_body(scene, &mut self.ball)?;
        Ok(Some(prepared.starting_from(&settled.state)))
    }

    /// Times one right-hand-side evaluation and 1 ms of vibration for each setting of the system.
    fn system<T>(
        &mut self,
        size: Size,
        settings: &[T],
        with: impl Fn(&T) -> Result<Scene, CostError>,
        should_continue: OnProgress<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let [mut call, mut vibration] = [Work::RhsEvaluation, Work::Vibration].map(|work| Growth {
            size,
            work,
            points: Vec::new(),
        });
        for (k, setting) in settings.iter().enumerate() {
            let mut on = || should_continue(k as f64 / settings.len() as f64);
            let scene = with(setting)?;
            let Some(prepared) = self.settled(&scene, &mut on)? else {
                return Ok(None);
            };
            let (system, state) = (prepared.system, prepared.state);
            let mut integrator = prepared.integrator;
            let nodes = scene.joint()?.spec.contact.nodes;
            let value = match size {
                Size::Nodes => nodes,
                _ => system.modes(),
            } as f64;
            let calls = (CALLS / (nodes * system.modes())).max(10);
            let mut force = vec![0.0; system.dim() - system.modes()];
            let timed = self.point(value, 1.0 / calls as f64, &mut on, || {
                for _ in 0..calls {
                    system.force(0.0, std::hint::black_box(&state), &mut force);
                    std::hint::black_box(&mut force);
                }
            });
            let Some((point, ())) = timed else {
                return Ok(None);
            };
            call.points.push(point);
            let timed = self.point(value, 1e-3 / TIMED, &mut on, || {
                integrator.start(&*system, 0.0, &state)?;
                integrator.integrate_to(&*system, TIMED)
            });
            let Some((point, done)) = timed else {
                return Ok(None);
            };
            done?;
            vibration.points.push(point);
        }
        Ok(Some(vec![call, vibration]))
    }

    fn exponents(
        &mut self,
        scene: &Scene,
        counts: &[usize],
        should_continue: OnProgress<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let mut points = Vec::new();
        for (k, &count) in counts.iter().enumerate() {
            let mut on = || should_continue(k as f64 / counts.len() as f64);
            let Some(prepared) = self.settled(scene, &mut on)? else {
                return Ok(None);
            };
            let (system, state) = (&*prepared.system, &prepared.state);
            if count > system.tangent_dim() {
                break;
            }
            let mut integrator =
                prepared
                    .integrator
                    .with_tangents(system, count, scene.start.seed)?;
            let timed = self.point(count as f64, 1e-3 / TIMED, &mut on, || {
                integrator.start(system, 0.0, state)?;
                integrator.integrate_to(system, TIMED)
            });
            let Some((point, done)) = timed else {
                return Ok(None);
            };
            done?;
            points.push(point);
        }
        Ok(Some(vec![Growth {
            size: Size::Exponents,
            work: Work::Vibration,
            points,
        }]))
    }

    fn recurrence(
        &mut self,
        scene: &Scene,
        states: &[usize],
        should_continue: OnProgress<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let longest = states.iter().copied().max().unwrap_or(0);
        let Some(prepared) = self.settled(scene, &mut || should_continue(0.0))? else {
            return Ok(None);
        };
        let on = &mut |share| should_continue(0.3 * share);
        let Some(samples) = displacement(scene, prepared, samples_for(longest), on)? else {
            return Ok(None);
        };
        let rule = recurrence_rule(0.5 * deviation(&samples));
        let mut points = Vec::new();
        for (k, &size) in states.iter().enumerate() {
            let mut on = || should_continue(0.3 + 0.7 * k as f64 / states.len() as f64);
            let vectors =
                DelayVectors::new(&samples[..samples_for(size)], SAMPLES_PER_LAG, DIMENSION)?;
            forget_peak_memory();
            let timed = self.point(size as f64, 1.0, &mut on, || quantify(&vectors, &rule));
            let Some((mut point, counted)) = timed else {
                return Ok(None);
            };
            counted?;
            point.memory = peak_memory();
            points.push(point);
        }
        Ok(Some(vec![Growth {
            size: Size::Recurrence,
            work: Work::Quantification,
            points,
        }]))
    }

    /// Times a tilt sweep (wall clock) for each number of threads. The points are short, because only the
    /// scaling with threads matters.
    fn threads(
        &mut self,
        scene: &Scene,
        counts: &[usize],
        should_continue: OnProgress<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let look = ResponsePlan {
            min_transient: 0.0,
            max_transient: 0.02,
            measurement_time: 0.02,
            exponents: 1,
            orbits: false,
            portrait: false,
            max_rhs_evals: None,
        };
        let tilts = (0..SWEPT).map(|k| 1.0 + 0.5 * k as f64);
        let plan = SweepPlan {
            scene: scene.clone(),
            axes: vec![Axis::new(Parameter::tilt(), tilts)],
            starts: vec![Start::Fresh],
            response: look,
        };
        let mut points = Vec::new();
        for (k, &threads) in counts.iter().enumerate() {
            let mut times = Vec::new();
            for _ in 0..self.repeats {
                let mut on = || should_continue(k as f64 / counts.len() as f64);
                let began = Instant::now();
                let all = sweep(
                    &plan,
                    Shard::WHOLE,
                    &[],
                    threads,
                    &mut ProgressOnly(&mut on),
                )?;
                times.push(began.elapsed().as_secs_f64());
                if !all {
                    return Ok(None);
                }
            }
            times.sort_by(f64::total_cmp);
            points.push(GrowthPoint {
                value: threads as f64,
                seconds: times[times.len() / 2],
                memory: None,
            });
        }
        Ok(Some(vec![Growth {
            size: Size::Threads,
            work: Work::Sweep,
            points,
        }]))
    }
}

/// Complete runs, once per duration because they are long.
fn runs(
    scene: &Scene,
    durations: &[f64],
    run: Run<'_>,
    should_continue: OnProgress<'_, f64>,
) -> Result<Option<Vec<Growth>>, CostError> {
    let mut points = Vec::new();
    for (k, &duration) in durations.iter().enumerate() {
        let mut on = || should_continue(k as f64 / durations.len() as f64);
        let Some(taken) = run(scene, duration, &mut on).map_err(CostError::Run)? else {
            return Ok(None);
        };
        points.push(GrowthPoint {
            value: duration,
            seconds: taken.seconds,
            memory: taken.memory,
        });
    }
    Ok(Some(vec![Growth {
        size: Size::Duration,
        work: Work::Run,
        points,
    }]))
}

/// An observer that ignores the points but may stop the sweep.
struct ProgressOnly<'a>(&'a mut dyn FnMut() -> bool);

impl SweepObserver for ProgressOnly<'_> {
    type Error = ThreadSpawnError;

    fn on_point(&mut self, _: SweepPoint) -> Result<(), ThreadSpawnError> {
        Ok(())
    }

    fn on_progress(&mut self, _: SweepProgress) -> bool {
        (self.0)()
    }
}

/// Peak memory of this process since its start or the last reset, bytes. `None` if the system does not report
/// it (Linux does).
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024 * kilobytes)
}

/// Resets the peak memory. Where that is impossible, the peak since the start of the process counts.
fn forget_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
