//! Arguments of the commands that can be heard.

use std::path::PathBuf;

use clap::Args as Arguments;

use crate::sound::{Place, Quantity, Source};

/// What is heard of a run.
#[derive(Debug, Default, Arguments)]
pub struct SoundArgs {
    /// Write the sound, 48 kHz, the loudest at -1 dB; `live`: of the first run, in real time.
    #[arg(long, value_name = "FILE")]
    pub wav: Option<PathBuf>,
    /// What is heard.
    #[arg(long, value_enum, default_value_t = Quantity::Velocity)]
    pub sound: Quantity,
    /// Listen to the body's surface nearest to this point (mm from the ball's centre; the beam is along z), outwards [default: the contact's centre].
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub at: Option<Point>,
}

impl SoundArgs {
    /// What is heard.
    pub fn source(&self) -> Source {
        Source {
            quantity: self.sound,
            place: match self.at {
                None => Place::Probe,
                Some(Point(mm)) => Place::Surface(mm.map(|x| 1e-3 * x)),
            },
        }
    }
}

/// A point, mm from the ball's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point(pub [f64; 3]);

fn point(text: &str) -> Result<Point, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let numbers = numbers.ok().and_then(|all| <[f64; 3]>::try_from(all).ok());
    let finite = numbers.filter(|all| all.iter().all(|x| x.is_finite()));
    finite
        .map(Point)
        .ok_or_else(|| "write three numbers, such as 8,0,60".to_owned())
}
