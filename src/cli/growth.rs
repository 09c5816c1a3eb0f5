//! `squeakscope growth`: how do time and memory grow with the size of the problem?

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{OutputFile, check_all, check_beside, check_directory};
use super::progress::Progress;
use super::report::{self, NAME};
use super::resources;
use super::study_args::GrowthArgs;
use crate::plot::growth_figure;
use crate::scene::Scene;
use crate::study::growth::{Growth, GrowthPlan, Taken, growth};
use crate::study::{threads, wait_for};
use crate::table::Table;
use crate::{escape, number};

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or writing; Ctrl-C.
pub(super) fn run(args: &GrowthArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop)
}

fn execute(args: &GrowthArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    if let Ok(joint) = scene.joint() {
        report::print_held(joint.held_at_first());
    }
    let name = scene.name.clone();
    let plan = GrowthPlan {
        repeats: args.repeats.into(),
        ..GrowthPlan::new(scene, threads(args.threads))
    };
    let own = args.scene.input();
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
    resources::start_pool()?;
    let progress = Progress::of_estimate();
    let found = growth(&plan, &mut run_apart, &mut |(size, share)| {
        progress.tell(share, size.name().to_owned());
        interrupt::goes_on(stop)
    });
    drop(progress);
    let failed = |doing| move |source: Cause| CliError::Run { doing, source };
    let (grown, whole) = found.map_err(|fault| failed("growth study")(fault.into()))?;
    if grown.is_empty() {
        return Err(CliError::NothingYet);
    }
    let figures = [growth_figure(&name, &grown)];
    let found = Found { growth: &grown };
    let mut files = Vec::new();
    // What is found is told even where a file cannot be written.
    let mut write_all = || -> Result<(), CliError> {
        files = write_figures(&args.out, "--out", &figures, (&args.drawn, &STUDY))?;
        let csv = OutputFile::check(&args.out.join("growth.csv"), "--out")?;
        csv.write(|out| out.write_all(csv_text(&grown).as_bytes()))?;
        files.push(WrittenFile::of(&csv)?);
        if let Some(file) = &page {
            file.write(|out| out.write_all(chapter(&name, &grown).as_bytes()))?;
            files.push(WrittenFile::of(file)?);
        }
        Ok(())
    };
    let written = write_all();
    Document::new(&found, &files)
        .of_scene(&name)
        .deliver(&text(&name, &grown), json.as_ref())?;
    written?;
    match whole {
        true => Ok(()),
        false => Err(CliError::Interrupted),
    }
}

/// Runs a scene for so long (s) in a process of its own, and tells what its report says of time and memory.
fn run_apart(
    scene: &Scene,
    duration: f64,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Option<Taken>, Cause> {
    let folder = tempfile::tempdir()?;
    let [file, report] = ["scene.toml", "run.json"].map(|name| folder.path().join(name));
    std::fs::write(&file, &scene.text)?;
    let mut running = Command::new(std::env::current_exe()?)
        .arg("run")
        .arg(&file)
        .args(["--duration", &format!("{}", 1e3 * duration)])
        .arg("--save")
        .arg(folder.path().join("run.rrd"))
        .arg("--json")
        .arg(&report)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()?;
    // SIGTERM comes to this process alone.
    wait_for(&mut running, goes_on)?;
    let done = running.wait_with_output()?;
    // Ctrl-C comes to both: that the run was interrupted, too, is no fault.
    if !goes_on() {
        return Ok(None);
    }
    if !done.status.success() {
        return Err(String::from_utf8_lossy(&done.stderr).trim().into());
    }
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report)?)?;
    let seconds = report["wall_s"].as_f64().ok_or("a run told no time")?;
    Ok(Some(Taken {
        seconds,
        memory: report["peak_memory_bytes"].as_u64(),
    }))
}

/// The growth with each size, as JSON has it.
#[derive(Serialize)]
struct Found<'a> {
    growth: &'a [Growth],
}

/// All points, a line each (CSV).
fn csv_text(grown: &[Growth]) -> String {
    let mut text = "size,value,work,seconds,peak_memory_mb\n".to_owned();
    for growth in grown {
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
fn chapter(scene: &str, grown: &[Growth]) -> String {
    let mut text = format!("## {}\n\n", escape::markdown(scene));
    for growth in grown {
        text += &table(growth, [growth.work.name(), "peak memory, MB"]).markdown();
        text.push('\n');
        if let Some(words) = words(growth) {
            let _ = writeln!(text, "{words}.\n");
        }
    }
    text
}

/// The text for the terminal.
fn text(scene: &str, grown: &[Growth]) -> String {
    let mut text = format!("{NAME}{}{NAME:#}: how cost grows\n", escape::line(scene));
    for growth in grown {
        let _ = writeln!(text, "{NAME}{}{NAME:#}", growth.work.name());
        text += &table(growth, ["time", "peak MB"]).text();
        if let Some(words) = words(growth) {
            let _ = writeln!(text, "  {words}");
        }
    }
    text
}

/// Time and memory of each size.
fn table(growth: &Growth, [time, memory]: [&str; 2]) -> Table {
    let titles = [growth.size.name(), time, memory];
    let mut table = titles.into_iter().fold(Table::default(), Table::right);
    for point in &growth.points {
        let memory = megabytes(point.memory).unwrap_or_else(|| "-".to_owned());
        let time = number::time(point.seconds, 3);
        table.row([point.value.to_string(), time, memory]);
    }
    table
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::SceneArgs;
    use crate::study::growth::{GrowthPoint, Size, Work};

    #[test]
    fn tables_tell_every_point_and_the_power() {
        let points = [64.0, 1024.0, 10_000.0].map(|value| GrowthPoint {
            value,
            seconds: 1e-8 * value,
            memory: Some(50_000_000),
        });
        let grown = [Growth {
            size: Size::Nodes,
            work: Work::Call,
            points: points.to_vec(),
        }];
        let csv = csv_text(&grown);
        assert_eq!(csv.lines().count(), 4);
        assert!(
            csv.contains("\"contact nodes\",10000,\"a call of the right-hand side\",1e-4,50.0"),
            "{csv}"
        );
        let page = chapter("torus-3deg", &grown);
        assert!(page.contains("| 64 | 0.640 us | 50.0 |"), "{page}");
        assert!(
            page.contains("the power 1.00 of the contact nodes."),
            "{page}"
        );
        let text = text("torus-3deg", &grown);
        assert!(
            text.contains("             64  0.640 us     50.0\n"),
            "{text}"
        );
        let json = serde_json::to_value(Found { growth: &grown }).unwrap();
        assert_eq!(json["growth"][0]["size"], "nodes");
    }

    #[test]
    fn a_study_that_is_stopped_at_once_has_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let args = GrowthArgs {
            scene: SceneArgs {
                scene: Some("impact-oscillator".to_owned()),
            },
            repeats: 1,
            threads: None,
            out: folder.path().join("growth"),
            drawn: Default::default(),
            page: None,
            json: None,
        };
        let stopped = execute(&args, &AtomicBool::new(true)).unwrap_err();
        assert_eq!(stopped.exit_code(), 130);
        assert!(!args.out.exists());
    }
}
