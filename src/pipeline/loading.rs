//! The loading of a simulated joint over time.

use crate::joint::{AssemblyError, BallJoint, Loading};
use crate::scene::LoadedJoint;

/// The times at which the loading of a joint changes, and its present value. A gradual change is applied at
/// multiples of a number of samples, counted from the start of the run, and a jump at its time: the motion does
/// not depend on the length of the frames.
#[derive(Debug)]
pub(super) struct LoadingClock {
    /// The scene's joint.
    pub tilted: LoadedJoint,
    /// Present tilt, load and rotation.
    pub now: Loading,
    /// Times of future jumps of the loading, s, in descending order.
    jumps: Vec<f64>,
    /// Samples between two updates of a loading that changes gradually: a frame of the scene. A frame of a
    /// live run may be shorter or longer.
    every: u64,
}

impl LoadingClock {
    /// The loading of a joint at the start of a run.
    pub fn new(tilted: LoadedJoint, every: u64) -> Self {
        let mut jumps = tilted.jumps();
        jumps.reverse();
        Self {
            now: tilted.loading(0.0),
            tilted,
            jumps,
            every,
        }
    }

    /// Takes the next jump up to a time (s).
    pub fn take_jump(&mut self, time: f64) -> Option<f64> {
        self.jumps.pop_if(|jump| *jump <= time)
    }

    /// The last sample, up to the given one, at which a gradual change is applied.
    pub fn last_update(&self, sample: u64) -> u64 {
        sample - sample % self.every
    }

    /// Number of samples from a sample on that belong to one joint.
    pub fn samples_until_change(&self, sample: u64, rate: f64) -> u64 {
        let until_update = if self.tilted.varies() {
            self.every - sample % self.every
        } else {
            u64::MAX
        };
        let next_jump = self.jumps.last();
        next_jump.map_or(until_update, |&jump| {
            until_update.min(first_sample_from(jump, rate) - sample)
        })
    }

    /// Continues with another joint from a time (s) on.
    pub fn replace(&mut self, tilted: LoadedJoint, now: f64) {
        self.now = tilted.loading(now);
        self.jumps = tilted.jumps();
        self.jumps.retain(|jump| *jump > now);
        self.jumps.reverse();
        self.tilted = tilted;
    }
}

/// The joint under the load and the rotation at time 0.
///
/// # Errors
/// As [`BallJoint::new`].
pub(super) fn ball_of(tilted: &LoadedJoint) -> Result<BallJoint, AssemblyError> {
    let mut ball = BallJoint::new(&tilted.spec)?;
    ball.set_probe_rotation(tilted.full_rotation);
    Ok(ball)
}

/// Reports an unreachable loading of a run of a duration (s) before the run: the patch is closest to the beam where
/// it is farthest from the pole, under the largest load.
///
/// # Errors
/// If the patch extends into the beam.
pub(super) fn check_reach(
    ball: &BallJoint,
    tilted: &LoadedJoint,
    duration: f64,
) -> Result<(), AssemblyError> {
    let mut ball = ball.clone();
    let [_, load] = tilted.load_span();
    let moved = tilted
        .loadings(duration)
        .filter_map(|now| Some((now.patch?.direction[2], now)));
    let farthest = moved.min_by(|a, b| a.0.total_cmp(&b.0));
    let start = Loading {
        patch: None,
        ..tilted.loading(0.0)
    };
    let ends = [tilted.tilt.min(), tilted.tilt.max()].map(|tilt| Loading { tilt, ..start });
    for at in farthest.map(|(_, at)| at).into_iter().chain(ends) {
        ball.set_loading(&Loading { load, ..at });
        ball.model(at.tilt)?;
    }
    Ok(())
}

/// Index of the first sample at or after a time (s).
fn first_sample_from(time: f64, rate: f64) -> u64 {
    let near = (time * rate).ceil() as u64;
    // Rounding of the product may shift the index by one.
    let is_from = |index: u64| index as f64 / rate >= time;
    match near {
        1.. if is_from(near - 1) => near - 1,
        _ if is_from(near) => near,
        _ => near + 1,
    }
}
