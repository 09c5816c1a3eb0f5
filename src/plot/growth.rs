//! Scaling of the cost: time and memory over problem size, on logarithmic axes.

use super::axis::{Axis, decades};
use super::color::Color;
use super::figure::{Figure, Layer, Panel};
use crate::study::growth::{Growth, GrowthPoint, Size, Work};

/// The figure `growth` with one panel for each size: time in ms, and peak memory in MB where it was
/// measured.
pub fn growth_figure(scene: &str, grown: &[Growth]) -> Figure {
    let panels = Size::ALL.into_iter().filter_map(|size| {
        let of: Vec<&Growth> = grown.iter().filter(|growth| growth.size == size).collect();
        (!of.is_empty()).then(|| panel(size, &of))
    });
    let panels: Vec<Panel> = panels.collect();
    Figure::grid(
        "growth",
        format!("{scene}: scaling of time and memory"),
        62.0,
        3,
        &panels,
    )
}

fn panel(size: Size, grown: &[&Growth]) -> Panel {
    let milliseconds = |point: &GrowthPoint| Some([point.value, 1e3 * point.seconds]);
    let megabytes = |point: &GrowthPoint| Some([point.value, point.memory? as f64 / 1e6]);
    let mut curves: Vec<(String, Vec<[f64; 2]>)> = Vec::new();
    for growth in grown {
        let points = growth.points.iter().filter_map(milliseconds).collect();
        curves.push((format!("{}, ms", growth.work.name()), points));
    }
    let points: Vec<_> = grown[0].points.iter().filter_map(megabytes).collect();
    let with_memory = !points.is_empty();
    if with_memory {
        curves.push(("memory, MB".to_owned(), points));
    }
    let all = || curves.iter().flat_map(|(_, points)| points);
    let (xs, ys) = (|| all().map(|[x, _]| *x), || all().map(|[_, y]| *y));
    let x = match size {
        // A linear axis: there are only a few thread counts.
        Size::Threads => Axis::with_margin(size.name(), xs()),
        _ => Axis::decades(size.name(), decades(xs())),
    };
    let y = match grown[0].work {
        Work::Sweep => Axis::linear("ms", [0.0, 1.3 * ys().fold(0.0, f64::max)]),
        _ if with_memory => Axis::decades("ms, MB", decades(ys())),
        _ => Axis::decades("ms", decades(ys())),
    };
    let layers = curves.iter().enumerate().flat_map(|(k, (label, points))| {
        let color = Color::Series(k);
        [
            Layer::line(points.clone(), color).with_label(label),
            Layer::points(points.clone(), 2.2, color),
        ]
    });
    Panel::new("", x, y, layers.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::FigureOptions;

    #[test]
    fn each_size_has_a_panel_and_each_work_a_curve() {
        let growth = |size, work| Growth {
            size,
            work,
            points: [1.0, 10.0]
                .map(|value| GrowthPoint {
                    value,
                    seconds: 1e-3 * value,
                    memory: matches!(size, Size::Duration).then_some(20_000_000),
                })
                .to_vec(),
        };
        let grown = [
            growth(Size::Nodes, Work::RhsEvaluation),
            growth(Size::Nodes, Work::Vibration),
            growth(Size::Threads, Work::Sweep),
            growth(Size::Duration, Work::Run),
        ];
        let svg = growth_figure("test", &grown).svg(&FigureOptions::default());
        for words in [
            "contact nodes",
            "one right-hand-side evaluation, ms",
            "1 ms of the settled vibration, ms",
            "a sweep, wall-clock time, ms",
            "memory, MB",
        ] {
            assert!(svg.contains(words), "{words}");
        }
        // Two points per curve; memory is drawn for the duration only.
        assert_eq!(svg.matches("<circle").count(), 10);
    }
}
