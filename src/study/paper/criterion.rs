//! What a claim states, and its comparison with the simulation results.

use serde::Deserialize;

use super::claims::{Embedding, Evidence, Verdict};
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

/// A comparison without its claim.
pub(super) struct Comparison {
    pub expected: String,
    pub measured: String,
    pub deviation: Option<f64>,
    pub verdict: Verdict,
}

/// Some tilts in degrees with their responses.
type Points<'e> = [(f64, &'e SettledResponse)];

impl Comparison {
    /// A comparison of a value that is not a number.
    fn new(expected: impl ToString, measured: Option<String>, verdict: Verdict) -> Self {
        Self {
            expected: expected.to_string(),
            measured: measured.unwrap_or_else(nothing),
            deviation: None,
            verdict,
        }
    }

    /// Compares a frequency with a published one, Hz. Without a result the claim cannot be compared;
    /// a response without such a line does not meet it.
    fn frequency(published: f64, measured: Option<Option<f64>>, within: f64) -> Self {
        let off = |hz: f64| hz / published - 1.0;
        let verdict = Verdict::when(measured, |hz| hz.is_some_and(|hz| off(hz).abs() <= within));
        let measured = measured.flatten();
        Self {
            deviation: measured.map(off),
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

fn nothing() -> String {
    "not found".to_owned()
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
        let delay = evidence.delay.filter(|_| first.is_some());
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
            Self::Lag(samples) => lag(samples, delay),
            Self::Dimension(is) => dimension(is, delay),
            Self::RecurrencePeriod { s, kind } => recurrence_period(s, kind, within, points),
            Self::NoRecurrencePeriod {} => no_recurrence_period(points),
            Self::Section(ref form) => Comparison::of_points(form, points, |response| {
                let found = section_form(response).map_or_else(nothing, str::to_owned);
                Some((found == *form, found))
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
        let measured = format!(
            "{}, other lines at {:.0} %",
            response.regime,
            100.0 * largest
        );
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
    let is_harmonic = |hz: f64| {
        let lower = lines.iter().filter(|&&of| of < 0.75 * hz);
        lower.into_iter().any(|&of| is_multiple(hz, of, MULTIPLE))
    };
    lines
        .iter()
        .copied()
        .filter(|&hz| !is_harmonic(hz))
        .collect()
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
    let first = nearest(&strong, base_hz[0])?;
    let second = nearest(&strong, base_hz[1])?;
    // The bases are those of the claim, not any lines.
    let off = |line: f64, base: f64| (line / base - 1.0).abs();
    if off(first, base_hz[0]) > BASE || off(second, base_hz[1]) > BASE {
        return None;
    }
    let sum = f64::from(orders[0]) * first + f64::from(orders[1]) * second;
    nearest(&all, sum.abs()).filter(|line| (line - sum.abs()).abs() <= MULTIPLE * second)
}

/// Relative tolerance of the base frequencies of a combination.
const BASE: f64 = 0.015;

fn harmonics(hz: f64, within: f64, points: &Points<'_>) -> Comparison {
    Comparison::of_points(format!("multiples of {}", khz(hz)), points, |response| {
        let lines = strong_lines(response);
        let others = lines
            .iter()
            .filter(|&&line| !is_multiple(line, hz, within))
            .count();
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
    let expected = model.map(|model| {
        let lines = model.lines.iter().take(count);
        lines.map(|line| line.frequency).collect::<Vec<_>>()
    });
    let found = response.zip(expected.as_ref()).map(|(response, expected)| {
        let lines = strong_lines(response);
        expected
            .iter()
            .filter_map(|&hz| nearest(&lines, hz).filter(|line| (line / hz - 1.0).abs() <= within))
            .collect::<Vec<_>>()
    });
    let list = |lines: &Vec<f64>| match lines.len() {
        0 => nothing(),
        _ => lines
            .iter()
            .map(|&hz| khz(hz))
            .collect::<Vec<_>>()
            .join(", "),
    };
    let verdict = Verdict::when(found.as_ref(), |found| found.len() == count);
    let shown = expected.as_ref().map_or_else(nothing, list);
    Comparison::new(shown, found.as_ref().map(list), verdict)
}

/// The paper does not state the sampling interval, so the delays cannot be compared.
fn lag(samples: f64, found: Option<Embedding>) -> Comparison {
    let measured = found.map(|delay| format!("{:.0} us", 1e6 * delay.lag));
    let expected = format!("{samples} samples");
    Comparison::new(expected, measured, Verdict::NotComparable)
}

fn dimension(is: usize, found: Option<Embedding>) -> Comparison {
    let found = found.map(|delay| delay.dimension);
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
        let is_silent = |hz: &&f64| {
            let line = nearest(&lines, **hz);
            line.is_none_or(|line| (line / **hz - 1.0).abs() > within)
        };
        let silent = modes.iter().filter(is_silent).count();
        let measured = format!("{silent} of {} unstable modes without a line", modes.len());
        Some((2 * silent > modes.len(), measured))
    })
}

fn recurrence_period(
    published: f64,
    kind: RecurrenceKind,
    within: f64,
    points: &Points<'_>,
) -> Comparison {
    Comparison::of_points(milliseconds(published), points, |response| {
        let found = response
            .recurrence_periods
            .last(kind)
            .map(|found| found.period);
        let is_so = found.is_some_and(|period| (period / published - 1.0).abs() <= within);
        let text = found.map_or_else(|| "none".to_owned(), milliseconds);
        Some((is_so, text))
    })
}

fn no_recurrence_period(points: &Points<'_>) -> Comparison {
    Comparison::of_points("none", points, |response| {
        let periods: Vec<String> = response
            .recurrence_periods
            .0
            .iter()
            .map(|found| milliseconds(found.period))
            .collect();
        let text = if periods.is_empty() {
            "none".to_owned()
        } else {
            periods.join(", ")
        };
        Some((periods.is_empty(), text))
    })
}

fn milliseconds(period: f64) -> String {
    format!("{:.3} ms", 1e3 * period)
}

/// Form of the Poincare section of a response; `None` if it has too few points.
fn section_form(response: &SettledResponse) -> Option<&'static str> {
    let points: Vec<&[f64]> = response.section.iter().map(|point| &point[..]).collect();
    match section_shape(&points, 2.0 * response.amplitude) {
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
    let verdict = if seen.is_empty() {
        Verdict::NotComparable
    } else if successive == regimes {
        Verdict::Met
    } else if seen.first() == regimes.first()
        && seen.last() == regimes.last()
        && regimes.iter().all(|regime| seen.contains(regime))
    {
        Verdict::Partly {
            share: longest_in_order(regimes, &seen) as f64 / seen.len() as f64,
        }
    } else {
        Verdict::NotMet
    };
    let measured = (!seen.is_empty()).then(|| successive.join(", "));
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
        let labels = || response.lines.iter().map(|line| &*line.label);
        let bases = ["f1", "f2"].into_iter();
        let found = bases
            .filter(|base| labels().any(|label| label.contains(base)))
            .count();
        Some((
            found == expected,
            format!("{} with {found}", response.regime),
        ))
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
