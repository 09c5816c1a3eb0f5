//! The systems of a study over some parameters: their equilibria, and the systems for the continuation of periodic orbits.

use std::cell::RefCell;
use std::sync::Arc;

use faer::Mat;

use crate::dynamics::System;
use crate::dynamics::continuation::{ContinuationOptions, Family, FamilyError, FamilyMember};
use crate::dynamics::equilibrium::{Eigenmode, Linearised, derivative};
use crate::joint::{LinearMode, NamedMode};
use crate::pipeline::PipelineError;
use crate::study::StudyError;
use crate::study::subject::{Subject, Trial};

/// Largest relative step of a difference with respect to a parameter.
const STEP: f64 = 0.02;

/// Systems over some parameters, for example those of a scene.
pub struct SubjectFamily {
    subject: Arc<dyn Subject>,
    /// Names of the parameters.
    names: Vec<String>,
    /// The last equilibrium, from which the next one is found.
    guess: RefCell<Vec<f64>>,
}

/// The system and its linearisation at its equilibrium, for some values of the parameters.
pub struct SteadyState {
    /// The system.
    pub system: Arc<dyn System>,
    /// Row that maps modal coordinates to the displacement of the probe.
    pub probe: Vec<f64>,
    /// The system linearised at the equilibrium.
    pub linearised: Linearised,
    /// Names of the modes of the body, of the modal coordinates, or of the components of the state.
    families: Vec<String>,
}

impl SubjectFamily {
    /// Systems over the parameters of these names.
    pub fn new(subject: Arc<dyn Subject>, names: Vec<String>) -> Self {
        Self {
            subject,
            names,
            guess: RefCell::default(),
        }
    }

    /// The system for some values of the parameters.
    ///
    /// # Errors
    /// If the values are invalid, or the system cannot be built.
    pub fn trial(&self, values: &[f64]) -> Result<Trial, PipelineError> {
        self.subject.trial(&self.names, values)
    }

    /// Builds the system for some values of the parameters and linearises it at its equilibrium.
    ///
    /// # Errors
    /// If the values are invalid, the system cannot be built, or it has no equilibrium.
    pub fn at(&self, values: &[f64]) -> Result<SteadyState, StudyError> {
        self.linearised(self.trial(values)?)
    }

    /// Linearises a system, or one of a variant of the scene, at its equilibrium.
    ///
    /// # Errors
    /// If it has no equilibrium.
    pub(super) fn linearised(&self, trial: Trial) -> Result<SteadyState, StudyError> {
        let prepared = trial.prepared;
        let (system, dim) = (prepared.integrator.into_system(), prepared.state.len());
        let mut guess = self.guess.borrow_mut();
        if system.modes() == 0 && guess.is_empty() {
            *guess = prepared.state;
        }
        guess.resize(dim, 0.0);
        let linearised = Linearised::new(&*system, &guess)?;
        guess[..linearised.dim()].copy_from_slice(&linearised.state);
        let families = match &prepared.ball {
            Some(ball) => ball.family_labels(),
            None if system.modes() > 0 => {
                (1..=system.modes()).map(|k| format!("mode {k}")).collect()
            }
            None => (0..dim).map(|k| format!("z[{k}]")).collect(),
        };
        Ok(SteadyState {
            system,
            probe: prepared.probe,
            linearised,
            families,
        })
    }

    /// Derivative of the scaled matrix with respect to the only parameter, per unit of the scene file; `scale` is the size on
    /// which the parameter changes.
    ///
    /// # Errors
    /// If the matrix cannot be computed on either side of the value.
    pub fn slope(&self, value: f64, scale: f64) -> Result<Mat<f64>, StudyError> {
        let (slope, _) = derivative(first_step(value, scale), |step| {
            self.at(&[value + step])
                .map(|state| state.linearised.matrix)
        })?;
        Ok(slope)
    }

    /// Options of the continuation over an interval of the parameter, with the maximum step of the systems.
    pub(super) fn options(&self, interval: [f64; 2]) -> Result<ContinuationOptions, PipelineError> {
        let max_step = self.trial(&interval[..1])?.max_step;
        Ok(ContinuationOptions::new(interval, max_step))
    }
}

impl Family for SubjectFamily {
    /// The observable is the displacement of the probe, m.
    fn member(&self, parameter: f64) -> Result<FamilyMember, FamilyError> {
        let trial = self.trial(&[parameter])?;
        Ok(FamilyMember {
            system: Box::new(trial.prepared.integrator.into_system()),
            drive_period: trial.drive_period,
            observable: trial.prepared.probe,
        })
    }
}

impl SteadyState {
    /// The mode with the name of the mode of the body, or of the component of the state, that has the largest share of it.
    pub fn named(&self, mode: &Eigenmode) -> NamedMode {
        let m = self.system.modes();
        let named = LinearMode::new(mode, m).named(&self.families);
        NamedMode {
            // Rates of a system without modes have any unit.
            unstable: if m > 0 {
                named.unstable
            } else {
                named.growth > 0.0
            },
            ..named
        }
    }

    /// Displacement of the probe (m) per unit of the amplitude `|w|` of a mode, see
    /// [`FirstLyapunov`](crate::dynamics::equilibrium::FirstLyapunov).
    pub fn probe_amplitude(&self, mode: &Eigenmode) -> f64 {
        let probe = self.probe.iter().zip(&self.linearised.scale);
        let parts = probe.zip(&mode.vector);
        let sum: faer::c64 = parts.map(|((probe, scale), x)| *x * (probe / scale)).sum();
        2.0 * sum.norm()
    }
}

/// Step of the first difference with respect to a parameter with a value; `scale` is the size on which it changes.
pub(super) fn first_step(value: f64, scale: f64) -> f64 {
    STEP * match value.abs() {
        0.0 => scale,
        size => size.min(scale),
    }
}
