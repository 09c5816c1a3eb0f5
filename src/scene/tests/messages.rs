//! Error messages of single keys.

use proptest::prelude::*;

use super::*;
use crate::scene::schema::Declared;
use crate::scene::tables::SCHEMA;

#[test]
fn keys_are_unique_and_named_with_their_units() {
    for key in &SCHEMA.0 {
        let (path, row) = (&key.path, key.guide_row());
        let suffix = match row.split('|').nth(3).map(str::trim) {
            Some("m/s") => "_m_per_s".to_owned(),
            Some("mm/s") => "_mm_per_s".to_owned(),
            Some("1/m") => "_per_m".to_owned(),
            Some("s/m") => "_s_per_m".to_owned(),
            Some("rad/s") => "_rad_per_s".to_owned(),
            Some("kg/m^3") => "_kg_m3".to_owned(),
            Some("N/kg") => "_n_per_kg".to_owned(),
            Some("m/s^2") => "_m_per_s2".to_owned(),
            Some("") => String::new(),
            Some(symbol) => format!("_{}", symbol.to_lowercase()),
            None => panic!("no unit column: {row}"),
        };
        assert!(path.ends_with(&suffix), "{path}: {suffix}");
        let count = SCHEMA.paths().filter(|other| other == path).count();
        assert_eq!(count, 1, "{path}");
    }
}

#[test]
fn laws_of_keys_are_choices_of_their_table() {
    let with_laws = SCHEMA.0.iter().filter(|key| !key.laws.is_empty());
    for Declared {
        table, path, laws, ..
    } in with_laws
    {
        for law in *laws {
            let choice = format!("\"{law}\"");
            let mut keys = SCHEMA.0.iter().filter(|key| key.table == *table);
            let is_choice = keys.any(|key| key.limits.allowed().contains(&choice));
            assert!(is_choice, "{path}: {law}");
        }
    }
}

#[test]
fn unknown_keys_are_reported_with_line_and_suggestion() {
    assert_eq!(
        refusal("[load]\nload_n = 150\ntilt_deq = 2\n[time]\nduration_ms = 1\n"),
        "mine.toml:3: unknown key `load.tilt_deq` (did you mean `load.tilt_deg`?); \
         [load] has the keys load_n, load, load_steps, load_csv, load_sine, tilt_deg, tilt, tilt_steps, tilt_csv, \
         tilt_sine, azimuth_deg"
    );
    assert!(
        refusal_with("[record]\nenergy_rate = 1\n")
            .contains("did you mean `record.energy_rate_khz`")
    );
    assert!(!refusal_with("[analysis.nope]\n").contains("did you mean"));
    let wrong_table = refusal_with("azimuth_deg = 3\n");
    assert!(wrong_table.starts_with("mine.toml:6: unknown key `time.azimuth_deg`"));
    assert!(wrong_table.contains("did you mean `load.azimuth_deg`?"));
    assert!(
        refusal_with("[frction]\n")
            .contains(":6: unknown key `frction` (did you mean `friction`?)")
    );
    assert!(refusal_with("[analysis.spectrm]\n").contains("did you mean `analysis.spectrum`?"));
    assert!(
        refusal_with("[qqqqqqqqqqqq]\n")
            .contains("`qqqqqqqqqqqq`; the top level has the keys name,")
    );
    let knot = "[load]\nload_n = 1\ntilt = [{ time_ms = 0, tilt_deg = 0, tlt = 1 }]\n";
    assert!(refusal(knot).contains(":3: unknown key `load.tilt.tlt`"));
}

#[test]
fn the_first_unknown_key_in_reading_order_is_reported() {
    assert!(refusal("zzz = 1\naaa = 2\n").contains(":1: unknown key `zzz`"));
}

#[test]
fn missing_values_are_reported_with_permitted_values() {
    assert_eq!(
        refusal("# no load\n[load]\ntilt_deg = 1\n"),
        "mine.toml:2: `load.load_n` is missing; it must be a number above 0, at most 1000000 N \
         (exactly one of `load_n`, `load`, `load_steps`, `load_sine` and `load_csv`)"
    );
    assert!(refusal("").contains("mine.toml:1: `load.load_n` is missing"));
    let no_tilt = refusal("[load]\nload_n = 1\n[time]\nduration_ms = 1\n");
    assert!(no_tilt.contains(":1: `load.tilt_deg` is missing"));
    assert!(
        no_tilt.contains(
            "exactly one of `tilt_deg`, `tilt`, `tilt_steps`, `tilt_sine` and `tilt_csv`"
        )
    );
    let knot = "[load]\nload_n = 1\n[[load.tilt]]\ntime_ms = 0\n[time]\nduration_ms = 1\n";
    assert!(refusal(knot).contains(":3: `load.tilt.tilt_deg` is missing"));
    assert!(refusal_with("[friction]\nmu_s = 0.5\n").contains(":6: `friction.mu_d` is missing"));
    let threshold = refusal_with("[analysis.recurrence]\n");
    assert!(threshold.contains(":6: `analysis.recurrence.recurrence_rate` is missing"));
}

#[test]
fn out_of_range_values_are_reported_with_line_and_range() {
    assert_eq!(
        refusal(SMALLEST.replace("= 150", "= -150")),
        "mine.toml:2: `load.load_n` = -150 is out of range; it must be a number above 0, at most 1000000 N"
    );
    assert_eq!(
        refusal(SMALLEST.replace("= 2.0", "= 90.5")),
        "mine.toml:3: `load.tilt_deg` = 90.5 is out of range; it must be a number from -90 to 90 deg"
    );
    for order in [0, 9] {
        assert_eq!(
            refusal_with(&format!("[body]\nelement_order = {order}\n")),
            format!(
                "mine.toml:7: `body.element_order` = {order} is out of range; \
                 it must be an integer from 1 to 8"
            )
        );
    }
    assert_eq!(
        refusal_with("[contact]\nnodes = 0\n"),
        "mine.toml:7: `contact.nodes` = 0 is out of range; \
         it must be an integer from 1 to 10000"
    );
    for value in ["nan", "inf", "-inf"] {
        let message = refusal(SMALLEST.replace("= 150", &format!("= {value}")));
        assert!(message.contains(&format!(":2: `load.load_n` = {value} is out of range")));
    }
    let overflow = refusal_with("[start]\nseed = 99999999999999999999\n");
    assert!(overflow.starts_with("mine.toml:7: not valid TOML: integer number overflowed"));
    assert!(
        refusal_with("[rotation]\nangular_velocity_rad_per_s = [0, nan, 0]\n")
            .contains("`rotation.angular_velocity_rad_per_s`")
    );
}

/// No numeric key accepts a value that is not finite.
#[test]
fn values_that_are_not_finite_are_rejected() {
    for Declared { table, name, .. } in &SCHEMA.0 {
        for value in ["nan", "inf", "-inf"] {
            let text = match &table[..] {
                "" => format!("{name} = {value}\n{SMALLEST}"),
                // A list of tables accepts no number.
                list if SCHEMA.find(list).is_some() => {
                    format!("{list} = [{{ {name} = {value} }}]\n")
                }
                "load" | "time" | "rotation" | "load.load_sine" | "load.tilt_sine" => {
                    format!("{table}.{name} = {value}\n")
                }
                table => format!("{SMALLEST}[{table}]\n{name} = {value}\n"),
            };
            let message = Scene::parse("mine.toml", text)
                .expect_err("refused")
                .to_string();
            assert!(!message.contains("unknown key"), "{message}");
        }
    }
}

#[test]
fn wrong_types_and_choices_are_reported_with_permitted_values() {
    assert_eq!(
        refusal(SMALLEST.replace("= 150", "= \"heavy\"")),
        "mine.toml:2: `load.load_n` is \"heavy\"; it must be a number above 0, at most 1000000 N"
    );
    assert_eq!(
        refusal_with("[contact]\nquadrature = \"gaus\"\n"),
        "mine.toml:7: `contact.quadrature` = \"gaus\" is not a valid choice \
         (did you mean `gauss`?); it must be \"rings\" or \"gauss\""
    );
    assert!(refusal_with("[contact]\nnodes = 10.5\n").contains("must be an integer"));
    assert!(refusal("load = 3\n").contains(":1: `load` is a table"));
    assert!(refusal("[[load]]\nload_n = 3\n").contains(":1: `load` is a table"));
    let long = format!("title = [\"{}\"]\n", "x".repeat(1000));
    assert!(refusal(long).len() < 200);
}

#[test]
fn invalid_toml_and_text_are_reported_with_line() {
    assert!(refusal("[load]\nload_n 150\n").starts_with("mine.toml:2: not valid TOML: "));
    assert!(refusal("a = 1\na = 2\n").starts_with("mine.toml:2: not valid TOML: duplicate key"));
    assert!(
        refusal(b"[load]\nload_n = \xff\n").starts_with("mine.toml:2: the scene file is not UTF-8")
    );
    assert!(refusal("[".repeat(100_000)).contains("not valid TOML"));
    assert!(refusal(format!("a = {}", "[".repeat(100_000))).contains("not valid TOML"));
}

#[test]
fn unknown_scenes_are_reported_with_suggestion() {
    let message = |name: &str| Scene::load(name).expect_err("not a scene").to_string();
    let near = message("chaos-5dg");
    assert!(near.starts_with("no scene is called `chaos-5dg` (did you mean `chaos-5deg`?)"));
    assert!(near.contains("tilt-ramp, printed-friction"));
    assert!(!message("").contains("did you mean"));
    assert!(
        message("absent/scene.toml").starts_with("cannot read the scene file `absent/scene.toml`")
    );
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().to_str().expect("UTF-8 path");
    assert!(message(path).starts_with("cannot read the scene file"));
}

#[cfg(unix)]
#[test]
fn an_endless_file_is_rejected() {
    let message = Scene::load("/dev/zero").expect_err("refused").to_string();
    assert!(message.contains("is larger than"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = Scene::parse("random", bytes);
    }

    /// A preset with random replacements parses to a scene in range, or fails with one message.
    #[test]
    fn mutated_presets_never_panic(
        which in 0..PRESETS.len(),
        start in any::<proptest::sample::Index>(),
        length in 0usize..12,
        replacement in r#"[-0-9.enaif\[\]{}=" \n_,x]{0,6}"#,
    ) {
        let mut text = PRESETS[which].text.as_bytes().to_vec();
        let start = start.index(text.len());
        let end = (start + length).min(text.len());
        text.splice(start..end, replacement.bytes());
        match Scene::parse("mutated", text) {
            Ok(scene) => {
                prop_assert!(scene.duration.is_finite() && scene.duration > 0.0);
                if let Ok(joint) = scene.joint() {
                    prop_assert!(joint.spec.load.is_finite() && joint.spec.load > 0.0);
                    prop_assert!(joint.tilt.max().abs() <= std::f64::consts::FRAC_PI_2);
                    prop_assert!((1..=10_000).contains(&joint.spec.contact.nodes));
                }
            }
            Err(error) => prop_assert!(error.to_string().contains("mutated")),
        }
    }
}
