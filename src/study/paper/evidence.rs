//! What was found, as the claims of the paper ask for it.

use crate::study::response::Response;

/// Tilts nearer to each other than this are the same, degrees.
const SAME: f64 = 1e-6;

/// Delay and dimension of an embedding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Embedding {
    /// Delay, s.
    pub lag: f64,
    /// Dimension.
    pub dimension: usize,
}

/// Settled responses over the tilt, and what else the claims speak of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Tilt in degrees, and the response there, by rising tilt.
    responses: Vec<(f64, Response)>,
    /// Natural frequencies of the finite-element model with the modes' names, Hz.
    pub natural_frequencies: Vec<(String, f64)>,
    /// The embedding chosen at 5 degrees.
    pub delay: Option<Embedding>,
}

impl Evidence {
    /// Responses at tilts, degrees.
    pub fn new(responses: impl IntoIterator<Item = (f64, Response)>) -> Self {
        let mut responses: Vec<_> = responses.into_iter().collect();
        responses.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            responses,
            ..Self::default()
        }
    }

    /// The response at a tilt, degrees.
    pub fn at(&self, tilt: f64) -> Option<&Response> {
        let mut all = self.responses.iter();
        let found = all.find(|(there, _)| (there - tilt).abs() < SAME);
        found.map(|(_, response)| response)
    }

    /// The responses from one tilt to another, degrees.
    pub fn between(&self, from: f64, to: f64) -> Vec<(f64, &Response)> {
        let within = |tilt: f64| tilt > from - SAME && tilt < to + SAME;
        let found = self.responses.iter().filter(|(tilt, _)| within(*tilt));
        found.map(|(tilt, response)| (*tilt, response)).collect()
    }

    /// All responses, by rising tilt.
    pub fn all(&self) -> Vec<(f64, &Response)> {
        self.between(f64::NEG_INFINITY, f64::INFINITY)
    }
}
