//! Who is near whom: a k-d tree over delay vectors.
//!
//! Recurrence times, false neighbours and Lyapunov exponents all ask for the nearest states of
//! *another* time: a state's neighbours along its own stretch of trajectory say nothing about the
//! attractor. So every question carries a Theiler window `apart` (J. Theiler, Phys. Rev. A 34,
//! 2427, 1986): vector `j` counts as a neighbour of `i` if `|i - j| >= max(apart, 1)`.
//!
//! The tree splits the vectors at the median of their widest coordinate, again and again (Friedman,
//! Bentley and Finkel, ACM Trans. Math. Softw. 3, 209, 1977), down to buckets of a few vectors.
//! A search measures the distance to boxes round the buckets and opens only those that may hold
//! something nearer. It is exact: its answers are those of measuring the distance to every
//! vector, to the last bit.

mod search;
#[cfg(test)]
mod tests;
mod tree;

use pulp::Arch;
use rayon::prelude::*;

use self::search::{Best, City, Euclid, Largest, Metric, Query};
use self::tree::{Bucket, Tree};
use super::{DelayVectors, Norm};

/// Buckets that one task of [`NeighbourTree::nearest_all`] answers for.
const BUCKETS_A_TASK: usize = 32;

/// A neighbour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Index of the vector.
    pub index: usize,
    /// Distance, in the signal's unit.
    pub distance: f64,
}

/// A k-d tree over delay vectors.
///
/// Distances are sums over the coordinates in ascending order (oldest first): of squares for
/// [`Norm::Euclidean`], whose distance is the square root of that sum. Which of two vectors is
/// nearer is decided by the sum.
///
/// Building takes `O(n log n)`, a search about `O(log n)` while the dimension is low; vectors
/// that coincide, however many, cost no more than others.
pub struct NeighbourTree<'a> {
    vectors: DelayVectors<'a>,
    norm: Norm,
    tree: Tree,
    arch: Arch,
}

/// Runs an expression with `$metric` the type that measures by this norm.
macro_rules! with_metric {
    ($norm:expr, $metric:ident => $body:expr) => {
        match $norm {
            Norm::Euclidean => {
                type $metric = Euclid;
                $body
            }
            Norm::Maximum => {
                type $metric = Largest;
                $body
            }
            Norm::Manhattan => {
                type $metric = City;
                $body
            }
        }
    };
}

impl<'a> NeighbourTree<'a> {
    /// The tree of these vectors.
    pub fn new(vectors: DelayVectors<'a>, norm: Norm) -> Self {
        Self {
            vectors,
            norm,
            tree: Tree::new(&vectors),
            arch: Arch::new(),
        }
    }

    /// The nearest neighbour of vector `i` among those with `|i - j| >= apart` (at least 1) and
    /// `j < limit`; of several at the same distance the one with the smallest index. `None` if
    /// there is none.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn nearest(&self, i: usize, apart: usize, limit: usize) -> Option<Neighbour> {
        let mut query = Query::new(&self.vectors, apart, limit);
        with_metric!(self.norm, M => self.arch.dispatch(
            #[inline(always)]
            || {
                query.at(i);
                self.tree.nearest::<M>(&mut query, Best::NONE).neighbour::<M>()
            }
        ))
    }

    /// [`NeighbourTree::nearest`] among those farther away than `radius`: the nearest that does
    /// not (nearly) coincide with vector `i`.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn nearest_beyond(
        &self,
        i: usize,
        radius: f64,
        apart: usize,
        limit: usize,
    ) -> Option<Neighbour> {
        with_metric!(self.norm, M => self.arch.dispatch(
            #[inline(always)]
            || {
                let mut query = Query::new(&self.vectors, apart, limit).beyond::<M>(radius);
                query.at(i);
                self.tree.nearest::<M>(&mut query, Best::NONE).neighbour::<M>()
            }
        ))
    }

    /// [`NeighbourTree::nearest`] of each of the vectors `0..limit` (all of them, if there are
    /// fewer), on all cores.
    pub fn nearest_all(&self, apart: usize, limit: usize) -> Vec<Option<Neighbour>> {
        let buckets = &self.tree.buckets;
        let answer = |buckets: &[Bucket]| {
            with_metric!(self.norm, M => self.arch.dispatch(
                #[inline(always)]
                || self.nearest_of_buckets::<M>(buckets, apart, limit)
            ))
        };
        let answers: Vec<_> = buckets.par_chunks(BUCKETS_A_TASK).map(answer).collect();
        let mut nearest = vec![None; limit.min(self.vectors.len())];
        for (i, neighbour) in answers.into_iter().flatten() {
            nearest[i] = neighbour;
        }
        nearest
    }

    /// The nearest neighbours of the vectors in some buckets. The neighbour of one is a good
    /// first guess for the next.
    #[inline(always)]
    fn nearest_of_buckets<M: Metric>(
        &self,
        buckets: &[Bucket],
        apart: usize,
        limit: usize,
    ) -> Vec<(usize, Option<Neighbour>)> {
        let mut query = Query::new(&self.vectors, apart, limit);
        let mut best = Best::NONE;
        let mut answers = Vec::with_capacity(buckets.len() * tree::BUCKET);
        for bucket in buckets {
            for &i in bucket.indices.iter().filter(|&&i| i < limit) {
                query.at(i);
                let guess = query.guess::<M>(best);
                best = self.tree.nearest::<M>(&mut query, guess);
                answers.push((i, best.neighbour::<M>()));
            }
        }
        answers
    }

    /// Calls `each` for every neighbour of vector `i` at `radius` or nearer with
    /// `|i - j| >= apart` (at least 1) and `j < limit`, in no particular but a fixed order.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn within(
        &self,
        i: usize,
        radius: f64,
        apart: usize,
        limit: usize,
        mut each: impl FnMut(Neighbour),
    ) {
        let mut query = Query::new(&self.vectors, apart, limit);
        with_metric!(self.norm, M => self.arch.dispatch(
            #[inline(always)]
            || {
                query.at(i);
                self.tree.within::<M>(&mut query, radius, &mut each);
            }
        ));
    }
}
