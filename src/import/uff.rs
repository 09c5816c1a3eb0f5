//! Universal files: time histories (dataset 58, text or binary).
//!
//! A dataset lies between two lines with -1. Dataset 58 has eleven lines of fixed columns and then its samples: numbers
//! as text, or with the letter b their bytes. The file is read as a whole; each history has a clock of its own
//! (Universal File Datasets Summary, University of Cincinnati, Structural Dynamics Research Laboratory).

use std::borrow::Cow;
use std::io::Read;
use std::sync::Arc;

use super::Problem;
use super::clock::{Timing, Uniform};
use super::table::{Column, ColumnHeader, Table, check_column_count};
use crate::foreign::shortened;

const FORMAT: &str = "universal";

/// Line that begins and ends a dataset.
const DELIMITER: &str = "-1";

/// Function type of a time history, and type of an abscissa that is a time.
const TIME_RESPONSE: i64 = 1;
const TIME: i64 = 17;

/// Relative uncertainty of the abscissa, which has six digits.
const UNCERTAINTY: f64 = 1e-5;

/// Whether a content begins with a dataset.
pub(super) fn is_universal(content: &[u8]) -> bool {
    let mut lines = Lines(content);
    let begins = lines.next().is_some_and(|line| line.trim() == DELIMITER);
    let kind = lines.find(|line| line.trim() != DELIMITER);
    let is_kind = |line: Cow<str>| field(&line, 0, 6).parse::<u32>().is_ok() || is_history(&line);
    begins && content.starts_with(b"    ") && kind.is_some_and(is_kind)
}

/// Reads all time histories. One that is damaged or of another kind of number is left out, with the first cause in the damage.
pub(super) fn read(mut content: impl Read) -> Result<Table, Problem> {
    let mut bytes = Vec::new();
    content.read_to_end(&mut bytes)?;
    let mut lines = Lines(&bytes);
    let mut columns = Vec::new();
    let mut others = 0;
    let mut left_out = None;
    while let Some(line) = lines.next() {
        if line.trim() != DELIMITER {
            continue;
        }
        // Some programs write the line twice.
        let Some(kind) = lines.find(|line| line.trim() != DELIMITER) else {
            break;
        };
        if !is_history(&kind) {
            others += 1;
            lines.find(|line| line.trim() == DELIMITER);
        } else {
            match history(&kind, &mut lines) {
                Ok(Some(history)) => columns.push(history),
                Ok(None) => others += 1,
                Err(problem) => left_out = left_out.or(Some(problem)),
            }
        }
    }
    if columns.is_empty() {
        if let Some(problem) = left_out {
            return Err(problem);
        }
        let content = format!("{others} datasets of other kinds than time histories (58)");
        return Err(Problem::no_samples(&content));
    }
    check_column_count(columns.len())?;
    let damage = left_out.map(|problem: Problem| format!("a time history is left out: {problem}"));
    Ok(Table { columns, damage })
}

/// Lines of a content, which may contain other bytes between them.
struct Lines<'a>(&'a [u8]);

impl<'a> Lines<'a> {
    /// The bytes of the next line.
    fn bytes(&mut self) -> Option<&'a [u8]> {
        let end = self.0.iter().position(|byte| *byte == b'\n');
        let (line, rest) = self.0.split_at(end.map_or(self.0.len(), |end| end + 1));
        self.0 = rest;
        (!line.is_empty()).then_some(line)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Cow<'a, str>;

    fn next(&mut self) -> Option<Self::Item> {
        self.bytes().map(String::from_utf8_lossy)
    }
}

/// The characters of a field, without surrounding blanks.
fn field(line: &str, start: usize, length: usize) -> String {
    let text: String = line.chars().skip(start).take(length).collect();
    text.trim().to_owned()
}

/// The whole number in a field; 0 if it is none.
fn whole(line: &str, start: usize, length: usize) -> i64 {
    field(line, start, length).parse().unwrap_or(0)
}

/// A real number, also with the exponent of Fortran.
fn real(text: &str) -> Option<f64> {
    let number = text.parse().ok();
    number.or_else(|| text.replace(['D', 'd'], "E").parse().ok())
}

fn is_history(line: &str) -> bool {
    matches!(&*field(line, 0, 7), "58" | "58b" | "58B")
}

/// Reads a dataset 58; `None` if it is no time history.
fn history(kind: &str, lines: &mut Lines<'_>) -> Result<Option<Column>, Problem> {
    let head: Vec<_> = lines.by_ref().take(11).collect();
    let [id, _, _, _, _, function, form, abscissa, ordinate, ..] = &head[..] else {
        let what = "a dataset 58 has less than 11 lines";
        return Err(Problem::damaged(FORMAT, what));
    };
    let is_binary = kind.trim_start().len() > 2 && kind.contains(['b', 'B']);
    let data = if is_binary {
        let length = usize::try_from(whole(kind, 31, 12)).unwrap_or(usize::MAX);
        let Some((data, rest)) = lines.0.split_at_checked(length) else {
            let (what, have) = ("a dataset 58", lines.0.len() as u64);
            return Err(Problem::truncated(FORMAT, what, have, length as u64));
        };
        lines.0 = rest;
        lines.find(|line| line.trim() == DELIMITER);
        data
    } else {
        let all = lines.0;
        let is_data = |line: &&[u8]| line.trim_ascii() != DELIMITER.as_bytes();
        let mut end = 0;
        while let Some(line) = lines.bytes().filter(is_data) {
            end += line.len();
        }
        &all[..end]
    };
    if whole(function, 0, 5) != TIME_RESPONSE && whole(abscissa, 0, 10) != TIME {
        return Ok(None);
    }
    let name = name(id, function);
    let is_double = match whole(form, 0, 10) {
        2 => false,
        4 => true,
        kind => {
            let what = format!("`{name}`, a time history of ordinate type {kind},");
            let remedy = "export real numbers (type 2 or 4)";
            return Err(Problem::unsupported(what, remedy));
        }
    };
    let is_even = whole(form, 20, 10) == 1;
    if is_binary && is_double && !is_even {
        let what = "a binary time history of double precision with uneven times";
        return Err(Problem::unsupported(what, "export it as text"));
    }
    let mut samples = if is_binary {
        numbers(data, is_double, whole(kind, 7, 6) == 1)
    } else {
        text(data, &name)?
    };
    let count = usize::try_from(whole(form, 10, 10)).unwrap_or(0);
    let timing = if is_even {
        let [start, step] = [30, 43].map(|at| real(&field(form, at, 13)).unwrap_or(0.0));
        Timing::Uniform(Uniform::new(start, step, UNCERTAINTY))
    } else {
        // Pairs of time and sample.
        let (pairs, _) = samples.as_chunks::<2>();
        let pairs = pairs.iter().take(count).map(|[time, x]| (*time, *x));
        let times: Vec<f64>;
        (times, samples) = pairs.unzip();
        Timing::Times {
            times: Arc::new(times),
            resolution: 0.0,
            relative: UNCERTAINTY,
        }
    };
    let have = samples.len();
    if have < count {
        let what = format!("`{name}` has {have} of {count} samples");
        return Err(Problem::damaged(FORMAT, what));
    }
    samples.truncate(count);
    let unit = Some(field(ordinate, 47, 20)).filter(|unit| unit != "NONE");
    Ok(Some(Column {
        header: ColumnHeader::with_unit(name, &unit.unwrap_or_default()),
        timing,
        samples,
    }))
}

/// Name of a history: its node with the direction, or else its description.
fn name(id: &str, function: &str) -> String {
    let given = |text: &String| !text.is_empty() && text != "NONE";
    let node = Some(field(function, 31, 10)).filter(given);
    let node = node.unwrap_or_else(|| field(function, 41, 10));
    if node == "0" || node.is_empty() {
        let id = Some(id.trim().to_owned()).filter(given);
        return id.unwrap_or_else(|| "history".to_owned());
    }
    let direction = whole(function, 51, 4);
    let Some(axis) = direction.unsigned_abs().checked_sub(1) else {
        return node;
    };
    let axes = ["X", "Y", "Z", "RX", "RY", "RZ"];
    let axis = axes.get(axis as usize).unwrap_or(&"?");
    format!("{node}:{}{axis}", if direction < 0 { '-' } else { '+' })
}

/// Numbers as text.
fn text(data: &[u8], name: &str) -> Result<Vec<f64>, Problem> {
    let text = String::from_utf8_lossy(data);
    let number = |word| {
        real(word).ok_or_else(|| {
            let what = format!("`{}` in `{name}` is not a number", shortened(word));
            Problem::damaged(FORMAT, what)
        })
    };
    text.split_whitespace().map(number).collect()
}

/// Binary numbers.
fn numbers(data: &[u8], is_double: bool, is_little: bool) -> Vec<f64> {
    let singles = data.as_chunks().0.iter();
    let doubles = data.as_chunks().0.iter();
    match (is_double, is_little) {
        (false, true) => singles.map(|b| f32::from_le_bytes(*b).into()).collect(),
        (false, false) => singles.map(|b| f32::from_be_bytes(*b).into()).collect(),
        (true, true) => doubles.map(|b| f64::from_le_bytes(*b)).collect(),
        (true, false) => doubles.map(|b| f64::from_be_bytes(*b)).collect(),
    }
}
