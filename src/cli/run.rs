//! `squeakscope run`: simulate a scene and record it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use schemars::JsonSchema;
use serde::Serialize;

use super::args::RunArgs;
use super::audit::{self, Audit};
use super::common_args::changed;
use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::exponents::{RunExponents, divergence_text};
use super::interrupt;
use super::output::{Kind, OutputFile};
use super::progress::{Notifier, Progress};
use super::report::{self, HEADING, WARNING};
use super::resources::start_thread_pool;
use crate::escape;
use crate::export::SamplesSink;
use crate::number::significant;
use crate::pipeline::message::{SpectralLine, Summary};
use crate::pipeline::{Monitor, PipelineError, Sink, Tee, drive, source};
use crate::record::{Output, RERUN_VERSION, RerunSink};
use crate::scene::{Integrator, Scene};
use crate::sound::WavSink;
use crate::study::lyapunov::Classified;
use crate::table::Table;

/// The recording, if no output is given.
const DEFAULT_RECORDING: &str = "squeak.rrd";

/// The result of a run.
#[derive(Serialize, JsonSchema)]
pub(super) struct RunResult<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// Lyapunov exponents; `null` if the scene does not compute them or the run has not settled.
    exponents: Option<RunExponents<'a>>,
    /// Peak memory: largest resident memory of the program, bytes; `null` if the system does not report it.
    peak_memory_bytes: Option<u64>,
    /// Integrator, as in the scene file.
    method: &'static str,
    /// Relative tolerance of a step; `null` for a fixed step.
    tolerance: Option<f64>,
    /// Energy audit; `null` if there was none.
    audit: Option<Audit>,
    /// Quantity, place and peak level of the sound file; `null` without a sound file.
    audio: Option<String>,
}

impl<'a> RunResult<'a> {
    fn new(scene: &Scene, summary: &'a Summary, audio: Option<String>) -> Self {
        let Integrator {
            method, tolerance, ..
        } = scene.integrator;
        Self {
            summary,
            exponents: summary.exponents.as_ref().map(Classified::run),
            peak_memory_bytes: peak_memory(),
            method: method.name(),
            tolerance: (!method.has_fixed_step()).then_some(tolerance),
            audit: Audit::of(summary),
            audio,
        }
    }
}

/// Peak memory of this process, bytes. `None` if the system does not report it (Linux does).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024 * kilobytes)
}

/// The output files.
struct Outputs {
    save: Option<OutputFile>,
    npz: Option<OutputFile>,
    wav: Option<OutputFile>,
    json: Option<OutputFile>,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running; an interrupt, after the results are written.
pub(super) fn execute(args: &RunArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    if args.strict && !audit::is_audited(&scene) {
        return Err(CliError::NotAudited);
    }
    let (recording, saved) = recording(args);
    let [save, npz, wav, json] = args.overwrite.check_all(
        args.scene.input(),
        [
            ("--save", recording, saved),
            ("--npz", Kind::ARRAYS, args.npz.as_deref()),
            ("--wav", Kind::SOUND, args.audio.wav.as_deref()),
            ("--json", Kind::JSON, args.json.as_deref()),
        ],
    )?;
    let outputs = Outputs {
        save,
        npz,
        wav,
        json,
    };
    let progress = Progress::of_simulation(scene.duration);
    let simulated = simulate(args, &scene, &outputs, stop, &progress);
    // Clears the bar before the report is printed.
    drop(progress);
    let (summary, audio) = simulated.map_err(CliError::during("run"))?;
    let files = [&outputs.save, &outputs.npz, &outputs.wav];
    let files = files.into_iter().flatten().map(WrittenFile::of);
    let files = files.collect::<Result<Vec<_>, _>>()?;
    let result = RunResult::new(&scene, &summary, audio);
    Document::new(&result, &files)
        .with_scene(&scene.name)
        .deliver(&text(&scene, &result), outputs.json.as_ref())?;
    if let Some(recording) = &outputs.save {
        print_viewer_command(recording.path())?;
    }
    match summary.interrupted {
        true => audit::check(&summary, false).and(Err(CliError::Interrupted)),
        false => audit::check(&summary, args.strict),
    }
}

/// Runs the pipeline: simulation, analyses, recording. Returns the summary, and a description of the sound
/// file.
fn simulate(
    args: &RunArgs,
    scene: &Scene,
    outputs: &Outputs,
    stop: &Arc<AtomicBool>,
    progress: &Progress,
) -> Result<(Summary, Option<String>), Cause> {
    let command = command_line();
    // An invalid scene fails here, before a file is opened.
    let simulation = source(scene)?;
    start_thread_pool()?;
    let path = |file: &Option<OutputFile>| file.as_ref().map(|file| file.path().to_owned());
    let output = output(args, path(&outputs.save));
    interrupt::start_work();
    let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
    // The recording is the last sink, so it gets its final name only after the samples.
    if let Some(path) = path(&outputs.npz) {
        sinks.push(Box::new(SamplesSink::new(path)));
    }
    let mut audio = None;
    if let Some(path) = path(&outputs.wav) {
        let header = simulation.header(&command);
        let sink = WavSink::new(path, args.audio.source(), &header, args.time_stretch)?;
        audio = Some((sink.description(), sink.loudest()));
        sinks.push(Box::new(sink));
    }
    let mut part = None;
    let notify = progress.notifier();
    if output != Output::default() {
        let notify = Arc::clone(&notify);
        let recording = RerunSink::new(&output, scene.record)?;
        part = recording.part().map(Path::to_owned);
        sinks.push(Box::new(
            recording.with_notice(move |message| notify(message)),
        ));
    }
    let monitor = Monitor {
        stop,
        progress: &|time| progress.set_position(time),
    };
    let done = drive(simulation, &command, &mut Tee::new(sinks), monitor);
    let summary = done.inspect_err(|fault| {
        if let Some(part) = part {
            report_partial_recording(&part, fault, &notify);
        }
    })?;
    let audio = audio.and_then(|(description, peak)| {
        let peak = peak.get()?;
        Some(format!("{description}; peak {peak}"))
    });
    Ok((summary, audio))
}

/// The recording and the viewer of a run.
fn output(args: &RunArgs, save: Option<PathBuf>) -> Output {
    Output {
        save,
        connect: args.connect.clone(),
        spawn: args.spawn,
    }
}

/// The scene with the changes of the command line.
fn scene(args: &RunArgs) -> Result<Scene, CliError> {
    let mut scene = args.scene.load()?;
    scene = args.accuracy.apply(scene)?;
    scene = args.budget.apply(scene);
    scene = changed(scene, args.tilt, Scene::with_tilt)?;
    scene = changed(scene, args.duration, Scene::with_duration)?;
    Ok(scene)
}

/// The file for the recording: the default file, which is replaced, if there is no other output.
fn recording(args: &RunArgs) -> (Kind, Option<&Path>) {
    let watched = args.spawn || args.connect.is_some();
    let files = [&args.npz, &args.audio.wav, &args.json];
    let other = watched || files.into_iter().any(Option::is_some);
    match &args.save {
        None if !other => (
            Kind::RECORDING.replaced(),
            Some(Path::new(DEFAULT_RECORDING)),
        ),
        save => (Kind::RECORDING, save.as_deref()),
    }
}

/// Reports the path of a partial recording, unless the error names it.
fn report_partial_recording(part: &Path, fault: &PipelineError, notify: &Notifier) {
    let has_data = std::fs::metadata(part).is_ok_and(|metadata| metadata.len() > 0);
    let path = part.display().to_string();
    let causes = std::iter::successors(Some(fault as &dyn std::error::Error), |cause| {
        cause.source()
    });
    let is_named = causes
        .map(ToString::to_string)
        .any(|message| message.contains(&path));
    if has_data && !is_named {
        notify(&format!(
            "the recording up to the failure can be opened: {path}"
        ));
    }
}

/// The command line that started the program.
pub(super) fn command_line() -> String {
    let name = std::iter::once("squeakscope".to_owned());
    let words = super::WORDS.get().into_iter().flatten().skip(1);
    let words = words.map(|word| word.to_string_lossy().into_owned());
    name.chain(words).collect::<Vec<_>>().join(" ")
}

/// Prints the commands that open a recording: in the browser, and in the native viewer.
pub(super) fn print_viewer_command(recording: &Path) -> Result<(), CliError> {
    let path = shell_word(recording);
    let native = format!("pip install rerun-sdk=={RERUN_VERSION}; rerun {path}");
    let text = format!("\nopen with: squeakscope view {path}  (native viewer: {native})\n");
    Ok(report::print(&text)?)
}

/// A path as one word of a shell command.
fn shell_word(path: &Path) -> String {
    let path = escape::path(path);
    match path.contains(char::is_whitespace) {
        true => format!("\"{path}\""),
        false => path,
    }
}

/// The report for the terminal.
fn text(scene: &Scene, result: &RunResult<'_>) -> String {
    let summary = result.summary;
    let is_joint = scene.joint().is_ok();
    let place = match is_joint {
        true => " at the central contact point",
        false => "",
    };
    let mut text = format!(
        "{HEADING}{}{HEADING:#}: {:.1} ms simulated in {:.2} s (simulation alone: {:.2} x real time)\n  \
         amplitude {:.4} um, peak velocity {:.3} mm/s{place}\n",
        escape::line(&scene.name),
        summary.simulated * 1e3,
        summary.wall,
        summary.real_time_factor,
        summary.amplitude * 1e6,
        summary.peak_velocity * 1e3
    );
    if let Some(motion) = summary.describe_motion() {
        let _ = writeln!(text, "  type of motion: {motion}");
    }
    if !summary.at_rest {
        text += &lines(&summary.peaks);
    }
    text += &integration(is_joint, result);
    if let Some(exponents) = &result.exponents {
        text += &exponents.text();
    }
    if let Some(divergence) = &summary.divergence {
        text += &divergence_text(divergence);
    }
    if summary.stats.steps_without_event_location > 0 {
        let _ = writeln!(
            text,
            "  {WARNING}warning:{WARNING:#} {} steps passed contact events without locating them, because \
             the events were too frequent",
            summary.stats.steps_without_event_location
        );
    }
    if let Some(audio) = &result.audio {
        let _ = writeln!(text, "  sound: {audio}");
    }
    text
}

/// The strongest lines of the spectrum. The recording has all of them.
fn lines(lines: &[SpectralLine]) -> String {
    const MAX_LINES: usize = 6;
    if lines.is_empty() {
        return "  no lines in the spectrum\n".to_owned();
    }
    let mut table = Table::default().right("").right("").left("");
    for line in lines.iter().take(MAX_LINES) {
        table.row([
            format!("{:.1} Hz", line.frequency),
            format!("{:.4} mm/s", line.amplitude * 1e3),
            line.label.clone(),
        ]);
    }
    table.text()
}

/// The integrator, its statistics and the energy residual.
fn integration(is_joint: bool, result: &RunResult<'_>) -> String {
    let Summary {
        stats, transitions, ..
    } = result.summary;
    let events = match (is_joint, result.summary.audit) {
        (false, _) => format!("{transitions} events"),
        (true, Some(residual)) => {
            format!("{transitions} contact transitions; relative energy residual {residual:.1e}")
        }
        (true, None) => format!("{transitions} contact transitions; no energy audit"),
    };
    let tolerance = result
        .tolerance
        .map(|tolerance| format!(", tolerance {tolerance:e}"));
    let fewer = result.summary.analysis_rate.filter(|rate| *rate < 1.0);
    let fewer = fewer.map(|rate| {
        let percent = significant(100.0 * rate, 2);
        format!("  analyses at {percent} % of their rate, to keep up with real time\n")
    });
    format!(
        "  {}{}: {} steps, {} rejected, {} right-hand-side evaluations; {events}\n{}",
        result.method,
        tolerance.unwrap_or_default(),
        stats.steps,
        stats.rejections,
        stats.rhs_evals,
        fewer.unwrap_or_default()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::common_args::SceneArgs;

    struct TestFolder {
        folder: tempfile::TempDir,
        stop: Arc<AtomicBool>,
    }

    impl TestFolder {
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
                    ..SceneArgs::default()
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
    fn a_run_lists_its_files() {
        let test = TestFolder::new();
        let args = RunArgs {
            duration: Some(12.0),
            ..test.args()
        };
        execute(&args, &test.stop).expect("success");
        let report = test.json();
        assert_eq!(report["simulated_s"], 0.012);
        assert_eq!(report["interrupted"], false);
        let size = std::fs::metadata(test.folder.path().join("out.rrd"))
            .expect("saved")
            .len();
        assert_eq!(report["files"][0]["bytes"], size);
    }

    #[test]
    fn an_interrupted_run_keeps_its_results() {
        let test = TestFolder::new();
        test.stop.store(true, std::sync::atomic::Ordering::Relaxed);
        let error = execute(&test.args(), &test.stop).expect_err("interrupted");
        assert_eq!(error.exit_code(), 130);
        assert_eq!(test.json()["interrupted"], true);
    }

    #[test]
    fn a_failure_while_running_has_exit_code_1() {
        let test = TestFolder::new();
        // The viewer does not exist.
        let args = RunArgs {
            connect: Some("rerun+nonsense://".to_owned()),
            ..test.args()
        };
        let error = execute(&args, &test.stop).expect_err("failed");
        assert_eq!(error.exit_code(), 1);
        assert!(!test.folder.path().join("out.json").exists());
    }

    #[test]
    fn bad_input_is_found_before_any_work() {
        let test = TestFolder::new();
        let bad = [
            RunArgs {
                tilt: Some(91.0),
                ..test.args()
            },
            RunArgs {
                tilt: Some(f64::NAN),
                ..test.args()
            },
            RunArgs {
                duration: Some(0.0),
                ..test.args()
            },
            RunArgs {
                scene: SceneArgs {
                    scene: Some("torus".to_owned()),
                    ..SceneArgs::default()
                },
                ..test.args()
            },
            RunArgs {
                npz: Some(PathBuf::from("absent/folder/out.npz")),
                ..test.args()
            },
            RunArgs {
                save: Some(test.folder.path().to_owned()),
                ..test.args()
            },
            RunArgs {
                npz: test.args().json,
                ..test.args()
            },
        ];
        for args in bad {
            let error = execute(&args, &test.stop).expect_err("refused");
            assert_eq!(error.exit_code(), 2, "{error}");
            assert!(!test.folder.path().join("out.rrd").exists());
        }
    }

    #[test]
    fn the_result_contains_the_summary() {
        let scene = Scene::load("chaos-5deg").expect("preset");
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
        let result = RunResult::new(&scene, &summary, None);
        let value = serde_json::to_value(&result).expect("JSON");
        assert_eq!(value["amplitude_m"], 0.69e-6);
        assert_eq!(value["lines"][0]["frequency_hz"], 4117.0);
        assert_eq!(value["lines"][0]["amplitude"], 0.016);
        assert_eq!(value["steps"], 0);
        assert_eq!(value["peak_velocity_m_per_s"], serde_json::Value::Null);
        let text = text(&scene, &result);
        assert!(text.contains("4117.0 Hz"), "{text}");
        assert!(text.contains("amplitude 0.6900 um"), "{text}");
    }

    #[test]
    fn the_default_output_is_a_recording() {
        let none = RunArgs::default();
        assert_eq!(recording(&none).1, Some(Path::new("squeak.rrd")));
        let watched = RunArgs {
            spawn: true,
            ..RunArgs::default()
        };
        assert_eq!(recording(&watched).1, None);
        assert!(output(&watched, None).spawn);
        let json = RunArgs {
            json: Some(PathBuf::from("a.json")),
            ..RunArgs::default()
        };
        assert_eq!(recording(&json).1, None);
        let both = RunArgs {
            save: Some(PathBuf::from("a.rrd")),
            connect: Some("rerun+http://host/proxy".to_owned()),
            ..RunArgs::default()
        };
        assert_eq!(recording(&both).1, Some(Path::new("a.rrd")));
        let expected = Output {
            save: Some(PathBuf::from("a.rrd")),
            connect: both.connect.clone(),
            spawn: false,
        };
        assert_eq!(output(&both, both.save.clone()), expected);
        assert_eq!(shell_word(Path::new("a b.rrd")), "\"a b.rrd\"");
    }
}
