//! What the run came to, from its last window.

use super::{LINE_WINDOW, Reading, half_range, peak_magnitude, samples};
use crate::analysis::{History, SpectrumAnalyser};
use crate::dynamics::Tally;
use crate::pipeline::message::{Frame, Summary};
use crate::scene::SpectrumSpec;

/// The last window where no spectrum is asked for, s.
const DEFAULT_WINDOW: f64 = 20e-3;

/// Keeps the last window and the counters; always there, since every run ends with a summary.
pub struct ClosingStage {
    /// Velocity and displacement, side by side.
    last: History<2>,
    rate: f64,
    tally: Tally,
    transitions: u64,
}

impl ClosingStage {
    /// With the spectrum's window, if there is one, of samples at `rate` (Hz).
    pub fn new(spectrum: Option<&SpectrumSpec>, rate: f64) -> Self {
        let length = samples(
            spectrum.map_or(DEFAULT_WINDOW, |spec| spec.sliding.window),
            rate,
            SpectrumAnalyser::FEWEST_SAMPLES,
        );
        Self {
            last: History::new(length),
            rate,
            tally: Tally::default(),
            transitions: 0,
        }
    }

    /// Takes the next frame.
    pub fn push(&mut self, frame: &Frame) {
        self.last.push([&frame.velocity, &frame.displacement]);
        self.tally = frame.tally;
        self.transitions += frame.transitions;
    }

    /// The lines, amplitude, peak velocity, tally and transitions; the rest is default. A run too
    /// short for a spectrum has no lines.
    pub fn summary(&self) -> Summary {
        let [velocity, displacement] = self.last.view().channels;
        let spectrum = SpectrumAnalyser::new(LINE_WINDOW, self.rate).analyse(velocity);
        Summary {
            peaks: spectrum.map_or_else(|_| Vec::new(), |s| Reading::of(&s).peaks()),
            amplitude: half_range(displacement),
            peak_velocity: peak_magnitude(velocity),
            tally: self.tally,
            transitions: self.transitions,
            ..Summary::default()
        }
    }
}
