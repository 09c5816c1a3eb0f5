//! What the commands call of the rest of the crate: the only place where the command line meets
//! the pipeline and the joint.

use std::path::Path;

use super::analyse::{Play, Tools};
use super::cost;
use super::error::{Cause, CliError};
use super::paper;
use super::paper_captions as captions;
use super::progress::Progress;
use super::report::print_warning;
use super::sweep;
use crate::analysis::range;
use crate::import::{
    Clock, Column, Format, ImportError, Selection, Signal, Table, read_signal_with,
};
use crate::joint::{BallJoint, Friction};
use crate::pipeline::message::{SignalInfo, Summary};
use crate::pipeline::{Monitor, Playback, drive};
use crate::plot::paper::{
    bifurcation, configuration, embedding, friction_curves, mode_shapes, motion, recurrence_plots,
    sections,
};
use crate::plot::{Figure, SIGNAL_FIGURES, cost_figures, signal_figures, sweep_figures};
use crate::record::cost::save_cost;
use crate::record::sweep::{SweepStudy, save_sweep};
use crate::record::{Output, RerunSink, read_series};
use crate::scene::RecordSpec;
use crate::study;
use crate::study::paper::{EMBEDDED_AT, Evidence, MOTIONS, SUCCESSION, paper_evidence};
use crate::study::signal::{highest_frequency, live_analysis};
use crate::study::sweep::{SweepPlan, SweepPoint};

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

/// What `squeakscope sweep` and `squeakscope merge` need.
pub(super) const SWEEPS: sweep::Tools = sweep::Tools {
    draw: sweep_figures,
    record,
};

/// Records a sweep over one parameter.
pub(super) fn record(
    plan: &SweepPlan,
    points: &[SweepPoint],
    command: &str,
    path: &Path,
) -> Result<(), Cause> {
    let sweep = SweepStudy {
        plan,
        points,
        command,
        ball: None,
    };
    Ok(save_sweep(path, &sweep)?)
}

/// What `squeakscope cost` needs.
pub(super) const COST: cost::Tools = cost::Tools {
    cost: |plan, watch| Ok(study::cost::cost(plan, watch)?),
    draw: cost_figures,
    record: |plan, study, command, path| Ok(save_cost(path, plan, study, command)?),
};

/// What `squeakscope paper` needs.
pub(super) const PAPER: paper::Tools = paper::Tools {
    evidence: |scene, points| Ok(paper_evidence(&scene.joint()?.spec, points)?),
    draw: draw_paper,
    record: |plan, points, command, path| {
        let ball = BallJoint::new(&plan.scene.joint()?.spec)?;
        let sweep = SweepStudy {
            plan,
            points,
            command,
            ball: Some(&ball),
        };
        Ok(save_sweep(path, &sweep)?)
    },
};

/// The paper's figures with captions: all, or only one.
fn draw_paper(
    plan: &SweepPlan,
    points: &[SweepPoint],
    evidence: &Evidence,
    only: Option<u8>,
) -> Result<Vec<Figure>, Cause> {
    let wanted = |number: u8| only.is_none_or(|only| only == number);
    let spec = &plan.scene.joint()?.spec;
    let ball = BallJoint::new(spec)?;
    let mut figures = paper_configuration(&ball, &wanted)?;
    let mut add = |figure: Figure, caption: &str| {
        figures.push(Figure {
            caption: caption.to_owned(),
            ..figure
        });
    };
    for (number, tilt) in (4..).zip(MOTIONS) {
        if let (true, Some(response)) = (wanted(number), evidence.at(tilt)) {
            let modes = study::growth_causes(&ball, &[tilt.to_radians()])?.concat();
            let figure = motion(number.into(), tilt, response, &modes);
            add(figure, &captions::motion(number, tilt, response));
        }
    }
    let chosen = evidence.at(EMBEDDED_AT).and_then(study::paper::embedding);
    if let (true, Some(chosen)) = (wanted(8), chosen) {
        let (choice, dt) = chosen?;
        add(embedding(EMBEDDED_AT, &choice, dt), captions::EMBEDDING);
    }
    let [first, last] = SUCCESSION;
    // Every second tenth of a degree: without 3.5, which the sweep has besides.
    let mut succession = evidence.between(first, last);
    succession.retain(|(tilt, _)| (5.0 * tilt - (5.0 * tilt).round()).abs() < 1e-6);
    if wanted(9) {
        add(recurrence_plots(&succession), captions::RECURRENCE);
    }
    if wanted(10) {
        add(sections(&succession), captions::SECTIONS);
    }
    if wanted(11) {
        add(bifurcation(plan, points), captions::EXPONENTS);
    }
    let findings = match points.is_empty() {
        true => Vec::new(),
        false => study::paper::compare(evidence),
    };
    for figure in &mut figures {
        if let Ok(number) = figure.name.trim_start_matches("figure-").parse() {
            figure.caption += &captions::differences(number, &findings);
        }
    }
    Ok(figures)
}

/// The paper's figures that need no motion: 1 to 3, as far as they are wanted.
fn paper_configuration(
    ball: &BallJoint,
    wanted: &dyn Fn(u8) -> bool,
) -> Result<Vec<Figure>, Cause> {
    let tilt = MOTIONS[2].to_radians();
    let mut figures = Vec::new();
    if wanted(1) {
        let figure = configuration(ball, &ball.model(tilt)?, tilt)?;
        figures.push((figure, captions::CONFIGURATION));
    }
    if wanted(2) {
        figures.push((mode_shapes(ball)?, captions::MODE_SHAPES));
    }
    if let (true, Friction::Stribeck { law, .. }) = (wanted(3), ball.spec().friction) {
        let velocity = ball.sliding_velocity(tilt);
        let sliding = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        figures.push((friction_curves(&law, sliding), captions::FRICTION));
    }
    let captioned = figures.into_iter().map(|(figure, caption)| Figure {
        caption: caption.to_owned(),
        ..figure
    });
    Ok(captioned.collect())
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
