//! What studies over the points of a plan share: the table, which grows and can be resumed, figures and a recording.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::console;
use super::error::CliError;
use super::figures::STUDY;
use super::harness::{Outputs, Watch};
use super::output::Kind;
use super::study_args::{ResponseArgs, SweepOutputs, WorkArgs};
use super::{interrupt, resources};
use crate::joint::BallJoint;
use crate::plot::Figure;
use crate::record::sweep::{SweepStudy, save_sweep};
use crate::report::Block;
use crate::study::response::ResponsePlan;
use crate::study::sweep::{
    Shard, SweepPlan, SweepPoint, SweepTable, TableWriter, read_table, sweep, write_table,
};
use crate::study::threads;

/// The table while it grows: an Arrow stream, which is removed when the table is complete.
const GROWING: &str = "--out, while it grows";

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
    interrupt::start_work();
    let mut table = TableWriter::new(&growing, plan, &known)?;
    let shard = work.shard.unwrap_or(Shard::WHOLE);
    let threads = threads(work.threads);
    let progress = &mut watch.progress();
    let points = sweep(plan, shard, known, threads, progress, |point| {
        table.add(point)
    });
    Ok(points?)
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
pub(super) fn points_of(
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
