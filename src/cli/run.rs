//! `squeakscope run`: simulate a scene and record it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::args::RunArgs;
use super::audit::{self, Audit};
use super::common_args::changed;
use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::exponents::{RunExponents, parting};
use super::interrupt;
use super::output::{OutputFile, check_all};
use super::progress::{Progress, Teller};
use super::report::{self, NAME};
use super::resources::start_pool;
use crate::escape;
use crate::export::SamplesSink;
use crate::pipeline::message::{SpectralLine, Summary};
use crate::pipeline::{Monitor, PipelineError, Sink, Tee, drive, source};
use crate::record::{Output, RerunSink};
use crate::scene::{Integrator, Scene};
use crate::sound::WavSink;
use crate::study::growth::peak_memory;
use crate::table::Table;

/// Where the recording goes if no output is asked for.
const DEFAULT_RECORDING: &str = "squeak.rrd";

/// What JSON says of a run.
#[derive(Serialize)]
struct Found<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// Lyapunov exponents, where the scene asks for them and the run has settled.
    exponents: Option<RunExponents<'a>>,
    /// The most memory that the program has held, bytes; `null` where the system does not tell.
    peak_memory_bytes: Option<u64>,
    /// The integrator, as scenes name it.
    method: &'static str,
    /// Error allowed in a step, relative to the size of the state; `null` where the step is fixed.
    tolerance: Option<f64>,
    /// The energy audit; `null` where nothing was audited.
    audit: Option<Audit>,
    /// What is heard in the sound file, in a few words; `null` without one.
    heard: Option<String>,
}

impl<'a> Found<'a> {
    fn new(scene: &Scene, summary: &'a Summary, heard: Option<String>) -> Self {
        let Integrator {
            method, tolerance, ..
        } = scene.integrator;
        Self {
            summary,
            exponents: summary.exponents.as_ref().map(RunExponents::new),
            peak_memory_bytes: peak_memory(),
            method: method.name(),
            tolerance: (!method.has_fixed_step()).then_some(tolerance),
            audit: Audit::of(summary),
            heard,
        }
    }
}

/// The files asked for.
struct Outputs {
    save: Option<OutputFile>,
    npz: Option<OutputFile>,
    wav: Option<OutputFile>,
    json: Option<OutputFile>,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running; Ctrl-C, after the results are written.
pub(super) fn run(args: &RunArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop)
}

fn execute(args: &RunArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    if args.strict && !audit::is_audited(&scene) {
        return Err(CliError::NotAudited);
    }
    let [save, npz, wav, json] = check_all(
        args.scene.input(),
        [
            ("--save", recording(args)),
            ("--npz", args.npz.as_deref()),
            ("--wav", args.heard.wav.as_deref()),
            ("--json", args.json.as_deref()),
        ],
    )?;
    let outputs = Outputs {
        save,
        npz,
        wav,
        json,
    };
    let progress = Progress::new(scene.duration);
    let ran = simulate(args, &scene, &outputs, stop, &progress);
    // The bar goes before anything else is printed.
    drop(progress);
    let (summary, heard) = ran.map_err(|source| CliError::Run {
        doing: "run",
        source,
    })?;
    let files = [&outputs.save, &outputs.npz, &outputs.wav];
    let files = files.into_iter().flatten().map(WrittenFile::of);
    let files = files.collect::<Result<Vec<_>, _>>()?;
    let found = Found::new(&scene, &summary, heard);
    Document::new(&found, &files)
        .of_scene(&scene.name)
        .deliver(&text(&scene, &found), outputs.json.as_ref())?;
    if let Some(recording) = &outputs.save {
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

/// Runs a scene down the road: simulation, analysis, recording. What it came to, and what is heard, in a few words.
fn simulate(
    args: &RunArgs,
    scene: &Scene,
    outputs: &Outputs,
    stop: &Arc<AtomicBool>,
    progress: &Progress,
) -> Result<(Summary, Option<String>), Cause> {
    let command = command_line();
    // Before anything is opened: what is wrong with the scene leaves nothing behind.
    let simulation = source(scene)?;
    start_pool()?;
    let path = |file: &Option<OutputFile>| file.as_ref().map(|file| file.path().to_owned());
    let output = output(args, path(&outputs.save));
    interrupt::work_begins();
    let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
    // The recording comes last: it takes its name only when the samples have theirs.
    if let Some(path) = path(&outputs.npz) {
        sinks.push(Box::new(SamplesSink::new(path)));
    }
    let mut heard = None;
    if let Some(path) = path(&outputs.wav) {
        let header = simulation.header(&command);
        let sink = WavSink::new(path, args.heard.source(), &header, args.slower)?;
        heard = Some((sink.words(), sink.loudest()));
        sinks.push(Box::new(sink));
    }
    let mut part = None;
    let notice = progress.teller();
    if output != Output::default() {
        let notice = Arc::clone(&notice);
        let recording = RerunSink::new(&output, scene.record)?;
        part = recording.part().map(Path::to_owned);
        sinks.push(Box::new(recording.with_notice(move |words| notice(words))));
    }
    let monitor = Monitor {
        stop,
        progress: &|time| progress.reach(time),
    };
    let done = drive(simulation, &command, &mut Tee::new(sinks), monitor);
    let summary = done.inspect_err(|fault| {
        if let Some(part) = part {
            tell_part(&part, fault, &notice);
        }
    })?;
    let heard = heard.and_then(|(what, loudest)| {
        let loudest = loudest.get()?;
        Some(format!("{what}; the loudest is {loudest}"))
    });
    Ok((summary, heard))
}

/// Where a run is recorded and shown.
fn output(args: &RunArgs, save: Option<PathBuf>) -> Output {
    Output {
        save,
        connect: args.connect.clone(),
        spawn: args.spawn,
    }
}

/// The scene asked for, with what the command line changes of it.
fn scene(args: &RunArgs) -> Result<Scene, CliError> {
    let mut scene = args.scene.load()?;
    scene = args.accuracy.apply(scene)?;
    scene = changed(scene, args.tilt, Scene::with_tilt)?;
    scene = changed(scene, args.duration, Scene::with_duration)?;
    Ok(scene)
}

/// Where the recording goes: without any output asked for, to the default file.
fn recording(args: &RunArgs) -> Option<&Path> {
    let watched = args.spawn || args.connect.is_some();
    match &args.save {
        Some(path) => Some(path),
        None if watched || args.npz.is_some() || args.heard.wav.is_some() => None,
        None => Some(Path::new(DEFAULT_RECORDING)),
    }
}

/// Tells where the beginning of a recording is, unless the fault is the recording's own and says so.
fn tell_part(part: &Path, fault: &PipelineError, notice: &Teller) {
    let is_there = std::fs::metadata(part).is_ok_and(|there| there.len() > 0);
    let place = part.display().to_string();
    let causes = std::iter::successors(Some(fault as &dyn std::error::Error), |cause| {
        cause.source()
    });
    let is_told = causes
        .map(ToString::to_string)
        .any(|words| words.contains(&place));
    if is_there && !is_told {
        notice(&format!(
            "what was recorded until then can be opened: {place}"
        ));
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

/// The text for the terminal.
fn text(scene: &Scene, found: &Found<'_>) -> String {
    let summary = found.summary;
    let is_joint = scene.joint().is_ok();
    let place = match is_joint {
        true => " at the central contact point",
        false => "",
    };
    let mut text = format!(
        "{NAME}{}{NAME:#}: {:.1} ms simulated in {:.2} s (simulation alone {:.2} x real time)\n  \
         amplitude {:.4} um, peak velocity {:.3} mm/s{place}\n",
        escape::line(&scene.name),
        summary.simulated * 1e3,
        summary.wall,
        summary.real_time_factor,
        summary.amplitude * 1e6,
        summary.peak_velocity * 1e3
    );
    text += &lines(&summary.peaks);
    text += &integration(is_joint, found);
    if let Some(exponents) = &found.exponents {
        text += &exponents.text();
    }
    if let Some(copies) = &summary.parting {
        text += &parting(copies);
    }
    if summary.tally.overrun > 0 {
        let _ = writeln!(
            text,
            "  beware: contact nodes opened and closed too often to stop at each; {} steps ran over their events",
            summary.tally.overrun
        );
    }
    if let Some(heard) = &found.heard {
        let _ = writeln!(text, "  heard: {heard}");
    }
    text
}

/// The strongest lines of the spectrum; more of them are read in the recording.
fn lines(lines: &[SpectralLine]) -> String {
    const SHOWN: usize = 6;
    if lines.is_empty() {
        return "  no line in the spectrum\n".to_owned();
    }
    let mut table = Table::default().right("").right("").left("");
    for line in lines.iter().take(SHOWN) {
        table.row([
            format!("{:.1} Hz", line.frequency),
            format!("{:.4} mm/s", line.amplitude * 1e3),
            line.label.clone(),
        ]);
    }
    table.text()
}

/// The integrator, its work and its errors.
fn integration(is_joint: bool, found: &Found<'_>) -> String {
    let Summary {
        tally, transitions, ..
    } = found.summary;
    let events = match (is_joint, found.summary.audit) {
        (false, _) => format!("{transitions} events"),
        (true, Some(residual)) => {
            format!("{transitions} contact transitions; energy residual {residual:.1e}")
        }
        (true, None) => format!("{transitions} contact transitions; energy not audited"),
    };
    let tolerance = found
        .tolerance
        .map(|tolerance| format!(" at {tolerance:e}"));
    format!(
        "  {}{}: {} steps, {} rejected, {} calls; {events}\n",
        found.method,
        tolerance.unwrap_or_default(),
        tally.steps,
        tally.rejections,
        tally.calls
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::SceneArgs;

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
                scene: SceneArgs {
                    scene: Some("mass-on-belt".to_owned()),
                },
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
        execute(&args, &desk.stop).expect("done");
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
        let error = execute(&desk.args(), &desk.stop).expect_err("interrupted");
        assert_eq!(error.exit_code(), 130);
        assert_eq!(desk.json()["interrupted"], true);
    }

    #[test]
    fn a_fault_while_running_is_no_bad_input() {
        let desk = Desk::new();
        // There is no viewer.
        let args = RunArgs {
            connect: Some("rerun+nonsense://".to_owned()),
            ..desk.args()
        };
        let error = execute(&args, &desk.stop).expect_err("failed");
        assert_eq!(error.exit_code(), 1);
        assert!(!desk.folder.path().join("out.json").exists());
    }

    #[test]
    fn bad_input_is_found_before_any_work() {
        let desk = Desk::new();
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
                scene: SceneArgs {
                    scene: Some("torus".to_owned()),
                },
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
            let error = execute(&args, &desk.stop).expect_err("refused");
            assert_eq!(error.exit_code(), 2, "{error}");
            assert!(!desk.folder.path().join("out.rrd").exists());
        }
    }

    #[test]
    fn what_is_found_carries_the_summary() {
        let scene = Scene::load("periodic-2deg").expect("preset");
        let summary = Summary {
            simulated: 0.1,
            amplitude: 0.69e-6,
            peak_velocity: f64::NAN,
            peaks: vec![SpectralLine {
                frequency: 4117.0,
                amplitude: 0.016,
                label: "f1".to_owned(),
            }],
            ..Summary::default()
        };
        let found = Found::new(&scene, &summary, None);
        let value = serde_json::to_value(&found).expect("JSON");
        assert_eq!(value["amplitude_m"], 0.69e-6);
        assert_eq!(value["lines"][0]["frequency_hz"], 4117.0);
        assert_eq!(value["lines"][0]["amplitude"], 0.016);
        assert_eq!(value["steps"], 0);
        assert_eq!(value["peak_velocity_m_per_s"], serde_json::Value::Null);
        let text = text(&scene, &found);
        assert!(text.contains("4117.0 Hz"), "{text}");
        assert!(text.contains("amplitude 0.6900 um"), "{text}");
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
        assert!(output(&watched, None).spawn);
        let both = RunArgs {
            save: Some(PathBuf::from("a.rrd")),
            connect: Some("rerun+http://host/proxy".to_owned()),
            ..RunArgs::default()
        };
        assert_eq!(recording(&both), Some(Path::new("a.rrd")));
        let expected = Output {
            save: Some(PathBuf::from("a.rrd")),
            connect: both.connect.clone(),
            spawn: false,
        };
        assert_eq!(output(&both, both.save.clone()), expected);
        assert_eq!(shown(Path::new("a b.rrd")), "\"a b.rrd\"");
    }
}
