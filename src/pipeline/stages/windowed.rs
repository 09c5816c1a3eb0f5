//! Analysis of a sliding window, the form of most stages.

use std::borrow::Cow;

use super::clock::samples;
use super::stage::{Context, Stage};
use crate::analysis::{AnalysisError, sliding::SlidingWindow};
use crate::pipeline::message::{Frame, Record};

/// A window of `C` channels that is due.
pub struct Window<'a, const C: usize> {
    /// Samples of each channel, oldest first.
    pub channels: [&'a [f64]; C],
    /// Number of samples of the run up to the newest sample of the window.
    pub seen: u64,
    /// Time of the newest sample, s.
    pub time: f64,
    /// Frame that contains the end of the window.
    pub frame: &'a Frame,
}

/// Channels of input signals of an analysis from one frame.
pub type Channels<'a, const C: usize> = [Cow<'a, [f64]>; C];

/// Displacement of the probe.
pub fn displacement(frame: &Frame) -> Channels<'_, 1> {
    [Cow::Borrowed(&frame.displacement)]
}

/// Velocity of the probe.
pub fn velocity(frame: &Frame) -> Channels<'_, 1> {
    [Cow::Borrowed(&frame.velocity)]
}

/// Marks a closure as an input. The compiler infers its lifetimes only if it is passed to a function.
pub fn input<const C: usize, I>(input: I) -> I
where
    I: for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
{
    input
}

/// A window of a length (s), evaluated at an interval (s), for samples at `rate` (Hz), at least one sample long.
pub fn sliding(window: f64, every: f64, rate: f64) -> SlidingWindow<1> {
    SlidingWindow::new(samples(window, rate, 1), every * rate)
}

/// Calls `analyse`, which returns records, for each window of the signals that `input` extracts from the frames. In a live run,
/// windows whose ends are too close ([`DisplayRates::apart`](crate::pipeline::message::DisplayRates::apart)) are skipped, and with a budget those for which there
/// is no time ([`Context::rate_divisor`]), unless the stage is [complete](Windowed::complete).
pub struct Windowed<const C: usize, I, A> {
    sliding: SlidingWindow<C>,
    input: I,
    analyse: A,
    /// Number of samples of the run per sample of `input`.
    step: u64,
    /// Whether every window is analysed even in a live run and with a budget.
    complete: bool,
}

impl<const C: usize, I, A, R> Windowed<C, I, A>
where
    I: for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
    A: FnMut(Window<'_, C>, &mut Context) -> Result<R, AnalysisError> + Send,
{
    /// A stage that analyses the windows of `sliding`.
    pub fn new(sliding: SlidingWindow<C>, input: I, analyse: A) -> Self {
        Self {
            sliding,
            input,
            analyse,
            step: 1,
            complete: false,
        }
    }

    /// The same stage for an input with every `step`-th sample of the run, including the first one.
    pub fn with_step(self, step: usize) -> Self {
        let step = step as u64;
        Self { step, ..self }
    }

    /// The same stage without skipped windows, for results that a lesson, a panel or a commentary reports.
    pub fn complete(self) -> Self {
        let complete = true;
        Self { complete, ..self }
    }
}

impl<const C: usize, I, A, R> Stage for Windowed<C, I, A>
where
    I: for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
    A: FnMut(Window<'_, C>, &mut Context) -> Result<R, AnalysisError> + Send,
    R: IntoIterator<Item = Record>,
{
    fn push(&mut self, frame: &Frame, context: &mut Context) -> Result<(), AnalysisError> {
        if !self.complete {
            self.sliding.min_spacing = frame.shown.map_or(0, |shown| shown.apart) / self.step;
            self.sliding.divisor = context.rate_divisor;
        }
        let channels = (self.input)(frame);
        let (analyse, step) = (&mut self.analyse, self.step);
        self.sliding
            .push(channels.each_ref().map(|x| &**x), |view| {
                let seen = (view.seen - 1) * step + 1;
                let window = Window {
                    channels: view.channels,
                    seen,
                    time: context.clock.time(seen as f64 - 1.0),
                    frame,
                };
                let records = analyse(window, context)?;
                context.records.extend(records);
                Ok(())
            })
    }
}
