//! The k-d tree: vectors sorted into buckets, buckets into boxes, boxes into larger boxes.

use crate::{DelayVectors, range};

/// Vectors per bucket.
pub(super) const BUCKET: usize = 16;

/// Parts per box: boxes or buckets one level below.
pub(super) const PARTS: usize = 8;

/// Approximate number of vectors sampled to choose the axis of a split.
const AXIS_SAMPLES: usize = 32;

/// Splits of fewer vectors run without a parallel task.
const MIN_PARALLEL: usize = 4096;

/// Index of an empty slot in the last bucket, or of an empty part of the last box.
pub(super) const NO_INDEX: usize = usize::MAX;

/// All buckets and boxes.
///
/// The shape depends only on the number of vectors: all buckets but the last are full, and all boxes but
/// the last of a level have [`PARTS`] parts. Part `p` of box `b` is therefore number `b * PARTS + p` of
/// the level below.
pub(super) struct Tree {
    /// Coordinate `c` of the vectors of bucket `b` is at `b * dimension + c`.
    pub coordinates: Vec<[f64; BUCKET]>,
    pub buckets: Vec<Bucket>,
    /// Levels from the boxes that contain buckets up to the root.
    pub levels: Vec<Level>,
}

/// Vectors of a bucket.
pub(super) struct Bucket {
    /// Indices of the vectors, ascending, padded with [`NO_INDEX`].
    pub indices: [usize; BUCKET],
}

/// Boxes of one level, described by the bounds of their parts.
pub(super) struct Level {
    /// Minimum and maximum of coordinate `c` in the parts of box `b`, at `b * dimension + c`.
    pub bounds: Vec<Bounds>,
    /// Index range in the parts of box `b`.
    pub spans: Vec<[Span; PARTS]>,
}

/// Bounds of a coordinate in the parts of a box.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub low: [f64; PARTS],
    pub high: [f64; PARTS],
}

/// Minimum and maximum of a set of indices.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub first: usize,
    pub last: usize,
}

impl Bounds {
    const NONE: Bounds = Bounds {
        low: [f64::INFINITY; PARTS],
        high: [f64::NEG_INFINITY; PARTS],
    };
}

impl Span {
    /// Empty range.
    pub const NONE: Span = Span {
        first: NO_INDEX,
        last: 0,
    };

    fn of(indices: impl Iterator<Item = usize>) -> Self {
        indices.fold(Self::NONE, |span, i| Span {
            first: span.first.min(i),
            last: span.last.max(i),
        })
    }
}

impl Tree {
    pub fn new(vectors: &DelayVectors<'_>) -> Self {
        let axes: Vec<&[f64]> = (0..vectors.dimension())
            .map(|c| vectors.coordinate(c))
            .collect();
        let mut order: Vec<(f64, usize)> = (0..vectors.len()).map(|i| (0.0, i)).collect();
        split(&mut order, &axes);
        let mut tree = Self {
            coordinates: Vec::with_capacity(order.len().div_ceil(BUCKET) * axes.len()),
            buckets: Vec::with_capacity(order.len().div_ceil(BUCKET)),
            levels: Vec::new(),
        };
        for members in order.chunks_mut(BUCKET) {
            members.sort_unstable_by_key(|&(_, i)| i);
            let mut indices = [NO_INDEX; BUCKET];
            for (slot, &(_, i)) in indices.iter_mut().zip(&*members) {
                *slot = i;
            }
            tree.buckets.push(Bucket { indices });
            // Empty slots repeat the last vector: they are never neighbours and do not widen a box.
            let member = |slot: usize| members[slot.min(members.len() - 1)].1;
            let gathered = axes
                .iter()
                .map(|axis| std::array::from_fn(|p| axis[member(p)]));
            tree.coordinates.extend(gathered);
        }
        tree.build_levels(axes.len());
        tree
    }

    /// Groups buckets into boxes, and boxes into larger boxes up to the root.
    fn build_levels(&mut self, dimension: usize) {
        let of_bucket = |b: usize| {
            let members = self.buckets[b].indices.iter().copied();
            Span::of(members.filter(|&i| i != NO_INDEX))
        };
        let bounds = |b: usize, c: usize| range(self.coordinates[b * dimension + c]);
        self.levels
            .push(Level::new(self.buckets.len(), dimension, of_bucket, bounds));
        while let Some(below) = self.levels.last().filter(|level| level.spans.len() > 1) {
            let of_box = |b: usize| Span {
                first: below.spans[b]
                    .iter()
                    .map(|s| s.first)
                    .min()
                    .unwrap_or(NO_INDEX),
                last: below.spans[b].iter().map(|s| s.last).max().unwrap_or(0),
            };
            let bounds = |b: usize, c: usize| {
                let Bounds { low, high } = below.bounds[b * dimension + c];
                [range(low)[0], range(high)[1]]
            };
            let above = Level::new(below.spans.len(), dimension, of_box, bounds);
            self.levels.push(above);
        }
    }
}

impl Level {
    /// Boxes for `count` parts.
    fn new(
        count: usize,
        dimension: usize,
        span: impl Fn(usize) -> Span,
        bounds: impl Fn(usize, usize) -> [f64; 2],
    ) -> Self {
        let boxes = count.div_ceil(PARTS);
        let mut level = Self {
            bounds: vec![Bounds::NONE; boxes * dimension],
            spans: vec![[Span::NONE; PARTS]; boxes],
        };
        for part in 0..count {
            let (b, p) = (part / PARTS, part % PARTS);
            level.spans[b][p] = span(part);
            for c in 0..dimension {
                let of_box = &mut level.bounds[b * dimension + c];
                [of_box.low[p], of_box.high[p]] = bounds(part, c);
            }
        }
        level
    }
}

/// Sorts vectors, given by their indices, for compact buckets and compact boxes on every level. The
/// numbers stored with the indices are workspace.
///
/// Coincident vectors are sorted by index, which lets the search skip a box of duplicates by its
/// smallest index.
fn split(order: &mut [(f64, usize)], axes: &[&[f64]]) {
    if order.len() <= BUCKET {
        return;
    }
    // Size of the largest bucket or box of which more than one is needed.
    let mut size = BUCKET;
    while size * PARTS < order.len() {
        size *= PARTS;
    }
    let half = order.len().div_ceil(size).div_ceil(2) * size;
    let axis = widest(order, axes);
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

/// Coordinate with the largest range among sampled vectors. The choice affects only the speed: a wide
/// coordinate makes compact boxes.
fn widest<'a>(order: &[(f64, usize)], axes: &[&'a [f64]]) -> &'a [f64] {
    let step = order.len().div_ceil(AXIS_SAMPLES);
    let (mut widest, mut width) = (axes[0], f64::NEG_INFINITY);
    for &axis in axes {
        let [low, high] = range(order.iter().step_by(step).map(|&(_, i)| axis[i]));
        if high - low > width {
            (widest, width) = (axis, high - low);
        }
    }
    widest
}
