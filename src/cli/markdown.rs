//! Renders the Markdown of lessons (headings, emphasis, tables) as lines of a terminal.

use ratatui::style::Stylize;
use ratatui::text::{Line, Span};

/// Renders a text.
pub(super) fn lines(markdown: &str) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    let mut table: Vec<Vec<Line<'static>>> = Vec::new();
    for line in markdown.lines() {
        match cells(line) {
            // The rule between head and body of a table.
            Some(cells) if cells.iter().all(|cell| is_rule(cell)) => {}
            Some(cells) => table.push(cells.into_iter().map(emphasized).collect()),
            None => {
                lines.extend(aligned(&std::mem::take(&mut table)));
                lines.push(match line.trim_start_matches('#') {
                    heading if heading.len() < line.len() => emphasized(heading.trim()).bold(),
                    _ => emphasized(line),
                });
            }
        }
    }
    lines.extend(aligned(&table));
    lines
}

/// Splits a table row into cells.
fn cells(line: &str) -> Option<Vec<&str>> {
    let inner = line.trim().strip_prefix('|')?.strip_suffix('|')?;
    Some(inner.split('|').map(str::trim).collect())
}

fn is_rule(cell: &str) -> bool {
    !cell.is_empty() && cell.chars().all(|c| "-:".contains(c))
}

/// Renders `**strong**` text in bold and removes the backticks of code.
fn emphasized(line: &str) -> Line<'static> {
    let pieces = line.split("**").enumerate();
    let spans = pieces.map(|(k, piece)| {
        let span = Span::from(piece.replace('`', ""));
        if k % 2 == 1 { span.bold() } else { span }
    });
    Line::from_iter(spans.filter(|span| !span.content.is_empty()))
}

/// Aligns the columns of a table; the first row is its head.
fn aligned(rows: &[Vec<Line<'static>>]) -> Vec<Line<'static>> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(Line::width).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<Line<'static>>| {
        let mut line = Line::default();
        for (k, (cell, width)) in row.iter().zip(&widths).enumerate() {
            line.spans.extend(cell.spans.iter().cloned());
            // Trailing spaces would wrap.
            if k + 1 < row.len() {
                line.push_span(Span::from(" ".repeat(width - cell.width() + 2)));
            }
        }
        line
    };
    let mut lines: Vec<_> = rows.iter().map(line).collect();
    if let Some(head) = lines.first_mut() {
        *head = std::mem::take(head).bold();
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_aligned_and_markup_is_removed() {
        let markdown = "## A `torus`\nwith **two** tones\n\n| measured | |\n|---|---|\n\
            | λ₁ | **0.1** 1/s |\n| a beat | 240 Hz |\n\nand so on";
        let lines = lines(markdown);
        assert_eq!(
            lines.iter().map(Line::to_string).collect::<Vec<_>>(),
            [
                "A torus",
                "with two tones",
                "",
                "measured  ",
                "λ₁        0.1 1/s",
                "a beat    240 Hz",
                "",
                "and so on"
            ]
        );
        let is_bold = |line: &Line<'_>, k: usize| {
            let style = line.style.patch(line.spans[k].style);
            style.add_modifier.contains(ratatui::style::Modifier::BOLD)
        };
        assert!(is_bold(&lines[0], 0) && is_bold(&lines[3], 0));
        assert!(is_bold(&lines[1], 1) && !is_bold(&lines[1], 0));
        assert!(is_bold(&lines[4], 2) && !is_bold(&lines[4], 0));
    }
}
