//! What each sign speaks for, how strongly, and in which words.

use super::neighbourhood::Foretold;
use super::signs::{Signs, Tones, Trend};
use super::{Evidence, Regime};
use crate::analysis::SectionShape;

use Regime::{Chaotic, Noise, Periodic, QuasiPeriodic, Transient};

/// A weight: `full` at one limit and beyond, 0 at the other, straight between.
struct Ramp {
    none: f64,
    all: f64,
    full: f64,
}

impl Ramp {
    fn at(&self, value: f64) -> f64 {
        let part = (value - self.none) / (self.all - self.none);
        self.full * part.clamp(0.0, 1.0)
    }
}

const fn ramp(none: f64, all: f64, full: f64) -> Ramp {
    Ramp { none, all, full }
}

/// Turns in the record; below the first limit nothing is believed.
const TURNS: Ramp = ramp(10.0, 40.0, 1.0);

/// Change of the envelope, natural logarithm, over the record.
const ENVELOPE: Ramp = ramp(0.08, 0.3, 0.95);
const ENVELOPE_CLARITY: Ramp = ramp(3.0, 6.0, 1.0);
/// A change so large that it need not be straight.
const LARGE_CHANGE: Ramp = ramp(1.0, 2.0, 1.0);

/// Natural logarithm of the level of the loudest eighth of the record over that of the faintest.
const UNEVEN: Ramp = ramp(1.0, 2.0, 0.95);

/// Change of the period, natural logarithm, over the record.
const TEMPO: Ramp = ramp(0.01, 0.04, 0.95);
const TEMPO_CLARITY: Ramp = ramp(5.0, 12.0, 1.0);

/// A section of so many points, a loop, an arc.
const POINTS: f64 = 0.7;
const ARC: f64 = 0.2;

/// Passages on a loop: a few may lie on one by chance.
const LOOP: Ramp = ramp(24.0, 80.0, 0.8);

/// Passages a period apart, over what noise explains: they are the same, they are not.
const REPEATED: Ramp = ramp(2.0, 1.2, 0.6);
const NOT_REPEATED: Ramp = ramp(3.0, 6.0, 0.7);

/// Lines that read clearly, and lines that leave something open.
const CLEAR_LINES: f64 = 0.6;
const LESS_CLEAR_LINES: f64 = 0.55;

/// A line that is no harmonic is a second tone if it has this share of the strongest.
const SECOND: f64 = 0.025;

/// Lines are read as tones where the floor is no broader than noise explains (the ratio of
/// [`Signs::lawful_floor`]; the part that is not white), where the record is long enough to part
/// neighbouring ones, and where the signal is foretold.
const LINES_FLOOR: Ramp = ramp(4.0, 1.2, 1.0);
const LINES_COLOURED: Ramp = ramp(3e-4, 7e-5, 1.0);
const LINES_TURNS: Ramp = ramp(30.0, 80.0, 1.0);
const LINES_FORETOLD: Ramp = ramp(0.4, 0.2, 1.0);

/// Common logarithm of the share of the power in the floor.
const NO_FLOOR: Ramp = ramp(-3.0, -6.0, 0.7);

/// Common logarithm of the share of the power in the part of the floor that is not white.
const COLOURED: Ramp = ramp(-3.6, -2.6, 0.8);

/// Natural logarithm of the floor over what noise explains, of a signal that is foretold.
const LAWFUL_FLOOR: Ramp = ramp(2.08, 3.91, 0.8);
const FORETOLD: Ramp = ramp(0.5, 0.3, 1.0);

/// Growth of the error of prediction from a lag to ten turns: it does not, it does.
const STEADY: Ramp = ramp(3.0, 1.5, 0.7);
const STEADY_ERROR: Ramp = ramp(0.8, 0.4, 1.0);
const PARTING: Ramp = ramp(4.0, 10.0, 0.7);

/// Natural logarithm of the factor by which neighbours still part after the first thirtieth of
/// the record.
const SLOW_PARTING: f64 = 0.8;
const PARTED: Ramp = ramp(0.25, 0.5, 1.0);

/// Natural logarithm of the distance to the nearest state far in time over that to the nearest,
/// beyond which it may be the motion itself that changes, and not its states that part.
const WANDERS: f64 = 0.6;

/// Error of prediction by the neighbour over that by a linear map: a bent law shows below, and
/// noise, whatever its colour, above.
const BENT: Ramp = ramp(0.7, 0.3, 1.0);
const NOT_BENT: Ramp = ramp(0.8, 0.95, 1.0);

/// Error of prediction a lag and ten turns ahead of what is noise.
const NOISE_NEAR: Ramp = ramp(0.15, 0.4, 0.9);
const NOISE_FAR: Ramp = ramp(0.6, 0.9, 1.0);

/// States among which neighbours were looked for: where they are few, none is near, and chaos
/// looks like noise.
const NOISE_STATES: Ramp = ramp(500.0, 2000.0, 1.0);

/// 0-1 test. Weak chaos gives little, which is why a small value says little.
const REGULAR_K: Ramp = ramp(0.4, 0.1, 0.3);
const IRREGULAR_K: Ramp = ramp(0.6, 0.9, 0.5);
const K_SAMPLES: Ramp = ramp(200.0, 1000.0, 1.0);

/// Exponent over its error.
const EXPONENT: Ramp = ramp(3.0, 8.0, 0.6);

/// Weights below this are not worth a sentence.
const LEAST: f64 = 0.005;

/// All evidence, strongest first.
///
/// Signs other than the two of change suppose a motion that lasts; they count for less, the more
/// the record changes, and all count for less in a record of few turns.
pub(super) fn evidence(signs: &Signs) -> Vec<Evidence> {
    let reliable = TURNS.at(signs.turns);
    let mut all = change(signs);
    let lasting: f64 = all.iter().map(|e| 1.0 - e.weight).product();
    let mut rest = lines(signs);
    rest.extend(section(signs));
    rest.extend(repetition(signs));
    rest.extend(prediction(signs));
    rest.extend(chaos_tests(signs));
    for evidence in &mut rest {
        evidence.weight *= lasting;
    }
    all.extend(rest);
    for evidence in &mut all {
        evidence.weight *= reliable;
    }
    if reliable < 1.0 {
        all.push(Evidence::new(
            "length of the record",
            signs.turns,
            &[Regime::Unsure],
            1.0 - reliable,
            format!(
                "The record holds {:.0} turns; {:.0} are wanted.",
                signs.turns, TURNS.all
            ),
        ));
    }
    all.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    let telling = all.iter().take_while(|e| e.weight >= LEAST).count();
    all.truncate(telling.max(1));
    all
}

/// A frequency to four digits, Hz.
fn hertz(frequency: f64) -> String {
    let decimals = (3.0 - frequency.max(1e-12).log10().floor()).clamp(0.0, 12.0);
    format!("{frequency:.*} Hz", decimals as usize)
}

/// Does it still change?
fn change(signs: &Signs) -> Vec<Evidence> {
    let envelope = |trend: Trend, size: f64| {
        Evidence::new(
            "envelope",
            trend.change,
            &[Transient],
            ENVELOPE.at(size)
                * ENVELOPE_CLARITY
                    .at(trend.clarity)
                    .max(LARGE_CHANGE.at(size)),
            format!(
                "The level {} by a factor of {:.2} over the record.",
                if trend.change < 0.0 { "falls" } else { "rises" },
                trend.change.abs().exp()
            ),
        )
    };
    let tempo = |trend: Trend| {
        Evidence::new(
            "tempo",
            trend.change,
            &[Transient],
            TEMPO.at(trend.change.abs()) * TEMPO_CLARITY.at(trend.clarity),
            format!(
                "The time of a turn {} by {:.1} % over the record.",
                if trend.change < 0.0 { "falls" } else { "rises" },
                100.0 * trend.change.exp_m1().abs()
            ),
        )
    };
    let uneven = Evidence::new(
        "evenness",
        signs.unevenness,
        &[Transient],
        UNEVEN.at(signs.unevenness),
        format!(
            "One eighth of the record is {:.1} times as loud as another.",
            signs.unevenness.exp()
        ),
    );
    let mut all = vec![
        envelope(signs.envelope, signs.envelope.change.abs()),
        uneven,
    ];
    all.extend(signs.tempo.map(tempo));
    all
}

/// Which tones are in it, and what lies between them?
fn lines(signs: &Signs) -> Vec<Evidence> {
    tones(signs).into_iter().chain(floor(signs)).collect()
}

fn tones(signs: &Signs) -> Option<Evidence> {
    let trusted = LINES_FLOOR.at(signs.lawful_floor())
        * LINES_COLOURED.at(signs.coloured)
        * (1.0 - parts_slowly(signs))
        * LINES_TURNS.at(signs.turns)
        * LINES_FORETOLD.at(signs.foretold.near);
    let reading = |value, says, weight, words| {
        Evidence::new("spectral lines", value, says, weight * trusted, words)
    };
    match signs.tones {
        Tones::None => None,
        Tones::One { f1, stray } if stray < SECOND => Some(reading(
            f1,
            &[Periodic],
            if stray == 0.0 {
                CLEAR_LINES
            } else {
                LESS_CLEAR_LINES
            },
            format!("The lines are harmonics of {}.", hertz(f1)),
        )),
        Tones::One { f1, stray } => Some(reading(
            f1,
            &[QuasiPeriodic],
            LESS_CLEAR_LINES,
            format!(
                "A line of {:.1} % of the strongest is no harmonic of {}.",
                100.0 * stray,
                hertz(f1)
            ),
        )),
        Tones::Two { f1, second, .. } if second < SECOND => Some(reading(
            f1,
            &[Periodic],
            LESS_CLEAR_LINES,
            format!(
                "The lines are harmonics of {}; a second tone has {:.2} % of the first.",
                hertz(f1),
                100.0 * second
            ),
        )),
        Tones::Two { f1, f2, .. } => Some(reading(
            f2 / f1,
            &[QuasiPeriodic],
            CLEAR_LINES,
            format!(
                "The lines are combinations of {} and {}, not in step.",
                hertz(f1),
                hertz(f2)
            ),
        )),
        Tones::InStep { f1, p, q } => Some(reading(
            f64::from(p) / f64::from(q),
            &[Periodic],
            LESS_CLEAR_LINES,
            format!(
                "The lines are combinations of {} and {p}/{q} of it.",
                hertz(f1)
            ),
        )),
        Tones::Many(count) => Some(reading(
            count as f64,
            &[QuasiPeriodic],
            LESS_CLEAR_LINES,
            format!("{count} lines are combinations of neither one tone nor two."),
        )),
    }
}

/// The power between the lines.
fn floor(signs: &Signs) -> [Evidence; 3] {
    let percent = 100.0 * signs.floor;
    let no_floor = Evidence::new(
        "floor",
        signs.floor,
        &[Periodic, QuasiPeriodic],
        NO_FLOOR.at(signs.floor.max(1e-30).log10()),
        format!("Only {percent:.1e} % of the power lies between the lines."),
    );
    let coloured = Evidence::new(
        "coloured floor",
        signs.coloured,
        // Coloured noise is foretold by a linear map as well as it can be.
        if BENT.at(signs.against_linear()) > 0.5 {
            &[Chaotic]
        } else {
            &[Chaotic, Noise]
        },
        COLOURED.at(signs.coloured.max(1e-30).log10()),
        format!(
            "{:.3} % of the power lies between the lines and is not white.",
            100.0 * signs.coloured
        ),
    );
    let ratio = signs.lawful_floor();
    let lawful = Evidence::new(
        "lawful floor",
        ratio,
        &[Chaotic],
        LAWFUL_FLOOR.at(ratio.max(1.0).ln()) * FORETOLD.at(signs.foretold.near),
        format!(
            "{percent:.2} % of the power lies between the lines, {ratio:.0} times what noise \
             would leave unforetold."
        ),
    );
    [no_floor, coloured, lawful]
}

/// Where does it come back to?
fn section(signs: &Signs) -> Option<Evidence> {
    let passages = signs.passages;
    let shape = |value, says, weight, words| {
        Some(Evidence::new(
            "Poincare section",
            value,
            says,
            weight,
            words,
        ))
    };
    match signs.section {
        SectionShape::Points(count) => shape(
            count as f64,
            &[Periodic],
            POINTS,
            match count {
                1 => format!("The section is one point in {passages} passages."),
                _ => format!("The section is {count} points in {passages} passages."),
            },
        ),
        SectionShape::Loop => shape(
            passages as f64,
            &[QuasiPeriodic],
            LOOP.at(passages as f64),
            format!("The section's {passages} passages lie on a closed curve."),
        ),
        SectionShape::Arc => shape(
            passages as f64,
            &[Chaotic, QuasiPeriodic, Transient],
            ARC,
            format!("The section's {passages} passages lie on an open curve."),
        ),
        SectionShape::Cloud | SectionShape::TooFew => None,
    }
}

/// Does it repeat?
fn repetition(signs: &Signs) -> Option<Evidence> {
    let ((apart, period), ratio) = (signs.periodic?, signs.unrepeated()?);
    let (repeated, not) = (REPEATED.at(ratio), NOT_REPEATED.at(ratio));
    Some(Evidence::new(
        "repetition",
        ratio,
        if repeated > not {
            &[Periodic]
        } else {
            &[QuasiPeriodic, Chaotic, Noise, Transient]
        },
        repeated.max(not) * LINES_FORETOLD.at(signs.foretold.near),
        format!(
            "Passages {} apart differ by {:.2} % of the deviation, {ratio:.1} times what noise \
             explains.",
            if period == 1 {
                "1 or more".to_owned()
            } else {
                format!("{period}, {}, ...", 2 * period)
            },
            100.0 * apart
        ),
    ))
}

/// To what degree neighbours part, 0 to 1, if over many turns.
fn parts_slowly(signs: &Signs) -> f64 {
    PARTED.at(signs.parting) * BENT.at(signs.against_linear())
}

/// How well is it foretold?
fn prediction(signs: &Signs) -> [Evidence; 4] {
    let Foretold {
        map,
        near,
        linear,
        far,
    } = signs.foretold;
    let (next, later) = match map {
        true => ("next sample", "forty samples"),
        false => ("next quarter turn", "ten turns"),
    };
    let (growth, ratio) = (signs.growth(), signs.against_linear());
    [
        Evidence::new(
            "lasting prediction",
            far,
            &[Periodic, QuasiPeriodic],
            STEADY.at(growth) * STEADY_ERROR.at(far) * (1.0 - parts_slowly(signs)),
            format!(
                "States once near each other differ after {later} by {:.1} % of the \
                 deviation, {growth:.1} times as much as at first.",
                100.0 * far
            ),
        ),
        Evidence::new(
            "lost prediction",
            growth,
            &[Chaotic],
            PARTING.at(growth) * BENT.at(ratio),
            format!(
                "Neighbours foretell the {next} to {:.1} % of the deviation, {later} to {:.0} %.",
                100.0 * near,
                100.0 * far
            ),
        ),
        Evidence::new(
            "slow parting",
            signs.parting,
            if signs.wandering > WANDERS {
                &[Chaotic, Transient]
            } else {
                &[Chaotic]
            },
            SLOW_PARTING * parts_slowly(signs),
            format!(
                "From a thirtieth to a quarter of the record on, neighbours part by a factor of \
                 {:.2}.",
                signs.parting.exp()
            ),
        ),
        Evidence::new(
            "no prediction",
            ratio,
            &[Noise],
            NOISE_NEAR.at(near)
                * NOISE_FAR.at(far)
                * NOT_BENT.at(ratio)
                * NOISE_STATES.at(signs.states as f64),
            format!(
                "Neighbours foretell the {next} to {:.0} % of the deviation, no better \
                 than a linear map does, to {:.0} %.",
                100.0 * near,
                100.0 * linear
            ),
        ),
    ]
}

/// Does it drive a point adrift, do neighbours part at a rate?
fn chaos_tests(signs: &Signs) -> Vec<Evidence> {
    let drift = signs.drift.map(|(k, samples)| {
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
            format!("The 0-1 test gives {k:.2}: 0 is regular, 1 is chaos or noise."),
        )
    });
    let exponent = signs.exponent.map(|[rate, error]| {
        Evidence::new(
            "exponent",
            rate,
            &[Chaotic],
            EXPONENT.at(rate / error.max(1e-9 * rate.abs())) * BENT.at(signs.against_linear()),
            format!("Neighbours part by exp({rate:.2} +- {error:.2}) a turn."),
        )
    });
    drift.into_iter().chain(exponent).collect()
}
