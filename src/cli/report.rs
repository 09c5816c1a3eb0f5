//! What the commands print: results, warnings and errors.

use std::fmt::Write as _;
use std::io::{self, Write as _};

use super::error::CliError;
use super::output::OutputError;
use crate::escape;
use crate::scene::{Held, SceneWarning};
use anstyle::{AnsiColor, Style};

/// The style of what is wrong, or grows.
pub(super) const BAD: Style = AnsiColor::Red.on_default().bold();
/// The style of what calls for care.
pub(super) const DOUBTFUL: Style = AnsiColor::Yellow.on_default().bold();
/// The style of a name that stands at the head of a text.
pub(super) const NAME: Style = Style::new().bold();

/// From radians back to the decimal of degrees that was written.
pub(super) fn degrees(radians: f64) -> f64 {
    (radians.to_degrees() * 1e9).round() / 1e9
}

/// Prints to the standard output, in colour where that is a terminal.
///
/// # Errors
/// When it cannot be written. A reader that has seen enough (`| head`) is no error.
pub fn print(text: &str) -> Result<(), OutputError> {
    let mut out = anstream::stdout().lock();
    match out
        .write_all(escape::terminal(text).as_bytes())
        .and_then(|()| out.flush())
    {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(OutputError::Terminal(source))
        }
        _ => Ok(()),
    }
}

/// Prints warnings to the standard error.
pub fn print_warnings(warnings: &[SceneWarning]) {
    for warning in warnings {
        print_warning(&warning.to_string());
    }
}

/// Prints a warning to the standard error.
pub fn print_warning(warning: &str) {
    tell(&format!("{DOUBTFUL}warning:{DOUBTFUL:#}"), warning);
}

/// Says on the standard error what is held where, though it varies in the scene.
pub fn print_held(held: Held) {
    if let Some(words) = held.words() {
        print_warning(&format!(
            "the scene changes with time; here it is held at its first values: {words}"
        ));
    }
}

/// Prints an error and what caused it to the standard error, on one line.
pub fn print_error(error: &CliError) {
    let mut message = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        let _ = write!(message, ": {error}");
        cause = error.source();
    }
    tell(&format!("{BAD}error:{BAD:#}"), &message);
}

/// Prints a message to the standard error, on one line whatever is in it. That nobody reads it, as when it goes
/// into a file on a full disk, changes nothing.
fn tell(head: &str, message: &str) {
    let _ = writeln!(anstream::stderr(), "{head} {}", escape::line(message));
}
