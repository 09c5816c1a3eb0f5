//! Spectrogram of the probe's velocity, column by column.

use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Windowed, velocity};
use crate::analysis::{
    sliding::SlidingWindow,
    tones::{SpectrumAnalyser, Window},
};
use crate::pipeline::message::Record;
use crate::scene::SpectrogramSpec;

/// Reference amplitude of the levels: 0 dB is 1 mm/s.
const REFERENCE: f64 = 1e-3;

/// Lowest reported level, dB; the logarithm of zero is undefined.
const LOWEST_DB: f64 = -160.0;

/// Emits [`Record::SpectrogramColumn`] of samples at `rate` (Hz) as soon as the window is full. The Hann
/// window suits short windows: a narrow main lobe matters more than low side lobes.
pub fn spectrogram(spec: &SpectrogramSpec, rate: f64) -> impl Stage + use<> {
    let length = samples(spec.window, rate, SpectrumAnalyser::MIN_SAMPLES);
    let max_frequency = spec.max_frequency;
    let mut analyser = SpectrumAnalyser::new(Window::Hann, rate);
    let sliding = SlidingWindow::new(length, spec.every * rate);
    let columns = Windowed::new(sliding, velocity, move |window, context| {
        let column = analyser.analyse(window.channels[0])?;
        // Rounding must not drop a last bin that lies exactly at the limit.
        let bins = (max_frequency / column.bin + 1e-9) as usize + 1;
        let level = |a: &f64| (20.0 * (a / REFERENCE).log10()).max(LOWEST_DB) as f32;
        Ok(Some(Record::SpectrogramColumn {
            time: context.clock.time(window.seen as f64 - 0.5 * length as f64),
            bin: column.bin,
            level_db: column.amplitude.iter().take(bins).map(level).collect(),
        }))
    });
    columns.complete()
}
