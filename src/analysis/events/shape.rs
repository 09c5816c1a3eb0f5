//! Which tones are events: a score from the shape of each.
//!
//! A knock excites resonances that die out at once; a struck note falls from its onset on; the pitch of a voice
//! glides, and its syllables follow each other; paths through noise are faint and crooked. A squeak is a plateau of level with
//! a smooth frequency that starts alone. Each of these is a number, and a weighted sum of them the score: the logarithm of the odds
//! of an event, fitted as a logistic regression to recordings with known squeaks. No number alone decides.
//! A recording full of struck notes or syllables is a hint only, which evidence of the tone itself outweighs.

use super::TonalEvent;
use super::baseband::averages;
use super::group::Group;
use super::partial::STEP_S;

/// A number about a tone, within limits, and its weight in the score.
struct Term {
    limits: [f64; 2],
    weight: f64,
}

const fn term(low: f64, high: f64, weight: f64) -> Term {
    Term {
        limits: [low, high],
        weight,
    }
}

/// The terms of the score in the order of [`Shape::numbers`]. The weights are those of the logistic
/// regression (`tests/it/squeaks`, seeds for tuning only).
const TERMS: [Term; NUMBERS] = [
    term(-8.0, 25.0, 0.213),
    term(-8.0, 0.0, 0.314),
    term(-2.0, 1.2, 2.31),
    term(5.0, 10.0, 1.71),
    term(-30.0, 15.0, 0.0492),
    term(0.0, 2.0, -1.04),
    term(0.0, 1.0, -6.92),
    term(0.0, 1.0, 6.47),
    term(0.0, 1.95, -3.38),
    term(0.0, 1.4, -2.07),
];
const NUMBERS: usize = 10;

/// Score of a tone all of whose numbers are 0, less the least score of an event.
const CONSTANT: f64 = -9.88;

/// Half of the time over which the level is averaged, steps.
const HALF_LEVEL: usize = 4;

/// Levels of the plateau and of dips, relative to the level that a tenth of the time is louder, dB.
const PLATEAU_DB: f64 = -3.0;
const DIP_DB: f64 = -7.0;
const DEEPEST_DB: f64 = -30.0;

/// Step of the frequencies whose range and bend are measured, steps of the track; three of them to each side.
const STRIDE: usize = 4;
const BEND: usize = 3;

/// Fall (dB/s) or relative range of frequency of a struck note or a syllable, its duration (s) and its
/// least signal-to-noise ratio (dB).
const FALL_DB_PER_S: f64 = 12.0;
const GLIDE: f64 = 0.03;
const NOTE_S: [f64; 2] = [0.12, 0.8];
const CLEAR_DB: f64 = 3.0;

/// Largest difference of the starts of tones that start together, and of an end and the start of the next note, s.
const TOGETHER_S: f64 = 0.03;
const AFTER_S: f64 = 0.05;

/// How a tone changes.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    snr_db: f64,
    duration_s: f64,
    frequency_hz: f64,
    /// Slope of the line of least squares through the level without a tenth at each end, dB/s.
    slope_db_per_s: f64,
    /// Median deviation of the frequency from the mean of those 0.06 s before and after, twofold, per cent.
    bend: f64,
    /// Share of the time in dips.
    dips: f64,
    /// Share of the time on the plateau.
    plateau: f64,
    /// Range of the middle 90 % of the frequencies, relative.
    glide: f64,
}

impl Shape {
    pub fn new(group: &Group, event: &TonalEvent) -> Self {
        let (_, leader) = group.leader();
        let power: Vec<f64> = leader.track.iter().map(|p| p.1).collect();
        let smooth = averages(&power, HALF_LEVEL);
        let loud = quantile(&smooth, 0.9).max(f64::MIN_POSITIVE);
        let levels: Vec<f64> = smooth
            .iter()
            .map(|p| db(p / loud).max(DEEPEST_DB))
            .collect();
        let share = |is: &dyn Fn(&f64) -> bool| {
            levels.iter().filter(|level| is(level)).count() as f64 / levels.len() as f64
        };
        let margin = levels.len() / 10;
        let frequencies: Vec<f64> = (0..leader.track.len())
            .step_by(STRIDE)
            .map(|i| leader.frequency_at(leader.time(i)) / leader.frequency_hz)
            .collect();
        let bends: Vec<f64> = frequencies
            .windows(2 * BEND + 1)
            .map(|w| (w[0] + w[2 * BEND] - 2.0 * w[BEND]).abs())
            .collect();
        Self {
            snr_db: event.snr_db,
            duration_s: event.span().length_s(),
            frequency_hz: event.frequency_hz,
            slope_db_per_s: slope(&levels[margin..levels.len() - margin]) / STEP_S,
            bend: 100.0 * quantile(&bends, 0.5),
            dips: share(&|level| *level < DIP_DB),
            plateau: share(&|level| *level > PLATEAU_DB),
            glide: quantile(&frequencies, 0.95) - quantile(&frequencies, 0.05),
        }
    }

    /// Whether this is like a struck note or a syllable.
    fn is_note(&self) -> bool {
        let changes = self.slope_db_per_s < -FALL_DB_PER_S || self.glide > GLIDE;
        let [least, most] = NOTE_S;
        changes && self.snr_db > CLEAR_DB && self.duration_s > least && self.duration_s < most
    }

    /// The numbers of the score, with those of the company.
    pub fn numbers(&self, company: [f64; 2]) -> [f64; NUMBERS] {
        [
            self.snr_db,
            self.snr_db.min(0.0),
            self.duration_s.max(1e-3).ln(),
            self.frequency_hz.ln(),
            self.slope_db_per_s,
            self.bend,
            self.dips,
            self.plateau,
            company[0],
            company[1],
        ]
    }

    /// Whether the tone is an event.
    pub fn is_event(&self, company: [f64; 2]) -> bool {
        let numbers = self.numbers(company);
        let terms = TERMS.iter().zip(numbers);
        let sum: f64 = terms
            .map(|(term, number)| term.weight * number.clamp(term.limits[0], term.limits[1]))
            .sum();
        CONSTANT + sum > 0.0
    }
}

/// What else sounds in a recording.
pub(super) struct Company {
    /// Number of sounds like a struck note or a syllable.
    notes: usize,
    /// Starts of all tones, s.
    starts: Vec<f64>,
}

impl Company {
    /// The company of tones from their shapes and starts (s).
    pub fn new<'a>(tones: impl Iterator<Item = (&'a Shape, f64)>) -> Self {
        let mut out = Self {
            notes: 0,
            starts: Vec::new(),
        };
        for (shape, start_s) in tones {
            out.notes += usize::from(shape.is_note());
            out.starts.push(start_s);
        }
        out
    }

    /// Logarithms of the number of notes, and of the number of other tones that start with a tone or where it
    /// ends, each plus 1.
    pub fn of(&self, event: &TonalEvent) -> [f64; 2] {
        let is_near = |start: &&f64| {
            (*start - event.start_s).abs() < TOGETHER_S || (*start - event.end_s).abs() < AFTER_S
        };
        // Less the tone itself.
        let together = self.starts.iter().filter(is_near).count().saturating_sub(1);
        [self.notes, together].map(|count| (count as f64).ln_1p())
    }
}

fn db(ratio: f64) -> f64 {
    10.0 * ratio.max(1e-20).log10()
}

/// The value that a share of the values is below; 0 for none.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = (sorted.len().saturating_sub(1) as f64 * share).round() as usize;
    sorted.get(index).copied().unwrap_or(0.0)
}

/// Slope of the line of least squares, per value.
fn slope(values: &[f64]) -> f64 {
    let middle = 0.5 * (values.len() as f64 - 1.0);
    let offsets = (0..values.len()).map(|i| i as f64 - middle);
    let (mut product, mut square) = (0.0, 0.0);
    for (x, y) in offsets.zip(values) {
        product += x * y;
        square += x * x;
    }
    if square > 0.0 { product / square } else { 0.0 }
}
