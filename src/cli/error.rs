//! Errors of the command line and their exit codes.

use std::error::Error;
use std::path::PathBuf;

use thiserror::Error;

use super::output::OutputError;
use crate::dynamics::DynamicsError;
use crate::dynamics::equilibrium::EquilibriumError;
use crate::fem::FemError;
use crate::import::ImportError;
use crate::joint::AssemblyError;
use crate::live::TourError;
use crate::pipeline::PipelineError;
use crate::record::ReadError;
use crate::scene::SceneError;
use crate::sound::NoSurface;
use crate::study::ThreadSpawnError;
use crate::study::branch::StartOutside;
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
    /// The signal cannot be analysed.
    #[error("{}: {reason}", path.display())]
    Signal {
        /// Path of the signal.
        path: PathBuf,
        /// Error of the analysis.
        reason: SignalError,
    },
    /// An output cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A table of a sweep cannot be read or written, or belongs to another sweep.
    #[error(transparent)]
    Table(#[from] TableError),
    /// An output or a choice for a single signal, and several files.
    #[error("{option} is for a single file; analyse the files one by one, or omit it")]
    OneFile {
        /// The option.
        option: &'static str,
    },
    /// A directory of signals cannot be read.
    #[error("cannot read the directory `{}` ({source}); check its permissions", path.display())]
    Directory {
        /// Path of the directory.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A directory without signals.
    #[error("the directory `{}` has no file of a known format; give the path of a signal", path.display())]
    NoSignals {
        /// Path of the directory.
        path: PathBuf,
    },
    /// The signal cannot be calibrated.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A file of measured friction that cannot be used.
    #[error("`{}`: {reason}", path.display())]
    FrictionPoints {
        /// Path of the file.
        path: PathBuf,
        /// Reason and remedy.
        reason: String,
    },
    /// Some of several files cannot be analysed.
    #[error("{failed} of {all} files could not be analysed; the table has the reasons")]
    FilesFailed {
        /// Number of files that could not be analysed.
        failed: usize,
        /// Number of all files.
        all: usize,
    },
    /// More than two parameters are swept.
    #[error("{count} parameters are swept; give one, or two for a map (--tilt counts as one)")]
    TooManyAxes {
        /// Number of parameters.
        count: usize,
    },
    /// One parameter is swept twice.
    #[error("`{path}` is swept twice; give it once")]
    AxisTwice {
        /// Path of the key.
        path: &'static str,
    },
    /// A branch over a key whose value is not a real number.
    #[error(
        "`{path}` is a count or a seed, over which no branch is continuous; choose a real number (`squeakscope scenes --keys` lists all keys)"
    )]
    NotContinuous {
        /// Path of the key.
        path: &'static str,
    },
    /// The table belongs to a sweep over another parameter.
    #[error("`{}` (--sweep) is not a sweep over `{parameter}` alone; give the table of one", path.display())]
    OtherSweep {
        /// Path of the table.
        path: PathBuf,
        /// Path of the key.
        parameter: &'static str,
    },
    /// An output of a study over one parameter.
    #[error("{option} needs one parameter; for a map over two, use --json or --figures")]
    OneParameter {
        /// The option.
        option: &'static str,
    },
    /// A start of periodic orbits outside the interval.
    #[error(transparent)]
    Start(#[from] StartOutside),
    /// A diagram over another parameter than the tilt.
    #[error(
        "--diagram needs the tilt as its parameter, not `{path}`; give --tilt A:B without --param"
    )]
    DiagramNeedsTilt {
        /// Path of the key.
        path: &'static str,
    },
    /// A recording of a sweep over two parameters.
    #[error(
        "--save records a sweep over one parameter, which becomes the timeline; sweep over `{first}` or \
         `{second}` alone, or omit --save"
    )]
    NoTimeline {
        /// Path of the first parameter.
        first: &'static str,
        /// Path of the second parameter.
        second: &'static str,
    },
    /// The tour cannot be read.
    #[error(transparent)]
    Tour(#[from] TourError),
    /// The playback speed is out of range.
    #[error("--speed {requested} is out of range; give {low} to {high} simulated ms per second")]
    Speed {
        /// Requested speed, simulated ms per second.
        requested: f64,
        /// Lowest speed.
        low: f64,
        /// Highest speed.
        high: f64,
    },
    /// The address or port of the live page cannot be used.
    #[error(
        "cannot serve the page at {host}, port {port}: {source}; choose another --port (0 for any free \
         port) or --host"
    )]
    Serve {
        /// Requested address.
        host: std::net::IpAddr,
        /// Requested port.
        port: u16,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The causes of growth are not defined for friction with a state.
    #[error(
        "the causes of growth (--causes) are computed for friction that depends on the slip velocity alone; omit \
         --causes, or choose another friction.law than \"lugre\" and \"rate-and-state\""
    )]
    NoCauses,
    /// A scene without a load has no tilt.
    #[error(
        "the scene `{scene}` has no load, and therefore no tilt; choose a parameter with --param KEY=A:B:STEP"
    )]
    NoTilt {
        /// Name of the scene.
        scene: String,
    },
    /// The shortest transient exceeds the longest.
    #[error(
        "--min-transient {min} ms exceeds --max-transient {max} ms; lower the first or raise the second"
    )]
    Transient {
        /// Shortest transient, ms.
        min: f64,
        /// Longest transient, ms.
        max: f64,
    },
    /// A failure while computing, drawing or recording.
    #[error("the {task} failed")]
    Run {
        /// Task that failed, such as `stability analysis`.
        task: &'static str,
        /// Cause of the failure.
        source: Cause,
    },
    /// The energy audit failed.
    #[error("{reason} (--strict)")]
    Audit {
        /// Size of the residual, and the remedy.
        reason: String,
    },
    /// The scene has no energy audit.
    #[error(
        "this scene has no energy audit (--strict): an audit needs a joint and record.energy_rate_khz above \
         0; choose such a scene, or omit --strict"
    )]
    NotAudited,
    /// A recording does not exist at the end of a live run.
    #[error("`{}` was not saved", path.display())]
    NotSaved {
        /// Path of the recording.
        path: PathBuf,
        /// Cause of the failure, and where the saved part is.
        source: Cause,
    },
    /// More exponents are requested than the system has.
    #[error(
        "--exponents {requested}: the system has {dimension} exponents; give 1 to {dimension}, or `all`"
    )]
    Exponents {
        /// Requested number of exponents.
        requested: usize,
        /// Dimension of the system.
        dimension: usize,
    },
    /// The operating system refuses more threads.
    #[error(
        "cannot start the threads for {purpose}; raise the limit of processes (ulimit -u) or free some memory"
    )]
    Threads {
        /// Purpose of the threads.
        purpose: &'static str,
        /// Error of the operating system.
        source: Cause,
    },
    /// The operating system refuses a thread for a study.
    #[error(transparent)]
    ThreadSpawnError(#[from] ThreadSpawnError),
    /// A panic outside the threads of a run: a bug.
    #[error("squeakscope panicked: {message}; please report this bug with the command line")]
    Panic {
        /// Message of the panic.
        message: String,
    },
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
    /// The exit code: 1 failure, 2 invalid input, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Import(_) | Self::Recording(_) | Self::Signal { .. } => 2,
            Self::OneFile { .. }
            | Self::FrictionPoints { .. }
            | Self::Calibration(_)
            | Self::Directory { .. }
            | Self::NoSignals { .. }
            | Self::FilesFailed { .. }
            | Self::NoCauses
            | Self::Exponents { .. }
            | Self::NoTimeline { .. }
            | Self::NotContinuous { .. }
            | Self::OneParameter { .. }
            | Self::OtherSweep { .. }
            | Self::Start(_)
            | Self::DiagramNeedsTilt { .. }
            | Self::NoTilt { .. }
            | Self::Transient { .. }
            | Self::TooManyAxes { .. }
            | Self::AxisTwice { .. }
            | Self::Tour(_)
            | Self::Speed { .. }
            | Self::NotAudited => 2,
            Self::Table(
                TableError::Write { .. } | TableError::Removed { .. } | TableError::Threads(_),
            )
            | Self::Threads { .. }
            | Self::ThreadSpawnError(_) => 1,
            Self::Table(_) => 2,
            Self::Output(error) if error.is_bad_input() => 2,
            Self::Run { source, .. } if is_bad_input(source.as_ref()) => 2,
            Self::Output(_)
            | Self::Run { .. }
            | Self::Audit { .. }
            | Self::NotSaved { .. }
            | Self::Serve { .. }
            | Self::Panic { .. } => 1,
            Self::Interrupted | Self::NoResult | Self::BeforeWork => 130,
        }
    }
}

/// Whether the input caused a failure: a scene whose numbers are each in range but do not make a valid joint,
/// too many exponents, or a probe on a system without a surface.
fn is_bad_input(cause: &(dyn Error + 'static)) -> bool {
    let step = matches!(cause.downcast_ref(), Some(PipelineError::Step { .. }));
    let exponents = matches!(
        cause.downcast_ref(),
        Some(DynamicsError::TangentCount { .. })
    );
    let no_surface = cause.is::<NoSurface>();
    // Not bad input: another machine may have enough memory.
    let memory = matches!(
        cause.downcast_ref(),
        Some(AssemblyError::Body(FemError::Memory { .. }))
    );
    let driven = matches!(cause.downcast_ref(), Some(EquilibriumError::Driven));
    step || exponents
        || driven
        || no_surface
        || cause.is::<AssemblyError>() && !memory
        || cause.source().is_some_and(is_bad_input)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_joint_is_bad_input() {
        let joint = AssemblyError::Unpublished {
            label: "5th bending".to_owned(),
        };
        let fault = |source: Cause| CliError::Run {
            task: "run",
            source,
        };
        assert_eq!(
            fault(Box::new(PipelineError::Assembly(joint))).exit_code(),
            2
        );
        assert_eq!(fault("the disk is full".into()).exit_code(), 1);
    }
}
