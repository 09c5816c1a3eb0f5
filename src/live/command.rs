//! Commands to a live session.

use serde::{Deserialize, Serialize};

use crate::pipeline::TooManyKicks;

/// Range of playback speeds, ms of simulated time per s of wall time.
pub const SPEED_RANGE: [f64; 2] = [0.01, 1000.0];
/// Range of kicks, mm/s.
pub const KICK_RANGE: [f64; 2] = [1e-6, 1000.0];
/// Default kick, mm/s: visible, and small compared with a squeak.
pub(super) const DEFAULT_KICK: f64 = 1.0;
/// A hard kick, mm/s: large compared with a squeak. The motion may settle on another tone.
pub const HARD_KICK: f64 = 30.0;

/// A command for a live session to do. The page sends it as JSON: `{"do": "tilt", "deg": 3.5}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Command {
    /// Set the tilt of the load.
    Tilt {
        /// Tilt in degrees (deg).
        deg: f64,
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
    /// Restart the scene.
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
    /// Start a recording.
    Record {},
    /// Stop the recording.
    StopRecording {},
}

/// A rejected command, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Rejected(pub(super) String);

impl From<TooManyKicks> for Rejected {
    fn from(why: TooManyKicks) -> Self {
        Self(why.to_string())
    }
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
    let refused = format!("{what} must be between {low} and {high} {unit}, not {asked}");
    Err(Rejected(refused))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read_from_json() {
        let read = |text| serde_json::from_str::<Command>(text);
        let tilt = read(r#"{"do": "tilt", "deg": 3.5}"#).unwrap();
        assert_eq!(tilt, Command::Tilt { deg: 3.5 });
        let kick = read(r#"{"do": "kick"}"#).unwrap();
        assert_eq!(kick, Command::Kick { mm_per_s: None });
        for bad in [
            r#"{"do": "tilt"}"#,
            r#"{"do": "tilt", "deg": "3"}"#,
            r#"{"do": "tilt", "deg": 3, "more": 1}"#,
            r#"{"do": "explode"}"#,
            r#"{"do": "pause", "for": 3}"#,
            r#"{"do": "record", "file": "x"}"#,
            r#"{"do": "kick", "mm/s": 1}"#,
            r#"{"do": "tilt", "do": "pause", "deg": 3}"#,
            "[]",
        ] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
