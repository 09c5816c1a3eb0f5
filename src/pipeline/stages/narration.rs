//! Narration: what is being seen now, in words that rest on measured numbers only.
//!
//! A spectrum and an envelope cannot prove a torus or chaos, so the words say what it *looks
//! like*. To keep them from flickering, a change is told only when two observations in a row
//! agree on it, and limits are easier to stay beyond than to cross.

use super::{Reading, words};
use crate::analysis::Bases;

/// Growth of the root mean square from one quarter of the window to the next, as a natural
/// logarithm: beyond the first it is growing (or fading), until it is back below the second.
const GROWTH: Limits = Limits {
    enter: 0.69,
    leave: 0.22,
};

/// Broadband share beyond which the floor is called broad.
const BROADBAND: Limits = Limits {
    enter: 0.02,
    leave: 0.01,
};

/// Peak velocity over sliding speed below which it is called silent (one leaves silence at the
/// larger, and enters it at the smaller).
const FAINT: Limits = Limits {
    enter: 0.5e-3,
    leave: 1e-3,
};

/// Time after which the same face is told again with the numbers of the day, s.
const REFRESH: f64 = 25e-3;

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

/// What one spectrum's window gives to speak of.
pub struct Observation<'a> {
    /// End of the window, s.
    pub time: f64,
    /// Tilt now, rad.
    pub tilt: f64,
    /// The lines and their names.
    pub reading: &'a Reading,
    /// The window's velocity, m/s.
    pub velocity: &'a [f64],
    /// Samples a second, Hz.
    pub sample_rate: f64,
    /// Half the peak-to-peak displacement, m.
    pub amplitude: f64,
    /// Largest speed, m/s.
    pub peak_velocity: f64,
}

impl Observation<'_> {
    /// Natural logarithm of the root mean square of the window's last quarter over that of the
    /// quarter before; 0 where one of them is zero.
    pub fn log_growth(&self) -> f64 {
        let quarter = self.velocity.len() / 4;
        let (before, last) = self.velocity[self.velocity.len() - 2 * quarter..].split_at(quarter);
        let power = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
        let ratio = power(last) / power(before);
        if ratio > 0.0 && ratio.is_finite() {
            0.5 * ratio.ln()
        } else {
            0.0
        }
    }

    /// Growth rate that [`Observation::log_growth`] means, 1/s.
    pub fn growth_rate(&self) -> f64 {
        let quarter = self.velocity.len() / 4;
        self.log_growth() * self.sample_rate / quarter as f64
    }

    /// Largest speed in the window's last quarter, m/s.
    fn recent_peak(&self) -> f64 {
        super::peak_magnitude(&self.velocity[3 * self.velocity.len() / 4..])
    }
}

/// The faces a run can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Hardly anything moves.
    Silent,
    /// The envelope rises.
    Growing,
    /// The envelope falls.
    Fading,
    /// One fundamental and its harmonics.
    Tone,
    /// Two base frequencies and their combinations.
    TwoTones,
    /// Lines over a broad floor.
    Broad,
    /// Lines without a simple pattern, or none.
    Unsettled,
}

/// Decides when to speak, and of what.
pub struct Narrator {
    /// Slip speed in steady sliding, m/s: what velocities are compared with.
    sliding_speed: f64,
    told: Option<Told>,
    /// A face seen once that differs from the one told.
    pending: Option<Face>,
}

/// What was said last.
#[derive(Clone, Copy)]
struct Told {
    face: Face,
    time: f64,
}

impl Narrator {
    /// Has said nothing yet.
    pub fn new(sliding_speed: f64) -> Self {
        Self {
            sliding_speed,
            told: None,
            pending: None,
        }
    }

    /// Takes the next observation; returns words (Markdown) if there is something new to say.
    pub fn observe(&mut self, seen: &Observation<'_>) -> Option<String> {
        let face = self.face(seen);
        let due = match self.told {
            None => true,
            Some(told) if told.face == face => {
                self.pending = None;
                // Half a sample of slack: times are sums of rounded numbers.
                seen.time - told.time + 0.5 / seen.sample_rate >= REFRESH
            }
            Some(_) => self.pending.replace(face) == Some(face),
        };
        if !due {
            return None;
        }
        self.pending = None;
        self.told = Some(Told {
            face,
            time: seen.time,
        });
        Some(words::describe(face, seen, self.sliding_speed))
    }

    fn face(&self, seen: &Observation<'_>) -> Face {
        let is = |face| self.told.is_some_and(|told| told.face == face);
        let growth = seen.log_growth();
        let faint = FAINT.now(is(Face::Silent)) * self.sliding_speed;
        if growth > GROWTH.now(is(Face::Growing)) {
            Face::Growing
        } else if seen.recent_peak() <= faint {
            Face::Silent
        } else if -growth > GROWTH.now(is(Face::Fading)) {
            Face::Fading
        } else if seen.reading.broadband > BROADBAND.now(is(Face::Broad)) {
            Face::Broad
        } else {
            match seen.reading.naming.bases {
                Bases::One { .. } => Face::Tone,
                Bases::Two { .. } => Face::TwoTones,
                Bases::None => Face::Unsettled,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{SpectrumAnalyser, Window};
    use crate::pipeline::stages::synthetic::{Motion, RATE, SLIDING_SPEED};

    /// What the narrator makes of a tone with an exponential envelope that ends at `speed`.
    fn observe<T>(rate: f64, speed: f64, time: f64, then: impl FnOnce(&Observation<'_>) -> T) -> T {
        let motion = Motion::tones(20e-3, &[(4117.0, speed, 0.0)]).with_growth(rate);
        let mut analyser = SpectrumAnalyser::new(Window::BlackmanHarris, RATE);
        let spectrum = analyser.analyse(&motion.velocity).unwrap();
        then(&Observation {
            time,
            tilt: 0.0,
            reading: &Reading::of(&spectrum),
            velocity: &motion.velocity,
            sample_rate: RATE,
            amplitude: 0.0,
            peak_velocity: speed,
        })
    }

    #[test]
    fn growth_rate_is_that_of_the_envelope() {
        for rate in [750.0, 50.0, 0.0, -300.0] {
            // Quarters that do not hold whole periods are off by their last half period.
            observe(rate, 1e-3, 0.0, |seen| {
                let error = seen.growth_rate() - rate;
                assert!(
                    error.abs() < 0.02 * rate.abs() + 1.0,
                    "{rate} off by {error}"
                );
            });
        }
    }

    #[test]
    fn a_change_is_told_when_it_is_seen_twice() {
        let mut narrator = Narrator::new(SLIDING_SPEED);
        let mut see = |rate, speed, k: u32| {
            let told = observe(rate, speed, 1e-3 * f64::from(k), |seen| {
                narrator.observe(seen)
            });
            told.map(|text| text.lines().next().unwrap_or_default().to_owned())
        };
        let (silent, growing) = (1e-3 * 1e-3 * SLIDING_SPEED, 1e-3);
        assert_eq!(see(0.0, silent, 0).as_deref(), Some("## Silent"));
        assert_eq!(see(0.0, silent, 1), None);
        // Once is not enough, nor twice with the old face in between.
        assert_eq!(see(700.0, growing, 2), None);
        assert_eq!(see(0.0, silent, 3), None);
        assert_eq!(see(700.0, growing, 4), None);
        assert_eq!(
            see(700.0, growing, 5).as_deref(),
            Some("## A vibration is growing")
        );
        // Between the two limits of growth (44 and 138 a second here) it stays what it was.
        assert_eq!(see(100.0, growing, 6), None);
        assert_eq!(see(100.0, growing, 7), None);
        assert_eq!(see(0.0, growing, 8), None);
        assert_eq!(see(100.0, growing, 9), None);
        assert_eq!(see(0.0, growing, 10), None);
        assert_eq!(
            see(0.0, growing, 11).as_deref(),
            Some("## Looks like a pure tone")
        );
        assert_eq!(see(100.0, growing, 12), None);
        assert_eq!(see(100.0, growing, 13), None);
        assert_eq!(see(-400.0, growing, 14), None);
        assert_eq!(
            see(-400.0, growing, 15).as_deref(),
            Some("## The vibration is fading")
        );
    }
}
