//! Arguments of `squeakscope live`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args as Arguments;

use super::browser::BrowserArgs;
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
    /// Address of the page; with any address other than 127.0.0.1, other machines can watch the run, and control
    /// it with the key in the printed address.
    #[arg(
        long,
        value_name = "ADDRESS",
        default_value = "127.0.0.1",
        help_heading = "Page"
    )]
    pub host: IpAddr,
    /// Port of the page; 0 takes a free port.
    #[arg(
        long,
        value_name = "PORT",
        default_value_t = 9180,
        help_heading = "Page"
    )]
    pub port: u16,
    /// Start a guided tour on the page: the one that ships, or that of a TOML file.
    #[arg(long, value_name = "FILE", num_args = 0..=1, help_heading = "Page")]
    pub tour: Option<Option<PathBuf>>,
    #[command(flatten, next_help_heading = "Page")]
    pub browser: BrowserArgs,
    /// Also open a Rerun viewer on this machine.
    #[arg(long, conflicts_with = "connect", help_heading = "Viewer")]
    pub spawn: bool,
    /// Also send the run to a Rerun viewer that is open.
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = DEFAULT_URL,
        value_parser = viewer_url, help_heading = "Viewer")]
    pub connect: Option<String>,
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
