//! The list of the figures of runs and of signals: which panels form a figure.

use super::{Figure, Panel};

/// The list of figures.
const FIGURES: &str = include_str!("figures.txt");
/// Height of a named row of a panel, mm.
const NAMED_ROW: f64 = 7.0;

/// The figures: name, title, height of a row of panels, and names of the panels.
fn list() -> impl Iterator<Item = [&'static str; 4]> {
    let lines = FIGURES.lines();
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(|line| {
        let mut cells = line.split('|').map(str::trim);
        std::array::from_fn(|_| cells.next().expect("four cells"))
    })
}

/// Names of the figures that runs and signals can have.
pub fn figure_names() -> Vec<&'static str> {
    list().map(|[name, ..]| name).collect()
}

/// The figures of a run or signal with a name; `panel` gives a panel by its name, if there is one.
pub fn figures(name: &str, panel: impl Fn(&str) -> Option<Panel>) -> Vec<Figure> {
    let figures = list().filter_map(|[stem, title, height, all]| {
        let rows = all.split('/');
        let rows = rows.map(|row| row.split_whitespace().filter_map(&panel).collect());
        let rows: Vec<Vec<Panel>> = rows.filter(|row: &Vec<_>| !row.is_empty()).collect();
        let named: usize = rows.iter().flatten().map(|panel| panel.y.names.len()).sum();
        let height: f64 = height.parse().expect("a height");
        let height = height * rows.len() as f64 + NAMED_ROW * named as f64;
        let title = format!("{name}: {title}");
        (!rows.is_empty()).then(|| Figure::new(stem, &title, height, rows))
    });
    figures.collect()
}
