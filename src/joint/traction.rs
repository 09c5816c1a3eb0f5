//! Eq. (6) and (8): the generalised forces of contact and friction. The hot loop.
//!
//! The law of friction is matched once, outside the loop over the nodes; the loop is then compiled
//! for that very law and for the widest vectors of the machine. An absent effect costs nothing:
//! without friction no velocity is formed. How nodes lift off, and whether a record is kept, is met
//! once a block, where it does not show.

use pulp::{Simd, WithSimd};

use super::friction::FrictionLaw;
use super::lanes::{LANES, Vector, parts};
use super::lift_off::LiftOff;
use super::nodes::Nodes;
use super::record::NodeSlopes;

/// What the loop does at each node for friction.
pub(crate) trait Law {
    /// Whether there is friction at all.
    const SLIDES: bool;
    /// Whether the radial velocity takes part, as Eq. (8) has it.
    const RADIAL: bool;
    /// `mu(V)/V` at the given speeds, all positive.
    fn ratio<S: Simd>(&self, simd: S, speed: Vector<S>) -> Vector<S>;
    /// The same, and `V` times the slope of the ratio: `dmu/dV - mu/V`.
    fn ratio_and_slope<S: Simd>(&self, simd: S, speed: Vector<S>) -> (Vector<S>, Vector<S>);
}

/// No friction.
pub(crate) struct Frictionless;

impl Law for Frictionless {
    const SLIDES: bool = false;
    const RADIAL: bool = false;
    #[inline(always)]
    fn ratio<S: Simd>(&self, simd: S, _: Vector<S>) -> Vector<S> {
        Vector::splat(simd, 0.0)
    }
    #[inline(always)]
    fn ratio_and_slope<S: Simd>(&self, simd: S, _: Vector<S>) -> (Vector<S>, Vector<S>) {
        (Vector::splat(simd, 0.0), Vector::splat(simd, 0.0))
    }
}

/// Eq. (5).
pub(crate) struct Smoothed<const RADIAL: bool>(pub super::Stribeck);

impl<const RADIAL: bool> Law for Smoothed<RADIAL> {
    const SLIDES: bool = true;
    const RADIAL: bool = RADIAL;
    #[inline(always)]
    fn ratio<S: Simd>(&self, simd: S, speed: Vector<S>) -> Vector<S> {
        self.0.ratio_vector(simd, speed)
    }
    #[inline(always)]
    fn ratio_and_slope<S: Simd>(&self, simd: S, speed: Vector<S>) -> (Vector<S>, Vector<S>) {
        self.0.ratio_and_slope_vector(simd, speed)
    }
}

/// A user's own law, called once a vector.
pub(crate) struct Custom<'a, const RADIAL: bool>(pub &'a dyn FrictionLaw);

impl<const RADIAL: bool> Law for Custom<'_, RADIAL> {
    const SLIDES: bool = true;
    const RADIAL: bool = RADIAL;
    #[inline(always)]
    fn ratio<S: Simd>(&self, _: S, speed: Vector<S>) -> Vector<S> {
        speed.through(|speeds| self.0.ratios(speeds))
    }
    #[inline(always)]
    fn ratio_and_slope<S: Simd>(&self, _: S, speed: Vector<S>) -> (Vector<S>, Vector<S>) {
        let (ratio, slope) =
            speed.through_both(|speeds, slopes| self.0.ratios_and_slopes(speeds, slopes));
        (ratio, speed * slope)
    }
}

/// One pass over the nodes.
pub(crate) struct Traction<'a, L> {
    pub nodes: &'a Nodes,
    pub law: L,
    /// Which nodes press.
    pub contact: LiftOff<'a>,
    /// Gets what is kept for the derivative, where that is wanted.
    pub record: Option<&'a mut [[f64; LANES]]>,
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
    fn with_simd<S: Simd>(self, simd: S) -> Passed {
        let zero = Vector::splat(simd, 0.0);
        match self.nodes.modes {
            PAPER_MODES => self.pass(simd, &mut [zero; PAPER_MODES]),
            m => self.pass(simd, &mut [zero; MOST_MODES][..m]),
        }
    }
}

impl<L: Law> Traction<'_, L> {
    /// The loop; `sums` are the accumulators, one a mode. Where their
    /// number is known to the compiler, they stay in registers.
    ///
    /// Eq. (1): the normal force on the ball is `-N e_r`, per area.
    ///
    /// Eq. (2): `N = max(0, p_n + k_c u_r)`, with `u_r` (m) from steady sliding.
    ///
    /// Eq. (3): the friction force is `-mu(V) N V_vec / V`, per area.
    ///
    /// Eq. (6): the virtual work of both, summed over the nodes with their areas `Delta A` (m^2).
    ///
    /// Eq. (8): the generalised force of mode `i` is `sum over nodes of
    /// (-mu N V_vec/V - N e_r) . Phi_i Delta A`, N/sqrt(kg).
    #[inline(always)]
    fn pass<S: Simd>(mut self, simd: S, sums: &mut [Vector<S>]) -> Passed {
        let modes = sums.len();
        let (q, v) = (&self.q[..modes], &self.v[..modes]);
        let zero = Vector::splat(simd, 0.0);
        let mut power = zero;
        for (index, (block, rows)) in self.nodes.iter().enumerate() {
            let rows = &rows[..modes];
            for part in 0..parts::<S>() {
                // Normal stress.
                let mut u_r = zero;
                for i in 0..modes {
                    u_r = rows[i]
                        .r
                        .part(simd, part)
                        .mul_add(Vector::splat(simd, q[i]), u_r);
                }
                let stiffness = block.stiffness.part(simd, part);
                let gap = stiffness.mul_add(u_r, block.pre_stress.part(simd, part));
                let area = block.area.part(simd, part);
                let normal = self.contact.stress(index, part, gap) * area;
                let pressing = || self.contact.pressing(index, part, gap, stiffness * area);
                if !L::SLIDES {
                    if let Some(record) = &mut self.record {
                        NodeSlopes::frictionless(simd, pressing()).keep(record, index, part);
                    }
                    for i in 0..modes {
                        sums[i] = rows[i].r.part(simd, part).mul_add(-normal, sums[i]);
                    }
                    continue;
                }
                // Slip velocity.
                let steady_speed = block.speed.part(simd, part);
                let (mut along, mut across, mut outward) = (steady_speed, zero, zero);
                for i in 0..modes {
                    let v = Vector::splat(simd, v[i]);
                    along = rows[i].s.part(simd, part).mul_add(v, along);
                    across = rows[i].t.part(simd, part).mul_add(v, across);
                    if L::RADIAL {
                        outward = rows[i].r.part(simd, part).mul_add(v, outward);
                    }
                }
                let mut square = across.mul_add(across, along * along);
                if L::RADIAL {
                    square = outward.mul_add(outward, square);
                }
                // A hair above zero, so that mu(V)/V can be formed by a division.
                let speed = square.at_least(1e-280).sqrt();
                // Friction force.
                let drag = if let Some(record) = &mut self.record {
                    let (ratio, slope) = self.law.ratio_and_slope(simd, speed);
                    let drag = normal * ratio;
                    let inverse = Vector::splat(simd, 1.0) / speed;
                    let outward = if L::RADIAL { outward } else { zero };
                    let slopes = NodeSlopes {
                        stiffness: pressing(),
                        coefficient: ratio * speed,
                        drag,
                        bend: normal * slope,
                        direction: [along, across, outward].map(|slip| slip * inverse),
                    };
                    slopes.keep(record, index, part);
                    -drag
                } else {
                    -(normal * self.law.ratio(simd, speed))
                };
                let (drag_along, drag_across) = (drag * along, drag * across);
                let deviation = drag_along - block.steady_friction.part(simd, part);
                power = deviation.mul_add(along - steady_speed, power);
                power = drag_across.mul_add(across, power);
                let mut radial = -normal;
                if L::RADIAL {
                    let drag_outward = drag * outward;
                    power = drag_outward.mul_add(outward, power);
                    radial = drag_outward - normal;
                }
                // Generalised forces.
                for i in 0..modes {
                    let sum = rows[i].s.part(simd, part).mul_add(drag_along, sums[i]);
                    let sum = rows[i].t.part(simd, part).mul_add(drag_across, sum);
                    sums[i] = rows[i].r.part(simd, part).mul_add(radial, sum);
                }
            }
        }
        for (out, sum) in self.force.iter_mut().zip(sums.iter()) {
            *out = sum.sum();
        }
        Passed { power: power.sum() }
    }
}

/// Number of modes in the paper: the loops are compiled for it apart.
pub(crate) const PAPER_MODES: usize = 11;

/// The most modes that a joint can have: as many as the hot loop has accumulators for.
pub const MOST_MODES: usize = 64;

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
    fn with_simd<S: Simd>(self, simd: S) {
        for ((block, rows), bits) in self.nodes.iter().zip(self.open.iter_mut()) {
            *bits = 0;
            for part in 0..parts::<S>() {
                let gap = block.gap(simd, rows, part, self.q);
                *bits |= gap.negative_bits() << (part * S::F64_LANES);
            }
        }
    }
}
