//! Old names of keys and tables: accepted, reported, and replaced in the text.

use super::*;
use crate::scene::tables::SCHEMA;

const OLD: &str = "\
# A comment.
[load]
load_n = 150
tilt_deg = 2
[time]
duration_ms = 10
[body]
torsion = 1 # one mode
axial = 0
[rotation]
rad_s = [0, 1, 0]
[analysis.exponents]
settle_ms = 2
[analysis]
butterfly = { start_ms = 3, distance = 1e-6 }
";

const NEW: &str = "\
# A comment.
[load]
load_n = 150
tilt_deg = 2
[time]
duration_ms = 10
[body]
torsion_modes = 1 # one mode
axial_modes = 0
[rotation]
angular_velocity_rad_per_s = [0, 1, 0]
[analysis.lyapunov]
transient_ms = 2
[analysis]
perturbed_trajectory = { start_ms = 3, initial_distance = 1e-6 }
";

#[test]
fn old_names_have_the_meaning_of_the_current_ones() {
    let (old, new) = (
        Scene::parse("mine.toml", OLD),
        Scene::parse("mine.toml", NEW),
    );
    let (mut old, new) = (old.expect("valid"), new.expect("valid"));
    assert_eq!(new.deprecated_keys, []);
    assert_eq!(old.text, NEW, "the text contains current names only");
    old.deprecated_keys.clear();
    assert_eq!(old, new);
}

#[test]
fn old_names_are_reported_with_line_and_current_name() {
    let scene = Scene::parse("mine.toml", OLD).expect("valid");
    let warnings: Vec<String> = scene.warnings().iter().map(ToString::to_string).collect();
    let expected = [
        (8, "body.torsion", "body.torsion_modes"),
        (9, "body.axial", "body.axial_modes"),
        (11, "rotation.rad_s", "rotation.angular_velocity_rad_per_s"),
        (12, "analysis.exponents", "analysis.lyapunov"),
        (
            13,
            "analysis.exponents.settle_ms",
            "analysis.lyapunov.transient_ms",
        ),
        (15, "analysis.butterfly", "analysis.perturbed_trajectory"),
        (
            15,
            "analysis.butterfly.distance",
            "analysis.perturbed_trajectory.initial_distance",
        ),
    ];
    let expected = expected.map(|(line, old, new)| {
        format!("mine.toml:{line}: the key `{old}` is deprecated; use `{new}`")
    });
    assert_eq!(warnings, expected);
    // A changed scene still reports the names in its file.
    let tilt = Parameter::tilt();
    let changed = scene.with_values(&[(tilt, 3.0)]).expect("valid");
    assert_eq!(changed.deprecated_keys, scene.deprecated_keys);
}

#[test]
fn every_old_name_is_accepted() {
    for key in &SCHEMA.0 {
        let Some(old) = key.key.old_name else {
            continue;
        };
        let written = format!("{}.{old}", key.table);
        assert_eq!(SCHEMA.current(&written), key.path);
        assert!(
            SCHEMA.find(&written).is_none(),
            "{written} is also a current key"
        );
    }
    assert_eq!(
        SCHEMA.current("analysis.butterfly"),
        "analysis.perturbed_trajectory"
    );
    assert_eq!(
        SCHEMA.current("analysis.butterfly.every_ms"),
        "analysis.perturbed_trajectory.every_ms"
    );
    assert_eq!(SCHEMA.current("body.nothing"), "body.nothing");
}

#[test]
fn overrides_accept_old_names() {
    let by_path = Parameter::named("rotation.rad_s").expect("a number");
    let by_name = Parameter::named("largest_lag_us").expect("a number");
    assert_eq!(by_path.path(), "rotation.angular_velocity_rad_per_s");
    assert_eq!(by_name.path(), "analysis.delay.max_lag_us");
    let deprecation = by_path.deprecation().expect("an old name").to_string();
    assert_eq!(
        deprecation,
        "parameter to vary: the key `rotation.rad_s` is deprecated; use \
         `rotation.angular_velocity_rad_per_s`"
    );
    assert_eq!(Parameter::tilt().deprecation(), None);
    let scene = Scene::load("chaos-5deg").expect("preset");
    let changed = scene
        .with_words(&[("body.beam_reaches", "centre")])
        .expect("valid");
    assert!(
        changed.text.contains("beam_length_to = \"centre\""),
        "{}",
        changed.text
    );
}

#[test]
fn suggestions_and_reference_contain_current_names_only() {
    let message = refusal_with("[analysis.lyapunov]\nsettle_m = 2\n");
    assert!(!message.contains("settle_ms"), "{message}");
    for old in [
        "`torsion`",
        "rad_s`]",
        "[analysis.butterfly]",
        "`least_diagonal`",
    ] {
        assert!(!key_reference().contains(old), "{old}");
    }
}

#[test]
fn both_names_of_a_key_are_rejected() {
    let message = refusal_with("[body]\ntorsion_modes = 1\ntorsion = 2\n");
    assert_eq!(
        message,
        "mine.toml:8: `body.torsion`: this is the old name of `body.torsion_modes`, which the scene \
         also contains; remove the old key"
    );
    let message = refusal_with("[analysis.lyapunov]\n[analysis.exponents]\n");
    assert!(
        message.starts_with("mine.toml:7: `analysis.exponents`: this is the old name"),
        "{message}"
    );
}

/// The former name of a method, which the command line accepts as well.
#[test]
fn an_old_name_of_a_choice_is_accepted() {
    let parsed = |method: &str| {
        let text = format!("{SMALLEST}method = \"{method}\"\n");
        Scene::parse("mine.toml", text).map(|scene| scene.integrator)
    };
    assert_eq!(parsed("tsit54").unwrap(), parsed("tsit5").unwrap());
}

/// A dot in a quoted key does not make it a path.
#[test]
fn quoted_keys_with_dots_are_unknown() {
    let message = refusal(format!("\"body.torsion\" = 1\n{SMALLEST}"));
    assert!(message.contains(":1: unknown key"), "{message}");
}
