//! Sources of frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::PipelineError;
use super::message::{AnalysisKind, Frame, Header};
use crate::scene::{AnalysisSpec, SectionSurface, StateCoordinate};

/// Yields the frames of a run: a [`Simulation`](super::Simulation), or the [`SignalSource`](super::SignalSource) of a
/// recorded signal.
pub trait Source: Send {
    /// The data known before the first frame. `command` is the command line.
    fn header(&self, command: &str) -> Header;

    /// The analyses of the run.
    fn analysis(&self) -> &AnalysisSpec;

    /// Sets a flag that stops the run once it is true. The present frame then ends with the last computed
    /// sample. A source whose frames take no time may ignore it.
    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        let _ = stop;
    }

    /// The next frame, which starts where the previous one ended; `None` after the last frame, and if the run
    /// was stopped before the first sample of the frame.
    ///
    /// # Errors
    /// If the next frame cannot be computed.
    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError>;

    /// Whether the last frame has been returned.
    fn is_finished(&self) -> bool;
}

/// The analyses that are switched on, for a header.
pub(super) fn kinds(spec: &AnalysisSpec) -> Vec<AnalysisKind> {
    let kinds = [
        (AnalysisKind::Spectrum, spec.spectrum.is_some()),
        (AnalysisKind::Spectrogram, spec.spectrogram.is_some()),
        (AnalysisKind::Recurrence, spec.recurrence.is_some()),
        (AnalysisKind::Delay, spec.delay.is_some()),
        (AnalysisKind::Quantification, spec.quantification.is_some()),
        (AnalysisKind::Section, spec.section.is_some()),
        (AnalysisKind::Chaos, spec.chaos.is_some()),
        (AnalysisKind::Regime, spec.regime.is_some()),
        (AnalysisKind::Exponents, spec.exponents.is_some()),
        (
            AnalysisKind::PerturbedTrajectory,
            spec.perturbed_trajectory.is_some(),
        ),
    ];
    let kinds = kinds.into_iter();
    kinds.filter_map(|(kind, on)| on.then_some(kind)).collect()
}

/// The coordinates of section points, for a header.
pub(super) fn section_coordinates(spec: &AnalysisSpec) -> Option<[StateCoordinate; 2]> {
    match spec.section.as_ref()?.surface {
        SectionSurface::State { shown, .. } => Some(shown),
        SectionSurface::Delay { .. } => None,
    }
}
