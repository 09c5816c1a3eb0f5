//! The layout of a small system.

use super::{ContainerLike, Layout, Parts, View, tab};
use crate::{
    pipeline::message::{Header, SmallInfo},
    record::{paths, small, style::Quantity},
};

/// Natural periods in the time window of the series.
const PERIODS: f64 = 12.0;

impl Layout {
    /// Motion and status of the system.
    pub fn motion_tab(&mut self, header: &Header, info: &SmallInfo) -> Option<ContainerLike> {
        let words = self.text("Observations", paths::NARRATION);
        let portrait = self.portrait();
        let embedding = self.embedding(header, 3.9);
        let recurrence = self.recurrence(header);
        let spectrogram = self.spectrogram(header);
        let spectrum = self.spectrum(header);
        let window = (PERIODS / info.frequency_hz).min(header.duration);
        let last = Quantity::Time.format(window);
        let displacement = self.series(
            &format!("Displacement x, µm (last {last})"),
            paths::DISPLACEMENT,
            Some(window),
        );
        let velocity = self.series(
            &format!("Velocity v, mm/s (last {last})"),
            paths::VELOCITY,
            Some(window),
        );
        let name = format!("Status: {}", small::key(info));
        let status: ContainerLike = View::state_timeline(name).with_origin(paths::STATUS).into();
        self.window(&status, window);

        let top = Parts::new()
            .add(1.0, portrait)
            .add(1.0, embedding)
            .add(1.0, recurrence)
            .row();
        let middle = Parts::new().add(1.62, spectrogram).add(1.0, spectrum).row();
        let series = Parts::new().add(1.0, displacement).add(1.0, velocity).row();
        let right = Parts::new()
            .add(0.40, top)
            .add(0.27, middle)
            .add(0.21, series)
            .add(0.12, status);
        let screen = Parts::new().add(0.25, words).add(0.75, right.column());
        tab("Overview", screen.row())
    }
}
