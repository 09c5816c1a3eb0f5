//! `squeakscope lyapunov`: does the motion repeat, drift on a torus, or forget itself, and how fast?

use std::error::Error;
use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::args::LyapunovArgs;
use super::error::{Cause, CliError};
use super::figures::{PIXELS, write_figure, write_figures};
use super::interrupt;
use super::lyapunov_report::{LyapunovReport, csv, in_brief};
use super::output::{
    OutputError, OutputFile, check_all, check_apart, check_beside, check_directory,
};
use super::progress::Progress;
use super::report::{self, FileReport};
use crate::dynamics::DynamicsError;
use crate::plot::{Figure, Format};
use crate::scene::{DEFAULT_SCENE, Scene};
use crate::study::Watch;
use crate::study::lyapunov::{
    Count, Ending, Goal, LyapunovProgress, LyapunovRequest, Phase, SceneLyapunov,
};

/// What the rest of the crate does for this command.
pub(super) struct Tools {
    /// Averages the exponents of a scene.
    pub follow:
        fn(&Scene, &LyapunovRequest, Watch<'_, LyapunovProgress>) -> Result<SceneLyapunov, Cause>,
    /// Their figure, under a name.
    pub draw: fn(&str, &SceneLyapunov) -> Figure,
}

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or drawing; Ctrl-C, after the results are
/// written.
pub(super) fn lyapunov(args: &LyapunovArgs, tools: &Tools) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop, tools)
}

fn execute(args: &LyapunovArgs, stop: &AtomicBool, tools: &Tools) -> Result<(), CliError> {
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    let terminal = Some(Path::new("-"));
    let json_shown = args.json.as_deref() == terminal;
    let csv_shown = args.csv.as_deref() == terminal;
    if json_shown && csv_shown {
        let (option, other) = ("--csv", "--json");
        let path = PathBuf::from("-");
        return Err(OutputError::Twice {
            path,
            option,
            other,
        }
        .into());
    }
    let path = args.figures.as_deref();
    // A file says its format; all else is a directory.
    let one = path.and_then(|path| Some((path, Format::of(path)?)));
    let one = one.filter(|(path, _)| !path.is_dir());
    let directory = path.filter(|_| one.is_none());
    let [json, csv_file, picture] = check_all(
        args.scene.as_deref().map(OsStr::new),
        [
            ("--json", args.json.as_deref().filter(|_| !json_shown)),
            ("--csv", args.csv.as_deref().filter(|_| !csv_shown)),
            ("--figures", one.map(|(path, _)| path)),
        ],
    )?;
    if let Some(directory) = directory {
        let others = [("--json", json.as_ref()), ("--csv", csv_file.as_ref())];
        check_figures(directory, &args.drawn.names(["lyapunov"], &PIXELS), &others)?;
    }
    let request = LyapunovRequest {
        count: args.exponents.unwrap_or(Count::All),
        settle: args.settle.map(|ms| 1e-3 * ms),
        goal: match (args.until, args.error) {
            (Some(time), _) => Goal::Time(time),
            (None, Some(half_width)) => Goal::HalfWidth(half_width),
            (None, None) => Goal::Verdict,
        },
        tolerance: args.tolerance,
    };
    let progress = Progress::of_estimate();
    let found = (tools.follow)(&scene, &request, &mut |at| {
        progress.tell(at.share, words(&at));
        // Until the transient is over, nothing is known.
        at.phase == Phase::Transient && !stop.load(Ordering::Relaxed) || interrupt::goes_on(stop)
    });
    // The bar goes before anything else is printed.
    drop(progress);
    let failed = |doing| move |source| CliError::Run { doing, source };
    let found = found.map_err(|source| match too_many(source.as_ref()) {
        Some(refused) => refused,
        None => failed("averaging of exponents")(source),
    })?;

    let mut files = Vec::new();
    // What is found is told even where a file cannot be written.
    let mut write_all = || -> Result<(), CliError> {
        if let Some(file) = &csv_file {
            file.write(|out| out.write_all(csv(&found.study.running).as_bytes()))?;
            files.push(FileReport::of(file)?);
        }
        let name = LyapunovReport::title(&scene.name, found.tilt);
        if let (Some(file), Some((_, format))) = (&picture, one) {
            let figure = (tools.draw)(&name, &found);
            files.push(write_figure(file, &figure, &args.drawn, format)?);
        }
        if let Some(directory) = directory {
            let figure = (tools.draw)(&name, &found);
            let drawn = (&args.drawn, &PIXELS[..]);
            files.extend(write_figures(directory, "--figures", &[figure], drawn)?);
        }
        Ok(())
    };
    let written = write_all();
    let report = LyapunovReport::new(&scene.name, &request, &found, files);
    if json_shown {
        report::print_json(&report)?;
    } else if csv_shown {
        report::print(&csv(&found.study.running))?;
        report::write_json(&report, json.as_ref())?;
    } else {
        report::deliver(&report, json.as_ref())?;
    }
    written?;
    match found.study.ending {
        Ending::Stopped => Err(CliError::Interrupted),
        Ending::Reached | Ending::OutOfTime => Ok(()),
    }
}

/// Whether more exponents were asked for than there are, among the causes of a fault.
fn too_many(cause: &(dyn Error + 'static)) -> Option<CliError> {
    match cause.downcast_ref() {
        Some(&DynamicsError::Width { asked, dimension }) => {
            Some(CliError::Exponents { asked, dimension })
        }
        _ => cause.source().and_then(too_many),
    }
}

/// The scene asked for, with what the command line changes of it.
fn scene(args: &LyapunovArgs) -> Result<Scene, CliError> {
    let mut scene = Scene::load(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    if let Some(error) = args.accuracy {
        scene = scene.with_accuracy(error)?;
    }
    if let Some(tilt) = args.tilt {
        scene = scene.with_tilt(tilt)?;
    }
    if let Some(duration) = args.duration {
        scene = scene.with_duration(duration)?;
    }
    if let Some(tolerance) = args.tolerance {
        scene = scene.with_tolerance(tolerance)?;
    }
    if let Some(seed) = args.seed {
        scene = scene.with_seed(seed);
    }
    Ok(scene.without_analyses())
}

/// Checks a directory for figures, which need not be there yet, and the files that will be in it.
fn check_figures(
    directory: &Path,
    names: &[String],
    others: &[(&'static str, Option<&OutputFile>)],
) -> Result<(), CliError> {
    check_directory(directory, "--figures", names)?;
    check_apart(directory, "--figures", others)?;
    check_beside(directory, "--figures", names, others)?;
    Ok(())
}

/// What the progress bar says.
fn words(at: &LyapunovProgress) -> String {
    match (at.phase, at.largest) {
        (Phase::Transient, _) => "the scene runs".to_owned(),
        (Phase::Settling, _) => "the tangent vectors settle".to_owned(),
        (Phase::Averaging, None) => "averaging".to_owned(),
        (Phase::Averaging, Some(largest)) => {
            format!("averaging, the largest is {} 1/s", in_brief(largest))
        }
    }
}

#[cfg(test)]
#[path = "lyapunov_tests.rs"]
mod tests;
