//! Where frames come from.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::PipelineError;
use super::message::{AnalysisKind, Computed, Frame, Header, SectionCoordinate, Shown, Subject};
use crate::scene::{AnalysisSpec, Scene, SectionSurface, StateCoordinate};

/// Gives the frames of a run, one after another: a [`Simulation`](super::Simulation), or the
/// [`Playback`](super::Playback) of a signal that somebody else made.
pub trait Source: Send {
    /// What is known before the first frame; `command` says how the program was started.
    fn header(&self, command: &str) -> Header;

    /// The analyses of the run.
    fn analysis(&self) -> &AnalysisSpec;

    /// Takes a flag that ends the run once it is true: then a frame that is being made ends with the last
    /// sample that is known. A source whose frames take no time need not look at it.
    fn heed(&mut self, stop: &Arc<AtomicBool>) {
        let _ = stop;
    }

    /// The next frame, which starts where the last one ended; `None` after the last one,
    /// and where it was told to stop before there was a sample.
    ///
    /// # Errors
    /// When there is a next frame, but it cannot be made.
    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError>;

    /// Whether the last frame has been given.
    fn is_over(&self) -> bool;
}

/// A source that goes on until somebody ends it, and takes orders between frames.
pub trait Steerable: Source {
    /// Goes on after the planned time, with tilts (rad) within `reach` to come.
    fn go_on(&mut self, reach: [f64; 2]);

    /// Tilts the load from the next sample on, rad; what the scene says of the tilt is over then. Whether
    /// the joint can be tilted so is for [`Scene::with_tilt`] to say.
    ///
    /// # Errors
    /// When there is no load that could be tilted.
    fn tilt(&mut self, tilt: f64) -> Result<(), PipelineError>;

    /// Adds a random velocity to each mode at the next sample: normal, with the standard deviation `size`
    /// (sqrt(kg) m/s). Tangent vectors and a second copy begin anew there.
    ///
    /// # Errors
    /// When the integrator cannot go on.
    fn kick(&mut self, size: f64, seed: u64) -> Result<(), PipelineError>;

    /// Makes frames of so many samples from now on, with so much to be drawn.
    fn cut(&mut self, samples: usize, shown: Shown);

    /// Time of the next sample, s.
    fn time(&self) -> f64;
}

impl Source for Box<dyn Source> {
    fn header(&self, command: &str) -> Header {
        self.as_ref().header(command)
    }

    fn analysis(&self) -> &AnalysisSpec {
        self.as_ref().analysis()
    }

    fn heed(&mut self, stop: &Arc<AtomicBool>) {
        self.as_mut().heed(stop);
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
        endless: false,
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
