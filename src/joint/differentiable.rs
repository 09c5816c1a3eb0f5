//! The derivative of the joint's force, as the tangent flow needs it.

use super::extras::Addition;
use super::jacobian::{Assembly, Multiplied, Swept};
use super::lanes::LANES;
use super::lift_off::LiftOff;
use super::record::KEPT;
use super::traction::PAPER_MODES;
use super::{Joint, MOST_MODES};
use crate::dynamics::{Differentiable, System};

/// Tangent vectors from which on the force's Jacobian is assembled first; fewer go through the
/// nodes themselves. About where the two cost the same with the paper's eleven modes.
pub(crate) const WORTH_ASSEMBLING: usize = 7;

/// The parts of a record.
pub(super) struct Parts<'a> {
    /// Each node's derivative.
    pub kept: &'a mut [[f64; LANES]],
    /// Sums over the nodes on their way.
    pub sums: &'a mut [[f64; LANES]],
    /// The Jacobian of the force, `m x 2m`, row-major.
    pub matrix: &'a mut [f64],
}

impl Joint {
    /// Numbers of the nodes' derivatives, of the sums, and of the matrix.
    fn record_parts(&self) -> [usize; 3] {
        let m = self.modes();
        [
            self.nodes.blocks.len() * (KEPT + usize::from(!self.contact_damping.is_none())) * LANES,
            2 * m * m * LANES,
            2 * m * m,
        ]
    }

    pub(super) fn parts_of<'a>(&self, record: &'a mut [f64]) -> Parts<'a> {
        let [kept, sums, matrix] = self.record_parts();
        let (kept, rest) = record.split_at_mut(kept);
        let (sums, rest) = rest.split_at_mut(sums);
        Parts {
            kept: kept.as_chunks_mut().0,
            sums: sums.as_chunks_mut().0,
            matrix: &mut rest[..matrix],
        }
    }

    /// Assembles the Jacobian of the force from a record, into the record, `m x 2m`, row-major.
    pub(crate) fn assembled<'a>(&self, record: &'a mut [f64]) -> &'a [f64] {
        let Parts { kept, sums, matrix } = self.parts_of(record);
        let nodes = &self.nodes;
        macro_rules! assemble {
            ($weights:literal) => {
                self.arch.dispatch(Assembly::<$weights> {
                    nodes,
                    kept: &*kept,
                    sums: &mut *sums,
                    matrix: &mut *matrix,
                })
            };
        }
        match (self.law.law(), self.law.radial()) {
            (None, _) => assemble!(1),
            (_, false) => assemble!(3),
            (_, true) => assemble!(4),
        }
        if self.has_extras() {
            self.arch.dispatch(Addition {
                nodes,
                radial: self.law.radial(),
                kept,
                sums,
                matrix,
            });
        }
        matrix
    }

    /// [`Differentiable::product`] by the assembled Jacobian.
    pub(crate) fn product_assembled(
        &self,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let matrix = self.assembled(record);
        self.arch.dispatch(Multiplied {
            modes: self.modes(),
            matrix,
            vectors,
            width,
            out,
        });
    }

    /// [`Differentiable::product`] node by node, without a matrix.
    pub(crate) fn product_swept(
        &self,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let kept = &*self.parts_of(record).kept;
        let nodes = &self.nodes;
        macro_rules! sweep {
            ($axes:literal) => {
                for first in (0..width).step_by(2) {
                    match (width - first, self.modes()) {
                        (1, PAPER_MODES) => sweep!($axes, 1, PAPER_MODES, first),
                        (1, _) => sweep!($axes, 1, MOST_MODES, first),
                        (_, PAPER_MODES) => sweep!($axes, 2, PAPER_MODES, first),
                        (_, _) => sweep!($axes, 2, MOST_MODES, first),
                    }
                }
            };
            ($axes:literal, $count:literal, $modes:ident, $first:ident) => {
                self.arch.dispatch(Swept::<$axes, $count, $modes> {
                    nodes,
                    kept,
                    vectors,
                    width,
                    first: $first,
                    out: &mut *out,
                })
            };
        }
        match (self.law.law(), self.law.radial()) {
            (None, _) => sweep!(0),
            (_, false) => sweep!(2),
            (_, true) => sweep!(3),
        }
    }
}

impl Differentiable for Joint {
    /// Each node's derivative, and room for the Jacobian of the force.
    fn record_len(&self) -> usize {
        self.record_parts().iter().sum()
    }

    /// The force is that without a record, to the last bit.
    ///
    /// Without a status, a node whose gap is exactly zero is recorded as open.
    fn force_recorded(
        &self,
        status: Option<&[u8]>,
        _t: f64,
        z: &[f64],
        out: &mut [f64],
        record: &mut [f64],
    ) {
        let contact = status.map_or(self.lift_off(), LiftOff::Held);
        self.force_by(contact, Some(self.parts_of(record).kept), z, out);
    }

    fn product(
        &self,
        _status: Option<&[u8]>,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        if width < WORTH_ASSEMBLING && !self.has_extras() {
            self.product_swept(record, vectors, width, out);
        } else {
            self.product_assembled(record, vectors, width, out);
        }
    }
}
