//! What the run shows now, decided from measured numbers only.
//!
//! A spectrum and an envelope cannot prove a torus or chaos, so the result is what the vibration *looks
//! like*. The words for it are read aloud, so they must not flicker: a change is reported only when
//! two observations in a row agree on it, limits have hysteresis, and tones are not reported while the
//! vibration still grows or fades, since the spectrum of a window that holds both smears. So the window
//! always starts after the last such change:
//!
//! * 20 ms after it a pure tone can be identified;
//! * 40 ms after it a torus can be distinguished from chaos; the floor must have been gone as long
//!   before chaos counts as ended. Less is not enough: nearby trajectories that
//!   separate as `exp(50 t / s)` look alike for 20 ms, and lines 240 Hz apart leave no room to
//!   see a floor between them in a window under `8 / 240 Hz`, two main lobes.
//!
//! # What the limits rest on
//!
//! The scenes that come with the program, seen through 40 ms without growth, every 5 ms (floor
//! as [`Spectrum::floor_share`](crate::analysis::Spectrum::floor_share); second tone as the
//! strongest line of the second base over the strongest line, velocities):
//!
//! | scene | floor | second tone | appearance |
//! |---|---|---|---|
//! | `periodic-2deg`, `mode-shift-3.5deg` | 2e-10 to 3e-10 | none | pure tone |
//! | `tilt-ramp`, to 95 ms (3 degrees just reached) | 5e-10 to 3e-7 | up to 0.036 | pure tone |
//! | `tilt-ramp`, 100 to 195 ms | 7e-6 to 8e-5 | 0.068 to 0.20 | two tones |
//! | `tilt-ramp`, from 205 ms (5.6 degrees) on | 9e-5 to 1.4e-3, median 7e-4 | 0.19 to 0.23 | broad floor |
//! | `torus-3deg`, seeds 1, 4, 5 | 1.3e-5 to 1.3e-4 | 0.16 | two tones |
//! | `chaos-5deg`, seeds 1, 2, 4 | 3e-5 (rarely) to 1.2e-3, median 6e-4 | 0.18 to 0.21 | broad floor |
//!
//! The torus at 3 degrees, reached from rest, is modulated at 40 Hz; its side lines merge with their
//! neighbours in 40 ms and make up its floor. Of the first five seeds the others go elsewhere:
//! to a tone of 2.0 kHz or to 7.5 with 4.7 kHz, floors below 2e-6; and seed 5 at 5 degrees to 2.0
//! with 12.2 kHz on a floor of 1.8e-4 to 3.6e-4. That one is reported as two tones and shows how near
//! the limit is: weak chaos and a torus with lines too close to resolve look the same in 40 ms.
//!
//! Growing, the envelope gains 3 to 4 (natural logarithm) in 5 ms; in its lasting form it keeps
//! to 0.1, chaos included.

use super::reading::{LINE_WINDOW, Reading, half_range, peak_magnitude};
use crate::analysis::{AnalysisError, Bases, SpectrumAnalyser};
use crate::pipeline::message::{Appearance, Circumstances, Vibration};

/// The envelope is followed in pieces of this length, s.
const PIECE: f64 = 5e-3;

/// Time without growth after which a pure tone is reported, s.
const BRIEF: f64 = 20e-3;

/// Growth of the root mean square from one piece to the next, as a natural logarithm: beyond the
/// first it is growing (or fading), until it is back below the second.
const GROWTH: Limits = Limits {
    enter: 0.69,
    leave: 0.22,
};

/// Peak velocity over sliding speed below which it is called silent (one leaves silence at the
/// larger, and enters it at the smaller).
const FAINT: Limits = Limits {
    enter: 0.5e-3,
    leave: 1e-3,
};

/// Peak velocity, m/s, below which it is called silent whatever the sliding speed: a joint at rest has
/// none to compare with.
const NOTHING: f64 = 1e-12;

/// Share of the power in the floor beyond which the floor is called broad.
const FLOOR: Limits = Limits {
    enter: 3e-4,
    leave: 6e-5,
};

/// Amplitude of the second tone over the first's beyond which there are two.
const SECOND: Limits = Limits {
    enter: 0.05,
    leave: 0.025,
};

/// Time after which the same appearance is reported again with current numbers, s.
const REFRESH: f64 = 50e-3;

/// Hysteresis.
struct Limits {
    enter: f64,
    leave: f64,
}

impl Limits {
    fn now(&self, inside: bool) -> f64 {
        if inside { self.leave } else { self.enter }
    }
}

/// The last samples at one instant, [`Narrator::MEMORY`] or what there is.
pub struct Heard<'a> {
    /// Time of the last sample, s.
    pub time: f64,
    /// What acts on the joint now.
    pub now: Circumstances,
    /// Velocity of the probe, m/s.
    pub velocity: &'a [f64],
    /// Displacement of the probe, m.
    pub displacement: &'a [f64],
}

/// Decides when there is something to report, and what.
pub struct Narrator {
    /// Samples a second, Hz.
    rate: f64,
    analyser: SpectrumAnalyser,
    /// When it last grew, faded or was silent, s.
    restless: f64,
    reported: Option<Report>,
    /// An appearance that differs from the one reported, and since when it has been seen.
    pending: Option<Report>,
}

/// An appearance and a time: what was reported last and when, or what has been seen and since when.
#[derive(Clone, Copy)]
struct Report {
    appearance: Appearance,
    time: f64,
}

/// How long a new appearance must have been seen before it replaces the one reported, s; it is always
/// seen twice. Chaos has calm stretches that look like the torus it came from, so its floor must have
/// been gone for as long as the narrator's memory.
fn patience(reported: Appearance, seen: Appearance) -> f64 {
    use Appearance::{Broad, Tone, TwoTones, Unsettled};
    match (reported, seen) {
        (Broad, Tone | TwoTones | Unsettled) => Narrator::MEMORY,
        _ => 0.0,
    }
}

impl Narrator {
    /// How far back it looks, s. Without growth for so long, a torus can be distinguished from chaos.
    pub const MEMORY: f64 = 40e-3;

    /// What it must have seen to begin with, s: growth is the ratio of two pieces.
    pub const FIRST: f64 = 2.0 * PIECE;

    /// Has reported nothing yet; for samples at `rate` (Hz).
    pub fn new(rate: f64) -> Self {
        Self {
            rate,
            analyser: SpectrumAnalyser::new(LINE_WINDOW, rate),
            restless: f64::NEG_INFINITY,
            reported: None,
            pending: None,
        }
    }

    /// Takes the samples up to now; returns what they show if it is time to report it.
    ///
    /// # Errors
    /// If there are too few samples for a spectrum.
    pub fn listen(&mut self, heard: &Heard<'_>) -> Result<Option<Vibration>, AnalysisError> {
        let envelope = Envelope::of(heard.velocity, self.rate);
        let change = self.change(&envelope, heard.now.sliding_speed);
        if change.is_some() {
            self.restless = heard.time;
        }
        let calm = ((heard.time - self.restless).max(Self::FIRST) * self.rate).round();
        let count = heard.velocity.len().min(calm as usize);
        let velocity = &heard.velocity[heard.velocity.len() - count..];
        let reading = Reading::of(&self.analyser.analyse(velocity)?);
        let appearance = change.unwrap_or_else(|| self.tones(&reading, count));
        let bases = reading.naming.bases;
        let (f1, f2) = match bases {
            Bases::None => (None, None),
            Bases::One { f1 } => (Some(f1), None),
            Bases::Two { f1, f2 } => (Some(f1), Some(f2)),
        };
        Ok(self.is_due(appearance, heard.time).then(|| Vibration {
            appearance,
            growth_rate: envelope.growth / PIECE,
            lines: reading.peaks(),
            f1,
            f2,
            beat: bases.beat(),
            second_tone: reading.second_tone(),
            floor_share: reading.floor,
            peak_speed: peak_magnitude(velocity),
            backward_speed: 0.0 - velocity.iter().copied().fold(0.0, f64::min),
            half_range: half_range(&heard.displacement[heard.displacement.len() - count..]),
            now: heard.now,
        }))
    }

    /// Whether to report this appearance now; if so, it counts as reported.
    fn is_due(&mut self, appearance: Appearance, time: f64) -> bool {
        // Half a sample of slack: times are sums of rounded numbers.
        let past = |since: f64, least: f64| time - since + 0.5 / self.rate >= least;
        let now = Report { appearance, time };
        let due = match (self.reported, self.pending) {
            (None, _) => appearance != Appearance::Settling,
            (Some(reported), _) if reported.appearance == appearance => {
                self.pending = None;
                past(reported.time, REFRESH)
            }
            (Some(reported), Some(seen)) if seen.appearance == appearance => {
                past(seen.time, patience(reported.appearance, appearance))
            }
            _ => {
                self.pending = Some(now);
                false
            }
        };
        if due {
            self.pending = None;
            self.reported = Some(now);
        }
        due
    }

    fn is(&self, appearance: Appearance) -> bool {
        let reported = self.reported;
        reported.is_some_and(|reported| reported.appearance == appearance)
    }

    /// The appearance of a vibration whose envelope changes, or that is hardly there.
    fn change(&self, envelope: &Envelope, sliding_speed: f64) -> Option<Appearance> {
        let faint = (FAINT.now(self.is(Appearance::Silent)) * sliding_speed).max(NOTHING);
        if envelope.growth > GROWTH.now(self.is(Appearance::Growing)) {
            Some(Appearance::Growing)
        } else if envelope.peak <= faint {
            Some(Appearance::Silent)
        } else if -envelope.growth > GROWTH.now(self.is(Appearance::Fading)) {
            Some(Appearance::Fading)
        } else {
            None
        }
    }

    /// The appearance of `count` samples of a vibration whose level has settled.
    fn tones(&self, reading: &Reading, count: usize) -> Appearance {
        // A sample of slack, as the window may be rounded.
        let heard = |seconds: f64| count as f64 + 1.0 > seconds * self.rate;
        let second = SECOND.now(self.is(Appearance::TwoTones));
        let pure = match reading.naming.bases {
            Bases::None => false,
            Bases::One { .. } => true,
            Bases::Two { .. } => reading.second_tone() <= second,
        };
        if heard(Self::MEMORY) && reading.floor > FLOOR.now(self.is(Appearance::Broad)) {
            Appearance::Broad
        } else if heard(BRIEF) && pure {
            Appearance::Tone
        } else if !heard(Self::MEMORY) {
            Appearance::Settling
        } else if reading.naming.bases == Bases::None {
            Appearance::Unsettled
        } else {
            Appearance::TwoTones
        }
    }
}

/// How loud it is, and whether that changes.
struct Envelope {
    /// Natural logarithm of the root mean square of the last piece over that of the piece before;
    /// 0 where one of them is zero.
    growth: f64,
    /// Largest speed in the last piece, m/s.
    peak: f64,
}

impl Envelope {
    /// From the last two pieces of `velocity`.
    fn of(velocity: &[f64], rate: f64) -> Self {
        let piece = ((PIECE * rate).round() as usize).min(velocity.len() / 2);
        let (before, last) = velocity[velocity.len() - 2 * piece..].split_at(piece);
        let power = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
        let ratio = power(last) / power(before);
        let both = ratio > 0.0 && ratio.is_finite();
        Self {
            growth: if both { 0.5 * ratio.ln() } else { 0.0 },
            peak: peak_magnitude(last),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::stages::synthetic_tests::{Motion, RATE, SLIDING_SPEED};

    const STEADY: Circumstances = Circumstances {
        tilt: 0.0,
        load: None,
        rotation_factor: None,
        sliding_speed: SLIDING_SPEED,
    };

    /// What the narrator makes of a tone with an exponential envelope that ends at `speed`.
    fn tell(narrator: &mut Narrator, rate: f64, speed: f64, time: f64) -> Option<Appearance> {
        let motion = Motion::tones(Narrator::MEMORY, &[(4117.0, speed, 0.0)]).with_growth(rate);
        let heard = Heard {
            time,
            now: STEADY,
            velocity: &motion.velocity,
            displacement: &motion.displacement,
        };
        let seen = narrator.listen(&heard).unwrap();
        seen.map(|vibration| vibration.appearance)
    }

    #[test]
    fn growth_is_that_of_the_envelope() {
        for rate in [750.0, 50.0, 0.0, -300.0] {
            let motion = Motion::tones(0.02, &[(4117.0, 1e-3, 0.0)]).with_growth(rate);
            // Pieces that do not hold whole periods are off by their last half period.
            let error = Envelope::of(&motion.velocity, RATE).growth / PIECE - rate;
            assert!(
                error.abs() < 0.02 * rate.abs() + 1.0,
                "{rate} off by {error}"
            );
        }
    }

    #[test]
    fn a_change_is_told_when_it_is_seen_twice() {
        let mut narrator = Narrator::new(RATE);
        let mut see = |rate, speed, k: u32| tell(&mut narrator, rate, speed, 1e-3 * f64::from(k));
        let (silent, growing) = (1e-3 * 1e-3 * SLIDING_SPEED, 1e-3);
        assert_eq!(see(0.0, silent, 0), Some(Appearance::Silent));
        assert_eq!(see(0.0, silent, 1), None);
        // Once is not enough, nor twice with the old face in between.
        assert_eq!(see(700.0, growing, 2), None);
        assert_eq!(see(0.0, silent, 3), None);
        assert_eq!(see(700.0, growing, 4), None);
        let told = see(700.0, growing, 5);
        assert_eq!(told, Some(Appearance::Growing));
        // Between the two limits of growth (44 and 138 a second) it stays what it was.
        assert_eq!(see(100.0, growing, 6), None);
        assert_eq!(see(100.0, growing, 7), None);
        // Calm: 20 ms after the last growth it is a tone, and growth takes more to be told again.
        assert_eq!(see(0.0, growing, 8), None);
        let told = see(0.0, growing, 9);
        assert_eq!(told, Some(Appearance::Settling));
        assert_eq!(see(0.0, growing, 26), None);
        assert_eq!(see(100.0, growing, 27), None);
        let told = see(0.0, growing, 28);
        assert_eq!(told, Some(Appearance::Tone));
        assert_eq!(see(-400.0, growing, 30), None);
        let told = see(-400.0, growing, 31);
        assert_eq!(told, Some(Appearance::Fading));
    }

    #[test]
    fn nothing_is_said_of_a_start_too_short_to_tell() {
        let motion = Motion::tones(Narrator::FIRST, &[(4117.0, 1e-3, 0.0)]);
        let mut narrator = Narrator::new(RATE);
        let heard = Heard {
            time: 0.0,
            now: STEADY,
            velocity: &motion.velocity,
            displacement: &motion.displacement,
        };
        assert_eq!(narrator.listen(&heard), Ok(None));
    }

    #[test]
    fn a_second_tone_counts_from_a_twentieth_on() {
        // The torus at 3 degrees with its second tone and its combinations weakened.
        for (second, appearance) in [(0.8, Appearance::Tone), (1.3, Appearance::TwoTones)] {
            let weak = |(f, a): (f64, f64)| (f, 0.05 * second * a, f);
            let mut tones = vec![(4112.9, 10e-3, 0.1), (12_338.7, 3e-3, 1.9)];
            tones.extend([(3873.0, 9e-3), (7985.9, 10e-3), (12_098.8, 5e-3)].map(weak));
            let motion = Motion::tones(Narrator::MEMORY, &tones);
            let mut narrator = Narrator::new(RATE);
            let heard = Heard {
                time: 0.0,
                now: STEADY,
                velocity: &motion.velocity,
                displacement: &motion.displacement,
            };
            let seen = narrator.listen(&heard).unwrap().unwrap();
            assert_eq!(seen.appearance, appearance, "{seen:?}");
        }
    }
}
