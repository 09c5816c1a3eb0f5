//! Linear prediction for a scene's mechanism before the run: complex eigenvalues and curves.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::Declaration;
use crate::joint::{BallJoint, Joint, NamedMode, is_unstable};
use crate::pipeline::error::PipelineError;
use crate::pipeline::message::{Coupling, MechanismPrediction, PredictedCurves};
use crate::scene::{LoadedJoint, Mechanism, Scene, SmallSystem};
use crate::systems::{MassOnBelt, TwoModesOnBelt};

/// Number of intervals of a computed curve.
pub const POINTS: usize = 120;

/// What a run of a joint is predicted from: the scene, its loading, and the joint at the start.
pub type JointOfRun<'a> = (&'a Scene, &'a LoadedJoint, &'a BallJoint);
/// Adds to the linear modes of a joint what else is predicted for a mechanism.
pub type Predict = fn(&mut MechanismPrediction, JointOfRun<'_>) -> Result<(), PipelineError>;

/// Coefficient of friction versus sliding speed, up to three times the speed of the run, with the operating
/// point.
pub fn friction_curves(
    speed: f64,
    laws: &[&dyn Fn(f64) -> f64],
    names: &'static [&'static str],
) -> PredictedCurves {
    let speeds = (0..=POINTS).map(|k| 3.0 * speed * k as f64 / POINTS as f64);
    let curve = |mu: &&dyn Fn(f64) -> f64| speeds.clone().map(|v| [1e3 * v, mu(v)]).collect();
    PredictedCurves {
        title: "Computed friction curve; dots: steady sliding",
        axes: ["sliding speed, mm/s", "coefficient of friction"],
        names,
        curves: laws.iter().map(curve).collect(),
        marks: laws.iter().map(|mu| [1e3 * speed, mu(speed)]).collect(),
    }
}

/// Sliding speed of a joint at a tilt (rad), m/s.
pub fn sliding_speed(ball: &BallJoint, tilt: f64) -> f64 {
    let velocity = ball.sliding_velocity(tilt);
    velocity.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// The linearised modes of a joint, with their names.
pub fn linear_modes(ball: &BallJoint, joint: &Joint) -> Result<Vec<NamedMode>, PipelineError> {
    let families = ball.family_labels();
    let modes = joint.linear_modes()?.into_iter();
    Ok(modes.map(|mode| mode.named(&families)).collect())
}

/// Prediction for a scene with a joint; `joint` is the joint at the start. `None` if the scene has no
/// mechanism.
///
/// # Errors
/// If eigenvalues do not converge, or the joint with exchanged slope factors cannot be assembled.
pub fn for_joint(
    scene: &Scene,
    tilted: &LoadedJoint,
    ball: &BallJoint,
    joint: &Joint,
) -> Result<Option<Arc<MechanismPrediction>>, PipelineError> {
    let Some(mechanism) = scene.mechanism else {
        return Ok(None);
    };
    let tilt = tilted.loading(0.0).tilt;
    let mut computed = MechanismPrediction {
        modes: linear_modes(ball, joint)?,
        natural_hz: ball.frequencies_hz().first().copied().unwrap_or(0.0),
        tilt: Some(tilt),
        sliding_speed: sliding_speed(ball, tilt),
        ..without_modes(mechanism, scene)
    };
    if let Some(predict) = Declaration::of(mechanism).predict {
        predict(&mut computed, (scene, tilted, ball))?;
    }
    Ok(Some(Arc::new(computed)))
}

/// A prediction without modes.
fn without_modes(mechanism: Mechanism, scene: &Scene) -> MechanismPrediction {
    MechanismPrediction {
        mechanism,
        modes: Vec::new(),
        natural_hz: 0.0,
        tilt: None,
        sliding_speed: 0.0,
        start: scene.start,
        readings: None,
        coupling: None,
        memory: None,
        table: None,
        passes: None,
        torus: None,
        picture: None,
    }
}

/// Prediction for a scene with a small system; `None` if the scene has no mechanism.
pub fn for_small(scene: &Scene, small: &SmallSystem) -> Option<Arc<MechanismPrediction>> {
    let mut computed = without_modes(scene.mechanism?, scene);
    match small {
        SmallSystem::MassOnBelt(system) => {
            computed.sliding_speed = system.belt;
            computed.natural_hz = system.omega / TAU;
            computed.modes = vec![mode(
                "mass on its spring",
                system.small_omega(),
                system.growth(),
            )];
            if system.stribeck.is_some() {
                let mu = |v| MassOnBelt::coefficient(system, v);
                computed.picture = Some(friction_curves(
                    system.belt,
                    &[&mu],
                    &["friction on the belt"],
                ));
            }
        }
        SmallSystem::TwoModesOnBelt(system) => {
            computed.sliding_speed = system.belt;
            computed.natural_hz = system.omega[0].min(system.omega[1]) / TAU;
            let names = ["first coupled mode", "second coupled mode"];
            let modes = system.modes_at(system.mu).into_iter().zip(names);
            computed.modes = modes
                .map(|(m, name)| mode(name, m.omega, m.growth))
                .collect();
            computed.coupling = Some(Coupling {
                mu: system.mu,
                critical: system.critical_mu(),
            });
            computed.picture = Some(flutter(system));
        }
        SmallSystem::ImpactOscillator(_) | SmallSystem::DampedContact(_) => {}
    }
    Some(Arc::new(computed))
}

fn mode(label: &str, omega: f64, growth: f64) -> NamedMode {
    NamedMode {
        label: label.to_owned(),
        frequency_hz: omega / TAU,
        growth,
        unstable: is_unstable(growth, omega),
    }
}

/// Frequencies of the two modes and the growth rate versus the coefficient of friction.
fn flutter(system: &TwoModesOnBelt) -> PredictedCurves {
    let highest = 1.6 * system.critical_mu().unwrap_or(0.0).max(system.mu);
    let along = (0..=POINTS).map(|k| highest.max(0.1) * k as f64 / POINTS as f64);
    let at = |mu: f64| {
        let [first, second] = system.modes_at(mu);
        [first.omega / TAU, second.omega / TAU, second.growth].map(|y| [mu, y])
    };
    let curve = |c: usize| along.clone().map(|mu| at(mu)[c]).collect();
    PredictedCurves {
        title: "Computed frequencies and growth rate of two coupled modes; dots: this run",
        axes: ["coefficient of friction", "frequency, Hz; growth rate, 1/s"],
        names: &["lower frequency", "higher frequency", "growth rate"],
        curves: (0..3).map(curve).collect(),
        marks: at(system.mu).to_vec(),
    }
}
