//! `squeakscope cost`: what does accuracy cost in this scene, and which setting is the cheapest?

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::cost_report::CostReport;
use super::engine;
use super::error::{Cause, CliError};
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{OutputFile, check_all, check_beside, check_directory};
use super::progress::Progress;
use super::report::{self, FileReport};
use super::run::command_line;
use super::study_args::CostArgs;
use crate::plot::Figure;
use crate::study::Watch;
use crate::study::cost::{Advice, CostPlan, CostSet, CostStudy, Knob, advice};

/// What the rest of the crate does for this command.
pub(super) struct Tools {
    /// Turns the knobs.
    pub cost: fn(&CostPlan, Watch<'_, (Knob, f64)>) -> Result<Option<CostStudy>, Cause>,
    /// The figures.
    pub draw: fn(&CostStudy) -> Vec<Figure>,
    /// Records the study of a plan, started by a command, into a file.
    pub record: fn(&CostPlan, &CostStudy, &str, &Path) -> Result<(), Cause>,
}

/// The table and the recording in the directory asked for.
const TABLE: &str = "cost.csv";
const RECORDING: &str = "cost.rrd";

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C.
pub(super) fn run(args: &CostArgs, tools: &Tools) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, tools)
}

fn execute(args: &CostArgs, stop: &AtomicBool, tools: &Tools) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    let mut plan = CostPlan::new(scene.clone());
    if !args.only.is_empty() {
        for knob in &args.only {
            if !plan.knobs.contains(knob) {
                // A scene without ball and beam has no such knob: the same words as everywhere.
                scene.ball_on_beam()?;
            }
        }
        plan.knobs.retain(|knob| args.only.contains(knob));
    }
    plan.repeats = args.repeats.into();
    if let Some(horizon) = args.horizon {
        plan.horizon = 1e-3 * horizon;
    }
    if args.write.is_some() && !plan.knobs.contains(&Knob::Integrator) {
        return Err(CliError::NoAdvice);
    }
    let own = args.scene.input();
    let [page, write, json] = check_all(
        own,
        [
            ("--page", args.page.as_deref()),
            ("--write", args.write.as_deref()),
            ("--json", args.json.as_deref()),
        ],
    )?;
    let figures = Knob::ALL.iter().map(|knob| format!("cost-{}", knob.name()));
    let mut names = args.drawn.names(figures, &STUDY);
    names.extend([TABLE, RECORDING].map(str::to_owned));
    check_directory(&args.out, "--out", &names)?;
    let others = [
        ("--page", page.as_ref()),
        ("--write", write.as_ref()),
        ("--json", json.as_ref()),
    ];
    check_beside(&args.out, "--out", &names, &others)?;
    engine::check_memory()?;
    engine::start_pool()?;
    let progress = Progress::of_estimate();
    let found = (tools.cost)(&plan, &mut |(knob, share)| {
        progress.tell(share, knob.name().to_owned());
        interrupt::goes_on(stop)
    });
    drop(progress);
    let failed = |doing| move |source| CliError::Run { doing, source };
    let Some(study) = found.map_err(failed("cost study"))? else {
        return Err(CliError::NothingYet);
    };
    let advised = advice(&study.sets);
    let mut report = CostReport::new(&study, &advised);
    // What is found is told even where a file cannot be written.
    let mut write_all = || -> Result<(), CliError> {
        let drawn = (&args.drawn, &STUDY[..]);
        report.files = write_figures(&args.out, "--out", &(tools.draw)(&study), drawn)?;
        let csv = inside(&args.out, TABLE)?;
        csv.write(|out| out.write_all(table(&study.sets).as_bytes()))?;
        report.files.push(FileReport::of(&csv)?);
        let recording = inside(&args.out, RECORDING)?;
        (tools.record)(&plan, &study, &command_line(), recording.path())
            .map_err(failed("recording"))?;
        report.files.push(FileReport::of(&recording)?);
        if let Some(file) = &write
            && !advised.is_empty()
        {
            let text = scene.with_advice(&settings(&advised))?.text;
            file.write(|out| out.write_all(text.as_bytes()))?;
            report.files.push(FileReport::of(file)?);
        }
        if let Some(file) = &page {
            let chapter = report.chapter();
            file.write(|out| out.write_all(chapter.as_bytes()))?;
            report.files.push(FileReport::of(file)?);
        }
        Ok(())
    };
    let written = write_all();
    report::deliver(&report, json.as_ref())?;
    written?;
    match study.stopped {
        true => Err(CliError::Interrupted),
        false if write.is_some() && advised.is_empty() => Err(CliError::NoAdvice),
        false => Ok(()),
    }
}

/// One of the files in the directory asked for.
fn inside(directory: &Path, name: &str) -> Result<OutputFile, CliError> {
    Ok(OutputFile::check(&directory.join(name), "--out")?)
}

/// Advice as a scene states it: the error, the method, its tolerance or step.
fn settings(advised: &[Advice]) -> Vec<(f64, &str, f64)> {
    let advised = advised.iter();
    advised
        .map(|advice| (advice.target, &*advice.method, advice.value))
        .collect()
}

/// All points, a line each (CSV).
fn table(sets: &[CostSet]) -> String {
    let mut text =
        "knob,family,turned,value,cpu_ms,calls,error,error_is,reference_error,detail,failed\n"
            .to_owned();
    for set in sets {
        for point in &set.points {
            let (error, failed) = match &point.error {
                Ok(error) => (format!("{error:e}"), String::new()),
                Err(why) => (String::new(), why.replace('"', "'")),
            };
            let floor = set
                .floor
                .map(|floor| format!("{floor:e}"))
                .unwrap_or_default();
            let _ = writeln!(
                text,
                "{},{},\"{}\",{:e},{:.6},{},{error},\"{}\",{floor},\"{}\",\"{failed}\"",
                set.knob.name(),
                set.family,
                set.turned,
                point.value,
                1e3 * point.seconds,
                point.calls,
                set.knob.error(),
                point.detail,
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::SceneArgs;
    use crate::scene::Scene;
    use crate::study::cost::CostPoint;

    fn point(seconds: f64, error: Result<f64, String>) -> CostPoint {
        CostPoint {
            value: 1e-4,
            seconds,
            calls: (1e6 * seconds).round() as u64,
            error,
            detail: String::new(),
        }
    }

    /// Two methods: one dear and exact, one cheap and coarse, and one that fails.
    fn turned(plan: &CostPlan, watch: Watch<'_, (Knob, f64)>) -> Result<Option<CostStudy>, Cause> {
        if !watch((Knob::Integrator, 0.5)) {
            return Ok(None);
        }
        let set = |family: &str, points| CostSet {
            knob: Knob::Integrator,
            family: family.to_owned(),
            turned: "tolerance",
            floor: Some(1e-10),
            points,
        };
        Ok(Some(CostStudy {
            scene: plan.scene.name.clone(),
            held: Default::default(),
            horizon: plan.horizon,
            exponent: None,
            stopped: false,
            sets: vec![
                set(
                    "lawson54",
                    vec![point(2e-3, Ok(1e-7)), point(1e-3, Ok(2e-3))],
                ),
                set(
                    "dop853",
                    vec![point(5e-4, Err("it \"blew\" up".to_owned()))],
                ),
            ],
        }))
    }

    const TOOLS: Tools = Tools {
        cost: turned,
        draw: |study| {
            vec![Figure::new(
                "cost-integrator",
                &study.scene,
                50.0,
                Vec::new(),
            )]
        },
        record: |plan, study, _, path| {
            let words = format!("{} {}", plan.scene.name, study.sets.len());
            Ok(std::fs::write(path, words)?)
        },
    };

    fn args(folder: &std::path::Path) -> CostArgs {
        CostArgs {
            scene: SceneArgs {
                scene: Some("torus-3deg".to_owned()),
            },
            only: Vec::new(),
            repeats: 1,
            horizon: Some(2.0),
            out: folder.join("cost"),
            drawn: Default::default(),
            page: Some(folder.join("page.md")),
            write: Some(folder.join("mine.toml")),
            json: Some(folder.join("cost.json")),
        }
    }

    #[test]
    fn the_cheapest_setting_is_advised_and_the_scene_takes_it() {
        let folder = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        execute(&args(folder.path()), &go, &TOOLS).unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        let json: serde_json::Value = serde_json::from_str(&read("cost.json")).unwrap();
        let advice = json["advice"].as_array().unwrap();
        let targets: Vec<f64> = advice
            .iter()
            .map(|a| a["target"].as_f64().unwrap())
            .collect();
        assert_eq!(targets, [1e-2, 1e-3, 1e-4, 1e-6]);
        assert_eq!(
            (&advice[0]["cpu_ms"], &advice[3]["cpu_ms"]),
            (&1.0.into(), &2.0.into())
        );
        assert_eq!(
            json["sets"][1]["points"][0]["error"],
            serde_json::Value::Null
        );
        let csv = read("cost/cost.csv");
        assert_eq!(csv.lines().count(), 4, "{csv}");
        assert!(csv.contains("\"it 'blew' up\""), "{csv}");
        assert_eq!(read("cost/cost.rrd"), "torus-3deg 2");
        let written = json["files"].as_array().unwrap();
        assert!(
            written
                .iter()
                .any(|file| file["path"].as_str().unwrap().ends_with("cost.rrd"))
        );
        let page = read("page.md");
        assert!(
            page.contains("| 1e-2 | `lawson54` at 1.0e-4 | 1.00 | 1000 | 2.0e-3 |"),
            "{page}"
        );
        assert!(
            page.contains("| 1.0e-4 | failed · 0.50 ms · 500 |"),
            "{page}"
        );
        let mine = folder.path().join("mine.toml");
        let scene = Scene::load(&mine.to_string_lossy()).unwrap();
        assert_eq!(scene.advice.len(), 4);
        assert_eq!(
            scene.with_accuracy(1e-5).unwrap().integrator.tolerance,
            1e-4
        );
    }

    #[test]
    fn what_a_scene_does_not_have_is_refused_and_a_stop_is_heeded() {
        let folder = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        let small = CostArgs {
            scene: SceneArgs {
                scene: Some("impact-oscillator".to_owned()),
            },
            only: vec![Knob::Nodes],
            ..args(folder.path())
        };
        assert_eq!(execute(&small, &go, &TOOLS).unwrap_err().exit_code(), 2);
        // A recording that cannot be written is known before any work.
        let taken = folder.path().join("taken");
        std::fs::create_dir_all(taken.join(RECORDING)).unwrap();
        let taken = CostArgs {
            out: taken,
            ..args(folder.path())
        };
        assert_eq!(execute(&taken, &go, &TOOLS).unwrap_err().exit_code(), 2);
        let stop = AtomicBool::new(true);
        let stopped = execute(&args(folder.path()), &stop, &TOOLS).unwrap_err();
        assert_eq!(stopped.exit_code(), 130);
        assert!(!folder.path().join("cost").exists());
    }
}
