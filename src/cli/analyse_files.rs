//! `squeakscope analyse` of several signals: a table over them and one JSON document.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::analyse::{analyse, write_labels};
use super::analyse_args::AnalyseArgs;
use super::console::print_notice;
use super::error::CliError;
use super::figures::PIXELS;
use super::harness::{Outputs, Watch};
use super::output::{Kind, check_directory, check_file};
use super::resources;
use crate::import::{Label, channels, why_no_signal};
use crate::plot::{figure_names, signal_figures};
use crate::study::signal::{AnalysedFiles, FailedFile, SignalAnalysis, write_events};

/// A file and its column, if one is selected.
type Job = (PathBuf, Option<String>);

/// Analyses several files or channels.
///
/// # Errors
/// Bad input before any work, or a file that cannot be analysed; failure while drawing; an interrupt.
pub(super) fn analyse_all(args: &AnalyseArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
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
    let mut files = Outputs::new(None, &args.output)
        .file("--events", Kind::TABLE, args.events.as_ref())?
        .check()?;
    check_directories(args, &jobs)?;
    resources::start_thread_pool()?;
    let watch = Watch::new(stop);
    let at_once = args.jobs.map_or(1, |jobs| jobs.get());
    for group in jobs.chunks(at_once) {
        let analysed = group
            .par_iter()
            .map(|(file, column)| analyse(args, file, column.clone(), &watch));
        for (job, analysed) in group.iter().zip(analysed.collect::<Vec<_>>()) {
            match analysed {
                Err(CliError::NoResult) => return Err(CliError::NoResult),
                Ok(mut analysed) => {
                    write_pictures(args, &name(job), &analysed, &mut files)?;
                    analysed.signal.samples = Vec::new();
                    analysed.part = None;
                    analysed.spectrogram = Vec::new();
                    result.analyses.push(analysed);
                }
                Err(error) => {
                    let (file, reason) = (job.0.clone(), reason(&error));
                    result.failures.push(FailedFile { file, reason });
                }
            }
        }
    }
    let all = result.analyses.len() + result.failures.len();
    let result = result.concluded();
    files.finish(watch, None, &result, |files| {
        files.write("--events", |path| write_events(path, &result.analyses))
    })?;
    match result.failures.len() {
        0 => Ok(()),
        failed => Err(CliError::Input(format!(
            "{failed} of {all} signals could not be analysed; the table has the reasons"
        ))),
    }
}

/// The signals. A file whose channels cannot be listed is one: a recording, of which the main column is analysed, or a
/// damaged file, whose analysis gives the reason.
fn jobs(args: &AnalyseArgs, skipped: &mut Vec<FailedFile>) -> Result<Vec<Job>, CliError> {
    let files = files(args, skipped)?;
    if files.len() > 1 && args.truth.as_ref().is_some_and(|truth| !truth.is_dir()) {
        return Err(CliError::Input(
            "--truth is a directory for several files, with the labels NAME.txt of each file NAME"
                .to_owned(),
        ));
    }
    let mut jobs: Vec<Job> = Vec::new();
    for file in files {
        let names = args.each_channel.then(|| channels(&file, args.skip_lines));
        match names {
            Some(Ok(names)) => {
                jobs.extend(names.into_iter().map(|name| (file.clone(), Some(name))));
            }
            _ => jobs.push((file, args.column.clone())),
        }
    }
    Ok(jobs)
}

/// Name of a signal for its figures and labels.
fn name((file, column): &Job) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let column = column.as_ref().map(|column| format!("-{column}"));
    // A name of a column may be no name of a file.
    format!("{stem}{}", column.unwrap_or_default())
        .replace(|c: char| std::path::is_separator(c) || c == ':', "_")
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
    let force = args.output.overwrite.force;
    if let Some(directory) = &args.figures.path {
        let names = args.figures.drawn.or_formats(PIXELS).names(&figure_names());
        for name in named.keys() {
            check_directory(&directory.join(name), "--figures", &names, force)?;
        }
    }
    if let Some(directory) = &args.labels {
        let names: Vec<_> = named.keys().map(|name| format!("{name}.txt")).collect();
        check_directory(directory, "--labels", &names, force)?;
    }
    Ok(())
}

/// Writes the figures and labels of one of several signals.
fn write_pictures(
    args: &AnalyseArgs,
    name: &str,
    report: &SignalAnalysis,
    files: &mut Outputs<'_>,
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

/// The files, with those in a directory that may be signals; the others are `skipped`, with the reason.
fn files(args: &AnalyseArgs, skipped: &mut Vec<FailedFile>) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    for path in &args.files {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let directory = path.display();
        let entries = std::fs::read_dir(path)
            .and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
        let mut inside: Vec<PathBuf> = entries.map_err(|source| {
            CliError::Input(format!(
                "cannot read the directory `{directory}` ({source}); check its permissions"
            ))
        })?;
        inside.sort();
        let before = files.len();
        for entry in &inside {
            let labelled = Label::recording(entry, &inside);
            let labels = labelled.map(|recording| format!("labels of {}", recording.display()));
            let Some(reason) = labels.or_else(|| why_no_signal(entry, args.skip_lines)) else {
                files.push(entry.clone());
                continue;
            };
            // The labels are read.
            if labelled.is_none() || args.truth.as_ref() != Some(path) {
                print_notice(&format!("{} is not analysed: {reason}", entry.display()));
            }
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
        CliError::Signal(_, reason) => reason.to_string(),
        _ => error.to_string(),
    }
}
