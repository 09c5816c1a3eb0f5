//! Calibrated signals: sound pressure and its levels.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use schemars::JsonSchema;
use serde::Serialize;
use thiserror::Error;

use crate::analysis::{
    AnalysisError,
    levels::{Calibration, LevelReference, SoundLevels, calibrate, sound_levels},
};
use crate::import::Signal;

/// Source of a calibration, parsed from `94dB=FILE`, `12.5Pa` or `50mV/Pa`.
#[derive(Clone, Debug, PartialEq)]
pub enum CalibrationSource {
    /// The level of a calibrator, dB, and its recording.
    Recording(f64, PathBuf),
    /// Pressure in Pa for one unit of the signal.
    Pascal(f64),
    /// Sensitivity of the microphone, V/Pa; the signal is in V.
    Volt(f64),
}

impl FromStr for CalibrationSource {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let above_zero = |text| number(text).filter(|x| *x > 0.0);
        let source = if let Some((level, path)) = text.split_once("dB=") {
            let level = number(level).filter(|_| !path.is_empty());
            level.map(|level| Self::Recording(level, path.into()))
        } else if let Some(sensitivity) = text.strip_suffix("mV/Pa") {
            above_zero(sensitivity).map(|millivolts| Self::Volt(1e-3 * millivolts))
        } else {
            text.strip_suffix("Pa")
                .and_then(above_zero)
                .map(Self::Pascal)
        };
        source.ok_or(
            "give the level of a calibrator and its recording (94dB=FILE), the pressure for one unit of the signal \
             (12.5Pa), or the sensitivity of the microphone for a signal in V (50mV/Pa)",
        )
    }
}

/// A signal cannot be calibrated.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CalibrationError {
    /// A sensitivity in V/Pa for a signal that is not in V.
    #[error(
        "the signal is not in V (its unit: `{unit}`), as a calibration in mV/Pa needs; give the pressure for one unit, such as 12.5Pa"
    )]
    NotInVolts {
        /// Unit of the signal.
        unit: String,
    },
    /// The recording of a calibrator has no tone.
    #[error("`{}`, the recording of the calibrator, has no tone of at least 0.5 s; record the calibrator again, with no other sound", path.display())]
    NoTone {
        /// Path of the recording.
        path: PathBuf,
    },
}

impl CalibrationSource {
    /// The calibration of a signal with a unit. `read` reads the recording of the calibrator.
    ///
    /// # Errors
    /// [`CalibrationError`], and errors of `read`.
    pub fn calibration<E: From<CalibrationError>>(
        &self,
        unit: &str,
        read: impl FnOnce(&Path) -> Result<Signal, E>,
    ) -> Result<Calibration, E> {
        let given = |sensitivity_pa| Calibration {
            sensitivity_pa,
            calibrator: None,
        };
        Ok(match self {
            Self::Pascal(pascal) => given(*pascal),
            Self::Volt(volt) if unit == "V" => given(1.0 / volt),
            Self::Volt(_) => {
                let unit = unit.to_owned();
                return Err(CalibrationError::NotInVolts { unit }.into());
            }
            Self::Recording(level, path) => {
                let tone = read(path)?;
                let calibration = calibrate(&tone.samples, tone.rate, *level);
                calibration.ok_or_else(|| CalibrationError::NoTone { path: path.clone() })?
            }
        })
    }
}

/// Calibrated sound levels, with the calibration that they rest on.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CalibratedLevels {
    /// Calibration: how the unit of the signal becomes a pressure.
    pub calibration: Calibration,
    /// The levels.
    #[serde(flatten)]
    pub levels: SoundLevels,
}

impl CalibratedLevels {
    /// Converts a signal to Pa, and returns its levels.
    ///
    /// # Errors
    /// As [`sound_levels`].
    pub fn of(signal: &mut Signal, calibration: Calibration) -> Result<Self, AnalysisError> {
        for sample in &mut signal.samples {
            *sample *= calibration.sensitivity_pa;
        }
        LevelReference::PASCAL.clone_into(&mut signal.unit);
        Ok(Self {
            calibration,
            levels: sound_levels(&signal.samples, signal.rate)?,
        })
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
            assert!(parse(text).is_err(), "{text}");
        }
    }

    /// A sine of an amplitude with 1 kHz.
    fn sine(amplitude: f64, unit: &str) -> Signal {
        let sample = |k: u32| amplitude * (std::f64::consts::TAU * 0.125 * f64::from(k)).sin();
        Signal {
            unit: unit.to_owned(),
            rate: 8000.0,
            samples: (0..8000).map(sample).collect(),
            ..Signal::default()
        }
    }

    #[test]
    fn the_recording_of_a_calibrator_gives_the_level_of_a_signal() {
        let source = CalibrationSource::Recording(94.0, "calibrator.wav".into());
        let mut signal = sine(0.2, "FS");
        let calibration = source.calibration("FS", |path| {
            assert_eq!(path, Path::new("calibrator.wav"));
            Ok::<_, CalibrationError>(sine(0.1, "FS"))
        });
        let levels = CalibratedLevels::of(&mut signal, calibration.unwrap()).unwrap();
        let level = levels.levels.a_weighted_level_db;
        assert!((level - 94.0 - 6.0206).abs() < 1e-3, "{levels:?}");
        // 100.02 dB are an amplitude of 2.83 Pa.
        assert_eq!(signal.unit, "Pa");
        assert!((signal.samples[2] / 2.8348 - 1.0).abs() < 1e-3);
        let silent = source.calibration("FS", |_| Ok::<_, CalibrationError>(sine(0.0, "FS")));
        assert!(matches!(silent, Err(CalibrationError::NoTone { .. })));
    }

    #[test]
    fn volts_need_a_signal_in_volts() {
        let source = CalibrationSource::Volt(0.05);
        let read = |_: &Path| {
            Err(CalibrationError::NoTone {
                path: PathBuf::new(),
            })
        };
        let calibration = source.calibration("V", read).unwrap();
        assert_eq!(calibration.sensitivity_pa, 20.0);
        // 20 Pa of amplitude are 117.0 dB.
        let levels = CalibratedLevels::of(&mut sine(1.0, "V"), calibration).unwrap();
        assert!((levels.levels.equivalent_level_db - 116.99).abs() < 0.01);
        let refused = source.calibration("FS", read);
        assert!(matches!(refused, Err(CalibrationError::NotInVolts { .. })));
    }
}
