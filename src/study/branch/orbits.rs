//! Branches of periodic orbits of a scene: from a settled motion, from Hopf points, and at period doublings.

use std::sync::{Mutex, PoisonError};

use super::BranchError;
use super::equilibria::BranchPlan;
use super::hopf::{Criticality, CriticalityMethod, SteadyBifurcation, SteadyBifurcationKind};
use super::result::{Branch, BranchBifurcation};
use super::steady::SteadyFamily;
use crate::analysis::Regime;
use crate::dynamics::continuation::{
    BifurcationKind, BranchEnd, BranchStart, BranchUpdate, ContinuationOptions, Family,
    FamilyError, HopfPoint, OrbitBranch, PeriodicOrbit, ReturnSearch, continue_orbits, hopf_orbit,
    settled_orbit, switched_orbit,
};
use crate::dynamics::{Integrator, System};
use crate::scene::{SmallSystem, SystemSpec};
use crate::study::response::{InitialState, ResponsePlan, response};
use crate::study::sweep::chain_of_causes;

/// Amplitude of the first orbit at a Hopf point relative to that at which the sliding speed reverses, or 1 um for a
/// system without sliding.
const HOPF_SHARE: f64 = 0.02;
/// Distance of the first orbit from a period doubling, relative to the size of the orbit.
const SWITCH: f64 = 0.02;
/// Largest period of a motion that is sought, in periods of its strongest line.
const MAX_RETURN: f64 = 40.0;
/// Distance from its start below which a settled motion has returned, relative to its size.
const RETURN: f64 = 0.02;
/// Relative distance of the parameters of two orbits at which they can be the same.
const SAME: f64 = 1e-2;

/// The systems of a scene over a parameter.
pub struct SceneFamily {
    steady: Mutex<SteadyFamily>,
    /// The last value of the parameter with its probe.
    probe: Mutex<Option<(f64, Vec<f64>)>>,
}

impl SceneFamily {
    /// The family of a plan.
    pub fn new(plan: &BranchPlan) -> Self {
        let [from, to] = plan.interval;
        let steady = SteadyFamily::new(
            plan.scene.clone(),
            vec![plan.parameter],
            vec![(to - from).abs()],
        );
        Self {
            steady: Mutex::new(steady),
            probe: Mutex::new(None),
        }
    }
}

impl Family for SceneFamily {
    fn system(&self, parameter: f64) -> Result<Box<dyn System + Send>, FamilyError> {
        let mut steady = self.steady.lock().unwrap_or_else(PoisonError::into_inner);
        let prepared = steady.prepared(&[parameter])?;
        *self.probe.lock().unwrap_or_else(PoisonError::into_inner) =
            Some((parameter, prepared.probe));
        Ok(prepared.system)
    }

    fn drive_period(&self, parameter: f64) -> Option<f64> {
        let steady = self.steady.lock().unwrap_or_else(PoisonError::into_inner);
        let scene = steady.scene_at(&[parameter]).ok()?;
        let omega = match scene.subject {
            SystemSpec::Small(SmallSystem::ImpactOscillator(system)) => system.drive_omega,
            SystemSpec::Small(SmallSystem::DampedContact(system)) => system.drive_omega,
            _ => 0.0,
        };
        (omega > 0.0).then(|| std::f64::consts::TAU / omega)
    }

    /// The displacement of the probe, m.
    fn observable(&self, parameter: f64, z: &[f64]) -> f64 {
        let mut kept = self.probe.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.as_ref().is_none_or(|(value, _)| *value != parameter) {
            let mut steady = self.steady.lock().unwrap_or_else(PoisonError::into_inner);
            match steady.prepared(&[parameter]) {
                Ok(prepared) => *kept = Some((parameter, prepared.probe)),
                Err(_) => return f64::NAN,
            }
        }
        let probe = kept.iter().flat_map(|(_, probe)| probe);
        probe.zip(z).map(|(row, q)| row * q).sum()
    }
}

/// Progress of a study of periodic orbits.
#[derive(Clone, Debug, PartialEq)]
pub enum OrbitProgress {
    /// A motion settles at a value of the parameter.
    Settling(f64),
    /// A branch has a new orbit.
    Orbit {
        /// Number of the branch.
        branch: usize,
        /// Number of orbits of this branch so far.
        orbits: usize,
        /// Value of the parameter.
        value: f64,
    },
}

/// A study of periodic orbits.
struct Study<'a> {
    plan: &'a BranchPlan,
    family: SceneFamily,
    options: ContinuationOptions,
    watch: &'a mut dyn FnMut(OrbitProgress) -> bool,
    stopped: bool,
}

/// Adds the branches of periodic orbits to a result that has the equilibria: the branch through the settled motion at
/// `start` (or at another value if the motion there is not periodic), the branches born at the Hopf points, and those
/// of the first period doublings. `watch` returns whether to continue.
///
/// # Errors
/// If the system cannot be built. Branches that cannot be followed are reported in the result.
pub fn add_orbits(
    plan: &BranchPlan,
    start: Option<f64>,
    result: &mut Branch,
    watch: &mut dyn FnMut(OrbitProgress) -> bool,
) -> Result<(), BranchError> {
    let max_step = plan.scene.integrator.max_step;
    let mut study = Study {
        plan,
        family: SceneFamily::new(plan),
        options: ContinuationOptions::new(plan.interval, max_step),
        watch,
        stopped: false,
    };
    study.add_settled(start, result)?;
    study.add_hopf_branches(result)?;
    study.add_doublings(result);
    Ok(())
}

impl Study<'_> {
    /// The branch through a settled periodic motion.
    fn add_settled(&mut self, start: Option<f64>, result: &mut Branch) -> Result<(), BranchError> {
        let mut reasons = Vec::new();
        for value in self.starts(start) {
            if self.stopped || !(self.watch)(OrbitProgress::Settling(value)) {
                self.stopped = true;
                return Ok(());
            }
            match self.settled(value)? {
                Ok(orbit) => {
                    self.follow(&orbit.into(), result);
                    return Ok(());
                }
                Err(_) if self.stopped => return Ok(()),
                Err(reason) => reasons.push(reason),
            }
        }
        result.ended.extend(reasons);
        Ok(())
    }

    /// Values of the parameter at which a settled motion is tried.
    fn starts(&self, start: Option<f64>) -> Vec<f64> {
        let [from, to] = self.plan.interval;
        let own = start.or_else(|| self.plan.scene.value_of(self.plan.parameter));
        let own = own.filter(|value| (from..=to).contains(value));
        if start.is_some() {
            return own.into_iter().collect();
        }
        let shares = [0.5, 0.25, 0.75, 0.05, 0.95].map(|share| from + share * (to - from));
        own.into_iter().chain(shares).collect()
    }

    /// The orbit of the settled motion at a value, or the reason why there is none.
    fn settled(&mut self, value: f64) -> Result<Result<PeriodicOrbit, String>, BranchError> {
        let name = self.plan.parameter.name();
        let scene = self
            .plan
            .scene
            .with_values(&[(self.plan.parameter, value)])?;
        let plan = ResponsePlan {
            min_transient: 0.02,
            max_transient: 1.0,
            measurement_time: 0.05,
            exponents: 0,
            portrait: false,
            max_rhs_evals: None,
        };
        let watch = &mut *self.watch;
        let mut stopped = false;
        let found = response(&scene, InitialState::Fresh, &plan, &mut None, &mut |_| {
            stopped |= !watch(OrbitProgress::Settling(value));
            !stopped
        });
        self.stopped |= stopped;
        let found = match found {
            Ok(Some(found)) => found,
            Ok(None) => return Ok(Err("interrupted".to_owned())),
            Err(error) => {
                return Ok(Err(format!(
                    "at {name} = {value}: {}",
                    chain_of_causes(&error)
                )));
            }
        };
        if found.regime != Regime::Periodic {
            let kind = found.motion();
            return Ok(Err(format!(
                "the settled motion at {name} = {value} is {kind}, not periodic"
            )));
        }
        let line = found.lines.first().map_or(1e3, |line| line.frequency);
        let search = ReturnSearch {
            settle_s: 0.0,
            max_period_s: MAX_RETURN / line,
            tolerance: RETURN,
        };
        let orbit = settled_orbit(&self.family, value, &found.state, &search, &self.options);
        Ok(orbit.map_err(|error| format!("at {name} = {value}: {}", chain_of_causes(&error))))
    }

    /// The branches born at the Hopf points that no branch has reached.
    fn add_hopf_branches(&mut self, result: &mut Branch) -> Result<(), BranchError> {
        let points: Vec<SteadyBifurcation> = result
            .steady_bifurcations()
            .filter(|found| found.kind == SteadyBifurcationKind::Hopf)
            .cloned()
            .collect();
        for found in points {
            if self.stopped {
                return Ok(());
            }
            if self.is_known(&found, result) {
                continue;
            }
            let at = format!("{} = {}", found.at.name, found.at.value);
            match self.born(&found)? {
                Ok(start) => {
                    fit_birth(&found, &start.orbit, result);
                    self.follow(&start, result);
                }
                Err(reason) => result
                    .ended
                    .push(format!("no branch from the Hopf point at {at}: {reason}")),
            }
        }
        Ok(())
    }

    /// Whether a branch has an orbit of small amplitude next to a Hopf point.
    fn is_known(&self, found: &SteadyBifurcation, result: &Branch) -> bool {
        let width = self.plan.interval[1] - self.plan.interval[0];
        let largest = result.points.iter().map(|point| point.orbit.amplitude);
        let largest = largest.fold(0.0, f64::max);
        result.points.iter().any(|point| {
            let near = (point.at.value - found.at.value).abs() < SAME * width;
            let alike = (point.orbit.frequency_hz() / found.frequency_hz - 1.0).abs() < SAME;
            near && alike && point.orbit.amplitude < 0.1 * largest
        })
    }

    /// The first orbit of the branch born at a Hopf point, or the reason why there is none.
    fn born(
        &mut self,
        found: &SteadyBifurcation,
    ) -> Result<Result<BranchStart, String>, BranchError> {
        let value = found.at.value;
        let mut steady = self
            .family
            .steady
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let state = steady.at(&[value])?;
        drop(steady);
        let omega = std::f64::consts::TAU * found.frequency_hz;
        let modes = state.modes()?;
        let apart = |mode: &crate::dynamics::equilibrium::Eigenmode| {
            (mode.value - faer::c64::new(0.0, omega)).norm()
        };
        let mode = modes.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let Some(mode) = mode else {
            return Ok(Err("the mode is lost".to_owned()));
        };
        let parts = mode.vector.iter().zip(&state.linearised.scale);
        let (real, imaginary) = parts.map(|(x, scale)| (x.re / scale, x.im / scale)).unzip();
        let point = HopfPoint {
            parameter: value,
            state: state.linearised.state.clone(),
            omega,
            real,
            imaginary,
        };
        let amplitude = HOPF_SHARE * self.sliding_speed().map_or(1e-6, |speed| speed / omega);
        let start = hopf_orbit(&self.family, &point, amplitude, &self.options);
        Ok(start.map_err(|error| chain_of_causes(&error)))
    }

    /// Speed of steady sliding, m/s.
    fn sliding_speed(&self) -> Option<f64> {
        match &self.plan.scene.subject {
            SystemSpec::Joint(joint) => {
                let size = joint
                    .spec
                    .rotation
                    .iter()
                    .map(|w| w * w)
                    .sum::<f64>()
                    .sqrt();
                let diameter = self.plan.scene.ball_on_beam().ok()?.geometry.ball_diameter;
                Some(0.5 * size * diameter)
            }
            SystemSpec::Small(system) => system.belt_speed(),
        }
    }

    /// The branches of twice the period at the period doublings found so far.
    fn add_doublings(&mut self, result: &mut Branch) {
        let doublings: Vec<_> = result
            .orbit_bifurcations()
            .filter(|found| found.bifurcation.kind == BifurcationKind::PeriodDoubling)
            .cloned()
            .collect();
        for found in doublings {
            if self.stopped {
                return;
            }
            let start = switched_orbit(&self.family, &found.bifurcation, SWITCH, &self.options);
            match start {
                Ok(start) => self.follow(&start, result),
                Err(error) => result.ended.push(format!(
                    "no branch from the period doubling at {} = {}: {}",
                    found.at.name,
                    found.at.value,
                    chain_of_causes(&error)
                )),
            }
        }
    }

    /// Follows a branch and adds it to the result, with the reasons of its ends.
    fn follow(&mut self, start: &BranchStart, result: &mut Branch) {
        let branch = result.orbit_branches();
        let watch = &mut *self.watch;
        let (mut orbits, mut stopped) = (0, false);
        let followed = continue_orbits(&self.family, start, &self.options, &mut |update| {
            if let BranchUpdate::Point(orbit) = update {
                orbits += 1;
                let value = orbit.parameter;
                stopped |= !watch(OrbitProgress::Orbit {
                    branch,
                    orbits,
                    value,
                });
            }
            !stopped
        });
        self.stopped |= stopped;
        match followed {
            Ok(orbits) => {
                let name = self.plan.parameter.name();
                result.ended.extend(ends(&orbits, branch, name));
                result.ended.extend(orbits.unresolved.iter().map(|[from, to]| {
                    format!(
                        "branch {branch} changes the number of its unstable multipliers between {name} = {from:.6} and \
                         {to:.6} without an identified bifurcation"
                    )
                }));
                result.add_orbits(self.plan, orbits);
            }
            Err(error) => result.ended.push(chain_of_causes(&error)),
        }
    }
}

/// Decides from the first orbit of the branch how the cycle of a Hopf point is born, where the normal form does not: it
/// has no significant sign, or does not hold up to the amplitude of this orbit.
fn fit_birth(found: &SteadyBifurcation, orbit: &PeriodicOrbit, result: &mut Branch) {
    let own = result
        .bifurcations
        .iter_mut()
        .find_map(|other| match other {
            BranchBifurcation::Steady(steady) if *steady == *found => Some(steady),
            _ => None,
        });
    let Some((cycle, speed)) = own.and_then(|own| Some((own.cycle.as_mut()?, own.crossing_speed?)))
    else {
        return;
    };
    let beyond_kinks = cycle
        .smooth_amplitude_m
        .is_some_and(|amplitude| amplitude < orbit.amplitude);
    let offset = orbit.parameter - found.at.value;
    if cycle.criticality != Criticality::Undetermined && !beyond_kinks
        || offset.abs() <= found.location_error
    {
        return;
    }
    cycle.method = CriticalityMethod::FittedBranch;
    // The growth rate of steady sliding where the cycle exists.
    cycle.criticality = match offset * speed > 0.0 {
        true => Criticality::Supercritical,
        false => Criticality::Subcritical,
    };
}

/// Points of a phase portrait.
const PORTRAIT: usize = 240;

/// Displacement (m) and velocity (m/s) at the probe over a period of each orbit of a result.
///
/// # Errors
/// If a system cannot be built, or an integration fails.
pub fn portraits(plan: &BranchPlan, result: &Branch) -> Result<Vec<Vec<[f64; 2]>>, BranchError> {
    let family = SceneFamily::new(plan);
    let options = ContinuationOptions::new(plan.interval, plan.scene.integrator.max_step);
    let portraits = result.points.iter().map(|point| {
        let orbit = &point.orbit;
        let mut steady = family.steady.lock().unwrap_or_else(PoisonError::into_inner);
        let prepared = steady.prepared(&[orbit.parameter])?;
        drop(steady);
        let system = prepared.system.as_ref();
        let mut integrator = Integrator::new(options.method, system)?;
        if system.switching().is_some_and(|s| !s.is_continuous()) {
            integrator = integrator.with_events(system)?;
        }
        let mut z = orbit.state.clone();
        z.resize(system.dim(), 0.0);
        integrator.start(system, 0.0, &z)?;
        let modes = system.modes();
        let samples = (0..=PORTRAIT).map(|k| {
            let time = orbit.period_s * k as f64 / PORTRAIT as f64;
            integrator.sample(system, time, &mut z)?;
            let row = |part: &[f64]| prepared.probe.iter().zip(part).map(|(p, x)| p * x).sum();
            Ok([row(&z[..modes]), row(&z[modes..])])
        });
        samples.collect::<Result<Vec<_>, BranchError>>()
    });
    portraits.collect()
}

/// Why a branch ends inside the interval.
fn ends(orbits: &OrbitBranch, branch: usize, name: &str) -> Vec<String> {
    let places = [orbits.points.first(), orbits.points.last()];
    let ends = orbits.ends.iter().zip(places);
    let reasons = ends.filter_map(|(end, place)| {
        let at = place.map_or(f64::NAN, |orbit| orbit.parameter);
        let why = match end.as_ref()? {
            BranchEnd::ParameterBound => return None,
            BranchEnd::Closed => "it returned to its start".to_owned(),
            BranchEnd::NotConverged { message } => message.clone(),
            BranchEnd::Grazing { guard, .. } => match guard {
                Some(guard) => format!("guard {guard} is grazed"),
                None => "the sequence of events changes".to_owned(),
            },
            BranchEnd::PeriodTooLong { period_s } => format!("the period reached {period_s:.3} s"),
            BranchEnd::Hopf {
                parameter,
                frequency_hz,
            } => {
                format!("it was born in a Hopf bifurcation at {parameter:.6}, {frequency_hz:.2} Hz")
            }
            BranchEnd::PeriodHalved { .. } => "it joins the branch of half its period".to_owned(),
            BranchEnd::MaxPoints => "the maximum number of points was reached".to_owned(),
            BranchEnd::Stopped => "interrupted".to_owned(),
        };
        Some(format!("branch {branch} ends at {name} = {at:.6}: {why}"))
    });
    reasons.collect()
}
