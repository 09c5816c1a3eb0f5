//! Fig. 9 and 10: recurrence plots and Poincare maps over the tilt.

use super::motion::{LAG, recurrence};
use crate::analysis::Regime;
use crate::figure::panel::{Axis, Mark, Panel};
use crate::figure::sweep::color_of;
use crate::figure::{Figure, FigureError};
use crate::study::response::Response;

/// Panels a row.
const ROW: usize = 4;

/// Fig. 9: recurrence plots of 5 ms at each of some tilts (degrees).
///
/// # Errors
/// [`FigureError`].
pub fn recurrence_plots(points: &[(f64, &Response)]) -> Result<Figure, FigureError> {
    let panels = points.iter().filter_map(|(tilt, response)| {
        let title = format!("{tilt}°, {}", response.regime);
        Some(recurrence(title, response.portrait.as_ref()?))
    });
    grid("figure-9", "Fig. 9 — recurrence plots", panels.collect())
}

/// Fig. 10: Poincare maps at each of some tilts (degrees), all on the same axes.
///
/// # Errors
/// [`FigureError`].
pub fn sections(points: &[(f64, &Response)]) -> Result<Figure, FigureError> {
    let all = || points.iter().flat_map(|(_, response)| &response.section);
    let [x, y] = [0, 1].map(|k| {
        let name = ["y(t), µm", "y(t + 2τ), µm"][k];
        Axis::around(name, all().map(move |point| 1e6 * point[k]))
    });
    let panels = points.iter().map(|(tilt, response)| Panel {
        title: format!("{tilt}°, {}", response.regime),
        x: x.clone(),
        y: y.clone(),
        marks: vec![Mark::Dots {
            points: response
                .section
                .iter()
                .map(|p| p.map(|y| 1e6 * y))
                .collect(),
            // A tone is a point, which is drawn to be seen.
            radius: match response.regime {
                Regime::Periodic => 4.0,
                _ => 1.5,
            },
            color: color_of(response.regime),
            label: String::new(),
        }],
    });
    let title = format!(
        "Fig. 10 — Poincaré maps at y(t + τ) = 0, τ = {:.0} µs",
        1e6 * LAG
    );
    grid("figure-10", &title, panels.collect())
}

fn grid(name: &str, title: &str, panels: Vec<Panel>) -> Result<Figure, FigureError> {
    let rows: Vec<Vec<Panel>> = panels.chunks(ROW).map(<[Panel]>::to_vec).collect();
    let height = 60 + 340 * rows.len() as u32;
    Figure::new(name, title, [1300, height], &rows)
}
