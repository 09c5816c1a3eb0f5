//! Lines of a text, and the fields of a row.

use std::borrow::Cow;
use std::io::{BufRead, Read, Seek, SeekFrom};

use super::Problem;
use super::table::MAX_COLUMNS;

/// Maximum line length, bytes: [`MAX_COLUMNS`] columns of 64 bytes each.
pub(super) const MAX_LINE: usize = 64 * MAX_COLUMNS;

/// The content in UTF-8 if it begins with a byte order mark of UTF-16, as spreadsheets export it.
pub(super) fn from_utf16(content: &mut impl BufRead) -> Result<Option<String>, Problem> {
    let number: fn([u8; 2]) -> u16 = match content.fill_buf()? {
        [0xFF, 0xFE, ..] => u16::from_le_bytes,
        [0xFE, 0xFF, ..] => u16::from_be_bytes,
        _ => return Ok(None),
    };
    let mut bytes = Vec::new();
    content.read_to_end(&mut bytes)?;
    let (pairs, _) = bytes.as_chunks();
    let text = char::decode_utf16(pairs.iter().map(|pair| number(*pair)));
    let text = text.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
    Ok(Some(text.collect()))
}

/// Calls `each` with number (from 1) and text of every nonblank line after the first `skipped` ones until it returns
/// false. Bytes that are not UTF-8 are Latin-1.
pub(super) fn each_line(
    content: &mut (impl BufRead + Seek),
    skipped: u64,
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
        if line <= skipped {
            continue;
        }
        let text = std::str::from_utf8(&bytes).map_or_else(
            |_| Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
            Cow::Borrowed,
        );
        let text = match text.strip_suffix('\n') {
            Some(text) => text.strip_suffix('\r').unwrap_or(text),
            None => &text,
        };
        // A byte order mark.
        let text = text.trim_start_matches('\u{feff}');
        // A spreadsheet states the separator in the first line.
        let is_hint = line == 1 && text.starts_with("sep=");
        if !is_hint && !text.trim().is_empty() && !each(line, text)? {
            break;
        }
    }
    Ok(())
}

/// Detects the separator of the fields of a row; a blank stands for any number of blanks.
pub(super) fn separator_of(row: &str) -> char {
    let found = [';', '\t', ','].into_iter().find(|&c| row.contains(c));
    found.unwrap_or(' ')
}

/// The fields of a row, without surrounding blanks and quotation marks.
pub(super) fn split_row(separator: char, row: &str) -> impl Iterator<Item = &str> {
    let is_blank = separator == ' ';
    let mut quoted = false;
    let ends = move |c: char| {
        quoted ^= c == '"';
        if is_blank {
            c.is_whitespace()
        } else {
            c == separator && !quoted
        }
    };
    row.split(ends)
        .filter(move |field| !(is_blank && field.is_empty()))
        .map(move |field| {
            if is_blank {
                field
            } else {
                field.trim().trim_matches('"').trim()
            }
        })
}

/// The number in a field. A comma, which does not separate fields here, may be the decimal point.
pub(super) fn number(field: &str) -> Option<f64> {
    match field.split_once(',').filter(|_| !field.contains('.')) {
        Some((whole, part)) => format!("{whole}.{part}").parse().ok(),
        None => field.parse().ok(),
    }
}
