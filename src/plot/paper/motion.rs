//! Fig. 4 to 10: the motion at one tilt, the choice of its embedding, and comparisons over the tilt.

use crate::analysis::{delay::DelayChoice, recurrence::RecurrenceImage};
use crate::joint::ExplainedMode;
use crate::plot::color::Color;
use crate::plot::response::{
    self, LAG, SMALLEST, SpectrumAxes, interpolated, largest, samples, section, section_axes,
};
use crate::plot::sensitivities::contributions;
use crate::plot::{Figure, Panel, false_neighbours, mutual_information};
use crate::study::response::{PhasePortrait, SettledResponse};

/// Highest frequency of a spectrum, Hz, and the decades of its amplitude axis.
const HIGHEST: f64 = 15e3;
const DECADES: i32 = 6;
/// Panels per row.
const ROW: usize = 4;

/// Fig. 4 to 7: growth rates of the linear modes `modes`, time series, phase portrait, spectrum, delay
/// reconstruction and recurrence plot of the motion at a tilt (degrees).
pub fn motion(
    number: usize,
    tilt_deg: f64,
    response: &SettledResponse,
    modes: &[ExplainedMode],
) -> Figure {
    let title = format!(
        "Fig. {number}: at {tilt_deg}°, {}",
        response.regime.with_confidence(response.confidence)
    );
    let unstable = modes.iter().filter(|mode| mode.unstable()).count();
    let named = modes
        .iter()
        .map(|mode| (format!("{:.2} kHz", 1e-3 * mode.frequency_hz), mode));
    let growth = contributions(&named.collect::<Vec<_>>());
    let mut panels = vec![growth.with_title(format!("{unstable} unstable modes"))];
    if let Some(portrait) = &response.portrait {
        let color = Color::Regime(response.regime);
        let strongest = response.lines.first();
        let strongest = strongest.map_or(SMALLEST[0], |line| line.amplitude);
        let plane = SpectrumAxes::new(strongest, DECADES, HIGHEST);
        let (dt, fine) = (
            portrait.dt_s,
            interpolated(&samples(portrait), portrait.dt_s),
        );
        panels.extend([
            response::time_series(&fine, dt, color),
            response::phase_portrait(&fine, None, color),
            response::spectrum(&plane, portrait, &response.lines),
            response::reconstruction(&fine, dt, color),
            response::recurrence(recurrence(portrait).as_ref(), false),
        ]);
    }
    for (panel, letter) in panels.iter_mut().zip(["a", "b", "c", "d", "e", "f"]) {
        panel.title = format!("{letter}: {}", panel.title);
    }
    Figure::grid(format!("figure-{number}"), title, 66.0, 3, &panels)
}

/// The recurrence plot; `None` for a constant signal.
fn recurrence(portrait: &PhasePortrait) -> Option<RecurrenceImage> {
    let mut pairs = portrait.u_m.windows(2);
    let moves = pairs.any(|pair| pair[0] != pair[1]);
    portrait.recurrence().ok().flatten().filter(|_| moves)
}

/// Fig. 8: mutual information and fraction of false nearest neighbours of the motion at a tilt (degrees),
/// sampled every `dt` (s).
pub fn embedding(tilt_deg: f64, choice: &DelayChoice, dt: f64) -> Figure {
    let delay = 1e6 * dt * choice.lag as f64;
    let (lag, dimension) = (choice.lag, choice.dimension);
    let title = format!("a: average mutual information: delay {delay:.0} µs");
    let information = mutual_information(choice, (dt, "s"), &format!("{lag} samples"));
    let information = information.with_title(title);
    let title = format!("b: false nearest neighbours: dimension {dimension}");
    let neighbours = false_neighbours(choice, &format!("m = {dimension}")).with_title(title);
    let title = format!("Fig. 8: choice of delay and dimension at {tilt_deg}°");
    Figure::new("figure-8", title, 80.0, vec![vec![information, neighbours]])
}

/// Title of the motion at a tilt (degrees).
fn title((tilt, response): &(f64, &SettledResponse)) -> String {
    format!("{tilt}°, {}", response.regime)
}

/// Fig. 9: recurrence plots of 5 ms at several tilts (degrees).
pub fn recurrence_plots(points: &[(f64, &SettledResponse)]) -> Figure {
    let panels = points.iter().filter_map(|point| {
        let found = recurrence(point.1.portrait.as_ref()?);
        Some(response::recurrence(found.as_ref(), false).with_title(title(point)))
    });
    let panels: Vec<Panel> = panels.collect();
    Figure::grid("figure-9", "Fig. 9: recurrence plots", 54.0, ROW, &panels)
}

/// Fig. 10: Poincaré sections at several tilts (degrees), all on the same axes.
pub fn sections(points: &[(f64, &SettledResponse)]) -> Figure {
    let found: Vec<&SettledResponse> = points.iter().map(|(_, response)| *response).collect();
    let size = found.iter().map(|response| largest(response)[0]);
    let plane = section_axes(&found, "u", size.fold(SMALLEST[0], f64::max));
    let panels = points
        .iter()
        .map(|point| section(&plane, Some(point.1)).with_title(title(point)));
    let panels: Vec<Panel> = panels.collect();
    let us = 1e6 * LAG;
    let title = format!("Fig. 10: Poincaré sections at u(t + τ) = 0, τ = {us:.0} µs");
    Figure::grid("figure-10", title, 54.0, ROW, &panels)
}
