//! What the paper claims, and how it compares with what was found.

use serde::{Deserialize, Serialize, Serializer};

use super::evidence::Evidence;
use crate::dynamics::Sign;
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
#[serde(deny_unknown_fields)]
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
    natural_frequency: Option<NaturalFrequency>,
    unstable_modes: Option<UnstableModes>,
    regime: Option<RegimeAt>,
    strongest_line: Option<LineAt>,
    mode_shift: Option<ShiftBetween>,
    line: Option<LineAt>,
    linear_mismatch: Option<MismatchAt>,
    lag: Option<LagAt>,
    dimension: Option<DimensionAt>,
    recurrence_period: Option<PeriodOver>,
    regime_over: Option<RegimeOver>,
    exponent_zero: Option<Span>,
    exponents_positive: Option<PositiveOver>,
    order: Option<Order>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct NaturalFrequency {
    mode: String,
    hz: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct UnstableModes {
    tilt_deg: f64,
    count: usize,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct RegimeAt {
    tilt_deg: f64,
    is: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct LineAt {
    tilt_deg: f64,
    hz: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShiftBetween {
    from_deg: f64,
    from_hz: f64,
    to_deg: f64,
    to_hz: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct MismatchAt {
    tilt_deg: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct LagAt {
    tilt_deg: f64,
    samples: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct DimensionAt {
    tilt_deg: f64,
    is: usize,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct PeriodOver {
    from_deg: f64,
    to_deg: f64,
    s: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct RegimeOver {
    from_deg: f64,
    to_deg: f64,
    is: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Span {
    from_deg: f64,
    to_deg: f64,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct PositiveOver {
    from_deg: f64,
    to_deg: f64,
    count: usize,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Order {
    regimes: Vec<String>,
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
        let told = claim.tell(evidence);
        Finding {
            published: told.published,
            ours: told.ours,
            deviation: told.deviation,
            holds: told.holds,
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
    let weights: f64 = findings.iter().map(|finding| finding.claim.weight).sum();
    let near = findings.iter().map(|f| f.claim.weight * f.nearness());
    near.sum::<f64>() / weights.max(f64::MIN_POSITIVE)
}

/// How well claims hold in all: the mean of their shares by their weights, 0 to 1.
pub fn score(findings: &[Finding]) -> f64 {
    let weights: f64 = findings.iter().map(|finding| finding.claim.weight).sum();
    let held = findings.iter().map(|f| f.claim.weight * f.holds.share());
    held.sum::<f64>() / weights.max(f64::MIN_POSITIVE)
}

/// A comparison without its claim.
struct Told {
    published: String,
    ours: String,
    deviation: Option<f64>,
    holds: Holds,
}

impl Told {
    /// A number against a published one; `None` if nothing was found.
    fn number(
        published: f64,
        ours: Option<f64>,
        within: f64,
        show: impl Fn(f64) -> String,
    ) -> Self {
        let deviation = ours.map(|ours| ours / published - 1.0);
        Self {
            published: show(published),
            ours: ours.map_or_else(nothing, &show),
            deviation,
            holds: match deviation {
                None => Holds::Unknown,
                Some(off) if off.abs() <= within => Holds::Yes,
                Some(_) => Holds::No,
            },
        }
    }

    /// How many of some points are as claimed.
    fn of_points(
        published: String,
        points: &[(f64, &Response)],
        is_so: impl Fn(&Response) -> bool,
        show: impl Fn(&Response) -> String,
    ) -> Self {
        let holding = points
            .iter()
            .filter(|(_, response)| is_so(response))
            .count();
        let ours = match points {
            [] => nothing(),
            [(_, one)] => show(one),
            _ => {
                let other = points.iter().find(|(_, response)| !is_so(response));
                let first =
                    other.map(|(tilt, response)| format!("; at {tilt} deg {}", show(response)));
                format!(
                    "{holding} of {} tilts{}",
                    points.len(),
                    first.unwrap_or_default()
                )
            }
        };
        Self {
            published,
            ours,
            deviation: None,
            holds: Holds::of(holding, points.len()),
        }
    }
}

fn nothing() -> String {
    "not found".to_owned()
}

fn khz(hz: f64) -> String {
    format!("{:.3} kHz", 1e-3 * hz)
}

impl Claim {
    fn tell(&self, evidence: &Evidence) -> Told {
        let at = |tilt: f64| evidence.at(tilt);
        let one = |tilt: f64| {
            at(tilt)
                .map(|response| (tilt, response))
                .into_iter()
                .collect::<Vec<_>>()
        };
        if let Some(NaturalFrequency { mode, hz }) = &self.natural_frequency {
            let found = evidence.natural_frequencies.iter();
            let found = found.filter(|(label, _)| label == mode).map(|(_, hz)| *hz);
            return Told::number(*hz, found.min_by(f64::total_cmp), self.within, khz);
        }
        if let Some(UnstableModes { tilt_deg, count }) = &self.unstable_modes {
            let of = |response: &Response| {
                let linear = response.linear.as_ref();
                linear.map_or(0, |linear| linear.unstable().count())
            };
            let is_so = |response: &Response| of(response) == *count;
            let show = |response: &Response| of(response).to_string();
            return Told::of_points(count.to_string(), &one(*tilt_deg), is_so, show);
        }
        if let Some(RegimeAt { tilt_deg, is }) = &self.regime {
            return regimes(is, &one(*tilt_deg));
        }
        if let Some(RegimeOver {
            from_deg,
            to_deg,
            is,
        }) = &self.regime_over
        {
            return regimes(is, &evidence.between(*from_deg, *to_deg));
        }
        let strongest = |tilt: f64| Some(at(tilt)?.lines.first()?.frequency);
        if let Some(LineAt { tilt_deg, hz }) = &self.strongest_line {
            return Told::number(*hz, strongest(*tilt_deg), self.within, khz);
        }
        if let Some(shift) = &self.mode_shift {
            let [from, to] = [
                (shift.from_hz, strongest(shift.from_deg)),
                (shift.to_hz, strongest(shift.to_deg)),
            ]
            .map(|(hz, found)| Told::number(hz, found, self.within, khz));
            let both = |a: String, b: String| format!("{a} to {b}");
            return Told {
                published: both(from.published, to.published),
                ours: both(from.ours, to.ours),
                deviation: None,
                holds: match (from.holds, to.holds) {
                    (Holds::Unknown, _) | (_, Holds::Unknown) => Holds::Unknown,
                    (Holds::Yes, Holds::Yes) => Holds::Yes,
                    _ => Holds::No,
                },
            };
        }
        if let Some(LineAt { tilt_deg, hz }) = &self.line {
            let lines = at(*tilt_deg).map_or(&[][..], |response| &response.lines);
            let off = |line: f64| (line / hz - 1.0).abs();
            // Among many faint lines one is near to anything.
            let strongest = lines.first().map_or(0.0, |line| line.amplitude);
            let seen = lines
                .iter()
                .filter(|line| line.amplitude >= SEEN * strongest);
            let nearest = seen.map(|line| line.frequency);
            let nearest = nearest.min_by(|a, b| off(*a).total_cmp(&off(*b)));
            return Told::number(*hz, nearest, self.within, khz);
        }
        if let Some(MismatchAt { tilt_deg }) = &self.linear_mismatch {
            return mismatch(at(*tilt_deg), self.within);
        }
        if let Some(LagAt { tilt_deg, samples }) = &self.lag {
            // The paper's spacing is not stated: there is nothing to hold the number against.
            let found = evidence.delay.filter(|_| at(*tilt_deg).is_some());
            return Told {
                published: format!("{samples} samples"),
                ours: found.map_or_else(nothing, |delay| format!("{:.0} us", 1e6 * delay.lag)),
                deviation: None,
                holds: Holds::Unknown,
            };
        }
        if let Some(DimensionAt { tilt_deg, is }) = &self.dimension {
            let found = evidence.delay.filter(|_| at(*tilt_deg).is_some());
            return Told {
                published: is.to_string(),
                ours: found.map_or_else(nothing, |delay| delay.dimension.to_string()),
                deviation: None,
                holds: match found {
                    None => Holds::Unknown,
                    Some(delay) if delay.dimension == *is => Holds::Yes,
                    Some(_) => Holds::No,
                },
            };
        }
        if let Some(PeriodOver {
            from_deg,
            to_deg,
            s,
        }) = &self.recurrence_period
        {
            let within = self.within;
            let is_so = |response: &Response| {
                let period = response.recurrence_period;
                period.is_some_and(|period| (period / s - 1.0).abs() <= within)
            };
            let show = |response: &Response| match response.recurrence_period {
                Some(period) => format!("{:.3} ms", 1e3 * period),
                None => "none".to_owned(),
            };
            let points = evidence.between(*from_deg, *to_deg);
            return Told::of_points(format!("{:.3} ms", 1e3 * s), &points, is_so, show);
        }
        if let Some(Span { from_deg, to_deg }) = &self.exponent_zero {
            let is_so = |response: &Response| {
                let spectrum = response.exponents.as_ref();
                let largest = spectrum.and_then(|spectrum| spectrum.exponents.first());
                largest.is_some_and(|e| e.low() > -NEARLY_ZERO && e.high() < NEARLY_ZERO)
            };
            let points = evidence.between(*from_deg, *to_deg);
            return Told::of_points("nearly zero".to_owned(), &points, is_so, largest);
        }
        if let Some(PositiveOver {
            from_deg,
            to_deg,
            count,
        }) = &self.exponents_positive
        {
            let is_so = |response: &Response| {
                (0..*count).all(|k| sign(response, k) == Some(Sign::Positive))
            };
            let published = match count {
                1 => "positive".to_owned(),
                count => format!("{count} positive"),
            };
            let points = evidence.between(*from_deg, *to_deg);
            return Told::of_points(published, &points, is_so, largest);
        }
        if let Some(Order { regimes }) = &self.order {
            return order(regimes, evidence);
        }
        Told {
            published: String::new(),
            ours: nothing(),
            deviation: None,
            holds: Holds::Unknown,
        }
    }
}

/// Whether the mode that grows fastest is not the one that is heard.
fn mismatch(response: Option<&Response>, within: f64) -> Told {
    let found = response.and_then(|response| {
        let modes = response.linear.as_ref()?.unstable();
        let fastest = modes.max_by(|a, b| a.growth.total_cmp(&b.growth))?;
        Some((fastest.frequency_hz, response.lines.first()?.frequency))
    });
    Told {
        published: "another one".to_owned(),
        ours: found.map_or_else(nothing, |(grows, heard)| {
            format!("{} grows fastest, {} is heard", khz(grows), khz(heard))
        }),
        deviation: None,
        holds: match found {
            None => Holds::Unknown,
            Some((grows, heard)) if (heard / grows - 1.0).abs() > within => Holds::Yes,
            Some(_) => Holds::No,
        },
    }
}

/// Points against the kinds of motion that they may have.
fn regimes(allowed: &[String], points: &[(f64, &Response)]) -> Told {
    let is_so = |response: &Response| allowed.contains(&response.regime.to_string());
    let show = |response: &Response| response.regime.to_string();
    Told::of_points(allowed.join(" or "), points, is_so, show)
}

/// The kinds of motion along the tilt against an order: the longest run of points that keeps to it,
/// over all of them, if each kind is there at all.
fn order(regimes: &[String], evidence: &Evidence) -> Told {
    let points = evidence.all();
    let seen: Vec<String> = points
        .iter()
        .map(|(_, response)| response.regime.to_string())
        .collect();
    let mut told: Vec<&str> = seen.iter().map(String::as_str).collect();
    told.dedup();
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
    let all_there = regimes.iter().all(|regime| seen.contains(regime));
    let missing = regimes
        .iter()
        .filter(|regime| !seen.contains(regime))
        .count();
    let present = (regimes.len() - missing) as f64 / regimes.len().max(1) as f64;
    let share = kept as f64 / seen.len().max(1) as f64;
    Told {
        published: regimes.join(", then "),
        ours: if told.is_empty() {
            nothing()
        } else {
            told.join(", ")
        },
        deviation: None,
        holds: match seen.len() {
            0 => Holds::Unknown,
            count if kept == count && all_there => Holds::Yes,
            _ => Holds::Partly(share * present),
        },
    }
}

fn sign(response: &Response, k: usize) -> Option<Sign> {
    let spectrum = response.exponents.as_ref()?;
    (k < spectrum.exponents.len()).then(|| spectrum.sign(k))
}

fn largest(response: &Response) -> String {
    let spectrum = response.exponents.as_ref();
    let largest = spectrum.and_then(|spectrum| spectrum.exponents.first());
    largest.map_or_else(nothing, |e| {
        // Small ones count: whether an interval holds zero must be seen.
        let places = if e.half_width < 2.0 { 2 } else { 0 };
        format!("{:.places$} +- {:.places$} 1/s", e.value, e.half_width)
    })
}
