//! Whether the contact slides at every tilt that is reached.

use crate::joint::{BodySpec, JointSpec, patch_direction};
use crate::scene::Schedule;
use crate::scene::error::{Fault, Place, SceneError};
use crate::scene::subject::TiltedJoint;

/// The central contact point must slide at every tilt that is reached: otherwise Eq. (24) has no
/// direction. It does not where the load's axis meets the axis of rotation. A ball that does not turn
/// slides nowhere, at any tilt: its joint is at rest, and Eq. (24) is read in the direction of the tilt.
pub fn sliding(
    joint: &JointSpec,
    tilt: &Schedule,
    place: impl FnOnce() -> Place,
) -> Result<(), SceneError> {
    /// Angle between the two axes below which sliding has no certain direction, rad.
    const TOO_CLOSE: f64 = 1e-4;

    let [x, y, z] = joint.rotation;
    if joint.rotation == [0.0; 3] {
        return Ok(());
    }
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
        Some(end) => {
            let problem = format!(
                "at a tilt of {:.3} deg the load lies along the axis of rotation, so the central \
                 contact point does not slide",
                end.to_degrees()
            );
            let remedy = "change the rotation, load.azimuth_deg or the tilt";
            Err(Fault::inconsistent("rotation.rad_s", problem, remedy).at(place()))
        }
    }
}

/// A contact patch from a file is that of one load: it must be the scene's, and stay.
pub fn patch_stays(joint: &TiltedJoint, place: impl FnOnce() -> Place) -> Result<(), SceneError> {
    let TiltedJoint {
        spec, tilt, load, ..
    } = joint;
    let BodySpec::Own(modes) = &spec.body else {
        return Ok(());
    };
    let moved = if tilt.varies() {
        Some(("load.tilt", "load.tilt_deg", "the load tilts"))
    } else if load.as_ref().is_some_and(Schedule::varies) {
        Some(("load.load", "load.load_n", "the load changes"))
    } else {
        None
    };
    if let Some((key, constant, what)) = moved {
        let file = modes.name();
        let problem = format!("{what}, and the contact patch of `{file}` stays as it is");
        let remedy = format!("give a constant {constant}, or leave out body.modes");
        return Err(Fault::inconsistent(key, problem, remedy).at(place()));
    }
    let direction = patch_direction(tilt.at(0.0), spec.azimuth);
    modes
        .check_load(spec.load, direction)
        .map_err(|problem| SceneError::Modes {
            at: place(),
            file: modes.name().to_owned(),
            problem: Box::new(problem),
        })
}
