//! Columns of samples with a common clock, and the selected one.

use std::ops::Range;
use std::sync::Arc;

use super::clock::Timing;
use super::{MAX_SAMPLES, Problem, Selection, Signal, units};
use crate::memory;

/// Maximum magnitude of a sample: the sum of the squares of all samples does not overflow.
const MAX_MAGNITUDE: f64 = 1e150;

/// Maximum number of columns, as in a spreadsheet.
pub(super) const MAX_COLUMNS: usize = 16_384;

/// Columns of samples, in memory.
#[derive(Default)]
pub struct Table {
    pub(super) columns: Vec<Column>,
    /// What of the content is left out, and why.
    pub(super) damage: Option<String>,
}

/// A column with its clock.
pub(super) struct Column {
    pub header: ColumnHeader,
    pub timing: Timing,
    pub samples: Vec<f64>,
}

/// Resolution of time in a recording, s.
const NANOSECOND: f64 = 1e-9;

impl Table {
    /// The series of a recording, with times (s) and values, as a table of one column.
    pub fn of_series(name: String, unit: &str, times: Vec<f64>, values: Vec<f64>) -> Self {
        let column = Column {
            header: ColumnHeader::with_unit(name, unit),
            timing: Timing::Times {
                times: Arc::new(times),
                resolution: NANOSECOND,
                relative: 0.0,
            },
            samples: values,
        };
        Self {
            columns: vec![column],
            damage: None,
        }
    }

    /// The selected signal.
    ///
    /// # Errors
    /// If there are several columns and none is selected, the selected one does not exist, the clock is
    /// missing or not uniform, the time range is outside the file or too long, or a sample in it is not
    /// finite.
    pub fn signal(mut self, selection: &Selection) -> Result<Signal, Problem> {
        read(&mut self, selection)
    }
}

impl Source for Table {
    fn headings(&self) -> Vec<ColumnHeader> {
        let columns = self.columns.iter();
        columns.map(|column| column.header.clone()).collect()
    }

    fn clock(&mut self, column: usize) -> Result<(Timing, usize), Problem> {
        let column = &self.columns[column];
        Ok((column.timing.clone(), column.samples.len()))
    }

    fn samples(&mut self, column: usize, range: Range<usize>, into: Buffer) -> Result<(), Problem> {
        into.extend(&self.columns[column].samples[range]);
        Ok(())
    }

    fn damage(&self) -> Option<&str> {
        self.damage.as_deref()
    }
}

/// Names and unit of a column.
#[derive(Clone, Default)]
pub(super) struct ColumnHeader {
    /// Name as in the file.
    pub header: String,
    /// Name without the unit.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
}

impl ColumnHeader {
    /// The header of a column whose name does not contain the unit.
    pub fn with_unit(name: String, unit: &str) -> Self {
        Self {
            header: name.clone(),
            name,
            unit: unit.to_owned(),
        }
    }

    /// The header of a column whose name may contain the unit.
    pub fn new(header: String) -> Self {
        let (name, unit) = units::split(&header);
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            header,
        }
    }
}

/// Takes the samples of a column.
pub(super) type Buffer<'a> = &'a mut Vec<f64>;

/// Columns whose samples and times are read only on request.
pub(super) trait Source {
    /// Headings of the columns, without the times.
    fn headings(&self) -> Vec<ColumnHeader>;

    /// Times and number of samples of a column, counted from 0.
    fn clock(&mut self, column: usize) -> Result<(Timing, usize), Problem>;

    /// Appends some samples of the column whose clock was read last.
    fn samples(&mut self, column: usize, range: Range<usize>, into: Buffer) -> Result<(), Problem>;

    /// What is wrong with the file, of which the samples before the damage are read.
    fn damage(&self) -> Option<&str> {
        None
    }
}

/// Reads the selected signal; only its samples are stored, and those of a text with their times.
pub(super) fn read(source: &mut dyn Source, selection: &Selection) -> Result<Signal, Problem> {
    let mut headings = source.headings();
    let column = find_column(&headings, selection.column.as_deref())?;
    let heading = headings.swap_remove(column);
    let (timing, count) = source.clock(column)?;
    if let Timing::Times { times, .. } = &timing
        && times.len() != count
    {
        return Err(Problem::Content(format!(
            "{} times for {count} samples of `{}`; export the file again",
            times.len(),
            heading.name
        )));
    }
    let (rate, start) = timing.rate_and_start(selection.rate)?;
    let range = range(selection, rate, start, count)?;
    let (have, most) = (range.len(), selection.max_samples.unwrap_or(MAX_SAMPLES));
    if have > most {
        return Err(Problem::Content(format!(
            "the selection has {have} samples, more than the limit of {most}; select a shorter part with --from and \
             --to, or raise the limit with --max-samples"
        )));
    }
    let mut samples = memory::allocate(have).map_err(|shortage| {
        Problem::Content(format!(
            "the {have} selected samples do not fit into memory: {shortage}; select a shorter part with --from and --to"
        ))
    })?;
    source.samples(column, range.clone(), &mut samples)?;
    if samples.len() != have {
        return Err(Problem::changed());
    }
    let time = |index: usize| start + index as f64 / rate;
    let is_invalid = |x: &f64| !x.is_finite() || x.abs() > MAX_MAGNITUDE;
    if let Some(bad) = samples.iter().position(is_invalid) {
        let index = range.start + bad;
        return Err(Problem::Content(format!(
            "sample {index} (at {} s) of `{}` is {:e}; samples are finite numbers below 1e150: exclude it with --from \
             and --to, or correct it",
            time(index),
            heading.name,
            samples[bad]
        )));
    }
    Ok(Signal {
        start: time(range.start),
        name: heading.name,
        unit: heading.unit,
        rate,
        samples,
    })
}

/// Checks the number of columns of a file.
pub(super) fn check_column_count(have: usize) -> Result<(), Problem> {
    if have > MAX_COLUMNS {
        return Err(Problem::Content(format!(
            "the file has {have} columns; the maximum is {MAX_COLUMNS}; save fewer"
        )));
    }
    Ok(())
}

/// Index of the selected column: by its full header, by its name, or by its index from 0.
fn find_column(headings: &[ColumnHeader], asked: Option<&str>) -> Result<usize, Problem> {
    let refused = |reason: &str| Problem::Content(format!("{reason}: {}", listed(headings)));
    let Some(asked) = asked else {
        if headings.len() == 1 {
            return Ok(0);
        }
        let several = "the file has several columns; choose one with --column";
        return Err(refused(several));
    };
    let by_header = headings.iter().position(|c| c.header == asked);
    let by_name = || headings.iter().position(|c| c.name == asked);
    let by_place = || {
        let place = asked.parse::<usize>().ok();
        place.filter(|&place| place < headings.len())
    };
    by_header
        .or_else(by_name)
        .or_else(by_place)
        .ok_or_else(|| refused(&format!("there is no column `{asked}`; choose one of")))
}

/// Headers separated by commas; a long list is shortened.
fn listed(headings: &[ColumnHeader]) -> String {
    const SHOWN: usize = 16;
    let shown = headings.iter().take(SHOWN);
    let text = shown.map(|c| &*c.header).collect::<Vec<_>>().join(", ");
    match headings.len().saturating_sub(SHOWN) {
        0 => text,
        more => format!("{text} and {more} more"),
    }
}

/// Indices of the samples at or after `from` and before `to`.
fn range(
    selection: &Selection,
    rate: f64,
    start: f64,
    count: usize,
) -> Result<Range<usize>, Problem> {
    /// Tolerance in sample spacings: a time just before a sample still selects it.
    const ROUNDING: f64 = 1e-6;

    let (first, last) = (start, start + count as f64 / rate);
    let index =
        |time: f64| (((time - start) * rate - ROUNDING).ceil().max(0.0) as usize).min(count);
    let from = selection.from.unwrap_or(first);
    let to = selection.to.unwrap_or(last);
    let slack = ROUNDING / rate;
    for (option, asked) in [("--from", from), ("--to", to)] {
        if !(first - slack <= asked && asked <= last + slack) {
            return Err(Problem::Content(format!(
                "{option} {asked} s is outside the file, which extends from {first} to {last} s"
            )));
        }
    }
    if index(from) >= index(to) {
        return Err(Problem::Content(format!(
            "--from {from} s is not before --to {to} s; give a range within the file, from {first} to {last} s"
        )));
    }
    Ok(index(from)..index(to))
}
