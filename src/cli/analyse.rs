//! `squeakscope analyse`: analyses signals and classifies their motion; of several, a table over the signals and one JSON
//! document.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::analyse_args::AnalyseArgs;
use super::console::print_notice;
use super::error::CliError;
use super::figures::PIXELS;
use super::harness::{Files, Outputs, Watch};
use super::output::{Kind, check_file};
use super::resources;
use super::run::{command_line, print_viewer_command};
use super::signal::read;
use crate::analysis::{
    events::TonalEvent,
    levels::{Calibration, LevelReference},
    stats::range,
};
use crate::escape;
use crate::export::{OutputError, replace_file};
use crate::import::{Format, Selection, channels};
use crate::number::fixed;
use crate::pipeline::message::{SignalInfo, Summary};
use crate::pipeline::{Monitor, SignalSource, drive};
use crate::plot::{signal_figure_names, signal_figures};
use crate::record::{Output, RerunSink};
use crate::report::{Block, Report, Table};
use crate::scene::RecordSpec;
use crate::study::signal::{
    FREQUENCY_MARGIN, Label, Score, SignalAnalysis, SignalError, SignalOptions, analyse_signal,
    live_analysis, write_events,
};

/// The analyses of several files.
#[derive(Default, Serialize, JsonSchema)]
pub(super) struct AnalysedFiles {
    /// Analyses in the order of the files; those of a directory are sorted by name.
    analyses: Vec<SignalAnalysis>,
    /// Failures: files that could not be analysed.
    failures: Vec<FailedFile>,
    /// Skipped: files in a directory that are no signals.
    skipped: Vec<FailedFile>,
    /// Whether each channel of a file is a signal of its own.
    #[serde(skip)]
    each_channel: bool,
}

/// A file that was not analysed.
#[derive(Serialize, JsonSchema)]
struct FailedFile {
    /// Path of the file.
    file: PathBuf,
    /// Reason why it was not analysed.
    reason: String,
}

/// A file, and its column (`None`: that of the arguments) or why its channels cannot be listed.
type Job = (PathBuf, Result<Option<String>, CliError>);

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
    let outputs = Outputs::new(Some(file.as_os_str()), &args.output)
        .file("--save", Kind::RECORDING, args.save.as_ref())
        .file("--labels", Kind::LABELS, args.labels.as_ref())
        .file("--events", Kind::TABLE, args.events.as_ref());
    let outputs = outputs.figures(&args.figures, PIXELS, signal_figure_names());
    let mut files = outputs.check()?;
    let watch = Watch::new(stop);
    let analysed = analyse(args, file, args.column.clone(), &watch)?;
    let recording = files.path("--save");
    let drawn = files.draw(|| signal_figures(&analysed));
    files.write("--labels", |path| write_labels(path, &analysed))?;
    files.write("--events", |path| write_table(path, [&analysed]))?;
    let mut interrupted = false;
    files.write("--save", |save| {
        let summary = play(file, &analysed, save, (&watch, stop))?;
        interrupted = summary.interrupted;
        Ok::<_, CliError>(())
    })?;
    files.finish(watch, None, &analysed, |_| drawn)?;
    if let Some(recording) = &recording {
        print_viewer_command(recording)?;
    }
    if interrupted {
        Err(CliError::Interrupted)
    } else {
        Ok(())
    }
}

/// Analyses several files or channels.
fn analyse_all(args: &AnalyseArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let save = args.save.as_ref().map(|_| "--save");
    if let Some(option) = save.or(args.event.map(|_| "--event")) {
        return Err(CliError::Input(format!(
            "{option} is for a single signal; analyse the signals one by one, or omit it"
        )));
    }
    let mut result = AnalysedFiles {
        each_channel: args.each_channel,
        ..AnalysedFiles::default()
    };
    let jobs = jobs(args, &mut result.skipped)?;
    let outputs = Outputs::new(None, &args.output);
    let mut files = outputs
        .file("--events", Kind::TABLE, args.events.as_ref())
        .check()?;
    check_directories(args, &jobs)?;
    resources::start_thread_pool()?;
    let watch = Watch::new(stop);
    let at_once = args.jobs.map_or(1, |jobs| jobs.get());
    let mut jobs = jobs.into_iter().peekable();
    while jobs.peek().is_some() {
        let group: Vec<_> = jobs.by_ref().take(at_once).collect();
        let analysed = group.into_par_iter().map(|job| {
            let name = name(&job);
            let (file, column) = job;
            let analysed = column.and_then(|column| analyse(args, &file, column, &watch));
            (file, name, analysed)
        });
        for (file, name, analysed) in analysed.collect::<Vec<_>>() {
            match analysed {
                Err(CliError::NoResult) => return Err(CliError::NoResult),
                Ok(mut analysed) => {
                    write_pictures(args, &name, &analysed, &mut files)?;
                    analysed.signal.samples = Vec::new();
                    analysed.part = None;
                    analysed.spectrogram = Vec::new();
                    result.analyses.push(analysed);
                }
                Err(error) => {
                    let reason = reason(&error);
                    result.failures.push(FailedFile { file, reason });
                }
            }
        }
    }
    let all = result.analyses.len() + result.failures.len();
    files.finish(watch, None, &result, |files| {
        files.write("--events", |path| write_table(path, &result.analyses))
    })?;
    match result.failures.len() {
        0 => Ok(()),
        failed => Err(CliError::Input(format!(
            "{failed} of {all} signals could not be analysed; the table has the reasons"
        ))),
    }
}

/// The signals, with the error of a file whose channels cannot be listed.
fn jobs(args: &AnalyseArgs, skipped: &mut Vec<FailedFile>) -> Result<Vec<Job>, CliError> {
    let files = files(&args.files, skipped)?;
    if files.len() > 1 && args.truth.as_ref().is_some_and(|truth| !truth.is_dir()) {
        return Err(CliError::Input(
            "--truth is a directory for several files, with the labels NAME.txt of each file NAME"
                .to_owned(),
        ));
    }
    let mut jobs: Vec<Job> = Vec::new();
    for file in files {
        // A recording has a main column.
        if !args.each_channel || Format::of(&file).is_ok_and(|format| format == Format::Rrd) {
            jobs.push((file, Ok(args.column.clone())));
            continue;
        }
        match channels(&file, args.skip_lines) {
            Ok(names) => jobs.extend(names.into_iter().map(|name| (file.clone(), Ok(Some(name))))),
            Err(error) => jobs.push((file, Err(error.into()))),
        }
    }
    Ok(jobs)
}

/// Name of a signal for its figures and labels.
fn name((file, column): &Job) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let column = match column {
        Ok(Some(column)) => format!("-{column}"),
        _ => String::new(),
    };
    // A name of a column may be no name of a file.
    format!("{stem}{column}").replace(|c: char| std::path::is_separator(c) || c == ':', "_")
}

/// Checks that the figures and labels of all signals can be written.
fn check_directories(args: &AnalyseArgs, jobs: &[Job]) -> Result<(), CliError> {
    if args.labels.is_none() && args.figures.path.is_none() {
        return Ok(());
    }
    let mut named = BTreeMap::new();
    for job in jobs {
        if let Some(other) = named.insert(name(job), job) {
            return Err(CliError::Input(format!(
                "figures and labels of {} and {} would have the same name; rename one, or analyse them one by one",
                other.0.display(),
                job.0.display()
            )));
        }
    }
    let overwrite = args.output.overwrite;
    if let Some(directory) = &args.figures.path {
        let names = args
            .figures
            .drawn
            .or_formats(PIXELS)
            .names(&signal_figure_names());
        for name in named.keys() {
            overwrite.check_directory(&directory.join(name), "--figures", &names)?;
        }
    }
    if let Some(directory) = &args.labels {
        let names: Vec<_> = named.keys().map(|name| format!("{name}.txt")).collect();
        overwrite.check_directory(directory, "--labels", &names)?;
    }
    Ok(())
}

/// Writes the figures and labels of one of several signals.
fn write_pictures(
    args: &AnalyseArgs,
    name: &str,
    report: &SignalAnalysis,
    files: &mut Files<'_>,
) -> Result<(), CliError> {
    if let Some(directory) = &args.figures.path {
        let figures = signal_figures(report);
        let drawn = args.figures.drawn.or_formats(PIXELS);
        for path in drawn.write(&directory.join(name), "--figures", &figures, None)? {
            files.add(&path)?;
        }
    }
    if let Some(directory) = &args.labels {
        std::fs::create_dir_all(directory).map_err(|error| {
            CliError::Failed(format!("cannot create {} ({error})", directory.display()))
        })?;
        let path = check_file(&directory.join(format!("{name}.txt")), "--labels")?;
        write_labels(&path, report)?;
        files.add(&path)?;
    }
    Ok(())
}

/// The files, with those in a directory whose format is known; the others are `skipped`, with the reason.
fn files(given: &[PathBuf], skipped: &mut Vec<FailedFile>) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    for path in given {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let directory = path.display();
        let unreadable = |source: io::Error| {
            CliError::Input(format!(
                "cannot read the directory `{directory}` ({source}); check its permissions"
            ))
        };
        let entries = std::fs::read_dir(path).map_err(unreadable)?;
        let entries = entries.map(|entry| entry.map(|entry| entry.path()));
        let mut inside = entries
            .collect::<io::Result<Vec<_>>>()
            .map_err(unreadable)?;
        inside.retain(|entry| entry.is_file());
        inside.sort();
        let before = files.len();
        for entry in &inside {
            let is_text = |path: &Path| path.extension().is_some_and(|ending| ending == "txt");
            let recording = |other: &&PathBuf| {
                !is_text(other)
                    && other.file_stem() == entry.file_stem()
                    && Format::of(other).is_ok()
            };
            let recording = inside.iter().find(recording).filter(|_| is_text(entry));
            let reason = match (recording, Format::of(entry)) {
                (Some(recording), _) => format!("labels of {}", recording.display()),
                (None, Ok(_)) => {
                    files.push(entry.clone());
                    continue;
                }
                (None, Err(problem)) => problem.to_string(),
            };
            print_notice(&format!("{} is not analysed: {reason}", entry.display()));
            skipped.push(FailedFile {
                file: entry.clone(),
                reason,
            });
        }
        if files.len() == before {
            return Err(CliError::Input(format!(
                "the directory `{directory}` has no file of a known format; give the path of a signal"
            )));
        }
    }
    Ok(files)
}

/// Why a file could not be analysed, without its path, which stands beside the reason.
fn reason(error: &CliError) -> String {
    match error {
        CliError::Import(error) => error.problem.to_string(),
        CliError::Signal { reason, .. } => reason.to_string(),
        _ => error.to_string(),
    }
}

/// Reads and analyses a column of a file.
fn analyse(
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
    let progress = &mut |share: f64, task: &str| watch.update(share, task);
    let analysed = analyse_signal(signal, &options, progress);
    let mut analysed = analysed.map_err(|reason| match reason {
        SignalError::Stopped(_) => CliError::NoResult,
        reason => CliError::Signal {
            path: file.to_owned(),
            reason,
        },
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

/// Writes the tonal events as labels.
fn write_labels(path: &Path, report: &SignalAnalysis) -> Result<(), OutputError> {
    let text = label_text(report.events(), report.level_reference());
    replace_file(path, |out| out.write_all(text.as_bytes()))
}

/// Writes the tonal events of files as a table.
fn write_table<'a>(
    path: &Path,
    analysed: impl IntoIterator<Item = &'a SignalAnalysis>,
) -> Result<(), CliError> {
    write_events(path, analysed).map_err(CliError::during("writing of the table"))
}

/// Tonal events as labels of Audacity: a line with start, end, frequency and level, and a line with the range of frequencies.
fn label_text(events: &[TonalEvent], reference: LevelReference) -> String {
    let mut text = String::new();
    for (number, event) in (1..).zip(events) {
        let TonalEvent {
            start_s,
            end_s,
            frequency_hz,
            frequency_low_hz,
            frequency_high_hz,
            level_db,
            kind,
            ..
        } = event;
        let _ = writeln!(
            text,
            "{start_s:.6}\t{end_s:.6}\t{number}: {kind}, {frequency_hz:.1} Hz, {level_db:.1} {reference}\n\\\t{frequency_low_hz:.6}\t{frequency_high_hz:.6}"
        );
    }
    text
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
    let source = source.to_string_lossy().into_owned();
    let title = format!(
        "{source}, {}: {} samples at {} Hz",
        signal.name,
        signal.samples.len(),
        signal.rate
    );
    let info = SignalInfo {
        source,
        column: signal.name.clone(),
        unit: signal.unit.clone(),
        start: signal.start,
        span: range(signal.samples.iter().copied()),
        highest_frequency: report.highest_frequency(FREQUENCY_MARGIN),
        events: report.events().to_vec(),
        level_reference: report.level_reference(),
    };
    let analysis = live_analysis(report);
    let playback = SignalSource::new(title, info, &signal.samples, signal.rate, analysis);
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

impl Report for AnalysedFiles {
    /// The signals, one per row, then those that failed, and how many events have labels.
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let scores = || self.analyses.iter().filter_map(|file| file.truth.as_ref());
        let analyses = self.analyses.iter().map(Ok);
        let table = Table::of(analyses.chain(self.failures.iter().map(Err)))
            .left("file", |row| match row {
                Ok(file) => file.file.as_deref().map(escape::path),
                Err(failed) => Some(escape::path(&failed.file)),
            })
            .left("channel", |row| {
                let file = row.ok().filter(|_| self.each_channel)?;
                Some(escape::line(&file.facts.name).into_owned())
            })
            .right("duration, s", |row| {
                fixed(row.ok().map(|file| file.facts.duration_s), 3)
            })
            .right("dB(A)", |row| {
                let levels = row.ok()?.sound_levels.as_ref();
                levels.map(|found| fixed(found.levels.a_weighted_level_db, 1))
            })
            .right("events", |row| {
                row.ok().map(|file| file.events().len().to_string())
            })
            .right("event, Hz", |row| {
                let event = row.ok()?.event();
                event.map(|event| fixed(event.frequency_hz, 1))
            })
            .right("line, Hz", |row| {
                let line = row.ok()?.tones.lines.first();
                line.map(|named| fixed(named.line.frequency, 1))
            });
        let counted = |file: &SignalAnalysis, count: fn(&Score) -> usize| {
            let score = file.truth.as_ref();
            score.map(|score| count(score).to_string())
        };
        let table = table
            .right("found", |row| counted(row.ok()?, |score| score.found))
            .right("false", |row| {
                counted(row.ok()?, |score| score.false_events.len())
            })
            .right("missed", |row| {
                counted(row.ok()?, |score| score.missed.len())
            });
        let table = table.left("type of motion", |row| match row {
            Ok(file) => file.verdict.get().ok().map(|it| it.regime.to_string()),
            Err(failed) => Some(escape::line(&failed.reason).into_owned()),
        });
        let mut blocks = vec![table.into()];
        if scores().next().is_some() {
            let mut sum = Score::default();
            scores().for_each(|score| sum += score.clone());
            blocks.extend(sum.blocks());
        }
        blocks
    }
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
    fn all_outputs_are_written_and_listed() {
        let test = TestFolder::new();
        test.run("@/tone.csv --save @/out.rrd --figures @/new/figures")
            .expect("success");
        let text = std::fs::read(test.0.path().join("out.json")).expect("written");
        let json: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
        assert_eq!(json["signal"]["start_s"], 2.0);
        assert_eq!(json["signal"]["duration_s"], 2.0);
        let files = json["files"].as_array().expect("a list");
        assert_eq!(files.len(), signal_figure_names().len() + 1);
        for file in files {
            let bytes = std::fs::read(file["path"].as_str().expect("a path")).expect("written");
            assert_eq!(file["bytes"], bytes.len());
        }
        let figure = files[0]["path"].as_str().map(std::fs::read);
        assert!(
            figure
                .expect("a path")
                .expect("written")
                .starts_with(b"\x89PNG")
        );
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
        assert_eq!(names, ["a.txt", "b.txt", "c.docx"]);
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
        let events = std::fs::read_to_string(path("events.csv")).expect("written");
        let rows: Vec<_> = events.lines().skip(1).collect();
        assert_eq!(rows.len(), 3, "{events}");
        assert!(rows[2].contains("b.csv,ref,1,"), "{events}");
        assert!(
            path("labels/b-ref.txt").is_file() && path("new/figures/a-ref/waveform.png").is_file()
        );
    }

    #[test]
    fn events_become_labels() {
        let event = TonalEvent {
            kind: crate::analysis::events::EventKind::Tone,
            probability: 0.99,
            start_s: 0.5,
            end_s: 2.25,
            frequency_hz: 1513.04,
            frequency_low_hz: 1500.0,
            frequency_high_hz: 1526.5,
            harmonics: 1,
            level_db: 68.2,
            snr_db: 30.0,
            modulation: None,
            vibrato: None,
            ridge: Vec::new(),
        };
        assert_eq!(
            label_text(&[event], LevelReference::SoundPressure),
            "0.500000\t2.250000\t1: tone, 1513.0 Hz, 68.2 dB re 20 uPa\n\\\t1500.000000\t1526.500000\n"
        );
        assert_eq!(label_text(&[], LevelReference::FullScale), "");
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
            assert!(matches!(error, CliError::Output(_)), "{error}");
            assert_eq!(error.exit_code(), 2, "{error}");
        }
        assert_eq!(std::fs::read(&file).expect("there"), b"sound");
    }
}
