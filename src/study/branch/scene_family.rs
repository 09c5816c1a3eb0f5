//! The systems of a scene over a parameter, for the continuation of periodic orbits.

use std::cell::{RefCell, RefMut};
use std::sync::Arc;

use super::equilibria::BranchPlan;
use super::result::Branch;
use super::steady::SteadyFamily;
use crate::dynamics::continuation::{ContinuationOptions, Family, FamilyError};
use crate::dynamics::{Integrator, System};
use crate::pipeline::{PipelineError, Prepared};
use crate::study::StudyError;

/// Systems over a parameter, for example those of a scene.
pub struct SubjectFamily {
    steady: RefCell<SteadyFamily>,
    last: RefCell<Option<Last>>,
}

/// The last value of the parameter with its probe and the period of its drive.
type Last = (f64, Vec<f64>, Option<f64>);

impl SubjectFamily {
    /// The family of a plan.
    pub fn new(plan: &BranchPlan) -> Self {
        Self {
            steady: SteadyFamily::of(Arc::clone(&plan.subject)).into(),
            last: RefCell::default(),
        }
    }

    /// Options of the continuation over an interval of the parameter, with the maximum step of the systems.
    pub(super) fn options(&self, interval: [f64; 2]) -> Result<ContinuationOptions, PipelineError> {
        let max_step = self.steady().trial(&interval[..1])?.max_step;
        Ok(ContinuationOptions::new(interval, max_step))
    }

    /// The steady states of the family.
    pub(super) fn steady(&self) -> RefMut<'_, SteadyFamily> {
        self.steady.borrow_mut()
    }

    fn built(&self, parameter: f64) -> Result<Prepared, PipelineError> {
        let trial = self.steady().trial(&[parameter])?;
        let probe = trial.prepared.probe.clone();
        *self.last.borrow_mut() = Some((parameter, probe, trial.drive_period));
        Ok(trial.prepared)
    }

    /// What `of` takes from the probe and the period of the drive at a value of the parameter.
    fn take<T>(&self, parameter: f64, of: impl FnOnce(&[f64], Option<f64>) -> T) -> Option<T> {
        let is_last = |last: &Last| last.0 == parameter;
        if !self.last.borrow().as_ref().is_some_and(is_last) {
            self.built(parameter).ok()?;
        }
        let last = self.last.borrow();
        last.as_ref().map(|(_, probe, drive)| of(probe, *drive))
    }
}

impl Family for SubjectFamily {
    fn system(&self, parameter: f64) -> Result<Box<dyn System>, FamilyError> {
        Ok(Box::new(self.built(parameter)?.integrator.into_system()))
    }

    fn drive_period(&self, parameter: f64) -> Option<f64> {
        self.take(parameter, |_, drive| drive)?
    }

    /// The displacement of the probe, m.
    fn observable(&self, parameter: f64, z: &[f64]) -> f64 {
        let displacement = |probe: &[f64], _| probe.iter().zip(z).map(|(row, q)| row * q).sum();
        self.take(parameter, displacement).unwrap_or(f64::NAN)
    }
}

/// Points of a phase portrait.
const PORTRAIT: usize = 240;

/// Displacement (m) and velocity (m/s) at the probe over a period of each orbit of a result.
///
/// # Errors
/// If a system cannot be built, or an integration fails.
pub fn portraits(plan: &BranchPlan, result: &Branch) -> Result<Vec<Vec<[f64; 2]>>, StudyError> {
    let family = SubjectFamily::new(plan);
    let options = family.options(plan.interval)?;
    let portraits = result.points.iter().map(|point| {
        let orbit = &point.orbit;
        let prepared = family.built(orbit.parameter)?;
        let system = prepared.integrator.system();
        let mut integrator = Integrator::new(options.method, system)?;
        if system.switching().is_some_and(|s| !s.is_continuous()) {
            integrator = integrator.with_events()?;
        }
        let mut z = orbit.state.clone();
        z.resize(system.dim(), 0.0);
        integrator.start(0.0, &z)?;
        let modes = system.modes();
        let samples = (0..=PORTRAIT).map(|k| {
            let time = orbit.period_s * k as f64 / PORTRAIT as f64;
            integrator.sample(time, &mut z)?;
            let row = |part: &[f64]| prepared.probe.iter().zip(part).map(|(p, x)| p * x).sum();
            Ok([row(&z[..modes]), row(&z[modes..])])
        });
        samples.collect::<Result<Vec<_>, StudyError>>()
    });
    portraits.collect()
}
