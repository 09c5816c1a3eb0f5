//! Values of the quantities in one run.

use super::quantity::Quantity;
use crate::analysis::Regime;
use crate::chain_of_causes;
use crate::joint::BallJoint;
use crate::pipeline::prepare_reusing_body;
use crate::scene::Scene;
use crate::study::cost::baseline::CostError;
use crate::study::response::{InitialState, ResponsePlan, SettledResponse, response};
use crate::study::stability;

/// Steps and range of the search for the border, deg; accuracy of its bisection, deg.
const BORDER_STEP: f64 = 0.25;
const BORDER_RANGE: f64 = 10.0;
const BORDER_ACCURACY: f64 = 1e-10;

/// Longest transient of a motion that starts with the kick of the scene, s.
const MAX_TRANSIENT: f64 = 0.4;

/// How a motion is run and measured.
#[derive(Clone, Copy)]
pub struct Window<'a> {
    /// State `[q | dq/dt]` at the start.
    pub start: &'a [f64],
    /// Time before the measurement, s.
    pub settling: f64,
    /// Measurement time, s.
    pub time: f64,
}

/// Values of the quantities in one run.
#[derive(Clone, Debug)]
pub struct Observation {
    /// The quantities, or the reasons why they are not defined.
    pub values: Vec<Result<f64, String>>,
    /// Half-widths of their 95 % statistical intervals; 0 if there is none.
    pub half_widths: Vec<f64>,
    /// Final state; empty if nothing was simulated.
    pub state: Vec<f64>,
    /// Right-hand-side evaluations per simulated second, 1/s.
    pub rhs_evals: f64,
}

impl Observation {
    /// A run that failed.
    fn failed(quantities: usize, reason: &str) -> Self {
        Self {
            values: vec![Err(reason.to_owned()); quantities],
            half_widths: vec![0.0; quantities],
            state: Vec::new(),
            rhs_evals: 0.0,
        }
    }

    /// Whether no quantity is known.
    pub fn has_failed(&self) -> bool {
        self.values.iter().all(Result::is_err)
    }
}

/// Runs a scene and measures the quantities. A run that fails leaves the quantities of the motion undefined.
/// Returns `None` if stopped.
pub fn observe(
    scene: &Scene,
    quantities: &[Quantity],
    window: &Window<'_>,
    ball: &mut Option<BallJoint>,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Option<Observation>, CostError> {
    let with_motion = quantities.iter().any(|quantity| !quantity.is_linear());
    let run = match with_motion {
        true => motion(scene, quantities, window, ball, should_continue),
        false => prepare_reusing_body(scene, ball)
            .map(|_| None)
            .map_err(CostError::from),
    };
    let motion = match run {
        Ok(None) if with_motion => return Ok(None),
        Ok(found) => found.ok_or_else(String::new),
        // A level that cannot be built or integrated, such as a step that is too long.
        Err(error @ (CostError::Settled(_) | CostError::System(_))) => {
            let reason = chain_of_causes(&error);
            return Ok(Some(Observation::failed(quantities.len(), &reason)));
        }
        Err(error) => return Err(error),
    };
    let mut half_widths = vec![0.0; quantities.len()];
    let mut values = Vec::new();
    for (quantity, half_width) in quantities.iter().zip(&mut half_widths) {
        values.push(match (quantity, &motion) {
            (Quantity::Growth, _) => growth(scene, ball, None)?,
            (Quantity::Border, _) => border(scene, ball)?,
            (_, Err(reason)) => Err(reason.clone()),
            (Quantity::Lyapunov, Ok(found)) => lyapunov(found, half_width),
            (_, Ok(found)) => of_motion(*quantity, found),
        });
    }
    let (state, rhs_evals) = match motion {
        Ok(found) => {
            let simulated = found.transient + window.time;
            (found.state, found.stats.rhs_evals as f64 / simulated)
        }
        Err(_) => (Vec::new(), 0.0),
    };
    Ok(Some(Observation {
        values,
        half_widths,
        state,
        rhs_evals,
    }))
}

/// The settled motion from the state of the window. A scene with other modes starts with its own kick.
fn motion(
    scene: &Scene,
    quantities: &[Quantity],
    window: &Window<'_>,
    ball: &mut Option<BallJoint>,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Option<SettledResponse>, CostError> {
    let modes = prepare_reusing_body(scene, ball)?.system.modes();
    let same = window.start.len() == 2 * modes;
    let plan = ResponsePlan {
        min_transient: window.settling,
        max_transient: window.settling + if same { 0.0 } else { MAX_TRANSIENT },
        measurement_time: window.time,
        exponents: usize::from(quantities.contains(&Quantity::Lyapunov)),
        orbits: false,
        portrait: false,
        max_rhs_evals: None,
    };
    let from = match same {
        true => InitialState::State(window.start),
        false => InitialState::Fresh,
    };
    Ok(response(scene, from, &plan, ball, &mut |_| {
        should_continue()
    })?)
}

/// A quantity of the motion. Only a periodic motion or a torus has lines and an amplitude that converges.
fn of_motion(quantity: Quantity, found: &SettledResponse) -> Result<f64, String> {
    let has_lines = matches!(found.regime, Regime::Periodic | Regime::QuasiPeriodic);
    match quantity {
        _ if found.regime == Regime::Silent => Err("the motion is at rest".to_owned()),
        Quantity::Rms => Ok(found.rms_velocity),
        _ if !has_lines => Err(format!(
            "the motion is {}: its largest displacement does not converge with the averaging time, and no line \
             is exact",
            found.regime
        )),
        Quantity::Frequency => {
            let line = found.lines.first().map(|line| line.frequency);
            line.ok_or_else(|| "the spectrum has no line".to_owned())
        }
        _ => Ok(found.amplitude),
    }
}

/// The largest exponent; `half_width` receives its statistical interval.
fn lyapunov(found: &SettledResponse, half_width: &mut f64) -> Result<f64, String> {
    let exponent = found
        .exponents
        .as_ref()
        .and_then(|found| found.exponents.first());
    let exponent = exponent.ok_or_else(|| "the averaging time is too short".to_owned())?;
    *half_width = exponent.half_width;
    match exponent.value.abs() > exponent.half_width {
        true => Ok(exponent.value),
        false => Err(format!(
            "the exponent {:.1} 1/s is zero within its 95 % interval of {:.1} 1/s, and has no relative error",
            exponent.value, exponent.half_width
        )),
    }
}

/// Largest growth rate, 1/s, at a tilt (rad), or at that of the scene.
fn growth(
    scene: &Scene,
    ball: &Option<BallJoint>,
    tilt: Option<f64>,
) -> Result<Result<f64, String>, CostError> {
    let (Ok(joint), Some(ball)) = (scene.joint(), ball) else {
        return Ok(Err(
            "only the joint has linear modes of steady sliding".to_owned()
        ));
    };
    let tilt = tilt.unwrap_or(joint.tilt.at(0.0));
    let modes = stability(ball, &[tilt])?;
    let rates = modes
        .iter()
        .flat_map(|at| &at.modes)
        .map(|mode| mode.growth);
    Ok(rates
        .reduce(f64::max)
        .ok_or_else(|| "the joint has no modes".to_owned()))
}

/// The tilt, deg, nearest to that of the scene at which the largest growth rate changes sign, by bisection.
fn border(scene: &Scene, ball: &Option<BallJoint>) -> Result<Result<f64, String>, CostError> {
    let joint = match scene.joint() {
        Ok(joint) => joint,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let own = joint.tilt.at(0.0).to_degrees();
    let is_unstable = |tilt: f64| -> Result<bool, CostError> {
        Ok(growth(scene, ball, Some(tilt.to_radians()))?.is_ok_and(|rate| rate > 0.0))
    };
    let here = is_unstable(own)?;
    let steps = (BORDER_RANGE / BORDER_STEP) as usize;
    for step in 1..=steps {
        for side in [1.0, -1.0] {
            let mut outside = own + side * BORDER_STEP * step as f64;
            if is_unstable(outside)? == here {
                continue;
            }
            let mut inside = outside - side * BORDER_STEP;
            while (outside - inside).abs() > BORDER_ACCURACY {
                let middle = 0.5 * (inside + outside);
                match is_unstable(middle)? == here {
                    true => inside = middle,
                    false => outside = middle,
                }
            }
            return Ok(Ok(0.5 * (inside + outside)));
        }
    }
    Ok(Err(format!(
        "the stability of steady sliding does not change within {BORDER_RANGE} deg of the tilt"
    )))
}
