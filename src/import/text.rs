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

use super::clock::{Timing, Uniform, uniform};
use super::lines::{Separator, each_line};
use super::preamble::Preamble;
use super::table::{ColumnHeader, MAX_COLUMNS, Source};
use super::{Problem, units};

/// A text whose columns are known.
pub(super) struct Text<R> {
    content: R,
    separator: Separator,
    /// Number of the line with the first row of numbers, from 1.
    first: u64,
    rows: usize,
    /// Columns of numbers, without the times.
    columns: Vec<Named>,
    time: Option<Time>,
    /// Name of a single column.
    stem: String,
}

/// A column with its heading.
struct Named {
    /// Index among the fields of a row.
    field: usize,
    header: String,
    name: String,
    unit: String,
    seen: ColumnStatistics,
}

/// The time column.
struct Time {
    field: usize,
    /// Unit, s.
    second: f64,
    /// Uncertainty of a time due to its number of digits, s.
    resolution: f64,
    /// Sample rate and start, if they have been evaluated.
    uniform: Option<Uniform>,
}

impl<R: BufRead + Seek> Text<R> {
    pub fn open(mut content: R, stem: &str) -> Result<Self, Problem> {
        let preamble = Preamble::of(&mut content)?.unwrap_or_default();
        let scan = Scan::of(&mut content, &preamble)?;
        let (separator, first, rows) = (scan.separator, scan.first, scan.rows);
        let mut columns = scan.columns;
        // Columns of words are ignored if there are others.
        if columns.iter().any(|c| c.seen.count > 0) {
            columns.retain(|c| c.seen.count > 0);
        }
        for column in &mut columns {
            if let Some((line, text)) = column.seen.fault.take() {
                return Err(Problem::NotANumber {
                    line,
                    column: column.header.clone(),
                    text,
                });
            }
        }
        let mut text = Self {
            content,
            separator,
            first,
            rows,
            columns,
            time: None,
            stem: stem.to_owned(),
        };
        if text.columns.len() > 1 {
            text.find_time();
        }
        if let Some(clock) = preamble.clock {
            text.time = Some(Time {
                field: 0,
                second: 1.0,
                resolution: 0.0,
                uniform: Some(clock),
            });
        }
        Ok(text)
    }

    /// Removes the time column from the columns, if there is one.
    fn find_time(&mut self) {
        let second = |c: &Named| units::seconds(&c.unit).filter(|_| units::is_time(&c.name));
        let mut seconds = self.columns.iter().map(second).enumerate();
        let by_name = seconds.find_map(|(place, second)| Some((place, second?)));
        let first = &self.columns[0];
        let (field, resolution) = (first.field, first.seen.resolution());
        if let Some((place, second)) = by_name {
            let column = self.columns.remove(place);
            self.time = Some(Time {
                field: column.field,
                second,
                resolution: column.seen.resolution() * second,
                uniform: None,
            });
        } else if first.seen.is_row_index {
            self.columns.remove(0);
        } else {
            let all = 0..self.rows;
            let mut values = |each: &mut dyn FnMut(f64)| self.values(field, all.clone(), each);
            let Ok(uniform) = uniform(&mut values, resolution, 0.0) else {
                return;
            };
            self.columns.remove(0);
            self.time = Some(Time {
                field,
                second: 1.0,
                resolution,
                uniform: Some(uniform),
            });
        }
    }

    /// Calls `each` for the numbers of a field in some rows; an empty field is a missing sample.
    fn values(
        &mut self,
        field: usize,
        rows: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        let (separator, first) = (self.separator, self.first);
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
        let lone = self.columns.len() == 1;
        let named = self.columns.iter().enumerate().map(|(place, c)| {
            let name = match (c.name.is_empty(), lone) {
                (false, _) => c.name.clone(),
                (true, true) => self.stem.clone(),
                (true, false) => place.to_string(),
            };
            ColumnHeader {
                header: match c.header.is_empty() {
                    true => name.clone(),
                    false => c.header.clone(),
                },
                name,
                unit: c.unit.clone(),
                count: self.rows,
            }
        });
        named.collect()
    }

    fn timing(&self) -> Timing {
        match &self.time {
            None => Timing::Unknown,
            Some(Time {
                uniform: Some(uniform),
                ..
            }) => Timing::Uniform(*uniform),
            Some(time) => Timing::Times {
                count: self.rows,
                resolution: time.resolution,
                relative: 0.0,
            },
        }
    }

    fn times(&mut self, each: &mut dyn FnMut(f64)) -> Result<(), Problem> {
        let Some(Time { field, second, .. }) = self.time else {
            return Ok(());
        };
        self.values(field, 0..self.rows, &mut |time| each(time * second))
    }

    fn samples(
        &mut self,
        column: usize,
        range: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        self.values(self.columns[column].field, range, each)
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
                    let begun = match preamble.columns.is_empty() {
                        true => Self::begin(line, text, &above, &last)?,
                        false => Self::after_preamble(line, text, preamble),
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
        scan.ok_or(Problem::NoSamples("headings or comments"))
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
                header: name.clone(),
                name,
                unit,
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
        if count > MAX_COLUMNS {
            return Err(Problem::TooManyColumns {
                have: count,
                most: MAX_COLUMNS,
            });
        }
        let named = |field: usize| {
            let header = *names.as_ref().and_then(|n| n.get(field)).unwrap_or(&"");
            let (name, own_unit) = units::split(header);
            let unit = units_row.as_ref().and_then(|u| bracketed(u.get(field)?));
            Named {
                field,
                header: header.to_owned(),
                name: name.to_owned(),
                unit: unit.unwrap_or(own_unit).to_owned(),
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
            return Err(Problem::Ragged { line, have, need });
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
        [(_, names), (line, row), ..] => Err(Problem::NotANumber {
            line: *line,
            column: fields(names).first().copied().unwrap_or("").to_owned(),
            text: shortened(fields(row).first().copied().unwrap_or("")),
        }),
    }
}

/// Statistics of a column from the first pass.
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

impl Default for ColumnStatistics {
    fn default() -> Self {
        Self {
            count: 0,
            fault: None,
            first: f64::NAN,
            largest: 0.0,
            is_row_index: true,
            decimals: 0,
            digits: 0,
        }
    }
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
