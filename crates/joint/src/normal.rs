//! Eq. (2) for several nodes at once: normal stress by gap function or by a given contact status, and contact damping.

use pulp::Simd;

use super::dual::Dual;
use super::simd::{LanePosition, Vector};

/// Relation between the gap function `s = p_n + k_c u_r` (Pa) and the normal stress. The variant is matched
/// once for a group of nodes, outside the loops over the modes, where its cost is not measurable; the hot
/// loop is not compiled for each variant.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Separation<'a> {
    /// A node separates if its gap function is negative.
    ByGap,
    /// Bonded nodes: they do not separate, and the stress can be tensile.
    Never,
    /// A fixed contact status, one bit per node (set for separated nodes). Closed nodes remain closed, also
    /// under tension. With contact damping, as many bits follow, set for closed nodes without contact force.
    Fixed(&'a [u8]),
}

impl Separation<'_> {
    /// Stress of the springs of the nodes in the vectors from `first` on, Pa. With the variant `ByGap` the derivative at a
    /// gap of exactly zero is that of a separated node.
    #[inline(always)]
    pub fn stress<S: Simd, const K: usize, const N: usize>(
        self,
        first: usize,
        gap: Dual<S, K, N>,
    ) -> Dual<S, K, N> {
        match self {
            Self::ByGap => gap.at_least(0.0),
            Self::Never => gap,
            Self::Fixed(status) => where_closed(status, first, gap),
        }
    }

    /// Stress of spring and dashpot (Pa) of the nodes that push, zero for the others. A contact pushes and never pulls: a
    /// damped node has no force while `unclamped`, the stress of both together, is negative. Bonded nodes can pull.
    #[inline(always)]
    pub fn damped<S: Simd, const K: usize, const N: usize>(
        self,
        first: usize,
        gap: Dual<S, K, N>,
        unclamped: Dual<S, K, N>,
    ) -> Dual<S, K, N> {
        match self {
            Self::ByGap => unclamped.linear(
                #[inline(always)]
                |x| x.where_positive(gap.value).where_positive(unclamped.value),
            ),
            Self::Never => unclamped,
            Self::Fixed(status) => {
                let (separated, pulled) = status.split_at(status.len() / 2);
                where_closed(separated, first, where_closed(pulled, first, unclamped))
            }
        }
    }
}

/// The numbers of nodes with a clear bit (closed nodes), zero for the others.
#[inline(always)]
fn where_closed<S: Simd, const K: usize, const N: usize>(
    status: &[u8],
    first: usize,
    numbers: Dual<S, K, N>,
) -> Dual<S, K, N> {
    numbers.linear(
        #[inline(always)]
        |mut vector| {
            for k in 0..K {
                let place = LanePosition::of::<S>(first + k);
                let part = vector.one(k).where_clear(status[place.block], place.part);
                vector.set(k, part);
            }
            vector
        },
    )
}

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

impl ContactDamping {
    /// Whether the contact is undamped.
    pub fn is_none(self) -> bool {
        self == Self::None
    }

    /// Stress of spring and dashpot of closed nodes (Pa) with the gap function `gap` (Pa), the stiffness (N/m^3) and the
    /// approach velocity `rate = du_r/dt` (m/s); negative where they pull.
    #[inline(always)]
    pub(crate) fn unclamped<S: Simd, const K: usize, const N: usize>(
        self,
        gap: Dual<S, K, N>,
        stiffness: Vector<S, K>,
        rate: Dual<S, K, N>,
    ) -> Dual<S, K, N> {
        match self {
            Self::None => gap,
            Self::KelvinVoigt { .. } => self.guard(gap, stiffness, rate),
            Self::HuntCrossley { .. } => gap * self.guard(gap, stiffness, rate),
        }
    }

    /// Guard of the contact force of closed nodes: a smooth function with the sign of the stress of spring and
    /// dashpot together. For a dashpot it is this stress (Pa); for Hunt-Crossley damping, `1 + chi du_r/dt`.
    #[inline(always)]
    pub(crate) fn guard<S: Simd, const K: usize, const N: usize>(
        self,
        gap: Dual<S, K, N>,
        stiffness: Vector<S, K>,
        rate: Dual<S, K, N>,
    ) -> Dual<S, K, N> {
        let one = stiffness.broadcast(1.0);
        match self {
            Self::None => Dual::constant(one),
            Self::KelvinVoigt { time } => gap + rate.times(stiffness * one.broadcast(time)),
            Self::HuntCrossley { dissipation } => rate.times_plus(one.broadcast(dissipation), one),
        }
    }
}
