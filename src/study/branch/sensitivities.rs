//! Sensitivities of the modes of steady sliding to the numbers of a scene.
//!
//! The eigenvalue `lambda` of the linearised system with right eigenvector `x` and left eigenvector `y`, `y* x = 1`,
//! changes with a parameter `p` as `d lambda/dp = y* (dA/dp) x`, without solving another eigenvalue problem. `dA/dp`
//! comes from extrapolated differences of the assembled matrix, which have an error estimate.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::family::{SubjectFamily, first_step};
use crate::dynamics::equilibrium::{derivative, eigenvalue_derivative};
use crate::joint::{BallJoint, BodySpec, Friction, NamedMode};
use crate::scene::{Parameter, Scene, SceneError};
use crate::study::{OnProgress, StudyError, Trial};

/// A derivative of the matrix is zero if it is within this multiple of its error.
const ZERO: f64 = 10.0;

const BALL: &str = "body.ball_diameter_mm";
const SOCKET: &str = "socket.diameter_mm";
const DAMPING: &str = "damping.ratio";

/// Sensitivity of a mode to one number of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ParameterSensitivity {
    /// Path of the key in the scene file; or `clearance_mm`, the diameter of the socket minus that of the ball, of which the
    /// socket changes; or factors on a measured friction curve: `friction.points.level` on all coefficients, and
    /// `friction.points.slope` on their differences from that at the sliding speed.
    pub parameter: String,
    /// Unit of the key; empty for a dimensionless number.
    pub unit: String,
    /// Value in the scene, in this unit.
    pub value: f64,
    /// Change of the growth rate with the number, 1/s per unit.
    pub growth_per_unit: f64,
    /// Change of the growth rate if the number increases by 1 %, 1/s; zero for a number that is zero, but for absent damping
    /// that of a damping ratio of 1 %.
    pub growth_per_percent: f64,
    /// Change of the frequency with the number, Hz per unit.
    pub frequency_per_unit: f64,
    /// Change of the frequency per percent: if the number increases by 1 %, Hz; as for the growth rate.
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

/// A number with its value, and the scene after a change of the number by a step.
struct Number<'a> {
    name: &'static str,
    unit: &'static str,
    value: f64,
    changed: Box<dyn Fn(f64) -> Result<Scene, SceneError> + 'a>,
}

impl<'a> Number<'a> {
    /// All numbers of a scene.
    fn all(scene: &'a Scene) -> Result<Vec<Self>, StudyError> {
        let keys = scene.physical_parameters().into_iter();
        let numbers = keys.map(|(parameter, value)| Self::of_key(scene, parameter, value));
        let mut numbers: Vec<Self> = numbers.collect();
        let Ok(joint) = scene.joint() else {
            return Ok(numbers);
        };
        if let BodySpec::BallOnBeam(body) = &joint.spec.body {
            numbers.retain(|number| ![BALL, SOCKET].contains(&number.name));
            let ball = 1e3 * body.geometry.ball_diameter;
            let value = 1e3 * joint.spec.socket.diameter - ball;
            let socket = scene.parameter(SOCKET)?;
            numbers.push(Self {
                name: "clearance_mm",
                unit: "mm",
                value,
                changed: Box::new(move |step| {
                    scene.with_values(&[(socket, ball + (value + step))])
                }),
            });
        }
        if joint.spec.damping.is_empty() {
            numbers.push(Self::of_key(scene, scene.parameter(DAMPING)?, 0.0));
        }
        if let Friction::Table { law, .. } = &joint.spec.friction {
            let points = law.points();
            let velocity = BallJoint::new(&joint.spec)?.sliding_velocity(joint.tilt.at(0.0));
            let [centre, _] = law.sliding(velocity.iter().map(|v| v * v).sum::<f64>().sqrt());
            for (name, zero) in [
                ("friction.points.level", 0.0),
                ("friction.points.slope", centre),
            ] {
                let changed = move |step: f64| {
                    let moved = points.iter();
                    let moved = moved.map(|[speed, mu]| [*speed, mu + step * (mu - zero)]);
                    scene.with_friction_points(&moved.collect::<Vec<_>>())
                };
                numbers.push(Self {
                    name,
                    unit: "",
                    value: 1.0,
                    changed: Box::new(changed),
                });
            }
        }
        Ok(numbers)
    }

    fn of_key(scene: &'a Scene, parameter: Parameter, value: f64) -> Self {
        Self {
            name: parameter.path(),
            unit: parameter.unit(),
            value,
            changed: Box::new(move |step| scene.with_values(&[(parameter, value + step)])),
        }
    }

    /// What 1 % of the number is.
    fn percent(&self) -> f64 {
        let is_absent_damping = self.name == DAMPING && self.value == 0.0;
        0.01 * if is_absent_damping { 1.0 } else { self.value }
    }
}

/// The sensitivities of all oscillating modes of steady sliding, in ascending order of frequency. `progress`
/// receives the share of the work that is done.
///
/// # Errors
/// [`StudyError::Stopped`]; if the system cannot be built or has no equilibrium.
pub fn sensitivities(
    scene: &Scene,
    progress: OnProgress<'_>,
) -> Result<Vec<ModeSensitivities>, StudyError> {
    let family = SubjectFamily::new(Arc::new(scene.clone()), Vec::new());
    let state = family.linearised(Trial::of_scene(scene.clone())?)?;
    let numbers = Number::all(scene)?;
    let mut modes = state.linearised.modes()?;
    modes.retain(|mode| mode.oscillates());
    modes.sort_by(|a, b| a.value.im.total_cmp(&b.value.im));
    let lefts = modes.iter().map(|mode| state.linearised.left(mode));
    let lefts: Vec<_> = lefts.collect();
    let found = modes.iter().map(|mode| ModeSensitivities {
        mode: state.named(mode),
        parameters: Vec::new(),
    });
    let mut found: Vec<ModeSensitivities> = found.collect();
    for (which, number) in numbers.iter().enumerate() {
        progress(which as f64 / numbers.len() as f64, "sensitivities")?;
        let (slope, error) = derivative(first_step(number.value, 1.0), |step| {
            let state = family.linearised(Trial::of_scene((number.changed)(step)?)?)?;
            Ok::<_, StudyError>(state.linearised.matrix)
        })?;
        if slope.norm_max() <= ZERO * error {
            continue;
        }
        for ((mode, left), found) in modes.iter().zip(&lefts).zip(&mut found) {
            let derivative = eigenvalue_derivative(left, &slope, &mode.vector);
            let frequency = derivative.im / std::f64::consts::TAU;
            found.parameters.push(ParameterSensitivity {
                parameter: number.name.to_owned(),
                unit: number.unit.to_owned(),
                value: number.value,
                growth_per_unit: derivative.re,
                growth_per_percent: number.percent() * derivative.re,
                frequency_per_unit: frequency,
                frequency_per_percent: number.percent() * frequency,
                error_per_unit: error * condition(left, &mode.vector),
            });
        }
    }
    for mode in &mut found {
        mode.parameters.sort_by(|a, b| {
            let [a, b] = [a, b].map(|it| [it.growth_per_percent, it.growth_per_unit].map(f64::abs));
            b[0].total_cmp(&a[0]).then(b[1].total_cmp(&a[1]))
        });
    }
    Ok(found)
}

/// Largest change of the eigenvalue for a matrix entry of size 1.
fn condition(left: &[faer::c64], right: &[faer::c64]) -> f64 {
    let largest = |vector: &[faer::c64]| vector.iter().map(|x| x.norm()).fold(0.0, f64::max);
    largest(left) * largest(right)
}
