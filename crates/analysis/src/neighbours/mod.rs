//! Nearest-neighbour search with a k-d tree over delay vectors.
//!
//! Recurrence times, false neighbours and Lyapunov exponents need the nearest states at *other* times:
//! neighbours along the same section of the trajectory carry no information about the attractor. Every
//! search therefore takes a Theiler window (J. Theiler, Phys. Rev. A 34, 2427, 1986): vector `j` counts
//! as a neighbour of `i` if `|i - j| >= max(theiler, 1)`.
//!
//! The tree splits the vectors recursively at the median of their widest coordinate (Friedman, Bentley
//! and Finkel, ACM Trans. Math. Softw. 3, 209, 1977), down to buckets of a few vectors. A search
//! computes the distance to boxes around the buckets and visits only those that can contain a nearer
//! vector. It is exact: the result is the same, to the last bit, as with the distances to all vectors.

mod search;
#[cfg(test)]
mod tests;
mod tree;

use rayon::prelude::*;

pub use self::search::Neighbour;
use self::search::{Best, Query};
use self::tree::Tree;
use super::{DelayVectors, Norm};
use crate::simd::vectorised;

/// Vectors per task of [`NeighbourTree::nearest_all`].
const VECTORS_A_TASK: usize = 512;

/// A k-d tree over delay vectors.
///
/// Distances are sums over the coordinates in ascending order (oldest first). For [`Norm::Euclidean`] it
/// is a sum of squares, and the distance its square root. Vectors are compared by that sum.
///
/// Building takes `O(n log n)`, a search about `O(log n)` in low dimensions. Coincident vectors cost no
/// more than others.
pub struct NeighbourTree<'a> {
    vectors: DelayVectors<'a>,
    norm: Norm,
    tree: Tree,
}

impl<'a> NeighbourTree<'a> {
    /// Builds the tree of the vectors.
    pub fn new(vectors: DelayVectors<'a>, norm: Norm) -> Self {
        Self {
            vectors,
            norm,
            tree: Tree::new(&vectors),
        }
    }

    /// Nearest neighbour of vector `i` among those with `|i - j| >= theiler` (at least 1) and
    /// `j < limit`. Of several at the same distance, the one with the smallest index. `None` if there is
    /// none.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn nearest(&self, i: usize, theiler: usize, limit: usize) -> Option<Neighbour> {
        self.nearest_beyond(i, -1.0, theiler, limit)
    }

    /// Like [`NeighbourTree::nearest`], among the neighbours farther away than `radius`. Excludes
    /// vectors that (nearly) coincide with vector `i`.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn nearest_beyond(
        &self,
        i: usize,
        radius: f64,
        theiler: usize,
        limit: usize,
    ) -> Option<Neighbour> {
        let mut query = Query::new(&self.vectors, self.norm, theiler, limit).beyond(radius);
        let best = vectorised(
            #[inline(always)]
            || {
                query.at(i);
                self.tree.nearest(&mut query, Best::NONE)
            },
        );
        best.neighbour(self.norm)
    }

    /// [`NeighbourTree::nearest`] for each of the given vectors. Fastest if they follow each other closely.
    ///
    /// # Panics
    /// If a vector is not below [`DelayVectors::len`].
    pub fn nearest_each(
        &self,
        mut vectors: impl Iterator<Item = usize>,
        theiler: usize,
        limit: usize,
    ) -> Vec<Option<Neighbour>> {
        let mut query = Query::new(&self.vectors, self.norm, theiler, limit);
        let mut before = (0, Best::NONE);
        let mut nearest = Vec::with_capacity(vectors.size_hint().0);
        vectorised(
            #[inline(always)]
            || {
                for i in vectors.by_ref() {
                    query.at(i);
                    // The neighbour of the previous vector has moved on as well.
                    let guess = query.guess(before);
                    let best = self.tree.nearest(&mut query, guess);
                    before = (i, best);
                    nearest.push(best.neighbour(self.norm));
                }
            },
        );
        nearest
    }

    /// [`NeighbourTree::nearest`] for each of the vectors `0..limit` (or all vectors, if there are
    /// fewer), on all cores.
    pub fn nearest_all(&self, theiler: usize, limit: usize) -> Vec<Option<Neighbour>> {
        let count = limit.min(self.vectors.len());
        let task = |task: usize| {
            let first = task * VECTORS_A_TASK;
            self.nearest_each(first..(first + VECTORS_A_TASK).min(count), theiler, limit)
        };
        let tasks = (0..count.div_ceil(VECTORS_A_TASK)).into_par_iter();
        let nearest: Vec<_> = tasks.map(task).collect();
        nearest.concat()
    }

    /// The vectors.
    pub fn vectors(&self) -> &DelayVectors<'a> {
        &self.vectors
    }

    /// Calls `each` for every neighbour of vector `i` within `radius` (inclusive) with
    /// `|i - j| >= theiler` (at least 1) and `j < limit`. The order is fixed but unspecified.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn within(
        &self,
        i: usize,
        radius: f64,
        theiler: usize,
        limit: usize,
        mut each: impl FnMut(Neighbour),
    ) {
        let mut query = Query::new(&self.vectors, self.norm, theiler, limit);
        vectorised(
            #[inline(always)]
            || {
                query.at(i);
                self.tree.within(&mut query, radius, &mut each);
            },
        );
    }
}
