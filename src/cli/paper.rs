//! `squeakscope paper`: reproduce the paper's figures and check its claims.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use anstyle::{AnsiColor, Style};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::{Document, WrittenFile};
use super::error::CliError;
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{Kind, OutputFile, Overwrite, is_stdout};
use super::paper_figures::{self, FIGURES};
use super::report::{self, HEADING};
use super::resources;
use super::study_args::{PaperArgs, SweepOutputs, WorkArgs};
use super::sweep::{Files, compute_points, write_points, write_recording};
use crate::escape;
use crate::joint::BallJoint;
use crate::plot::Format;
use crate::scene::{Parameter, Scene};
use crate::study::paper::{
    Finding, Score, Verdict, add_short_averages, compare, paper_evidence, short_average_plan,
};
use crate::study::sweep::{Start, SweepPlan};
use crate::text::paper as words;

/// The calibrated scene, which meets most of the paper's claims.
const SCENE: &str = "paper";

/// The first figure that needs a simulation.
const FIRST_SIMULATED: u8 = 4;

/// Name of the page in the output directory.
const PAGE: &str = "README.md";
/// Name of the table in the output directory.
const TABLE: &str = "sweep.arrow";
/// Name of the table of short averages in the output directory.
const SHORT_TABLE: &str = "short.arrow";
/// Name of the recording in the output directory.
const RECORDING: &str = "paper.rrd";

const MET: Style = AnsiColor::Green.on_default();
const NOT_MET: Style = AnsiColor::Red.on_default();

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt, after the results so far are
/// written.
pub(super) fn execute(
    args: &PaperArgs,
    stop: &AtomicBool,
    plan: impl FnOnce(Scene, Start) -> SweepPlan,
) -> Result<(), CliError> {
    let mut scene = args.scene.load_or(SCENE)?;
    scene = args.accuracy.apply(scene)?;
    scene.ball_on_beam()?;
    report::print_study_warnings(&scene);
    if let Some(seed) = args.seed {
        scene = scene.with_values(&[(Parameter::named("start.seed")?, seed as f64)])?;
    }
    let plan = plan(scene, args.start);
    let (outputs, [files, short_files], described) = prepare(args)?;
    let short_plan = short_average_plan(&plan);
    // Reuse the points of an earlier or interrupted run.
    let work = WorkArgs {
        resume: true,
        shard: None,
        threads: args.threads,
    };
    let [mut points, mut short] = [Vec::new(), Vec::new()];
    let mut written = Vec::new();
    if args.figure.is_none_or(|figure| figure >= FIRST_SIMULATED) {
        let done;
        (points, done) = compute_points(&plan, &work, &files, stop)?;
        written = vec![write_points(&plan, &mut points, &files, done)?];
        if !done {
            return Err(CliError::Interrupted);
        }
        let done;
        (short, done) = compute_points(&short_plan, &work, &short_files, stop)?;
        written.push(write_points(&short_plan, &mut short, &short_files, done)?);
        if !done {
            return Err(CliError::Interrupted);
        }
    }
    let spec = &plan.scene.joint()?.spec;
    let evidence = |points| paper_evidence(spec, points).map_err(CliError::during("comparison"));
    let [evidence, short] = [evidence(&points)?, evidence(&short)?];
    // Without simulated points there is nothing to compare.
    let mut claims = match points.is_empty() {
        true => Vec::new(),
        false => compare(&evidence),
    };
    let short_average = add_short_averages(&mut claims, &short);
    let figures = paper_figures::figures(&plan, &points, (&evidence, &claims), args.figure)
        .map_err(CliError::during("drawing"))?;
    let drawn = (&args.drawn, &STUDY[..]);
    written.extend(write_figures(&args.out, "--out", &figures, drawn)?);
    if args.figure.is_none() {
        let ball = BallJoint::new(spec).map_err(CliError::during("recording"))?;
        written.extend(write_recording(&plan, &points, &files, Some(&ball))?);
    }
    let captions = figures.iter().filter(|_| args.figure.is_some());
    let result = PaperResult {
        start: args.start,
        score: Score::of(&claims),
        short_average,
        claims,
        captions: captions.map(|figure| figure.caption.clone()).collect(),
    };
    let scene = &plan.scene.name;
    if args.figure.is_none() {
        let shown = args.drawn.formats(&STUDY).iter();
        // Prefer a format that browsers show, and PNG to SVG.
        let shown = shown.rev().find(|format| **format != Format::Pdf);
        let ending = shown.unwrap_or(&Format::Pdf).ending();
        let figures = args.drawn.arrange(&figures);
        let figures: Vec<_> = figures.iter().map(|f| (&*f.name, &*f.caption)).collect();
        let start = (&**scene, &*result.start.to_string());
        let page = words::page(start, &figures, ending, (&result.score, &result.claims));
        written.push(write(&args.out.join(PAGE), &page)?);
    }
    if let Some(file) = described {
        let start = &*result.start.to_string();
        let about = words::description(start, (&result.score, &result.claims));
        let text = plan.scene.with_about(&about)?.text;
        file.write(|out| out.write_all(text.as_bytes()))?;
        written.push(WrittenFile::of(&file)?);
    }
    let document = Document::new(&result, &written).with_scene(scene);
    let text = text(scene, &result);
    document.deliver_or_print(&text, outputs.json.as_deref(), files.json.as_ref())?;
    Ok(())
}

/// Checks all outputs and creates the directory.
fn prepare(args: &PaperArgs) -> Result<(SweepOutputs, [Files; 2], Option<OutputFile>), CliError> {
    let numbers = match args.figure {
        Some(number) => number..=number,
        None => 1..=FIGURES,
    };
    let figures = numbers.map(|number| format!("figure-{number}"));
    let mut names = args.drawn.names(figures, &STUDY);
    if args.figure.is_none() {
        names.extend([PAGE, RECORDING].map(str::to_owned));
    }
    args.overwrite.check_directory(&args.out, "--out", &names)?;
    // The tables of an earlier or interrupted run are continued.
    let tables = [TABLE, "sweep.arrows", SHORT_TABLE, "short.arrows"];
    Overwrite::ALLOWED.check_directory(&args.out, "--out", &tables)?;
    let scene_file = args.scene.input();
    // A path inside the new directory is checked after the directory exists.
    let json = args.json.as_deref();
    let json = json.filter(|path| !is_stdout(path) && !path.starts_with(&args.out));
    let overwrite = args.overwrite;
    overwrite.check_all(scene_file, [("--json", Kind::JSON, json)])?;
    // A scene file may be described itself.
    let write = args.write.as_deref();
    let [described] = overwrite.check_all(None, [("--write", Kind::SCENE, write)])?;
    if args.figure.is_none() {
        resources::check_memory()?;
    }
    interrupt::start_work();
    std::fs::create_dir_all(&args.out).map_err(CliError::during("creation of the directory"))?;
    let table = |name| SweepOutputs {
        out: args.out.join(name),
        figures: None,
        drawn: args.drawn.clone(),
        save: None,
        json: None,
        overwrite: Overwrite::ALLOWED,
    };
    let outputs = SweepOutputs {
        save: args.figure.is_none().then(|| args.out.join(RECORDING)),
        json: args.json.clone(),
        ..table(TABLE)
    };
    let short = table(SHORT_TABLE);
    let kind = (Kind::STUDY_TABLE, Overwrite::ALLOWED);
    let check = |outputs| Files::check((scene_file, outputs), &[], kind);
    let files = [check(&outputs)?, check(&short)?];
    Ok((outputs, files, described))
}

/// Writes a text file.
fn write(path: &Path, text: &str) -> Result<WrittenFile, CliError> {
    let file = OutputFile::check(path, "--out")?;
    file.write(|out| out.write_all(text.as_bytes()))?;
    Ok(WrittenFile::of(&file)?)
}

/// The comparison with the paper.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
pub(super) struct PaperResult {
    /// Initial states of the sweep over the tilt.
    start: Start,
    /// Agreement with the paper.
    #[serde(flatten)]
    score: Score,
    /// Agreement with the paper of short averages: over 0.1 s that begin 0.05 s after the start, settled or not.
    short_average: Score,
    /// Claims in the order of the paper.
    claims: Vec<Finding>,
    /// Caption (Markdown) of the figure selected with `--figure`.
    captions: Vec<String>,
}

/// The report for the terminal.
fn text(scene: &str, result: &PaperResult) -> String {
    let mut text = String::new();
    if !result.claims.is_empty() {
        let _ = writeln!(
            text,
            "{HEADING}{}{HEADING:#} (start: {}): {}",
            escape::line(scene),
            result.start,
            words::score_text(&result.score)
        );
        let _ = writeln!(
            text,
            "  averages over 0.1 s, 0.05 s after the start: {}",
            words::score_text(&result.short_average)
        );
    }
    for finding in &result.claims {
        let style = match finding.verdict {
            Verdict::Met => MET,
            Verdict::NotMet => NOT_MET,
            _ => Style::new(),
        };
        let _ = writeln!(
            text,
            "  {:<13} {}\n  {:<13}   paper {}, simulation {}: {style}{}{style:#}",
            finding.place,
            finding.statement,
            "",
            finding.expected,
            finding.measured,
            words::verdict(finding)
        );
        if finding
            .short_average
            .as_ref()
            .is_some_and(|short| short.verdict != finding.verdict)
        {
            let _ = writeln!(
                text,
                "  {:<13}   short average {}",
                "",
                words::short_average(finding)
            );
        }
    }
    text.extend(result.captions.iter().map(|caption| format!("{caption}\n")));
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::SceneArgs;
    use crate::study::paper::claims;
    use crate::study::response::ResponsePlan;
    use crate::study::sweep::Axis;

    /// A short sweep over two tilts.
    fn short_plan(scene: Scene, start: Start) -> SweepPlan {
        SweepPlan {
            scene,
            axes: vec![Axis::new(Parameter::tilt(), [2.0, 5.0])],
            starts: vec![start],
            response: ResponsePlan {
                min_transient: 0.02,
                max_transient: 0.02,
                measurement_time: 0.01,
                exponents: 1,
                orbits: false,
                portrait: false,
                max_rhs_evals: None,
            },
        }
    }

    #[test]
    fn figures_captions_and_claims_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("paper");
        let mut args = PaperArgs {
            scene: SceneArgs::default(),
            figure: None,
            out: out.clone(),
            overwrite: Default::default(),
            drawn: Default::default(),
            start: Start::Fresh,
            seed: Some(4),
            accuracy: Default::default(),
            threads: None,
            write: Some(folder.path().join("described.toml")),
            json: Some(folder.path().join("paper.json")),
        };
        let stop = AtomicBool::new(false);
        execute(&args, &stop, short_plan).unwrap();
        let page = std::fs::read_to_string(out.join("README.md")).unwrap();
        assert!(
            page.contains("![figure-4](figure-4.png)\n\n**Fig. 4**, 2°. (a) Growth"),
            "{page}"
        );
        assert!(
            page.contains(
                "| Fig. 4a | Four unstable modes at a tilt of 2.0 deg | 4 | 4 | met | same | 1 |"
            ),
            "{page}"
        );
        assert!(page.contains(
            "| Fig. 6a | Five unstable modes at a tilt of 3.5 deg | 5 | not found | not comparable | same | 1 |"
        ));
        let json = std::fs::read(folder.path().join("paper.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(report["claims"].as_array().unwrap().len(), claims().len());
        let [strict, partial] = ["strict_score", "partial_score"].map(|name| report[name].as_f64());
        assert!(strict <= partial && strict < Some(0.6), "{report}");
        let claim = &report["claims"][0];
        for field in [
            "id",
            "place",
            "statement",
            "quote",
            "expected",
            "measured",
            "verdict",
        ] {
            assert!(claim[field].is_string(), "{field} of {claim}");
        }
        assert!(claim["weight"].is_number());
        let described = std::fs::read_to_string(folder.path().join("described.toml")).unwrap();
        let about = Scene::parse("described.toml", described).unwrap().about;
        let counts = "Unstable modes at 2.0, 3.0, 3.5 and 5.0 deg: 4, not found (paper: 4), ";
        assert!(about.replace('\n', " ").contains(counts), "{about}");
        args.write = None;
        // A second run reuses the sweep and draws only the selected figure.
        args.figure = Some(9);
        let refused = execute(&args, &stop, short_plan).unwrap_err();
        assert!(refused.to_string().contains("--force"), "{refused}");
        args.overwrite = Overwrite::ALLOWED;
        let before = std::fs::read(out.join("sweep.arrow")).unwrap();
        execute(&args, &stop, short_plan).unwrap();
        assert_eq!(std::fs::read(out.join("sweep.arrow")).unwrap(), before);
        let drawn = std::fs::read_to_string(out.join("figure-9.svg")).unwrap();
        assert!(drawn.contains("</svg>"), "{drawn}");
        // A different sweep does not replace the table.
        args.seed = Some(5);
        let refused = execute(&args, &stop, short_plan).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
    }

    /// The table of claims of the scene `paper`; the guide (`reproduce_paper`) has the command that writes it and the
    /// text of the scene.
    fn table() -> PaperResult {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/paper/table.json");
        serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
    }

    /// The text of the scene is that of its table, and the table has the present claims.
    #[test]
    fn the_text_of_the_scene_is_generated_from_its_table() {
        let table = table();
        let start = table.start.to_string();
        let text = words::description(&start, (&table.score, &table.claims));
        assert_eq!(Scene::load(SCENE).unwrap().about, text.trim_end());
        assert_eq!(Score::of(&table.claims), table.score);
        assert_eq!(table.claims.len(), claims().len());
        for (found, claim) in table.claims.iter().zip(claims()) {
            assert_eq!(
                (&found.id, &found.statement, &found.quote),
                (&claim.id, &claim.statement, &claim.quote)
            );
            assert_eq!(
                (found.weight, found.tolerance),
                (claim.weight, claim.tolerance)
            );
        }
    }

    /// The whole sweep again: verdicts and values of the table.
    #[test]
    #[ignore = "takes minutes; cargo test --release --lib the_table_of_the_scene -- --ignored"]
    fn the_table_of_the_scene_is_reproduced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let args = PaperArgs {
            scene: SceneArgs::default(),
            figure: None,
            out: path("paper"),
            overwrite: Default::default(),
            drawn: Default::default(),
            start: table().start,
            seed: None,
            accuracy: Default::default(),
            threads: None,
            write: None,
            json: Some(path("paper.json")),
        };
        execute(
            &args,
            &AtomicBool::new(false),
            crate::study::paper::paper_plan,
        )
        .unwrap();
        let again: PaperResult =
            serde_json::from_slice(&std::fs::read(path("paper.json")).unwrap()).unwrap();
        for (again, stored) in again.claims.iter().zip(table().claims) {
            assert_eq!(*again, stored);
        }
    }
}
