//! What the paper claims, and how it compares with what was found.

use serde::{Deserialize, Serialize, Serializer};

use super::evidence::Evidence;
use crate::dynamics::{Exponent, Sign};
use crate::study::response::Response;

/// The claims, as data (TOML).
pub const CLAIMS: &str = include_str!("../../../assets/paper/claims.toml");

/// A line counts as there from this share of the strongest one's amplitude.
const SEEN: f64 = 0.05;

/// An exponent is nearly zero if its whole interval is nearer to it than this, 1/s: about a tenth of what
/// chaos has.
const NEARLY_ZERO: f64 = 10.0;

/// A claim of the paper.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Claim {
    /// A short name.
    pub id: String,
    /// Where it stands in the paper.
    #[serde(rename = "where")]
    pub place: String,
    /// What it says, in our words.
    pub says: String,
    /// How much it counts when parameter sets are compared.
    pub weight: f64,
    /// Relative deviation within which a number counts as reached.
    #[serde(default)]
    pub within: f64,
    #[serde(flatten)]
    statement: Statement,
}

/// What is claimed, as a quantity that can be measured. Angles are tilts of the load.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Statement {
    /// A mode of the finite-element model has this natural frequency.
    NaturalFrequency { mode: String, hz: f64 },
    /// So many modes of steady sliding are unstable.
    UnstableModes { tilt_deg: f64, count: usize },
    /// The motion is of one of these kinds.
    Regime { tilt_deg: f64, is: Vec<String> },
    /// The same over a range of tilts.
    RegimeOver {
        from_deg: f64,
        to_deg: f64,
        is: Vec<String>,
    },
    /// The strongest line has this frequency.
    StrongestLine { tilt_deg: f64, hz: f64 },
    /// Some line has this frequency.
    Line { tilt_deg: f64, hz: f64 },
    /// The strongest line moves from one frequency to another.
    ModeShift {
        from_deg: f64,
        from_hz: f64,
        to_deg: f64,
        to_hz: f64,
    },
    /// The mode that grows fastest is not the one that is heard.
    LinearMismatch { tilt_deg: f64 },
    /// The delay of the embedding.
    Lag { tilt_deg: f64, samples: f64 },
    /// The dimension of the embedding.
    Dimension { tilt_deg: f64, is: usize },
    /// The diagonals of the recurrence plot are this far apart, s.
    RecurrencePeriod { from_deg: f64, to_deg: f64, s: f64 },
    /// The largest Lyapunov exponent is nearly zero.
    ExponentZero { from_deg: f64, to_deg: f64 },
    /// So many Lyapunov exponents are positive.
    ExponentsPositive {
        from_deg: f64,
        to_deg: f64,
        count: usize,
    },
    /// The kinds of motion follow each other in this order as the tilt grows.
    Order { regimes: Vec<String> },
}

#[derive(Deserialize)]
struct Claims {
    claim: Vec<Claim>,
}

/// All claims, in the order of the paper.
pub fn claims() -> Vec<Claim> {
    // A test shows that the program's own file can be read.
    toml::from_str::<Claims>(CLAIMS).map_or_else(|_| Vec::new(), |claims| claims.claim)
}

/// Whether a claim holds of what was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "HoldsRecord")]
pub enum Holds {
    /// It does.
    Yes,
    /// It holds in part: at this share of the tilts it speaks of, 0 to 1.
    Partly(f64),
    /// It does not.
    No,
    /// Nothing was found that could tell.
    Unknown,
}

/// Whether a claim holds, as JSON has it.
#[derive(Serialize)]
struct HoldsRecord {
    holds: &'static str,
    share: f64,
}

impl From<Holds> for HoldsRecord {
    fn from(holds: Holds) -> Self {
        Self {
            holds: holds.name(),
            share: holds.share(),
        }
    }
}

impl Holds {
    /// In a word: `yes`, `partly`, `no` or `unknown`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::Partly(_) => "partly",
            Self::No => "no",
            Self::Unknown => "unknown",
        }
    }

    /// How far it holds, 0 to 1; what cannot be told does not.
    pub fn share(self) -> f64 {
        match self {
            Self::Yes => 1.0,
            Self::Partly(share) => share,
            Self::No | Self::Unknown => 0.0,
        }
    }

    /// By what was found, if anything was.
    fn when<T>(found: Option<T>, is_so: impl Fn(T) -> bool) -> Self {
        match found.map(is_so) {
            None => Self::Unknown,
            Some(true) => Self::Yes,
            Some(false) => Self::No,
        }
    }

    /// By counts.
    fn of(holding: usize, all: usize) -> Self {
        match (holding, all) {
            (_, 0) => Self::Unknown,
            (0, _) => Self::No,
            (holding, all) if holding == all => Self::Yes,
            (holding, all) => Self::Partly(holding as f64 / all as f64),
        }
    }
}

/// A claim beside what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The claim.
    #[serde(flatten, serialize_with = "claim_record")]
    pub claim: Claim,
    /// What is published, in a word.
    pub published: String,
    /// What was found, in a word.
    pub ours: String,
    /// Relative deviation of a number.
    pub deviation: Option<f64>,
    /// Whether the claim holds.
    #[serde(flatten)]
    pub holds: Holds,
}

/// A claim as JSON has it: its words.
fn claim_record<S: Serializer>(claim: &Claim, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Record<'a> {
        id: &'a str,
        place: &'a str,
        says: &'a str,
        weight: f64,
    }
    let record = Record {
        id: &claim.id,
        place: &claim.place,
        says: &claim.says,
        weight: claim.weight,
    };
    record.serialize(serializer)
}

/// Compares every claim with what was found.
pub fn compare(evidence: &Evidence) -> Vec<Finding> {
    let findings = claims().into_iter().map(|claim| {
        let verdict = claim.statement.judge(claim.within, evidence);
        Finding {
            published: verdict.published,
            ours: verdict.ours,
            deviation: verdict.deviation,
            holds: verdict.holds,
            claim,
        }
    });
    findings.collect()
}

impl Finding {
    /// How near the claim is to holding, 0 to 1: a number that is off by twice what it may be is
    /// half way there.
    pub fn nearness(&self) -> f64 {
        match (self.holds, self.deviation) {
            (Holds::No, Some(off)) => self.claim.within / off.abs().max(f64::MIN_POSITIVE),
            (holds, _) => holds.share(),
        }
    }
}

/// How near all claims are to holding: the mean of [`Finding::nearness`] by their weights, 0 to 1.
pub fn nearness(findings: &[Finding]) -> f64 {
    weighted_mean(findings, Finding::nearness)
}

/// How well claims hold in all: the mean of their shares by their weights, 0 to 1.
pub fn score(findings: &[Finding]) -> f64 {
    weighted_mean(findings, |finding| finding.holds.share())
}

fn weighted_mean(findings: &[Finding], value: impl Fn(&Finding) -> f64) -> f64 {
    let weights: f64 = findings.iter().map(|finding| finding.claim.weight).sum();
    let values = findings.iter().map(|f| f.claim.weight * value(f));
    values.sum::<f64>() / weights.max(f64::MIN_POSITIVE)
}

/// A comparison without its claim.
struct Verdict {
    published: String,
    ours: String,
    deviation: Option<f64>,
    holds: Holds,
}

impl Verdict {
    /// Of what is no number.
    fn new(published: impl ToString, ours: Option<String>, holds: Holds) -> Self {
        Self {
            published: published.to_string(),
            ours: ours.unwrap_or_else(nothing),
            deviation: None,
            holds,
        }
    }

    /// A frequency against a published one, Hz; `None` if nothing was found.
    fn frequency(published: f64, ours: Option<f64>, within: f64) -> Self {
        let deviation = ours.map(|ours| ours / published - 1.0);
        let holds = Holds::when(deviation, |off| off.abs() <= within);
        Self {
            deviation,
            ..Self::new(khz(published), ours.map(khz), holds)
        }
    }

    /// How many of some points are as claimed: `look` tells whether one is, and what was found there.
    fn of_points(
        published: impl ToString,
        points: &[(f64, &Response)],
        look: impl Fn(&Response) -> (bool, String),
    ) -> Self {
        let seen: Vec<_> = points.iter().map(|(tilt, r)| (tilt, look(r))).collect();
        let holding = seen.iter().filter(|(_, (is_so, _))| *is_so).count();
        let ours = match &seen[..] {
            [] => None,
            [(_, (_, shown))] => Some(shown.clone()),
            _ => {
                let other = seen.iter().find(|(_, (is_so, _))| !is_so);
                let first = other.map(|(tilt, (_, shown))| format!("; at {tilt} deg {shown}"));
                let first = first.unwrap_or_default();
                Some(format!("{holding} of {} tilts{first}", seen.len()))
            }
        };
        Self::new(published, ours, Holds::of(holding, seen.len()))
    }
}

fn nothing() -> String {
    "not found".to_owned()
}

fn khz(hz: f64) -> String {
    format!("{:.3} kHz", 1e-3 * hz)
}

impl Statement {
    fn judge(&self, within: f64, evidence: &Evidence) -> Verdict {
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
                let ours = found.map(|delay| format!("{:.0} us", 1e6 * delay.lag));
                // The paper's spacing is not stated: there is nothing to hold the number against.
                Verdict::new(format!("{samples} samples"), ours, Holds::Unknown)
            }
            Self::Dimension { tilt_deg, is } => {
                let found = evidence.delay.filter(|_| at(tilt_deg).is_some());
                let found = found.map(|delay| delay.dimension);
                let holds = Holds::when(found, |dimension| dimension == is);
                Verdict::new(is, found.map(|dimension| dimension.to_string()), holds)
            }
            Self::RecurrencePeriod {
                from_deg,
                to_deg,
                s,
            } => recurrence_period(s, within, &evidence.between(from_deg, to_deg)),
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

fn natural_frequency(mode: &str, hz: f64, within: f64, evidence: &Evidence) -> Verdict {
    let found = evidence.natural_frequencies.iter();
    let found = found.filter(|(label, _)| label == mode).map(|(_, hz)| *hz);
    Verdict::frequency(hz, found.min_by(f64::total_cmp), within)
}

fn unstable_modes(count: usize, points: &[(f64, &Response)]) -> Verdict {
    Verdict::of_points(count, points, |response| {
        let linear = response.linear.as_ref();
        let found = linear.map_or(0, |linear| linear.unstable().count());
        (found == count, found.to_string())
    })
}

/// Points against the kinds of motion that they may have.
fn regimes(allowed: &[String], points: &[(f64, &Response)]) -> Verdict {
    Verdict::of_points(allowed.join(" or "), points, |response| {
        let found = response.regime.to_string();
        (allowed.contains(&found), found)
    })
}

fn strongest_line(response: Option<&Response>, hz: f64, within: f64) -> Verdict {
    let line = response.and_then(|response| response.lines.first());
    Verdict::frequency(hz, line.map(|line| line.frequency), within)
}

/// The line nearest to a frequency.
fn line(response: Option<&Response>, hz: f64, within: f64) -> Verdict {
    let lines = response.map_or(&[][..], |response| &response.lines);
    let off = |line: f64| (line / hz - 1.0).abs();
    // Among many faint lines one is near to anything.
    let strongest = lines.first().map_or(0.0, |line| line.amplitude);
    let seen = lines
        .iter()
        .filter(|line| line.amplitude >= SEEN * strongest);
    let nearest = seen.map(|line| line.frequency);
    let nearest = nearest.min_by(|a, b| off(*a).total_cmp(&off(*b)));
    Verdict::frequency(hz, nearest, within)
}

/// Both of two frequencies.
fn both(from: Verdict, to: Verdict) -> Verdict {
    let holds = match (from.holds, to.holds) {
        (Holds::Unknown, _) | (_, Holds::Unknown) => Holds::Unknown,
        (Holds::Yes, Holds::Yes) => Holds::Yes,
        _ => Holds::No,
    };
    let ours = format!("{} to {}", from.ours, to.ours);
    Verdict::new(
        format!("{} to {}", from.published, to.published),
        Some(ours),
        holds,
    )
}

/// Whether the mode that grows fastest is not the one that is heard.
fn mismatch(response: Option<&Response>, within: f64) -> Verdict {
    let found = response.and_then(|response| {
        let modes = response.linear.as_ref()?.unstable();
        let fastest = modes.max_by(|a, b| a.growth.total_cmp(&b.growth))?;
        Some((fastest.frequency_hz, response.lines.first()?.frequency))
    });
    let ours = found
        .map(|(grows, heard)| format!("{} grows fastest, {} is heard", khz(grows), khz(heard)));
    let holds = Holds::when(found, |(grows, heard)| (heard / grows - 1.0).abs() > within);
    Verdict::new("another one", ours, holds)
}

fn recurrence_period(published: f64, within: f64, points: &[(f64, &Response)]) -> Verdict {
    let show = |period: f64| format!("{:.3} ms", 1e3 * period);
    Verdict::of_points(show(published), points, |response| {
        let found = response.recurrence_period;
        let is_so = found.is_some_and(|period| (period / published - 1.0).abs() <= within);
        (is_so, found.map_or_else(|| "none".to_owned(), show))
    })
}

fn exponent_zero(points: &[(f64, &Response)]) -> Verdict {
    Verdict::of_points("nearly zero", points, |response| {
        let largest = largest(response);
        let is_so = largest.is_some_and(|e| e.low() > -NEARLY_ZERO && e.high() < NEARLY_ZERO);
        (is_so, shown(largest))
    })
}

fn exponents_positive(count: usize, points: &[(f64, &Response)]) -> Verdict {
    let published = match count {
        1 => "positive".to_owned(),
        count => format!("{count} positive"),
    };
    Verdict::of_points(published, points, |response| {
        let is_so = (0..count).all(|k| sign(response, k) == Some(Sign::Positive));
        (is_so, shown(largest(response)))
    })
}

/// The kinds of motion along the tilt against an order: the longest run of points that keeps to it,
/// over all of them, if each kind is there at all.
fn order(regimes: &[String], points: &[(f64, &Response)]) -> Verdict {
    let seen: Vec<String> = points.iter().map(|(_, r)| r.regime.to_string()).collect();
    let mut successive = seen.clone();
    successive.dedup();
    // The most points that can be kept so that their kinds never go back in the order.
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
        0 => Holds::Unknown,
        count if kept == count && present == regimes.len() => Holds::Yes,
        count => {
            let share = kept as f64 / count as f64;
            Holds::Partly(share * (present as f64 / regimes.len().max(1) as f64))
        }
    };
    let ours = (!seen.is_empty()).then(|| successive.join(", "));
    Verdict::new(regimes.join(", then "), ours, holds)
}

fn sign(response: &Response, k: usize) -> Option<Sign> {
    let spectrum = response.exponents.as_ref()?;
    (k < spectrum.exponents.len()).then(|| spectrum.sign(k))
}

fn largest(response: &Response) -> Option<Exponent> {
    response.exponents.as_ref()?.exponents.first().copied()
}

fn shown(exponent: Option<Exponent>) -> String {
    exponent.map_or_else(nothing, |e| {
        // Small ones count: whether an interval holds zero must be seen.
        let places = if e.half_width < 2.0 { 2 } else { 0 };
        format!("{:.places$} +- {:.places$} 1/s", e.value, e.half_width)
    })
}
