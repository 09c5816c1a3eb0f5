//! Analyses that run one after the other on the same thread, and the state that they share.

use super::embedding::DelayChoices;
use crate::analysis::{AnalysisError, sliding::SlidingWindow, tones::Bases};
use crate::pipeline::message::{Frame, Record};

/// An analysis stage: it takes the frames of a run, one by one, and adds records to the context.
pub type Stage = Box<dyn FnMut(&Frame, &mut Context) -> Result<(), AnalysisError> + Send>;

/// The context of a stage: state shared by the stages of a group.
pub struct Context {
    /// Times of the samples.
    pub clock: Clock,
    /// Delays and dimensions chosen so far.
    pub choices: DelayChoices,
    /// Base frequencies of the lines of the last spectrum: other stages use the same names.
    pub bases: Bases,
    /// Broadband share of the last spectrum; 1 if its window is not full, or too short for a floor between lines.
    pub floor: f64,
    /// Every so many windows of an analysis that is only displayed are computed.
    pub rate_divisor: u64,
    /// Records of the present frame so far.
    pub records: Vec<Record>,
}

impl Context {
    /// For samples at `rate` (Hz).
    pub fn new(rate: f64) -> Self {
        Self {
            clock: Clock::new(rate),
            choices: DelayChoices::default(),
            bases: Bases::None,
            floor: 1.0,
            rate_divisor: 1,
            records: Vec::new(),
        }
    }

    /// Limits the windows of an analysis that is only displayed: in a live run those whose ends are too close
    /// ([`DisplayRates::apart`](crate::pipeline::message::DisplayRates::apart)) are skipped, and with a budget those for
    /// which there is no time. `step` is the number of samples of the run per sample of the window.
    pub fn limit(&self, sliding: &mut SlidingWindow<1>, frame: &Frame, step: u64) {
        sliding.min_spacing = frame.shown.map_or(0, |shown| shown.apart) / step;
        sliding.divisor = self.rate_divisor;
    }
}

/// A group of stages with a common context.
pub struct StageGroup {
    /// State shared by the stages.
    pub context: Context,
    /// The stages, each after those whose choices it uses.
    pub stages: Vec<Stage>,
}

impl StageGroup {
    /// The records of the next frame.
    pub fn analyse(&mut self, frame: &Frame) -> Result<Vec<Record>, AnalysisError> {
        let Self { context, stages } = self;
        context.clock.advance(frame);
        stages
            .iter_mut()
            .try_for_each(|stage| stage(frame, context))?;
        Ok(std::mem::take(&mut context.records))
    }
}

/// A window of a signal that is due.
pub struct Window<'a> {
    /// Samples, oldest first.
    pub signal: &'a [f64],
    /// Number of samples of the run up to the newest sample of the window.
    pub seen: u64,
    /// Time of the newest sample, s.
    pub time: f64,
}

/// Displacement of the probe.
pub fn displacement(frame: &Frame) -> &[f64] {
    &frame.displacement
}

/// Velocity of the probe.
pub fn velocity(frame: &Frame) -> &[f64] {
    &frame.velocity
}

/// A stage that calls `analyse` for each window of a signal. `is_limited` says that the results are only displayed, see
/// [`Context::limit`]; results that a lesson, a panel or a commentary reports are complete.
pub fn windowed(
    signal: fn(&Frame) -> &[f64],
    mut sliding: SlidingWindow<1>,
    is_limited: bool,
    mut analyse: impl FnMut(&Window<'_>, &mut Context) -> Result<(), AnalysisError> + Send + 'static,
) -> Stage {
    Box::new(move |frame, context| {
        if is_limited {
            context.limit(&mut sliding, frame, 1);
        }
        sliding.push([signal(frame)], |view| {
            let window = Window {
                signal: view.channels[0],
                seen: view.seen,
                time: context.clock.time(view.seen as f64 - 1.0),
            };
            analyse(&window, context)
        })
    })
}

/// Time of every sample of the run from its index. Rounding errors do not accumulate.
#[derive(Clone, Copy)]
pub struct Clock {
    dt: f64,
    origin: Option<f64>,
    seen: u64,
}

impl Clock {
    /// For samples at `rate` (Hz). The first frame defines the origin.
    pub fn new(rate: f64) -> Self {
        Self {
            dt: 1.0 / rate,
            origin: None,
            seen: 0,
        }
    }

    /// Counts the samples of the next frame, which starts where the last one ended.
    pub fn advance(&mut self, frame: &Frame) {
        self.origin.get_or_insert(frame.t0);
        self.seen += frame.len() as u64;
    }

    /// Time of the sample with the (possibly fractional) index `k` of the run, s.
    pub fn time(&self, k: f64) -> f64 {
        self.origin.unwrap_or(0.0) + k * self.dt
    }

    /// Time of the newest sample, s.
    pub fn newest(&self) -> f64 {
        self.time(self.seen as f64 - 1.0)
    }

    /// Simulated time so far, s.
    pub fn elapsed(&self) -> f64 {
        self.seen as f64 * self.dt
    }
}

/// A time in samples, at least `least`.
pub fn samples(seconds: f64, rate: f64, least: usize) -> usize {
    ((seconds * rate).round() as usize).max(least)
}

/// A window of a length (s), evaluated at an interval (s), for samples at `rate` (Hz), at least one sample long.
pub fn sliding(window: f64, every: f64, rate: f64) -> SlidingWindow<1> {
    SlidingWindow::new(samples(window, rate, 1), every * rate)
}
