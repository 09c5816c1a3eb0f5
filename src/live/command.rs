//! What may be asked of a session.

use serde::{Deserialize, Serialize};

use crate::pipeline::TooManyKicks;

/// Paces that may be asked for, simulated ms a second.
pub const PACES: [f64; 2] = [0.01, 1000.0];
/// Kicks that may be asked for, mm/s.
pub const KICKS: [f64; 2] = [1e-6, 1000.0];
/// The kick if none is asked for, mm/s: seen, and small beside a squeak.
pub(super) const KICK: f64 = 1.0;
/// A hard kick, mm/s: large beside a squeak, so that another tone may win.
pub const HARD: f64 = 30.0;

/// What may be asked of a session; from the page as JSON: `{"do": "tilt", "deg": 3.5}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Command {
    /// Tilt the load, degrees.
    Tilt {
        /// The tilt, degrees.
        deg: f64,
    },
    /// Let the time stand still.
    Pause {},
    /// Let it go on.
    Resume {},
    /// Make one frame, and stand still.
    Step {},
    /// Go at another pace.
    Pace {
        /// Simulated ms a second.
        ms_per_s: f64,
    },
    /// Push at random: each kick in another direction.
    Kick {
        /// Size, mm/s (of the modes' velocities, sqrt(kg) mm/s).
        #[serde(default)]
        mm_per_s: Option<f64>,
    },
    /// Begin the scene anew.
    Reset {},
    /// Follow neighbours of the motion, as the scene asks for them (exponents, a second copy), or leave them out,
    /// which is faster. Begins the scene anew.
    Neighbours {
        /// Whether to follow them.
        follow: bool,
    },
    /// Another scene.
    Scene {
        /// Its name: a preset's, or that of the scene the session began with.
        name: String,
    },
    /// Record into a file from now on.
    Record {},
    /// End the recording.
    StopRecording {},
}

impl Command {
    /// What it takes of a client's allowance, see [`super::server`]: in proportion to what it costs the run.
    pub(super) fn cost(&self) -> f64 {
        match self {
            Self::Kick { .. } => 5.0,
            Self::Reset {} | Self::Neighbours { .. } | Self::Scene { .. } | Self::Record {} => 25.0,
            _ => 1.0,
        }
    }
}

/// A command that is not carried out, and why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub(super) String);

impl From<TooManyKicks> for Refused {
    fn from(why: TooManyKicks) -> Self {
        Self(why.to_string())
    }
}

/// A number that is asked for, if it is within a range.
pub(super) fn within(
    what: &str,
    asked: f64,
    [low, high]: [f64; 2],
    unit: &str,
) -> Result<f64, Refused> {
    if (low..=high).contains(&asked) {
        return Ok(asked);
    }
    let refused = format!("{what} must be from {low} to {high} {unit}, not {asked}");
    Err(Refused(refused))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_words_of_json() {
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
