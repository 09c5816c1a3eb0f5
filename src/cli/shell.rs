//! `squeakscope completions` and `squeakscope man`.

use std::fs;

use super::args::{CompletionsArgs, ManArgs};
use super::error::CliError;
use super::help;
use super::output::OutputError;
use super::report;

/// Prints the completion script of a shell.
///
/// # Errors
/// If the standard output cannot be written.
pub(super) fn completions(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut help::command(), "squeakscope", &mut script);
    Ok(report::print(&String::from_utf8_lossy(&script))?)
}

/// Writes `squeakscope.1`, and `squeakscope-COMMAND.1` for each command.
///
/// # Errors
/// Bad input if the directory cannot be created; failure if a page cannot be written.
pub(super) fn man(args: &ManArgs) -> Result<(), CliError> {
    let directory = &args.directory;
    let command = help::command();
    let pages = command.get_subcommands();
    let pages = pages.map(|command| format!("squeakscope-{}.1", command.get_name()));
    let pages: Vec<String> = pages.chain(["squeakscope.1".to_owned()]).collect();
    args.overwrite.check_directory(directory, "DIR", &pages)?;
    fs::create_dir_all(directory)
        .and_then(|()| clap_mangen::generate_to(command, directory))
        .map_err(|source| OutputError::Failed {
            path: directory.clone(),
            source,
        })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_man_page() {
        let folder = tempfile::tempdir().unwrap();
        let directory = folder.path().join("man1");
        man(&ManArgs {
            directory: directory.clone(),
            overwrite: Default::default(),
        })
        .unwrap();
        let page = |name: &str| fs::read_to_string(directory.join(name)).unwrap();
        assert!(page("squeakscope.1").contains(".TH squeakscope 1"));
        for command in help::command().get_subcommands() {
            let text = page(&format!("squeakscope-{}.1", command.get_name()));
            assert!(text.contains("Examples"), "{text}");
        }
    }
}
