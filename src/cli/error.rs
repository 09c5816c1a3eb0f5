//! What can go wrong on the command line, and the exit code it gives.

use std::error::Error;
use std::path::PathBuf;

use thiserror::Error;

use super::output::OutputError;
use crate::analysis::AnalysisError;
use crate::dynamics::DynamicsError;
use crate::fem::FemError;
use crate::import::ImportError;
use crate::joint::AssemblyError;
use crate::pipeline::PipelineError;
use crate::record::ReadError;
use crate::scene::SceneError;
use crate::sound::NoSurface;
use crate::study::NoThread;
use crate::study::sweep::TableError;

/// Any error of a layer below, kept as the source.
pub(super) type Cause = Box<dyn Error + Send + Sync>;

/// Why a command did not end well.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CliError {
    /// The scene cannot be run.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The file holds no signal.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The recording holds no such column.
    #[error(transparent)]
    Recording(#[from] ReadError),
    /// The signal is not one that can be analysed.
    #[error("{}: {reason}", path.display())]
    Signal {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: AnalysisError,
    },
    /// A result cannot be written where it should go.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A table of a sweep cannot be read or written, or is not of this sweep.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A table of that name is there already.
    #[error("`{}` is there already (--out); go on with it by --resume, or give another path", path.display())]
    WouldReplace {
        /// The table.
        path: PathBuf,
    },
    /// A log of a calibration is not of this one.
    #[error("`{}` cannot be gone on with (--resume): {reason}; give another --out", path.display())]
    ForeignLog {
        /// The log.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// More parameters are swept than a map has axes.
    #[error("{count} parameters are swept; give one, or two for a map (--tilt counts as one)")]
    TooManyAxes {
        /// How many.
        count: usize,
    },
    /// One parameter is swept twice.
    #[error("`{path}` is swept twice; give it once, or another one")]
    AxisTwice {
        /// Its path.
        path: &'static str,
    },
    /// A recording is asked for of a sweep over two parameters.
    #[error(
        "--save is for a sweep over one parameter, which is then the timeline to scrub; sweep over `{first}` or `{second}` alone, or leave --save out"
    )]
    NoTimeline {
        /// Path of the first parameter.
        first: &'static str,
        /// Path of the second.
        second: &'static str,
    },
    /// A pace is out of range.
    #[error("--pace must be from {low} to {high} simulated ms a second, not {asked}")]
    Pace {
        /// The pace asked for, ms a second.
        asked: f64,
        /// The slowest.
        low: f64,
        /// The fastest.
        high: f64,
    },
    /// The page cannot be served there.
    #[error(
        "the page cannot be served at {host}, port {port}: {source}; give another --port (0 for any), or --host"
    )]
    Serve {
        /// The address.
        host: std::net::IpAddr,
        /// The port.
        port: u16,
        /// What the system says.
        source: std::io::Error,
    },
    /// The table of a sweep has no tilts.
    #[error("`{}` (--sweep) is not of a sweep over the tilt alone; give the table of one", path.display())]
    NoBands {
        /// The table.
        path: PathBuf,
    },
    /// There is nothing to write into the scene.
    #[error(
        "there is no advice to write (--write): no setting of the integrator was tried, or none reaches an error of 1e-2; turn that knob, too"
    )]
    NoAdvice,
    /// A scene without a load has no tilt to sweep.
    #[error(
        "the scene `{scene}` has no load, and so no tilt; say what to vary by --over KEY=A:B:STEP"
    )]
    NoTilt {
        /// Name of the scene.
        scene: String,
    },
    /// The shortest time for a transient is beyond the longest.
    #[error(
        "--least {least} ms is longer than --most {most} ms; give a shorter one, or a longer --most"
    )]
    Times {
        /// The shortest, ms.
        least: f64,
        /// The longest, ms.
        most: f64,
    },
    /// A table has another format than the ending of its name promises.
    #[error("`{}`: the table is an Arrow stream (--out); give it a name that ends in .arrow", path.display())]
    NotArrow {
        /// The table.
        path: PathBuf,
    },
    /// A fault while running.
    #[error("the {doing} failed")]
    Run {
        /// What was being done: run, stability analysis, model.
        doing: &'static str,
        /// Why.
        source: Cause,
    },
    /// The energy audit does not hold.
    #[error("{reason} (--strict)")]
    Audit {
        /// What is wrong, and what to do.
        reason: String,
    },
    /// There was no energy audit.
    #[error(
        "nothing was audited (--strict): only a joint has an energy audit, and only where record.energy_rate_khz \
         is above 0; take such a scene, or leave --strict out"
    )]
    NotAudited,
    /// A file that was asked for is not there at the end.
    #[error("`{}` was not saved", path.display())]
    NotSaved {
        /// The file.
        path: PathBuf,
        /// Why not, and what there is instead.
        source: Cause,
    },
    /// More exponents than there are.
    #[error(
        "`--exponents` = {asked}: this motion has {dimension} exponents; give 1 to {dimension}, or `all`"
    )]
    Exponents {
        /// How many were asked for.
        asked: usize,
        /// How many there are.
        dimension: usize,
    },
    /// The system gives no more threads.
    #[error(
        "the threads for {purpose} cannot be started; raise the limit of processes (ulimit -u) or free some memory"
    )]
    Threads {
        /// What they are for.
        purpose: &'static str,
        /// What the system says.
        source: Cause,
    },
    /// The same for a study.
    #[error(transparent)]
    NoThread(#[from] NoThread),
    /// A panic outside the threads of a run: a fault of this program.
    #[error("the program panicked: {message}; please report this, with the command")]
    Panic {
        /// What it said.
        message: String,
    },
    /// Ctrl-C, while files were read and the joint was made.
    #[error("interrupted before anything was begun; nothing is left behind")]
    BeforeWork,
    /// Ctrl-C, before there was anything.
    #[error("interrupted before anything was found")]
    NothingYet,
    /// Ctrl-C.
    #[error("interrupted; what was reached until then is kept")]
    Interrupted,
}

impl CliError {
    /// The exit code that it gives: 1 a fault while running, 2 bad input, 130 Ctrl-C.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Import(_) | Self::Recording(_) | Self::Signal { .. } => 2,
            Self::WouldReplace { .. }
            | Self::NoAdvice
            | Self::Exponents { .. }
            | Self::NoTimeline { .. }
            | Self::NoTilt { .. }
            | Self::Times { .. }
            | Self::NotArrow { .. }
            | Self::ForeignLog { .. }
            | Self::TooManyAxes { .. }
            | Self::AxisTwice { .. }
            | Self::Pace { .. }
            | Self::NotAudited
            | Self::NoBands { .. } => 2,
            Self::Table(
                TableError::Write { .. } | TableError::Gone { .. } | TableError::Begin(_),
            )
            | Self::Threads { .. }
            | Self::NoThread(_) => 1,
            Self::Table(_) => 2,
            Self::Output(error) if error.is_bad_input() => 2,
            Self::Run { source, .. } if is_impossible(source.as_ref()) => 2,
            Self::Output(_)
            | Self::Run { .. }
            | Self::Audit { .. }
            | Self::NotSaved { .. }
            | Self::Serve { .. }
            | Self::Panic { .. } => 1,
            Self::Interrupted | Self::NothingYet | Self::BeforeWork => 130,
        }
    }
}

/// Whether the cause of a fault is what was asked for: a scene whose numbers, each in its range, make
/// no joint together, or more exponents than there are.
fn is_impossible(cause: &(dyn Error + 'static)) -> bool {
    let step = matches!(cause.downcast_ref(), Some(PipelineError::Step { .. }));
    // More exponents than there are.
    let width = matches!(cause.downcast_ref(), Some(DynamicsError::Width { .. }));
    // Another machine may have the memory.
    let memory = matches!(
        cause.downcast_ref(),
        Some(AssemblyError::Body(FemError::Memory { .. }))
    );
    // Nothing there to listen to.
    let surface = cause.is::<NoSurface>();
    step || width
        || surface
        || cause.is::<AssemblyError>() && !memory
        || cause.source().is_some_and(is_impossible)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_that_cannot_be_is_bad_input() {
        let joint = AssemblyError::Unpublished {
            label: "5th bending".to_owned(),
        };
        let fault = |source: Cause| CliError::Run {
            doing: "run",
            source,
        };
        assert_eq!(
            fault(Box::new(PipelineError::Assembly(joint))).exit_code(),
            2
        );
        assert_eq!(fault("the disk is full".into()).exit_code(), 1);
    }
}
