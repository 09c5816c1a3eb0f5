//! Columns of samples with one clock, and the one that is asked for.

use std::ops::Range;

use super::clock::Timing;
use super::{Clock, MAX_SAMPLES, Problem, Selection, Signal, units};
use crate::memory;

/// The largest sample: a sum of the squares of all of them is still a number.
const LARGEST: f64 = 1e150;

/// The most columns that are told apart, as many as a sheet of a spreadsheet has.
pub(super) const MOST_COLUMNS: usize = 16_384;

/// Samples under a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name as the file has it.
    pub header: String,
    /// Its name without the unit.
    pub name: String,
    /// Its unit, empty if unknown.
    pub unit: String,
    /// The samples.
    pub values: Vec<f64>,
}

impl Column {
    /// A column whose name says nothing of its unit.
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

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The signals, the times not among them.
    pub columns: Vec<Column>,
    /// Their times.
    pub clock: Clock,
}

impl Table {
    /// The signal that is asked for.
    ///
    /// # Errors
    /// If there are several columns and none is chosen, or the one chosen is not there, if the
    /// clock is missing or not uniform, if the stretch is not in the file or too long, or if a sample in
    /// it is not finite.
    pub fn signal(mut self, selection: &Selection) -> Result<Signal, Problem> {
        let choice = Choice::new(&mut self, selection)?;
        let mut samples = self.columns.swap_remove(choice.column).values;
        samples.truncate(choice.stretch.end);
        samples.drain(..choice.stretch.start);
        choice.signal(samples)
    }
}

impl Source for Table {
    fn headings(&self) -> Vec<Heading> {
        let heading = |column: &Column| Heading {
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
        stretch: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem> {
        self.columns[column].values[stretch]
            .iter()
            .for_each(|x| each(*x));
        Ok(())
    }
}

/// What is known of a column before its samples are read.
pub(super) struct Heading {
    /// Its name as the file has it.
    pub header: String,
    /// Its name without the unit.
    pub name: String,
    /// Its unit, empty if unknown.
    pub unit: String,
    /// How many samples it has.
    pub count: usize,
}

impl Heading {
    /// That of a column whose name may have the unit in it.
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

/// Columns whose samples and times are read when they are asked for, and only then held.
pub(super) trait Source {
    /// The columns, the times not among them.
    fn headings(&self) -> Vec<Heading>;

    /// What is said of the times.
    fn timing(&self) -> Timing;

    /// Calls `each` for the time of each sample (s), where the file states them; by default it does not.
    fn times(&mut self, _each: &mut dyn FnMut(f64)) -> Result<(), Problem> {
        Ok(())
    }

    /// Calls `each` for some samples of a column, counted from 0.
    fn samples(
        &mut self,
        column: usize,
        stretch: Range<usize>,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Problem>;
}

/// Reads the signal that is asked for; nothing but its samples is held.
pub(super) fn read(source: &mut dyn Source, selection: &Selection) -> Result<Signal, Problem> {
    let choice = Choice::new(source, selection)?;
    let stretch = choice.stretch.clone();
    let samples = memory::room(stretch.len());
    let mut samples = samples.map_err(|shortage| Problem::Memory {
        samples: stretch.len(),
        shortage,
    })?;
    source.samples(choice.column, stretch, &mut |x| samples.push(x))?;
    choice.signal(samples)
}

/// What of a source is the signal.
struct Choice {
    heading: Heading,
    column: usize,
    rate: f64,
    start: f64,
    stretch: Range<usize>,
}

impl Choice {
    fn new(source: &mut dyn Source, selection: &Selection) -> Result<Self, Problem> {
        let mut headings = source.headings();
        let column = place(&headings, selection.column.as_deref())?;
        let heading = headings.swap_remove(column);
        let timing = source.timing();
        if let Timing::Times { count, .. } = timing
            && count != heading.count
        {
            return Err(Problem::UnevenTimes {
                column: heading.name,
                times: count,
                samples: heading.count,
            });
        }
        let (rate, start) =
            timing.rate_and_start(selection.rate, &mut |each| source.times(each))?;
        let stretch = stretch(selection, rate, start, heading.count)?;
        let most = selection.max_samples.unwrap_or(MAX_SAMPLES);
        if stretch.len() > most {
            let have = stretch.len();
            return Err(Problem::TooManySamples { have, most });
        }
        Ok(Self {
            heading,
            column,
            rate,
            start,
            stretch,
        })
    }

    /// The signal of these samples, if they can be analysed.
    fn signal(self, samples: Vec<f64>) -> Result<Signal, Problem> {
        if samples.len() != self.stretch.len() {
            return Err(Problem::Changed);
        }
        let time = |index: usize| self.start + index as f64 / self.rate;
        if let Some(bad) = samples.iter().position(|value| !value.is_finite()) {
            let index = self.stretch.start + bad;
            return Err(Problem::NotFinite {
                index,
                time: time(index),
                column: self.heading.name,
                value: samples[bad],
            });
        }
        if let Some(bad) = samples.iter().position(|value| value.abs() > LARGEST) {
            let index = self.stretch.start + bad;
            return Err(Problem::TooLarge {
                index,
                time: time(index),
                column: self.heading.name,
                value: samples[bad],
            });
        }
        Ok(Signal {
            start: time(self.stretch.start),
            name: self.heading.name,
            unit: self.heading.unit,
            rate: self.rate,
            samples,
        })
    }
}

/// Which column is asked for: by its whole header, by its name, or by its place from 0.
fn place(headings: &[Heading], asked: Option<&str>) -> Result<usize, Problem> {
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

/// The samples from `from` on, up to but without `to`.
fn stretch(
    selection: &Selection,
    rate: f64,
    start: f64,
    count: usize,
) -> Result<Range<usize>, Problem> {
    /// A time this share of a spacing before a sample is still that of the sample.
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
        return Err(Problem::Backwards {
            from,
            to,
            first,
            last,
        });
    }
    Ok(index(from)..index(to))
}
