//! The command line: arguments in, one command run, one exit code out.
//!
//! | exit code | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | a fault while running |
//! | 2 | bad input: arguments, a scene, a signal, an output that cannot be written |
//! | 130 | interrupted by Ctrl-C, SIGTERM or a closed terminal; what was reached until then is kept |
//!
//! Results go to the standard output, everything else (progress, warnings, errors) to the
//! standard error. Each command that prints a result writes it with `--json FILE` too: the struct
//! beside the computation, with version, scene and files.

mod analyse;
mod args;
mod audit;
mod basins;
mod calibrate;
mod common_args;
mod cost;
mod document;
mod effects;
mod error;
mod exponents;
mod figures;
mod growth;
mod interrupt;
mod live;
mod live_args;
mod lyapunov;
mod lyapunov_text;
mod model;
mod output;
mod paper;
mod paper_figures;
mod plain;
mod progress;
mod report;
mod resources;
mod run;
mod scenes;
mod signal_text;
mod sound_args;
mod stability;
mod steps;
mod study_args;
mod sweep;
mod terminal;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use clap::Parser;

use crate::escape;
use crate::pipeline::panic_message;

use args::{Args, Command, RunArgs};

pub use error::CliError;

/// Runs the program: arguments from the environment, messages to the standard error.
pub fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        // Help and version come this way too, with exit code 0.
        Err(error) => safe(error).exit(),
    };
    match caught(|| dispatch(args)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report::print_error(&error);
            ExitCode::from(error.exit_code())
        }
    }
}

/// An error of arguments that can be printed: the same of arguments without hidden characters, which may come from
/// the names of files (`analyse *`).
fn safe(error: clap::Error) -> clap::Error {
    let words = std::env::args_os().map(|word| escape::line(&word.to_string_lossy()).into_owned());
    Args::try_parse_from(words).err().unwrap_or(error)
}

/// Does some work; a panic is an error like any other, with its exit code.
fn caught(work: impl FnOnce() -> Result<(), CliError>) -> Result<(), CliError> {
    // The program ends after it: nothing is used again that it may have left half done.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        Err(CliError::Panic {
            message: panic_message(&*panic),
        })
    })
}

fn dispatch(args: Args) -> Result<(), CliError> {
    match args.command {
        None => run::run(&RunArgs::default()),
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Live(args)) => live::run(&args),
        Some(Command::Scenes(args)) => scenes::scenes(&args),
        Some(Command::Stability(args)) => stability::stability(&args),
        Some(Command::Lyapunov(args)) => lyapunov::lyapunov(&args),
        Some(Command::Sweep(args)) => sweep::run(&args),
        Some(Command::Basins(args)) => basins::basins(&args),
        Some(Command::Paper(args)) => paper::run(&args),
        Some(Command::Calibrate(args)) => calibrate::run(&args),
        Some(Command::Cost(args)) => cost::run(&args),
        Some(Command::Growth(args)) => growth::run(&args),
        Some(Command::Merge(args)) => sweep::merge(&args),
        Some(Command::Model(args)) => model::model(&args),
        Some(Command::Analyse(args)) => analyse::analyse(&args),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_exit_code() {
        caught(|| Ok(())).expect("done");
        let fault = caught(|| panic!("lost the ball")).expect_err("a panic");
        assert_eq!(fault.exit_code(), 1);
        assert!(fault.to_string().contains("lost the ball"), "{fault}");
    }
}
