//! `squeakscope paper`: every figure and every claim of the paper, beside what is found here.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{OutputFile, check_all, check_directory};
use super::paper_figures::{self, FIGURES};
use super::resources;
use super::study_args::{PaperArgs, SweepOutputs, WorkArgs};
use super::sweep::{Files, show, work_through, write_recording, write_tables};
use crate::escape;
use crate::joint::BallJoint;
use crate::plot::Format;
use crate::scene::{Parameter, Scene};
use crate::study::paper::{Finding, Holds, compare, paper_evidence, paper_plan, score};
use crate::study::sweep::{Start, SweepPlan};
use crate::text::paper as words;

/// The scene that meets most of the paper's claims.
const SCENE: &str = "paper";

/// The first figure that shows a motion; those before need no simulation.
const FIRST_OF_MOTION: u8 = 4;

/// The page, the table and the recording in the directory asked for.
const PAGE: &str = "README.md";
const TABLE: &str = "sweep.arrow";
const RECORDING: &str = "paper.rrd";

const MET: Style = AnsiColor::Green.on_default();
const NOT_MET: Style = AnsiColor::Red.on_default();
const NAME: Style = Style::new().bold();

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C, after what is known has been
/// written.
pub(super) fn run(args: &PaperArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, paper_plan)
}

fn execute(
    args: &PaperArgs,
    stop: &AtomicBool,
    plan: impl FnOnce(Scene, Start) -> SweepPlan,
) -> Result<(), CliError> {
    let mut scene = Scene::load(args.scene.as_deref().unwrap_or(SCENE))?;
    scene = args.accuracy.apply(scene)?;
    scene.ball_on_beam()?;
    if let Some(seed) = args.seed {
        scene = scene.with_values(&[(Parameter::named("start.seed")?, seed as f64)])?;
    }
    let plan = plan(scene, args.start);
    let (outputs, files) = prepare(args)?;
    // What a run before has found need not be found again.
    let work = WorkArgs {
        resume: true,
        shard: None,
        threads: args.threads,
    };
    let mut points = Vec::new();
    let mut written = Vec::new();
    if args.only.is_none_or(|only| only >= FIRST_OF_MOTION) {
        let done;
        (points, done) = work_through(&plan, &work, &files, stop)?;
        written = write_tables(&plan, &mut points, &files)?;
        if !done {
            return Err(CliError::Interrupted);
        }
    }
    let failed = |doing, source: Cause| CliError::Run { doing, source };
    let spec = &plan.scene.joint()?.spec;
    let evidence =
        paper_evidence(spec, &points).map_err(|fault| failed("comparison", fault.into()))?;
    // Without a motion nothing can be compared.
    let claims = match points.is_empty() {
        true => Vec::new(),
        false => compare(&evidence),
    };
    let figures = paper_figures::figures(&plan, &points, (&evidence, &claims), args.only)
        .map_err(|fault| failed("drawing", fault))?;
    let drawn = (&args.drawn, &STUDY[..]);
    written.extend(write_figures(&args.out, "--out", &figures, drawn)?);
    if args.only.is_none() {
        let ball = BallJoint::new(spec).map_err(|fault| failed("recording", fault.into()))?;
        written.extend(write_recording(&plan, &points, &files, Some(&ball))?);
    }
    let captions = figures.iter().filter(|_| args.only.is_some());
    let result = PaperResult {
        start: args.start,
        score: score(&claims),
        claims,
        captions: captions.map(|figure| figure.caption.clone()).collect(),
    };
    let scene = &plan.scene.name;
    if args.only.is_none() {
        let shown = args.drawn.formats(&STUDY).iter();
        // What a browser shows, if it was drawn; pixels first.
        let shown = shown.rev().find(|format| **format != Format::Pdf);
        let ending = shown.unwrap_or(&Format::Pdf).ending();
        let figures: Vec<_> = figures.iter().map(|f| (&*f.name, &*f.caption)).collect();
        let start = (&**scene, &*result.start.to_string());
        let page = words::page(start, &figures, ending, (result.score, &result.claims));
        written.push(write(&args.out.join(PAGE), &page)?);
    }
    let document = Document::new(&result, &written).of_scene(scene);
    show(&document, &text(scene, &result), &outputs, &files)
}

/// Checks all outputs before any work, and makes the directory.
fn prepare(args: &PaperArgs) -> Result<(SweepOutputs, Files), CliError> {
    let figures = (1..=FIGURES).map(|number| format!("figure-{number}"));
    let mut names = args.drawn.names(figures, &STUDY);
    names.extend([PAGE, TABLE, "sweep.csv", RECORDING].map(str::to_owned));
    check_directory(&args.out, "--out", &names)?;
    let scene_file = args.scene.as_deref().map(OsStr::new);
    // One in the directory that is still to be made is checked there.
    let json = args.json.as_deref();
    let json = json.filter(|path| *path != Path::new("-") && !path.starts_with(&args.out));
    check_all(scene_file, [("--json", json)])?;
    if args.only.is_none() {
        resources::check_memory()?;
    }
    interrupt::work_begins();
    std::fs::create_dir_all(&args.out).map_err(|source| CliError::Run {
        doing: "making of the directory",
        source: source.into(),
    })?;
    let outputs = SweepOutputs {
        out: args.out.join(TABLE),
        figures: None,
        drawn: args.drawn.clone(),
        save: args.only.is_none().then(|| args.out.join(RECORDING)),
        json: args.json.clone(),
    };
    let files = Files::check(scene_file, &outputs, &[])?;
    Ok((outputs, files))
}

/// Writes a text into the directory.
fn write(path: &Path, text: &str) -> Result<WrittenFile, CliError> {
    let file = OutputFile::check(path, "--out")?;
    file.write(|out| out.write_all(text.as_bytes()))?;
    Ok(WrittenFile::of(&file)?)
}

/// What is found of the paper.
#[derive(Debug, Serialize)]
struct PaperResult {
    /// How the tilts were started.
    start: Start,
    /// How well the claims hold, by their weights, 0 to 1.
    score: f64,
    /// The claims, in the order of the paper.
    claims: Vec<Finding>,
    /// The caption of the only figure asked for (Markdown).
    captions: Vec<String>,
}

/// The text for the terminal.
fn text(scene: &str, found: &PaperResult) -> String {
    let mut text = String::new();
    if !found.claims.is_empty() {
        let _ = writeln!(
            text,
            "{NAME}{}{NAME:#}, started {}: {:.0} % of the paper's claims hold, by their weights",
            escape::line(scene),
            found.start,
            100.0 * found.score
        );
    }
    for finding in &found.claims {
        let style = match finding.holds {
            Holds::Yes => MET,
            Holds::No => NOT_MET,
            _ => Style::new(),
        };
        let _ = writeln!(
            text,
            "  {:<13} {}\n  {:<13}   published {}, here {}: {style}{}{style:#}",
            finding.claim.place,
            finding.claim.says,
            "",
            finding.published,
            finding.ours,
            words::verdict(finding)
        );
    }
    text.extend(found.captions.iter().map(|caption| format!("{caption}\n")));
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::response::ResponsePlan;
    use crate::study::sweep::Axis;

    /// Two tilts, shortly.
    fn short(scene: Scene, start: Start) -> SweepPlan {
        SweepPlan {
            scene,
            axes: vec![Axis::new(Parameter::tilt(), [2.0, 5.0])],
            starts: vec![start],
            response: ResponsePlan {
                least: 0.02,
                most: 0.02,
                measure: 0.01,
                exponents: 1,
                portrait: false,
                most_calls: None,
            },
        }
    }

    #[test]
    fn the_figures_come_with_captions_and_the_table_of_claims() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("paper");
        let mut args = PaperArgs {
            scene: None,
            only: None,
            out: out.clone(),
            drawn: Default::default(),
            start: Start::Cold,
            seed: Some(4),
            accuracy: Default::default(),
            threads: None,
            json: Some(folder.path().join("paper.json")),
        };
        let stop = AtomicBool::new(false);
        execute(&args, &stop, short).unwrap();
        let page = std::fs::read_to_string(out.join("README.md")).unwrap();
        assert!(
            page.contains("![figure-4](figure-4.png)\n\n**Fig. 4**, 2°. (a) Growth"),
            "{page}"
        );
        assert!(
            page.contains("| Fig. 4a | four unstable modes at 2.0 deg | 4 | 4 | yes |"),
            "{page}"
        );
        assert!(
            page.contains("| Fig. 6a | five unstable modes at 3.5 deg | 5 | not found | unknown |")
        );
        let json = std::fs::read(folder.path().join("paper.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(report["claims"].as_array().unwrap().len(), 34);
        assert!(
            report["score"].as_f64().unwrap() < 0.6,
            "{}",
            report["score"]
        );
        let claim = &report["claims"][0];
        for field in ["id", "place", "says", "published", "ours", "holds"] {
            assert!(claim[field].is_string(), "{field} of {claim}");
        }
        assert!(claim["weight"].is_number() && claim["share"].is_number());
        // A second run finds the sweep done, and draws only what is asked for.
        args.only = Some(9);
        let before = std::fs::read(out.join("sweep.arrow")).unwrap();
        execute(&args, &stop, short).unwrap();
        assert_eq!(std::fs::read(out.join("sweep.arrow")).unwrap(), before);
        let drawn = std::fs::read_to_string(out.join("figure-9.svg")).unwrap();
        assert!(drawn.contains("</svg>"), "{drawn}");
        // Another question does not go over it.
        args.seed = Some(5);
        let refused = execute(&args, &stop, short).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
    }
}
