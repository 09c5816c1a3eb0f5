//! Computed curves of friction.

use crate::pipeline::message::{CurveQuantity, PredictedCurves};

/// Number of intervals of a computed curve.
pub const POINTS: usize = 120;

/// Coefficient of friction versus sliding speed, up to three times the speed of the run, with the operating
/// point.
pub fn friction_curves(speed: f64, laws: &[&dyn Fn(f64) -> f64]) -> PredictedCurves {
    let speeds = (0..=POINTS).map(|k| 3.0 * speed * k as f64 / POINTS as f64);
    let curve = |mu: &&dyn Fn(f64) -> f64| speeds.clone().map(|v| [1e3 * v, mu(v)]).collect();
    PredictedCurves {
        subject: CurveQuantity::Friction,
        curves: laws.iter().map(curve).collect(),
        marks: laws.iter().map(|mu| [1e3 * speed, mu(speed)]).collect(),
    }
}
