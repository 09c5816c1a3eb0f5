//! Arguments of the studies: what is told of many runs.

use std::num::NonZero;
use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args as Arguments, ValueEnum, value_parser};

use super::common_args::{AccuracyArgs, SceneArgs, positive, tilts};
use super::figures::FigureArgs;
use super::steps::{Steps, StepsError};
use crate::study::cost::Knob;
use crate::study::sweep::{Shard, Start};

/// Arguments of `squeakscope sweep`.
#[derive(Debug, Arguments)]
pub struct SweepArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Tilts of the load in degrees, from A to B (inclusive) in steps of STEP [default: 1:8:0.5, where nothing else is swept].
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true, value_parser = tilts)]
    pub tilt: Option<Steps>,
    /// Any number of the scene file, by its path; twice, or beside --tilt, for a map of both.
    #[arg(long, value_name = "KEY=A:B:STEP")]
    pub over: Vec<Over>,
    /// How each point is started: from the scene's kick (cold), or from the settled state of its lower (up) or higher (down) neighbour; both is up and down.
    #[arg(long, value_enum, default_value_t = SweepStart::Both)]
    pub start: SweepStart,
    /// Seed of the random kick, which decides between attractors.
    #[arg(long, value_name = "SEED", value_parser = value_parser!(u64).range(..=1 << 50))]
    pub seed: Option<u64>,
    /// How responses are taken.
    #[command(flatten)]
    pub response: ResponseArgs,
    /// How the work is done.
    #[command(flatten)]
    pub work: WorkArgs,
    /// Where results go.
    #[command(flatten)]
    pub outputs: SweepOutputs,
}

/// Arguments of `squeakscope basins`.
#[derive(Debug, Arguments)]
pub struct BasinsArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Keep the tilt of the load constant at this angle, -90 to 90 degrees [default: the scene's tilt at its start].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub tilt: Option<f64>,
    /// How many random kicks.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = value_parser!(u32).range(1..=100_000))]
    pub kicks: u32,
    /// Standard deviation of the modal velocities of a kick, 0 to 1000 sqrt(kg) mm/s [default: the scene's].
    #[arg(long, value_name = "MM_PER_S", allow_negative_numbers = true)]
    pub kick: Option<f64>,
    /// Seed of the first kick; the others have the next ones.
    #[arg(long, value_name = "SEED", default_value_t = 1, value_parser = value_parser!(u64).range(..=1 << 50))]
    pub seed: u64,
    /// How responses are taken.
    #[command(flatten)]
    pub response: ResponseArgs,
    /// How the work is done.
    #[command(flatten)]
    pub work: WorkArgs,
    /// Where results go.
    #[command(flatten)]
    pub outputs: SweepOutputs,
}

/// Arguments of `squeakscope paper`.
#[derive(Debug, Arguments)]
pub struct PaperArgs {
    /// Name of a scene, or path of a scene file [default: paper].
    pub scene: Option<String>,
    /// Only this figure, 1 to 11 [default: all, and the table of claims].
    #[arg(long, value_name = "FIG", value_parser = value_parser!(u8).range(1..=11))]
    pub only: Option<u8>,
    /// The directory for figures, captions and tables.
    #[arg(long, value_name = "DIR", default_value = "paper")]
    pub out: PathBuf,
    /// How figures are drawn.
    #[command(flatten)]
    pub drawn: FigureArgs,
    /// How each tilt is started: from the scene's kick (cold), or from the settled state of its lower (up) or higher (down) neighbour.
    #[arg(long, value_enum, default_value_t = Start::Cold)]
    pub start: Start,
    /// Seed of the random kick, which decides between attractors.
    #[arg(long, value_name = "SEED", value_parser = value_parser!(u64).range(..=1 << 50))]
    pub seed: Option<u64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Threads [default: as many as there are cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// Write the comparison as JSON, too; `-` prints it instead of the table.
    #[arg(long, value_name = "FILE|-")]
    pub json: Option<PathBuf>,
}

/// Arguments of `squeakscope calibrate`.
#[derive(Debug, Arguments)]
pub struct CalibrateArgs {
    /// Name of a scene, or path of a scene file, with all that the paper does state [default: periodic-2deg].
    pub scene: Option<String>,
    /// Seed of all choices of the search.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// How many generations.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = value_parser!(u32).range(1..=1000))]
    pub generations: u32,
    /// Sets a generation.
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = value_parser!(u32).range(1..=10_000))]
    pub population: u32,
    /// Threads [default: as many as there are cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// Go on with the sets that are missing in the log.
    #[arg(long)]
    pub resume: bool,
    /// The log of all sets tried, written one by one: JSON, a line each.
    #[arg(long, value_name = "FILE", default_value = "calibrate.jsonl")]
    pub out: PathBuf,
    /// Write the best set as a scene file.
    #[arg(long, value_name = "FILE.toml")]
    pub best: Option<PathBuf>,
    /// Write the best sets and all they meet as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `squeakscope cost`.
#[derive(Debug, Arguments)]
pub struct CostArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Turn only this knob; may be given several times [default: all that the scene has].
    #[arg(long, value_name = "KNOB", value_enum)]
    pub only: Vec<Knob>,
    /// Runs of each setting, of which the median counts; long ones, of invariants and exponents, are run once.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = value_parser!(u8).range(1..=101))]
    pub repeats: u8,
    /// The longest time over which trajectories are compared; chaos shortens it [default: 4, without a joint 50].
    #[arg(long, value_name = "MS", value_parser = compared, allow_negative_numbers = true)]
    pub horizon: Option<f64>,
    /// The directory for figures, the table (cost.csv) and the recording (cost.rrd).
    #[arg(long, value_name = "DIR", default_value = "cost")]
    pub out: PathBuf,
    /// How figures are drawn.
    #[command(flatten)]
    pub drawn: FigureArgs,
    /// Write the sets as a chapter of a page (Markdown), such as those of the guide.
    #[arg(long, value_name = "FILE.md")]
    pub page: Option<PathBuf>,
    /// Write the scene with the advice in it, for `--accuracy`.
    #[arg(long, value_name = "FILE.toml")]
    pub write: Option<PathBuf>,
    /// Write all points as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `squeakscope growth`.
#[derive(Debug, Arguments)]
pub struct GrowthArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Runs of each size, of which the median counts.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = value_parser!(u8).range(1..=101))]
    pub repeats: u8,
    /// The most threads of a sweep [default: as many as there are cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// The directory for figure and table.
    #[arg(long, value_name = "DIR", default_value = "growth")]
    pub out: PathBuf,
    /// How figures are drawn.
    #[command(flatten)]
    pub drawn: FigureArgs,
    /// Write the growth as a chapter of a page (Markdown), such as that of the guide.
    #[arg(long, value_name = "FILE.md")]
    pub page: Option<PathBuf>,
    /// Write all points as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// How the responses of a sweep are taken.
#[derive(Clone, Copy, Debug, Arguments)]
#[command(mut_arg("accuracy", |accuracy| accuracy.conflicts_with("tolerance")))]
pub struct ResponseArgs {
    /// The least time before a transient counts as over.
    #[arg(long, value_name = "MS", default_value_t = 50.0, value_parser = positive)]
    pub least: f64,
    /// The longest time to wait for the transient to be over.
    #[arg(long, value_name = "MS", default_value_t = 1000.0, value_parser = positive)]
    pub most: f64,
    /// Time over which the settled motion is measured; a zero exponent is told after 1000 periods of the slowest mode.
    #[arg(long, value_name = "MS", default_value_t = 600.0, value_parser = measured)]
    pub measure: f64,
    /// How many of the largest Lyapunov exponents to follow; 0 for none.
    #[arg(long, value_name = "K", default_value_t = 3)]
    pub exponents: usize,
    /// Relative tolerance of the integrator, 1e-13 to 0.01 [default: the scene's].
    #[arg(long, value_name = "TOLERANCE", allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
}

/// How the points of a sweep are worked through.
#[derive(Clone, Copy, Debug, Default, Arguments)]
pub struct WorkArgs {
    /// Go on with the points that are missing in the table.
    #[arg(long)]
    pub resume: bool,
    /// Do only this part of the points, such as 3/8, for one machine of many; `merge` joins the parts.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
    /// Threads [default: as many as there are cores].
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
}

/// Arguments of `squeakscope merge`.
#[derive(Debug, Arguments)]
pub struct MergeArgs {
    /// Tables of parts of one sweep.
    #[arg(required = true)]
    pub tables: Vec<PathBuf>,
    /// Where results go.
    #[command(flatten)]
    pub outputs: SweepOutputs,
}

/// Where the results of a sweep go.
#[derive(Debug, Arguments)]
pub struct SweepOutputs {
    /// The table of all results (Arrow), written point by point; a short one (CSV) goes beside it.
    #[arg(long, value_name = "FILE", default_value = "sweep.arrow")]
    pub out: PathBuf,
    /// Draw the figures into this directory.
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// How figures are drawn.
    #[command(flatten)]
    pub drawn: FigureArgs,
    /// Save a recording for the Rerun viewer, with the parameter as the timeline to scrub; of a sweep over one parameter.
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Write every number as JSON, too; `-` prints it instead of the table.
    #[arg(long, value_name = "FILE|-")]
    pub json: Option<PathBuf>,
}

/// How the points of a sweep are started: as a [`Start`], or as several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SweepStart {
    /// Each from the scene's kick.
    Cold,
    /// Each from its lower neighbour.
    Up,
    /// Each from its higher neighbour.
    Down,
    /// Up and down.
    Both,
    /// Cold, up and down.
    All,
}

/// A number of the scene and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Over {
    /// Its path, or its name.
    pub name: String,
    /// Its values.
    pub values: Steps,
}

impl FromStr for Over {
    type Err = StepsError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (name, values) = text.split_once('=').ok_or(StepsError::NoKey)?;
        Ok(Self {
            name: name.trim().to_owned(),
            values: values.parse()?,
        })
    }
}

/// Takes the number of a part and how many there are.
fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/');
    let parts = parts.and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
    match parts {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Shard { number, of }),
        _ => Err("write I/N, such as 3/8, with I from 1 to N".to_owned()),
    }
}

/// Takes a time long enough to tell anything by.
fn measured(text: &str) -> Result<f64, String> {
    match positive(text) {
        Ok(time) if time >= 5.0 => Ok(time),
        _ => Err("write a number of milliseconds from 5".to_owned()),
    }
}

/// A time over which trajectories can be compared, ms.
fn compared(text: &str) -> Result<f64, String> {
    match positive(text) {
        Ok(time) if (0.1..=1000.0).contains(&time) => Ok(time),
        _ => Err("write a number of milliseconds from 0.1 to 1000".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_says_what_it_is_over() {
        let over: Over = "contact.stiffness_factor=1:3:0.5".parse().unwrap();
        assert_eq!(over.name, "contact.stiffness_factor");
        assert_eq!(over.values.values().count(), 5);
        assert_eq!("1:3:0.5".parse::<Over>(), Err(StepsError::NoKey));
        assert_eq!(shard("3/8"), Ok(Shard { number: 3, of: 8 }));
        for text in ["0/8", "9/8", "3", "a/b", "1/0", "-1/2"] {
            assert!(shard(text).is_err(), "{text}");
        }
    }
}
