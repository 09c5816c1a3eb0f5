//! `squeakscope basins`: coexisting attractors and the share of random kicks that reach each.

use std::sync::atomic::AtomicBool;

use super::console;
use super::error::CliError;
use super::harness::Watch;
use super::points::{compute_points, outputs, response_plan, tables, write};
use super::study_args::BasinsArgs;
use crate::plot::basins_figure;
use crate::report::Report as _;
use crate::scene::Parameter;
use crate::study::basins::Basins;
use crate::study::lyapunov::title;
use crate::study::sweep::{Axis, Start, SweepPlan};

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the results so far are
/// written.
pub(super) fn execute(args: &BasinsArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let plan = plan(args)?;
    console::print_study_warnings(&plan.subject);
    console::print_fixed(&plan.subject, []);
    let stems = ["basins".to_owned()];
    let files = outputs(args.scene.input(), &args.outputs, Some(&args.work), &stems)?;
    let watch = Watch::new(stop);
    let points = compute_points(&plan, &args.work, tables(&files), &watch)?;
    let basins = Basins::new(plan.subject.start_tilt(), plan.size(), &points);
    files.finish(watch, Some(&plan.subject.name), &basins, |files| {
        let title = title(&plan.subject.name, basins.tilt);
        let figures = || vec![basins_figure(&title, &points, &basins.attractors)];
        let report = basins.blocks(&plan.subject.name);
        write(&plan, &points, basins.interrupted, files, figures, &report)
    })
}

/// The random kicks as a sweep over the seed.
fn plan(args: &BasinsArgs) -> Result<SweepPlan, CliError> {
    let numbers = [
        ("load.tilt_deg", args.tilt),
        ("start.kick_mm_per_s", args.kick),
        ("time.tolerance", args.response.tolerance),
    ];
    let scene = args.scene.load_with(args.response.accuracy, &numbers)?;
    let seeds = (0..args.kicks).map(|k| (args.seed + u64::from(k)) as f64);
    Ok(SweepPlan {
        subject: scene,
        axes: vec![Axis::new(Parameter::named("start.seed")?, seeds)],
        starts: vec![Start::Fresh],
        response: response_plan(&args.response, true)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::tests::parsed;

    fn run(folder: &std::path::Path, line: &str) -> Result<(), CliError> {
        let folder = folder.display();
        let study = "--kicks 3 --kick 0.02 --seed 7 --min-transient 20 --max-transient 400 --measure 10 --exponents 0";
        let outputs = format!(
            "--out {folder}/basins.arrow --figures {folder}/figures --save {folder}/basins.rrd --json {folder}/basins.json"
        );
        let line = format!("printed-friction --tolerance 1e-4 {study} {outputs} {line}");
        execute(&parsed(&line), &AtomicBool::new(false))
    }

    #[test]
    fn every_kick_with_the_printed_friction_decays() {
        let folder = tempfile::tempdir().unwrap();
        run(folder.path(), "--tilt 2.5").unwrap();
        let json = std::fs::read(folder.path().join("basins.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(report["tilt_rad"], 2.5_f64.to_radians());
        assert_eq!(report["undecided"], 0);
        let attractors = report["attractors"].as_array().unwrap();
        assert_eq!(attractors.len(), 1, "{report}");
        assert_eq!(attractors[0]["regime"], "silent");
        assert_eq!(attractors[0]["share"], 1.0);
        assert_eq!(attractors[0]["seeds"], serde_json::json!([7, 8, 9]));
        let svg = std::fs::read_to_string(folder.path().join("figures/basins.svg")).unwrap();
        assert!(svg.contains("<title>printed-friction at 2.5 deg"), "{svg}");
        assert_eq!(report["files"].as_array().unwrap().len(), 4);
        let saved = std::fs::metadata(folder.path().join("basins.rrd")).unwrap();
        assert!(saved.len() > 0);
        // The existing table is not replaced.
        let again = run(folder.path(), "--tilt 2.5").unwrap_err();
        assert_eq!(again.exit_code(), 2);
    }

    #[test]
    fn a_tilt_out_of_range_is_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let error = run(folder.path(), "--tilt 91").unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(!folder.path().join("basins.arrow").exists());
    }
}
