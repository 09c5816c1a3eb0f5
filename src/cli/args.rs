//! The command line as clap parses it.

use std::path::PathBuf;

use clap::{Args as Arguments, Parser, Subcommand, value_parser};
use clap_complete::Shell;

use super::analyse_args::AnalyseArgs;
use super::common_args::{
    AccuracyArgs, BudgetArgs, SceneArgs, SoundArgs, ViewerArgs, positive, tilts,
};
use super::figures::FigureArgs;
use super::friction::FrictionArgs;
use super::harness::OutputArgs;
use super::live::LiveArgs;
use super::output::Overwrite;
use super::schema::results;
use super::steps::Steps;
use super::study_args::{BasinsArgs, BranchArgs, CostArgs, MergeArgs, PaperArgs, SweepArgs};
use super::view::ViewArgs;

/// Simulate and analyse friction-induced vibration of a ball joint: limit cycles, tori and chaos.
///
/// Without a command, squeakscope runs the scene `tilt-ramp` and saves the recording to `squeak.rrd`.
#[derive(Debug, Parser)]
#[command(name = "squeakscope", version)]
pub struct Args {
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The commands. `super::help` groups them by task and adds their examples.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a scene and record it.
    Run(RunArgs),
    /// Show a recording in the browser.
    ///
    /// Serves the recording and Rerun's web viewer on this machine until Ctrl-C.
    View(ViewArgs),
    /// Run a scene interactively, controlled from a web page.
    ///
    /// Serves the page and opens the browser. The run continues until Ctrl-C. Tilt, playback speed and scene can be
    /// changed while it runs.
    Live(LiveArgs),
    /// List the scenes, print one as a scene file, compare two, or list all keys.
    Scenes(ScenesArgs),
    /// Compute the complex eigenvalues at steady sliding.
    ///
    /// A mode with a growth rate of at least 0.1 1/s is unstable and can squeak.
    Stability(StabilityArgs),
    /// Compute Lyapunov exponents with 95 % intervals and classify the attractor.
    Lyapunov(LyapunovArgs),
    /// Compute the settled response as a function of the tilt or any other parameter.
    Sweep(SweepArgs),
    /// Follow equilibria and periodic motions over a parameter.
    ///
    /// Hopf points, folds, period doublings and Neimark-Sacker points are located. Over two parameters, the command
    /// computes a stability map with the curves of the Hopf points.
    Branch(BranchArgs),
    /// Find coexisting attractors and the share of random kicks that reach each.
    Basins(BasinsArgs),
    /// Merge the tables of the shards of a sweep.
    Merge(MergeArgs),
    /// Reproduce the paper's figures and check each of its claims.
    Paper(PaperArgs),
    /// Measure what accuracy and effects cost, and find the cheapest settings.
    ///
    /// For each numerical setting the error against time, for each effect of the scene its price and what it changes, and
    /// settings for total errors of 1e-2, 1e-3 and 1e-4, verified by finer runs; at the first tilt of the scene.
    Cost(CostArgs),
    /// Export the arrays of Eq. (8) to NumPy.
    Model(ModelArgs),
    /// Analyse a signal from a file and classify its motion.
    ///
    /// Reads WAV, FLAC, MP3, AAC, M4A, MP4, Ogg, Opus, AIFF, CSV and other text columns, .uff, .npy, .npz, .mat and
    /// recordings (.rrd). Of several files, or of a directory, it prints a table.
    Analyse(AnalyseArgs),
    /// Fit the Stribeck law to measured coefficients of friction.
    ///
    /// Prints the law with 95 % intervals, and the lines of a scene file.
    Friction(FrictionArgs),
    /// Print the JSON Schema of the `--json` output of a command.
    ///
    /// Without a command, it lists the commands that write JSON.
    Schema(SchemaArgs),
    /// Print a completion script for a shell.
    Completions(CompletionsArgs),
    /// Write the man pages.
    Man(ManArgs),
}

/// Arguments of `squeakscope run`.
#[derive(Debug, Default, Arguments)]
#[command(
    next_help_heading = "Simulation",
    // This command has no audio output other than the file.
    mut_arg("sound", |sound| sound.requires("wav")),
    mut_arg("probe", |probe| probe.requires("wav")),
)]
pub struct RunArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Hold the tilt of the load at this angle, -90 to 90 degrees.
    #[arg(long, value_name = "DEG")]
    pub tilt: Option<f64>,
    /// Simulate this much time, 0.1 to 100000 ms.
    #[arg(long, value_name = "MS")]
    pub duration: Option<f64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    #[command(flatten)]
    pub budget: BudgetArgs,
    /// Fail with exit code 1 if the residual of the energy audit exceeds 5 %; refuse a scene without an
    /// audit.
    #[arg(long)]
    pub strict: bool,
    /// Save the recording to this file [default: squeak.rrd, if there is no other output; it is replaced without
    /// --force].
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub save: Option<PathBuf>,
    /// Write the samples as NumPy arrays: t, q, qdot, u, v, tilt_deg, and load_n and rotation_factor if they
    /// vary.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub npz: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub audio: SoundArgs,
    /// Stretch the sound in time by this factor, 0.01 to 1000; its pitch falls by the same factor.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = time_stretch, requires = "wav", help_heading = "Sound")]
    pub time_stretch: f64,
    #[command(flatten)]
    pub viewer: ViewerArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
}

/// Arguments of `squeakscope scenes`.
#[derive(Debug, Default, Arguments)]
#[command(
    mut_arg("scene", |scene| {
        scene.value_name("NAME").help("Check this scene, a name or a file, and print it as TOML")
    }),
    mut_arg("set", |set| set.requires("scene")),
)]
pub struct ScenesArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Print every key of a scene file with its meaning, unit, range and default.
    #[arg(long, conflicts_with_all = ["scene", "json", "compare"])]
    pub keys: bool,
    /// Print the keys in which two scenes differ.
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["scene", "set"])]
    pub compare: Vec<String>,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of `squeakscope stability`.
#[derive(Debug, Arguments)]
#[command(group(clap::ArgGroup::new("drawn").args(["causes", "sensitivities"]).multiple(true)))]
#[command(mut_arg("figures", |figures| {
    figures.requires("drawn").help("Draw the sensitivities of the unstable modes, and the causes, to this directory")
}))]
pub struct StabilityArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// One tilt in degrees, or tilts from A to B (inclusive) in steps of STEP [default: the knots of the
    /// scene's tilt].
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true, value_parser = tilts)]
    pub tilt: Option<Steps>,
    /// For each term of the linearised joint, print its share of the growth rate and the growth rate without
    /// it.
    #[arg(long)]
    pub causes: bool,
    /// Print how growth rate and frequency of each mode change with every number of the scene, per 1 % and per unit.
    #[arg(long)]
    pub sensitivities: bool,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
}

/// Arguments of `squeakscope lyapunov`.
#[derive(Debug, Default, Arguments)]
#[command(next_help_heading = "Simulation")]
#[command(mut_arg("accuracy", |accuracy| accuracy.conflicts_with("tolerance")))]
pub struct LyapunovArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Hold the tilt of the load at this angle, -90 to 90 degrees [default: the scene runs, then its last
    /// tilt is held].
    #[arg(long, value_name = "DEG")]
    pub tilt: Option<f64>,
    /// Run the scene for this time before the tangent vectors start, 0.1 to 100000 ms.
    #[arg(long, value_name = "MS")]
    pub duration: Option<f64>,
    /// Seed of the random kick, which can select one of several coexisting attractors.
    #[arg(long, value_name = "SEED", value_parser = value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Relative tolerance of the integrator, 1e-13 to 0.01 [default: the scene's; at most 5e-8 for all
    /// exponents].
    #[arg(long, value_name = "TOLERANCE")]
    pub tolerance: Option<f64>,
    /// Number of largest exponents to compute, or `all`.
    #[arg(long, value_name = "K", default_value = "all", value_parser = exponents, help_heading = "Averaging")]
    pub exponents: ExponentCount,
    /// Align the tangent vectors for this time before averaging starts [default: 100 periods of the slowest
    /// mode].
    #[arg(long, value_name = "MS", value_parser = positive,
        help_heading = "Averaging")]
    pub settle: Option<f64>,
    /// Average over this simulated time [default: until the attractor is classified].
    #[arg(long, value_name = "SECONDS", value_parser = positive,
        help_heading = "Averaging")]
    pub average_time: Option<f64>,
    /// Average until the 95 % interval of every requested exponent has at most this half-width.
    #[arg(long, value_name = "1/S", value_parser = positive,
        conflicts_with = "average_time", help_heading = "Averaging")]
    pub target_half_width: Option<f64>,
    /// Also write the running averages as CSV; `-` prints them instead of the table.
    #[arg(long, value_name = "FILE|-", help_heading = "Output")]
    pub csv: Option<PathBuf>,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
}

/// Arguments of `squeakscope model`.
#[derive(Debug, Arguments)]
pub struct ModelArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Write the arrays to this file.
    #[arg(long, value_name = "FILE.npz")]
    pub out: PathBuf,
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Arguments of `squeakscope schema`.
#[derive(Debug, Arguments)]
pub struct SchemaArgs {
    /// Command whose result the schema describes [default: list the commands].
    #[arg(value_parser = results())]
    pub command: Option<String>,
}

/// Arguments of `squeakscope completions`.
#[derive(Debug, Arguments)]
pub struct CompletionsArgs {
    /// Shell that reads the script.
    pub shell: Shell,
}

/// Arguments of `squeakscope man`.
#[derive(Debug, Arguments)]
pub struct ManArgs {
    /// Write one page per command to this directory; it is created if it does not exist.
    #[arg(value_name = "DIR")]
    pub directory: PathBuf,
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// A number of exponents; `None` for all.
type ExponentCount = Option<usize>;

/// Parses a number of exponents. The upper limit is checked later, when the dimension of the system is known.
fn exponents(text: &str) -> Result<ExponentCount, String> {
    match text.parse() {
        _ if text == "all" => Ok(None),
        Ok(count) if count > 0 => Ok(Some(count)),
        _ => Err("give a whole number of at least 1, or `all`".to_owned()),
    }
}

/// Parses the factor of a time stretch.
fn time_stretch(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let number = number.filter(|number| (0.01..=1000.0).contains(number));
    number.ok_or_else(|| "give a number from 0.01 to 1000".to_owned())
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use super::*;

    fn parse(line: &str) -> Result<Args, clap::Error> {
        crate::cli::parse(line.split(' ').map(OsString::from).collect())
    }

    #[test]
    fn tilts_are_limited_to_90_degrees() {
        let values: Vec<f64> = tilts("-90:90:45").unwrap().0;
        assert_eq!(values, [-90.0, -45.0, 0.0, 45.0, 90.0]);
        let error = tilts("0:91:1").unwrap_err();
        assert!(error.contains("a tilt of 91 degrees"), "{error}");
    }

    #[test]
    fn each_study_has_its_own_table() {
        let Some(Command::Sweep(sweep)) = parse("squeakscope sweep").unwrap().command else {
            panic!("sweep expected");
        };
        let Some(Command::Basins(basins)) = parse("squeakscope basins").unwrap().command else {
            panic!("basins expected");
        };
        assert_ne!(sweep.outputs.out, basins.outputs.out);
    }

    #[test]
    fn a_sweep_refuses_unknown_starts_and_short_measurements() {
        assert!(
            parse("squeakscope sweep torus-1.75deg --tilt 1:8:0.5 --start both --shard 1/2")
                .is_ok()
        );
        assert!(parse("squeakscope sweep --start sideways").is_err());
        assert!(parse("squeakscope sweep --measure 1").is_err());
        assert!(parse("squeakscope merge").is_err());
    }

    #[test]
    fn a_run_takes_negative_tilts_and_a_viewer_without_url() {
        let Ok(Args {
            command: Some(Command::Run(run)),
        }) = parse("squeakscope run torus-1.75deg --tilt -2.5 --connect --json out.json")
        else {
            panic!("these are the arguments of a run");
        };
        assert_eq!(run.tilt, Some(-2.5));
        let default = Some("rerun+http://127.0.0.1:9876/proxy");
        assert_eq!(run.viewer.connect.as_deref(), default);
        assert_eq!(run.output.json, Some(PathBuf::from("out.json")));
        assert!(parse("squeakscope run --spawn --connect").is_err());
        assert_eq!(run.budget.budget, None);
        assert!(parse("squeakscope run --budget realtime").is_ok());
        assert!(parse("squeakscope live --budget complete").is_ok());
        assert!(parse("squeakscope run --budget never").is_err());
        for sound in ["--sound pressure", "--probe 8,0,60", "--time-stretch 10"] {
            assert!(
                parse(&format!("squeakscope run {sound}")).is_err(),
                "needs --wav"
            );
            assert!(parse(&format!("squeakscope run --wav a.wav {sound}")).is_ok());
        }
        assert!(parse("squeakscope stability --tilt -3:3:1").is_ok());
        assert!(parse("squeakscope model").is_err());
    }

    #[test]
    fn a_comparison_takes_two_scenes_and_no_changes() {
        assert!(parse("squeakscope scenes --compare a b").is_ok());
        for rest in [
            "--compare a",
            "--compare a b --set time.seed=5",
            "--compare a b c",
        ] {
            assert!(
                parse(&format!("squeakscope scenes {rest}")).is_err(),
                "{rest}"
            );
        }
    }

    #[test]
    fn exponents_are_a_positive_number_or_all() {
        assert_eq!(exponents("all"), Ok(None));
        assert_eq!(exponents("3"), Ok(Some(3)));
        for text in ["0", "-1", "1.5", "", "none"] {
            assert!(exponents(text).is_err(), "{text}");
        }
        assert_eq!(positive("2.5"), Ok(2.5));
        for text in ["0", "-1", "nan", "inf", "much"] {
            assert!(positive(text).is_err(), "{text}");
        }
    }
}
