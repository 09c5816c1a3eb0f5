//! The lesson on a joint that turns to and fro.

use squeakscope::pipeline::message::TiltDirection;
use squeakscope::scene::Scene;

use super::run::Run;

/// The squeak of each pass starts after the computed growth and ends after it, on both ways.
#[test]
fn a_turning_joint_squeaks_between_the_computed_tilts() {
    let run = Run::named("articulation");
    let predicted = run.computed().passes.as_ref().expect("passes");
    assert_eq!(predicted.len(), 2);
    let lesson = run.measured();
    assert_eq!(lesson.passes.len(), 2);
    for way in ["rising", "falling"] {
        run.assert_confirmed(&format!("joint, {way} tilt"), "squeak");
    }
    for (found, expected) in lesson.passes.iter().zip(predicted) {
        assert_eq!(found.way, expected.way);
        let along = if found.way == TiltDirection::Up {
            1.0
        } else {
            -1.0
        };
        let squeak = found
            .squeak
            .expect("a squeak")
            .map(|tilt| along * tilt.to_degrees());
        let grows = expected
            .unstable
            .expect("growth")
            .map(|tilt| along * tilt.to_degrees());
        assert!(
            squeak[0] > grows[0] && squeak[0] < grows[0] + 2.0,
            "{squeak:?} {grows:?}"
        );
        assert!(squeak[1] > grows[1] - 0.5, "{squeak:?} {grows:?}");
    }
}

/// A joint whose friction does not fall with the speed turns silently, and the lesson says so.
#[test]
fn a_joint_with_constant_friction_turns_silently() {
    let text = Scene::load("articulation").expect("preset").text;
    let from =
        "mu_s = 0.55\nmu_d = 0.25\ncreep_slope_s_per_m = 1000\nstribeck_slope_s_per_m = 13.25\n";
    assert!(text.contains(from));
    let text = text
        .replace(
            "    { key = \"friction.stribeck_slope_s_per_m\", min = 5, max = 25 },\n",
            "",
        )
        .replace("[start]", "[damping]\nratio = 0.005\n\n[start]")
        .replace(
            from,
            "law = \"constant\"\nmu = 0.3\ncreep_slope_s_per_m = 1000\n",
        );
    let run = Run::of(&Scene::parse("silent.toml", text).expect("valid"));
    let lesson = run.last_lesson();
    assert!(
        run.measured()
            .passes
            .iter()
            .all(|pass| pass.squeak.is_none()),
        "{lesson}"
    );
    for way in ["rising", "falling"] {
        run.assert_confirmed(&format!("joint, {way} tilt"), "no squeak");
    }
}
