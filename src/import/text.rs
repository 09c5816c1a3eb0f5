//! Columns of numbers as text: CSV and similar formats.
//!
//! The separator is detected from the first row of numbers: `;`, else a tab, else `,`, else blanks. A comma within a
//! field is a decimal point. What stands above the numbers is read by the module `preamble`. Lines that start with `#`
//! are comments. An empty field is a missing sample.
//!
//! The first pass through the text finds columns, rows and digits. Later passes read the times and the
//! selected samples. No column is stored.

use std::io::{BufRead, Seek};
use std::ops::Range;

use super::clock::{Timing, uniform};
use super::lines::{Separator, each_line, number};
use super::preamble::{Preamble, is_comment, is_row_of_numbers, widths};
use super::table::{ColumnHeader, Each, Source, check_column_count};
use super::{Problem, units};

/// A text whose columns are known.
pub(super) struct Text<R> {
    content: R,
    /// Number of lines before the preamble.
    skipped: u64,
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
    /// Opens a text without its first `skipped` lines.
    pub fn open(mut content: R, stem: &str, skipped: u64) -> Result<Self, Problem> {
        let preamble = Preamble::of(&mut content, skipped)?;
        let mut scan = Scan::of(&mut content, skipped, &preamble)?;
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
            skipped,
            scan,
            time: None,
            timing: Timing::Unknown,
            stem: stem.to_owned(),
        };
        if text.scan.columns.len() > 1 {
            text.find_time(preamble.clock.is_some());
        }
        if let Some(clock) = preamble.clock {
            text.timing = Timing::Uniform(clock);
        }
        Ok(text)
    }

    /// Removes the time column from the columns, if there is one. Without a clock it may have no name.
    fn find_time(&mut self, has_clock: bool) {
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
        } else if !has_clock {
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
        each_line(&mut self.content, self.skipped, |line, text| {
            if line < first || is_comment(text) {
                return Ok(true);
            }
            if rows.contains(&row) {
                let field = separator.fields(text).nth(field);
                each(field.and_then(number).unwrap_or(f64::NAN));
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

    fn times(&mut self, each: Each) -> Result<(), Problem> {
        let Some((field, second)) = self.time else {
            return Ok(());
        };
        self.values(field, 0..self.scan.rows, &mut |time| each(time * second))
    }

    fn samples(&mut self, column: usize, range: Range<usize>, each: Each) -> Result<(), Problem> {
        self.values(self.scan.columns[column].field, range, each)
    }
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
    fn of(
        content: &mut (impl BufRead + Seek),
        skipped: u64,
        preamble: &Preamble,
    ) -> Result<Self, Problem> {
        let mut scan: Option<Self> = None;
        each_line(content, skipped, |line, text| {
            match &mut scan {
                _ if line <= preamble.last || is_comment(text) => {}
                Some(scan) => scan.take(line, text)?,
                None if is_row_of_numbers(text) => {
                    let begun = Self::begin(line, text, preamble)?;
                    scan.insert(begun).take(line, text)?;
                }
                None => {}
            }
            Ok(true)
        })?;
        scan.ok_or_else(|| Problem::no_samples("headings or comments"))
    }

    /// The columns of the first row of numbers, with the names and units of a preamble.
    fn begin(first: u64, row: &str, preamble: &Preamble) -> Result<Self, Problem> {
        let separator = Separator::of(row);
        let (given, have) = widths(separator, row);
        // A trailing separator in each row is not a column, unless it has a name.
        let count = if preamble.is_heading {
            have.min(given.max(preamble.columns.len()))
        } else {
            given
        };
        check_column_count(count)?;
        let named = |field: usize| {
            let heading = preamble.columns.get(field).cloned();
            Named {
                field,
                heading: heading.unwrap_or_else(|| ColumnHeader::new(String::new(), 0)),
                seen: ColumnStatistics::default(),
            }
        };
        Ok(Self {
            separator,
            first,
            rows: 0,
            columns: (preamble.beside..count).map(named).collect(),
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
                column.seen.take(field, line);
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
    fn take(&mut self, field: &str, line: u64) {
        if self.fault.is_some() {
            return;
        }
        let number = number(field);
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

/// Start of a text, for a message.
pub(super) fn shortened(text: &str) -> String {
    const MOST: usize = 30;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
