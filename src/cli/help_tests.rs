//! The help is complete and its examples are valid.

use std::collections::BTreeMap;

use clap::FromArgMatches;

use super::*;

/// Columns of the terminal.
const COLUMNS: usize = 100;

fn entries() -> impl Iterator<Item = CommandExamples> {
    tasks().into_iter().flat_map(|(_, commands)| commands)
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
    for (name, _) in entries() {
        *count.entry(name.to_owned()).or_default() += 1;
    }
    let mut expected = BTreeMap::new();
    for command in Args::command().get_subcommands() {
        expected.insert(command.get_name().to_owned(), 1);
    }
    assert_eq!(count, expected);
}

#[test]
fn every_example_parses() {
    let own = entries().map(|(name, examples)| {
        assert!((2..=3).contains(&examples.len()), "{name}");
        (Some(name), examples)
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
    for (title, _) in tasks() {
        assert!(help.contains(&format!("\n{title}:\n")), "{help}");
    }
}

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
    for command in command().get_subcommands() {
        let text = page(&format!("squeakscope-{}.1", command.get_name()));
        assert!(text.contains("Examples"), "{text}");
    }
}
