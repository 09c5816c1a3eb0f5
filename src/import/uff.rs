//! Universal files: time histories (dataset 58, text or binary).
//!
//! A dataset lies between two lines with -1. Dataset 58 has eleven lines of fixed columns and then its samples: numbers
//! as text, or with the letter b their bytes. The file is read as a whole; each history has a clock of its own
//! (Universal File Datasets Summary, University of Cincinnati, Structural Dynamics Research Laboratory).

use std::borrow::Cow;
use std::io::Read;

use super::clock::{Timing, Uniform};
use super::table::{ColumnHeader, Table, check_column_count, find_column};
use super::text::shortened;
use super::{Problem, Selection, Signal};

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

/// The names and units of the histories.
pub(super) fn headings(content: impl Read) -> Result<Vec<ColumnHeader>, Problem> {
    let bytes = all(content)?;
    let histories = histories(&bytes)?.into_iter();
    Ok(histories.map(|history| history.heading).collect())
}

/// Reads the selected history.
pub(super) fn read(content: impl Read, selection: &Selection) -> Result<Signal, Problem> {
    let bytes = all(content)?;
    let histories = histories(&bytes)?;
    check_column_count(histories.len())?;
    let headings: Vec<_> = histories.iter().map(|h| h.heading.clone()).collect();
    let column = find_column(&headings, selection.column.as_deref())?;
    let rest = Selection {
        column: None,
        ..selection.clone()
    };
    histories[column].table()?.signal(&rest)
}

fn all(mut content: impl Read) -> Result<Vec<u8>, Problem> {
    let mut bytes = Vec::new();
    content.read_to_end(&mut bytes)?;
    Ok(bytes)
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

fn is_history(line: &str) -> bool {
    matches!(&*field(line, 0, 7), "58" | "58b" | "58B")
}

/// A time history whose samples have not been read.
struct History<'a> {
    heading: ColumnHeader,
    is_double: bool,
    is_even: bool,
    start: f64,
    step: f64,
    /// Byte order of binary samples: whether the lowest byte is the first.
    is_little: Option<bool>,
    data: &'a [u8],
}

/// The time histories of a file.
fn histories(bytes: &[u8]) -> Result<Vec<History<'_>>, Problem> {
    let mut lines = Lines(bytes);
    let mut histories = Vec::new();
    let mut others = 0;
    while let Some(line) = lines.next() {
        if line.trim() != DELIMITER {
            continue;
        }
        // Some programs write the line twice.
        let Some(kind) = lines.find(|line| line.trim() != DELIMITER) else {
            break;
        };
        if is_history(&kind) {
            match history(&kind, &mut lines)? {
                Some(history) => histories.push(history),
                None => others += 1,
            }
        } else {
            others += 1;
            lines.find(|line| line.trim() == DELIMITER);
        }
    }
    if histories.is_empty() {
        let content = format!("{others} datasets of other kinds than time histories (58)");
        return Err(Problem::no_samples(&content));
    }
    Ok(histories)
}

/// Reads the head of a dataset 58 and finds its samples; `None` if it is no time history.
fn history<'a>(kind: &str, lines: &mut Lines<'a>) -> Result<Option<History<'a>>, Problem> {
    let head: Vec<_> = lines.by_ref().take(11).collect();
    let [id, _, _, _, _, function, form, abscissa, ordinate, ..] = &head[..] else {
        return Err(Problem::damaged(
            FORMAT,
            "a dataset 58 has less than 11 lines",
        ));
    };
    let whole = |line: &str, start, length| field(line, start, length).parse::<i64>().unwrap_or(0);
    let real = |start| {
        field(form, start, 13)
            .replace(['D', 'd'], "E")
            .parse()
            .unwrap_or(0.0)
    };
    let is_binary = kind.trim_start().len() > 2 && kind.contains(['b', 'B']);
    let data = if is_binary {
        let length = usize::try_from(whole(kind, 31, 12)).unwrap_or(usize::MAX);
        let Some((data, rest)) = lines.0.split_at_checked(length) else {
            let have = lines.0.len() as u64;
            return Err(Problem::truncated(
                FORMAT,
                "a dataset 58",
                have,
                length as u64,
            ));
        };
        lines.0 = rest;
        lines.find(|line| line.trim() == DELIMITER);
        data
    } else {
        let all = lines.0;
        let mut end = 0;
        while let Some(line) = lines
            .bytes()
            .filter(|line| line.trim_ascii() != DELIMITER.as_bytes())
        {
            end += line.len();
        }
        &all[..end]
    };
    if whole(function, 0, 5) != TIME_RESPONSE && whole(abscissa, 0, 10) != TIME {
        return Ok(None);
    }
    let name = |text: String| Some(text).filter(|text| !text.is_empty() && text != "NONE");
    let node = name(field(function, 31, 10)).unwrap_or_else(|| field(function, 41, 10));
    let direction = match whole(function, 51, 4) {
        0 => String::new(),
        number => {
            let axes = ["X", "Y", "Z", "RX", "RY", "RZ"];
            let axis = axes.get(number.unsigned_abs() as usize - 1).unwrap_or(&"?");
            format!(":{}{axis}", if number < 0 { '-' } else { '+' })
        }
    };
    let name_of_node = if node == "0" || node.is_empty() {
        name(id.trim().to_owned()).unwrap_or_else(|| "history".to_owned())
    } else {
        node + &direction
    };
    let unit = name(field(ordinate, 47, 20)).unwrap_or_default();
    let count = usize::try_from(whole(form, 10, 10)).unwrap_or(0);
    let is_double = match whole(form, 0, 10) {
        2 => false,
        4 => true,
        kind => {
            let what = format!("`{name_of_node}`, a time history of ordinate type {kind},");
            return Err(Problem::unsupported(
                what,
                "export real numbers (type 2 or 4)",
            ));
        }
    };
    Ok(Some(History {
        heading: ColumnHeader::with_unit(name_of_node, &unit, count),
        is_double,
        is_even: whole(form, 20, 10) == 1,
        start: real(30),
        step: real(43),
        is_little: is_binary.then(|| whole(kind, 7, 6) == 1),
        data,
    }))
}

impl History<'_> {
    /// The samples with their times.
    fn table(&self) -> Result<Table, Problem> {
        let mut values = match self.is_little {
            Some(is_little) => self.numbers(is_little)?,
            None => self.text()?,
        };
        let mut times = Vec::new();
        if !self.is_even {
            let (pairs, _) = values.as_chunks::<2>();
            (times, values) = pairs.iter().map(|[time, value]| (*time, *value)).unzip();
        }
        let (have, count) = (values.len(), self.heading.count);
        if have < count {
            let what = format!("`{}` has {have} of {count} samples", self.heading.name);
            return Err(Problem::damaged(FORMAT, what));
        }
        values.truncate(count);
        times.truncate(count);
        let timing = if self.is_even {
            Timing::Uniform(Uniform::new(self.start, self.step, UNCERTAINTY))
        } else {
            Timing::Times {
                count,
                resolution: 0.0,
                relative: UNCERTAINTY,
            }
        };
        Ok(Table {
            columns: vec![(self.heading.clone(), values)],
            times,
            timing,
        })
    }

    /// Numbers as text; pairs of time and sample if the times are uneven.
    fn text(&self) -> Result<Vec<f64>, Problem> {
        let text = String::from_utf8_lossy(self.data);
        let number = |word: &str| {
            let number = word
                .parse()
                .or_else(|_| word.replace(['D', 'd'], "E").parse());
            number.map_err(|_| {
                let what = format!(
                    "`{}` in `{}` is not a number",
                    shortened(word),
                    self.heading.name
                );
                Problem::damaged(FORMAT, what)
            })
        };
        text.split_whitespace().map(number).collect()
    }

    /// Binary numbers; pairs of time and sample if the times are uneven.
    fn numbers(&self, is_little: bool) -> Result<Vec<f64>, Problem> {
        if self.is_double && !self.is_even {
            let what = "a binary time history of double precision with uneven times";
            return Err(Problem::unsupported(what, "export it as text"));
        }
        let (singles, _) = self.data.as_chunks::<4>();
        let (doubles, _) = self.data.as_chunks::<8>();
        Ok(match (self.is_double, is_little) {
            (false, true) => singles
                .iter()
                .map(|b| f32::from_le_bytes(*b).into())
                .collect(),
            (false, false) => singles
                .iter()
                .map(|b| f32::from_be_bytes(*b).into())
                .collect(),
            (true, true) => doubles.iter().map(|b| f64::from_le_bytes(*b)).collect(),
            (true, false) => doubles.iter().map(|b| f64::from_be_bytes(*b)).collect(),
        })
    }
}
