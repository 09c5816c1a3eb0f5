//! Arguments of `squeakscope live`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args as Arguments;

use super::common_args::{AccuracyArgs, BudgetArgs, DEFAULT_URL, SceneArgs, positive, viewer_url};
use super::output::Overwrite;
use super::sound_args::SoundArgs;

/// Arguments of `squeakscope live`.
#[derive(Debug, Arguments)]
pub struct LiveArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Start at this tilt of the load, -90 to 90 degrees, and hold it until you change it.
    #[arg(long, value_name = "DEG", help_heading = "Simulation")]
    pub tilt: Option<f64>,
    /// Playback speed at the start, 0.01 to 1000 simulated ms per second; 1000 is real time.
    #[arg(long, value_name = "MS", default_value_t = 20.0, value_parser = positive, help_heading = "Simulation")]
    pub speed: f64,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    #[command(flatten)]
    pub budget: BudgetArgs,
    /// Skip Lyapunov exponents and the perturbed trajectory (the most expensive analyses) to keep up with
    /// real time.
    #[arg(long, help_heading = "Simulation")]
    pub no_lyapunov: bool,
    /// Fail with exit code 1 if the residual of the last energy audit exceeds 5 %; refuse a scene without an
    /// audit.
    #[arg(long, help_heading = "Simulation")]
    pub strict: bool,
    /// Open a Rerun viewer on this machine; control the run from the terminal [default, if a viewer of the
    /// right version is installed].
    #[arg(long, group = "watched", help_heading = "Viewer")]
    pub spawn: bool,
    /// Send the recording to a running Rerun viewer; control the run from the terminal.
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = DEFAULT_URL,
        value_parser = viewer_url, group = "watched", help_heading = "Viewer")]
    pub connect: Option<String>,
    /// Serve a web page with views, controls and sound [default, if no viewer is installed].
    #[arg(long, group = "watched", help_heading = "Viewer")]
    pub serve: bool,
    /// Address of the page; with any address other than 127.0.0.1, other machines can watch the run, and control
    /// it with the key in the printed address.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1",
        conflicts_with_all = ["spawn", "connect"], help_heading = "Viewer")]
    pub host: IpAddr,
    /// Port of the page; 0 takes a free port.
    #[arg(long, value_name = "PORT", default_value_t = 9180,
        conflicts_with_all = ["spawn", "connect"], help_heading = "Viewer")]
    pub port: u16,
    /// Show the types of motion of this `sweep` table under the tilt slider [default: sweep.arrow, if it
    /// exists].
    #[arg(long, value_name = "FILE", conflicts_with_all = ["spawn", "connect"],
        help_heading = "Viewer")]
    pub sweep: Option<PathBuf>,
    /// Start a guided tour on the page: the one that ships, or that of a TOML file.
    #[arg(long, value_name = "FILE", num_args = 0..=1, conflicts_with_all = ["spawn", "connect"],
        help_heading = "Viewer")]
    pub tour: Option<Option<PathBuf>>,
    /// Ignore the keyboard and draw nothing in the terminal.
    #[arg(long, help_heading = "Viewer")]
    pub no_keys: bool,
    /// Save a recording from the start to this file.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub save: Option<PathBuf>,
    /// Directory for the recordings that you start during the run: live-1.rrd, live-2.rrd, ...
    #[arg(long, value_name = "DIR", default_value = ".", help_heading = "Output")]
    pub record_dir: PathBuf,
    #[command(flatten)]
    pub overwrite: Overwrite,
    #[command(flatten)]
    pub audio: SoundArgs,
}
