//! Labels of what sounds in a recording, by ear, and how many of them the search for events finds.

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::events::{EventKind, TonalEvent};
use crate::import::Label;

/// Least common part of an event and a label, of the longer one.
const COMMON: f64 = 0.3;

/// Relative deviation of the frequency of an event from the range of a label.
const FREQUENCY: f64 = 0.01;

/// Events compared with labels: an event is found if it has a label of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Score {
    /// Number of labels with an event.
    pub found: usize,
    /// Numbers of the events without a label, from 1.
    #[serde(rename = "false")]
    pub false_events: Vec<usize>,
    /// Labels without an event.
    pub missed: Vec<Label>,
}

/// Numbers of events and labels of one or several files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct TotalScore {
    /// Labels with an event.
    pub found: usize,
    /// Events without a label.
    #[serde(rename = "false")]
    pub false_events: usize,
    /// Labels without an event.
    pub missed: usize,
}

impl TotalScore {
    /// The sum of some scores; `None` without any.
    pub fn of<'a>(scores: impl IntoIterator<Item = &'a Score>) -> Option<Self> {
        let counts = scores.into_iter().map(|score| Self {
            found: score.found,
            false_events: score.false_events.len(),
            missed: score.missed.len(),
        });
        counts.reduce(|a, b| Self {
            found: a.found + b.found,
            false_events: a.false_events + b.false_events,
            missed: a.missed + b.missed,
        })
    }
}

/// Common part of an event with a label, of the longer one; `None` if the event does not fit.
fn fit(label: &Label, event: &TonalEvent) -> Option<f64> {
    let [a, b] = [label.span, event.span()];
    let common = a.end_s.min(b.end_s) - a.start_s.max(b.start_s);
    let longer = a.length_s().max(b.length_s()).max(f64::MIN_POSITIVE);
    let sounds = label.range_hz.is_none_or(|[low, high]| {
        let range = low * (1.0 - FREQUENCY)..=high * (1.0 + FREQUENCY);
        range.contains(&event.frequency_hz)
    });
    Some(common / longer).filter(|share| sounds && *share >= COMMON)
}

impl Score {
    /// Compares tones with labels. Each label takes the event with the largest common part of those that are left.
    pub fn of(events: &[TonalEvent], labels: &[Label]) -> Self {
        let is_tone = |index: &usize| events[*index].kind == EventKind::Tone;
        let mut left: Vec<usize> = (0..events.len()).filter(is_tone).collect();
        let mut score = Self::default();
        for label in labels {
            let fits = left.iter().enumerate();
            let fits =
                fits.filter_map(|(place, &event)| Some((place, fit(label, &events[event])?)));
            if let Some((place, _)) = fits.max_by(|a, b| a.1.total_cmp(&b.1)) {
                left.remove(place);
                score.found += 1;
            } else {
                score.missed.push(label.clone());
            }
        }
        score.false_events = left.into_iter().map(|event| event + 1).collect();
        score
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(start_s: f64, end_s: f64, frequency_hz: f64) -> TonalEvent {
        TonalEvent {
            kind: crate::analysis::events::EventKind::Tone,
            probability: 0.99,
            start_s,
            end_s,
            frequency_hz,
            frequency_low_hz: frequency_hz,
            frequency_high_hz: frequency_hz,
            harmonics: 1,
            level_db: -20.0,
            snr_db: 20.0,
            modulation: None,
            vibrato: None,
            ridge: Vec::new(),
        }
    }

    #[test]
    fn events_with_a_label_of_their_own_are_found() {
        let text =
            "0,5\t1,5\tsqueak\r\n\\\t1400\t1600\n2.0\t3.0\n\\\t-1\t-1\n\n5\t6\tchirp of a bird\n";
        let labels = Label::parse(text).expect("labels");
        assert_eq!(labels[0].range_hz, Some([1400.0, 1600.0]));
        assert_eq!((&*labels[1].text, labels[1].range_hz), ("", None));
        let events = [
            event(0.6, 1.4, 1390.0),
            // Another frequency, a second one for the same label, and too short a common part.
            event(0.6, 1.4, 2000.0),
            event(2.1, 2.6, 500.0),
            event(2.0, 3.0, 500.0),
            event(5.9, 7.0, 800.0),
        ];
        let score = Score::of(&events, &labels);
        assert_eq!((score.found, &score.false_events[..]), (2, &[2, 3, 5][..]));
        assert_eq!(score.missed, labels[2..]);
        let text = crate::report::markdown(&score.blocks());
        assert!(
            text.contains("2 of 3 labels found, 1 missed; 3 false events"),
            "{text}"
        );
    }
}
