//! `squeakscope sweep` and `squeakscope merge`: the settled response over parameters of a scene.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use super::console;
use super::error::CliError;
use super::figures::STUDY;
use super::harness::{Outputs, Watch};
use super::output::Kind;
use super::resources;
use super::steps::{Steps, parameters};
use super::study_args::{MergeArgs, ResponseArgs, SweepArgs, SweepOutputs, WorkArgs};
use crate::joint::BallJoint;
use crate::plot::{Figure, sweep_figures};
use crate::record::sweep::{SweepStudy, save_sweep};
use crate::report::{Block, Report as _};
use crate::study::response::ResponsePlan;
use crate::study::sweep::{
    Axis, Shard, SweepPlan, SweepPoint, SweepResult, SweepTable, TableError, TableWriter,
    read_table, sweep, write_table,
};
use crate::study::threads;

/// The table while it grows: an Arrow stream, which is removed when the table is complete.
const GROWING: &str = "--out, while it grows";

/// Runs `squeakscope sweep`.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the results so far are
/// written.
pub(super) fn execute(args: &SweepArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let plan = plan(args)?;
    check_timeline(&plan, &args.outputs)?;
    console::print_study_warnings(&plan.subject);
    console::print_fixed(&plan.subject, plan.axes.iter().flat_map(Axis::parameter));
    let input = args.scene.input();
    let files = outputs(input, &args.outputs, Some(&args.work), &stems(&plan))?;
    let watch = Watch::new(stop);
    let points = compute_points(&plan, &args.work, tables(&files), &watch)?;
    let shard = args.work.shard.unwrap_or(Shard::WHOLE);
    let result = SweepResult::new(&plan, points, shard);
    finish(&plan, result, files, watch)
}

/// The outputs of a study over parameters, or of a merge, which has no work; `stems` are those of the figures' file names.
pub(super) fn outputs<'a>(
    input: Option<&OsStr>,
    args: &'a SweepOutputs,
    work: Option<&WorkArgs>,
    stems: &[String],
) -> Result<Outputs<'a>, CliError> {
    let mut outputs = Outputs::new(input, &args.output);
    outputs.force |= work.is_some_and(|work| work.resume);
    let table = work.map_or(Kind::TABLE, |_| Kind::STUDY_TABLE);
    let growing = args.out.with_extension("arrows");
    outputs
        .file("--out", table, Some(&args.out))?
        .file(GROWING, Kind::GROWING_TABLE, Some(growing))?
        .file("--save", Kind::RECORDING, args.save.as_ref())?
        .figures(&args.figures, STUDY, stems)
}

/// The paths of the table of a study over parameters, complete and growing.
pub(super) fn tables(files: &Outputs<'_>) -> [PathBuf; 2] {
    ["--out", GROWING].map(|option| files.path(option).expect("is always written"))
}

/// Computes the points that the table lacks and adds them to it. Returns all known points; some are missing after an
/// interrupt.
pub(super) fn compute_points(
    plan: &SweepPlan,
    work: &WorkArgs,
    [table, growing]: [PathBuf; 2],
    watch: &Watch<'_>,
) -> Result<Vec<SweepPoint>, CliError> {
    let known = if work.resume {
        known_points(plan, [&growing, &table])?
    } else {
        Vec::new()
    };
    resources::start_thread_pool()?;
    super::interrupt::start_work();
    let mut table = TableWriter::new(&growing, plan, &known)?;
    let shard = work.shard.unwrap_or(Shard::WHOLE);
    let threads = threads(work.threads);
    let progress = &mut watch.progress();
    let points = sweep(plan, shard, known, threads, progress, |point| {
        table.add(point)
    });
    Ok(points?)
}

/// Runs `squeakscope merge`.
///
/// # Errors
/// Bad input: a table that cannot be read, belongs to another sweep, or has a different result at the same
/// point; failure while writing.
pub(super) fn merge(args: &MergeArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let mut tables = args.tables.iter().map(|path| (path, read_table(path)));
    let Some((path, first)) = tables.next() else {
        return Ok(());
    };
    let first = first?;
    let plan = SweepPlan::from_identity(&first.identity)
        .map_err(|reason| TableError::invalid(path, reason))?;
    check_timeline(&plan, &args.outputs)?;
    let files = outputs(None, &args.outputs, None, &stems(&plan))?;
    // Points by their index in the plan.
    let mut merged: BTreeMap<usize, SweepPoint> = BTreeMap::new();
    for (path, table) in std::iter::once((path, Ok(first))).chain(tables) {
        for point in points_of(&plan, path, table?)? {
            let index = point.place.index;
            let existing = merged.entry(index).or_insert_with(|| point.clone());
            if *existing != point {
                let reason =
                    format!("its point {index} differs from the same point in another table");
                return Err(TableError::invalid(path, reason).into());
            }
        }
    }
    let merged = merged.into_values().collect();
    let result = SweepResult {
        interrupted: false,
        ..SweepResult::new(&plan, merged, Shard::WHOLE)
    };
    finish(&plan, result, files, Watch::new(stop))
}

/// Stems of the figures' file names, which do not depend on the points.
fn stems(plan: &SweepPlan) -> Vec<String> {
    let figures = sweep_figures(plan, &[]).into_iter();
    figures.map(|figure| figure.name).collect()
}

/// Refuses a recording of a sweep over two parameters: a recording has one timeline.
fn check_timeline(plan: &SweepPlan, outputs: &SweepOutputs) -> Result<(), CliError> {
    match (&plan.axes[..], &outputs.save) {
        ([first, second, ..], Some(_)) => Err(CliError::Input(format!(
            "--save records a sweep over one parameter, which becomes the timeline; sweep over `{}` or `{}` alone, or \
             omit --save",
            first.name, second.name
        ))),
        _ => Ok(()),
    }
}

/// Concludes and delivers the result.
fn finish(
    plan: &SweepPlan,
    result: SweepResult,
    files: Outputs<'_>,
    watch: Watch<'_>,
) -> Result<(), CliError> {
    // An interrupt while the ends are searched leaves the table complete.
    let lacks_points = result.interrupted;
    let result = result.concluded(plan, &mut watch.progress());
    files.finish(watch, Some(&plan.subject.name), &result, |files| {
        let figures = || sweep_figures(plan, &result.points);
        let report = result.blocks(&plan.subject.name);
        write(plan, &result.points, lacks_points, files, figures, &report)
    })
}

/// Writes the complete table and removes that which grew, which stays for `--resume` after an interrupt; draws the figures,
/// and records the points, if there are any, with the report.
pub(super) fn write(
    plan: &SweepPlan,
    points: &[SweepPoint],
    interrupted: bool,
    files: &mut Outputs<'_>,
    figures: impl FnOnce() -> Vec<Figure>,
    report: &[Block],
) -> Result<(), CliError> {
    let [_, growing] = tables(files);
    if interrupted {
        files.add(&growing)?;
    } else {
        files.write("--out", |path| write_table(path, plan, points))?;
        // A merge has none.
        let _ = std::fs::remove_file(growing);
    }
    // The recording is written even if a figure cannot be.
    let drawn = files.draw(figures);
    if !points.is_empty() {
        files.write("--save", |path| record(plan, points, report, path, None))?;
    }
    drawn
}

/// Saves a recording with the report of the study; with `ball`, it shows the modes of ball and beam.
pub(super) fn record(
    plan: &SweepPlan,
    points: &[SweepPoint],
    report: &[Block],
    path: &Path,
    ball: Option<&BallJoint>,
) -> Result<(), CliError> {
    let sweep = SweepStudy {
        plan,
        points,
        report,
        command: &console::command_line(),
        ball,
    };
    save_sweep(path, &sweep).map_err(CliError::during("recording"))
}

/// The points of an existing table that is resumed: the first of these that has points.
fn known_points(plan: &SweepPlan, tables: [&Path; 2]) -> Result<Vec<SweepPoint>, CliError> {
    // An empty file: the sweep was killed before its first point.
    let has_points = |path: &&Path| path.metadata().is_ok_and(|file| file.len() > 0);
    match tables.into_iter().find(has_points) {
        Some(path) => points_of(plan, path, read_table(path)?),
        None => Ok(Vec::new()),
    }
}

/// The points of the table of this path, which belongs to a plan; warns if the table is truncated.
fn points_of(
    plan: &SweepPlan,
    path: &Path,
    table: SweepTable,
) -> Result<Vec<SweepPoint>, CliError> {
    table.check(plan, path)?;
    if table.truncated {
        console::print_warning(&format!(
            "`{}` is truncated after {} points; any further points are lost",
            path.display(),
            table.points.len()
        ));
    }
    Ok(table.points)
}

/// The sweep that the arguments request.
fn plan(args: &SweepArgs) -> Result<SweepPlan, CliError> {
    let numbers = [
        ("start.seed", args.seed.map(|seed| seed as f64)),
        ("time.tolerance", args.response.tolerance),
    ];
    let scene = args.scene.load_with(args.response.accuracy, &numbers)?;
    // Tilts in degrees as in Fig. 11.
    let default = Steps((2..=16).map(|k| 0.5 * f64::from(k)).collect());
    let axes = parameters(&scene, args.tilt.clone(), &args.param, default)?.into_iter();
    let axes = axes.map(|(parameter, steps)| Axis::new(parameter, steps.0));
    let axes: Vec<Axis> = axes.collect();
    let plan = SweepPlan {
        subject: scene,
        response: response_plan(&args.response, axes.len() == 1)?,
        axes,
        starts: args.start.starts(),
    };
    // Refuse invalid values before the sweep starts.
    for axis in &plan.axes {
        for value in &axis.values {
            plan.subject.with_values(&[(axis.parameter()?, *value)])?;
        }
    }
    for index in [0, plan.size() - 1] {
        plan.scene_at(&plan.place(index))?;
    }
    Ok(plan)
}

/// The transient and the measurement of each response.
///
/// # Errors
/// If the shortest transient is above the longest.
pub(super) fn response_plan(args: &ResponseArgs, portrait: bool) -> Result<ResponsePlan, CliError> {
    let (min, max) = (args.min_transient, args.max_transient);
    if min > max {
        return Err(CliError::Input(format!(
            "--min-transient {min} ms exceeds --max-transient {max} ms; lower the first or raise the second"
        )));
    }
    Ok(ResponsePlan {
        min_transient_s: 1e-3 * min,
        max_transient_s: 1e-3 * max,
        measurement_s: 1e-3 * args.measure,
        exponents: args.exponents,
        orbits: true,
        portrait,
        max_rhs_evals: None,
    })
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
