//! Mechanisms of friction-induced vibration that a scene can demonstrate, and what each requires of the scene.

use strum::{EnumString, IntoStaticStr, VariantArray};

use super::spec::Scene;
use super::subject::{LoadedJoint, SmallSystem, SystemSpec};
use crate::joint::{DynamicFriction, Friction};

/// A mechanism that a scene demonstrates. Its lesson explains the mechanism next to the view that shows it,
/// with numbers measured in the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray, IntoStaticStr, EnumString)]
#[strum(serialize_all = "kebab-case")]
pub enum Mechanism {
    /// Friction that decreases with sliding speed excites one mode.
    NegativeSlope,
    /// Two modes couple and flutter at a constant coefficient of friction.
    ModeCoupling,
    /// A mass or contact node sticks to the moving surface and slips periodically.
    StickSlip,
    /// Contact nodes separate and impact.
    LiftOff,
    /// The two slope factors of Eq. (5) as printed and exchanged: stable sliding or squeak.
    ExchangedFriction,
    /// Several modes are unstable, and the initial kick determines the mode that dominates.
    WhichModeWins,
    /// The regime changes at a higher tilt on the upward ramp than on the downward ramp.
    Hysteresis,
    /// Two incommensurate frequencies and their combination frequencies.
    Torus,
    /// A periodic motion becomes a torus when a pair of its Floquet multipliers leaves the unit circle.
    TorusBirth,
    /// A perturbed trajectory diverges exponentially from the original.
    Chaos,
    /// Elastic bristles bend before the contact slides, and reduce the slope of friction for fast oscillations.
    Bristles,
    /// Friction follows the sliding speed only after a slip distance.
    ContactAge,
    /// Friction given by the points of a measurement.
    MeasuredFriction,
    /// A joint that turns to and fro squeaks between two tilts of each pass.
    Articulation,
    /// Predictions of the complex eigenvalues compared with the simulated vibration.
    Prediction,
}

impl Mechanism {
    /// All mechanisms.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// Name in a scene file.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// What a scene lacks to demonstrate the mechanism, so that its lesson has something to measure, and the remedy.
    pub(super) fn missing_in(self, scene: &Scene) -> Option<[&'static str; 2]> {
        if scene.analysis.spectrum.is_none() {
            return Some([
                "reports the strongest spectral line, and the scene computes no spectrum",
                "add [analysis.spectrum]",
            ]);
        }
        let (is_met, problem, remedy) = self.requirement(scene)?;
        (!is_met).then_some([problem, remedy])
    }

    /// Whether the scene has what the mechanism requires, with the problem and the remedy otherwise.
    #[allow(
        clippy::too_many_lines,
        reason = "one arm for each mechanism, with condition, problem and remedy"
    )]
    fn requirement(self, scene: &Scene) -> Option<(bool, &'static str, &'static str)> {
        let (joint, small) = match &scene.subject {
            SystemSpec::Joint(joint) => (Some(joint), None),
            SystemSpec::Small(small) => (None, Some(small)),
        };
        let friction = joint.map(|joint| &joint.spec.friction);
        let has = |test: fn(&LoadedJoint) -> bool| joint.is_some_and(test);
        let has_snapshots = scene.record.patch_rate > 0.0;
        Some(match self {
            Self::NegativeSlope => (
                matches!(small, Some(SmallSystem::MassOnBelt(belt)) if belt.stribeck.is_some()),
                "requires a mass on a belt with friction that decreases with speed",
                "use [mass_on_belt] with stribeck_slope_s_per_m",
            ),
            Self::ModeCoupling => (
                matches!(small, Some(SmallSystem::TwoModesOnBelt(_))),
                "requires two modes on a belt",
                "use [two_modes_on_belt]",
            ),
            Self::StickSlip => (
                matches!(small, Some(SmallSystem::MassOnBelt(_)))
                    || has_snapshots && friction.is_some_and(|law| *law != Friction::None),
                "requires a system that can stick, and snapshots of it",
                "use [mass_on_belt], or a joint with [friction] and record.patch_rate_khz above 0",
            ),
            Self::LiftOff => (
                has_snapshots && has(|joint| joint.spec.contact.unilateral),
                "requires contact nodes that can separate, and snapshots of them",
                "use a joint with contact.unilateral = true and record.patch_rate_khz above 0",
            ),
            Self::ExchangedFriction => (
                matches!(friction, Some(Friction::Stribeck { .. })),
                "exchanges the two slope factors of Eq. (5)",
                "use a joint with friction.law = \"stribeck\"",
            ),
            Self::WhichModeWins | Self::Prediction => (
                joint.is_some(),
                "requires the modes of a ball joint",
                "use a scene with a [load] table",
            ),
            Self::Hysteresis => (
                joint.is_some_and(|LoadedJoint { tilt, .. }| {
                    tilt.max() > tilt.at(0.0).max(tilt.at(scene.duration))
                }),
                "requires a tilt that increases and decreases again within the run",
                "add [[load.tilt]] knots for such a ramp",
            ),
            Self::Torus => return None,
            Self::TorusBirth => (
                has(|joint| {
                    joint.load.is_none() && joint.rotation.is_none() && joint.tilt.varies()
                }),
                "requires a load whose tilt changes, and nothing else",
                "add [[load.tilt]] knots, and hold load and rotation constant",
            ),
            Self::Bristles => (
                matches!(
                    friction,
                    Some(Friction::Dynamic {
                        law: DynamicFriction::LuGre(_),
                        ..
                    })
                ),
                "requires friction with elastic bristles",
                "use a joint with friction.law = \"lugre\"",
            ),
            Self::ContactAge => (
                matches!(
                    friction,
                    Some(Friction::Dynamic {
                        law: DynamicFriction::RateAndState(_),
                        ..
                    })
                ),
                "requires friction with the age of the contact",
                "use a joint with friction.law = \"rate-and-state\"",
            ),
            Self::MeasuredFriction => (
                matches!(friction, Some(Friction::Table { .. })),
                "requires a measured friction curve",
                "use a joint with friction.law = \"table\"",
            ),
            Self::Articulation => (
                has(LoadedJoint::patch_moves),
                "requires a rotation that moves the contact patch",
                "use a joint with rotation.moves_patch = true",
            ),
            Self::Chaos => (
                scene.analysis.perturbed_trajectory.is_some(),
                "requires a perturbed trajectory",
                "add [analysis.perturbed_trajectory]",
            ),
        })
    }
}
