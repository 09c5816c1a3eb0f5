//! Tables of texts.

use super::{Block, Cell};
use crate::escape;

/// A table with titled columns of cells. A column without any text is left out.
#[derive(Clone, Debug, Default)]
pub struct Table {
    columns: Vec<Column>,
}

#[derive(Clone, Debug)]
struct Column {
    title: String,
    /// Whether it is aligned right, as numbers are.
    #[cfg_attr(
        not(feature = "cli"),
        expect(dead_code, reason = "only the terminal aligns columns")
    )]
    is_right: bool,
    /// The cell in each row.
    cells: Vec<Cell>,
}

/// A table under construction: what its rows stand for, and the columns so far.
pub struct TableOf<R> {
    rows: Vec<R>,
    table: Table,
}

impl Table {
    /// Begins a table with a row for each item.
    pub fn of<R>(items: impl IntoIterator<Item = R>) -> TableOf<R> {
        TableOf {
            rows: items.into_iter().collect(),
            table: Self::default(),
        }
    }
}

impl<R> TableOf<R> {
    /// Adds a left-aligned column, for text: its title, and its cell in the row of an item.
    pub fn left<C: Into<Cell>>(self, title: impl Into<String>, cell: impl Fn(&R) -> C) -> Self {
        self.column(title.into(), false, &|row| cell(row).into())
    }

    /// Adds a right-aligned column, for numbers.
    pub fn right<C: Into<Cell>>(self, title: impl Into<String>, cell: impl Fn(&R) -> C) -> Self {
        self.column(title.into(), true, &|row| cell(row).into())
    }

    // Not generic in the cell: it is compiled once for each kind of row, not for each column.
    fn column(mut self, title: String, is_right: bool, cell: &dyn Fn(&R) -> Cell) -> Self {
        let cells: Vec<Cell> = self.rows.iter().map(cell).collect();
        if cells.is_empty() || cells.iter().any(|cell| !cell.text.is_empty()) {
            self.table.columns.push(Column {
                title,
                is_right,
                cells,
            });
        }
        self
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        self.table.markdown()
    }
}

impl<R> From<TableOf<R>> for Block {
    fn from(table: TableOf<R>) -> Self {
        Self::Table(table.table)
    }
}

impl Table {
    /// The lines of the table: in each the texts of all columns, which `text` makes of their cells.
    fn lines(&self, text: impl Fn(&Column, &Cell) -> String) -> Vec<Vec<String>> {
        let rows = self.columns.first().map_or(0, |column| column.cells.len());
        let line = |row: usize| {
            let columns = self.columns.iter();
            columns
                .map(|column| text(column, &column.cells[row]))
                .collect()
        };
        (0..rows).map(line).collect()
    }

    /// The table for the terminal: lines are indented by two spaces, columns separated by two. Without titles there is
    /// no title line.
    #[cfg(feature = "cli")]
    pub(super) fn terminal(&self) -> String {
        let length = |text: &str| text.chars().count();
        let padded = |column: &Column, cell: &Cell| {
            let lengths = column.cells.iter().map(|cell| length(&cell.text));
            let width = lengths.fold(length(&column.title), usize::max);
            let blanks = " ".repeat(width - length(&cell.text));
            if column.is_right {
                format!("  {blanks}{}", cell.terminal())
            } else {
                format!("  {}{blanks}", cell.terminal())
            }
        };
        let titles = self.columns.iter();
        let titles = titles.map(|column| padded(column, &column.title.as_str().into()));
        let has_titles = self.columns.iter().any(|column| !column.title.is_empty());
        let titles = has_titles.then(|| titles.collect::<Vec<_>>());
        let lines = titles.into_iter().chain(self.lines(padded));
        lines
            .map(|line| format!("{}\n", line.concat().trim_end()))
            .collect()
    }

    /// The table in Markdown.
    pub(super) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let titles = self.columns.iter().map(|column| column.title.clone());
        let mut text = line(titles.collect());
        text += &"|---".repeat(self.columns.len());
        text += "|\n";
        // Labels of modes can come from a user's file.
        let cell = |_: &Column, cell: &Cell| {
            let text = escape::markdown(&cell.text);
            cell.tone.cell(text).markdown()
        };
        text.extend(self.lines(cell).into_iter().map(line));
        text
    }
}
