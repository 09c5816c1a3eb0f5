//! Tests of the continuation against closed forms and published values.

mod cyclic;
mod forced;
mod impacts;
mod joint;
mod limit_cycles;
mod lorenz;
mod multipliers;
mod sticking;
mod stop;
mod systems;
mod torus;

use super::flow::Flow;
use super::shape::OrbitSample;
use super::shot::Shot;
use super::*;
use crate::dynamics::{Accuracy, MethodName};

/// Options for small smooth systems: order 8 at a tight tolerance.
fn precise(bounds: [f64; 2], max_step: f64) -> ContinuationOptions {
    ContinuationOptions {
        method: MethodName::Dop853.with(Accuracy::relative(1e-12), max_step),
        newton_tolerance: 1e-10,
        ..ContinuationOptions::new(bounds, max_step)
    }
}

/// States of an orbit at equal intervals, the first one at phase zero.
fn sample_orbit(
    family: &dyn Family,
    orbit: &PeriodicOrbit,
    count: usize,
    options: &ContinuationOptions,
) -> Vec<OrbitSample> {
    let mut flow = Flow::new(family, options).expect("a family");
    let sys = flow.system(orbit.parameter).expect("a system");
    let samples = flow.samples(sys.as_ref(), &Shot::of(orbit), count, false);
    samples.expect("a sound orbit").states
}

/// Follows a branch without watching it.
fn follow(
    family: &dyn Family,
    start: impl Into<BranchStart>,
    options: &ContinuationOptions,
) -> OrbitBranch {
    continue_orbits(family, &start.into(), options, &mut |_| true).expect("an orbit at the start")
}

/// The orbit near a settled motion.
fn settle(
    family: &dyn Family,
    parameter: f64,
    state: &[f64],
    settle_s: f64,
    options: &ContinuationOptions,
) -> PeriodicOrbit {
    let search = ReturnSearch {
        settle_s,
        max_period_s: 100.0,
        tolerance: 0.02,
    };
    settled_orbit(family, parameter, state, &search, options).expect("a periodic motion")
}

/// The bifurcations of one kind.
fn of_kind(branch: &OrbitBranch, kind: BifurcationKind) -> Vec<&Bifurcation> {
    let all = branch.bifurcations.iter();
    all.filter(|bifurcation| bifurcation.kind == kind).collect()
}
