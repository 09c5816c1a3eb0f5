//! Damping of the normal contact.

use pulp::Simd;

use super::separation::Separation;
use super::simd::Vector;

/// Damping law of the normal contact as a function of the approach velocity `du_r/dt`.
///
/// A contact pushes and never pulls: where spring and dashpot together would pull, a closed node has no
/// force. It separates later, at `p_n + k_c u_r = 0`. Bonded nodes can pull.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ContactDamping {
    /// No contact damping.
    #[default]
    None,
    /// A dashpot in parallel with the spring of a closed node: `N = max(0, p_n + k_c (u_r + tau du_r/dt))`.
    /// The force ends continuously, before separation, and jumps at closing.
    KelvinVoigt {
        /// Retardation time `tau`, s.
        time: f64,
    },
    /// Damping proportional to the stress of the spring: `N = (p_n + k_c u_r) max(0, 1 + chi du_r/dt)`, which
    /// is continuous at separation and at closing. K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440.
    HuntCrossley {
        /// Dissipation factor `chi`, s/m. An impact at a low speed `v` has the coefficient of restitution
        /// `1 - 2 chi v / 3`.
        dissipation: f64,
    },
}

/// Normal stress of the damped contact and its derivatives; zero for nodes without contact force.
#[derive(Clone, Copy)]
pub(crate) struct DampedStress<S: Simd, const K: usize> {
    /// Normal stress, Pa. Without that of the spring, it is the stress of the damping.
    pub normal: Vector<S, K>,
    /// Derivative of the normal stress with respect to displacement, N/m^3.
    pub stiffness: Vector<S, K>,
    /// Derivative of the normal stress with respect to velocity, N s/m^3.
    pub viscosity: Vector<S, K>,
}

impl ContactDamping {
    /// Whether the contact is undamped.
    pub fn is_none(self) -> bool {
        self == Self::None
    }

    /// Normal stress of the nodes in the vectors from `first` on, with the gap function `gap` and the spring
    /// stress `spring` (Pa), the stiffness (N/m^3) and the approach velocity `rate = du_r/dt` (m/s).
    #[inline(always)]
    pub(crate) fn stress<S: Simd, const K: usize>(
        self,
        contact: Separation<'_>,
        first: usize,
        [gap, spring, stiffness, rate]: [Vector<S, K>; 4],
    ) -> DampedStress<S, K> {
        let pressing = contact.pressing(first, gap, stiffness);
        let (factor, viscosity) = match self {
            Self::None => {
                return DampedStress {
                    normal: spring,
                    stiffness: pressing,
                    viscosity: gap.broadcast(0.0),
                };
            }
            Self::KelvinVoigt { time } => (gap.broadcast(1.0), pressing * gap.broadcast(time)),
            Self::HuntCrossley { dissipation } => (
                rate.mul_add(gap.broadcast(dissipation), gap.broadcast(1.0)),
                spring * gap.broadcast(dissipation),
            ),
        };
        let unclamped = spring + viscosity * rate;
        let pushing = |numbers| contact.pushing(first, unclamped, numbers);
        DampedStress {
            normal: pushing(unclamped),
            stiffness: pushing(pressing * factor),
            viscosity: pushing(viscosity),
        }
    }

    /// Normal stress of a single closed node, Pa; negative where spring and dashpot together pull.
    pub(crate) fn unclamped(self, spring: f64, stiffness: f64, rate: f64) -> f64 {
        match self {
            Self::None => spring,
            Self::KelvinVoigt { time } => spring + stiffness * time * rate,
            Self::HuntCrossley { dissipation } => spring * (1.0 + dissipation * rate),
        }
    }

    /// Guard of the contact force of closed nodes: a smooth function with the sign of the stress of spring and
    /// dashpot together. For a dashpot it is this stress (Pa); for Hunt-Crossley damping, `1 + chi du_r/dt`.
    #[inline(always)]
    pub(crate) fn guard<S: Simd>(self, [gap, stiffness, rate]: [Vector<S>; 3]) -> Vector<S> {
        let one = gap.broadcast(1.0);
        match self {
            Self::None => one,
            Self::KelvinVoigt { time } => gap + stiffness * gap.broadcast(time) * rate,
            Self::HuntCrossley { dissipation } => rate.mul_add(gap.broadcast(dissipation), one),
        }
    }

    /// Derivatives of [`ContactDamping::guard`] with respect to displacement and velocity of a node.
    pub(crate) fn guard_slopes(self, stiffness: f64) -> [f64; 2] {
        match self {
            Self::None => [0.0; 2],
            Self::KelvinVoigt { time } => [stiffness, stiffness * time],
            Self::HuntCrossley { dissipation } => [0.0, dissipation],
        }
    }
}
