//! Evidence from features: the supported regimes, the weight and the description.

use super::change::{Change, Changed};
use super::features::{Features, MIN_SECOND_TONE, Tones, Trend};
use super::neighbourhood::PredictionError;
use super::{BlindSpot, Evidence, Regime};
use crate::analysis::SectionShape;

use Regime::{Chaotic, Noise, Periodic, QuasiPeriodic, Transient};

/// A weight that increases linearly from 0 at the limit `zero` to `max` at the limit `full`.
struct Ramp {
    zero: f64,
    full: f64,
    max: f64,
}

impl Ramp {
    fn at(&self, value: f64) -> f64 {
        let part = (value - self.zero) / (self.full - self.zero);
        self.max * part.clamp(0.0, 1.0)
    }
}

const fn ramp(zero: f64, full: f64, max: f64) -> Ramp {
    Ramp { zero, full, max }
}

/// Number of periods in the record. Below the first limit all weights are 0.
const PERIODS: Ramp = ramp(10.0, 40.0, 1.0);

/// Change of the envelope over the record, natural logarithm.
const ENVELOPE: Ramp = ramp(0.08, 0.3, 0.95);
const ENVELOPE_SIGNIFICANCE: Ramp = ramp(3.0, 6.0, 1.0);
/// A change large enough to count without being linear.
const LARGE_CHANGE: Ramp = ramp(1.0, 2.0, 1.0);

/// Ratio of the largest to the smallest level of an eighth of the record, natural logarithm.
const LEVEL_RANGE: Ramp = ramp(1.0, 2.0, 0.95);

/// Change of the period over the record, natural logarithm.
const PERIOD_DRIFT: Ramp = ramp(0.01, 0.04, 0.95);
const PERIOD_DRIFT_SIGNIFICANCE: Ramp = ramp(5.0, 12.0, 1.0);

/// Lasting change of a level, natural logarithm.
const CHANGE: Ramp = ramp(0.1, 0.3, 0.95);
const CHANGE_SIGNIFICANCE: Ramp = ramp(8.0, 14.0, 1.0);

/// Weights of a section with points and of an arc.
const POINTS: f64 = 0.7;
const ARC: f64 = 0.2;

/// Number of crossings on a loop: a few can form a loop by chance.
const LOOP: Ramp = ramp(24.0, 80.0, 0.8);

/// Distance of crossings one period apart, over the part explained by noise: repetition, no repetition.
const REPEATED: Ramp = ramp(2.0, 1.2, 0.6);
const NOT_REPEATED: Ramp = ramp(3.0, 6.0, 0.7);

/// Weights of lines with a clear reading and of lines with an ambiguous one.
const CLEAR_LINES: f64 = 0.6;
const AMBIGUOUS_LINES: f64 = 0.55;

/// The lines count if the broadband share is explained by noise (the ratio [`Features::floor_ratio`];
/// the coloured part), if the record is long enough to separate neighbouring lines, and if the signal is
/// predictable.
const LINES_FLOOR: Ramp = ramp(4.0, 1.2, 1.0);
const LINES_COLOURED: Ramp = ramp(3e-4, 7e-5, 1.0);
const LINES_PERIODS: Ramp = ramp(30.0, 80.0, 1.0);
const LINES_PREDICTABLE: Ramp = ramp(0.4, 0.2, 1.0);

/// The broadband share supports chaos if the record is long enough to separate the lines of a torus.
const FLOOR_PERIODS: Ramp = ramp(30.0, 100.0, 1.0);

/// Decimal logarithm of the broadband share.
const NO_BROADBAND: Ramp = ramp(-3.0, -6.0, 0.7);

/// Decimal logarithm of the coloured part of the broadband share.
const COLOURED: Ramp = ramp(-3.6, -2.6, 0.8);

/// Broadband share over the value for noise, natural logarithm, of a predictable signal.
const FLOOR_RATIO: Ramp = ramp(2.08, 3.91, 0.8);
const PREDICTABLE: Ramp = ramp(0.5, 0.3, 1.0);

/// Growth of the prediction error from one lag to ten periods: none, strong.
const STEADY: Ramp = ramp(3.0, 1.5, 0.7);
const STEADY_ERROR: Ramp = ramp(0.8, 0.4, 1.0);
const ERROR_GROWTH: Ramp = ramp(4.0, 10.0, 0.7);

/// Growth of the distance of neighbours after the first 1/30 of the record, natural logarithm.
const SLOW_DIVERGENCE: f64 = 0.8;
const DIVERGED: Ramp = ramp(0.25, 0.5, 1.0);

/// Distance to the nearest state distant in time over that to the nearest state, natural logarithm.
/// Above this limit a drift of the motion can be the cause, instead of divergence.
const MAX_DRIFT: f64 = 0.6;

/// Nearest-neighbour prediction error over that of a linear map: a nonlinear signal has a small ratio,
/// noise of any colour a large one.
const NONLINEAR: Ramp = ramp(0.7, 0.3, 1.0);
const LINEAR: Ramp = ramp(0.8, 0.95, 1.0);

/// Prediction error of noise one lag and ten periods ahead.
const NOISE_SHORT: Ramp = ramp(0.15, 0.4, 0.9);
const NOISE_LONG: Ramp = ramp(0.6, 0.9, 1.0);

/// Number of states among which neighbours are searched: with few states none is close, and chaos looks
/// like noise.
const NOISE_STATES: Ramp = ramp(500.0, 2000.0, 1.0);

/// 0-1 test. Weak chaos gives a small value, too, which is why a small value has a low weight.
const REGULAR_K: Ramp = ramp(0.4, 0.1, 0.3);
const IRREGULAR_K: Ramp = ramp(0.6, 0.9, 0.5);
const K_SAMPLES: Ramp = ramp(200.0, 1000.0, 1.0);

/// Exponent over its error.
const EXPONENT: Ramp = ramp(3.0, 8.0, 0.6);

/// Evidence with a smaller weight is omitted.
const MIN_WEIGHT: f64 = 0.005;

/// All evidence, strongest first.
///
/// Features other than those of nonstationarity assume a stationary motion. Nonstationarity reduces
/// their weight, and a record of few periods reduces all weights.
pub(super) fn evidence(features: &Features) -> Vec<Evidence> {
    let reliable = PERIODS.at(features.periods_seen);
    let mut all = nonstationarity(features);
    let stationarity = stationarity(features);
    let mut rest = spectrum(features);
    rest.extend(section(features));
    rest.extend(repetition(features));
    rest.extend(prediction(features));
    rest.extend(chaos_tests(features));
    for evidence in &mut rest {
        evidence.weight *= stationarity;
    }
    all.extend(rest);
    for evidence in &mut all {
        evidence.weight *= reliable;
    }
    if reliable < 1.0 {
        all.push(Evidence::new(
            "record length",
            features.periods_seen,
            &[Regime::Undetermined],
            1.0 - reliable,
            format!(
                "The record contains {:.0} periods; {:.0} are needed.",
                features.periods_seen, PERIODS.full
            ),
        ));
    }
    all.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    let relevant = all.iter().take_while(|e| e.weight >= MIN_WEIGHT).count();
    all.truncate(relevant.max(1));
    all
}

/// Whether the record is so short that it reduces all weights.
pub(super) fn is_short(features: &Features) -> bool {
    PERIODS.at(features.periods_seen) < 1.0
}

/// The part of its weight that the evidence of stationary motion keeps, 0 to 1.
pub(super) fn stationarity(features: &Features) -> f64 {
    let nonstationary = nonstationarity(features);
    nonstationary.iter().map(|e| 1.0 - e.weight).product()
}

/// A frequency with four digits, Hz.
fn hertz(frequency: f64) -> String {
    let decimals = (3.0 - frequency.max(1e-12).log10().floor()).clamp(0.0, 12.0);
    format!("{frequency:.*} Hz", decimals as usize)
}

/// Nonstationarity of the record.
fn nonstationarity(features: &Features) -> Vec<Evidence> {
    let envelope = |trend: Trend, size: f64| {
        Evidence::new(
            "envelope",
            trend.change,
            &[Transient],
            ENVELOPE.at(size)
                * ENVELOPE_SIGNIFICANCE
                    .at(trend.significance)
                    .max(LARGE_CHANGE.at(size)),
            format!(
                "The level {} by a factor of {:.2} over the record.",
                if trend.change < 0.0 {
                    "decreases"
                } else {
                    "increases"
                },
                trend.change.abs().exp()
            ),
        )
    };
    let period_drift = |trend: Trend| {
        Evidence::new(
            "period drift",
            trend.change,
            &[Transient],
            PERIOD_DRIFT.at(trend.change.abs()) * PERIOD_DRIFT_SIGNIFICANCE.at(trend.significance),
            format!(
                "The period {} by {:.1} % over the record.",
                if trend.change < 0.0 {
                    "decreases"
                } else {
                    "increases"
                },
                100.0 * trend.change.exp_m1().abs()
            ),
        )
    };
    let levels = Evidence::new(
        "level variation",
        features.level_range,
        &[Transient],
        LEVEL_RANGE.at(features.level_range),
        format!(
            "The rms level of one eighth of the record is {:.1} times that of another.",
            features.level_range.exp()
        ),
    );
    let mut all = vec![
        envelope(features.envelope, features.envelope.change.abs()),
        levels,
    ];
    all.extend(features.period_drift.map(period_drift));
    all.extend(features.change.map(change));
    let blind = |evidence: Evidence| evidence.blind_to(BlindSpot::SlowModulation);
    all.into_iter().map(blind).collect()
}

/// A change from one motion to another.
fn change(change: Change) -> Evidence {
    let quantity = match change.of {
        Changed::Level => "rms level",
        Changed::Difference => "difference of successive periods",
    };
    Evidence::new(
        "change of motion",
        change.size,
        &[Transient],
        CHANGE.at(change.size.abs()) * CHANGE_SIGNIFICANCE.at(change.significance),
        format!(
            "At {:.0} % of the record the {quantity} changes by a factor of {:.2} and stays there.",
            100.0 * change.at,
            change.size.exp()
        ),
    )
}

/// Spectral lines and the power between them.
fn spectrum(features: &Features) -> Vec<Evidence> {
    tones(features).into_iter().chain(floor(features)).collect()
}

fn tones(features: &Features) -> Option<Evidence> {
    let reliability = LINES_FLOOR.at(features.floor_ratio())
        * LINES_COLOURED.at(features.coloured)
        * (1.0 - slow_divergence(features))
        * LINES_PERIODS.at(features.periods_seen)
        * LINES_PREDICTABLE.at(features.prediction_error.short);
    let (value, regime, weight, description) = reading(features.tones)?;
    let weight = weight * reliability;
    let evidence = Evidence::new("spectral lines", value, &[regime], weight, description);
    Some(evidence.blind_to(match regime {
        Periodic => BlindSpot::WeakSecondFrequency,
        _ => BlindSpot::WeakChaos,
    }))
}

/// The value, the supported regime, the weight and the description of the lines.
fn reading(tones: Tones) -> Option<(f64, Regime, f64, String)> {
    let unrelated_line = |unrelated: f64, relation: String| {
        let percent = 100.0 * unrelated;
        format!("A line with {percent:.1} % of the largest amplitude is not a {relation}.")
    };
    Some(match tones {
        Tones::None => return None,
        Tones::One { f1, unrelated } if unrelated < MIN_SECOND_TONE => {
            let weight = match unrelated {
                0.0 => CLEAR_LINES,
                _ => AMBIGUOUS_LINES,
            };
            let text = format!("The lines are harmonics of {}.", hertz(f1));
            (f1, Periodic, weight, text)
        }
        Tones::One { f1, unrelated } => {
            let text = unrelated_line(unrelated, format!("harmonic of {}", hertz(f1)));
            (f1, QuasiPeriodic, AMBIGUOUS_LINES, text)
        }
        Tones::Two { f1, second, .. } if second < MIN_SECOND_TONE => {
            let text = format!(
                "The lines are harmonics of {}; a second tone has {:.2} % of the amplitude of the first.",
                hertz(f1),
                100.0 * second
            );
            (f1, Periodic, AMBIGUOUS_LINES, text)
        }
        Tones::Two { f1, f2, .. } => {
            let text = format!(
                "The lines are combinations of {} and {}, which are not phase-locked.",
                hertz(f1),
                hertz(f2)
            );
            (f2 / f1, QuasiPeriodic, CLEAR_LINES, text)
        }
        Tones::PhaseLocked {
            f1,
            p,
            q,
            unrelated,
        } if unrelated >= MIN_SECOND_TONE => {
            let relation = format!("combination of {} and {p}/{q} of it", hertz(f1));
            let text = unrelated_line(unrelated, relation);
            (f1, QuasiPeriodic, AMBIGUOUS_LINES, text)
        }
        Tones::PhaseLocked { f1, p, q, .. } => {
            let text = format!(
                "The lines are combinations of {} and {p}/{q} of it (phase-locked).",
                hertz(f1)
            );
            (f64::from(p) / f64::from(q), Periodic, AMBIGUOUS_LINES, text)
        }
        Tones::Many(count) => {
            let text = format!("{count} lines fit neither one nor two base frequencies.");
            (count as f64, QuasiPeriodic, AMBIGUOUS_LINES, text)
        }
    })
}

/// The power between the lines.
fn floor(features: &Features) -> [Evidence; 3] {
    let percent = 100.0 * features.floor;
    let resolved = FLOOR_PERIODS.at(features.periods_seen);
    let no_broadband = Evidence::new(
        "broadband share",
        features.floor,
        &[Periodic, QuasiPeriodic],
        NO_BROADBAND.at(features.floor.max(1e-30).log10()),
        format!("Only {percent:.1e} % of the power is broadband."),
    )
    .blind_to(BlindSpot::WeakChaos);
    let coloured = Evidence::new(
        "coloured broadband share",
        features.coloured,
        // A linear map predicts coloured noise as well as possible.
        if NONLINEAR.at(features.relative_to_linear()) > 0.5 {
            &[Chaotic]
        } else {
            &[Chaotic, Noise]
        },
        COLOURED.at(features.coloured.max(1e-30).log10()) * resolved,
        format!(
            "{:.3} % of the power is broadband and not white.",
            100.0 * features.coloured
        ),
    )
    .blind_to(BlindSpot::UnresolvedLines);
    let ratio = features.floor_ratio();
    let deterministic = Evidence::new(
        "deterministic broadband share",
        ratio,
        &[Chaotic],
        FLOOR_RATIO.at(ratio.max(1.0).ln())
            * PREDICTABLE.at(features.prediction_error.short)
            * resolved,
        format!(
            "{percent:.2} % of the power is broadband, {ratio:.0} times as much as noise of the size \
             of the prediction error."
        ),
    )
    .blind_to(BlindSpot::UnresolvedLines);
    [no_broadband, coloured, deterministic]
}

/// Shape of the Poincare section.
fn section(features: &Features) -> Option<Evidence> {
    let crossings = features.crossings;
    let shape = |value, supports, weight, description| {
        let evidence = Evidence::new("Poincare section", value, supports, weight, description);
        Some(evidence.blind_to(BlindSpot::ThinAttractor))
    };
    match features.section {
        SectionShape::Points(count) => shape(
            count as f64,
            &[Periodic],
            POINTS,
            match count {
                1 => format!("The section has one point in {crossings} crossings."),
                _ => format!("The section has {count} points in {crossings} crossings."),
            },
        ),
        SectionShape::Loop => shape(
            crossings as f64,
            &[QuasiPeriodic],
            LOOP.at(crossings as f64),
            format!("The {crossings} crossings of the section form a closed curve."),
        ),
        SectionShape::Arc => shape(
            crossings as f64,
            &[Chaotic, QuasiPeriodic, Transient],
            ARC,
            format!("The {crossings} crossings of the section form an open curve."),
        ),
        SectionShape::Cloud | SectionShape::TooFew => None,
    }
}

/// Repetition of the crossings.
fn repetition(features: &Features) -> Option<Evidence> {
    let ((distance, period), ratio) = (features.repetition?, features.repetition_ratio()?);
    let (repeated, not) = (REPEATED.at(ratio), NOT_REPEATED.at(ratio));
    Some(Evidence::new(
        "repetition",
        ratio,
        if repeated > not {
            &[Periodic]
        } else {
            &[QuasiPeriodic, Chaotic, Noise, Transient]
        },
        repeated.max(not) * LINES_PREDICTABLE.at(features.prediction_error.short),
        format!(
            "Crossings {} apart differ by {:.2} % of the standard deviation, {ratio:.1} times as much \
             as noise or a weak second tone explains.",
            if period == 1 {
                "1 or more".to_owned()
            } else {
                format!("{period}, {}, ...", 2 * period)
            },
            100.0 * distance
        ),
    )
    .blind_to(match repeated > not {
        true => BlindSpot::WeakSecondFrequency,
        false => BlindSpot::SparseStates,
    }))
}

/// Degree of slow divergence of neighbours, 0 to 1.
fn slow_divergence(features: &Features) -> f64 {
    DIVERGED.at(features.divergence) * NONLINEAR.at(features.relative_to_linear())
}

/// Predictability.
fn prediction(features: &Features) -> [Evidence; 4] {
    let PredictionError {
        ahead,
        short,
        linear,
        long,
    } = features.prediction_error;
    let (next, later) = match ahead {
        quarter if quarter == features.lag => {
            ("a quarter period".to_owned(), "ten periods".to_owned())
        }
        1 => ("one sample".to_owned(), "40 samples".to_owned()),
        samples => (
            format!("{samples} samples"),
            format!("{} samples", 40 * samples),
        ),
    };
    let (error_growth, ratio) = (features.error_growth(), features.relative_to_linear());
    [
        Evidence::new(
            "long-term predictability",
            long,
            &[Periodic, QuasiPeriodic],
            STEADY.at(error_growth) * STEADY_ERROR.at(long) * (1.0 - slow_divergence(features)),
            format!(
                "Initially close states differ by {:.1} % of the standard deviation after {later}, \
                 {error_growth:.1} times as much as after {next}.",
                100.0 * long
            ),
        )
        .blind_to(BlindSpot::WeakChaos),
        Evidence::new(
            "loss of predictability",
            error_growth,
            &[Chaotic],
            ERROR_GROWTH.at(error_growth) * NONLINEAR.at(ratio),
            format!(
                "Nearest-neighbour prediction error: {:.1} % of the standard deviation {next} ahead, \
                 {:.0} % {later} ahead.",
                100.0 * short,
                100.0 * long
            ),
        )
        .blind_to(BlindSpot::SparseStates),
        Evidence::new(
            "slow divergence",
            features.divergence,
            if features.drift > MAX_DRIFT {
                &[Chaotic, Transient]
            } else {
                &[Chaotic]
            },
            SLOW_DIVERGENCE * slow_divergence(features),
            format!(
                "The distance of nearest neighbours grows by a factor of {:.2} between 1/30 and 1/4 of \
                 the record length.",
                features.divergence.exp()
            ),
        )
        .blind_to(BlindSpot::SlowModulation),
        Evidence::new(
            "unpredictability",
            ratio,
            &[Noise],
            NOISE_SHORT.at(short)
                * NOISE_LONG.at(long)
                * LINEAR.at(ratio)
                * NOISE_STATES.at(features.states as f64),
            format!(
                "Nearest-neighbour prediction error {next} ahead: {:.0} % of the standard deviation, no \
                 better than a linear map ({:.0} %).",
                100.0 * short,
                100.0 * linear
            ),
        )
        .blind_to(BlindSpot::SparseStates),
    ]
}

/// 0-1 test and Lyapunov exponent.
fn chaos_tests(features: &Features) -> Vec<Evidence> {
    let zero_one = features.zero_one.map(|(k, samples)| {
        let (regular, irregular) = (REGULAR_K.at(k), IRREGULAR_K.at(k));
        Evidence::new(
            "0-1 test",
            k,
            if irregular > regular {
                &[Chaotic, Noise]
            } else {
                &[Periodic, QuasiPeriodic]
            },
            irregular.max(regular) * K_SAMPLES.at(samples as f64),
            format!("The 0-1 test gives {k:.2} (0: regular, 1: chaos or noise)."),
        )
        .blind_to(match irregular > regular {
            true => BlindSpot::SlowBeat,
            false => BlindSpot::WeakChaos,
        })
    });
    let exponent = features.exponent.map(|[rate, error]| {
        Evidence::new(
            "Lyapunov exponent",
            rate,
            &[Chaotic],
            EXPONENT.at(rate / error.max(1e-9 * rate.abs()))
                * NONLINEAR.at(features.relative_to_linear()),
            format!("Neighbours diverge by a factor of exp({rate:.2} +- {error:.2}) per period."),
        )
        .blind_to(BlindSpot::SparseStates)
    });
    zero_one.into_iter().chain(exponent).collect()
}
