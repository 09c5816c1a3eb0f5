//! Old names of options: replaced before clap parses the command line, each with a warning.
//!
//! An old name works for one release. Add a row here when you rename an option.

use std::ffi::OsString;

/// Renamed options: command, old name, new name.
const OPTIONS: [[&str; 3]; 16] = [
    ["run", "--slower", "--time-stretch"],
    ["run", "--at", "--probe"],
    ["live", "--at", "--probe"],
    ["live", "--pace", "--speed"],
    ["live", "--no-neighbours", "--no-lyapunov"],
    ["live", "--folder", "--record-dir"],
    ["lyapunov", "--until", "--average-time"],
    ["lyapunov", "--error", "--target-half-width"],
    ["lyapunov", "--png", "--figures"],
    ["sweep", "--over", "--param"],
    ["sweep", "--least", "--min-transient"],
    ["sweep", "--most", "--max-transient"],
    ["basins", "--least", "--min-transient"],
    ["basins", "--most", "--max-transient"],
    ["paper", "--only", "--figure"],
    ["analyse", "--png", "--figures"],
];

/// Renamed values: command, option, old value, new value.
const VALUES: [[&str; 4]; 6] = [
    ["sweep", "--start", "cold", "fresh"],
    ["sweep", "--start", "up", "upward"],
    ["sweep", "--start", "down", "downward"],
    ["paper", "--start", "cold", "fresh"],
    ["paper", "--start", "up", "upward"],
    ["paper", "--start", "down", "downward"],
];

/// Replaces the old names in the arguments `words` (the first word is the program).
///
/// Returns the new arguments and one warning per old name. Both forms are replaced: `--old VALUE` and
/// `--old=VALUE`. An argument that is not UTF-8 stays unchanged.
pub(super) fn replace(words: Vec<OsString>) -> (Vec<OsString>, Vec<String>) {
    let mut warnings = Vec::new();
    let mut warn = |old: &str, new: &str| {
        let warning = format!("`{old}` is deprecated; use `{new}`");
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    };
    let mut command: Option<String> = None;
    let mut previous = String::new();
    let mut only_values = false;
    let mut replaced = Vec::with_capacity(words.len());
    for (k, word) in words.into_iter().enumerate() {
        let Some(text) = word.to_str().filter(|_| k > 0 && !only_values) else {
            replaced.push(word);
            continue;
        };
        let Some(command) = &command else {
            if !text.starts_with('-') {
                command = Some(text.to_owned());
            }
            replaced.push(word);
            continue;
        };
        only_values = text == "--";
        let (option, value) = match text.split_once('=') {
            Some((option, value)) if option.starts_with("--") => (option, Some(value)),
            _ => (text, None),
        };
        let renamed = OPTIONS
            .iter()
            .find(|[of, old, _]| of == command && *old == option);
        let option = match renamed {
            Some([_, old, new]) => {
                warn(old, new);
                *new
            }
            None => option,
        };
        let new_value = |option: &str, value: &str| {
            let mut values = VALUES.iter();
            let found =
                values.find(|[of, name, old, _]| of == command && *name == option && *old == value);
            found.map(|[.., new]| *new)
        };
        let text = match value {
            Some(value) => match new_value(option, value) {
                Some(new) => {
                    warn(&format!("{option}={value}"), &format!("{option}={new}"));
                    format!("{option}={new}")
                }
                None => format!("{option}={value}"),
            },
            None => match new_value(&previous, option) {
                Some(new) => {
                    warn(
                        &format!("{previous} {option}"),
                        &format!("{previous} {new}"),
                    );
                    new.to_owned()
                }
                None => option.to_owned(),
            },
        };
        previous.clone_from(&text);
        replaced.push(text.into());
    }
    (replaced, warnings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::help;

    fn replaced(line: &str) -> (String, Vec<String>) {
        let (words, warnings) = replace(line.split(' ').map(OsString::from).collect());
        let words: Vec<_> = words.iter().map(|word| word.to_str().unwrap()).collect();
        (words.join(" "), warnings)
    }

    #[test]
    fn old_names_are_replaced_in_both_forms_with_one_warning_each() {
        let (line, warnings) =
            replaced("squeakscope sweep --over load_n=1:2:1 --over=nodes=1:2:1 --most=9");
        assert_eq!(
            line,
            "squeakscope sweep --param load_n=1:2:1 --param=nodes=1:2:1 --max-transient=9"
        );
        assert_eq!(
            warnings,
            [
                "`--over` is deprecated; use `--param`",
                "`--most` is deprecated; use `--max-transient`"
            ]
        );
    }

    #[test]
    fn old_values_are_replaced_in_both_forms() {
        for (old, new) in [
            ("--start cold", "--start fresh"),
            ("--start=up", "--start=upward"),
        ] {
            let (line, warnings) = replaced(&format!("squeakscope sweep {old}"));
            assert_eq!(line, format!("squeakscope sweep {new}"));
            assert_eq!(warnings, [format!("`{old}` is deprecated; use `{new}`")]);
        }
    }

    #[test]
    fn other_arguments_stay() {
        for line in [
            "squeakscope",
            "squeakscope run --until 1",
            "squeakscope merge -- --most",
            "squeakscope sweep up --start both --out cold",
            "squeakscope sweep -- --over",
        ] {
            assert_eq!(replaced(line), (line.to_owned(), Vec::new()));
        }
    }

    #[test]
    fn clap_knows_the_new_names_and_not_the_old_ones() {
        let root = help::command();
        let find = |command: &str, option: &str| {
            let command = root.find_subcommand(command).expect(command);
            let mut options = command.get_arguments();
            options
                .find(|known| known.get_long() == option.strip_prefix("--"))
                .cloned()
        };
        for [command, old, new] in OPTIONS {
            assert!(find(command, new).is_some(), "{command} {new}");
            assert!(find(command, old).is_none(), "{command} {old}");
        }
        for [command, option, old, new] in VALUES {
            let values = find(command, option).expect(option).get_possible_values();
            let known = |name: &str| values.iter().any(|value| value.matches(name, false));
            assert!(known(new) && !known(old), "{command} {option} {old}");
        }
    }
}
