//! The program `squeakscope`; [`squeakscope::main`] parses the arguments and returns the exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(squeakscope::main(std::env::args_os().collect()))
}
