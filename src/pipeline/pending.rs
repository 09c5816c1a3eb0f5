//! Commands that wait for a run: however many come, they take the room of a few.

/// What a steered run can be told.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Tilt the load, rad; see [`Steerable::tilt`](super::Steerable::tilt).
    Tilt(f64),
    /// Add a random velocity to each mode; see [`Steerable::kick`](super::Steerable::kick).
    Kick {
        /// Standard deviation, sqrt(kg) m/s.
        size: f64,
        /// Of the random numbers.
        seed: u64,
    },
    /// Stop the simulated time.
    Pause,
    /// Let it go on.
    Resume,
    /// Make one frame, and stop.
    Step,
    /// Go at a pace from now on: simulated seconds a second, above 0.
    Pace(f64),
    /// End the run.
    End,
}

/// Kicks that one frame takes, at most.
pub const KICKS_A_FRAME: usize = 4;

/// A frame has all the kicks that it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a frame takes at most {KICKS_A_FRAME} kicks: kick again after the next frame")]
pub struct TooManyKicks;

/// The commands given since the last frame, combined.
///
/// Of tilts, playback speeds, and pause and resume, the last one counts. A single step pauses the run, and is
/// cancelled by a resume; several are one. Kicks add up to [`KICKS_A_FRAME`], and follow the tilt. An end is final.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pending {
    /// Tilt, rad.
    pub(super) tilt: Option<f64>,
    /// Size (sqrt(kg) m/s) and seed of each.
    pub(super) kicks: Vec<(f64, u64)>,
    pub(super) control: Control,
}

/// The commands that a run obeys at once, even while it is paused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Control {
    pub pause: Option<bool>,
    pub step: bool,
    /// Simulated seconds a second.
    pub pace: Option<f64>,
    pub end: bool,
}

impl Pending {
    /// Adds a command.
    ///
    /// # Errors
    /// [`TooManyKicks`], and nothing has changed.
    pub fn add(&mut self, order: Order) -> Result<(), TooManyKicks> {
        let control = &mut self.control;
        match order {
            Order::Tilt(tilt) => self.tilt = Some(tilt),
            Order::Kick { .. } if self.kicks.len() >= KICKS_A_FRAME => return Err(TooManyKicks),
            Order::Kick { size, seed } => self.kicks.push((size, seed)),
            Order::Pause => control.pause = Some(true),
            Order::Resume => (control.pause, control.step) = (Some(false), false),
            Order::Step => (control.pause, control.step) = (Some(true), true),
            Order::Pace(pace) => control.pace = Some(pace),
            Order::End => control.end = true,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_commands_are_combined_into_a_few() {
        let mut pending = Pending::default();
        let mut refused = 0;
        for k in 0..1_000_000_u64 {
            let x = k as f64;
            let kick = Order::Kick { size: x, seed: k };
            for order in [Order::Tilt(x), Order::Pause, Order::Pace(1.0 + x), kick] {
                refused += u64::from(pending.add(order).is_err());
            }
        }
        assert_eq!(refused, 1_000_000 - KICKS_A_FRAME as u64);
        let expected = Pending {
            tilt: Some(999_999.0),
            kicks: (0..KICKS_A_FRAME as u64).map(|k| (k as f64, k)).collect(),
            control: Control {
                pause: Some(true),
                pace: Some(1e6),
                ..Control::default()
            },
        };
        assert_eq!(pending, expected);
    }

    #[test]
    fn the_last_of_pause_step_and_resume_counts() {
        let after = |orders: &[Order]| {
            let mut pending = Pending::default();
            for order in orders {
                pending.add(order.clone()).unwrap();
            }
            (pending.control.pause, pending.control.step)
        };
        assert_eq!(after(&[Order::Pause, Order::Resume]), (Some(false), false));
        assert_eq!(after(&[Order::Step, Order::Resume]), (Some(false), false));
        assert_eq!(after(&[Order::Resume, Order::Step]), (Some(true), true));
        assert_eq!(after(&[Order::Step, Order::Pause]), (Some(true), true));
    }
}
