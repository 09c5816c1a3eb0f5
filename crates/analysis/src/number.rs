//! Formatting of numbers in sentences.

/// A number with `digits` significant digits; with a power of ten below 1e-4 and from 1e6 on.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let places = digits.saturating_sub(1);
    match value.abs().log10().floor() as i32 {
        magnitude @ -4..=5 => {
            let decimals = (places as i32 - magnitude).max(0) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.places$e}"),
    }
}
