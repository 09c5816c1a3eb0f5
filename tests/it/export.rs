//! The NumPy files: reading returns the written data, which suffice to integrate the same model.

use squeakscope::dynamics::System;
use squeakscope::export::{ModelArrays, SamplesSink, read_model, write_model};
use squeakscope::joint::{
    BallJoint, Constant, ContactDamping, Friction, FrictionTable, Joint, Model,
};
use squeakscope::numpy::{encode_npz, read_npz};
use squeakscope::pipeline::{Monitor, initial_state, run};
use squeakscope::scene::Scene;

fn scene() -> Scene {
    Scene::load("torus-3deg")
        .unwrap()
        .with_duration(5.0)
        .unwrap()
}

#[test]
fn a_model_is_read_back_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.npz");
    let scene = scene();
    let model = BallJoint::new(&scene.joint().unwrap().spec)
        .unwrap()
        .model(scene.joint().unwrap().tilt.at(0.0))
        .unwrap();
    let arrays = ModelArrays::new(model, initial_state(&scene, 11));
    write_model(&path, &arrays).unwrap();
    let mut back = read_model(&path).unwrap();
    // Absent damping is written as zeros.
    assert_eq!(back.model.damping, [0.0; 11]);
    back.model.damping.clear();
    assert_eq!(back, arrays);
    // The documented shapes, as another program reads them.
    let raw = read_npz(&path).unwrap();
    let shape = |name: &str| raw[name].shape.clone();
    assert_eq!(shape("version"), [0; 0]);
    assert_eq!(shape("shapes"), [100, 3, 11]);
    for name in ["positions", "normals", "sliding_velocity"] {
        assert_eq!(shape(name), [100, 3], "{name}");
    }
    for name in ["areas", "pre_stress", "stiffness"] {
        assert_eq!(shape(name), [100], "{name}");
    }
    for name in ["omega", "damping", "q_eq", "probe"] {
        assert_eq!(shape(name), [11], "{name}");
    }
    assert_eq!((shape("friction"), shape("z0")), (vec![4], vec![22]));
    assert_eq!(raw["friction"].values, [0.55, 0.25, 1000.0, 13.25]);
    let load: f64 = raw["areas"]
        .values
        .iter()
        .zip(&raw["pre_stress"].values)
        .map(|(a, p)| a * p)
        .sum();
    assert!((load / 150.0 - 1.0).abs() < 1e-12);
}

/// A model without friction, and a file with a missing array.
#[test]
fn other_models_and_incomplete_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.npz");
    let mut scene = scene();
    let spec = &mut scene.joint_mut().unwrap().spec;
    spec.friction = Friction::None;
    spec.contact.unilateral = false;
    let model = BallJoint::new(&scene.joint().unwrap().spec)
        .unwrap()
        .model(0.0)
        .unwrap();
    write_model(&path, &ModelArrays::new(model.clone(), vec![0.0; 22])).unwrap();
    let back = read_model(&path).unwrap().model;
    assert_eq!((back.friction, back.unilateral), (Friction::None, false));
    let level = Constant {
        mu: 0.3,
        creep: 500.0,
    };
    let effects = Model {
        friction: Friction::Constant {
            law: level,
            radial: false,
        },
        convection: Some([0.1, 0.2, 0.3]),
        ..model
    };
    for contact_damping in [
        ContactDamping::KelvinVoigt { time: 1e-7 },
        ContactDamping::HuntCrossley { dissipation: 2.0 },
    ] {
        let model = Model {
            contact_damping,
            ..effects.clone()
        };
        write_model(&path, &ModelArrays::new(model.clone(), vec![0.0; 22])).unwrap();
        let back = read_model(&path).unwrap().model;
        assert_eq!(
            (back.friction, back.contact_damping, back.convection),
            (model.friction, contact_damping, model.convection)
        );
    }
    let law = FrictionTable::new(vec![[0.001, 0.5], [0.2, 0.3]], 800.0).unwrap();
    let measured = Model {
        friction: Friction::Table {
            law: std::sync::Arc::new(law),
            radial: true,
        },
        ..effects
    };
    write_model(&path, &ModelArrays::new(measured.clone(), vec![0.0; 22])).unwrap();
    let back = read_model(&path).unwrap().model;
    assert_eq!(back.friction, measured.friction);
    std::fs::write(&path, b"not a zip").unwrap();
    assert!(read_model(&path).is_err());
    encode_npz(std::fs::File::create(&path).unwrap(), &[]).unwrap();
    let fault = read_model(&path).unwrap_err();
    assert!(fault.to_string().contains("`areas` is missing"), "{fault}");
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
