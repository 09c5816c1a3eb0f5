//! Whether a scene can show the mechanism that it names: its lesson must have something to measure.

use crate::joint::Friction;
use crate::scene::document::Document;
use crate::scene::error::SceneError;
use crate::scene::mechanism::Mechanism;
use crate::scene::spec::Scene;
use crate::scene::subject::{SmallSystem, SubjectSpec, TiltedJoint};

/// What a scene lacks for a mechanism, and what to do about it.
type Lack = (&'static str, &'static str);

/// Refuses a mechanism that the scene cannot show.
pub fn check(document: &Document<'_>, scene: &Scene) -> Result<(), SceneError> {
    let Some(mechanism) = scene.mechanism else {
        return Ok(());
    };
    match lack(scene, mechanism) {
        None => Ok(()),
        Some((problem, remedy)) => Err(document.inconsistent(
            "mechanism",
            &[],
            format!("\"{}\" {problem}", mechanism.name()),
            remedy,
        )),
    }
}

/// The mechanism that a scene names, if it can show it.
pub fn shown(scene: &Scene) -> Option<Mechanism> {
    let named = scene.mechanism;
    named.filter(|mechanism| lack(scene, *mechanism).is_none())
}

fn lack(scene: &Scene, mechanism: Mechanism) -> Option<Lack> {
    use Mechanism as M;
    let subject = &scene.subject;
    let heard = scene.analysis.spectrum.is_some();
    let mut lacks = match mechanism {
        M::NegativeSlope => vec![(!falls(subject), FALLS)],
        M::ModeCoupling => vec![(!is_coupled(subject), COUPLED)],
        M::StickSlip => vec![(!can_stick(scene), STICKS)],
        M::LiftOff => vec![(!can_lift_off(scene), LIFTS_OFF)],
        M::ExchangedFriction => vec![(!has_two_slopes(subject), TWO_SLOPES)],
        M::WhichModeWins | M::Prediction => vec![(joint(subject).is_none(), JOINT)],
        M::Hysteresis => vec![(!tilts_both_ways(scene), BOTH_WAYS)],
        M::Torus => Vec::new(),
        M::Chaos => vec![(scene.analysis.butterfly.is_none(), BUTTERFLY)],
    };
    // Whatever it is, its pitch is told.
    lacks.push((!heard, SPECTRUM));
    lacks.into_iter().find(|(is, _)| *is).map(|(_, lack)| lack)
}

const SPECTRUM: Lack = (
    "tells what is heard, and nothing listens",
    "add [analysis.spectrum]",
);
const FALLS: Lack = (
    "is shown by a mass on a belt whose friction falls with the speed",
    "take [mass_on_belt] with stribeck_slope_s_per_m",
);
const COUPLED: Lack = (
    "is shown by two modes on a belt",
    "take [two_modes_on_belt]",
);
const STICKS: Lack = (
    "needs something that can stick, and snapshots of it",
    "take [mass_on_belt], or a joint with [friction] and record.patch_rate_khz above 0",
);
const LIFTS_OFF: Lack = (
    "needs contact nodes that can open, and snapshots of them",
    "take a joint without contact.unilateral = false, and record.patch_rate_khz above 0",
);
const TWO_SLOPES: Lack = (
    "exchanges the two slope factors of Eq. (5)",
    "take a joint with friction.law = \"stribeck\"",
);
const JOINT: Lack = ("needs the modes of a joint", "give the scene a [load]");
const BOTH_WAYS: Lack = (
    "needs a tilt that goes up and comes down again within the run",
    "give [[load.tilt]] knots of such a course",
);
const BUTTERFLY: Lack = (
    "is shown by two copies that start almost alike",
    "add [analysis.butterfly]",
);

fn joint(subject: &SubjectSpec) -> Option<&TiltedJoint> {
    match subject {
        SubjectSpec::Joint(joint) => Some(joint),
        SubjectSpec::Small(_) => None,
    }
}

fn falls(subject: &SubjectSpec) -> bool {
    matches!(subject, SubjectSpec::Small(SmallSystem::MassOnBelt(belt)) if belt.stribeck.is_some())
}

fn is_coupled(subject: &SubjectSpec) -> bool {
    matches!(subject, SubjectSpec::Small(SmallSystem::TwoModesOnBelt(_)))
}

fn can_stick(scene: &Scene) -> bool {
    match &scene.subject {
        SubjectSpec::Joint(joint) => {
            joint.spec.friction != Friction::None && scene.record.patch_rate > 0.0
        }
        SubjectSpec::Small(small) => matches!(small, SmallSystem::MassOnBelt(_)),
    }
}

fn can_lift_off(scene: &Scene) -> bool {
    joint(&scene.subject).is_some_and(|joint| joint.spec.contact.unilateral)
        && scene.record.patch_rate > 0.0
}

fn has_two_slopes(subject: &SubjectSpec) -> bool {
    joint(subject).is_some_and(|joint| matches!(joint.spec.friction, Friction::Stribeck { .. }))
}

/// Whether some tilt lies above both the first and the last one.
fn tilts_both_ways(scene: &Scene) -> bool {
    joint(&scene.subject).is_some_and(|joint| {
        let ends = joint.tilt.at(0.0).max(joint.tilt.at(scene.duration));
        joint.tilt.max() > ends
    })
}
