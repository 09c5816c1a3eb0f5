//! The stages of analysis: each keeps what it needs of the samples so far and emits records at
//! instants of its own.

mod butterfly;
mod chaos;
mod chatter;
mod choices;
mod clock;
mod closing;
mod delay;
mod exponents;
mod lesson;
mod narration;
mod narrator;
mod quantification;
mod reading;
mod recurrence;
mod regime;
mod section;
mod spectrogram;
mod spectrum;
mod stage;
#[cfg(test)]
pub(super) mod synthetic_tests;
mod thinning;
mod windowed;

pub use stage::{Context, Stage};

use butterfly::ButterflyStage;
use chatter::ChatterStage;
use closing::ClosingStage;
use exponents::ExponentsStage;
use lesson::LessonStage;

use super::message::Header;
use crate::scene::AnalysisSpec;

/// The stages that a run needs, in their order: each observes the records of those before it.
pub fn stages(spec: &AnalysisSpec, header: &Header) -> Vec<Box<dyn Stage>> {
    let rate = header.sample_rate;
    let delay = spec.delay.as_ref();
    let joint = header.joint();
    let closing = ClosingStage::new(spec.spectrum.as_ref(), rate);
    let stages = [
        boxed(&spec.spectrum, |spec| spectrum::spectrum(spec, rate)),
        // The narration is of a joint that slides.
        boxed(&spec.spectrum.zip(joint), |(spec, joint)| {
            narration::narration(spec.sliding.every, rate, joint)
        }),
        boxed(&spec.spectrogram, |spec| {
            spectrogram::spectrogram(spec, rate)
        }),
        // Before those that take what it chooses.
        boxed(&spec.delay, |spec| delay::delay(spec, rate)),
        boxed(&spec.recurrence, |spec| {
            recurrence::recurrence(spec, delay, rate)
        }),
        boxed(&spec.quantification, |spec| {
            quantification::quantification(spec, delay, rate)
        }),
        spec.section
            .as_ref()
            .map(|spec| section::section(spec, delay, rate)),
        boxed(&spec.chaos, |spec| chaos::chaos(spec, delay, rate)),
        boxed(&spec.regime, |spec| regime::regime(spec, rate)),
        boxed(&spec.exponents, |_| ExponentsStage::default()),
        boxed(&spec.butterfly, |spec| ButterflyStage::new(*spec, rate)),
        boxed(&joint, |_| ChatterStage::default()),
        LessonStage::new(spec, header).map(|stage| Box::new(stage) as Box<dyn Stage>),
        Some(Box::new(closing) as Box<dyn Stage>),
    ];
    stages.into_iter().flatten().collect()
}

/// The stage for what a scene asks for, if it does.
fn boxed<T, S: Stage + 'static>(
    spec: &Option<T>,
    stage: impl FnOnce(&T) -> S,
) -> Option<Box<dyn Stage>> {
    let stage = spec.as_ref().map(stage)?;
    Some(Box::new(stage))
}
