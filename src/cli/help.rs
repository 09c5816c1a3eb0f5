//! The help: commands grouped by task, with examples at the end of each command's help; the same as pages of `man`, and
//! completions for shells.

use std::fmt::Write as _;
use std::fs;

use clap::{Arg, CommandFactory};

use super::args::{Args, CompletionsArgs, ManArgs};
use super::console;
use super::error::CliError;
use super::output::check_directory;
use crate::export;

/// The commands by task: `# TASK`, `## COMMAND`, and two or three examples, each a purpose and an indented command line.
const HELP: &str = include_str!("../../assets/help.md");

/// What an example does, and its command line.
type Example = [&'static str; 2];

/// A command with its examples.
type CommandExamples = (&'static str, Vec<Example>);

/// The tasks with their commands, each with its examples. Every command of [`super::args::Command`] occurs once; a test
/// checks it.
fn tasks() -> Vec<(&'static str, Vec<CommandExamples>)> {
    let command = |text: &'static str| {
        let mut lines = text.lines().filter(|line| !line.is_empty());
        let name = lines.next().unwrap_or_default();
        let mut examples: Vec<Example> = Vec::new();
        while let (Some(purpose), Some(line)) = (lines.next(), lines.next()) {
            examples.push([purpose.trim_end_matches(':'), line.trim_start()]);
        }
        (name, examples)
    };
    let task = |text: &'static str| {
        let mut parts = text.split("\n## ");
        let title = parts.next().unwrap_or_default().trim_end();
        (title, parts.map(command).collect())
    };
    let tasks = HELP.trim_start_matches("# ").split("\n# ");
    tasks.map(task).collect()
}

/// Examples at the end of the main help.
const FIRST_STEPS: [Example; 3] = [
    [
        "Simulate the default scene; `squeakscope view squeak.rrd` opens the recording",
        "squeakscope",
    ],
    ["Change the tilt while it squeaks", "squeakscope live"],
    [
        "Analyse your own recording",
        "squeakscope analyse squeak.wav",
    ],
];

/// The parser of the command line, with the grouped help and the examples.
pub(super) fn command() -> clap::Command {
    // A negative number is a value, not an option.
    let negative = |arg: Arg| {
        if arg.is_positional() || !arg.get_action().takes_values() {
            arg
        } else {
            arg.allow_negative_numbers(true)
        }
    };
    let mut command = Args::command().mut_subcommands(|command| command.mut_args(negative));
    let header = *command.get_styles().get_header();
    let literal = *command.get_styles().get_literal();
    let examples = |examples: &[Example]| {
        let mut text = format!("{header}Examples:{header:#}");
        for [purpose, line] in examples {
            let _ = write!(text, "\n  {purpose}:\n    {literal}{line}{literal:#}");
        }
        text
    };
    let mut groups = String::new();
    for (title, commands) in tasks() {
        let _ = writeln!(groups, "{header}{title}:{header:#}");
        for (name, own) in commands {
            let about = command
                .find_subcommand(name)
                .and_then(clap::Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(groups, "  {literal}{name:<11}{literal:#}  {about}");
            command = command.mut_subcommand(name, |command| command.after_help(examples(&own)));
        }
        groups.push('\n');
    }
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}{header}Options:{header:#}\n\
         {{options}}{{after-help}}"
    );
    let more = format!(
        "`{literal}squeakscope COMMAND --help{literal:#}` prints the options of a command.\n\n{}",
        examples(&FIRST_STEPS)
    );
    command.help_template(template).after_help(more)
}

/// Prints the completion script of a shell.
///
/// # Errors
/// If the standard output cannot be written.
pub(super) fn completions(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "squeakscope", &mut script);
    console::print(&String::from_utf8_lossy(&script))
}

/// Writes `squeakscope.1`, and `squeakscope-COMMAND.1` for each command.
///
/// # Errors
/// Bad input if the directory cannot be created; failure if a page cannot be written.
pub(super) fn man(args: &ManArgs) -> Result<(), CliError> {
    let directory = &args.directory;
    let command = command();
    let pages = command.get_subcommands();
    let pages = pages.map(|command| format!("squeakscope-{}.1", command.get_name()));
    let pages: Vec<String> = pages.chain(["squeakscope.1".to_owned()]).collect();
    check_directory(directory, "DIR", &pages, args.overwrite.force)?;
    fs::create_dir_all(directory)
        .and_then(|()| clap_mangen::generate_to(command, directory))
        .map_err(|source| {
            let path = directory.clone();
            export::OutputError { path, source }.into()
        })
}

#[cfg(test)]
#[path = "help_tests.rs"]
mod tests;
