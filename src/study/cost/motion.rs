//! The settled motion of a scene with other settings, and the time that it takes.

use cpu_time::ProcessTime;
use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::regime::Regime;
use crate::dynamics::Exponent;
use crate::pipeline::prepare;
use crate::scene::Scene;
use crate::study::response::{ResponsePlan, SettledResponse, response};
use crate::study::{OnProgress, Stopped, StudyError, Trial};

/// Settling time of each run and its measurement, periods of the slowest mode.
const SETTLING: f64 = 50.0;
const MEASUREMENT: f64 = 60.0;

/// Longest transient of the first run, from the kick of the scene, s.
const MAX_TRANSIENT: f64 = 1.0;

/// Simulated time of a timed run, in measurements.
const TIMED: f64 = 0.25;

/// Number of timed runs. The shortest counts: other processes only lengthen a run.
pub const REPEATS: usize = 5;

/// Maximum number of right-hand-side evaluations of a run.
const MAX_RHS_EVALS: u64 = 20_000_000;

/// A settled motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Motion {
    /// Regime: the type of motion.
    pub regime: Regime,
    /// Frequency of the strongest line of the displacement, Hz; `null` without a line.
    pub frequency_hz: Option<f64>,
    /// Amplitude of this line, m.
    pub amplitude_m: Option<f64>,
    /// RMS velocity, m/s.
    pub rms_velocity_m_per_s: f64,
    /// Largest Lyapunov exponent, 1/s; `null` if it was not computed.
    pub exponent_per_s: Option<Exponent>,
}

impl Motion {
    fn of(found: &SettledResponse) -> Self {
        let line = found.lines.first();
        let spectrum = found.exponents.as_ref();
        Self {
            regime: found.regime,
            frequency_hz: line.map(|line| line.frequency),
            amplitude_m: line.map(|line| line.amplitude),
            rms_velocity_m_per_s: found.rms_velocity_m_per_s,
            exponent_per_s: spectrum.and_then(|spectrum| spectrum.exponents.first().copied()),
        }
    }

    /// Whether the frequency and amplitude of a line converge with the time of measurement.
    pub fn has_lines(&self) -> bool {
        matches!(self.regime, Regime::Periodic | Regime::QuasiPeriodic)
    }

    /// Largest relative difference from a reference: of the rms velocity and, if the reference has lines, of frequency and
    /// amplitude of the strongest one.
    pub fn difference(&self, reference: &Self) -> f64 {
        let relative = |value: Option<f64>, of: Option<f64>| match (value, of) {
            (Some(value), Some(of)) => (value / of - 1.0).abs(),
            _ => 1.0,
        };
        let rms = [self, reference].map(|motion| Some(motion.rms_velocity_m_per_s));
        let rms = relative(rms[0], rms[1]);
        if !reference.has_lines() {
            return rms;
        }
        rms.max(relative(self.frequency_hz, reference.frequency_hz))
            .max(relative(self.amplitude_m, reference.amplitude_m))
    }

    /// Whether the largest exponents agree within their 95 % intervals; `None` if one of them is unknown.
    pub fn exponents_agree(&self, other: &Self) -> Option<bool> {
        let (a, b) = (self.exponent_per_s?, other.exponent_per_s?);
        let width = a.half_width.hypot(b.half_width);
        width
            .is_finite()
            .then(|| (a.value - b.value).abs() <= width)
    }
}

/// Runs variants of a scene from one settled state, and reports the progress.
pub struct Runner<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The settled response, whose state lacks those of friction, which belong to the nodes; `None` until it has settled.
    pub settled: Option<SettledResponse>,
    /// How each run settles and is measured.
    pub plan: ResponsePlan,
    progress: OnProgress<'a>,
    /// The task, and the completed share of the whole.
    task: (&'static str, f64),
}

impl<'a> Runner<'a> {
    /// Runs the scene from its kick until it has settled.
    pub fn settle(scene: &'a Scene, progress: OnProgress<'a>) -> Result<Self, StudyError> {
        let system = prepare(scene)?.integrator.into_system();
        let omega = system.omega().iter().copied();
        let period = std::f64::consts::TAU / omega.filter(|w| *w > 0.0).fold(1e9, f64::min);
        let whole = |time: f64| (time * scene.sample_rate).ceil() / scene.sample_rate;
        let settling = whole(SETTLING * period);
        let mut runner = Self {
            scene,
            settled: None,
            plan: ResponsePlan {
                min_transient_s: settling,
                max_transient_s: MAX_TRANSIENT.max(2.0 * settling),
                measurement_s: whole(MEASUREMENT * period),
                exponents: 0,
                orbits: false,
                portrait: false,
                max_rhs_evals: Some(MAX_RHS_EVALS),
            },
            progress,
            task: ("settling", 0.0),
        };
        let mut settled = runner.respond(scene, None, 0)?;
        if settled.regime == Regime::Silent || settled.rms_velocity_m_per_s == 0.0 {
            return Err(StudyError::AtRest);
        }
        settled.state.truncate(2 * system.modes());
        runner.settled = Some(settled);
        // Less than one sample shorter, so that the window never counts as too short because of rounding.
        runner.plan.max_transient_s = settling * (1.0 - 1e-9);
        Ok(runner)
    }

    /// Begins a task at this share of the whole.
    pub fn begin(&mut self, task: &'static str, share: f64) {
        self.task = (task, share);
    }

    /// Reports the progress, often enough for an interrupt.
    pub fn check(&mut self) -> Result<(), Stopped> {
        let (task, share) = self.task;
        (self.progress)(share, task)
    }

    fn respond(
        &mut self,
        scene: &Scene,
        earlier: Option<&SettledResponse>,
        exponents: usize,
    ) -> Result<SettledResponse, StudyError> {
        let trial = Trial::of_scene(scene.clone().without_analyses())?;
        let plan = self.plan;
        let plan = ResponsePlan { exponents, ..plan };
        response(trial, earlier, &plan, &mut || self.check())
    }

    /// The motion of a scene from the settled state.
    pub fn motion(&mut self, scene: &Scene, exponents: usize) -> Result<Motion, StudyError> {
        let settled = self.settled.clone();
        let found = self.respond(scene, settled.as_ref(), exponents)?;
        Ok(Motion::of(&found))
    }

    /// Two successive measurements of the motion of a scene, the first with its largest exponent.
    pub fn twice(&mut self, scene: &Scene) -> Result<(Motion, Motion), StudyError> {
        let settled = self.settled.clone();
        let first = self.respond(scene, settled.as_ref(), 1)?;
        let next = self.respond(scene, Some(&first), 0)?;
        Ok((Motion::of(&first), Motion::of(&next)))
    }

    /// CPU time (s) and right-hand-side evaluations per simulated second of the motion from the settled state.
    pub fn time(&mut self, scene: &Scene) -> Result<[f64; 2], StudyError> {
        let mut run = prepare(scene)?;
        if let Some(settled) = &self.settled {
            run = run.starting_from(&settled.state);
        }
        let simulated = TIMED * self.plan.measurement_s;
        let seconds = self.shortest(|| {
            run.integrator.start(0.0, &run.state)?;
            Ok(run.integrator.integrate_to(simulated)?)
        })?;
        let rhs_evals = run.integrator.stats().rhs_evals as f64 / REPEATS as f64;
        Ok([seconds / simulated, rhs_evals / simulated])
    }

    /// The shortest CPU time of some work, s.
    pub fn shortest(
        &mut self,
        mut work: impl FnMut() -> Result<(), StudyError>,
    ) -> Result<f64, StudyError> {
        let mut shortest = f64::INFINITY;
        for _ in 0..REPEATS {
            self.check()?;
            let began = ProcessTime::now();
            work()?;
            shortest = shortest.min(began.elapsed().as_secs_f64());
        }
        Ok(shortest)
    }
}
