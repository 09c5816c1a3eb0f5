//! `squeakscope analyse`: what kind of motion is in anybody's file?

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::args::AnalyseArgs;
use super::document::{Document, WrittenFile};
use super::engine;
use super::error::{Cause, CliError};
use super::figures::{PIXELS, write_figures};
use super::interrupt;
use super::output::{OutputFile, check_all, check_directory};
use super::progress::Progress;
use super::report;
use super::run::{command_line, shown};
use super::signal_text;
use crate::import::{Selection, Signal};
use crate::pipeline::message::Summary;
use crate::plot::Figure;
use crate::study::signal::{SignalReport, SignalSearch, analyse_signal};

/// A signal to be played along the road of a simulation.
pub(super) struct Play<'a> {
    /// The file that it comes from.
    pub file: &'a Path,
    /// The signal and what is known of it.
    pub report: &'a SignalReport,
    /// How the program was started, for the record.
    pub command: &'a str,
    /// Where the recording goes.
    pub save: &'a Path,
    /// True once it shall end.
    pub stop: &'a Arc<AtomicBool>,
    /// To be told the share done, 0 to 1, from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// What the rest of the crate does for this command.
pub(super) struct Tools {
    /// Reads a signal.
    pub read: fn(&Path, &Selection) -> Result<Signal, CliError>,
    /// Stems of the names of the figures.
    pub names: &'static [&'static str],
    /// The figures.
    pub draw: fn(&SignalReport) -> Vec<Figure>,
    /// Records the analyses along the signal.
    pub play: fn(&Play<'_>) -> Result<Summary, Cause>,
}

/// The report with the file that it is on.
#[derive(Serialize)]
struct Analysed<'a> {
    file: &'a Path,
    #[serde(flatten)]
    report: &'a SignalReport,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while drawing or recording; Ctrl-C.
pub(super) fn analyse(args: &AnalyseArgs, tools: &Tools) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, tools)
}

fn execute(args: &AnalyseArgs, stop: &Arc<AtomicBool>, tools: &Tools) -> Result<(), CliError> {
    let [save, json] = check_all(
        Some(args.file.as_os_str()),
        [
            ("--save", args.save.as_deref()),
            ("--json", args.json.as_deref()),
        ],
    )?;
    if let Some(directory) = &args.figures {
        let names = args.drawn.names(tools.names, &PIXELS);
        check_directory(directory, "--figures", &names)?;
    }
    if save.is_some() {
        engine::check_memory()?;
    }
    let signal = (tools.read)(
        &args.file,
        &Selection {
            column: args.column.clone(),
            rate: args.rate,
            from: args.from,
            to: args.to,
            max_samples: Some(args.max_samples),
        },
    )?;
    engine::start_pool()?;
    let search = SignalSearch {
        lag: args.lag.map(|lag| lag as usize),
        dimension: args.dimension.map(|m| m as usize),
        threshold: args.threshold,
    };
    let progress = Progress::of_steps();
    let report = analyse_signal(signal, &search, &mut |share, name| {
        progress.step(share, name);
        interrupt::goes_on(stop)
    });
    // The bar goes before anything else is printed.
    drop(progress);
    let report = report.map_err(|reason| CliError::Signal {
        path: args.file.clone(),
        reason,
    })?;
    let report = report.ok_or(CliError::NothingYet)?;
    let mut files = Vec::new();
    if let Some(directory) = &args.figures {
        let drawn = (&args.drawn, &PIXELS[..]);
        files.extend(write_figures(
            directory,
            "--figures",
            &(tools.draw)(&report),
            drawn,
        )?);
    }
    let summary = save
        .as_ref()
        .map(|save| play(args, &report, save, stop, tools))
        .transpose()?;
    files.extend(save.as_ref().map(WrittenFile::of).transpose()?);
    let mut text = signal_text::text(&args.file, &report);
    if !files.is_empty() {
        text.push('\n');
    }
    let analysed = Analysed {
        file: &args.file,
        report: &report,
    };
    Document::new(&analysed, &files).deliver(&text, json.as_ref())?;
    if let Some(recording) = &save {
        report::print(&format!(
            "\nopen it with: rerun {}\n",
            shown(recording.path())
        ))?;
    }
    match summary {
        Some(summary) if summary.interrupted => Err(CliError::Interrupted),
        _ => Ok(()),
    }
}

/// Sends the signal down the road into a recording.
fn play(
    args: &AnalyseArgs,
    report: &SignalReport,
    save: &OutputFile,
    stop: &Arc<AtomicBool>,
    tools: &Tools,
) -> Result<Summary, CliError> {
    let progress = Progress::of_steps();
    let summary = (tools.play)(&Play {
        file: &args.file,
        report,
        command: &command_line(),
        save: save.path(),
        stop,
        progress: &|share| progress.step(share, "recording"),
    });
    drop(progress);
    summary.map_err(|source| CliError::Run {
        doing: "recording",
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn tone(_: &Path, _: &Selection) -> Result<Signal, CliError> {
        let sample = |k: u32| (TAU * 0.0213 * f64::from(k)).sin();
        Ok(Signal {
            name: "tone".to_owned(),
            unit: "m".to_owned(),
            rate: 1000.0,
            start: 2.0,
            samples: (0..2000).map(sample).collect(),
        })
    }

    const TOOLS: Tools = Tools {
        read: tone,
        names: &["tone"],
        draw: |_| vec![Figure::new("tone", "A tone", 30.0, Vec::new())],
        play: |job| {
            std::fs::write(job.save, job.command)?;
            (job.progress)(0.5);
            Ok(Summary {
                interrupted: job.report.signal.start != 2.0,
                ..Summary::default()
            })
        },
    };

    struct Desk(tempfile::TempDir);

    impl Desk {
        fn args(&self) -> AnalyseArgs {
            let path = |name: &str| self.0.path().join(name);
            AnalyseArgs {
                file: path("tone.wav"),
                save: Some(path("out.rrd")),
                figures: Some(path("new/figures")),
                json: Some(path("out.json")),
                ..AnalyseArgs::default()
            }
        }
    }

    fn desk() -> Desk {
        Desk(tempfile::tempdir().expect("temporary folder"))
    }

    #[test]
    fn all_outputs_are_written_and_told() {
        let (desk, stop) = (desk(), Arc::default());
        execute(&desk.args(), &stop, &TOOLS).expect("done");
        let text = std::fs::read(desk.0.path().join("out.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(json["signal"]["start_s"], 2.0);
        assert_eq!(json["signal"]["duration_s"], 2.0);
        assert_eq!(json["files"].as_array().map(Vec::len), Some(2));
        let figure = desk.0.path().join("new/figures/tone.png");
        let figure = std::fs::read(figure).expect("written");
        assert!(figure.starts_with(b"\x89PNG"));
        assert_eq!(json["files"][0]["bytes"], figure.len());
    }

    #[test]
    fn an_interrupted_analysis_leaves_nothing() {
        let (desk, stop) = (desk(), Arc::new(AtomicBool::new(true)));
        let error = execute(&desk.args(), &stop, &TOOLS).expect_err("interrupted");
        assert_eq!(error.exit_code(), 130);
        assert_eq!(std::fs::read_dir(desk.0.path()).expect("there").count(), 0);
    }

    #[test]
    fn outputs_are_checked_before_the_file_is_read() {
        let (desk, stop) = (desk(), Arc::default());
        let never = Tools {
            read: |_, _| panic!("nothing must be read"),
            ..TOOLS
        };
        let file = desk.args().file;
        std::fs::write(&file, "sound").expect("written");
        for args in [
            AnalyseArgs {
                json: Some(file.clone()),
                ..desk.args()
            },
            AnalyseArgs {
                figures: Some(file.clone()),
                ..desk.args()
            },
            AnalyseArgs {
                save: desk.args().json,
                ..desk.args()
            },
        ] {
            let error = execute(&args, &stop, &never).expect_err("refused");
            assert_eq!(error.exit_code(), 2, "{error}");
        }
        assert_eq!(std::fs::read(&file).expect("there"), b"sound");
    }

    #[test]
    fn a_fault_while_drawing_is_no_bad_input() {
        let (desk, stop) = (desk(), Arc::default());
        let tools = Tools {
            draw: |_| vec![Figure::new("flat", "", 0.0, Vec::new())],
            ..TOOLS
        };
        let error = execute(&desk.args(), &stop, &tools).expect_err("failed");
        assert_eq!(error.exit_code(), 1);
    }
}
