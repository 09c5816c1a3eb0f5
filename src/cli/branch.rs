//! `squeakscope branch`: equilibria over a parameter with their modes and bifurcations, or a stability map over two.

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};

use super::console;
use super::error::CliError;
use super::figures::STUDY;
use super::harness::{Outputs, Watch};
use super::output::Kind;
use super::resources;
use super::steps::{Interval, parameters};
use super::study_args::BranchArgs;
use crate::export::replace_file;
use crate::plot::{branch_figures, map_figure};
use crate::record::branch::save_branch;
use crate::scene::{Parameter, Scene};
use crate::study::branch::{
    Branch, BranchPlan, MapPlan, OrbitStarts, TiltDiagram, add_tori, stability_map, write_branch,
};
use crate::study::sweep::{SweepPlan, SweepPoint, TableError, read_table};
use crate::study::{StudyError, threads};

/// Default interval of the tilt, degrees.
const TILTS: Interval = Interval([0.0, 8.0]);
/// Default numbers of points of the equilibria, and of each parameter of a map.
const POINTS: [u32; 2] = [81, 41];
/// Stems of the figures' file names over one parameter, and over two.
const FIGURES: [&[&str]; 2] = [&["modes", "branch", "multipliers"], &["stability-map"]];

/// A parameter and its interval.
type Span = (Parameter, [f64; 2]);

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while computing or writing; an interrupt, after the results so far are written.
pub(super) fn execute(args: &BranchArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    let spans = spans(args, &scene)?;
    console::print_study_warnings(&scene);
    console::print_fixed(&scene, spans.iter().map(|span| span.0));
    match spans[..] {
        [one, two] => map(args, stop, scene, [one, two]),
        _ => branch(args, stop, scene, spans[0]),
    }
}

/// The branches over one parameter.
fn branch(
    args: &BranchArgs,
    stop: &AtomicBool,
    scene: Scene,
    (parameter, interval): Span,
) -> Result<(), CliError> {
    let settled = settled(args, parameter)?;
    let points = args.points.unwrap_or(POINTS[0]) as usize;
    let plan = BranchPlan::new(scene.clone(), parameter, interval, points);
    if args.diagram.is_some() && parameter != Parameter::tilt() {
        return Err(CliError::Input(format!(
            "--diagram needs the tilt as its parameter, not `{}`; give --tilt A:B without --param",
            parameter.path()
        )));
    }
    if let Some(start) = args.start {
        plan.check_start(start)?;
    }
    let files = Outputs::new(args.scene.input(), &args.output)
        .file("--out", Kind::TABLE, args.out.as_ref())?
        .file("--save", Kind::RECORDING, args.save.as_ref())?
        .file("--diagram", Kind::JSON, args.diagram.as_ref())?
        .figures(&args.figures, STUDY, FIGURES[0])?;
    resources::start_thread_pool()?;
    let name = &scene.name;
    let watch = Watch::new(stop);
    let mut result = compute(args, &watch, &scene, &plan).map_err(failed)?;
    result.settled.extend(settled);
    result.interrupted = stop.load(Ordering::Relaxed);
    files.finish(watch, Some(name), &result, |files| {
        // A part of a diagram would look like all of it.
        if !result.interrupted {
            let diagram = TiltDiagram::new(&result);
            files.write("--diagram", |path| {
                replace_file(path, |out| {
                    writeln!(out, "{}", serde_json::to_string(&diagram)?)
                })
            })?;
        }
        files.write("--out", |path| {
            write_branch(path, &result).map_err(CliError::during("writing of the table"))
        })?;
        let drawn = files.draw(|| branch_figures(name, &result));
        if !result.points.is_empty() {
            files.write("--save", |path| {
                let saved = save_branch(path, &scene, &result, &console::command_line());
                saved.map_err(CliError::during("recording"))
            })?;
        }
        drawn
    })
}

/// Computes the branches and, if requested, the tori.
fn compute(
    args: &BranchArgs,
    watch: &Watch<'_>,
    scene: &Scene,
    plan: &BranchPlan,
) -> Result<Branch, StudyError> {
    let starts = match (args.start, &args.diagram) {
        _ if args.equilibria => None,
        (Some(value), _) => Some(OrbitStarts::At(value)),
        (None, Some(_)) => Some(OrbitStarts::Sweep(scene, threads(args.threads))),
        (None, None) => Some(OrbitStarts::Scene),
    };
    let mut update = watch.progress();
    let mut result = plan.follow(starts, &mut update, &mut |_| ())?;
    if let Some(count) = args.tori {
        add_tori(plan, count, &mut result, &mut update)?;
    }
    Ok(result)
}

/// The points of the sweep for the branch diagram.
fn settled(args: &BranchArgs, parameter: Parameter) -> Result<Vec<SweepPoint>, CliError> {
    let Some(path) = &args.sweep else {
        return Ok(Vec::new());
    };
    let table = read_table(path)?;
    let plan = SweepPlan::from_identity(&table.identity)
        .map_err(|reason| TableError::invalid(path, reason))?;
    match &plan.axes[..] {
        [axis] if axis.name == parameter.path() => Ok(table.points),
        _ => Err(CliError::Input(format!(
            "`{}` (--sweep) is not a sweep over `{}` alone; give the table of one",
            path.display(),
            parameter.path()
        ))),
    }
}

/// The stability map over two parameters.
fn map(
    args: &BranchArgs,
    stop: &AtomicBool,
    scene: Scene,
    spans: [Span; 2],
) -> Result<(), CliError> {
    let of_one = [
        ("--out", args.out.is_some()),
        ("--save", args.save.is_some()),
        ("--diagram", args.diagram.is_some()),
        ("--sweep", args.sweep.is_some()),
        ("--start", args.start.is_some()),
        ("--tori", args.tori.is_some()),
    ];
    if let Some((option, _)) = of_one.into_iter().find(|(_, given)| *given) {
        return Err(CliError::Input(format!(
            "{option} needs one parameter; for a map over two, use --json or --figures"
        )));
    }
    let outputs = Outputs::new(args.scene.input(), &args.output);
    let files = outputs.figures(&args.figures, STUDY, FIGURES[1])?;
    let plan = MapPlan {
        scene,
        parameters: spans.map(|span| span.0),
        intervals: spans.map(|span| span.1),
        size: [args.points.unwrap_or(POINTS[1]) as usize; 2],
        orbits: !args.equilibria,
    };
    let name = &plan.scene.name;
    let watch = Watch::new(stop);
    let map = stability_map(&plan, threads(args.threads), &mut watch.progress());
    let map = map.map_err(failed)?;
    files.finish(watch, Some(name), &map, |files| {
        files.draw(|| vec![map_figure(name, &map)])
    })
}

/// The parameters and their intervals: one, or two for a map.
fn spans(args: &BranchArgs, scene: &Scene) -> Result<Vec<Span>, CliError> {
    let spans = parameters(scene, args.tilt, &args.param, TILTS)?.into_iter();
    let spans: Vec<Span> = spans.map(|(parameter, span)| (parameter, span.0)).collect();
    for &(parameter, interval) in &spans {
        if !parameter.is_continuous() {
            return Err(CliError::Input(format!(
                "`{}` is a count or a seed, over which no branch is continuous; choose a real number (`squeakscope \
                 scenes --keys` lists all keys)",
                parameter.path()
            )));
        }
        // Refuse invalid values before the study starts.
        for value in interval {
            scene.with_values(&[(parameter, value)])?;
        }
    }
    Ok(spans)
}

fn failed(source: StudyError) -> CliError {
    CliError::during("study of branches")(source)
}
