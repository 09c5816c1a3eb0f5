//! The help is complete, its examples are valid, and the guide has a current copy.

use std::collections::BTreeMap;
use std::path::Path;

use clap::FromArgMatches;

use super::*;

/// Columns of the help in the guide.
const COLUMNS: usize = 100;

fn entries() -> impl Iterator<Item = Entry> {
    tasks().into_iter().flat_map(|task| task.commands)
}

/// The command of the parser and its subcommands, with full names.
fn built() -> clap::Command {
    let mut command = command()
        .disable_help_subcommand(true)
        .term_width(COLUMNS)
        .mut_subcommands(|command| command.term_width(COLUMNS));
    command.build();
    command
}

#[test]
fn arguments_are_consistent() {
    command().debug_assert();
}

#[test]
fn every_command_is_in_one_group() {
    let mut count: BTreeMap<String, usize> = BTreeMap::new();
    for entry in entries() {
        *count.entry(entry.name.to_owned()).or_default() += 1;
    }
    let mut expected = BTreeMap::new();
    for command in Args::command().get_subcommands() {
        expected.insert(command.get_name().to_owned(), 1);
    }
    assert_eq!(count, expected);
}

#[test]
fn every_example_parses() {
    let own = entries().map(|entry| {
        let count = entry.examples.len();
        assert!((2..=3).contains(&count), "{}", entry.name);
        (Some(entry.name), entry.examples)
    });
    let all = own.chain([(None, FIRST_STEPS.to_vec())]);
    for (name, examples) in all {
        for [_, line] in examples {
            // The shell handles the redirection.
            let line = line.split(" > ").next().unwrap_or(line);
            let matches = command().try_get_matches_from(line.split(' '));
            let matches = matches.unwrap_or_else(|error| panic!("{line}: {error}"));
            Args::from_arg_matches(&matches).unwrap_or_else(|error| panic!("{line}: {error}"));
            if name.is_some() {
                assert_eq!(matches.subcommand_name(), name, "{line}");
            }
        }
    }
}

#[test]
fn every_option_has_help() {
    for command in built().get_subcommands() {
        for argument in command.get_arguments() {
            assert!(
                argument.get_help().is_some(),
                "{} {}",
                command.get_name(),
                argument.get_id()
            );
        }
    }
}

#[test]
fn the_main_help_fits_the_terminal() {
    let help = built().render_help().to_string();
    for line in help.lines() {
        assert!(line.chars().count() <= COLUMNS, "{line}");
    }
    for task in tasks() {
        assert!(help.contains(&format!("\n{}:\n", task.title)), "{help}");
    }
}

/// The page of the guide with the help of all commands.
fn page() -> String {
    let mut page = "# Commands\n\n\
        The help of `squeakscope` and of each command, as `--help` prints it. This page is generated from the\n\
        program: `UPDATE_GUIDE=1 cargo test --release --lib cli::help` writes it.\n"
        .to_owned();
    let mut root = built();
    let mut block = |title: &str, help: String| {
        let lines: Vec<&str> = help.trim_end().lines().map(str::trim_end).collect();
        let _ = write!(page, "\n## {title}\n\n```text\n{}\n```\n", lines.join("\n"));
    };
    block("squeakscope", root.render_long_help().to_string());
    for entry in entries() {
        let command = root.find_subcommand_mut(entry.name).expect(entry.name);
        let help = command.render_long_help().to_string();
        block(&format!("squeakscope {}", entry.name), help);
    }
    page
}

#[test]
fn the_guide_has_the_current_help() {
    let page = page();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/guide/reference/commands.md");
    if std::env::var_os("UPDATE_GUIDE").is_some() {
        std::fs::write(&file, &page).unwrap();
    }
    let current = std::fs::read_to_string(&file).unwrap_or_default();
    let mut lines = page.lines().zip(current.lines());
    let differs = lines.find(|(new, old)| new != old);
    assert!(
        page == current,
        "src/guide/reference/commands.md is not current; UPDATE_GUIDE=1 writes it: {differs:?}"
    );
}
