//! Reports for the terminal.

use anstyle::{AnsiColor, Style};

use super::{Block, Cell, Tone};

/// Errors, unstable modes, positive exponents.
pub const BAD: Style = AnsiColor::Red.on_default().bold();
/// Warnings, and results that need care.
pub const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Headings.
pub const HEADING: Style = Style::new().bold();

/// The blocks with colour codes: what belongs to a heading is indented by two spaces, and a blank line precedes each
/// further heading.
pub fn terminal(blocks: &[Block]) -> String {
    let mut text = String::new();
    for block in blocks {
        match block {
            Block::Heading(title, rest) => {
                if !text.is_empty() {
                    text.push('\n');
                }
                text += &format!("{HEADING}{title}{HEADING:#}{rest}\n");
            }
            Block::Text(cells) => {
                let cells: String = cells.iter().map(Cell::terminal).collect();
                text += &format!("  {cells}\n");
            }
            Block::Table(table) => text += &table.terminal(),
            Block::Warning(warning) => {
                text += &format!("  {WARNING}warning:{WARNING:#} {warning}\n");
            }
            Block::Code(code) => {
                if !text.is_empty() {
                    text.push('\n');
                }
                text += code;
            }
        }
    }
    text
}

impl Cell {
    /// The text in the colour of its tone.
    pub(super) fn terminal(&self) -> String {
        let style = match self.tone {
            Tone::Plain => return self.text.clone(),
            Tone::Strong => HEADING,
            Tone::Good => AnsiColor::Green.on_default(),
            Tone::Doubtful => WARNING,
            Tone::Bad => BAD,
        };
        format!("{style}{}{style:#}", self.text)
    }
}
