//! Switching between explicit and implicit steps.

use super::reference::extrapolated;
use super::systems::{Duffing, differenced};
use super::*;
use crate::dynamics::Differentiable;

/// A mass on a spring and on a moving belt, whose friction is smooth: it creeps where it sticks.
struct Creeper {
    /// Slip speed at which friction is nearly full, m/s.
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
}

differenced!(Creeper);

const START: [f64; 2] = [0.0, BELT];

fn methods() -> [Method; 3] {
    let [lawson, .., rodas, auto] = adaptive_methods(1e-6, 0.5);
    [lawson, rodas, auto]
}

#[test]
fn it_goes_implicit_where_the_mass_sticks_and_comes_back() {
    let creeper = Creeper { creep: 1e-4 };
    let [lawson, _, auto] = methods();
    let explicit = run(lawson, &creeper, &START, 60.0).tally();
    let mut motion = run(auto, &creeper, &START, 0.0);
    let (mut stuck, mut slipping) = ([0_u32; 2], [0_u32; 2]);
    let mut z = [0.0; 2];
    for k in 1..=6000 {
        motion
            .sample(&creeper, 0.01 * f64::from(k), &mut z)
            .unwrap();
        let implicit = usize::from(motion.is_implicit());
        if Creeper::slip(&z).abs() < 1e-4 {
            stuck[implicit] += 1;
        } else if Creeper::slip(&z).abs() > 0.05 {
            slipping[implicit] += 1;
        }
    }
    let tally = motion.tally();
    assert!(stuck[1] > 5 * stuck[0], "{stuck:?}");
    assert!(slipping[0] > 5 * slipping[1], "{slipping:?}");
    assert!(tally.switches >= 8, "{tally:?}");
    // A Jacobian with its factors is counted as ten calls here.
    let cost = tally.calls + 10 * tally.jacobians;
    assert!(5 * cost < explicit.calls, "{tally:?} {explicit:?}");
}

#[test]
fn all_three_come_to_the_same() {
    let creeper = Creeper { creep: 1e-3 };
    let exact = extrapolated(&creeper, &START, 20.0, 20_000);
    for method in methods() {
        let error = distance(run(method, &creeper, &START, 20.0).state(), &exact);
        assert!(error < 1e-4, "{method:?}: {error:e}");
    }
}

#[test]
fn where_nothing_is_stiff_it_is_the_explicit_method() {
    let [lawson, _, auto] = methods();
    let (lawson, auto) = (
        run(lawson, &Duffing, &Duffing::START, 100.0),
        run(auto, &Duffing, &Duffing::START, 100.0),
    );
    assert_eq!(
        (lawson.state(), lawson.tally()),
        (auto.state(), auto.tally())
    );
}

#[test]
fn a_neighbour_takes_the_same_kind_of_steps() {
    let creeper = Creeper { creep: 1e-3 };
    let [.., auto] = methods();
    let mut motion = run(auto, &creeper, &START, 5.0);
    let there = motion.state().to_vec();
    motion.add_neighbour(&creeper, &there).unwrap();
    let (mut first, mut second) = ([0.0; 2], [0.0; 2]);
    for k in 1..=2000 {
        let t = 5.0 + 0.02 * f64::from(k);
        motion.sample(&creeper, t, &mut first).unwrap();
        motion.sample_neighbour(&creeper, t, &mut second).unwrap();
        assert_eq!(first, second, "the same start, the same steps: at {t}");
    }
    assert!(motion.tally().switches > 4, "{:?}", motion.tally());
}

#[test]
fn exponents_go_through_the_switches() {
    // Strongly attracting: one exponent zero (the phase of the cycle), the other far below.
    let creeper = Creeper { creep: 1e-3 };
    for method in methods() {
        let motion = Integrator::new(method, &creeper).unwrap();
        let mut motion = motion.with_tangents(&creeper, 2, 1).unwrap();
        motion.start(&creeper, 0.0, &START).unwrap();
        motion.land(&creeper, 50.0).unwrap();
        motion.forget_growth();
        motion.land(&creeper, 550.0).unwrap();
        let spectrum = motion.exponents().unwrap();
        let [first, second] = [0, 1].map(|k| spectrum.exponents[k].value);
        assert!(first.abs() < 0.02, "{method:?}: {spectrum:?}");
        assert!(second < -1.0, "{method:?}: {spectrum:?}");
    }
}
