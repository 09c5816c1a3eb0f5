//! Where frames come from.

use std::sync::Arc;

use super::message::{AnalysisKind, Computed, Frame, Header, SectionCoordinate, Subject};
use super::{PipelineError, Simulation, SmallSimulation};
use crate::scene::{AnalysisSpec, Scene, SectionSurface, StateCoordinate, SubjectSpec};

/// Gives the frames of a run, one after another: a [`Simulation`](super::Simulation), or the
/// [`Playback`](super::Playback) of a signal that somebody else made.
pub trait Source: Send {
    /// What is known before the first frame; `command` says how the program was started.
    fn header(&self, command: &str) -> Header;

    /// The analyses of the run.
    fn analysis(&self) -> &AnalysisSpec;

    /// The next frame, which starts where the last one ended; `None` after the last one.
    ///
    /// # Errors
    /// When there is a next frame, but it cannot be made.
    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError>;

    /// Whether the last frame has been given.
    fn is_over(&self) -> bool;
}

/// The simulation of what a scene runs.
///
/// # Errors
/// As [`Simulation::new`] and [`SmallSimulation::new`].
pub fn source(scene: &Scene) -> Result<Box<dyn Source>, PipelineError> {
    Ok(match scene.subject {
        SubjectSpec::Joint(_) => Box::new(Simulation::new(scene)?),
        SubjectSpec::Small(_) => Box::new(SmallSimulation::new(scene)?),
    })
}

impl Source for Box<dyn Source> {
    fn header(&self, command: &str) -> Header {
        self.as_ref().header(command)
    }

    fn analysis(&self) -> &AnalysisSpec {
        self.as_ref().analysis()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        self.as_mut().next_frame()
    }

    fn is_over(&self) -> bool {
        self.as_ref().is_over()
    }
}

/// The header of a scene's run; `command` says how the program was started, `computed` is what was
/// computed of its mechanism.
pub(super) fn header(
    scene: &Scene,
    command: &str,
    subject: Subject,
    computed: Option<Arc<Computed>>,
) -> Header {
    Header {
        scene: scene.name.clone(),
        title: scene.title.clone(),
        about: scene.about.clone(),
        scene_text: scene.text.clone(),
        command: command.to_owned(),
        sample_rate: scene.sample_rate,
        duration: scene.duration,
        analyses: kinds(&scene.analysis),
        section: section_coordinates(&scene.analysis),
        subject,
        computed,
    }
}

/// The analyses by the records that they make, for a header.
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
        (AnalysisKind::Butterfly, spec.butterfly.is_some()),
    ];
    let on = kinds.into_iter().filter(|(_, on)| *on);
    on.map(|(kind, _)| kind).collect()
}

/// What the coordinates of a passage are, for a header.
pub(super) fn section_coordinates(spec: &AnalysisSpec) -> [SectionCoordinate; 2] {
    match spec.section.as_ref().map(|section| &section.surface) {
        Some(SectionSurface::State { shown, .. }) => shown.map(|coordinate| match coordinate {
            StateCoordinate::Q(mode) => SectionCoordinate::Q(mode),
            StateCoordinate::Qdot(mode) => SectionCoordinate::Qdot(mode),
        }),
        Some(SectionSurface::Delay { .. }) | None => SectionCoordinate::DELAYED,
    }
}
