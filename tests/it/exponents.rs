//! Lyapunov exponents of the scenes: zero on limit cycles and tori, positive in chaos.

use squeakscope::dynamics::{Attractor, Exponent, Motion, Sign};
use squeakscope::scene::{Scene, Schedule};
use squeakscope::study::lyapunov::{
    FULL_SPECTRUM_TOLERANCE, Goal, LyapunovRequest, LyapunovResult, scene_lyapunov,
};

fn follow(scene: Scene, count: Option<usize>, goal: Goal) -> LyapunovResult {
    let request = LyapunovRequest {
        count,
        settle: None,
        goal,
        tolerance: None,
    };
    scene_lyapunov(&scene, &request, &mut |_, _| Ok(())).expect("done")
}

fn scene(name: &str) -> Scene {
    Scene::load(name).expect("preset")
}

/// Signs of the computed exponents, with the exponents for assertion messages.
fn signs(found: &LyapunovResult) -> (Vec<Sign>, &[Exponent]) {
    let spectrum = &found.study.spectrum;
    let signs = (0..spectrum.exponents.len()).map(|k| spectrum.sign(k));
    (signs.collect(), &spectrum.exponents)
}

/// A limit cycle has one zero exponent; the others are negative.
#[test]
fn cycles_have_one_zero_exponent() {
    for name in ["periodic-2deg", "mode-shift-3.5deg"] {
        let found = follow(scene(name), Some(3), Goal::Time(0.65));
        let (signs, exponents) = signs(&found);
        let expected = [Sign::Zero, Sign::Negative, Sign::Negative];
        assert_eq!(signs, expected, "{name}: {exponents:?}");
        assert_eq!(found.study.spectrum.attractor(), Attractor::Cycle, "{name}");
    }
}

/// A torus has two zero exponents, and none is undetermined.
#[test]
fn a_torus_has_two_zero_exponents() {
    let found = follow(scene("doubled-torus-3deg"), Some(4), Goal::Classification);
    let (signs, exponents) = signs(&found);
    let expected = [Sign::Zero, Sign::Zero, Sign::Negative, Sign::Negative];
    assert_eq!(signs, expected, "{exponents:?}");
    assert_eq!(found.study.spectrum.attractor(), Attractor::Torus(2));
}

/// The scene `chaos-5deg` is chaotic.
#[test]
fn chaos_has_a_positive_exponent() {
    let found = follow(scene("chaos-5deg"), Some(2), Goal::Time(1.5));
    let (signs, exponents) = signs(&found);
    assert_eq!(signs[0], Sign::Positive, "{exponents:?}");
}

/// The sum of all exponents equals the mean trace if the steps resolve the fastest contraction (about
/// 2e5 1/s, a node that nearly sticks). At the tolerance of the scenes, 1e-5, the sum is 12 % off, at
/// 1e-7 0.09 %, at 1e-9 0.008 %. If all exponents are computed, the steps are shortened accordingly.
#[test]
fn the_sum_is_the_mean_trace() {
    for name in ["doubled-torus-3deg", "chaos-5deg"] {
        let scene = scene(name);
        assert_eq!(scene.integrator.tolerance, 1e-5);
        let found = follow(scene, None, Goal::Time(0.05));
        assert_eq!(found.tolerance, Some(FULL_SPECTRUM_TOLERANCE));
        let (sum, trace) = (found.study.sum(), found.study.mean_trace_per_s);
        let (sum, trace) = (sum.expect("all"), trace.expect("smooth"));
        assert!((sum / trace - 1.0).abs() < 1e-3, "{name}: {sum} {trace}");
        let imbalance = found.study.imbalance().expect("both");
        assert!(imbalance < 1e-3, "{imbalance}");
    }
    // Requesting the number of available exponents requests all of them; fewer keep the tolerance of the
    // scene.
    let found = follow(scene("doubled-torus-3deg"), Some(22), Goal::Time(1e-3));
    assert_eq!(found.tolerance, Some(FULL_SPECTRUM_TOLERANCE));
    let found = follow(scene("doubled-torus-3deg"), Some(21), Goal::Time(1e-3));
    assert_eq!(found.tolerance, Some(1e-5));
}

/// Ten milliseconds are 17 periods: no exponent counts as zero yet, and the dimension is undefined.
#[test]
fn a_short_time_leaves_a_torus_undecided() {
    let found = follow(scene("periodic-2deg"), None, Goal::Time(0.01));
    let spectrum = &found.study.spectrum;
    assert_eq!(spectrum.count(Sign::Zero), 0, "{spectrum:?}");
    assert_eq!(found.study.attractor(), Attractor::Undecided);
    assert_eq!(spectrum.kaplan_yorke, None);
}

/// Without a kick the joint stays bitwise in steady sliding, which is unstable at 5 degrees.
#[test]
fn steady_sliding_is_an_equilibrium() {
    let mut scene = scene("chaos-5deg").with_duration(5.0).expect("in range");
    scene.start.kick = 0.0;
    let found = follow(scene, Some(4), Goal::Time(0.05));
    assert_eq!(found.study.motion, Motion::Still);
    let unstable = Attractor::UnstableEquilibrium;
    assert_eq!(found.study.attractor(), unstable);
}

/// The last frame of a ramp has the tilt of its start; the averaging has the tilt of its end.
#[test]
fn a_ramp_is_averaged_at_its_final_tilt() {
    let scene = scene("tilt-ramp");
    let end = scene.joint().expect("a joint").tilt.at(f64::INFINITY);
    let found = follow(scene, Some(1), Goal::Time(1e-3));
    assert_eq!(found.tilt_rad, Some(end));
}

/// The joint of `chaos-5deg` and `doubled-torus-3deg` with a slow tilt ramp from 0 degrees to `tilt_deg`: an
/// upward continuation of the motion.
fn continued_up(tilt_deg: f64) -> Scene {
    let knots = [[0.0, 0.0], [0.04, 0.0], [0.04 + 0.04 * tilt_deg, tilt_deg]];
    let knots = knots.map(|[time, tilt]: [f64; 2]| [time, tilt.to_radians()]);
    let mut scene = scene("chaos-5deg").with_duration(500.0).expect("in range");
    let tilt = Schedule::piecewise_linear(knots.to_vec()).expect("rising times");
    scene.joint_mut().expect("a joint").tilt = tilt;
    scene
}

/// The attractor reached by upward continuation: the largest exponent is zero at 3 degrees and clearly
/// positive at 5 and 6.
///
/// `cargo test --release --test it exponents::upward_continuation -- --ignored --nocapture`
#[test]
#[ignore = "about 30 s of simulated time; run with the command above"]
fn upward_continuation_becomes_chaotic_between_3_and_5_degrees() {
    let mut found = Vec::new();
    for tilt in [3.0, 5.0, 6.0] {
        let found_here = follow(continued_up(tilt), Some(3), Goal::Time(6.0));
        println!("{tilt} deg: {:?}", found_here.study.spectrum);
        found.push(found_here);
    }
    let sign = |k: usize| found[k].study.spectrum.sign(0);
    assert_eq!(sign(0), Sign::Zero);
    for k in [1, 2] {
        assert_eq!(sign(k), Sign::Positive);
        let largest = found[k].study.spectrum.exponents[0];
        assert!((20.0..150.0).contains(&largest.value), "{largest:?}");
    }
}
