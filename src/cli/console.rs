//! Printing of results, warnings and errors.

use std::io::{self, Write as _};
use std::path::Path;

use super::error::CliError;
use super::harness::OutputArgs;
use crate::chain_of_causes;
use crate::escape;
use crate::record::RERUN_VERSION;
use crate::report::{BAD, WARNING};
use crate::scene::{LoadedJoint, Parameter, Scene};

/// Prints to the standard output, in colour if that is a terminal.
///
/// # Errors
/// If the standard output cannot be written. A closed pipe (`| head`) is not an error.
pub fn print(text: &str) -> Result<(), CliError> {
    let mut out = anstream::stdout().lock();
    match out
        .write_all(escape::terminal(text).as_bytes())
        .and_then(|()| out.flush())
    {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::Terminal(source))
        }
        _ => Ok(()),
    }
}

/// Prints the warnings of a scene to the standard error.
pub fn print_warnings(warnings: &[String]) {
    for warning in warnings {
        print_warning(warning);
    }
}

/// Prints the warnings of the scene of a study, which does not run the analyses of the scene.
pub fn print_study_warnings(scene: &Scene) {
    print_warnings(&scene.clone().without_analyses().warnings());
}

/// Prints a notice to the standard error.
pub fn print_notice(notice: &str) {
    print_message("note:", notice);
}

/// Prints a warning to the standard error.
pub fn print_warning(warning: &str) {
    print_message(&format!("{WARNING}warning:{WARNING:#}"), warning);
}

/// Warns about quantities that vary with time in the scene, but are constant in this command; not about a tilt
/// that the command varies.
pub fn print_fixed(scene: &Scene, varied: impl IntoIterator<Item = Parameter>) {
    let fixed = scene.joint().map(LoadedJoint::fixed_at_start);
    let mut fixed = fixed.unwrap_or_default();
    if varied.into_iter().any(|key| key == Parameter::tilt()) {
        fixed.tilt_rad = None;
    }
    if let Some(values) = fixed.description() {
        print_warning(&format!(
            "the scene changes with time; this command uses its initial values: {values}"
        ));
    }
}

/// Prints an error with its causes to the standard error, on one line.
pub fn print_error(error: &CliError) {
    print_message(&format!("{BAD}error:{BAD:#}"), &chain_of_causes(error));
}

/// Prints a message to the standard error on one line. A failure to print it, such as on a full disk, is
/// ignored.
fn print_message(label: &str, message: &str) {
    let _ = writeln!(anstream::stderr(), "{label} {}", escape::line(message));
}

/// The command line that started the program.
pub fn command_line() -> String {
    let name = std::iter::once("squeakscope".to_owned());
    let words = super::WORDS.get().into_iter().flatten().skip(1);
    let words = words.map(|word| word.to_string_lossy().into_owned());
    name.chain(words).collect::<Vec<_>>().join(" ")
}

/// Prints the commands that open a recording, in the browser and in the native viewer, unless JSON is printed.
pub fn print_viewer_command(recording: &Path, output: &OutputArgs) -> Result<(), CliError> {
    if output.prints_json() {
        return Ok(());
    }
    let path = shell_word(recording);
    let native = format!("pip install rerun-sdk=={RERUN_VERSION}; rerun {path}");
    let text = format!("\nopen with: squeakscope view {path}  (native viewer: {native})\n");
    print(&text)
}

/// A path as one word of a shell command.
fn shell_word(path: &Path) -> String {
    let path = escape::path(path);
    if path.contains(char::is_whitespace) {
        format!("\"{path}\"")
    } else {
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_with_a_blank_is_quoted() {
        assert_eq!(shell_word(Path::new("a b.rrd")), "\"a b.rrd\"");
    }
}
