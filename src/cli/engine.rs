//! What the commands call of the rest of the crate: the only place where the command line meets
//! the pipeline and the joint.

use std::io::Cursor;
use std::path::Path;

use super::analyse::{FigureFile, Play, Tools};
use super::error::{Cause, CliError};
use super::lyapunov;
use super::model::ModelFile;
use super::report::ModeReport;
use super::run::{Job, Viewer};
use super::sweep;
use super::sweep_view::sweep_view;
use crate::analysis::range;
use crate::export::{ModelArrays, SamplesSink, encode_model};
use crate::figure::{lyapunov_figure, signal_figures, sweep_figures};
use crate::import::{Clock, Column, Format, ImportError, Selection, Signal, Table, read_signal};
use crate::joint::BallJoint;
use crate::pipeline::message::{SignalInfo, Summary};
use crate::pipeline::{Monitor, Playback, Sink, Tee, drive, initial_state, source};
use crate::record::sweep::save_sweep;
use crate::record::{Output, RerunSink, read_series};
use crate::scene::{RecordSpec, Scene};
use crate::study;
use crate::study::lyapunov::scene_lyapunov;
use crate::study::signal::{SignalReport, highest_frequency, live_analysis};

/// Runs a scene down the road: simulation, analysis, recording.
pub(super) fn simulate(job: &Job<'_>) -> Result<Summary, Cause> {
    // Before anything is opened: what is wrong with the scene leaves nothing behind.
    let simulation = source(job.scene)?;
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
    let ball = BallJoint::new(&scene.joint()?.spec)?;
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
    let joint = scene.joint()?;
    let model = BallJoint::new(&joint.spec)?.model(joint.tilt.at(0.0))?;
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

/// What `squeakscope lyapunov` needs.
pub(super) const EXPONENTS: lyapunov::Tools = lyapunov::Tools {
    follow: |scene, request, watch| Ok(scene_lyapunov(scene, request, watch)?),
    draw: |name, found| Ok(lyapunov_figure(name, found)?.png()?),
};

/// What `squeakscope sweep` and `squeakscope merge` need.
pub(super) const SWEEPS: sweep::Tools = sweep::Tools {
    draw: |plan, points| {
        let drawn = sweep_figures(plan, points)?.into_iter().map(|figure| {
            Ok(sweep::Drawn {
                png: figure.png()?,
                name: figure.name,
                svg: figure.svg,
            })
        });
        drawn.collect()
    },
    record: |plan, points, command, path| {
        Ok(save_sweep(path, &sweep_view(plan, points, command)?)?)
    },
};

/// What `squeakscope analyse` needs.
pub(super) const LABORATORY: Tools = Tools { read, draw, play };

/// Times of a recording are whole nanoseconds.
const NANOSECOND: f64 = 1e-9;

/// Reads a signal from any file, recordings included.
fn read(path: &Path, selection: &Selection) -> Result<Signal, CliError> {
    let failed = |problem| ImportError {
        path: path.to_owned(),
        problem,
    };
    if Format::of(path).map_err(failed)? != Format::Rrd {
        return Ok(read_signal(path, selection)?);
    }
    let series = read_series(path, selection.column.as_deref())?;
    let table = Table {
        columns: vec![Column::new(series.name, &series.unit, series.values)],
        clock: Clock::Times {
            times: series.times,
            resolution: NANOSECOND,
        },
    };
    // The column has been chosen above.
    let rest = Selection {
        column: None,
        ..selection.clone()
    };
    Ok(table.signal(&rest).map_err(failed)?)
}

/// The figures of a report.
fn draw(report: &SignalReport) -> Result<Vec<FigureFile>, Cause> {
    let figures = signal_figures(report)?;
    let file = |figure: crate::figure::Figure| {
        Ok(FigureFile {
            name: format!("{}.png", figure.name),
            png: figure.png()?,
        })
    };
    figures.into_iter().map(file).collect()
}

/// Sends a signal down the road of a simulation: analysis, recording.
fn play(job: &Play<'_>) -> Result<Summary, Cause> {
    let signal = &job.report.signal;
    let source = job.file.file_name().unwrap_or(job.file.as_os_str());
    let source = source.to_string_lossy().into_owned();
    let info = SignalInfo {
        source: source.clone(),
        column: signal.name.clone(),
        unit: signal.unit.clone(),
        start: signal.start,
        span: range(signal.samples.iter().copied()),
        highest_frequency: highest_frequency(job.report),
    };
    let title = format!(
        "{source}, {}: {} samples at {} Hz",
        signal.name,
        signal.samples.len(),
        signal.rate
    );
    let playback = Playback::new(
        title,
        info,
        signal.samples.clone(),
        signal.rate,
        live_analysis(job.report),
    );
    let output = Output {
        save: Some(job.save.to_owned()),
        ..Output::default()
    };
    let mut sink = RerunSink::new(&output, RecordSpec::SAMPLES_ONLY)?;
    let (start, duration) = (signal.start, signal.duration());
    let monitor = Monitor {
        stop: job.stop,
        progress: &|time| (job.progress)((time - start) / duration),
    };
    Ok(drive(playback, job.command, &mut sink, monitor)?)
}
