//! How cost grows: time and memory over size, on axes of decades.

use super::cost::decades;
use super::panel::{Axis, Mark, Panel};
use super::style::{BLUE, VERMILION};
use super::{Figure, FigureError};
use crate::study::growth::{Growth, GrowthPoint, Size, Work};

/// A panel for each size, `growth`: the time of a work in milliseconds, and the most memory held in
/// megabytes where it is told.
///
/// # Errors
/// [`FigureError`].
pub fn growth_figure(scene: &str, grown: &[Growth]) -> Result<Figure, FigureError> {
    let panels: Vec<Panel> = Size::ALL
        .into_iter()
        .filter_map(|size| {
            let of: Vec<&Growth> = grown.iter().filter(|growth| growth.size == size).collect();
            (!of.is_empty()).then(|| panel(size, &of))
        })
        .collect();
    let rows: Vec<Vec<Panel>> = panels.chunks(3).map(<[Panel]>::to_vec).collect();
    let height = 440 * rows.len().max(1) as u32;
    Figure::new(
        "growth",
        &format!("{scene} — how cost grows"),
        [1500, height],
        &rows,
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
    let x = decades(all().map(|[x, _]| *x), 0.0);
    let y = decades(all().map(|[_, y]| *y), 1.0);
    let mut marks = Vec::new();
    for ((label, points), color) in curves.into_iter().zip([BLUE, VERMILION]) {
        marks.push(Mark::Line {
            points: points.clone(),
            color,
            label,
        });
        marks.push(Mark::Dots {
            points,
            radius: 3.0,
            color,
            label: String::new(),
        });
    }
    Panel {
        title: String::new(),
        x: match size {
            // There are few of them.
            Size::Threads => Axis::around(size.name(), marks_x(&marks)),
            _ => Axis::decades(size.name(), x),
        },
        y: match grown[0].work {
            Work::Sweep => Axis::linear("ms", [0.0, 1.3 * top(&marks)]),
            _ if with_memory => Axis::decades("ms, MB", y),
            _ => Axis::decades("ms", y),
        },
        marks,
    }
}

/// The points of all lines.
fn points(marks: &[Mark]) -> impl Iterator<Item = &[f64; 2]> {
    marks.iter().flat_map(|mark| match mark {
        Mark::Line { points, .. } => &points[..],
        _ => &[],
    })
}

fn marks_x(marks: &[Mark]) -> impl Iterator<Item = f64> {
    points(marks).map(|[x, _]| *x)
}

fn top(marks: &[Mark]) -> f64 {
    points(marks).map(|[_, y]| *y).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            growth(Size::Nodes, Work::Call),
            growth(Size::Nodes, Work::Vibration),
            growth(Size::Threads, Work::Sweep),
            growth(Size::Duration, Work::Run),
        ];
        let svg = growth_figure("test", &grown).unwrap().svg;
        for words in [
            "contact nodes",
            "a call of the right-hand side, ms",
            "1 ms of the settled vibration, ms",
            "a sweep, by the clock, ms",
            "memory, MB",
        ] {
            assert!(svg.contains(words), "{words}");
        }
        // Two dots a curve; memory is drawn where it is what grows.
        assert_eq!(svg.matches("<circle").count(), 10);
    }
}
