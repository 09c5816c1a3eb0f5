//! `squeakscope sweep` and `squeakscope merge`: the settled response over parameters of a scene.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use super::console;
use super::error::CliError;
use super::harness::{Outputs, Watch};
use super::points::{compute_points, outputs, points_of, response_plan, tables, write};
use super::steps::{Steps, parameters};
use super::study_args::{MergeArgs, SweepArgs, SweepOutputs};
use crate::plot::sweep_figures;
use crate::report::Report as _;
use crate::study::sweep::{
    Axis, Shard, SweepPlan, SweepPoint, SweepResult, TableError, read_table,
};

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

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
