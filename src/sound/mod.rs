//! Motions to listen to: from samples at a simulation's rate to sound at [`RATE`].
//!
//! What is heard is stated by [`Source`]. Played slower than life, a motion sounds lower by as much. The
//! filter of the resampler is a windowed sinc: what a loudspeaker could not play is taken away, not folded
//! back.

mod resample;
mod wav;

pub use resample::Resampler;
pub use wav::WavSink;

use serde::{Deserialize, Serialize};

/// Samples of sound a second, Hz.
pub const RATE: u32 = 48_000;

/// What of a motion is heard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// The velocity of the probe: what a laser vibrometer aimed at it would play.
    #[default]
    Velocity,
    /// The acceleration of the probe. The pressure far from a source much smaller than the wave length follows
    /// the acceleration of its surface: a proxy of the radiated sound, without the room and without the
    /// directions in which a body radiates.
    Pressure,
}

impl Source {
    /// What is heard, in a few words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Velocity => "velocity of the contact's centre",
            Self::Pressure => {
                "acceleration of the contact's centre, as the pressure far away follows it"
            }
        }
    }
}

/// Turns the velocity of the probe into what is heard.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pickup {
    source: Source,
    last: Option<f64>,
}

impl Pickup {
    /// Listens to so much of the motion.
    pub fn new(source: Source) -> Self {
        Self { source, last: None }
    }

    /// What is heard of velocities (m/s) that are `dt` (s) apart: the next piece, of the same length, m/s or
    /// m/s^2.
    pub fn hear<'a>(&'a mut self, velocity: &'a [f64], dt: f64) -> impl Iterator<Item = f64> + 'a {
        velocity.iter().map(move |&v| match self.source {
            Source::Velocity => v,
            Source::Pressure => {
                let before = self.last.replace(v).unwrap_or(v);
                (v - before) / dt
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressure_is_the_velocitys_rate_across_pieces() {
        let mut pickup = Pickup::new(Source::Pressure);
        let mut heard: Vec<f64> = pickup.hear(&[1.0, 3.0], 0.5).collect();
        heard.extend(pickup.hear(&[2.0], 0.5));
        assert_eq!(heard, [0.0, 4.0, -2.0]);
    }
}
