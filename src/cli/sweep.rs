//! `squeakscope sweep` and `squeakscope merge`: what happens as a number of the scene changes?

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::document::{Document, WrittenFile};
use super::error::CliError;
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{OutputFile, check_all, check_directory};
use super::progress::Progress;
use super::report;
use super::resources;
use super::run::command_line;
use super::study_args::{
    MergeArgs, Over, ResponseArgs, SweepArgs, SweepOutputs, SweepStart, WorkArgs,
};
use crate::escape;
use crate::joint::BallJoint;
use crate::number::{fixed, uncertain};
use crate::plot::sweep_figures;
use crate::record::sweep::{SweepStudy, save_sweep};
use crate::scene::{Held, Parameter, TiltedJoint};
use crate::study::response::ResponsePlan;
use crate::study::sweep::{
    Audience, Axis, CsvWriter, Shard, Start, SweepPlan, SweepPoint, SweepProgress, SweepResult,
    SweepTable, TableError, TableWriter, read_table, sweep, write_csv, write_table,
};
use crate::study::threads;
use crate::table::Table;

/// The tilts that are swept if nothing is said, degrees: those of Fig. 11.
const TILTS: [f64; 3] = [1.0, 8.0, 0.5];

const NAME: Style = Style::new().bold();
const BEWARE: Style = AnsiColor::Yellow.on_default().bold();

/// More rows than these are not printed.
const MOST_ROWS: usize = 100;

/// Runs `squeakscope sweep`.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C, after what is known has been
/// written.
pub(super) fn run(args: &SweepArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop)
}

fn execute(args: &SweepArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let plan = plan(args)?;
    check_timeline(&plan, &args.outputs)?;
    report::print_warnings(&plan.scene.clone().without_analyses().warnings());
    report::print_held(held(&plan));
    let scene = args.scene.input();
    let files = Files::check(scene, &args.outputs, &names(&plan))?;
    let (mut points, done) = work_through(&plan, &args.work, &files, stop)?;
    let shard = args.work.shard.unwrap_or(Shard::WHOLE);
    deliver(&plan, &mut points, (&args.outputs, &files), (shard, !done))?;
    if done {
        Ok(())
    } else {
        Err(CliError::Interrupted)
    }
}

/// Takes the responses that are not in the table yet, and adds them to it. All points known, and
/// whether they are all that there should be.
pub(super) fn work_through(
    plan: &SweepPlan,
    work: &WorkArgs,
    files: &Files,
    stop: &AtomicBool,
) -> Result<(Vec<SweepPoint>, bool), CliError> {
    let known = known(work.resume, plan, files.table.path())?;
    resources::start_pool()?;
    interrupt::work_begins();
    let mut notes = Notes {
        table: TableWriter::new(files.table.path(), &plan.identity(), &known)?,
        csv: CsvWriter::new(files.csv.path(), plan, &known)?,
        points: known.clone(),
        progress: Progress::of_estimate(),
        stop,
    };
    let shard = work.shard.unwrap_or(Shard::WHOLE);
    let threads = threads(work.threads);
    let done = sweep(plan, shard, &known, threads, &mut notes)?;
    Ok((notes.points, done))
}

/// Runs `squeakscope merge`.
///
/// # Errors
/// Bad input: a table that cannot be read, of another sweep, or that says otherwise of the same point;
/// a fault while writing.
pub(super) fn merge(args: &MergeArgs) -> Result<(), CliError> {
    let mut tables = args
        .tables
        .iter()
        .map(|path| read_table(path).map(|table| (path, table)));
    let (path, first) = match tables.next() {
        Some(read) => read?,
        None => return Ok(()),
    };
    let plan = SweepPlan::of_identity(&first.identity).map_err(|reason| {
        CliError::Table(TableError::Foreign {
            path: path.clone(),
            reason,
        })
    })?;
    check_timeline(&plan, &args.outputs)?;
    let identity = first.identity.clone();
    // Points by their places in the plan.
    let mut merged: BTreeMap<usize, SweepPoint> = BTreeMap::new();
    for read in std::iter::once(Ok((path, first))).chain(tables) {
        let (path, table) = read?;
        table.check(&plan, path)?;
        warn_of_tear(path, &table);
        for point in table.points {
            let index = point.place.index;
            let there = merged.entry(index).or_insert_with(|| point.clone());
            if *there != point {
                return Err(CliError::Table(TableError::Foreign {
                    path: path.clone(),
                    reason: format!("its point {index} is not what another table says of it"),
                }));
            }
        }
    }
    let mut merged: Vec<SweepPoint> = merged.into_values().collect();
    let files = Files::check(None, &args.outputs, &names(&plan))?;
    // What an earlier merge has made may be made again; anything else is kept.
    let out = files.table.path();
    let own = read_table(out).is_ok_and(|table| table.identity == identity);
    if out.exists() && !own {
        return Err(CliError::WouldReplace {
            path: out.to_owned(),
        });
    }
    deliver(
        &plan,
        &mut merged,
        (&args.outputs, &files),
        (Shard::WHOLE, false),
    )
}

/// Stems of the names of the figures, which do not depend on the points.
fn names(plan: &SweepPlan) -> Vec<String> {
    let figures = sweep_figures(plan, &[]).into_iter();
    figures.map(|figure| figure.name).collect()
}

/// A recording has one timeline, and so a sweep that is recorded has one parameter.
fn check_timeline(plan: &SweepPlan, outputs: &SweepOutputs) -> Result<(), CliError> {
    match (&plan.axes[..], &outputs.save) {
        ([first, second, ..], Some(_)) => Err(CliError::NoTimeline {
            first: first.parameter().path(),
            second: second.parameter().path(),
        }),
        _ => Ok(()),
    }
}

/// The files asked for, checked before any work.
pub(super) struct Files {
    table: OutputFile,
    csv: OutputFile,
    pub json: Option<OutputFile>,
    save: Option<OutputFile>,
}

impl Files {
    /// Checks all of them; `figures` are the stems of the names of the figures.
    pub fn check(
        input: Option<&OsStr>,
        outputs: &SweepOutputs,
        figures: &[String],
    ) -> Result<Self, CliError> {
        let csv = outputs.out.with_extension("csv");
        let ending = outputs
            .out
            .extension()
            .and_then(OsStr::to_str)
            .unwrap_or("");
        if !["", "arrow", "arrows"].contains(&ending) {
            return Err(CliError::NotArrow {
                path: outputs.out.clone(),
            });
        }
        let json = outputs
            .json
            .as_deref()
            .filter(|path| *path != Path::new("-"));
        if let Some(directory) = &outputs.figures {
            let names = outputs.drawn.names(figures, &STUDY);
            check_directory(directory, "--figures", &names)?;
        }
        let [table, csv, json, save] = check_all(
            input,
            [
                ("--out", Some(&*outputs.out)),
                ("--out, short table", Some(&*csv)),
                ("--json", json),
                ("--save", outputs.save.as_deref()),
            ],
        )?;
        if save.is_some() {
            resources::check_memory()?;
        }
        match (table, csv) {
            (Some(table), Some(csv)) => Ok(Self {
                table,
                csv,
                json,
                save,
            }),
            _ => unreachable!("both were asked for"),
        }
    }
}

/// What is done as points come.
struct Notes<'a> {
    table: TableWriter,
    csv: CsvWriter,
    points: Vec<SweepPoint>,
    progress: Progress,
    stop: &'a AtomicBool,
}

impl Audience for Notes<'_> {
    type Error = TableError;

    fn point(&mut self, point: SweepPoint) -> Result<(), TableError> {
        self.table.add(&point)?;
        self.csv.add(&point)?;
        self.points.push(point);
        Ok(())
    }

    fn progress(&mut self, progress: SweepProgress) -> bool {
        let SweepProgress { done, all, share } = progress;
        self.progress.tell(share, format!("{done} of {all} points"));
        !self.stop.load(Ordering::Relaxed)
    }
}

/// Writes the whole tables, draws, and shows what is found.
fn deliver(
    plan: &SweepPlan,
    points: &mut [SweepPoint],
    (outputs, files): (&SweepOutputs, &Files),
    (shard, interrupted): (Shard, bool),
) -> Result<(), CliError> {
    let mut written = write_tables(plan, points, files)?;
    if let Some(directory) = &outputs.figures {
        let drawn = (&outputs.drawn, &STUDY[..]);
        let figures = sweep_figures(plan, points);
        written.extend(write_figures(directory, "--figures", &figures, drawn)?);
    }
    written.extend(write_recording(plan, points, files, None)?);
    let found = SweepResult::new(plan, points, shard, interrupted);
    let document = Document::new(&found, &written).of_scene(&plan.scene.name);
    show(&document, &text(&plan.scene.name, &found), outputs, files)
}

/// Shows a result, or prints it as JSON, as asked for.
pub(super) fn show(
    document: &Document<'_, impl Serialize>,
    text: &str,
    outputs: &SweepOutputs,
    files: &Files,
) -> Result<(), CliError> {
    match outputs.json.as_deref() == Some(Path::new("-")) {
        true => document.print()?,
        false => document.deliver(text, files.json.as_ref())?,
    }
    Ok(())
}

/// Writes the points in their order, and the short table beside them.
pub(super) fn write_tables(
    plan: &SweepPlan,
    points: &mut [SweepPoint],
    files: &Files,
) -> Result<Vec<WrittenFile>, CliError> {
    write_table(files.table.path(), &plan.identity(), points)?;
    write_csv(files.csv.path(), plan, points)?;
    Ok(vec![
        WrittenFile::of(&files.table)?,
        WrittenFile::of(&files.csv)?,
    ])
}

/// Writes the recording, if one is asked for; of nothing there is none. With the modes of ball and beam, if they
/// are to be shown.
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
    save_sweep(file.path(), &sweep).map_err(|source| CliError::Run {
        doing: "recording",
        source: source.into(),
    })?;
    Ok(Some(WrittenFile::of(file)?))
}

/// The points that are known already. A file that is there is only touched by `--resume`.
fn known(resume: bool, plan: &SweepPlan, path: &Path) -> Result<Vec<SweepPoint>, CliError> {
    match (path.exists(), resume) {
        (false, _) => Ok(Vec::new()),
        (true, false) => Err(CliError::WouldReplace {
            path: path.to_owned(),
        }),
        (true, true) => {
            // Killed before its first point was there.
            if path.metadata().is_ok_and(|meta| meta.len() == 0) {
                return Ok(Vec::new());
            }
            let table = read_table(path)?;
            table.check(plan, path)?;
            warn_of_tear(path, &table);
            Ok(table.points)
        }
    }
}

/// Says so where a table breaks off.
fn warn_of_tear(path: &Path, table: &SweepTable) {
    if table.torn {
        report::print_warning(&format!(
            "`{}` breaks off after {} whole points: what follows is lost",
            path.display(),
            table.points.len()
        ));
    }
}

/// Where the sweep holds what varies in its scene; a tilt that is swept is not held.
fn held(plan: &SweepPlan) -> Held {
    let joint = plan.scene.joint();
    let held = joint.map_or_else(|_| Held::default(), TiltedJoint::held_at_first);
    let sweeps_tilt = plan.axes.iter().any(|a| a.parameter() == Parameter::tilt());
    Held {
        tilt: held.tilt.filter(|_| !sweeps_tilt),
        ..held
    }
}

/// What is asked for.
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
    for Over { name, values } in &args.over {
        axes.push(Axis::new(Parameter::named(name)?, values.values()));
    }
    if scene.joint().is_err()
        && axes
            .iter()
            .all(|axis| axis.parameter() == Parameter::tilt())
    {
        return Err(CliError::NoTilt { scene: scene.name });
    }
    if axes.is_empty() {
        let [from, to, step] = TILTS;
        let count = ((to - from) / step).round() as u32;
        let tilts = (0..=count).map(|k| from + f64::from(k) * step);
        axes.push(Axis::new(Parameter::tilt(), tilts));
    }
    if axes.len() > 2 {
        return Err(CliError::TooManyAxes { count: axes.len() });
    }
    if let [one, two] = &axes[..]
        && one.parameter() == two.parameter()
    {
        return Err(CliError::AxisTwice {
            path: one.parameter().path(),
        });
    }
    let plan = SweepPlan {
        scene,
        response: response_plan(&args.response, axes.len() == 1),
        axes,
        starts: match args.start {
            SweepStart::Cold => vec![Start::Cold],
            SweepStart::Up => vec![Start::Up],
            SweepStart::Down => vec![Start::Down],
            SweepStart::Both => vec![Start::Up, Start::Down],
            SweepStart::All => Start::ALL.to_vec(),
        },
    };
    // What cannot be is told now, not at the end of the sweep.
    for axis in &plan.axes {
        for value in axis.values() {
            plan.scene.with_values(&[(axis.parameter(), *value)])?;
        }
    }
    for index in [0, plan.len() - 1] {
        plan.scene_at(&plan.place(index))?;
    }
    check_times(&args.response)?;
    Ok(plan)
}

/// Refuses a shortest time beyond the longest.
pub(super) fn check_times(args: &ResponseArgs) -> Result<(), CliError> {
    match args.least <= args.most {
        true => Ok(()),
        false => Err(CliError::Times {
            least: args.least,
            most: args.most,
        }),
    }
}

/// How responses are taken.
pub(super) fn response_plan(args: &ResponseArgs, portrait: bool) -> ResponsePlan {
    ResponsePlan {
        least: 1e-3 * args.least,
        most: 1e-3 * args.most,
        measure: 1e-3 * args.measure,
        exponents: args.exponents,
        portrait,
        most_calls: None,
    }
}

/// The text for the terminal.
fn text(scene: &str, found: &SweepResult<'_>) -> String {
    let scene = escape::line(scene);
    let mut text = format!("{NAME}{scene}{NAME:#} over {}\n", found.axes.join(" and "));
    let (known, part) = (found.points_known, found.points_of_part);
    if known < part {
        let _ = writeln!(
            text,
            "  {BEWARE}{known} of {part} points{BEWARE:#} so far; --resume goes on with the rest"
        );
    } else if known < found.points_in_all {
        let _ = writeln!(
            text,
            "  a part: {known} of {} points; `squeakscope merge` joins the parts",
            found.points_in_all
        );
    }
    for stretch in &found.stretches {
        let values = match stretch.from == stretch.to {
            true => stretch.from.to_string(),
            false => format!("{} to {}", stretch.from, stretch.to),
        };
        let _ = writeln!(text, "  {:>4}  {values}: {}", stretch.start, stretch.regime);
    }
    if !found.hysteresis.is_empty() {
        let values: Vec<String> = found.hysteresis.iter().map(f64::to_string).collect();
        let _ = writeln!(text, "  up and down differ at {}", values.join(", "));
    }
    if found.points.len() <= MOST_ROWS {
        let _ = writeln!(text, "\n{}", table(found).text());
    }
    let count = |what: fn(&SweepPoint) -> bool| found.points.iter().filter(|p| what(p)).count();
    let failed = count(|point| point.outcome.is_err());
    if failed > 0 {
        let _ = writeln!(
            text,
            "  {BEWARE}{failed} points{BEWARE:#} have no response: see `error` in the tables"
        );
    }
    let unsettled = count(SweepPoint::is_unsettled);
    if unsettled > 0 {
        let _ = writeln!(
            text,
            "  {BEWARE}{unsettled} points{BEWARE:#} (marked *) still changed when they were measured; give a longer --most"
        );
    }
    text
}

/// The points, a row each.
fn table(found: &SweepResult<'_>) -> Table {
    let axes = found.axes.iter();
    let table = axes.fold(Table::default().right(""), |table, axis| table.right(axis));
    let table = table.left("motion").right("um").right("line, Hz");
    let mut table = table.right("exponent, 1/s").left("unstable");
    for point in found.points {
        let response = point.outcome.as_ref().ok();
        let mark = if point.is_unsettled() { "*" } else { "" };
        let line = response.and_then(|found| found.lines.first());
        let spectrum = response.and_then(|found| found.exponents.as_ref());
        let largest = spectrum.and_then(|spectrum| spectrum.exponents.first());
        let linear = response.and_then(|found| found.linear.as_ref());
        let mut row = vec![point.place.start.to_string()];
        row.extend(point.place.values.iter().map(f64::to_string));
        row.extend([
            format!("{}{mark}", point.kind()),
            fixed(response.map(|found| 1e6 * found.amplitude), 4),
            fixed(line.map(|line| line.frequency), 1),
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
