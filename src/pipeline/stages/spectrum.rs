//! Sliding amplitude spectrum of the probe's velocity, and the words on what it shows.

use super::narration::{Narrator, Observation};
use super::{Clock, Emit, LINE_WINDOW, Reading, half_range, peak_magnitude, samples};
use crate::analysis::{SlidingWindow, SpectrumAnalyser};
use crate::pipeline::AnalyseError;
use crate::pipeline::message::{Frame, Header, Record};
use crate::scene::SpectrumSpec;

/// Emits [`Record::Spectrum`], and [`Record::Narration`] when there is something new to say.
///
/// Until the window is full the spectrum is taken of what is there, from a quarter of the window
/// on; its bins are then wider.
pub struct SpectrumStage {
    /// Velocity and displacement, side by side.
    sliding: SlidingWindow<2>,
    analyser: SpectrumAnalyser,
    narrator: Narrator,
    rate: f64,
}

impl SpectrumStage {
    /// The stage of a run announced by `header`.
    pub fn new(spec: &SpectrumSpec, header: &Header) -> Self {
        let rate = header.sample_rate;
        let length = samples(spec.window, rate, SpectrumAnalyser::FEWEST_SAMPLES);
        Self {
            sliding: SlidingWindow::new(length, spec.every * rate)
                .starting_with((length / 4).max(SpectrumAnalyser::FEWEST_SAMPLES)),
            analyser: SpectrumAnalyser::new(LINE_WINDOW, rate),
            narrator: Narrator::new(header.sliding_speed),
            rate,
        }
    }

    /// Takes the next frame.
    pub fn push(
        &mut self,
        frame: &Frame,
        clock: &Clock,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        let Self {
            sliding,
            analyser,
            narrator,
            rate,
        } = self;
        sliding.push([&frame.velocity, &frame.displacement], |view| {
            let [velocity, displacement] = view.channels;
            let spectrum = analyser.analyse(velocity)?;
            let reading = Reading::of(&spectrum);
            let time = clock.time(view.seen as f64 - 1.0);
            let said = narrator.observe(&Observation {
                time,
                tilt: frame.tilt,
                reading: &reading,
                velocity,
                sample_rate: *rate,
                amplitude: half_range(displacement),
                peak_velocity: peak_magnitude(velocity),
            });
            emit(Record::Spectrum {
                time,
                bin: spectrum.bin,
                peaks: reading.peaks(),
                amplitude: spectrum.amplitude,
            })?;
            match said {
                Some(text) => emit(Record::Narration { time, text }),
                None => Ok(()),
            }
        })
    }
}
