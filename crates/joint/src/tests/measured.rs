//! A measured friction curve in a simulation.

use super::*;
use squeakscope_dynamics::{Accuracy, Integrator, MethodName};

/// The state after 0.3 ms of free vibration.
fn simulated(friction: Friction) -> Vec<f64> {
    let joint = Joint::new(&scattered(20, 5, friction));
    let method = MethodName::Lawson853.with(Accuracy::relative(1e-11), 1e-5);
    let mut run = Integrator::new(method, &joint).unwrap();
    run.start(0.0, &state(&joint, 31)).unwrap();
    run.integrate_to(3e-4).unwrap();
    run.state().to_vec()
}

/// A simulation with a table of Eq. (5) agrees with one with Eq. (5); the difference decreases at least
/// with the second power of the distance of the points.
#[test]
fn simulations_with_a_table_agree_with_the_formula() {
    let Friction::Stribeck { law, radial } = STRIBECK else {
        unreachable!()
    };
    let table = |intervals: u32| {
        let speeds = (0..=intervals).map(|k| f64::from(k) / f64::from(intervals));
        let points = speeds.map(|v| [v, sliding(&law, v)]).collect();
        let law = Arc::new(FrictionTable::new(points, law.creep).unwrap());
        simulated(Friction::Table { law, radial })
    };
    let exact = simulated(STRIBECK);
    let size = exact[5..].iter().map(|v| v.abs()).sum::<f64>();
    let errors = [100, 200, 400].map(|intervals| {
        let difference = table(intervals).into_iter().zip(&exact).skip(5);
        difference.map(|(a, b)| (a - b).abs()).sum::<f64>() / size
    });
    assert!(
        errors[1] < errors[0] / 4.0 && errors[2] < errors[0] / 16.0,
        "{errors:?}"
    );
    assert!(errors[2] < 1e-8, "{errors:?}");
}
