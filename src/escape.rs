//! Escaping of text from foreign files before display.
//!
//! The name of an array, the title of a scene or the path of a file can contain anything: a sequence
//! that clears the terminal, a newline that fakes a message, a control character that reverses the rest
//! of the line. Terminals, pages, recordings and figures show such characters escaped, in the notation
//! of TOML and JSON (`\n`, `\u001b`). JSON files and tables are read by programs and keep the text
//! unchanged.

/// Whether a character is invisible but changes how other text is displayed.
pub(crate) fn is_hidden(c: char) -> bool {
    c.is_control()
        // Line and paragraph separators; directional marks, embeddings, overrides and isolates.
        || matches!(c, '\u{2028}' | '\u{2029}' | '\u{61c}' | '\u{200e}' | '\u{200f}')
        || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A name on one line, with all hidden characters escaped.
pub(crate) fn line(text: &str) -> String {
    escaped(text, |_| false)
}

/// A text of several lines: like [`line`], but keeps line breaks and tabs.
pub(crate) fn lines(text: &str) -> String {
    // Windows uses two characters per line end.
    escaped(&text.replace("\r\n", "\n"), |c| matches!(c, '\n' | '\t'))
}

fn escaped(text: &str, is_kept: fn(char) -> bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            c if is_kept(c) || !is_hidden(c) => shown.push(c),
            '\n' => shown.push_str("\\n"),
            '\r' => shown.push_str("\\r"),
            '\t' => shown.push_str("\\t"),
            // All of them have four digits.
            c => shown += &format!("\\u{:04x}", u32::from(c)),
        }
    }
    shown
}

/// A path on one line.
pub(crate) fn path(path: &std::path::Path) -> String {
    line(&path.to_string_lossy())
}

/// A text of this program that contains foreign names, which are escaped: like [`lines`], but keeps
/// colours.
#[cfg(feature = "cli")]
pub(crate) fn terminal(text: &str) -> String {
    let mut pieces = text.split('\u{1b}');
    let mut shown = lines(pieces.next().unwrap_or_default());
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

/// A name as Markdown: on one line, with all markup escaped.
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

/// A name as inline code in Markdown.
#[cfg(feature = "record")]
pub(crate) fn code(name: &str) -> String {
    let name = line(name);
    let ticks = fence(&name, 1);
    if name.starts_with('`') || name.ends_with('`') {
        format!("{ticks} {name} {ticks}")
    } else {
        format!("{ticks}{name}{ticks}")
    }
}

/// A text as a code block in Markdown.
#[cfg(feature = "record")]
pub(crate) fn block(language: &str, text: &str) -> String {
    let text = lines(text.trim_end());
    let ticks = fence(&text, 3);
    format!("{ticks}{language}\n{text}\n{ticks}")
}

/// A run of backticks longer than any in the text, of at least `min` characters.
#[cfg(feature = "record")]
fn fence(text: &str, min: usize) -> String {
    let longest = text.split(|c| c != '`').map(str::len).max().unwrap_or(0);
    "`".repeat(min.max(longest + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_are_escaped() {
        assert_eq!(line("Größe, µm ⟂ 球"), "Größe, µm ⟂ 球");
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
        assert_eq!(lines("a\tb\nc"), "a\tb\nc");
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
    fn names_are_escaped_in_markdown() {
        assert_eq!(markdown("a\n# b ![x](y)"), "a\\\\n\\# b \\!\\[x\\](y)");
        assert_eq!(code("plain"), "`plain`");
        assert_eq!(code("`a``b"), "``` `a``b ```");
        assert_eq!(
            block("toml", "a = 1\n```\n# b\n"),
            "````toml\na = 1\n```\n# b\n````"
        );
    }
}
