//! The lesson on the birth of a torus.

use squeakscope::pipeline::message::ToneGrowth;
use squeakscope::scene::Scene;

use super::run::{Run, changed};

const END: &str = "time_ms = 800\ntilt_deg = 1.2";
const FACTS: [&str; 2] = ["decay of the second tone", "growth of the second tone"];
/// A ramp that is twice as fast.
const FAST: &str = "time_ms = 400\ntilt_deg = 1.2";

/// The scene with a replacement, until a time (ms) soon after the end of its ramp.
fn ramp([from, to]: [&str; 2], duration_ms: f64) -> Scene {
    let scene = changed("torus-birth", from, to);
    scene.with_duration(duration_ms).expect("valid")
}

/// Whether a measured rate is within 2 % of the computed one, and its interval is not wider than that.
#[track_caller]
fn assert_agrees(part: ToneGrowth) {
    let computed = part.computed_per_s;
    assert!(
        (part.growth.value / computed - 1.0).abs() < 0.02,
        "{part:?}"
    );
    assert!(part.growth.half_width < 0.02 * computed.abs(), "{part:?}");
}

/// The multipliers alone predict the growth on ramps of several speeds, from several starts of the same motion. The
/// measurement uses simulated samples only, whatever the frames of the playback are.
#[test]
fn the_second_tone_decays_and_grows_as_its_multiplier_predicts() {
    let fastest = "time_ms = 500\ntilt_deg = 1.9";
    let weaker = ["= 0.01\nseed", "= 0.008\nseed"];
    for (change, duration_ms, speeds, [low, high]) in [
        ([END, END], 850.0, &[][..], [0.6, 0.9]),
        ([END, FAST], 480.0, &[2e-3, 0.5], [0.8, 1.2]),
        ([END, fastest], 520.0, &[], [0.8, 1.3]),
        (weaker, 850.0, &[], [0.6, 0.9]),
    ] {
        let scene = ramp(change, duration_ms);
        let run = Run::of(&scene);
        let torus = run.computed().torus.as_ref().expect("a torus");
        assert!((torus.tilt.to_degrees() - 0.346_987).abs() < 1e-5);
        let birth = torus.birth().expect("an orbit");
        assert!((birth.second_hz - 240.98).abs() < 0.01, "{birth:?}");
        assert!(birth.growth_per_s.abs() < 1e-3, "{birth:?}");
        let found = run.measured().second_tone.expect("a second tone");
        for speed in speeds {
            let live = Run::at_speed(&scene, *speed);
            assert_eq!(live.measured().second_tone, Some(found), "{speed}");
            assert_eq!(live.last_lesson(), run.last_lesson(), "{speed}");
        }
        let (decay, growth) = (found.decay.expect("decay"), found.growth.expect("growth"));
        assert_agrees(decay);
        assert_agrees(growth);
        assert!(decay.computed_per_s < -40.0 && growth.computed_per_s > 40.0);
        let [first, last] = growth.tilts.map(f64::to_degrees);
        assert!(low < first && first < last && last < high, "{growth:?}");
        assert!(found.ratio > 0.05, "{found:?}");
        let rates = FACTS.map(|name| run.number(name));
        assert_eq!(rates, [decay.growth.value, growth.growth.value]);
    }
}

/// A ramp that ends before the point has no torus, and the lesson claims none.
#[test]
fn a_ramp_below_the_point_has_no_second_tone() {
    let run = Run::of(&ramp([END, "time_ms = 400\ntilt_deg = 0.3"], 480.0));
    assert_eq!(run.computed().torus, None);
    assert_eq!(run.measured().second_tone, None);
    let point = run.text("tilt of the Neimark-Sacker point");
    assert!(point.starts_with("none on the branch"), "{point}");
    assert_eq!(FACTS.map(|name| run.fact(name).measured), [None, None]);
}

/// Another kick leads to another motion, at whose frequency the torus is not predicted.
#[test]
fn another_motion_is_not_compared_with_the_branch() {
    let scene = ramp([END, FAST], 480.0).with_overrides(&[("start.seed", "22")]);
    let run = Run::of(&scene.expect("valid"));
    assert!(run.dominant_hz() > 12e3, "{}", run.dominant_hz());
    if let Some(found) = run.measured().second_tone {
        assert_eq!((found.decay, found.growth), (None, None), "{found:?}");
    }
    assert_eq!(FACTS.map(|name| run.fact(name).measured), [None, None]);
}
