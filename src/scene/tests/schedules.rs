//! Tilt, load and rotation as functions of time: parsing and error messages.

use std::fs;

use crate::scene::schema::Declared;
use crate::scene::tables::SCHEMA;
use crate::scene::tables::load::is_schedule_key;
use crate::scene::*;

/// A scene with the given lines for load, tilt and rotation.
fn text(lines: &str) -> String {
    let given = |key: &str| lines.lines().any(|line| line.starts_with(key));
    let load = if given("load.load") {
        ""
    } else {
        "load.load_n = 150\n"
    };
    let tilt = if given("load.tilt") {
        ""
    } else {
        "load.tilt_deg = 2\n"
    };
    format!("{lines}\n{load}{tilt}time.duration_ms = 10\n")
}

fn joint(lines: &str) -> LoadedJoint {
    let scene = Scene::parse("mine.toml", text(lines)).unwrap_or_else(|error| panic!("{error}"));
    scene.joint().expect("a joint").clone()
}

fn refusal(lines: &str) -> String {
    let refused = Scene::parse("mine.toml", text(lines));
    refused.expect_err("must be rejected").to_string()
}

/// A scene in a folder with another file.
fn with_file(
    name: &str,
    content: &str,
    lines: &str,
) -> (tempfile::TempDir, Result<Scene, SceneError>) {
    let folder = tempfile::tempdir().expect("temporary folder");
    fs::write(folder.path().join(name), content).expect("written");
    let path = folder.path().join("mine.toml");
    fs::write(&path, text(lines)).expect("written");
    let scene = Scene::load(path.to_str().expect("UTF-8"));
    (folder, scene)
}

#[test]
fn a_change_carries_the_perturbation_or_the_displacement_over() {
    let of = |lines: &str| joint(lines).carry;
    assert_eq!(of(""), Carry::Perturbation);
    assert_eq!(of("time.carry = \"perturbation\""), Carry::Perturbation);
    assert_eq!(of("time.carry = \"displacement\""), Carry::Displacement);
    let message = refusal("time.carry = \"velocity\"");
    assert!(
        message.contains("must be \"perturbation\" or \"displacement\""),
        "{message}"
    );
}

#[test]
fn each_quantity_accepts_each_form() {
    let knots = joint(
        "load.load = [{ time_ms = 0, load_n = 100 }, { time_ms = 4, load_n = 200 }]\n\
         load.tilt = [{ time_ms = 0, tilt_deg = 0 }, { time_ms = 4, tilt_deg = 4 }]\n\
         rotation.factor = [{ time_ms = 0, factor = 1 }, { time_ms = 4, factor = 3 }]",
    );
    let at = knots.loading(1e-3);
    assert_eq!((at.load, at.rotation_factor), (125.0, 1.5));
    assert!((at.tilt.to_degrees() - 1.0).abs() < 1e-12);
    let whole = std::f64::consts::FRAC_1_SQRT_2;
    assert_eq!(at.rotation, [1.5 * whole, 1.5 * whole, 0.0]);
    assert_eq!(knots.load_span(), [100.0, 200.0]);
    assert_eq!(knots.rotation_span(), [1.0, 3.0]);
    assert_eq!(knots.jumps(), [0.0; 0]);

    let steps = joint(
        "load.load_steps = [{ time_ms = 0, load_n = 100 }, { time_ms = 4, load_n = 200 }]\n\
         load.tilt_steps = [{ time_ms = 1, tilt_deg = 0 }, { time_ms = 3, tilt_deg = 4 }]\n\
         rotation.factor_steps = [{ time_ms = 0, factor = 1 }, { time_ms = 4, factor = 3 }]",
    );
    let at = |ms: f64| steps.loading(ms / 1e3);
    assert_eq!((at(3.9).load, at(4.0).load), (100.0, 200.0));
    assert_eq!((at(0.0).tilt, at(3.0).tilt), (0.0, 4f64.to_radians()));
    assert_eq!(
        (at(3.9).rotation_factor, at(4.0).rotation_factor),
        (1.0, 3.0)
    );
    assert_eq!(
        steps.jumps(),
        [0.003, 0.004],
        "simultaneous steps of load and rotation are merged"
    );

    let sines = joint(
        "load.load_sine = { mean_n = 150, amplitude_n = 50, frequency_hz = 25, phase_deg = 90 }\n\
         load.tilt_sine = { mean_deg = 3, amplitude_deg = 1, frequency_hz = 25 }\n\
         rotation.factor_sine = { mean = 2, amplitude = 0.5, frequency_hz = 25, phase_deg = -90 }",
    );
    let at = sines.loading(0.0);
    assert_eq!(
        (at.load, at.tilt, at.rotation_factor),
        (200.0, 3f64.to_radians(), 1.5)
    );
    let later = sines.loading(10e-3);
    assert!((later.load - 150.0).abs() < 1e-12 && (later.rotation_factor - 2.0).abs() < 1e-12);
    assert!((later.tilt - 4f64.to_radians()).abs() < 1e-15);
}

#[test]
fn parameters_are_the_initial_values() {
    let sines = joint(
        "load.load_sine = { mean_n = 150, amplitude_n = 50, frequency_hz = 25, phase_deg = 90 }\n\
         rotation.angular_velocity_rad_per_s = [0, 2, 0]\n\
         rotation.factor_steps = [{ time_ms = 1, factor = 0.5 }, { time_ms = 2, factor = 3 }]",
    );
    assert_eq!(
        (sines.spec.load, sines.spec.rotation),
        (200.0, [0.0, 1.0, 0.0])
    );
    let held = sines.fixed_at_start();
    let words = "load 200 N, rotation 0.5 times rotation.angular_velocity_rad_per_s";
    assert_eq!(held.description().as_deref(), Some(words));
    let constant = joint("load.load_steps = [{ time_ms = 0, load_n = 100 }]");
    assert_eq!(constant.fixed_at_start(), FixedAt::default());
    assert_eq!(constant.fixed_at_start().description(), None);
    let ramp = Scene::load("tilt-ramp").expect("preset");
    let held = ramp.joint().expect("a joint").fixed_at_start();
    assert_eq!(held.description().as_deref(), Some("tilt 0 deg"));
}

#[test]
fn a_quantity_is_unique() {
    let cases = [
        (
            "load.tilt_deg = 1\nload.tilt_sine = { mean_deg = 3, amplitude_deg = 1, frequency_hz = 25 }",
            ":2: `load.tilt_sine`: the scene gives the tilt more than once; keep one of load.tilt_deg and load.tilt_sine",
        ),
        (
            "load.load_csv = \"a.csv\"\nload.load_n = 3",
            ":2: `load.load_csv`: the scene gives the load more than once; keep one of load.load_n and load.load_csv",
        ),
        (
            "rotation.factor = [{ time_ms = 0, factor = 1 }]\n\
             rotation.factor_steps = [{ time_ms = 0, factor = 1 }]",
            ":2: `rotation.factor_steps`: the scene gives the rotation more than once",
        ),
    ];
    for (lines, expected) in cases {
        let message = refusal(lines);
        assert!(
            message.starts_with(&format!("mine.toml{expected}")),
            "{message}"
        );
    }
}

#[test]
fn values_of_a_function_are_in_range() {
    let cases = [
        (
            "load.load_sine = { mean_n = 150, amplitude_n = 150, frequency_hz = 25 }",
            ":1: `load.load_sine.amplitude_n`: the load reaches 0; reduce it; the load must be a number above 0, at most 1000000 N",
        ),
        (
            "load.tilt_sine = { mean_deg = 80, amplitude_deg = 10.5, frequency_hz = 25 }",
            ":1: `load.tilt_sine.amplitude_deg`: the tilt reaches 90.5; reduce it",
        ),
        (
            "rotation.factor_sine = { mean = -999, amplitude = 1.5, frequency_hz = 25 }",
            ":1: `rotation.factor_sine.amplitude`: the rotation reaches -1000.5; reduce it",
        ),
        (
            "load.load_steps = [{ time_ms = 0, load_n = 1 }, { time_ms = 1, load_n = 0 }]",
            ":1: `load.load_steps.load_n` = 0 is out of range",
        ),
        (
            "rotation.factor = [{ time_ms = 0, factor = 1 }, { time_ms = 1, factor = -1001 }]",
            ":1: `rotation.factor.factor` = -1001 is out of range; it must be a number from -1000 to 1000",
        ),
        (
            "rotation.angular_velocity_rad_per_s = [0, 20, 0]\nrotation.factor = [{ time_ms = 0, factor = 600 }]",
            ":2: `rotation.angular_velocity_rad_per_s`: with its factor a component reaches 12000 rad/s",
        ),
        (
            "rotation.angular_velocity_rad_per_s = [0, 0, 1]\n\
             load.tilt_sine = { mean_deg = 1, amplitude_deg = 2, frequency_hz = 25 }",
            ":2: `rotation.angular_velocity_rad_per_s`: at a tilt of 0.000 deg the load is parallel to the axis",
        ),
    ];
    for (lines, expected) in cases {
        let message = refusal(lines);
        assert!(
            message.starts_with(&format!("mine.toml{expected}")),
            "{message}"
        );
    }
    // Values at the ends of the range are accepted.
    joint("load.tilt_sine = { mean_deg = 80, amplitude_deg = 10, frequency_hz = 25 }");
    joint("load.load_sine = { mean_n = 150, amplitude_n = 149.99, frequency_hz = 25 }");
}

/// A frame has 256 samples at 200 kHz or 1.28 ms; 20 frames are the period of 39.0625 Hz.
#[test]
fn a_sine_too_fast_for_the_frames_is_rejected() {
    let sine = |frequency: f64| {
        format!(
            "load.tilt_sine = {{ mean_deg = 3, amplitude_deg = 1, frequency_hz = {frequency} }}"
        )
    };
    joint(&sine(39.0625));
    let message = refusal(&sine(39.1));
    let expected = "mine.toml:1: `load.tilt_sine.frequency_hz`: the tilt is updated once per frame, every \
                    1.28 ms, which is too coarse for 39.1 Hz; reduce it to at most 39.062 Hz, or \
                    reduce time.frame_samples";
    assert_eq!(message, expected);
    joint(&format!("{}\ntime.frame_samples = 128", sine(78.0)));
}

#[test]
fn points_out_of_order_are_reported_with_line() {
    let lines =
        "load.load_steps = [\n  { time_ms = 1, load_n = 1 },\n  { time_ms = 1, load_n = 2 }]";
    let message = refusal(lines);
    let expected =
        "mine.toml:3: `load.load_steps.time_ms`: this time is not later than the previous time";
    assert!(message.starts_with(expected), "{message}");
}

/// Parameters of functions of time that are not finite are rejected with their names.
#[test]
fn parameters_of_functions_are_finite() {
    let numbers = || SCHEMA.0.iter().filter(|key| is_schedule_key(&key.path));
    assert_eq!(numbers().count(), 3 * (2 + 2 + 4));
    for Declared {
        table, path, name, ..
    } in numbers()
    {
        let is_list = SCHEMA.find(table).is_some();
        for value in ["nan", "inf", "-inf"] {
            let siblings = numbers().filter(|sibling| sibling.table == *table);
            let fields: Vec<String> = siblings
                .map(|sibling| match sibling.name {
                    sibling if sibling == *name => format!("{name} = {value}"),
                    sibling => format!("{sibling} = 0.5"),
                })
                .collect();
            let fields = fields.join(", ");
            let message = refusal(&if is_list {
                format!("{table} = [{{ {fields} }}]")
            } else {
                format!("{table} = {{ {fields} }}")
            });
            let expected = format!("mine.toml:1: `{path}` = {value} is out of range");
            assert!(message.starts_with(&expected), "{message}");
        }
    }
}

#[test]
fn knots_are_read_from_csv_files() {
    let csv = "# made up\r\ntime_ms, tilt_deg\r\n\r\n0, 0.1\r\n2.5, 3e0 # the top\r\n4,-1\r\n";
    let (_folder, scene) = with_file("tilt.csv", csv, "load.tilt_csv = \"tilt.csv\"");
    let scene = scene.expect("valid");
    let knots = [[0.0, 0.1], [2.5, 3.0], [4.0, -1.0]];
    let si = knots.map(|[ms, deg]: [f64; 2]| [ms / 1e3, deg.to_radians()]);
    let tilt = Schedule::piecewise_linear(si.to_vec()).expect("rising times");
    assert_eq!(scene.joint().expect("a joint").tilt, tilt);

    // The text is self-contained and parses without the file.
    assert!(!scene.text.contains("tilt_csv"), "{}", scene.text);
    assert!(
        scene
            .text
            .ends_with("# load.tilt was read from \"tilt.csv\"\n"),
        "{}",
        scene.text
    );
    let again = Scene::parse("mine.toml", &scene.text).expect("valid");
    assert_eq!(again.subject, scene.subject);
    let stiffness = Parameter::named("stiffness_factor").expect("a number");
    let stiffer = scene.with_values(&[(stiffness, 2.0)]).expect("valid");
    assert_eq!(stiffer.joint().expect("a joint").tilt, tilt);
    let level = scene
        .with_values(&[(Parameter::tilt(), 2.0)])
        .expect("valid");
    assert!(!level.joint().expect("a joint").tilt.varies());
}

#[test]
fn load_and_rotation_are_read_from_csv_files() {
    let (_folder, scene) = with_file(
        "f.csv",
        "time_ms,factor\n0,1\n9,2",
        "rotation.factor_csv = \"f.csv\"",
    );
    let scene = scene.expect("valid");
    assert_eq!(scene.joint().expect("a joint").rotation_span(), [1.0, 2.0]);
    assert!(
        scene
            .text
            .contains("rotation.factor = [{ time_ms = 0, factor = 1 }"),
        "{}",
        scene.text
    );
    let (_folder, scene) = with_file(
        "l.csv",
        "\u{feff}time_ms,load_n\n0,100\n9,200",
        "load.load_csv = \"l.csv\"",
    );
    assert_eq!(
        scene.expect("valid").joint().expect("a joint").load_span(),
        [100.0, 200.0]
    );
}

#[test]
fn invalid_csv_files_are_reported_with_name_and_line() {
    let many: String = (0..=10_000).map(|k| format!("{k},1\n")).collect();
    let cases = [
        (
            "time_ms,tilt\n0,1\n",
            "1: `load.tilt_csv`: the first line does not contain the names of the columns; begin with the line `time_ms,tilt_deg`",
        ),
        ("", "1: `load.tilt_csv`: the first line"),
        (
            "time_ms;tilt_deg\n0;1\n",
            "1: `load.tilt_csv`: the first line does not contain the names of the columns",
        ),
        (
            "# tabs\ntime_ms\ttilt_deg\n0\t1\n",
            "2: `load.tilt_csv`: the first line does not contain the names of the columns",
        ),
        (
            "time_ms,tilt_deg\n\n# none\n",
            "3: `load.tilt_csv`: the file contains no knot",
        ),
        (
            "time_ms,tilt_deg\n0,1\n1,2,3\n",
            "3: `load.tilt_csv`: the line has 3 fields instead of 2; write",
        ),
        (
            "time_ms,tilt_deg\n0,1\n1\n",
            "3: `load.tilt_csv`: the line has 1 fields",
        ),
        (
            "time_ms,tilt_deg\n0,one\n",
            "2: `load.tilt.tilt_deg` is `one`; it must be a number from -90 to 90 deg",
        ),
        ("time_ms,tilt_deg\n0,\n", "2: `load.tilt.tilt_deg` is ``"),
        (
            "time_ms,tilt_deg\n0,91\n",
            "2: `load.tilt.tilt_deg` = `91` is out of range",
        ),
        (
            "time_ms,tilt_deg\n0,nan\n",
            "2: `load.tilt.tilt_deg` = `nan` is out of range",
        ),
        (
            "time_ms,tilt_deg\n-1,0\n",
            "2: `load.tilt.time_ms` = `-1` is out of range",
        ),
        (
            "time_ms,tilt_deg\n1,0\n# again\n1,0\n",
            "4: `load.tilt.time_ms`: this time is not later",
        ),
    ];
    for (csv, expected) in cases {
        let (folder, scene) = with_file("tilt.csv", csv, "load.tilt_csv = \"tilt.csv\"");
        let message = scene.expect_err("rejected").to_string();
        let place = folder.path().join("tilt.csv").display().to_string();
        assert!(
            message.starts_with(&format!("{place}:{expected}")),
            "{message}"
        );
    }
    let full = format!("time_ms,tilt_deg\n{many}");
    let (_folder, scene) = with_file("tilt.csv", &full, "load.tilt_csv = \"tilt.csv\"");
    let message = scene.expect_err("rejected").to_string();
    assert!(
        message.contains(".csv:10002: `load.tilt_csv`: the file contains more than 10000 knots"),
        "{message}"
    );
}

#[test]
fn unreadable_csv_files_are_reported_at_their_key() {
    let (_folder, scene) = with_file("other.csv", "", "\nload.tilt_csv = \"tilt.csv\"");
    let message = scene.expect_err("rejected").to_string();
    assert!(
        message.contains("mine.toml:2: `load.tilt_csv`: the file `"),
        "{message}"
    );
    assert!(message.contains("cannot be read"), "{message}");
    let message = refusal("load.tilt_csv = \"/dev/zero\"");
    #[cfg(unix)]
    assert!(message.contains("not a regular file"), "{message}");
    #[cfg(not(unix))]
    assert!(message.contains("cannot be read"), "{message}");
    let large = " ".repeat(5 << 20);
    let (_folder, scene) = with_file("tilt.csv", &large, "load.tilt_csv = \"tilt.csv\"");
    let message = scene.expect_err("rejected").to_string();
    assert!(message.contains("is larger than"), "{message}");
}

#[test]
fn functions_of_time_cannot_be_varied() {
    let lines = "load.load = [{ time_ms = 0, load_n = 100 }, { time_ms = 4, load_n = 200 }]\n\
                 rotation.factor = [{ time_ms = 0, factor = 1 }, { time_ms = 4, factor = 3 }]";
    let scene = Scene::parse("mine.toml", text(lines)).expect("valid");
    for (name, word) in [
        ("load.load_n", "load"),
        ("rotation.angular_velocity_rad_per_s", "rotation"),
    ] {
        let parameter = Parameter::named(name).expect("a number");
        let message = scene
            .with_values(&[(parameter, 1.0)])
            .expect_err("rejected")
            .to_string();
        let expected = format!(
            "override of scene mine: `{name}`: the {word} of this scene is a function of time"
        );
        assert!(message.starts_with(&expected), "{message}");
    }
    for name in [
        "load.tilt_sine.mean_deg",
        "load.load.time_ms",
        "rotation.factor_steps.factor",
    ] {
        let message = Parameter::named(name)
            .expect_err("not a parameter")
            .to_string();
        assert!(
            message.contains("it is not a single number that is constant in time"),
            "{message}"
        );
    }
    assert_eq!(
        Parameter::named("load_n").expect("a unique name").path(),
        "load.load_n"
    );
}

#[test]
fn a_constant_tilt_replaces_each_form() {
    for form in [
        "load.tilt = [{ time_ms = 0, tilt_deg = 0 }, { time_ms = 4, tilt_deg = 4 }]",
        "load.tilt_steps = [{ time_ms = 0, tilt_deg = 0 }, { time_ms = 4, tilt_deg = 4 }]",
        "load.tilt_sine = { mean_deg = 3, amplitude_deg = 1, frequency_hz = 25 }",
    ] {
        let scene = Scene::parse("mine.toml", text(form)).expect("valid");
        let level = scene
            .with_values(&[(Parameter::tilt(), 2.0)])
            .expect("valid");
        let tilt = &level.joint().expect("a joint").tilt;
        assert_eq!(*tilt, Schedule::constant(2f64.to_radians()), "{form}");
    }
}

#[test]
fn changes_after_the_end_are_reported() {
    let lines = "load.load_steps = [{ time_ms = 0, load_n = 1 }, { time_ms = 12, load_n = 2 }]\n\
                 rotation.factor = [{ time_ms = 0, factor = 1 }, { time_ms = 10, factor = 3 }]";
    let scene = Scene::parse("mine.toml", text(lines)).expect("valid");
    let warnings = scene.warnings();
    let expected = "the run ends at 10 ms, before the last change of the load at 12 ms; \
                    increase time.duration_ms";
    assert_eq!(warnings, [expected]);
    // No sample follows a step at the end of the run; a segment up to the end is simulated.
    let lines = "load.load_steps = [{ time_ms = 0, load_n = 1 }, { time_ms = 10, load_n = 2 }]\n\
                 rotation.factor = [{ time_ms = 0, factor = 1 }, { time_ms = 10, factor = 3 }]";
    let scene = Scene::parse("mine.toml", text(lines)).expect("valid");
    let warnings = scene.warnings();
    let expected = "the run ends at 10 ms, without a sample after the last change of the load at \
                    10 ms; increase time.duration_ms";
    assert_eq!(warnings, [expected]);
}

/// A frame has 256 samples at 200 kHz.
#[test]
fn knots_within_a_frame_are_reported() {
    let warned = |knots: &str| {
        let lines = format!("load.load = [{knots}]");
        let scene = Scene::parse("mine.toml", text(&lines)).expect("valid");
        scene.warnings()
    };
    let steep = "{ time_ms = 1, load_n = 1 }, { time_ms = 1.5, load_n = 2 }";
    assert!(
        warned(steep)[0]
            .contains("a knot at 1.5 ms that follows the previous knot by less than a frame")
    );
    let level = "{ time_ms = 1, load_n = 1 }, { time_ms = 1.5, load_n = 1 }";
    assert!(warned(level).is_empty());
    let frames = "{ time_ms = 1.28, load_n = 1 }, { time_ms = 2.56, load_n = 2 }";
    assert!(warned(frames).is_empty());
}

/// Without rotation the contact sticks.
#[test]
fn the_rotation_can_stop() {
    use crate::pipeline::{Monitor, run};

    let lines = "rotation.factor_steps = [{ time_ms = 0, factor = 0 }, { time_ms = 3, factor = 1 }, \
                 { time_ms = 6, factor = 0 }]";
    let scene = Scene::parse("mine.toml", text(lines)).expect("valid");
    let mut records = Vec::new();
    let summary = run(&scene, "test", &mut records, Monitor::default()).expect("runs");
    assert!(summary.amplitude_m.is_finite());
    let crate::pipeline::message::Record::Header(header) = &records[0] else {
        panic!("the header comes first");
    };
    let speed = header.joint().expect("a joint").sliding_speed;
    assert!(speed > 0.0 && speed.is_finite(), "{speed}");
}
