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

/// Commands for one kind of task.
struct Task {
    title: &'static str,
    commands: Vec<Entry>,
}

/// A command with two or three examples: what each does, and its command line.
struct Entry {
    name: &'static str,
    examples: Vec<[&'static str; 2]>,
}

/// The commands by task: `# TASK`, `## COMMAND`, and examples, each a purpose and an indented command line.
const HELP: &str = include_str!("../../assets/help.md");

/// Every command of [`super::args::Command`] occurs once; a test checks it.
fn tasks() -> Vec<Task> {
    let mut tasks: Vec<Task> = Vec::new();
    let mut purpose = "";
    for line in HELP.lines().filter(|line| !line.is_empty()) {
        let task = tasks.last_mut();
        if let Some(title) = line.strip_prefix("# ") {
            let commands = Vec::new();
            tasks.push(Task { title, commands });
        } else if let (Some(task), Some(name)) = (task, line.strip_prefix("## ")) {
            let examples = Vec::new();
            task.commands.push(Entry { name, examples });
        } else if let Some(example) = line.strip_prefix("    ") {
            let entry = tasks.last_mut().and_then(|task| task.commands.last_mut());
            if let Some(entry) = entry {
                entry.examples.push([purpose, example]);
            }
        } else {
            purpose = line.trim_end_matches(':');
        }
    }
    tasks
}

/// Examples at the end of the main help.
const FIRST_STEPS: [[&str; 2]; 3] = [
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
    let examples = |examples: &[[&str; 2]]| {
        let mut text = format!("{header}Examples:{header:#}");
        for [purpose, line] in examples {
            let _ = write!(text, "\n  {purpose}:\n    {literal}{line}{literal:#}");
        }
        text
    };
    let mut groups = String::new();
    for Task { title, commands } in tasks() {
        let _ = writeln!(groups, "{header}{title}:{header:#}");
        for Entry {
            name,
            examples: own,
        } in commands
        {
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
