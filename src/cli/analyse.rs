//! `squeakscope analyse`: analyses a signal and classifies its motion, with all outputs.

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::analyse_args::AnalyseArgs;
use super::analyse_files::analyse_all;
use super::console::{command_line, print_viewer_command};
use super::error::CliError;
use super::figures::PIXELS;
use super::harness::{Outputs, Watch};
use super::output::Kind;
use super::resources;
use super::signal::read;
use crate::analysis::{levels::Calibration, stats::range};
use crate::export::{OutputError, replace_file};
use crate::import::{Label, Selection};
use crate::pipeline::message::{SignalInfo, Summary};
use crate::pipeline::{Monitor, SignalSource, drive};
use crate::plot::{figure_names, signal_figures};
use crate::record::{Output, RerunSink};
use crate::scene::RecordSpec;
use crate::study::signal::{
    FREQUENCY_MARGIN, Score, SignalAnalysis, SignalError, SignalOptions, analyse_signal,
    live_analysis, write_events,
};

/// Runs the command.
///
/// # Errors
/// Bad input before any work, or a file that cannot be analysed; failure while drawing or recording; an interrupt.
pub(super) fn execute(args: &AnalyseArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    match &args.files[..] {
        [file] if !file.is_dir() && !args.each_channel => analyse_one(args, file, stop),
        _ => analyse_all(args, stop),
    }
}

/// Analyses a single file, with all outputs.
fn analyse_one(args: &AnalyseArgs, file: &Path, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let mut files = Outputs::new(Some(file.as_os_str()), &args.output)
        .file("--save", Kind::RECORDING, args.save.as_ref())?
        .file("--labels", Kind::LABELS, args.labels.as_ref())?
        .file("--events", Kind::TABLE, args.events.as_ref())?
        .figures(&args.figures, PIXELS, figure_names())?;
    let watch = Watch::new(stop);
    let analysed = analyse(args, file, args.column.clone(), &watch)?;
    let recording = files.path("--save");
    let drawn = files.draw(|| signal_figures(&analysed));
    files.write("--labels", |path| write_labels(path, &analysed))?;
    files.write("--events", |path| write_events(path, [&analysed]))?;
    let mut interrupted = false;
    files.write("--save", |save| {
        let summary = play(file, &analysed, save, (&watch, stop))?;
        interrupted = summary.interrupted;
        Ok::<_, CliError>(())
    })?;
    files.finish(watch, None, &analysed, |_| drawn)?;
    if let Some(recording) = &recording {
        print_viewer_command(recording, &args.output)?;
    }
    if interrupted {
        Err(CliError::Interrupted)
    } else {
        Ok(())
    }
}

/// Reads and analyses a column of a file.
pub(super) fn analyse(
    args: &AnalyseArgs,
    file: &Path,
    column: Option<String>,
    watch: &Watch<'_>,
) -> Result<SignalAnalysis, CliError> {
    let truth = args.truth.as_ref().map(|truth| read_labels(truth, file));
    let truth = truth.transpose()?;
    let signal = read(
        file,
        &Selection {
            column,
            rate: args.rate,
            skip_lines: args.skip_lines,
            from: args.from,
            to: args.to,
            max_samples: Some(args.max_samples),
        },
        watch,
    )?;
    // After the samples are in memory.
    resources::start_thread_pool()?;
    let calibrator = Selection {
        column: args.column.clone(),
        skip_lines: args.skip_lines,
        ..Selection::default()
    };
    let calibration = args.calibration.as_ref();
    let calibration = calibration
        .map(|source| source.calibration(&signal.unit, |path| read(path, &calibrator, watch)))
        .transpose()?;
    let options = options(args, calibration);
    let analysed = analyse_signal(signal, &options, &mut watch.progress());
    let mut analysed = analysed.map_err(|reason| match reason {
        SignalError::Stopped(_) => CliError::NoResult,
        reason => CliError::Signal(file.to_owned(), reason),
    })?;
    analysed.file = Some(file.to_owned());
    analysed.truth = truth.map(|labels| Score::of(analysed.events(), &labels));
    Ok(analysed)
}

/// The labels of a file: those of `truth`, or of the text file with its name in this directory.
fn read_labels(truth: &Path, file: &Path) -> Result<Vec<Label>, CliError> {
    let path = if truth.is_dir() {
        truth
            .join(file.file_stem().unwrap_or_default())
            .with_added_extension("txt")
    } else {
        truth.to_owned()
    };
    let refused = |reason: String| CliError::Input(format!("{}: {reason}", path.display()));
    let text = std::fs::read_to_string(&path).map_err(|error| {
        refused(format!(
            "cannot read the labels ({error}); export them from Audacity, or make an empty file if nothing sounds"
        ))
    })?;
    Label::parse(&text).map_err(|error| refused(error.to_string()))
}

/// Writes the tones as labels.
pub(super) fn write_labels(path: &Path, report: &SignalAnalysis) -> Result<(), OutputError> {
    let text = Label::text_of(report.events(), report.level_reference());
    replace_file(path, |out| out.write_all(text.as_bytes()))
}

/// The options of the analysis.
fn options(args: &AnalyseArgs, calibration: Option<Calibration>) -> SignalOptions {
    SignalOptions {
        lag: args.lag.map(|lag| lag as usize),
        dimension: args.dimension.map(|m| m as usize),
        threshold: args.threshold,
        norm: args.norm.unwrap_or_default(),
        theiler: if args.line_of_identity {
            Some(0)
        } else {
            args.theiler.map(|samples| samples as usize)
        },
        min_diagonal: args.min_diagonal.map(|states| states as usize),
        min_vertical: args.min_vertical.map(|states| states as usize),
        event: args.event.map(|number| number as usize),
        faint: args.faint,
        calibration,
    }
}

/// Sends the signal through the pipeline of a simulation: analyses and recording.
fn play(
    file: &Path,
    report: &SignalAnalysis,
    save: &Path,
    (watch, stop): (&Watch<'_>, &Arc<AtomicBool>),
) -> Result<Summary, CliError> {
    let signal = &report.signal;
    let source = file.file_name().unwrap_or(file.as_os_str());
    let info = SignalInfo {
        source: source.to_string_lossy().into_owned(),
        column: signal.name.clone(),
        unit: signal.unit.clone(),
        start: signal.start,
        span: range(signal.samples.iter().copied()),
        highest_frequency: report.highest_frequency(FREQUENCY_MARGIN),
        events: report.events().to_vec(),
        level_reference: report.level_reference(),
    };
    let analysis = live_analysis(report);
    let playback = SignalSource::new(info, &signal.samples, signal.rate, analysis);
    let output = Output {
        save: Some(save.to_owned()),
        ..Output::default()
    };
    let sink = RerunSink::new(&output, RecordSpec::default());
    let mut sink = sink.map_err(CliError::during("recording"))?;
    let (start, duration) = (signal.start, signal.duration());
    let monitor = Monitor {
        stop,
        progress: &|time| {
            // The run reads `stop` itself.
            let _ = watch.update((time - start) / duration, "recording");
        },
    };
    drive(playback, &command_line(), &mut sink, monitor).map_err(CliError::during("recording"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::tests::parsed;
    use std::f64::consts::TAU;

    /// A folder with a signal file: a sine, from 2 s to 4 s.
    struct TestFolder(tempfile::TempDir);

    impl TestFolder {
        fn new() -> Self {
            let folder = tempfile::tempdir().expect("temporary folder");
            let sample = |k: u32| (TAU * 0.0213 * f64::from(k)).sin();
            let rows =
                (0..2000).map(|k| format!("{:.3},{}\n", 2.0 + 1e-3 * f64::from(k), sample(k)));
            let text = format!("time (s),tone (m)\n{}", rows.collect::<String>());
            std::fs::write(folder.path().join("tone.csv"), text).expect("written");
            Self(folder)
        }

        /// The arguments with JSON; `@` is the folder.
        fn args(&self, line: &str) -> AnalyseArgs {
            let line = format!("{line} --json @/out.json --max-samples 10000");
            parsed(&line.replace('@', &self.0.path().display().to_string()))
        }

        fn run(&self, line: &str) -> Result<(), CliError> {
            execute(&self.args(line), &Arc::default())
        }
    }

    #[test]
    fn several_files_and_a_folder_give_a_table_and_one_json() {
        let test = TestFolder::new();
        let path = |name: &str| test.0.path().join(name);
        std::fs::create_dir(path("more")).expect("made");
        std::fs::copy(path("tone.csv"), path("more/b.csv")).expect("copied");
        std::fs::copy(path("tone.csv"), path("more/a.csv")).expect("copied");
        std::fs::write(path("more/c.bin"), [0, 1, 2, 3]).expect("written");
        std::fs::write(path("empty.csv"), "u\n").expect("written");
        let json = || -> serde_json::Value {
            serde_json::from_slice(&std::fs::read(path("out.json")).expect("written"))
                .expect("JSON")
        };
        test.run("@/more @/tone.csv").expect("success");
        let one = json();
        let files: Vec<_> = one["analyses"].as_array().expect("a list").iter().collect();
        let names = files
            .iter()
            .map(|file| Path::new(file["file"].as_str().expect("a path")));
        let names: Vec<_> = names
            .map(|path| path.file_name().expect("a name"))
            .collect();
        assert_eq!(names, ["a.csv", "b.csv", "tone.csv"]);
        assert_eq!(files[0]["verdict"], files[2]["verdict"]);
        test.run("@/more @/tone.csv --force --jobs 3")
            .expect("success");
        assert_eq!(json(), one);
        // A file that cannot be analysed is named, and the others are still analysed.
        let failed = test
            .run("@/empty.csv @/tone.csv --force")
            .expect_err("one failed");
        assert_eq!(failed.exit_code(), 2, "{failed}");
        assert_eq!(json()["analyses"].as_array().map(Vec::len), Some(1));
        let reason = &json()["failures"][0];
        assert!(
            reason["file"]
                .as_str()
                .expect("a path")
                .ends_with("empty.csv")
        );
        let why = reason["reason"].as_str().expect("a text");
        assert!(why.starts_with("the file contains no sample"), "{why}");
        // An output of a single file, and two files of one name.
        std::fs::copy(path("tone.csv"), path("more/tone.dat")).expect("copied");
        for (output, reason) in [
            ("--save @/out.rrd", "--save"),
            ("--labels @/labels", "would have the same name"),
        ] {
            let line = format!("@/more @/tone.csv --force {output}");
            let refused = test.run(&line).expect_err("refused");
            assert_eq!(refused.exit_code(), 2);
            assert!(refused.to_string().contains(reason), "{refused}");
        }
        // An empty file that is called a signal is no note, but a signal that failed.
        std::fs::write(path("more/none.wav"), "").expect("written");
        test.run("@/more --force").expect_err("one failed");
        let json = json();
        let failed = &json["failures"][0];
        assert!(
            failed["file"]
                .as_str()
                .expect("a path")
                .ends_with("none.wav")
        );
        let why = failed["reason"].as_str().expect("a text");
        assert!(why.starts_with("the file is empty"), "{why}");
        assert_eq!(json["analyses"].as_array().map(Vec::len), Some(3));
    }

    #[test]
    fn what_a_directory_has_is_analysed_or_named() {
        let test = TestFolder::new();
        let path = |name: &str| test.0.path().join(name);
        std::fs::create_dir(path("rig")).expect("made");
        let tone = |k: u32| (TAU * 0.11 * f64::from(k)).sin();
        let rows = |right: &dyn Fn(u32) -> f64| -> String {
            let row = |k| format!("{},{}\n", 0.5 * tone(k), right(k));
            (0..9600).map(row).collect()
        };
        std::fs::write(path("rig/a.csv"), format!("mic,ref\n{}", rows(&|_| 0.0))).expect("written");
        std::fs::write(path("rig/b.csv"), format!("mic,ref\n{}", rows(&tone))).expect("written");
        std::fs::write(path("rig/c.docx"), b"\0\x01\x02").expect("written");
        std::fs::write(path("rig/notes.pdf"), "%PDF\nThe joint was dry.\n").expect("written");
        std::fs::write(path("rig/.a.csv"), "mic,ref\n").expect("written");
        std::fs::create_dir(path("rig/more")).expect("made");
        for (name, labels) in [("a", "0\t2\ttone\n"), ("b", "0\t2\n\\\t100\t200\n")] {
            std::fs::write(path(&format!("rig/{name}.txt")), labels).expect("written");
        }
        let outputs = "--labels @/labels --events @/events.csv --figures @/new/figures";
        let line = format!("@/rig --each-channel --rate 8000 --truth @/rig {outputs}");
        test.run(&line).expect("success");
        let json = std::fs::read(path("out.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
        let skipped = json["skipped"].as_array().expect("a list");
        let name = |file: &serde_json::Value| {
            let path = Path::new(file["file"].as_str().expect("a path"));
            path.file_name().expect("a name").to_owned()
        };
        let names: Vec<_> = skipped.iter().map(name).collect();
        let expected = [".a.csv", "a.txt", "b.txt", "c.docx", "more", "notes.pdf"];
        assert_eq!(names, expected);
        // A silent channel is a result.
        let kinds = |k: usize| json["analyses"][k]["verdict"]["regime"].as_str();
        assert_eq!(kinds(1), Some("silent"));
        assert_ne!(kinds(0), Some("silent"));
        // The tone of 880 Hz sounds in three channels, and one label of each file lies elsewhere.
        let truth: Vec<_> = (0..4)
            .map(|k| json["analyses"][k]["truth"].clone())
            .collect();
        let counts = truth.iter().map(|score| {
            let missed = score["missed"].as_array().expect("a list").len();
            (
                score["found"].as_u64(),
                score["false"].as_array().expect("a list").len(),
                missed,
            )
        });
        let expected = [
            (Some(1), 0, 0),
            (Some(0), 0, 1),
            (Some(0), 1, 1),
            (Some(0), 1, 1),
        ];
        assert_eq!(counts.collect::<Vec<_>>(), expected);
        let all = serde_json::json!({"found": 1, "false": 2, "missed": 3});
        assert_eq!(json["truth"], all);
        let events = std::fs::read_to_string(path("events.csv")).expect("written");
        let rows: Vec<_> = events.lines().skip(1).collect();
        assert_eq!(rows.len(), 3, "{events}");
        assert!(rows[2].contains("b.csv,ref,1,"), "{events}");
        assert!(
            path("labels/b-ref.txt").is_file() && path("new/figures/a-ref/waveform.png").is_file()
        );
    }

    #[test]
    fn an_interrupted_analysis_leaves_nothing() {
        let (test, stop) = (TestFolder::new(), Arc::new(AtomicBool::new(true)));
        let args = test.args("@/tone.csv --save @/out.rrd --figures @/new/figures");
        let error = execute(&args, &stop).expect_err("interrupted");
        assert_eq!(error.exit_code(), 130);
        // Only the signal file.
        assert_eq!(std::fs::read_dir(test.0.path()).expect("there").count(), 1);
    }

    #[test]
    fn outputs_are_checked_before_the_file_is_read() {
        let test = TestFolder::new();
        let file = test.0.path().join("tone.csv");
        // Not a valid signal either, but the outputs are checked first.
        std::fs::write(&file, "sound").expect("written");
        for line in [
            "--events @/tone.csv",
            "--figures @/tone.csv",
            "--save @/out.json",
            "--labels @/out.rrd",
        ] {
            let error = test
                .run(&format!("@/tone.csv {line}"))
                .expect_err("refused");
            assert!(matches!(error, CliError::Input(_)), "{error}");
            assert_eq!(error.exit_code(), 2, "{error}");
        }
        assert_eq!(std::fs::read(&file).expect("there"), b"sound");
    }
}
