//! The tree: vectors sorted into buckets, buckets into boxes, boxes into boxes.

use crate::analysis::{DelayVectors, range};

/// Vectors in a bucket.
pub(super) const BUCKET: usize = 16;

/// Parts of a box: the boxes or buckets one level below.
pub(super) const PARTS: usize = 8;

/// The axis of a split is chosen by about this many vectors of those to be split.
const SURVEYED: usize = 128;

/// With fewer vectors than this a split is not worth a task of its own.
const WORTH_A_TASK: usize = 4096;

/// The index of a place in the last bucket, or of a part of the last box, that is empty.
pub(super) const NOBODY: usize = usize::MAX;

/// All buckets and boxes.
///
/// The shape follows from the number of vectors alone: all buckets but the last are full, all
/// boxes but the last of a level have [`PARTS`] parts, so part `p` of box `b` is number
/// `b * PARTS + p` of the level below.
pub(super) struct Tree {
    /// Coordinate `c` of the vectors of bucket `b` at `b * dimension + c`.
    pub coordinates: Vec<[f64; BUCKET]>,
    pub buckets: Vec<Bucket>,
    /// From the boxes that hold buckets up to the one that holds all.
    pub levels: Vec<Level>,
}

/// Who is in a bucket.
pub(super) struct Bucket {
    /// Indices of the vectors, ascending, [`NOBODY`] at the end.
    pub indices: [usize; BUCKET],
}

/// The boxes of one level, each by the bounds of its parts.
pub(super) struct Level {
    /// Smallest and largest coordinate `c` in the parts of box `b` at `b * dimension + c`.
    pub bounds: Vec<Bounds>,
    /// Smallest and largest index in the parts of box `b`.
    pub spans: Vec<[Span; PARTS]>,
}

/// Bounds of a coordinate in the parts of a box.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub low: [f64; PARTS],
    pub high: [f64; PARTS],
}

/// The smallest and the largest of some indices.
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
    /// No index at all.
    pub const NONE: Span = Span {
        first: NOBODY,
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
            let mut indices = [NOBODY; BUCKET];
            for (place, &(_, i)) in indices.iter_mut().zip(&*members) {
                *place = i;
            }
            tree.buckets.push(Bucket { indices });
            // Empty places repeat the last vector: they are never neighbours, nor do they widen
            // a box.
            let member = |place: usize| members[place.min(members.len() - 1)].1;
            let gathered = axes
                .iter()
                .map(|axis| std::array::from_fn(|p| axis[member(p)]));
            tree.coordinates.extend(gathered);
        }
        tree.box_up(axes.len());
        tree
    }

    /// Puts buckets into boxes, and boxes into boxes until there is only one.
    fn box_up(&mut self, dimension: usize) {
        let of_bucket = |b: usize| {
            let members = self.buckets[b].indices.iter().copied();
            Span::of(members.filter(|&i| i != NOBODY))
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
                    .unwrap_or(NOBODY),
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

/// Sorts vectors, given by their indices, such that consecutive full buckets, and consecutive
/// full boxes of every level, lie apart. The numbers beside the indices are workspace.
///
/// Vectors that coincide are put in order of their indices, so that a box of nothing but
/// duplicates is passed over by its smallest index.
fn split(order: &mut [(f64, usize)], axes: &[&[f64]]) {
    if order.len() <= BUCKET {
        return;
    }
    // The largest bucket or box of which more than one is needed.
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
    if low.len() < WORTH_A_TASK {
        split(low, axes);
        split(high, axes);
    } else {
        rayon::join(|| split(low, axes), || split(high, axes));
    }
}

/// The coordinate in which the vectors spread the most, by a survey. Any would do; a wide one
/// makes compact boxes.
fn widest<'a>(order: &[(f64, usize)], axes: &[&'a [f64]]) -> &'a [f64] {
    let step = order.len().div_ceil(SURVEYED);
    let (mut widest, mut width) = (axes[0], f64::NEG_INFINITY);
    for &axis in axes {
        let [low, high] = range(order.iter().step_by(step).map(|&(_, i)| axis[i]));
        if high - low > width {
            (widest, width) = (axis, high - low);
        }
    }
    widest
}
