//! Mechanisms of friction-induced vibration that a scene can demonstrate, and what each requires of the scene.

use strum::{EnumMessage, EnumString, IntoStaticStr, VariantArray};

use super::spec::Scene;
use super::subject::LoadedJoint;
use super::subject::SmallSystem::{MassOnBelt, TwoModesOnBelt};
use super::subject::SystemSpec::Small;
use crate::joint::{DynamicFriction, Friction};

/// A mechanism that a scene demonstrates. Its lesson explains the mechanism next to the view that shows it,
/// with numbers measured in the run.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray, IntoStaticStr, EnumString, EnumMessage,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Mechanism {
    /// Friction that decreases with sliding speed excites one mode.
    #[strum(
        message = "requires a mass on a belt with friction that decreases with speed; use [mass_on_belt] with stribeck_slope_s_per_m"
    )]
    NegativeSlope,
    /// Two modes couple and flutter at a constant coefficient of friction.
    #[strum(message = "requires two modes on a belt; use [two_modes_on_belt]")]
    ModeCoupling,
    /// A mass or contact node sticks to the moving surface and slips periodically.
    #[strum(
        message = "requires a system that can stick, and snapshots of it; use [mass_on_belt], or a joint with [friction] and record.patch_rate_khz above 0"
    )]
    StickSlip,
    /// Contact nodes separate and impact.
    #[strum(
        message = "requires contact nodes that can separate, and snapshots of them; use a joint with contact.unilateral = true and record.patch_rate_khz above 0"
    )]
    LiftOff,
    /// The two slope factors of Eq. (5) as printed and exchanged: stable sliding or squeak.
    #[strum(
        message = "exchanges the two slope factors of Eq. (5); use a joint with friction.law = \"stribeck\" and mu_s other than mu_d"
    )]
    ExchangedFriction,
    /// Several modes are unstable, and the initial kick determines the mode that dominates.
    #[strum(message = "requires the modes of a ball joint; use a scene with a [load] table")]
    WhichModeWins,
    /// The regime changes at a higher tilt on the upward ramp than on the downward ramp.
    #[strum(
        message = "requires a tilt that increases and decreases again within the run; add [[load.tilt]] knots for such a ramp"
    )]
    Hysteresis,
    /// Two incommensurate frequencies and their combination frequencies.
    Torus,
    /// A periodic motion becomes a torus when a pair of its Floquet multipliers leaves the unit circle.
    #[strum(
        message = "requires a load whose tilt changes, and nothing else; add [[load.tilt]] knots, and hold load and rotation constant"
    )]
    TorusBirth,
    /// A perturbed trajectory diverges exponentially from the original.
    #[strum(message = "requires a perturbed trajectory; add [analysis.perturbed_trajectory]")]
    Chaos,
    /// Elastic bristles bend before the contact slides, and reduce the slope of friction for fast oscillations.
    #[strum(
        message = "requires friction with elastic bristles; use a joint with friction.law = \"lugre\""
    )]
    Bristles,
    /// Friction follows the sliding speed only after a slip distance.
    #[strum(
        message = "requires friction with the age of the contact; use a joint with friction.law = \"rate-and-state\""
    )]
    ContactAge,
    /// Friction given by the points of a measurement.
    #[strum(
        message = "requires a measured friction curve; use a joint with friction.law = \"table\""
    )]
    MeasuredFriction,
    /// A joint that turns to and fro squeaks between two tilts of each pass.
    #[strum(
        message = "requires a rotation that moves the contact patch; use a joint with rotation.moves_patch = true"
    )]
    Articulation,
    /// Predictions of the complex eigenvalues compared with the simulated vibration.
    #[strum(message = "requires the modes of a ball joint; use a scene with a [load] table")]
    Prediction,
}

/// What a lesson measures and shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Evidence {
    /// The level of the vibration, whose growth is compared with the computed one.
    Growth,
    /// The squeak in each pass of a joint that turns, and the strongest line over the tilt.
    Turning,
    /// The contact, as it sticks and separates.
    Contact,
    /// The energies of the modes, and the spectrum with the computed frequencies.
    Modes,
    /// The strongest line over the tilt.
    Loop,
    /// The spectrum and the section of a torus.
    Torus,
    /// The second tone of a torus while the tilt changes.
    Birth,
    /// The distance of a perturbed trajectory.
    Divergence,
}

impl Mechanism {
    /// All mechanisms.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// Name in a scene file.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// What its lesson measures and shows.
    pub fn evidence(self) -> Evidence {
        match self {
            Self::NegativeSlope | Self::ModeCoupling | Self::ExchangedFriction => Evidence::Growth,
            Self::Bristles | Self::ContactAge | Self::MeasuredFriction => Evidence::Growth,
            Self::Articulation => Evidence::Turning,
            Self::StickSlip | Self::LiftOff => Evidence::Contact,
            Self::WhichModeWins | Self::Prediction => Evidence::Modes,
            Self::Hysteresis => Evidence::Loop,
            Self::Torus => Evidence::Torus,
            Self::TorusBirth => Evidence::Birth,
            Self::Chaos => Evidence::Divergence,
        }
    }

    /// What a scene lacks to demonstrate the mechanism, so that its lesson has something to measure, and the remedy.
    pub(super) fn missing_in(self, scene: &Scene) -> Option<(&'static str, &'static str)> {
        if scene.analysis.spectrum.is_none() {
            let problem = "reports the strongest spectral line, and the scene computes no spectrum";
            return Some((problem, "add [analysis.spectrum]"));
        }
        (!self.is_met(scene))
            .then(|| self.get_message()?.split_once("; "))
            .flatten()
    }

    fn is_met(self, scene: &Scene) -> bool {
        let joint = scene.joint().ok();
        let friction = joint.map_or(&Friction::None, |joint| &joint.spec.friction);
        let has = |test: fn(&LoadedJoint) -> bool| joint.is_some_and(test);
        let has_snapshots = scene.record.patch_rate > 0.0;
        match (self, &scene.subject) {
            (Self::Torus, _) => true,
            (Self::NegativeSlope, Small(MassOnBelt(belt))) => belt.stribeck.is_some(),
            (Self::StickSlip, Small(MassOnBelt(_))) => true,
            (Self::ModeCoupling, Small(TwoModesOnBelt(_))) => true,
            (Self::NegativeSlope | Self::ModeCoupling, _) => false,
            (Self::StickSlip, _) => has_snapshots && *friction != Friction::None,
            (Self::LiftOff, _) => has_snapshots && has(|joint| joint.spec.contact.unilateral),
            (Self::ExchangedFriction, _) => {
                matches!(friction, Friction::Stribeck { law, .. } if law.mu_s != law.mu_d)
            }
            (Self::WhichModeWins | Self::Prediction, _) => joint.is_some(),
            (Self::Hysteresis, _) => joint.is_some_and(|LoadedJoint { tilt, .. }| {
                tilt.max() > tilt.at(0.0).max(tilt.at(scene.duration))
            }),
            (Self::TorusBirth, _) => has(|joint| {
                joint.tilt.varies() && !joint.load.varies() && !joint.rotation_factor.varies()
            }),
            (Self::Bristles | Self::ContactAge, _) => match friction {
                Friction::Dynamic { law, .. } => {
                    matches!(law, DynamicFriction::LuGre(_)) == (self == Self::Bristles)
                }
                _ => false,
            },
            (Self::MeasuredFriction, _) => matches!(friction, Friction::Table { .. }),
            (Self::Articulation, _) => has(LoadedJoint::patch_moves),
            (Self::Chaos, _) => scene.analysis.perturbed_trajectory.is_some(),
        }
    }
}
