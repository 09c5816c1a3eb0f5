//! Errors of the command line and their exit codes.

use std::error::Error;
use std::path::PathBuf;

use thiserror::Error;

use crate::dynamics::DynamicsError;
use crate::dynamics::equilibrium::EquilibriumError;
use crate::export;
use crate::fem::FemError;
use crate::import::ImportError;
use crate::joint::AssemblyError;
use crate::live::TourError;
use crate::pipeline::PipelineError;
use crate::record::ReadError;
use crate::scene::SceneError;
use crate::sound::NoSurface;
use crate::study::Stopped;
use crate::study::signal::{CalibrationError, SignalError};
use crate::study::sweep::TableError;

/// An error of another module, as the source of a [`CliError`].
pub(super) type Cause = Box<dyn Error + Send + Sync>;

/// An error of a command of the command-line interface (CLI).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CliError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The file does not hold a signal.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The recording cannot be read, or does not have the column.
    #[error(transparent)]
    Recording(#[from] ReadError),
    /// The signal at a path cannot be analysed.
    #[error("{}: {}", .0.display(), .1)]
    Signal(PathBuf, SignalError),
    /// Arguments or files that do not fit the command: what, and the remedy.
    #[error("{0}")]
    Input(String),
    /// A failure without another error as its cause.
    #[error("{0}")]
    Failed(String),
    /// The standard output cannot be written.
    #[error("cannot write to the standard output; check its destination and the free space")]
    Terminal(#[source] std::io::Error),
    /// Writing failed after the checks had passed; a file that existed before is unchanged.
    #[error(transparent)]
    NotWritten(#[from] export::OutputError),
    /// A table of a sweep cannot be read or written, or belongs to another sweep.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The signal cannot be calibrated.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The tour cannot be read.
    #[error(transparent)]
    Tour(#[from] TourError),
    /// A failure of a task, such as `stability analysis`, and its cause.
    #[error("the {0} failed")]
    Run(&'static str, #[source] Cause),
    /// The scene has no energy audit.
    #[error(
        "this scene has no energy audit (--strict): an audit needs a joint and record.energy_rate_khz above \
         0; choose such a scene, or omit --strict"
    )]
    NotAudited,
    /// The recording of this path does not exist at the end of a live run; why, and where the saved part is.
    #[error("`{}` was not saved", .0.display())]
    NotSaved(PathBuf, #[source] Cause),
    /// The operating system refuses more threads for this purpose.
    #[error(
        "cannot start the threads for {0}; raise the limit of processes (ulimit -u) or free some memory"
    )]
    Threads(&'static str, #[source] Cause),
    /// Interrupted while files are read and the joint is assembled.
    #[error("interrupted before the computation started; nothing is written")]
    BeforeWork,
    /// Interrupted before the first result.
    #[error("interrupted before the first result")]
    NoResult,
    /// Interrupted during the computation.
    #[error("interrupted; the results so far are saved")]
    Interrupted,
}

impl CliError {
    /// Makes the cause of a failure the error of a task, such as `stability analysis`.
    pub(super) fn during<E: Into<Cause>>(task: &'static str) -> impl Fn(E) -> Self + Copy {
        move |source| {
            let source = source.into();
            if is_stopped(source.as_ref()) {
                return Self::NoResult;
            }
            Self::Run(task, source)
        }
    }

    /// The exit code: 1 failure, 2 invalid input, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Interrupted | Self::NoResult | Self::BeforeWork => 130,
            Self::Failed(_)
            | Self::Terminal(_)
            | Self::NotWritten(_)
            | Self::NotSaved(..)
            | Self::Threads(..)
            | Self::Table(TableError::Write(..) | TableError::Removed(..) | TableError::Study(_)) => {
                1
            }
            Self::Run(_, source) if !is_bad_input(source.as_ref()) => 1,
            _ => 2,
        }
    }
}

/// Whether the user has interrupted the work.
fn is_stopped(cause: &(dyn Error + 'static)) -> bool {
    cause.is::<Stopped>() || cause.source().is_some_and(is_stopped)
}

/// Whether the input caused a failure: a scene whose numbers are each in range but do not make a valid joint,
/// too many exponents, or a probe on a system without a surface.
fn is_bad_input(cause: &(dyn Error + 'static)) -> bool {
    let is_invalid_joint = cause.downcast_ref().is_some_and(|error| {
        // Another machine may have enough memory.
        !matches!(error, AssemblyError::Body(FemError::Memory { .. }))
    });
    is_invalid_joint
        || cause.is::<SceneError>()
        || cause.is::<NoSurface>()
        || matches!(cause.downcast_ref(), Some(PipelineError::Step { .. }))
        || matches!(
            cause.downcast_ref(),
            Some(DynamicsError::TangentCount { .. })
        )
        || matches!(cause.downcast_ref(), Some(EquilibriumError::Driven))
        || cause.source().is_some_and(is_bad_input)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::StudyError;

    #[test]
    fn an_invalid_joint_is_bad_input() {
        let joint = AssemblyError::NoMesh {
            file: "modes.npz".to_owned(),
        };
        let fault = |source: Cause| CliError::Run("run", source);
        assert_eq!(
            fault(Box::new(PipelineError::Assembly(joint))).exit_code(),
            2
        );
        assert_eq!(fault("the disk is full".into()).exit_code(), 1);
    }

    #[test]
    fn the_cause_of_a_study_decides_whether_it_is_bad_input() {
        let exit_code = |study: StudyError| CliError::Run("study", study.into()).exit_code();
        let joint = || AssemblyError::NoMesh {
            file: "modes.npz".to_owned(),
        };
        let memory = AssemblyError::Body(FemError::Memory { megabytes: 64_000 });
        let pipeline = |fault| StudyError::Pipeline(PipelineError::Assembly(fault));
        assert_eq!(exit_code(StudyError::Assembly(joint())), 2);
        assert_eq!(exit_code(pipeline(joint())), 2);
        assert_eq!(exit_code(EquilibriumError::Driven.into()), 2);
        assert_eq!(exit_code(pipeline(memory)), 1);
    }
}
