//! `squeakscope cost`: accuracy against CPU time in a scene, and the cheapest integrator.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::document::{Document, WrittenFile};
use super::error::CliError;
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{Kind, OutputFile};
use super::progress::Progress;
use super::report::{self, HEADING};
use super::resources;
use super::run::command_line;
use super::study_args::CostArgs;
use crate::escape;
use crate::number::short;
use crate::plot::cost_figures;
use crate::record::cost::save_cost;
use crate::scene::{Scene, SceneError};
use crate::study::cost::{CostPlan, CostSetting, CostStudy, ErrorBudget, WorkPrecisionSet, cost};
use crate::text::cost as words;

/// Name of the table in the output directory.
const TABLE: &str = "cost.csv";
/// Name of the recording in the output directory.
const RECORDING: &str = "cost.rrd";

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt.
pub(super) fn execute(args: &CostArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let plan = plan(args)?;
    let files = Files::check(args)?;
    resources::check_memory()?;
    resources::start_thread_pool()?;
    let progress = Progress::with_estimate();
    let study = cost(&plan, &mut |(setting, share)| {
        progress.update(share, setting.name().to_owned());
        interrupt::should_continue(stop)
    });
    drop(progress);
    match study.map_err(|source| failed("cost study", source))? {
        None => Err(CliError::NoResult),
        Some(study) => deliver(args, &plan, &study, &files),
    }
}

fn failed(task: &'static str, source: impl Into<super::error::Cause>) -> CliError {
    let source = source.into();
    CliError::Run { task, source }
}

/// The study that the arguments request.
fn plan(args: &CostArgs) -> Result<CostPlan, CliError> {
    let scene = args.scene.load()?;
    report::print_study_warnings(&scene);
    let mut plan = CostPlan::new(scene.clone());
    if !args.setting.is_empty() {
        if args
            .setting
            .iter()
            .any(|setting| !plan.settings.contains(setting))
        {
            // A scene without ball and beam lacks the setting; this call returns the usual error.
            scene.ball_on_beam()?;
        }
        plan.settings
            .retain(|setting| args.setting.contains(setting));
    }
    plan.repeats = args.repeats.into();
    if !args.target.is_empty() {
        plan.targets.clone_from(&args.target);
        plan.targets.sort_by(|a, b| b.total_cmp(a));
        plan.targets.dedup();
    }
    if !args.quantity.is_empty() {
        plan.quantities.clear();
        for quantity in &args.quantity {
            if !plan.quantities.contains(quantity) {
                plan.quantities.push(*quantity);
            }
        }
    }
    if let Some(horizon) = args.horizon {
        plan.horizon = 1e-3 * horizon;
    }
    let advising = [CostSetting::Integrator, CostSetting::Budget];
    let advises = plan
        .settings
        .iter()
        .any(|setting| advising.contains(setting));
    match args.write.is_some() && !advises {
        true => Err(CliError::NoAdvice),
        false => Ok(plan),
    }
}

/// The output files.
struct Files {
    markdown: Option<OutputFile>,
    write: Option<OutputFile>,
    json: Option<OutputFile>,
}

impl Files {
    fn check(args: &CostArgs) -> Result<Self, CliError> {
        let input = args.scene.input();
        let [markdown, write, json] = args.overwrite.check_all(
            input,
            [
                ("--markdown", Kind::MARKDOWN, args.markdown.as_deref()),
                ("--write", Kind::SCENE, args.write.as_deref()),
                ("--json", Kind::JSON, args.json.as_deref()),
            ],
        )?;
        let figures = CostSetting::ALL
            .iter()
            .map(|setting| format!("cost-{}", setting.name()));
        let mut names = args.drawn.names(figures, &STUDY);
        names.extend([TABLE, RECORDING].map(str::to_owned));
        args.overwrite.check_directory(&args.out, "--out", &names)?;
        Ok(Self {
            markdown,
            write,
            json,
        })
    }
}

/// Writes all files and prints the report.
fn deliver(
    args: &CostArgs,
    plan: &CostPlan,
    study: &CostStudy,
    files: &Files,
) -> Result<(), CliError> {
    let mut written = Vec::new();
    // The report is printed even if a file cannot be written.
    let all = write_all(args, plan, study, files, &mut written);
    Document::new(study, &written).deliver(&text(study), files.json.as_ref())?;
    all?;
    match study.stopped {
        true => Err(CliError::Interrupted),
        false if args.write.is_some() && !recommends(study) => Err(CliError::NoAdvice),
        false => Ok(()),
    }
}

/// Whether the study found settings that `--accuracy` can use.
fn recommends(study: &CostStudy) -> bool {
    let budgets = study.budget.as_ref().map(ErrorBudget::verified);
    !study.advice.is_empty() || budgets.is_some_and(|budgets| !budgets.is_empty())
}

/// The scene with the recommendations of the study.
fn recommended(scene: &Scene, study: &CostStudy) -> Result<Scene, SceneError> {
    let advice = study.advice.iter();
    let advice: Vec<_> = advice.map(|a| (a.target, &*a.method, a.value)).collect();
    let scene = scene.with_advice(&advice)?;
    match &study.budget {
        Some(budget) => scene.with_budgets(&budget.verified()),
        None => Ok(scene),
    }
}

fn write_all(
    args: &CostArgs,
    plan: &CostPlan,
    study: &CostStudy,
    files: &Files,
    written: &mut Vec<WrittenFile>,
) -> Result<(), CliError> {
    let drawn = (&args.drawn, &STUDY[..]);
    written.extend(write_figures(
        &args.out,
        "--out",
        &cost_figures(study),
        drawn,
    )?);
    let write = |file: &OutputFile, text: &str| {
        file.write(|out| out.write_all(text.as_bytes()))?;
        WrittenFile::of(file)
    };
    written.push(write(&inside(&args.out, TABLE)?, &table(&study.sets))?);
    let recording = inside(&args.out, RECORDING)?;
    save_cost(recording.path(), plan, study, &command_line())
        .map_err(|source| failed("recording", source))?;
    written.push(WrittenFile::of(&recording)?);
    if let Some(file) = files.write.as_ref().filter(|_| recommends(study)) {
        written.push(write(file, &recommended(&plan.scene, study)?.text)?);
    }
    if let Some(file) = &files.markdown {
        written.push(write(file, &words::chapter(study))?);
    }
    Ok(())
}

/// The report for the terminal.
fn text(study: &CostStudy) -> String {
    let mut text = format!(
        "{HEADING}{}{HEADING:#}: trajectories compared over {} ms",
        escape::line(&study.scene),
        short(1e3 * study.horizon)
    );
    if let Some(exponent) = study.exponent {
        let _ = write!(
            text,
            ", largest Lyapunov exponent {:.1} 1/s",
            exponent.value
        );
    }
    if let Some(held) = study.fixed_at.description() {
        let _ = write!(text, "\nthe scene is held at its initial values: {held}");
    }
    text.push('\n');
    for set in &study.sets {
        let _ = write!(
            text,
            "{HEADING}{}{HEADING:#}: {}",
            set.setting.name(),
            set.family
        );
        if let Some(floor) = set.floor {
            let _ = write!(text, " (error of the reference {floor:.1e})");
        }
        let settings = words::settings(set, |reason| escape::line(reason).into_owned());
        let _ = write!(text, "\n{}", settings.text());
    }
    if !study.advice.is_empty() {
        let _ = write!(
            text,
            "{HEADING}cheapest integrators{HEADING:#} by time-integration error; the errors of nodes, \
             modes and elements add to it\n{}",
            words::advice(study).text()
        );
    }
    if let Some(budget) = &study.budget {
        let _ = write!(
            text,
            "{HEADING}error budget{HEADING:#} of all settings together\n{}",
            words::budget(budget)
        );
    }
    text
}

/// A file in the output directory.
fn inside(directory: &Path, name: &str) -> Result<OutputFile, CliError> {
    Ok(OutputFile::check(&directory.join(name), "--out")?)
}

/// All points as CSV.
fn table(sets: &[WorkPrecisionSet]) -> String {
    let mut text =
        "setting,family,varied,value,cpu_ms,rhs_evals,error,error_meaning,reference_error,detail,failure\n"
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
                set.setting.name(),
                set.family,
                set.parameter,
                point.value,
                1e3 * point.seconds,
                point.rhs_evals,
                set.setting.error(),
                point.detail,
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::SceneArgs;
    use crate::scene::{AccuracyBudget, SceneSetting};
    use crate::study::cost::{
        BudgetChoice, Quantity, QuantityValue, Source, SourceShare, WorkPrecisionPoint, advice,
    };

    fn point(seconds: f64, error: Result<f64, String>) -> WorkPrecisionPoint {
        WorkPrecisionPoint {
            value: 1e-4,
            seconds,
            rhs_evals: (1e6 * seconds).round() as u64,
            error,
            detail: String::new(),
        }
    }

    /// A budget with a verified choice of 201 nodes for an error of 1e-3.
    fn example_budget() -> ErrorBudget {
        let share = SourceShare {
            source: Source::Nodes,
            setting: "201 nodes in rings".to_owned(),
            errors: vec![2e-4],
            seconds: 1e-2,
        };
        let choice = BudgetChoice {
            budget: AccuracyBudget {
                target: 1e-3,
                settings: vec![SceneSetting::number("contact.nodes", 201.0)],
                averaging_time: 0.08,
                errors: [("frequency".to_owned(), 2.5e-4)].into(),
                fingerprint: "0".to_owned(),
            },
            verified: true,
            tries: 1,
            predicted: vec![2e-4],
            shares: vec![share],
            next: Some(Source::Nodes),
            seconds: 0.1,
            rhs_evals: 100_000,
        };
        let frequency = QuantityValue {
            quantity: Quantity::Frequency,
            value: Some(4110.8),
            undefined: None,
        };
        ErrorBudget {
            quantities: vec![frequency],
            choices: vec![choice],
            ..ErrorBudget::default()
        }
    }

    /// A method with an accurate and a cheap point, and a method that fails.
    fn example_study(plan: &CostPlan) -> CostStudy {
        let set = |family: &str, points| WorkPrecisionSet {
            setting: CostSetting::Integrator,
            family: family.to_owned(),
            parameter: "tolerance".into(),
            floor: Some(1e-10),
            points,
        };
        let sets = vec![
            set(
                "lawson54",
                vec![point(2e-3, Ok(1e-7)), point(1e-3, Ok(2e-3))],
            ),
            set(
                "dop853",
                vec![point(5e-4, Err("it \"blew\" up".to_owned()))],
            ),
        ];
        CostStudy {
            scene: plan.scene.name.clone(),
            fixed_at: Default::default(),
            horizon: plan.horizon,
            exponent: None,
            stopped: false,
            budget: Some(example_budget()),
            advice: advice(&sets),
            sets,
        }
    }

    fn args(folder: &std::path::Path) -> CostArgs {
        CostArgs {
            scene: SceneArgs {
                scene: Some("torus-3deg".to_owned()),
                ..SceneArgs::default()
            },
            setting: Vec::new(),
            repeats: 1,
            horizon: Some(2.0),
            target: Vec::new(),
            quantity: Vec::new(),
            out: folder.join("cost"),
            overwrite: Default::default(),
            drawn: Default::default(),
            markdown: Some(folder.join("page.md")),
            write: Some(folder.join("mine.toml")),
            json: Some(folder.join("cost.json")),
        }
    }

    #[test]
    fn the_cheapest_integrator_is_recommended_and_the_scene_takes_it() {
        let folder = tempfile::tempdir().unwrap();
        let args = args(folder.path());
        let (plan, files) = (plan(&args).unwrap(), Files::check(&args).unwrap());
        deliver(&args, &plan, &example_study(&plan), &files).unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        let json: serde_json::Value = serde_json::from_str(&read("cost.json")).unwrap();
        let advice = json["advice"].as_array().unwrap();
        let targets: Vec<f64> = advice
            .iter()
            .map(|a| a["target"].as_f64().unwrap())
            .collect();
        assert_eq!(targets, [1e-2, 1e-3, 1e-4, 1e-6]);
        assert_eq!(
            (&advice[0]["cpu_s"], &advice[3]["cpu_s"]),
            (&1e-3.into(), &2e-3.into())
        );
        assert_eq!(json["horizon_s"], 2e-3);
        assert_eq!(json["sets"][0]["setting"], "integrator");
        assert_eq!(
            json["sets"][0]["error_measure"],
            "largest error of the state"
        );
        let failed = &json["sets"][1]["points"][0];
        assert_eq!(failed["error"], serde_json::Value::Null);
        assert_eq!(failed["failed"], "it \"blew\" up");
        let csv = read("cost/cost.csv");
        assert_eq!(csv.lines().count(), 4, "{csv}");
        assert!(csv.contains("\"it 'blew' up\""), "{csv}");
        assert!(
            folder
                .path()
                .join("cost/cost.rrd")
                .metadata()
                .unwrap()
                .len()
                > 0
        );
        let written = json["files"].as_array().unwrap();
        assert!(
            written
                .iter()
                .any(|file| file["path"].as_str().unwrap().ends_with("cost.rrd"))
        );
        let page = read("page.md");
        assert!(
            page.contains("| 1e-2 | lawson54, tolerance 1e-4 | 1 | 1000 | 2.0e-3 |"),
            "{page}"
        );
        assert!(page.contains("| 1e-4 | failed · 0.5 ms · 500 |"), "{page}");
        let mine = folder.path().join("mine.toml");
        let scene = Scene::load(&mine.to_string_lossy()).unwrap();
        assert_eq!(scene.advice.len(), 4);
        assert_eq!(json["budget"]["choices"][0]["verified"], true);
        assert_eq!(scene.budgets[0].errors["frequency"], 2.5e-4);
        let accurate = scene.with_accuracy(1e-3).unwrap();
        assert_eq!(accurate.joint().unwrap().spec.contact.nodes, 201);
        let report = text(&example_study(&plan));
        assert!(report.contains("201 nodes in rings"), "{report}");
        assert!(report.contains("to improve next: nodes"), "{report}");
        assert_eq!(
            scene.with_accuracy(1e-5).unwrap().integrator.tolerance,
            1e-4
        );
    }

    #[test]
    fn missing_settings_are_refused_and_interrupts_stop_the_study() {
        let folder = tempfile::tempdir().unwrap();
        let run = AtomicBool::new(false);
        let small = CostArgs {
            scene: SceneArgs {
                scene: Some("impact-oscillator".to_owned()),
                ..SceneArgs::default()
            },
            setting: vec![CostSetting::Nodes],
            ..args(folder.path())
        };
        assert_eq!(execute(&small, &run).unwrap_err().exit_code(), 2);
        // A recording that cannot be written is refused before any work.
        let taken = folder.path().join("taken");
        std::fs::create_dir_all(taken.join(RECORDING)).unwrap();
        let taken = CostArgs {
            out: taken,
            ..args(folder.path())
        };
        assert_eq!(execute(&taken, &run).unwrap_err().exit_code(), 2);
        let stop = AtomicBool::new(true);
        let stopped = execute(&args(folder.path()), &stop).unwrap_err();
        assert_eq!(stopped.exit_code(), 130);
        assert!(!folder.path().join("cost").exists());
    }
}
