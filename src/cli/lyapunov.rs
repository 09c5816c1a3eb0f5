//! `squeakscope lyapunov`: does the motion repeat, drift on a torus, or forget itself, and how fast?

use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::args::LyapunovArgs;
use super::common_args::changed;
use super::document::{Document, WrittenFile};
use super::error::{Cause, CliError};
use super::figures::{FigureArgs, PIXELS, write_figure, write_figures};
use super::interrupt;
use super::lyapunov_text::{Found, csv, text, title};
use super::output::{
    OutputError, OutputFile, check_all, check_apart, check_beside, check_directory,
};
use super::progress::Progress;
use super::report;
use crate::dynamics::DynamicsError;
use crate::number::uncertain;
use crate::plot::{Format, lyapunov_figure};
use crate::scene::Scene;
use crate::study::lyapunov::{
    Count, Ending, Goal, LyapunovProgress, LyapunovRequest, Phase, SceneLyapunov, scene_lyapunov,
};

/// Runs the command.
///
/// # Errors
/// Bad input before any work; a fault while running or drawing; Ctrl-C, after the results are
/// written.
pub(super) fn lyapunov(args: &LyapunovArgs) -> Result<(), CliError> {
    let stop = interrupt::catch()?;
    execute(args, &stop)
}

fn execute(args: &LyapunovArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    let outputs = Outputs::check(args)?;
    let request = request(args);
    let progress = Progress::of_estimate();
    let found = scene_lyapunov(&scene, &request, &mut |at| {
        progress.tell(at.share, progress_words(&at));
        // Until the transient is over, nothing is known.
        at.phase == Phase::Transient && !stop.load(Ordering::Relaxed) || interrupt::goes_on(stop)
    });
    // The bar goes before anything else is printed.
    drop(progress);
    let found = found.map_err(|fault| failure(fault.into()))?;

    let mut files = Vec::new();
    // What is found is told even where a file cannot be written.
    let written = outputs.write(&scene.name, &found, &args.drawn, &mut files);
    let result = Found::new(request.goal, &found);
    let document = Document::new(&result, &files).of_scene(&scene.name);
    if is_printed(&args.json) {
        document.print()?;
    } else if is_printed(&args.csv) {
        report::print(&csv(&found.study.running))?;
        document.write(outputs.json.as_ref())?;
    } else {
        document.deliver(&text(&scene.name, &result), outputs.json.as_ref())?;
    }
    written?;
    match found.study.ending {
        Ending::Stopped => Err(CliError::Interrupted),
        Ending::Reached | Ending::OutOfTime => Ok(()),
    }
}

fn request(args: &LyapunovArgs) -> LyapunovRequest {
    LyapunovRequest {
        count: args.exponents.unwrap_or(Count::All),
        settle: args.settle.map(|ms| 1e-3 * ms),
        goal: match (args.until, args.error) {
            (Some(time), _) => Goal::Time(time),
            (None, Some(half_width)) => Goal::HalfWidth(half_width),
            (None, None) => Goal::Verdict,
        },
        tolerance: args.tolerance,
    }
}

/// Whether a result is printed in place of the table.
fn is_printed(path: &Option<PathBuf>) -> bool {
    path.as_deref() == Some(Path::new("-"))
}

/// The files asked for, checked before any work.
struct Outputs {
    json: Option<OutputFile>,
    csv: Option<OutputFile>,
    /// A file for the figure, whose ending says the format.
    picture: Option<(OutputFile, Format)>,
    /// A directory for the figure.
    directory: Option<PathBuf>,
}

impl Outputs {
    fn check(args: &LyapunovArgs) -> Result<Self, CliError> {
        let file = |path: &'_ Option<PathBuf>| path.clone().filter(|_| !is_printed(path));
        if is_printed(&args.json) && is_printed(&args.csv) {
            return Err(CliError::Output(OutputError::Twice {
                path: PathBuf::from("-"),
                option: "--csv",
                other: "--json",
            }));
        }
        let path = args.figures.as_deref();
        // A file says its format; all else is a directory.
        let one = path.and_then(|path| Some((path, Format::of(path)?)));
        let one = one.filter(|(path, _)| !path.is_dir());
        let directory = path.filter(|_| one.is_none());
        let [json, csv, picture] = check_all(
            args.scene.input(),
            [
                ("--json", file(&args.json).as_deref()),
                ("--csv", file(&args.csv).as_deref()),
                ("--figures", one.map(|(path, _)| path)),
            ],
        )?;
        if let Some(directory) = directory {
            let names = args.drawn.names(["lyapunov"], &PIXELS);
            let others = [("--json", json.as_ref()), ("--csv", csv.as_ref())];
            check_directory(directory, "--figures", &names)?;
            check_apart(directory, "--figures", &others)?;
            check_beside(directory, "--figures", &names, &others)?;
        }
        Ok(Self {
            json,
            csv,
            picture: picture.zip(one.map(|(_, format)| format)),
            directory: directory.map(Path::to_owned),
        })
    }

    /// Writes running values and figure; `files` are those that there are then.
    fn write(
        &self,
        scene: &str,
        found: &SceneLyapunov,
        drawn: &FigureArgs,
        files: &mut Vec<WrittenFile>,
    ) -> Result<(), CliError> {
        if let Some(file) = &self.csv {
            file.write(|out| out.write_all(csv(&found.study.running).as_bytes()))?;
            files.push(WrittenFile::of(file)?);
        }
        let figure = || lyapunov_figure(&title(scene, found.tilt), found);
        if let Some((file, format)) = &self.picture {
            files.push(write_figure(file, &figure(), drawn, *format)?);
        }
        if let Some(directory) = &self.directory {
            let drawn = (drawn, &PIXELS[..]);
            files.extend(write_figures(directory, "--figures", &[figure()], drawn)?);
        }
        Ok(())
    }
}

/// The error of a study: that more exponents were asked for than there are is bad input.
fn failure(source: Cause) -> CliError {
    too_many(source.as_ref()).unwrap_or(CliError::Run {
        doing: "averaging of exponents",
        source,
    })
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
    let mut scene = args.scene.load()?;
    scene = args.accuracy.apply(scene)?;
    scene = changed(scene, args.tilt, Scene::with_tilt)?;
    scene = changed(scene, args.duration, Scene::with_duration)?;
    scene = changed(scene, args.tolerance, Scene::with_tolerance)?;
    if let Some(seed) = args.seed {
        scene = scene.with_seed(seed);
    }
    Ok(scene.without_analyses())
}

/// What the progress bar says.
fn progress_words(at: &LyapunovProgress) -> String {
    match (at.phase, at.largest) {
        (Phase::Transient, _) => "the scene runs".to_owned(),
        (Phase::Settling, _) => "the tangent vectors settle".to_owned(),
        (Phase::Averaging, None) => "averaging".to_owned(),
        (Phase::Averaging, Some(largest)) => {
            let largest = uncertain(largest.value, largest.half_width);
            format!("averaging, the largest is {largest} 1/s")
        }
    }
}

#[cfg(test)]
#[path = "lyapunov_tests.rs"]
mod tests;
