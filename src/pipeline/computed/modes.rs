//! The linearised modes of a joint.

use crate::joint::{BallJoint, Joint, NamedMode};
use crate::pipeline::error::PipelineError;

/// The linearised modes of a joint, with their names.
pub fn linear_modes(ball: &BallJoint, joint: &Joint) -> Result<Vec<NamedMode>, PipelineError> {
    let families = ball.family_labels();
    let modes = joint.linear_modes()?.into_iter();
    Ok(modes.map(|mode| mode.named(&families)).collect())
}
