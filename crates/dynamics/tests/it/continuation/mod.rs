//! Tests of the continuation against closed forms and published values.

mod forced;
mod impacts;
mod limit_cycles;
mod lorenz;
mod sticking;
mod stop;
mod systems;
mod torus;

use squeakscope_dynamics::continuation::*;
use squeakscope_dynamics::{Accuracy, Integrator, MethodName};

/// Options for small smooth systems: order 8 at a tight tolerance.
fn precise(bounds: [f64; 2], max_step: f64) -> ContinuationOptions {
    ContinuationOptions {
        method: MethodName::Dop853.with(Accuracy::relative(1e-12), max_step),
        ..ContinuationOptions::new(bounds, max_step)
    }
}

/// Time (s) and state of an orbit at equal intervals, the first one at phase zero.
fn sample_orbit(
    family: &dyn Family,
    orbit: &PeriodicOrbit,
    count: usize,
    options: &ContinuationOptions,
) -> Vec<(f64, Vec<f64>)> {
    let sys = family.member(orbit.parameter).expect("a system").system;
    let sys = sys.as_ref();
    let mut run = Integrator::new(options.method, sys).expect("a valid method");
    if sys.switching().is_some() {
        run = run.with_events().expect("a system with guards");
    }
    run.start(0.0, &orbit.state).expect("a finite state");
    let times = (0..count).map(|k| orbit.period_s * k as f64 / count as f64);
    times
        .map(|t| {
            let mut z = orbit.state.clone();
            run.sample(t, &mut z).expect("a sound orbit");
            (t, z)
        })
        .collect()
}

/// Follows a branch without watching it.
fn follow(
    family: &dyn Family,
    start: impl Into<BranchStart>,
    options: &ContinuationOptions,
) -> OrbitBranch {
    continue_orbits(family, &start.into(), options, &mut |_| Ok(())).expect("an orbit at the start")
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
