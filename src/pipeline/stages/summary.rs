//! Results of a run from its last window.

use super::clock::samples;
use super::named_lines::{LINE_WINDOW, NamedLines, half_range, is_at_rest, peak_magnitude};
use super::stage::{Context, Emit, Stage};
use crate::analysis::{History, SpectrumAnalyser};
use crate::dynamics::SolverStats;
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::{Frame, Header, Summary};
use crate::scene::SpectrumSpec;

/// Length of the last window if the scene requests no spectrum, s.
const DEFAULT_WINDOW: f64 = 20e-3;

/// Keeps the last window and the counters. Present in every run, since each run has a summary.
pub struct SummaryStage {
    /// Velocity and displacement.
    last: History<2>,
    rate: f64,
    /// Peak velocity below which the vibration is at rest, m/s.
    rest: f64,
    stats: SolverStats,
    transitions: u64,
}

impl SummaryStage {
    /// Uses the window of the spectrum, if there is one, for the run described by `header`.
    pub fn new(spectrum: Option<&SpectrumSpec>, header: &Header) -> Self {
        let rate = header.sample_rate;
        let window = spectrum.map_or(DEFAULT_WINDOW, |spec| spec.sliding.window);
        Self {
            last: History::new(samples(window, rate, SpectrumAnalyser::MIN_SAMPLES)),
            rate,
            rest: header.rest_speed,
            stats: SolverStats::default(),
            transitions: 0,
        }
    }
}

impl Stage for SummaryStage {
    fn push(
        &mut self,
        frame: &Frame,
        _context: &mut Context,
        _emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        self.last.push([&frame.velocity, &frame.displacement]);
        self.stats = frame.stats;
        self.transitions += frame.transitions;
        Ok(())
    }

    /// Adds spectral lines, amplitude, peak velocity, solver statistics and transitions. A run too short for
    /// a spectrum has no lines, and neither has a vibration at rest.
    fn summarise(&self, summary: &mut Summary) {
        let [velocity, displacement] = self.last.view().channels;
        summary.peak_velocity = peak_magnitude(velocity);
        summary.at_rest = !velocity.is_empty() && is_at_rest(velocity, self.rest);
        if !summary.at_rest {
            let spectrum = SpectrumAnalyser::new(LINE_WINDOW, self.rate).analyse(velocity);
            let named = spectrum.map(|spectrum| NamedLines::of(&spectrum).peaks_above(self.rest));
            summary.peaks = named.unwrap_or_default();
        }
        summary.amplitude = half_range(displacement);
        summary.stats = self.stats;
        summary.transitions = self.transitions;
    }
}
