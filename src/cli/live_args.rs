//! Arguments of `squeakscope live`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args as Arguments;

use super::common_args::{AccuracyArgs, DEFAULT_URL, SceneArgs, positive, viewer_url};
use super::sound_args::SoundArgs;

/// Arguments of `squeakscope live`.
#[derive(Debug, Arguments)]
pub struct LiveArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Begin at this tilt of the load, -90 to 90 degrees, and stay there until told otherwise.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub tilt: Option<f64>,
    /// Begin at this pace, 0.01 to 1000 simulated ms a second; 1000 is real time.
    #[arg(long, value_name = "MS", default_value_t = 20.0, value_parser = positive, allow_negative_numbers = true)]
    pub pace: f64,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    /// Leave out exponents and second copy of the scene, which cost most: for real time.
    #[arg(long)]
    pub no_neighbours: bool,
    /// Open a viewer on this machine, and steer from the terminal [default, where a viewer of the right version is installed].
    #[arg(long, group = "watched")]
    pub spawn: bool,
    /// Watch in a viewer that is already open, and steer from the terminal.
    #[arg(long, value_name = "URL", num_args = 0..=1, default_missing_value = DEFAULT_URL,
        value_parser = viewer_url, group = "watched")]
    pub connect: Option<String>,
    /// Serve a page with viewer, controls and sound [default, where no viewer is installed].
    #[arg(long, group = "watched")]
    pub serve: bool,
    /// Where the page is served; anything but 127.0.0.1 lets others watch and steer.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", conflicts_with_all = ["spawn", "connect"])]
    pub host: IpAddr,
    /// Port of the page; 0 takes one that is free.
    #[arg(long, value_name = "PORT", default_value_t = 9180, conflicts_with_all = ["spawn", "connect"])]
    pub port: u16,
    /// Draw the kinds of motion in this table of `sweep` under the slider of the tilt [default: sweep.arrow, if it is there].
    #[arg(long, value_name = "FILE", conflicts_with_all = ["spawn", "connect"])]
    pub sweep: Option<PathBuf>,
    /// Record from the start into this file.
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Where recordings go that are asked for on the way, as live-1.rrd, live-2.rrd, ...
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub folder: PathBuf,
    /// What is heard.
    #[command(flatten)]
    pub heard: SoundArgs,
    /// End with exit code 1 if energy and work of the last run do not agree to 5 %; refuse a scene whose energy is not audited.
    #[arg(long)]
    pub strict: bool,
    /// Take no keys and draw nothing in the terminal.
    #[arg(long)]
    pub no_keys: bool,
}
