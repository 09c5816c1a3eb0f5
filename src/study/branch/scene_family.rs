//! The systems of a scene over a parameter, for the continuation of periodic orbits.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::BranchError;
use super::equilibria::BranchPlan;
use super::result::Branch;
use super::steady::SteadyFamily;
use crate::dynamics::continuation::{ContinuationOptions, Family, FamilyError};
use crate::dynamics::{Integrator, System};
use crate::scene::SystemSpec;

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

    /// The steady states of the family.
    pub(super) fn steady(&self) -> MutexGuard<'_, SteadyFamily> {
        self.steady.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Family for SceneFamily {
    fn system(&self, parameter: f64) -> Result<Box<dyn System + Send>, FamilyError> {
        let prepared = self.steady().prepared(&[parameter])?;
        *self.probe.lock().unwrap_or_else(PoisonError::into_inner) =
            Some((parameter, prepared.probe));
        Ok(prepared.system)
    }

    fn drive_period(&self, parameter: f64) -> Option<f64> {
        match self.steady().scene_at(&[parameter]).ok()?.subject {
            SystemSpec::Small(system) => system.drive_period(),
            SystemSpec::Joint(_) => None,
        }
    }

    /// The displacement of the probe, m.
    fn observable(&self, parameter: f64, z: &[f64]) -> f64 {
        let mut kept = self.probe.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.as_ref().is_none_or(|(value, _)| *value != parameter) {
            match self.steady().prepared(&[parameter]) {
                Ok(prepared) => *kept = Some((parameter, prepared.probe)),
                Err(_) => return f64::NAN,
            }
        }
        let probe = kept.iter().flat_map(|(_, probe)| probe);
        probe.zip(z).map(|(row, q)| row * q).sum()
    }
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
        let prepared = family.steady().prepared(&[orbit.parameter])?;
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
