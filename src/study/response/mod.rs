//! The settled response of a scene: the attractor that the simulation reaches, and its characteristics.
//!
//! A simulation starts from the scene's kick, or from the final state of another one, and runs until its
//! transient has ended ([`TransientDetector`]), or until its amplitude falls below the silence threshold. Then one window
//! of the settled motion is sampled. All measures are computed from this window; the Lyapunov exponents come from tangent
//! vectors integrated with it, or from the Floquet multipliers of the stable periodic orbit that the motion follows. The
//! motion is not settled if the energies of its modes, or its local exponents ([`ChangeDetector`]), change in the window.

mod measure;
mod orbit;

#[cfg(test)]
pub(crate) mod tests;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::{
    poincare::ClosedCurves,
    recurrence::{Measures, RecurrencePeriods},
    regime::Regime,
    tones::{Bases, SpectralLine},
    transient::TransientDetector,
};
use crate::dynamics::continuation::PeriodicOrbit;
use crate::dynamics::{Integrator, LyapunovSpectrum, Motion, SolverStats};
use crate::pipeline::ChangeDetector;
use crate::pipeline::message::regime_on;

use super::subject::Trial;
use super::{POLL, StabilityAt, StopCheck, StudyError};
use measure::Samples;
pub use measure::section_lag;
pub(super) use measure::{recurrence_periods, thinned};

/// Plan of one response: transient limits, measurement time, optional analyses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponsePlan {
    /// Minimum transient time, s: the transient is not considered ended before.
    pub min_transient_s: f64,
    /// Maximum transient time, s. A motion that changes during the measurement is measured once more, which
    /// may take one measurement longer.
    pub max_transient_s: f64,
    /// Measurement time, s: length of the window of settled motion.
    pub measurement_s: f64,
    /// Number of leading Lyapunov exponents to compute; 0 for none. Limited to the dimension of the system.
    pub exponents: usize,
    /// Whether the exponents of a settled motion that follows a stable periodic orbit are those of the orbit. They are then
    /// computed with the tolerance of the continuation and not that of the scene, and a quarter of the measurement time is
    /// enough, if it has 250 periods.
    pub orbits: bool,
    /// Whether to keep samples and spectrum for phase portraits and recurrence plots.
    pub portrait: bool,
    /// Maximum number of right-hand-side evaluations; the response fails beyond it. `None` for no limit.
    pub max_rhs_evals: Option<u64>,
}

impl Default for ResponsePlan {
    fn default() -> Self {
        Self {
            min_transient_s: 0.05,
            max_transient_s: 1.0,
            // 1000 periods of the slowest mode: an exponent counts as zero only after that many.
            measurement_s: 0.6,
            exponents: 3,
            orbits: true,
            portrait: true,
            max_rhs_evals: None,
        }
    }
}

/// Period of the slowest mode of the ball on the beam, s, for which the default times hold.
pub(super) const SLOWEST: f64 = 6e-4;

impl ResponsePlan {
    /// The plan with all times multiplied by a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.min_transient_s *= factor;
        self.max_transient_s *= factor;
        self.measurement_s *= factor;
        self
    }
}

/// Length of an energy block, periods of the slowest mode.
const BLOCK: f64 = 5.0;

/// Time for the tangent vectors to align with the Lyapunov directions, periods of the slowest mode.
const ALIGN: f64 = 40.0;

/// Time for which a periodic motion is measured: share of the measurement time, and minimum number of periods.
const PERIODIC_SHARE: f64 = 0.25;
const PERIODIC_PERIODS: f64 = 250.0;

/// Computes the settled response of a system; of a scene at the tilt of its start, with its linear modes. It starts from the
/// initial state of the scene, with its kick, or from the final state of an earlier response, whose lines give theirs their
/// names as far as possible.
///
/// # Errors
/// [`StudyError::Stopped`]; if the linear modes cannot be computed, or the integration or an analysis fails.
pub fn response(
    mut trial: Trial,
    earlier: Option<&SettledResponse>,
    plan: &ResponsePlan,
    check: StopCheck<'_>,
) -> Result<SettledResponse, StudyError> {
    let (lag, seed, silence) = (trial.lag, trial.seed, trial.silence);
    let scene = trial.scene.take();
    let joint = scene.as_ref().and_then(|scene| scene.joint().ok());
    let linear = match joint.zip(trial.prepared.ball.as_ref()) {
        Some((joint, ball)) => Some(StabilityAt::new(ball, joint.tilt.at(0.0))?),
        None => None,
    };
    let bases = earlier.map_or(Bases::None, SettledResponse::bases);
    if let Some(earlier) = earlier {
        // Accumulated quantities at the end, such as work, restart from zero.
        trial.prepared = trial.prepared.starting_from(&earlier.state);
    }
    let mut run = Run::new(trial, plan, check)?;
    let settled = run.settle()?;
    let transient = run.time();
    let scene = scene.filter(|_| settled && plan.orbits && plan.exponents > 0);
    let orbit = scene.and_then(|scene| orbit::stable_orbit(scene, &run));
    let measured = run.measure_motion(transient, orbit.as_ref(), seed)?;
    let found = measured.samples.response(lag, silence, bases)?;
    run.end_a_period()?;
    let exponents = measured.exponents;
    let settled = settled && !measured.changed;
    let motion = match run.drive_period {
        Some(_) => Motion::Driven,
        None => Motion::Free,
    };
    let attractor = exponents.as_ref().map(|found| found.attractor_of(motion));
    // While a motion decays or grows, only a positive exponent decides.
    let attractor = attractor.filter(|attractor| settled || attractor.is_chaotic());
    let (regime, confidence) = match attractor.and_then(regime_on) {
        _ if measured.follows_orbit => (Regime::Periodic, 1.0),
        Some(regime) if found.regime != Regime::Silent => (regime, 0.95),
        _ => (found.regime, found.confidence),
    };
    let is_regular = matches!(regime, Regime::Periodic | Regime::QuasiPeriodic);
    Ok(SettledResponse {
        transient_s: measured.transient,
        settled,
        regime,
        confidence,
        doubling: if is_regular { found.doubling } else { 0 },
        exponents,
        linear,
        portrait: found.portrait.filter(|_| plan.portrait),
        state: run.z[..run.integrator.system().tangent_dim()].to_vec(),
        stats: run.integrator.stats(),
        ..found
    })
}

/// One simulation in progress.
pub(super) struct Run<'a> {
    probe: Vec<f64>,
    /// Sample rate, Hz.
    rate: f64,
    /// Displacement below which the system is at rest, m.
    silence: f64,
    /// Period of the slowest motion, s.
    period: f64,
    drive_period: Option<f64>,
    integrator: Integrator<'static>,
    /// State at the last sample.
    z: Vec<f64>,
    samples: u64,
    check: StopCheck<'a>,
    plan: &'a ResponsePlan,
}

/// One measured window of the motion after its transient.
struct Measured {
    samples: Samples,
    /// Time before the window, s.
    transient: f64,
    /// Whether the motion changed within the window.
    changed: bool,
    /// Whether the motion follows a known periodic orbit.
    follows_orbit: bool,
    /// Exponents of the last motion within the window, or of the orbit, if they are computed.
    exponents: Option<LyapunovSpectrum>,
}

impl<'a> Run<'a> {
    /// Starts at the prepared state.
    fn new(trial: Trial, plan: &'a ResponsePlan, check: StopCheck<'a>) -> Result<Self, StudyError> {
        let prepared = trial.prepared;
        let omega = prepared.integrator.system().omega().iter().copied();
        let slowest = omega.filter(|w| *w > 0.0).fold(f64::MAX, f64::min);
        let mut run = Self {
            period: trial.period.unwrap_or(std::f64::consts::TAU / slowest),
            drive_period: trial.drive_period,
            silence: trial.silence,
            probe: prepared.probe,
            rate: trial.sample_rate,
            integrator: prepared.integrator,
            z: prepared.state,
            samples: 0,
            check,
            plan,
        };
        run.integrator.start(0.0, &run.z)?;
        Ok(run)
    }

    /// Time of the last sample, s.
    fn time(&self) -> f64 {
        self.samples as f64 / self.rate
    }

    /// Advances by one sample.
    fn advance(&mut self) -> Result<(), StudyError> {
        self.samples += 1;
        let time = self.time();
        self.integrator.sample(time, &mut self.z)?;
        let rhs_evals = self.integrator.stats().rhs_evals;
        if self.plan.max_rhs_evals.is_some_and(|max| rhs_evals > max) {
            return Err(StudyError::TooManyEvaluations { rhs_evals, time });
        }
        if self.samples % POLL == 1 {
            (self.check)()?;
        }
        Ok(())
    }

    /// Displacement of the probe, m.
    fn displacement(&self) -> f64 {
        self.probe.iter().zip(&self.z).map(|(a, b)| a * b).sum()
    }

    /// Velocity of the probe, m/s.
    fn velocity(&self) -> f64 {
        let along = |rates: &[f64]| self.probe.iter().zip(rates).map(|(a, b)| a * b).sum();
        match self.integrator.system().modes() {
            0 => {
                let mut rates = vec![0.0; self.z.len()];
                self.integrator
                    .system()
                    .rhs(self.time(), &self.z, &mut rates);
                along(&rates)
            }
            modes => along(&self.z[modes..]),
        }
    }

    /// Energies of the modes, or the squares of the components of a system without modes.
    fn energies(&self) -> impl Iterator<Item = f64> {
        let omega = self.integrator.system().omega();
        let count = if omega.is_empty() {
            self.z.len()
        } else {
            omega.len()
        };
        let z = &self.z;
        (0..count).map(move |k| match omega.get(k) {
            Some(omega) => z[count + k] * z[count + k] + (omega * z[k]).powi(2),
            None => z[k] * z[k],
        })
    }

    /// A detector of the end of a transient in these energies.
    fn detector(&self) -> TransientDetector {
        let block = (BLOCK * self.period * self.rate).round().min(1e9) as usize;
        TransientDetector::new(self.energies().count(), block)
    }

    /// Runs to the end of a period of the drive, so that another run can continue from there at time zero.
    fn end_a_period(&mut self) -> Result<(), StudyError> {
        if let Some(drive) = self.drive_period {
            let count = (self.time() / drive - 1e-9).ceil();
            self.integrator.integrate_to(count * drive)?;
            self.z.copy_from_slice(self.integrator.state());
        }
        Ok(())
    }

    /// Runs until the transient has ended; returns whether it has.
    fn settle(&mut self) -> Result<bool, StudyError> {
        let plan = self.plan;
        let mut detector = self.detector();
        let mut largest: f64 = 0.0;
        let mut next_check = 0;
        while self.time() < plan.max_transient_s {
            self.advance()?;
            largest = largest.max(self.displacement().abs());
            if !detector.push(self.energies()) {
                continue;
            }
            let silent = largest < self.silence && detector.blocks() > 1;
            largest = 0.0;
            // Repeated tests on growing data would sooner or later pass by chance: space them by 10 %.
            if detector.blocks() < next_check || self.time() < plan.min_transient_s {
                continue;
            }
            next_check = detector.blocks() + detector.blocks() / 10 + 1;
            if detector.has_ended() || silent {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Adds tangent vectors at the current state and lets them align.
    fn start_tangents(&mut self, width: usize, seed: u64) -> Result<(), StudyError> {
        let time = self.time();
        self.integrator.integrate_to(time)?;
        let start = self.integrator.state().to_vec();
        let mut with = self.integrator.clone().with_tangents(width, seed)?;
        with.start(time, &start)?;
        self.integrator = with;
        let align = (ALIGN * self.period * self.rate).min(1e9) as u64;
        for _ in 0..align {
            self.advance()?;
        }
        let time = self.time();
        self.integrator.integrate_to(time)?;
        self.integrator.reset_growth();
        Ok(())
    }

    /// Measures the motion after a transient (s), which follows the given orbit, if any. `seed` is that of the tangent
    /// vectors of other motions.
    fn measure_motion(
        &mut self,
        mut transient: f64,
        orbit: Option<&PeriodicOrbit>,
        seed: u64,
    ) -> Result<Measured, StudyError> {
        let plan = self.plan;
        let width = plan.exponents.min(self.integrator.system().tangent_dim());
        if let Some(orbit) = orbit {
            let window = PERIODIC_SHARE * plan.measurement_s;
            let window = window.max(PERIODIC_PERIODS * orbit.period_s);
            let window = window.min(plan.measurement_s);
            let mut measured = self.sample_window(transient, window)?;
            if !measured.changed {
                measured.exponents = Some(orbit::exponents(orbit, width));
                measured.follows_orbit = true;
                return Ok(measured);
            }
            transient = self.time();
        }
        if width > 0 {
            self.start_tangents(width, seed)?;
        }
        loop {
            let measured = self.sample_window(transient, plan.measurement_s)?;
            if !measured.changed || self.time() >= plan.max_transient_s + plan.measurement_s {
                return Ok(measured);
            }
            // The motion looked settled but changed: measure the new one.
            transient = self.time();
            self.integrator.reset_growth();
        }
    }

    /// Samples one window (s) after a transient (s).
    fn sample_window(&mut self, transient: f64, window: f64) -> Result<Measured, StudyError> {
        let count = (window * self.rate).round().max(1.0) as usize;
        let mut samples = Samples {
            rate: self.rate,
            displacement: Vec::with_capacity(count),
            velocity: Vec::with_capacity(count),
        };
        let mut detector = self.detector();
        let changes = ChangeDetector::new(&self.integrator, self.time(), 1.0 / self.rate);
        let mut changes = self.integrator.exponents().map(|_| changes);
        let mut largest: f64 = 0.0;
        for _ in 0..count {
            self.advance()?;
            if let Some(changes) = &mut changes {
                changes.push(&self.integrator, &self.z);
            }
            let displacement = self.displacement();
            samples.displacement.push(displacement);
            samples.velocity.push(self.velocity());
            detector.push(self.energies());
            largest = largest.max(displacement.abs());
        }
        let time = self.time();
        self.integrator.integrate_to(time)?;
        self.z.copy_from_slice(self.integrator.state());
        let motions = changes.map(|mut changes| changes.segments(&self.integrator));
        let mut motions = motions.unwrap_or_default();
        let changed = largest >= self.silence && (motions.len() > 1 || detector.has_changed());
        let exponents = motions.pop().map(|motion| motion.spectrum);
        Ok(Measured {
            samples,
            transient,
            changed,
            follows_orbit: false,
            exponents: exponents.filter(|spectrum| spectrum.time > 0.0),
        })
    }
}

/// A settled response of a scene, in SI units. Measures that could not be computed are empty. Each field is a column of
/// the table of a sweep, which is derived from this type: so no field may be flattened.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SettledResponse {
    /// Transient time before the measurement, s. It includes earlier windows in which the motion changed.
    pub transient_s: f64,
    /// Whether the motion is settled: the transient had ended, and the motion did not change while measured.
    pub settled: bool,
    /// Half the peak-to-peak displacement of the probe, m.
    pub amplitude_m: f64,
    /// Mean displacement of the probe, m.
    pub mean_m: f64,
    /// RMS velocity of the probe, m/s.
    pub rms_velocity_m_per_s: f64,
    /// Peak absolute velocity of the probe, m/s.
    pub peak_velocity_m_per_s: f64,
    /// Regime: the type of motion, by the exponents if they decide, else by the samples.
    pub regime: Regime,
    /// Confidence of the regime, 0 to 1; 0.95, that of their intervals, if the exponents decide.
    pub confidence: f64,
    /// Broadband share: share of the spectral power outside the lines, 0 to 1.
    pub broadband_share: f64,
    /// Newest local maxima of the displacement, m: a column of the bifurcation diagram.
    pub maxima_m: Vec<f64>,
    /// Newest points of the section: `y(t)` and `y(t + 2 tau)` where `y(t + tau)` crosses zero upwards, m.
    pub section_m: Vec<[f64; 2]>,
    /// Closed curves of the section: the motion is on a torus; `None` if there are none.
    pub curves: Option<ClosedCurves>,
    /// Doubling order of a periodic or quasi-periodic motion: 0; 1 if it has lines at halves of the
    /// combinations of its base frequencies, 2 if at quarters.
    pub doubling: u32,
    /// Spectral lines in descending order of amplitude.
    pub lines: Vec<SpectralLine>,
    /// Leading Lyapunov exponents; `None` if none were computed.
    pub exponents: Option<LyapunovSpectrum>,
    /// Recurrence quantification; `None` for a silent motion.
    pub recurrence: Option<Measures>,
    /// Periods of the diagonal lines of the recurrence plot: finest, beat, doubled; s.
    pub recurrence_periods: RecurrencePeriods,
    /// Linear modes at steady sliding; `None` for a system other than the joint.
    pub linear: Option<StabilityAt>,
    /// Final state `[q | dq/dt]`, for continuation.
    pub state: Vec<f64>,
    /// Solver statistics.
    pub stats: SolverStats,
    /// Samples and spectrum for plots, if requested.
    // JSON does not have them, see `SweepPoint`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(skip)]
    pub portrait: Option<PhasePortrait>,
}

impl SettledResponse {
    /// The regime, and the doubling of a motion that has doubled: "torus, doubled", "periodic, doubled
    /// twice".
    pub fn motion(&self) -> String {
        let kind = match (self.regime, self.doubling) {
            (Regime::QuasiPeriodic, 1..) => "torus".to_owned(),
            (regime, _) => regime.to_string(),
        };
        match self.doubling {
            0 => kind,
            1 => format!("{kind}, doubled"),
            _ => format!("{kind}, doubled twice"),
        }
    }

    /// Name of the lowest line of the last doubling, such as `(f1 + f2)/2`; `None` without one.
    pub fn doubling_line(&self) -> Option<&str> {
        let ending = match self.doubling {
            0 => return None,
            1 => "/2",
            _ => "/4",
        };
        let mut lines = self.lines.iter().map(|line| &*line.label);
        lines.find(|label| label.ends_with(ending))
    }

    /// Base frequencies by the names of the lines.
    pub fn bases(&self) -> Bases {
        Bases::of_names(|name| {
            let line = self.lines.iter().find(|line| line.label == name);
            line.map(|line| line.frequency)
        })
    }
}

/// Samples for the phase portrait and the recurrence plot, and the amplitude spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhasePortrait {
    /// Sampling interval `dt` of the portrait, s.
    pub dt_s: f64,
    /// Newest displacements `u` of the probe for the portrait, m.
    pub u_m: Vec<f32>,
    /// Velocities `v` of the probe for the portrait, at the same times, m/s.
    pub v_m_per_s: Vec<f32>,
    /// Bin width of the spectrum, Hz; the first bin is at 0 Hz.
    pub spectrum_bin_hz: f64,
    /// Amplitude spectrum of the displacement over the whole measurement window, m.
    pub spectrum_m: Vec<f32>,
}
