//! Every number of a report is a number of its JSON: what a test of a result calls.

use serde_json::Value;

use super::{Report, markdown};

/// Factors between the unit of JSON and a printed one: prefixes, percent, degrees.
const FACTORS: [f64; 8] = [
    1.0,
    1e3,
    1e6,
    1e9,
    1e-3,
    100.0,
    180.0 / std::f64::consts::PI,
    1e-6,
];

/// Checks the report of a result with few numbers. Counts are lengths of lists; `constants` are those of the texts.
pub fn check(result: &dyn Report, constants: &[f64]) {
    let json = serde_json::to_value(result).expect("JSON");
    let mut known = constants.to_vec();
    collect(&json, &mut known);
    let text = markdown(&result.blocks("a scene"));
    for (token, printed) in numbers(&text) {
        let (digits, power) = token.split_once('e').unwrap_or((token, "0"));
        let decimals = digits
            .split_once('.')
            .map_or(0, |(_, decimals)| decimals.len()) as i32;
        // Large half-widths round to tens.
        let whole = digits.len() - digits.trim_end_matches('0').len();
        let zeros = if decimals == 0 {
            whole.min(2) as i32
        } else {
            0
        };
        let power: i32 = power.parse().expect("an exponent");
        let half = 0.5001 * 10_f64.powi(zeros - decimals + power);
        let agrees = known
            .iter()
            // A frequency may be printed for a period.
            .flat_map(|x| [*x, 1.0 / x])
            .flat_map(|x| FACTORS.map(|factor| (factor * x).abs()))
            .any(|x| (x - printed).abs() <= half);
        assert!(
            agrees,
            "{token} is no number of the result:\n{text}\n{json:#}"
        );
    }
}

/// The numbers in a text.
fn numbers(text: &str) -> impl Iterator<Item = (&str, f64)> {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-' | '+');
    let tokens = text.split(move |c: char| !is_part(c));
    let tokens = tokens.map(|token| token.trim_matches(['-', '.', '+', 'e']));
    tokens.filter_map(|token| Some((token, token.parse().ok()?)))
}

/// The numbers of a value, and the lengths of its lists.
fn collect(value: &Value, known: &mut Vec<f64>) {
    match value {
        Value::Number(number) => known.extend(number.as_f64()),
        Value::Array(items) => {
            known.push(items.len() as f64);
            items.iter().for_each(|item| collect(item, known));
        }
        Value::Object(fields) => fields.values().for_each(|field| collect(field, known)),
        Value::String(text) => {
            known.extend(numbers(text).map(|(_, number)| number));
        }
        Value::Null | Value::Bool(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use serde::Serialize;

    use super::*;
    use crate::report::Block;

    #[derive(Serialize)]
    struct Found {
        frequency_hz: f64,
        #[serde(skip)]
        shown: f64,
    }

    impl Report for Found {
        fn blocks(&self, _name: &str) -> Vec<Block> {
            vec![Block::text(format!("{:.1} Hz", self.shown))]
        }
    }

    #[test]
    fn a_number_that_json_does_not_have_is_found() {
        let found = |shown| Found {
            frequency_hz: 4117.26,
            shown,
        };
        check(&found(4117.3), &[]);
        check(&found(4.1), &[]);
        let other = std::panic::catch_unwind(|| check(&found(4117.4), &[]));
        assert!(other.is_err());
    }
}
