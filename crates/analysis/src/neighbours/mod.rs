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

use std::marker::PhantomData;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

pub use self::search::Neighbour;
use self::search::{Best, Euclidean, Manhattan, Maximum, Metric, Query};
use self::tree::Tree;
use super::{DelayVectors, Norm};

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
    arch: Arch,
}

/// A search, compiled for the instruction set of the machine.
///
/// (A separate type, because a closure is compiled for the baseline instruction set.)
struct Search<'t, 'a, M, K> {
    tree: &'t NeighbourTree<'a>,
    theiler: usize,
    limit: usize,
    kind: K,
    metric: PhantomData<M>,
}

/// Nearest neighbour of a vector, optionally only among those farther away than a radius.
struct Nearest {
    i: usize,
    beyond: Option<f64>,
}

/// Nearest neighbours of some vectors.
struct NearestEach<I>(I);

/// All neighbours of a vector within a radius.
struct Within<'e, F> {
    i: usize,
    radius: f64,
    each: &'e mut F,
}

impl<M: Metric> WithSimd for Search<'_, '_, M, Nearest> {
    type Output = Option<Neighbour>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut query = Query::new(&self.tree.vectors, self.theiler, self.limit);
        if let Some(radius) = self.kind.beyond {
            query = query.beyond::<M>(radius);
        }
        query.at(self.kind.i);
        let best = self.tree.tree.nearest::<S, M>(simd, &mut query, Best::NONE);
        best.neighbour::<M>()
    }
}

impl<M: Metric, I: Iterator<Item = usize>> WithSimd for Search<'_, '_, M, NearestEach<I>> {
    type Output = Vec<Option<Neighbour>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let NearestEach(vectors) = self.kind;
        let mut query = Query::new(&self.tree.vectors, self.theiler, self.limit);
        let mut before = (0, Best::NONE);
        let mut nearest = Vec::with_capacity(vectors.size_hint().0);
        // A closure in an iterator might be compiled for the baseline instruction set.
        for i in vectors {
            query.at(i);
            // The neighbour of the previous vector has moved on as well.
            let guess = query.guess::<M>(before);
            let best = self.tree.tree.nearest::<S, M>(simd, &mut query, guess);
            before = (i, best);
            nearest.push(best.neighbour::<M>());
        }
        nearest
    }
}

impl<M: Metric, F: FnMut(Neighbour)> WithSimd for Search<'_, '_, M, Within<'_, F>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Within { i, radius, each } = self.kind;
        let mut query = Query::new(&self.tree.vectors, self.theiler, self.limit);
        query.at(i);
        self.tree.tree.within::<M>(&mut query, radius, each);
    }
}

/// Runs a search with the norm of the tree.
macro_rules! dispatch {
    ($tree:expr, $theiler:expr, $limit:expr, $kind:expr) => {
        match $tree.norm {
            Norm::Euclidean => dispatch!($tree, $theiler, $limit, $kind, Euclidean),
            Norm::Maximum => dispatch!($tree, $theiler, $limit, $kind, Maximum),
            Norm::Manhattan => dispatch!($tree, $theiler, $limit, $kind, Manhattan),
        }
    };
    ($tree:expr, $theiler:expr, $limit:expr, $kind:expr, $metric:ty) => {
        $tree.arch.dispatch(Search {
            tree: $tree,
            theiler: $theiler,
            limit: $limit,
            kind: $kind,
            metric: PhantomData::<$metric>,
        })
    };
}

impl<'a> NeighbourTree<'a> {
    /// Builds the tree of the vectors.
    pub fn new(vectors: DelayVectors<'a>, norm: Norm) -> Self {
        Self {
            vectors,
            norm,
            tree: Tree::new(&vectors),
            arch: Arch::new(),
        }
    }

    /// Nearest neighbour of vector `i` among those with `|i - j| >= theiler` (at least 1) and
    /// `j < limit`. Of several at the same distance, the one with the smallest index. `None` if there is
    /// none.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn nearest(&self, i: usize, theiler: usize, limit: usize) -> Option<Neighbour> {
        dispatch!(self, theiler, limit, Nearest { i, beyond: None })
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
        let beyond = Some(radius);
        dispatch!(self, theiler, limit, Nearest { i, beyond })
    }

    /// [`NeighbourTree::nearest`] for each of the given vectors. Fastest if they follow each other closely.
    ///
    /// # Panics
    /// If a vector is not below [`DelayVectors::len`].
    pub fn nearest_each(
        &self,
        vectors: impl Iterator<Item = usize>,
        theiler: usize,
        limit: usize,
    ) -> Vec<Option<Neighbour>> {
        dispatch!(self, theiler, limit, NearestEach(vectors))
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
        let each = &mut each;
        dispatch!(self, theiler, limit, Within { i, radius, each });
    }
}
