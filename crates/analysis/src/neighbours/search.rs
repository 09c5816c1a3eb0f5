//! Search in the k-d tree: nearest boxes first, distant boxes skipped.
//!
//! Functions that run for every vector are inlined into a function compiled for the instruction set of
//! the machine, which vectorises their loops over the slots of a bucket and the parts of a box.

use super::tree::{BUCKET, Bounds, NO_INDEX, PARTS, Span, Tree};
use crate::{DelayVectors, Norm};

/// A neighbouring vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Index of the vector.
    pub index: usize,
    /// Distance, in the signal's unit.
    pub distance: f64,
}

/// Maximum in one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// A search for neighbours of one vector.
pub(super) struct Query<'a> {
    norm: Norm,
    vectors: DelayVectors<'a>,
    theiler: usize,
    limit: usize,
    /// Sum limit: vectors at or below it are excluded. Negative to exclude none.
    beyond: f64,
    i: usize,
    /// Coordinates of vector `i`.
    centre: Vec<f64>,
    /// Boxes and buckets to visit, the nearest last.
    pending: Vec<Node>,
}

/// A box or bucket that may contain neighbours.
#[derive(Clone, Copy)]
struct Node {
    /// Lower bound of the distance sum of its vectors.
    sum: f64,
    /// 0 for a bucket, `l` for a box of `levels[l - 1]`.
    level: usize,
    number: usize,
}

/// The nearest neighbour so far.
#[derive(Clone, Copy)]
pub(super) struct Best {
    sum: f64,
    index: usize,
}

impl Best {
    pub const NONE: Best = Best {
        sum: f64::INFINITY,
        index: NO_INDEX,
    };

    #[inline(always)]
    pub fn neighbour(self, norm: Norm) -> Option<Neighbour> {
        (self.index != NO_INDEX).then(|| Neighbour {
            index: self.index,
            distance: distance(norm, self.sum),
        })
    }
}

impl<'a> Query<'a> {
    pub fn new(vectors: &DelayVectors<'a>, norm: Norm, theiler: usize, limit: usize) -> Self {
        Self {
            norm,
            vectors: *vectors,
            theiler: theiler.max(1),
            limit: limit.min(vectors.len()),
            beyond: -1.0,
            i: 0,
            centre: Vec::with_capacity(vectors.dimension()),
            pending: Vec::new(),
        }
    }

    /// Excludes the vectors within the radius.
    pub fn beyond(mut self, radius: f64) -> Self {
        self.beyond = sum_limit(self.norm, radius);
        self
    }

    /// Searches for neighbours of vector `i`.
    #[inline(always)]
    pub fn at(&mut self, i: usize) {
        self.i = i;
        self.centre.clear();
        self.centre.extend(self.vectors.vector(i));
    }

    /// Whether vector `j` counts as a neighbour.
    #[inline(always)]
    fn is_candidate(&self, j: usize) -> bool {
        j < self.limit && self.i.abs_diff(j) >= self.theiler
    }

    /// Lower bound of the indices in the span that count as neighbours; [`NO_INDEX`] if there are none.
    #[inline(always)]
    fn first_in(&self, span: Span) -> usize {
        let after = self.i.saturating_add(self.theiler);
        let first = if self.i.abs_diff(span.first) < self.theiler {
            after
        } else {
            span.first
        };
        if first <= span.last && first < self.limit {
            first
        } else {
            NO_INDEX
        }
    }

    /// A first guess from another vector and its neighbour: the vector as long after that neighbour as this
    /// vector is after the other one.
    #[inline(always)]
    pub fn guess(&self, (other, best): (usize, Best)) -> Best {
        let index = best.index.wrapping_add(self.i).wrapping_sub(other);
        if best.index == NO_INDEX || !self.is_candidate(index) {
            return Best::NONE;
        }
        let there = self.vectors.vector(index);
        let differences = there.zip(&self.centre).map(|(a, b)| a - b);
        Best {
            sum: self.norm.unrooted(differences),
            index,
        }
    }
}

impl Tree {
    /// Nearest neighbour, or `best` if none is nearer.
    ///
    /// A box is skipped if its rounded distance exceeds the best one. At equal distance it is visited
    /// only if it contains a smaller index.
    #[inline(always)]
    pub fn nearest(&self, query: &mut Query<'_>, mut best: Best) -> Best {
        query.pending.push(self.root());
        while let Some(node) = query.pending.pop() {
            if node.sum > best.sum {
                continue;
            }
            if node.level == 0 {
                let sums = self.distances(query, node.number);
                let indices = &self.buckets[node.number].indices;
                for slot in within(&sums, best.sum) {
                    let (sum, j) = (sums[slot], indices[slot]);
                    let nearer = sum < best.sum || (sum == best.sum && j < best.index);
                    if nearer && sum > query.beyond && query.is_candidate(j) {
                        best = Best { sum, index: j };
                    }
                }
            } else {
                let (sums, spans) = self.parts(query, node);
                let first_new = query.pending.len();
                for part in within(&sums, best.sum) {
                    let sum = sums[part];
                    let first = query.first_in(spans[part]);
                    if first == NO_INDEX || (sum == best.sum && first >= best.index) {
                        continue;
                    }
                    if sum <= query.beyond && self.farthest(query, node, part) <= query.beyond {
                        continue;
                    }
                    query.pending.push(node.part(part, sum));
                    // Insertion sort: few parts reach this point.
                    let mut place = query.pending.len() - 1;
                    while place > first_new && query.pending[place - 1].sum <= sum {
                        query.pending.swap(place - 1, place);
                        place -= 1;
                    }
                }
            }
        }
        best
    }

    /// All neighbours within the radius.
    #[inline(always)]
    pub fn within(&self, query: &mut Query<'_>, radius: f64, each: &mut impl FnMut(Neighbour)) {
        let sum_limit = sum_limit(query.norm, radius);
        query.pending.push(self.root());
        while let Some(node) = query.pending.pop() {
            if node.level == 0 {
                let sums = self.distances(query, node.number);
                for (&sum, &j) in sums.iter().zip(&self.buckets[node.number].indices) {
                    if sum <= sum_limit && query.is_candidate(j) {
                        each(Neighbour {
                            index: j,
                            distance: distance(query.norm, sum),
                        });
                    }
                }
            } else {
                let (sums, spans) = self.parts(query, node);
                for (part, (&sum, &span)) in sums.iter().zip(spans).enumerate() {
                    if sum <= sum_limit && query.first_in(span) != NO_INDEX {
                        query.pending.push(node.part(part, sum));
                    }
                }
            }
        }
    }

    fn root(&self) -> Node {
        Node {
            sum: 0.0,
            level: self.levels.len(),
            number: 0,
        }
    }

    /// Distance sums to the vectors of a bucket.
    #[inline(always)]
    fn distances(&self, query: &Query<'_>, bucket: usize) -> [f64; BUCKET] {
        let dimension = query.centre.len();
        let coordinates = &self.coordinates[bucket * dimension..][..dimension];
        let mut sums = [0.0; BUCKET];
        for (there, here) in coordinates.iter().zip(&query.centre) {
            query
                .norm
                .add(&mut sums, there.iter().map(|there| here - there));
        }
        sums
    }

    /// Distance sums to the parts of a box, and their index ranges.
    #[inline(always)]
    fn parts(&self, query: &Query<'_>, node: Node) -> ([f64; PARTS], &[Span; PARTS]) {
        let dimension = query.centre.len();
        let level = &self.levels[node.level - 1];
        let bounds = &level.bounds[node.number * dimension..][..dimension];
        let mut sums = [0.0; PARTS];
        for (Bounds { low, high }, here) in bounds.iter().zip(&query.centre) {
            let outside = low
                .iter()
                .zip(high)
                .map(|(low, high)| larger(larger(low - here, here - high), 0.0));
            query.norm.add(&mut sums, outside);
        }
        (sums, &level.spans[node.number])
    }
}

impl Tree {
    /// Upper bound of the distance sums to the vectors in a part of a box.
    fn farthest(&self, query: &Query<'_>, node: Node, part: usize) -> f64 {
        let dimension = query.centre.len();
        let bounds = &self.levels[node.level - 1].bounds[node.number * dimension..][..dimension];
        let sides = bounds.iter().zip(&query.centre).map(|(bounds, here)| {
            let (low, high) = (bounds.low[part], bounds.high[part]);
            larger(here - low, high - here)
        });
        query.norm.unrooted(sides)
    }
}

impl Node {
    /// A part of this box at a distance sum.
    #[inline(always)]
    fn part(self, part: usize, sum: f64) -> Node {
        Node {
            sum,
            level: self.level - 1,
            number: self.number * PARTS + part,
        }
    }
}

/// The slots whose sums are within a limit, in order.
#[inline(always)]
fn within<const N: usize>(sums: &[f64; N], limit: f64) -> SetBits {
    let mut bits = 0;
    for (slot, sum) in sums.iter().enumerate() {
        bits |= u64::from(*sum <= limit) << slot;
    }
    SetBits(bits)
}

/// Distance of an unrooted one.
#[inline(always)]
fn distance(norm: Norm, unrooted: f64) -> f64 {
    match norm {
        Norm::Euclidean => unrooted.sqrt(),
        Norm::Maximum | Norm::Manhattan => unrooted,
    }
}

/// Largest unrooted distance whose distance is at most `radius`.
fn sum_limit(norm: Norm, radius: f64) -> f64 {
    if radius < 0.0 || norm != Norm::Euclidean {
        return radius;
    }
    // The square is rounded, so the limit is found among the adjacent numbers.
    let mut sum = radius * radius;
    while sum.sqrt() > radius {
        sum = sum.next_down();
    }
    while sum < f64::INFINITY && sum.next_up().sqrt() <= radius {
        sum = sum.next_up();
    }
    sum
}

/// Positions of the bits that are set.
struct SetBits(u64);

impl Iterator for SetBits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let position = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (position < 64).then_some(position)
    }
}
