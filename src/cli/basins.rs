//! `squeakscope basins`: which attractors coexist, and how many kicks lead to each?

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::error::CliError;
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::report::{self, FileReport, Report, list_files};
use super::study_args::BasinsArgs;
use super::sweep::{
    Files, check_times, response_plan, work_through, write_recording, write_tables,
};
use crate::VERSION;
use crate::escape;
use crate::plot::Figure;
use crate::scene::{DEFAULT_SCENE, Parameter, Scene};
use crate::study::basins::{Attractor, attractors};
use crate::study::sweep::{Axis, Start, SweepPlan, SweepPoint};

/// What the rest of the crate does for this command.
pub(super) struct Tools {
    /// The figure of coexisting attractors under a title.
    pub draw: fn(&str, &[SweepPoint], &[Attractor]) -> Figure,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C, after what is known has been
/// written.
pub(super) fn basins(args: &BasinsArgs, tools: &Tools) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, tools)
}

fn execute(args: &BasinsArgs, stop: &AtomicBool, tools: &Tools) -> Result<(), CliError> {
    let plan = plan(args)?;
    report::print_warnings(&plan.scene.clone().without_analyses().warnings());
    if let Ok(joint) = plan.scene.joint() {
        report::print_held(joint.held_at_first());
    }
    let scene = args.scene.as_deref().map(OsStr::new);
    let files = Files::check(scene, &args.outputs, &["basins".to_owned()])?;
    let (mut points, done) = work_through(&plan, &args.work, &files, stop)?;
    let mut written = write_tables(&plan, &mut points, &files)?;
    let found = attractors(&points);
    let joint = plan.scene.joint().ok();
    let tilt = joint.map(|joint| report::degrees(joint.tilt.at(0.0)));
    if let Some(directory) = &args.outputs.figures {
        let title = match tilt {
            Some(tilt) => format!("{} at {tilt} deg", plan.scene.name),
            None => plan.scene.name.clone(),
        };
        let figure = (tools.draw)(&title, &points, &found);
        let drawn = (&args.outputs.drawn, &STUDY[..]);
        written.extend(write_figures(directory, "--figures", &[figure], drawn)?);
    }
    written.extend(write_recording(&plan, &points, &files, None)?);
    let report = BasinsReport::new(&plan, tilt, &points, &found, !done, written);
    match args.outputs.json.as_deref() == Some(std::path::Path::new("-")) {
        true => report::print_json(&report)?,
        false => report::deliver(&report, files.json.as_ref())?,
    }
    if done {
        Ok(())
    } else {
        Err(CliError::Interrupted)
    }
}

/// The kicks are a sweep over their seeds.
fn plan(args: &BasinsArgs) -> Result<SweepPlan, CliError> {
    check_times(&args.response)?;
    let mut scene = Scene::load(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    if let Some(error) = args.response.accuracy {
        scene = scene.with_accuracy(error)?;
    }
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

/// Result of `squeakscope basins`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BasinsReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// Tilt of the load, degrees; `null` for a scene without a load.
    pub tilt_deg: Option<f64>,
    /// Kicks in all.
    pub kicks: usize,
    /// Kicks that have been followed.
    pub followed: usize,
    /// Kicks whose motion still changed when it was measured, or could not be followed.
    pub undecided: usize,
    /// Whether Ctrl-C ended it before its time.
    pub interrupted: bool,
    /// The attractors, the commonest first.
    pub attractors: Vec<AttractorReport>,
    /// Files written.
    pub files: Vec<FileReport>,
}

/// One attractor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttractorReport {
    /// Kind of motion.
    pub regime: String,
    /// Frequency of the strongest line, Hz.
    pub frequency_hz: Option<f64>,
    /// Amplitude at the probe, um.
    pub amplitude_um: f64,
    /// Its share of the kicks followed, 0 to 1.
    pub share: f64,
    /// The share's 95 % interval.
    pub interval: [f64; 2],
    /// Seeds of the kicks that led to it.
    pub seeds: Vec<u64>,
}

impl BasinsReport {
    fn new(
        plan: &SweepPlan,
        tilt_deg: Option<f64>,
        points: &[SweepPoint],
        attractors: &[Attractor],
        interrupted: bool,
        files: Vec<FileReport>,
    ) -> Self {
        let decided: usize = attractors.iter().map(|a| a.members.len()).sum();
        let reports = attractors.iter().map(|attractor| AttractorReport {
            regime: attractor.regime.to_string(),
            frequency_hz: attractor.frequency,
            amplitude_um: 1e6 * attractor.amplitude,
            share: attractor.share,
            interval: attractor.interval,
            seeds: attractor
                .members
                .iter()
                .map(|&k| points[k].place.values[0] as u64)
                .collect(),
        });
        Self {
            version: VERSION,
            scene: plan.scene.name.clone(),
            tilt_deg,
            kicks: plan.len(),
            followed: points.len(),
            undecided: points.len() - decided,
            interrupted,
            attractors: reports.collect(),
            files,
        }
    }
}

impl Report for BasinsReport {
    fn text(&self) -> String {
        let at = self
            .tilt_deg
            .map(|tilt| format!(" at {tilt} deg"))
            .unwrap_or_default();
        let mut text = format!(
            "{}{at}: {} attractors of {} kicks\n",
            escape::line(&self.scene),
            self.attractors.len(),
            self.followed
        );
        if self.followed < self.kicks {
            let _ = writeln!(
                text,
                "  {} of {} kicks so far; --resume goes on with the rest",
                self.followed, self.kicks
            );
        }
        let _ = writeln!(
            text,
            "  {:>6}  {:>10}  {:<16}  {:>9}  {:>8}  seeds",
            "share", "95 %", "motion", "line, Hz", "um"
        );
        for attractor in &self.attractors {
            const SHOWN: usize = 8;
            let seeds = attractor.seeds.iter().take(SHOWN).map(u64::to_string);
            let more = if attractor.seeds.len() > SHOWN {
                ", ..."
            } else {
                ""
            };
            let [low, high] = attractor.interval.map(|share| 100.0 * share);
            let _ = writeln!(
                text,
                "  {:>4.0} %  {:>10}  {:<16}  {:>9}  {:>8.4}  {}{more}",
                100.0 * attractor.share,
                format!("{low:.0} to {high:.0}"),
                attractor.regime,
                attractor
                    .frequency_hz
                    .map(|hz| format!("{hz:.1}"))
                    .unwrap_or_default(),
                attractor.amplitude_um,
                seeds.collect::<Vec<_>>().join(", ")
            );
        }
        if self.undecided > 0 {
            let _ = writeln!(
                text,
                "  {} kicks undecided: their motion still changed when it was measured, or could not be \
                 followed; give a longer --most",
                self.undecided
            );
        }
        list_files(&mut text, &self.files);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::study_args::{ResponseArgs, SweepOutputs, WorkArgs};

    fn draw(title: &str, _: &[SweepPoint], found: &[Attractor]) -> Figure {
        Figure::new(
            "basins",
            format!("{title}: {}", found.len()),
            50.0,
            Vec::new(),
        )
    }

    const TOOLS: Tools = Tools { draw };

    fn args(folder: &std::path::Path) -> BasinsArgs {
        BasinsArgs {
            scene: Some("printed-friction".to_owned()),
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
                accuracy: None,
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
        execute(&args, &AtomicBool::new(false), &TOOLS).unwrap();
        let json = std::fs::read(folder.path().join("basins.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(report["tilt_deg"], 2.5);
        assert_eq!(report["undecided"], 0);
        let attractors = report["attractors"].as_array().unwrap();
        assert_eq!(attractors.len(), 1, "{report}");
        assert_eq!(attractors[0]["regime"], "silent");
        assert_eq!(attractors[0]["share"], 1.0);
        assert_eq!(attractors[0]["seeds"], serde_json::json!([7, 8, 9]));
        let svg = std::fs::read_to_string(folder.path().join("figures/basins.svg")).unwrap();
        assert!(
            svg.contains("<title>printed-friction at 2.5 deg: 1</title>"),
            "{svg}"
        );
        assert!(folder.path().join("basins.rrd").metadata().unwrap().len() > 0);
        // What is there is not done again, and not lost either.
        let again = execute(&args, &AtomicBool::new(false), &TOOLS).unwrap_err();
        assert_eq!(again.exit_code(), 2);
    }

    #[test]
    fn a_tilt_out_of_range_is_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let args = BasinsArgs {
            tilt: Some(91.0),
            ..args(folder.path())
        };
        let error = execute(&args, &AtomicBool::new(false), &TOOLS).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(!args.outputs.out.exists());
    }
}
