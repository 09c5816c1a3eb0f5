//! The analyses of several files as one result.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use super::{Score, SignalAnalysis, TotalScore};
use crate::analysis::events::EventKind;
use crate::escape;
use crate::number::fixed;
use crate::report::{Block, Report, Table};

/// The analyses of several files.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct AnalysedFiles {
    /// Analyses in the order of the files; those of a directory are sorted by name.
    pub analyses: Vec<SignalAnalysis>,
    /// Failures: files that could not be analysed.
    pub failures: Vec<FailedFile>,
    /// Skipped: files in a directory that are no signals.
    pub skipped: Vec<FailedFile>,
    /// Events compared with the labels of all files; `null` without labels.
    pub truth: Option<TotalScore>,
    /// Whether each channel of a file is a signal of its own.
    #[serde(skip)]
    pub each_channel: bool,
}

/// A file that was not analysed.
#[derive(Debug, Serialize, JsonSchema)]
pub struct FailedFile {
    /// Path of the file.
    pub file: PathBuf,
    /// Reason why it was not analysed.
    pub reason: String,
}

impl AnalysedFiles {
    /// The result with the sum of the scores.
    pub fn concluded(self) -> Self {
        Self {
            truth: TotalScore::of(self.scores()),
            ..self
        }
    }

    fn scores(&self) -> impl Iterator<Item = &Score> {
        self.analyses.iter().filter_map(|file| file.truth.as_ref())
    }
}

impl Report for AnalysedFiles {
    /// The signals, one per row, then those that failed, and how many events have labels.
    fn blocks(&self, _name: &str) -> Vec<Block> {
        let score = |row: &Result<&SignalAnalysis, &FailedFile>| {
            row.ok().and_then(|file| file.truth.clone())
        };
        let analyses = self.analyses.iter().map(Ok);
        let table = Table::of(analyses.chain(self.failures.iter().map(Err)))
            .left("file", |row| match row {
                Ok(file) => file.file.as_deref().map(escape::path),
                Err(failed) => Some(escape::path(&failed.file)),
            })
            .left("channel", |row| {
                let file = row.ok().filter(|_| self.each_channel)?;
                Some(escape::line(&file.facts.name))
            })
            .right("duration, s", |row| {
                fixed(row.ok().map(|file| file.facts.duration_s), 3)
            })
            .right("dB(A)", |row| {
                let levels = row.ok()?.sound_levels.as_ref();
                levels.map(|found| fixed(found.levels.a_weighted_level_db, 1))
            })
            .right("tones", |row| {
                let events = row.ok()?.events().iter();
                let tones = events.filter(|event| event.kind == EventKind::Tone);
                Some(tones.count().to_string())
            })
            .right("tone, Hz", |row| {
                let event = row.ok()?.event();
                event.map(|event| fixed(event.frequency_hz, 1))
            })
            .right("line, Hz", |row| {
                let line = row.ok()?.tones.lines.first();
                line.map(|named| fixed(named.line.frequency, 1))
            })
            .right("found", |row| Some(score(row)?.found.to_string()))
            .right("false", |row| {
                Some(score(row)?.false_events.len().to_string())
            })
            .right("missed", |row| Some(score(row)?.missed.len().to_string()))
            .left("type of motion", |row| match row {
                Ok(file) => Some(match file.verdict.get() {
                    Ok(verdict) => verdict.regime.to_string(),
                    Err(reason) => format!("skipped: {reason}"),
                }),
                Err(failed) => Some(escape::line(&failed.reason)),
            });
        let mut blocks = vec![table.into()];
        blocks.extend(self.truth.as_ref().map(TotalScore::block));
        blocks.extend(self.scores().flat_map(Score::missed_labels));
        blocks
    }
}
