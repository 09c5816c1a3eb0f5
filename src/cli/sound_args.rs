//! Arguments of the commands with sound.

use std::path::PathBuf;

use clap::Args as Arguments;

use super::common_args::positive;
use crate::sound::{Place, Quantity, Source};

/// The sound file, the quantity that it plays, and the point of the surface.
#[derive(Debug, Default, Arguments)]
#[command(next_help_heading = "Sound")]
pub struct SoundArgs {
    /// Write the sound as a WAV file: 48 kHz, peak at -1 dBFS without --wav-level. `live` writes the first run, at
    /// real-time speed.
    #[arg(long, value_name = "FILE")]
    pub wav: Option<PathBuf>,
    /// Keep the true level, to compare runs by ear: full scale is this velocity, mm/s (with --sound pressure this
    /// acceleration, m/s^2).
    #[arg(long, value_name = "PEAK", value_parser = positive, requires = "wav")]
    pub wav_level: Option<f64>,
    /// Quantity that the sound represents.
    #[arg(long, value_enum, default_value_t = Quantity::Velocity)]
    pub sound: Quantity,
    /// Play the normal motion of the surface point nearest to X,Y,Z: mm from the ball's centre, beam at negative z
    /// [default: the contact's centre].
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub probe: Option<Point>,
}

impl SoundArgs {
    /// The quantity and its place.
    pub fn source(&self) -> Source {
        let unit = match self.sound {
            Quantity::Velocity => 1e-3,
            Quantity::Pressure => 1.0,
        };
        Source {
            full_scale: self.wav_level.map(|peak| unit * peak),
            quantity: self.sound,
            place: match self.probe {
                None => Place::Probe,
                Some(Point(mm)) => Place::Surface(mm.map(|x| 1e-3 * x)),
            },
        }
    }
}

/// A point, in mm from the ball's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub [f64; 3]);

fn point(text: &str) -> Result<Point, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let numbers = numbers.ok().and_then(|all| <[f64; 3]>::try_from(all).ok());
    let finite = numbers.filter(|all| all.iter().all(|x| x.is_finite()));
    finite
        .map(Point)
        .ok_or_else(|| "give three numbers, such as 8,0,60".to_owned())
}
