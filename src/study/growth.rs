//! How cost grows: with contact nodes, modes, exponents, states of a recurrence plot, threads, and the
//! length of a run; in time, and in memory.
//!
//! Accuracy is left aside: what it costs is told by [`cost`](super::cost).

#[cfg(test)]
mod tests;

use std::time::Instant;

use serde::Serialize;

use super::Watch;
use super::cost::{
    CostError, DIMENSION, SAMPLES_A_LAG, displacement, recurrence_rule, samples_for, timed,
};
use super::pool::NoThread;
use super::response::{From, ResponsePlan, response};
use super::sweep::{Audience, Axis, Shard, Start, SweepPlan, SweepPoint, SweepProgress, sweep};
use crate::analysis::{DelayVectors, deviation, quantify};
use crate::joint::{BallJoint, Frequencies};
use crate::pipeline::{Prepared, prepare_on};
use crate::scene::{Parameter, Scene};

/// What grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Size {
    /// Contact nodes.
    Nodes,
    /// Modes of the body.
    Modes,
    /// Lyapunov exponents that are followed.
    Exponents,
    /// States of a recurrence plot.
    Recurrence,
    /// Threads of a sweep.
    Threads,
    /// Simulated time of a run, s.
    Duration,
}

impl Size {
    /// All of them.
    pub const ALL: [Self; 6] = [
        // First, while the program holds nothing else.
        Self::Recurrence,
        Self::Nodes,
        Self::Modes,
        Self::Exponents,
        Self::Threads,
        Self::Duration,
    ];

    /// Its name, with its unit.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Work {
    /// One call of the right-hand side.
    Call,
    /// A millisecond of the settled vibration, by the scene's integrator.
    Vibration,
    /// The quantification of a recurrence plot.
    Quantification,
    /// A sweep of [`SWEPT`] points, by the clock.
    Sweep,
    /// A whole run with its analyses and its recording, by the clock.
    Run,
}

impl Work {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Call => "a call of the right-hand side",
            Self::Vibration => "1 ms of the settled vibration",
            Self::Quantification => "the quantification",
            Self::Sweep => "a sweep, by the clock",
            Self::Run => "a run with analyses and recording, by the clock",
        }
    }
}

/// One work at rising sizes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// What grows.
    pub size: Size,
    /// What is timed.
    pub work: Work,
    /// The points.
    pub points: Vec<GrowthPoint>,
}

/// One size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GrowthPoint {
    /// The size, in the unit of [`Size::name`].
    pub value: f64,
    /// CPU time of all threads (of a sweep: time by the clock), s: the median of the repeated runs.
    pub seconds: f64,
    /// The most memory that the program held meanwhile, bytes; `None` where the system does not tell, and
    /// for sizes with which it hardly grows.
    pub memory: Option<u64>,
}

impl Growth {
    /// The exponent `p` of `seconds ~ size^p` over the upper half of the points; `None` for fewer than two.
    pub fn exponent(&self) -> Option<f64> {
        let half = self.points.len().saturating_sub(1) / 2;
        let [a, .., b] = &self.points[half..] else {
            return None;
        };
        Some((b.seconds / a.seconds).ln() / (b.value / a.value).ln())
    }
}

/// What is measured, and at which sizes. Sizes that a scene does not have are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowthPlan {
    /// The scene, held at its first tilt, load and rotation.
    pub scene: Scene,
    /// Runs of each size, 1 or more.
    pub repeats: usize,
    /// Contact nodes.
    pub nodes: Vec<usize>,
    /// Bending pairs, torsion modes, axial modes: of finite elements, as the paper has few.
    pub modes: Vec<[usize; 3]>,
    /// Exponents.
    pub exponents: Vec<usize>,
    /// States of a recurrence plot.
    pub states: Vec<usize>,
    /// Threads of a sweep.
    pub threads: Vec<usize>,
    /// Simulated times of a run, s.
    pub durations: Vec<f64>,
}

impl GrowthPlan {
    /// The usual sizes, with threads up to so many.
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

/// Runs a scene for so long (s) with its analyses and its recording: best in a process of its own, which
/// holds nothing else. Asks now and then whether to go on; `None` if it was told to stop.
pub type Run<'a> =
    &'a mut dyn FnMut(&Scene, f64, &mut dyn FnMut() -> bool) -> Result<Option<Taken>, Cause>;

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// Time by the clock, s.
    pub seconds: f64,
    /// The most memory that it held, bytes; `None` where the system does not tell.
    pub memory: Option<u64>,
}

/// Why a run failed.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// What was measured, and whether that is all.
pub type Grown = (Vec<Growth>, bool);

/// Points of the sweep that is timed.
pub const SWEPT: usize = 8;

/// Calls of the right-hand side that are timed together: for so many nodes times modes.
const CALLS: usize = 20_000_000;

/// Vibration that is timed, s: at many modes or nodes, and with exponents.
const TIMED: f64 = 4e-3;

/// Measures how the work of a scene grows. If `watch` says no, what is done by then; whether all is.
///
/// # Errors
/// If something of a size cannot be set up or run.
pub fn growth(
    plan: &GrowthPlan,
    run: Run<'_>,
    watch: Watch<'_, (Size, f64)>,
) -> Result<Grown, CostError> {
    let held = plan.scene.clone().without_analyses();
    let has_joint = held.joint().is_ok();
    // Modes and nodes from a file are as many as they are.
    let has_beam = held.ball_on_beam().is_ok();
    let mut meter = Meter {
        repeats: plan.repeats,
        ball: None,
    };
    let mut found = Vec::new();
    for (done, size) in Size::ALL.into_iter().enumerate() {
        let mut goes_on = |part: f64| watch((size, (done as f64 + part) / Size::ALL.len() as f64));
        if !goes_on(0.0) {
            return Ok((found, false));
        }
        let grown = match size {
            Size::Threads if !has_joint => Some(Vec::new()),
            Size::Nodes | Size::Modes if !has_beam => Some(Vec::new()),
            Size::Nodes => {
                let with = |nodes: &usize| {
                    let mut scene = held.clone();
                    scene.joint_mut()?.spec.contact.nodes = *nodes;
                    Ok(scene)
                };
                meter.system(size, &plan.nodes, with, &mut goes_on)?
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
                meter.system(size, &plan.modes, with, &mut goes_on)?
            }
            Size::Exponents => meter.exponents(&held, &plan.exponents, &mut goes_on)?,
            Size::Recurrence => meter.recurrence(&held, &plan.states, &mut goes_on)?,
            Size::Threads => meter.threads(&held, &plan.threads, &mut goes_on)?,
            Size::Duration => runs(&plan.scene, &plan.durations, run, &mut goes_on)?,
        };
        let Some(grown) = grown else {
            return Ok((found, false));
        };
        found.extend(grown.into_iter().filter(|growth| !growth.points.is_empty()));
    }
    Ok((found, true))
}

/// Measures.
struct Meter {
    repeats: usize,
    /// The joint before, whose body may serve again.
    ball: Option<BallJoint>,
}

impl Meter {
    /// The CPU time of some work, as a point. `None` if it was told to stop.
    fn point<T>(
        &self,
        value: f64,
        share: f64,
        goes_on: &mut dyn FnMut() -> bool,
        mut work: impl FnMut() -> T,
    ) -> Option<(GrowthPoint, T)> {
        let mut goes = true;
        let (result, seconds) = timed(self.repeats, || {
            goes = goes && goes_on();
            goes.then(&mut work)
        });
        let point = GrowthPoint {
            value,
            seconds: seconds * share,
            memory: None,
        };
        Some((point, result?))
    }

    /// A scene made ready in the state that it settles to.
    fn settled(
        &mut self,
        scene: &Scene,
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Result<Option<Prepared>, CostError> {
        let look = ResponsePlan {
            exponents: 0,
            portrait: false,
            most: 0.1,
            measure: 0.01,
            ..ResponsePlan::default()
        };
        let on = &mut |_| goes_on();
        let Some(settled) = response(scene, From::Cold, &look, &mut self.ball, on)? else {
            return Ok(None);
        };
        let prepared = prepare_on(scene, &mut self.ball)?;
        Ok(Some(prepared.starting_from(&settled.state)))
    }

    /// Sizes of the system itself: what a call costs, and a millisecond.
    fn system<T>(
        &mut self,
        size: Size,
        settings: &[T],
        with: impl Fn(&T) -> Result<Scene, CostError>,
        goes_on: Watch<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let [mut call, mut vibration] = [Work::Call, Work::Vibration].map(|work| Growth {
            size,
            work,
            points: Vec::new(),
        });
        for (k, setting) in settings.iter().enumerate() {
            let mut on = || goes_on(k as f64 / settings.len() as f64);
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
                integrator.land(&*system, TIMED)
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
        goes_on: Watch<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let mut points = Vec::new();
        for (k, &count) in counts.iter().enumerate() {
            let mut on = || goes_on(k as f64 / counts.len() as f64);
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
                integrator.land(system, TIMED)
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
        goes_on: Watch<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let longest = states.iter().copied().max().unwrap_or(0);
        let Some(prepared) = self.settled(scene, &mut || goes_on(0.0))? else {
            return Ok(None);
        };
        let on = &mut |share| goes_on(0.3 * share);
        let Some(samples) = displacement(scene, prepared, samples_for(longest), on)? else {
            return Ok(None);
        };
        let rule = recurrence_rule(0.5 * deviation(&samples));
        let mut points = Vec::new();
        for (k, &size) in states.iter().enumerate() {
            let mut on = || goes_on(0.3 + 0.7 * k as f64 / states.len() as f64);
            let vectors =
                DelayVectors::new(&samples[..samples_for(size)], SAMPLES_A_LAG, DIMENSION)?;
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

    /// A sweep over the tilt on so many threads, by the clock. Each point is short: what is measured is
    /// how they share the machine.
    fn threads(
        &mut self,
        scene: &Scene,
        counts: &[usize],
        goes_on: Watch<'_, f64>,
    ) -> Result<Option<Vec<Growth>>, CostError> {
        let look = ResponsePlan {
            least: 0.0,
            most: 0.02,
            measure: 0.02,
            exponents: 1,
            portrait: false,
            most_calls: None,
        };
        let tilts = (0..SWEPT).map(|k| 1.0 + 0.5 * k as f64);
        let plan = SweepPlan {
            scene: scene.clone(),
            axes: vec![Axis::new(Parameter::tilt(), tilts)],
            starts: vec![Start::Cold],
            response: look,
        };
        let mut points = Vec::new();
        for (k, &threads) in counts.iter().enumerate() {
            let mut times = Vec::new();
            for _ in 0..self.repeats {
                let mut on = || goes_on(k as f64 / counts.len() as f64);
                let began = Instant::now();
                let all = sweep(&plan, Shard::WHOLE, &[], threads, &mut Nobody(&mut on))?;
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

/// Whole runs; each once, as they are long.
fn runs(
    scene: &Scene,
    durations: &[f64],
    run: Run<'_>,
    goes_on: Watch<'_, f64>,
) -> Result<Option<Vec<Growth>>, CostError> {
    let mut points = Vec::new();
    for (k, &duration) in durations.iter().enumerate() {
        let mut on = || goes_on(k as f64 / durations.len() as f64);
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

/// Does not listen, but may stop.
struct Nobody<'a>(&'a mut dyn FnMut() -> bool);

impl Audience for Nobody<'_> {
    type Error = NoThread;

    fn point(&mut self, _: SweepPoint) -> Result<(), NoThread> {
        Ok(())
    }

    fn progress(&mut self, _: SweepProgress) -> bool {
        (self.0)()
    }
}

/// The most memory that this program has held since it began, or since it was told to forget that, bytes;
/// `None` where the system does not tell (Linux does).
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024 * kilobytes)
}

/// Starts anew from what is held now; where that cannot be done, the peak since the start counts.
fn forget_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}
