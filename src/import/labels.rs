//! Labels of Audacity.

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::events::Span;

/// A label of Audacity: an interval, perhaps with a range of frequencies.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Label {
    /// Where the label lies, s.
    #[serde(flatten)]
    pub span: Span,
    /// Range of frequencies, Hz; `None` without a spectral selection.
    pub range_hz: Option<[f64; 2]>,
    /// Text of the label.
    pub text: String,
}

/// A line of a label file that is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "line {0} is no label of Audacity: start, end and text, separated by tabs; export the labels again"
)]
pub struct LabelError(pub usize);

impl Label {
    /// Reads the labels of a file: a line with start, end and text, separated by tabs, and a line with `\` and the range
    /// of frequencies for a spectral selection.
    ///
    /// # Errors
    /// [`LabelError`] with the number of the line.
    pub fn parse(text: &str) -> Result<Vec<Self>, LabelError> {
        let mut labels: Vec<Self> = Vec::new();
        for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let fields: Vec<&str> = line.split('\t').map(str::trim).collect();
            let value = |k: usize| fields.get(k)?.replace(',', ".").parse::<f64>().ok();
            let pair = |k| value(k).zip(value(k + 1)).filter(|(low, high)| low <= high);
            if let ["\\", ..] = fields[..]
                && let (Some(label), Some((low, high))) = (labels.last_mut(), pair(1))
            {
                // A range that is open has a negative end.
                label.range_hz = (low > 0.0).then_some([low, high]);
            } else if let Some((start_s, end_s)) = pair(0) {
                labels.push(Self {
                    span: Span { start_s, end_s },
                    range_hz: None,
                    text: fields[2..].join(" "),
                });
            } else if !line.trim().is_empty() {
                return Err(LabelError(number));
            }
        }
        Ok(labels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_no_label_is_named() {
        for text in ["start\tend\tlabel", "3\t2\tback", "0\t1\n\\\t300"] {
            let line = text.lines().count();
            assert_eq!(Label::parse(text), Err(LabelError(line)), "{text}");
        }
    }
}
