//! What the commands call of the rest of the crate: the only place where the command line meets
//! the pipeline and the joint.

use std::io::Cursor;

use super::error::Cause;
use super::model::ModelFile;
use super::report::ModeReport;
use super::run::{Job, Viewer};
use crate::export::{ModelArrays, SamplesSink, encode_model};
use crate::joint::BallJoint;
use crate::pipeline::message::Summary;
use crate::pipeline::{Monitor, Simulation, Sink, Tee, drive, initial_state};
use crate::record::{Output, RerunSink};
use crate::scene::Scene;
use crate::study;

/// Runs a scene down the road: simulation, analysis, recording.
pub(super) fn simulate(job: &Job<'_>) -> Result<Summary, Cause> {
    // Before anything is opened: what is wrong with the joint leaves nothing behind.
    let simulation = Simulation::new(job.scene)?;
    let output = Output {
        save: job.save.map(Into::into),
        connect: match job.viewer {
            Viewer::At(url) => Some(url.to_owned()),
            Viewer::Nobody | Viewer::Spawned => None,
        },
        spawn: job.viewer == Viewer::Spawned,
    };
    let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
    // The recording comes last: it takes its name only when the samples have theirs.
    if let Some(path) = job.npz {
        sinks.push(Box::new(SamplesSink::new(path.to_owned())));
    }
    if output != Output::default() {
        sinks.push(Box::new(RerunSink::new(&output, job.scene.record)?));
    }
    let monitor = Monitor {
        stop: job.stop,
        progress: job.progress,
    };
    Ok(drive(
        simulation,
        job.command,
        &mut Tee::new(sinks),
        monitor,
    )?)
}

/// The modes at steady sliding at each of the tilts (rad), by frequency.
pub(super) fn stability(scene: &Scene, tilts: &[f64]) -> Result<Vec<Vec<ModeReport>>, Cause> {
    let ball = BallJoint::new(&scene.joint)?;
    let found = study::stability(&ball, tilts)?;
    Ok(found
        .into_iter()
        .map(|at| {
            let modes = at.modes.into_iter();
            modes
                .map(|mode| ModeReport {
                    frequency_hz: mode.frequency_hz,
                    growth_per_s: mode.growth,
                    unstable: mode.unstable,
                    label: mode.label,
                })
                .collect()
        })
        .collect())
}

/// The model of a scene at its start.
pub(super) fn model(scene: &Scene) -> Result<ModelFile, Cause> {
    let model = BallJoint::new(&scene.joint)?.model(scene.tilt.at(0.0))?;
    let (nodes, modes) = (model.nodes(), model.modes());
    let arrays = ModelArrays::new(model, initial_state(scene, modes));
    let mut npz = Cursor::new(Vec::new());
    encode_model(&mut npz, &arrays)?;
    Ok(ModelFile {
        nodes,
        modes,
        npz: npz.into_inner(),
    })
}
