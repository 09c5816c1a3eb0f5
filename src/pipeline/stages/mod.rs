//! The stages of analysis: each keeps what it needs of the samples so far and emits records at
//! instants of its own.

mod butterfly;
mod chaos;
mod chatter;
mod choices;
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

use super::message::Header;
use crate::scene::AnalysisSpec;

/// The stages that a run needs, in their order: each observes the records of those before it.
pub fn stages(spec: &AnalysisSpec, header: &Header) -> Vec<Box<dyn Stage>> {
    let rate = header.sample_rate;
    let delay = spec.delay.as_ref();
    let joint = header.joint();
    let mut stages: Vec<Box<dyn Stage>> = Vec::new();
    if let Some(spec) = &spec.spectrum {
        stages.push(Box::new(spectrum::spectrum(spec, rate)));
        // The narration is of a joint that slides.
        if let Some(joint) = joint {
            stages.push(Box::new(narration::narration(spec.every, rate, joint)));
        }
    }
    if let Some(spec) = &spec.spectrogram {
        stages.push(Box::new(spectrogram::spectrogram(spec, rate)));
    }
    // Before those that take what it chooses.
    if let Some(spec) = delay {
        stages.push(Box::new(delay::delay(spec, rate)));
    }
    if let Some(spec) = &spec.recurrence {
        stages.push(Box::new(recurrence::recurrence(spec, delay, rate)));
    }
    if let Some(spec) = &spec.quantification {
        stages.push(Box::new(quantification::quantification(spec, delay, rate)));
    }
    if let Some(spec) = &spec.section {
        stages.push(section::section(spec, delay, rate));
    }
    if let Some(spec) = &spec.chaos {
        stages.push(Box::new(chaos::chaos(spec, delay, rate)));
    }
    if let Some(spec) = &spec.regime {
        stages.push(Box::new(regime::regime(spec, rate)));
    }
    if spec.exponents.is_some() {
        stages.push(Box::new(exponents::ExponentsStage::default()));
    }
    if let Some(spec) = spec.butterfly {
        stages.push(Box::new(butterfly::ButterflyStage::new(spec, rate)));
    }
    if joint.is_some() {
        stages.push(Box::new(chatter::ChatterStage::default()));
    }
    if let Some(lesson) = lesson::LessonStage::new(spec, header) {
        stages.push(Box::new(lesson));
    }
    stages.push(Box::new(closing::ClosingStage::new(
        spec.spectrum.as_ref(),
        rate,
    )));
    stages
}
