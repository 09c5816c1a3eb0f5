//! A second motion beside a first one, on the first one's steps.
//!
//! Two integrations of neighbouring states that choose their steps each for itself part by the
//! errors of their steps, long before the flow has parted them. On the same steps their errors are
//! the same but for what the flow makes of their difference, so that even a difference of a
//! millionth of those errors grows as the flow makes it grow.

use std::collections::VecDeque;

use super::{Integrator, Neighbour, Taken};
use crate::dynamics::control::Control;
use crate::dynamics::{DynamicsError, System};

/// The neighbour waits at most this many steps for someone to look at it.
const BEHIND: usize = 64;

impl Neighbour {
    /// A copy of a motion, from the state `z` on.
    pub fn new<Y: System + ?Sized>(
        first: &Integrator,
        sys: &Y,
        z: &[f64],
    ) -> Result<Self, DynamicsError> {
        let mut follower = first.alone();
        // Whatever the error, the step ends where the first motion's did.
        follower.pace.control = Control::Fixed(f64::INFINITY);
        let born = follower.time();
        follower.start(sys, born, z)?;
        Ok(Self {
            follower: Box::new(follower),
            born,
            ends: VecDeque::with_capacity(BEHIND + 1),
        })
    }

    /// Since when it is there, s.
    pub fn born(&self) -> f64 {
        self.born
    }

    /// Takes note of a step of the first motion that ended at `end` (s).
    pub fn note<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        end: f64,
        is_implicit: bool,
    ) -> Result<(), DynamicsError> {
        self.ends.push_back(Taken { end, is_implicit });
        if self.ends.len() > BEHIND {
            self.go_to_next_end(sys)?;
        }
        Ok(())
    }

    /// Takes note that the first motion's last step does not count.
    pub fn rewind(&mut self) {
        // Where that step has been followed already, landing at the end of the new one undoes it.
        self.ends.pop_back();
    }

    /// Writes its state at time `t` (s), to which the first motion has gone, to `out`.
    pub fn sample<Y: System + ?Sized>(
        &mut self,
        sys: &Y,
        t: f64,
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        while let Some(&Taken { end, is_implicit }) = self.ends.front() {
            if end >= t {
                self.follower.lead(is_implicit);
                self.follower.go_past(sys, t, end)?;
                break;
            }
            self.go_to_next_end(sys)?;
        }
        self.follower.sample(sys, t, out)
    }

    /// Goes on to time `t` (s), where the first motion is.
    pub fn catch_up<Y: System + ?Sized>(&mut self, sys: &Y, t: f64) -> Result<(), DynamicsError> {
        while !self.ends.is_empty() {
            self.go_to_next_end(sys)?;
        }
        self.follower.land(sys, t)
    }

    /// Goes on with a changed system.
    pub fn restart<Y: System + ?Sized>(&mut self, sys: &Y) -> Result<(), DynamicsError> {
        self.follower.restart(sys)
    }

    fn go_to_next_end<Y: System + ?Sized>(&mut self, sys: &Y) -> Result<(), DynamicsError> {
        match self.ends.pop_front() {
            Some(Taken { end, is_implicit }) => {
                self.follower.lead(is_implicit);
                self.follower.land(sys, end)
            }
            None => Ok(()),
        }
    }
}
