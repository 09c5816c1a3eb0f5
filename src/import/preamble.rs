//! Preambles of oscilloscopes and loggers: the lines above the numbers that state settings, names and units.
//!
//! | instrument | first line | names and units | clock |
//! |---|---|---|---|
//! | Keysight InfiniiVision | `x-axis,1,2` | that line; the next line | time column |
//! | Rigol DS1000Z | `X,CH1,Start,Increment` | that line; the next line | `Start`, `Increment` |
//! | Tektronix MSO, MDO, DPO | `Model,MDO3024` | last line of the preamble; `Vertical Units` | time column |
//! | Tektronix TDS | `Record Length,2.5e+03,,` beside the first sample | left of the first samples | time column |
//! | Siglent SDS | `Record Length,Analog:7000` | `Source`; `Vertical Units` | time column |
//! | LeCroy | `LECROYWS424,...` | last line of the preamble; V | time column |
//! | LabVIEW measurement file | `LabVIEW Measurement` | last line of the preamble; `Y_Unit_Label` | time column, or `Delta_X` |
//!
//! PicoScope writes names, units in brackets and numbers, which every text may have.

use std::io::{BufRead, Seek};

use super::Problem;
use super::clock::Uniform;
use super::lines::{Separator, each_line};

/// Largest number of lines of a preamble.
const MAX_LINES: usize = 200;

/// What a preamble states.
#[derive(Default)]
pub(super) struct Preamble {
    /// Number of its last line, from 1.
    pub last: u64,
    /// Names and units of the columns.
    pub columns: Vec<(String, String)>,
    /// Number of fields at the left of the samples, which belong to the preamble.
    pub beside: usize,
    /// Clock, if the preamble states it.
    pub clock: Option<Uniform>,
}

/// Lines with their numbers and fields.
type Lines = Vec<(u64, Vec<String>)>;

impl Preamble {
    /// The preamble of a content; `None` without a known one.
    pub fn of(content: &mut (impl BufRead + Seek)) -> Result<Option<Self>, Problem> {
        let mut lines = Lines::new();
        each_line(content, |line, text| {
            let fields = Separator::of(text).fields(text).map(str::to_owned);
            lines.push((line, fields.collect()));
            let is_known = lines.len() > 1 || is_known(&lines[0].1);
            Ok(is_known && lines.len() < MAX_LINES)
        })?;
        let Some((_, first)) = lines.first().filter(|(_, first)| is_known(first)) else {
            return Ok(None);
        };
        Ok(match &first[0][..] {
            "x-axis" => keysight(&lines),
            "X" => rigol(&lines),
            "Record Length" if is_beside_samples(first) => Some(beside_samples(&lines)),
            _ => with_settings(&lines),
        })
    }
}

/// Whether a first line is that of a known preamble.
fn is_known(fields: &[String]) -> bool {
    let second = fields.get(1).map_or("", String::as_str);
    match &fields[0][..] {
        "x-axis" | "Model" | "LabVIEW Measurement" => true,
        "X" => fields.iter().any(|field| field == "Increment"),
        "Record Length" => second.starts_with("Analog:") || is_beside_samples(fields),
        word => word.starts_with("LECROY"),
    }
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

fn keysight(lines: &Lines) -> Option<Preamble> {
    let [(_, names), (last, units), ..] = &lines[..] else {
        return None;
    };
    let columns = names.iter().zip(units).enumerate();
    let columns = columns.map(|(k, (name, word))| match k {
        0 => ("time".to_owned(), unit(word)),
        _ => (name.clone(), unit(word)),
    });
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
        values.get(place)?.parse().ok()
    };
    let (start, increment) = (number("Start")?, number("Increment")?);
    let channels = names.iter().zip(values);
    let channels = channels.take_while(|(name, _)| *name != "Start");
    Some(Preamble {
        last: *last,
        columns: channels
            .map(|(name, word)| (name.clone(), unit(word)))
            .collect(),
        clock: Some(Uniform {
            rate: increment.recip(),
            start,
            uncertainty: 1e-6,
        }),
        ..Preamble::default()
    })
}

/// Whether a line has a setting (name, value, unit) and a sample (time, value).
fn is_beside_samples(fields: &[String]) -> bool {
    let is_number = |field: &String| field.parse::<f64>().is_ok();
    fields.len() >= SETTING + 2 && fields[SETTING..SETTING + 2].iter().all(is_number)
}

/// Number of fields of a setting beside a sample.
const SETTING: usize = 3;

/// A preamble beside the first samples.
fn beside_samples(lines: &Lines) -> Preamble {
    let setting = |name| setting(lines, name).map_or("", String::as_str);
    let mut columns = vec![(String::new(), String::new()); SETTING];
    columns.push(("time".to_owned(), "s".to_owned()));
    columns.push((
        setting("Source").to_owned(),
        unit(setting("Vertical Units")),
    ));
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
        given.peek().is_some() && given.all(|field| field.parse::<f64>().is_ok())
    };
    let end = lines
        .windows(2)
        .position(|pair| pair.iter().all(|(_, row)| is_numbers(row)))?;
    let (last, header) = lines.get(end.checked_sub(1)?)?;
    let setting = |name: &str| setting(&lines[..end], name);
    // Siglent states `CH1:V`.
    let vertical = setting("Vertical Units").or_else(|| setting("Y_Unit_Label"));
    let vertical = vertical.map_or("V", |value| value.rsplit(':').next().unwrap_or(value));
    let has_time = ["time", "second", "x_value"].contains(&header[0].to_lowercase().as_str());
    let columns = header
        .iter()
        .enumerate()
        .map(|(k, name)| match (k, has_time) {
            (0, true) => ("time".to_owned(), "s".to_owned()),
            // Siglent heads the columns with their units.
            _ if ["Volt", "Value"].contains(&&name[..]) => {
                let source = setting("Source").cloned();
                (source.unwrap_or_else(|| name.clone()), unit(vertical))
            }
            _ => (name.clone(), unit(vertical)),
        });
    let interval = setting("Delta_X").or_else(|| setting("Sample Interval"));
    let interval = interval.and_then(|value| value.rsplit(':').next()?.parse::<f64>().ok());
    let start = setting("X0").and_then(|value| value.parse().ok());
    let clock = interval.filter(|_| !has_time).map(|interval| Uniform {
        rate: interval.recip(),
        start: start.unwrap_or(0.0),
        uncertainty: 1e-6,
    });
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
