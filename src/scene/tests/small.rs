//! Scenes with a small system.

use std::f64::consts::TAU;

use crate::scene::*;
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt};

const TIME: &str = "time.duration_ms = 10\n";
const IMPACT: &str = "\
[impact_oscillator]
natural_frequency_hz = 200
drive_amplitude_m_per_s2 = 80
drive_frequency_hz = 560
restitution = 0.8
";
const BELT: &str = "\
[mass_on_belt]
natural_frequency_hz = 400
load_n_per_kg = 210
mu_s = 0.55
mu_d = 0.25
belt_speed_mm_per_s = 10
";
const DAMPED: &str = "\
[damped_contact]
natural_frequency_hz = 150
damping_ratio = 0.01
drive_amplitude_m_per_s2 = 20
drive_frequency_hz = 300
contact_frequency_hz = 600
contact_damping_ratio = 0.25
";

fn scene(tables: &str) -> Scene {
    Scene::parse("small.toml", format!("{TIME}{tables}")).expect("valid")
}

fn refusal(tables: &str) -> String {
    Scene::parse("small.toml", format!("{TIME}{tables}"))
        .expect_err("must be rejected")
        .to_string()
}

#[test]
fn each_table_is_converted_to_si() {
    assert_eq!(
        scene(&format!("{IMPACT}wall_position_um = -3\n")).subject,
        SystemSpec::Small(SmallSystem::ImpactOscillator(ImpactOscillator {
            omega: TAU * 200.0,
            damping: 0.0,
            drive: 80.0,
            drive_omega: TAU * 560.0,
            drive_phase: 0.0,
            wall: -3e-6,
            restitution: 0.8,
        }))
    );
    assert_eq!(
        scene(BELT).subject,
        SystemSpec::Small(SmallSystem::MassOnBelt(MassOnBelt {
            omega: TAU * 400.0,
            damping: 0.0,
            load: 210.0,
            mu_s: 0.55,
            mu_d: 0.25,
            belt: 0.01,
            stribeck: None,
        }))
    );
    let contact = TAU * 600.0;
    assert_eq!(
        scene(DAMPED).subject,
        SystemSpec::Small(SmallSystem::DampedContact(DampedContact {
            omega: TAU * 150.0,
            damping: 0.01,
            drive: 20.0,
            drive_omega: TAU * 300.0,
            drive_phase: 0.0,
            contact_stiffness: contact * contact,
            contact_damping: 0.5 * contact,
        }))
    );
}

#[test]
fn the_initial_state_is_read() {
    let start = "[start]\nposition_um = 20\nvelocity_mm_per_s = -3\nkick_mm_per_s = 0\n";
    let start = scene(&format!("{IMPACT}{start}")).start;
    assert_eq!((start.position, start.velocity), (20e-6, -3e-3));
    assert_eq!(start.kick, 0.0);
    assert_eq!(
        refusal(&format!("{IMPACT}[start]\nposition_um = -1\n")),
        "small.toml:8: `start.position_um`: the initial position -1 µm is below the wall at 0 µm; \
         increase it to at least impact_oscillator.wall_position_um"
    );
    let joint = "[load]\nload_n = 150\ntilt_deg = 2\n[start]\nvelocity_mm_per_s = 1\n";
    assert!(refusal(joint).starts_with(
        "small.toml:6: `start.velocity_mm_per_s`: a ball joint starts at steady sliding"
    ));
}

#[test]
fn a_scene_defines_one_system() {
    assert_eq!(
        refusal(&format!("{IMPACT}{BELT}")),
        "small.toml:7: `mass_on_belt`: a scene defines one system, and [impact_oscillator] \
         already defines one; keep [impact_oscillator] or [mass_on_belt]"
    );
    assert_eq!(
        refusal(&format!("[load]\nload_n = 150\ntilt_deg = 2\n{BELT}")),
        "small.toml:2: `load`: a scene defines one system, and [mass_on_belt] already defines one; \
         keep [mass_on_belt] or [load]"
    );
    for table in [
        "body", "socket", "rotation", "contact", "friction", "damping",
    ] {
        let message = refusal(&format!("{DAMPED}[{table}]\n"));
        assert!(
            message.contains(&format!(":9: `{table}`: a scene defines one system")),
            "{message}"
        );
    }
    let message = refusal(&format!("{DAMPED}[record]\npatch_rate_khz = 1\n"));
    assert!(message.starts_with("small.toml:9: `record`: a small system has neither"));
    let message = refusal(&format!("time.carry = \"displacement\"\n{IMPACT}"));
    assert!(
        message.contains("`time.carry`: a small system has no load"),
        "{message}"
    );
}

#[test]
fn errors_contain_line_and_remedy() {
    assert_eq!(
        refusal(&IMPACT.replace("restitution = 0.8", "restitution = 1.2")),
        "small.toml:6: `impact_oscillator.restitution` = 1.2 is out of range; \
         it must be a number from 0 to 1"
    );
    assert!(
        refusal("[mass_on_belt]\nnatural_frequency_hz = 400\nload_n_per_kg = 210\n")
            .contains(":2: `mass_on_belt.mu_s` is missing; it must be a number from 0 to 10")
    );
    assert!(
        refusal(&BELT.replace("mu_d = 0.25", "mu_d = 0.6"))
            .starts_with("small.toml:6: `mass_on_belt.mu_d`: it exceeds the static coefficient")
    );
    assert!(refusal(&BELT.replace("mu_s", "mu_ss")).contains("did you mean `mass_on_belt.mu_s`?"));
    assert!(
        refusal(&format!(
            "{BELT}[analysis.section]\nplane_q = [1, 1]\ncoordinates = [\"q1\", \"qdot1\"]\n"
        ))
        .contains("the normal has more components than the system has modes (1)")
    );
}

#[test]
fn operations_on_a_joint_are_rejected() {
    let error = scene(BELT).with_tilt(2.0).expect_err("no joint");
    assert_eq!(
        error.to_string(),
        "a ball joint is required, but the scene `small` defines a mass on a belt; choose a scene with \
         a [load] table, such as `tilt-ramp`"
    );
    assert!(scene(BELT).joint_mut().is_err());
    assert!(scene(BELT).warnings().is_empty());
    assert_eq!(scene(BELT).subject.modes(), 1);
    assert!(scene(BELT).with_duration(5.0).is_ok());
}
