//! `squeakscope lyapunov`: Lyapunov exponents with their 95 % intervals, and the attractor.

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
use super::lyapunov_text::{LyapunovResult, csv, text, title};
use super::output::{Kind, OutputError, OutputFile, check_apart, is_stdout};
use super::progress::Progress;
use super::report;
use crate::dynamics::DynamicsError;
use crate::number::uncertain;
use crate::plot::{Format, lyapunov_figure};
use crate::scene::Scene;
use crate::study::lyapunov::{
    Ending, ExponentCount, Goal, LyapunovProgress, LyapunovRequest, Phase, SceneLyapunov,
    scene_lyapunov,
};

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or drawing; an interrupt, after the results are
/// written.
pub(super) fn execute(args: &LyapunovArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = scene(args)?;
    report::print_warnings(&scene.warnings());
    let outputs = Outputs::check(args)?;
    let request = request(args);
    let progress = Progress::with_estimate();
    let found = scene_lyapunov(&scene, &request, &mut |at| {
        progress.update(at.share, progress_message(&at));
        // Nothing to save during the transient: an interrupt may end the program at once.
        at.phase == Phase::Transient && !stop.load(Ordering::Relaxed)
            || interrupt::should_continue(stop)
    });
    // Clears the bar before the report is printed.
    drop(progress);
    let found = found.map_err(|fault| failure(fault.into()))?;

    let mut files = Vec::new();
    // The report is printed even if a file cannot be written.
    let written = outputs.write(&scene.name, &found, &args.drawn, &mut files);
    let result = LyapunovResult::new(request.goal, &found);
    let document = Document::new(&result, &files).with_scene(&scene.name);
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
        Ending::Reached | Ending::MaxTimeReached => Ok(()),
    }
}

fn request(args: &LyapunovArgs) -> LyapunovRequest {
    LyapunovRequest {
        count: args.exponents.unwrap_or(ExponentCount::All),
        settle: args.settle.map(|ms| 1e-3 * ms),
        goal: match (args.average_time, args.target_half_width) {
            (Some(time), _) => Goal::Time(time),
            (None, Some(half_width)) => Goal::HalfWidth(half_width),
            (None, None) => Goal::Classification,
        },
        tolerance: args.tolerance,
    }
}

/// Whether a result is printed instead of the table.
fn is_printed(path: &Option<PathBuf>) -> bool {
    path.as_deref().is_some_and(is_stdout)
}

/// The output files.
struct Outputs {
    json: Option<OutputFile>,
    csv: Option<OutputFile>,
    /// The figure, if `--figures` is a file; its extension selects the format.
    picture: Option<(OutputFile, Format)>,
    /// The directory of the figure, if `--figures` is a directory.
    directory: Option<PathBuf>,
}

impl Outputs {
    fn check(args: &LyapunovArgs) -> Result<Self, CliError> {
        let file = |path: &'_ Option<PathBuf>| path.clone().filter(|_| !is_printed(path));
        if is_printed(&args.json) && is_printed(&args.csv) {
            return Err(OutputError::twice(Path::new("-"), "--csv", "--json").into());
        }
        let path = args.figures.as_deref();
        // A path without the extension of a format is a directory.
        let one = path.and_then(|path| Some((path, Format::of(path)?)));
        let one = one.filter(|(path, _)| !path.is_dir());
        let directory = path.filter(|_| one.is_none());
        let [json, csv, picture] = args.overwrite.check_all(
            args.scene.input(),
            [
                ("--json", Kind::JSON, file(&args.json).as_deref()),
                ("--csv", Kind::CSV, file(&args.csv).as_deref()),
                ("--figures", Kind::FIGURE, one.map(|(path, _)| path)),
            ],
        )?;
        if let Some(directory) = directory {
            let names = args.drawn.names(["lyapunov"], &PIXELS);
            let others = [("--json", json.as_ref()), ("--csv", csv.as_ref())];
            args.overwrite
                .check_directory(directory, "--figures", &names)?;
            check_apart(directory, "--figures", &others)?;
        }
        Ok(Self {
            json,
            csv,
            picture: picture.zip(one.map(|(_, format)| format)),
            directory: directory.map(Path::to_owned),
        })
    }

    /// Writes the running averages and the figure, and adds them to `files`.
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
            drawn.check(&[figure()])?;
            files.push(write_figure(file, &figure(), drawn, *format)?);
        }
        if let Some(directory) = &self.directory {
            let drawn = (drawn, &PIXELS[..]);
            files.extend(write_figures(directory, "--figures", &[figure()], drawn)?);
        }
        Ok(())
    }
}

/// The error of a study; too many exponents are bad input.
fn failure(source: Cause) -> CliError {
    too_many(source.as_ref()).unwrap_or_else(|| CliError::during("averaging of exponents")(source))
}

/// Finds a request for too many exponents among the causes of a failure.
fn too_many(cause: &(dyn Error + 'static)) -> Option<CliError> {
    match cause.downcast_ref() {
        Some(DynamicsError::TangentCount { asked, dimension }) => Some(CliError::Input(format!(
            "--exponents {asked}: the system has {dimension} exponents; give 1 to {dimension}, or `all`"
        ))),
        _ => cause.source().and_then(too_many),
    }
}

/// The scene with the changes of the command line.
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

/// The message of the progress bar.
fn progress_message(at: &LyapunovProgress) -> String {
    match (at.phase, at.largest) {
        (Phase::Transient, _) => "running the scene".to_owned(),
        (Phase::Settling, _) => "aligning the tangent vectors".to_owned(),
        (Phase::Averaging, None) => "averaging".to_owned(),
        (Phase::Averaging, Some(largest)) => {
            let largest = uncertain(largest.value, largest.half_width);
            format!("averaging, largest exponent {largest} 1/s")
        }
    }
}

#[cfg(test)]
#[path = "lyapunov_tests.rs"]
mod tests;
