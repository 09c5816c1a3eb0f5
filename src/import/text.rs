//! Columns of numbers as text: CSV and similar formats.
//!
//! The separator is detected from the first row of numbers: `;`, else a tab, else `,`, else blanks. If commas
//! do not separate fields, they may be decimal points. A row above the numbers contains the column names; a
//! second one, all in brackets, contains their units. Lines that start with `#` are comments. The last
//! comment before the numbers contains the column names if no row does and it has as many fields (as
//! `numpy.savetxt` writes it). An empty field is a missing sample.
//!
//! The first pass through the text finds columns, rows and digits. Later passes read the times and the
//! selected samples. No column is stored.

use std::io::{BufRead, Seek};
use std::ops::Range;

use super::clock::{Timing, uniform};
use super::lines::{Separator, each_line};
use super::preamble::Preamble;
use super::table::{ColumnHeader, Source, check_column_count};
use super::{Problem, units};

/// A text whose columns are known.
pub(super) struct Text<R> {
    content: R,
    /// Columns of numbers, without the times.
    scan: Scan,
    /// Field of the time column, and its unit, s.
    time: Option<(usize, f64)>,
    timing: Timing,
    /// Name of a single column.
    stem: String,
}

/// A column with its heading.
struct Named {
    /// Index among the fields of a row.
    field: usize,
    heading: ColumnHeader,
    seen: ColumnStatistics,
}

impl<R: BufRead + Seek> Text<R> {
    pub fn open(mut content: R, stem: &str) -> Result<Self, Problem> {
        let preamble = Preamble::of(&mut content)?.unwrap_or_default();
        let mut scan = Scan::of(&mut content, &preamble)?;
        // Columns of words are ignored if there are others.
        if scan.columns.iter().any(|c| c.seen.count > 0) {
            scan.columns.retain(|c| c.seen.count > 0);
        }
        for column in &mut scan.columns {
            if let Some((line, text)) = column.seen.fault.take() {
                return Err(Problem::not_a_number(line, &column.heading.header, &text));
            }
        }
        let mut text = Self {
            content,
            scan,
            time: None,
            timing: Timing::Unknown,
            stem: stem.to_owned(),
        };
        if text.scan.columns.len() > 1 {
            text.find_time();
        }
        if let Some(clock) = preamble.clock {
            text.timing = Timing::Uniform(clock);
        }
        Ok(text)
    }

    /// Removes the time column from the columns, if there is one.
    fn find_time(&mut self) {
        let columns = &mut self.scan.columns;
        let second =
            |c: &Named| units::seconds(&c.heading.unit).filter(|_| units::is_time(&c.heading.name));
        let mut seconds = columns.iter().map(second).enumerate();
        let by_name = seconds.find_map(|(place, second)| Some((place, second?)));
        let first = &columns[0];
        let (field, resolution) = (first.field, first.seen.resolution());
        if let Some((place, second)) = by_name {
            let column = columns.remove(place);
            self.time = Some((column.field, second));
            self.timing = Timing::Times {
                count: self.scan.rows,
                resolution: column.seen.resolution() * second,
                relative: 0.0,
            };
        } else if first.seen.is_row_index {
            columns.remove(0);
        } else {
            let all = 0..self.scan.rows;
            let mut values = |each: &mut dyn FnMut(f64)| self.values(field, all.clone(), each);
            if let Ok(uniform) = uniform(&mut values, resolution, 0.0) {
                self.scan.columns.remove(0);
                self.timing = Timing::Uniform(uniform);
            }
        }
    }

    /// Calls `each` for the numbers of a field in some rows; an empty field is a missing sample.
    fn values(
        &mut self,
        field: usize,
        rows: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        let (separator, first) = (self.scan.separator, self.scan.first);
        let mut row = 0;
        each_line(&mut self.content, |line, text| {
            if line < first || is_comment(text) {
                return Ok(true);
            }
            if rows.contains(&row) {
                let field = separator.fields(text).nth(field);
                each(field.and_then(|f| separator.number(f)).unwrap_or(f64::NAN));
            }
            row += 1;
            Ok(row < rows.end)
        })
    }
}

impl<R: BufRead + Seek> Source for Text<R> {
    fn headings(&self) -> Vec<ColumnHeader> {
        let is_lone = self.scan.columns.len() == 1;
        let named = self.scan.columns.iter().enumerate().map(|(place, c)| {
            let mut heading = ColumnHeader {
                count: self.scan.rows,
                ..c.heading.clone()
            };
            if heading.header.is_empty() {
                heading.name = if is_lone {
                    self.stem.clone()
                } else {
                    place.to_string()
                };
                heading.header.clone_from(&heading.name);
            }
            heading
        });
        named.collect()
    }

    fn timing(&self) -> Timing {
        self.timing
    }

    fn times(&mut self, each: &mut dyn FnMut(f64)) -> Result<(), Problem> {
        let Some((field, second)) = self.time else {
            return Ok(());
        };
        self.values(field, 0..self.scan.rows, &mut |time| each(time * second))
    }

    fn samples(
        &mut self,
        column: usize,
        range: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        self.values(self.scan.columns[column].field, range, each)
    }
}

fn is_comment(line: &str) -> bool {
    line.starts_with('#')
}

/// Result of the first pass.
struct Scan {
    separator: Separator,
    /// Number of the line with the first row of numbers.
    first: u64,
    rows: usize,
    columns: Vec<Named>,
}

impl Scan {
    fn of(content: &mut (impl BufRead + Seek), preamble: &Preamble) -> Result<Self, Problem> {
        let mut scan: Option<Self> = None;
        // The first two rows above the numbers, and the last line before them.
        let mut above = Vec::new();
        let mut last = String::new();
        each_line(content, |line, text| {
            match &mut scan {
                _ if line <= preamble.last => {}
                Some(_) if is_comment(text) => {}
                Some(scan) => scan.take(line, text)?,
                None if !is_comment(text) && is_row_of_numbers(text) => {
                    let begun = if preamble.columns.is_empty() {
                        Self::begin(line, text, &above, &last)?
                    } else {
                        Self::after_preamble(line, text, preamble)
                    };
                    scan.insert(begun).take(line, text)?;
                }
                None => {
                    if !is_comment(text) && above.len() < 2 {
                        above.push((line, text.to_owned()));
                    }
                    text.clone_into(&mut last);
                }
            }
            Ok(true)
        })?;
        scan.ok_or_else(|| Problem::no_samples("headings or comments"))
    }

    /// The columns of the first row of numbers, with the names and units of a preamble.
    fn after_preamble(first: u64, sample: &str, preamble: &Preamble) -> Self {
        let separator = Separator::of(sample);
        let last = separator.fields(sample).enumerate();
        let last = last.filter(|(_, field)| !field.is_empty()).last();
        let named = |field: usize| {
            let (name, unit) = preamble.columns.get(field).cloned().unwrap_or_default();
            Named {
                field,
                heading: ColumnHeader::with_unit(name, &unit, 0),
                seen: ColumnStatistics::default(),
            }
        };
        Self {
            separator,
            first,
            rows: 0,
            columns: (preamble.beside..=last.map_or(0, |(k, _)| k))
                .map(named)
                .collect(),
        }
    }

    /// Determines the columns from the first row of numbers and the lines above it.
    fn begin(
        first: u64,
        sample: &str,
        above: &[(u64, String)],
        last: &str,
    ) -> Result<Self, Problem> {
        let separator = Separator::of(sample);
        let mut count = separator.fields(sample).count();
        let (names, units_row) = headings(above, separator)?;
        let names = names.or_else(|| {
            let names: Vec<_> = separator.fields(last.strip_prefix('#')?.trim()).collect();
            (names.len() == count && count > 1).then_some(names)
        });
        // A trailing separator in each row is not a column.
        let named_empty = |names: &[&str]| names.last() == Some(&"");
        if separator.fields(sample).last() == Some("") && names.as_deref().is_none_or(named_empty) {
            count -= 1;
        }
        check_column_count(count)?;
        let named = |field: usize| {
            let header = *names.as_ref().and_then(|n| n.get(field)).unwrap_or(&"");
            let mut heading = ColumnHeader::new(header.to_owned(), 0);
            if let Some(unit) = units_row.as_ref().and_then(|u| bracketed(u.get(field)?)) {
                heading.unit = unit.to_owned();
            }
            Named {
                field,
                heading,
                seen: ColumnStatistics::default(),
            }
        };
        Ok(Self {
            separator,
            first,
            rows: 0,
            columns: (0..count).map(named).collect(),
        })
    }

    /// Processes a row of numbers.
    fn take(&mut self, line: u64, row: &str) -> Result<(), Problem> {
        let need = self.columns.last().map_or(0, |column| column.field + 1);
        let mut columns = self.columns.iter_mut().peekable();
        // Trailing separators are no columns.
        let (mut have, mut given) = (0, 0);
        for field in self.separator.fields(row) {
            if let Some(column) = columns.next_if(|column| column.field == have) {
                column.seen.take(field, line, self.separator);
            }
            have += 1;
            if !field.is_empty() {
                given = have;
            }
        }
        if have < need || given > need {
            return Err(Problem::Content(format!(
                "line {line} has {have} fields instead of {need}; complete or remove it"
            )));
        }
        self.rows += 1;
        Ok(())
    }
}

/// Whether at least half of the fields are numbers.
fn is_row_of_numbers(row: &str) -> bool {
    let separator = Separator::of(row);
    let (mut numbers, mut words) = (0, 0);
    for field in separator.fields(row).filter(|f| !f.is_empty()) {
        match separator.number(field) {
            Some(_) => numbers += 1,
            None => words += 1,
        }
    }
    numbers > 0 && numbers >= words
}

/// The fields of a heading.
type Fields<'a> = Option<Vec<&'a str>>;

/// Names and units from the rows above the numbers, of which the first two are given.
fn headings(
    rows: &[(u64, String)],
    separator: Separator,
) -> Result<(Fields<'_>, Fields<'_>), Problem> {
    let fields = |row| separator.fields(row).collect::<Vec<_>>();
    match rows {
        [] => Ok((None, None)),
        [(_, names)] => Ok((Some(fields(names)), None)),
        [(_, names), (_, units)] if fields(units).iter().all(|u| bracketed(u).is_some()) => {
            Ok((Some(fields(names)), Some(fields(units))))
        }
        [(_, names), (line, row), ..] => {
            let first = |row| fields(row).first().copied().unwrap_or("");
            let text = shortened(first(row));
            Err(Problem::not_a_number(*line, first(names), &text))
        }
    }
}

/// Statistics of a column from the first pass.
#[derive(Default)]
struct ColumnStatistics {
    /// Number of numbers and empty fields before the first invalid field.
    count: usize,
    /// The first field that is not a number, with its line.
    fault: Option<(u64, String)>,
    /// The first number, and the largest magnitude.
    first: f64,
    largest: f64,
    /// Whether the column only counts the rows, 0, 1, 2, ... or 1, 2, 3, ...
    is_row_index: bool,
    /// Largest number of decimals, minus the exponent of ten.
    decimals: i32,
    /// Largest number of significant digits.
    digits: i32,
}

impl ColumnStatistics {
    fn take(&mut self, field: &str, line: u64, separator: Separator) {
        if self.fault.is_some() {
            return;
        }
        let number = separator.number(field);
        if number.is_some() {
            self.take_digits(field);
        } else if !field.is_empty() {
            self.fault = Some((line, shortened(field)));
            return;
        }
        let value = number.unwrap_or(f64::NAN);
        if self.count == 0 {
            self.first = value;
            self.is_row_index = [0.0, 1.0].contains(&value);
        }
        self.is_row_index &= value == self.first + self.count as f64;
        self.largest = self.largest.max(value.abs());
        self.count += 1;
    }

    fn take_digits(&mut self, field: &str) {
        let (mantissa, exponent) = field.split_once(['e', 'E']).unwrap_or((field, "0"));
        let exponent = exponent.parse().unwrap_or(0);
        let digits = |text: &str| text.chars().filter(char::is_ascii_digit).count() as i32;
        let (whole, part) = mantissa.split_once(['.', ',']).unwrap_or((mantissa, ""));
        let leading = whole.trim_start_matches(['+', '-', '0']);
        self.digits = self.digits.max(match leading {
            "" => digits(part.trim_start_matches('0')),
            whole => digits(whole) + digits(part),
        });
        self.decimals = self.decimals.max(digits(part) - exponent);
    }

    /// Uncertainty of a value due to its number of digits.
    ///
    /// Programs write a fixed number of either decimals or significant digits.
    fn resolution(&self) -> f64 {
        let in_all = self.largest * 10.0_f64.powi(1 - self.digits);
        in_all.max(10.0_f64.powi(-self.decimals))
    }
}

/// Text in brackets.
fn bracketed(field: &str) -> Option<&str> {
    let pairs = [('(', ')'), ('[', ']')];
    let inside = |(open, close)| field.strip_prefix(open)?.strip_suffix(close);
    pairs.into_iter().find_map(inside)
}

/// Start of a text, for a message.
fn shortened(text: &str) -> String {
    const MOST: usize = 30;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
