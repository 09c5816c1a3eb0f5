//! Damping of the normal contact.

use pulp::Simd;

use super::separation::Separation;
use super::simd::Vector;

/// Damping law of the normal contact as a function of the approach velocity `du_r/dt`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactDamping {
    /// No contact damping.
    #[default]
    None,
    /// A dashpot in parallel with the spring of a closed node: `N = p_n + k_c (u_r + tau du_r/dt)`. The
    /// force is discontinuous at separation.
    KelvinVoigt {
        /// Retardation time `tau`, s.
        time: f64,
    },
    /// Damping proportional to the stress of the spring: `N = (p_n + k_c u_r) (1 + chi du_r/dt)`, which
    /// vanishes continuously at separation. K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440.
    HuntCrossley {
        /// Dissipation factor `chi`, s/m. An impact at a low speed `v` has the coefficient of restitution
        /// `1 - 2 chi v / 3`.
        dissipation: f64,
    },
}

/// Stress of the contact damping and derivatives of the normal stress.
#[derive(Clone, Copy)]
pub(crate) struct Dashpot<S: Simd, const K: usize> {
    /// Damping stress, Pa.
    pub stress: Vector<S, K>,
    /// Derivative of the normal stress with respect to displacement, N/m^3; zero for separated nodes.
    pub stiffness: Vector<S, K>,
    /// Derivative of the normal stress with respect to velocity, N s/m^3; zero for separated nodes.
    pub viscosity: Vector<S, K>,
}

impl ContactDamping {
    /// Whether the contact is undamped.
    pub fn is_none(self) -> bool {
        self == Self::None
    }

    /// Damping of the nodes in the vectors from `first` on, with the spring stress `spring` (Pa) and the
    /// approach velocity `rate = du_r/dt` (m/s).
    #[inline(always)]
    pub(crate) fn dashpot<S: Simd, const K: usize>(
        self,
        contact: Separation<'_>,
        first: usize,
        [gap, spring, stiffness, rate]: [Vector<S, K>; 4],
    ) -> Dashpot<S, K> {
        let pressing = contact.pressing(first, gap, stiffness);
        let (factor, viscosity) = match self {
            Self::None => (gap.broadcast(1.0), gap.broadcast(0.0)),
            Self::KelvinVoigt { time } => (gap.broadcast(1.0), pressing * gap.broadcast(time)),
            Self::HuntCrossley { dissipation } => (
                rate.mul_add(gap.broadcast(dissipation), gap.broadcast(1.0)),
                spring * gap.broadcast(dissipation),
            ),
        };
        Dashpot {
            stress: viscosity * rate,
            stiffness: pressing * factor,
            viscosity,
        }
    }

    /// Damping stress of a single node, Pa.
    pub(crate) fn stress(self, closed: bool, spring: f64, stiffness: f64, rate: f64) -> f64 {
        match self {
            Self::KelvinVoigt { time } if closed => stiffness * time * rate,
            Self::HuntCrossley { dissipation } => spring * dissipation * rate,
            Self::None | Self::KelvinVoigt { .. } => 0.0,
        }
    }
}
