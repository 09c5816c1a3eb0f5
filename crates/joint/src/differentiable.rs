//! The derivative of the joint's force, for tangent vectors.

use super::contact_force::PAPER_MODES;
use super::evolving::{EvolvingProduct, record_blocks};
use super::jacobian::{Assembly, MatrixFreeProduct, MatrixProduct};
use super::node_slopes::KEPT;
use super::separation::Separation;
use super::simd::LANES;
use super::{Joint, MAX_MODES};
use squeakscope_dynamics::{Differentiable, System};

/// Minimum number of tangent vectors for which the Jacobian is assembled; fewer vectors use matrix-free
/// products. Both cost about the same at this number for the eleven modes of the paper.
pub(crate) const MIN_VECTORS_TO_ASSEMBLE: usize = 13;

/// Parts of a record.
pub(super) struct Parts<'a> {
    /// Derivatives of the nodes.
    pub kept: &'a mut [[f64; LANES]],
    /// Partial sums over the nodes.
    pub sums: &'a mut [[f64; LANES]],
    /// The Jacobian of the force, `m x 2m`, row-major.
    pub matrix: &'a mut [f64],
}

impl Joint {
    /// Lengths of the node derivatives, the partial sums and the matrix.
    fn record_parts(&self) -> [usize; 3] {
        let m = self.modes();
        if self.evolving().is_some() {
            return [record_blocks(self.nodes.count) * LANES, 0, 0];
        }
        [
            self.nodes.blocks.len() * (KEPT + usize::from(!self.contact_damping.is_none())) * LANES,
            m * (2 * m).max(3) * LANES,
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

    /// Assembles the Jacobian of the force (`m x 2m`, row-major) in the record.
    pub(crate) fn assembled<'a>(&self, record: &'a mut [f64]) -> &'a [f64] {
        let Parts { kept, sums, matrix } = self.parts_of(record);
        self.arch.dispatch(Assembly {
            nodes: &self.nodes,
            friction: self.law.law().is_some(),
            radial: self.law.radial(),
            kept,
            sums,
            matrix,
        });
        matrix
    }

    /// [`Differentiable::product`] with the assembled Jacobian.
    pub(crate) fn product_assembled(
        &self,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let matrix = self.assembled(record);
        self.arch.dispatch(MatrixProduct {
            modes: self.modes(),
            matrix,
            vectors,
            width,
            out,
        });
    }

    /// [`Differentiable::product`] without a matrix, as a sum over the nodes.
    pub(crate) fn product_matrix_free(
        &self,
        record: &mut [f64],
        vectors: &[f64],
        width: usize,
        out: &mut [f64],
    ) {
        let Parts { kept, sums, .. } = self.parts_of(record);
        let sums = &mut sums[..3 * self.modes()];
        macro_rules! sweep {
            ($axes:literal) => {
                match self.modes() {
                    PAPER_MODES => sweep!($axes, PAPER_MODES),
                    _ => sweep!($axes, MAX_MODES),
                }
            };
            ($axes:literal, $modes:ident) => {
                self.arch.dispatch(MatrixFreeProduct::<$axes, $modes> {
                    nodes: &self.nodes,
                    kept,
                    vectors,
                    width,
                    sums,
                    out,
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
    /// Length of the node derivatives and the Jacobian.
    fn record_len(&self) -> usize {
        self.record_parts().iter().sum()
    }

    /// The force is bit-identical to that without a record.
    ///
    /// Without a status, a node with a gap of exactly zero is recorded as separated.
    fn force_recorded(
        &self,
        status: Option<&[u8]>,
        _t: f64,
        z: &[f64],
        out: &mut [f64],
        record: &mut [f64],
    ) {
        let contact = status.map_or(self.lift_off(), Separation::Fixed);
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
        if let Some(evolving) = self.evolving() {
            let kept = &*self.parts_of(record).kept;
            self.arch.dispatch(EvolvingProduct {
                nodes: &self.nodes,
                evolving,
                kept,
                vectors,
                width,
                out,
            });
        } else if width < MIN_VECTORS_TO_ASSEMBLE && !self.has_optional_terms() {
            self.product_matrix_free(record, vectors, width, out);
        } else {
            self.product_assembled(record, vectors, width, out);
        }
    }
}
