//! Results of a run from its last window.

use std::sync::Arc;

use super::stage::samples;
use super::tones::{LINE_WINDOW, NamedLines, half_range, peak_magnitude};
use crate::analysis::{
    regime::{RegimeSearch, Verdict, classify},
    sliding::History,
    tones::{Bases, SpectrumAnalyser},
};
use crate::dynamics::Attractor;
use crate::pipeline::message::{
    Exponents, Frame, Header, JointInfo, Record, Subject, Summary, regime_on,
};
use crate::scene::SpectrumSpec;

/// Ratio of peak velocity to sliding speed below which a vibration is quiet. A vibration that friction sustains grows to
/// about the sliding speed; this is 40 dB below.
const QUIET_RATIO: f64 = 0.01;

/// Length of the last window if the scene requests no spectrum, s.
const DEFAULT_WINDOW: f64 = 20e-3;
/// Length of the window that is classified if the scene requests no classification, s, and the displacement below which it
/// is silent, m.
const CLASSIFIED_WINDOW: f64 = 40e-3;
const SILENCE: f64 = 0.3e-9;

/// Keeps the last window, the counters and the last results of other stages.
pub struct SummaryStage {
    /// Velocity and displacement.
    last: History<2>,
    /// Number of their newest samples in the last window.
    window: usize,
    is_signal: bool,
    rate: f64,
    /// Peak velocity below which the vibration is at rest, m/s.
    rest: f64,
    /// Peak velocity below which it is quiet, m/s.
    quiet: f64,
    /// Counters, and the last results that the scene requests.
    so_far: Summary,
}

impl SummaryStage {
    /// Uses the window of the spectrum, if there is one, for the run described by `header`.
    pub fn new(spectrum: Option<&SpectrumSpec>, header: &Header) -> Self {
        let rate = header.sample_rate;
        let sliding = header.joint().map_or(0.0, JointInfo::largest_sliding_speed);
        let window = spectrum.map_or(DEFAULT_WINDOW, |spec| spec.window);
        let window = samples(window, rate, SpectrumAnalyser::MIN_SAMPLES);
        Self {
            last: History::new(window.max(samples(CLASSIFIED_WINDOW, rate, 1))),
            window,
            is_signal: matches!(header.subject, Subject::Signal(_)),
            rate,
            rest: header.rest_speed,
            quiet: header.silence().max(QUIET_RATIO * sliding),
            so_far: Summary::default(),
        }
    }

    /// Classifies the last displacement if the scene has not done so. The verdict on a signal from a file is not that of a
    /// run.
    fn classified(&self) -> Option<Arc<Verdict>> {
        if self.so_far.verdict.is_some() || self.is_signal {
            return self.so_far.verdict.clone();
        }
        let search = RegimeSearch {
            sample_rate: self.rate,
            silence: SILENCE,
            background: 0.0,
        };
        let [_, displacement] = self.last.view().channels;
        let latest = samples(CLASSIFIED_WINDOW, self.rate, 1).min(displacement.len());
        let latest = &displacement[displacement.len() - latest..];
        classify(latest, &search).ok().map(Arc::new)
    }

    /// Adds a frame and the records of the other stages for it.
    pub fn push(&mut self, frame: &Frame, records: &[Record]) {
        self.last.push([&frame.velocity, &frame.displacement]);
        self.so_far.stats = frame.stats;
        self.so_far.transitions += frame.transitions;
        for record in records {
            match record {
                Record::Regime { verdict, .. } => self.so_far.verdict = Some(Arc::clone(verdict)),
                Record::Exponents(found) => self.so_far.exponents = Some(found.as_ref().clone()),
                Record::TrajectoryDivergence(found) => self.so_far.divergence = Some(*found),
                _ => {}
            }
        }
    }

    /// The last exponents, if they decide on an attractor.
    pub fn decided_exponents(&self) -> Option<&Exponents> {
        let exponents = self.so_far.exponents.as_ref();
        exponents.filter(|exponents| exponents.attractor().is_decided())
    }

    /// Whether the intervals of all exponents are negative. A vibration that friction does not sustain then decays, even if
    /// the average is too short to tell its slowest decay from a zero exponent.
    fn decays(&self) -> bool {
        let exponents = self.so_far.exponents.as_ref();
        let exponents = exponents.map_or(&[][..], |found| &found.spectrum.exponents);
        !exponents.is_empty() && exponents.iter().all(|exponent| exponent.high() < 0.0)
    }

    /// Type of motion, spectral lines, amplitude, peak velocity, and what is known so far. A run too short for a spectrum
    /// has no lines, and neither has a vibration at rest.
    pub fn summary(&self) -> Summary {
        let mut summary = self.so_far.clone();
        let last = self.last.view().channels;
        let [velocity, displacement] =
            last.map(|samples| &samples[samples.len().saturating_sub(self.window)..]);
        summary.peak_velocity_m_per_s = peak_magnitude(velocity);
        summary.quiet = !velocity.is_empty() && summary.peak_velocity_m_per_s < self.quiet;
        summary.at_rest = !velocity.is_empty() && summary.peak_velocity_m_per_s < self.rest;
        if !summary.at_rest {
            let spectrum = SpectrumAnalyser::new(LINE_WINDOW, self.rate).analyse(velocity);
            let lines = spectrum.map(|spectrum| NamedLines::following(&spectrum, Bases::None));
            summary.lines = lines.map_or_else(|_| Vec::new(), |lines| lines.peaks_above(self.rest));
        }
        let verdict = self.classified();
        if summary.at_rest {
            summary.motion = Some("at rest".to_owned());
        } else if let Some(exponents) = self.decided_exponents() {
            summary.motion = Some(type_of(exponents.attractor()));
        } else if summary.quiet && self.decays() {
            summary.motion = Some(type_of(Attractor::FixedPoint));
        } else if let Some(verdict) = &verdict {
            summary.motion_confidence = verdict.decided_confidence();
            summary.motion = Some(verdict.name());
        }
        summary.verdict = verdict;
        summary.amplitude_m = half_range(displacement);
        summary
    }
}

/// The type of motion on an attractor, in the words of a classification where it has one.
fn type_of(attractor: Attractor) -> String {
    regime_on(attractor).map_or_else(|| attractor.to_string(), |regime| regime.to_string())
}
