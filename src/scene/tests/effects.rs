//! Optional effects: friction laws, contact damping, convection `Omega x u`.

use crate::joint::{Constant, ContactDamping, Friction, JointSpec};
use crate::scene::*;

const SMALLEST: &str = "[load]\nload_n = 150\ntilt_deg = 2\n[time]\nduration_ms = 1\n";

fn spec(added: &str) -> JointSpec {
    let scene = Scene::parse("mine.toml", format!("{SMALLEST}{added}")).unwrap();
    scene.joint().unwrap().spec.clone()
}

fn refusal(added: &str) -> String {
    let refused = Scene::parse("mine.toml", format!("{SMALLEST}{added}"));
    refused.expect_err("must be rejected").to_string()
}

#[test]
fn absent_tables_disable_effects() {
    let spec = spec("");
    assert_eq!(spec.friction, Friction::None);
    assert_eq!(spec.contact.damping, ContactDamping::None);
    assert!(!spec.convection && spec.damping.is_empty());
}

#[test]
fn each_law_reads_its_parameters() {
    assert_eq!(
        spec("[friction]\nlaw = \"constant\"\nmu = 0.4\nradial = false\n").friction,
        Friction::Constant {
            law: Constant {
                mu: 0.4,
                creep: 1000.0
            },
            radial: false
        }
    );
    assert_eq!(
        spec("[friction]\nlaw = \"none\"\n").friction,
        Friction::None
    );
    assert_eq!(
        spec("[contact_damping]\nlaw = \"kelvin-voigt\"\nretardation_time_us = 0.5\n")
            .contact
            .damping,
        ContactDamping::KelvinVoigt { time: 0.5e-6 }
    );
    assert_eq!(
        spec("[contact_damping]\nlaw = \"hunt-crossley\"\ndissipation_s_per_m = 2\n")
            .contact
            .damping,
        ContactDamping::HuntCrossley { dissipation: 2.0 }
    );
    assert!(spec("[rotation]\nconvection = true\n").convection);
}

#[test]
fn parameters_of_other_laws_are_rejected() {
    let cases = [
        ("[friction]\nlaw = \"constant\"\n", "friction.mu"),
        ("[friction]\nmu_s = 0.5\n", "friction.mu_d"),
        (
            "[friction]\nlaw = \"constant\"\nmu = 0.4\nmu_s = 0.5\n",
            "friction.mu_s",
        ),
        (
            "[friction]\nmu_s = 0.5\nmu_d = 0.3\nmu = 0.4\n",
            "friction.mu",
        ),
        (
            "[friction]\nlaw = \"none\"\ncreep_slope_s_per_m = 10\n",
            "friction.creep_slope_s_per_m",
        ),
        (
            "[contact_damping]\nretardation_time_us = 1\n",
            "contact_damping.law",
        ),
        (
            "[contact_damping]\nlaw = \"kelvin-voigt\"\ndissipation_s_per_m = 1\n",
            "contact_damping.dissipation_s_per_m",
        ),
        (
            "[contact_damping]\nlaw = \"hunt-crossley\"\n",
            "contact_damping.dissipation_s_per_m",
        ),
    ];
    for (added, key) in cases {
        let message = refusal(added);
        assert!(
            message.starts_with("mine.toml:") && message.contains(&format!("`{key}`")),
            "{added}: {message}"
        );
    }
}
