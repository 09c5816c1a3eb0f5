//! What the search for tonal events returns.

use schemars::JsonSchema;
use serde::Serialize;

use super::ridge::value_at;

/// An interval of time in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Span {
    /// Start, s in the time of the recording.
    pub start_s: f64,
    /// End, s in the time of the recording.
    pub end_s: f64,
}

impl Span {
    /// Length, s.
    pub fn length_s(&self) -> f64 {
        self.end_s - self.start_s
    }
}

/// One point of a ridge: frequency and level of a partial at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RidgePoint {
    /// Time, s in the time of the recording.
    pub time_s: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Level of the ridge, dB relative to the level reference.
    pub level_db: f64,
}

/// Periodic modulation of the amplitude of an event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Modulation {
    /// Frequency of the modulation of the amplitude, Hz.
    pub modulation_hz: f64,
    /// Depth of the modulation `m` in `1 + m cos(2 pi f t)`: 0 to 1 for a sine; more for a pulsating tone.
    pub modulation_depth: f64,
}

/// Periodic modulation of the frequency of an event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Vibrato {
    /// Frequency of the vibrato, Hz.
    pub vibrato_hz: f64,
    /// Largest deviation of the vibrato from the mean frequency, Hz.
    pub vibrato_deviation_hz: f64,
}

/// Kind of an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema, strum::Display)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "lowercase")]
pub enum EventKind {
    /// A sustained tone, such as a squeak.
    #[default]
    Tone,
    /// Noise of a resonance: level and phase fluctuate.
    #[strum(to_string = "narrow-band noise")]
    NarrowBandNoise,
    /// A series of bursts of a resonance: creak, chatter, rattle.
    Bursts,
}

/// A tonal event: a sustained tone with its harmonics, from a start to an end. The frequency may drift and
/// vibrate, the amplitude may be modulated.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TonalEvent {
    /// Kind. Only a tone is a squeak.
    pub kind: EventKind,
    /// Estimated probability of this kind, from recordings whose sounds are known, 0 to 1.
    pub probability: f64,
    /// Start, s in the time of the recording.
    pub start_s: f64,
    /// End, s in the time of the recording.
    pub end_s: f64,
    /// Frequency of the fundamental, mean over the event weighted by its power, Hz.
    pub frequency_hz: f64,
    /// Low end of the frequency range of the fundamental, Hz.
    pub frequency_low_hz: f64,
    /// High end of the frequency range of the fundamental, Hz.
    pub frequency_high_hz: f64,
    /// Number of harmonics found, the fundamental included.
    pub harmonics: usize,
    /// Level of the event: mean power with its harmonics and sidebands, dB relative to the level reference.
    pub level_db: f64,
    /// Signal-to-noise ratio: power of the fundamental over the noise in the third octave around it, dB.
    pub snr_db: f64,
    /// Modulation of the amplitude, where there is one.
    #[serde(flatten)]
    pub modulation: Option<Modulation>,
    /// Modulation of the frequency, where there is one.
    #[serde(flatten)]
    pub vibrato: Option<Vibrato>,
    /// Ridge of the fundamental, at equal steps of time.
    pub ridge: Vec<RidgePoint>,
}

impl TonalEvent {
    /// The interval in which the event sounds.
    pub fn span(&self) -> Span {
        Span {
            start_s: self.start_s,
            end_s: self.end_s,
        }
    }

    /// Frequency of the fundamental at a time (s), interpolated along the ridge and constant beyond it, Hz.
    pub fn frequency_at(&self, time_s: f64) -> f64 {
        let of = |point: &RidgePoint| [point.time_s, point.frequency_hz];
        value_at(&self.ridge, of, time_s).unwrap_or(self.frequency_hz)
    }
}

/// Mains hum: steady lines at multiples of 50 or 60 Hz.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Hum {
    /// Fundamental, measured near 50 or 60 Hz, Hz.
    pub fundamental_hz: f64,
    /// Number of multiples of the fundamental found.
    pub harmonics: usize,
    /// Level of all of them together, dB relative to the level reference.
    pub level_db: f64,
}

/// All tonal events of a recording, in the order of their starts, and what was recognised as no event.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct TonalEvents {
    /// The events, in the order of their starts.
    pub events: Vec<TonalEvent>,
    /// Mains hum, if there is any.
    pub hum: Option<Hum>,
}
