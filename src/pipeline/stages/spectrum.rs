//! Sliding amplitude spectrum of the probe's velocity, its lines named.

use super::{Context, Emit, LINE_WINDOW, Reading, Stage, samples};
use crate::analysis::{SlidingWindow, SpectrumAnalyser};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Record};
use crate::scene::SpectrumSpec;

/// Emits [`Record::Spectrum`].
///
/// Until the window is full the spectrum is taken of what is there, from a quarter of the window
/// on; its bins are then wider.
pub struct SpectrumStage {
    sliding: SlidingWindow<1>,
    analyser: SpectrumAnalyser,
}

impl SpectrumStage {
    /// For samples at `rate` (Hz).
    pub fn new(spec: &SpectrumSpec, rate: f64) -> Self {
        let length = samples(spec.sliding.window, rate, SpectrumAnalyser::FEWEST_SAMPLES);
        Self {
            sliding: SlidingWindow::new(length, spec.sliding.every * rate)
                .starting_with((length / 4).max(SpectrumAnalyser::FEWEST_SAMPLES)),
            analyser: SpectrumAnalyser::new(LINE_WINDOW, rate),
        }
    }
}

impl Stage for SpectrumStage {
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self { sliding, analyser } = self;
        sliding.space_out(frame.apart());
        sliding.push([&frame.velocity], |view| {
            let spectrum = analyser.analyse(view.channels[0])?;
            emit(Record::Spectrum {
                time: context.time(view.seen as f64 - 1.0),
                bin: spectrum.bin,
                peaks: Reading::of(&spectrum).peaks(),
                amplitude: spectrum.amplitude,
            })
        })
    }
}
