//! `squeakscope lyapunov`: Lyapunov exponents with their 95 % intervals, and the attractor.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::atomic::AtomicBool;

use super::args::LyapunovArgs;
use super::console;
use super::error::{Cause, CliError};
use super::figures::PIXELS;
use super::harness::{Outputs, Watch};
use super::output::{Kind, is_stdout, used_twice};
use crate::dynamics::DynamicsError;
use crate::export::replace_file;
use crate::plot::lyapunov_figure;
use crate::scene::Scene;
use crate::study::lyapunov::{Goal, LyapunovRequest, RunningExponents, scene_lyapunov, title};

/// Runs the command.
///
/// # Errors
/// Bad input before any work; failure while running or drawing; an interrupt, after the results are
/// written.
pub(super) fn execute(args: &LyapunovArgs, stop: &AtomicBool) -> Result<(), CliError> {
    let scene = scene(args)?;
    console::print_warnings(&scene.warnings());
    let csv_path = args.csv.as_ref();
    let is_csv_printed = csv_path.is_some_and(|path| is_stdout(path));
    if is_csv_printed && args.output.prints_json() {
        return Err(used_twice("-".as_ref(), "--csv", "--json"));
    }
    let mut files = Outputs::new(args.scene.input(), &args.output)
        .file("--csv", Kind::CSV, csv_path.filter(|_| !is_csv_printed))?
        .figures(&args.figures, PIXELS, ["lyapunov"])?;
    files.prints_report = !is_csv_printed;
    let watch = Watch::new(stop);
    let result = scene_lyapunov(&scene, &request(args), &mut watch.progress());
    let result = result.map_err(|fault| failure(fault.into()))?;
    files.finish(watch, Some(&scene.name), &result, |files| {
        let csv = csv(&result.study.running);
        if is_csv_printed {
            console::print(&csv)?;
        }
        files.write("--csv", |path| {
            replace_file(path, |out| out.write_all(csv.as_bytes()))
        })?;
        let title = title(&scene.name, result.tilt_rad);
        files.draw(|| vec![lyapunov_figure(&title, &result)])
    })
}

fn request(args: &LyapunovArgs) -> LyapunovRequest {
    LyapunovRequest {
        count: args.exponents,
        settle: args.settle.map(|ms| 1e-3 * ms),
        goal: match (args.average_time, args.target_half_width) {
            (Some(time), _) => Goal::Time(time),
            (None, Some(half_width)) => Goal::HalfWidth(half_width),
            (None, None) => Goal::Classification,
        },
        tolerance: args.tolerance,
    }
}

/// The running averages as CSV.
fn csv(running: &[RunningExponents]) -> String {
    let count = running.first().map_or(0, |at| at.exponents.len());
    let mut text = "time_s".to_owned();
    for k in 1..=count {
        let _ = write!(text, ",exponent_{k}_per_s,half_width_{k}_per_s");
    }
    text.push('\n');
    for at in running {
        let _ = write!(text, "{}", at.time);
        for e in &at.exponents {
            let _ = write!(text, ",{},{}", e.value, e.half_width);
        }
        text.push('\n');
    }
    text
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
    let numbers = [
        ("load.tilt_deg", args.tilt),
        ("time.duration_ms", args.duration),
        ("time.tolerance", args.tolerance),
    ];
    let mut scene = args.scene.load_with(args.accuracy, &numbers)?;
    if let Some(seed) = args.seed {
        scene = scene.with_overrides(&[("start.seed", seed.to_string())])?;
    }
    Ok(scene.without_analyses())
}

#[cfg(test)]
#[path = "lyapunov_tests.rs"]
mod tests;
