//! Arguments of the studies, which run many simulations.

use std::num::NonZero;
use std::path::PathBuf;

use clap::{Args as Arguments, ValueEnum, value_parser};

use super::common_args::{AccuracyArgs, SceneArgs, positive, tilts};
use super::figures::{FigureArgs, FigureStyle};
use super::harness::OutputArgs;
use super::steps::{Interval, Keyed, Steps};
use crate::study::sweep::{Shard, Start};

/// Arguments of `squeakscope sweep`.
#[derive(Debug, Arguments)]
#[command(next_help_heading = "Parameters")]
pub struct SweepArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Tilts of the load in degrees, from A to B (inclusive) in steps of STEP [default: 1:8:0.5, if there is
    /// no
    /// --param].
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true, value_parser = tilts)]
    pub tilt: Option<Steps>,
    /// Vary this numeric key of the scene file from A to B in steps of STEP. Give two parameters, of which
    /// --tilt may be one, for a map.
    #[arg(long, value_name = "KEY=A:B:STEP")]
    pub param: Vec<Keyed<Steps>>,
    /// Initial state of each point.
    #[arg(long, value_enum, default_value_t = SweepStart::Both)]
    pub start: SweepStart,
    /// Seed of the random kick, which can select one of several coexisting attractors.
    #[arg(long, value_name = "SEED", value_parser = value_parser!(u64).range(..=1 << 50))]
    pub seed: Option<u64>,
    #[command(flatten)]
    pub response: ResponseArgs,
    #[command(flatten)]
    pub work: WorkArgs,
    #[command(flatten)]
    pub outputs: SweepOutputs,
}

/// Arguments of `squeakscope branch`.
#[derive(Debug, Arguments)]
#[command(next_help_heading = "Parameters")]
pub struct BranchArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Follow the branches over the tilt of the load in degrees, from A to B [default: 0:8, if there is no --param].
    #[arg(long, value_name = "A:B", allow_hyphen_values = true)]
    pub tilt: Option<Interval>,
    /// Follow the branches over this numeric key of the scene file, from A to B. Give two parameters, of which --tilt
    /// may be one, for a stability map.
    #[arg(long, value_name = "KEY=A:B")]
    pub param: Vec<Keyed<Interval>>,
    /// Number of points of the equilibria, or of each parameter of a map; more are inserted where modes change quickly
    /// [default: 81; for a map: 41].
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(2..=10_000))]
    pub points: Option<u32>,
    /// Compute the equilibria only, without periodic orbits; of a map, the Hopf curves only.
    #[arg(long)]
    pub equilibria: bool,
    /// Start the periodic orbits from the settled motion at this value of the parameter [default: the value of the
    /// scene, or another value at which the motion is periodic].
    #[arg(long, value_name = "VALUE", conflicts_with = "equilibria")]
    pub start: Option<f64>,
    /// Follow the torus beyond each supercritical Neimark-Sacker point of an attracting orbit at N values up to the end of
    /// the interval: base frequencies, rotation number, phase-locked tongues, doubling. Each value needs about two
    /// seconds of simulated time.
    #[arg(long, value_name = "N", conflicts_with = "equilibria",
        value_parser = value_parser!(u32).range(1..=10_000))]
    pub tori: Option<u32>,
    /// Number of threads of a map, and of the settled responses of a diagram [default: the number of cores].
    #[arg(long, value_name = "N", help_heading = "Execution")]
    pub threads: Option<NonZero<usize>>,
    /// Write the points to this table: an Arrow file, Parquet (.parquet) or CSV (.csv; without lists).
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub out: Option<PathBuf>,
    /// Write the branch diagram over the tilt for the live page to this JSON file, with the settled responses of a
    /// sweep, from whose periodic motions the branches start.
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["start", "equilibria", "sweep"],
        help_heading = "Output"
    )]
    pub diagram: Option<PathBuf>,
    /// Save a recording for the Rerun viewer, with the parameter as its timeline.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub save: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
    /// Add the settled responses of this table of a sweep over the same parameter to the branch diagram.
    #[arg(long, value_name = "FILE", requires = "figures")]
    pub sweep: Option<PathBuf>,
}

/// Arguments of `squeakscope basins`.
#[derive(Debug, Arguments)]
#[command(
    next_help_heading = "Parameters",
    // Not the table of `sweep`, which would be another study.
    mut_arg("out", |out| out.default_value("basins.arrow")),
)]
pub struct BasinsArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Hold the tilt of the load at this angle, -90 to 90 degrees [default: the tilt at the start of the
    /// scene].
    #[arg(long, value_name = "DEG")]
    pub tilt: Option<f64>,
    /// Number of random kicks.
    #[arg(long, value_name = "N", default_value_t = 20,
        value_parser = value_parser!(u32).range(1..=100_000))]
    pub kicks: u32,
    /// Standard deviation of the modal velocities of a kick, 0 to 1000 sqrt(kg) mm/s [default: the scene's].
    #[arg(long, value_name = "MM_PER_S")]
    pub kick: Option<f64>,
    /// Seed of the first kick; each further kick takes the next seed.
    #[arg(long, value_name = "SEED", default_value_t = 1,
        value_parser = value_parser!(u64).range(..=1 << 50))]
    pub seed: u64,
    #[command(flatten)]
    pub response: ResponseArgs,
    #[command(flatten)]
    pub work: WorkArgs,
    #[command(flatten)]
    pub outputs: SweepOutputs,
}

/// Arguments of `squeakscope paper`.
#[derive(Debug, Arguments)]
#[command(next_help_heading = "Simulation")]
#[command(mut_arg("scene", |scene| scene.help("Name of a scene, or path of a scene file [default: paper]")))]
pub struct PaperArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Draw only this figure, 1 to 11 [default: all figures, and the table of claims].
    #[arg(long, value_name = "N", value_parser = value_parser!(u8).range(1..=11))]
    pub figure: Option<u8>,
    /// Initial state at each tilt.
    #[arg(long, value_enum, default_value_t = Start::Fresh)]
    pub start: Start,
    /// Seed of the random kick, which can select one of several coexisting attractors.
    #[arg(long, value_name = "SEED", value_parser = value_parser!(u64).range(..=1 << 50))]
    pub seed: Option<u64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Number of threads [default: the number of cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// Write figures, captions and tables to this directory.
    #[arg(
        long,
        value_name = "DIR",
        default_value = "paper",
        help_heading = "Output"
    )]
    pub out: PathBuf,
    /// Write the scene with a description that is generated from its table of claims.
    #[arg(
        long,
        value_name = "FILE.toml",
        help_heading = "Output",
        conflicts_with = "figure"
    )]
    pub write: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub drawn: FigureStyle,
}

/// Arguments of `squeakscope cost`.
#[derive(Debug, Arguments)]
pub struct CostArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
}

/// Transient, measurement and accuracy of the responses of a sweep.
#[derive(Clone, Copy, Debug, Arguments)]
#[command(next_help_heading = "Response")]
#[command(mut_arg("accuracy", |accuracy| accuracy.conflicts_with("tolerance")))]
pub struct ResponseArgs {
    /// Simulate at least this time before the motion can count as settled.
    #[arg(long, value_name = "MS", default_value_t = 50.0, value_parser = positive)]
    pub min_transient: f64,
    /// Wait at most this time for the modal energies to become stationary.
    #[arg(long, value_name = "MS", default_value_t = 1000.0, value_parser = positive)]
    pub max_transient: f64,
    /// Measure the settled motion for this time, and one that follows a stable periodic orbit for a quarter
    /// of it, with the exponents of the orbit. Otherwise an exponent counts as zero only after 1,000 periods
    /// of the slowest mode.
    #[arg(long, value_name = "MS", default_value_t = 600.0, value_parser = measure)]
    pub measure: f64,
    /// Number of largest Lyapunov exponents; 0 for none.
    #[arg(long, value_name = "K", default_value_t = 3)]
    pub exponents: usize,
    /// Relative tolerance of the integrator, 1e-13 to 0.01 [default: the scene's].
    #[arg(long, value_name = "TOLERANCE")]
    pub tolerance: Option<f64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
}

/// Arguments for the work of a sweep: threads, shards and resumption.
#[derive(Clone, Copy, Debug, Default, Arguments)]
#[command(next_help_heading = "Execution")]
pub struct WorkArgs {
    /// Compute the points that are missing in the table --out; without --resume, an existing table is an
    /// error.
    #[arg(long)]
    pub resume: bool,
    /// Compute only part I of N, such as 3/8, to share a sweep among machines; `merge` joins the parts.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
    /// Number of threads [default: the number of cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
}

/// Arguments of `squeakscope merge`.
#[derive(Debug, Arguments)]
pub struct MergeArgs {
    /// Tables of the shards of one sweep.
    #[arg(required = true)]
    pub tables: Vec<PathBuf>,
    #[command(flatten)]
    pub outputs: SweepOutputs,
}

/// Output files of a sweep.
#[derive(Debug, Arguments)]
#[command(next_help_heading = "Output")]
pub struct SweepOutputs {
    /// Write the results to this table: an Arrow file, Parquet (.parquet) or CSV (.csv; without lists). While
    /// the study is running, the table is an Arrow stream of the same name that ends in .arrows.
    #[arg(long, value_name = "FILE", default_value = "sweep.arrow")]
    pub out: PathBuf,
    /// Save a recording for the Rerun viewer, with the parameter as its timeline; only for a sweep over one
    /// parameter.
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
}

/// Initial states of the points of a sweep: one [`Start`], or several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SweepStart {
    /// The initial state of the scene, with its random kick.
    Fresh,
    /// The settled state at the next lower value.
    Upward,
    /// The settled state at the next higher value.
    Downward,
    /// Upward and downward, which shows hysteresis.
    Both,
    /// Fresh, upward and downward.
    All,
}

impl SweepStart {
    /// The starts that this choice stands for.
    pub fn starts(self) -> Vec<Start> {
        match self {
            Self::Fresh => vec![Start::Fresh],
            Self::Upward => vec![Start::Upward],
            Self::Downward => vec![Start::Downward],
            Self::Both => vec![Start::Upward, Start::Downward],
            Self::All => Start::ALL.to_vec(),
        }
    }
}

/// Parses the number of a shard and the number of shards.
fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/');
    let parts = parts.and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
    match parts {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Shard { number, of }),
        _ => Err("give I/N, such as 3/8, with I from 1 to N".to_owned()),
    }
}

/// Parses a measuring time in ms; a shorter one does not resolve the lowest frequency.
fn measure(text: &str) -> Result<f64, String> {
    match positive(text) {
        Ok(time) if time >= 5.0 => Ok(time),
        _ => Err("give a time of at least 5 ms".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_parsed() {
        assert_eq!(shard("3/8"), Ok(Shard { number: 3, of: 8 }));
        for text in ["0/8", "9/8", "3", "a/b", "1/0", "-1/2"] {
            assert!(shard(text).is_err(), "{text}");
        }
    }
}
