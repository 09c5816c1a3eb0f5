//! `squeakscope paper`: every figure and every claim of the paper, beside what is found here.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use super::engine;
use super::error::{Cause, CliError};
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{OutputFile, check_all, check_directory};
use super::report::{FileReport, Report, list_files};
use super::study_args::{PaperArgs, SweepOutputs, WorkArgs};
use super::sweep::{Files, Record, tell, work_through, write_recording, write_tables};
use crate::VERSION;
use crate::escape;
use crate::plot::{Figure, Format};
use crate::scene::{Parameter, Scene};
use crate::study::paper::{Evidence, Finding, Holds, compare, paper_plan, score};
use crate::study::sweep::{Start, SweepPlan, SweepPoint};

/// The scene that meets most of the paper's claims.
const SCENE: &str = "paper";

/// The first figure that shows a motion; those before need no simulation.
const FIRST_OF_MOTION: u8 = 4;

/// How many figures there are.
const FIGURES: u8 = 11;

/// The page, the table and the recording in the directory asked for.
const PAGE: &str = "README.md";
const TABLE: &str = "sweep.arrow";
const RECORDING: &str = "paper.rrd";

const MET: Style = AnsiColor::Green.on_default();
const NOT_MET: Style = AnsiColor::Red.on_default();
const NAME: Style = Style::new().bold();

/// What the rest of the crate does for this command.
pub(super) struct Tools {
    /// The evidence in the points of a sweep over the tilt.
    pub evidence: fn(&Scene, &[SweepPoint]) -> Result<Evidence, Cause>,
    /// The figures, all or only one, each with its caption.
    pub draw: DrawPaper,
    /// Records the sweep behind them, with the mode shapes.
    pub record: Record,
}

/// The figures of the paper: all, or only the one with a number.
pub(super) type DrawPaper =
    fn(&SweepPlan, &[SweepPoint], &Evidence, Option<u8>) -> Result<Vec<Figure>, Cause>;

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C, after what is known has been
/// written.
pub(super) fn run(args: &PaperArgs, tools: &Tools) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, tools, paper_plan)
}

fn execute(
    args: &PaperArgs,
    stop: &AtomicBool,
    tools: &Tools,
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
        written = write_tables(&plan, &plan.identity(), &mut points, &files)?;
        if !done {
            return Err(CliError::Interrupted);
        }
    }
    let failed = |doing| move |source| CliError::Run { doing, source };
    let evidence = (tools.evidence)(&plan.scene, &points).map_err(failed("comparison"))?;
    let figures = (tools.draw)(&plan, &points, &evidence, args.only).map_err(failed("drawing"))?;
    let drawn = (&args.drawn, &STUDY[..]);
    written.extend(write_figures(&args.out, "--out", &figures, drawn)?);
    written.extend(write_recording(&plan, &points, &files, tools.record)?);
    // Without a motion nothing can be compared.
    let findings = match points.is_empty() {
        true => Vec::new(),
        false => compare(&evidence),
    };
    let mut report = PaperReport::new(&plan, &findings, written);
    if args.only.is_some() {
        report.captions = figures
            .iter()
            .map(|figure| figure.caption.clone())
            .collect();
    }
    if args.only.is_none() {
        let shown = args.drawn.formats(&STUDY).iter();
        // What a browser shows, if it was drawn; pixels first.
        let shown = shown.rev().find(|format| **format != Format::Pdf);
        let page = page(&report, &figures, shown.copied().unwrap_or(Format::Pdf));
        report.files.push(write(&args.out.join(PAGE), &page)?);
    }
    tell(&report, &outputs, &files)
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
        engine::check_memory()?;
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
fn write(path: &Path, text: &str) -> Result<FileReport, CliError> {
    let file = OutputFile::check(path, "--out")?;
    file.write(|out| out.write_all(text.as_bytes()))?;
    Ok(FileReport::of(&file)?)
}

/// Result of `squeakscope paper`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PaperReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// How the tilts were started.
    pub start: String,
    /// How well the claims hold, by their weights, 0 to 1.
    pub score: f64,
    /// The claims, in the order of the paper.
    pub claims: Vec<ClaimReport>,
    /// The caption of the only figure asked for (Markdown).
    pub captions: Vec<String>,
    /// Files written.
    pub files: Vec<FileReport>,
}

/// One claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClaimReport {
    /// A short name.
    pub id: String,
    /// Where it stands in the paper.
    pub place: String,
    /// What it says.
    pub says: String,
    /// What is published.
    pub published: String,
    /// What was found.
    pub ours: String,
    /// Relative deviation of a number.
    pub deviation: Option<f64>,
    /// `yes`, `partly`, `no` or `unknown`.
    pub holds: &'static str,
    /// How far it holds, 0 to 1.
    pub share: f64,
    /// How much it counts.
    pub weight: f64,
}

impl PaperReport {
    fn new(plan: &SweepPlan, findings: &[Finding], files: Vec<FileReport>) -> Self {
        let claims = findings.iter().map(|finding| ClaimReport {
            id: finding.claim.id.clone(),
            place: finding.claim.place.clone(),
            says: finding.claim.says.clone(),
            published: finding.published.clone(),
            ours: finding.ours.clone(),
            deviation: finding.deviation,
            holds: match finding.holds {
                Holds::Yes => "yes",
                Holds::Partly(_) => "partly",
                Holds::No => "no",
                Holds::Unknown => "unknown",
            },
            share: finding.holds.share(),
            weight: finding.claim.weight,
        });
        let starts: Vec<String> = plan.starts.iter().map(Start::to_string).collect();
        Self {
            version: VERSION,
            scene: plan.scene.name.clone(),
            start: starts.join(", "),
            score: score(findings),
            claims: claims.collect(),
            captions: Vec::new(),
            files,
        }
    }
}

impl ClaimReport {
    /// The deviation of a number, or how far the claim holds.
    fn verdict(&self) -> String {
        let deviation = self
            .deviation
            .map(|off| format!(" ({:+.1} %)", 100.0 * off));
        match self.holds {
            "partly" => format!("partly, {:.0} %", 100.0 * self.share),
            holds => format!("{holds}{}", deviation.unwrap_or_default()),
        }
    }
}

impl Report for PaperReport {
    fn text(&self) -> String {
        let mut text = String::new();
        if !self.claims.is_empty() {
            let _ = writeln!(
                text,
                "{NAME}{}{NAME:#}, started {}: {:.0} % of the paper's claims hold, by their weights",
                escape::line(&self.scene),
                self.start,
                100.0 * self.score
            );
        }
        for claim in &self.claims {
            let style = match claim.holds {
                "yes" => MET,
                "no" => NOT_MET,
                _ => Style::new(),
            };
            let _ = writeln!(text, "  {:<13} {}", claim.place, claim.says);
            let _ = writeln!(
                text,
                "  {:<13}   published {}, here {}: {style}{}{style:#}",
                "",
                claim.published,
                claim.ours,
                claim.verdict()
            );
        }
        for caption in &self.captions {
            let _ = writeln!(text, "{caption}");
        }
        list_files(&mut text, &self.files);
        text
    }
}

/// The page of figures with their captions and the table of claims, Markdown.
fn page(report: &PaperReport, figures: &[Figure], format: Format) -> String {
    let mut page = format!(
        "# The paper's figures, as found here\n\n\
         J. Kang, *Nonlinear Vibration Induced by Friction in a Ball Joint System*, Lubricants 2022, 10, \
         201 (CC BY), <https://doi.org/10.3390/lubricants10090201>; scene {}, started {}, squeakscope \
         {}.\n\n",
        escape::code(&report.scene),
        report.start,
        report.version
    );
    let ending = format.ending();
    for Figure { name, caption, .. } in figures {
        let _ = writeln!(page, "![{name}]({name}.{ending})\n\n{caption}\n");
    }
    let _ = write!(
        page,
        "## Claims\n\n{:.0} % hold, by their weights.\n\n\
         | where | claim | published | here | holds |\n|---|---|---|---|---|\n",
        100.0 * report.score
    );
    for claim in &report.claims {
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {} |",
            claim.place,
            claim.says,
            claim.published,
            claim.ours,
            claim.verdict()
        );
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::response::ResponsePlan;
    use crate::study::sweep::Axis;

    fn evidence(_: &Scene, points: &[SweepPoint]) -> Result<Evidence, Cause> {
        let responses = points.iter().filter_map(|point| {
            let response = point.outcome.as_ref().ok()?;
            Some((point.place.values[0], response.clone()))
        });
        Ok(Evidence::new(responses))
    }

    fn draw(
        _: &SweepPlan,
        points: &[SweepPoint],
        _: &Evidence,
        only: Option<u8>,
    ) -> Result<Vec<Figure>, Cause> {
        let name = format!("figure-{}", only.unwrap_or(4));
        let mut figure = Figure::new(name, points.len().to_string(), 50.0, Vec::new());
        figure.caption = "What is seen.".to_owned();
        Ok(vec![figure])
    }

    fn record(_: &SweepPlan, points: &[SweepPoint], _: &str, path: &Path) -> Result<(), Cause> {
        Ok(std::fs::write(path, points.len().to_string())?)
    }

    const TOOLS: Tools = Tools {
        evidence,
        draw,
        record,
    };

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
        execute(&args, &stop, &TOOLS, short).unwrap();
        let page = std::fs::read_to_string(out.join("README.md")).unwrap();
        assert!(
            page.contains("![figure-4](figure-4.png)\n\nWhat is seen."),
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
        assert!(report["score"].as_f64().unwrap() < 0.6);
        // A second run finds the sweep done, and draws only what is asked for.
        args.only = Some(9);
        let before = std::fs::read(out.join("sweep.arrow")).unwrap();
        execute(&args, &stop, &TOOLS, short).unwrap();
        assert_eq!(std::fs::read(out.join("sweep.arrow")).unwrap(), before);
        let drawn = std::fs::read_to_string(out.join("figure-9.svg")).unwrap();
        assert!(drawn.contains("<title>2</title>"), "{drawn}");
        // Another question does not go over it.
        args.seed = Some(5);
        let refused = execute(&args, &stop, &TOOLS, short).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
    }
}
