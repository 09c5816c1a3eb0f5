//! Results as text: a result gives its blocks, and one renderer each writes them for the terminal and in Markdown.

#[cfg(test)]
#[path = "agreement_tests.rs"]
pub mod agreement;
mod table;
#[cfg(feature = "cli")]
mod terminal;

use std::fmt::{self, Display, Formatter};

use schemars::JsonSchema;
use serde::Serialize;

use crate::dynamics::Exponent;
use crate::escape;
use crate::number::{value_and_error, with_error};

pub use table::{Table, TableOf};
#[cfg(feature = "cli")]
pub use terminal::{BAD, HEADING, WARNING, terminal};

/// A result of a study or an analysis. Its serialization is its JSON, its blocks are its text.
pub trait Report: erased_serde::Serialize {
    /// The text of the result; `name` is that of the scene or the file, for the title.
    fn blocks(&self, name: &str) -> Vec<Block>;

    /// Whether the user interrupted the computation, so that the result is only a part.
    fn is_interrupted(&self) -> bool {
        false
    }
}

erased_serde::serialize_trait_object!(Report);

/// A part of a report.
#[derive(Clone, Debug)]
pub enum Block {
    /// A title, and the rest of its line.
    Heading(String, String),
    /// A line of text.
    Text(Vec<Cell>),
    /// A table.
    Table(Table),
    /// A reason to distrust the result, with the remedy.
    Warning(String),
    /// Lines to be copied, such as those of a scene file.
    Code(String),
}

impl Block {
    /// A title, and the rest of its line: `: 3 of 11 modes`, ` of 500 states`. Control characters in either are
    /// escaped.
    pub fn heading(title: impl AsRef<str>, rest: impl AsRef<str>) -> Self {
        let [title, rest] = [title.as_ref(), rest.as_ref()].map(escape::line);
        Self::Heading(title, rest)
    }

    /// A line of text.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(vec![text.into().into()])
    }
}

/// A text with its tone.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cell {
    /// The text, without colour codes.
    pub text: String,
    /// How it is shown.
    pub tone: Tone,
}

/// How a text is shown: its colour in the terminal; bold in Markdown unless plain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// As it is.
    #[default]
    Plain,
    /// As a heading.
    Strong,
    /// Green: as expected.
    Good,
    /// Yellow: needs care.
    Doubtful,
    /// Red: unstable, failed, contrary to the expectation.
    Bad,
}

impl Tone {
    /// A text in this tone.
    pub fn cell(self, text: impl Display) -> Cell {
        Cell {
            text: text.to_string(),
            tone: self,
        }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Tone::Plain.cell(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Tone::Plain.cell(text)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    /// An empty cell for nothing.
    fn from(cell: Option<T>) -> Self {
        cell.map_or_else(Self::default, Into::into)
    }
}

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Measured {
    /// The value.
    pub value: f64,
    /// Half-width of the 95 % interval; not finite if unknown.
    pub half_width: f64,
    /// Unit of both; empty for a dimensionless number.
    #[serde(skip)]
    pub unit: &'static str,
}

impl Measured {
    /// A dimensionless value.
    pub fn new(value: f64, half_width: f64) -> Self {
        Self {
            value,
            half_width,
            unit: "",
        }
    }

    /// The same number with a unit.
    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Value and half-width as texts, for two columns of a table.
    pub fn parts(&self) -> [String; 2] {
        value_and_error(self.value, self.half_width)
    }
}

impl From<&Exponent> for Measured {
    fn from(exponent: &Exponent) -> Self {
        Self::new(exponent.value, exponent.half_width)
    }
}

impl Display for Measured {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}", with_error(self.value, self.half_width))?;
        if self.unit.is_empty() {
            return Ok(());
        }
        write!(f, " {}", self.unit)
    }
}

/// The blocks in Markdown. Headings are those of level 2.
pub fn markdown(blocks: &[Block]) -> String {
    let block = |block: &Block| match block {
        Block::Heading(title, rest) => {
            format!("## {}{}\n", escape::markdown(title), escape::markdown(rest))
        }
        Block::Text(cells) => {
            let cells = cells.iter().map(Cell::markdown);
            format!("{}\n", cells.collect::<String>())
        }
        Block::Table(table) => table.markdown(),
        Block::Warning(text) => format!("**Warning:** {text}\n"),
        Block::Code(text) => format!("```\n{text}```\n"),
    };
    let blocks: Vec<String> = blocks.iter().map(block).collect();
    blocks.join("\n")
}

impl Cell {
    /// The text, bold unless its tone is plain.
    fn markdown(&self) -> String {
        if self.tone == Tone::Plain || self.text.is_empty() {
            self.text.clone()
        } else {
            format!("**{}**", self.text)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_two_digits_of_its_error_and_one_unit() {
        assert_eq!(
            Measured::new(61.234, 1.23).unit("1/s").to_string(),
            "61.2 ± 1.2 1/s"
        );
        assert_eq!(
            Measured::new(0.5, f64::INFINITY).to_string(),
            "0.5 (error unknown)"
        );
    }

    fn blocks() -> Vec<Block> {
        let table = Table::of(["1780.1"])
            .right("Hz", |text| *text)
            .left("", |_| Tone::Bad.cell("unstable"))
            .right("without text", |_| "");
        vec![
            Block::heading("a\u{1b}b", ": 1 of 2 modes"),
            Block::Text(vec!["sum ".into(), Tone::Strong.cell(3)]),
            table.into(),
            Block::Warning("too short".to_owned()),
        ]
    }

    #[test]
    fn blocks_become_markdown() {
        let expected = "## a\\\\u001bb: 1 of 2 modes\n\nsum **3**\n\n| Hz |  |\n|---|---|\n| 1780.1 | **unstable** |\n\n\
                        **Warning:** too short\n";
        assert_eq!(markdown(&blocks()), expected);
    }

    #[test]
    fn a_label_does_not_break_a_table() {
        let table = Table::of(["a|b"]).left("mode", |label| *label);
        assert_eq!(table.markdown(), "| mode |\n|---|\n| a\\|b |\n");
    }

    #[cfg(feature = "cli")]
    #[test]
    fn blocks_become_indented_lines_below_their_heading() {
        let text = terminal(&blocks());
        assert_eq!(
            anstream::adapter::strip_str(&text).to_string(),
            "a\\u001bb: 1 of 2 modes\n  sum 3\n      Hz\n  1780.1  unstable\n  warning: too short\n"
        );
        assert!(text.contains(&format!("{BAD}unstable{BAD:#}")), "{text:?}");
    }
}
