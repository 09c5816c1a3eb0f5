//! Commands to a live session.

use serde::{Deserialize, Serialize};

use super::tour::TourStep;

/// Range of playback speeds, ms of simulated time per s of wall time.
pub const SPEED_RANGE: [f64; 2] = [0.01, 1000.0];
/// Range of kicks, mm/s.
pub const KICK_RANGE: [f64; 2] = [1e-6, 1000.0];
/// Default kick, mm/s: visible, and small compared with a squeak.
pub(super) const DEFAULT_KICK: f64 = 1.0;
/// A hard kick, mm/s: large compared with a squeak. The motion may settle on another tone.
pub const HARD_KICK: f64 = 30.0;

/// A command for a live session to do. The page sends it as JSON: `{"do": "set", "key": "tilt_deg", "value": 3.5}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Command {
    /// Change a number of the scene: one of its controls.
    Set {
        /// Dotted path of the number, or its name: `load.tilt_deg` or `tilt_deg`.
        key: String,
        /// Value, in the unit of the key.
        value: f64,
    },
    /// Pause the simulation.
    Pause {},
    /// Resume the simulation.
    Resume {},
    /// Compute one frame, then pause.
    Step {},
    /// Set the playback speed.
    Speed {
        /// Playback speed, ms of simulated time per s of wall time.
        ms_per_s: f64,
    },
    /// Add a random velocity to each mode; each kick has another direction.
    Kick {
        /// Standard deviation of the modal velocities, sqrt(kg) mm/s; the default is 1.
        #[serde(default)]
        mm_per_s: Option<f64>,
    },
    /// Start the run again, from where the scene, the bookmark or the step of the tour began.
    Reset {},
    /// Switch the Lyapunov exponents and the perturbed trajectory of the scene on or off. Without
    /// them the simulation is faster. Restarts the scene.
    Lyapunov {
        /// Whether they are enabled.
        enabled: bool,
    },
    /// Run another scene.
    Scene {
        /// Name of a preset, or of the first scene of the session.
        name: String,
    },
    /// Start a bookmark from its first instant: the motion does not depend on what ran before.
    Open(Box<TourStep>),
    /// Show a step of the tour, from 0, with its scene and settings; without a step the tour ends.
    Tour {
        /// The step.
        step: Option<usize>,
    },
    /// Show a black screen on all pages, or the run again.
    Blank {
        /// Whether the screen is black.
        on: bool,
    },
    /// Start a recording.
    Record {},
    /// Stop the recording.
    StopRecording {},
}

/// A settled motion that is expected from some time on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Promise {
    /// Type of motion, as in the panel of the page.
    pub motion: String,
    /// Frequency of the strongest line, kHz; any by default.
    #[serde(default)]
    pub line_khz: Option<f64>,
    /// Simulated time from which the motion is settled, ms.
    pub after_ms: f64,
}

impl Promise {
    /// Tolerance of the frequency.
    const TOLERANCE: f64 = 0.02;

    /// Whether a motion is the promised one: its type, and the frequency of its strongest line, Hz.
    pub fn is_kept(&self, motion: &str, line_hz: Option<f64>) -> bool {
        let close =
            |khz: f64| line_hz.is_some_and(|hz| (1e-3 * hz / khz - 1.0).abs() <= Self::TOLERANCE);
        motion == self.motion && self.line_khz.is_none_or(close)
    }
}

impl std::fmt::Display for Promise {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.motion)?;
        self.line_khz
            .map_or(Ok(()), |khz| write!(f, ", {khz:.2} kHz"))
    }
}

/// A rejected command, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Rejected(pub(super) String);

/// A rejection for a reason.
pub(super) fn rejected(reason: impl std::fmt::Display) -> Rejected {
    Rejected(reason.to_string())
}

/// Checks that a number is within its range.
pub(super) fn check_range(
    what: &str,
    asked: f64,
    [low, high]: [f64; 2],
    unit: &str,
) -> Result<f64, Rejected> {
    if (low..=high).contains(&asked) {
        return Ok(asked);
    }
    let range = format!("{low} and {high} {unit}");
    let range = range.trim_end();
    Err(Rejected(format!(
        "{what} must be between {range}, not {asked}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read_from_json() {
        let read = |text| serde_json::from_str::<Command>(text);
        let tilt = read(r#"{"do": "set", "key": "tilt_deg", "value": 3.5}"#).unwrap();
        let key = "tilt_deg".to_owned();
        assert_eq!(tilt, Command::Set { key, value: 3.5 });
        let kick = read(r#"{"do": "kick"}"#).unwrap();
        assert_eq!(kick, Command::Kick { mm_per_s: None });
        for bad in [
            r#"{"do": "set", "key": "tilt_deg"}"#,
            r#"{"do": "set", "key": "tilt_deg", "value": "3"}"#,
            r#"{"do": "set", "key": "tilt_deg", "value": 3, "more": 1}"#,
            r#"{"do": "explode"}"#,
            r#"{"do": "pause", "for": 3}"#,
            r#"{"do": "record", "file": "x"}"#,
            r#"{"do": "kick", "mm/s": 1}"#,
            r#"{"do": "set", "do": "pause", "key": "tilt_deg", "value": 3}"#,
            "[]",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
