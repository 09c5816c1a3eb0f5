//! Samples left out, where an analysis needs a long time more than many samples.

/// Every so many samples of a stream, the first one included.
pub struct EveryStep {
    step: usize,
    /// Samples to be left out before the next one.
    skip: usize,
}

impl EveryStep {
    /// Every `step`-th, at least 1.
    pub fn new(step: usize) -> Self {
        Self { step, skip: 0 }
    }

    /// Those of the next samples.
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
    fn every_step_does_not_depend_on_the_pieces() {
        let stream: Vec<f64> = (0..100).map(f64::from).collect();
        let expected: Vec<f64> = (0..100).step_by(7).map(f64::from).collect();
        for piece in [1, 3, 7, 8, 100] {
            let mut every_step = EveryStep::new(7);
            let mut kept = Vec::new();
            for piece in stream.chunks(piece) {
                kept.extend(every_step.of(piece));
            }
            assert_eq!(kept, expected, "pieces of {piece}");
        }
    }
}
