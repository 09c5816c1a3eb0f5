//! The layout of a signal from a file.

use super::{ContainerLike, Layout, Parts, tab};
use crate::{
    pipeline::message::{Header, SignalInfo},
    record::{paths, style},
};

/// Periods of the highest frequency shown that the detail view covers.
const PERIODS: f64 = 100.0;

impl Layout {
    /// Waveform, spectrum, spectrogram, embedding and recurrence plot.
    pub fn signal_tab(&mut self, header: &Header, signal: &SignalInfo) -> Option<ContainerLike> {
        let words = self.text("Classification", paths::NARRATION);
        let name = style::with_unit(style::signal_name(signal), &signal.unit);
        let window = (PERIODS / signal.highest_frequency).min(header.duration);
        let near = format!("{name} (last {})", style::Quantity::Time.format(window));
        let near = self.series(&near, paths::WAVEFORM, Some(window));
        let whole = self.series(&format!("{name} (whole signal)"), paths::WAVEFORM, None);
        let [low, high] = signal.span;
        let margin = 0.05 * (high - low);
        for view in [&near, &whole] {
            self.range(view, low - margin, high + margin);
        }
        let embedding = self.embedding(header, 3.9);
        let recurrence = self.recurrence(header);
        let spectrogram = self.spectrogram(header);
        let spectrum = self.spectrum(header);

        let top = Parts::new().add(1.0, embedding).add(1.0, recurrence).row();
        let middle = Parts::new().add(1.62, spectrogram).add(1.0, spectrum).row();
        let bottom = Parts::new().add(1.62, whole).add(1.0, near).row();
        let right = Parts::new()
            .add(0.44, top)
            .add(0.35, middle)
            .add(0.21, bottom);
        let screen = Parts::new().add(0.25, words).add(0.75, right.column());
        tab("Overview", screen.row())
    }
}
