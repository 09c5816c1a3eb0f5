//! The events of several files as a table: one row per event.

use std::path::Path;

use arrow_schema::FieldRef;
use serde::{Deserialize, Serialize};
use serde_arrow::schema::{SchemaLike, TracingOptions};

use super::SignalAnalysis;
use crate::export::OutputError;
use crate::study::table;

/// A row: an event.
#[derive(Serialize, Deserialize)]
struct Row {
    /// Path of the file.
    file: String,
    /// Name of the column or channel.
    channel: String,
    /// Number of the event in the file.
    event: u32,
    kind: String,
    probability: f64,
    start_s: f64,
    end_s: f64,
    frequency_hz: f64,
    frequency_low_hz: f64,
    frequency_high_hz: f64,
    harmonics: u32,
    level_db: f64,
    /// What the level is relative to.
    level_reference: String,
    snr_db: f64,
    modulation_hz: Option<f64>,
    modulation_depth: Option<f64>,
    vibrato_hz: Option<f64>,
    vibrato_deviation_hz: Option<f64>,
}

/// Writes the events of files: Parquet or CSV if the name ends so, otherwise an Arrow file. An existing file is
/// replaced.
///
/// # Errors
/// If the file cannot be written; an existing file is then unchanged.
pub fn write_events<'a>(
    path: &Path,
    files: impl IntoIterator<Item = &'a SignalAnalysis>,
) -> Result<(), OutputError> {
    let rows: Vec<Row> = files.into_iter().flat_map(rows).collect();
    let fields = Vec::<FieldRef>::from_type::<Row>(TracingOptions::default());
    table::write(path, table::schema(fields), &rows)
}

fn rows(report: &SignalAnalysis) -> impl Iterator<Item = Row> {
    let file = report.file.as_deref().unwrap_or(Path::new(""));
    (1..).zip(report.events()).map(move |(number, event)| Row {
        file: file.display().to_string(),
        channel: report.facts.name.clone(),
        event: number,
        kind: event.kind.to_string(),
        probability: event.probability,
        start_s: event.start_s,
        end_s: event.end_s,
        frequency_hz: event.frequency_hz,
        frequency_low_hz: event.frequency_low_hz,
        frequency_high_hz: event.frequency_high_hz,
        harmonics: event.harmonics as u32,
        level_db: event.level_db,
        level_reference: report.level_reference().to_string(),
        snr_db: event.snr_db,
        modulation_hz: event.modulation.as_ref().map(|m| m.modulation_hz),
        modulation_depth: event.modulation.as_ref().map(|m| m.modulation_depth),
        vibrato_hz: event.vibrato.as_ref().map(|v| v.vibrato_hz),
        vibrato_deviation_hz: event.vibrato.as_ref().map(|v| v.vibrato_deviation_hz),
    })
}
