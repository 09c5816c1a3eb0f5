//! Tables of texts.

use super::Cell;

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Align {
    Left,
    Right,
}

/// A table with titled columns and rows of cells.
#[derive(Clone, Debug, Default)]
pub struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Adds a left-aligned column, for text.
    pub fn left(mut self, title: impl Into<String>) -> Self {
        self.columns.push((title.into(), Align::Left));
        self
    }

    /// Adds a right-aligned column, for numbers.
    pub fn right(mut self, title: impl Into<String>) -> Self {
        self.columns.push((title.into(), Align::Right));
        self
    }

    /// Adds a row with one cell per column.
    pub fn row<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        let row: Vec<Cell> = cells.into_iter().map(Into::into).collect();
        debug_assert_eq!(row.len(), self.columns.len(), "{row:?}");
        self.rows.push(row);
    }

    /// The table for the terminal: lines are indented by two spaces, columns separated by two. Without titles there is
    /// no title line.
    #[cfg(feature = "cli")]
    pub(super) fn terminal(&self) -> String {
        let titles: Vec<Cell> = self
            .columns
            .iter()
            .map(|(t, _)| t.as_str().into())
            .collect();
        let has_titles = titles.iter().any(|title| !title.text.is_empty());
        let lines = has_titles.then_some(&titles).into_iter().chain(&self.rows);
        let width = |cell: &Cell| cell.text.chars().count();
        let widths = (0..self.columns.len()).map(|column| {
            let cells = lines.clone().filter_map(|line| line.get(column));
            cells.map(width).max().unwrap_or(0)
        });
        let widths: Vec<usize> = widths.collect();
        let mut text = String::new();
        for line in lines {
            let cells = line.iter().zip(&self.columns).zip(&widths);
            let cells = cells.map(|((cell, (_, align)), whole)| {
                let blanks = " ".repeat(whole - width(cell));
                match align {
                    Align::Left => format!("  {}{blanks}", cell.terminal()),
                    Align::Right => format!("  {blanks}{}", cell.terminal()),
                }
            });
            text += cells.collect::<String>().trim_end();
            text.push('\n');
        }
        text
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = line(
            self.columns
                .iter()
                .map(|(title, _)| title.clone())
                .collect(),
        );
        text += &"|---".repeat(self.columns.len());
        text += "|\n";
        let rows = self.rows.iter();
        text.extend(rows.map(|row| line(row.iter().map(Cell::markdown).collect())));
        text
    }
}
