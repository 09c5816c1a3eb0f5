//! `squeakscope live`: an interactive run, controlled from its page.

use std::net::{IpAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Arg, Args as Arguments};

use super::audit;
use super::browser::BrowserArgs;
use super::common_args::{AccuracyArgs, BudgetArgs, SceneArgs, SoundArgs, ViewerArgs, positive};
use super::console;
use super::error::CliError;
use super::harness::{OutputArgs, Outputs};
use super::interrupt;
use super::output::{Kind, Overwrite, check_file};
use super::resources;
use crate::escape;
use crate::live::{
    Command, Limits, Page, SPEED_RANGE, SavedFile, Session, SessionOptions, Tour, bind,
};
use crate::pipeline::PipelineError;
use crate::pipeline::message::Summary;
use crate::scene::Scene;

/// Arguments of `squeakscope live`.
#[derive(Debug, Arguments)]
#[command(next_help_heading = "Simulation", mut_args(also_viewer))]
pub struct LiveArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Start at this tilt of the load, -90 to 90 degrees, and hold it until you change it.
    #[arg(long, value_name = "DEG")]
    pub tilt: Option<f64>,
    /// Playback speed at the start, 0.01 to 1000 simulated ms per second; 1000 is real time.
    #[arg(long, value_name = "MS", default_value_t = 20.0, value_parser = positive)]
    pub speed: f64,
    #[command(flatten)]
    pub accuracy: AccuracyArgs,
    #[command(flatten)]
    pub budget: BudgetArgs,
    /// Skip Lyapunov exponents and the perturbed trajectory (the most expensive analyses) to keep up with
    /// real time.
    #[arg(long)]
    pub no_lyapunov: bool,
    /// Fail with exit code 1 if the residual of the last energy audit exceeds 5 %; refuse a scene without an
    /// audit.
    #[arg(long)]
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
    #[command(flatten)]
    pub viewer: ViewerArgs,
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

/// Describes the viewer as an addition to the page. An argument that `mut_arg` changes would move to the end of the help.
fn also_viewer(arg: Arg) -> Arg {
    match arg.get_id().as_str() {
        "spawn" => arg.help("Also open a Rerun viewer on this machine"),
        "connect" => arg.help("Also send the run to a Rerun viewer that is open"),
        _ => arg,
    }
}

/// Period of the checks for an interrupt and for the end of the run.
pub(super) const POLL_PERIOD: Duration = Duration::from_millis(10);

/// The task in an error.
const LIVE_RUN: &str = "live run";

/// Runs the command until Ctrl-C, which is its normal end.
///
/// # Errors
/// Bad input before any work; failure while running, after the files are complete.
pub(super) fn run(args: &LiveArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let tilt = [("load.tilt_deg", args.tilt)];
    let scene = args.scene.load_with(args.accuracy, &tilt)?;
    let scene = args.budget.apply(scene)?;
    console::print_warnings(&scene.warnings());
    audit::check_scene(&scene, args.strict)?;
    let plan = plan(args, scene)?;
    resources::check_memory()?;
    resources::start_thread_pool()?;
    let listener = bound(args.host, args.port)?;
    let second = Arc::new(Session::new(plan.second()));
    let session = Arc::new(Session::new(plan));
    if args.tour.is_some() {
        let first = session.apply(&Command::Tour { step: Some(0) });
        first.map_err(CliError::during(LIVE_RUN))?;
    }
    let page = Page::open(
        listener,
        Arc::clone(&session),
        Some(second),
        Limits::default(),
    );
    let page = page.map_err(|source| CliError::Threads("the page", source.into()))?;
    console::print(&format!("live page: {}\n", page.url()))?;
    if !args.host.is_loopback() {
        console::print_warning(
            "whoever knows this address can control the run (--host); give the audience the address under \
             `Share`, which only watches",
        );
    }
    let ended = control(&session, stop, &page, args.browser)?;
    let closed = page.close();
    // After a failed run, do not also report recordings that had not started.
    let delivered = deliver(session.saved(ended.is_ok()));
    let summary = ended.map_err(|fault| {
        // `main` prints the returned error, so the cause comes last.
        if let Err(missing) = &delivered {
            console::print_error(missing);
        }
        CliError::during(LIVE_RUN)(fault)
    })?;
    delivered?;
    closed.map_err(CliError::during(LIVE_RUN))?;
    summary.map_or(Ok(()), |summary| audit::check(&summary, args.strict))
}

/// A listener of a page.
///
/// # Errors
/// If the address or the port cannot be used.
pub(super) fn bound(host: IpAddr, port: u16) -> Result<TcpListener, CliError> {
    bind(host, port).map_err(|source| {
        CliError::Failed(format!(
            "cannot serve the page at {host}, port {port}: {source}; choose another --port (0 for any free port) or --host"
        ))
    })
}

/// Prints the saved files, and the error of each missing file; returns the last error.
fn deliver(files: Vec<SavedFile>) -> Result<(), CliError> {
    let mut delivered = Ok(());
    for SavedFile { path, outcome } in files {
        let outcome = outcome.and_then(|()| match path.metadata() {
            Ok(_) => Ok(()),
            Err(fault) => Err(format!("it was complete, but has been removed: {fault}").into()),
        });
        match outcome {
            Ok(()) => console::print(&format!("{}\n", escape::path(&path)))?,
            Err(source) => {
                if let Err(earlier) = &delivered {
                    console::print_error(earlier);
                }
                delivered = Err(CliError::NotSaved(path, source));
            }
        }
    }
    delivered
}

type RunEnd = Result<Option<Summary>, PipelineError>;

/// Runs a session until a signal, the page or a failure ends it. Opens the browser once there is something to see.
fn control(
    session: &Arc<Session>,
    stop: &AtomicBool,
    page: &Page,
    browser: BrowserArgs,
) -> Result<RunEnd, CliError> {
    interrupt::start_work();
    session.start().map_err(CliError::during(LIVE_RUN))?;
    let mut is_shown = false;
    while !session.is_finished() {
        if stop.load(Ordering::Relaxed) || page.is_finished() {
            session.end();
        } else if !is_shown && session.panel().time_s > 0.0 {
            is_shown = true;
            browser.open(page.url());
        }
        std::thread::sleep(POLL_PERIOD);
    }
    Ok(session.join())
}

fn plan(args: &LiveArgs, scene: Scene) -> Result<SessionOptions, CliError> {
    let [low, high] = SPEED_RANGE;
    if !(low..=high).contains(&args.speed) {
        return Err(CliError::Input(format!(
            "--speed {} is out of range; give {low} to {high} simulated ms per second",
            args.speed
        )));
    }
    let output = OutputArgs {
        json: None,
        overwrite: args.overwrite,
    };
    let files = Outputs::new(args.scene.input(), &output)
        .file("--save", Kind::RECORDING, args.save.as_ref())?
        .file("--wav", Kind::SOUND, args.audio.wav.as_ref())?
        .check()?;
    // live-0.rrd is never used: this checks the directory.
    check_file(&args.record_dir.join("live-0.rrd"), "--record-dir")?;
    Ok(SessionOptions {
        scene,
        command: console::command_line(),
        speed: 1e-3 * args.speed,
        lyapunov: !args.no_lyapunov,
        viewer: args.viewer.output(None),
        computes_diagram: true,
        folder: args.record_dir.clone(),
        save: files.path("--save"),
        wav: files.path("--wav"),
        source: args.audio.source(),
        tour: match &args.tour {
            Some(Some(path)) => Some(Tour::read(path)?),
            Some(None) | None => Tour::shipped(),
        },
    })
}
