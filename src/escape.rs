//! Text from files that others made, as it is shown.
//!
//! The name of an array, the title of a scene or the path of a file may hold anything: a sequence that clears
//! the terminal, a newline that fakes a message, a control character that reverses the rest of the line.
//! Terminals, pages, recordings and figures show such characters escaped, as TOML and JSON write them (`\n`,
//! `\u001b`). JSON files and tables are for programs and keep the text as it is.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Whether a character is not shown itself, but changes how other text is shown.
pub(crate) fn is_hidden(c: char) -> bool {
    c.is_control()
        // Line and paragraph separators; marks, embeddings, overrides and isolates of a direction.
        || matches!(c, '\u{2028}' | '\u{2029}' | '\u{61c}' | '\u{200e}' | '\u{200f}')
        || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A name on one line: every hidden character is escaped.
pub(crate) fn line(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(2 * text.len());
    for c in text.chars() {
        match c {
            '\n' => shown.push_str("\\n"),
            '\r' => shown.push_str("\\r"),
            '\t' => shown.push_str("\\t"),
            c if is_hidden(c) => {
                // All of them have four digits. Writing to a string cannot fail.
                let _ = write!(shown, "\\u{:04x}", u32::from(c));
            }
            c => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

/// A text of several lines: as [`line`], but line breaks and tabs stay.
pub(crate) fn lines(text: &str) -> Cow<'_, str> {
    let stays = |c| matches!(c, '\n' | '\t');
    if !text.contains(|c| is_hidden(c) && !stays(c)) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(2 * text.len());
    // Windows ends its lines with two characters.
    for piece in text.replace("\r\n", "\n").split_inclusive(stays) {
        let body = piece.trim_end_matches(stays);
        shown.push_str(&line(body));
        shown.push_str(&piece[body.len()..]);
    }
    Cow::Owned(shown)
}

/// A path on one line.
#[cfg(feature = "cli")]
pub(crate) fn path(path: &std::path::Path) -> String {
    line(&path.to_string_lossy()).into_owned()
}

/// A text of our own with names in it, each of them escaped: as [`lines`], but colours stay.
#[cfg(feature = "cli")]
pub(crate) fn terminal(text: &str) -> String {
    let mut pieces = text.split('\u{1b}');
    let mut shown = lines(pieces.next().unwrap_or_default()).into_owned();
    for piece in pieces {
        let codes = piece
            .strip_prefix('[')
            .and_then(|rest| rest.split_once('m'));
        let is_code = |c: char| c.is_ascii_digit() || c == ';';
        let rest = match codes.filter(|(codes, _)| codes.chars().all(is_code)) {
            Some((codes, rest)) => {
                shown.extend(["\u{1b}[", codes, "m"]);
                rest
            }
            None => {
                shown.push_str("\\u001b");
                piece
            }
        };
        shown.push_str(&lines(rest));
    }
    shown
}

/// A name as Markdown: on one line, and without any meaning there.
pub(crate) fn markdown(name: &str) -> String {
    let mut shown = String::with_capacity(name.len());
    for c in line(name).chars() {
        if "\\`*_[]<>|~&!#".contains(c) {
            shown.push('\\');
        }
        shown.push(c);
    }
    shown
}

/// A name as code within a line of Markdown.
#[cfg(feature = "record")]
pub(crate) fn code(name: &str) -> String {
    let name = line(name);
    let ticks = fence(&name, 1);
    match name.starts_with('`') || name.ends_with('`') {
        true => format!("{ticks} {name} {ticks}"),
        false => format!("{ticks}{name}{ticks}"),
    }
}

/// A text as a block of code in Markdown.
#[cfg(feature = "record")]
pub(crate) fn block(language: &str, text: &str) -> String {
    let text = lines(text.trim_end());
    let ticks = fence(&text, 3);
    format!("{ticks}{language}\n{text}\n{ticks}")
}

/// More backticks in a row than the text has anywhere, and at least so many.
#[cfg(feature = "record")]
fn fence(text: &str, least: usize) -> String {
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    "`".repeat(least.max(longest + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_are_shown() {
        assert!(matches!(line("Größe, µm ⟂ 球"), Cow::Borrowed(_)));
        assert_eq!(line("a\n\u{1b}[31mb\r\t"), "a\\n\\u001b[31mb\\r\\t");
        for hidden in ('\u{0}'..='\u{1f}').chain('\u{7f}'..='\u{9f}') {
            assert!(!line(&hidden.to_string()).contains(hidden));
        }
        for hidden in ('\u{202a}'..='\u{202e}').chain('\u{2066}'..='\u{2069}') {
            assert_eq!(
                line(&format!("a{hidden}b")),
                format!("a\\u{:04x}b", u32::from(hidden))
            );
        }
        assert_eq!(lines("a\tb\r\nc\u{9b}d\re\n\n"), "a\tb\nc\\u009bd\\re\n\n");
        assert!(matches!(lines("a\tb\nc"), Cow::Borrowed(_)));
    }

    #[cfg(feature = "cli")]
    #[test]
    fn only_colours_reach_a_terminal() {
        let text = "\u{1b}[1;31mred\u{1b}[0m\n\u{1b}[2J\u{1b}]0;title\u{7}\u{1b}";
        let shown = "\u{1b}[1;31mred\u{1b}[0m\n\\u001b[2J\\u001b]0;title\\u0007\\u001b";
        assert_eq!(terminal(text), shown);
    }

    #[cfg(feature = "record")]
    #[test]
    fn a_name_means_nothing_in_markdown() {
        assert_eq!(markdown("a\n# b ![x](y)"), "a\\\\n\\# b \\!\\[x\\](y)");
        assert_eq!(code("plain"), "`plain`");
        assert_eq!(code("`a``b"), "``` `a``b ```");
        assert_eq!(
            block("toml", "a = 1\n```\n# b\n"),
            "````toml\na = 1\n```\n# b\n````"
        );
    }
}
