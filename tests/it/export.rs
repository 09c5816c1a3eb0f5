//! The NumPy files contain all numbers of the model and of a run.

use std::collections::BTreeMap;

use squeakscope::dynamics::System;
use squeakscope::export::{SamplesSink, encode_model, replace_file};
use squeakscope::joint::{
    BallJoint, ContactDamping, Friction, FrictionTable, Joint, Model, Stribeck,
};
use squeakscope::numpy::{Array, read_npz};
use squeakscope::pipeline::{Monitor, initial_state, run};
use squeakscope::scene::Scene;

fn scene() -> Scene {
    Scene::load("doubled-torus-3deg")
        .unwrap()
        .with_duration(5.0)
        .unwrap()
}

/// The arrays that another program reads.
fn written(model: &Model) -> BTreeMap<String, Array> {
    let file = tempfile::NamedTempFile::new().unwrap();
    replace_file(file.path(), |file| encode_model(file, model, &[0.0; 22])).unwrap();
    read_npz(file.path()).unwrap()
}

#[test]
fn a_model_is_written_with_all_its_numbers() {
    let scene = scene();
    let spec = &scene.joint().unwrap().spec;
    let model = BallJoint::new(spec)
        .unwrap()
        .model(scene.joint().unwrap().tilt.at(0.0))
        .unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    let start = initial_state(&scene, 11);
    let q_eq = Joint::new(&model).equilibrium().q.clone();
    replace_file(file.path(), |file| encode_model(file, &model, &start)).unwrap();
    let raw = read_npz(file.path()).unwrap();
    let n = model.areas.len();
    for (name, shape, values) in [
        ("version", &[][..], &[1.0][..]),
        ("positions", &[n, 3], model.positions.as_flattened()),
        ("normals", &[n, 3], model.normals.as_flattened()),
        ("areas", &[n], &model.areas),
        ("pre_stress", &[n], &model.pre_stress),
        ("stiffness", &[n], &model.stiffness),
        ("omega", &[11], &model.omega),
        // Absent damping is written as zeros.
        ("damping", &[11], &[0.0; 11]),
        (
            "sliding_velocity",
            &[n, 3],
            model.sliding_velocity.as_flattened(),
        ),
        ("friction", &[4], &[0.55, 0.25, 1000.0, 13.25]),
        (
            "radial",
            &[],
            &[f64::from(u8::from(model.friction.radial()))],
        ),
        ("unilateral", &[], &[1.0]),
        ("q_eq", &[11], &q_eq),
        ("probe", &[11], &model.probe),
        ("z0", &[22], &start),
    ] {
        assert_eq!(
            (&raw[name].shape[..], &raw[name].values[..]),
            (shape, values),
            "{name}"
        );
    }
    // Rows that multiply q.
    let shapes = &raw["shapes"];
    assert_eq!(shapes.shape, [n, 3, 11]);
    for (k, shape) in model.shapes.iter().enumerate() {
        let (node, mode) = (k / 11, k % 11);
        let column: [f64; 3] =
            std::array::from_fn(|axis| shapes.values[(3 * node + axis) * 11 + mode]);
        assert_eq!(column, *shape, "node {node}, mode {mode}");
    }
    let load: f64 = (model.areas.iter().zip(&model.pre_stress))
        .map(|(a, p)| a * p)
        .sum();
    assert!((load / 150.0 - 1.0).abs() < 1e-12);
}

#[test]
fn effects_and_other_friction_laws_have_their_own_arrays() {
    let mut scene = scene();
    let spec = &mut scene.joint_mut().unwrap().spec;
    spec.friction = Friction::None;
    spec.contact.unilateral = false;
    let model = BallJoint::new(&scene.joint().unwrap().spec)
        .unwrap()
        .model(0.0)
        .unwrap();
    let raw = written(&model);
    assert_eq!(raw["friction"].values, [0.0; 4]);
    assert_eq!(raw["unilateral"].values, [0.0]);
    for name in ["contact_damping", "convection", "friction_points", "lugre"] {
        assert!(!raw.contains_key(name), "{name}");
    }
    let effects = Model {
        friction: Friction::Stribeck {
            law: Stribeck::constant(0.3, 500.0),
            radial: false,
        },
        convection: Some([0.1, 0.2, 0.3]),
        ..model
    };
    for (contact_damping, expected) in [
        (ContactDamping::KelvinVoigt { time: 1e-7 }, [1e-7, 0.0]),
        (
            ContactDamping::HuntCrossley { dissipation: 2.0 },
            [0.0, 2.0],
        ),
    ] {
        let raw = written(&Model {
            contact_damping,
            ..effects.clone()
        });
        assert_eq!(raw["contact_damping"].values, expected);
        assert_eq!(raw["friction"].values, [0.3, 0.3, 500.0, 0.0]);
        assert_eq!(raw["radial"].values, [0.0]);
        assert_eq!(raw["convection"].values, [0.1, 0.2, 0.3]);
    }
    let law = FrictionTable::new(vec![[0.001, 0.5], [0.2, 0.3]], 800.0).unwrap();
    let raw = written(&Model {
        friction: Friction::Table {
            law: std::sync::Arc::new(law),
            radial: true,
        },
        ..effects
    });
    assert_eq!(raw["friction_points"].shape, [2, 2]);
    assert_eq!(raw["friction_points"].values, [0.001, 0.5, 0.2, 0.3]);
    assert!(raw["friction"].values[0].is_nan());
    assert_eq!(raw["friction"].values[2], 800.0);
    assert_eq!(raw["radial"].values, [1.0]);
}

/// The samples start at `z0`, end one sample before the duration, and satisfy `u = probe . q`.
#[test]
fn samples_fit_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.npz");
    let scene = scene();
    let mut sink = SamplesSink::new(path.clone());
    run(&scene, "test", &mut sink, Monitor::default()).unwrap();
    let arrays = read_npz(&path).unwrap();
    let joint: Joint = BallJoint::new(&scene.joint().unwrap().spec)
        .unwrap()
        .joint(scene.joint().unwrap().tilt.at(0.0))
        .unwrap();
    let m = joint.modes();
    assert_eq!(arrays["q"].shape, [1000, m]);
    assert_eq!(arrays["qdot"].shape, [1000, m]);
    let z0: Vec<f64> = [&arrays["q"].values[..m], &arrays["qdot"].values[..m]].concat();
    assert_eq!(z0, initial_state(&scene, m));
    assert_eq!(arrays["t"].values[0], 0.0);
    assert!((arrays["t"].values[999] - 4.995e-3).abs() < 1e-15);
    for k in [0, 499, 999] {
        let u = joint.probe_value(&arrays["q"].values[k * m..][..m]);
        let v = joint.probe_value(&arrays["qdot"].values[k * m..][..m]);
        assert_eq!((arrays["u"].values[k], arrays["v"].values[k]), (u, v));
        assert!((arrays["tilt_deg"].values[k] - 3.0).abs() < 1e-12);
    }
}
