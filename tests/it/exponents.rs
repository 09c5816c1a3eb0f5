//! What the exponents of the scenes are: zero on cycles and tori, positive in chaos.

use squeakscope::dynamics::{Attractor, Exponent, Motion, Sign, Stability};
use squeakscope::scene::{Scene, Schedule};
use squeakscope::study::lyapunov::{
    Count, Goal, LyapunovRequest, RESOLVING, SceneLyapunov, scene_lyapunov,
};

fn follow(scene: Scene, count: Count, goal: Goal) -> SceneLyapunov {
    let request = LyapunovRequest {
        count,
        settle: None,
        goal,
        tolerance: None,
    };
    scene_lyapunov(&scene, &request, &mut |_| true).expect("done")
}

fn scene(name: &str) -> Scene {
    Scene::load(name).expect("preset")
}

/// Signs of the exponents followed, with the exponents for a message.
fn signs(found: &SceneLyapunov) -> (Vec<Sign>, &[Exponent]) {
    let spectrum = &found.study.spectrum;
    let signs = (0..spectrum.exponents.len()).map(|k| spectrum.sign(k));
    (signs.collect(), &spectrum.exponents)
}

/// A limit cycle has one exponent of zero; the next ones are negative.
#[test]
fn cycles_have_one_zero_exponent() {
    for name in ["periodic-2deg", "mode-shift-3.5deg"] {
        let found = follow(scene(name), Count::Largest(3), Goal::Time(0.65));
        let (signs, exponents) = signs(&found);
        let expected = [Sign::Zero, Sign::Negative, Sign::Negative];
        assert_eq!(signs, expected, "{name}: {exponents:?}");
        assert_eq!(found.study.spectrum.attractor(), Attractor::Cycle, "{name}");
    }
}

/// A torus has two, and none is doubtful.
#[test]
fn a_torus_has_two_zero_exponents() {
    let found = follow(scene("torus-3deg"), Count::Largest(4), Goal::Verdict);
    let (signs, exponents) = signs(&found);
    let expected = [Sign::Zero, Sign::Zero, Sign::Negative, Sign::Negative];
    assert_eq!(signs, expected, "{exponents:?}");
    assert_eq!(found.study.spectrum.attractor(), Attractor::Torus(2));
}

/// The chaos of the scene that is named after it.
#[test]
fn chaos_has_a_positive_exponent() {
    let found = follow(scene("chaos-5deg"), Count::Largest(2), Goal::Time(1.5));
    let (signs, exponents) = signs(&found);
    assert_eq!(signs[0], Sign::Positive, "{exponents:?}");
}

/// All exponents add up to the mean trace, where the steps resolve the fastest contraction (about
/// 2e5 1/s, a node that nearly sticks): at the scenes' tolerance, 1e-5, the sum is 12 % off, at 1e-7
/// 0.09 %, at 1e-9 0.008 %. Where all are followed, the steps are made short enough for it.
#[test]
fn the_sum_is_the_mean_trace() {
    for name in ["torus-3deg", "chaos-5deg"] {
        let scene = scene(name);
        assert_eq!(scene.integrator.tolerance, 1e-5);
        let found = follow(scene, Count::All, Goal::Time(0.05));
        assert_eq!(found.tolerance, Some(RESOLVING));
        let (sum, trace) = (found.study.sum(), found.study.mean_trace);
        let (sum, trace) = (sum.expect("all"), trace.expect("smooth"));
        assert!((sum / trace - 1.0).abs() < 1e-3, "{name}: {sum} {trace}");
        let imbalance = found.study.imbalance().expect("both");
        assert!(imbalance < 1e-3, "{imbalance}");
    }
    // As many as there are is all of them; fewer keep the scene's tolerance.
    let found = follow(scene("torus-3deg"), Count::Largest(22), Goal::Time(1e-3));
    assert_eq!(found.tolerance, Some(RESOLVING));
    let found = follow(scene("torus-3deg"), Count::Largest(21), Goal::Time(1e-3));
    assert_eq!(found.tolerance, Some(1e-5));
}

/// Ten milliseconds are 17 periods: nothing near zero is a zero yet, and no dimension is told of it.
#[test]
fn a_short_time_makes_no_torus() {
    let found = follow(scene("periodic-2deg"), Count::All, Goal::Time(0.01));
    let spectrum = &found.study.spectrum;
    assert_eq!(spectrum.count(Sign::Zero), 0, "{spectrum:?}");
    assert_eq!(found.study.attractor(), Attractor::Undecided);
    assert_eq!(spectrum.kaplan_yorke(), None);
}

/// Without a kick the joint stays in steady sliding, to the last bit, which is unstable at 5 degrees.
#[test]
fn exact_rest_is_an_equilibrium() {
    let mut scene = scene("chaos-5deg").with_duration(5.0).expect("in range");
    scene.start.kick = 0.0;
    let found = follow(scene, Count::Largest(4), Goal::Time(0.05));
    assert_eq!(found.study.motion, Motion::Still);
    let unstable = Attractor::Equilibrium(Stability::Unstable);
    assert_eq!(found.study.attractor(), unstable);
}

/// The last frame of a ramp has the tilt of its start; what is averaged has the tilt of its end.
#[test]
fn a_ramp_is_followed_to_its_end() {
    let scene = scene("tilt-ramp");
    let end = scene.joint().expect("a joint").tilt.at(f64::INFINITY);
    let found = follow(scene, Count::Largest(1), Goal::Time(1e-3));
    assert_eq!(found.tilt, Some(end));
}

/// The joint of `chaos-5deg` and `torus-3deg`, tilted slowly from 0 degrees up to a tilt: the motion
/// is continued up to it.
fn continued_up(tilt_deg: f64) -> Scene {
    let knots = [(0.0, 0.0), (0.04, 0.0), (0.04 + 0.04 * tilt_deg, tilt_deg)];
    let knots = knots.map(|(time, tilt): (f64, f64)| (time, tilt.to_radians()));
    let mut scene = scene("chaos-5deg").with_duration(500.0).expect("in range");
    let tilt = Schedule::through(knots.to_vec()).expect("rising times");
    scene.joint_mut().expect("a joint").tilt = tilt;
    scene
}

/// The natural set: the largest exponent is zero at 3 degrees and clearly positive at 5 and 6.
///
/// `cargo test --release --test it exponents::the_natural_set -- --ignored --nocapture`
#[test]
#[ignore = "about 30 s of simulated time; see the command above"]
fn the_natural_set_turns_chaotic_between_3_and_5_degrees() {
    let mut found = Vec::new();
    for tilt in [3.0, 5.0, 6.0] {
        let found_here = follow(continued_up(tilt), Count::Largest(3), Goal::Time(6.0));
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
