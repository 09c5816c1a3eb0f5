//! Tori beyond a Neimark-Sacker point: base frequencies, rotation number, phase locking and doubling, from settled runs.
//!
//! A supercritical Neimark-Sacker point bears an attracting torus. The parameter steps away from the point, and at each
//! value the motion settles from the state of the value before. Its two base frequencies are those of spectral lines over
//! 128 beats, and their error is the difference between the halves of this time. Where the rotation number is a ratio
//! of small integers within its error, Newton's method decides whether the motion is a stable periodic orbit of that
//! ratio: the torus is then phase-locked. The branch of this orbit ends in folds, the borders of the tongue.

use schemars::JsonSchema;
use serde::Serialize;

use super::equilibria::BranchPlan;
use super::result::{At, Branch};
use crate::analysis::tones::{
    Bases, FREQUENCY_UNCERTAINTY, Line, LineCriterion, SpectrumAnalyser, Window, follow_lines,
};
use crate::chain_of_causes;
use crate::dynamics::continuation::{
    BifurcationKind, ContinuationError, ContinuationOptions, Criticality, Family, FamilyMember,
    PeriodicOrbit, ReturnSearch, continue_orbits, settled_orbit,
};
use crate::dynamics::{Accuracy, DynamicsError, Integrator, Method, MethodName};
use crate::study::{OnProgress, StudyError};

/// Beats of the window of the frequencies, and between two looks at the amplitude of the second tone while it settles.
const BEATS: [f64; 2] = [128.0, 32.0];
/// Relative change of this amplitude below which the motion has settled, and maximum number of looks.
const SETTLED: f64 = 2e-3;
const MAX_LOOKS: usize = 60;
/// Samples per period of the first tone.
const SAMPLES: f64 = 64.0;
/// Largest change of both frequencies from one value to the next, relative to the second one: the lines of a doubled torus
/// are farther away.
const STEP: f64 = 0.2;
/// Amplitude of the second tone relative to the strongest line below which there is no torus.
const LEAST: f64 = 1e-4;
/// Relative error of the second frequency above which the motion is not regular.
const REGULAR: f64 = 1e-3;
/// Largest number of periods of a locked motion.
const MAX_PERIODS: u32 = 64;
/// Distance from its start below which a locked motion has returned, relative to its size.
const RETURN: f64 = 1e-3;
/// Natural logarithm of the magnitude below which the multipliers of a locked motion lie: it attracts.
const ATTRACTS: f64 = -1e-5;
/// Share of the amplitudes of the orbit at a Neimark-Sacker point by which the first motion is displaced from it.
const DISPLACED: f64 = 0.03;
/// Relative tolerance of the simulations.
const TOLERANCE: f64 = 1e-8;
/// Smallest error of a rotation number, from the interpolation of lines.
const LEAST_ERROR: f64 = 1e-8;

/// The motion at a value of the parameter beyond a Neimark-Sacker point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "lowercase")]
pub enum TorusKind {
    /// Two base frequencies.
    Torus,
    /// Two base frequencies, with lines at halves of their combinations: the torus is doubled.
    Doubled,
    /// Phase-locked: a periodic motion whose frequencies have a ratio of integers.
    Locked,
    /// Without a second tone: the torus has vanished.
    Vanished,
    /// Frequencies that do not settle: the motion is irregular.
    Irregular,
}

/// A settled motion beyond a Neimark-Sacker point.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TorusPoint {
    /// Kind of the motion.
    pub kind: TorusKind,
    /// Frequency of the first tone, Hz.
    pub first_hz: f64,
    /// Second base frequency: distance of the side lines from the first tone, Hz. `None` without a second tone.
    pub second_hz: Option<f64>,
    /// Amplitude of the strongest side line relative to the strongest line.
    pub side_line: f64,
    /// Rotation number: the second frequency over the first.
    pub rotation_number: Option<f64>,
    /// Error of the rotation number: half the difference between the halves of the time. Zero if the motion is locked.
    pub rotation_number_error: Option<f64>,
    /// Phase locking: rotation number `p/q` as `[p, q]` if the motion is locked.
    pub locking: Option<[u32; 2]>,
    /// Value of the parameter.
    #[serde(flatten)]
    pub at: At,
}

/// A phase-locked tongue: an interval of the parameter with a stable periodic orbit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Tongue {
    /// Phase locking: rotation number `p/q` as `[p, q]`.
    pub locking: [u32; 2],
    /// The folds that are its borders, in ascending order; `None` where the orbit ends in another way.
    pub borders: [Option<f64>; 2],
}

/// A torus from its birth on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Torus {
    /// Number of the branch of periodic orbits from which it is born.
    pub branch: usize,
    /// Value of the parameter at which the torus is born: the Neimark-Sacker point.
    pub born: f64,
    /// The settled motions, in their order away from this point.
    pub points: Vec<TorusPoint>,
    /// The phase-locked tongues found, each with its `locking` as `[p, q]` and its two `borders` in ascending order.
    pub tongues: Vec<Tongue>,
    /// Why the study of the torus ended before the last value, if it did.
    pub ended: Option<String>,
}

/// Adds the tori of the supercritical Neimark-Sacker points of attracting orbits to a result, each at `count` values of the
/// parameter between the point and the end of the interval.
pub fn add_tori(
    plan: &BranchPlan,
    count: u32,
    result: &mut Branch,
    progress: OnProgress<'_>,
) -> Result<(), StudyError> {
    let family = plan.family();
    let options = family.options(plan.interval)?;
    let method = MethodName::Lawson853.with(Accuracy::relative(TOLERANCE), options.method.max_step);
    let mut tori = Vec::new();
    for found in result.orbit_bifurcations() {
        let point = &found.bifurcation;
        let is_supercritical = point
            .birth
            .is_some_and(|birth| birth.criticality == Criticality::Supercritical);
        let (Some(rate), Some(second_hz)) = (point.crossing_rate, point.torus_frequency_hz) else {
            continue;
        };
        if !is_supercritical || !point.has_stable_side() {
            continue;
        }
        let width = plan.interval[usize::from(rate > 0.0)] - point.parameter;
        let values = (1..=count).map(|k| point.parameter + width * f64::from(k) / f64::from(count));
        let orbit = &point.orbit;
        let moved = orbit.state.iter().zip(&orbit.component_amplitudes);
        let study = TorusStudy {
            family: &family,
            name: plan.name(),
            options: &options,
            method,
            state: moved.map(|(z, size)| z + DISPLACED * size).collect(),
            frequencies_hz: [point.frequency_hz, second_hz],
        };
        let mut torus = Torus {
            branch: found.branch,
            born: point.parameter,
            ..Torus::default()
        };
        let values: Vec<f64> = values.collect();
        torus.ended = study.follow(&values, &mut torus, progress).err();
        tori.push(torus);
    }
    result.tori.extend(tori);
    Ok(())
}

/// A motion that is followed over a family.
struct TorusStudy<'a> {
    family: &'a dyn Family,
    /// Name of the parameter.
    name: &'a str,
    /// Options of the locked orbits.
    options: &'a ContinuationOptions,
    /// Method of the simulations.
    method: Method,
    /// The present state, on or near the torus.
    state: Vec<f64>,
    /// Both base frequencies, Hz.
    frequencies_hz: [f64; 2],
}

impl TorusStudy<'_> {
    /// Follows a torus over some values of the parameter.
    ///
    /// # Errors
    /// Why it ends before the last value.
    fn follow(
        mut self,
        values: &[f64],
        torus: &mut Torus,
        progress: OnProgress<'_>,
    ) -> Result<(), String> {
        for (k, &value) in values.iter().enumerate() {
            let at = format!("{} = {value}", self.name);
            let go_on = progress(k as f64 / values.len() as f64, &format!("torus, {at}"));
            go_on.map_err(|_| "interrupted")?;
            let point = self.settled(value);
            let mut point =
                point.map_err(|error| format!("at {at}: {}", chain_of_causes(&error)))?;
            if point.kind == TorusKind::Torus
                && let Some((ratio, orbit)) = self.locking(&point)
            {
                point.kind = TorusKind::Locked;
                point.rotation_number = Some(f64::from(ratio[0]) / f64::from(ratio[1]));
                point.rotation_number_error = Some(0.0);
                point.locking = Some(ratio);
                self.add_tongue(ratio, orbit, &mut torus.tongues);
            }
            let kind = point.kind;
            torus.points.push(point);
            let end = match kind {
                TorusKind::Vanished => "without a second tone",
                TorusKind::Irregular => "irregular",
                TorusKind::Torus | TorusKind::Doubled | TorusKind::Locked => continue,
            };
            return Err(format!("at {at}: the motion is {end}"));
        }
        Ok(())
    }

    /// Lets the motion settle at a value of the parameter and measures its tones.
    fn settled(&mut self, parameter: f64) -> Result<TorusPoint, ContinuationError> {
        let member = self.family.member(parameter);
        let member = member.map_err(|source| ContinuationError::Family { parameter, source })?;
        let drive_hz = member.drive_period.map(f64::recip);
        let [first_hz, second_hz] = self.frequencies_hz;
        let first_hz = drive_hz.unwrap_or(first_hz);
        let rate = SAMPLES * first_hz;
        let tones_in = |signal: &[f64]| {
            let found = tones_in(signal, rate, [first_hz, second_hz], drive_hz.is_some());
            found.unwrap_or(Tones {
                first_hz,
                second: None,
                doubled: false,
            })
        };
        let mut simulate = |beats: f64| {
            let count = (beats * rate / second_hz).ceil() as usize;
            let signal = self.simulate(&member, (count, rate));
            signal.map_err(|source| ContinuationError::Integration { parameter, source })
        };
        let mut before = 0.0;
        for _ in 0..MAX_LOOKS {
            let second = tones_in(&simulate(BEATS[1])?).second;
            let now = second.map_or(0.0, |[_, amplitude]| amplitude);
            if (now - before).abs() <= SETTLED * now.max(LEAST) {
                break;
            }
            before = now;
        }
        let signal = simulate(BEATS[0])?;
        let (early, late) = signal.split_at(signal.len() / 2);
        let tones = tones_in(&signal);
        let rotation = |tones: &Tones| Some(tones.second?[0] / tones.first_hz);
        let halves = rotation(&tones_in(early)).zip(rotation(&tones_in(late)));
        let error = halves.map(|(a, b)| (0.5 * (a - b).abs()).max(LEAST_ERROR));
        let rotation_number = rotation(&tones);
        let share = error.zip(rotation_number).map(|(error, of)| error / of);
        if let Some([second, _]) = tones.second {
            self.frequencies_hz = [tones.first_hz, second];
        }
        Ok(TorusPoint {
            kind: match tones.second {
                None => TorusKind::Vanished,
                Some(_) if share.is_none_or(|share| share >= REGULAR) => TorusKind::Irregular,
                Some(_) if tones.doubled => TorusKind::Doubled,
                Some(_) => TorusKind::Torus,
            },
            first_hz: tones.first_hz,
            second_hz: tones.second.map(|[second, _]| second),
            side_line: tones.second.map_or(0.0, |[_, amplitude]| amplitude),
            rotation_number,
            rotation_number_error: error,
            locking: None,
            at: At::new(self.name, parameter),
        })
    }

    /// Simulates `count` samples of the observable at a rate (Hz). The state becomes that at the end, at a multiple of the
    /// period of a drive.
    fn simulate(
        &mut self,
        member: &FamilyMember,
        (count, rate): (usize, f64),
    ) -> Result<Vec<f64>, DynamicsError> {
        let sys = member.system.as_ref();
        let (mut integrator, mut z) = Integrator::started(self.method, sys, &self.state)?;
        let mut signal = Vec::with_capacity(count);
        for k in 1..=count {
            integrator.sample(k as f64 / rate, &mut z)?;
            let terms = member.observable.iter().zip(&z);
            signal.push(terms.map(|(a, z)| a * z).sum::<f64>());
        }
        let end = count as f64 / rate;
        let end = member
            .drive_period
            .map_or(end, |drive| (end / drive).ceil() * drive);
        integrator.integrate_to(end)?;
        self.state = integrator.state()[..sys.tangent_dim()].to_vec();
        Ok(signal)
    }

    /// The ratio of integers at which a torus is locked, with its attracting periodic orbit; `None` if it is not.
    fn locking(&self, point: &TorusPoint) -> Option<([u32; 2], PeriodicOrbit)> {
        let (rotation, error) = point.rotation_number.zip(point.rotation_number_error)?;
        let ratio = (1..=MAX_PERIODS).find_map(|q| {
            let p = (rotation * f64::from(q)).round();
            let off = (rotation - p / f64::from(q)).abs();
            (p > 0.0 && off <= 3.0 * error).then_some([p as u32, q])
        })?;
        let period = f64::from(ratio[1]) / point.first_hz;
        let search = ReturnSearch {
            settle_s: 0.0,
            max_period_s: period * 1.01,
            tolerance: RETURN,
        };
        let (at, state) = (point.at.value, &self.state);
        let orbit = settled_orbit(self.family, at, state, &search, self.options);
        let orbit = orbit.ok()?;
        let is_whole = (orbit.period_s / period - 1.0).abs() < 1e-3;
        let attracts = orbit
            .nontrivial_multipliers()
            .all(|multiplier| multiplier.ln_magnitude < ATTRACTS);
        (attracts && is_whole).then_some((ratio, orbit))
    }

    /// Adds the tongue of a locked orbit, unless it is known.
    fn add_tongue(&self, locking: [u32; 2], orbit: PeriodicOrbit, tongues: &mut Vec<Tongue>) {
        let here = orbit.parameter;
        let contains = |tongue: &Tongue| {
            let [low, high] = tongue.borders;
            tongue.locking == locking
                && low.is_none_or(|low| low <= here)
                && high.is_none_or(|high| here <= high)
        };
        if tongues.iter().any(contains) {
            return;
        }
        let branch = continue_orbits(self.family, &orbit.into(), self.options, &mut |_| Ok(()));
        let found = branch.map_or(Vec::new(), |branch| branch.bifurcations);
        let folds = found
            .iter()
            .filter(|found| found.kind == BifurcationKind::Fold);
        let folds = folds.map(|fold| fold.parameter);
        let below = folds.clone().filter(|at| *at < here).reduce(f64::max);
        let borders = [below, folds.filter(|at| *at > here).reduce(f64::min)];
        tongues.push(Tongue { locking, borders });
    }
}

/// Both tones of a settled motion.
struct Tones {
    first_hz: f64,
    /// Second frequency and amplitude of its strongest line relative to the strongest line.
    second: Option<[f64; 2]>,
    doubled: bool,
}

/// The tones in a signal near the expected ones, of which a drive sets the first; `None` without lines.
fn tones_in(
    signal: &[f64],
    rate: f64,
    [first, second]: [f64; 2],
    is_driven: bool,
) -> Option<Tones> {
    let mut analyser = SpectrumAnalyser::new(Window::BlackmanHarris, rate);
    let spectrum = analyser.analyse(signal).ok()?;
    let lines = spectrum.lines(&LineCriterion {
        ratio_to_strongest: LEAST,
        max_lines: 24,
        ..LineCriterion::default()
    });
    let strongest = lines.first()?.amplitude;
    let is_first = |line: &&Line| (line.frequency - first).abs() < STEP * second;
    let first_hz = if is_driven {
        first
    } else {
        lines.iter().find(is_first)?.frequency
    };
    // The side lines of all harmonics of the first tone, and of the mean.
    let side = lines.iter().find_map(|line| {
        let off = line.frequency - first_hz * (line.frequency / first_hz).round();
        let is_second = (off.abs() / second - 1.0).abs() < STEP;
        is_second.then_some([off.abs(), line.amplitude / strongest])
    });
    let doubled = side.is_some_and(|[f2, _]| {
        let bases = Bases::Two { f1: first_hz, f2 };
        let uncertainty = FREQUENCY_UNCERTAINTY * spectrum.bin;
        follow_lines(&lines, uncertainty, bases).doubling > 0
    });
    Some(Tones {
        first_hz,
        second: side,
        doubled,
    })
}

#[cfg(test)]
#[path = "tori_tests.rs"]
mod tests;
