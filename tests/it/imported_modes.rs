//! Imported modes and contact patch: a file written by `model` reproduces its joint, inconsistent scenes are rejected
//! with one message, and a body from another program squeals.

use std::fs;
use std::path::{Path, PathBuf};

use squeakscope::export::{encode_model, replace_file};
use squeakscope::joint::{BallJoint, Model};
use squeakscope::numpy::{encode_npz, read_npz};
use squeakscope::pipeline::message::Record;
use squeakscope::pipeline::{Monitor, initial_state, run};
use squeakscope::scene::{Parameter, Scene};
use squeakscope::study::stability;

/// Load, friction, initial state and duration of a scene, without the body.
const REST: &str = "
[load]
load_n = 150
azimuth_deg = 30
tilt_deg = 3.0

[friction]
mu_s = 0.55
mu_d = 0.25
stribeck_slope_s_per_m = 13.25

[start]
kick_mm_per_s = 3

[time]
duration_ms = 6
";

/// A folder with `beam.toml`, which has a finite-element body, and `own.toml`, which imports its modes from the model
/// of the first.
struct TestFolder {
    folder: tempfile::TempDir,
}

fn write_model(path: &Path, model: &Model, start: &[f64]) {
    replace_file(path, |file| encode_model(file, model, start)).unwrap();
}

impl TestFolder {
    fn new() -> Self {
        let folder = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        let meshed = "[contact]\nnodes = 60\nquadrature = \"gauss\"\nstiffness_factor = 2.75\n";
        folder.put("beam.toml", &format!("{meshed}{REST}"));
        folder.put("own.toml", &format!("body.modes = \"modes.npz\"\n{REST}"));
        let scene = folder.scene("beam.toml");
        write_model(&folder.path("modes.npz"), &model(&scene), &state(&scene));
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn put(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn load(&self, name: &str) -> Result<Scene, String> {
        let path = self.path(name);
        Scene::load(path.to_str().unwrap()).map_err(|error| error.to_string())
    }

    fn scene(&self, name: &str) -> Scene {
        self.load(name).unwrap()
    }

    /// Error message for `own.toml` with a replacement.
    fn refusal(&self, from: &str, to: &str) -> String {
        let text = fs::read_to_string(self.path("own.toml")).unwrap();
        assert!(text.contains(from), "{text}");
        self.put("other.toml", &text.replace(from, to));
        self.load("other.toml").expect_err("rejected")
    }
}

fn model(scene: &Scene) -> Model {
    let joint = scene.joint().unwrap();
    let ball = BallJoint::new(&joint.spec).unwrap();
    ball.model(joint.tilt.at(0.0)).unwrap()
}

fn state(scene: &Scene) -> Vec<f64> {
    initial_state(scene, scene.subject.modes())
}

fn records(scene: &Scene) -> Vec<Record> {
    let mut sink = Vec::new();
    run(scene, "test", &mut sink, Monitor::default()).unwrap();
    sink
}

/// Samples and energies of a run. The shown nodes differ: a file fixes its nodes, the ball has more in rings.
fn motion(records: &[Record]) -> Vec<String> {
    let frames = records.iter().filter_map(|record| match record {
        Record::Samples(frame) => Some(format!(
            "{:?} {:?} {:?} {:?}",
            frame.q, frame.qdot, frame.velocity, frame.energy
        )),
        _ => None,
    });
    frames.collect()
}

/// Model, eigenvalues and motion are bit-identical.
#[test]
fn an_exported_model_reproduces_its_joint() {
    let folder = TestFolder::new();
    let (beam, own) = (folder.scene("beam.toml"), folder.scene("own.toml"));
    assert_eq!(model(&own), model(&beam));
    assert_eq!(own.subject.modes(), 11);
    let growth = |scene: &Scene| -> Vec<[f64; 2]> {
        let joint = scene.joint().unwrap();
        let ball = BallJoint::new(&joint.spec).unwrap();
        let found = stability(&ball, &[joint.tilt.at(0.0)]).unwrap();
        let modes = found[0].modes.iter();
        modes.map(|mode| [mode.frequency_hz, mode.growth]).collect()
    };
    assert_eq!(growth(&own), growth(&beam));
    let (of_beam, of_own) = (records(&beam), records(&own));
    let frames = motion(&of_beam);
    assert!(frames.len() >= 4);
    assert_eq!(motion(&of_own), frames);
    // Exporting again gives the same file.
    let again = folder.path("again.npz");
    write_model(&again, &model(&own), &state(&own));
    assert_eq!(
        fs::read(again).unwrap(),
        fs::read(folder.path("modes.npz")).unwrap()
    );
    // The file contains no surface of the body.
    let outline = |records: &[Record]| match &records[0] {
        Record::Header(header) => header.joint().unwrap().outline.vertices.len(),
        _ => panic!("no header"),
    };
    assert!(outline(&of_beam) > 100);
    assert_eq!(outline(&of_own), 0);
}

/// Without a probe row the probe is the central node of the patch, like that of the finite-element body.
#[test]
fn the_default_probe_is_the_centre_of_the_patch() {
    let folder = TestFolder::new();
    let rings = "[contact]\nnodes = 61\nquadrature = \"rings\"\n";
    folder.put("rings.toml", &format!("{rings}{REST}"));
    let beam = model(&folder.scene("rings.toml"));
    let path = folder.path("modes.npz");
    write_model(&path, &beam, &[0.0; 22]);
    let arrays = read_npz(&path).unwrap();
    let kept = arrays.iter().filter(|(name, _)| *name != "probe");
    let kept: Vec<_> = kept
        .map(|(name, array)| (name.as_str(), array.clone()))
        .collect();
    encode_npz(std::fs::File::create(&path).unwrap(), &kept).unwrap();
    let found = model(&folder.scene("own.toml")).probe;
    for (found, expected) in found.iter().zip(&beam.probe) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn inconsistent_scenes_are_rejected() {
    let folder = TestFolder::new();
    let assert_rejected = |from: &str, to: &str, words: [&str; 2]| {
        let message = folder.refusal(from, to);
        for words in words {
            assert!(message.contains(words), "{message}");
        }
    };
    let ramp = "tilt = [{ time_ms = 0, tilt_deg = 3 }, { time_ms = 5, tilt_deg = 3.01 }]";
    assert_rejected(
        "tilt_deg = 3.0",
        ramp,
        [
            "one load and tilt only, which change with time",
            "remove body.modes",
        ],
    );
    assert_rejected(
        "load_n = 150",
        "load_sine = { mean_n = 150, amplitude_n = 1, frequency_hz = 10 }",
        [
            "one load and tilt only, which change with time",
            "set a constant load.tilt_deg and load.load_n",
        ],
    );
    assert_rejected(
        "tilt_deg = 3.0",
        "tilt_deg = 3.5",
        ["toml:6: `body.modes`: modes.npz", "tilt of 3.000 deg"],
    );
    assert_rejected(
        "azimuth_deg = 30",
        "azimuth_deg = 40",
        ["azimuth 30.000 deg", "create a file for each"],
    );
    assert_rejected(
        "load_n = 150",
        "load_n = 160",
        ["is 150.000000 N", "load of the scene is 160 N"],
    );
    for line in [
        "body.torsion_modes = 1",
        "body.ball_diameter_mm = 32",
        "socket.youngs_modulus_gpa = 70",
        "contact.nodes = 60",
        "contact.quadrature = \"gauss\"",
        "contact.stiffness_distribution = \"pre-stress\"",
        "contact.radius_factor = 1.0",
    ] {
        let key = line.split(' ').next().unwrap();
        let place = format!("toml:1: `{key}`: body.modes imports");
        assert_rejected(
            "body.modes",
            &format!("{line}\nbody.modes"),
            [&place, "remove this key"],
        );
    }
    let missing = folder.path("none.npz").display().to_string();
    assert_rejected("modes.npz", "none.npz", [&missing, "check its path"]);
    assert_rejected(
        "modes.npz",
        "own.toml",
        ["toml:1: `body.modes`: ", "write it with numpy.savez"],
    );
    assert_rejected(
        "\n[start]",
        "[damping]\nratio = [0.1]\n\n[start]",
        ["1 ratios for 11 modes", "one ratio for each"],
    );
}

/// Changes that keep the imported modes, and operations that require the mesh.
#[test]
fn other_tilts_are_rejected_for_imported_modes() {
    let folder = TestFolder::new();
    let scene = folder.scene("own.toml");
    assert!(scene.clone().with_tilt(3.05).is_ok());
    let message = scene.clone().with_tilt(2.0).unwrap_err().to_string();
    assert!(
        message.contains("differs by 1.000 deg from the load"),
        "{message}"
    );
    let message = scene.ball_on_beam().unwrap_err().to_string();
    assert!(
        message.contains("imports them from `modes.npz`"),
        "{message}"
    );
    // Assembly also checks the tilt.
    let joint = scene.joint().unwrap();
    let ball = BallJoint::new(&joint.spec).unwrap();
    let message = ball.model(0.0).unwrap_err().to_string();
    assert!(
        message.contains("the modes of `modes.npz` are invalid for this load"),
        "{message}"
    );
    assert!(
        ball.body()
            .unwrap_err()
            .to_string()
            .contains("without body.modes")
    );
    // A sweep reads the file once.
    fs::remove_file(folder.path("modes.npz")).unwrap();
    let factor = Parameter::named("stiffness_factor").unwrap();
    let stiff = scene.with_values(&[(factor, 2.0)]).unwrap();
    let (before, after) = (model(&scene), model(&stiff));
    assert_eq!(after.shapes, before.shapes);
    assert_eq!(after.stiffness[7], 2.0 * before.stiffness[7]);
    let load = Parameter::named("load_n").unwrap();
    assert!(scene.with_values(&[(load, 100.0)]).is_err());
}

/// A sweep table cannot be resumed with other modes.
#[test]
fn the_identity_of_a_sweep_includes_its_modes() {
    use squeakscope::study::response::ResponsePlan;
    use squeakscope::study::sweep::{Axis, Start, SweepPlan};
    let folder = TestFolder::new();
    let plan = |scene: Scene| SweepPlan {
        subject: scene,
        axes: vec![Axis::new(
            Parameter::named("stiffness_factor").unwrap(),
            [1.0, 2.0],
        )],
        starts: vec![Start::Fresh],
        response: ResponsePlan::default(),
    };
    let before = plan(folder.scene("own.toml")).identity();
    assert_eq!(plan(folder.scene("own.toml")).identity(), before);
    let path = folder.path("modes.npz");
    let mut arrays = read_npz(&path).unwrap();
    arrays.get_mut("omega").unwrap().values[10] *= 1.001;
    let arrays: Vec<_> = arrays
        .iter()
        .map(|(name, array)| (name.as_str(), array.clone()))
        .collect();
    encode_npz(std::fs::File::create(&path).unwrap(), &arrays).unwrap();
    assert_ne!(plan(folder.scene("own.toml")).identity(), before);
    assert!(
        !plan(folder.scene("beam.toml"))
            .identity()
            .contains("modes = ")
    );
}

fn hip() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_modes/hip.toml");
    Scene::load(path.to_str().unwrap()).unwrap()
}

/// The modes from scikit-fem: the only unstable mode dominates the vibration.
#[test]
fn a_body_from_another_program_squeals() {
    let scene = hip();
    let joint = scene.joint().unwrap();
    let ball = BallJoint::new(&joint.spec).unwrap();
    assert_eq!(ball.mode_labels()[11], "mode 12");
    assert!((ball.ball_radius() - 16e-3).abs() < 1e-9);
    let found = stability(&ball, &[joint.tilt.at(0.0)]).unwrap();
    let [unstable] = found[0].unstable().collect::<Vec<_>>()[..] else {
        panic!("{found:?}")
    };
    assert!(
        (unstable.frequency_hz - 11.3e3).abs() < 20.0,
        "{unstable:?}"
    );
    assert!((100.0..150.0).contains(&unstable.growth), "{unstable:?}");
    let records = records(&scene);
    let Some(Record::Summary(summary)) = records.last() else {
        panic!("no summary")
    };
    let loudest = &summary.lines[0];
    assert!((loudest.frequency - 11.3e3).abs() < 20.0, "{loudest:?}");
    assert!((7e-3..11e-3).contains(&loudest.amplitude), "{loudest:?}");
    let Record::Header(header) = &records[0] else {
        panic!("no header")
    };
    let outline = &header.joint().unwrap().outline;
    assert_eq!(outline.shapes.len(), 12 * outline.vertices.len());
}

/// Recordings with and without a surface of the body.
#[cfg(feature = "record")]
#[test]
fn recordings_are_readable() {
    use squeakscope::record::{Output, RerunSink, paths, read_series};
    let folder = TestFolder::new();
    let path = folder.path("run.rrd");
    for (scene, samples) in [
        (folder.scene("own.toml"), 1200),
        (hip().with_duration(6.0).unwrap(), 1200),
    ] {
        let output = Output {
            save: Some(path.clone()),
            ..Output::default()
        };
        let mut sink = RerunSink::new(&output, scene.record).unwrap();
        run(&scene, "test", &mut sink, Monitor::default()).unwrap();
        let series = read_series(&path, Some(paths::DISPLACEMENT)).unwrap();
        assert_eq!(series.values.len(), samples);
    }
}
