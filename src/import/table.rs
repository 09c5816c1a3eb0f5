//! Columns of samples with one clock, and the one that is asked for.

use super::{Clock, Problem, Selection, Signal};

/// The largest sample: a sum of the squares of all of them is still a number.
const LARGEST: f64 = 1e150;

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
    /// clock is missing or not uniform, if the stretch is not in the file, or if a sample in it is
    /// not finite.
    pub fn signal(mut self, selection: &Selection) -> Result<Signal, Problem> {
        let place = self.place(selection.column.as_deref())?;
        let column = self.columns.swap_remove(place);
        if let Clock::Times { times, .. } = &self.clock
            && times.len() != column.values.len()
        {
            return Err(Problem::UnevenTimes {
                column: column.name,
                times: times.len(),
                samples: column.values.len(),
            });
        }
        let (rate, start) = self.clock.rate_and_start(selection.rate)?;
        let stretch = stretch(selection, rate, start, column.values.len())?;
        let time = |index: usize| start + index as f64 / rate;
        let samples = column.values[stretch.clone()].to_vec();
        if let Some(bad) = samples.iter().position(|value| !value.is_finite()) {
            let index = stretch.start + bad;
            return Err(Problem::NotFinite {
                index,
                time: time(index),
                column: column.name,
                value: samples[bad],
            });
        }
        if let Some(bad) = samples.iter().position(|value| value.abs() > LARGEST) {
            let index = stretch.start + bad;
            return Err(Problem::TooLarge {
                index,
                time: time(index),
                column: column.name,
                value: samples[bad],
            });
        }
        Ok(Signal {
            name: column.name,
            unit: column.unit,
            rate,
            start: time(stretch.start),
            samples,
        })
    }

    /// Which column is asked for: by its whole header, by its name, or by its place from 0.
    fn place(&self, asked: Option<&str>) -> Result<usize, Problem> {
        let headers = || self.columns.iter().map(|c| c.header.clone()).collect();
        let Some(asked) = asked else {
            return match self.columns.len() {
                1 => Ok(0),
                _ => Err(Problem::ChooseColumn { columns: headers() }),
            };
        };
        let by_header = self.columns.iter().position(|c| c.header == asked);
        let by_name = || self.columns.iter().position(|c| c.name == asked);
        let by_place = || {
            let place = asked.parse::<usize>().ok();
            place.filter(|&place| place < self.columns.len())
        };
        by_header
            .or_else(by_name)
            .or_else(by_place)
            .ok_or_else(|| Problem::NoSuchColumn {
                asked: asked.to_owned(),
                columns: headers(),
            })
    }
}

/// The samples from `from` on, up to but without `to`.
fn stretch(
    selection: &Selection,
    rate: f64,
    start: f64,
    count: usize,
) -> Result<std::ops::Range<usize>, Problem> {
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
