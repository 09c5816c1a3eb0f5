//! Analysis stages. Each keeps the samples that it needs and emits records at its own times.

mod appearance;
mod divergence;
mod embedding;
mod regime;
mod section;
mod stage;
mod summary;
#[cfg(test)]
pub(super) mod synthetic_tests;
mod tones;

pub use stage::{Clock, Context, Stage, StageGroup, samples};
pub use summary::SummaryStage;

use super::message::Header;
use crate::scene::{AnalysisSpec, EmbeddingSpec, SectionSurface};

/// The groups of stages of a run, in the order of their records. Groups do not depend on each other.
pub fn stages(spec: &AnalysisSpec, header: &Header) -> Vec<StageGroup> {
    let rate = header.sample_rate;
    let delay = spec.delay.as_ref();
    let mut groups: Vec<Vec<Stage>> = Vec::new();
    if let Some(spec) = &spec.spectrum {
        let spectrum = tones::spectrum(spec, rate, header.rest_speed);
        // Only a sliding joint is described, with the names of the lines of the spectrum.
        let joint = header.joint();
        let narration = joint.map(|joint| tones::narration(spec.every, joint, header));
        groups.push([spectrum].into_iter().chain(narration).collect());
    }
    if let Some(spec) = &spec.spectrogram {
        groups.push(vec![tones::spectrogram(spec, rate)]);
    }
    let (recurrence, quantification) = (spec.recurrence, spec.quantification);
    let section = spec.section.as_ref();
    let unfolded = [
        // Before the stages that use its choice.
        delay.map(|spec| embedding::delay(spec, rate)),
        recurrence.map(|spec| embedding::recurrence(&spec, delay, rate)),
        quantification.map(|spec| embedding::quantification(&spec, delay, rate)),
        section.map(|spec| section::section(spec, delay, rate)),
        spec.chaos.map(|spec| embedding::chaos(&spec, delay, rate)),
    ];
    let unfolded = unfolded.into_iter().flatten();
    if needs_choice(spec) {
        groups.push(unfolded.collect());
    } else {
        groups.extend(unfolded.map(|stage| vec![stage]));
    }
    if let Some(spec) = &spec.regime {
        groups.push(vec![regime::regime(spec, rate)]);
    }
    if let Some(spec) = spec.perturbed_trajectory {
        groups.push(vec![divergence::divergence(spec, rate)]);
    }
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
