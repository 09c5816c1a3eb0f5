//! The simulation results that the claims of the paper are compared with.

use crate::study::response::SettledResponse;

/// Tilts closer than this are equal, degrees.
const SAME: f64 = 1e-6;

/// Delay and dimension of an embedding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Embedding {
    /// Embedding delay, s.
    pub lag: f64,
    /// Embedding dimension.
    pub dimension: usize,
}

/// Evidence for the claims: settled responses over the tilt, natural frequencies, and the embedding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Tilt in degrees and response, in ascending order of tilt.
    responses: Vec<(f64, SettledResponse)>,
    /// Mode labels and natural frequencies of the finite-element model, Hz.
    pub natural_frequencies: Vec<(String, f64)>,
    /// The embedding chosen at a tilt of 5 degrees.
    pub delay: Option<Embedding>,
}

impl Evidence {
    /// Creates the evidence from tilts in degrees and their responses.
    pub fn new(responses: impl IntoIterator<Item = (f64, SettledResponse)>) -> Self {
        let mut responses: Vec<_> = responses.into_iter().collect();
        responses.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            responses,
            ..Self::default()
        }
    }

    /// The response at a tilt in degrees.
    pub fn at(&self, tilt: f64) -> Option<&SettledResponse> {
        let mut all = self.responses.iter();
        let found = all.find(|(there, _)| (there - tilt).abs() < SAME);
        found.map(|(_, response)| response)
    }

    /// The responses within a range of tilts in degrees, ends included.
    pub fn between(&self, from: f64, to: f64) -> Vec<(f64, &SettledResponse)> {
        let within = |tilt: f64| tilt > from - SAME && tilt < to + SAME;
        let found = self.responses.iter().filter(|(tilt, _)| within(*tilt));
        found.map(|(tilt, response)| (*tilt, response)).collect()
    }

    /// All responses, in ascending order of tilt.
    pub fn all(&self) -> Vec<(f64, &SettledResponse)> {
        self.between(f64::NEG_INFINITY, f64::INFINITY)
    }
}
