//! Limits how often a plot is redrawn.

use crate::pipeline::message::Frame;

/// Timer of the redraws of a plot, at most at the picture rate of the viewer; without a viewer every change
/// is drawn.
#[derive(Debug, Default)]
pub struct RedrawTimer {
    /// Minimum interval between two pictures, s.
    interval: f64,
    /// Time of the last picture, s.
    last: Option<f64>,
}

impl RedrawTimer {
    /// Takes the picture rate from a frame.
    pub fn set_rate(&mut self, frame: &Frame) {
        self.interval = frame.shown.map_or(0.0, |shown| 1.0 / shown.pictures);
    }

    /// Whether a picture is due at a time (s); if so, the interval starts again.
    pub fn is_due(&mut self, time: f64) -> bool {
        let due = self.last.is_none_or(|last| time >= last + self.interval);
        if due {
            self.last = Some(time);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::DisplayRates;

    #[test]
    fn pictures_for_a_viewer_keep_their_interval() {
        let mut due = RedrawTimer::default();
        assert!(due.is_due(0.0) && due.is_due(1e-3));
        due.set_rate(&Frame {
            shown: Some(DisplayRates {
                speed: 1.0,
                pictures: 20.0,
                every: 1,
                apart: 0,
            }),
            ..Frame::default()
        });
        let drawn = (1..=120).filter(|ms| due.is_due(1e-3 * f64::from(*ms)));
        assert_eq!(drawn.collect::<Vec<_>>(), [51, 101]);
        due.set_rate(&Frame::default());
        assert!(due.is_due(0.1211));
    }
}
