//! `squeakscope run`: simulate a scene and record it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use schemars::JsonSchema;
use serde::Serialize;

use super::args::RunArgs;
use super::audit::{self, Audit};
use super::console;
use super::error::{Cause, CliError};
use super::figures::PIXELS;
use super::harness::{Outputs, Watch};
use super::interrupt;
use super::output::Kind;
use super::resources::start_thread_pool;
use crate::chain_of_causes;
use crate::escape;
use crate::export::SamplesSink;
use crate::number::significant;
use crate::pipeline::message::{Exponents, SpectralLine, Summary, TrajectoryDivergence};
use crate::pipeline::{Monitor, PipelineError, Simulation, Sink, Source as _, Tee, drive};
use crate::plot::{RUN_FIGURES, RunFigures};
use crate::record::{RERUN_VERSION, RerunSink};
use crate::report::{Block, Measured, Report, Table};
use crate::scene::{Integrator, Scene};
use crate::sound::WavSink;
use crate::study::lyapunov::Classified;

/// The recording, if no output is given.
const DEFAULT_RECORDING: &str = "squeak.rrd";

/// The result of a run.
#[derive(Serialize, JsonSchema)]
pub(super) struct RunResult<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// Lyapunov exponents; `null` if the scene does not compute them or the run has not settled.
    exponents: Option<Classified<&'a Exponents>>,
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
    /// Whether the scene has a joint.
    #[serde(skip)]
    is_joint: bool,
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
            is_joint: scene.joint().is_ok(),
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

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running; an interrupt, after the results are written.
pub(super) fn execute(args: &RunArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let numbers = [
        ("load.tilt_deg", args.tilt),
        ("time.duration_ms", args.duration),
    ];
    let scene = args.scene.load_with(args.accuracy, &numbers)?;
    let scene = args.budget.apply(scene)?;
    console::print_warnings(&scene.warnings());
    audit::check_scene(&scene, args.strict)?;
    let (recording, saved) = recording(args);
    let files = Outputs::new(args.scene.input(), &args.output)
        .file("--save", recording, saved)?
        .file("--npz", Kind::ARRAYS, args.npz.as_ref())?
        .file("--wav", Kind::SOUND, args.audio.wav.as_ref())?
        .figures(&args.figures, PIXELS, RUN_FIGURES)?;
    let watch = Watch::new(stop);
    let mut figures = args.figures.path.is_some().then(RunFigures::default);
    let simulated = simulate(args, &scene, (&files, figures.as_mut()), stop, &watch);
    let (summary, audio) = simulated.map_err(CliError::during("run"))?;
    let result = RunResult::new(&scene, &summary, audio);
    let saved = files.path("--save");
    let ended = files.finish(watch, Some(&scene.name), &result, |files| {
        ["--save", "--npz", "--wav"]
            .into_iter()
            .try_for_each(|option| files.write(option, |_| Ok::<_, CliError>(())))?;
        files.draw(|| figures.as_mut().map_or(Vec::new(), RunFigures::figures))
    });
    if let Some(recording) = saved.filter(|_| matches!(ended, Ok(()) | Err(CliError::Interrupted)))
    {
        print_viewer_command(&recording)?;
    }
    if summary.interrupted {
        audit::check(&summary, false).and(ended)
    } else {
        ended.and_then(|()| audit::check(&summary, args.strict))
    }
}

/// Runs the pipeline: simulation, analyses, recording. Returns the summary, and a description of the sound
/// file.
fn simulate(
    args: &RunArgs,
    scene: &Scene,
    (files, figures): (&Outputs<'_>, Option<&mut RunFigures>),
    stop: &Arc<AtomicBool>,
    watch: &Watch<'_>,
) -> Result<(Summary, Option<String>), Cause> {
    let command = command_line();
    // An invalid scene fails here, before a file is opened.
    let simulation = Simulation::new(scene)?;
    start_thread_pool()?;
    interrupt::start_work();
    let mut sinks: Vec<Box<dyn Sink + '_>> = Vec::new();
    sinks.extend(figures.map(|figures| -> Box<dyn Sink + '_> { Box::new(figures) }));
    // The recording is the last sink, so it gets its final name only after the samples.
    if let Some(path) = files.path("--npz") {
        sinks.push(Box::new(SamplesSink::new(path)));
    }
    let mut audio = None;
    if let Some(path) = files.path("--wav") {
        let header = simulation.header(&command);
        let sink = WavSink::new(path, args.audio.source(), &header, args.time_stretch)?;
        audio = Some((sink.description(), sink.loudest()));
        sinks.push(Box::new(sink));
    }
    let mut part = None;
    let notify = watch.notifier();
    if let Some(output) = args.viewer.output(files.path("--save")) {
        let recording = RerunSink::new(&output, scene.record)?;
        part = recording.part().map(Path::to_owned);
        sinks.push(Box::new(recording.with_notice(notify.clone())));
    }
    let monitor = Monitor {
        stop,
        progress: &|time| {
            // The run reads `stop` itself.
            let _ = watch.update(time / scene.duration, "simulating");
        },
    };
    let done = drive(simulation, &command, &mut Tee::new(sinks), monitor);
    let summary = done.inspect_err(|fault| {
        if let Some(part) = part {
            report_partial_recording(&part, fault, notify);
        }
    })?;
    let audio = audio.and_then(|(description, peak)| {
        let peak = peak.get()?;
        Some(format!("{description}; peak {peak}"))
    });
    Ok((summary, audio))
}

/// The file for the recording: the default file, which is replaced, if there is no other output.
fn recording(args: &RunArgs) -> (Kind, Option<&Path>) {
    let files = [
        &args.npz,
        &args.audio.wav,
        &args.output.json,
        &args.figures.path,
    ];
    let other = args.viewer.output(None).is_some() || files.into_iter().any(Option::is_some);
    match &args.save {
        None if !other => (Kind::DEFAULT_RECORDING, Some(Path::new(DEFAULT_RECORDING))),
        save => (Kind::RECORDING, save.as_deref()),
    }
}

/// Reports the path of a partial recording, unless the error names it.
fn report_partial_recording(part: &Path, fault: &PipelineError, notify: impl Fn(&str)) {
    let has_data = std::fs::metadata(part).is_ok_and(|metadata| metadata.len() > 0);
    let path = part.display().to_string();
    let is_named = chain_of_causes(fault).contains(&path);
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
    console::print(&text)
}

/// A path as one word of a shell command.
fn shell_word(path: &Path) -> String {
    let path = escape::path(path);
    if path.contains(char::is_whitespace) {
        format!("\"{path}\"")
    } else {
        path
    }
}

impl Report for RunResult<'_> {
    fn blocks(&self, scene: &str) -> Vec<Block> {
        let summary = self.summary;
        let rest = format!(
            ": {:.1} ms simulated in {:.2} s (simulation alone: {:.2} x real time)",
            summary.simulated_s * 1e3,
            summary.wall_s,
            summary.real_time_factor,
        );
        let place = if self.is_joint {
            " at the central contact point"
        } else {
            ""
        };
        let mut blocks = vec![
            Block::heading(scene, rest),
            Block::text(format!(
                "amplitude {:.4} um, peak velocity {:.3} mm/s{place}",
                summary.amplitude_m * 1e6,
                summary.peak_velocity_m_per_s * 1e3
            )),
        ];
        if let Some(motion) = summary.describe_motion() {
            blocks.push(Block::text(format!("type of motion: {motion}")));
        }
        if !summary.at_rest {
            blocks.push(lines(&summary.lines));
        }
        blocks.extend(self.integration());
        if let Some(exponents) = &self.exponents {
            blocks.push(Block::text(exponents.line()));
        }
        if let Some(divergence) = &summary.divergence {
            blocks.push(divergence_line(divergence));
        }
        let passed = summary.stats.steps_without_event_location;
        if passed > 0 {
            blocks.push(Block::Warning(format!(
                "{passed} steps passed contact events without locating them, because the events were too frequent"
            )));
        }
        if let Some(audio) = &self.audio {
            blocks.push(Block::text(format!("sound: {audio}")));
        }
        if !summary.facts.is_empty() {
            blocks.push(Block::heading("lesson", ""));
        }
        let facts = summary.facts.iter().map(|fact| Block::Text(fact.line()));
        blocks.extend(facts);
        blocks
    }

    fn is_interrupted(&self) -> bool {
        self.summary.interrupted
    }
}

/// The strongest lines of the spectrum. The recording has all of them.
fn lines(lines: &[SpectralLine]) -> Block {
    const MAX_LINES: usize = 6;
    if lines.is_empty() {
        return Block::text("no lines in the spectrum");
    }
    Table::of(lines.iter().take(MAX_LINES))
        .right("", |line| format!("{:.1} Hz", line.frequency))
        .right("", |line| format!("{:.4} mm/s", line.amplitude * 1e3))
        .left("", |line| line.label.clone())
        .into()
}

/// The divergence of the perturbed trajectory.
fn divergence_line(divergence: &TrajectoryDivergence) -> Block {
    let rate = divergence.line.map(|line| {
        let rate =
            |sign: f64| Measured::new(sign * line.rate_per_s, line.half_width_per_s).unit("1/s");
        if line.grows() {
            format!(", growing at {}", rate(1.0))
        } else if line.shrinks() {
            format!(", shrinking at {}", rate(-1.0))
        } else {
            format!(", no significant growth ({})", rate(1.0))
        }
    });
    let saturation = match divergence.saturated_s {
        Some(time) => format!("saturated at {:.0} ms", 1e3 * time),
        None => "not saturated".to_owned(),
    };
    Block::text(format!(
        "perturbed trajectory, started at {:.0} ms: relative distance {:.1e}{}, {saturation}",
        1e3 * divergence.start_s,
        divergence.distance,
        rate.unwrap_or_default()
    ))
}

impl RunResult<'_> {
    /// The integrator, its statistics and the energy residual.
    fn integration(&self) -> Vec<Block> {
        let Summary {
            stats, transitions, ..
        } = self.summary;
        let events = match (self.is_joint, self.summary.energy_residual) {
            (false, _) => format!("{transitions} events"),
            (true, Some(residual)) => {
                format!(
                    "{transitions} contact transitions; relative energy residual {residual:.1e}"
                )
            }
            (true, None) => format!("{transitions} contact transitions; no energy audit"),
        };
        let tolerance = self.tolerance;
        let tolerance = tolerance.map_or(String::new(), |tolerance| {
            format!(", tolerance {tolerance:e}")
        });
        let mut blocks = vec![Block::text(format!(
            "{}{tolerance}: {} steps, {} rejected, {} right-hand-side evaluations; {events}",
            self.method, stats.steps, stats.rejections, stats.rhs_evals,
        ))];
        if let Some(rate) = self.summary.analysis_rate.filter(|rate| *rate < 1.0) {
            let percent = significant(100.0 * rate, 2);
            blocks.push(Block::text(format!(
                "analyses at {percent} % of their rate, to keep up with real time"
            )));
        }
        blocks
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::cli::tests::parsed;
    use crate::pipeline::message::DivergenceFit;
    use crate::record::Output;

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

        /// Runs the mass on a belt with a recording and JSON; `@` is the folder.
        fn run(&self, line: &str) -> Result<(), CliError> {
            self.run_scene(&format!(
                "mass-on-belt --save @/out.rrd --json @/out.json {line}"
            ))
        }

        fn run_scene(&self, line: &str) -> Result<(), CliError> {
            let folder = self.folder.path().display().to_string();
            execute(&parsed(&line.replace('@', &folder)), &self.stop)
        }

        fn json(&self) -> serde_json::Value {
            let text = std::fs::read(self.folder.path().join("out.json")).expect("written");
            serde_json::from_slice(&text).expect("JSON")
        }
    }

    /// The figures of a run: those of its analyses, and of its lesson.
    #[test]
    fn a_run_draws_its_pictures() {
        let test = TestFolder::new();
        test.run("--duration 2000 --figures @/figures")
            .expect("success");
        let names = std::fs::read_dir(test.folder.path().join("figures")).expect("made");
        let mut names: Vec<_> = names
            .map(|entry| {
                entry
                    .expect("readable")
                    .file_name()
                    .into_string()
                    .expect("text")
            })
            .collect();
        names.sort();
        for name in [
            "portrait.png",
            "return-times.png",
            "section.png",
            "spectrum.png",
        ] {
            assert!(names.iter().any(|found| found == name), "{name}: {names:?}");
        }
        let files = test.json()["files"].as_array().expect("a list").len();
        assert_eq!(files, names.len() + 1, "the recording, too");
    }

    #[test]
    fn a_run_lists_its_files() {
        let test = TestFolder::new();
        test.run("--duration 12").expect("success");
        let report = test.json();
        assert_eq!(report["simulated_s"], 0.012);
        assert_eq!(report["interrupted"], false);
        let size = std::fs::metadata(test.folder.path().join("out.rrd"))
            .expect("saved")
            .len();
        assert_eq!(report["files"][0]["bytes"], size);
    }

    #[test]
    fn a_run_reports_the_facts_of_its_lesson() {
        let test = TestFolder::new();
        test.run_scene("negative-slope --duration 100 --json @/out.json")
            .expect("success");
        let report = test.json();
        let facts = report["facts"].as_array().expect("a list");
        let fact = |name| facts.iter().find(|fact| fact["name"] == name);
        let claim = fact("vibration").expect("a claim");
        assert_eq!(claim["measured"], "grows");
        assert_eq!(claim["agrees"], true);
        let rate = fact("growth rate, while small").expect("a rate");
        let [predicted, measured] = ["predicted", "measured"].map(|key| rate[key].as_f64());
        let ratio = measured.expect("a number") / predicted.expect("a number");
        assert!((ratio - 1.0).abs() < 0.01, "{rate}");
        assert_eq!(rate["unit"], "1/s");
        // A scene without a mechanism has no lesson.
        test.run_scene("impact-oscillator --duration 10 --force --json @/out.json")
            .expect("success");
        assert_eq!(test.json()["facts"], serde_json::json!([]));
    }

    #[test]
    fn an_interrupted_run_keeps_its_results() {
        let test = TestFolder::new();
        test.stop.store(true, std::sync::atomic::Ordering::Relaxed);
        let error = test.run("").expect_err("interrupted");
        assert_eq!(error.exit_code(), 130);
        assert_eq!(test.json()["interrupted"], true);
    }

    #[test]
    fn a_failure_while_running_has_exit_code_1() {
        let test = TestFolder::new();
        // The viewer does not exist.
        let mut args: RunArgs = parsed("mass-on-belt");
        args.viewer.connect = Some("rerun+nonsense://".to_owned());
        let error = execute(&args, &test.stop).expect_err("failed");
        assert_eq!(error.exit_code(), 1);
        assert!(!test.folder.path().join("out.json").exists());
    }

    #[test]
    fn bad_input_is_found_before_any_work() {
        let test = TestFolder::new();
        let outputs = "--save @/out.rrd --json @/out.json";
        for line in [
            format!("mass-on-belt {outputs} --tilt 91"),
            format!("mass-on-belt {outputs} --tilt NaN"),
            format!("mass-on-belt {outputs} --duration 0"),
            format!("torus {outputs}"),
            format!("mass-on-belt {outputs} --npz absent/folder/out.npz"),
            "mass-on-belt --save @".to_owned(),
            "mass-on-belt --npz @/out.npz --json @/out.npz".to_owned(),
        ] {
            let error = test.run_scene(&line).expect_err(&line);
            assert_eq!(error.exit_code(), 2, "{error}");
            assert!(!test.folder.path().join("out.rrd").exists());
        }
    }

    #[test]
    fn the_result_contains_the_summary() {
        let scene = Scene::load("chaos-5deg").expect("preset");
        let summary = Summary {
            simulated_s: 0.1,
            amplitude_m: 0.69e-6,
            peak_velocity_m_per_s: f64::NAN,
            lines: vec![SpectralLine {
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
        let text = crate::report::markdown(&result.blocks(&scene.name));
        assert!(text.contains("4117.0 Hz"), "{text}");
        assert!(text.contains("amplitude 0.6900 um"), "{text}");
    }

    #[test]
    fn the_default_output_is_a_recording() {
        let saved = |line: &str| recording(&parsed(line)).1.map(Path::to_owned);
        assert_eq!(saved(""), Some(PathBuf::from("squeak.rrd")));
        assert_eq!(saved("--spawn"), None);
        let output = |line: &str| parsed::<RunArgs>(line).viewer.output(saved(line)).unwrap();
        assert!(output("--spawn").spawn);
        assert_eq!(saved("--json a.json"), None);
        let both = "--save a.rrd --connect rerun+http://host/proxy";
        assert_eq!(saved(both), Some(PathBuf::from("a.rrd")));
        let expected = Output {
            save: Some(PathBuf::from("a.rrd")),
            connect: Some("rerun+http://host/proxy".to_owned()),
            spawn: false,
        };
        assert_eq!(output(both), expected);
        assert_eq!(shell_word(Path::new("a b.rrd")), "\"a b.rrd\"");
    }

    #[test]
    fn divergence_is_printed_in_a_line() {
        let line = |divergence: &TrajectoryDivergence| {
            crate::report::markdown(&[divergence_line(divergence)])
        };
        let mut divergence = TrajectoryDivergence {
            time_s: 0.2,
            start_s: 0.05,
            distance: 2e-3,
            line: None,
            saturated_s: None,
        };
        assert_eq!(
            line(&divergence),
            "perturbed trajectory, started at 50 ms: relative distance 2.0e-3, not saturated\n"
        );
        divergence.line = Some(DivergenceFit {
            rate_per_s: 70.0,
            half_width_per_s: 5.0,
            since_s: 0.06,
            intercept: 0.0,
        });
        divergence.saturated_s = Some(0.18);
        let text = line(&divergence);
        assert!(text.ends_with("growing at 70.0 ± 5.0 1/s, saturated at 180 ms\n"));
        divergence.line = divergence.line.map(|line| DivergenceFit {
            rate_per_s: 3.0,
            ..line
        });
        let text = line(&divergence);
        assert!(
            text.contains("no significant growth (3.0 ± 5.0 1/s)"),
            "{text}"
        );
    }
}
