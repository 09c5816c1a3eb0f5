//! When a picture is drawn anew.

use crate::pipeline::message::Frame;

/// Lets a picture be drawn each time it changes or, where somebody watches, no more often than a screen shows it.
#[derive(Debug, Default)]
pub struct Due {
    /// Time between two pictures, at least, s.
    apart: f64,
    /// Time of the last one, s.
    last: Option<f64>,
}

impl Due {
    /// Takes from a frame how often pictures are shown.
    pub fn follow(&mut self, frame: &Frame) {
        self.apart = frame.shown.map_or(0.0, |shown| 1.0 / shown.pictures);
    }

    /// Whether a picture of this time (s) is to be drawn; the next one counts from it.
    pub fn is_due(&mut self, time: f64) -> bool {
        let due = self.last.is_none_or(|last| time >= last + self.apart);
        if due {
            self.last = Some(time);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::message::Shown;

    #[test]
    fn where_somebody_watches_pictures_keep_their_distance() {
        let mut due = Due::default();
        assert!(due.is_due(0.0) && due.is_due(1e-3));
        due.follow(&Frame {
            shown: Some(Shown {
                pictures: 20.0,
                every: 1,
                apart: 0,
            }),
            ..Frame::default()
        });
        let drawn = (1..=120).filter(|ms| due.is_due(1e-3 * f64::from(*ms)));
        assert_eq!(drawn.collect::<Vec<_>>(), [51, 101]);
        due.follow(&Frame::default());
        assert!(due.is_due(0.1211));
    }
}
