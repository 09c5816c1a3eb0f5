//! Columns of numbers as text: CSV and its relatives.
//!
//! What parts the fields is told from the first row of numbers: `;`, else a tab, else `,`, else
//! blanks. Where commas do not part fields they may stand for the decimal point. A row above the
//! numbers names the columns; a second one, all in brackets, gives their units. Lines that begin
//! with `#` are remarks; the last one before the numbers names the columns if nothing else does
//! and it has as many fields (as `numpy.savetxt` writes it). An empty field is a missing sample.

use super::{Clock, Column, Problem, Table, clock, units};

/// All columns of a text.
pub(super) fn decode(bytes: &[u8], stem: &str) -> Result<Table, Problem> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let lines = || {
        (1..)
            .zip(text.lines())
            .filter(|(_, l)| !l.trim().is_empty())
    };
    let rows = || lines().filter(|(_, line)| !line.starts_with('#'));
    let (number, sample) = rows()
        .find(|(_, line)| is_row_of_numbers(line))
        .ok_or(Problem::NoSamples("headings or remarks"))?;
    let separator = Separator::of(sample);
    let mut count = separator.fields(sample).len();
    let above: Vec<_> = rows().take_while(|(line, _)| *line < number).collect();
    let (names, units_row) = headings(&above, separator)?;
    let names = names.or_else(|| {
        let (_, remark) = lines().take_while(|(line, _)| *line < number).last()?;
        let names = separator.fields(remark.strip_prefix('#')?.trim());
        (names.len() == count && count > 1).then_some(names)
    });
    // A separator too many at the end of each row makes no column.
    let ends_empty = |fields: &[&str]| fields.last() == Some(&"");
    if ends_empty(&separator.fields(sample)) && names.as_deref().is_none_or(ends_empty) {
        count -= 1;
    }
    let mut columns: Vec<Reading> = Vec::new();
    columns.resize_with(count, Reading::default);
    for (line, row) in rows().skip_while(|(line, _)| *line < number) {
        let fields = separator.fields(row);
        let surplus = fields.len() == count + 1 && ends_empty(&fields);
        if fields.len() != count && !surplus {
            return Err(Problem::Ragged {
                line,
                have: fields.len(),
                need: count,
            });
        }
        for (column, field) in columns.iter_mut().zip(fields) {
            column.take(field, line, separator);
        }
    }
    let named = columns.into_iter().enumerate().map(|(place, reading)| {
        let header = *names.as_ref().and_then(|n| n.get(place)).unwrap_or(&"");
        let (name, own_unit) = units::split(header);
        let unit = units_row.as_ref().and_then(|u| bracketed(u.get(place)?));
        Named {
            header: header.to_owned(),
            name: name.to_owned(),
            unit: unit.unwrap_or(own_unit).to_owned(),
            reading,
        }
    });
    table(named.collect(), stem)
}

/// What parts the fields of a row.
#[derive(Clone, Copy, PartialEq)]
enum Separator {
    Character(char),
    Blanks,
}

impl Separator {
    /// What parts those of this row.
    fn of(row: &str) -> Self {
        let found = [';', '\t', ','].into_iter().find(|&c| row.contains(c));
        found.map_or(Self::Blanks, Self::Character)
    }

    /// The fields of a row, without blanks and quotation marks about them.
    fn fields(self, row: &str) -> Vec<&str> {
        let Self::Character(separator) = self else {
            return row.split_whitespace().collect();
        };
        let mut quoted = false;
        let ends = |c: char| {
            quoted ^= c == '"';
            c == separator && !quoted
        };
        row.split(ends)
            .map(|f| f.trim().trim_matches('"').trim())
            .collect()
    }

    /// The number that a field says; commas that do not part fields may be decimal points.
    fn number(self, field: &str) -> Option<f64> {
        let is_decimal = self != Self::Character(',') && !field.contains('.');
        match field.split_once(',').filter(|_| is_decimal) {
            Some((whole, part)) => format!("{whole}.{part}").parse().ok(),
            None => field.parse().ok(),
        }
    }
}

/// Whether at least half of the fields are numbers.
fn is_row_of_numbers(row: &str) -> bool {
    let separator = Separator::of(row);
    let fields = separator.fields(row).into_iter().filter(|f| !f.is_empty());
    let (numbers, words): (Vec<_>, Vec<_>) = fields.partition(|f| separator.number(f).is_some());
    !numbers.is_empty() && numbers.len() >= words.len()
}

/// The fields of a heading.
type Heading<'a> = Option<Vec<&'a str>>;

/// Names and units from the rows above the numbers.
fn headings<'a>(
    rows: &[(u64, &'a str)],
    separator: Separator,
) -> Result<(Heading<'a>, Heading<'a>), Problem> {
    let fields = |row| separator.fields(row);
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

/// A column with what its heading says.
struct Named {
    header: String,
    name: String,
    unit: String,
    reading: Reading,
}

/// Finds the time among the columns and names those without a heading.
fn table(mut columns: Vec<Named>, stem: &str) -> Result<Table, Problem> {
    // Columns of words say nothing here, as long as there are others.
    if columns.iter().any(|c| !c.reading.values.is_empty()) {
        columns.retain(|c| !c.reading.values.is_empty());
    }
    for column in &mut columns {
        if let Some((line, text)) = column.reading.fault.take() {
            return Err(Problem::NotANumber {
                line,
                column: column.header.clone(),
                text,
            });
        }
    }
    let mut clock = Clock::Unknown;
    if columns.len() > 1 {
        let second = |c: &Named| units::seconds(&c.unit).filter(|_| units::is_time(&c.name));
        let by_name = columns.iter().position(|c| second(c).is_some());
        let first = &columns[0].reading;
        if let Some(place) = by_name {
            let second = second(&columns[place]).unwrap_or(1.0);
            clock = columns.remove(place).reading.clock(second);
        } else if first.numbers_rows() {
            columns.remove(0);
        } else if clock::uniform(&first.values, first.resolution()).is_ok() {
            clock = columns.remove(0).reading.clock(1.0);
        }
    }
    let lone = columns.len() == 1;
    let named = columns.into_iter().enumerate().map(|(place, c)| {
        let name = match (c.name.is_empty(), lone) {
            (false, _) => c.name,
            (true, true) => stem.to_owned(),
            (true, false) => place.to_string(),
        };
        Column {
            header: if c.header.is_empty() {
                name.clone()
            } else {
                c.header
            },
            name,
            unit: c.unit,
            values: c.reading.values,
        }
    });
    Ok(Table {
        columns: named.collect(),
        clock,
    })
}

/// One column while it is being read.
#[derive(Default)]
struct Reading {
    values: Vec<f64>,
    /// The first field that is no number, with its line.
    fault: Option<(u64, String)>,
    /// The most digits behind the decimal point, less the exponent of ten.
    decimals: i32,
    /// The most digits that count.
    digits: i32,
}

impl Reading {
    fn take(&mut self, field: &str, line: u64, separator: Separator) {
        if self.fault.is_some() {
            return;
        }
        if field.is_empty() {
            self.values.push(f64::NAN);
        } else if let Some(value) = separator.number(field) {
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
            self.values.push(value);
        } else {
            self.fault = Some((line, shortened(field)));
        }
    }

    /// By how much a value may be off because of the digits it was written with.
    ///
    /// Programs write either so many digits behind the point or so many in all.
    fn resolution(&self) -> f64 {
        let largest = self.values.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
        let in_all = largest * 10.0_f64.powi(1 - self.digits);
        in_all.max(10.0_f64.powi(-self.decimals))
    }

    /// Whether it only counts the rows, 0, 1, 2, ... or 1, 2, 3, ...
    fn numbers_rows(&self) -> bool {
        let first = self.values[0];
        let expected = (0..).map(|k| first + f64::from(k));
        [0.0, 1.0].contains(&first) && self.values.iter().zip(expected).all(|(v, e)| *v == e)
    }

    /// As times in a unit of so many seconds.
    fn clock(self, second: f64) -> Clock {
        Clock::Times {
            resolution: self.resolution() * second,
            times: self.values.iter().map(|t| t * second).collect(),
        }
    }
}

/// What is in brackets.
fn bracketed(field: &str) -> Option<&str> {
    let pairs = [('(', ')'), ('[', ']')];
    let inside = |(open, close)| field.strip_prefix(open)?.strip_suffix(close);
    pairs.into_iter().find_map(inside)
}

/// The beginning of a text, for a message.
fn shortened(text: &str) -> String {
    const MOST: usize = 30;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
