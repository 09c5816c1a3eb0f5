//! Who is near whom: a k-d tree over delay vectors.

use super::{DelayVectors, Norm};

/// A neighbour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Index of the vector.
    pub index: usize,
    /// Distance, in the signal's unit.
    pub distance: f64,
}

/// A k-d tree over delay vectors.
pub struct NeighbourTree<'a> {
    vectors: DelayVectors<'a>,
    norm: Norm,
}

// Until the tree grows: brute force with the same meaning.
impl<'a> NeighbourTree<'a> {
    /// The tree of these vectors.
    pub fn new(vectors: DelayVectors<'a>, norm: Norm) -> Self {
        Self { vectors, norm }
    }

    fn distance(&self, i: usize, j: usize) -> f64 {
        let pairs = self
            .vectors
            .vector(i)
            .zip(self.vectors.vector(j))
            .map(|(a, b)| (a - b).abs());
        match self.norm {
            Norm::Euclidean => pairs.map(|d| d * d).sum::<f64>().sqrt(),
            Norm::Maximum => pairs.fold(0.0, f64::max),
            Norm::Manhattan => pairs.sum(),
        }
    }

    /// The nearest neighbour of vector `i` among those with `|i - j| >= apart` (at least 1) and
    /// `j < limit`; of several at the same distance the one with the smallest index. `None` if
    /// there is none.
    pub fn nearest(&self, i: usize, apart: usize, limit: usize) -> Option<Neighbour> {
        let mut best: Option<Neighbour> = None;
        for j in (0..limit.min(self.vectors.len())).filter(|&j| i.abs_diff(j) >= apart.max(1)) {
            let distance = self.distance(i, j);
            if best.is_none_or(|b| distance < b.distance) {
                best = Some(Neighbour { index: j, distance });
            }
        }
        best
    }

    /// Calls `each` for every neighbour of vector `i` at `radius` or nearer with
    /// `|i - j| >= apart` (at least 1) and `j < limit`, in no particular but a fixed order.
    pub fn within(
        &self,
        i: usize,
        radius: f64,
        apart: usize,
        limit: usize,
        mut each: impl FnMut(Neighbour),
    ) {
        for j in (0..limit.min(self.vectors.len())).filter(|&j| i.abs_diff(j) >= apart.max(1)) {
            let distance = self.distance(i, j);
            if distance <= radius {
                each(Neighbour { index: j, distance });
            }
        }
    }
}
