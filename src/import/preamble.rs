//! What stands above the numbers of a text: settings, names and units.
//!
//! | instrument | first line | names and units | clock |
//! |---|---|---|---|
//! | Keysight InfiniiVision | `x-axis,1,2` | that line; the next line | time column |
//! | Rigol DS1000Z | `X,CH1,Start,Increment` | that line; the next line | `Start`, `Increment` |
//! | Rigol MSO5000 | `CH1V,CH2V,t0 = -1e-3,tInc = 1e-6` | that line | `t0`, `tInc` |
//! | Tektronix MSO, MDO, DPO | `Model,MDO3024` | last line of the preamble; `Vertical Units` | time column |
//! | Tektronix TDS | `Record Length,2.5e+03,,` beside the first sample | left of the first samples | time column |
//! | Siglent SDS | `Record Length,Analog:7000` | `Source`; `Vertical Units` | time column |
//! | LeCroy | `LECROYWS424,...` | last line of the preamble; V | time column |
//! | LabVIEW measurement file | `LabVIEW Measurement` | last line of the preamble; `Y_Unit_Label` | time column, or `Delta_X` |
//!
//! Any other text begins with titles, which are skipped, and a row of names with as many fields as the numbers. A row of
//! units may follow: in brackets, known ones, or with a unit of time below the name of a time. Without a row of
//! names, the last comment has the names if it has as many fields (as `numpy.savetxt` writes it).

use std::io::{BufRead, Seek};

use super::Problem;
use super::clock::Uniform;
use super::lines::{Separator, each_line, number};
use super::table::ColumnHeader;
use super::text::shortened;
use super::units;

/// Relative uncertainty of a stated interval.
const UNCERTAINTY: f64 = 1e-6;

/// Largest number of lines of a preamble.
const MAX_LINES: usize = 200;

/// What a preamble states.
#[derive(Default)]
pub(super) struct Preamble {
    /// Number of its last line, from 1.
    pub last: u64,
    /// Names and units of the columns.
    pub columns: Vec<ColumnHeader>,
    /// Whether the names are those of a row above the numbers, not of an instrument.
    pub is_heading: bool,
    /// Number of fields at the left of the samples, which belong to the preamble.
    pub beside: usize,
    /// Clock, if the preamble states it.
    pub clock: Option<Uniform>,
}

/// Lines with their numbers and fields.
type Lines = Vec<(u64, Vec<String>)>;

impl Preamble {
    /// The preamble of a content without its first `skipped` lines.
    pub fn of(content: &mut (impl BufRead + Seek), skipped: u64) -> Result<Self, Problem> {
        let mut lines: Vec<(u64, String)> = Vec::new();
        let mut is_instrument = false;
        let mut comment = String::new();
        each_line(content, skipped, |line, text| {
            if lines.is_empty() {
                is_instrument = is_known(&fields(text));
            }
            if is_comment(text) && !is_instrument {
                text.clone_into(&mut comment);
                return Ok(true);
            }
            let pair = lines.last().map(|(_, former)| [former, text]);
            let has_begun = pair.is_some_and(|pair| pair.iter().all(|row| is_numbers(row)));
            lines.push((line, text.to_owned()));
            Ok((is_instrument || !has_begun) && lines.len() < MAX_LINES)
        })?;
        if is_instrument {
            let lines: Lines = lines.iter().map(|(n, text)| (*n, fields(text))).collect();
            let known = match &lines[0].1[0][..] {
                "x-axis" => keysight(&lines),
                "X" => rigol(&lines),
                _ if has_increment(&lines[0].1) => rigol_mso(&lines),
                "Record Length" if is_beside_samples(&lines[0].1) => Some(beside_samples(&lines)),
                _ => with_settings(&lines),
            };
            if let Some(known) = known {
                return Ok(known);
            }
        }
        heading(&lines, &comment)
    }
}

/// The fields of a line on its own.
fn fields(text: &str) -> Vec<String> {
    let fields = Separator::of(text).fields(text);
    fields.map(str::to_owned).collect()
}

pub(super) fn is_comment(line: &str) -> bool {
    line.starts_with('#')
}

/// Number of numbers and of words in a row.
fn count(row: &str) -> (usize, usize) {
    let given = Separator::of(row).fields(row).filter(|f| !f.is_empty());
    given.fold((0, 0), |(numbers, words), field| {
        if number(field).is_some() {
            (numbers + 1, words)
        } else {
            (numbers, words + 1)
        }
    })
}

/// Whether all fields that are not empty are numbers.
fn is_numbers(row: &str) -> bool {
    matches!(count(row), (1.., 0))
}

/// Whether at least half of the fields are numbers.
pub(super) fn is_row_of_numbers(row: &str) -> bool {
    let (numbers, words) = count(row);
    numbers > 0 && numbers >= words
}

/// Number of fields of a row without and with the empty ones at its end.
pub(super) fn widths(separator: Separator, row: &str) -> (usize, usize) {
    let fields = separator.fields(row).enumerate();
    fields.fold((0, 0), |(given, _), (k, field)| {
        (if field.is_empty() { given } else { k + 1 }, k + 1)
    })
}

/// The titles, names and units above the first two rows of numbers alone, or else above the first row of which at
/// least half are numbers.
fn heading(lines: &[(u64, String)], comment: &str) -> Result<Preamble, Problem> {
    let is_pair = |pair: &[(u64, String)]| pair.iter().all(|(_, row)| is_numbers(row));
    let first = lines.windows(2).position(is_pair);
    let first = first.or_else(|| lines.iter().position(|(_, row)| is_row_of_numbers(row)));
    let Some(((_, row), above)) = first.map(|first| (&lines[first], &lines[..first])) else {
        return Ok(Preamble::default());
    };
    let separator = Separator::of(row);
    let (given, have) = widths(separator, row);
    let fits = |(_, row): &&(u64, String)| (given..=have).contains(&widths(separator, row).0);
    let fields_of = |row| separator.fields(row).collect::<Vec<_>>();
    let mut rows = above
        .iter()
        .filter(fits)
        .map(|(n, row)| (*n, fields_of(row)));
    let mut names = rows.next_back();
    let mut former = rows.next_back();
    let mut units_row = Vec::new();
    if let (Some((_, units)), Some((_, above))) = (&names, &former)
        && units::is_row(above, units)
    {
        units_row.clone_from(units);
        names = former;
        former = rows.next_back();
    }
    let is_time = |names: &[&str]| {
        names
            .iter()
            .any(|name| units::is_time(units::split(name).0))
    };
    if let Some((line, names)) = &names
        && !is_time(names)
    {
        // The row may be one of damaged numbers.
        let is_number = |name: &&str| number(name).is_some();
        if former.is_some() || names.iter().any(is_number) {
            let place = names.iter().position(|name| !is_number(name)).unwrap_or(0);
            let column = former.map_or(place.to_string(), |(_, former)| former[place].to_owned());
            return Err(Problem::not_a_number(
                *line,
                &column,
                &shortened(names[place]),
            ));
        }
    }
    let names = match names {
        Some((_, names)) => names,
        // A row with further fields, or a comment.
        None => {
            let longer = above.last().map(|(_, row)| fields_of(row));
            let longer = longer.filter(|names| names.len() > have);
            let comment = comment
                .strip_prefix('#')
                .map(|names| fields_of(names.trim()));
            let comment = comment.filter(|names| names.len() == have && have > 1);
            longer.or(comment).unwrap_or_default()
        }
    };
    let end = names
        .iter()
        .rposition(|name| !name.is_empty())
        .map_or(0, |last| last + 1);
    let columns = names[..end].iter().enumerate().map(|(k, name)| {
        let mut column = ColumnHeader::new((*name).to_owned(), 0);
        if let Some(unit) = units_row.get(k) {
            units::without_brackets(unit).clone_into(&mut column.unit);
        }
        column
    });
    Ok(Preamble {
        last: above.last().map_or(0, |(line, _)| *line),
        columns: columns.collect(),
        is_heading: true,
        ..Preamble::default()
    })
}

/// Whether a first line is that of an instrument.
fn is_known(fields: &[String]) -> bool {
    let second = fields.get(1).map_or("", String::as_str);
    match &fields[0][..] {
        "x-axis" | "Model" | "LabVIEW Measurement" => true,
        "X" => fields.iter().any(|field| field == "Increment"),
        "Record Length" => second.starts_with("Analog:") || is_beside_samples(fields),
        word => word.starts_with("LECROY") || has_increment(fields),
    }
}

/// Whether a line states the time between samples as the MSO5000 does.
fn has_increment(fields: &[String]) -> bool {
    fields.iter().any(|field| field.starts_with("tInc"))
}

/// The unit of a word for it, as instruments write them.
fn unit(word: &str) -> String {
    match word.to_lowercase().as_str() {
        "second" | "seconds" | "s" => "s".to_owned(),
        "volt" | "volts" | "v" => "V".to_owned(),
        "ampere" | "amperes" | "amp" | "amps" => "A".to_owned(),
        _ => word.to_owned(),
    }
}

/// A column with the word for its unit.
fn column(name: &str, word: &str) -> ColumnHeader {
    ColumnHeader::with_unit(name.to_owned(), &unit(word), 0)
}

fn keysight(lines: &Lines) -> Option<Preamble> {
    let [(_, names), (last, units), ..] = &lines[..] else {
        return None;
    };
    let columns = names.iter().zip(units).enumerate();
    let columns = columns.map(|(k, (name, word))| column(if k == 0 { "time" } else { name }, word));
    Some(Preamble {
        last: *last,
        columns: columns.collect(),
        ..Preamble::default()
    })
}

fn rigol(lines: &Lines) -> Option<Preamble> {
    let [(_, names), (last, values), ..] = &lines[..] else {
        return None;
    };
    let number = |name: &str| -> Option<f64> {
        let place = names.iter().position(|field| field == name)?;
        number(values.get(place)?)
    };
    let (start, increment) = (number("Start")?, number("Increment")?);
    let channels = names.iter().zip(values);
    let channels = channels.take_while(|(name, _)| *name != "Start");
    Some(Preamble {
        last: *last,
        columns: channels.map(|(name, word)| column(name, word)).collect(),
        clock: Some(Uniform::new(start, increment, UNCERTAINTY)),
        ..Preamble::default()
    })
}

fn rigol_mso(lines: &Lines) -> Option<Preamble> {
    let (last, fields) = lines.first()?;
    let setting = |name: &str| -> Option<f64> {
        let mut values = fields.iter().filter_map(|field| field.strip_prefix(name));
        number(values.next()?.trim_start().strip_prefix('=')?.trim())
    };
    let channels = fields.iter().take_while(|field| !field.starts_with("t0"));
    let channels = channels.map(|field| match field.strip_suffix(['V', 'A']) {
        Some(name) => column(name, &field[name.len()..]),
        None => ColumnHeader::new(field.clone(), 0),
    });
    Some(Preamble {
        last: *last,
        columns: channels.collect(),
        clock: Some(Uniform::new(setting("t0")?, setting("tInc")?, UNCERTAINTY)),
        ..Preamble::default()
    })
}

/// Whether a line has a setting (name, value, unit) and a sample (time, value).
fn is_beside_samples(fields: &[String]) -> bool {
    let is_number = |field: &String| number(field).is_some();
    fields.len() >= SETTING + 2 && fields[SETTING..SETTING + 2].iter().all(is_number)
}

/// Number of fields of a setting beside a sample.
const SETTING: usize = 3;

/// A preamble beside the first samples.
fn beside_samples(lines: &Lines) -> Preamble {
    let setting = |name| setting(lines, name).map_or("", String::as_str);
    let mut columns = vec![column("", ""); SETTING];
    columns.push(column("time", "s"));
    columns.push(column(setting("Source"), setting("Vertical Units")));
    Preamble {
        columns,
        beside: SETTING,
        ..Preamble::default()
    }
}

/// The value of the last setting of a name, if there is one.
fn setting<'a>(lines: &'a [(u64, Vec<String>)], name: &str) -> Option<&'a String> {
    let mut found = lines.iter().rev().filter(|(_, fields)| fields[0] == name);
    found.find_map(|(_, fields)| fields.get(1).filter(|value| !value.is_empty()))
}

/// A preamble of lines with a name and its value, which ends before two rows of numbers alone.
fn with_settings(lines: &Lines) -> Option<Preamble> {
    let is_numbers = |fields: &[String]| {
        let mut given = fields.iter().filter(|field| !field.is_empty()).peekable();
        given.peek().is_some() && given.all(|field| number(field).is_some())
    };
    let end = lines
        .windows(2)
        .position(|pair| pair.iter().all(|(_, row)| is_numbers(row)))?;
    let (last, header) = lines.get(end.checked_sub(1)?)?;
    let setting = |name: &str| setting(&lines[..end], name);
    // Siglent states `CH1:V`.
    let vertical = setting("Vertical Units").or_else(|| setting("Y_Unit_Label"));
    // LeCroy states none.
    let unstated = if lines[0].1[0].starts_with("LECROY") {
        "V"
    } else {
        ""
    };
    let vertical = vertical.map_or(unstated, |value| value.rsplit(':').next().unwrap_or(value));
    let has_time = ["time", "second", "x_value"].contains(&header[0].to_lowercase().as_str());
    let columns = header
        .iter()
        .enumerate()
        .map(|(k, name)| match (k, has_time) {
            (0, true) => column("time", "s"),
            // Siglent heads the columns with their units.
            _ if ["Volt", "Value"].contains(&&name[..]) => {
                let source = setting("Source");
                column(source.unwrap_or(name), vertical)
            }
            _ => column(name, vertical),
        });
    let interval = setting("Delta_X").or_else(|| setting("Sample Interval"));
    let interval = interval.and_then(|value| number(value.rsplit(':').next()?));
    let start = setting("X0").and_then(|value| number(value));
    let clock = interval.filter(|_| !has_time);
    let clock = clock.map(|interval| Uniform::new(start.unwrap_or(0.0), interval, UNCERTAINTY));
    Some(Preamble {
        last: *last,
        columns: columns.collect(),
        clock,
        ..Preamble::default()
    })
}

#[cfg(test)]
mod tests {
    use crate::import::{Selection, Signal, read_signal};

    /// Reads a column of a file with these lines.
    fn read(lines: &[&str], column: &str) -> Signal {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("scope.csv");
        std::fs::write(&path, lines.join("\r\n")).expect("written");
        let selection = Selection {
            column: (!column.is_empty()).then(|| column.to_owned()),
            ..Selection::default()
        };
        read_signal(&path, &selection).expect("readable")
    }

    fn check(signal: &Signal, name: &str, rate: f64, start: f64, samples: &[f64]) {
        assert_eq!((&signal.name[..], &signal.unit[..]), (name, "V"));
        assert!((signal.rate / rate - 1.0).abs() < 1e-6, "{}", signal.rate);
        assert!((signal.start - start).abs() < 1e-9, "{}", signal.start);
        assert_eq!(signal.samples, samples);
    }

    #[test]
    fn keysight_states_the_units_in_the_second_line() {
        let lines = [
            "x-axis,1,2",
            "second,Volt,Volt",
            "-1.0E-03,+1.5E-01,+2.0E+00",
            "+0.0E+00,+2.5E-01,+2.5E+00",
            "+1.0E-03,-3.5E-01,+3.0E+00",
        ];
        check(&read(&lines, "2"), "2", 1e3, -1e-3, &[2.0, 2.5, 3.0]);
    }

    #[test]
    fn rigol_states_start_and_increment() {
        let lines = [
            "X,CH1,CH2,Start,Increment,",
            "Sequence,Volt,Volt,-6.000000e-04,1.000000e-06",
            "0,1.0e-01,2.0e-01,,",
            "1,1.5e-01,2.5e-01,,",
            "2,2.0e-01,3.0e-01,,",
        ];
        check(&read(&lines, "CH1"), "CH1", 1e6, -6e-4, &[0.1, 0.15, 0.2]);
    }

    #[test]
    fn rigol_mso5000_states_start_and_increment_beside_the_names() {
        let lines = [
            "CH1V,CH2A,t0 = -6.0e-04, tInc = 1.0e-06,",
            "1.0e-01,2.0e-01,,",
            "1.5e-01,2.5e-01,,",
            "2.0e-01,3.0e-01,,",
        ];
        check(&read(&lines, "CH1"), "CH1", 1e6, -6e-4, &[0.1, 0.15, 0.2]);
        assert_eq!(read(&lines, "CH2").unit, "A");
    }

    #[test]
    fn tektronix_has_a_line_for_each_setting() {
        let lines = [
            "Model,MDO3024",
            "Firmware Version,1.26",
            "",
            "Point Format,Y,",
            "Horizontal Units,s,",
            "Horizontal Scale,0.0004,",
            "Sample Interval,4e-07,",
            "Record Length,3,",
            "Vertical Units,V,",
            "Label,,",
            "TIME,CH1,",
            "-2.0000e-03,0.04,",
            "-1.9996e-03,0.05,",
            "-1.9992e-03,0.06,",
        ];
        check(&read(&lines, ""), "CH1", 2.5e6, -2e-3, &[0.04, 0.05, 0.06]);
    }

    #[test]
    fn tektronix_once_wrote_its_settings_beside_the_samples() {
        let lines = [
            "Record Length,2.500000e+03,,-0.005020000000,   0.04000,",
            "Sample Interval,4.000000e-06,,-0.005016000000,   0.05000,",
            "Trigger Point,1.250000000000e+03,,-0.005012000000,   0.06000,",
            ",,,-0.005008000000,   0.07000,",
            "Source,CH1,,-0.005004000000,   0.08000,",
            "Vertical Units,V,,-0.005000000000,   0.09000,",
            "Model Number,TDS2024B,,-0.004996000000,   0.10000,",
            ",,,-0.004992000000,   0.11000,",
        ];
        let samples = [0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.10, 0.11];
        check(&read(&lines, ""), "CH1", 250e3, -5.02e-3, &samples);
        // With units of the settings, in quotation marks.
        let lines = [
            "\"Record Length\",500,\"Points\",-2.0e-03,0.04",
            "\"Sample Interval\",1.0e-03,s,-1.0e-03,0.05",
            "\"Source\",\"CH2\",,0.0e-03,0.06",
            "\"Vertical Units\",\"V\",,1.0e-03,0.07",
        ];
        check(&read(&lines, ""), "CH2", 1e3, -2e-3, &samples[..4]);
    }

    #[test]
    fn siglent_names_the_source_in_the_preamble() {
        let lines = [
            "Record Length,Analog:3",
            "Sample Interval,Analog:0.000001000",
            "Vertical Units,CH1:V",
            "Vertical Scale,CH1:0.50",
            "Horizontal Units,S",
            "Model Number,SDS1104X-E",
            "Source,CH1",
            "Second,Volt",
            "-0.000500000000,0.12",
            "-0.000499000000,0.14",
            "-0.000498000000,0.16",
        ];
        check(&read(&lines, ""), "CH1", 1e6, -5e-4, &[0.12, 0.14, 0.16]);
    }

    #[test]
    fn lecroy_has_numbers_in_its_preamble() {
        let lines = [
            "LECROYWS424,52341,Waveform",
            "Segments,1,SegmentSize,3",
            "Segment,TrigTime,TimeSinceSegment1",
            "#1,19-Aug-2024 14:22:33,0",
            "Time,Ampl",
            "-5e-06,0.1",
            "-4e-06,0.2",
            "-3e-06,0.3",
        ];
        check(&read(&lines, ""), "Ampl", 1e6, -5e-6, &[0.1, 0.2, 0.3]);
    }

    #[test]
    fn labview_has_two_headers() {
        let lines = [
            "LabVIEW Measurement\t",
            "Writer_Version\t2",
            "Separator\tTab",
            "X_Columns\tOne",
            "***End_of_Header***\t",
            "\t",
            "Channels\t1\t",
            "Samples\t3\t",
            "Y_Unit_Label\tVolts\t",
            "X_Dimension\tTime\t",
            "X0\t0.0000000000000000E+0\t",
            "Delta_X\t1.000000E-3\t",
            "***End_of_Header***\t\t",
            "X_Value\tVoltage\tComment",
            "0.000000\t1.25",
            "0.001000\t1.50",
            "0.002000\t1.75",
        ];
        check(&read(&lines, ""), "Voltage", 1e3, 0.0, &[1.25, 1.5, 1.75]);
    }

    #[test]
    fn german_labview_has_decimal_commas() {
        let lines = [
            "LabVIEW Measurement\t",
            "Decimal_Separator\t,",
            "***End_of_Header***\t",
            "Channels\t1\t",
            "X0\t0,0000000000000000E+0\t",
            "Delta_X\t1,000000E-3\t",
            "***End_of_Header***\t\t",
            "X_Value\tVoltage\tComment",
            "0,000000\t1,25\t",
            "0,001000\t1,50\t",
            "0,002000\t1,75\t",
        ];
        let signal = read(&lines, "");
        assert_eq!(signal.unit, "", "no unit is stated");
        let signal = Signal {
            unit: "V".to_owned(),
            ..signal
        };
        check(&signal, "Voltage", 1e3, 0.0, &[1.25, 1.5, 1.75]);
    }

    #[test]
    fn picoscope_writes_units_in_brackets() {
        let lines = [
            "Time,Channel A",
            "(ms),(V)",
            "",
            "-1.00000000,0.10",
            "0.00000000,0.20",
            "1.00000000,0.30",
        ];
        check(&read(&lines, ""), "Channel A", 1e3, -1e-3, &[0.1, 0.2, 0.3]);
    }
}
