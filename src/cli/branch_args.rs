//! Arguments of `squeakscope branch`.

use std::num::NonZero;
use std::path::PathBuf;

use clap::{Args as Arguments, value_parser};

use super::common_args::SceneArgs;
use super::figures::FigureArgs;
use super::harness::OutputArgs;
use super::steps::{Interval, Keyed};

/// Arguments of `squeakscope branch`.
#[derive(Debug, Arguments)]
pub struct BranchArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Follow the branches over the tilt of the load in degrees, from A to B [default: 0:8, if there is no --param].
    #[arg(
        long,
        value_name = "A:B",
        allow_hyphen_values = true,
        help_heading = "Parameters"
    )]
    pub tilt: Option<Interval>,
    /// Follow the branches over this numeric key of the scene file, from A to B. Give two parameters, of which --tilt
    /// may be one, for a stability map.
    #[arg(long, value_name = "KEY=A:B", help_heading = "Parameters")]
    pub param: Vec<Keyed<Interval>>,
    /// Number of points of the equilibria, or of each parameter of a map; more are inserted where modes change quickly
    /// [default: 81; for a map: 41].
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(2..=10_000),
        help_heading = "Parameters")]
    pub points: Option<u32>,
    /// Compute the equilibria only, without periodic orbits; of a map, the Hopf curves only.
    #[arg(long, help_heading = "Parameters")]
    pub equilibria: bool,
    /// Start the periodic orbits from the settled motion at this value of the parameter [default: the value of the
    /// scene, or another value at which the motion is periodic].
    #[arg(
        long,
        value_name = "VALUE",
        conflicts_with = "equilibria",
        help_heading = "Parameters"
    )]
    pub start: Option<f64>,
    /// Follow the torus beyond each supercritical Neimark-Sacker point of an attracting orbit at N values up to the end of
    /// the interval: base frequencies, rotation number, phase-locked tongues, doubling. Each value needs about two
    /// seconds of simulated time.
    #[arg(
        long,
        value_name = "N",
        conflicts_with = "equilibria",
        value_parser = value_parser!(u32).range(1..=10_000),
        help_heading = "Parameters"
    )]
    pub tori: Option<u32>,
    /// Number of threads of a map, and of the settled responses of a diagram [default: the number of cores].
    #[arg(long, value_name = "N", help_heading = "Execution")]
    pub threads: Option<NonZero<usize>>,
    /// Write the points to this table: an Arrow file, Parquet (.parquet) or CSV (.csv; the scalar quantities).
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
    #[arg(
        long,
        value_name = "FILE",
        requires = "figures",
        help_heading = "Figures"
    )]
    pub sweep: Option<PathBuf>,
}
