//! Means of several quantities over blocks of equal length, in bounded memory.

/// Maximum number of blocks. When it is reached, blocks are merged in pairs.
const MAX_BLOCKS: usize = 128;

/// Means of several quantities over successive blocks of equal length. When the storage is full, adjacent
/// blocks are merged: after the first 64 blocks there are always 64 to 128, for any length of the stream.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockMeans {
    width: usize,
    /// Means of each full block, block by block.
    full: Vec<f64>,
    /// Sums of the incomplete block, and its entries so far.
    sums: Vec<f64>,
    entries: usize,
    /// Entries per block.
    length: usize,
}

impl BlockMeans {
    /// Creates blocks of one entry, for `width` quantities.
    pub fn new(width: usize) -> Self {
        Self {
            width,
            full: Vec::new(),
            sums: vec![0.0; width],
            entries: 0,
            length: 1,
        }
    }

    /// Adds an entry: one value of each quantity.
    ///
    /// # Panics
    /// If the number of values differs from the width.
    pub fn push(&mut self, values: &[f64]) {
        assert_eq!(values.len(), self.width, "values per entry");
        if self.count() == MAX_BLOCKS {
            self.merge();
        }
        for (sum, x) in self.sums.iter_mut().zip(values) {
            *sum += x;
        }
        self.entries += 1;
        if self.entries == self.length {
            let length = self.length as f64;
            self.full.extend(self.sums.iter().map(|sum| sum / length));
            self.sums.fill(0.0);
            self.entries = 0;
        }
    }

    /// Number of full blocks.
    pub fn count(&self) -> usize {
        self.full.len() / self.width
    }

    /// Entries per block.
    pub fn length(&self) -> usize {
        self.length
    }

    /// The means of a quantity in all full blocks.
    pub fn channel(&self, quantity: usize) -> Vec<f64> {
        let blocks = self.full.chunks_exact(self.width);
        blocks.map(|block| block[quantity]).collect()
    }

    /// Merges adjacent blocks. Their number is even, and no block is incomplete.
    fn merge(&mut self) {
        let pairs = self.full.chunks_exact(2 * self.width);
        let merged = pairs.flat_map(|pair| {
            let (one, other) = pair.split_at(self.width);
            one.iter().zip(other).map(|(a, b)| 0.5 * (a + b))
        });
        self.full = merged.collect();
        self.length *= 2;
    }
}
