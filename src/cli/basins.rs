//! `squeakscope basins`: coexisting attractors and the share of random kicks that reach each.

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use super::document::Document;
use super::error::CliError;
use super::figures::{STUDY, draw};
use super::lyapunov_text::title;
use super::output::Kind;
use super::report;
use super::study_args::BasinsArgs;
use super::sweep::{
    Files, check_transient, compute_points, response_plan, write_points, write_recording,
};
use crate::escape;
use crate::number::fixed;
use crate::plot::basins_figure;
use crate::scene::Parameter;
use crate::study::basins::Basins;
use crate::study::sweep::{Axis, Start, SweepPlan};
use crate::table::Table;

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the results so far are
/// written.
pub(super) fn execute(args: &BasinsArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let plan = plan(args)?;
    report::print_study_warnings(&plan.scene);
    report::print_fixed(&plan.scene, []);
    let scene = args.scene.input();
    let overwrite = args.outputs.overwrite.or(args.work.resume);
    let names = ["basins".to_owned()];
    let files = Files::check(
        (scene, &args.outputs),
        &names,
        (Kind::STUDY_TABLE, overwrite),
    )?;
    let (mut points, done) = compute_points(&plan, &args.work, &files, stop)?;
    let mut written = vec![write_points(&plan, &mut points, &files, done)?];
    let basins = Basins::new(&plan, &points, !done);
    let title = title(&plan.scene.name, basins.tilt);
    // The report is printed even if a file cannot be written.
    let drawn = draw(
        args.outputs.figures.as_deref(),
        || vec![basins_figure(&title, &points, &basins.attractors)],
        (&args.outputs.drawn, &STUDY),
        &mut written,
    );
    written.extend(write_recording(&plan, &points, &files, None)?);
    let document = Document::new(&basins, &written).with_scene(&plan.scene.name);
    let text = text(&title, &basins);
    document.deliver_or_print(&text, args.outputs.json.as_deref(), files.json.as_ref())?;
    drawn?;
    if done {
        Ok(())
    } else {
        Err(CliError::Interrupted)
    }
}

/// The random kicks as a sweep over the seed.
fn plan(args: &BasinsArgs) -> Result<SweepPlan, CliError> {
    check_transient(&args.response)?;
    let mut scene = args.scene.load()?;
    scene = args.response.accuracy.apply(scene)?;
    for (name, value) in [
        ("load.tilt_deg", args.tilt),
        ("start.kick_mm_per_s", args.kick),
        ("time.tolerance", args.response.tolerance),
    ] {
        if let Some(value) = value {
            scene = scene.with_values(&[(Parameter::named(name)?, value)])?;
        }
    }
    let seeds = (0..args.kicks).map(|k| (args.seed + u64::from(k)) as f64);
    Ok(SweepPlan {
        scene,
        axes: vec![Axis::new(Parameter::named("start.seed")?, seeds)],
        starts: vec![Start::Fresh],
        response: response_plan(&args.response, true),
    })
}

/// The report for the terminal.
fn text(title: &str, basins: &Basins) -> String {
    /// Number of seeds per row. The tables have all of them.
    const MAX_SEEDS: usize = 8;

    let mut text = format!(
        "{}: {} attractors from {} kicks\n",
        escape::line(title),
        basins.attractors.len(),
        basins.simulated
    );
    if basins.simulated < basins.kicks {
        let _ = writeln!(
            text,
            "  {} of {} kicks computed; --resume computes the rest",
            basins.simulated, basins.kicks
        );
    }
    let mut table = Table::default()
        .right("share")
        .right("95 % interval")
        .left("type of motion");
    table = table.right("line, Hz").right("amplitude, um").left("seeds");
    for attractor in &basins.attractors {
        let seeds = attractor.seeds.iter().take(MAX_SEEDS).map(u64::to_string);
        let more = match attractor.seeds.len() > MAX_SEEDS {
            true => ", ...",
            false => "",
        };
        let [low, high] = attractor.interval.map(|share| 100.0 * share);
        table.row([
            format!("{:.0} %", 100.0 * attractor.share),
            format!("{low:.0} to {high:.0}"),
            attractor.regime.to_string(),
            fixed(attractor.frequency, 1),
            fixed(1e6 * attractor.amplitude, 4),
            seeds.collect::<Vec<_>>().join(", ") + more,
        ]);
    }
    text += &table.text();
    if basins.undecided > 0 {
        let _ = writeln!(
            text,
            "  {} kicks undecided: the motion had not settled, or the simulation failed; raise \
             --max-transient",
            basins.undecided
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::{AccuracyArgs, SceneArgs};
    use crate::cli::study_args::{ResponseArgs, SweepOutputs, WorkArgs};

    fn args(folder: &std::path::Path) -> BasinsArgs {
        BasinsArgs {
            scene: SceneArgs {
                scene: Some("printed-friction".to_owned()),
                ..SceneArgs::default()
            },
            tilt: Some(2.5),
            kicks: 3,
            kick: Some(0.02),
            seed: 7,
            response: ResponseArgs {
                min_transient: 20.0,
                max_transient: 400.0,
                measure: 10.0,
                exponents: 0,
                tolerance: Some(1e-4),
                accuracy: AccuracyArgs::default(),
            },
            work: WorkArgs::default(),
            outputs: SweepOutputs {
                out: folder.join("basins.arrow"),
                figures: Some(folder.join("figures")),
                overwrite: Default::default(),
                drawn: Default::default(),
                save: Some(folder.join("basins.rrd")),
                json: Some(folder.join("basins.json")),
            },
        }
    }

    #[test]
    fn every_kick_with_the_printed_friction_decays() {
        let folder = tempfile::tempdir().unwrap();
        let args = args(folder.path());
        execute(&args, &AtomicBool::new(false)).unwrap();
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
        let again = execute(&args, &AtomicBool::new(false)).unwrap_err();
        assert_eq!(again.exit_code(), 2);
    }

    #[test]
    fn a_tilt_out_of_range_is_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let args = BasinsArgs {
            tilt: Some(91.0),
            ..args(folder.path())
        };
        let error = execute(&args, &AtomicBool::new(false)).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(!args.outputs.out.exists());
    }
}
