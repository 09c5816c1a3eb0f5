//! The claims of the paper, compared with the simulation results.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::criterion::Criterion;
use crate::analysis::delay::DelayChoice;
use crate::study::response::SettledResponse;

/// The claims as TOML.
pub const CLAIMS: &str = include_str!("../../../assets/paper/claims.toml");

/// A claim of the paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Claim {
    /// Identifier (id) of the claim.
    pub id: String,
    /// Place in the paper: figure or section.
    pub place: String,
    /// Quote: words of the paper.
    pub quote: String,
    /// Statement of the claim as it is compared.
    pub statement: String,
    /// Weight of the claim in the scores, positive.
    pub weight: f64,
    /// Relative tolerance of a numeric claim; 0 for others.
    #[serde(default)]
    pub tolerance: f64,
}

/// A claim with the tilts and the criterion by which it is compared.
#[derive(Debug, Deserialize)]
pub struct ClaimEntry {
    /// The claim.
    #[serde(flatten)]
    pub claim: Claim,
    /// Reason for the tolerance.
    #[serde(default)]
    pub reason: String,
    /// Tilts to which the claim refers, degrees.
    tilts_deg: Option<Vec<f64>>,
    /// First and last of these tilts, degrees; all tilts if there are neither.
    range_deg: Option<[f64; 2]>,
    #[serde(flatten)]
    criterion: Criterion,
}

#[derive(Deserialize)]
struct Claims {
    claim: Vec<ClaimEntry>,
}

/// All claims, in the order of the paper.
pub fn claims() -> Vec<ClaimEntry> {
    // A test parses the built-in file.
    toml_edit::de::from_str::<Claims>(CLAIMS).map_or_else(|_| Vec::new(), |claims| claims.claim)
}

/// Finding on a claim: its comparison with the simulation results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// The claim.
    #[serde(flatten)]
    pub claim: Claim,
    /// Its comparison.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// Finding from short averages, which can see a transient in place of the attractor.
    pub short_average: Option<ShortAverage>,
}

/// Comparison of a claim with the simulation results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Expected value according to the paper, as text.
    pub expected: String,
    /// Measured value of the simulation, as text.
    pub measured: String,
    /// Relative deviation of a numeric value.
    pub deviation: Option<f64>,
    /// Verdict on the claim.
    #[serde(flatten)]
    pub verdict: Verdict,
}

/// Finding on a claim from short averages ([`short_average_plan`](super::short_average_plan)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShortAverage {
    /// Measured value of the simulation, as text.
    pub measured: String,
    /// Verdict on the claim.
    #[serde(flatten)]
    pub verdict: Verdict,
}

/// Verdict on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Verdict {
    /// The claim holds at every tilt to which it refers.
    Met,
    /// The claim holds at some of these tilts.
    Partly {
        /// Share of the tilts at which it holds, between 0 and 1.
        share: f64,
    },
    /// The claim does not hold.
    NotMet,
    /// The paper does not state enough to compare, or there is no result to compare with.
    NotComparable,
}

impl Verdict {
    /// Name in text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Partly { .. } => "partly met",
            Self::NotMet => "not met",
            Self::NotComparable => "not comparable",
        }
    }

    /// Share to which the claim holds, 0 to 1; zero if it cannot be compared.
    pub fn share(self) -> f64 {
        match self {
            Self::Met => 1.0,
            Self::Partly { share } => share,
            Self::NotMet | Self::NotComparable => 0.0,
        }
    }

    /// Compares a result, if there is one.
    pub(super) fn when<T>(found: Option<T>, is_so: impl Fn(T) -> bool) -> Self {
        match found.map(is_so) {
            None => Self::NotComparable,
            Some(true) => Self::Met,
            Some(false) => Self::NotMet,
        }
    }

    /// Compares by counts.
    pub(super) fn of(holding: usize, all: usize) -> Self {
        match (holding, all) {
            (_, 0) => Self::NotComparable,
            (0, _) => Self::NotMet,
            (holding, all) if holding == all => Self::Met,
            (holding, all) => Self::Partly {
                share: holding as f64 / all as f64,
            },
        }
    }
}

/// Tilts closer than this are equal, degrees.
const SAME: f64 = 1e-6;

/// Evidence for the claims: settled responses over the tilt, natural frequencies, and the embedding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Tilt in degrees and response, in ascending order of tilt.
    responses: Vec<(f64, SettledResponse)>,
    /// Mode labels and natural frequencies of the finite-element model, Hz.
    pub natural_frequencies: Vec<(String, f64)>,
    /// Delay and dimension chosen at a tilt of 5 degrees, and the sampling interval, s.
    pub embedding: Option<(DelayChoice, f64)>,
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
        let found = self.between(tilt, tilt);
        found.first().map(|(_, response)| *response)
    }

    /// The responses within a range of tilts in degrees, ends included.
    pub fn between(&self, from: f64, to: f64) -> Vec<(f64, &SettledResponse)> {
        let within = |tilt: f64| tilt > from - SAME && tilt < to + SAME;
        let found = self.responses.iter().filter(|(tilt, _)| within(*tilt));
        found.map(|(tilt, response)| (*tilt, response)).collect()
    }
}

/// Compares every claim with the simulation results.
pub fn compare(evidence: &Evidence) -> Vec<Finding> {
    let findings = claims().into_iter().map(|claimed| {
        let points: Vec<_> = match (&claimed.tilts_deg, claimed.range_deg) {
            (Some(tilts), _) => tilts.iter().flat_map(|&t| evidence.between(t, t)).collect(),
            (None, Some([from, to])) => evidence.between(from, to),
            (None, None) => evidence.between(f64::NEG_INFINITY, f64::INFINITY),
        };
        let (claim, criterion) = (claimed.claim, claimed.criterion);
        Finding {
            comparison: criterion.compare(claim.tolerance, &points, evidence),
            claim,
            short_average: None,
        }
    });
    findings.collect()
}

/// Adds the findings from short averages to those from long ones, and returns their score.
pub fn add_short_averages(findings: &mut [Finding], evidence: &Evidence) -> Score {
    let short = compare(evidence);
    let score = Score::of(&short);
    for (finding, short) in findings.iter_mut().zip(short) {
        finding.short_average = Some(ShortAverage {
            measured: short.comparison.measured,
            verdict: short.comparison.verdict,
        });
    }
    score
}

/// Score: the agreement of a simulation with the paper.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// Strict score: share of the comparable claims that are met, by weight, 0 to 1.
    pub strict_score: f64,
    /// Score with partial credit for claims that hold at some of their tilts, by weight, 0 to 1.
    pub partial_score: f64,
    /// Number of claims that are met.
    pub met: usize,
    /// Number of claims that are partly met.
    pub partly: usize,
    /// Number of claims that are not met.
    pub not_met: usize,
    /// Number of claims that are not comparable.
    pub not_comparable: usize,
}

impl Score {
    /// Counts the verdicts of findings.
    pub fn of(findings: &[Finding]) -> Self {
        let all = findings
            .iter()
            .map(|it| (it.claim.weight, it.comparison.verdict));
        let count = |is: fn(Verdict) -> bool| all.clone().filter(|(_, it)| is(*it)).count();
        // Weighted means over the claims that can be compared.
        let comparable = all.clone().filter(|(_, it)| *it != Verdict::NotComparable);
        let weights: f64 = comparable.clone().map(|(weight, _)| weight).sum();
        let mean = |share: fn(Verdict) -> f64| {
            let weighted = comparable.clone().map(|(weight, it)| weight * share(it));
            weighted.sum::<f64>() / weights.max(f64::MIN_POSITIVE)
        };
        Self {
            strict_score: mean(|verdict| f64::from(verdict == Verdict::Met)),
            partial_score: mean(Verdict::share),
            met: count(|verdict| verdict == Verdict::Met),
            partly: count(|verdict| matches!(verdict, Verdict::Partly { .. })),
            not_met: count(|verdict| verdict == Verdict::NotMet),
            not_comparable: count(|verdict| verdict == Verdict::NotComparable),
        }
    }
}
