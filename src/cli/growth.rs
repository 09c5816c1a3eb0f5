//! `squeakscope growth`: how time and memory scale with the size of the problem.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::figures::{STUDY, write_figures};
use super::interrupt;
use super::output::{Kind, OutputFile};
use super::progress::Progress;
use super::report::{self, HEADING};
use super::resources;
use super::study_args::GrowthArgs;
use super::words::words;
use crate::plot::growth_figure;
use crate::scene::Scene;
use crate::study::growth::{Growth, GrowthPlan, RunCost, growth};
use crate::study::{threads, wait_for};
use crate::table::Table;
use crate::{escape, number};

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or writing; an interrupt.
pub(super) fn execute(args: &GrowthArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = args.scene.load()?;
    report::print_study_warnings(&scene);
    if let Ok(joint) = scene.joint() {
        report::print_held(joint.fixed_at_start());
    }
    let name = scene.name.clone();
    let plan = GrowthPlan {
        repeats: args.repeats.into(),
        ..GrowthPlan::new(scene, threads(args.threads))
    };
    let input = args.scene.input();
    let mut names = args.drawn.names(["growth"], &STUDY);
    names.push("growth.csv".to_owned());
    args.overwrite.check_directory(&args.out, "--out", &names)?;
    let [markdown, json] = args.overwrite.check_all(
        input,
        [
            ("--markdown", Kind::MARKDOWN, args.markdown.as_deref()),
            ("--json", Kind::JSON, args.json.as_deref()),
        ],
    )?;
    resources::start_thread_pool()?;
    let progress = Progress::with_estimate();
    let measured = growth(&plan, &mut run_in_process, &mut |(size, share)| {
        progress.update(share, size.name().to_owned());
        interrupt::should_continue(stop)
    });
    drop(progress);
    let failed = |task| move |source: Cause| CliError::Run { task, source };
    let (growths, complete) = measured.map_err(|fault| failed("growth study")(fault.into()))?;
    if growths.is_empty() {
        return Err(CliError::NoResult);
    }
    let figures = [growth_figure(&name, &growths)];
    let result = GrowthResult {
        growth: growths.as_slice().into(),
    };
    let mut files = Vec::new();
    // The report is printed even if a file cannot be written.
    let mut write_all = || -> Result<(), CliError> {
        files = write_figures(&args.out, "--out", &figures, (&args.drawn, &STUDY))?;
        let csv = OutputFile::check(&args.out.join("growth.csv"), "--out")?;
        csv.write(|out| out.write_all(csv_text(&growths).as_bytes()))?;
        files.push(WrittenFile::of(&csv)?);
        if let Some(file) = &markdown {
            file.write(|out| out.write_all(chapter(&name, &growths).as_bytes()))?;
            files.push(WrittenFile::of(file)?);
        }
        Ok(())
    };
    let written = write_all();
    Document::new(&result, &files)
        .with_scene(&name)
        .deliver(&text(&name, &growths), json.as_ref())?;
    written?;
    match complete {
        true => Ok(()),
        false => Err(CliError::Interrupted),
    }
}

/// Runs a scene for `duration` (s) in a separate process and returns its wall time and peak memory; `None`
/// after an interrupt.
fn run_in_process(
    scene: &Scene,
    duration: f64,
    should_continue: &mut dyn FnMut() -> bool,
) -> Result<Option<RunCost>, Cause> {
    let folder = tempfile::tempdir()?;
    let [file, report] = ["scene.toml", "run.json"].map(|name| folder.path().join(name));
    std::fs::write(&file, &scene.text)?;
    let mut running = Command::new(
        words()
            .first()
            .ok_or("the program does not know its name")?,
    )
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
    // Only this process receives SIGTERM; it must end the run.
    wait_for(&mut running, should_continue)?;
    let done = running.wait_with_output()?;
    // Both processes receive Ctrl-C: an interrupted run is not a failure.
    if !should_continue() {
        return Ok(None);
    }
    if !done.status.success() {
        return Err(String::from_utf8_lossy(&done.stderr).trim().into());
    }
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(report)?)?;
    let seconds = report["wall_s"]
        .as_f64()
        .ok_or("a run did not report its wall time")?;
    Ok(Some(RunCost {
        seconds,
        memory: report["peak_memory_bytes"].as_u64(),
    }))
}

/// The result of the study.
#[derive(Serialize, Deserialize)]
pub(super) struct GrowthResult<'a> {
    /// Time and memory over each size.
    growth: Cow<'a, [Growth]>,
}

/// All points as CSV.
fn csv_text(growths: &[Growth]) -> String {
    let mut text = "size,value,work,seconds,peak_memory_mb\n".to_owned();
    for growth in growths {
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

/// The result as a Markdown chapter with one table per size.
fn chapter(scene: &str, growths: &[Growth]) -> String {
    let mut text = format!("## {}\n\n", escape::markdown(scene));
    for growth in growths {
        text += &table(growth, [growth.work.name(), "peak memory, MB"]).markdown();
        text.push('\n');
        if let Some(power_law) = power_law(growth) {
            let _ = writeln!(text, "{power_law}.\n");
        }
    }
    text
}

/// The report for the terminal.
fn text(scene: &str, growths: &[Growth]) -> String {
    let mut text = format!(
        "{HEADING}{}{HEADING:#}: scaling of time and memory\n",
        escape::line(scene)
    );
    for growth in growths {
        let _ = writeln!(text, "{HEADING}{}{HEADING:#}", growth.work.name());
        text += &table(growth, ["time", "peak MB"]).text();
        if let Some(power_law) = power_law(growth) {
            let _ = writeln!(text, "  {power_law}");
        }
    }
    text
}

/// Time and memory at each size.
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

/// The exponent of the power law over the larger half of the sizes.
fn power_law(growth: &Growth) -> Option<String> {
    let exponent = growth.exponent()?;
    Some(format!(
        "Larger half of the sizes: time grows as ({})^{exponent:.2}",
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
    fn tables_have_every_point_and_the_exponent() {
        let points = [64.0, 1024.0, 10_000.0].map(|value| GrowthPoint {
            value,
            seconds: 1e-8 * value,
            memory: Some(50_000_000),
        });
        let growths = [Growth {
            size: Size::Nodes,
            work: Work::RhsEvaluation,
            points: points.to_vec(),
        }];
        let csv = csv_text(&growths);
        assert_eq!(csv.lines().count(), 4);
        assert!(
            csv.contains(&format!(
                "\"contact nodes\",10000,\"{}\",1e-4,50.0",
                Work::RhsEvaluation.name()
            )),
            "{csv}"
        );
        let page = chapter("torus-3deg", &growths);
        assert!(page.contains("| 64 | 0.640 us | 50.0 |"), "{page}");
        assert!(
            page.contains("time grows as (contact nodes)^1.00."),
            "{page}"
        );
        let text = text("torus-3deg", &growths);
        assert!(
            text.contains("             64  0.640 us     50.0\n"),
            "{text}"
        );
        let json = serde_json::to_value(GrowthResult {
            growth: growths.as_slice().into(),
        })
        .unwrap();
        assert_eq!(json["growth"][0]["size"], "nodes");
    }

    #[test]
    fn an_interrupted_study_writes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let args = GrowthArgs {
            scene: SceneArgs {
                scene: Some("impact-oscillator".to_owned()),
                ..SceneArgs::default()
            },
            repeats: 1,
            threads: None,
            out: folder.path().join("growth"),
            overwrite: Default::default(),
            drawn: Default::default(),
            markdown: None,
            json: None,
        };
        let stopped = execute(&args, &AtomicBool::new(true)).unwrap_err();
        assert_eq!(stopped.exit_code(), 130);
        assert!(!args.out.exists());
    }
}
