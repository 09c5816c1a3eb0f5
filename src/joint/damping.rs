//! Damping of the contact: what resists the speed at which a gap closes.

use pulp::Simd;

use super::lanes::Vector;
use super::lift_off::LiftOff;

/// Damping of the contact, by the velocity `du_r/dt` at which a node is pressed in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactDamping {
    /// None.
    #[default]
    None,
    /// A dashpot beside the spring while the node is closed: `N = p_n + k_c (u_r + tau du_r/dt)`. At
    /// lift-off its force jumps.
    KelvinVoigt {
        /// Retardation time `tau`, s.
        time: f64,
    },
    /// Damping in proportion to the spring's stress: `N = (p_n + k_c u_r) (1 + chi du_r/dt)`, which is zero
    /// at lift-off by itself. K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440.
    HuntCrossley {
        /// Dissipation `chi`, s/m: an impact at a low speed `v` has the restitution `1 - 2 chi v / 3`.
        dissipation: f64,
    },
}

/// What a contact does that resists the speed at which it closes.
#[derive(Clone, Copy)]
pub(crate) struct Dashpot<S: Simd, const K: usize> {
    /// Stress of the damping alone, Pa.
    pub stress: Vector<S, K>,
    /// How the whole normal stress changes with the displacement, N/m^3; zero for open nodes.
    pub stiffness: Vector<S, K>,
    /// How it changes with the velocity, N s/m^3; zero for open nodes.
    pub viscosity: Vector<S, K>,
}

impl ContactDamping {
    /// Whether there is none.
    pub fn is_none(self) -> bool {
        self == Self::None
    }

    /// The damping of nodes of the vectors from `first` on, whose spring's stress is `spring` (Pa), at
    /// the velocity `rate = du_r/dt` (m/s).
    #[inline(always)]
    pub(crate) fn dashpot<S: Simd, const K: usize>(
        self,
        contact: LiftOff<'_>,
        first: usize,
        [gap, spring, stiffness, rate]: [Vector<S, K>; 4],
    ) -> Dashpot<S, K> {
        let pressing = contact.pressing(first, gap, stiffness);
        let (factor, viscosity) = match self {
            Self::None => (gap.same(1.0), gap.same(0.0)),
            Self::KelvinVoigt { time } => (gap.same(1.0), pressing * gap.same(time)),
            Self::HuntCrossley { dissipation } => (
                rate.mul_add(gap.same(dissipation), gap.same(1.0)),
                spring * gap.same(dissipation),
            ),
        };
        Dashpot {
            stress: viscosity * rate,
            stiffness: pressing * factor,
            viscosity,
        }
    }

    /// The same at one node, pressed if `closed`: stress of the damping, Pa.
    pub(crate) fn stress(self, closed: bool, spring: f64, stiffness: f64, rate: f64) -> f64 {
        match self {
            Self::KelvinVoigt { time } if closed => stiffness * time * rate,
            Self::HuntCrossley { dissipation } => spring * dissipation * rate,
            Self::None | Self::KelvinVoigt { .. } => 0.0,
        }
    }
}
