//! Optional effects: friction laws, contact damping, convection `Omega x u`.

use crate::joint::{
    ContactDamping, DynamicFriction, Friction, FrictionTable, JointSpec, LuGre, RateAndState,
    Stribeck,
};
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
        Friction::Stribeck {
            law: Stribeck::constant(0.4, 1000.0),
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

const BRISTLES: &str =
    "[friction]\nlaw = \"lugre\"\nmu_s = 0.5\nmu_d = 0.3\nbristle_stiffness_per_m = 1e5\n";
const AGEING: &str = "[friction]\nlaw = \"rate-and-state\"\nmu_0 = 0.5\ndirect_effect = 0.01\n\
     evolution_effect = 0.03\nreference_speed_m_per_s = 0.02\nslip_distance_um = 5\n";

#[test]
fn laws_with_states_are_read() {
    let law = DynamicFriction::LuGre(LuGre {
        mu_s: 0.5,
        mu_d: 0.3,
        stribeck: 10.0,
        stiffness: 1e5,
        damping: 0.0,
        viscous: 0.0,
    });
    let radial = true;
    assert_eq!(spec(BRISTLES).friction, Friction::Dynamic { law, radial });
    let more = "bristle_damping_s_per_m = 2\nviscous_s_per_m = 0.1\nradial = false\n";
    let Friction::Dynamic {
        law: DynamicFriction::LuGre(law),
        radial: false,
    } = spec(&format!("{BRISTLES}{more}")).friction
    else {
        panic!("bristles without the radial component");
    };
    assert_eq!((law.damping, law.viscous), (2.0, 0.1));
    let law = DynamicFriction::RateAndState(RateAndState {
        mu_0: 0.5,
        direct: 0.01,
        evolution: 0.03,
        reference_speed: 0.02,
        distance: 5e-6,
    });
    assert_eq!(spec(AGEING).friction, Friction::Dynamic { law, radial });
}

#[test]
fn what_excludes_laws_with_states_is_reported() {
    let cases = [
        (
            format!("{BRISTLES}creep_slope_s_per_m = 1000\n"),
            "friction.creep_slope_s_per_m",
        ),
        (format!("{BRISTLES}mu_0 = 0.3\n"), "friction.mu_0"),
        (BRISTLES.replace("0.3", "0"), "friction.mu_d"),
        (BRISTLES.replace("mu_s = 0.5\n", ""), "friction.mu_s"),
        (
            BRISTLES.replace("bristle_stiffness_per_m = 1e5\n", ""),
            "friction.bristle_stiffness_per_m",
        ),
        (
            format!("{BRISTLES}[contact]\nnodes = 401\n"),
            "contact.nodes",
        ),
        (
            format!("{AGEING}bristle_stiffness_per_m = 1e5\n"),
            "friction.bristle_stiffness_per_m",
        ),
        (format!("{AGEING}mu_s = 0.5\n"), "friction.mu_s"),
        (AGEING.replace("0.01", "0.001"), "friction.direct_effect"),
        (
            AGEING.replace(
                "reference_speed_m_per_s = 0.02",
                "reference_speed_m_per_s = 1e-320",
            ),
            "friction.reference_speed_m_per_s",
        ),
        (
            AGEING.replace("slip_distance_um = 5\n", ""),
            "friction.slip_distance_um",
        ),
        (
            format!("{SLIDING}viscous_s_per_m = 1\n"),
            "friction.viscous_s_per_m",
        ),
        (
            format!("{SLIDING}evolution_effect = 0.1\n"),
            "friction.evolution_effect",
        ),
    ];
    for (added, key) in cases {
        let message = refusal(&added);
        assert!(message.contains(key), "{added}: {message}");
    }
}

const SLIDING: &str = "[friction]\nmu_s = 0.5\nmu_d = 0.3\n";

/// A scene in a folder with a file of a measured friction curve.
fn with_curve(content: &str) -> (tempfile::TempDir, Result<Scene, SceneError>) {
    let folder = tempfile::tempdir().expect("temporary folder");
    std::fs::write(folder.path().join("mu.csv"), content).expect("written");
    let path = folder.path().join("mine.toml");
    let friction = "[friction]\nlaw = \"table\"\npoints_csv = \"mu.csv\"\n";
    std::fs::write(&path, format!("{SMALLEST}{friction}")).expect("written");
    let scene = Scene::load(path.to_str().expect("UTF-8"));
    (folder, scene)
}

#[test]
fn measured_curves_are_read_from_the_scene_and_from_files() {
    let listed = spec(
        "[friction]\nlaw = \"table\"\ncreep_slope_s_per_m = 500\nradial = false\n\
         points = [{ speed_m_per_s = 0, mu = 0.5 }, { speed_m_per_s = 0.25, mu = 0.3 }]\n",
    );
    let law = FrictionTable::new(vec![[0.0, 0.5], [0.25, 0.3]], 500.0).unwrap();
    let law = std::sync::Arc::new(law);
    let radial = false;
    assert_eq!(listed.friction, Friction::Table { law, radial });

    let (_folder, scene) = with_curve("speed_m_per_s, mu\n0.001,0.5 # rest\n\n0.25, 0.3\n");
    let scene = scene.expect("valid");
    let Friction::Table { law, radial } = &scene.joint().unwrap().spec.friction else {
        panic!("{:?}", scene.joint());
    };
    assert_eq!(
        (law.points(), law.creep()),
        (&[[0.001, 0.5], [0.25, 0.3]][..], 1000.0)
    );
    assert!(radial);
    // The text contains the points instead of the name of the file.
    assert!(!scene.text.contains("points_csv"), "{}", scene.text);
    assert!(
        scene
            .text
            .ends_with("# friction.points was read from \"mu.csv\"\n")
    );
    let again = Scene::parse("elsewhere.toml", &scene.text).unwrap();
    assert_eq!(again.joint().unwrap().spec, scene.joint().unwrap().spec);
}

#[test]
fn invalid_curves_are_reported_with_file_and_line() {
    let cases = [
        (
            "V,mu\n0,1\n",
            "1: `friction.points_csv`: the first line does not contain the names of the columns; begin with the line `speed_m_per_s,mu`",
        ),
        (
            "speed_m_per_s,mu\n",
            "1: `friction.points_csv`: the file contains no knot",
        ),
        (
            "speed_m_per_s,mu\n0,0.5\n0,0.4\n",
            "3: `friction.points.speed_m_per_s`: this speed is not higher than the previous speed; sort the speeds in strictly increasing order",
        ),
        (
            "speed_m_per_s,mu\n0,-0.5\n",
            "2: `friction.points.mu` = `-0.5` is out of range",
        ),
    ];
    for (content, expected) in cases {
        let (folder, scene) = with_curve(content);
        let message = scene.expect_err("rejected").to_string();
        let place = folder.path().join("mu.csv").display().to_string();
        assert!(
            message.starts_with(&format!("{place}:{expected}")),
            "{message}"
        );
    }
    let point = "points = [{ speed_m_per_s = 0.1, mu = 0.5 }]";
    for (lines, expected) in [
        ("law = \"table\"".to_owned(), "`friction.points` is missing"),
        (
            format!("law = \"table\"\n{point}\npoints_csv = \"mu.csv\""),
            "the scene gives the friction curve more than once; keep one of friction.points and friction.points_csv",
        ),
        (
            format!("law = \"table\"\nmu = 0.3\n{point}"),
            "`friction.mu`: the selected law",
        ),
        (
            format!("mu_s = 0.5\nmu_d = 0.3\n{point}"),
            "`friction.points`: the selected law",
        ),
        (
            "law = \"table\"\n\
             points = [{ speed_m_per_s = 0, mu = 0.5 }, { speed_m_per_s = 1e-300, mu = 0.4 }]"
                .to_owned(),
            "`friction.points`: two speeds are so close",
        ),
        (
            "law = \"table\"\npoints = []".to_owned(),
            "`friction.points` = [] is out of range",
        ),
    ] {
        let message = refusal(&format!("[friction]\n{lines}\n"));
        assert!(message.contains(expected), "{message}");
    }
    assert!(Parameter::named("friction.points.mu").is_err());
}

/// A ball joint with a shell of plastic, whose patch is wide.
fn shell(load: f64, added: &str) -> Result<Scene, SceneError> {
    let text = format!(
        "[body]\nball_diameter_mm = 27\nbeam_diameter_mm = 12\nbeam_length_mm = 60\nfrequencies = \"fe\"\n\
         [socket]\ndiameter_mm = 27.1\nyoungs_modulus_gpa = 2.8\npoissons_ratio = 0.35\n\
         [load]\nload_n = {load}\ntilt_deg = 0\n[contact]\n{added}\n[time]\nduration_ms = 1\n"
    );
    Scene::parse("shell.toml", text)
}

#[test]
fn a_wide_hertz_patch_is_reported_and_a_wider_one_refused() {
    use crate::joint::BallJoint;

    assert!(shell(50.0, "").unwrap().warnings().is_empty());
    let scene = shell(400.0, "").unwrap();
    let warnings = scene.warnings();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("as contact.pressure"), "{warnings:?}");
    let spec = &scene.joint().unwrap().spec;
    let half_angle = spec.hertz_half_angle(400.0).unwrap();
    let lost_load = spec.lost_load(half_angle);
    let model = BallJoint::new(spec).unwrap().model(0.0).unwrap();
    let forces = model
        .areas
        .iter()
        .zip(&model.pre_stress)
        .map(|(area, p)| area * p);
    let along: f64 = forces
        .zip(&model.normals)
        .map(|(force, normal)| force * normal[2])
        .sum();
    assert!(
        (along / 400.0 - (1.0 - lost_load)).abs() < 1e-12,
        "{along} {lost_load}"
    );
    assert!(
        half_angle > 20_f64.to_radians() && lost_load > 0.03,
        "{half_angle} {lost_load}"
    );
    let refused = shell(3000.0, "").unwrap_err().to_string();
    assert!(
        refused.contains("90 degrees") && refused.contains("contact.pressure"),
        "{refused}"
    );
}

#[test]
fn a_pressure_over_the_radius_carries_the_load_along_its_direction() {
    use crate::joint::BallJoint;

    let pressure = "pressure = [{radius_mm = 0, pressure_mpa = 9}, {radius_mm = 6, pressure_mpa = 10}, {radius_mm = 12, pressure_mpa = 0}]";
    let scene = shell(3000.0, pressure).unwrap();
    assert!(scene.warnings().is_empty());
    for distribution in ["uniform", "pre-stress"] {
        let scene = scene
            .with_overrides(&[("stiffness_distribution", distribution)])
            .unwrap();
        let spec = &scene.joint().unwrap().spec;
        let model = BallJoint::new(spec).unwrap().model(0.0).unwrap();
        let sum = |of: &dyn Fn(usize) -> f64| (0..model.nodes()).map(of).sum::<f64>();
        let along = sum(&|k| model.areas[k] * model.pre_stress[k] * model.normals[k][2]);
        assert!((along / 3000.0 - 1.0).abs() < 1e-12, "{along}");
        let crate::joint::BodySpec::BallOnBeam(body) = &spec.body else {
            panic!("a ball on a beam");
        };
        let hertz = body.hertz(&spec.socket, 3000.0);
        let stiffness = sum(&|k| model.areas[k] * model.stiffness[k]);
        assert!(
            (stiffness / hertz.stiffness - 1.0).abs() < 1e-12,
            "{stiffness}"
        );
    }
    for (added, expected) in [
        (
            "pressure = [{radius_mm = 0, pressure_mpa = 9}]",
            "at least two",
        ),
        (
            "pressure = [{radius_mm = 1, pressure_mpa = 9}, {radius_mm = 2, pressure_mpa = 1}]",
            "radius_mm = 0",
        ),
        (
            "pressure = [{radius_mm = 0, pressure_mpa = 9}, {radius_mm = 0, pressure_mpa = 1}]",
            "not larger",
        ),
        (
            "pressure = [{radius_mm = 0, pressure_mpa = 9}, {radius_mm = 13.4, pressure_mpa = 1}]",
            "at most at 13.23 mm",
        ),
        (
            "radius_factor = 2\npressure = [{radius_mm = 0, pressure_mpa = 9}, {radius_mm = 2, pressure_mpa = 1}]",
            "remove this key",
        ),
    ] {
        let refused = shell(3000.0, added).unwrap_err().to_string();
        assert!(refused.contains(expected), "{refused}");
    }
}
