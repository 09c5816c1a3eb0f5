//! Steady states of a scene as functions of its parameters.

use super::BranchError;
use super::differences::{Differences, difference};
use crate::dynamics::System;
use crate::dynamics::equilibrium::{Eigenmode, Linearised};
use crate::joint::{BallJoint, LinearMode, NamedMode};
use crate::pipeline::{Prepared, prepare_reusing_body};
use crate::scene::{Parameter, Scene};

/// Largest relative step of a difference with respect to a parameter.
pub(super) const STEP: f64 = 0.02;

/// The steady sliding of a scene, for any values of some of its parameters.
pub struct SteadyFamily {
    scene: Scene,
    parameters: Vec<Parameter>,
    /// Sizes on which each parameter changes, for differences.
    scales: Vec<f64>,
    /// The joint of the last values; its modes are computed again only if the body changes.
    ball: Option<BallJoint>,
    /// The last equilibrium, from which the next one is found.
    guess: Vec<f64>,
}

/// The system and its linearisation at its equilibrium, for some values of the parameters.
pub struct SteadyState {
    /// The system.
    pub system: Box<dyn System + Send>,
    /// Row that maps modal coordinates to the displacement of the probe.
    pub probe: Vec<f64>,
    /// The system linearised at the equilibrium.
    pub linearised: Linearised,
    /// Names of the modes of the body, or of the modal coordinates.
    families: Vec<String>,
}

impl SteadyFamily {
    /// The steady sliding of a scene over some parameters; `scales` are the sizes on which they change, for example
    /// the widths of the intervals that are studied.
    pub fn new(scene: Scene, parameters: Vec<Parameter>, scales: Vec<f64>) -> Self {
        Self {
            scene,
            parameters,
            scales,
            ball: None,
            guess: Vec::new(),
        }
    }

    /// The parameters.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The scene with some values of the parameters, in the units of the scene file.
    ///
    /// # Errors
    /// [`BranchError::Scene`].
    pub fn scene_at(&self, values: &[f64]) -> Result<Scene, BranchError> {
        let pairs: Vec<_> = self
            .parameters
            .iter()
            .copied()
            .zip(values.iter().copied())
            .collect();
        Ok(self.scene.with_values(&pairs)?)
    }

    /// Builds the system for some values of the parameters.
    ///
    /// # Errors
    /// If the values are invalid, or the system cannot be built.
    pub fn prepared(&mut self, values: &[f64]) -> Result<Prepared, BranchError> {
        let scene = self.scene_at(values)?;
        Ok(prepare_reusing_body(&scene, &mut self.ball)?)
    }

    /// Builds the system for some values of the parameters and linearises it at its equilibrium.
    ///
    /// # Errors
    /// If the values are invalid, the system cannot be built, or it has no equilibrium.
    pub fn at(&mut self, values: &[f64]) -> Result<SteadyState, BranchError> {
        let scene = self.scene_at(values)?;
        self.at_scene(&scene)
    }

    /// Builds the system of a variant of the scene and linearises it at its equilibrium.
    ///
    /// # Errors
    /// If the system cannot be built, or it has no equilibrium.
    pub fn at_scene(&mut self, scene: &Scene) -> Result<SteadyState, BranchError> {
        let prepared = prepare_reusing_body(scene, &mut self.ball)?;
        let (system, dim) = (prepared.system, prepared.state.len());
        self.guess.resize(dim, 0.0);
        let linearised = Linearised::new(system.as_ref(), &self.guess)?;
        self.guess[..linearised.dim()].copy_from_slice(&linearised.state);
        let families = match &self.ball {
            Some(ball) => ball.family_labels(),
            None => (1..=system.modes()).map(|k| format!("mode {k}")).collect(),
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

    /// Derivative of the scaled matrix with respect to one of the parameters, per unit of the scene file.
    ///
    /// # Errors
    /// If the matrix cannot be computed on either side of the value.
    pub fn slope(&mut self, values: &[f64], which: usize) -> Result<Differences, BranchError> {
        let here = values[which];
        let size = match here.abs() {
            0.0 => self.scales[which],
            size => size.min(self.scales[which]),
        };
        difference(STEP * size, |step| {
            let mut moved = values.to_vec();
            moved[which] = here + step;
            self.at(&moved).map(|state| state.linearised.matrix)
        })
    }
}

impl SteadyState {
    /// The modes with their names.
    ///
    /// # Errors
    /// If the eigenvalue iteration does not converge.
    pub fn modes(&self) -> Result<Vec<Eigenmode>, BranchError> {
        Ok(self.linearised.modes()?)
    }

    /// The mode with the name of the mode of the body that has the largest share of its energy.
    pub fn named(&self, mode: &Eigenmode) -> NamedMode {
        let m = self.families.len();
        let mut shares: Vec<f64> = (0..m)
            .map(|i| mode.vector[i].norm_sqr() + mode.vector[m + i].norm_sqr())
            .collect();
        let total: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= total);
        let linear = LinearMode {
            frequency_hz: mode.frequency_hz(),
            growth: mode.value.re,
            shares,
        };
        linear.named(&self.families)
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
