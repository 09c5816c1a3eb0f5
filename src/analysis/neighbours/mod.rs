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

use std::marker::PhantomData;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

pub use self::search::Neighbour;
use self::search::{Best, City, Euclid, Largest, Metric, Query};
use self::tree::{BUCKET, Bucket, Tree};
use super::{DelayVectors, Norm};

/// Buckets that one task of [`NeighbourTree::nearest_all`] answers for.
const BUCKETS_A_TASK: usize = 32;

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

/// Something to be done in the tree, compiled for the instructions of the machine.
///
/// (A job is a type of its own because a closure would be compiled for those of any machine.)
struct Job<'t, 'a, M, K> {
    tree: &'t NeighbourTree<'a>,
    apart: usize,
    limit: usize,
    kind: K,
    metric: PhantomData<M>,
}

/// The nearest neighbour of a vector among those farther than a radius, if one is given.
struct Nearest {
    i: usize,
    beyond: Option<f64>,
}

/// The nearest neighbours of the vectors in some buckets.
struct NearestOfBuckets<'t>(&'t [Bucket]);

/// All neighbours of a vector within a radius.
struct Within<'e, F> {
    i: usize,
    radius: f64,
    each: &'e mut F,
}

impl<M: Metric> WithSimd for Job<'_, '_, M, Nearest> {
    type Output = Option<Neighbour>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let mut query = Query::new(&self.tree.vectors, self.apart, self.limit);
        if let Some(radius) = self.kind.beyond {
            query = query.beyond::<M>(radius);
        }
        query.at(self.kind.i);
        let best = self.tree.tree.nearest::<M>(&mut query, Best::NONE);
        best.neighbour::<M>()
    }
}

impl<M: Metric> WithSimd for Job<'_, '_, M, NearestOfBuckets<'_>> {
    type Output = Vec<(usize, Option<Neighbour>)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Self::Output {
        let NearestOfBuckets(buckets) = self.kind;
        let mut query = Query::new(&self.tree.vectors, self.apart, self.limit);
        let mut best = Best::NONE;
        let mut answers = Vec::with_capacity(buckets.len() * BUCKET);
        for bucket in buckets {
            for &i in bucket.indices.iter().filter(|&&i| i < self.limit) {
                query.at(i);
                // The neighbour of the last one is a good first guess for this.
                let guess = query.guess::<M>(best);
                best = self.tree.tree.nearest::<M>(&mut query, guess);
                answers.push((i, best.neighbour::<M>()));
            }
        }
        answers
    }
}

impl<M: Metric, F: FnMut(Neighbour)> WithSimd for Job<'_, '_, M, Within<'_, F>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Within { i, radius, each } = self.kind;
        let mut query = Query::new(&self.tree.vectors, self.apart, self.limit);
        query.at(i);
        self.tree.tree.within::<M>(&mut query, radius, each);
    }
}

/// Does a job with the norm of the tree.
macro_rules! dispatch {
    ($tree:expr, $apart:expr, $limit:expr, $kind:expr) => {
        match $tree.norm {
            Norm::Euclidean => dispatch!($tree, $apart, $limit, $kind, Euclid),
            Norm::Maximum => dispatch!($tree, $apart, $limit, $kind, Largest),
            Norm::Manhattan => dispatch!($tree, $apart, $limit, $kind, City),
        }
    };
    ($tree:expr, $apart:expr, $limit:expr, $kind:expr, $metric:ty) => {
        $tree.arch.dispatch(Job {
            tree: $tree,
            apart: $apart,
            limit: $limit,
            kind: $kind,
            metric: PhantomData::<$metric>,
        })
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
        dispatch!(self, apart, limit, Nearest { i, beyond: None })
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
        let beyond = Some(radius);
        dispatch!(self, apart, limit, Nearest { i, beyond })
    }

    /// [`NeighbourTree::nearest`] of each of the vectors `0..limit` (all of them, if there are
    /// fewer), on all cores.
    pub fn nearest_all(&self, apart: usize, limit: usize) -> Vec<Option<Neighbour>> {
        let answer = |buckets| dispatch!(self, apart, limit, NearestOfBuckets(buckets));
        let tasks = self.tree.buckets.par_chunks(BUCKETS_A_TASK);
        let answers: Vec<_> = tasks.map(answer).collect();
        let mut nearest = vec![None; limit.min(self.vectors.len())];
        for (i, neighbour) in answers.into_iter().flatten() {
            nearest[i] = neighbour;
        }
        nearest
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
        let each = &mut each;
        dispatch!(self, apart, limit, Within { i, radius, each });
    }
}
