//! What the commands call of the rest of the crate: the only place where the command line meets
//! the pipeline and the joint.

use std::io::Cursor;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use super::analyse::{Play, Tools};
use super::basins;
use super::error::{Cause, CliError};
use super::growth;
use super::interrupt;
use super::lyapunov;
use super::model::ModelFile;
use super::progress::{Progress, Teller};
use super::report::{CauseReport, ModeReport, print_warning};
use super::run::{Job, Viewer};
use crate::analysis::range;
use crate::export::{ModelArrays, SamplesSink, encode_model};
use crate::import::{
    Clock, Column, Format, ImportError, Selection, Signal, Table, read_signal_with,
};
use crate::joint::BallJoint;
use crate::pipeline::message::{SignalInfo, Summary};
use crate::pipeline::{Monitor, PipelineError, Playback, Sink, Tee, drive, initial_state, source};
use crate::plot::{SIGNAL_FIGURES, basins_figure, growth_figure, lyapunov_figure, signal_figures};
use crate::record::{Output, RerunSink, read_series};
use crate::scene::{RecordSpec, Scene};
use crate::sound::WavSink;
use crate::study;
use crate::study::growth::Taken;
use crate::study::lyapunov::scene_lyapunov;
use crate::study::signal::{highest_frequency, live_analysis};
use crate::study::wait_for;

/// Runs a scene down the road: simulation, analysis, recording.
pub(super) fn simulate(job: &Job<'_>) -> Result<Summary, Cause> {
    // Before anything is opened: what is wrong with the scene leaves nothing behind.
    let simulation = source(job.scene)?;
    start_pool()?;
    let output = Output {
        save: job.save.map(Into::into),
        connect: match job.viewer {
            Viewer::At(url) => Some(url.to_owned()),
            Viewer::Nobody | Viewer::Spawned => None,
        },
        spawn: job.viewer == Viewer::Spawned,
    };
    interrupt::work_begins();
    let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
    // The recording comes last: it takes its name only when the samples have theirs.
    if let Some(path) = job.npz {
        sinks.push(Box::new(SamplesSink::new(path.to_owned())));
    }
    let mut heard = None;
    if let Some((path, source, slower)) = job.wav {
        let header = simulation.header(job.command);
        let sink = WavSink::new(path.to_owned(), source, &header, slower)?;
        heard = Some((sink.words(), sink.loudest()));
        sinks.push(Box::new(sink));
    }
    let mut part = None;
    if output != Output::default() {
        let notice = Arc::clone(&job.notice);
        let recording = RerunSink::new(&output, job.scene.record)?;
        part = recording.part().map(Path::to_owned);
        sinks.push(Box::new(recording.with_notice(move |words| notice(words))));
    }
    let monitor = Monitor {
        stop: job.stop,
        progress: job.progress,
    };
    let mut tee = Tee::new(sinks);
    let done = drive(simulation, job.command, &mut tee, monitor);
    if let Some((what, loudest)) = heard
        && let Some(loudest) = loudest.get()
    {
        (job.hears)(format!("{what}; the loudest is {loudest}"));
    }
    done.map_err(|fault| {
        if let Some(part) = part {
            tell_part(&part, &fault, &job.notice);
        }
        fault.into()
    })
}

/// Address space of the threads of a run or a study, bytes: the allocator reserves 64 MB for each, and ends the
/// program where it finds no more.
const THREADS_SPACE: usize = 300_000_000;

/// Starts the threads that analyses share, unless they run: started by the first analysis, they would panic where the
/// system gives none. Called after what needs much memory at once, since each thread reserves some.
pub(super) fn start_pool() -> Result<(), CliError> {
    if !crate::memory::is_granted(THREADS_SPACE) {
        return Err(CliError::Threads {
            purpose: "the analyses",
            source: format!(
                "they need {} MB of address space, which the system refuses; raise the limit (`ulimit -v`)",
                THREADS_SPACE / 1_000_000
            )
            .into(),
        });
    }
    let pool = rayon::ThreadPoolBuilder::new().thread_name(|k| format!("analysis {k}"));
    match pool.build_global() {
        // A second call has no cause.
        Err(fault) if std::error::Error::source(&fault).is_some() => Err(CliError::Threads {
            purpose: "the analyses",
            // Its own source says the same again.
            source: fault.to_string().into(),
        }),
        _ => Ok(()),
    }
}

/// Makes sure, before any work, that there is memory for a recording.
pub(super) fn check_memory() -> Result<(), CliError> {
    crate::record::check_memory().map_err(|source| CliError::Run {
        doing: "recording",
        source: source.into(),
    })
}

/// Tells where the beginning of a recording is, unless the fault is the recording's own and says so.
fn tell_part(part: &Path, fault: &PipelineError, notice: &Teller) {
    let is_there = std::fs::metadata(part).is_ok_and(|there| there.len() > 0);
    let place = part.display().to_string();
    let causes = std::iter::successors(Some(fault as &dyn std::error::Error), |cause| {
        cause.source()
    });
    let is_told = causes
        .map(ToString::to_string)
        .any(|words| words.contains(&place));
    if is_there && !is_told {
        notice(&format!(
            "what was recorded until then can be opened: {place}"
        ));
    }
}

/// The modes at steady sliding at each of the tilts (rad), by frequency, with their causes if asked
/// for.
pub(super) fn stability(
    scene: &Scene,
    tilts: &[f64],
    causes: bool,
) -> Result<Vec<Vec<ModeReport>>, Cause> {
    let ball = BallJoint::new(&scene.joint()?.spec)?;
    let found = study::stability(&ball, tilts)?;
    let explained = match causes {
        true => study::growth_causes(&ball, tilts)?,
        false => vec![Vec::new(); tilts.len()],
    };
    let reports = found.into_iter().zip(explained).map(|(at, explained)| {
        // Both lists are by frequency; what does not oscillate has no causes.
        let mut explained = explained.into_iter();
        let modes = at.modes.into_iter().map(|mode| {
            let why = match mode.frequency_hz > 0.0 {
                true => explained.next(),
                false => None,
            };
            let causes = why.into_iter().flat_map(|mode| mode.causes);
            ModeReport {
                frequency_hz: mode.frequency_hz,
                growth_per_s: mode.growth,
                unstable: mode.unstable,
                label: mode.label,
                causes: causes
                    .map(|cause| CauseReport {
                        cause: cause.cause.name(),
                        share_per_s: cause.share,
                        without_per_s: cause.without,
                    })
                    .collect(),
            }
        });
        modes.collect()
    });
    Ok(reports.collect())
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
    draw: lyapunov_figure,
};

/// What `squeakscope basins` needs.
pub(super) const BASINS: basins::Tools = basins::Tools {
    draw: basins_figure,
};

/// What `squeakscope growth` needs.
pub(super) const GROWTH: growth::Tools = growth::Tools {
    growth: |plan, watch| Ok(study::growth::growth(plan, &mut run_apart, watch)?),
    draw: growth_figure,
};

/// Runs a scene for so long (s) in a process of its own, and tells what its report says of time and memory.
fn run_apart(
    scene: &Scene,
    duration: f64,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Option<Taken>, Cause> {
    let folder = tempfile::tempdir()?;
    let [file, report] = ["scene.toml", "run.json"].map(|name| folder.path().join(name));
    std::fs::write(&file, &scene.text)?;
    let mut running = Command::new(std::env::current_exe()?)
        .arg("run")
        .arg(&file)
        .args(["--duration", &format!("{}", 1e3 * duration)])
        .arg("--save")
        .arg(folder.path().join("run.rrd"))
        .arg("--json")
        .arg(&report)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()?;
    // SIGTERM comes to this process alone.
    wait_for(&mut running, goes_on)?;
    let done = running.wait_with_output()?;
    // Ctrl-C comes to both: that the run was interrupted, too, is no fault.
    if !goes_on() {
        return Ok(None);
    }
    if !done.status.success() {
        return Err(String::from_utf8_lossy(&done.stderr).trim().into());
    }
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report)?)?;
    let seconds = report["wall_s"].as_f64().ok_or("a run told no time")?;
    Ok(Some(Taken {
        seconds,
        memory: report["peak_memory_bytes"].as_u64(),
    }))
}

/// What `squeakscope analyse` needs.
pub(super) const LABORATORY: Tools = Tools {
    read,
    names: &SIGNAL_FIGURES,
    draw: signal_figures,
    play,
};

/// Times of a recording are whole nanoseconds.
const NANOSECOND: f64 = 1e-9;

/// Reads a signal from any file, recordings included.
fn read(path: &Path, selection: &Selection) -> Result<Signal, CliError> {
    let failed = |problem| ImportError {
        path: path.to_owned(),
        problem,
    };
    if Format::of(path).map_err(failed)? != Format::Rrd {
        let progress = Progress::of_steps();
        let signal = read_signal_with(path, selection, &mut |share| {
            progress.step(share, "reading");
        });
        return Ok(signal?);
    }
    let series = read_series(path, selection.column.as_deref())?;
    if let Some(damage) = &series.damage {
        let length = match (series.times.first(), series.times.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        };
        print_warning(&format!(
            "{} is damaged at {damage}; the {} samples of `{}` before that, {length:.6} s, are read",
            path.display(),
            series.values.len(),
            series.name
        ));
    }
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
        &signal.samples,
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
