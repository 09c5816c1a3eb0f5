//! The analysis of a sliding window, the form of most stages.

use std::borrow::Cow;

use super::clock::samples;
use super::stage::{Context, Emit, Stage};
use crate::analysis::SlidingWindow;
use crate::pipeline::error::AnalyseError;
use crate::pipeline::message::Frame;
use crate::scene::SlidingSpec;

/// A window that is due, of `C` channels.
pub struct Window<'a, const C: usize> {
    /// The samples of each channel, oldest first.
    pub channels: [&'a [f64]; C],
    /// Samples of the run up to the newest one of the window.
    pub seen: u64,
    /// Time of the newest sample, s.
    pub time: f64,
    /// The frame in which the window ends.
    pub frame: &'a Frame,
}

/// The signals of a frame that an analysis takes.
pub type Channels<'a, const C: usize> = [Cow<'a, [f64]>; C];

/// The displacement of the probe.
pub fn displacement(frame: &Frame) -> Channels<'_, 1> {
    [Cow::Borrowed(&frame.displacement)]
}

/// The velocity of the probe.
pub fn velocity(frame: &Frame) -> Channels<'_, 1> {
    [Cow::Borrowed(&frame.velocity)]
}

/// A closure as an input: the compiler infers no lifetimes for one that is not passed to a function.
pub fn input<const C: usize, I>(input: I) -> I
where
    I: for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
{
    input
}

/// The windows that a scene asks for of samples at `rate` (Hz), of one sample at least.
pub fn sliding(spec: &SlidingSpec, rate: f64) -> SlidingWindow<1> {
    SlidingWindow::new(samples(spec.window, rate, 1), spec.every * rate)
}

/// Calls `analyse` for each window of what `input` takes from the frames. While the run is shown live,
/// windows that end too close together ([`Frame::apart`]) are skipped.
pub struct Windowed<const C: usize, I, A> {
    sliding: SlidingWindow<C>,
    input: I,
    analyse: A,
    /// One sample of `input` for so many of the run.
    step: u64,
    /// Whether each window is analysed, also while the run is shown live.
    complete: bool,
}

impl<const C: usize, I, A> Windowed<C, I, A>
where
    I: for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
    A: FnMut(Window<'_, C>, &mut Context, &mut Emit<'_>) -> Result<(), AnalyseError> + Send,
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

    /// The same for an input of every `step`-th sample of the run, the first one included.
    pub fn with_step(self, step: usize) -> Self {
        let step = step as u64;
        Self { step, ..self }
    }

    /// The same, no window skipped.
    pub fn complete(self) -> Self {
        let complete = true;
        Self { complete, ..self }
    }
}

impl<const C: usize, I, A> Stage for Windowed<C, I, A>
where
    I: for<'f> FnMut(&'f Frame) -> Channels<'f, C> + Send,
    A: FnMut(Window<'_, C>, &mut Context, &mut Emit<'_>) -> Result<(), AnalyseError> + Send,
{
    fn push(
        &mut self,
        frame: &Frame,
        context: &mut Context,
        emit: &mut Emit<'_>,
    ) -> Result<(), AnalyseError> {
        if !self.complete {
            self.sliding.space_out(frame.apart() / self.step);
        }
        let channels = (self.input)(frame);
        let (analyse, step) = (&mut self.analyse, self.step);
        self.sliding
            .push(channels.each_ref().map(|x| &**x), |view| {
                let seen = (view.seen - 1) * step + 1;
                let window = Window {
                    channels: view.channels,
                    seen,
                    time: context.newest(seen),
                    frame,
                };
                analyse(window, context, emit)
            })
    }
}
