//! Analysis stages. Each keeps the samples that it needs and emits records at its own times.

mod appearance;
mod chaos;
mod choices;
mod clock;
mod delay;
mod divergence;
mod lesson;
mod named_lines;
mod narration;
mod quantification;
mod recurrence;
mod regime;
mod section;
mod spectrogram;
mod spectrum;
mod stage;
mod summary;
#[cfg(test)]
pub(super) mod synthetic_tests;
mod windowed;

pub use clock::Clock;
pub use lesson::LessonStage;
pub use stage::{Context, Stage, StageGroup};
pub use summary::SummaryStage;

use divergence::DivergenceStage;

use super::message::Header;
use crate::scene::{AnalysisSpec, EmbeddingSpec, SectionSurface};

/// The groups of stages of a run, in the order of their records. Groups do not depend on each other.
pub fn stages(spec: &AnalysisSpec, header: &Header) -> Vec<StageGroup> {
    let rate = header.sample_rate;
    let delay = spec.delay.as_ref();
    let joint = header.joint();
    let rest = header.rest_speed;
    let tones = [
        boxed(&spec.spectrum, |spec| spectrum::spectrum(spec, rate, rest)),
        // Only a sliding joint is described, with the names of the lines of the spectrum.
        boxed(&spec.spectrum.zip(joint), |(spec, joint)| {
            narration::narration(spec.every, joint, header)
        }),
    ];
    let spectrogram = boxed(&spec.spectrogram, |spec| {
        spectrogram::spectrogram(spec, rate)
    });
    let unfolded = [
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
    ];
    let regime = boxed(&spec.regime, |spec| regime::regime(spec, rate));
    let divergence = boxed(&spec.perturbed_trajectory, |spec| {
        DivergenceStage::new(*spec, rate)
    });
    let mut groups: Vec<Vec<_>> = vec![tones.into_iter().flatten().collect()];
    groups.push(spectrogram.into_iter().collect());
    if needs_choice(spec) {
        groups.push(unfolded.into_iter().flatten().collect())
    } else {
        groups.extend(unfolded.into_iter().flatten().map(|stage| vec![stage]))
    }
    groups.push(regime.into_iter().collect());
    groups.push(divergence.into_iter().collect());
    groups.retain(|stages| !stages.is_empty());
    let group = |stages| StageGroup {
        context: Context::new(rate),
        stages,
    };
    groups.into_iter().map(group).collect()
}

/// Whether a stage uses the delay or the dimension that the delay analysis chooses.
fn needs_choice(spec: &AnalysisSpec) -> bool {
    let embeddings = [
        spec.recurrence.map(|spec| spec.embedding),
        spec.quantification.map(|spec| spec.embedding),
        spec.chaos.map(|spec| spec.embedding),
    ];
    let is_chosen =
        |embedding: &EmbeddingSpec| embedding.lag.is_none() || embedding.dimension.is_none();
    let surface = spec.section.as_ref().map(|spec| &spec.surface);
    let chosen_section = matches!(surface, Some(SectionSurface::Delay { lag: None, .. }));
    chosen_section || embeddings.iter().flatten().any(is_chosen)
}

/// The stage for a specification, if there is one.
fn boxed<T, S: Stage + 'static>(
    spec: &Option<T>,
    stage: impl FnOnce(&T) -> S,
) -> Option<Box<dyn Stage>> {
    let stage = spec.as_ref().map(stage)?;
    Some(Box::new(stage))
}
