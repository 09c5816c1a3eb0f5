//! Text tables: aligned columns for the terminal, or Markdown for a page.

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Align {
    Left,
    Right,
}

/// A table with titled columns and rows of cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Adds a left-aligned column, for text.
    pub(crate) fn left(mut self, title: impl Into<String>) -> Self {
        self.columns.push((title.into(), Align::Left));
        self
    }

    /// Adds a right-aligned column, for numbers.
    pub(crate) fn right(mut self, title: impl Into<String>) -> Self {
        self.columns.push((title.into(), Align::Right));
        self
    }

    /// Adds a row with one cell per column. Cells can contain colour codes.
    pub(crate) fn row<C: Into<String>>(&mut self, cells: impl IntoIterator<Item = C>) {
        let row: Vec<String> = cells.into_iter().map(Into::into).collect();
        debug_assert_eq!(row.len(), self.columns.len(), "{row:?}");
        self.rows.push(row);
    }

    /// The table for the terminal: lines are indented by two spaces, columns separated by two. Without
    /// titles there is no title line.
    pub(crate) fn text(&self) -> String {
        let titles: Vec<String> = self.columns.iter().map(|(t, _)| t.clone()).collect();
        let has_titles = titles.iter().any(|title| !title.is_empty());
        let lines = has_titles.then_some(&titles).into_iter().chain(&self.rows);
        let width = |column: usize| {
            let cells = lines.clone().filter_map(|line| line.get(column));
            cells.map(|cell| width(cell)).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let mut text = String::new();
        for line in lines {
            let cells = line.iter().zip(&self.columns).zip(&widths);
            let cells = cells.map(|((cell, (_, align)), width)| {
                let blanks = " ".repeat(width - self::width(cell));
                match align {
                    Align::Left => format!("  {cell}{blanks}"),
                    Align::Right => format!("  {blanks}{cell}"),
                }
            });
            text += cells.collect::<String>().trim_end();
            text.push('\n');
        }
        text
    }

    /// The table in Markdown.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let titles: Vec<String> = self.columns.iter().map(|(t, _)| t.clone()).collect();
        let mut text = line(&titles);
        text += &"|---".repeat(self.columns.len());
        text += "|\n";
        text.extend(self.rows.iter().map(|row| line(row)));
        text
    }
}

/// Number of visible characters, without those of colour codes.
fn width(cell: &str) -> usize {
    let mut pieces = cell.split("\u{1b}[");
    let before = pieces.next().unwrap_or_default().chars().count();
    let after = pieces.map(|piece| {
        let visible = piece.split_once('m').map_or(piece, |(_, visible)| visible);
        visible.chars().count()
    });
    before + after.sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_by_visible_width() {
        let mut table = Table::default().right("Hz").left("mode").left("");
        table.row(["12.5", "\u{1b}[1mλ\u{1b}[0m", "unstable"]);
        table.row(["1234.0", "bending", ""]);
        assert_eq!(
            table.text(),
            "      Hz  mode\n    12.5  \u{1b}[1mλ\u{1b}[0m        unstable\n  1234.0  bending\n"
        );
        assert_eq!(
            table.markdown().lines().next_back(),
            Some("| 1234.0 | bending |  |")
        );
        assert!(
            table
                .markdown()
                .starts_with("| Hz | mode |  |\n|---|---|---|\n")
        );
    }

    #[test]
    fn a_table_without_titles_has_no_title_line() {
        let mut table = Table::default().left("").right("");
        table.row(["a", "1"]);
        assert_eq!(table.text(), "  a  1\n");
        assert_eq!(Table::default().text(), "");
    }
}
