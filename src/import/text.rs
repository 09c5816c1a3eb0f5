//! Columns of numbers as text: CSV and similar formats.
//!
//! The separator is detected from the first row of numbers: `;`, else a tab, else `,`, else blanks. A comma within a
//! field is a decimal point. What stands above the numbers is read by the module `preamble`. Lines that start with `#`
//! are comments. An empty field is a missing sample.
//!
//! The first rows determine the columns and which of them is the time. One pass through the text then reads the times and
//! the selected column, which are stored.

use std::io::{BufRead, Seek};
use std::ops::Range;
use std::sync::Arc;

use super::clock::{Timing, Uniform, uniform};
use super::lines::{each_line, number, separator_of, split_row};
use super::preamble::{Preamble, is_comment, is_row_of_numbers, widths};
use super::table::{Buffer, ColumnHeader, Source, check_column_count};
use super::{Problem, units};
use crate::memory;

/// A text whose columns are known.
pub(super) struct Text<R> {
    content: R,
    /// Number of lines before the preamble.
    skipped: u64,
    /// Number of the line with the first row of numbers.
    first: u64,
    rows: Rows,
    /// Field and heading of each column, without the times.
    columns: Vec<(usize, ColumnHeader)>,
    /// Field of the time column, its name, and its unit, s.
    time: Option<(usize, ColumnHeader, f64)>,
    /// Clock that the preamble states.
    clock: Option<Uniform>,
    /// Samples of the column whose clock was read last.
    samples: Vec<f64>,
}

/// Rows of numbers.
struct Rows {
    separator: char,
    /// Number of fields.
    width: usize,
}

impl Rows {
    /// The fields of a row; trailing separators are no columns.
    fn fields<'a>(&self, line: u64, row: &'a str) -> Result<Vec<&'a str>, Problem> {
        let fields: Vec<_> = split_row(self.separator, row).collect();
        let (have, need) = (fields.len(), self.width);
        if have < need || fields[need..].iter().any(|field| !field.is_empty()) {
            return Err(Problem::Content(format!(
                "line {line} has {have} fields instead of {need}; complete or remove it"
            )));
        }
        Ok(fields)
    }
}

impl<R: BufRead + Seek> Text<R> {
    /// Opens a text without its first `skipped` lines. `stem` is the name of a single column.
    pub fn open(mut content: R, stem: &str, skipped: u64) -> Result<Self, Problem> {
        let (preamble, lines) = Preamble::of(&mut content, skipped)?;
        let rows = lines
            .iter()
            .filter(|(line, row)| *line > preamble.last && !is_comment(row));
        let rows: Vec<_> = rows
            .skip_while(|(_, row)| !is_row_of_numbers(row))
            .collect();
        let Some((first, row)) = rows.first() else {
            return Err(Problem::NoNumbers);
        };
        let separator = separator_of(row);
        let (given, have) = widths(separator, row);
        // A trailing separator in each row is not a column, unless it has a name.
        let width = if preamble.is_heading {
            have.min(given.max(preamble.columns.len()))
        } else {
            given
        };
        check_column_count(width)?;
        let fields = split_row(separator, row).enumerate();
        let fields = fields.take(width).skip(preamble.beside);
        // Columns of words are ignored.
        let columns = fields.filter(|(_, text)| text.is_empty() || number(text).is_some());
        let heading = |field: usize| preamble.columns.get(field).cloned().unwrap_or_default();
        let mut text = Self {
            content,
            skipped,
            first: *first,
            rows: Rows { separator, width },
            columns: columns.map(|(field, _)| (field, heading(field))).collect(),
            time: None,
            clock: preamble.clock,
            samples: Vec::new(),
        };
        let rows = rows.iter().map(|(line, row)| text.rows.fields(*line, row));
        let rows: Vec<_> = rows.collect::<Result<_, _>>()?;
        text.find_time(&rows);
        let is_lone = text.columns.len() == 1;
        for (place, (_, heading)) in text.columns.iter_mut().enumerate() {
            if heading.header.is_empty() {
                heading.name = if is_lone {
                    stem.to_owned()
                } else {
                    place.to_string()
                };
                heading.header.clone_from(&heading.name);
            }
        }
        Ok(text)
    }

    /// Removes the time column from the columns, if there is one, or one that counts the rows. Without a clock the first
    /// column is the time if it increases uniformly in the first rows.
    fn find_time(&mut self, rows: &[Vec<&str>]) {
        if self.columns.len() < 2 {
            return;
        }
        let second = |(_, c): &(usize, ColumnHeader)| {
            units::seconds(&c.unit).filter(|_| units::is_time(&c.name))
        };
        let mut seconds = self.columns.iter().map(second).enumerate();
        let mut time = seconds.find_map(|(place, second)| Some((place, second?)));
        if time.is_none() {
            let field = self.columns[0].0;
            let mut digits = Digits::default();
            let take = |row: &Vec<&str>| digits.take(row[field]).unwrap_or(f64::NAN);
            let values: Vec<f64> = rows.iter().map(take).collect();
            let mut counted = values.iter().zip(0_u32..);
            if [0.0, 1.0].contains(&values[0])
                && counted.all(|(value, k)| *value == values[0] + f64::from(k))
            {
                self.columns.remove(0);
            } else if self.clock.is_none() && uniform(&values, digits.resolution(), 0.0).is_ok() {
                time = Some((0, 1.0));
            }
        }
        self.time = time.map(|(place, second)| {
            let (field, heading) = self.columns.remove(place);
            (field, heading, second)
        });
    }
}

impl<R: BufRead + Seek> Source for Text<R> {
    fn headings(&self) -> Vec<ColumnHeader> {
        let headings = self.columns.iter().map(|(_, heading)| heading);
        headings.cloned().collect()
    }

    fn clock(&mut self, column: usize) -> Result<(Timing, usize), Problem> {
        let (field, heading) = &self.columns[column];
        let (mut times, mut samples) = (Vec::new(), Vec::new());
        let mut digits = Digits::default();
        each_line(&mut self.content, self.skipped, |line, text| {
            if line < self.first || is_comment(text) {
                return Ok(true);
            }
            let fields = self.rows.fields(line, text)?;
            let value = |field: usize, heading: &ColumnHeader| match number(fields[field]) {
                Some(value) => Ok(value),
                None if fields[field].is_empty() => Ok(f64::NAN),
                None => Err(Problem::not_a_number(line, &heading.header, fields[field])),
            };
            if let Some((field, heading, second)) = &self.time {
                push(&mut times, second * value(*field, heading)?)?;
                digits.take(fields[*field]);
            }
            push(&mut samples, value(*field, heading)?)?;
            Ok(true)
        })?;
        let timing = match (self.clock, &self.time) {
            (Some(clock), _) => Timing::Uniform(clock),
            (None, Some((.., second))) => Timing::Times {
                times: Arc::new(times),
                resolution: digits.resolution() * second,
                relative: 0.0,
            },
            (None, None) => Timing::Rate(None),
        };
        self.samples = samples;
        Ok((timing, self.samples.len()))
    }

    fn samples(
        &mut self,
        _column: usize,
        range: Range<usize>,
        into: Buffer,
    ) -> Result<(), Problem> {
        into.extend(&self.samples[range]);
        Ok(())
    }
}

/// Appends a number, if there is memory for it.
fn push(into: &mut Vec<f64>, number: f64) -> Result<(), Problem> {
    if into.len() == into.capacity() {
        let more = into.len().max(1024);
        let need = 2 * more * size_of::<f64>();
        memory::check(need as u64).map_err(|shortage| {
            Problem::Content(format!(
                "the numbers of the text do not fit into memory: {shortage}; split the file"
            ))
        })?;
        into.reserve_exact(more);
    }
    into.push(number);
    Ok(())
}

/// The digits with which the numbers of a column are written.
#[derive(Default)]
struct Digits {
    /// Largest magnitude.
    largest: f64,
    /// Largest number of decimals, minus the exponent of ten.
    decimals: i32,
    /// Largest number of significant digits.
    digits: i32,
}

impl Digits {
    /// The number in a field, whose digits then count.
    fn take(&mut self, field: &str) -> Option<f64> {
        let value = number(field)?;
        let (mantissa, exponent) = field.split_once(['e', 'E']).unwrap_or((field, "0"));
        let exponent = exponent.parse().unwrap_or(0);
        let digits = |text: &str| text.chars().filter(char::is_ascii_digit).count() as i32;
        let (_, part) = mantissa.split_once(['.', ',']).unwrap_or((mantissa, ""));
        let significant = mantissa.trim_start_matches(|c| !matches!(c, '1'..='9'));
        self.digits = self.digits.max(digits(significant));
        self.decimals = self.decimals.max(digits(part) - exponent);
        self.largest = self.largest.max(value.abs());
        Some(value)
    }

    /// Uncertainty of a value due to its number of digits.
    ///
    /// Programs write a fixed number of either decimals or significant digits.
    fn resolution(&self) -> f64 {
        let in_all = self.largest * 10.0_f64.powi(1 - self.digits);
        in_all.max(10.0_f64.powi(-self.decimals))
    }
}
