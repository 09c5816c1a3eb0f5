//! Spectrogram of the probe's velocity, a column at a time.

use super::{Context, Emit, Stage, samples};
use crate::analysis::{Column, SpectrumAnalyser, Stft, Window};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::SpectrogramSpec;

/// The reference of the levels: 0 dB is an amplitude of 1 mm/s.
const REFERENCE: f64 = 1e-3;

/// The lowest level told; silence has no logarithm.
const LOWEST_DB: f64 = -160.0;

/// Emits [`Record::SpectrogramColumn`], each once its window is full. A Hann window: short
/// windows need its narrow lobe more than they need low side lobes.
pub struct SpectrogramStage {
    stft: Stft,
    max_frequency: f64,
}

impl SpectrogramStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: &SpectrogramSpec, rate: f64) -> Self {
        let length = samples(spec.sliding.window, rate, SpectrumAnalyser::FEWEST_SAMPLES);
        Self {
            stft: Stft::new(Window::Hann, length, spec.sliding.every * rate, rate),
            max_frequency: spec.max_frequency,
        }
    }
}

impl Stage for SpectrogramStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let max_frequency = self.max_frequency;
        self.stft.push(&frame.velocity, |column: Column| {
            // The last bin may lie at the limit: rounding must not lose it.
            let bins = (max_frequency / column.bin + 1e-9) as usize + 1;
            let level = |a: &f64| (20.0 * (a / REFERENCE).log10()).max(LOWEST_DB) as f32;
            emit(Record::SpectrogramColumn {
                time: context.time(column.centre),
                bin: column.bin,
                level_db: column.amplitude.iter().take(bins).map(level).collect(),
            })
        })
    }
}
