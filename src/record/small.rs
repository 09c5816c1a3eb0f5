//! A small system: series and phase portrait coloured by status, and the status as a band.

use crate::record::sdk::{SeriesLines, StateChange, StateConfiguration};

use super::portrait::Portrait;
use super::samples::push_probe;
use super::stream::{RecordingStream, WIDTH, nanos};
use super::{paths, style};
use crate::pipeline::message::{Frame, SmallInfo, StatusKind};
use crate::plot::{Color, Unit};

/// Natural periods in the trail of the phase portrait.
const TRAIL: f64 = 40.0;

/// The series and the status of a small system.
#[derive(Debug)]
pub struct SmallFrames {
    small: SmallInfo,
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
    pub fn new(rec: &RecordingStream, small: &SmallInfo) -> Self {
        for (path, name) in [
            (paths::DISPLACEMENT, "displacement, µm"),
            (paths::VELOCITY, "velocity, mm/s"),
        ] {
            // A static colour would override the colour of the status.
            rec.start(path, vec![(name.to_owned(), Color::Run, WIDTH)], false);
        }
        let labels = || small.statuses.iter().map(|status| status.label);
        let band = StateConfiguration::new()
            .with_values(labels())
            .with_labels(labels())
            .with_colors(colors(small));
        rec.log_static(paths::STATUS, &band);
        Self {
            last: None,
            stats: StatusStats::default(),
            small: small.clone(),
        }
    }

    /// Adds a frame.
    pub fn push(&mut self, rec: &RecordingStream, frame: &Frame) {
        self.draw_status(rec, frame);
        push_probe(rec, frame);
        self.stats.push(frame, self.small.statuses.len());
    }

    /// Logs changes of the status, as a band and as the colour of the series.
    fn draw_status(&mut self, rec: &RecordingStream, frame: &Frame) {
        let mut times = Vec::new();
        let mut changed = Vec::new();
        for (k, &status) in frame.status.iter().enumerate() {
            if self.last.replace(status) != Some(status) {
                times.push(nanos(frame.time(k)));
                changed.push(&self.small.statuses[usize::from(status)]);
            }
        }
        if times.is_empty() {
            return;
        }
        let labels = changed.iter().map(|status| status.label);
        let band = StateChange::new().with_state(labels);
        rec.send_rows(paths::STATUS, &times, band.columns_of_unit_batches());
        for path in [paths::DISPLACEMENT, paths::VELOCITY] {
            let colors = changed.iter().map(|status| color(status.kind));
            let colors = SeriesLines::update_fields().with_colors(colors);
            rec.send_rows(path, &times, colors.columns_of_unit_batches());
        }
    }

    /// Shares of each status since the last call, as a Markdown sentence.
    pub fn status_summary(&mut self) -> String {
        let stats = std::mem::take(&mut self.stats);
        let all: u64 = stats.samples.iter().sum();
        let shares = self.small.statuses.iter().zip(&stats.samples);
        let shares = shares.filter(|(_, samples)| **samples > 0);
        let shares = shares.map(|(status, &samples)| {
            let percent = 1e2 * samples as f64 / all as f64;
            format!("{} **{percent:.0} %**", status.label)
        });
        let shares: Vec<String> = shares.collect();
        let (time, shares) = (Unit::write(stats.time, "s"), shares.join(", "));
        let (count, transition) = (stats.transitions, self.small.transition);
        format!("Last {time}: {shares}; {count} {transition}.")
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

/// The phase portrait, with a trail in the colours of the statuses.
pub fn portrait(rec: &RecordingStream, small: &SmallInfo) -> Portrait {
    Portrait::new(rec, TRAIL / small.frequency_hz, colors(small))
}

fn colors(small: &SmallInfo) -> Vec<Color> {
    let kinds = small.statuses.iter().map(|status| status.kind);
    kinds.map(color).collect()
}

/// The colour of a status, as for slipping and sticking nodes.
pub fn color(kind: StatusKind) -> Color {
    match kind {
        StatusKind::Free => Color::Run,
        StatusKind::Held => Color::Compared,
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
    let words = statuses.map(|status| format!("{} ({})", status.label, color(status.kind)));
    words.collect::<Vec<_>>().join(", ")
}
