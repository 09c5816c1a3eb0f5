//! The squeak of a joint that turns to and fro: the tilts at which it starts and ends in each pass.

use crate::pipeline::message::{SqueakPass, TiltDirection};

/// Time below the limit after which the squeak has ended, s; a beat is shorter.
const PAUSE: f64 = 5e-3;

/// Detects the squeak in each pass, from one reversal to the next.
#[derive(Default)]
pub struct Turning {
    /// Level above which the joint squeaks, m/s.
    limit: f64,
    /// Present tilt, rad.
    tilt: Option<f64>,
    pub passes: Vec<SqueakPass>,
    /// Last time at which the level exceeded the limit, s.
    last_above: Option<f64>,
}

impl Turning {
    /// `limit`: level above which the joint squeaks, m/s.
    pub fn new(limit: f64) -> Self {
        Self {
            limit,
            ..Self::default()
        }
    }

    /// Sets the tilt (rad) of the following levels. A change of its direction begins a pass.
    pub fn set_tilt(&mut self, tilt: f64) {
        let Some(before) = self.tilt.replace(tilt).filter(|before| *before != tilt) else {
            return;
        };
        let way = TiltDirection::of(before, tilt);
        if self.passes.last().is_none_or(|pass| pass.way != way) {
            self.passes.push(SqueakPass {
                way,
                squeak: None,
                has_ended: false,
            });
            self.last_above = None;
        }
    }

    /// Processes the velocity level (m/s) at a time, s. A squeak that has ended may begin again: its end is the last
    /// one of the pass.
    pub fn push(&mut self, time: f64, level: f64) {
        let (Some(tilt), Some(pass)) = (self.tilt, self.passes.last_mut()) else {
            return;
        };
        if level > self.limit {
            let [first, _] = pass.squeak.unwrap_or([tilt; 2]);
            pass.squeak = Some([first, tilt]);
            pass.has_ended = false;
            self.last_above = Some(time);
        } else if self.last_above.is_some_and(|last| time - last > PAUSE) {
            pass.has_ended = true;
        }
    }

    /// Whether the joint squeaks.
    pub fn squeaks(&self) -> bool {
        let pass = self.passes.last();
        pass.is_some_and(|pass| pass.squeak.is_some() && !pass.has_ended)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tilt that rises from -10 to 10 and falls back in steps of 1, 10 ms each.
    fn turned(level: impl Fn(TiltDirection, i32) -> f64) -> Vec<SqueakPass> {
        let mut turning = Turning::new(1.0);
        for k in 0..=40 {
            let tilt = 10 - (k - 20i32).abs();
            let way = if k <= 20 {
                TiltDirection::Up
            } else {
                TiltDirection::Down
            };
            turning.set_tilt(f64::from(tilt));
            for part in 0..10 {
                let time = 1e-2 * f64::from(k) + 1e-3 * f64::from(part);
                turning.push(time, level(way, tilt));
            }
        }
        turning.passes
    }

    #[test]
    fn each_pass_has_the_tilts_at_which_the_squeak_starts_and_ends() {
        let found = turned(|way, tilt| match way {
            TiltDirection::Up => f64::from(u8::from((-7..=5).contains(&tilt))) * 2.0,
            TiltDirection::Down => f64::from(u8::from((-3..=8).contains(&tilt))) * 2.0,
        });
        let of = |k: usize| (found[k].way, found[k].squeak, found[k].has_ended);
        assert_eq!(found.len(), 2);
        assert_eq!(of(0), (TiltDirection::Up, Some([-7.0, 5.0]), true));
        assert_eq!(of(1), (TiltDirection::Down, Some([8.0, -3.0]), true));
    }

    #[test]
    fn a_silent_pass_has_no_squeak_and_a_sounding_one_no_end() {
        let found = turned(|way, _| match way {
            TiltDirection::Up => 0.5,
            TiltDirection::Down => 3.0,
        });
        assert_eq!((found[0].squeak, found[0].has_ended), (None, false));
        assert_eq!(
            (found[1].squeak, found[1].has_ended),
            (Some([9.0, -10.0]), false)
        );
    }

    #[test]
    fn a_beat_does_not_end_the_squeak() {
        let mut turning = Turning::new(1.0);
        turning.set_tilt(0.0);
        turning.set_tilt(1.0);
        for k in 0..100 {
            turning.push(1e-3 * f64::from(k), if k % 4 == 0 { 2.0 } else { 0.5 });
            assert!(!turning.passes[0].has_ended);
        }
    }
}
