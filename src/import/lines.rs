//! Lines of a text, and the fields of a row.

use std::io::{BufRead, Read, Seek, SeekFrom};

use super::Problem;
use super::table::MAX_COLUMNS;

/// Maximum line length, bytes: [`MAX_COLUMNS`] columns of 64 bytes each.
const MAX_LINE: usize = 64 * MAX_COLUMNS;

/// Calls `each` with number (from 1) and text of every nonblank line until it returns false.
pub(super) fn each_line(
    content: &mut (impl BufRead + Seek),
    mut each: impl FnMut(u64, &str) -> Result<bool, Problem>,
) -> Result<(), Problem> {
    content.seek(SeekFrom::Start(0))?;
    let most = MAX_LINE + 1;
    let mut bytes = Vec::new();
    for line in 1.. {
        bytes.clear();
        Read::take(&mut *content, most as u64).read_until(b'\n', &mut bytes)?;
        if bytes.is_empty() {
            break;
        }
        if bytes.len() == most && !bytes.ends_with(b"\n") {
            return Err(Problem::Content(format!(
                "line {line} is longer than {MAX_LINE} bytes; check that the file is text with one row of samples per \
                 line"
            )));
        }
        let text = String::from_utf8_lossy(&bytes);
        let text = match text.strip_suffix('\n') {
            Some(text) => text.strip_suffix('\r').unwrap_or(text),
            None => &text,
        };
        // A byte order mark.
        let text = text.trim_start_matches('\u{feff}');
        if !text.trim().is_empty() && !each(line, text)? {
            break;
        }
    }
    Ok(())
}

/// Separator of the fields of a row.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Separator {
    Character(char),
    Blanks,
}

impl Separator {
    /// Detects the separator of a row.
    pub fn of(row: &str) -> Self {
        let found = [';', '\t', ','].into_iter().find(|&c| row.contains(c));
        found.map_or(Self::Blanks, Self::Character)
    }

    /// The fields of a row, without surrounding blanks and quotation marks.
    pub fn fields(self, row: &str) -> impl Iterator<Item = &str> {
        let mut quoted = false;
        let ends = move |c: char| match self {
            Self::Blanks => c.is_whitespace(),
            Self::Character(separator) => {
                quoted ^= c == '"';
                c == separator && !quoted
            }
        };
        let blanks = self == Self::Blanks;
        row.split(ends)
            .filter(move |field| !(blanks && field.is_empty()))
            .map(move |field| match blanks {
                true => field,
                false => field.trim().trim_matches('"').trim(),
            })
    }

    /// The number in a field; commas that do not separate fields may be decimal points.
    pub fn number(self, field: &str) -> Option<f64> {
        let is_decimal = self != Self::Character(',') && !field.contains('.');
        match field.split_once(',').filter(|_| is_decimal) {
            Some((whole, part)) => format!("{whole}.{part}").parse().ok(),
            None => field.parse().ok(),
        }
    }
}
