//! Eq. (6) and (8): the generalised forces of contact and friction. The hot loop.
//!
//! The law of friction and whether nodes lift off are matched once, outside the loop over the
//! nodes; the loop is then compiled for that very choice and for the widest vectors of the machine.
//! An absent effect costs nothing: without friction no velocity is formed.

use pulp::{Simd, WithSimd};

use super::friction::FrictionLaw;
use super::lanes::{Fused, LANES, Lanes, Plain, Reals};
use super::nodes::{Block, Nodes, Rows};

/// What the loop does at each node for friction.
pub(crate) trait Law {
    /// Whether there is friction at all.
    const SLIDES: bool;
    /// Whether the radial velocity takes part, as Eq. (8) has it.
    const RADIAL: bool;
    /// `mu(V)/V` at the given speeds, all positive.
    fn ratio<R: Reals>(&self, speed: Lanes) -> Lanes;
}

/// No friction.
pub(crate) struct Frictionless;

impl Law for Frictionless {
    const SLIDES: bool = false;
    const RADIAL: bool = false;
    #[inline(always)]
    fn ratio<R: Reals>(&self, _: Lanes) -> Lanes {
        Lanes::ZERO
    }
}

/// Eq. (5).
pub(crate) struct Smoothed<const RADIAL: bool>(pub super::Stribeck);

impl<const RADIAL: bool> Law for Smoothed<RADIAL> {
    const SLIDES: bool = true;
    const RADIAL: bool = RADIAL;
    #[inline(always)]
    fn ratio<R: Reals>(&self, speed: Lanes) -> Lanes {
        self.0.ratio_lanes::<R>(speed)
    }
}

/// A user's own law, called once a block.
pub(crate) struct Custom<'a, const RADIAL: bool>(pub &'a dyn FrictionLaw);

impl<const RADIAL: bool> Law for Custom<'_, RADIAL> {
    const SLIDES: bool = true;
    const RADIAL: bool = RADIAL;
    #[inline(always)]
    fn ratio<R: Reals>(&self, speed: Lanes) -> Lanes {
        Lanes(self.0.ratios(&speed.0))
    }
}

/// One pass over the nodes.
pub(crate) struct Traction<'a, L> {
    pub nodes: &'a Nodes,
    pub law: L,
    pub unilateral: bool,
    /// Modal coordinates and velocities.
    pub q: &'a [f64],
    pub v: &'a [f64],
    /// Gets the generalised forces, `m`.
    pub force: &'a mut [f64],
}

/// What the pass found beside the forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Passed {
    /// Power of friction's deviation from steady sliding on the vibration, W.
    pub power: f64,
}

impl<L: Law> WithSimd for Traction<'_, L> {
    type Output = Passed;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Passed {
        // Without vector instructions there is no fused one either.
        match (S::IS_SCALAR, self.unilateral, self.nodes.modes) {
            (false, true, PAPER_MODES) => self.pass::<Fused, true>(&mut [Lanes::ZERO; PAPER_MODES]),
            (false, true, m) => self.pass::<Fused, true>(&mut [Lanes::ZERO; MOST_MODES][..m]),
            (false, false, m) => self.pass::<Fused, false>(&mut [Lanes::ZERO; MOST_MODES][..m]),
            (true, true, m) => self.pass::<Plain, true>(&mut [Lanes::ZERO; MOST_MODES][..m]),
            (true, false, m) => self.pass::<Plain, false>(&mut [Lanes::ZERO; MOST_MODES][..m]),
        }
    }
}

impl<L: Law> Traction<'_, L> {
    /// The loop for arithmetic `R`, with or without lift-off; `sums` are the accumulators, one a
    /// mode. Where their number is known to the compiler, they stay in registers.
    #[inline(always)]
    fn pass<R: Reals, const UNILATERAL: bool>(self, sums: &mut [Lanes]) -> Passed {
        let modes = sums.len();
        let (q, v) = (&self.q[..modes], &self.v[..modes]);
        let force = &mut self.force[..modes];
        let mut power = Lanes::ZERO;
        for (block, rows) in self.nodes.iter() {
            let rows = &rows[..modes];
            // Eq. (2)
            let mut u_r = Lanes::ZERO;
            for i in 0..modes {
                u_r = R::mul_add(rows[i].r, Lanes::splat(q[i]), u_r);
            }
            let mut stress = R::mul_add(block.stiffness, u_r, block.pre_stress);
            if UNILATERAL {
                stress = stress.at_least(0.0);
            }
            let normal = stress * block.area;
            if !L::SLIDES {
                for i in 0..modes {
                    sums[i] = R::mul_add(rows[i].r, -normal, sums[i]);
                }
                continue;
            }
            let slip = Slip::of::<R, L>(block, rows, v);
            // Eq. (3): -mu N V_vec / V
            let drag = -(normal * self.law.ratio::<R>(slip.speed::<R, L>()));
            let along = drag * slip.along;
            let across = drag * slip.across;
            let outward = if L::RADIAL {
                drag * slip.outward
            } else {
                Lanes::ZERO
            };
            let vibration = slip.along - block.speed;
            power = R::mul_add(along - block.steady_friction, vibration, power);
            power = R::mul_add(across, slip.across, power);
            if L::RADIAL {
                power = R::mul_add(outward, slip.outward, power);
            }
            // Eq. (8)
            let radial = outward - normal;
            for i in 0..modes {
                let sum = R::mul_add(rows[i].s, along, sums[i]);
                let sum = R::mul_add(rows[i].t, across, sum);
                sums[i] = R::mul_add(rows[i].r, radial, sum);
            }
        }
        for (out, sum) in force.iter_mut().zip(sums.iter()) {
            *out = sum.sum();
        }
        Passed { power: power.sum() }
    }
}

/// Number of modes in the paper: the loop is compiled for it apart.
const PAPER_MODES: usize = 11;

/// The most modes that the loop's accumulators hold.
pub(crate) const MOST_MODES: usize = 64;

/// Slip velocity, Eq. (4), in the node's frame.
#[derive(Clone, Copy)]
pub(crate) struct Slip {
    pub along: Lanes,
    pub across: Lanes,
    pub outward: Lanes,
}

impl Slip {
    #[inline(always)]
    pub fn of<R: Reals, L: Law>(block: &Block, rows: &[Rows], v: &[f64]) -> Self {
        let mut slip = Slip {
            along: block.speed,
            across: Lanes::ZERO,
            outward: Lanes::ZERO,
        };
        for (row, &v) in rows.iter().zip(v) {
            let v = Lanes::splat(v);
            slip.along = R::mul_add(row.s, v, slip.along);
            slip.across = R::mul_add(row.t, v, slip.across);
            if L::RADIAL {
                slip.outward = R::mul_add(row.r, v, slip.outward);
            }
        }
        slip
    }

    /// Its magnitude, kept a hair above zero so that `mu(V)/V` can be formed by a division.
    #[inline(always)]
    pub fn speed<R: Reals, L: Law>(&self) -> Lanes {
        let mut square = R::mul_add(self.across, self.across, self.along * self.along);
        if L::RADIAL {
            square = R::mul_add(self.outward, self.outward, square);
        }
        square.at_least(1e-280).map(f64::sqrt)
    }
}

/// A pass over the normal gaps only: which nodes are open.
pub(crate) struct OpenNodes<'a> {
    pub nodes: &'a Nodes,
    pub q: &'a [f64],
    /// Gets one bit a node, eight nodes a byte; a set bit means open.
    pub open: &'a mut [u8],
}

impl WithSimd for OpenNodes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((block, rows), bits) in self.nodes.iter().zip(self.open.iter_mut()) {
            let mut gap = block.pre_stress;
            for (row, &q) in rows.iter().zip(self.q) {
                let stress = block.stiffness * row.r;
                gap = if S::IS_SCALAR {
                    Plain::mul_add(stress, Lanes::splat(q), gap)
                } else {
                    Fused::mul_add(stress, Lanes::splat(q), gap)
                };
            }
            *bits = (0..LANES).fold(0, |bits, l| bits | (u8::from(gap.0[l] < 0.0) << l));
        }
    }
}
