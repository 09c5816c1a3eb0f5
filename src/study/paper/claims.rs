//! The claims of the paper, compared with the simulation results.

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::evidence::Evidence;
use crate::analysis::RecurrenceKind;
use crate::dynamics::{Exponent, Sign};
use crate::study::response::SettledResponse;

/// The claims as TOML.
pub const CLAIMS: &str = include_str!("../../../assets/paper/claims.toml");

/// Minimum amplitude of a line that counts, relative to the strongest line.
const MIN_LINE_AMPLITUDE: f64 = 0.05;

/// An exponent is nearly zero if its whole interval lies within this distance of zero, 1/s: about a tenth of
/// the largest exponent in chaos.
const NEARLY_ZERO: f64 = 10.0;

/// A claim of the paper.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Claim {
    /// Short identifier of the claim.
    pub id: String,
    /// Place in the paper: figure or section.
    #[serde(rename = "where")]
    pub place: String,
    /// The claim in words.
    pub statement: String,
    /// Weight of the claim when parameter sets are compared.
    pub weight: f64,
    /// Relative tolerance of a numeric claim.
    #[serde(default)]
    pub within: f64,
    #[serde(flatten)]
    criterion: Criterion,
}

/// The claimed value of a measurable quantity. Angles are tilts of the load.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Criterion {
    /// A mode of the finite-element model has this natural frequency.
    NaturalFrequency { mode: String, hz: f64 },
    /// Number of unstable modes of steady sliding.
    UnstableModes { tilt_deg: f64, count: usize },
    /// The motion has one of these regimes.
    Regime { tilt_deg: f64, is: Vec<String> },
    /// The motion has one of these regimes over a range of tilts.
    RegimeOver {
        from_deg: f64,
        to_deg: f64,
        is: Vec<String>,
    },
    /// Frequency of the strongest spectral line, Hz.
    StrongestLine { tilt_deg: f64, hz: f64 },
    /// Frequency of some spectral line, Hz.
    Line { tilt_deg: f64, hz: f64 },
    /// The strongest line moves from one frequency to another.
    ModeShift {
        from_deg: f64,
        from_hz: f64,
        to_deg: f64,
        to_hz: f64,
    },
    /// The linear mode with the largest growth rate is not the one that dominates the sound.
    LinearMismatch { tilt_deg: f64 },
    /// Delay of the embedding.
    Lag { tilt_deg: f64, samples: f64 },
    /// Embedding dimension.
    Dimension { tilt_deg: f64, is: usize },
    /// Distance between the diagonal lines of the recurrence plot, s.
    RecurrencePeriod {
        from_deg: f64,
        to_deg: f64,
        s: f64,
        kind: RecurrenceKind,
    },
    /// The largest Lyapunov exponent is nearly zero.
    ExponentZero { from_deg: f64, to_deg: f64 },
    /// Number of positive Lyapunov exponents.
    ExponentsPositive {
        from_deg: f64,
        to_deg: f64,
        count: usize,
    },
    /// Order of the regimes with increasing tilt.
    Order { regimes: Vec<String> },
}

#[derive(Deserialize)]
struct Claims {
    claim: Vec<Claim>,
}

/// All claims, in the order of the paper.
pub fn claims() -> Vec<Claim> {
    // A test parses the built-in file.
    toml::from_str::<Claims>(CLAIMS).map_or_else(|_| Vec::new(), |claims| claims.claim)
}

/// Agreement of a claim with the simulation results: whether it holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "HoldsRecord", from = "HoldsRecord")]
pub enum Agreement {
    /// The claim holds.
    Yes,
    /// The claim holds at this share of the tilts it refers to, 0 to 1.
    Partly(f64),
    /// The claim does not hold.
    No,
    /// There is no result to compare with.
    Unknown,
}

/// JSON form of [`Agreement`].
#[derive(Serialize, Deserialize)]
struct HoldsRecord {
    /// Whether the claim holds: `yes`, `partly`, `no` or `unknown`.
    holds: Cow<'static, str>,
    /// Share to which the claim holds, 0 to 1.
    share: f64,
}

impl From<Agreement> for HoldsRecord {
    fn from(holds: Agreement) -> Self {
        Self {
            holds: holds.name().into(),
            share: holds.share(),
        }
    }
}

impl From<HoldsRecord> for Agreement {
    fn from(HoldsRecord { holds, share }: HoldsRecord) -> Self {
        match &*holds {
            "yes" => Self::Yes,
            "partly" => Self::Partly(share),
            "no" => Self::No,
            _ => Self::Unknown,
        }
    }
}

impl Agreement {
    /// Name in text and JSON: `yes`, `partly`, `no` or `unknown`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::Partly(_) => "partly",
            Self::No => "no",
            Self::Unknown => "unknown",
        }
    }

    /// Share to which the claim holds, 0 to 1; zero if unknown.
    pub fn share(self) -> f64 {
        match self {
            Self::Yes => 1.0,
            Self::Partly(share) => share,
            Self::No | Self::Unknown => 0.0,
        }
    }

    /// Compares a result, if there is one.
    fn when<T>(found: Option<T>, is_so: impl Fn(T) -> bool) -> Self {
        match found.map(is_so) {
            None => Self::Unknown,
            Some(true) => Self::Yes,
            Some(false) => Self::No,
        }
    }

    /// Compares by counts.
    fn of(holding: usize, all: usize) -> Self {
        match (holding, all) {
            (_, 0) => Self::Unknown,
            (0, _) => Self::No,
            (holding, all) if holding == all => Self::Yes,
            (holding, all) => Self::Partly(holding as f64 / all as f64),
        }
    }
}

/// Finding on a claim: its comparison with the simulation results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The claim.
    #[serde(flatten, with = "ClaimRecord")]
    pub claim: Claim,
    /// The published value as text.
    pub published: String,
    /// The simulated value as text.
    pub simulated: String,
    /// Relative deviation of a numeric value.
    pub deviation: Option<f64>,
    /// Whether the claim holds.
    #[serde(flatten)]
    pub holds: Agreement,
}

/// JSON form of a claim.
#[derive(Serialize, Deserialize)]
struct ClaimRecord {
    /// Identifier (id) of the claim.
    id: String,
    /// Place in the paper: figure or section.
    place: String,
    /// Statement of the claim.
    statement: String,
    /// Weight of the claim in the score.
    weight: f64,
}

impl ClaimRecord {
    fn serialize<S: Serializer>(claim: &Claim, to: S) -> Result<S::Ok, S::Error> {
        let record = Self {
            id: claim.id.clone(),
            place: claim.place.clone(),
            statement: claim.statement.clone(),
            weight: claim.weight,
        };
        Serialize::serialize(&record, to)
    }

    /// Reads the claim, with the criterion of the present version.
    fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Claim, D::Error> {
        let record = <Self as Deserialize>::deserialize(from)?;
        let claim = claims().into_iter().find(|claim| claim.id == record.id);
        let claim = claim
            .ok_or_else(|| serde::de::Error::custom(format!("unknown claim `{}`", record.id)))?;
        Ok(Claim {
            place: record.place,
            statement: record.statement,
            weight: record.weight,
            ..claim
        })
    }
}

/// Compares every claim with the simulation results.
pub fn compare(evidence: &Evidence) -> Vec<Finding> {
    let findings = claims().into_iter().map(|claim| {
        let comparison = claim.criterion.compare(claim.within, evidence);
        Finding {
            published: comparison.published,
            simulated: comparison.simulated,
            deviation: comparison.deviation,
            holds: comparison.holds,
            claim,
        }
    });
    findings.collect()
}

impl Finding {
    /// Fitness of the claim, 0 to 1. A value that deviates by twice its tolerance has a fitness of 0.5.
    pub fn fitness(&self) -> f64 {
        match (self.holds, self.deviation) {
            (Agreement::No, Some(off)) => self.claim.within / off.abs().max(f64::MIN_POSITIVE),
            (holds, _) => holds.share(),
        }
    }
}

/// Fitness of all claims, 0 to 1: the weighted mean of [`Finding::fitness`].
pub fn fitness(findings: &[Finding]) -> f64 {
    weighted_mean(findings, Finding::fitness)
}

/// Score of all claims, 0 to 1: the weighted mean of the shares to which they hold.
pub fn score(findings: &[Finding]) -> f64 {
    weighted_mean(findings, |finding| finding.holds.share())
}

fn weighted_mean(findings: &[Finding], value: impl Fn(&Finding) -> f64) -> f64 {
    let weights: f64 = findings.iter().map(|finding| finding.claim.weight).sum();
    let values = findings.iter().map(|f| f.claim.weight * value(f));
    values.sum::<f64>() / weights.max(f64::MIN_POSITIVE)
}

/// A comparison without its claim.
struct Comparison {
    published: String,
    simulated: String,
    deviation: Option<f64>,
    holds: Agreement,
}

impl Comparison {
    /// A comparison of a value that is not a number.
    fn new(published: impl ToString, simulated: Option<String>, holds: Agreement) -> Self {
        Self {
            published: published.to_string(),
            simulated: simulated.unwrap_or_else(nothing),
            deviation: None,
            holds,
        }
    }

    /// Compares a frequency with a published one, Hz; `None` if there is no result.
    fn frequency(published: f64, simulated: Option<f64>, within: f64) -> Self {
        let deviation = simulated.map(|simulated| simulated / published - 1.0);
        let holds = Agreement::when(deviation, |off| off.abs() <= within);
        Self {
            deviation,
            ..Self::new(khz(published), simulated.map(khz), holds)
        }
    }

    /// Compares each of some points; `look` returns whether a point agrees, and its value as text.
    fn of_points(
        published: impl ToString,
        points: &[(f64, &SettledResponse)],
        look: impl Fn(&SettledResponse) -> (bool, String),
    ) -> Self {
        let seen: Vec<_> = points.iter().map(|(tilt, r)| (tilt, look(r))).collect();
        let holding = seen.iter().filter(|(_, (is_so, _))| *is_so).count();
        let simulated = match &seen[..] {
            [] => None,
            [(_, (_, shown))] => Some(shown.clone()),
            _ => {
                let other = seen.iter().find(|(_, (is_so, _))| !is_so);
                let first = other.map(|(tilt, (_, shown))| format!("; at {tilt} deg {shown}"));
                let first = first.unwrap_or_default();
                Some(format!("{holding} of {} tilts{first}", seen.len()))
            }
        };
        Self::new(published, simulated, Agreement::of(holding, seen.len()))
    }
}

fn nothing() -> String {
    "not found".to_owned()
}

fn khz(hz: f64) -> String {
    format!("{:.3} kHz", 1e-3 * hz)
}

impl Criterion {
    fn compare(&self, within: f64, evidence: &Evidence) -> Comparison {
        let at = |tilt: f64| evidence.at(tilt);
        let one = |tilt: f64| -> Vec<_> { at(tilt).map(|r| (tilt, r)).into_iter().collect() };
        match *self {
            Self::NaturalFrequency { ref mode, hz } => {
                natural_frequency(mode, hz, within, evidence)
            }
            Self::UnstableModes { tilt_deg, count } => unstable_modes(count, &one(tilt_deg)),
            Self::Regime { tilt_deg, ref is } => regimes(is, &one(tilt_deg)),
            Self::RegimeOver {
                from_deg,
                to_deg,
                ref is,
            } => regimes(is, &evidence.between(from_deg, to_deg)),
            Self::StrongestLine { tilt_deg, hz } => strongest_line(at(tilt_deg), hz, within),
            Self::Line { tilt_deg, hz } => line(at(tilt_deg), hz, within),
            Self::ModeShift {
                from_deg,
                from_hz,
                to_deg,
                to_hz,
            } => both(
                strongest_line(at(from_deg), from_hz, within),
                strongest_line(at(to_deg), to_hz, within),
            ),
            Self::LinearMismatch { tilt_deg } => mismatch(at(tilt_deg), within),
            Self::Lag { tilt_deg, samples } => {
                let found = evidence.delay.filter(|_| at(tilt_deg).is_some());
                let simulated = found.map(|delay| format!("{:.0} us", 1e6 * delay.lag));
                // The paper does not state the sampling interval, so the delays cannot be compared.
                Comparison::new(format!("{samples} samples"), simulated, Agreement::Unknown)
            }
            Self::Dimension { tilt_deg, is } => {
                let found = evidence.delay.filter(|_| at(tilt_deg).is_some());
                let found = found.map(|delay| delay.dimension);
                let holds = Agreement::when(found, |dimension| dimension == is);
                Comparison::new(is, found.map(|dimension| dimension.to_string()), holds)
            }
            Self::RecurrencePeriod {
                from_deg,
                to_deg,
                s,
                kind,
            } => recurrence_period((s, kind), within, &evidence.between(from_deg, to_deg)),
            Self::ExponentZero { from_deg, to_deg } => {
                exponent_zero(&evidence.between(from_deg, to_deg))
            }
            Self::ExponentsPositive {
                from_deg,
                to_deg,
                count,
            } => exponents_positive(count, &evidence.between(from_deg, to_deg)),
            Self::Order { ref regimes } => order(regimes, &evidence.all()),
        }
    }
}

fn natural_frequency(mode: &str, hz: f64, within: f64, evidence: &Evidence) -> Comparison {
    let found = evidence.natural_frequencies.iter();
    let found = found.filter(|(label, _)| label == mode).map(|(_, hz)| *hz);
    Comparison::frequency(hz, found.min_by(f64::total_cmp), within)
}

fn unstable_modes(count: usize, points: &[(f64, &SettledResponse)]) -> Comparison {
    Comparison::of_points(count, points, |response| {
        let linear = response.linear.as_ref();
        let found = linear.map_or(0, |linear| linear.unstable().count());
        (found == count, found.to_string())
    })
}

/// Compares the regimes of points with the allowed ones.
fn regimes(allowed: &[String], points: &[(f64, &SettledResponse)]) -> Comparison {
    Comparison::of_points(allowed.join(" or "), points, |response| {
        let found = response.regime.to_string();
        (allowed.contains(&found), found)
    })
}

fn strongest_line(response: Option<&SettledResponse>, hz: f64, within: f64) -> Comparison {
    let line = response.and_then(|response| response.lines.first());
    Comparison::frequency(hz, line.map(|line| line.frequency), within)
}

/// Compares the spectral line nearest to a frequency.
fn line(response: Option<&SettledResponse>, hz: f64, within: f64) -> Comparison {
    let lines = response.map_or(&[][..], |response| &response.lines);
    let off = |line: f64| (line / hz - 1.0).abs();
    // Among many weak lines, one is close to any frequency.
    let strongest = lines.first().map_or(0.0, |line| line.amplitude);
    let seen = lines
        .iter()
        .filter(|line| line.amplitude >= MIN_LINE_AMPLITUDE * strongest);
    let nearest = seen.map(|line| line.frequency);
    let nearest = nearest.min_by(|a, b| off(*a).total_cmp(&off(*b)));
    Comparison::frequency(hz, nearest, within)
}

/// Combines the comparisons of two frequencies; both must hold.
fn both(from: Comparison, to: Comparison) -> Comparison {
    let holds = match (from.holds, to.holds) {
        (Agreement::Unknown, _) | (_, Agreement::Unknown) => Agreement::Unknown,
        (Agreement::Yes, Agreement::Yes) => Agreement::Yes,
        _ => Agreement::No,
    };
    let simulated = format!("{} to {}", from.simulated, to.simulated);
    Comparison::new(
        format!("{} to {}", from.published, to.published),
        Some(simulated),
        holds,
    )
}

/// Whether the mode with the largest growth rate is not the one that dominates the sound.
fn mismatch(response: Option<&SettledResponse>, within: f64) -> Comparison {
    let found = response.and_then(|response| {
        let modes = response.linear.as_ref()?.unstable();
        let fastest = modes.max_by(|a, b| a.growth.total_cmp(&b.growth))?;
        Some((fastest.frequency_hz, response.lines.first()?.frequency))
    });
    let simulated = found.map(|(fastest_hz, strongest_hz)| {
        format!(
            "fastest growth at {}, strongest line at {}",
            khz(fastest_hz),
            khz(strongest_hz)
        )
    });
    let holds = Agreement::when(found, |(fastest_hz, strongest_hz)| {
        (strongest_hz / fastest_hz - 1.0).abs() > within
    });
    Comparison::new("different modes", simulated, holds)
}

fn recurrence_period(
    (published, kind): (f64, RecurrenceKind),
    within: f64,
    points: &[(f64, &SettledResponse)],
) -> Comparison {
    let show = |period: f64| format!("{:.3} ms", 1e3 * period);
    Comparison::of_points(show(published), points, |response| {
        let found = response
            .recurrence_periods
            .last(kind)
            .map(|found| found.period);
        let is_so = found.is_some_and(|period| (period / published - 1.0).abs() <= within);
        (is_so, found.map_or_else(|| "none".to_owned(), show))
    })
}

fn exponent_zero(points: &[(f64, &SettledResponse)]) -> Comparison {
    Comparison::of_points("nearly zero", points, |response| {
        let largest = largest(response);
        let is_so = largest.is_some_and(|e| e.low() > -NEARLY_ZERO && e.high() < NEARLY_ZERO);
        (is_so, shown(largest))
    })
}

fn exponents_positive(count: usize, points: &[(f64, &SettledResponse)]) -> Comparison {
    let published = match count {
        1 => "positive".to_owned(),
        count => format!("{count} positive"),
    };
    Comparison::of_points(published, points, |response| {
        let is_so = (0..count).all(|k| sign(response, k) == Some(Sign::Positive));
        (is_so, shown(largest(response)))
    })
}

/// Compares the regimes along the tilt with an order. The share is the length of the longest subsequence of
/// points in that order relative to all points, times the share of the regimes that occur.
fn order(regimes: &[String], points: &[(f64, &SettledResponse)]) -> Comparison {
    let seen: Vec<String> = points.iter().map(|(_, r)| r.regime.to_string()).collect();
    let mut successive = seen.clone();
    successive.dedup();
    // Dynamic programming: longest subsequence whose regimes never go backwards in the order.
    let mut best = vec![0; regimes.len()];
    for regime in &seen {
        let Some(place) = regimes.iter().position(|r| r == regime) else {
            continue;
        };
        let before = best[..=place].iter().copied().max().unwrap_or(0);
        best[place] = before + 1;
    }
    let kept = best.into_iter().max().unwrap_or(0);
    let present = regimes
        .iter()
        .filter(|regime| seen.contains(regime))
        .count();
    let holds = match seen.len() {
        0 => Agreement::Unknown,
        count if kept == count && present == regimes.len() => Agreement::Yes,
        count => {
            let share = kept as f64 / count as f64;
            Agreement::Partly(share * (present as f64 / regimes.len().max(1) as f64))
        }
    };
    let simulated = (!seen.is_empty()).then(|| successive.join(", "));
    Comparison::new(regimes.join(", then "), simulated, holds)
}

fn sign(response: &SettledResponse, k: usize) -> Option<Sign> {
    let spectrum = response.exponents.as_ref()?;
    (k < spectrum.exponents.len()).then(|| spectrum.sign(k))
}

fn largest(response: &SettledResponse) -> Option<Exponent> {
    response.exponents.as_ref()?.exponents.first().copied()
}

fn shown(exponent: Option<Exponent>) -> String {
    exponent.map_or_else(nothing, |e| {
        // For a small exponent the text must show whether the interval contains zero.
        let places = if e.half_width < 2.0 { 2 } else { 0 };
        format!("{:.places$} +- {:.places$} 1/s", e.value, e.half_width)
    })
}
