//! Labels of Audacity.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use super::Format;
use crate::analysis::events::{EventKind, Span, TonalEvent};
use crate::analysis::levels::LevelReference;

/// A label of Audacity: an interval, perhaps with a range of frequencies.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Label {
    /// Where the label lies, s.
    #[serde(flatten)]
    pub span: Span,
    /// Range of frequencies, Hz; `None` without a spectral selection.
    pub range_hz: Option<[f64; 2]>,
    /// Text of the label.
    pub text: String,
}

/// A line of a label file that is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "line {0} is no label of Audacity: start, end and text, separated by tabs; export the labels again"
)]
pub struct LabelError(pub usize);

impl Label {
    /// Reads the labels of a file: a line with start, end and text, separated by tabs, and a line with `\` and the range
    /// of frequencies for a spectral selection.
    ///
    /// # Errors
    /// [`LabelError`] with the number of the line.
    pub fn parse(text: &str) -> Result<Vec<Self>, LabelError> {
        let mut labels: Vec<Self> = Vec::new();
        for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let fields: Vec<&str> = line.split('\t').map(str::trim).collect();
            let value = |k: usize| fields.get(k)?.replace(',', ".").parse::<f64>().ok();
            let pair = |k| value(k).zip(value(k + 1)).filter(|(low, high)| low <= high);
            if let ["\\", ..] = fields[..]
                && let (Some(label), Some((low, high))) = (labels.last_mut(), pair(1))
            {
                // A range that is open has a negative end.
                label.range_hz = (low > 0.0).then_some([low, high]);
            } else if let Some((start_s, end_s)) = pair(0) {
                labels.push(Self {
                    span: Span { start_s, end_s },
                    range_hz: None,
                    text: fields[2..].join(" "),
                });
            } else if !line.trim().is_empty() {
                return Err(LabelError(number));
            }
        }
        Ok(labels)
    }

    /// Tones, which are what labels are compared with, as text of a file: a line with start, end, number, frequency and
    /// level, and a line with the range of frequencies.
    pub fn text_of(events: &[TonalEvent], reference: LevelReference) -> String {
        let label = |(number, event): (usize, &TonalEvent)| {
            format!(
                "{:.6}\t{:.6}\t{number}: {:.1} Hz, {:.1} {reference}\n\\\t{:.6}\t{:.6}\n",
                event.start_s,
                event.end_s,
                event.frequency_hz,
                event.level_db,
                event.frequency_low_hz,
                event.frequency_high_hz
            )
        };
        let numbered = (1..).zip(events);
        let tones = numbered.filter(|(_, event)| event.kind == EventKind::Tone);
        tones.map(label).collect()
    }

    /// The recording with the labels of a text: one of its name among the files beside it.
    pub fn recording<'a>(text: &Path, beside: &'a [PathBuf]) -> Option<&'a PathBuf> {
        let is_text = |path: &Path| path.extension().is_some_and(|ending| ending == "txt");
        let is_recording = |other: &Path| {
            !is_text(other) && other.file_stem() == text.file_stem() && Format::of(other).is_ok()
        };
        let mut beside = beside.iter();
        beside.find(|other| is_text(text) && is_recording(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_no_label_is_named() {
        for text in ["start\tend\tlabel", "3\t2\tback", "0\t1\n\\\t300"] {
            let line = text.lines().count();
            assert_eq!(Label::parse(text), Err(LabelError(line)), "{text}");
        }
    }

    #[test]
    fn events_become_labels() {
        let event = TonalEvent {
            kind: EventKind::Tone,
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
        // Noise is no label, as `--truth` compares tones.
        let noise = TonalEvent {
            kind: EventKind::NarrowBandNoise,
            ..event.clone()
        };
        assert_eq!(
            Label::text_of(&[noise, event], LevelReference::SoundPressure),
            "0.500000\t2.250000\t2: 1513.0 Hz, 68.2 dB re 20 uPa\n\\\t1500.000000\t1526.500000\n"
        );
        assert_eq!(Label::text_of(&[], LevelReference::FullScale), "");
    }
}
