//! Tonal events over the spectrogram.

use super::{Picture, SignalFigures};
use crate::plot::{Color, Layer};

/// Colour of ridges: visible on the dark colours of strong tones.
const RIDGE: Color = Color::Series(6);

impl SignalFigures<'_> {
    /// The spectrogram with the ridges of the events, numbered at their starts.
    pub fn events(&self) -> Picture {
        let mut panel = self.spectrogram_panel();
        let events = self.report.events();
        let title = match (&self.report.sound, events.len()) {
            (None, _) => "no tonal events: the sample rate is not that of sound",
            (Some(_), 0) => "no tonal events",
            (Some(sound), _) => &format!(
                "events with number and level ({}) at their starts",
                sound.level_reference
            ),
        };
        if !events.is_empty() {
            let ridges = events.iter().map(|event| {
                let ridge = event.ridge.iter();
                ridge.map(|p| [p.time_s, p.frequency_hz]).collect()
            });
            let ridges = Layer::lines(ridges.collect(), RIDGE).with_size(1.3);
            let starts = events.iter().zip(1..).map(|(event, number)| {
                let start = [event.start_s, event.frequency_at(event.start_s)];
                (start, format!("{number}: {:.1}", event.level_db))
            });
            let starts = Layer {
                color: RIDGE,
                ..Layer::peaks(starts.collect())
            };
            panel.layers.extend([ridges.with_id("ridges"), starts]);
        }
        Ok((88.0, vec![vec![panel.with_title(title)]]))
    }
}
