//! `squeakscope sweep` and `squeakscope merge`: the settled response over parameters of a scene.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::document::{Document, WrittenFile};
use super::error::CliError;
use super::figures::{STUDY, draw};
use super::interrupt;
use super::output::{Kind, OutputFile, Overwrite, is_stdout};
use super::progress::Progress;
use super::report::{self, HEADING, WARNING};
use super::resources;
use super::run::command_line;
use super::steps::Keyed;
use super::study_args::{MergeArgs, ResponseArgs, SweepArgs, SweepOutputs, WorkArgs};
use crate::dynamics::continuation::BifurcationKind;
use crate::escape;
use crate::joint::BallJoint;
use crate::number::{fixed, quantity, uncertain};
use crate::plot::sweep_figures;
use crate::record::sweep::{SweepStudy, save_sweep};
use crate::scene::Parameter;
use crate::study::branch::hysteresis_ends;
use crate::study::response::ResponsePlan;
use crate::study::sweep::{
    Axis, Shard, SweepObserver, SweepPlan, SweepPoint, SweepProgress, SweepResult, SweepTable,
    TableError, TableWriter, read_table, sweep, write_table,
};
use crate::study::threads;
use crate::table::Table;

/// Default tilts, degrees: first, last, step, as in Fig. 11.
const TILTS: [f64; 3] = [1.0, 8.0, 0.5];

/// Largest number of points that are printed as a table.
const MAX_ROWS: usize = 100;

/// Runs `squeakscope sweep`.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the results so far are
/// written.
pub(super) fn execute(args: &SweepArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let plan = plan(args)?;
    check_timeline(&plan, &args.outputs)?;
    report::print_study_warnings(&plan.scene);
    report::print_fixed(&plan.scene, plan.axes.iter().map(Axis::parameter));
    let scene = args.scene.input();
    let overwrite = args.outputs.overwrite.or(args.work.resume);
    let files = Files::check(
        (scene, &args.outputs),
        &names(&plan),
        (Kind::STUDY_TABLE, overwrite),
    )?;
    let (mut points, done) = compute_points(&plan, &args.work, &files, stop)?;
    let shard = args.work.shard.unwrap_or(Shard::WHOLE);
    let outputs = (&args.outputs, &files);
    deliver(&plan, &mut points, outputs, (shard, !done), stop)?;
    if done {
        Ok(())
    } else {
        Err(CliError::Interrupted)
    }
}

/// Computes the points that the table lacks and adds them to it. Returns all known points, and whether the
/// shard is complete.
pub(super) fn compute_points(
    plan: &SweepPlan,
    work: &WorkArgs,
    files: &Files,
    stop: &AtomicBool,
) -> Result<(Vec<SweepPoint>, bool), CliError> {
    let known = known_points(work.resume, plan, files)?;
    resources::start_thread_pool()?;
    interrupt::start_work();
    let mut recorder = Recorder {
        table: TableWriter::new(files.growing.path(), plan, &known)?,
        points: known.clone(),
        progress: Progress::with_estimate(),
        stop,
    };
    let shard = work.shard.unwrap_or(Shard::WHOLE);
    let threads = threads(work.threads);
    let done = sweep(plan, shard, &known, threads, &mut recorder)?;
    Ok((recorder.points, done))
}

/// Runs `squeakscope merge`.
///
/// # Errors
/// Bad input: a table that cannot be read, belongs to another sweep, or has a different result at the same
/// point; failure while writing.
pub(super) fn merge(args: &MergeArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let mut tables = args
        .tables
        .iter()
        .map(|path| read_table(path).map(|table| (path, table)));
    let (path, first) = match tables.next() {
        Some(read) => read?,
        None => return Ok(()),
    };
    let plan = SweepPlan::from_identity(&first.identity).map_err(|reason| {
        CliError::Table(TableError::Invalid {
            path: path.clone(),
            reason,
        })
    })?;
    check_timeline(&plan, &args.outputs)?;
    let outputs = (None, &args.outputs);
    let files = Files::check(
        outputs,
        &names(&plan),
        (Kind::TABLE, args.outputs.overwrite),
    )?;
    // Points by their index in the plan.
    let mut merged: BTreeMap<usize, SweepPoint> = BTreeMap::new();
    for read in std::iter::once(Ok((path, first))).chain(tables) {
        let (path, table) = read?;
        table.check(&plan, path)?;
        warn_if_truncated(path, &table);
        for point in table.points {
            let index = point.place.index;
            let existing = merged.entry(index).or_insert_with(|| point.clone());
            if *existing != point {
                return Err(CliError::Table(TableError::Invalid {
                    path: path.clone(),
                    reason: format!(
                        "its point {index} differs from the same point in another table"
                    ),
                }));
            }
        }
    }
    let mut merged: Vec<SweepPoint> = merged.into_values().collect();
    deliver(
        &plan,
        &mut merged,
        (&args.outputs, &files),
        (Shard::WHOLE, false),
        stop,
    )
}

/// Stems of the figures' file names, which do not depend on the points.
fn names(plan: &SweepPlan) -> Vec<String> {
    let figures = sweep_figures(plan, &[]).into_iter();
    figures.map(|figure| figure.name).collect()
}

/// Refuses a recording of a sweep over two parameters: a recording has one timeline.
fn check_timeline(plan: &SweepPlan, outputs: &SweepOutputs) -> Result<(), CliError> {
    match (&plan.axes[..], &outputs.save) {
        ([first, second, ..], Some(_)) => Err(CliError::Input(format!(
            "--save records a sweep over one parameter, which becomes the timeline; sweep over `{}` or `{}` alone, or \
             omit --save",
            first.parameter().path(),
            second.parameter().path()
        ))),
        _ => Ok(()),
    }
}

/// The output files.
pub(super) struct Files {
    table: OutputFile,
    /// The table while it grows: an Arrow stream, which is removed when the table is complete.
    growing: OutputFile,
    pub json: Option<OutputFile>,
    save: Option<OutputFile>,
}

impl Files {
    /// Checks all outputs; `figures` are the stems of the figures' file names.
    pub fn check(
        (input, outputs): (Option<&OsStr>, &SweepOutputs),
        figures: &[String],
        (kind, overwrite): (Kind, Overwrite),
    ) -> Result<Self, CliError> {
        let growing = outputs.out.with_extension("arrows");
        let json = outputs.json.as_deref().filter(|path| !is_stdout(path));
        let [table, growing, json, save] = overwrite.check_all(
            input,
            [
                ("--out", kind, Some(&*outputs.out)),
                ("--out", Kind::GROWING_TABLE, Some(&*growing)),
                ("--json", Kind::JSON, json),
                ("--save", Kind::RECORDING, outputs.save.as_deref()),
            ],
        )?;
        if let Some(directory) = &outputs.figures {
            let names = outputs.drawn.names(figures, &STUDY);
            overwrite.check_directory(directory, "--figures", &names)?;
        }
        if save.is_some() {
            resources::check_memory()?;
        }
        match (table, growing) {
            (Some(table), Some(growing)) => Ok(Self {
                table,
                growing,
                json,
                save,
            }),
            _ => unreachable!("both paths are given"),
        }
    }
}

/// Writes each point to the tables and shows the progress.
struct Recorder<'a> {
    table: TableWriter,
    points: Vec<SweepPoint>,
    progress: Progress,
    stop: &'a AtomicBool,
}

impl SweepObserver for Recorder<'_> {
    type Error = TableError;

    fn on_point(&mut self, point: SweepPoint) -> Result<(), TableError> {
        self.table.add(&point)?;
        self.points.push(point);
        Ok(())
    }

    fn on_progress(&mut self, progress: SweepProgress) -> bool {
        let SweepProgress { done, all, share } = progress;
        self.progress
            .update(share, format!("{done} of {all} points"));
        !self.stop.load(Ordering::Relaxed)
    }
}

/// Writes the complete tables, draws the figures, and prints the report.
fn deliver(
    plan: &SweepPlan,
    points: &mut [SweepPoint],
    (outputs, files): (&SweepOutputs, &Files),
    (shard, interrupted): (Shard, bool),
    stop: &AtomicBool,
) -> Result<(), CliError> {
    let mut written = vec![write_points(plan, points, files, !interrupted)?];
    // The report is printed even if a file cannot be written.
    let drawn = draw(
        outputs.figures.as_deref(),
        || sweep_figures(plan, points),
        (&outputs.drawn, &STUDY),
        &mut written,
    );
    written.extend(write_recording(plan, points, files, None)?);
    let mut result = SweepResult::new(plan, points, shard, interrupted);
    if !interrupted && !result.hysteresis.is_empty() {
        let progress = Progress::of_phases();
        let ends = hysteresis_ends(plan, points, &result.hysteresis, &mut |_| {
            progress.update(1.0, "branches that end the hysteresis");
            interrupt::should_continue(stop)
        });
        drop(progress);
        match ends {
            Ok(ends) => result.hysteresis_ends = ends,
            Err(source) => report::print_warning(&format!("hysteresis: {source}")),
        }
    }
    let document = Document::new(&result, &written).with_scene(&plan.scene.name);
    let text = text(&plan.scene.name, &result);
    document.deliver_or_print(&text, outputs.json.as_deref(), files.json.as_ref())?;
    drawn
}

/// Writes the complete table and removes that which grew; the latter stays for `--resume` if points are missing.
pub(super) fn write_points(
    plan: &SweepPlan,
    points: &mut [SweepPoint],
    files: &Files,
    complete: bool,
) -> Result<WrittenFile, CliError> {
    if !complete {
        return Ok(WrittenFile::of(&files.growing)?);
    }
    write_table(files.table.path(), plan, points)?;
    // A merge has none.
    let _ = std::fs::remove_file(files.growing.path());
    Ok(WrittenFile::of(&files.table)?)
}

/// Writes the recording, if it is requested and there are points; with `ball`, it shows the modes of ball and
/// beam.
pub(super) fn write_recording(
    plan: &SweepPlan,
    points: &[SweepPoint],
    files: &Files,
    ball: Option<&BallJoint>,
) -> Result<Option<WrittenFile>, CliError> {
    let Some(file) = files.save.as_ref().filter(|_| !points.is_empty()) else {
        return Ok(None);
    };
    let sweep = SweepStudy {
        plan,
        points,
        command: &command_line(),
        ball,
    };
    save_sweep(file.path(), &sweep).map_err(CliError::during("recording"))?;
    Ok(Some(WrittenFile::of(file)?))
}

/// The points of an existing table that is resumed: the one that grew, or else the complete one.
fn known_points(
    resume: bool,
    plan: &SweepPlan,
    files: &Files,
) -> Result<Vec<SweepPoint>, CliError> {
    // An empty file: the sweep was killed before its first point.
    let has_points = |path: &&Path| path.metadata().is_ok_and(|file| file.len() > 0);
    let mut tables = [files.growing.path(), files.table.path()].into_iter();
    let Some(path) = tables.find(has_points).filter(|_| resume) else {
        return Ok(Vec::new());
    };
    let table = read_table(path)?;
    table.check(plan, path)?;
    warn_if_truncated(path, &table);
    Ok(table.points)
}

/// Warns if a table is truncated.
fn warn_if_truncated(path: &Path, table: &SweepTable) {
    if table.truncated {
        report::print_warning(&format!(
            "`{}` is truncated after {} points; any further points are lost",
            path.display(),
            table.points.len()
        ));
    }
}

/// The sweep that the arguments request.
fn plan(args: &SweepArgs) -> Result<SweepPlan, CliError> {
    let mut scene = args.scene.load()?;
    scene = args.response.accuracy.apply(scene)?;
    let seed = args.seed.map(|seed| seed as f64);
    for (name, value) in [
        ("start.seed", seed),
        ("time.tolerance", args.response.tolerance),
    ] {
        if let Some(value) = value {
            scene = scene.with_values(&[(Parameter::named(name)?, value)])?;
        }
    }
    let mut axes = Vec::new();
    if let Some(tilts) = &args.tilt {
        axes.push(Axis::new(Parameter::tilt(), tilts.values()));
    }
    for Keyed { key, range } in &args.param {
        axes.push(Axis::new(scene.parameter(key)?, range.values()));
    }
    if scene.joint().is_err()
        && axes
            .iter()
            .all(|axis| axis.parameter() == Parameter::tilt())
    {
        return Err(CliError::no_tilt(&scene));
    }
    if axes.is_empty() {
        let [from, to, step] = TILTS;
        let count = ((to - from) / step).round() as u32;
        let tilts = (0..=count).map(|k| from + f64::from(k) * step);
        axes.push(Axis::new(Parameter::tilt(), tilts));
    }
    if axes.len() > 2 {
        return Err(CliError::too_many_axes(axes.len()));
    }
    if let [one, two] = &axes[..]
        && one.parameter() == two.parameter()
    {
        return Err(CliError::axis_twice(one.parameter()));
    }
    let plan = SweepPlan {
        scene,
        response: response_plan(&args.response, axes.len() == 1),
        axes,
        starts: args.start.starts(),
    };
    // Refuse invalid values before the sweep starts.
    for axis in &plan.axes {
        for value in axis.values() {
            plan.scene.with_values(&[(axis.parameter(), *value)])?;
        }
    }
    for index in [0, plan.len() - 1] {
        plan.scene_at(&plan.place(index))?;
    }
    check_transient(&args.response)?;
    Ok(plan)
}

/// Refuses a shortest transient above the longest.
pub(super) fn check_transient(args: &ResponseArgs) -> Result<(), CliError> {
    let (min, max) = (args.min_transient, args.max_transient);
    if min <= max {
        return Ok(());
    }
    Err(CliError::Input(format!(
        "--min-transient {min} ms exceeds --max-transient {max} ms; lower the first or raise the second"
    )))
}

/// The transient and the measurement of each response.
pub(super) fn response_plan(args: &ResponseArgs, portrait: bool) -> ResponsePlan {
    ResponsePlan {
        min_transient: 1e-3 * args.min_transient,
        max_transient: 1e-3 * args.max_transient,
        measurement_time: 1e-3 * args.measure,
        exponents: args.exponents,
        orbits: true,
        portrait,
        max_rhs_evals: None,
    }
}

/// The report for the terminal.
fn text(scene: &str, result: &SweepResult<'_>) -> String {
    let scene = escape::line(scene);
    let mut text = format!(
        "{HEADING}{scene}{HEADING:#} over {}\n",
        result.axes.join(" and ")
    );
    let (known, part) = (result.points_computed, result.points_in_shard);
    if known < part {
        let _ = writeln!(
            text,
            "  {WARNING}{known} of {part} points{WARNING:#} computed; --resume computes the rest"
        );
    } else if known < result.points_total {
        let _ = writeln!(
            text,
            "  a shard: {known} of {} points; `squeakscope merge` joins the shards",
            result.points_total
        );
    }
    for stretch in &result.regime_intervals {
        let values = match stretch.from == stretch.to {
            true => stretch.from.to_string(),
            false => format!("{} to {}", stretch.from, stretch.to),
        };
        let _ = writeln!(text, "  {:>4}  {values}: {}", stretch.start, stretch.regime);
    }
    for transition in &result.transitions {
        if let Some(doubling) = &transition.doubling {
            let _ = writeln!(
                text,
                "  {:>4}  between {} and {}: {doubling}",
                transition.start, transition.from, transition.to
            );
        }
    }
    if !result.hysteresis.is_empty() {
        let values: Vec<String> = result.hysteresis.iter().map(f64::to_string).collect();
        let _ = writeln!(
            text,
            "  hysteresis: upward and downward differ at {}",
            values.join(", ")
        );
    }
    for end in &result.hysteresis_ends {
        let what = match end.kind {
            BifurcationKind::Fold => "ends",
            _ => "loses its stability",
        };
        let _ = writeln!(
            text,
            "    the motion of {} {what} at {:.6} ({})",
            quantity(end.frequency_hz, 5, "Hz"),
            end.value,
            end.kind
        );
    }
    if result.points.len() <= MAX_ROWS {
        let _ = writeln!(text, "\n{}", table(result).text());
    }
    let count = |is_counted: fn(&SweepPoint) -> bool| {
        let counted = result.points.iter().filter(|point| is_counted(point));
        counted.count()
    };
    let failed = count(|point| point.outcome.is_err());
    if failed > 0 {
        let _ = writeln!(
            text,
            "  {WARNING}{failed} points{WARNING:#} failed; the column `error` of the table has the reasons"
        );
    }
    let unsettled = count(SweepPoint::is_unsettled);
    if unsettled > 0 {
        let _ = writeln!(
            text,
            "  {WARNING}{unsettled} points{WARNING:#} (marked *) had not settled before the measurement; \
             raise --max-transient"
        );
    }
    text
}

/// The points, one per row.
fn table(result: &SweepResult<'_>) -> Table {
    let axes = result.axes.iter();
    let table = axes.fold(Table::default().right(""), |table, axis| table.right(axis));
    let table = table
        .left("type of motion")
        .right("amplitude, um")
        .right("line, Hz")
        .right("doubling");
    let mut table = table.right("exponent, 1/s").right("unstable modes");
    for point in result.points {
        let response = point.outcome.as_ref().ok();
        let mark = if point.is_unsettled() { "*" } else { "" };
        let line = response.and_then(|response| response.lines.first());
        let spectrum = response.and_then(|response| response.exponents.as_ref());
        let largest = spectrum.and_then(|spectrum| spectrum.exponents.first());
        let linear = response.and_then(|response| response.linear.as_ref());
        let mut row = vec![point.place.start.to_string()];
        row.extend(point.place.values.iter().map(f64::to_string));
        row.extend([
            format!("{}{mark}", point.regime_name()),
            fixed(response.map(|response| 1e6 * response.amplitude), 4),
            fixed(line.map(|line| line.frequency), 1),
            response.map_or_else(String::new, |response| response.doubling.to_string()),
            largest.map_or_else(String::new, |e| uncertain(e.value, e.half_width)),
            linear.map_or_else(String::new, |linear| linear.unstable().count().to_string()),
        ]);
        table.row(row);
    }
    table
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
