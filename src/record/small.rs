//! A small system: series and phase portrait coloured by status, and the status as a band.

use crate::record::sdk::{Color, SeriesLines, StateChange, StateConfiguration};

use super::{
    error::RecordError,
    paths,
    portrait::Portrait,
    samples::{Rows, push_probe},
    stream::{self, RecordingStream},
    style,
};
use crate::pipeline::message::{Frame, SmallInfo, StatusKind};
use crate::plot::Unit;

/// Natural periods in the trail of the phase portrait.
const TRAIL: f64 = 40.0;

/// The series, portrait and status of a small system.
#[derive(Debug)]
pub struct SmallFrames {
    small: SmallInfo,
    portrait: Portrait,
    /// Status at the last sample.
    last: Option<u8>,
    stats: StatusStats,
}

/// Statistics of the status since the last report.
#[derive(Debug, Default)]
struct StatusStats {
    /// Duration, s.
    time: f64,
    /// Number of samples in each status.
    samples: Vec<u64>,
    transitions: u64,
}

impl SmallFrames {
    /// Names the series and the statuses, and starts empty.
    pub fn new(
        rec: &RecordingStream,
        rows: &mut Rows,
        small: &SmallInfo,
    ) -> Result<Self, RecordError> {
        let colors: Vec<Color> = small.statuses.iter().map(|s| color(s.kind)).collect();
        for (path, name) in [
            (paths::DISPLACEMENT, "displacement, µm"),
            (paths::VELOCITY, "velocity, mm/s"),
        ] {
            // A static colour would override the colour of the status.
            let style = SeriesLines::new().with_names([name]).with_widths([1.2]);
            rec.log_static(path, &style)?;
            rows.add(path, 1);
        }
        let labels = || small.statuses.iter().map(|status| status.label.as_str());
        let band = StateConfiguration::new()
            .with_values(labels())
            .with_labels(labels())
            .with_colors(colors.iter().copied());
        rec.log_static(paths::STATUS, &band)?;
        Ok(Self {
            portrait: Portrait::new(TRAIL / small.frequency_hz, colors),
            last: None,
            stats: StatusStats::default(),
            small: small.clone(),
        })
    }

    /// Adds a frame.
    pub fn push(
        &mut self,
        rec: &RecordingStream,
        rows: &mut Rows,
        frame: &Frame,
    ) -> Result<(), RecordError> {
        self.draw_status(rec, frame)?;
        push_probe(rows, frame);
        self.portrait.push(rec, frame)?;
        self.stats.push(frame, self.small.statuses.len());
        Ok(())
    }

    /// Logs changes of the status, as a band and as the colour of the series.
    fn draw_status(&mut self, rec: &RecordingStream, frame: &Frame) -> Result<(), RecordError> {
        let mut times = Vec::new();
        let mut changed = Vec::new();
        for (k, &status) in frame.status.iter().enumerate() {
            if self.last.replace(status) != Some(status) {
                times.push(stream::nanos(frame.time(k)));
                changed.push(&self.small.statuses[usize::from(status)]);
            }
        }
        if times.is_empty() {
            return Ok(());
        }
        let labels = changed.iter().map(|status| status.label.as_str());
        let band = StateChange::new().with_state(labels);
        stream::send_rows(rec, paths::STATUS, &times, band.columns_of_unit_batches())?;
        for path in [paths::DISPLACEMENT, paths::VELOCITY] {
            let colors = changed.iter().map(|status| color(status.kind));
            let colors = SeriesLines::update_fields().with_colors(colors);
            stream::send_rows(rec, path, &times, colors.columns_of_unit_batches())?;
        }
        Ok(())
    }

    /// Shares of each status since the last call, as a Markdown sentence.
    pub fn status_summary(&mut self) -> String {
        let stats = std::mem::take(&mut self.stats);
        let all: u64 = stats.samples.iter().sum();
        let shares = self.small.statuses.iter().zip(&stats.samples);
        let shares: Vec<String> = shares
            .filter(|(_, samples)| **samples > 0)
            .map(|(status, &samples)| {
                format!(
                    "{} **{:.0} %**",
                    status.label,
                    1e2 * samples as f64 / all as f64
                )
            })
            .collect();
        format!(
            "Last {}: {}; {} {}.",
            Unit::write(stats.time, "s"),
            shares.join(", "),
            stats.transitions,
            self.small.transition,
        )
    }
}

impl StatusStats {
    fn push(&mut self, frame: &Frame, statuses: usize) {
        self.time += frame.end() - frame.t0;
        self.samples.resize(statuses, 0);
        for &status in &frame.status {
            self.samples[usize::from(status)] += 1;
        }
        self.transitions += frame.transitions;
    }
}

/// The colour of a status, as for slipping and sticking nodes.
pub fn color(kind: StatusKind) -> Color {
    match kind {
        StatusKind::Free => style::SIGNAL,
        StatusKind::Held => style::ACCENT,
        StatusKind::Other => style::ROTATION,
    }
}

/// Legend of the statuses for titles: `flying (blue), resting on the wall (orange)`.
pub fn key(small: &SmallInfo) -> String {
    let color = |kind| match kind {
        StatusKind::Free => "blue",
        StatusKind::Held => "orange",
        StatusKind::Other => "green",
    };
    let statuses = small.statuses.iter();
    let words: Vec<String> = statuses
        .map(|status| format!("{} ({})", status.label, color(status.kind)))
        .collect();
    words.join(", ")
}
