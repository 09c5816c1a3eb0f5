//! The tilt as a function of time, and whether the contact slides at all of it.

use crate::joint::{BodySpec, JointSpec, patch_direction};
use crate::scene::Schedule;
use crate::scene::error::{Fault, Place, SceneError};
use crate::scene::file::Document;
use crate::scene::keys;

pub(super) fn tilt(document: &Document<'_>) -> Result<Schedule, SceneError> {
    let elements = match (
        document.find(&keys::TILT)?,
        document.list(&keys::TILT_KNOTS)?,
    ) {
        (Some(tilt), None) => return Ok(Schedule::constant(tilt)),
        (None, Some(elements)) => elements,
        (None, None) => return Err(document.missing(&keys::TILT)),
        (Some(_), Some(_)) => {
            return Err(document.inconsistent(
                keys::TILT_KNOTS.path,
                &[keys::TILT.path],
                "the tilt is given twice, as a constant and as a function of time",
                "keep one of load.tilt_deg and load.tilt",
            ));
        }
    };
    let mut knots: Vec<(f64, f64)> = Vec::with_capacity(elements.len());
    for element in &elements {
        let time = document.get_in(element, &keys::KNOT_TIME)?;
        let tilt = document.get_in(element, &keys::KNOT_TILT)?;
        if let Some(&(before, _)) = knots.last()
            && time <= before
        {
            return Err(out_of_order(document.place_of_element(element)));
        }
        knots.push((time, tilt));
    }
    Schedule::through(knots)
        .ok_or_else(|| out_of_order(document.place_of(&[keys::TILT_KNOTS.path])))
}

fn out_of_order(place: Place) -> SceneError {
    Fault::Inconsistent {
        key: keys::KNOT_TIME.path,
        problem: "this knot is not later than the one before".to_owned(),
        remedy: "put the knots in order, each time once".to_owned(),
    }
    .at(place)
}

/// The central contact point must slide at every tilt that is reached: otherwise Eq. (24) has no
/// direction. It does not where the load's axis meets the axis of rotation. A ball that does not turn
/// slides nowhere, at any tilt: its joint is at rest, and Eq. (24) is read in the direction of the tilt.
pub(in crate::scene) fn sliding(
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
    let knots = tilt.knots().iter().map(|knot| knot.1);
    let lowest = knots.clone().fold(f64::INFINITY, f64::min) - TOO_CLOSE;
    let highest = knots.fold(f64::NEG_INFINITY, f64::max) + TOO_CLOSE;
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

/// A contact patch from a file is that of one load: it must be the scene's, and stay.
pub(in crate::scene) fn patch_stays(
    joint: &JointSpec,
    tilt: &Schedule,
    place: impl FnOnce() -> Place,
) -> Result<(), SceneError> {
    let BodySpec::Own(modes) = &joint.body else {
        return Ok(());
    };
    if tilt.min() != tilt.max() {
        return Err(Fault::Inconsistent {
            key: keys::TILT_KNOTS.path,
            problem: format!(
                "the load tilts, and the contact nodes of `{}` stay where they are",
                modes.name()
            ),
            remedy: "give a constant load.tilt_deg, or leave out body.modes".to_owned(),
        }
        .at(place()));
    }
    let direction = patch_direction(tilt.at(0.0), joint.azimuth);
    modes
        .check_load(joint.load, direction)
        .map_err(|problem| SceneError::Modes {
            at: place(),
            file: modes.name().to_owned(),
            problem: Box::new(problem),
        })
}
