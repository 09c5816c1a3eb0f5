//! The ball joint over its tilt: the tone of 4.1 kHz and the torus that is born from it.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use squeakscope::dynamics::continuation::{
    BifurcationKind, BranchEnd, ContinuationOptions, Family, FamilyError, FamilyMember, Multiplier,
    OrbitBranch, PeriodicOrbit, ReturnSearch, continue_orbits, settled_orbit,
};
use squeakscope::dynamics::{Accuracy, Integrator, MethodName, System};
use squeakscope::joint::BallJoint;
use squeakscope::scene::Scene;

/// The joint of a scene over the tilt in degrees; the observable is the displacement of the central contact point.
struct TiltFamily {
    ball: BallJoint,
}

impl TiltFamily {
    /// With the number of nodes for which the numbers of a test were found.
    fn of_scene(name: &str, nodes: usize) -> Self {
        let scene = Scene::load(name).unwrap();
        let mut spec = scene.joint().unwrap().spec.clone();
        spec.contact.nodes = nodes;
        Self {
            ball: BallJoint::new(&spec).unwrap(),
        }
    }
}

impl Family for TiltFamily {
    fn member(&self, tilt_deg: f64) -> Result<FamilyMember, FamilyError> {
        let joint = self.ball.joint(tilt_deg.to_radians())?;
        Ok(FamilyMember {
            drive_period: None,
            observable: joint.probe().to_vec(),
            system: Box::new(joint),
        })
    }
}

fn joint_options() -> ContinuationOptions {
    let max_step = 2e-5;
    ContinuationOptions {
        method: MethodName::Lawson54.with(Accuracy::relative(1e-8), max_step),
        ..ContinuationOptions::new([0.0, 8.0], max_step)
    }
}

/// The orbit of the motion 300 ms after a random kick of the modal velocities.
fn tone(
    family: &TiltFamily,
    tilt_deg: f64,
    [kick, tolerance]: [f64; 2],
    seed: u64,
) -> PeriodicOrbit {
    let sys = family.member(tilt_deg).unwrap().system;
    let m = sys.modes();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut z = vec![0.0; sys.dim()];
    for v in &mut z[m..2 * m] {
        *v = kick * rng.random_range(-1.0..1.0);
    }
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-5), 1e-4);
    let mut run = Integrator::new(method, sys.as_ref()).unwrap();
    run.start(0.0, &z).unwrap();
    run.integrate_to(0.3).unwrap();
    let search = ReturnSearch {
        settle_s: 0.0,
        max_period_s: 2e-3,
        tolerance,
    };
    settled_orbit(family, tilt_deg, run.state(), &search, &joint_options()).expect("a tone")
}

fn follow(family: &TiltFamily, start: PeriodicOrbit) -> OrbitBranch {
    continue_orbits(family, &start.into(), &joint_options(), &mut |_| Ok(()))
        .expect("an orbit at the start")
}

/// The largest distance of a multiplier from the eigenvalues of a monodromy matrix by central differences of the plain
/// method of order 8.
fn distance_from_differences(family: &TiltFamily, orbit: &PeriodicOrbit) -> f64 {
    let sys = family.member(orbit.parameter).unwrap().system;
    let sys = sys.as_ref();
    let (n, m) = (sys.tangent_dim(), sys.modes());
    let method = MethodName::Dop853.with(Accuracy::relative(1e-12), 1e-5);
    let end = |z: &[f64]| {
        let mut run = Integrator::new(method, sys).unwrap();
        run.start(0.0, z).unwrap();
        run.integrate_to(orbit.period_s).unwrap();
        run.state().to_vec()
    };
    let speed = orbit.component_amplitudes[m..]
        .iter()
        .fold(0.0_f64, |max, v| max.max(*v));
    let unit = |i: usize| if i < m { speed / sys.omega()[i] } else { speed };
    let mut monodromy = DMatrix::zeros(n, n);
    for j in 0..n {
        let step = 1e-5 * unit(j);
        let [ahead, behind] = [step, -step].map(|by| {
            let mut z = orbit.state.clone();
            z[j] += by;
            end(&z)
        });
        for i in 0..n {
            let slope = (ahead[i] - behind[i]) / (2.0 * step);
            monodromy[(i, j)] = slope * unit(j) / unit(i);
        }
    }
    let eigenvalues = monodromy.complex_eigenvalues();
    let distance = |multiplier: &Multiplier| {
        let all = eigenvalues.iter();
        all.map(|z| (z.re - multiplier.re()).hypot(z.im - multiplier.im()))
            .fold(f64::INFINITY, f64::min)
    };
    orbit.multipliers.iter().map(distance).fold(0.0, f64::max)
}

/// The branch of the scene `periodic-2deg` over 0 to 8 degrees takes 0.9 s, as long as 2.5 runs of 300 ms. Simulations of 1 s
/// from next to the orbit grow at -5.4656, -0.5373, 0.5354 and 5.174 1/s at -0.2, -0.02, 0.02 and 0.2 degrees from the
/// Neimark-Sacker point; the multipliers give -5.4664, -0.5358, 0.5334 and 5.228 1/s.
#[test]
fn the_tone_of_the_joint_has_the_multipliers_of_finite_differences_and_becomes_a_torus() {
    let family = TiltFamily::of_scene("periodic-2deg", 100);
    let orbit = tone(&family, 2.0, [1e-5, 0.05], 6);
    assert!(
        (orbit.frequency_hz() - 4110.813).abs() < 0.01,
        "{}",
        orbit.frequency_hz()
    );
    assert!(orbit.stable && orbit.trivial_multiplier_error.unwrap() < 1e-7);
    let error = distance_from_differences(&family, &orbit);
    assert!(error < 1e-6, "{error:e}");
    let branch = follow(&family, orbit.clone());
    assert_eq!(
        branch.ends,
        [
            Some(BranchEnd::ParameterBound),
            Some(BranchEnd::ParameterBound)
        ]
    );
    assert!(branch.unresolved.is_empty());
    assert!(
        branch.newton_iterations <= 60,
        "{}",
        branch.newton_iterations
    );
    assert_eq!(branch.bifurcations.len(), 1);
    let torus = &branch.bifurcations[0];
    assert_eq!(torus.kind, BifurcationKind::NeimarkSacker);
    assert!(
        (torus.parameter - 6.778_622_6).abs() < 1e-5,
        "{}",
        torus.parameter
    );
    assert!((torus.torus_frequency_hz.unwrap() - 268.0087).abs() < 1e-3);
    // The exponents of a long simulation.
    let sys = family.member(2.0).unwrap().system;
    let method = MethodName::Lawson54.with(Accuracy::relative(1e-7), 1e-4);
    let mut run = Integrator::new(method, sys.as_ref())
        .and_then(|run| run.with_tangents(3, 1))
        .unwrap();
    run.start(0.0, &orbit.state).unwrap();
    run.integrate_to(0.1).unwrap();
    run.reset_growth();
    run.integrate_to(0.3).unwrap();
    let spectrum = run.exponents().unwrap();
    for (exponent, multiplier) in spectrum.exponents.iter().zip(&orbit.multipliers) {
        let growth = multiplier.growth_per_s(orbit.period_s);
        assert!(
            (exponent.low()..=exponent.high()).contains(&growth),
            "{exponent:?} {growth}"
        );
    }
}

/// The tone of the family of `doubled-torus-3deg` becomes a torus at 0.347 degrees, with a second frequency of 0.241 kHz: the lines of
/// the simulated torus are at 4.11 kHz, 3.87 kHz and their difference 0.24 kHz.
#[test]
fn the_torus_of_the_joint_is_born_with_its_observed_frequencies() {
    let family = TiltFamily::of_scene("doubled-torus-3deg", 100);
    let orbit = tone(&family, 0.0, [1e-3, 0.2], 1);
    let branch = follow(&family, orbit);
    let all = branch.bifurcations.iter();
    let mut tori = all.filter(|found| found.kind == BifurcationKind::NeimarkSacker);
    let torus = tori.next().expect("a Neimark-Sacker point");
    assert!(tori.next().is_none(), "{:?}", branch.bifurcations.len());
    assert!(
        (torus.parameter - 0.346_857).abs() < 1e-4,
        "{}",
        torus.parameter
    );
    assert!((torus.frequency_hz - 4104.27).abs() < 0.1);
    assert!((torus.torus_frequency_hz.unwrap() - 240.98).abs() < 0.1);
    assert!(branch.unresolved.is_empty());
}

/// The tone of 573 Hz in scene `paper` exists between two folds only, at 0.3334459 and 0.9098432 degrees, where a motion
/// that attracts meets one that repels: the branch returns to its first orbit.
#[test]
fn the_branch_between_two_folds_of_the_joint_is_closed() {
    let family = TiltFamily::of_scene("paper", 28);
    let orbit = tone(&family, 0.75, [1e-5, 0.02], 1);
    assert!((orbit.frequency_hz() - 572.92).abs() < 0.01 && orbit.stable);
    let options = ContinuationOptions {
        bounds: [0.3, 0.95],
        ..joint_options()
    };
    let start = orbit.into();
    let branch = continue_orbits(&family, &start, &options, &mut |_| Ok(())).unwrap();
    assert_eq!(branch.ends, [Some(BranchEnd::Closed), None]);
    // Every change of the number of multipliers outside the unit circle is that of a fold.
    assert!(branch.unresolved.is_empty());
    assert_eq!(branch.bifurcations.len(), 2);
    for (fold, parameter) in branch.bifurcations.iter().zip([0.909_843_2, 0.333_445_9]) {
        assert_eq!(fold.kind, BifurcationKind::Fold);
        assert!((fold.parameter - parameter).abs() < 1e-5);
        assert_eq!(fold.unstable_change.abs(), 1);
    }
}
