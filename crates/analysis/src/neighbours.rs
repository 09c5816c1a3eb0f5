//! Nearest-neighbour search with a k-d tree over delay vectors.
//!
//! Recurrence times, false neighbours and Lyapunov exponents need the nearest states at *other* times:
//! neighbours along the same section of the trajectory carry no information about the attractor. Every
//! search therefore takes a Theiler window (J. Theiler, Phys. Rev. A 34, 2427, 1986): vector `j` counts
//! as a neighbour of `i` if `|i - j| >= max(theiler, 1)`.
//!
//! The tree halves the vectors recursively at the median of their widest coordinate (Friedman, Bentley
//! and Finkel, ACM Trans. Math. Softw. 3, 209, 1977), down to buckets of a few vectors. A search
//! computes the distance to boxes around the buckets and visits only those that can contain a nearer
//! vector. It is exact: the result is the same, to the last bit, as with the distances to all vectors.

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::simd::vectorised;
use crate::{delay::DelayVectors, norm::Norm, stats::range};

/// Vectors per bucket.
const BUCKET: usize = 16;

/// Approximate number of vectors sampled to choose the axis of a split.
const AXIS_SAMPLES: usize = 32;

/// Splits of fewer vectors run without a parallel task.
const MIN_PARALLEL: usize = 4096;

/// Vectors per task of [`NeighbourTree::nearest_all`].
const VECTORS_A_TASK: usize = 512;

/// A neighbouring vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Neighbour {
    /// Index of the vector.
    pub index: usize,
    /// Distance, in the signal's unit.
    pub distance: f64,
}

/// Unrooted distance and index of a vector. The nearer of two vectors is the smaller pair: of several at the same
/// distance, the one with the smallest index.
type Candidate = (f64, usize);

/// Beyond all candidates. Its index is also that of an empty slot in the last bucket.
const NONE: Candidate = (f64::INFINITY, usize::MAX);

/// A k-d tree over delay vectors.
///
/// Distances are sums over the coordinates in ascending order (oldest first). For [`Norm::Euclidean`] it
/// is a sum of squares, and the distance its square root. Vectors are compared by that sum.
///
/// Building takes `O(n log n)`, a search about `O(log n)` in low dimensions. Coincident vectors cost no
/// more than others.
pub(crate) struct NeighbourTree<'a> {
    vectors: DelayVectors<'a>,
    norm: Norm,
    /// Indices of the vectors of each bucket, ascending. Empty slots of the last one have that of [`NONE`].
    buckets: Vec<[usize; BUCKET]>,
    /// Coordinate `c` of the vectors of bucket `b` is at `b * dimension + c`.
    coordinates: Vec<[f64; BUCKET]>,
    /// First and last index in each box. A box is followed by all boxes in the first half of its buckets, and these
    /// by those in the second half.
    spans: Vec<[usize; 2]>,
    /// Minimum and maximum of coordinate `c` in box `b`, at `b * dimension + c`.
    bounds: Vec<[f64; 2]>,
}

impl<'a> NeighbourTree<'a> {
    /// Builds the tree of the vectors.
    pub fn new(vectors: DelayVectors<'a>, norm: Norm) -> Self {
        let axes: Vec<&[f64]> = (0..vectors.dimension())
            .map(|c| vectors.coordinate(c))
            .collect();
        let mut order: Vec<(f64, usize)> = (0..vectors.len()).map(|i| (0.0, i)).collect();
        split(&mut order, &axes);
        let mut tree = Self {
            vectors,
            norm,
            buckets: Vec::new(),
            coordinates: Vec::new(),
            spans: Vec::new(),
            bounds: Vec::new(),
        };
        for members in order.chunks_mut(BUCKET) {
            members.sort_unstable_by_key(|&(_, i)| i);
            let member = |slot: usize| members.get(slot).map(|&(_, i)| i);
            let indices = std::array::from_fn(|slot| member(slot).unwrap_or(NONE.1));
            tree.buckets.push(indices);
            // Empty slots repeat the last vector: they are never neighbours and do not widen a box.
            let last = members[members.len() - 1].1;
            let gathered = axes
                .iter()
                .map(|axis| std::array::from_fn(|slot| axis[member(slot).unwrap_or(last)]));
            tree.coordinates.extend(gathered);
        }
        tree.add_boxes(tree.root());
        tree
    }

    /// The box around all buckets.
    fn root(&self) -> Node {
        Node {
            sum: 0.0,
            number: 0,
            first: 0,
            count: self.buckets.len(),
        }
    }

    /// Adds the next box, and those within it.
    fn add_boxes(&mut self, node: Node) {
        let dimension = self.vectors.dimension();
        let Node { number, first, .. } = node;
        if node.count == 1 {
            let indices = || self.buckets[first].iter().copied();
            let last = indices().rfind(|&i| i != NONE.1).unwrap_or(0);
            self.spans.push([self.buckets[first][0], last]);
            let coordinates = &self.coordinates[first * dimension..][..dimension];
            self.bounds.extend(coordinates.iter().copied().map(range));
            return;
        }
        self.spans.push([0; 2]);
        self.bounds.resize(self.bounds.len() + dimension, [0.0; 2]);
        let halves = node.halves();
        halves.into_iter().for_each(|half| self.add_boxes(half));
        let [a, b] = halves.map(|half| half.number);
        let [a_span, b_span] = [a, b].map(|half| self.spans[half]);
        self.spans[number] = [a_span[0].min(b_span[0]), a_span[1].max(b_span[1])];
        for c in 0..dimension {
            let [a, b] = [a, b].map(|half| self.bounds[half * dimension + c]);
            self.bounds[number * dimension + c] = [a[0].min(b[0]), a[1].max(b[1])];
        }
    }

    /// The nearest neighbour of vector `i` farther away than `radius` among those with `|i - j| >= theiler` (at
    /// least 1). Of several at the same distance, the one with the smallest index. `None` if there is none.
    ///
    /// # Panics
    /// If `i` is not below [`DelayVectors::len`].
    pub fn nearest_beyond(&self, i: usize, radius: f64, theiler: usize) -> Option<Neighbour> {
        let mut query = Query::new(self, theiler, usize::MAX);
        query.beyond = self.norm.rooted_limit(radius);
        let best = vectorised(
            #[inline(always)]
            || {
                query.at(i);
                query.visit(NONE, |found| found)
            },
        );
        self.neighbour(best)
    }

    /// For each of the given vectors the nearest neighbour among those with `|i - j| >= theiler` (at least 1) and
    /// `j < limit`. Fastest if the vectors follow each other closely.
    ///
    /// # Panics
    /// If a vector is not below [`DelayVectors::len`].
    pub fn nearest_each(
        &self,
        mut vectors: impl Iterator<Item = usize>,
        theiler: usize,
        limit: usize,
    ) -> Vec<Option<Neighbour>> {
        let mut query = Query::new(self, theiler, limit);
        let mut before = (0, NONE);
        let mut nearest = Vec::with_capacity(vectors.size_hint().0);
        vectorised(
            #[inline(always)]
            || {
                for i in vectors.by_ref() {
                    query.at(i);
                    // The neighbour of the previous vector has moved on as well.
                    let guess = query.guess(before);
                    let best = query.visit(guess, |found| found);
                    before = (i, best);
                    nearest.push(self.neighbour(best));
                }
            },
        );
        nearest
    }

    /// [`NeighbourTree::nearest_each`] for all vectors, on all cores.
    pub fn nearest_all(&self, theiler: usize) -> Vec<Option<Neighbour>> {
        let count = self.vectors.len();
        let task = |task: usize| {
            let first = task * VECTORS_A_TASK;
            self.nearest_each(first..(first + VECTORS_A_TASK).min(count), theiler, count)
        };
        let tasks = (0..count.div_ceil(VECTORS_A_TASK)).into_par_iter();
        let nearest: Vec<_> = tasks.map(task).collect();
        nearest.concat()
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
        mut each: impl FnMut(usize),
    ) {
        let mut query = Query::new(self, theiler, limit);
        let farthest = (self.norm.rooted_limit(radius), usize::MAX);
        vectorised(
            #[inline(always)]
            || {
                query.at(i);
                query.visit(
                    farthest,
                    #[inline(always)]
                    |(_, j)| {
                        each(j);
                        farthest
                    },
                );
            },
        );
    }

    fn neighbour(&self, (unrooted, index): Candidate) -> Option<Neighbour> {
        (index != NONE.1).then(|| Neighbour {
            index,
            distance: self.norm.rooted(unrooted),
        })
    }
}

/// A box that may contain neighbours.
#[derive(Clone, Copy)]
struct Node {
    /// Lower bound of the unrooted distance of its vectors.
    sum: f64,
    number: usize,
    /// First bucket and number of buckets.
    first: usize,
    count: usize,
}

impl Node {
    /// The boxes around the halves of its buckets, of which it has several. A box of `n` buckets contains `2 n - 2` others.
    fn halves(self) -> [Self; 2] {
        let half = self.count.div_ceil(2);
        let part = |number, first, count| Self {
            sum: 0.0,
            number,
            first,
            count,
        };
        [
            part(self.number + 1, self.first, half),
            part(self.number + 2 * half, self.first + half, self.count - half),
        ]
    }
}

/// A search for neighbours of one vector.
///
/// Its functions are inlined into one that is compiled for the instruction set of the machine.
struct Query<'a> {
    tree: &'a NeighbourTree<'a>,
    theiler: usize,
    limit: usize,
    /// Vectors within this unrooted distance are excluded. Negative to exclude none.
    beyond: f64,
    i: usize,
    /// Coordinates of vector `i`.
    centre: Vec<f64>,
    /// Boxes to visit, the nearest last.
    pending: Vec<Node>,
}

impl<'a> Query<'a> {
    fn new(tree: &'a NeighbourTree<'a>, theiler: usize, limit: usize) -> Self {
        Self {
            tree,
            theiler: theiler.max(1),
            limit: limit.min(tree.vectors.len()),
            beyond: -1.0,
            i: 0,
            centre: Vec::with_capacity(tree.vectors.dimension()),
            pending: Vec::new(),
        }
    }

    /// Searches for neighbours of vector `i`.
    #[inline(always)]
    fn at(&mut self, i: usize) {
        self.i = i;
        self.centre.clear();
        self.centre.extend(self.tree.vectors.vector(i));
    }

    /// Whether vector `j` counts as a neighbour.
    #[inline(always)]
    fn is_neighbour(&self, j: usize) -> bool {
        j < self.limit && self.i.abs_diff(j) >= self.theiler
    }

    /// A first guess from another vector and its neighbour: the vector as long after that neighbour as this
    /// vector is after the other one.
    #[inline(always)]
    fn guess(&self, (other, (_, near)): (usize, Candidate)) -> Candidate {
        let index = near.wrapping_add(self.i).wrapping_sub(other);
        if near == NONE.1 || !self.is_neighbour(index) {
            return NONE;
        }
        let guessed = self.tree.vectors.vector(index);
        let differences = guessed.zip(&self.centre).map(|(a, b)| a - b);
        (self.tree.norm.unrooted(differences), index)
    }

    /// Calls `each` for the neighbours before a limit, nearest boxes first. It returns a new limit, which is not above
    /// the present one. Returns the last limit.
    #[inline(always)]
    fn visit(
        &mut self,
        mut limit: Candidate,
        mut each: impl FnMut(Candidate) -> Candidate,
    ) -> Candidate {
        let tree = self.tree;
        self.pending.push(tree.root());
        while let Some(node) = self.pending.pop() {
            if node.sum > limit.0 {
                continue;
            }
            if node.count == 1 {
                let sums = self.distances(node.first);
                if sums.iter().fold(false, |any, sum| any | (*sum <= limit.0)) {
                    for found in sums.into_iter().zip(tree.buckets[node.first]) {
                        if found < limit && found.0 > self.beyond && self.is_neighbour(found.1) {
                            limit = each(found);
                        }
                    }
                }
                continue;
            }
            let mut halves = node.halves();
            for half in &mut halves {
                half.sum = self.distance(half.number);
            }
            if halves[0].sum < halves[1].sum {
                halves.swap(0, 1);
            }
            for half in halves {
                let first = self.first_in(half.number);
                if first != NONE.1
                    && (half.sum, first) < limit
                    && (half.sum > self.beyond || self.farthest(half.number) > self.beyond)
                {
                    self.pending.push(half);
                }
            }
        }
        limit
    }

    /// Lower bound of the indices in a box that count as neighbours; that of [`NONE`] if there are none.
    #[inline(always)]
    fn first_in(&self, number: usize) -> usize {
        let [first, last] = self.tree.spans[number];
        let first = if self.i.abs_diff(first) < self.theiler {
            self.i.saturating_add(self.theiler)
        } else {
            first
        };
        if first <= last && first < self.limit {
            first
        } else {
            NONE.1
        }
    }

    /// Unrooted distances to the vectors of a bucket.
    #[inline(always)]
    fn distances(&self, bucket: usize) -> [f64; BUCKET] {
        let dimension = self.centre.len();
        let coordinates = &self.tree.coordinates[bucket * dimension..][..dimension];
        let mut sums = [0.0; BUCKET];
        for (coordinates, centre) in coordinates.iter().zip(&self.centre) {
            let differences = coordinates.iter().map(|coordinate| centre - coordinate);
            self.tree.norm.add(&mut sums, differences);
        }
        sums
    }

    /// Minimum and maximum of each coordinate in a box, with that of the vector.
    #[inline(always)]
    fn sides(&self, number: usize) -> impl Iterator<Item = ([f64; 2], f64)> {
        let dimension = self.centre.len();
        let bounds = &self.tree.bounds[number * dimension..][..dimension];
        bounds.iter().copied().zip(self.centre.iter().copied())
    }

    /// Unrooted distance to a box.
    #[inline(always)]
    fn distance(&self, number: usize) -> f64 {
        let outside = |([low, high], x): ([f64; 2], f64)| larger(larger(low - x, x - high), 0.0);
        self.tree.norm.unrooted(self.sides(number).map(outside))
    }

    /// Upper bound of the unrooted distances to the vectors in a box.
    fn farthest(&self, number: usize) -> f64 {
        let side = |([low, high], x): ([f64; 2], f64)| larger(x - low, high - x);
        self.tree.norm.unrooted(self.sides(number).map(side))
    }
}

/// Maximum in one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Sorts vectors, given by their indices, for compact buckets and compact boxes around halves of them. The
/// numbers stored with the indices are workspace.
///
/// Coincident vectors are sorted by index, which lets the search skip a box of duplicates by its
/// smallest index.
fn split(order: &mut [(f64, usize)], axes: &[&[f64]]) {
    if order.len() <= BUCKET {
        return;
    }
    let half = order.len().div_ceil(BUCKET).div_ceil(2) * BUCKET;
    // The choice of the axis affects only the speed.
    let step = order.len().div_ceil(AXIS_SAMPLES);
    let width = |axis: &&&[f64]| {
        let [low, high] = range(order.iter().step_by(step).map(|&(_, i)| axis[i]));
        high - low
    };
    let widest = axes.iter().max_by(|a, b| width(a).total_cmp(&width(b)));
    let axis = widest.expect("a vector has coordinates");
    for (x, i) in order.iter_mut() {
        *x = axis[*i];
    }
    order.select_nth_unstable_by(half, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (low, high) = order.split_at_mut(half);
    if low.len() < MIN_PARALLEL {
        split(low, axes);
        split(high, axes);
    } else {
        rayon::join(|| split(low, axes), || split(high, axes));
    }
}
