//! Samples left out, where an analysis needs a long time more than many samples.

/// Every so many samples of a stream, the first one included.
pub struct EveryStep {
    step: usize,
    /// Samples to be left out before the next one.
    skip: usize,
    kept: Vec<f64>,
}

impl EveryStep {
    /// Every `step`-th, at least 1.
    pub fn new(step: usize) -> Self {
        Self {
            step,
            skip: 0,
            kept: Vec::new(),
        }
    }

    /// The step, samples.
    pub fn step(&self) -> usize {
        self.step
    }

    /// Those of the next samples.
    pub fn of(&mut self, samples: &[f64]) -> &[f64] {
        self.kept.clear();
        let rest = samples.iter().skip(self.skip);
        self.kept.extend(rest.step_by(self.step));
        self.skip = self.skip + self.kept.len() * self.step - samples.len();
        &self.kept
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
                kept.extend_from_slice(every_step.of(piece));
            }
            assert_eq!(kept, expected, "pieces of {piece}");
        }
    }
}
