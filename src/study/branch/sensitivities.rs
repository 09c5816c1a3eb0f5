//! Sensitivities of the modes of steady sliding to the numbers of a scene.
//!
//! The eigenvalue `lambda` of the linearised system with right eigenvector `x` and left eigenvector `y`, `y* x = 1`,
//! changes with a parameter `p` as `d lambda/dp = y* (dA/dp) x`, without solving another eigenvalue problem. `dA/dp`
//! comes from extrapolated differences of the assembled matrix, which have an error estimate.

use schemars::JsonSchema;
use serde::Serialize;

use super::BranchError;
use super::differences::largest;
use super::steady::SteadyFamily;
use crate::dynamics::equilibrium::eigenvalue_derivative;
use crate::joint::NamedMode;
use crate::scene::Scene;

/// A derivative of the matrix is zero if it is within this multiple of its error.
const ZERO: f64 = 10.0;

/// Sensitivity of a mode to one number of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ParameterSensitivity {
    /// Path of the key in the scene file.
    pub parameter: String,
    /// Unit of the key; empty for a dimensionless number.
    pub unit: String,
    /// Value in the scene, in this unit.
    pub value: f64,
    /// Change of the growth rate with the number, 1/s per unit.
    pub growth_per_unit: f64,
    /// Change of the growth rate if the number increases by 1 %, 1/s; zero for a number that is zero.
    pub growth_per_percent: f64,
    /// Change of the frequency with the number, Hz per unit.
    pub frequency_per_unit: f64,
    /// Change of the frequency per percent: if the number increases by 1 %, Hz; zero for a number that is zero.
    pub frequency_per_percent: f64,
    /// Error estimate of `growth_per_unit`.
    pub error_per_unit: f64,
}

/// A mode and its sensitivities.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ModeSensitivities {
    /// The mode.
    #[serde(flatten)]
    pub mode: NamedMode,
    /// The numbers on which the mode depends, in descending order of the change per 1 %, then per unit.
    pub parameters: Vec<ParameterSensitivity>,
}

/// The sensitivities of all oscillating modes of steady sliding, in ascending order of frequency. `on_progress`
/// receives the share of the work that is done, and returns whether to continue; `None` if it stopped the study.
///
/// # Errors
/// If the system cannot be built or has no equilibrium.
pub fn sensitivities(
    scene: &Scene,
    on_progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Vec<ModeSensitivities>>, BranchError> {
    let (parameters, values): (Vec<_>, Vec<_>) = scene.physical_parameters().into_iter().unzip();
    let scales = vec![1.0; parameters.len()];
    let mut family = SteadyFamily::new(scene.clone(), parameters.clone(), scales);
    let state = family.at(&values)?;
    let mut modes = state.modes()?;
    modes.retain(|mode| mode.oscillates());
    modes.sort_by(|a, b| a.value.im.total_cmp(&b.value.im));
    let lefts: Vec<_> = modes
        .iter()
        .map(|mode| state.linearised.left(mode))
        .collect();
    let mut found: Vec<ModeSensitivities> = modes
        .iter()
        .map(|mode| ModeSensitivities {
            mode: state.named(mode),
            parameters: Vec::new(),
        })
        .collect();
    for (which, parameter) in parameters.iter().enumerate() {
        if !on_progress(which as f64 / parameters.len() as f64) {
            return Ok(None);
        }
        let slope = family.slope(&values, which)?;
        if largest(&slope.value) <= ZERO * slope.error {
            continue;
        }
        for ((mode, left), found) in modes.iter().zip(&lefts).zip(&mut found) {
            let derivative = eigenvalue_derivative(left, &slope.value, &mode.vector);
            let value = values[which];
            let frequency = derivative.im / std::f64::consts::TAU;
            found.parameters.push(ParameterSensitivity {
                parameter: parameter.path().to_owned(),
                unit: parameter.unit().to_owned(),
                value,
                growth_per_unit: derivative.re,
                growth_per_percent: 0.01 * value * derivative.re,
                frequency_per_unit: frequency,
                frequency_per_percent: 0.01 * value * frequency,
                error_per_unit: slope.error * condition(left, &mode.vector),
            });
        }
    }
    for mode in &mut found {
        mode.parameters.sort_by(|a, b| {
            let by_percent = b
                .growth_per_percent
                .abs()
                .total_cmp(&a.growth_per_percent.abs());
            by_percent.then(b.growth_per_unit.abs().total_cmp(&a.growth_per_unit.abs()))
        });
    }
    Ok(Some(found))
}

/// Largest change of the eigenvalue for a matrix entry of size 1.
fn condition(left: &[faer::c64], right: &[faer::c64]) -> f64 {
    let largest = |vector: &[faer::c64]| vector.iter().map(|x| x.norm()).fold(0.0, f64::max);
    largest(left) * largest(right)
}
