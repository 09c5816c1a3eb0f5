//! The simulated system: the ball joint or a small system.

use schemars::JsonSchema;
use serde::Serialize;
use strum::{EnumString, IntoStaticStr, VariantArray};

use super::schedule::Schedule;
use crate::joint::{JointSpec, Loading, PatchFrame};
use crate::systems::{DampedContact, ImpactOscillator, MassOnBelt, TwoModesOnBelt};

/// The simulated system.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a scene has one subject: its size does not matter"
)]
pub enum SystemSpec {
    /// A ball joint under a load and a rotation that may change with time.
    Joint(LoadedJoint),
    /// A small system.
    Small(SmallSystem),
}

/// A ball joint and its loading as functions of time.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedJoint {
    /// The joint with its load and rotation at time 0.
    pub spec: JointSpec,
    /// Angular velocity vector at a factor of 1, rad/s.
    pub full_rotation: [f64; 3],
    /// Tilt of the load, rad.
    pub tilt: Schedule,
    /// Load, N.
    pub load: Schedule,
    /// Factor on the angular velocity, negative for the opposite rotation.
    pub rotation_factor: Schedule,
    /// Time from which the rotation moves the patch, s: there the patch is at the tilt, which is constant. `None`
    /// if the patch stays at the tilt whatever the rotation.
    pub patch_moves_from: Option<f64>,
    /// What a change of tilt, load or rotation carries over.
    pub carry: Carry,
}

/// Part of the motion that a change of tilt, load or rotation carries over to the new equilibrium. The modal
/// velocities are carried over in both cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, VariantArray, IntoStaticStr, EnumString)]
#[strum(serialize_all = "kebab-case")]
pub enum Carry {
    /// The perturbation `z` from the equilibrium: a change excites nothing.
    #[default]
    Perturbation,
    /// The displacement `q_eq + z`: a change moves the perturbation by the shift of the equilibrium,
    /// `z += q_eq(old) - q_eq(new)`.
    Displacement,
}

/// Values fixed at one instant: a study of a single state holds the time-dependent quantities of a scene; `None` for
/// quantities that are constant in the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct FixedAt {
    /// Tilt, rad.
    pub tilt_rad: Option<f64>,
    /// Load, N.
    pub load_n: Option<f64>,
    /// Factor on the angular velocity.
    pub rotation_factor: Option<f64>,
}

impl LoadedJoint {
    /// Loading of the joint at time `t` (s).
    pub fn loading(&self, t: f64) -> Loading {
        let rotation_factor = self.rotation_factor.at(t);
        let (tilt, azimuth) = (self.tilt.at(t), self.spec.azimuth);
        let turn = self.patch_turn(t).filter(|by| *by != [0.0; 3]);
        let patch = turn.map(|by| PatchFrame::tilted(tilt, azimuth).turned(by));
        Loading {
            tilt: patch.map_or(tilt, |patch| patch.tilt(azimuth)),
            patch,
            load: self.load.at(t),
            rotation: self.full_rotation.map(|w| rotation_factor * w),
            rotation_factor,
        }
    }

    /// Rotation vector (rad) of the patch in the axes of the body at time `t` (s), if the rotation moves it: the
    /// load has a fixed direction in the socket, so that a direction `d` seen from the body changes by
    /// `dd/dt = -Omega x d`. The axis of `Omega` is fixed, and the turn is the integral of its magnitude.
    fn patch_turn(&self, t: f64) -> Option<[f64; 3]> {
        let from = self.patch_moves_from?;
        let turned = |t| self.rotation_factor.integral(t);
        let amount = turned(t) - turned(from);
        Some(self.full_rotation.map(|w| -amount * w))
    }

    /// Whether the rotation moves the patch.
    pub fn patch_moves(&self) -> bool {
        self.patch_moves_from.is_some() && self.full_rotation != [0.0; 3]
    }

    /// Loadings at the start of a run of a duration (s), at its end, and at equal intervals between.
    pub fn loadings(&self, duration: f64) -> impl Iterator<Item = Loading> {
        const INTERVALS: u32 = 1000;
        let times = (0..=INTERVALS).map(move |k| duration * f64::from(k) / f64::from(INTERVALS));
        times.map(|t| self.loading(t))
    }

    /// Minimum and maximum tilt of a run of a duration (s), rad.
    pub fn tilt_span(&self, duration: f64) -> [f64; 2] {
        let start = [self.tilt.min(), self.tilt.max()];
        if !self.patch_moves() {
            return start;
        }
        let tilts = self.loadings(duration).map(|loading| loading.tilt);
        tilts.fold(start, |[low, high], tilt| [low.min(tilt), high.max(tilt)])
    }

    /// Minimum and maximum load, N.
    pub fn load_span(&self) -> [f64; 2] {
        [self.load.min(), self.load.max()]
    }

    /// Minimum and maximum factor on the angular velocity.
    pub fn rotation_span(&self) -> [f64; 2] {
        [self.rotation_factor.min(), self.rotation_factor.max()]
    }

    /// Load (N), tilt (rad) and factor on the angular velocity.
    pub(super) fn schedules(&self) -> [&Schedule; 3] {
        [&self.load, &self.tilt, &self.rotation_factor]
    }

    /// Whether tilt, load or rotation change with time.
    pub fn varies(&self) -> bool {
        self.patch_moves() || self.schedules().into_iter().any(Schedule::varies)
    }

    /// Times of all discontinuities of tilt, load and rotation, s, ascending, without duplicates.
    pub fn jumps(&self) -> Vec<f64> {
        let schedules = self.schedules().into_iter();
        let mut jumps: Vec<f64> = schedules.flat_map(Schedule::jumps).collect();
        jumps.sort_by(f64::total_cmp);
        jumps.dedup();
        jumps
    }

    /// Initial values of all time-dependent quantities, at which a study of a single state holds them.
    pub fn fixed_at_start(&self) -> FixedAt {
        self.fixed_at(self.loading(0.0))
    }

    /// Values of the time-dependent quantities under the given loading.
    pub fn fixed_at(&self, loading: Loading) -> FixedAt {
        let [load, tilt, factor] = self.schedules().map(Schedule::varies);
        FixedAt {
            tilt_rad: (tilt || self.patch_moves()).then_some(loading.tilt),
            load_n: load.then_some(loading.load),
            rotation_factor: factor.then_some(loading.rotation_factor),
        }
    }
}

impl FixedAt {
    /// Fixed values as text, such as `tilt 3 deg, load 150 N`; `None` if no quantity depends on time.
    pub fn description(&self) -> Option<String> {
        // The conversion to radians and back is accurate to about twelve digits.
        let short = |x: f64| (1e9 * x).round() / 1e9;
        let turns = "times rotation.angular_velocity_rad_per_s";
        let values = [
            ("tilt", self.tilt_rad.map(f64::to_degrees), "deg"),
            ("load", self.load_n, "N"),
            ("rotation", self.rotation_factor, turns),
        ];
        let all: Vec<String> = values
            .into_iter()
            .filter_map(|(name, value, unit)| Some(format!("{name} {} {unit}", short(value?))))
            .collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

/// A small system with well-known dynamics, used to verify the program. Its mass is 1 kg, so that modal
/// coordinate and displacement have the same value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SmallSystem {
    /// A driven oscillator with impacts on a rigid wall.
    ImpactOscillator(ImpactOscillator),
    /// A mass on a moving belt.
    MassOnBelt(MassOnBelt),
    /// A mass with two modes on a moving belt.
    TwoModesOnBelt(TwoModesOnBelt),
    /// A driven oscillator with a one-sided viscoelastic contact.
    DampedContact(DampedContact),
}

impl SmallSystem {
    /// Short description, such as `an impact oscillator`.
    pub fn description(&self) -> &'static str {
        match self {
            Self::ImpactOscillator(_) => "an impact oscillator",
            Self::MassOnBelt(_) => "a mass on a belt",
            Self::TwoModesOnBelt(_) => "a mass with two modes on a belt",
            Self::DampedContact(_) => "an oscillator with a viscoelastic contact",
        }
    }

    /// Speed of the belt, m/s; `None` without a belt.
    pub fn belt_speed(&self) -> Option<f64> {
        match self {
            Self::MassOnBelt(system) => Some(system.belt),
            Self::TwoModesOnBelt(system) => Some(system.belt),
            Self::ImpactOscillator(_) | Self::DampedContact(_) => None,
        }
    }

    /// Period of the drive, s; `None` without a drive.
    pub fn drive_period(&self) -> Option<f64> {
        let mut system = *self;
        let (omega, _) = system.drive()?;
        (omega > 0.0).then(|| std::f64::consts::TAU / omega)
    }

    /// Circular frequency (rad/s) and phase (rad) of the drive; `None` for a system without a drive.
    pub fn drive(&mut self) -> Option<(f64, &mut f64)> {
        match self {
            Self::ImpactOscillator(system) => Some((system.drive_omega, &mut system.drive_phase)),
            Self::DampedContact(system) => Some((system.drive_omega, &mut system.drive_phase)),
            Self::MassOnBelt(_) | Self::TwoModesOnBelt(_) => None,
        }
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        match self {
            Self::TwoModesOnBelt(_) => 2,
            Self::ImpactOscillator(_) | Self::MassOnBelt(_) | Self::DampedContact(_) => 1,
        }
    }
}

impl SystemSpec {
    /// Number of modes.
    pub fn modes(&self) -> usize {
        match self {
            Self::Joint(joint) => joint.spec.body.modes(),
            Self::Small(small) => small.modes(),
        }
    }
}
