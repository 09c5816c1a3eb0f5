//! Spectrogram of the probe's velocity, a column at a time.

use super::clock::samples;
use super::stage::Stage;
use super::windowed::{Windowed, velocity};
use crate::analysis::{SlidingWindow, SpectrumAnalyser, Window};
use crate::pipeline::message::Record;
use crate::scene::SpectrogramSpec;

/// The reference of the levels: 0 dB is an amplitude of 1 mm/s.
const REFERENCE: f64 = 1e-3;

/// The lowest level reported; silence has no logarithm.
const LOWEST_DB: f64 = -160.0;

/// Emits [`Record::SpectrogramColumn`] of samples at `rate` (Hz), each once its window is full. A Hann
/// window: short windows need its narrow lobe more than they need low side lobes.
pub fn spectrogram(spec: &SpectrogramSpec, rate: f64) -> impl Stage + use<> {
    let length = samples(spec.sliding.window, rate, SpectrumAnalyser::FEWEST_SAMPLES);
    let max_frequency = spec.max_frequency;
    let mut analyser = SpectrumAnalyser::new(Window::Hann, rate);
    let sliding = SlidingWindow::new(length, spec.sliding.every * rate);
    let columns = Windowed::new(sliding, velocity, move |window, context, emit| {
        let column = analyser.analyse(window.channels[0])?;
        // The last bin may lie at the limit: rounding must not lose it.
        let bins = (max_frequency / column.bin + 1e-9) as usize + 1;
        let level = |a: &f64| (20.0 * (a / REFERENCE).log10()).max(LOWEST_DB) as f32;
        emit(Record::SpectrogramColumn {
            time: context.clock.time(window.seen as f64 - 0.5 * length as f64),
            bin: column.bin,
            level_db: column.amplitude.iter().take(bins).map(level).collect(),
        })
    });
    columns.complete()
}
