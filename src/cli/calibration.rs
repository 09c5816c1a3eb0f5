//! `squeakscope analyse --calibration`: sound levels of a calibrated signal.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::error::CliError;
use super::report::HEADING;
use super::signal::read;
use crate::analysis::{Calibration, SoundLevels, calibrate, sound_levels};
use crate::import::{Selection, Signal};
use crate::number::significant;
use crate::table::Table;

/// Source of a calibration: the option `--calibration`.
#[derive(Clone, Debug, PartialEq)]
pub enum CalibrationSource {
    /// The level of a calibrator, dB, and its recording.
    Recording(f64, PathBuf),
    /// Pressure in Pa for one unit of the signal.
    Pascal(f64),
    /// Sensitivity of the microphone, V/Pa; the signal is in V.
    Volt(f64),
}

/// A text has none of the forms of a calibration.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error(
    "give the level of a calibrator and its recording (94dB=FILE), the pressure for one unit of the signal \
     (12.5Pa), or the sensitivity of the microphone for a signal in V (50mV/Pa)"
)]
pub struct CalibrationFormError;

impl FromStr for CalibrationSource {
    type Err = CalibrationFormError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |text: &str| {
            let number = text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
            number.ok_or(CalibrationFormError)
        };
        let above_zero =
            |text| number(text).and_then(|x| (x > 0.0).then_some(x).ok_or(CalibrationFormError));
        if let Some((level, path)) = text.split_once("dB=") {
            return match path {
                "" => Err(CalibrationFormError),
                _ => Ok(Self::Recording(number(level)?, path.into())),
            };
        }
        if let Some(sensitivity) = text.strip_suffix("mV/Pa") {
            return Ok(Self::Volt(1e-3 * above_zero(sensitivity)?));
        }
        match text.strip_suffix("Pa") {
            Some(pascal) => Ok(Self::Pascal(above_zero(pascal)?)),
            None => Err(CalibrationFormError),
        }
    }
}

/// Sound levels with the calibration that they rest on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct CalibratedLevels {
    /// Calibration: how the unit of the signal becomes a pressure.
    calibration: Calibration,
    #[serde(flatten)]
    levels: SoundLevels,
}

impl CalibratedLevels {
    /// The levels of a signal; `column` is that of the recording of the calibrator, too.
    pub fn of(
        signal: &Signal,
        source: &CalibrationSource,
        column: Option<&str>,
    ) -> Result<Self, CliError> {
        let given = |sensitivity_pa| Calibration {
            sensitivity_pa,
            calibrator: None,
        };
        let calibration = match source {
            CalibrationSource::Pascal(pascal) => given(*pascal),
            CalibrationSource::Volt(volt) if signal.unit == "V" => given(1.0 / volt),
            CalibrationSource::Volt(_) => {
                return Err(CliError::NotInVolts {
                    unit: signal.unit.clone(),
                });
            }
            CalibrationSource::Recording(level, path) => {
                let selection = Selection {
                    column: column.map(str::to_owned),
                    ..Selection::default()
                };
                let tone = read(path, &selection)?;
                let calibration = calibrate(&tone.samples, tone.rate, *level);
                calibration.ok_or_else(|| CliError::NoCalibratorTone { path: path.clone() })?
            }
        };
        let pressure = signal
            .samples
            .iter()
            .map(|x| calibration.sensitivity_pa * x);
        let levels = sound_levels(&pressure.collect::<Vec<_>>(), signal.rate);
        let levels = levels.ok_or(CliError::NoResult)?;
        Ok(Self {
            calibration,
            levels,
        })
    }

    /// The A-weighted equivalent level, dB.
    pub fn a_weighted(&self) -> f64 {
        self.levels.a_weighted_level_db
    }

    /// The paragraph of the report.
    pub fn text(&self) -> String {
        let SoundLevels {
            equivalent_level_db,
            a_weighted_level_db,
            fast_maximum_db,
            peak_level_db,
            third_octaves,
        } = &self.levels;
        let mut text = format!(
            "{HEADING}sound levels{HEADING:#}, dB re 20 uPa\n  A-weighted: equivalent {a_weighted_level_db:.1}, maximum \
             (fast) {fast_maximum_db:.1}; unweighted: equivalent {equivalent_level_db:.1}, peak {peak_level_db:.1}\n"
        );
        let sensitivity = significant(self.calibration.sensitivity_pa, 4);
        let _ = match self.calibration.calibrator {
            None => writeln!(text, "  calibration: 1 unit is {sensitivity} Pa, as given"),
            Some(tone) => writeln!(
                text,
                "  calibration: 1 unit is {sensitivity} Pa, by a tone of {:.1} Hz at {} dB that varies by {:.2} dB; the \
                 uncertainty of the calibrator (class 1: up to 0.4 dB) and of the microphone adds to it",
                tone.tone_hz, tone.stated_level_db, tone.level_deviation_db
            ),
        };
        let mut table = Table::default()
            .right("third octave, Hz")
            .right("dB")
            .right("+-");
        for band in third_octaves {
            table.row([
                band.centre_hz.to_string(),
                format!("{:.1}", band.band_level_db),
                format!("{:.1}", band.standard_deviation_db),
            ]);
        }
        text += &table.text();
        text + "  +-: standard deviation for random noise; less for tones\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_is_a_recording_or_a_sensitivity() {
        let parse = |text: &str| text.parse::<CalibrationSource>();
        let recording = CalibrationSource::Recording(94.0, "a=b.wav".into());
        assert_eq!(parse("94dB=a=b.wav"), Ok(recording));
        assert_eq!(parse("12.5Pa"), Ok(CalibrationSource::Pascal(12.5)));
        assert_eq!(parse("50mV/Pa"), Ok(CalibrationSource::Volt(0.05)));
        for text in [
            "", "94dB", "94dB=", "94", "-1Pa", "0Pa", "xPa", "nanPa", "V/Pa", "mV/Pa",
        ] {
            assert_eq!(parse(text), Err(CalibrationFormError), "{text}");
        }
    }

    #[test]
    fn the_recording_of_a_calibrator_gives_the_level_of_a_signal() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibrator.csv");
        let sine = |amplitude: f64, k: u32| {
            amplitude * (std::f64::consts::TAU * 0.125 * f64::from(k)).sin()
        };
        let rows = (0..8000).map(|k| format!("{},{}\n", f64::from(k) / 8000.0, sine(0.1, k)));
        std::fs::write(&path, format!("t,p\n{}", rows.collect::<String>())).unwrap();
        let signal = Signal {
            rate: 8000.0,
            samples: (0..8000).map(|k| sine(0.2, k)).collect(),
            ..Signal::default()
        };
        let source = CalibrationSource::Recording(94.0, path.clone());
        let levels = CalibratedLevels::of(&signal, &source, None).unwrap();
        assert!(
            (levels.a_weighted() - 94.0 - 6.0206).abs() < 1e-3,
            "{levels:?}"
        );
        assert!(
            levels.text().contains("a tone of 1000.0 Hz at 94 dB"),
            "{}",
            levels.text()
        );
        std::fs::write(&path, "t,p\n0,0\n0.5,0\n1,0\n").unwrap();
        let refused = CalibratedLevels::of(&signal, &source, None).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
        assert!(refused.to_string().contains("has no tone"), "{refused}");
    }

    #[test]
    fn volts_need_a_signal_in_volts() {
        let signal = Signal {
            unit: "V".to_owned(),
            rate: 8000.0,
            samples: (0..8000).map(|k| (0.7 * f64::from(k)).sin()).collect(),
            ..Signal::default()
        };
        let source = CalibrationSource::Volt(0.05);
        let levels = CalibratedLevels::of(&signal, &source, None).unwrap();
        assert_eq!(levels.calibration.sensitivity_pa, 20.0);
        // 20 Pa of amplitude are 117.0 dB.
        assert!((levels.levels.equivalent_level_db - 116.99).abs() < 0.01);
        assert!(levels.text().contains("1 unit is 20"), "{}", levels.text());
        let bare = Signal {
            unit: "FS".to_owned(),
            ..signal
        };
        let refused = CalibratedLevels::of(&bare, &source, None).unwrap_err();
        assert_eq!(refused.exit_code(), 2, "{refused}");
    }
}
