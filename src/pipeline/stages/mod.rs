//! Analysis stages. Each keeps the samples that it needs and emits records at its own times.

mod appearance;
mod chaos;
mod chatter;
mod choices;
mod clock;
mod delay;
mod divergence;
mod exponents;
mod lesson;
mod named_lines;
mod narration;
mod quantification;
mod recurrence;
mod reduction;
mod regime;
mod section;
mod spectrogram;
mod spectrum;
mod stage;
mod subsample;
mod summary;
#[cfg(test)]
pub(super) mod synthetic_tests;
mod windowed;

pub use stage::{Context, Stage};

use chatter::ChatterStage;
use divergence::DivergenceStage;
use exponents::ExponentsStage;
use lesson::LessonStage;
use reduction::ReductionStage;
use summary::SummaryStage;

use super::message::Header;
use crate::scene::AnalysisSpec;

/// The stages of a run, in order. Each stage observes the records of the stages before it.
pub fn stages(spec: &AnalysisSpec, header: &Header) -> Vec<Box<dyn Stage>> {
    let rate = header.sample_rate;
    let delay = spec.delay.as_ref();
    let joint = header.joint();
    let rest = header.rest_speed;
    let summary = SummaryStage::new(spec.spectrum.as_ref(), header);
    let stages = [
        boxed(&spec.spectrum, |spec| spectrum::spectrum(spec, rate, rest)),
        // Only a sliding joint is described.
        boxed(&spec.spectrum.zip(joint), |(spec, joint)| {
            narration::narration(spec.sliding.every, joint, header)
        }),
        boxed(&spec.spectrogram, |spec| {
            spectrogram::spectrogram(spec, rate)
        }),
        // Before the stages that use its choice.
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
        boxed(&spec.perturbed_trajectory, |spec| {
            DivergenceStage::new(*spec, rate)
        }),
        boxed(&joint, |_| ChatterStage::default()),
        boxed(&joint, |_| ReductionStage::default()),
        LessonStage::new(spec, header).map(|stage| Box::new(stage) as Box<dyn Stage>),
        Some(Box::new(summary) as Box<dyn Stage>),
    ];
    stages.into_iter().flatten().collect()
}

/// The stage for a specification, if there is one.
fn boxed<T, S: Stage + 'static>(
    spec: &Option<T>,
    stage: impl FnOnce(&T) -> S,
) -> Option<Box<dyn Stage>> {
    let stage = spec.as_ref().map(stage)?;
    Some(Box::new(stage))
}
