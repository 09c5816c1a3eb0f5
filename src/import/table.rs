//! Columns of samples with a common clock, and the selected one.

use std::ops::Range;

use super::clock::Timing;
use super::{Clock, MAX_SAMPLES, Problem, Selection, Signal, units};
use crate::memory;

/// Maximum magnitude of a sample: the sum of the squares of all samples does not overflow.
const MAX_MAGNITUDE: f64 = 1e150;

/// Maximum number of columns, as in a spreadsheet.
pub(super) const MAX_COLUMNS: usize = 16_384;

/// Named samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name as in the file.
    pub header: String,
    /// Name without the unit.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// The samples.
    pub values: Vec<f64>,
}

impl Column {
    /// A column whose name does not contain its unit.
    pub fn new(name: impl Into<String>, unit: &str, values: Vec<f64>) -> Self {
        let name = name.into();
        Self {
            header: name.clone(),
            name,
            unit: unit.to_owned(),
            values,
        }
    }
}

/// Content of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Signals, without the times.
    pub columns: Vec<Column>,
    /// Times of the samples.
    pub clock: Clock,
}

/// Resolution of time in a recording, s.
const NANOSECOND: f64 = 1e-9;

impl Table {
    /// The series of a recording, with times (s) and values, as a table of one column.
    pub fn of_series(name: String, unit: &str, times: Vec<f64>, values: Vec<f64>) -> Self {
        Self {
            columns: vec![Column::new(name, unit, values)],
            clock: Clock::Times {
                times,
                resolution: NANOSECOND,
            },
        }
    }

    /// The selected signal.
    ///
    /// # Errors
    /// If there are several columns and none is selected, the selected one does not exist, the clock is
    /// missing or not uniform, the time range is outside the file or too long, or a sample in it is not
    /// finite.
    pub fn signal(mut self, selection: &Selection) -> Result<Signal, Problem> {
        let choice = Choice::new(&mut self, selection)?;
        let mut samples = self.columns.swap_remove(choice.column).values;
        samples.truncate(choice.range.end);
        samples.drain(..choice.range.start);
        choice.signal(samples)
    }
}

impl Source for Table {
    fn headings(&self) -> Vec<ColumnHeader> {
        let heading = |column: &Column| ColumnHeader {
            header: column.header.clone(),
            name: column.name.clone(),
            unit: column.unit.clone(),
            count: column.values.len(),
        };
        self.columns.iter().map(heading).collect()
    }

    fn timing(&self) -> Timing {
        match &self.clock {
            Clock::Unknown => Timing::Unknown,
            Clock::Rate(rate) => Timing::Rate(*rate),
            Clock::Times { times, resolution } => Timing::Times {
                count: times.len(),
                resolution: *resolution,
                relative: 0.0,
            },
        }
    }

    fn times(&mut self, each: &mut dyn FnMut(f64)) -> Result<(), Problem> {
        if let Clock::Times { times, .. } = &self.clock {
            times.iter().for_each(|time| each(*time));
        }
        Ok(())
    }

    fn samples(
        &mut self,
        column: usize,
        range: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        self.columns[column].values[range]
            .iter()
            .for_each(|x| each(*x));
        Ok(())
    }
}

/// Properties of a column that are known before its samples are read.
pub(super) struct ColumnHeader {
    /// Name as in the file.
    pub header: String,
    /// Name without the unit.
    pub name: String,
    /// Unit, empty if unknown.
    pub unit: String,
    /// Number of samples.
    pub count: usize,
}

impl ColumnHeader {
    /// ColumnHeader of a column whose name may contain the unit.
    pub fn new(header: String, count: usize) -> Self {
        let (name, unit) = units::split(&header);
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            header,
            count,
        }
    }
}

/// Columns whose samples and times are read only on request.
pub(super) trait Source {
    /// Headings of the columns, without the times.
    fn headings(&self) -> Vec<ColumnHeader>;

    /// Time information.
    fn timing(&self) -> Timing;

    /// Calls `each` for the time of each sample (s), if the file contains times; by default it does nothing.
    fn times(&mut self, _each: &mut dyn FnMut(f64)) -> Result<(), Problem> {
        Ok(())
    }

    /// Calls `each` for some samples of a column, counted from 0.
    fn samples(
        &mut self,
        column: usize,
        range: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem>;
}

/// Reads the selected signal; only its samples are stored.
pub(super) fn read(source: &mut dyn Source, selection: &Selection) -> Result<Signal, Problem> {
    let choice = Choice::new(source, selection)?;
    let range = choice.range.clone();
    let samples = memory::allocate(range.len());
    let mut samples = samples.map_err(|shortage| Problem::Memory {
        samples: range.len(),
        shortage,
    })?;
    source.samples(choice.column, range, &mut |x| samples.push(x))?;
    choice.signal(samples)
}

/// The selected part of a source.
struct Choice {
    heading: ColumnHeader,
    column: usize,
    rate: f64,
    start: f64,
    range: Range<usize>,
}

impl Choice {
    fn new(source: &mut dyn Source, selection: &Selection) -> Result<Self, Problem> {
        let mut headings = source.headings();
        let column = find_column(&headings, selection.column.as_deref())?;
        let heading = headings.swap_remove(column);
        let timing = source.timing();
        if let Timing::Times { count, .. } = timing
            && count != heading.count
        {
            return Err(Problem::CountMismatch {
                column: heading.name,
                times: count,
                samples: heading.count,
            });
        }
        let (rate, start) =
            timing.rate_and_start(selection.rate, &mut |each| source.times(each))?;
        let range = range(selection, rate, start, heading.count)?;
        let most = selection.max_samples.unwrap_or(MAX_SAMPLES);
        if range.len() > most {
            let have = range.len();
            return Err(Problem::TooManySamples { have, most });
        }
        Ok(Self {
            heading,
            column,
            rate,
            start,
            range,
        })
    }

    /// Checks the samples and returns the signal.
    fn signal(self, samples: Vec<f64>) -> Result<Signal, Problem> {
        if samples.len() != self.range.len() {
            return Err(Problem::Changed);
        }
        let time = |index: usize| self.start + index as f64 / self.rate;
        if let Some(bad) = samples.iter().position(|value| !value.is_finite()) {
            let index = self.range.start + bad;
            return Err(Problem::NotFinite {
                index,
                time: time(index),
                column: self.heading.name,
                value: samples[bad],
            });
        }
        if let Some(bad) = samples.iter().position(|value| value.abs() > MAX_MAGNITUDE) {
            let index = self.range.start + bad;
            return Err(Problem::TooLarge {
                index,
                time: time(index),
                column: self.heading.name,
                value: samples[bad],
            });
        }
        Ok(Signal {
            start: time(self.range.start),
            name: self.heading.name,
            unit: self.heading.unit,
            rate: self.rate,
            samples,
        })
    }
}

/// Index of the selected column: by its full header, by its name, or by its index from 0.
fn find_column(headings: &[ColumnHeader], asked: Option<&str>) -> Result<usize, Problem> {
    let headers = || headings.iter().map(|c| c.header.clone()).collect();
    let Some(asked) = asked else {
        return match headings.len() {
            1 => Ok(0),
            _ => Err(Problem::ChooseColumn { columns: headers() }),
        };
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
        .ok_or_else(|| Problem::NoSuchColumn {
            asked: asked.to_owned(),
            columns: headers(),
        })
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
    let (from, to) = (
        selection.from.unwrap_or(first),
        selection.to.unwrap_or(last),
    );
    for (option, asked) in [("--from", selection.from), ("--to", selection.to)] {
        let Some(asked) = asked else { continue };
        let slack = ROUNDING / rate;
        if !(first - slack <= asked && asked <= last + slack) {
            return Err(Problem::Outside {
                option,
                asked,
                first,
                last,
            });
        }
    }
    if index(from) >= index(to) {
        return Err(Problem::EmptyRange {
            from,
            to,
            first,
            last,
        });
    }
    Ok(index(from)..index(to))
}
