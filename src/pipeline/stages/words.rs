//! The words themselves: short Markdown that can be read aloud to people new to the matter.

use std::f64::consts::LN_2;

use super::narrator::{Circumstances, Face, Observation};
use super::{Reading, half_range, peak_magnitude};
use crate::analysis::{Bases, Combination};
use crate::dynamics::{Attractor, Exponent, Motion, Sign, Stability};
use crate::pipeline::message::{Exponents, Parting, PartingLine};
use crate::scene::ButterflySpec;

/// How many lines are spelled out.
const SPELLED: usize = 4;

/// A heading, what is seen, and how large it is.
pub fn describe(face: Face, seen: &Observation<'_>) -> String {
    let heading = match face {
        Face::Silent => "Silent",
        Face::Growing => "A vibration is growing",
        Face::Fading => "The vibration is fading",
        Face::Settling => "The vibration settles",
        Face::Tone => "Looks like a pure tone",
        Face::TwoTones => "Looks like two tones",
        Face::Broad => "Lines over a broad floor: looks like chaos",
        Face::Unsettled => "No simple pattern",
    };
    let reading = seen.reading;
    let body = match (face, reading.naming.bases) {
        (Face::Silent, _) => {
            "The ball slides steadily; there is hardly anything to hear.".to_owned()
        }
        (Face::Growing, _) => envelope(seen, "doubles"),
        (Face::Fading, _) => envelope(seen, "halves"),
        (Face::Settling, _) => settling(reading),
        (Face::Broad, _) => broad(reading),
        (Face::Tone, Bases::One { f1 } | Bases::Two { f1, .. }) => tone(f1, reading),
        (Face::TwoTones, Bases::Two { f1, f2 }) => two_tones(f1, f2, reading),
        (Face::Tone | Face::TwoTones | Face::Unsettled, _) => unsettled(reading),
    };
    let size = size(face, seen);
    let now = circumstances(&seen.now);
    format!("## {heading}\n\n{body}\n\n{size}\n\n{now}")
}

/// The verdict of the exponents at the end of a run.
pub fn exponents(last: &Exponents) -> String {
    let spectrum = &last.spectrum;
    let told = spectrum.exponents.iter().take(SPELLED).enumerate();
    let told: Vec<String> = told
        .map(|(k, exponent)| format!("λ{} = {}", k + 1, with_error(exponent)))
        .collect();
    let largest = spectrum.exponents.first().map_or(0.0, |first| first.value);
    let others = match spectrum.dimension > spectrum.count(Sign::Zero) {
        true => "; the others are below it",
        false => "",
    };
    let meaning = match last.attractor() {
        Attractor::Equilibrium(Stability::Stable) => {
            "It does not move at all, and what comes near comes to it.".to_owned()
        }
        Attractor::Equilibrium(Stability::Unstable) => format!(
            "It does not move at all, and yet the least push would grow e-fold every **{}**.",
            rounded(1.0 / largest, 2, "s")
        ),
        Attractor::Equilibrium(Stability::Undecided) => {
            "It does not move at all; whether a push would grow is not told yet.".to_owned()
        }
        Attractor::Rest => "All are below zero: neighbours meet, at rest.".to_owned(),
        Attractor::InStep => {
            "All are below zero: neighbours meet, in step with what drives them.".to_owned()
        }
        Attractor::Cycle => format!(
            "One is zero, along the motion{others}: neighbours come to the same closed loop."
        ),
        Attractor::Torus(_) => {
            let zeros = spectrum.count(Sign::Zero);
            let are = if zeros == 1 { "is" } else { "are" };
            let driven = match last.motion {
                Motion::Driven => " (and the drive has one)",
                Motion::Free | Motion::Still => "",
            };
            format!(
                "{zeros} {are} zero, one a tone{driven}{others}: neighbours neither meet nor part."
            )
        }
        Attractor::Chaos | Attractor::HyperChaos(_) => format!(
            "Above zero: what is not known of the start grows e-fold every **{}**.",
            rounded(1.0 / largest, 2, "s")
        ),
        Attractor::Undecided => {
            "Their errors do not yet tell which are zero: a longer run would.".to_owned()
        }
    };
    format!(
        "## By its exponents: {}\n\n{} per s, over {}. {meaning}",
        last.attractor(),
        told.join(", "),
        quantity(spectrum.time, "s"),
    )
}

/// An exponent with its error, 1/s.
pub(super) fn with_error(exponent: &Exponent) -> String {
    if exponent.half_width.is_finite() {
        let digits = if exponent.half_width < 0.1 { 2 } else { 1 };
        let scale = 10f64.powi(digits);
        // What is rounded to nothing has no sign.
        let value = (scale * exponent.value).round() / scale + 0.0;
        let digits = digits as usize;
        format!("{value:.digits$} ± {:.digits$}", exponent.half_width)
    } else {
        format!("{:.1} (error not known)", exponent.value)
    }
}

/// Two copies that started almost alike have become as different as two motions can be.
pub fn parted(spec: &ButterflySpec, parting: &Parting) -> String {
    let after = parting.saturated.unwrap_or(parting.time) - parting.start;
    let rate = match parting.line.filter(PartingLine::grows) {
        Some(line) => format!(", e-fold every **{}**", rounded(1.0 / line.rate, 2, "s")),
        None => String::new(),
    };
    format!(
        "## The butterfly has beaten its wings\n\nTwo copies of the joint that differed by \
         **{:.0e}** of their motion have parted within **{}**{rate}. From here on, one tells \
         nothing of the other.",
        spec.distance,
        rounded(after, 2, "s"),
    )
}

/// The envelope is measured to a few per cent, so two digits are told.
fn envelope(seen: &Observation<'_>, step: &str) -> String {
    let time = rounded(LN_2 / seen.growth_rate.abs(), 2, "s");
    let near = match seen.reading.lines.first() {
        Some(line) => format!(", strongest near **{}**", quantity(line.frequency, "Hz")),
        None => String::new(),
    };
    format!("It {step} about every **{time}**{near}.")
}

/// Before a window without growth is long enough to tell more.
fn settling(reading: &Reading) -> String {
    format!(
        "It has stopped growing or fading and finds its lasting form. {}",
        strongest(reading)
    )
}

fn tone(f1: f64, reading: &Reading) -> String {
    let overtones = spelled(reading, |name| name.n > 1 && name.m == 0);
    let overtones = if overtones.is_empty() {
        "No overtone stands out".to_owned()
    } else {
        format!("Overtones: {overtones}")
    };
    let (tone, period) = (quantity(f1, "Hz"), quantity(1.0 / f1, "s"));
    let second = match reading.naming.bases {
        Bases::Two { f2, .. } => format!(
            " A second tone, f2 = {}, is there, but faint: {} of the first.",
            quantity(f2, "Hz"),
            percent(reading.second_tone())
        ),
        Bases::None | Bases::One { .. } => String::new(),
    };
    format!(
        "One fundamental, f1 = **{tone}**: the motion repeats about every {period}. \
         {overtones}.{second}"
    )
}

fn two_tones(f1: f64, f2: f64, reading: &Reading) -> String {
    let mut text = format!(
        "Two base frequencies, f1 = **{}** and f2 = **{}**.",
        quantity(f1, "Hz"),
        quantity(f2, "Hz")
    );
    let combinations = spelled(reading, Combination::is_mixed);
    if combinations.is_empty() {
        text += " No combination of them stands out.";
    } else {
        text += &format!(" Their combinations show: {combinations}.");
    }
    if let Some(beat) = reading.naming.bases.beat() {
        text += &format!(
            " They beat at {}, once every {}.",
            quantity(beat, "Hz"),
            quantity(1.0 / beat, "s")
        );
    }
    text + " Unless their ratio is a simple fraction, the motion never quite repeats: it winds round a torus."
}

fn broad(reading: &Reading) -> String {
    let share = percent(reading.floor);
    let lines = strongest(reading);
    format!(
        "The lines stand on a floor that holds **{share}** of the power; pure tones leave none. \
         {lines} Chaos does this; so does noise: a spectrum alone cannot tell them apart."
    )
}

fn unsettled(reading: &Reading) -> String {
    let lines = strongest(reading);
    format!(
        "{lines} They fit neither one fundamental nor two base frequencies; perhaps the motion is \
         changing just now."
    )
}

/// Tilt, and whatever else changes with time.
fn circumstances(now: &Circumstances) -> String {
    let mut text = format!("Tilt {:.1}°", now.tilt.to_degrees());
    if let Some(load) = now.load {
        text += &format!(", load {}", quantity(load, "N"));
    }
    if let Some(factor) = now.rotation_factor {
        text += &format!(", rotation {factor:.2} times that of the scene");
    }
    text + "."
}

/// How far and how fast, against the speed of sliding.
fn size(face: Face, seen: &Observation<'_>) -> String {
    let sliding_speed = seen.now.sliding_speed;
    let speed = quantity(peak_magnitude(seen.velocity), "m/s");
    if sliding_speed == 0.0 {
        return format!("The ball does not turn; the contact point moves at up to {speed}.");
    }
    let sliding = quantity(sliding_speed, "m/s");
    if face == Face::Silent {
        return format!("It moves at {speed} at most; the ball slides at {sliding}.");
    }
    // The probe's velocity counts along the sliding: slip reverses where it outruns it backwards.
    let backwards = -seen.velocity.iter().copied().fold(0.0, f64::min);
    let slip = if backwards > sliding_speed {
        "so its slip reverses"
    } else {
        "so it never slips backwards"
    };
    let swing = quantity(half_range(seen.displacement), "m");
    format!(
        "The contact point swings ±{swing}, at up to {speed}; backwards at up to {} against a \
         sliding speed of {sliding}, {slip}.",
        quantity(backwards, "m/s")
    )
}

/// The strongest lines whose names are `wanted`, such as `3 f1 (12.3 kHz)`.
fn spelled(reading: &Reading, wanted: impl Fn(Combination) -> bool) -> String {
    let named = reading.lines.iter().zip(&reading.naming.names);
    let chosen =
        named.filter_map(|(line, name)| name.filter(|&name| wanted(name)).map(|name| (line, name)));
    let texts = chosen.map(|(line, name)| format!("{name} ({})", quantity(line.frequency, "Hz")));
    texts.take(SPELLED).collect::<Vec<_>>().join(", ")
}

/// A sentence on the strongest lines.
fn strongest(reading: &Reading) -> String {
    let lines = reading.lines.iter().take(SPELLED);
    let texts: Vec<String> = lines
        .map(|line| format!("**{}**", quantity(line.frequency, "Hz")))
        .collect();
    match texts.as_slice() {
        [] => "No line stands out.".to_owned(),
        [one] => format!("One line stands out, at {one}."),
        many => format!("The strongest lines are at {}.", many.join(", ")),
    }
}

/// Three digits and an SI prefix: `4.12 kHz`, `690 nm`.
pub(super) fn quantity(value: f64, unit: &str) -> String {
    rounded(value, 3, unit)
}

/// A share in per cent, to two digits: `0.085 %`, `12 %`.
pub(super) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let magnitude = if value > 0.0 {
        value.log10().floor()
    } else {
        0.0
    };
    let decimals = (1.0 - magnitude).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$} %")
}

/// A value rounded to so many digits, with an SI prefix.
pub(super) fn rounded(value: f64, digits: usize, unit: &str) -> String {
    const PREFIXES: [&str; 8] = ["f", "p", "n", "µ", "m", "", "k", "M"];
    // The exponent is that of the rounded value: 999.9 is 1.00 k.
    let text = format!("{value:.*e}", digits - 1);
    let value = text.parse().unwrap_or(value);
    let exponent: i32 = text
        .split_once('e')
        .and_then(|(_, e)| e.parse().ok())
        .unwrap_or(0);
    let step = exponent.div_euclid(3).clamp(-5, 2);
    let decimals = (digits as i32 - 1 - (exponent - 3 * step)).clamp(0, 2) as usize;
    let scaled = value / 1000_f64.powi(step);
    let prefix = PREFIXES[(step + 5) as usize];
    format!("{scaled:.decimals$} {prefix}{unit}")
}

#[cfg(test)]
mod tests {
    use super::{Circumstances, circumstances, percent, quantity, rounded};

    #[test]
    fn what_varies_besides_the_tilt_is_told() {
        let steady = Circumstances {
            tilt: 3.04f64.to_radians(),
            load: None,
            rotation_factor: None,
            sliding_speed: 0.016,
        };
        assert_eq!(circumstances(&steady), "Tilt 3.0°.");
        let varying = Circumstances {
            load: Some(121.4),
            rotation_factor: Some(0.5),
            ..steady
        };
        let told = "Tilt 3.0°, load 121 N, rotation 0.50 times that of the scene.";
        assert_eq!(circumstances(&varying), told);
    }

    #[test]
    fn shares_have_two_digits() {
        assert_eq!(percent(0.000_85), "0.085 %");
        assert_eq!(percent(0.0231), "2.3 %");
        assert_eq!(percent(0.5), "50 %");
        assert_eq!(percent(0.0), "0.0 %");
    }

    #[test]
    fn quantities_have_three_digits_and_a_prefix() {
        assert_eq!(quantity(4117.3, "Hz"), "4.12 kHz");
        assert_eq!(quantity(240.4, "Hz"), "240 Hz");
        assert_eq!(quantity(999.9, "Hz"), "1.00 kHz");
        assert_eq!(quantity(6.9e-7, "m"), "690 nm");
        assert_eq!(quantity(0.01784, "m/s"), "17.8 mm/s");
        assert_eq!(quantity(0.0, "m/s"), "0.00 m/s");
        assert_eq!(quantity(3e-18, "m"), "0.00 fm");
        assert_eq!(quantity(-2.5e-6, "m"), "-2.50 µm");
        assert_eq!(rounded(953.4e-6, 2, "s"), "950 µs");
        assert_eq!(rounded(1.249e-3, 2, "s"), "1.2 ms");
    }
}
