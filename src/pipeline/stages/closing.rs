//! The results of the run, from its last window.

use super::clock::samples;
use super::reading::{LINE_WINDOW, Reading, half_range, peak_magnitude};
use super::stage::{Context, Emit, Stage};
use crate::analysis::{History, SpectrumAnalyser};
use crate::dynamics::Tally;
use crate::pipeline::error::AnalyseError;
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
        let window = spectrum.map_or(DEFAULT_WINDOW, |spec| spec.sliding.window);
        Self {
            last: History::new(samples(window, rate, SpectrumAnalyser::FEWEST_SAMPLES)),
            rate,
            tally: Tally::default(),
            transitions: 0,
        }
    }
}

impl Stage for ClosingStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        _emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        self.last.push([&frame.velocity, &frame.displacement]);
        self.tally = frame.tally;
        self.transitions += frame.transitions;
        Ok(())
    }

    /// The lines, amplitude, peak velocity, tally and transitions. A run too short for a spectrum has no
    /// lines.
    fn summarise(&self, summary: &mut Summary) {
        let [velocity, displacement] = self.last.view().channels;
        let spectrum = SpectrumAnalyser::new(LINE_WINDOW, self.rate).analyse(velocity);
        summary.peaks = spectrum.map_or_else(|_| Vec::new(), |s| Reading::of(&s).peaks());
        summary.amplitude = half_range(displacement);
        summary.peak_velocity = peak_magnitude(velocity);
        summary.tally = self.tally;
        summary.transitions = self.transitions;
    }
}
