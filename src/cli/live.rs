//! `squeakscope live`: an interactive run, controlled from the terminal or the live page.

use std::io::{IsTerminal, stderr, stdin, stdout};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::audit;
use super::common_args::changed;
use super::error::CliError;
use super::interrupt;
use super::live_args::LiveArgs;
use super::output::{Kind, OutputFile};
use super::report;
use super::resources;
use super::run::command_line;
use super::terminal::{KeyAction, Terminal};
use crate::escape;
use crate::live::{
    Page, PageContent, RegimeBands, SPEED_RANGE, SavedFile, Session, SessionOptions, SessionThread,
    Tour, ViewTarget, bind,
};
use crate::pipeline::PipelineError;
use crate::pipeline::message::Summary;
use crate::record::{Output, RERUN_VERSION};
use crate::scene::Scene;

/// Default table of `sweep`.
const DEFAULT_SWEEP: &str = "sweep.arrow";
/// Period of the checks for keys and for the end of the run.
const POLL_PERIOD: Duration = Duration::from_millis(25);

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running; an interrupt, after the files are complete.
pub(super) fn run(args: &LiveArgs, stop: &Arc<AtomicBool>) -> Result<(), CliError> {
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    if args.strict && !audit::is_audited(&scene) {
        return Err(CliError::NotAudited);
    }
    let mut content = content(args)?;
    let plan = plan(args, scene)?;
    resources::check_memory()?;
    resources::start_thread_pool()?;
    let page = match plan.watcher {
        ViewTarget::Page => Some(
            bind(args.host, args.port).map_err(|source| CliError::Serve {
                host: args.host,
                port: args.port,
                source,
            })?,
        ),
        ViewTarget::Views | ViewTarget::Viewer(_) => None,
    };
    let second = page.is_some().then(|| Session::new(second(&plan)));
    let session = Arc::new(Session::new(plan));
    let page = match page {
        None => None,
        Some(serving) => {
            let address = serving.address;
            content.second = second.map(Arc::new);
            let page = Page::open(serving, Arc::clone(&session), content);
            let page = page.map_err(|source| CliError::Threads {
                purpose: "the page",
                source: source.into(),
            })?;
            report::print(&format!("live page: {}\n", page.url()))?;
            if !address.ip().is_loopback() {
                report::print_warning(
                    "whoever knows this address can control the run (--host); give the audience the address under \
                     `Share`, which only watches",
                );
            }
            Some(page)
        }
    };
    let keys = !args.no_keys && stdin().is_terminal() && stdout().is_terminal();
    let ended = control(&session, stop, keys, page.as_ref())?;
    let closed = page.map_or(Ok(()), Page::close);
    let mut files = session.saved();
    // After a failed run, do not also report recordings that had not started.
    files.retain(|file| file.begun || ended.is_ok());
    let delivered = deliver(files);
    let summary = ended.map_err(|fault| {
        // `main` prints the returned error, so the cause comes last.
        if let Err(missing) = &delivered {
            report::print_error(missing);
        }
        failed(fault.into())
    })?;
    delivered?;
    closed.map_err(|fault| failed(fault.into()))?;
    let interrupted = stop.load(Ordering::Relaxed);
    match summary {
        Some(summary) if interrupted => {
            audit::check(&summary, false).and(Err(CliError::Interrupted))
        }
        Some(summary) => audit::check(&summary, args.strict),
        None => Ok(()),
    }
}

/// Prints the saved files, and the error of each missing file; returns the last error.
fn deliver(files: Vec<SavedFile>) -> Result<(), CliError> {
    let mut delivered = Ok(());
    for SavedFile { path, outcome, .. } in files {
        let there = outcome.and_then(|()| match path.metadata() {
            Ok(_) => Ok(()),
            Err(fault) => Err(format!("it was complete, but has been removed: {fault}").into()),
        });
        match there {
            Ok(()) => report::print(&format!("{}\n", escape::path(&path)))?,
            Err(source) => {
                if let Err(earlier) = &delivered {
                    report::print_error(earlier);
                }
                delivered = Err(CliError::NotSaved { path, source });
            }
        }
    }
    delivered
}

fn failed(source: super::error::Cause) -> CliError {
    CliError::Run {
        task: "live run",
        source,
    }
}

type RunEnd = Result<Option<Summary>, PipelineError>;

/// Runs a session until a key, a signal, the page or a failure ends it.
fn control(
    session: &Arc<Session>,
    stop: &AtomicBool,
    keys: bool,
    page: Option<&Page>,
) -> Result<RunEnd, CliError> {
    interrupt::start_work();
    let running = start(session, keys)?;
    let mut terminal = match keys {
        true => Some(Terminal::open(page.map(Page::url)).map_err(|fault| failed(fault.into()))?),
        false => {
            if stderr().is_terminal() {
                report::print_warning("keyboard control needs a terminal; Ctrl-C ends the run");
            }
            None
        }
    };
    while !running.is_finished() {
        let mut ended = stop.load(Ordering::Relaxed) || page.is_some_and(Page::is_finished);
        if let Some(terminal) = &mut terminal {
            let action = terminal.update(session);
            match action.map_err(|fault| failed(fault.into()))? {
                KeyAction::Continue => {}
                KeyAction::Quit => ended = true,
                KeyAction::Interrupt => {
                    stop.store(true, Ordering::Relaxed);
                    ended = true;
                }
            }
        }
        if ended {
            session.end();
        }
        running.wait(POLL_PERIOD);
    }
    drop(terminal);
    Ok(running.end())
}

/// Starts a session. Its notices appear in the terminal interface, or as warnings without one.
fn start(session: &Arc<Session>, keys: bool) -> Result<SessionThread, CliError> {
    let notified = Arc::clone(session);
    let notice: Arc<dyn Fn(&str) + Send + Sync> = match keys {
        true => Arc::new(move |message| notified.log(message)),
        false => Arc::new(report::print_warning),
    };
    SessionThread::start(session, notice).map_err(|fault| failed(fault.into()))
}

/// The scene with the changes of the command line.
fn scene(args: &LiveArgs) -> Result<Scene, CliError> {
    let mut scene = args.scene.load()?;
    scene = args.accuracy.apply(scene)?;
    scene = args.budget.apply(scene);
    scene = changed(scene, args.tilt, Scene::with_tilt)?;
    Ok(scene)
}

fn plan(args: &LiveArgs, scene: Scene) -> Result<SessionOptions, CliError> {
    let [low, high] = SPEED_RANGE;
    if !(low..=high).contains(&args.speed) {
        return Err(CliError::Speed {
            requested: args.speed,
            low,
            high,
        });
    }
    let [save, wav] = args.overwrite.check_all(
        args.scene.input(),
        [
            ("--save", Kind::RECORDING, args.save.as_deref()),
            ("--wav", Kind::SOUND, args.audio.wav.as_deref()),
        ],
    )?;
    // live-0.rrd is never used: this checks the directory.
    OutputFile::check(&args.record_dir.join("live-0.rrd"), "--record-dir")?;
    Ok(SessionOptions {
        scene,
        command: command_line(),
        speed: 1e-3 * args.speed,
        lyapunov: !args.no_lyapunov,
        watcher: watcher(args),
        folder: args.record_dir.clone(),
        save: save.map(|file| file.path().to_owned()),
        wav: wav.map(|file| file.path().to_owned()),
        source: args.audio.source(),
    })
}

fn watcher(args: &LiveArgs) -> ViewTarget {
    let viewer = |connect, spawn| {
        ViewTarget::Viewer(Output {
            save: None,
            connect,
            spawn,
        })
    };
    match &args.connect {
        Some(url) => viewer(Some(url.clone()), false),
        None if args.spawn => viewer(None, true),
        None if args.serve || args.tour.is_some() || !viewer_is_installed() => ViewTarget::Page,
        None => viewer(None, true),
    }
}

/// What the page shows besides the run.
fn content(args: &LiveArgs) -> Result<PageContent, CliError> {
    let tour = match &args.tour {
        Some(Some(path)) => Some(Tour::read(path)?),
        Some(None) | None => Tour::shipped(),
    };
    Ok(PageContent {
        swept: bands(args.sweep.as_deref())?,
        tour,
        starts_tour: args.tour.is_some(),
        second: None,
    })
}

/// The second run of the page: as the first one, but without its files and its most expensive analyses.
fn second(plan: &SessionOptions) -> SessionOptions {
    SessionOptions {
        scene: plan.scene.clone(),
        command: plan.command.clone(),
        speed: plan.speed,
        lyapunov: false,
        watcher: ViewTarget::Views,
        folder: plan.folder.clone(),
        save: None,
        wav: None,
        source: plan.source,
    }
}

/// Whether the `PATH` has a Rerun viewer of the version that opens these recordings.
fn viewer_is_installed() -> bool {
    let output = Command::new("rerun")
        .arg("--version")
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output();
    output.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains(RERUN_VERSION))
}

/// The types of motion of a sweep: the requested table, or the default table if it exists.
fn bands(requested: Option<&Path>) -> Result<Option<RegimeBands>, CliError> {
    match requested {
        Some(path) => match RegimeBands::from_sweep(path)? {
            Some(bands) => Ok(Some(bands)),
            None => Err(CliError::NoBands {
                path: path.to_owned(),
            }),
        },
        // A file of that name that is not a sweep over the tilt is ignored.
        None => Ok(RegimeBands::from_sweep(Path::new(DEFAULT_SWEEP))
            .ok()
            .flatten()),
    }
}
