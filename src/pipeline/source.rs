//! Sources of frames.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::message::{AnalysisKind, DisplayRates, Frame, Header, SectionCoordinate};
use super::{PipelineError, RunState, Simulation, SmallSimulation};
use crate::scene::{AnalysisSpec, Parameter, Scene, SectionSurface, StateCoordinate, SystemSpec};

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

/// A controllable source of frames: numbers of the scene, velocities and frame length can be changed between frames.
pub trait ControllableSource: Source {
    /// Lets the run continue after the planned time.
    fn run_until_stopped(&mut self);

    /// Sets the time of the first sample, s, at which the schedules of the scene continue. [`Self::set_state`] follows.
    ///
    /// # Errors
    /// If the loading of this time is not possible.
    fn seek(&mut self, time: f64) -> Result<(), PipelineError>;

    /// Sets the state at the next sample, relative to the steady sliding under the present numbers; its time is not used.
    ///
    /// # Errors
    /// If their number is wrong, or the integrator cannot start.
    fn set_state(&mut self, state: &RunState) -> Result<(), PipelineError>;

    /// Changes a number of the scene from the next sample on, in the unit of a scene file; see [`Scene::set`]. The
    /// motion continues from its present state. A tilt replaces the tilt schedule of the scene.
    ///
    /// # Errors
    /// If the scene does not permit the value, or the system cannot be assembled with it: the run continues unchanged.
    fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), PipelineError>;

    /// Adds a Gaussian random velocity of standard deviation `size` (sqrt(kg) m/s) to each mode at the next
    /// sample. Tangent vectors and the perturbed trajectory restart there.
    ///
    /// # Errors
    /// If the integrator cannot restart.
    fn kick(&mut self, size: f64, seed: u64) -> Result<(), PipelineError>;

    /// Sets the number of samples per frame and the display rates from the next frame on.
    fn set_frame_length(&mut self, samples: usize, shown: DisplayRates);

    /// Time of the next sample, s.
    fn time(&self) -> f64;

    /// The scene, with the numbers that have been changed.
    fn scene(&self) -> &Scene;
}

impl Source for Box<dyn Source> {
    fn header(&self, command: &str) -> Header {
        self.as_ref().header(command)
    }

    fn analysis(&self) -> &AnalysisSpec {
        self.as_ref().analysis()
    }

    fn set_stop_flag(&mut self, stop: &Arc<AtomicBool>) {
        self.as_mut().set_stop_flag(stop);
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, PipelineError> {
        self.as_mut().next_frame()
    }

    fn is_finished(&self) -> bool {
        self.as_ref().is_finished()
    }
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
    let on = kinds.into_iter().filter(|(_, on)| *on);
    on.map(|(kind, _)| kind).collect()
}

/// The coordinates of section points, for a header.
pub(super) fn section_coordinates(spec: &AnalysisSpec) -> [SectionCoordinate; 2] {
    match spec.section.as_ref().map(|section| &section.surface) {
        Some(SectionSurface::State { shown, .. }) => shown.map(|coordinate| match coordinate {
            StateCoordinate::Q(mode) => SectionCoordinate::Q(mode),
            StateCoordinate::Qdot(mode) => SectionCoordinate::Qdot(mode),
        }),
        Some(SectionSurface::Delay { .. }) | None => SectionCoordinate::DELAYED,
    }
}

/// Builds the simulation of a scene for an interactive run.
///
/// # Errors
/// As [`Simulation::new`] and [`SmallSimulation::new`].
pub fn controllable_source(scene: &Scene) -> Result<Box<dyn ControllableSource>, PipelineError> {
    Ok(match scene.subject {
        SystemSpec::Joint(_) => Box::new(Simulation::new(scene)?),
        SystemSpec::Small(_) => Box::new(SmallSimulation::new(scene)?),
    })
}

/// Builds the simulation of a scene.
///
/// # Errors
/// As [`controllable_source`].
pub fn source(scene: &Scene) -> Result<Box<dyn Source>, PipelineError> {
    Ok(controllable_source(scene)?)
}
