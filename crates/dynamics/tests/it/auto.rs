//! Automatic switching between explicit and implicit steps.

use super::reference::extrapolated;
use super::systems::{Duffing, by_differences};
use super::*;
use squeakscope_dynamics::Differentiable;

/// A mass on a spring and a moving belt with regularised friction: it creeps instead of sticking.
struct Creeper {
    /// Sliding speed at which friction is nearly fully developed, m/s.
    creep: f64,
}

const BELT: f64 = 0.1;

impl Creeper {
    fn slip(z: &[f64]) -> f64 {
        BELT - z[1]
    }
}

impl System for Creeper {
    fn omega(&self) -> &[f64] {
        &[1.0]
    }
    fn force(&self, _t: f64, z: &[f64], out: &mut [f64]) {
        let slip = Self::slip(z);
        let falling = 0.4 + 0.6 * (-slip.abs() / 0.1).exp();
        out[0] = (slip / self.creep).tanh() * falling;
    }
    fn differentiable(&self) -> Option<&dyn Differentiable> {
        Some(self)
    }
    fn is_autonomous(&self) -> bool {
        true
    }
}

by_differences!(Creeper);

const START: [f64; 2] = [0.0, BELT];

fn methods() -> [Method; 3] {
    let [lawson, .., rodas, auto] = adaptive_methods(1e-6, 0.5);
    [lawson, rodas, auto]
}

#[test]
fn implicit_steps_while_the_mass_sticks_explicit_steps_otherwise() {
    let creeper = Creeper { creep: 1e-4 };
    let [lawson, _, auto] = methods();
    let explicit = run(lawson, &creeper, &START, 60.0).stats();
    let mut motion = run(auto, &creeper, &START, 0.0);
    let (mut stuck, mut slipping) = ([0_u32; 2], [0_u32; 2]);
    let mut z = [0.0; 2];
    for k in 1..=6000 {
        motion.sample(0.01 * f64::from(k), &mut z).unwrap();
        let implicit = usize::from(motion.is_implicit());
        if Creeper::slip(&z).abs() < 1e-4 {
            stuck[implicit] += 1;
        } else if Creeper::slip(&z).abs() > 0.05 {
            slipping[implicit] += 1;
        }
    }
    let stats = motion.stats();
    assert!(stuck[1] > 5 * stuck[0], "{stuck:?}");
    assert!(slipping[0] > 5 * slipping[1], "{slipping:?}");
    assert!(stats.switches >= 8, "{stats:?}");
    // A Jacobian with its factorisation counts as ten evaluations.
    let cost = stats.rhs_evals + 10 * stats.jacobians;
    assert!(5 * cost < explicit.rhs_evals, "{stats:?} {explicit:?}");
}

#[test]
fn explicit_implicit_and_automatic_steps_agree() {
    let creeper = Creeper { creep: 1e-3 };
    let exact = extrapolated(&creeper, &START, 20.0, 20_000);
    for method in methods() {
        let error = distance(run(method, &creeper, &START, 20.0).state(), &exact);
        assert!(error < 1e-4, "{method:?}: {error:e}");
    }
}

#[test]
fn without_stiffness_all_steps_are_explicit() {
    let [lawson, _, auto] = methods();
    let (lawson, auto) = (
        run(lawson, &Duffing, &Duffing::START, 100.0),
        run(auto, &Duffing, &Duffing::START, 100.0),
    );
    assert_eq!(
        (lawson.state(), lawson.stats()),
        (auto.state(), auto.stats())
    );
}

#[test]
fn a_perturbed_trajectory_takes_the_same_method_at_each_step() {
    let creeper = Creeper { creep: 1e-3 };
    let [.., auto] = methods();
    let mut motion = run(auto, &creeper, &START, 5.0);
    let initial = motion.state().to_vec();
    motion.add_perturbed(&initial).unwrap();
    let (mut first, mut second) = ([0.0; 2], [0.0; 2]);
    for k in 1..=2000 {
        let t = 5.0 + 0.02 * f64::from(k);
        motion.sample(t, &mut first).unwrap();
        motion.sample_perturbed(t, &mut second).unwrap();
        assert_eq!(
            first, second,
            "identical initial states must stay identical, at {t}"
        );
    }
    assert!(motion.stats().switches > 4, "{:?}", motion.stats());
}

#[test]
fn exponents_are_correct_across_method_switches() {
    // Strongly attracting limit cycle: one zero exponent (the phase), the other strongly negative.
    let creeper = Creeper { creep: 1e-3 };
    for method in methods() {
        let motion = Integrator::new(method, &creeper).unwrap();
        let mut motion = motion.with_tangents(2, 1).unwrap();
        motion.start(0.0, &START).unwrap();
        motion.integrate_to(50.0).unwrap();
        motion.reset_growth();
        motion.integrate_to(550.0).unwrap();
        let spectrum = motion.exponents().unwrap();
        let [first, second] = [0, 1].map(|k| spectrum.exponents[k].value);
        assert!(first.abs() < 0.02, "{method:?}: {spectrum:?}");
        assert!(second < -1.0, "{method:?}: {spectrum:?}");
    }
}
