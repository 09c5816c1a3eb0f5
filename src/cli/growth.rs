//! `squeakscope growth`: how do time and memory grow with the size of the problem?

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::atomic::AtomicBool;

use anstyle::Style;
use serde::Serialize;

use super::engine;
use super::error::{Cause, CliError};
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{OutputFile, check_all, check_beside, check_directory};
use super::progress::Progress;
use super::report::{self, FileReport, Report, list_files};
use super::study_args::GrowthArgs;
use crate::VERSION;
use crate::escape;
use crate::plot::Figure;
use crate::scene::{DEFAULT_SCENE, Scene};
use crate::study::Watch;
use crate::study::growth::{Grown, Growth, GrowthPlan, Size};
use crate::study::threads;

const NAME: Style = Style::new().bold();

/// What the rest of the crate does for this command.
pub(super) struct Tools {
    /// Measures; and whether it was let to its end.
    pub growth: fn(&GrowthPlan, Watch<'_, (Size, f64)>) -> Result<Grown, Cause>,
    /// The figure of a scene.
    pub draw: fn(&str, &[Growth]) -> Figure,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C.
pub(super) fn run(args: &GrowthArgs, tools: &Tools) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, tools)
}

fn execute(args: &GrowthArgs, stop: &AtomicBool, tools: &Tools) -> Result<(), CliError> {
    let scene = Scene::load(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    if let Ok(joint) = scene.joint() {
        report::print_held(joint.held_at_first());
    }
    let name = scene.name.clone();
    let plan = GrowthPlan {
        repeats: args.repeats.into(),
        ..GrowthPlan::new(scene, threads(args.threads))
    };
    let own = args.scene.as_deref().map(OsStr::new);
    let mut names = args.drawn.names(["growth"], &STUDY);
    names.push("growth.csv".to_owned());
    check_directory(&args.out, "--out", &names)?;
    let [page, json] = check_all(
        own,
        [
            ("--page", args.page.as_deref()),
            ("--json", args.json.as_deref()),
        ],
    )?;
    let others = [("--page", page.as_ref()), ("--json", json.as_ref())];
    check_beside(&args.out, "--out", &names, &others)?;
    engine::start_pool()?;
    let progress = Progress::of_estimate();
    let found = (tools.growth)(&plan, &mut |(size, share)| {
        progress.tell(share, size.name().to_owned());
        interrupt::goes_on(stop)
    });
    drop(progress);
    let failed = |doing| move |source| CliError::Run { doing, source };
    let (grown, whole) = found.map_err(failed("growth study"))?;
    if grown.is_empty() {
        return Err(CliError::NothingYet);
    }
    let figures = [(tools.draw)(&name, &grown)];
    let mut report = GrowthReport {
        version: VERSION,
        scene: name,
        growth: grown,
        files: Vec::new(),
    };
    // What is found is told even where a file cannot be written.
    let mut write_all = || -> Result<(), CliError> {
        report.files = write_figures(&args.out, "--out", &figures, (&args.drawn, &STUDY))?;
        let csv = OutputFile::check(&args.out.join("growth.csv"), "--out")?;
        csv.write(|out| out.write_all(report.table().as_bytes()))?;
        report.files.push(FileReport::of(&csv)?);
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
    match whole {
        true => Ok(()),
        false => Err(CliError::Interrupted),
    }
}

/// Result of `squeakscope growth`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GrowthReport {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// The growth with each size.
    pub growth: Vec<Growth>,
    /// Files written.
    pub files: Vec<FileReport>,
}

impl GrowthReport {
    /// All points, a line each (CSV).
    fn table(&self) -> String {
        let mut text = "size,value,work,seconds,peak_memory_mb\n".to_owned();
        for growth in &self.growth {
            for point in &growth.points {
                let memory = megabytes(point.memory).unwrap_or_default();
                let _ = writeln!(
                    text,
                    "\"{}\",{},\"{}\",{:e},{memory}",
                    growth.size.name(),
                    point.value,
                    growth.work.name(),
                    point.seconds
                );
            }
        }
        text
    }

    /// The growth as a chapter of a page: a table a size.
    fn chapter(&self) -> String {
        let mut text = format!("## {}\n\n", escape::markdown(&self.scene));
        for growth in &self.growth {
            let _ = writeln!(
                text,
                "| {} | {} | peak memory, MB |\n|---|---|---|",
                growth.size.name(),
                growth.work.name()
            );
            for point in &growth.points {
                let memory = megabytes(point.memory).unwrap_or_else(|| "-".to_owned());
                let _ = writeln!(
                    text,
                    "| {} | {} | {memory} |",
                    point.value,
                    time(point.seconds)
                );
            }
            text.push('\n');
            if let Some(words) = words(growth) {
                let _ = writeln!(text, "{words}.\n");
            }
        }
        text
    }
}

impl Report for GrowthReport {
    fn text(&self) -> String {
        let mut text = format!(
            "{NAME}{}{NAME:#}: how cost grows\n",
            escape::line(&self.scene)
        );
        for growth in &self.growth {
            let _ = writeln!(text, "{NAME}{}{NAME:#}", growth.work.name());
            let _ = writeln!(
                text,
                "  {:>26}  {:>10}  {:>11}",
                growth.size.name(),
                "time",
                "peak MB"
            );
            for point in &growth.points {
                let memory = megabytes(point.memory).unwrap_or_else(|| "-".to_owned());
                let _ = writeln!(
                    text,
                    "  {:>26}  {:>10}  {memory:>11}",
                    point.value,
                    time(point.seconds)
                );
            }
            if let Some(words) = words(growth) {
                let _ = writeln!(text, "  {words}");
            }
        }
        list_files(&mut text, &self.files);
        text
    }
}

/// How it grows at last.
fn words(growth: &Growth) -> Option<String> {
    let exponent = growth.exponent()?;
    Some(format!(
        "over the larger half as the power {exponent:.2} of the {}",
        growth.size.name()
    ))
}

fn megabytes(memory: Option<u64>) -> Option<String> {
    memory.map(|bytes| format!("{:.1}", bytes as f64 / 1e6))
}

/// A time as people write it.
fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.3} us", 1e6 * s),
        s if s < 1.0 => format!("{:.2} ms", 1e3 * s),
        s => format!("{s:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::growth::{GrowthPoint, Size, Work};

    const TOOLS: Tools = Tools {
        growth: |plan, watch| {
            if !watch((Size::Nodes, 0.5)) {
                return Ok((Vec::new(), false));
            }
            let point = |value: f64| GrowthPoint {
                value,
                seconds: 1e-8 * value,
                memory: Some(50_000_000),
            };
            let grown = vec![Growth {
                size: Size::Nodes,
                work: Work::Call,
                points: plan
                    .nodes
                    .iter()
                    .map(|nodes| point(*nodes as f64))
                    .collect(),
            }];
            Ok((grown, true))
        },
        draw: |scene, grown| {
            Figure::new(
                "growth",
                format!("{scene} {}", grown.len()),
                50.0,
                Vec::new(),
            )
        },
    };

    #[test]
    fn tables_tell_every_point_and_the_power() {
        let folder = tempfile::tempdir().unwrap();
        let args = GrowthArgs {
            scene: Some("torus-3deg".to_owned()),
            repeats: 1,
            threads: None,
            out: folder.path().join("growth"),
            drawn: Default::default(),
            page: Some(folder.path().join("page.md")),
            json: Some(folder.path().join("growth.json")),
        };
        execute(&args, &AtomicBool::new(false), &TOOLS).unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        let csv = read("growth/growth.csv");
        assert_eq!(csv.lines().count(), 11);
        assert!(
            csv.contains("\"contact nodes\",10000,\"a call of the right-hand side\",1e-4,50.0"),
            "{csv}"
        );
        let page = read("page.md");
        assert!(page.contains("| 64 | 0.640 us | 50.0 |"), "{page}");
        assert!(
            page.contains("the power 1.00 of the contact nodes."),
            "{page}"
        );
        let json: serde_json::Value = serde_json::from_str(&read("growth.json")).unwrap();
        assert_eq!(json["growth"][0]["size"], "nodes");
        assert!(read("growth/growth.svg").contains("<title>torus-3deg 1</title>"));
        let stopped = execute(&args, &AtomicBool::new(true), &TOOLS).unwrap_err();
        assert_eq!(stopped.exit_code(), 130);
    }
}
