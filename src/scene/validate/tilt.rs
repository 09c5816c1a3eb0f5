//! Whether the contact slides at every tilt that is reached.

use crate::joint::JointSpec;
use crate::scene::Schedule;
use crate::scene::error::{Fault, Place, SceneError};
use crate::scene::keys;

/// The central contact point must slide at every tilt that is reached: otherwise Eq. (24) has no
/// direction. It does not where the load's axis meets the axis of rotation.
pub(in crate::scene) fn sliding(
    joint: &JointSpec,
    tilt: &Schedule,
    place: impl FnOnce() -> Place,
) -> Result<(), SceneError> {
    /// Angle between the two axes below which sliding has no certain direction, rad.
    const TOO_CLOSE: f64 = 1e-4;

    let [x, y, z] = joint.rotation;
    let (sin, cos) = joint.azimuth.sin_cos();
    // Across the plane in which the load tilts, and within it.
    let across = y * cos - x * sin;
    let within = x * cos + y * sin;
    let axis = within.atan2(z);
    let off_plane = across.abs().atan2(within.hypot(z));
    if off_plane > TOO_CLOSE {
        return Ok(());
    }
    let (lowest, highest) = (tilt.min() - TOO_CLOSE, tilt.max() + TOO_CLOSE);
    // An axis has two ends, half a turn apart.
    let half_turn = std::f64::consts::PI;
    let meets = [axis - half_turn, axis, axis + half_turn]
        .into_iter()
        .find(|end| (lowest..=highest).contains(end));
    match meets {
        None => Ok(()),
        Some(end) => Err(Fault::Inconsistent {
            key: keys::ROTATION.path,
            problem: format!(
                "at a tilt of {:.3} deg the load lies along the axis of rotation, so the central \
                 contact point does not slide",
                end.to_degrees()
            ),
            remedy: "change the rotation, load.azimuth_deg or the tilt".to_owned(),
        }
        .at(place())),
    }
}
