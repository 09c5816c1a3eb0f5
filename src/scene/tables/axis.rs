//! Checks that the contact slides, and that an imported patch is valid for the load.

use super::load::{LOAD, TILT};
use crate::joint::{BodySpec, patch_direction};
use crate::scene::document::Document;
use crate::scene::error::{SceneError, ensure};
use crate::scene::subject::LoadedJoint;

/// Checks that the central contact point slides at every tilt of the run; otherwise the direction of Eq. (24)
/// is undefined. The point does not slide if the load is parallel to the axis of rotation. A joint without
/// rotation is accepted: it is at rest, and Eq. (24) uses the direction of the tilt.
pub fn check_sliding(document: &Document<'_>, joint: &LoadedJoint) -> Result<(), SceneError> {
    /// Angle between the two axes below which the sliding direction is ill-conditioned, rad.
    const TOO_CLOSE: f64 = 1e-4;

    let [x, y, z] = joint.spec.rotation;
    if joint.spec.rotation == [0.0; 3] {
        return Ok(());
    }
    let (sin, cos) = joint.spec.azimuth.sin_cos();
    // Components normal to the tilt plane and in it.
    let across = y * cos - x * sin;
    let within = x * cos + y * sin;
    let axis = within.atan2(z);
    let off_plane = across.abs().atan2(within.hypot(z));
    if off_plane > TOO_CLOSE {
        return Ok(());
    }
    let (lowest, highest) = (joint.tilt.min() - TOO_CLOSE, joint.tilt.max() + TOO_CLOSE);
    // The axis has two opposite directions.
    let half_turn = std::f64::consts::PI;
    for end in [axis - half_turn, axis, axis + half_turn] {
        ensure!(document,
            !(lowest..=highest).contains(&end) => "rotation.angular_velocity_rad_per_s", &tilt_keys();
            "at a tilt of {:.3} deg the load is parallel to the axis of rotation, and the central contact point does \
             not slide", end.to_degrees();
            "change the axis, load.azimuth_deg or the tilt");
    }
    Ok(())
}

/// Checks that load and tilt are constant and equal to those of an imported contact patch.
pub fn check_imported_patch(
    document: &Document<'_>,
    joint: &LoadedJoint,
) -> Result<(), SceneError> {
    let (spec, tilt) = (&joint.spec, &joint.tilt);
    let BodySpec::Imported(modes) = &spec.body else {
        return Ok(());
    };
    let others = vec!["rotation.moves_patch", "body.modes"];
    let keys = [tilt_keys(), LOAD.paths(), others].concat();
    ensure!(document, !(tilt.varies() || joint.load.varies() || joint.patch_moves()) => "body.modes", &keys;
        "the contact patch of `{}` is valid for one load and tilt only, which change with time", modes.name();
        "set a constant load.tilt_deg and load.load_n without rotation.moves_patch, or remove body.modes");
    let direction = patch_direction(tilt.at(0.0), spec.azimuth);
    modes
        .check_load(spec.load, direction)
        .map_err(|problem| SceneError::modes(document.place_of(keys), modes.name(), &problem))
}

fn tilt_keys() -> Vec<&'static str> {
    [TILT.paths(), vec!["load.azimuth_deg"]].concat()
}
