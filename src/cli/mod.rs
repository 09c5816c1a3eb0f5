//! The command line: parse the arguments, run one command, return an exit code.
//!
//! | exit code | meaning |
//! |---|---|
//! | 0 | success |
//! | 1 | failure during the computation or while writing results |
//! | 2 | invalid input: arguments, scene, signal, or an output that cannot be written |
//! | 130 | interrupted by Ctrl-C, SIGTERM or a closed terminal; the results so far are saved. `live` and `view` end so normally, with 0 |
//!
//! Results go to the standard output; progress, warnings and errors go to the standard error. Each command
//! with a result also writes it as JSON with `--json FILE`: the result struct with the version of the
//! program, the scene and the files written.

mod analyse;
mod analyse_args;
mod analyse_files;
mod args;
mod audit;
mod basins;
mod branch;
mod browser;
mod common_args;
mod console;
mod cost;
mod error;
mod figures;
mod friction;
mod harness;
mod help;
mod interrupt;
mod live;
mod lyapunov;
mod model;
mod output;
mod paper;
mod paper_figures;
mod points;
mod resources;
mod run;
mod scenes;
mod schema;
mod signal;
mod stability;
mod steps;
mod study_args;
mod sweep;
mod view;

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use clap::FromArgMatches;

use crate::escape;
use crate::pipeline::panic_message;
use crate::study::paper::paper_plan;

use args::{Args, Command, RunArgs};

pub use error::CliError;

/// The arguments, of which the first is the name or path of the program. Those of the process differ if another
/// program, such as Python, runs the command line.
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Runs the program with arguments, of which the first is the name of the program, and returns its exit code.
///
/// Results go to the standard output, messages to the standard error. The module source documents the exit
/// codes: 0 success, 1 failure, 2 invalid input, 130 interrupted.
pub fn main(words: Vec<OsString>) -> u8 {
    let _ = WORDS.set(words.clone());
    let args = match parse(words.clone()) {
        Ok(args) => args,
        // `--help` and `--version` also end here, with exit code 0.
        Err(error) => {
            let error = escaped(words, error);
            // As clap itself: a closed output changes nothing.
            let _ = error.print();
            return error.exit_code() as u8;
        }
    };
    match caught(|| dispatch(args)) {
        Ok(()) => 0,
        Err(error) => {
            console::print_error(&error);
            error.exit_code()
        }
    }
}

fn parse(words: Vec<OsString>) -> Result<Args, clap::Error> {
    let matches = help::command().try_get_matches_from(words)?;
    Args::from_arg_matches(&matches)
}

/// Returns the same error for arguments with escaped control characters. Names of files can contain such
/// characters (`analyse *`), and clap repeats them in its message.
fn escaped(words: Vec<OsString>, error: clap::Error) -> clap::Error {
    let words = words.iter().map(|word| word.to_string_lossy());
    let words = words.map(|word| escape::line(&word).into());
    parse(words.collect()).err().unwrap_or(error)
}

/// Runs `work` and turns a panic into an error with an exit code.
fn caught(work: impl FnOnce() -> Result<(), CliError>) -> Result<(), CliError> {
    // The program ends afterwards, so no state that the panic left inconsistent is used again.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        Err(CliError::Failed(format!(
            "squeakscope panicked: {}; please report this bug with the command line",
            panic_message(&*panic)
        )))
    })
}

fn dispatch(args: Args) -> Result<(), CliError> {
    let command = match args.command {
        None => Command::Run(RunArgs::default()),
        Some(command) => command,
    };
    match command {
        Command::Run(args) => interruptible(|stop| run::execute(&args, stop)),
        Command::Live(args) => interruptible(|stop| live::run(&args, stop)),
        Command::View(args) => interruptible(|stop| view::execute(&args, stop)),
        Command::Scenes(args) => scenes::scenes(&args),
        Command::Stability(args) => interruptible(|stop| stability::stability(&args, stop)),
        Command::Lyapunov(args) => interruptible(|stop| lyapunov::execute(&args, stop)),
        Command::Sweep(args) => interruptible(|stop| sweep::execute(&args, stop)),
        Command::Branch(args) => interruptible(|stop| branch::execute(&args, stop)),
        Command::Basins(args) => interruptible(|stop| basins::execute(&args, stop)),
        Command::Paper(args) => interruptible(|stop| paper::execute(&args, stop, paper_plan)),
        Command::Cost(args) => interruptible(|stop| cost::execute(&args, stop)),
        Command::Merge(args) => interruptible(|stop| sweep::merge(&args, stop)),
        Command::Model(args) => model::model(&args),
        Command::Friction(args) => friction::execute(&args),
        Command::Analyse(args) => interruptible(|stop| analyse::execute(&args, stop)),
        Command::Schema(args) => schema::schema(&args),
        Command::Completions(args) => help::completions(&args),
        Command::Man(args) => help::man(&args),
    }
}

/// Runs a command that an interrupt ends in an orderly way.
fn interruptible(
    command: impl FnOnce(&Arc<AtomicBool>) -> Result<(), CliError>,
) -> Result<(), CliError> {
    command(&interrupt::install_handler()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The arguments of a command from its words.
    pub fn parsed<A: clap::Args>(line: &str) -> A {
        let command = A::augment_args(clap::Command::new("test").no_binary_name(true));
        let matches = command.try_get_matches_from(line.split_whitespace());
        A::from_arg_matches(&matches.expect("arguments")).expect("values")
    }

    #[test]
    fn a_panic_becomes_an_error_with_exit_code_1() {
        caught(|| Ok(())).expect("success");
        let fault = caught(|| panic!("index out of bounds")).expect_err("a panic");
        assert_eq!(fault.exit_code(), 1);
        assert!(fault.to_string().contains("index out of bounds"), "{fault}");
    }
}
