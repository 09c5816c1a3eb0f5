//! Checks that the contact slides, and that an imported patch is valid for the load.

use crate::joint::{BodySpec, JointSpec, patch_direction};
use crate::scene::Schedule;
use crate::scene::error::{Fault, Location, SceneError};
use crate::scene::subject::LoadedJoint;

/// Checks that the central contact point slides at every tilt of the run; otherwise the direction of Eq. (24)
/// is undefined. The point does not slide if the load is parallel to the axis of rotation. A joint without
/// rotation is accepted: it is at rest, and Eq. (24) uses the direction of the tilt.
pub fn check_sliding(
    joint: &JointSpec,
    tilt: &Schedule,
    place: impl FnOnce() -> Location,
) -> Result<(), SceneError> {
    /// Angle between the two axes below which the sliding direction is ill-conditioned, rad.
    const TOO_CLOSE: f64 = 1e-4;

    let [x, y, z] = joint.rotation;
    if joint.rotation == [0.0; 3] {
        return Ok(());
    }
    let (sin, cos) = joint.azimuth.sin_cos();
    // Components normal to the tilt plane and in it.
    let across = y * cos - x * sin;
    let within = x * cos + y * sin;
    let axis = within.atan2(z);
    let off_plane = across.abs().atan2(within.hypot(z));
    if off_plane > TOO_CLOSE {
        return Ok(());
    }
    let (lowest, highest) = (tilt.min() - TOO_CLOSE, tilt.max() + TOO_CLOSE);
    // The axis has two opposite directions.
    let half_turn = std::f64::consts::PI;
    let meets = [axis - half_turn, axis, axis + half_turn]
        .into_iter()
        .find(|end| (lowest..=highest).contains(end));
    match meets {
        None => Ok(()),
        Some(end) => {
            let problem = format!(
                "at a tilt of {:.3} deg the load is parallel to the axis of rotation, and the central \
                 contact point does not slide",
                end.to_degrees()
            );
            let remedy = "change the axis, load.azimuth_deg or the tilt";
            Err(
                Fault::inconsistent("rotation.angular_velocity_rad_per_s", problem, remedy)
                    .at(place()),
            )
        }
    }
}

/// Checks that load and tilt are constant and equal to those of an imported contact patch.
pub fn check_imported_patch(
    joint: &LoadedJoint,
    place: impl FnOnce() -> Location,
) -> Result<(), SceneError> {
    let LoadedJoint {
        spec, tilt, load, ..
    } = joint;
    let BodySpec::Imported(modes) = &spec.body else {
        return Ok(());
    };
    let moved = if tilt.varies() {
        Some((
            "load.tilt",
            "the tilt changes with time",
            "set a constant load.tilt_deg",
        ))
    } else if load.as_ref().is_some_and(Schedule::varies) {
        Some((
            "load.load",
            "the load changes with time",
            "set a constant load.load_n",
        ))
    } else if joint.patch_moves() {
        let key = "rotation.moves_patch";
        Some((
            key,
            "the rotation moves the patch",
            "remove rotation.moves_patch",
        ))
    } else {
        None
    };
    if let Some((key, what, fix)) = moved {
        let file = modes.name();
        let problem = format!(
            "{what}, but the contact patch of `{file}` is valid for one load and tilt only"
        );
        let remedy = format!("{fix}, or remove body.modes");
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
