//! Tonal events over the spectrogram.

use super::SignalFigures;
use crate::analysis::TonalEvent;
use crate::plot::figure::Marker;
use crate::plot::{Color, Figure, Layer};

/// Colour of ridges: visible on the dark colours of strong tones.
const RIDGE: Color = Color::Series(6);

impl SignalFigures<'_> {
    /// The spectrogram with the ridges of the events, numbered at their starts.
    pub fn events(&self) -> Figure {
        let mut panel = self.spectrogram_panel();
        let events = self.report.events();
        let title = match (&self.report.sound, events.len()) {
            (None, _) => "no tonal events: the sample rate is not that of sound",
            (Some(_), 0) => "no tonal events",
            (Some(sound), _) => &format!(
                "events with number and level ({}), from start to end (triangles)",
                sound.level_reference
            ),
        };
        if !events.is_empty() {
            panel.layers.extend(self.event_layers(events));
        }
        let rows = vec![vec![panel.with_title(title)]];
        Figure::new("events", self.title("Tonal events"), 88.0, rows)
    }

    /// Ridges, starts, ends and numbers, the latter above the starts.
    fn event_layers(&self, events: &[TonalEvent]) -> Vec<Layer> {
        let ridges = events.iter().map(|event| self.ridge(event));
        let ends = |time: fn(&TonalEvent) -> f64| -> Vec<[f64; 2]> {
            events
                .iter()
                .map(|event| self.point(event, time(event)))
                .collect()
        };
        let (starts, stops) = (ends(|event| event.start_s), ends(|event| event.end_s));
        let numbers = starts.iter().zip(events).zip(1..);
        let numbers = numbers.map(|((start, event), number)| {
            Layer::text(*start, format!("{number}: {:.1}", event.level_db)).with_id("numbers")
        });
        let numbers: Vec<Layer> = numbers.collect();
        let mark = |points, marker, id| {
            let points = Layer::points(points, 3.5, RIDGE);
            points.with_marker(marker).with_id(id)
        };
        let mut layers = vec![
            Layer::lines(ridges.collect(), RIDGE)
                .with_line_width(1.3)
                .with_id("ridges"),
            mark(starts, Marker::Up, "starts"),
            mark(stops, Marker::Down, "ends"),
        ];
        layers.extend(numbers);
        layers
    }

    /// The fundamental of an event over time.
    fn ridge(&self, event: &TonalEvent) -> Vec<[f64; 2]> {
        let points = event.ridge.iter();
        let [time, frequency] = [self.time_unit.factor, self.frequency_unit.factor];
        let points = points.map(|p| [p.time_s * time, p.frequency_hz * frequency]);
        points.collect()
    }

    /// The fundamental of an event at a time, s.
    fn point(&self, event: &TonalEvent, time_s: f64) -> [f64; 2] {
        let frequency = event.frequency_at(time_s);
        [
            time_s * self.time_unit.factor,
            frequency * self.frequency_unit.factor,
        ]
    }
}
