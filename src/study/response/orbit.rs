//! The stable periodic orbit that a settled motion follows.
//!
//! The exponents of a periodic orbit are the logarithms of its Floquet multipliers over its period. One period determines
//! them, so that nothing has to be averaged.

use std::cell::RefCell;

use crate::dynamics::continuation::{
    ContinuationOptions, Family, FamilyError, Multiplier, PeriodicOrbit, ReturnSearch,
    settled_orbit,
};
use crate::dynamics::{Exponent, LyapunovSpectrum, System};
use crate::joint::BallJoint;
use crate::pipeline::prepare_reusing_body;
use crate::scene::{Scene, SystemSpec};

/// Distance from its start at which a motion has returned, relative to its size.
const RETURN: f64 = 0.02;
/// Largest distance between the settled motion and the orbit, relative to the size of the orbit. The motion and the orbit are
/// integrated with different tolerances.
const NEAR: f64 = 1e-2;
/// Minimum rate at which motions approach the orbit, 1/s. Close to a bifurcation the orbit attracts from its immediate
/// neighbourhood only, or the motion has not reached it yet.
const MIN_DECAY: f64 = 1.0;
/// Smallest error that is stated for a multiplier.
const MIN_ERROR: f64 = 1e-6;
/// Longest period, in periods of the slowest mode.
const LONGEST: f64 = 5.0;

/// A scene as a family of one system.
struct OneScene<'a> {
    scene: &'a Scene,
    ball: RefCell<&'a mut Option<BallJoint>>,
    probe: &'a [f64],
}

impl Family for OneScene<'_> {
    fn system(&self, _parameter: f64) -> Result<Box<dyn System>, FamilyError> {
        let prepared = prepare_reusing_body(self.scene, &mut self.ball.borrow_mut())?;
        Ok(Box::new(prepared.integrator.into_system()))
    }

    /// The motion of a driven system is no orbit of this search: see [`stable_orbit`].
    fn drive_period(&self, _parameter: f64) -> Option<f64> {
        None
    }

    /// The displacement of the probe, m.
    fn observable(&self, _parameter: f64, z: &[f64]) -> f64 {
        self.probe.iter().zip(z).map(|(row, q)| row * q).sum()
    }
}

/// The stable orbit of a settled motion of the scene's system in the state `z`, with a displacement of the probe above
/// `silence` (m). `None` for another motion, for a driven one, whose phase at the state is unknown, and for an orbit whose
/// stability is doubtful. `slowest` is the period of the slowest mode, s.
pub(super) fn stable_orbit(
    scene: &Scene,
    ball: &mut Option<BallJoint>,
    system: &dyn System,
    [z, probe]: [&[f64]; 2],
    slowest: f64,
    silence: f64,
) -> Option<PeriodicOrbit> {
    if matches!(&scene.subject, SystemSpec::Small(system) if system.drive_period().is_some()) {
        return None;
    }
    system.differentiable()?;
    let family = OneScene {
        scene,
        ball: RefCell::new(ball),
        probe,
    };
    let search = ReturnSearch {
        settle_s: 0.0,
        max_period_s: LONGEST * slowest,
        tolerance: RETURN,
    };
    // The family has no parameter; its bounds only scale it.
    let options = ContinuationOptions::new([-1.0, 1.0], scene.integrator.max_step);
    // A motion that does not return is not periodic.
    let orbit = settled_orbit(&family, 0.0, z, &search, &options).ok()?;
    let rate = orbit
        .nontrivial_multipliers()
        .map(|multiplier| multiplier.growth_per_s(orbit.period_s))
        .fold(f64::NEG_INFINITY, f64::max);
    let is_near = distance(system.omega(), z, &orbit) < NEAR;
    (orbit.stable && rate < -MIN_DECAY && orbit.amplitude > silence && is_near).then_some(orbit)
}

/// Distance between a state and phase zero of an orbit in the norm of the energy, relative to the size of the orbit.
fn distance(omega: &[f64], z: &[f64], orbit: &PeriodicOrbit) -> f64 {
    let units = |i: usize| omega.get(i).copied().unwrap_or(1.0);
    let norm = |value: &dyn Fn(usize) -> f64| {
        let squares = (0..orbit.state.len()).map(|i| (units(i) * value(i)).powi(2));
        squares.sum::<f64>().sqrt()
    };
    norm(&|i| z[i] - orbit.state[i]) / norm(&|i| orbit.component_amplitudes[i])
}

/// The leading `count` exponents of an orbit. Their intervals are twice the error of the trivial multiplier, and at least
/// [`MIN_ERROR`].
pub(super) fn exponents(orbit: &PeriodicOrbit, count: usize) -> LyapunovSpectrum {
    let period = orbit.period_s;
    let trivial = orbit.trivial_multiplier_error.unwrap_or(f64::INFINITY);
    let error = (2.0 * trivial).max(MIN_ERROR) / period;
    let exponent = |multiplier: &Multiplier| Exponent {
        value: multiplier.growth_per_s(period),
        half_width: error,
    };
    let contraction = orbit
        .nontrivial_multipliers()
        .map(|multiplier| -multiplier.growth_per_s(period))
        .fold(f64::INFINITY, f64::min);
    LyapunovSpectrum {
        exponents: orbit.multipliers.iter().take(count).map(exponent).collect(),
        time: period,
        dimension: orbit.multipliers.len(),
        resolution: error,
        kaplan_yorke: Some(Exponent {
            value: 1.0,
            half_width: error / contraction,
        }),
    }
}
