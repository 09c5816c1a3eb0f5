//! Formatting of numbers for sentences, tables and labels.

pub(crate) use crate::analysis::significant;

/// An angle in degrees that gives the same radians again, if there is one.
pub(crate) fn degrees(radians: f64) -> f64 {
    let near = radians.to_degrees();
    let rounded = (1e9 * near).round() / 1e9;
    let candidates = [rounded, near, near.next_up(), near.next_down()];
    let exact = candidates.into_iter().find(|d| d.to_radians() == radians);
    exact.unwrap_or(near)
}

/// A value rounded to `digits` significant digits.
pub(crate) fn to_digits(value: f64, digits: usize) -> f64 {
    let text = format!("{value:.*e}", digits - 1);
    text.parse().unwrap_or(value)
}

/// The power of ten of a value rounded to `digits` significant digits: 999.9 with three is 1.00e3.
fn power_of_ten(value: f64, digits: usize) -> i32 {
    let text = format!("{value:.*e}", digits - 1);
    let power = text.split_once('e').and_then(|(_, e)| e.parse().ok());
    power.unwrap_or(0)
}

/// SI prefixes from 1e-12 to 1e9.
pub(crate) const PREFIXES: [&str; 8] = ["p", "n", "µ", "m", "", "k", "M", "G"];

/// The prefix of a unit for values of about this power of a thousand, and its own power.
pub(crate) fn prefix(power: i32, unit: &str) -> (i32, &'static str) {
    // Kilometres of displacement and kiloseconds are not in use.
    let is_large = ["Pa", "V", "A", "N", "Hz"].contains(&unit);
    let power = power.clamp(-4, if is_large { 2 } else { 0 });
    (power, PREFIXES[(power + 4) as usize])
}

/// A value with `digits` significant digits and an SI prefix: `4.12 kHz`, `690 nm`.
pub(crate) fn quantity(value: f64, digits: usize, unit: &str) -> String {
    let (exponent, value) = (power_of_ten(value, digits), to_digits(value, digits));
    let (power, prefix) = prefix(exponent.div_euclid(3), unit);
    // Of a value below the smallest prefix nothing remains.
    let most = digits as i32 - 1;
    let decimals = (most - (exponent - 3 * power)).clamp(0, most) as usize;
    let scaled = value / 1000_f64.powi(power);
    format!("{scaled:.decimals$} {prefix}{unit}")
}

/// A value with at most three significant digits and an SI prefix: `60 ms`, `1 µm`.
pub(crate) fn brief(value: f64, unit: &str) -> String {
    let text = quantity(value, 3, unit);
    let (digits, unit) = text.split_once(' ').unwrap_or((&text, ""));
    format!("{} {unit}", without_zeros(digits))
}

/// A number without zeros at the end of its decimals.
pub(crate) fn without_zeros(digits: &str) -> &str {
    if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        digits
    }
}

/// A share in percent with two digits: `0.085 %`, `12 %`.
pub(crate) fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let decimals = (1 - power_of_ten(value, 2)).clamp(0, 6) as usize;
    format!("{value:.decimals$} %")
}

/// A number with this many decimals, without the sign of a value that rounds to zero.
pub(crate) fn rounded(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|b| matches!(b, b'0' | b'.')) => zero.to_owned(),
        _ => text,
    }
}

/// A value with its error, usually the half-width of its 95 % interval: [`value_and_error`] in one text.
pub(crate) fn with_error(value: f64, error: f64) -> String {
    let [value, error] = value_and_error(value, error);
    match &error[..] {
        "" => value,
        "?" => format!("{value} (error unknown)"),
        error => format!("{value} ± {error}"),
    }
}

/// A number for a label: at most three significant digits, no trailing zeros.
pub(crate) fn short(value: f64) -> String {
    trimmed(value, 3)
}

/// A number with at most `digits` significant digits, without trailing zeros.
pub(crate) fn trimmed(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    match text.split_once('e') {
        Some((digits, power)) => format!("{}e{power}", without_zeros(digits)),
        None => without_zeros(&text).to_owned(),
    }
}

/// A number in the usual notation of tolerances: `1e-5`, `0.25`, `100`.
pub(crate) fn tolerance(value: f64) -> String {
    if (1e-2..1e6).contains(&value.abs()) || value == 0.0 {
        return short(value);
    }
    format!("{value:.1e}").replace(".0e", "e")
}

/// An error with two or three digits.
pub(crate) fn error(error: f64) -> String {
    match error {
        error if (1e-2..1e4).contains(&error) || error == 0.0 => short(error),
        error => format!("{error:.1e}"),
    }
}

/// A count with its noun: `1 point`, `3 points`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// A file size: `12.3 kB`, `4.5 MB`.
pub(crate) fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// A number for a table column, as [`rounded`]; empty for `None`.
pub(crate) fn fixed(value: impl Into<Option<f64>>, decimals: usize) -> String {
    value
        .into()
        .map_or_else(String::new, |value| rounded(value, decimals))
}

/// A range of values such as `100 to 150`; a single value if both ends are equal.
pub(crate) fn format_range(ends: [f64; 2], format: impl Fn(f64) -> String) -> String {
    match ends.map(format) {
        [low, high] if low == high => low,
        [low, high] => format!("{low} to {high}"),
    }
}

/// A value and its error for two columns, with two digits of the error, and with powers of ten below 1e-4 and from 1e7 on.
/// The error is `?` if unknown, and empty for minus infinity.
pub(crate) fn value_and_error(value: f64, error: f64) -> [String; 2] {
    if value == f64::NEG_INFINITY {
        return ["-inf".to_owned(), String::new()];
    }
    if !error.is_finite() {
        return [short(value), "?".to_owned()];
    }
    // The power of ten of the last digit.
    let last = if error > 0.0 {
        power_of_ten(error, 2) - 1
    } else {
        -3
    };
    let unit = 10_f64.powi(last);
    let has_power = error > 0.0 && !(1e-4..1e7).contains(&value.abs().max(error));
    let text = match value {
        value if !value.is_finite() => "?".to_owned(),
        value if has_power && value.abs() < unit => "0".to_owned(),
        value if has_power => {
            let decimals = (power_of_ten(value, 2) - last).max(0) as usize;
            format!("{value:.decimals$e}")
        }
        value if last > 0 => rounded((value / unit).round() * unit, 0),
        value => rounded(value, (-last).min(15) as usize),
    };
    let error = match error {
        error if has_power || last < -9 => format!("{error:.1e}"),
        error if last > 0 => rounded((error / unit).round() * unit, 0),
        error => rounded(error, -last as usize),
    };
    [text, error]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_two_digits() {
        assert_eq!(percent(0.000_85), "0.085 %");
        assert_eq!(percent(0.0231), "2.3 %");
        assert_eq!(percent(0.5), "50 %");
        assert_eq!(percent(0.0), "0.0 %");
    }

    #[test]
    fn quantities_have_three_digits_and_a_prefix() {
        assert_eq!(quantity(4117.3, 3, "Hz"), "4.12 kHz");
        assert_eq!(quantity(240.4, 3, "Hz"), "240 Hz");
        assert_eq!(quantity(999.9, 3, "Hz"), "1.00 kHz");
        assert_eq!(quantity(6.9e-7, 3, "m"), "690 nm");
        assert_eq!(quantity(0.01784, 3, "m/s"), "17.8 mm/s");
        assert_eq!(quantity(0.0, 3, "m/s"), "0.00 m/s");
        assert_eq!(quantity(3e-18, 3, "m"), "0.00 pm");
        assert_eq!(quantity(1500.0, 3, "s"), "1500 s");
        assert_eq!(quantity(-2.5e-6, 3, "m"), "-2.50 µm");
        assert_eq!(quantity(953.4e-6, 2, "s"), "950 µs");
        assert_eq!(quantity(1.249e-3, 2, "s"), "1.2 ms");
        assert_eq!(brief(0.06, "s"), "60 ms");
        assert_eq!(brief(1.25e-6, "m"), "1.25 µm");
        assert_eq!(brief(300.0, "Hz"), "300 Hz");
    }

    #[test]
    fn labels_have_at_most_three_digits() {
        for (x, text) in [
            (0.0, "0"),
            (0.25, "0.25"),
            (4.117, "4.12"),
            (12.0, "12"),
            (-0.5, "-0.5"),
            (1234.0, "1234"),
            (1e-5, "1e-5"),
            (-1.234e7, "-1.23e7"),
        ] {
            assert_eq!(short(x), text);
        }
        assert_eq!(significant(0.006_4, 4), "0.006400");
        assert_eq!(significant(f64::NAN, 4), "NaN");
        assert_eq!(quantity(1.234_2e-6, 4, "s"), "1.234 µs");
        assert_eq!(quantity(0.25, 4, "s"), "250.0 ms");
        assert_eq!(quantity(4104.267, 5, "Hz"), "4.1043 kHz");
        assert_eq!(size(12_345), "12.3 kB");
        assert_eq!(size(4_500_000), "4.5 MB");
        assert_eq!(fixed(None, 1), "");
        assert_eq!(fixed(2.25, 1), "2.2");
        assert_eq!(fixed(-0.004, 2), "0.00");
    }

    #[test]
    fn values_have_the_decimals_of_their_error() {
        assert_eq!(with_error(61.237, 1.25), "61.2 ± 1.2");
        assert_eq!(with_error(-1234.5, 31.0), "-1234 ± 31");
        assert_eq!(with_error(-0.01, 1.7), "0.0 ± 1.7");
        assert_eq!(with_error(-0.06, 1.7), "-0.1 ± 1.7");
        assert_eq!(with_error(1305.2, 131.0), "1310 ± 130");
        assert_eq!(with_error(2.0, 0.0996), "2.00 ± 0.10");
        assert_eq!(with_error(-0.04, 0.35), "-0.04 ± 0.35");
        assert_eq!(with_error(50.04, 0.0946), "50.040 ± 0.095");
        assert_eq!(with_error(1305.0, 13.0), "1305 ± 13");
        assert_eq!(with_error(1.0, f64::INFINITY), "1 (error unknown)");
        assert_eq!(with_error(f64::NEG_INFINITY, 0.0), "-inf");
        assert_eq!(with_error(0.25, 0.0), "0.250 ± 0.000");
        assert_eq!(with_error(-2.938, 2e-4), "-2.93800 ± 0.00020");
        assert_eq!(with_error(-344_895.6, 2200.0), "-344900 ± 2200");
        assert_eq!(with_error(1.5e8, 2500.0), "1.500000e8 ± 2.5e3");
        assert_eq!(with_error(-1.5e-9, 3.14e-13), "-1.50000e-9 ± 3.1e-13");
        assert_eq!(with_error(3e-11, 2e-8), "0 ± 2.0e-8");
        assert_eq!(with_error(2.0, 3e-11), "2.000000000000 ± 3.0e-11");
    }

    #[test]
    fn degrees_give_the_same_radians_again() {
        assert_eq!(degrees(2.5_f64.to_radians()), 2.5);
        for k in -9000..=9000 {
            let radians = (0.01 * f64::from(k)).to_radians();
            assert_eq!(degrees(radians).to_radians(), radians, "{k}");
        }
    }
}
