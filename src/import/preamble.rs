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
use super::lines::{MAX_LINE, each_line, number, separator_of, split_row};
use super::table::ColumnHeader;
use super::units;

/// Relative uncertainty of a stated interval.
const UNCERTAINTY: f64 = 1e-6;

/// Largest number of lines that are read for the preamble and the columns.
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

/// Lines with their numbers.
type Lines = Vec<(u64, String)>;

impl Preamble {
    /// The preamble of a content without its first `skipped` lines, and the first lines.
    pub fn of(content: &mut (impl BufRead + Seek), skipped: u64) -> Result<(Self, Lines), Problem> {
        let mut lines = Lines::new();
        let mut is_instrument = false;
        let mut comment = String::new();
        let mut length = 0;
        each_line(content, skipped, |line, text| {
            if lines.is_empty() {
                is_instrument = is_known(&fields(text));
            }
            if is_comment(text) && !is_instrument {
                text.clone_into(&mut comment);
                return Ok(true);
            }
            length += text.len();
            lines.push((line, text.to_owned()));
            Ok(lines.len() < MAX_LINES && length < MAX_LINE)
        })?;
        let instrument = is_instrument.then(|| instrument(&lines)).flatten();
        let preamble = match instrument {
            Some(preamble) => preamble,
            None => heading(&lines, &comment, is_instrument)?,
        };
        Ok((preamble, lines))
    }
}

/// The fields of a line on its own.
fn fields(text: &str) -> Vec<&str> {
    split_row(separator_of(text), text).collect()
}

pub(super) fn is_comment(line: &str) -> bool {
    line.starts_with('#')
}

/// Number of numbers and of words in a row.
fn count(row: &str) -> (usize, usize) {
    let given = fields(row).into_iter().filter(|field| !field.is_empty());
    let (numbers, words): (Vec<_>, Vec<_>) = given.partition(|field| number(field).is_some());
    (numbers.len(), words.len())
}

/// Whether at least half of the fields are numbers.
pub(super) fn is_row_of_numbers(row: &str) -> bool {
    let (numbers, words) = count(row);
    numbers > 0 && numbers >= words
}

/// Number of fields of a row without and with the empty ones at its end.
pub(super) fn widths(separator: char, row: &str) -> (usize, usize) {
    let fields = split_row(separator, row).enumerate();
    fields.fold((0, 0), |(given, _), (k, field)| {
        (if field.is_empty() { given } else { k + 1 }, k + 1)
    })
}

/// The titles, names and units above the first two rows of numbers alone, or else above the first row of which at
/// least half are numbers.
fn heading(lines: &Lines, comment: &str, is_instrument: bool) -> Result<Preamble, Problem> {
    let is_numbers = |(_, row): &(u64, String)| matches!(count(row), (1.., 0));
    let first = lines
        .windows(2)
        .position(|pair| pair.iter().all(is_numbers));
    let first = first.or_else(|| lines.iter().position(|(_, row)| is_row_of_numbers(row)));
    let Some(((_, row), above)) = first.map(|first| (&lines[first], &lines[..first])) else {
        return Ok(Preamble::default());
    };
    let separator = separator_of(row);
    let (given, have) = widths(separator, row);
    // The last line may have further fields.
    let last = above.last().map_or(0, |(line, _)| *line);
    let fits = |(line, row): &&(u64, String)| {
        let width = widths(separator, row).0;
        given <= width && (width <= have || *line == last)
    };
    let fields_of = |row| split_row(separator, row).collect::<Vec<_>>();
    let mut rows = above
        .iter()
        .filter(fits)
        .map(|(line, row)| (*line, fields_of(row)));
    let mut names = rows.next_back();
    let mut former = rows.next_back();
    let mut units_row = Vec::new();
    if let (Some((_, units)), Some((_, above))) = (&names, &former)
        && (units::is_row(above, units)
            || is_instrument && units.iter().all(|word| unit(word) != *word))
    {
        units_row.clone_from(units);
        names = former;
        former = rows.next_back();
    }
    let is_time = |name: &&str| units::is_time(units::split(name).0);
    if let Some((line, names)) = &names
        && !is_instrument
        && !names.iter().any(is_time)
    {
        // The row may be one of damaged numbers.
        let is_number = |name: &&str| number(name).is_some();
        if former.is_some() || names.iter().any(is_number) {
            let place = names.iter().position(|name| !is_number(name)).unwrap_or(0);
            let column = former.map_or(place.to_string(), |(_, former)| former[place].to_owned());
            return Err(Problem::not_a_number(*line, &column, names[place]));
        }
    }
    let names = names.map(|(_, names)| names).or_else(|| {
        let names = fields_of(comment.strip_prefix('#')?.trim());
        let are_words = names.iter().all(|name| number(name).is_none());
        (names.len() == have && have > 1 && are_words).then_some(names)
    });
    let mut names = names.unwrap_or_default();
    while names.pop_if(|name| name.is_empty()).is_some() {}
    let columns = names.iter().enumerate().map(|(k, name)| {
        let mut column = ColumnHeader::new((*name).to_owned());
        if let Some(word) = units_row.get(k) {
            unit(units::without_brackets(word)).clone_into(&mut column.unit);
        }
        column
    });
    let mut preamble = Preamble {
        last,
        columns: columns.collect(),
        is_heading: !is_instrument,
        ..Preamble::default()
    };
    if is_instrument {
        preamble.take_settings(above);
    }
    Ok(preamble)
}

impl Preamble {
    /// Adds what lines with a name and its value state.
    fn take_settings(&mut self, lines: &[(u64, String)]) {
        let setting = |name: &str| setting(lines, name);
        // Siglent states `CH1:V`; LeCroy states none.
        let vertical = setting("Vertical Units").or_else(|| setting("Y_Unit_Label"));
        let is_lecroy = lines
            .first()
            .is_some_and(|(_, text)| text.starts_with("LECROY"));
        let unstated = if is_lecroy { "V" } else { "" };
        let vertical = vertical.map_or(unstated, |value| value.rsplit(':').next().unwrap_or(value));
        // The column of times is then left blank.
        let is_blank = setting("X_Columns") == Some("No");
        self.beside = usize::from(is_blank);
        let mut has_time = false;
        for (k, column) in self.columns.iter_mut().enumerate() {
            let is_time =
                ["time", "second", "x_value", "x-axis"].contains(&&*column.name.to_lowercase());
            if k == 0 && !is_blank && (is_time || column.unit == "s") {
                *column = ColumnHeader::with_unit("time".to_owned(), "s");
                has_time = true;
            } else if column.unit.is_empty() {
                unit(vertical).clone_into(&mut column.unit);
            }
        }
        if let (Some(source), [_, column]) = (setting("Source"), &mut self.columns[..]) {
            *column = ColumnHeader::with_unit(source.to_owned(), &column.unit);
        }
        let interval = setting("Delta_X").or_else(|| setting("Sample Interval"));
        let interval = interval.and_then(|value| number(value.rsplit(':').next()?));
        let start = setting("X0").and_then(number).unwrap_or(0.0);
        self.clock = interval
            .filter(|_| !has_time)
            .map(|interval| Uniform::new(start, interval, UNCERTAINTY));
    }
}

/// Whether a first line is that of an instrument.
fn is_known(fields: &[&str]) -> bool {
    match fields {
        ["x-axis" | "Model" | "LabVIEW Measurement", ..] => true,
        ["X", ..] => fields.contains(&"Increment"),
        ["Record Length", second, ..] => second.starts_with("Analog:") || is_beside_samples(fields),
        [word, ..] => word.starts_with("LECROY") || has_increment(fields),
        [] => false,
    }
}

/// Whether a line states the time between samples as the MSO5000 does.
fn has_increment(fields: &[&str]) -> bool {
    fields.iter().any(|field| field.starts_with("tInc"))
}

/// The unit of a word for it, as instruments write them.
fn unit(word: &str) -> &str {
    match &word.to_lowercase()[..] {
        "second" | "seconds" | "s" => "s",
        "volt" | "volts" | "v" => "V",
        "ampere" | "amperes" | "amp" | "amps" | "a" => "A",
        _ => word,
    }
}

/// The preamble of an instrument that has no row of names above its numbers.
fn instrument(lines: &Lines) -> Option<Preamble> {
    let column = |name: &str, word| ColumnHeader::with_unit(name.to_owned(), unit(word));
    let (first, text) = lines.first()?;
    let names = fields(text);
    if is_beside_samples(&names) {
        let setting = |name| setting(lines, name).unwrap_or_default();
        let mut columns = vec![ColumnHeader::default(); SETTING];
        columns.push(column("time", "s"));
        columns.push(column(setting("Source"), setting("Vertical Units")));
        return Some(Preamble {
            columns,
            beside: SETTING,
            ..Preamble::default()
        });
    }
    let (last, columns, start, increment): (_, Vec<_>, _, _) = if has_increment(&names) {
        // Rigol MSO5000: `CH1V`, `t0 = -1e-3`.
        let setting = |name: &str| -> Option<&str> {
            let mut values = names.iter().filter_map(|field| field.strip_prefix(name));
            Some(values.next()?.trim_start().strip_prefix('=')?.trim())
        };
        let channels = names.iter().take_while(|field| !field.starts_with("t0"));
        let channels = channels.map(|field| match field.strip_suffix(['V', 'A']) {
            Some(name) => column(name, &field[name.len()..]),
            // A column of times may come first: `Time(s)`.
            None => ColumnHeader::new((*field).to_owned()),
        });
        (first, channels.collect(), setting("t0")?, setting("tInc")?)
    } else {
        // Rigol DS1000Z: names above values.
        let (last, values) = lines.get(1)?;
        let values = fields(values);
        let setting = |name: &str| values.get(names.iter().position(|field| *field == name)?);
        let channels = names
            .iter()
            .zip(&values)
            .take_while(|(name, _)| **name != "Start");
        let channels = channels.map(|(name, word)| column(name, word));
        (
            last,
            channels.collect(),
            *setting("Start")?,
            *setting("Increment")?,
        )
    };
    Some(Preamble {
        last: *last,
        columns,
        clock: Some(Uniform::new(
            number(start)?,
            number(increment)?,
            UNCERTAINTY,
        )),
        ..Preamble::default()
    })
}

/// Whether a line has a setting (name, value, unit) and a sample (time, value).
fn is_beside_samples(fields: &[&str]) -> bool {
    let is_number = |field: &&str| number(field).is_some();
    fields.len() >= SETTING + 2 && fields[SETTING..SETTING + 2].iter().all(is_number)
}

/// Number of fields of a setting beside a sample.
const SETTING: usize = 3;

/// The value of the last setting of a name, if there is one.
fn setting<'a>(lines: &'a [(u64, String)], name: &str) -> Option<&'a str> {
    lines
        .iter()
        .rev()
        .find_map(|(_, text)| match fields(text)[..] {
            [first, value, ..] if first == name && !value.is_empty() => Some(value),
            _ => None,
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
        let lines = [
            "Time(s),CH1V,t0 = -6.0e-04, tInc = 1.0e-06,",
            "-6.00e-04,1.0e-01,,",
            "-5.99e-04,1.5e-01,,",
            "-5.98e-04,2.0e-01,,",
        ];
        check(&read(&lines, ""), "CH1", 1e6, -6e-4, &[0.1, 0.15, 0.2]);
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
    fn labview_may_leave_the_times_blank() {
        let lines = [
            "LabVIEW Measurement\t",
            "Decimal_Separator\t,",
            "X_Columns\tNo",
            "***End_of_Header***\t",
            "Y_Unit_Label\tVolts\t",
            "X0\t2,0E+0\t",
            "Delta_X\t5,0E-5\t",
            "***End_of_Header***\t\t",
            "X_Value\tMic\tComment",
            "\t1,25",
            "\t1,50",
            "\t1,75",
        ];
        check(&read(&lines, ""), "Mic", 2e4, 2.0, &[1.25, 1.5, 1.75]);
    }

    #[test]
    fn a_comment_with_numbers_names_no_columns() {
        let lines = [
            "# logger 3",
            "# rate 1000",
            "0.000 0.1",
            "0.001 0.2",
            "0.002 0.3",
        ];
        let signal = read(&lines, "");
        assert_eq!((&*signal.name, signal.rate), ("scope", 1e3));
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
