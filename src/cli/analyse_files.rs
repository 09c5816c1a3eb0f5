//! `squeakscope analyse`: of several files, a table over the files and one JSON document.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::analyse::{self, analyse};
use super::analyse_args::AnalyseArgs;
use super::document::Document;
use super::error::CliError;
use super::output::Kind;
use super::resources;
use crate::escape;
use crate::import::Format;
use crate::number::fixed;
use crate::study::signal::AnalysedFile;
use crate::table::Table;

/// The analyses of several files.
#[derive(Default, Serialize, JsonSchema)]
pub(super) struct AnalysedFiles {
    /// Analyses in the order of the files; those of a directory are sorted by name.
    analyses: Vec<AnalysedFile>,
    /// Failures: files that could not be analysed.
    failures: Vec<FailedFile>,
}

/// A file that could not be analysed.
#[derive(Serialize, JsonSchema)]
struct FailedFile {
    /// Path of the file.
    file: PathBuf,
    /// Reason why it could not be analysed.
    reason: String,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work, or a file that cannot be analysed; failure while drawing or recording; an interrupt.
pub(super) fn execute(args: &AnalyseArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    match &args.files[..] {
        [file] if !file.is_dir() => analyse::execute(args, file, stop),
        _ => analyse_all(args, stop),
    }
}

/// Analyses several files.
fn analyse_all(args: &AnalyseArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    for (option, given) in [
        ("--save", args.save.is_some()),
        ("--labels", args.labels.is_some()),
        ("--figures", args.figures.is_some()),
        ("--event", args.event.is_some()),
    ] {
        if given {
            return Err(CliError::Input(format!(
                "{option} is for a single file; analyse the files one by one, or omit it"
            )));
        }
    }
    let files = files(&args.files)?;
    let json = [("--json", Kind::JSON, args.json.as_deref())];
    let [json] = args.overwrite.check_all(None, json)?;
    resources::start_thread_pool()?;
    let jobs = args.jobs.map_or(1, |jobs| jobs.get());
    let mut found: Vec<(&Path, Result<AnalysedFile, CliError>)> = Vec::new();
    for some in files.chunks(jobs) {
        let analysed = some
            .par_iter()
            .map(|file| (&**file, analyse(args, file, stop)));
        found.extend(analysed.collect::<Vec<_>>());
        if found
            .iter()
            .any(|(_, report)| matches!(report, Err(CliError::NoResult)))
        {
            return Err(CliError::NoResult);
        }
    }
    let text = text(&found);
    let mut result = AnalysedFiles::default();
    for (file, analysed) in found {
        match analysed {
            Ok(analysed) => result.analyses.push(analysed),
            Err(error) => result.failures.push(FailedFile {
                file: file.to_owned(),
                reason: reason(&error),
            }),
        }
    }
    Document::new(&result, &[]).deliver(&text, json.as_ref())?;
    match result.failures.len() {
        0 => Ok(()),
        failed => Err(CliError::Input(format!(
            "{failed} of {} files could not be analysed; the table has the reasons",
            files.len()
        ))),
    }
}

/// The files, with those in a directory whose format is known.
fn files(given: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
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
        let mut inside = Vec::new();
        for entry in entries {
            let entry = entry.map_err(unreadable)?.path();
            if entry.is_file() && Format::of(&entry).is_ok() {
                inside.push(entry);
            }
        }
        inside.sort();
        if inside.is_empty() {
            return Err(CliError::Input(format!(
                "the directory `{directory}` has no file of a known format; give the path of a signal"
            )));
        }
        files.extend(inside);
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

/// The files, one per row.
fn text(found: &[(&Path, Result<AnalysedFile, CliError>)]) -> String {
    let table = Table::default().left("file").right("duration, s");
    let calibrated = |analysed: &AnalysedFile| analysed.sound_levels.is_some();
    let has_levels = found
        .iter()
        .any(|(_, analysed)| analysed.as_ref().is_ok_and(calibrated));
    let table = match has_levels {
        true => table.right("dB(A)"),
        false => table,
    };
    let table = table.right("events").right("event, Hz").right("line, Hz");
    let mut table = table.left("type of motion");
    for (file, report) in found {
        let mut row = vec![escape::path(file)];
        match report {
            Ok(AnalysedFile {
                report,
                sound_levels,
                ..
            }) => {
                let line = report.tones.lines.first();
                row.push(fixed(Some(report.facts.duration_s), 3));
                if has_levels {
                    let levels = sound_levels.as_ref();
                    row.push(fixed(levels.map(|l| l.levels.a_weighted_level_db), 1));
                }
                row.extend([
                    report.events().len().to_string(),
                    fixed(report.event().map(|event| event.frequency_hz), 1),
                    fixed(line.map(|named| named.line.frequency), 1),
                    match report.verdict.get() {
                        Ok(verdict) => verdict.regime.to_string(),
                        Err(_) => String::new(),
                    },
                ]);
            }
            Err(error) => {
                row.extend(vec![String::new(); 4 + usize::from(has_levels)]);
                row.push(escape::line(&reason(error)).into_owned());
            }
        }
        table.row(row);
    }
    table.text()
}
