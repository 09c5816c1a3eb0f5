//! Subsampling, for analyses that need long windows rather than many samples.

/// Subsampler of a stream: keeps every n-th sample, including the first one.
pub struct Subsampler {
    step: usize,
    /// Number of samples to skip before the next one.
    skip: usize,
}

impl Subsampler {
    /// Keeps every `step`-th sample; `step` is at least 1.
    pub fn new(step: usize) -> Self {
        Self { step, skip: 0 }
    }

    /// The kept samples of the next block.
    pub fn of(&mut self, samples: &[f64]) -> Vec<f64> {
        let rest = samples.iter().skip(self.skip);
        let kept: Vec<f64> = rest.step_by(self.step).copied().collect();
        self.skip = self.skip + kept.len() * self.step - samples.len();
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_result_does_not_depend_on_the_blocks() {
        let stream: Vec<f64> = (0..100).map(f64::from).collect();
        let expected: Vec<f64> = (0..100).step_by(7).map(f64::from).collect();
        for piece in [1, 3, 7, 8, 100] {
            let mut subsampler = Subsampler::new(7);
            let mut kept = Vec::new();
            for piece in stream.chunks(piece) {
                kept.extend(subsampler.of(piece));
            }
            assert_eq!(kept, expected, "pieces of {piece}");
        }
    }
}
