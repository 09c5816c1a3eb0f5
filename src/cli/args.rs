//! The arguments as the user writes them.

use std::path::PathBuf;

use clap::{Args as Arguments, Parser, Subcommand, value_parser};

use super::common_args::{AccuracyArgs, DEFAULT_URL, SceneArgs, positive, tilts, viewer_url};
use super::figures::FigureArgs;
use super::live_args::LiveArgs;
use super::sound_args::SoundArgs;
use super::steps::Steps;
use super::study_args::{
    BasinsArgs, CalibrateArgs, CostArgs, GrowthArgs, MergeArgs, PaperArgs, SweepArgs,
};
use crate::analysis::Threshold;
use crate::import::MAX_SAMPLES;
use crate::study::lyapunov::Count;

/// Watch friction squeak: a ball joint from silence to a pure tone, to a torus, to chaos.
///
/// Without a command, the scene `tilt-ramp` runs and is saved to `squeak.rrd`.
#[derive(Debug, Parser)]
#[command(name = "squeakscope", version)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a scene and record it.
    Run(RunArgs),
    /// Run a scene until told to stop, and steer it meanwhile: from a page with viewer, controls and sound, or
    /// from the terminal.
    Live(LiveArgs),
    /// List the scenes, or print one as TOML to start your own from.
    Scenes(ScenesArgs),
    /// Complex eigenvalues at steady sliding: which modes can squeak.
    Stability(StabilityArgs),
    /// Lyapunov exponents with their errors: rest, cycle, torus, chaos or hyper-chaos.
    Lyapunov(LyapunovArgs),
    /// What happens as the tilt changes, or any other number of a scene: settled responses.
    Sweep(SweepArgs),
    /// Which attractors coexist, and how many of many random kicks lead to each.
    Basins(BasinsArgs),
    /// Join the tables of the parts of a sweep.
    Merge(MergeArgs),
    /// Make the counterpart of every figure of the paper, and compare every claim of its text.
    Paper(PaperArgs),
    /// Search what the paper leaves open for the set that meets most of its claims.
    Calibrate(CalibrateArgs),
    /// What accuracy costs in this scene, at its first tilt: each knob's error against CPU time and calls, and
    /// the cheapest integrator.
    Cost(CostArgs),
    /// How time and memory grow with nodes, modes, exponents, recurrence plots, threads and the length of a run.
    Growth(GrowthArgs),
    /// Write all that Eq. (8) needs as NumPy arrays.
    Model(ModelArgs),
    /// Tell the kind of motion of a signal from anybody's file: WAV, CSV, .npy, .npz, .rrd.
    Analyse(AnalyseArgs),
}

/// Arguments of `squeakscope run`.
#[derive(Debug, Default, Arguments)]
#[command(
    // Only a file can be heard of this command.
    mut_arg("sound", |sound| sound.requires("wav")),
    mut_arg("at", |at| at.requires("wav")),
)]
pub struct RunArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Keep the tilt of the load constant at this angle, -90 to 90 degrees.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub tilt: Option<f64>,
    /// Simulate this long, 0.1 to 100000 ms.
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub duration: Option<f64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Save the recording [default: squeak.rrd, if no other output is asked for].
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Write the samples as NumPy arrays t, q, qdot, u, v, tilt_deg; load_n and rotation_factor where they vary.
    #[arg(long, value_name = "FILE")]
    pub npz: Option<PathBuf>,
    /// What is heard.
    #[command(flatten)]
    pub heard: SoundArgs,
    /// Play the sound so many times slower than life, and so lower: 0.01 to 1000.
    #[arg(long, value_name = "TIMES", default_value_t = 1.0, value_parser = slower, allow_negative_numbers = true, requires = "wav")]
    pub slower: f64,
    /// Open a viewer on this machine and watch.
    #[arg(long, conflicts_with = "connect")]
    pub spawn: bool,
    /// Watch in a viewer that is already open.
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = DEFAULT_URL,
        value_parser = viewer_url)]
    pub connect: Option<String>,
    /// End with exit code 1 if energy and work do not agree to 5 %; refuse a scene whose energy is not audited.
    #[arg(long)]
    pub strict: bool,
    /// Write the summary as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `squeakscope scenes`.
#[derive(Debug, Default, Arguments)]
pub struct ScenesArgs {
    /// Print this scene (a name, or a file to be checked) as TOML.
    pub name: Option<String>,
    /// Print every key of a scene file: meaning, unit, allowed values, default.
    #[arg(long, conflicts_with_all = ["name", "json"])]
    pub keys: bool,
    /// Tell which effects this scene calls for, which it leaves out, and what each costs or would cost, measured.
    #[arg(long, requires = "name", conflicts_with = "keys")]
    pub effects: bool,
    /// Write the list as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `squeakscope stability`.
#[derive(Debug, Arguments)]
pub struct StabilityArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Tilts in degrees: one, or from A to B (inclusive) in steps of STEP [default: the tilts at the scene's knots].
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true, value_parser = tilts)]
    pub tilt: Option<Steps>,
    /// Say why each mode grows or dies: what each term of the linearised joint feeds into it, and how it would grow without.
    #[arg(long)]
    pub causes: bool,
    /// Write the eigenvalues as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `squeakscope lyapunov`.
#[derive(Debug, Default, Arguments)]
#[command(mut_arg("accuracy", |accuracy| accuracy.conflicts_with("tolerance")))]
pub struct LyapunovArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// How many of the largest exponents, or `all` [default: all].
    #[arg(long, value_name = "K", value_parser = exponents)]
    pub exponents: Option<Count>,
    /// Average for this much simulated time [default: until the verdict is clear].
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Average until every exponent asked for is known to this much on either side, 95 % confidence.
    #[arg(long, value_name = "1/S", value_parser = positive, allow_negative_numbers = true,
        conflicts_with = "until")]
    pub error: Option<f64>,
    /// Let the tangent vectors turn for this long before their growth counts [default: 100 periods of the slowest mode].
    #[arg(long, value_name = "MS", value_parser = positive, allow_negative_numbers = true)]
    pub settle: Option<f64>,
    /// Keep the tilt of the load constant at this angle, -90 to 90 degrees [default: the scene runs, then its last tilt is kept].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub tilt: Option<f64>,
    /// Run the scene this long before anything is measured, 0.1 to 100000 ms.
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// Seed of the random kick, which decides between attractors.
    #[arg(long, value_name = "SEED", value_parser = value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Relative tolerance of the integrator, 1e-13 to 0.01 [default: the scene's, and at most 5e-8 while all exponents are followed].
    #[arg(long, value_name = "TOLERANCE", allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Draw the figure: a file that ends in .png, .svg or .pdf, or a directory for lyapunov.png.
    #[arg(long, value_name = "FILE|DIR", alias = "png")]
    pub figures: Option<PathBuf>,
    /// How figures are drawn.
    #[command(flatten)]
    pub drawn: FigureArgs,
    /// Write the running values as columns of text; `-` prints them instead of the table.
    #[arg(long, value_name = "FILE|-")]
    pub csv: Option<PathBuf>,
    /// Write every number as JSON, too; `-` prints it instead of the table.
    #[arg(long, value_name = "FILE|-")]
    pub json: Option<PathBuf>,
}

/// Takes a number of exponents; that there are so many is checked when the system is known.
fn exponents(text: &str) -> Result<Count, String> {
    match text.parse() {
        _ if text == "all" => Ok(Count::All),
        Ok(count) if count > 0 => Ok(Count::Largest(count)),
        _ => Err("write a whole number from 1, or `all`".to_owned()),
    }
}

/// Takes how many times slower something is played.
fn slower(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|number| (0.01..=1000.0).contains(number));
    number.ok_or_else(|| "write a number from 0.01 to 1000".to_owned())
}

/// Arguments of `squeakscope model`.
#[derive(Debug, Arguments)]
pub struct ModelArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The file to write.
    #[arg(long, value_name = "FILE.npz")]
    pub out: PathBuf,
    /// Write what the model consists of as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Arguments of `squeakscope analyse`.
#[derive(Debug, Default, Arguments)]
pub struct AnalyseArgs {
    /// The file: WAV, CSV or other columns of text, .npy, .npz, or a recording (.rrd).
    pub file: PathBuf,
    /// Column or channel, by name or by place from 0 (the time not counted); may be left out where there is only one.
    #[arg(long, value_name = "NAME")]
    pub column: Option<String>,
    /// Samples a second, for a file that does not say.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub rate: Option<f64>,
    /// Leave out what comes before this time of the file.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Leave out what comes from this time of the file on.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Refuse to read more samples than this. Each takes 8 bytes of memory.
    #[arg(long, value_name = "N", default_value_t = MAX_SAMPLES, value_parser = max_samples, allow_negative_numbers = true)]
    pub max_samples: usize,
    /// Delay of the state space in samples [default: chosen by mutual information].
    #[arg(long, value_name = "SAMPLES", value_parser = value_parser!(u32).range(1..))]
    pub lag: Option<u32>,
    /// Dimension of the state space [default: chosen by false neighbours].
    #[arg(long, value_name = "M", value_parser = value_parser!(u32).range(1..))]
    pub dimension: Option<u32>,
    /// Recurrence threshold: rate:R (share of pairs), distance:D (signal's unit), spread:S (standard deviations) or neighbours:N [default: rate:0.05].
    #[arg(long, value_name = "KIND:VALUE", value_parser = threshold)]
    pub threshold: Option<Threshold>,
    /// Save a recording in which the analyses run along the signal.
    #[arg(long, value_name = "FILE.rrd")]
    pub save: Option<PathBuf>,
    /// Draw the figures into this directory.
    #[arg(long, value_name = "DIR", alias = "png")]
    pub figures: Option<PathBuf>,
    /// How figures are drawn.
    #[command(flatten)]
    pub drawn: FigureArgs,
    /// Write every number as JSON, too.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Takes a number of samples, such as 100000000 or 1e8.
fn max_samples(text: &str) -> Result<usize, String> {
    let number = text.parse::<f64>().ok();
    let whole = number.filter(|n| *n >= 1.0 && *n <= 1e15 && n.fract() == 0.0);
    whole
        .map(|n| n as usize)
        .ok_or_else(|| "give a whole number from 1 to 1e15".to_owned())
}

/// Takes a recurrence threshold; its range is checked here so that a slip is found before any work.
fn threshold(text: &str) -> Result<Threshold, String> {
    let (kind, value) = text.split_once(':').unwrap_or(("rate", text));
    let number = || {
        value
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite() && *v > 0.0)
    };
    let threshold = match kind {
        "rate" => number().filter(|rate| *rate <= 1.0).map(Threshold::Rate),
        "distance" => number().map(Threshold::Distance),
        "spread" => number().map(Threshold::Spread),
        "neighbours" => {
            let count = value.parse().ok().filter(|count| *count > 0);
            count.map(Threshold::Neighbours)
        }
        _ => None,
    };
    threshold.ok_or_else(|| {
        "write rate:R with R up to 1, distance:D, spread:S or neighbours:N, each above 0".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::steps::StepsError;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn tilts_are_at_most_horizontal() {
        let found: Vec<f64> = tilts("-90:90:45").unwrap().values().collect();
        assert_eq!(found, [-90.0, -45.0, 0.0, 45.0, 90.0]);
        assert_eq!(tilts("0:91:1"), Err(StepsError::TiltOutOfRange(91.0)));
    }

    #[test]
    fn a_sweep_needs_ways_and_times_that_there_are() {
        let parse = |line: &str| Args::try_parse_from(line.split(' '));
        assert!(
            parse("squeakscope sweep torus-3deg --tilt 1:8:0.5 --start both --shard 1/2").is_ok()
        );
        assert!(parse("squeakscope sweep --start sideways").is_err());
        assert!(parse("squeakscope sweep --measure 1").is_err());
        assert!(parse("squeakscope merge").is_err());
    }

    #[test]
    fn runs_take_negative_tilts_and_a_viewer_without_address() {
        let parse = |line: &str| Args::try_parse_from(line.split(' '));
        let Ok(Args {
            command: Some(Command::Run(run)),
        }) = parse("squeakscope run torus-3deg --tilt -2.5 --connect --json out.json")
        else {
            panic!("these are the arguments of a run");
        };
        assert_eq!(run.tilt, Some(-2.5));
        assert_eq!(run.connect.as_deref(), Some(DEFAULT_URL));
        assert_eq!(run.json, Some(PathBuf::from("out.json")));
        assert!(parse("squeakscope run --spawn --connect").is_err());
        // Only a file can be heard.
        for heard in ["--sound pressure", "--at 8,0,60", "--slower 10"] {
            assert!(parse(&format!("squeakscope run {heard}")).is_err());
            assert!(parse(&format!("squeakscope run --wav a.wav {heard}")).is_ok());
        }
        assert!(parse("squeakscope stability --tilt -3:3:1").is_ok());
        assert!(parse("squeakscope model").is_err());
    }

    #[test]
    fn exponents_are_counted_or_all() {
        assert_eq!(exponents("all"), Ok(Count::All));
        assert_eq!(exponents("3"), Ok(Count::Largest(3)));
        for text in ["0", "-1", "1.5", "", "none"] {
            assert!(exponents(text).is_err(), "{text}");
        }
        assert_eq!(positive("2.5"), Ok(2.5));
        for text in ["0", "-1", "nan", "inf", "much"] {
            assert!(positive(text).is_err(), "{text}");
        }
    }

    #[test]
    fn thresholds_have_a_kind() {
        assert_eq!(threshold("0.1"), Ok(Threshold::Rate(0.1)));
        assert_eq!(threshold("distance:2e-3"), Ok(Threshold::Distance(2e-3)));
        assert_eq!(threshold("spread:0.2"), Ok(Threshold::Spread(0.2)));
        assert_eq!(threshold("neighbours:10"), Ok(Threshold::Neighbours(10)));
        for text in [
            "",
            "rate:1.1",
            "rate:0",
            "spread:nan",
            "neighbours:0.5",
            "near:1",
            "distance:-1",
        ] {
            assert!(threshold(text).is_err(), "{text}");
        }
    }
}
