//! Searches in the tree: boxes nearest first, those too far away not at all.
//!
//! All that runs for every vector is inlined into a function compiled for the instructions of
//! the machine; its loops over the places of a bucket or the parts of a box are then vector
//! instructions.

use super::super::DelayVectors;
use super::tree::{BUCKET, Bounds, NOBODY, PARTS, Span, Tree};

/// A neighbour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Index of the vector.
    pub index: usize,
    /// Distance, in the signal's unit.
    pub distance: f64,
}

/// A norm, as a sum of something over the coordinates.
pub(super) trait Metric {
    /// The sum so far with the next difference.
    fn add(sum: f64, difference: f64) -> f64;

    /// The distance that a sum stands for; never falls as the sum grows.
    fn distance(sum: f64) -> f64 {
        sum
    }

    /// The largest sum whose distance is at most `radius`.
    fn reach(radius: f64) -> f64 {
        radius
    }
}

/// Sum of squares.
pub(super) struct Euclid;

/// Largest magnitude.
pub(super) struct Largest;

/// Sum of magnitudes.
pub(super) struct City;

impl Metric for Euclid {
    #[inline(always)]
    fn add(sum: f64, difference: f64) -> f64 {
        sum + difference * difference
    }

    #[inline(always)]
    fn distance(sum: f64) -> f64 {
        sum.sqrt()
    }

    fn reach(radius: f64) -> f64 {
        if radius < 0.0 {
            return radius;
        }
        // The square is rounded; the sum sought is next to it.
        let mut sum = radius * radius;
        while sum.sqrt() > radius {
            sum = sum.next_down();
        }
        while sum < f64::INFINITY && sum.next_up().sqrt() <= radius {
            sum = sum.next_up();
        }
        sum
    }
}

impl Metric for Largest {
    #[inline(always)]
    fn add(sum: f64, difference: f64) -> f64 {
        larger(sum, difference.abs())
    }
}

impl Metric for City {
    #[inline(always)]
    fn add(sum: f64, difference: f64) -> f64 {
        sum + difference.abs()
    }
}

/// The larger of two numbers, in one instruction.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// What is looked for: neighbours of a vector.
pub(super) struct Query<'a> {
    vectors: DelayVectors<'a>,
    apart: usize,
    limit: usize,
    /// Vectors at this distance or nearer are no neighbours; negative if all are.
    beyond: f64,
    i: usize,
    /// The vector `i`.
    centre: Vec<f64>,
    /// Boxes and buckets still to be opened, the nearest last.
    open: Vec<Open>,
}

/// A box or bucket that may hold neighbours.
#[derive(Clone, Copy)]
struct Open {
    /// No vector in it is nearer.
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
        index: NOBODY,
    };

    #[inline(always)]
    pub fn neighbour<M: Metric>(self) -> Option<Neighbour> {
        (self.index != NOBODY).then(|| Neighbour {
            index: self.index,
            distance: M::distance(self.sum),
        })
    }
}

impl<'a> Query<'a> {
    pub fn new(vectors: &DelayVectors<'a>, apart: usize, limit: usize) -> Self {
        Self {
            vectors: *vectors,
            apart: apart.max(1),
            limit: limit.min(vectors.len()),
            beyond: -1.0,
            i: 0,
            centre: Vec::with_capacity(vectors.dimension()),
            open: Vec::new(),
        }
    }

    /// Leaves out the vectors within the radius.
    pub fn beyond<M: Metric>(mut self, radius: f64) -> Self {
        self.beyond = M::reach(radius);
        self
    }

    /// Asks for neighbours of vector `i`.
    #[inline(always)]
    pub fn at(&mut self, i: usize) {
        self.i = i;
        self.centre.clear();
        self.centre.extend(self.vectors.vector(i));
    }

    /// Whether vector `j` counts as a neighbour.
    #[inline(always)]
    fn admits(&self, j: usize) -> bool {
        j < self.limit && self.i.abs_diff(j) >= self.apart
    }

    /// No index in the span that counts as a neighbour is smaller; [`NOBODY`] if none counts.
    #[inline(always)]
    fn first_in(&self, span: Span) -> usize {
        let after = self.i.saturating_add(self.apart);
        let first = if self.i.abs_diff(span.first) < self.apart {
            after
        } else {
            span.first
        };
        if first <= span.last && first < self.limit {
            first
        } else {
            NOBODY
        }
    }

    /// The neighbour found for another vector, as a first guess for this one.
    #[inline(always)]
    pub fn guess<M: Metric>(&self, other: Best) -> Best {
        if !self.admits(other.index) {
            return Best::NONE;
        }
        let there = self.vectors.vector(other.index);
        let differences = there.zip(&self.centre).map(|(a, b)| a - b);
        Best {
            sum: differences.fold(0.0, M::add),
            index: other.index,
        }
    }
}

impl Tree {
    /// The nearest neighbour, or `best` if none is nearer.
    ///
    /// A box is passed over if its distance, rounded as every distance is, is larger than the
    /// best; if it is equal, the box must hold a smaller index to be opened.
    #[inline(always)]
    pub fn nearest<M: Metric>(&self, query: &mut Query<'_>, mut best: Best) -> Best {
        query.open.push(self.root());
        while let Some(node) = query.open.pop() {
            if node.sum > best.sum {
                continue;
            }
            if node.level == 0 {
                let sums = self.distances::<M>(query, node.number);
                if !any_within(&sums, best.sum) {
                    continue;
                }
                for (&sum, &j) in sums.iter().zip(&self.buckets[node.number].indices) {
                    let nearer = sum < best.sum || (sum == best.sum && j < best.index);
                    if nearer && sum > query.beyond && query.admits(j) {
                        best = Best { sum, index: j };
                    }
                }
            } else {
                let (sums, spans) = self.parts::<M>(query, node);
                let already_open = query.open.len();
                for (part, (&sum, &span)) in sums.iter().zip(spans).enumerate() {
                    if sum > best.sum {
                        continue;
                    }
                    let first = query.first_in(span);
                    if first == NOBODY || (sum == best.sum && first >= best.index) {
                        continue;
                    }
                    if sum <= query.beyond && self.farthest::<M>(query, node, part) <= query.beyond
                    {
                        continue;
                    }
                    query.open.push(node.part(part, sum));
                    // Into its place: few parts get here.
                    let mut place = query.open.len() - 1;
                    while place > already_open && query.open[place - 1].sum <= sum {
                        query.open.swap(place - 1, place);
                        place -= 1;
                    }
                }
            }
        }
        best
    }

    /// All neighbours within the radius.
    #[inline(always)]
    pub fn within<M: Metric>(
        &self,
        query: &mut Query<'_>,
        radius: f64,
        each: &mut impl FnMut(Neighbour),
    ) {
        let reach = M::reach(radius);
        query.open.push(self.root());
        while let Some(node) = query.open.pop() {
            if node.level == 0 {
                let sums = self.distances::<M>(query, node.number);
                for (&sum, &j) in sums.iter().zip(&self.buckets[node.number].indices) {
                    if sum <= reach && query.admits(j) {
                        each(Neighbour {
                            index: j,
                            distance: M::distance(sum),
                        });
                    }
                }
            } else {
                let (sums, spans) = self.parts::<M>(query, node);
                for (part, (&sum, &span)) in sums.iter().zip(spans).enumerate() {
                    if sum <= reach && query.first_in(span) != NOBODY {
                        query.open.push(node.part(part, sum));
                    }
                }
            }
        }
    }

    fn root(&self) -> Open {
        Open {
            sum: 0.0,
            level: self.levels.len(),
            number: 0,
        }
    }

    /// The distances to the vectors of a bucket.
    #[inline(always)]
    fn distances<M: Metric>(&self, query: &Query<'_>, bucket: usize) -> [f64; BUCKET] {
        let dimension = query.centre.len();
        let coordinates = &self.coordinates[bucket * dimension..][..dimension];
        let mut sums = [0.0; BUCKET];
        for (there, here) in coordinates.iter().zip(&query.centre) {
            for (sum, there) in sums.iter_mut().zip(there) {
                *sum = M::add(*sum, here - there);
            }
        }
        sums
    }

    /// The distances to the parts of a box, and the indices they hold.
    #[inline(always)]
    fn parts<M: Metric>(&self, query: &Query<'_>, node: Open) -> ([f64; PARTS], &[Span; PARTS]) {
        let dimension = query.centre.len();
        let level = &self.levels[node.level - 1];
        let bounds = &level.bounds[node.number * dimension..][..dimension];
        let mut sums = [0.0; PARTS];
        for (Bounds { low, high }, here) in bounds.iter().zip(&query.centre) {
            for (sum, (low, high)) in sums.iter_mut().zip(low.iter().zip(high)) {
                *sum = M::add(*sum, larger(larger(low - here, here - high), 0.0));
            }
        }
        (sums, &level.spans[node.number])
    }
}

impl Tree {
    /// No vector in the part of a box is farther.
    fn farthest<M: Metric>(&self, query: &Query<'_>, node: Open, part: usize) -> f64 {
        let dimension = query.centre.len();
        let bounds = &self.levels[node.level - 1].bounds[node.number * dimension..][..dimension];
        let sides = bounds.iter().zip(&query.centre).map(|(bounds, here)| {
            let (low, high) = (bounds.low[part], bounds.high[part]);
            larger(here - low, high - here)
        });
        sides.fold(0.0, M::add)
    }
}

impl Open {
    /// Part of this box at a distance.
    #[inline(always)]
    fn part(self, part: usize, sum: f64) -> Open {
        Open {
            sum,
            level: self.level - 1,
            number: self.number * PARTS + part,
        }
    }
}

/// Whether any of the sums is at most the limit. All are compared: that is one instruction for
/// several of them.
#[inline(always)]
fn any_within(sums: &[f64], limit: f64) -> bool {
    sums.iter().fold(false, |any, &sum| any | (sum <= limit))
}
