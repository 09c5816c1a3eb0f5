//! Figure of a calibration: which claims of the paper can be met together.

use super::axis::Axis;
use super::color::Color;
use super::figure::{Figure, Layer, Panel};
use crate::study::calibrate::{MetClaims, ParetoFront, Trial, shares};

/// The shares of the known claims on two subjects that each trial meets, with the Pareto front of the trials.
pub fn calibration_figure(known: &MetClaims, trials: &[Trial], fronts: &[ParetoFront]) -> Figure {
    let panels = fronts.iter().map(|front| panel(known, trials, front));
    let title = format!(
        "share of the claims that each of {} parameter sets meets, among those that any meets",
        trials.len()
    );
    Figure::new("pareto", title, 70.0, vec![panels.collect()])
}

fn panel(known: &MetClaims, trials: &[Trial], front: &ParetoFront) -> Panel {
    let percent = |shares: [f64; 2]| shares.map(|share| 100.0 * share);
    let all = shares(known, trials, front.subjects)
        .into_iter()
        .map(percent);
    let best: Vec<_> = front.best.iter().map(|at| percent(at.shares)).collect();
    let hover = front.best.iter().map(|at| format!("set {}", at.trial));
    // Between two of its points the front has a corner, because no set lies beyond either.
    let corners = best
        .windows(2)
        .flat_map(|pair| [pair[0], [pair[0][0], pair[1][1]]]);
    let steps = corners.chain(best.last().copied()).collect();
    let axis = |k: usize| {
        let label = format!("{}, %", front.subjects[k]);
        Axis::linear(label, [-4.0, 104.0])
    };
    let layers = vec![
        Layer::points(all.collect(), 1.2, Color::Faint).with_label("sets"),
        Layer::line(steps, Color::Accent).with_label("Pareto front"),
        Layer::points(best, 2.2, Color::Accent)
            .with_hover(hover.collect())
            .with_id("best"),
    ];
    Panel::new(String::new(), axis(0), axis(1), layers).square()
}
