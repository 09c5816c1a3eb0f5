//! `squeakscope basins`: which attractors coexist, and how many kicks lead to each?

use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use super::document::Document;
use super::error::CliError;
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::lyapunov_text::title;
use super::report;
use super::study_args::BasinsArgs;
use super::sweep::{
    Files, check_times, response_plan, show, work_through, write_recording, write_tables,
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
/// Bad input before any work; a fault while running or writing; Ctrl-C, after what is known has been
/// written.
pub(super) fn basins(args: &BasinsArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop)
}

fn execute(args: &BasinsArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let plan = plan(args)?;
    report::print_warnings(&plan.scene.clone().without_analyses().warnings());
    if let Ok(joint) = plan.scene.joint() {
        report::print_held(joint.held_at_first());
    }
    let scene = args.scene.input();
    let files = Files::check(scene, &args.outputs, &["basins".to_owned()])?;
    let (mut points, done) = work_through(&plan, &args.work, &files, stop)?;
    let mut written = write_tables(&plan, &mut points, &files)?;
    let found = Basins::new(&plan, &points, !done);
    let title = title(&plan.scene.name, found.tilt);
    if let Some(directory) = &args.outputs.figures {
        let figure = basins_figure(&title, &points, &found.attractors);
        let drawn = (&args.outputs.drawn, &STUDY[..]);
        written.extend(write_figures(directory, "--figures", &[figure], drawn)?);
    }
    written.extend(write_recording(&plan, &points, &files, None)?);
    let document = Document::new(&found, &written).of_scene(&plan.scene.name);
    show(&document, &text(&title, &found), &args.outputs, &files)?;
    if done {
        Ok(())
    } else {
        Err(CliError::Interrupted)
    }
}

/// The kicks are a sweep over their seeds.
fn plan(args: &BasinsArgs) -> Result<SweepPlan, CliError> {
    check_times(&args.response)?;
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
        starts: vec![Start::Cold],
        response: response_plan(&args.response, true),
    })
}

/// The text for the terminal.
fn text(title: &str, found: &Basins) -> String {
    /// More seeds than these are in the tables.
    const SHOWN: usize = 8;

    let mut text = format!(
        "{}: {} attractors of {} kicks\n",
        escape::line(title),
        found.attractors.len(),
        found.followed
    );
    if found.followed < found.kicks {
        let _ = writeln!(
            text,
            "  {} of {} kicks so far; --resume goes on with the rest",
            found.followed, found.kicks
        );
    }
    let mut table = Table::default().right("share").right("95 %").left("motion");
    table = table.right("line, Hz").right("um").left("seeds");
    for attractor in &found.attractors {
        let seeds = attractor.seeds.iter().take(SHOWN).map(u64::to_string);
        let more = match attractor.seeds.len() > SHOWN {
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
    if found.undecided > 0 {
        let _ = writeln!(
            text,
            "  {} kicks undecided: their motion still changed when it was measured, or could not be \
             followed; give a longer --most",
            found.undecided
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
            },
            tilt: Some(2.5),
            kicks: 3,
            kick: Some(0.02),
            seed: 7,
            response: ResponseArgs {
                least: 20.0,
                most: 400.0,
                measure: 10.0,
                exponents: 0,
                tolerance: Some(1e-4),
                accuracy: AccuracyArgs::default(),
            },
            work: WorkArgs::default(),
            outputs: SweepOutputs {
                out: folder.join("basins.arrow"),
                figures: Some(folder.join("figures")),
                drawn: Default::default(),
                save: Some(folder.join("basins.rrd")),
                json: Some(folder.join("basins.json")),
            },
        }
    }

    #[test]
    fn all_kicks_of_the_printed_friction_come_to_rest() {
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
        assert_eq!(report["files"].as_array().unwrap().len(), 5);
        let saved = std::fs::metadata(folder.path().join("basins.rrd")).unwrap();
        assert!(saved.len() > 0);
        // What is there is not done again, and not lost either.
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
