//! Numbers as they stand in a sentence.

/// A value rounded to so many digits, with an SI prefix: `4.12 kHz`, `690 nm`.
pub fn quantity(value: f64, digits: usize, unit: &str) -> String {
    const PREFIXES: [&str; 8] = ["f", "p", "n", "µ", "m", "", "k", "M"];
    // The exponent is that of the rounded value: 999.9 is 1.00 k.
    let text = format!("{value:.*e}", digits - 1);
    let value = text.parse().unwrap_or(value);
    let exponent = text.split_once('e').and_then(|(_, e)| e.parse().ok());
    let exponent: i32 = exponent.unwrap_or(0);
    let step = exponent.div_euclid(3).clamp(-5, 2);
    let decimals = (digits as i32 - 1 - (exponent - 3 * step)).clamp(0, 2) as usize;
    let scaled = value / 1000_f64.powi(step);
    let prefix = PREFIXES[(step + 5) as usize];
    format!("{scaled:.decimals$} {prefix}{unit}")
}

/// A share in per cent, to two digits: `0.085 %`, `12 %`.
pub fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let magnitude = if value > 0.0 {
        value.log10().floor()
    } else {
        0.0
    };
    let decimals = (1.0 - magnitude).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$} %")
}

/// A number without a unit, to three digits where it is small, whole where it is large.
pub fn plain(x: f64) -> String {
    match x.abs() {
        100.0.. => format!("{x:.0}"),
        10.0.. => format!("{x:.1}"),
        0.1.. => format!("{x:.2}"),
        _ => format!("{x:.4}"),
    }
}

/// An angle (rad) in degrees, to a tenth.
pub fn tenths(angle: f64) -> f64 {
    (10.0 * angle.to_degrees()).round() / 10.0
}

/// A value with half the width of its 95 % interval.
pub fn with_error(value: f64, half_width: f64) -> String {
    if half_width.is_finite() {
        let digits = if half_width < 0.1 { 2 } else { 1 };
        let scale = 10f64.powi(digits);
        // What is rounded to nothing has no sign.
        let value = (scale * value).round() / scale + 0.0;
        let digits = digits as usize;
        format!("{value:.digits$} ± {half_width:.digits$}")
    } else {
        format!("{value:.1} (error not known)")
    }
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
        assert_eq!(quantity(3e-18, 3, "m"), "0.00 fm");
        assert_eq!(quantity(-2.5e-6, 3, "m"), "-2.50 µm");
        assert_eq!(quantity(953.4e-6, 2, "s"), "950 µs");
        assert_eq!(quantity(1.249e-3, 2, "s"), "1.2 ms");
    }
}
