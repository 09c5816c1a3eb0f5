//! Checks that a scene can demonstrate its mechanism: the lesson must have something to measure.

use crate::joint::{DynamicFriction, Friction};
use crate::scene::document::Document;
use crate::scene::error::SceneError;
use crate::scene::mechanism::Mechanism;
use crate::scene::spec::Scene;
use crate::scene::subject::{LoadedJoint, SmallSystem, SystemSpec};

/// A missing requirement of a mechanism, and the remedy.
type Requirement = (&'static str, &'static str);

/// Rejects a mechanism that the scene cannot demonstrate.
pub fn check(document: &Document<'_>, scene: &Scene) -> Result<(), SceneError> {
    let Some(mechanism) = scene.mechanism else {
        return Ok(());
    };
    match missing_requirement(scene, mechanism) {
        None => Ok(()),
        Some((problem, remedy)) => Err(document.inconsistent(
            "mechanism",
            &[],
            format!("\"{}\" {problem}", mechanism.name()),
            remedy,
        )),
    }
}

/// Returns the mechanism of a scene if the scene can demonstrate it.
pub fn demonstrated(scene: &Scene) -> Option<Mechanism> {
    let named = scene.mechanism;
    named.filter(|mechanism| missing_requirement(scene, *mechanism).is_none())
}

fn missing_requirement(scene: &Scene, mechanism: Mechanism) -> Option<Requirement> {
    use Mechanism as M;
    let subject = &scene.subject;
    let has_spectrum = scene.analysis.spectrum.is_some();
    let mut requirements = match mechanism {
        M::NegativeSlope => vec![(!has_negative_slope(subject), NEGATIVE_SLOPE)],
        M::ModeCoupling => vec![(!has_two_modes(subject), TWO_MODES)],
        M::StickSlip => vec![(!can_stick(scene), STICKING)],
        M::LiftOff => vec![(!can_separate(scene), SEPARATION)],
        M::ExchangedFriction => vec![(!has_two_slopes(subject), TWO_SLOPES)],
        M::WhichModeWins | M::Prediction => vec![(joint(subject).is_none(), JOINT)],
        M::Hysteresis => vec![(!has_tilt_maximum(scene), TILT_MAXIMUM)],
        M::Torus => Vec::new(),
        M::TorusBirth => vec![(!only_tilt_varies(subject), TILT_ALONE)],
        M::Bristles => vec![(!has_bristles(subject), BRISTLES)],
        M::ContactAge => vec![(!has_contact_age(subject), CONTACT_AGE)],
        M::MeasuredFriction => vec![(!has_measured_friction(subject), MEASURED_FRICTION)],
        M::Articulation => vec![(!turns(subject), TURNING)],
        M::Chaos => vec![(
            scene.analysis.perturbed_trajectory.is_none(),
            PERTURBED_TRAJECTORY,
        )],
    };
    // All lessons report the strongest spectral line.
    requirements.push((!has_spectrum, SPECTRUM));
    requirements
        .into_iter()
        .find(|(is_missing, _)| *is_missing)
        .map(|(_, requirement)| requirement)
}

const SPECTRUM: Requirement = (
    "reports the strongest spectral line, and the scene computes no spectrum",
    "add [analysis.spectrum]",
);
const NEGATIVE_SLOPE: Requirement = (
    "requires a mass on a belt with friction that decreases with speed",
    "use [mass_on_belt] with stribeck_slope_s_per_m",
);
const TWO_MODES: Requirement = ("requires two modes on a belt", "use [two_modes_on_belt]");
const STICKING: Requirement = (
    "requires a system that can stick, and snapshots of it",
    "use [mass_on_belt], or a joint with [friction] and record.patch_rate_khz above 0",
);
const SEPARATION: Requirement = (
    "requires contact nodes that can separate, and snapshots of them",
    "use a joint with contact.unilateral = true and record.patch_rate_khz above 0",
);
const TWO_SLOPES: Requirement = (
    "exchanges the two slope factors of Eq. (5)",
    "use a joint with friction.law = \"stribeck\"",
);
const JOINT: Requirement = (
    "requires the modes of a ball joint",
    "use a scene with a [load] table",
);
const TILT_MAXIMUM: Requirement = (
    "requires a tilt that increases and decreases again within the run",
    "add [[load.tilt]] knots for such a ramp",
);
const TILT_ALONE: Requirement = (
    "requires a load whose tilt changes, and nothing else",
    "add [[load.tilt]] knots, and hold load and rotation constant",
);
const BRISTLES: Requirement = (
    "requires friction with elastic bristles",
    "use a joint with friction.law = \"lugre\"",
);
const CONTACT_AGE: Requirement = (
    "requires friction with the age of the contact",
    "use a joint with friction.law = \"rate-and-state\"",
);
const MEASURED_FRICTION: Requirement = (
    "requires a measured friction curve",
    "use a joint with friction.law = \"table\"",
);
const TURNING: Requirement = (
    "requires a rotation that moves the contact patch",
    "use a joint with rotation.moves_patch = true",
);
const PERTURBED_TRAJECTORY: Requirement = (
    "requires a perturbed trajectory",
    "add [analysis.perturbed_trajectory]",
);

fn joint(subject: &SystemSpec) -> Option<&LoadedJoint> {
    match subject {
        SystemSpec::Joint(joint) => Some(joint),
        SystemSpec::Small(_) => None,
    }
}

fn has_negative_slope(subject: &SystemSpec) -> bool {
    matches!(subject, SystemSpec::Small(SmallSystem::MassOnBelt(belt)) if belt.stribeck.is_some())
}

fn has_two_modes(subject: &SystemSpec) -> bool {
    matches!(subject, SystemSpec::Small(SmallSystem::TwoModesOnBelt(_)))
}

fn can_stick(scene: &Scene) -> bool {
    match &scene.subject {
        SystemSpec::Joint(joint) => {
            joint.spec.friction != Friction::None && scene.record.patch_rate > 0.0
        }
        SystemSpec::Small(small) => matches!(small, SmallSystem::MassOnBelt(_)),
    }
}

fn can_separate(scene: &Scene) -> bool {
    joint(&scene.subject).is_some_and(|joint| joint.spec.contact.unilateral)
        && scene.record.patch_rate > 0.0
}

fn has_two_slopes(subject: &SystemSpec) -> bool {
    joint(subject).is_some_and(|joint| matches!(joint.spec.friction, Friction::Stribeck { .. }))
}

fn has_bristles(subject: &SystemSpec) -> bool {
    let lugre = |joint: &LoadedJoint| {
        matches!(
            joint.spec.friction,
            Friction::Dynamic {
                law: DynamicFriction::LuGre(_),
                ..
            }
        )
    };
    joint(subject).is_some_and(lugre)
}

fn has_contact_age(subject: &SystemSpec) -> bool {
    let rate_and_state = |joint: &LoadedJoint| {
        matches!(
            joint.spec.friction,
            Friction::Dynamic {
                law: DynamicFriction::RateAndState(_),
                ..
            }
        )
    };
    joint(subject).is_some_and(rate_and_state)
}

fn has_measured_friction(subject: &SystemSpec) -> bool {
    joint(subject).is_some_and(|joint| matches!(joint.spec.friction, Friction::Table { .. }))
}

fn turns(subject: &SystemSpec) -> bool {
    joint(subject).is_some_and(LoadedJoint::patch_moves)
}

fn only_tilt_varies(subject: &SystemSpec) -> bool {
    joint(subject).is_some_and(|joint| {
        let constant = joint.load.is_none() && joint.rotation.is_none();
        constant && joint.tilt.varies()
    })
}

/// Whether the maximum tilt exceeds both the first and the last tilt.
fn has_tilt_maximum(scene: &Scene) -> bool {
    joint(&scene.subject).is_some_and(|joint| {
        let ends = joint.tilt.at(0.0).max(joint.tilt.at(scene.duration));
        joint.tilt.max() > ends
    })
}
