//! Sounds with pitch that are no sustained tones: knocks, struck notes, speech.
//!
//! A knock excites resonances that die out at once; a struck note falls from its onset on; the pitch of a voice glides, and a
//! syllable is short. One such sound alone can be a short squeak. Several of them make a recording of
//! speech or music, in which only what is long, level and steady in pitch is an event. A sung, bowed
//! or blown note is a tonal event: nothing in the sound tells it from a squeak.

use super::TonalEvent;

/// Time over which the change of level is taken, in steps of the ridge.
const SLOPE_STEPS: usize = 12;

/// Deepest level that counts, below the loudest, dB.
const DEEPEST_DB: f64 = 40.0;

/// Fall of a struck sound, dB/s; that of a resonance after a knock.
const STRUCK_DB_PER_S: f64 = 12.0;
const KNOCK_DB_PER_S: f64 = 40.0;

/// Length of a resonance after a knock, s; of a syllable; of the shortest event among speech or music.
const KNOCK_S: f64 = 0.3;
const SYLLABLE_S: f64 = 0.25;
const SUSTAINED_S: f64 = 0.4;

/// Shortest note or syllable, s: a knock seems to last for 0.1 s in the longest windows.
const NOTE_S: f64 = 0.14;

/// Relative range of frequency of a glide; largest among speech or music, and largest of any event.
const GLIDE: f64 = 0.04;
const STEADY: f64 = 0.033;
const LARGEST_GLIDE: f64 = 0.05;

/// Largest change of level of an event among speech or music, dB/s.
const LEVEL_DB_PER_S: f64 = 9.0;

/// Least signal-to-noise ratio of an event among speech or music, dB.
const CLEAR_SNR_DB: f64 = 6.0;

/// Onsets of sounds that make speech or music, and time between different onsets, s.
const ONSETS: usize = 4;
const ONSET_S: f64 = 0.06;

/// How a sound changes.
struct Shape {
    duration_s: f64,
    /// Median change of level, dB/s.
    slope: f64,
    /// Range of the middle 90 % of the frequencies, relative.
    glide: f64,
}

impl Shape {
    fn of(event: &TonalEvent) -> Self {
        let levels = event.ridge.iter().map(|point| point.level_db_fs);
        let least = levels.clone().fold(f64::MIN, f64::max) - DEEPEST_DB;
        let levels: Vec<f64> = levels.map(|level| level.max(least)).collect();
        let step = event.span().length_s() / event.ridge.len() as f64 * SLOPE_STEPS as f64;
        let changes = levels.windows(SLOPE_STEPS + 1);
        let mut slopes: Vec<f64> = changes.map(|w| (w[SLOPE_STEPS] - w[0]) / step).collect();
        slopes.sort_by(f64::total_cmp);
        let mut frequencies: Vec<f64> = event.ridge.iter().map(|p| p.frequency_hz).collect();
        frequencies.sort_by(f64::total_cmp);
        let at = |values: &[f64], share: f64| {
            let index = (values.len().saturating_sub(1) as f64 * share) as usize;
            values.get(index).copied()
        };
        let [low, high] = [0.05, 0.95].map(|share| at(&frequencies, share).unwrap_or(1.0));
        Self {
            duration_s: event.span().length_s(),
            slope: at(&slopes, 0.5).unwrap_or(0.0),
            glide: high / low - 1.0,
        }
    }

    fn is_fleeting(&self) -> bool {
        self.slope < -STRUCK_DB_PER_S || self.glide > GLIDE || self.duration_s < SYLLABLE_S
    }

    fn is_resonance(&self) -> bool {
        self.slope < -KNOCK_DB_PER_S && self.duration_s < KNOCK_S
    }

    fn is_sustained(&self) -> bool {
        self.duration_s > SUSTAINED_S && self.slope.abs() < LEVEL_DB_PER_S && self.glide < STEADY
    }
}

/// Leaves the events that are sustained tones, from candidates in the order of their starts.
pub(super) fn sustained(candidates: Vec<TonalEvent>, shortest_s: f64) -> Vec<TonalEvent> {
    let shapes: Vec<Shape> = candidates.iter().map(Shape::of).collect();
    let (mut onsets, mut last) = (0, f64::MIN);
    for (event, shape) in candidates.iter().zip(&shapes) {
        let is_note = shape.is_fleeting() && !shape.is_resonance() && shape.duration_s > NOTE_S;
        if is_note && event.start_s > last + ONSET_S {
            (onsets, last) = (onsets + 1, event.start_s);
        }
    }
    let is_event = |event: &TonalEvent, shape: &Shape| {
        shape.duration_s >= shortest_s
            && shape.glide < LARGEST_GLIDE
            && !shape.is_resonance()
            && (onsets < ONSETS || shape.is_sustained() && event.snr_db > CLEAR_SNR_DB)
    };
    let pairs = candidates.into_iter().zip(&shapes);
    pairs
        .filter_map(|(event, shape)| is_event(&event, shape).then_some(event))
        .collect()
}
