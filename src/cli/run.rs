//! `squeakscope run`: simulate a scene and record it.

use std::cell::OnceCell;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::args::RunArgs;
use super::audit;
use super::error::{Cause, CliError};
use super::interrupt;
use super::output::{OutputFile, check_all};
use super::progress::{Progress, Teller};
use super::report::{self, FileReport, RunReport};
use crate::escape;
use crate::pipeline::message::Summary;
use crate::scene::{DEFAULT_SCENE, Scene};
use crate::sound::Source;

/// Where the recording goes if no output is asked for.
const DEFAULT_RECORDING: &str = "squeak.rrd";

/// What a simulation is asked to do.
pub(super) struct Job<'a> {
    /// What to simulate.
    pub scene: &'a Scene,
    /// How the program was started, for the record.
    pub command: &'a str,
    /// Where the recording goes; a file already there is replaced only by a whole new one.
    pub save: Option<&'a Path>,
    /// Where the samples go as NumPy arrays.
    pub npz: Option<&'a Path>,
    /// Where the sound goes, what is heard, and how many times slower than life.
    pub wav: Option<(&'a Path, Source, f64)>,
    /// Who watches.
    pub viewer: Viewer<'a>,
    /// True once the run shall end.
    pub stop: &'a Arc<AtomicBool>,
    /// To be told the simulated time reached (s), from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
    /// To be told what happens that is no error, in a line.
    pub notice: Teller,
    /// To be told at the end what is heard and how loud, in a few words.
    pub hears: &'a dyn Fn(String),
}

/// Who watches a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Viewer<'a> {
    /// Nobody.
    Nobody,
    /// A viewer opened for it on this machine.
    Spawned,
    /// A viewer that listens at a URL.
    At(&'a str),
}

/// Runs the command; `simulate` does the work and says what it came to.
///
/// # Errors
/// Bad input before any work; a fault while running; Ctrl-C, after the results are written.
pub(super) fn run(
    args: &RunArgs,
    simulate: impl FnOnce(&Job<'_>) -> Result<Summary, Cause>,
) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, simulate)
}

fn execute(
    args: &RunArgs,
    stop: &Arc<AtomicBool>,
    simulate: impl FnOnce(&Job<'_>) -> Result<Summary, Cause>,
) -> Result<(), CliError> {
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    if args.strict && !audit::is_audited(&scene) {
        return Err(CliError::NotAudited);
    }
    let [save, npz, wav, json] = check_all(
        args.scene.as_deref().map(OsStr::new),
        [
            ("--save", recording(args)),
            ("--npz", args.npz.as_deref()),
            ("--wav", args.heard.wav.as_deref()),
            ("--json", args.json.as_deref()),
        ],
    )?;
    let progress = Progress::new(scene.duration);
    let command = command_line();
    let heard = OnceCell::new();
    let summary = simulate(&Job {
        scene: &scene,
        command: &command,
        save: save.as_ref().map(OutputFile::path),
        npz: npz.as_ref().map(OutputFile::path),
        wav: wav
            .as_ref()
            .map(|wav| (wav.path(), args.heard.source(), args.slower)),
        viewer: viewer(args),
        stop,
        progress: &|time| progress.reach(time),
        notice: progress.teller(),
        hears: &|words| heard.set(words).expect("it is told once"),
    });
    // The bar goes before anything else is printed.
    drop(progress);
    let summary = summary.map_err(|source| CliError::Run {
        doing: "run",
        source,
    })?;
    let files = [&save, &npz, &wav]
        .into_iter()
        .flatten()
        .map(FileReport::of);
    let files = files.collect::<Result<Vec<_>, _>>()?;
    let report = RunReport {
        heard: heard.into_inner(),
        ..RunReport::new(&scene, &summary, files)
    };
    report::deliver(&report, json.as_ref())?;
    if let Some(recording) = &save {
        report::print(&format!(
            "\nopen it with: rerun {}\n",
            shown(recording.path())
        ))?;
    }
    match summary.interrupted {
        true => audit::judge(&summary, false).and(Err(CliError::Interrupted)),
        false => audit::judge(&summary, args.strict),
    }
}

/// The scene asked for, with what the command line changes of it.
fn scene(args: &RunArgs) -> Result<Scene, CliError> {
    let mut scene = Scene::load(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    if let Some(error) = args.accuracy {
        scene = scene.with_accuracy(error)?;
    }
    if let Some(tilt) = args.tilt {
        scene = scene.with_tilt(tilt)?;
    }
    if let Some(duration) = args.duration {
        scene = scene.with_duration(duration)?;
    }
    Ok(scene)
}

/// Where the recording goes: without any output asked for, to the default file.
fn recording(args: &RunArgs) -> Option<&Path> {
    let watched = viewer(args) != Viewer::Nobody;
    match &args.save {
        Some(path) => Some(path),
        None if watched || args.npz.is_some() || args.heard.wav.is_some() => None,
        None => Some(Path::new(DEFAULT_RECORDING)),
    }
}

fn viewer(args: &RunArgs) -> Viewer<'_> {
    match &args.connect {
        Some(url) => Viewer::At(url),
        None if args.spawn => Viewer::Spawned,
        None => Viewer::Nobody,
    }
}

/// How the program was started.
pub(super) fn command_line() -> String {
    let name = std::iter::once("squeakscope".to_owned());
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| word.to_string_lossy().into_owned());
    name.chain(words).collect::<Vec<_>>().join(" ")
}

/// A path as one word of a shell.
pub(super) fn shown(path: &Path) -> String {
    let path = escape::path(path);
    match path.contains(char::is_whitespace) {
        true => format!("\"{path}\""),
        false => path,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// Stands for a simulation: saves a recording and reports what it was asked for.
    fn pretend(job: &Job<'_>) -> Result<Summary, Cause> {
        (job.progress)(job.scene.duration / 2.0);
        if let Some(path) = job.save {
            std::fs::write(path, job.command)?;
        }
        Ok(Summary {
            simulated: job.scene.duration,
            interrupted: job.stop.load(std::sync::atomic::Ordering::Relaxed),
            ..Summary::default()
        })
    }

    struct Desk {
        folder: tempfile::TempDir,
        stop: Arc<AtomicBool>,
    }

    impl Desk {
        fn new() -> Self {
            Self {
                folder: tempfile::tempdir().expect("temporary folder"),
                stop: Arc::default(),
            }
        }

        fn args(&self) -> RunArgs {
            RunArgs {
                scene: Some("torus-3deg".to_owned()),
                save: Some(self.folder.path().join("out.rrd")),
                json: Some(self.folder.path().join("out.json")),
                ..RunArgs::default()
            }
        }

        fn json(&self) -> serde_json::Value {
            let text = std::fs::read(self.folder.path().join("out.json")).expect("written");
            serde_json::from_slice(&text).expect("JSON")
        }
    }

    #[test]
    fn a_run_reports_its_files() {
        let desk = Desk::new();
        let args = RunArgs {
            duration: Some(12.0),
            ..desk.args()
        };
        execute(&args, &desk.stop, pretend).expect("done");
        let report = desk.json();
        assert_eq!(report["simulated_s"], 0.012);
        assert_eq!(report["interrupted"], false);
        let size = std::fs::metadata(desk.folder.path().join("out.rrd"))
            .expect("saved")
            .len();
        assert_eq!(report["files"][0]["bytes"], size);
    }

    #[test]
    fn an_interrupted_run_keeps_its_results() {
        let desk = Desk::new();
        desk.stop.store(true, std::sync::atomic::Ordering::Relaxed);
        let error = execute(&desk.args(), &desk.stop, pretend).expect_err("interrupted");
        assert_eq!(error.exit_code(), 130);
        assert_eq!(desk.json()["interrupted"], true);
    }

    #[test]
    fn a_fault_while_running_is_no_bad_input() {
        let desk = Desk::new();
        let error = execute(&desk.args(), &desk.stop, |_| {
            Err("the state left the numbers".into())
        })
        .expect_err("failed");
        assert_eq!(error.exit_code(), 1);
        assert!(!desk.folder.path().join("out.json").exists());
    }

    #[test]
    fn bad_input_is_found_before_any_work() {
        let desk = Desk::new();
        let never = |_: &Job<'_>| -> Result<Summary, Cause> { panic!("no work must be done") };
        let bad = [
            RunArgs {
                tilt: Some(91.0),
                ..desk.args()
            },
            RunArgs {
                tilt: Some(f64::NAN),
                ..desk.args()
            },
            RunArgs {
                duration: Some(0.0),
                ..desk.args()
            },
            RunArgs {
                scene: Some("torus".to_owned()),
                ..desk.args()
            },
            RunArgs {
                npz: Some(PathBuf::from("absent/folder/out.npz")),
                ..desk.args()
            },
            RunArgs {
                save: Some(desk.folder.path().to_owned()),
                ..desk.args()
            },
            RunArgs {
                npz: desk.args().json,
                ..desk.args()
            },
        ];
        for args in bad {
            let error = execute(&args, &desk.stop, never).expect_err("refused");
            assert_eq!(error.exit_code(), 2, "{error}");
        }
    }

    #[test]
    fn outputs_have_sensible_defaults() {
        let none = RunArgs::default();
        assert_eq!(recording(&none), Some(Path::new("squeak.rrd")));
        let watched = RunArgs {
            spawn: true,
            ..RunArgs::default()
        };
        assert_eq!(recording(&watched), None);
        assert_eq!(viewer(&watched), Viewer::Spawned);
        let both = RunArgs {
            save: Some(PathBuf::from("a.rrd")),
            connect: Some("rerun+http://host/proxy".to_owned()),
            ..RunArgs::default()
        };
        assert_eq!(recording(&both), Some(Path::new("a.rrd")));
        assert_eq!(viewer(&both), Viewer::At("rerun+http://host/proxy"));
        assert_eq!(shown(Path::new("a b.rrd")), "\"a b.rrd\"");
    }
}
