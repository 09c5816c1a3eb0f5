//! The stages of analysis: each keeps what it needs of the samples seen and emits records at
//! instants of its own.

mod butterfly;
mod chaos;
mod chatter;
mod choices;
mod closing;
mod delay;
mod exponents;
mod lesson;
mod line;
mod narration;
mod narrator;
mod quantification;
mod recurrence;
mod regime;
mod section;
mod spectrogram;
mod spectrum;
#[cfg(test)]
pub(super) mod synthetic;
mod thinning;
mod words;

pub use butterfly::ButterflyStage;
pub use chaos::ChaosStage;
pub use chatter::ChatterStage;
pub use choices::Choices;
pub use closing::ClosingStage;
pub use delay::DelayStage;
pub use exponents::ExponentsStage;
pub use lesson::LessonStage;
pub use narration::NarrationStage;
pub use quantification::QuantificationStage;
pub use recurrence::RecurrenceStage;
pub use regime::RegimeStage;
pub use section::SectionStage;
pub use spectrogram::SpectrogramStage;
pub use spectrum::SpectrumStage;

use super::analyse::AnalyseError;
use super::message::{Frame, Peak, Record, Summary};
use crate::analysis::{
    Combination, FREQUENCY_UNCERTAINTY, Line, LineCriterion, Naming, SlidingWindow, Spectrum,
    Window, name_lines, range,
};
use crate::scene::SlidingSpec;

/// Where a stage puts its records.
type Emit<'a> = dyn FnMut(Record) -> Result<(), AnalyseError> + 'a;

/// A stage: takes the frames of a run one by one.
pub trait Stage: Send {
    /// Takes the next frame.
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError>;

    /// Says what there is to say after the last frame; by default nothing.
    fn finish(&mut self, _context: &mut Context, _emit: &mut Emit<'_>) -> Result<(), AnalyseError> {
        Ok(())
    }

    /// Adds what it knows to the summary of the run; by default nothing.
    fn summarise(&self, _summary: &mut Summary) {}
}

/// What the stages share.
pub struct Context {
    /// The time of every sample.
    pub clock: Clock,
    /// Delays and dimensions chosen so far.
    pub choices: Choices,
}

impl Context {
    /// For samples at `rate` (Hz).
    pub fn new(rate: f64) -> Self {
        Self {
            clock: Clock::new(rate),
            choices: Choices::default(),
        }
    }

    /// See [`Clock::time`].
    fn time(&self, k: f64) -> f64 {
        self.clock.time(k)
    }

    /// Time of the newest of `seen` samples, s.
    fn newest(&self, seen: u64) -> f64 {
        self.clock.time(seen as f64 - 1.0)
    }
}

/// The window of all spectra whose lines are read: its side lobes hide nothing above -92 dB.
const LINE_WINDOW: Window = Window::BlackmanHarris;

/// The time of every sample of the run, from the first one; no sum, hence no drift.
pub struct Clock {
    dt: f64,
    origin: Option<f64>,
    seen: u64,
}

impl Clock {
    /// For samples at `rate` (Hz); starts with the first frame.
    pub fn new(rate: f64) -> Self {
        Self {
            dt: 1.0 / rate,
            origin: None,
            seen: 0,
        }
    }

    /// Checks that the frame goes on where the last one ended, to a hundredth of a sample.
    pub fn check(&mut self, frame: &Frame) -> Result<(), AnalyseError> {
        let origin = *self.origin.get_or_insert(frame.t0);
        let due = origin + self.seen as f64 * self.dt;
        let (late, off) = (frame.t0 - due, frame.dt - self.dt);
        let slack = 0.01 * self.dt;
        // Written so that NaN fails, too.
        if late.abs() <= slack && off.abs() * frame.len() as f64 <= slack {
            return Ok(());
        }
        Err(AnalyseError::Gap {
            index: frame.index,
            found: frame.t0,
            dt: frame.dt,
            sample: self.seen,
            due,
        })
    }

    /// Counts the samples of a frame that has been analysed.
    pub fn advance(&mut self, frame: &Frame) {
        self.seen += frame.len() as u64;
    }

    /// Time of the sample with the (possibly fractional) index `k` of the run, s.
    pub fn time(&self, k: f64) -> f64 {
        self.origin.unwrap_or(0.0) + k * self.dt
    }

    /// Time covered so far, s.
    pub fn elapsed(&self) -> f64 {
        self.seen as f64 * self.dt
    }
}

/// A time in samples, at least `least`.
fn samples(seconds: f64, rate: f64, least: usize) -> usize {
    ((seconds * rate).round() as usize).max(least)
}

/// The windows that a scene asks for of samples at `rate` (Hz), of one sample at least.
fn sliding(spec: &SlidingSpec, rate: f64) -> SlidingWindow<1> {
    SlidingWindow::new(samples(spec.window, rate, 1), spec.every * rate)
}

/// A spectrum's lines and how they read.
#[derive(Clone, Debug, PartialEq)]
struct Reading {
    lines: Vec<Line>,
    naming: Naming,
    /// See [`Spectrum::floor_share`].
    floor: f64,
}

impl Reading {
    fn of(spectrum: &Spectrum) -> Self {
        let lines = spectrum.lines(&LineCriterion::default());
        Self {
            naming: name_lines(&lines, FREQUENCY_UNCERTAINTY * spectrum.bin),
            floor: spectrum.floor_share(),
            lines,
        }
    }

    /// Amplitude of the strongest line that the second base takes part in, over that of the
    /// strongest line; 0 if there is none.
    fn second_tone(&self) -> f64 {
        let named = self.lines.iter().zip(&self.naming.names);
        let mut second = named.filter(|(_, name)| name.is_some_and(|name| name.m != 0));
        let line = second.next().map(|(line, _)| line);
        line.map_or(0.0, |line| line.amplitude / self.lines[0].amplitude)
    }

    fn peaks(&self) -> Vec<Peak> {
        let peak = |(line, name): (&Line, &Option<Combination>)| Peak {
            frequency: line.frequency,
            amplitude: line.amplitude,
            label: name.map_or_else(String::new, |name| name.to_string()),
        };
        self.lines
            .iter()
            .zip(&self.naming.names)
            .map(peak)
            .collect()
    }
}

/// The largest magnitude of a slice.
fn peak_magnitude(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| x.abs().max(m))
}

/// Half the peak-to-peak value of a slice; 0 if it is empty.
fn half_range(x: &[f64]) -> f64 {
    let [low, high] = range(x.iter().copied());
    if high > low { 0.5 * (high - low) } else { 0.0 }
}
