//! What a claim states, and its comparison with the simulation results.

use serde::Deserialize;

use super::claims::{Comparison, Evidence, Verdict};
use crate::analysis::{
    poincare::{SectionShape, section_shape},
    recurrence::RecurrenceKind,
    regime::Regime,
};
use crate::dynamics::{Exponent, Sign};
use crate::report::Measured;
use crate::study::response::SettledResponse;

/// Minimum amplitude of a line that counts, relative to the strongest line.
const MIN_LINE_AMPLITUDE: f64 = 0.05;

/// An exponent is nearly zero if its whole interval lies within this distance of zero, 1/s: about a tenth of
/// the largest exponent in chaos.
const NEARLY_ZERO: f64 = 10.0;

/// The claimed value of a measurable quantity.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Criterion {
    /// A mode of the finite-element model has this natural frequency.
    NaturalFrequency { mode: String, hz: f64 },
    /// Number of unstable modes of steady sliding.
    UnstableModes(usize),
    /// The motion has one of these regimes.
    Regime(Vec<String>),
    /// Lines that are no harmonics of the strongest one are weaker than this share of it.
    NearlyPeriodic(f64),
    /// Frequency of the strongest spectral line, Hz.
    StrongestLine(f64),
    /// Frequency of some spectral line, Hz.
    Line(f64),
    /// Frequency of some spectral line that is no harmonic of another line, Hz.
    IndependentLine(f64),
    /// A line at an integer combination of two other lines, Hz.
    Combination {
        hz: f64,
        base_hz: [f64; 2],
        orders: [i32; 2],
    },
    /// All lines are harmonics of this frequency (Hz), and there is more than one.
    Harmonics(f64),
    /// The strongest lines are lines at another tilt, too.
    SameLines { as_deg: f64, count: usize },
    /// Least share of the power between the lines.
    Broadband(f64),
    /// Most unstable modes have no line near their frequency that is no harmonic of another.
    LinearMismatch {},
    /// Delay of the embedding, samples.
    Lag(f64),
    /// Embedding dimension.
    Dimension(usize),
    /// Distance between the diagonal lines of the recurrence plot, s.
    RecurrencePeriod { s: f64, kind: RecurrenceKind },
    /// The recurrence plot has no period.
    NoRecurrencePeriod {},
    /// Form of the Poincare section: `points`, a few; `circle`, one closed curve; or `scattered`.
    Section(String),
    /// The largest Lyapunov exponent is nearly zero.
    ExponentZero {},
    /// Number of positive Lyapunov exponents.
    ExponentsPositive(usize),
    /// Order of the regimes with increasing tilt.
    Order(Vec<String>),
    /// Number of base frequencies of a periodic, a quasi-periodic and a chaotic motion.
    BaseFrequencies([usize; 3]),
}

/// Some tilts in degrees with their responses.
type Points<'e> = [(f64, &'e SettledResponse)];

impl Comparison {
    /// A comparison of a value that is not a number.
    fn new(expected: impl ToString, measured: Option<String>, verdict: Verdict) -> Self {
        Self {
            expected: expected.to_string(),
            measured: measured.unwrap_or_else(|| NOTHING.to_owned()),
            deviation: None,
            verdict,
        }
    }

    /// Compares a frequency with a published one, Hz. Without a result the claim cannot be compared;
    /// a response without such a line does not meet it.
    fn frequency(published: f64, measured: Option<Option<f64>>, within: f64) -> Self {
        let is_near = |hz: Option<f64>| hz.is_some_and(|hz| is_near(hz, published, within));
        let verdict = Verdict::when(measured, is_near);
        let measured = measured.flatten();
        Self {
            deviation: measured.map(|hz| hz / published - 1.0),
            ..Self::new(khz(published), measured.map(khz), verdict)
        }
    }

    /// Compares each of some points; `agreement` returns whether a point agrees, and its value as text, if it can be compared.
    fn of_points(
        expected: impl ToString,
        points: &Points<'_>,
        agreement: impl Fn(&SettledResponse) -> Option<(bool, String)>,
    ) -> Self {
        let seen = points.iter().map(|(tilt, r)| Some((tilt, agreement(r)?)));
        let seen: Vec<_> = seen.flatten().collect();
        let holding = seen.iter().filter(|(_, (is_so, _))| *is_so).count();
        let measured = match &seen[..] {
            [] => None,
            [(_, (_, shown))] => Some(shown.clone()),
            _ => {
                let other = seen.iter().find(|(_, (is_so, _))| !is_so);
                let first = other.map(|(tilt, (_, shown))| format!("; at {tilt} deg {shown}"));
                let first = first.unwrap_or_default();
                Some(format!("{holding} of {} tilts{first}", seen.len()))
            }
        };
        Self::new(expected, measured, Verdict::of(holding, seen.len()))
    }
}

/// Measured value without a result.
const NOTHING: &str = "not found";

/// Texts separated by commas; `none` if there are none.
fn listed(texts: impl Iterator<Item = String>, none: &str) -> String {
    let texts: Vec<String> = texts.collect();
    if texts.is_empty() {
        none.to_owned()
    } else {
        texts.join(", ")
    }
}

/// Whether a value differs from a published one by at most a relative tolerance.
fn is_near(value: f64, published: f64, within: f64) -> bool {
    (value / published - 1.0).abs() <= within
}

fn khz(hz: f64) -> String {
    format!("{:.3} kHz", 1e-3 * hz)
}

impl Criterion {
    /// Compares the claim with the responses at its tilts and with the evidence. `within` is the relative tolerance of
    /// numbers.
    pub fn compare(&self, within: f64, points: &Points<'_>, evidence: &Evidence) -> Comparison {
        let first = points.first().map(|(_, response)| *response);
        let line = |hz, found: &dyn Fn(&SettledResponse) -> Option<f64>| {
            Comparison::frequency(hz, first.map(found), within)
        };
        let embedding = evidence.embedding.as_ref().filter(|_| first.is_some());
        match *self {
            Self::NaturalFrequency { ref mode, hz } => {
                let found = evidence.natural_frequencies.iter();
                let found = found.filter(|(label, _)| label == mode).map(|(_, hz)| *hz);
                Comparison::frequency(hz, found.min_by(f64::total_cmp).map(Some), within)
            }
            Self::UnstableModes(count) => Comparison::of_points(count, points, |response| {
                let linear = response.linear.as_ref();
                let found = linear.map_or(0, |linear| linear.unstable().count());
                Some((found == count, found.to_string()))
            }),
            Self::Regime(ref allowed) => {
                Comparison::of_points(allowed.join(" or "), points, |response| {
                    let found = regime(response).to_string();
                    Some((allowed.contains(&found), found))
                })
            }
            Self::NearlyPeriodic(share) => nearly_periodic(share, points),
            Self::StrongestLine(hz) => line(hz, &|r| Some(r.lines.first()?.frequency)),
            Self::Line(hz) => line(hz, &|r| nearest(&strong_lines(r), hz)),
            Self::IndependentLine(hz) => line(hz, &|r| nearest(&independent_lines(r), hz)),
            Self::Combination {
                hz,
                base_hz,
                orders,
            } => line(hz, &|r| combination(r, base_hz, orders)),
            Self::Harmonics(hz) => harmonics(hz, within, points),
            Self::SameLines { as_deg, count } => {
                let model = evidence.at(as_deg);
                same_lines(first, model, count, within)
            }
            Self::Broadband(share) => {
                let percent = |share: f64| format!("{:.1} %", 100.0 * share);
                let expected = format!("at least {}", percent(share));
                Comparison::of_points(expected, points, |response| {
                    let found = response.broadband_share;
                    Some((found >= share, percent(found)))
                })
            }
            Self::LinearMismatch {} => linear_mismatch(points, within),
            // The paper does not state the sampling interval, so the delays cannot be compared.
            Self::Lag(samples) => Comparison::new(
                format!("{samples} samples"),
                embedding.map(|(choice, dt)| format!("{:.0} µs", 1e6 * (choice.lag as f64 * dt))),
                Verdict::NotComparable,
            ),
            Self::Dimension(is) => dimension(is, embedding.map(|(choice, _)| choice.dimension)),
            Self::RecurrencePeriod { s, kind } => {
                Comparison::of_points(milliseconds(s), points, |response| {
                    let found = response.recurrence_periods.last(kind);
                    let found = found.map(|found| found.period);
                    let is_so = found.is_some_and(|period| is_near(period, s, within));
                    Some((is_so, listed(found.map(milliseconds).into_iter(), "none")))
                })
            }
            Self::NoRecurrencePeriod {} => Comparison::of_points("none", points, |response| {
                let found = &response.recurrence_periods.0;
                let shown = found.iter().map(|found| milliseconds(found.period));
                Some((found.is_empty(), listed(shown, "none")))
            }),
            Self::Section(ref form) => Comparison::of_points(form, points, |response| {
                let found = section_form(response).unwrap_or(NOTHING);
                Some((found == form, found.to_owned()))
            }),
            Self::ExponentZero {} => Comparison::of_points("nearly zero", points, |response| {
                let largest = largest(response)?;
                let is_so = largest.low() > -NEARLY_ZERO && largest.high() < NEARLY_ZERO;
                Some((is_so, shown(largest)))
            }),
            Self::ExponentsPositive(count) => exponents_positive(count, points),
            Self::Order(ref regimes) => order(regimes, points),
            Self::BaseFrequencies(counts) => base_frequencies(counts, points),
        }
    }
}

/// The regime of a response: chaotic if its largest exponent is positive, which is surer than the classification of its
/// signal.
fn regime(response: &SettledResponse) -> Regime {
    if sign(response, 0) == Some(Sign::Positive) {
        Regime::Chaotic
    } else {
        response.regime
    }
}

/// Whether a frequency is a multiple of another one, within a relative tolerance.
fn is_multiple(hz: f64, of: f64, within: f64) -> bool {
    let ratio = hz / of;
    ratio > 0.5 && (ratio / ratio.round() - 1.0).abs() <= within
}

/// Relative tolerance of a multiple of a measured line.
const MULTIPLE: f64 = 2e-3;

fn nearly_periodic(share: f64, points: &Points<'_>) -> Comparison {
    let expected = format!("other lines below {:.0} %", 100.0 * share);
    Comparison::of_points(expected, points, |response| {
        let Some(strongest) = response.lines.first() else {
            return Some((false, "no lines".to_owned()));
        };
        let others = response.lines.iter();
        let others = others.filter(|l| !is_multiple(l.frequency, strongest.frequency, MULTIPLE));
        let largest = others
            .map(|l| l.amplitude / strongest.amplitude)
            .fold(0.0, f64::max);
        let is_regular = matches!(response.regime, Regime::Periodic | Regime::QuasiPeriodic);
        let (regime, percent) = (response.regime, 100.0 * largest);
        let measured = format!("{regime}, other lines at {percent:.0} %");
        Some((is_regular && largest < share, measured))
    })
}

/// Frequencies of the lines that count, Hz: among many weak lines, one is close to any frequency.
fn strong_lines(response: &SettledResponse) -> Vec<f64> {
    let strongest = response.lines.first().map_or(0.0, |line| line.amplitude);
    let lines = response.lines.iter();
    let lines = lines.filter(|line| line.amplitude >= MIN_LINE_AMPLITUDE * strongest);
    lines.map(|line| line.frequency).collect()
}

/// Frequencies of the lines that count and are no harmonics of other such lines, Hz.
fn independent_lines(response: &SettledResponse) -> Vec<f64> {
    let lines = strong_lines(response);
    let is_multiple = |hz: f64, of: f64| of < 0.75 * hz && is_multiple(hz, of, MULTIPLE);
    let is_harmonic = |hz: f64| lines.iter().any(|of| is_multiple(hz, *of));
    let independent = lines.iter().copied().filter(|hz| !is_harmonic(*hz));
    independent.collect()
}

/// The line nearest to a frequency.
fn nearest(lines: &[f64], hz: f64) -> Option<f64> {
    let off = |line: f64| (line - hz).abs();
    let lines = lines.iter().copied();
    lines.min_by(|a, b| off(*a).total_cmp(&off(*b)))
}

/// The line at a combination of the lines nearest to two base frequencies, Hz.
fn combination(response: &SettledResponse, base_hz: [f64; 2], orders: [i32; 2]) -> Option<f64> {
    let all: Vec<f64> = response.lines.iter().map(|line| line.frequency).collect();
    let strong = strong_lines(response);
    // The bases are those of the claim, not any lines.
    let base = |hz: f64| nearest(&strong, hz).filter(|line| is_near(*line, hz, BASE));
    let [first, second] = [base(base_hz[0])?, base(base_hz[1])?];
    let sum = (f64::from(orders[0]) * first + f64::from(orders[1]) * second).abs();
    nearest(&all, sum).filter(|line| (line - sum).abs() <= MULTIPLE * second)
}

/// Relative tolerance of the base frequencies of a combination.
const BASE: f64 = 0.015;

fn harmonics(hz: f64, within: f64, points: &Points<'_>) -> Comparison {
    Comparison::of_points(format!("multiples of {}", khz(hz)), points, |response| {
        let lines = strong_lines(response);
        let others = lines.iter().filter(|&&it| !is_multiple(it, hz, within));
        let others = others.count();
        let measured = match others {
            0 => format!("{} multiples", lines.len()),
            others => format!("{others} of {} lines are no multiples", lines.len()),
        };
        Some((others == 0 && lines.len() > 1, measured))
    })
}

fn same_lines(
    response: Option<&SettledResponse>,
    model: Option<&SettledResponse>,
    count: usize,
    within: f64,
) -> Comparison {
    let expected = model.into_iter().flat_map(|model| &model.lines);
    let expected = expected.take(count).map(|line| line.frequency);
    let expected: Vec<f64> = expected.collect();
    let found = response.filter(|_| model.is_some()).map(|response| {
        let lines = strong_lines(response);
        let same = |hz: &f64| nearest(&lines, *hz).filter(|line| is_near(*line, *hz, within));
        expected.iter().filter_map(same).collect::<Vec<_>>()
    });
    let list = |lines: &[f64]| listed(lines.iter().map(|hz| khz(*hz)), NOTHING);
    let verdict = Verdict::when(found.as_ref(), |found| found.len() == count);
    Comparison::new(list(&expected), found.as_deref().map(list), verdict)
}

fn dimension(is: usize, found: Option<usize>) -> Comparison {
    let verdict = Verdict::when(found, |dimension| dimension == is);
    Comparison::new(is, found.map(|dimension| dimension.to_string()), verdict)
}

/// Whether most unstable modes have no line near their frequency.
fn linear_mismatch(points: &Points<'_>, within: f64) -> Comparison {
    Comparison::of_points("most unstable modes silent", points, |response| {
        let lines = independent_lines(response);
        let modes = response.linear.as_ref().map_or_else(Vec::new, |linear| {
            linear.unstable().map(|mode| mode.frequency_hz).collect()
        });
        let is_silent =
            |hz: &&f64| nearest(&lines, **hz).is_none_or(|line| !is_near(line, **hz, within));
        let silent = modes.iter().filter(is_silent).count();
        let measured = format!("{silent} of {} unstable modes without a line", modes.len());
        Some((2 * silent > modes.len(), measured))
    })
}

fn milliseconds(period: f64) -> String {
    format!("{:.3} ms", 1e3 * period)
}

/// Form of the Poincare section of a response; `None` if it has too few points.
fn section_form(response: &SettledResponse) -> Option<&'static str> {
    let points: Vec<&[f64]> = response.section_m.iter().map(|point| &point[..]).collect();
    match section_shape(&points, 2.0 * response.amplitude_m) {
        SectionShape::TooFew => None,
        SectionShape::Points(_) => Some("points"),
        _ => Some(match response.curves {
            Some(curves) if curves.count == 1 => "circle",
            _ => "scattered",
        }),
    }
}

fn exponents_positive(count: usize, points: &Points<'_>) -> Comparison {
    let expected = match count {
        1 => "positive".to_owned(),
        count => format!("{count} positive"),
    };
    Comparison::of_points(expected, points, |response| {
        let is_so = (0..count).all(|k| sign(response, k) == Some(Sign::Positive));
        Some((is_so, shown(largest(response)?)))
    })
}

/// Compares the regimes along the tilt with an order, which holds if each regime occurs and none returns
/// after a later one. If the motion begins and ends as claimed, the claim holds in part: the share is the
/// length of the longest subsequence of tilts in that order relative to all tilts.
fn order(regimes: &[String], points: &Points<'_>) -> Comparison {
    let seen: Vec<String> = points.iter().map(|(_, r)| regime(r).to_string()).collect();
    let mut successive = seen.clone();
    successive.dedup();
    let has_ends = seen.first() == regimes.first() && seen.last() == regimes.last();
    let holding = if has_ends && regimes.iter().all(|regime| seen.contains(regime)) {
        longest_in_order(regimes, &seen)
    } else {
        0
    };
    let measured = (!seen.is_empty()).then(|| successive.join(", "));
    let verdict = Verdict::of(holding, seen.len());
    Comparison::new(regimes.join(", then "), measured, verdict)
}

/// Length of the longest subsequence whose regimes never go backwards in an order, by dynamic programming.
fn longest_in_order(regimes: &[String], seen: &[String]) -> usize {
    let mut best = vec![0; regimes.len()];
    for regime in seen {
        let Some(place) = regimes.iter().position(|r| r == regime) else {
            continue;
        };
        let before = best[..=place].iter().copied().max().unwrap_or(0);
        best[place] = before + 1;
    }
    best.into_iter().max().unwrap_or(0)
}

/// Compares the number of base frequencies of each point with that of its regime; points of other regimes do
/// not count.
fn base_frequencies(
    [periodic, quasi_periodic, chaotic]: [usize; 3],
    points: &Points<'_>,
) -> Comparison {
    let expected = format!("{periodic}, {quasi_periodic}, {chaotic}");
    Comparison::of_points(expected, points, |response| {
        let expected = match response.regime {
            Regime::Periodic => periodic,
            Regime::QuasiPeriodic => quasi_periodic,
            Regime::Chaotic => chaotic,
            _ => return None,
        };
        let is_named = |base: &&str| response.lines.iter().any(|line| line.label.contains(base));
        let found = ["f1", "f2"].iter().filter(|base| is_named(base)).count();
        let measured = format!("{} with {found}", response.regime);
        Some((found == expected, measured))
    })
}

fn sign(response: &SettledResponse, k: usize) -> Option<Sign> {
    let spectrum = response.exponents.as_ref()?;
    (k < spectrum.exponents.len()).then(|| spectrum.sign(k))
}

fn largest(response: &SettledResponse) -> Option<Exponent> {
    response.exponents.as_ref()?.exponents.first().copied()
}

fn shown(exponent: Exponent) -> String {
    Measured::from(&exponent).unit("1/s").to_string()
}
