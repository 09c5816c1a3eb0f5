//! Figures of the growth of the modes of steady sliding: what contributes to it, and what changes it.

use super::axis::{extent, lowest_growth, readable};
use super::{Axis, Color, Figure, Layer, Panel};
use crate::joint::{Cause, ExplainedMode};
use crate::number::significant;
use crate::study::StabilityAt;
use crate::study::branch::ModeSensitivities;

/// Largest number of bars of a mode.
const MOST: usize = 9;
/// Largest number of modes of the figure of the causes.
const MODES: usize = 10;
/// Height of a row, mm, and of the rest of a panel.
const ROW_MM: [f64; 2] = [5.0, 30.0];
/// Colours of a growing and a decreasing growth rate.
const COLORS: [Color; 2] = [Color::Series(4), Color::Series(3)];

/// The figure `causes`: what contributes to the growth rate of each oscillating mode. `explained` are the oscillating
/// modes of `at`, in the same order. Of many modes, those with the largest growth rates are shown.
pub fn causes_figure(title: &str, at: &StabilityAt, explained: &[ExplainedMode]) -> Figure {
    let oscillating = at.modes.iter().filter(|mode| mode.frequency_hz > 0.0);
    let mut modes: Vec<_> = explained.iter().zip(oscillating).collect();
    modes.sort_by(|a, b| b.0.growth_per_s.total_cmp(&a.0.growth_per_s));
    modes.truncate(MODES);
    modes.sort_by(|a, b| a.0.frequency_hz.total_cmp(&b.0.frequency_hz));
    let modes = modes.into_iter().map(|(mode, named)| {
        let kilohertz = 1e-3 * mode.frequency_hz;
        (format!("{}, {kilohertz:.2} kHz", named.label), mode)
    });
    let panel = contributions(&modes.collect::<Vec<_>>());
    let height = ROW_MM[1] + ROW_MM[0] * panel.y.names.len() as f64;
    let title = format!("{title}: contributions to the growth rate");
    Figure::new("causes", &title, height, vec![vec![panel]])
}

/// The stacked contributions of the terms of the model to the growth rate of each mode, positive ones to the right and
/// negative ones to the left of zero, with their sum. Strong damping does not determine the axis.
pub fn contributions(modes: &[(String, &ExplainedMode)]) -> Panel {
    let color = |cause: Cause| Color::Series(cause as usize);
    let rows = modes.iter().map(|(name, mode)| {
        let mut ends = [0.0_f64; 2];
        let bars = mode.causes.iter().map(|cause| {
            let end = &mut ends[usize::from(cause.share_per_s < 0.0)];
            let from = std::mem::replace(end, *end + cause.share_per_s);
            ([from, *end], color(cause.cause))
        });
        (name.clone(), bars.collect())
    });
    let rows: Vec<(String, Vec<_>)> = rows.collect();
    let ends = rows.iter().flat_map(|(_, bars)| bars);
    let [low, high] = extent(ends.map(|([_, end], _)| *end).chain([0.0]));
    let lowest = lowest_growth([low, high]);
    let axis = Axis::with_margin("growth rate, 1/s", [lowest, high].into_iter());
    let mut panel = Panel::bars("", axis, rows);
    if low < lowest {
        panel.title = "strong damping is cut at the left edge".to_owned();
    }
    let causes = modes.first().map_or(&[][..], |(_, mode)| &mode.causes);
    let keys = causes.iter().map(|cause| {
        let name = cause.cause.name().replace("Omega x u", "Ω × u");
        Layer::areas(Vec::new(), 1.0, color(cause.cause)).with_label(name)
    });
    let sums = modes.iter().enumerate();
    let sums = sums.map(|(row, (_, mode))| [mode.growth_per_s, panel.y.row(row)]);
    let sums: Vec<[f64; 2]> = sums.collect();
    // The pale rim is visible on dark bars.
    let rims = Layer::points(sums.clone(), 3.4, Color::Pale);
    let sums = Layer::points(sums, 2.3, Color::Ink).with_label("sum: growth rate");
    panel.layers.extend(keys.chain([rims, sums]));
    panel
}

/// The figure `sensitivities`: for each mode the numbers of the scene with the largest change of the growth rate per
/// 1 %, from the top. `title` names the scene.
pub fn sensitivities_figure(title: &str, modes: &[&ModeSensitivities]) -> Figure {
    let panels = modes.iter().map(|mode| panel(mode));
    let columns = modes.len().clamp(1, 2);
    let row = ROW_MM[1] + ROW_MM[0] * MOST as f64;
    let title = format!("{title}: growth rate if a number increases by 1 %");
    Figure::grid("sensitivities", &title, row, columns, panels.collect())
}

fn panel(mode: &ModeSensitivities) -> Panel {
    let shown = mode.parameters.iter();
    let shown = shown.filter(|it| it.growth_per_percent != 0.0).take(MOST);
    let changes = shown.clone().map(|it| it.growth_per_percent);
    let axis = Axis::with_margin("change of the growth rate, 1/s", changes.chain([0.0]));
    let rows = shown.map(|it| {
        let to = it.growth_per_percent;
        let bar = ([0.0, to], COLORS[usize::from(to < 0.0)]);
        (readable(&it.parameter, &it.unit), vec![bar])
    });
    let growth = significant(mode.mode.growth, 4);
    let (label, hertz) = (&mode.mode.label, mode.mode.frequency_hz);
    let title = format!("{label}, {hertz:.1} Hz, growth rate {growth} 1/s");
    Panel::bars(&title, axis, rows.collect())
}
