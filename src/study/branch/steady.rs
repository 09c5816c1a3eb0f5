//! Steady states of a scene as functions of its parameters.

use std::sync::Arc;

use super::differences::{Differences, difference};
use crate::dynamics::System;
use crate::dynamics::equilibrium::{Eigenmode, Linearised};
use crate::joint::{BallJoint, LinearMode, NamedMode};
use crate::pipeline::PipelineError;
use crate::scene::{Parameter, Scene};
use crate::study::StudyError;
use crate::study::subject::{SceneSubject, Subject, Trial};

/// Largest relative step of a difference with respect to a parameter.
pub(super) const STEP: f64 = 0.02;

/// The equilibria of systems, such as the steady sliding of a scene, over some parameters.
pub struct SteadyFamily {
    subject: Arc<dyn Subject>,
    /// The joint of the last values; its modes are computed again only if the body changes.
    ball: Option<BallJoint>,
    /// The last equilibrium, from which the next one is found.
    guess: Vec<f64>,
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

impl SteadyFamily {
    /// The steady sliding of a scene over some parameters.
    pub fn new(scene: Scene, parameters: Vec<Parameter>) -> Self {
        Self::of(Arc::new(SceneSubject { scene, parameters }))
    }

    /// The equilibria of any systems.
    pub fn of(subject: Arc<dyn Subject>) -> Self {
        Self {
            subject,
            ball: None,
            guess: Vec::new(),
        }
    }

    /// What is varied.
    pub fn subject(&self) -> &Arc<dyn Subject> {
        &self.subject
    }

    /// The system for some values of the parameters.
    ///
    /// # Errors
    /// If the values are invalid, or the system cannot be built.
    pub fn trial(&mut self, values: &[f64]) -> Result<Trial, PipelineError> {
        self.subject.trial(values, &mut self.ball)
    }

    /// Builds the system for some values of the parameters and linearises it at its equilibrium.
    ///
    /// # Errors
    /// If the values are invalid, the system cannot be built, or it has no equilibrium.
    pub fn at(&mut self, values: &[f64]) -> Result<SteadyState, StudyError> {
        let trial = self.trial(values)?;
        self.linearised(trial)
    }

    /// Builds the system of a variant of the scene and linearises it at its equilibrium.
    ///
    /// # Errors
    /// If the system cannot be built, or it has no equilibrium.
    pub fn at_scene(&mut self, scene: &Scene) -> Result<SteadyState, StudyError> {
        let trial = Trial::of_scene(scene, &mut self.ball)?;
        self.linearised(trial)
    }

    fn linearised(&mut self, trial: Trial) -> Result<SteadyState, StudyError> {
        let prepared = trial.prepared;
        let (system, dim) = (prepared.integrator.into_system(), prepared.state.len());
        if system.modes() == 0 && self.guess.is_empty() {
            self.guess = prepared.state;
        }
        self.guess.resize(dim, 0.0);
        let linearised = Linearised::new(&*system, &self.guess)?;
        self.guess[..linearised.dim()].copy_from_slice(&linearised.state);
        let families = match &self.ball {
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

    /// Slip speed of steady sliding at the centre of the patch of the last joint, at a tilt (rad), m/s; `None` before one.
    pub fn sliding_speed(&self, tilt: f64) -> Option<f64> {
        let velocity = self.ball.as_ref()?.sliding_velocity(tilt);
        Some(velocity.iter().map(|v| v * v).sum::<f64>().sqrt())
    }

    /// Derivative of the scaled matrix with respect to the only parameter, per unit of the scene file; `scale` is the size on
    /// which the parameter changes.
    ///
    /// # Errors
    /// If the matrix cannot be computed on either side of the value.
    pub fn slope(&mut self, value: f64, scale: f64) -> Result<Differences, StudyError> {
        let size = match value.abs() {
            0.0 => scale,
            size => size.min(scale),
        };
        difference(STEP * size, |step| {
            self.at(&[value + step])
                .map(|state| state.linearised.matrix)
        })
    }
}

impl SteadyState {
    /// The modes with their names.
    ///
    /// # Errors
    /// If the eigenvalue iteration does not converge.
    pub fn modes(&self) -> Result<Vec<Eigenmode>, StudyError> {
        Ok(self.linearised.modes()?)
    }

    /// The mode with the name of the mode of the body, or of the component of the state, that has the largest share of it.
    pub fn named(&self, mode: &Eigenmode) -> NamedMode {
        let m = self.system.modes();
        let squares: Vec<f64> = mode.vector.iter().map(|x| x.norm_sqr()).collect();
        let mut shares = squares.clone();
        if m > 0 {
            shares = (0..m).map(|i| squares[i] + squares[m + i]).collect();
        }
        let total: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= total);
        let linear = LinearMode {
            frequency_hz: mode.frequency_hz(),
            growth: mode.value.re,
            shares,
        };
        let named = linear.named(&self.families);
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
        let parts = self
            .probe
            .iter()
            .zip(&mode.vector)
            .zip(&self.linearised.scale);
        let sum: faer::c64 = parts.map(|((probe, x), scale)| *x * (probe / scale)).sum();
        2.0 * sum.norm()
    }
}
