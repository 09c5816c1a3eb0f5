//! `squeakscope run`: simulate a scene and record it.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::args::RunArgs;
use super::audit;
use super::console::{self, command_line, print_viewer_command};
use super::error::{Cause, CliError};
use super::figures::PIXELS;
use super::harness::{Outputs, Watch};
use super::interrupt;
use super::output::Kind;
use super::resources::start_thread_pool;
use crate::chain_of_causes;
use crate::export::SamplesSink;
use crate::pipeline::message::Summary;
use crate::pipeline::{
    Monitor, PipelineError, RunResult, Simulation, Sink, Source as _, Tee, drive,
};
use crate::plot::figure_names;
use crate::record::{RerunSink, RunFigures};
use crate::scene::Scene;
use crate::sound::WavSink;

/// The recording, if no output is given.
const DEFAULT_RECORDING: &str = "squeak.rrd";

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
        .figures(&args.figures, PIXELS, figure_names())?;
    let watch = Watch::new(stop);
    let figures = args.figures.path.as_ref();
    let mut figures = figures.map(|_| RunFigures::new(scene.record));
    let simulated = simulate(args, &scene, (&files, figures.as_mut()), stop, &watch);
    let (summary, audio) = simulated.map_err(CliError::during("run"))?;
    let result = RunResult::new(&scene, &summary, audio);
    let saved = files.path("--save");
    let ended = files.finish(watch, Some(&scene.name), &result, |files| {
        ["--save", "--npz", "--wav"]
            .into_iter()
            .try_for_each(|option| files.write(option, |_| Ok::<_, CliError>(())))?;
        files.draw(|| figures.as_ref().map_or(Vec::new(), RunFigures::figures))
    });
    if let Some(recording) = saved.filter(|_| matches!(ended, Ok(()) | Err(CliError::Interrupted)))
    {
        print_viewer_command(&recording, &args.output)?;
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

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::cli::tests::parsed;
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
            "displacement.png",
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
        assert_eq!(claim["measured"], "growth");
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
    }
}
