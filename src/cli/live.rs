//! `squeakscope live`: a run that goes on until told to stop, and is steered meanwhile.

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
use super::output::{OutputFile, check_all};
use super::report;
use super::resources;
use super::run::command_line;
use super::terminal::Terminal;
use crate::escape;
use crate::live::{Bands, PACES, Page, Plan, Running, SavedFile, Session, Watcher, bind};
use crate::pipeline::PipelineError;
use crate::pipeline::message::Summary;
use crate::record::{Output, RERUN_VERSION};
use crate::scene::Scene;

/// The table that `sweep` writes unless told otherwise.
const LAST_SWEEP: &str = "sweep.arrow";
/// How often it is looked whether the run is to end.
const LOOK_EVERY: Duration = Duration::from_millis(25);

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running; Ctrl-C, after the files are whole.
pub(super) fn run(args: &LiveArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    if args.strict && !audit::is_audited(&scene) {
        return Err(CliError::NotAudited);
    }
    let swept = bands(args.sweep.as_deref())?;
    let plan = plan(args, scene)?;
    resources::check_memory()?;
    resources::start_pool()?;
    let page = match plan.watcher {
        Watcher::Page => Some(
            bind(args.host, args.port).map_err(|source| CliError::Serve {
                host: args.host,
                port: args.port,
                source,
            })?,
        ),
        Watcher::Viewer(_) => None,
    };
    let session = Arc::new(Session::new(plan));
    let page = match page {
        None => None,
        Some(serving) => {
            let address = serving.address;
            let page = Page::open(serving, Arc::clone(&session), swept);
            let page = page.map_err(|source| CliError::Threads {
                purpose: "the page",
                source: source.into(),
            })?;
            report::print(&format!("the page: {}\n", page.url()))?;
            if !address.ip().is_loopback() {
                report::print_warning("whoever reaches this address can watch and steer (--host)");
            }
            Some(page)
        }
    };
    let keys = !args.no_keys && stdin().is_terminal() && stdout().is_terminal();
    let ran = steer(&session, &stop, keys, page.as_ref())?;
    let closed = page.map_or(Ok(()), Page::close);
    let mut files = session.saved();
    // That what was not begun is not there needs no words beside those of a run that failed.
    files.retain(|file| file.begun || ran.is_ok());
    let delivered = deliver(files);
    let summary = ran.map_err(|fault| {
        // The cause comes last, as everywhere.
        if let Err(missing) = &delivered {
            report::print_error(missing);
        }
        faulty(fault.into())
    })?;
    delivered?;
    closed.map_err(|fault| faulty(fault.into()))?;
    let interrupted = stop.load(Ordering::Relaxed);
    match summary {
        Some(summary) if interrupted => {
            audit::judge(&summary, false).and(Err(CliError::Interrupted))
        }
        Some(summary) => audit::judge(&summary, args.strict),
        None => Ok(()),
    }
}

/// Prints the files that are there, and the error of each that is not; the last one is returned.
fn deliver(files: Vec<SavedFile>) -> Result<(), CliError> {
    let mut delivered = Ok(());
    for SavedFile { path, outcome, .. } in files {
        let there = outcome.and_then(|()| match path.metadata() {
            Ok(_) => Ok(()),
            Err(fault) => Err(format!("it was complete, but is there no longer: {fault}").into()),
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

fn faulty(source: super::error::Cause) -> CliError {
    CliError::Run {
        doing: "live run",
        source,
    }
}

type Ran = Result<Option<Summary>, PipelineError>;

/// Lets a session go on until it is ended by keys, by a signal or by a fault.
fn steer(
    session: &Arc<Session>,
    stop: &AtomicBool,
    keys: bool,
    page: Option<&Page>,
) -> Result<Ran, CliError> {
    interrupt::work_begins();
    let running = start(session, keys)?;
    let mut terminal = match keys {
        true => Some(Terminal::open(page.map(Page::url)).map_err(|fault| faulty(fault.into()))?),
        false => {
            if stderr().is_terminal() {
                report::print_warning("there are no keys here; Ctrl-C ends the run");
            }
            None
        }
    };
    while !running.is_over() {
        let mut ended = stop.load(Ordering::Relaxed) || page.is_some_and(Page::is_over);
        if let Some(terminal) = &mut terminal {
            let told = terminal.turn(session);
            match told.map_err(|fault| faulty(fault.into()))? {
                super::terminal::Told::Nothing => {}
                super::terminal::Told::Quit => ended = true,
                super::terminal::Told::Interrupt => {
                    stop.store(true, Ordering::Relaxed);
                    ended = true;
                }
            }
        }
        if ended {
            session.end();
        }
        running.wait(LOOK_EVERY);
    }
    drop(terminal);
    Ok(running.end())
}

/// Starts a session, which tells what happens beside it: in the terminal if that shows it, else as warnings.
fn start(session: &Arc<Session>, keys: bool) -> Result<Running, CliError> {
    let told = Arc::clone(session);
    let notice: Arc<dyn Fn(&str) + Send + Sync> = match keys {
        true => Arc::new(move |words| told.tell(words)),
        false => Arc::new(report::print_warning),
    };
    Running::start(session, notice).map_err(|fault| faulty(fault.into()))
}

/// The scene asked for, with what the command line changes of it.
fn scene(args: &LiveArgs) -> Result<Scene, CliError> {
    let mut scene = args.scene.load()?;
    scene = args.accuracy.apply(scene)?;
    scene = changed(scene, args.tilt, Scene::with_tilt)?;
    Ok(scene)
}

fn plan(args: &LiveArgs, scene: Scene) -> Result<Plan, CliError> {
    let [low, high] = PACES;
    if !(low..=high).contains(&args.pace) {
        return Err(CliError::Pace {
            asked: args.pace,
            low,
            high,
        });
    }
    let [save, wav] = check_all(
        args.scene.input(),
        [
            ("--save", args.save.as_deref()),
            ("--wav", args.heard.wav.as_deref()),
        ],
    )?;
    // A name that nobody has: whether there can be recordings at all.
    OutputFile::check(&args.folder.join("live-0.rrd"), "--folder")?;
    Ok(Plan {
        scene,
        command: command_line(),
        pace: 1e-3 * args.pace,
        neighbours: !args.no_neighbours,
        watcher: watcher(args),
        folder: args.folder.clone(),
        save: save.map(|file| file.path().to_owned()),
        wav: wav.map(|file| file.path().to_owned()),
        source: args.heard.source(),
    })
}

fn watcher(args: &LiveArgs) -> Watcher {
    let viewer = |connect, spawn| {
        Watcher::Viewer(Output {
            save: None,
            connect,
            spawn,
        })
    };
    match &args.connect {
        Some(url) => viewer(Some(url.clone()), false),
        None if args.spawn => viewer(None, true),
        None if args.serve || !viewer_is_installed() => Watcher::Page,
        None => viewer(None, true),
    }
}

/// Whether there is a viewer on the `PATH` that opens what is recorded here.
fn viewer_is_installed() -> bool {
    let asked = Command::new("rerun")
        .arg("--version")
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output();
    asked.is_ok_and(|said| String::from_utf8_lossy(&said.stdout).contains(RERUN_VERSION))
}

/// The kinds of motion that a sweep has found: that which is asked for, else the last one if it is there.
fn bands(asked: Option<&Path>) -> Result<Option<Bands>, CliError> {
    match asked {
        Some(path) => match Bands::of_sweep(path)? {
            Some(bands) => Ok(Some(bands)),
            None => Err(CliError::NoBands {
                path: path.to_owned(),
            }),
        },
        // Whatever else has that name is none of our business.
        None => Ok(Bands::of_sweep(Path::new(LAST_SWEEP)).ok().flatten()),
    }
}
