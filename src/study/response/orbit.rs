//! The stable periodic orbit that a settled motion follows.
//!
//! The exponents of a periodic orbit are the logarithms of its Floquet multipliers over its period. One period determines
//! them, so that nothing has to be averaged.

use std::sync::Arc;

use super::Run;
use crate::dynamics::continuation::{
    ContinuationOptions, Multiplier, PeriodicOrbit, ReturnSearch, settled_orbit,
};
use crate::dynamics::{Exponent, LyapunovSpectrum};
use crate::scene::Scene;
use crate::study::branch::SubjectFamily;

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

/// The stable orbit of a settled motion of the scene. `None` for another or a silent motion, for a driven one, whose phase at
/// the state is unknown, and for an orbit whose stability is doubtful.
pub(super) fn stable_orbit(scene: Scene, run: &Run<'_>) -> Option<PeriodicOrbit> {
    if run.drive_period.is_some() {
        return None;
    }
    let (system, z) = (run.integrator.system(), &run.z[..]);
    system.differentiable()?;
    // The family has no parameter; its bounds only scale it.
    let options = ContinuationOptions::new([-1.0, 1.0], scene.integrator.max_step);
    let family = SubjectFamily::new(Arc::new(scene), Vec::new());
    let search = ReturnSearch {
        settle_s: 0.0,
        max_period_s: LONGEST * run.period,
        tolerance: RETURN,
    };
    // A motion that does not return is not periodic.
    let orbit = settled_orbit(&family, 0.0, z, &search, &options).ok()?;
    let is_near = distance(system.omega(), z, &orbit) < NEAR;
    let attracts = orbit.stable && decay(&orbit) > MIN_DECAY;
    (attracts && orbit.amplitude > run.silence && is_near).then_some(orbit)
}

/// Rate at which motions approach an orbit, 1/s.
fn decay(orbit: &PeriodicOrbit) -> f64 {
    let multipliers = orbit.nontrivial_multipliers();
    let rates = multipliers.map(|multiplier| -multiplier.growth_per_s(orbit.period_s));
    rates.fold(f64::INFINITY, f64::min)
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
    LyapunovSpectrum {
        exponents: orbit.multipliers.iter().take(count).map(exponent).collect(),
        time: period,
        dimension: orbit.multipliers.len(),
        resolution: error,
        kaplan_yorke: Some(Exponent {
            value: 1.0,
            half_width: error / decay(orbit),
        }),
    }
}
