//! What the commands call of the rest of the crate: the only place where the command line meets
//! the pipeline and the joint.

use std::path::Path;

use super::analyse::{Play, Tools};
use super::error::{Cause, CliError};
use super::progress::Progress;
use super::report::print_warning;
use crate::analysis::range;
use crate::import::{
    Clock, Column, Format, ImportError, Selection, Signal, Table, read_signal_with,
};
use crate::pipeline::message::{SignalInfo, Summary};
use crate::pipeline::{Monitor, Playback, drive};
use crate::plot::{SIGNAL_FIGURES, signal_figures};
use crate::record::{Output, RerunSink, read_series};
use crate::scene::RecordSpec;
use crate::study::signal::{highest_frequency, live_analysis};

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
